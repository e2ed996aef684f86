//! The texts.

use std::fmt;
use std::str::FromStr;

use serde::Serialize;
use thiserror::Error;

/// A lecture, or a paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Text {
    /// Gabriel Zachmann, *Culling*, in: Advanced Computer Graphics, 2013 and 2014.
    Zachmann,
    /// *Culling*, in: CSE 167, Introduction to Computer Graphics, University of California, San Diego, 2015.
    Ucsd,
    /// Sung-Eui Yoon, *Clipping and Culling*, in: CS 380, Computer Graphics, KAIST.
    Kaist,
    /// Hansong Zhang and Kenneth E. Hoff III, *Fast Backface Culling Using Normal Masks*, 1997.
    ZhangHoff,
}

impl Text {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Zachmann, Self::Ucsd, Self::Kaist, Self::ZhangHoff];

    /// Its name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Zachmann => "zachmann",
            Self::Ucsd => "ucsd",
            Self::Kaist => "kaist",
            Self::ZhangHoff => "zhang-hoff",
        }
    }

    /// Authors, title and year.
    #[must_use]
    pub const fn reference(self) -> &'static str {
        match self {
            Self::Zachmann => {
                "G. Zachmann, Culling; lecture, Advanced Computer Graphics, 2013 and 2014"
            }
            Self::Ucsd => {
                "Culling; lecture, CSE 167 Computer Graphics, University of California, San Diego, 2015"
            }
            Self::Kaist => {
                "S.-E. Yoon, Clipping and Culling; lecture, CS 380 Computer Graphics, KAIST"
            }
            Self::ZhangHoff => {
                "H. Zhang and K. E. Hoff III, Fast Backface Culling Using Normal Masks; paper, 1997"
            }
        }
    }
}

impl fmt::Display for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// There is no text of that name.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("there is no text '{0}'; the texts are zachmann, ucsd, kaist and zhang-hoff")]
pub struct NoSuchText(pub String);

impl FromStr for Text {
    type Err = NoSuchText;

    fn from_str(name: &str) -> Result<Self, NoSuchText> {
        Self::ALL.into_iter().find(|t| t.name() == name).ok_or_else(|| NoSuchText(name.to_owned()))
    }
}
