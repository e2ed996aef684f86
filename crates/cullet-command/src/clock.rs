//! The clock of commands that time stages.

use std::sync::OnceLock;
use std::time::Instant;

/// Nanoseconds since the first call.
pub fn clock() -> u64 {
    static START: OnceLock<Instant> = OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_nanos() as u64
}
