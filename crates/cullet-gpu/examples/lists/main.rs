//! Lists of many scenes and views by the CPU and, where there is a device, a check that it lists
//! the same.
//!
//! `cargo run --release -p cullet-gpu --example lists`; `WGPU_BACKEND=gl` asks OpenGL. With `CULLET_REQUIRE_GPU` set there must be a
//! device.

mod answers;
mod device;
mod lists;
mod scenes;

use answers::{answers, report};
use cullet_gpu::{GpuError, Passes, Tier, testing, wait};
use device::least;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let gpu = match wait(least()) {
        Ok(gpu) => gpu,
        Err(why @ GpuError::NoAdapter { .. }) if !testing::is_required(Tier::Compute) => {
            eprintln!("by the CPU alone: {why}");
            println!("{}", report(&wait(answers(None))?)?);
            return Ok(());
        }
        Err(why) => return Err(why.into()),
    };
    let info = gpu.adapter.get_info();
    eprintln!("on {} ({:?})", info.name, info.backend);
    // Lists need no pyramid.
    let passes = Passes::without_occlusion(&gpu.device)?;
    println!("{}", report(&wait(answers(Some((&gpu, &passes))))?)?);
    Ok(())
}
