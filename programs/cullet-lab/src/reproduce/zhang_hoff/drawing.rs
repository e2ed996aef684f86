//! How long a frame takes: the reference renderer draws what the masks leave.
//!
//! A frame with masks is all that such a frame takes: a mask for each copy, the list of what is
//! left, and drawing it. A frame without is the same call for all triangles; the renderer sets each
//! one up and finds by its winding on the screen whether it faces away, as a graphics card does.

use std::time::{Duration, Instant};

use crate::methods::Bulk;
use cullet::cull::Indices;
use cullet::cull::backface::Planes8;
use cullet::{
    Camera, Depth, Instance, Projection, Scene, Simd, Transform, View, Visible, draw::TriangleRange,
};
use cullet_command::console::{Console, interrupted};
use cullet_command::exit::{Exit, Failure};
use cullet_draw::{Frame, RenderOptions, Selection, render};

use super::culling::{Grids, Pair, mask_to};
use crate::shapes::fibonacci;

/// Each frame is drawn so often each way at the most, and as long as this; the fastest counts.
const PASSES: usize = 40;
const PATIENCE: Duration = Duration::from_secs(4);

/// Results of drawing.
#[derive(Debug)]
pub(super) struct Times {
    /// Views drawn.
    pub(super) frames: u32,
    /// Whether all lists gave the image of the whole.
    pub(super) images_agree: bool,
    /// Share culled by the 8-bit planes in those views.
    pub(super) planes8_percent: f64,
    /// Milliseconds a frame, means over the views; `None` where none was drawn.
    pub(super) ms: Option<Milliseconds>,
}

/// Milliseconds a frame, by what is drawn.
#[derive(Debug)]
pub(super) struct Milliseconds {
    pub(super) baseline: f64,
    pub(super) empty: f64,
    pub(super) planes8: f64,
    /// For each grid.
    pub(super) masks: Vec<f64>,
}

/// How what is drawn is chosen.
#[derive(Clone, Copy, Debug)]
enum Way {
    All,
    Nothing,
    Planes8,
    Masks(usize),
}

/// Memory that is reused from frame to frame.
#[derive(Debug, Default)]
struct Lists {
    kept: Indices,
    visible: Visible,
}

/// Draws some views every way.
pub(super) fn draw(
    pair: &Pair,
    grids: &Grids,
    radii: f64,
    (frames, size): (u32, [u32; 2]),
    console: &Console,
) -> Result<Times, Failure> {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(pair.subject.mesh.clone());
    for offset in pair.offsets {
        let instance = Instance::new(mesh, Transform::from_translation(offset));
        scene.add(instance).map_err(internal)?;
    }
    scene.commit(&cullet::Culler::default());
    let mesh = &pair.subject.mesh;
    let planes = Planes8::new(mesh.positions(), mesh.indices());
    let mut ways = vec![Way::All, Way::Nothing, Way::Planes8];
    ways.extend((0..grids.0.len()).map(Way::Masks));
    let (mut sums, mut drawn) = (vec![Duration::ZERO; ways.len()], 0);
    let (mut images_agree, mut kept_by_planes) = (true, 0);
    let mut lists = Lists::default();
    let options = RenderOptions { threads: 1, ..RenderOptions::default() };
    let mut progress = console.progress("drawing", u64::from(frames));
    for i in 0..frames {
        let direction = fibonacci(i as usize, frames as usize);
        let view = view(pair, direction, radii, size)?;
        let eyes = pair.eyes(direction, radii);
        let mut best = vec![Duration::MAX; ways.len()];
        let mut whole: Option<Frame> = None;
        let begin = Instant::now();
        // All ways in turn, so that what disturbs one disturbs all.
        for pass in 0..PASSES {
            if pass > 0 && begin.elapsed() > PATIENCE {
                break;
            }
            for (&way, best) in ways.iter().zip(&mut best) {
                let start = Instant::now();
                let selection = match way {
                    Way::All => Selection::All,
                    Way::Nothing => {
                        lists.clear();
                        Selection::Visible(&lists.visible)
                    }
                    Way::Planes8 => lists.list(eyes, |eye, kept| {
                        planes.keep(Simd::best(), eye, kept);
                    }),
                    Way::Masks(n) => lists.list(eyes, |eye, kept| {
                        let (grid, masks) = &grids.0[n];
                        let mask = mask_to(grid, eye, &pair.subject.sphere);
                        masks.keep(Simd::best(), &mask, kept);
                    }),
                };
                let frame = render(&scene, &view, selection, &options);
                *best = start.elapsed().min(*best);
                match (way, &whole) {
                    (Way::Nothing, _) => {}
                    (Way::All, _) => whole = Some(frame),
                    (_, Some(whole)) => images_agree &= frame.ids == whole.ids,
                    (_, None) => {}
                }
                if pass == 0 && matches!(way, Way::Planes8) {
                    kept_by_planes += lists.visible.triangles.len() as u64;
                }
            }
        }
        progress.step();
        drawn += 1;
        sums.iter_mut().zip(&best).for_each(|(sum, best)| *sum += *best);
        if interrupted() {
            break;
        }
    }
    progress.finish();
    let mean = |sum: Duration| sum.as_secs_f64() * 1e3 / f64::from(drawn);
    let all = pair.triangles() * u64::from(drawn);
    Ok(Times {
        frames: drawn,
        images_agree,
        planes8_percent: (all - kept_by_planes) as f64 * 100.0 / all.max(1) as f64,
        ms: (drawn > 0).then(|| Milliseconds {
            baseline: mean(sums[0]),
            empty: mean(sums[1]),
            planes8: mean(sums[2]),
            masks: sums[3..].iter().map(|&s| mean(s)).collect(),
        }),
    })
}

impl Lists {
    fn clear(&mut self) {
        self.visible.triangles.clear();
        self.visible.triangle_ranges.clear();
    }

    /// The triangles of each copy that are kept, seen from an eye in its own space.
    fn list(
        &mut self,
        eyes: [[f64; 4]; 2],
        mut keep: impl FnMut([f64; 4], &mut Indices),
    ) -> Selection<'_> {
        self.clear();
        let visible = &mut self.visible;
        for (slot, eye) in (0..).zip(eyes) {
            keep(eye, &mut self.kept);
            let (first, count) = (visible.triangles.len() as u32, self.kept.len() as u32);
            visible.triangle_ranges.push(TriangleRange { slot, level: 0, first, count });
            visible.triangles.extend_from_slice(&self.kept);
        }
        Selection::Visible(visible)
    }
}

/// A view of both copies that they just fit.
fn view(pair: &Pair, direction: [f64; 3], radii: f64, size: [u32; 2]) -> Result<View, Failure> {
    // A little more than the tangent to the sphere, which the window is to hold.
    let sine = 1.0 / (radii * 0.98);
    let tangent = sine / (1.0 - sine * sine).max(1e-6).sqrt();
    let aspect = f64::from(size[0]) / f64::from(size[1]);
    let fov_y_radians = 2.0 * (tangent / aspect.min(1.0)).atan();
    let near = (radii - 1.0) * pair.radius * 0.5;
    let projection = Projection::Perspective { fov_y_radians, aspect, near, far: f64::INFINITY };
    let eye = direction.map(|v| v * radii * pair.radius);
    View::new(&Camera::look_at(eye, [0.0; 3], projection), Depth::Reversed, size).map_err(internal)
}

/// A failure that only a fault of this program can cause.
pub(super) fn internal(error: impl ToString) -> Failure {
    Failure { exit: Exit::Internal, message: error.to_string() }
}
