//! Native version of the page's work: 100,000 boxes and as many instances, culled from a camera
//! that turns and read back. `web_native [LEVEL]` prints, for `test/cost.mjs`, how many were listed
//! in all and the least and median microseconds.

use std::time::Instant;

use cullet::Simd;
use cullet_web::{BoxSet, Kind, SceneSet, SceneView, Settings};

const COUNT: usize = 100_000;
const FRAMES: usize = 200;

/// The same numbers as in the page.
struct Random(u32);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(self.0) / f64::from(u32::MAX) * 2.0 - 1.0
    }
}

fn clip(frame: usize) -> [f64; 16] {
    let (s, c) = (frame as f64 * 0.02).sin_cos();
    let (y, near, far) = (1.0 / (0.5_f64).tan(), 0.1, 700.0);
    let (x, z, w) = (y / 1.6, far / (near - far), near * far / (near - far));
    // The projection times a turn about Y.
    [x * c, 0.0, -s * z, s, 0.0, y, 0.0, 0.0, x * s, 0.0, c * z, -c, 0.0, 0.0, w, 0.0]
}

fn planes(m: &[f64; 16]) -> [f64; 24] {
    let row = |r: usize| [m[r], m[4 + r], m[8 + r], m[12 + r]];
    let [x, y, z, w] = [0, 1, 2, 3].map(row);
    let rows = [(w, x, 1.0), (w, x, -1.0), (w, y, 1.0), (w, y, -1.0), (z, z, 0.0), (w, z, -1.0)];
    let mut out = [0.0; 24];
    for (i, (a, b, s)) in rows.iter().enumerate() {
        (0..4).for_each(|j| out[i * 4 + j] = a[j] + s * b[j]);
    }
    out
}

fn report(name: &str, mut frame: impl FnMut(usize) -> usize) {
    let mut times = Vec::new();
    let mut listed = 0;
    for i in 0..FRAMES + 20 {
        let start = Instant::now();
        let count = frame(i);
        if i >= 20 {
            times.push(start.elapsed().as_nanos() as f64 / 1000.0);
            listed += count;
        }
    }
    times.sort_by(f64::total_cmp);
    println!("{name} {listed} {:.1} {:.1}", times[0], times[FRAMES / 2]);
}

fn main() {
    let name = std::env::args().nth(1).unwrap_or_else(|| "sse2".to_owned());
    let Some(level) = Simd::all().into_iter().find(|l| l.name() == name) else {
        eprintln!("there is no level {name}; there are {:?}", Simd::all());
        std::process::exit(2);
    };
    let mut random = Random(7);
    let places: Vec<[f64; 3]> =
        (0..COUNT).map(|_| [0; 3].map(|_| (random.next() * 500.0).trunc())).collect();
    let Some(set) = BoxSet::new(COUNT) else { return };
    let mut set = set.at_level(level);
    for (b, p) in set.boxes_mut().iter_mut().zip(&places) {
        let [x, y, z] = p.map(|v| v as f32);
        *b = [x - 1.0, y - 1.0, z - 1.0, x + 1.0, y + 1.0, z + 1.0];
    }
    set.commit(0, COUNT, false);
    report("boxes", |i| {
        set.cull(0, &planes(&clip(i)));
        set.visible(0).iter().fold(0_usize, |sum, &v| sum.wrapping_add(v as usize))
    });
    let mut scene = SceneSet::new(cullet::Scene::new());
    let positions: Vec<f32> = (0..8)
        .flat_map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|v| if v == 1 { 1.0 } else { -1.0 }))
        .collect();
    let indices = [
        0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6,
        1, 3, 5, 3, 7, 5,
    ];
    let Ok(mesh) = scene.add_mesh(&positions, &indices, &[], Kind(0)) else { return };
    let matrix = |p: &[f64; 3]| {
        [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, p[0], p[1], p[2], 1.0]
    };
    let matrices: Vec<f64> = places.iter().flat_map(matrix).collect();
    if scene.add(mesh, &matrices, 1, 0).is_err() {
        return;
    }
    scene.commit();
    for (name, flags) in [("frustum", 1), ("occlusion", 0)] {
        let mut view = SceneView::new(Settings { preset: 1, output: 0, flags, draw_us: 0.0 });
        view.culler_mut().simd = level;
        report(name, |i| {
            if view.set_camera(clip(i), 0, [1280, 720], u32::MAX).is_err()
                || view.cull(&scene).is_err()
            {
                return 0;
            }
            view.ids().iter().fold(0_usize, |sum, &v| sum.wrapping_add(v as usize))
        });
    }
}
