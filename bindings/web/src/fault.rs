//! Kinds of faults in a call.

use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// Kind of a fault: the number that crosses to the page, which knows the name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Code {
    /// There is not enough memory.
    Memory = 1,
    /// A number is out of its range.
    Argument = 2,
    /// An id names nothing (any more).
    Id = 3,
    /// A mesh is refused.
    Mesh = 4,
    /// A camera is refused.
    Camera = 5,
    /// A file is refused.
    File = 6,
    /// A file is over a limit.
    Limit = 7,
}

/// Why a call is refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The kind.
    pub code: Code,
    /// The item, its value, the limit and what to do.
    pub message: String,
}

impl Fault {
    /// A fault with its message.
    pub fn new(code: Code, message: impl ToString) -> Self {
        Self { code, message: message.to_string() }
    }
}

/// Whether `bytes` more can be had now. Allocating without asking ends the module where they
/// cannot.
pub(crate) fn has_room(bytes: usize) -> bool {
    Vec::<u8>::new().try_reserve_exact(bytes).is_ok()
}
