//! Numbers with fractions in messages.
//!
//! What writes them in decimal digits is as much code as a stage. A host that has such code of its
//! own, as a browser has, turns the feature `digits` off and writes them itself: each is then the
//! mark U+0001, a letter for its form, the bits of its f64 in hexadecimal digits, and a semicolon.

use core::fmt::{Display, Formatter, Result};

/// A number and how it is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Digits {
    /// A fixed number of digits after the point, 9 at the most, which the letter gives.
    Fixed(f64, u8),
    /// The shortest digits that tell it from its neighbours, with an exponent: `e` and `x`.
    Exponent32(f32),
    Exponent(f64),
    /// The same without one: `p` and `q`.
    Plain32(f32),
    Plain(f64),
}

impl Display for Digits {
    #[cfg(feature = "digits")]
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        match *self {
            Self::Fixed(v, digits) => write!(f, "{v:.*}", usize::from(digits)),
            Self::Exponent32(v) => write!(f, "{v:e}"),
            Self::Exponent(v) => write!(f, "{v:e}"),
            Self::Plain32(v) => write!(f, "{v}"),
            Self::Plain(v) => write!(f, "{v}"),
        }
    }

    #[cfg(not(feature = "digits"))]
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let (form, v) = match *self {
            Self::Fixed(v, digits) => ((b'0' + digits) as char, v),
            Self::Exponent32(v) => ('e', v.into()),
            Self::Exponent(v) => ('x', v),
            Self::Plain32(v) => ('p', v.into()),
            Self::Plain(v) => ('q', v),
        };
        write!(f, "\u{1}{form}{:x};", v.to_bits())
    }
}

/// Three numbers, parted by commas, in brackets.
pub(crate) struct Point<T>(pub(crate) [T; 3], pub(crate) fn(T) -> Digits);

impl<T: Copy> Display for Point<T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let [x, y, z] = self.0.map(self.1);
        write!(f, "[{x}, {y}, {z}]")
    }
}
