//! Answers of the engine as hashes, a line each: two machines agree where the lines do.
//!
//! What a view sees, each pixel of its occlusion buffer, lights and their casters, lines of sight,
//! what is prepared and baked, and the functions below all of it. SIMD levels of one machine are
//! held against each other here, so that a line names none. `cargo xtask test platforms` runs it on
//! all that it can get.
#![forbid(unsafe_code)]

mod bakes;
mod functions;
mod hash;
mod scenes;

use std::process::ExitCode;

fn main() -> ExitCode {
    let bits = usize::BITS;
    eprintln!("{} {}, {bits} bits", std::env::consts::ARCH, std::env::consts::OS);
    eprintln!("SIMD levels: {:?}", cullet::Simd::all());
    match functions::run().and_then(|()| scenes::run()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("everywhere: {why}");
            ExitCode::FAILURE
        }
    }
}
