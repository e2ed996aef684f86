//! Times `scene.cull(camera).visible` without Python: for `border.py`, which talks to it.
//!
//! `python_border SCENE WIDTH HEIGHT M00 ... M33` (the matrix from world to clip space, column-major, reversed depth) reads
//! numbers of runs from its input, a line each, and answers with the median of their times in nanoseconds, how many
//! instances are visible, and the sum of their ids.

use std::error::Error;
use std::io::BufRead;
use std::time::Instant;

use engine::{Culler, Depth, Scene, View, ViewState, Visible};

/// The ids of what is visible, ascending, as the package gives them.
fn read_back(scene: &Scene, visible: &Visible, bits: &mut Vec<u64>, ids: &mut Vec<u32>) {
    bits.clear();
    bits.resize((scene.slot_count() as usize).div_ceil(64), 0);
    for handle in visible.slots().filter_map(|slot| scene.handle(slot)) {
        bits[handle.index as usize / 64] |= 1 << (handle.index % 64);
    }
    ids.clear();
    for (word, bits) in (0_u32..).zip(bits) {
        while *bits != 0 {
            ids.push(word * 64 + bits.trailing_zeros());
            *bits &= *bits - 1;
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [scene, width, height, matrix @ ..] = &args[..] else {
        return Err("python_border SCENE WIDTH HEIGHT M00 ... M33".into());
    };
    let scene = cullet_scenes::build(scene)?.scene;
    let matrix: Vec<f64> = matrix.iter().map(|v| v.parse()).collect::<Result<_, _>>()?;
    let matrix: [f64; 16] = matrix.try_into().map_err(|_| "a matrix has 16 numbers")?;
    let view = View::from_matrix(matrix, Depth::Reversed, [width.parse()?, height.parse()?])?;
    let culler = Culler::balanced();
    let (mut state, mut visible) = (ViewState::default(), Visible::default());
    let (mut bits, mut ids) = (Vec::new(), Vec::new());
    for line in std::io::stdin().lock().lines() {
        let mut times = Vec::new();
        for _ in 0..line?.trim().parse::<usize>()?.max(1) {
            let begin = Instant::now();
            culler.cull_one(&scene, &view, &mut state, &mut visible);
            read_back(&scene, &visible, &mut bits, &mut ids);
            times.push(begin.elapsed().as_nanos());
        }
        times.sort_unstable();
        let sum: u64 = ids.iter().map(|&id| u64::from(id)).sum();
        println!("{} {} {sum}", times[times.len() / 2], ids.len());
    }
    Ok(())
}
