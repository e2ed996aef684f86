//! Works in turn, of which the fastest time counts.

use std::time::Instant;

use cullet_gpu::{Gpu, GpuError};

/// Turns that count: what else a machine does only adds.
pub(crate) const TURNS: usize = 9;

/// Milliseconds of each of some works in each of some turns, one work after the other, so that what disturbs one disturbs all.
pub(crate) fn turns(
    gpu: &Gpu,
    works: usize,
    mut run: impl FnMut(usize) -> Result<(), GpuError>,
) -> Result<Vec<Vec<f64>>, GpuError> {
    let mut all = vec![Vec::with_capacity(TURNS); works];
    for turn in 0..=TURNS {
        for (work, times) in all.iter_mut().enumerate() {
            gpu.finish()?;
            let began = Instant::now();
            run(work)?;
            gpu.finish()?;
            // The first turn makes what is made once.
            if turn > 0 {
                times.push(began.elapsed().as_secs_f64() * 1e3);
            }
        }
    }
    Ok(all)
}

/// The fastest of some times.
pub(crate) fn fastest(times: &[f64]) -> f64 {
    times.iter().copied().fold(f64::INFINITY, f64::min)
}
