//! The path, and what each way of culling costs along it.

use std::time::Instant;

use cullet::cull::frustum::batch::Planes;
use cullet::cull::frustum::tree::Cut;
use cullet::{Camera, Projection, Simd};
use cullet_command::console::{Console, grouped, interrupted};
use cullet_command::exit::{Exit, Failure};
use cullet_io::Model;
use glam::{DVec2, DVec3};

use super::record::{AssarssonMollerRecord, TricksRow, WideRow};
use super::scalar::{Counts, Sides, Tree, Tricks, sides};
use cullet_command::machine::Machine;

/// Each way goes along the path so often; of each frame the fastest counts.
const PASSES: usize = 5;

/// More boxes than this do not end within some minutes.
const MOST_BOXES: u32 = 4_000_000;

const FOV_DEGREES: f64 = 60.0;

const NONE: Tricks = Tricks { octant: false, masking: false, plane: false, motion: false };
const VARIANTS: [(&str, Tricks); 7] = [
    ("plain", NONE),
    ("octant test", Tricks { octant: true, ..NONE }),
    ("masking", Tricks { masking: true, ..NONE }),
    ("plane coherency", Tricks { plane: true, ..NONE }),
    ("motion coherency", Tricks { motion: true, ..NONE }),
    ("masking and motion", Tricks { masking: true, motion: true, ..NONE }),
    ("all four", Tricks { octant: true, masking: true, plane: true, motion: true }),
];

/// A frame in both forms.
struct Frame {
    sides: Sides,
    planes: Planes,
}

/// A time and a cost for every frame.
struct Cost {
    ns: Vec<f64>,
    nodes: u64,
    planes: u64,
}

impl Cost {
    fn new(frames: usize) -> Self {
        Self { ns: vec![f64::INFINITY; frames], nodes: 0, planes: 0 }
    }

    fn took(&mut self, frame: usize, start: Instant) {
        let ns = start.elapsed().as_nanos().max(1) as f64;
        self.ns[frame] = self.ns[frame].min(ns);
    }

    fn add(&mut self, counts: Counts) {
        self.nodes += counts.nodes;
        self.planes += counts.planes;
    }

    fn mean_ns(&self, frames: usize) -> f64 {
        self.ns[..frames].iter().sum::<f64>() / frames as f64
    }
}

/// How the view goes through the scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct Walk {
    pub(super) frames: u32,
    /// Angle by which it turns from frame to frame.
    pub(super) degrees: f64,
    /// How far it goes from frame to frame; a ten-thousandth of the scene where not said.
    pub(super) stride: Option<f64>,
}

/// Measures everything.
pub(super) fn all(
    walk: &Walk,
    model: &Model,
    console: &Console,
) -> Result<AssarssonMollerRecord, Failure> {
    let scene = &model.scene;
    let count = scene.slot_count();
    if count > MOST_BOXES {
        let message = format!(
            "{}: {} instances, {} at the most; choose a smaller model",
            model.name,
            grouped(u64::from(count)),
            grouped(u64::from(MOST_BOXES))
        );
        return Err(Failure { exit: Exit::Limit, message });
    }
    let (frames, stride) = path(walk, model)?;
    // The very boxes that the engine tests, so that the answers can be compared.
    let boxes: Vec<[DVec3; 2]> = (0..count as usize)
        .map(|slot| scene.boxes().get(slot))
        .map(|b| [b.min, b.max].map(|v| DVec3::from(v.map(f64::from))))
        .collect();
    let tree = Tree::new(&boxes);
    let hierarchy = scene.hierarchy();
    let level = Simd::best();
    let words = boxes.len().div_ceil(64);
    let (mut truth, mut found) = (vec![0_u64; words], vec![0_u64; words]);
    let mut costs: Vec<Cost> = VARIANTS.iter().map(|_| Cost::new(frames.len())).collect();
    let mut wide = Cost::new(frames.len());
    let mut record = AssarssonMollerRecord {
        schema: 1,
        model: model.name.clone(),
        boxes: u64::from(count),
        frames: 0,
        degrees: walk.degrees,
        stride,
        fov_degrees: FOV_DEGREES,
        visible_percent: 0.0,
        machine: Machine::here(),
        rows: Vec::new(),
        wide: Vec::new(),
        frames_differing: 0,
        lost: 0,
        kept_at_the_border: 0,
        visible_in_all: 0,
        complete: true,
    };
    let mut runs = Vec::new();
    let mut progress = console.progress("culling", (PASSES * frames.len()) as u64);
    'all: for pass in 0..PASSES {
        let mut states: Vec<_> = VARIANTS.iter().map(|_| tree.state()).collect();
        let mut cut = Cut::new();
        for (at, frame) in frames.iter().enumerate() {
            // A pass that ends early is one the less; but of the first, what was done is all there
            // is.
            if interrupted() {
                record.complete = false;
                break 'all;
            }
            let first = pass == 0;
            for (i, ((_, tricks), cost)) in VARIANTS.iter().zip(&mut costs).enumerate() {
                let start = Instant::now();
                let counts = tree.cull(&frame.sides, *tricks, &mut states[i], &mut runs);
                cost.took(at, start);
                if first {
                    cost.add(counts);
                    let into = if i == 0 { &mut truth } else { &mut found };
                    tree.mark(&runs, into);
                    record.frames_differing += u64::from(i > 0 && found != truth);
                }
            }
            let start = Instant::now();
            cut.cull(level, &frame.planes, hierarchy.nodes(), hierarchy.boxes());
            wide.took(at, start);
            if first {
                record.frames += 1;
                wide.planes += cut.plane_tests() * 16;
                for (&exact, &kept) in truth.iter().zip(cut.visible()) {
                    record.visible_in_all += u64::from(exact.count_ones());
                    record.lost += u64::from((exact & !kept).count_ones());
                    record.kept_at_the_border += u64::from((kept & !exact).count_ones());
                }
            }
            progress.step();
        }
    }
    progress.finish();
    let done = record.frames as usize;
    if done == 0 {
        return Ok(record);
    }
    let per_frame = |n: u64| n as f64 / done as f64;
    record.visible_percent = per_frame(record.visible_in_all) * 100.0 / f64::from(count.max(1));
    let plain = costs[0].mean_ns(done);
    record.rows = VARIANTS
        .iter()
        .zip(&costs)
        .map(|((variant, _), cost)| {
            let ns = cost.mean_ns(done);
            TricksRow {
                variant,
                nodes: per_frame(cost.nodes),
                plane_tests: per_frame(cost.planes),
                ns,
                fewer_tests: costs[0].planes as f64 / cost.planes.max(1) as f64,
                speedup: plain / ns,
            }
        })
        .collect();
    let ns = wide.mean_ns(done);
    record.wide = vec![WideRow {
        variant: "sixteen at once",
        plane_tests: per_frame(wide.planes),
        ns,
        speedup: plain / ns,
    }];
    Ok(record)
}

/// The frames of the walk: around a circle, or straight on where the view does not turn; and the
/// stride.
fn path(walk: &Walk, model: &Model) -> Result<(Vec<Frame>, f64), Failure> {
    let extent = model.scene.extent();
    let empty = || {
        Failure::input(format!(
            "{}: no instance has finite bounds, so there is nowhere to walk; choose another model",
            model.name
        ))
    };
    if extent.is_empty() {
        return Err(empty());
    }
    let [min, max] = [extent.min, extent.max].map(|v| DVec3::from(v.map(f64::from)));
    let (middle, diagonal) = ((min + max) * 0.5, (max - min).length());
    if !(diagonal > 0.0 && diagonal.is_finite()) {
        return Err(empty());
    }
    let stride = walk.stride.unwrap_or(diagonal * 1e-4);
    let step = walk.degrees.to_radians();
    let length = stride * f64::from(walk.frames);
    // All of the scene is before far, wherever the walk goes.
    let projection = Projection::Perspective {
        fov_y_radians: FOV_DEGREES.to_radians(),
        aspect: 16.0 / 9.0,
        near: diagonal * 1e-5,
        far: diagonal * 1.1 + length,
    };
    let mut at = DVec2::new(middle.x, middle.z);
    let mut frames = Vec::with_capacity(walk.frames as usize);
    for frame in 0..walk.frames {
        // Not along an axis, where planes are simpler than elsewhere.
        let (x, z) = (0.3 + step * f64::from(frame)).sin_cos();
        let camera = Camera {
            eye: [at.x, middle.y, at.y],
            direction: [x, -0.05, z],
            up: [0.0, 1.0, 0.0],
            projection,
        };
        let frustum = camera.frustum().map_err(Failure::usage)?;
        let sides = sides(&frustum).ok_or_else(empty)?;
        frames.push(Frame { sides, planes: Planes::new(&frustum) });
        at += DVec2::new(x, z) * stride;
    }
    Ok((frames, stride))
}
