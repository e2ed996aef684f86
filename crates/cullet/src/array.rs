//! Small arrays, made and mapped.
//!
//! [`std::array::from_fn`] and `map` stay correct when a closure panics half-way; that takes some
//! 150 lines of LLVM IR for each closure, and there are hundreds here: they were an eighth of what
//! the compiler had to read. These two are written out for each length.

/// Arrays of few lengths, made and mapped element by element in order.
pub(crate) trait Each<T, const N: usize>: Sized {
    /// The array of what `f` makes of each element.
    fn each<U>(self, f: impl FnMut(T) -> U) -> [U; N];

    /// The array of what `f` makes of each index.
    fn of_indices(f: impl FnMut(usize) -> T) -> Self;
}

/// The array of what `f` makes of each index.
#[inline(always)]
pub(crate) fn from_fn<T, const N: usize>(f: impl FnMut(usize) -> T) -> [T; N]
where
    [T; N]: Each<T, N>,
{
    <[T; N]>::of_indices(f)
}

macro_rules! each {
    ($($length:literal: $($index:literal $element:ident),+;)+) => {$(
        impl<T> Each<T, $length> for [T; $length] {
            #[inline(always)]
            fn each<U>(self, mut f: impl FnMut(T) -> U) -> [U; $length] {
                let [$($element),+] = self;
                [$(f($element)),+]
            }

            #[inline(always)]
            fn of_indices(mut f: impl FnMut(usize) -> T) -> Self {
                [$(f($index)),+]
            }
        }
    )+};
}

each! {
    2: 0 a, 1 b;
    3: 0 a, 1 b, 2 c;
    4: 0 a, 1 b, 2 c, 3 d;
    5: 0 a, 1 b, 2 c, 3 d, 4 e;
    6: 0 a, 1 b, 2 c, 3 d, 4 e, 5 g;
    8: 0 a, 1 b, 2 c, 3 d, 4 e, 5 g, 6 h, 7 i;
    16: 0 a, 1 b, 2 c, 3 d, 4 e, 5 g, 6 h, 7 i, 8 j, 9 k, 10 l, 11 m, 12 n, 13 o, 14 p, 15 q;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_and_indices_come_in_order() {
        let mut seen = Vec::new();
        let doubled: [i32; 3] = [5, 6, 7].each(|v| {
            seen.push(v);
            v * 2
        });
        assert_eq!((seen, doubled), (vec![5, 6, 7], [10, 12, 14]));
        assert_eq!(from_fn::<usize, 16>(|i| i), core::array::from_fn::<usize, 16, _>(|i| i));
    }
}
