//! The program `cullet`.
#![forbid(unsafe_code)]

fn main() {}
