//! Savings of each stage of culling for a renderer: frame times against those of a renderer that
//! leaves back faces to the graphics hardware and hands it everything, and the check that the
//! pictures are the same.

use std::io::Write;
use std::time::Instant;

use cullet::{Output, View, ViewState, Visible, view::CullFace};
use cullet_gpu::{GpuError, Tier};
use cullet_scenes::paths::PathSpec;

use crate::draw::{DrawError, Pane, Renderer, Style};
use crate::headless::{self, Gpu};
use crate::numbers::grouped;
use crate::state::Stages;
use crate::world::World;

/// The pictures' size.
const SIZE: [u32; 2] = [1280, 720];
/// Views of each path.
const VIEWS: usize = 4;
/// Measured frames of each view, of which the fastest counts: what else the machine does only adds.
/// One before them makes lists and pipelines.
const FRAMES: usize = 5;
const GROUND: [f32; 3] = [0.1, 0.12, 0.15];

/// Why there is no measurement.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// There is no device, or it went away.
    #[error(transparent)]
    Device(#[from] GpuError),
    /// The scene does not fit.
    #[error(transparent)]
    Draw(#[from] DrawError),
    /// Nobody reads the table.
    #[error("the table cannot be written: {0}")]
    Write(#[from] std::io::Error),
}

/// A way to draw a frame.
struct Way {
    name: &'static str,
    /// The culling settings; `None` hands everything to the device.
    stages: Option<Stages>,
    faces: CullFace,
}

fn ways() -> Vec<Way> {
    let way = |name, stages| Way { name, stages, faces: CullFace::Back };
    let deep = |depth| Stages { depth, ..Stages::without_occlusion() };
    vec![
        Way { name: "nothing is culled", stages: None, faces: CullFace::None },
        way(BASE, None),
        way("+ frustum, whole instances", Some(Stages::frustum_only())),
        way("+ back faces, clusters", Some(deep(Output::Clusters))),
        way("  the same by triangles", Some(deep(Output::Triangles))),
        way("+ occlusion, clusters", Some(Stages::default())),
        way(
            "  the same by triangles",
            Some(Stages { depth: Output::Triangles, ..Stages::default() }),
        ),
    ]
}

/// The way that the others are measured against.
const BASE: &str = "hardware back faces alone";

/// Figures of a way, on average over the views.
#[derive(Clone, Copy, Debug, Default)]
struct Took {
    culling_ms: f64,
    frame_ms: f64,
    triangles: u64,
    /// Pixels that are not as the base drew them, of all views.
    other: u64,
}

/// Measures a scene and writes a table to `out`. Returns how many pixels culling changed: none,
/// unless something is wrong. A frame is culling, drawing and waiting for the device, one after the
/// other.
///
/// # Errors
/// See [`BenchError`].
pub fn run(world: &World, out: &mut impl Write) -> Result<u64, BenchError> {
    let gpu = Gpu::open(Tier::Draw)?;
    let info = gpu.adapter.get_info();
    let mut renderer = Renderer::new(&gpu.adapter, &gpu.device);
    renderer.set_scene(&gpu.device, &gpu.queue, &world.model)?;
    let [w, h] = SIZE;
    let instances = grouped(world.counts.instances);
    let triangles = grouped(world.counts.triangles);
    writeln!(
        out,
        "{}: {triangles} triangles of {instances} instances, {w}x{h}, {}",
        world.name, info.name
    )?;
    let mut changed = 0;
    for path in [PathSpec::Walk, PathSpec::Orbit] {
        let rigs = world.path(&path, VIEWS, SIZE);
        let views: Vec<View> = rigs.iter().filter_map(|r| r.view(SIZE).ok()).collect();
        if views.is_empty() {
            writeln!(out, "\n{path}: the scene leaves no room for it")?;
            continue;
        }
        let n = views.len();
        writeln!(
            out,
            "\n{path}: mean of {n} views, of each the fastest of {FRAMES} frames{}",
            load()
        )?;
        writeln!(
            out,
            "{:27} {:>10} {:>10} {:>9} {:>8} {:>13}  picture",
            "", "culling ms", "frame ms", "frames/s", "faster", "triangles"
        )?;
        let mut bench = Bench { gpu: &gpu, renderer: &mut renderer, world, views: &views };
        let base = Way { name: BASE, stages: None, faces: CullFace::Back };
        let mut pictures = vec![Vec::new(); views.len()];
        let against = bench.measure(&base, &mut pictures, true)?;
        for way in ways() {
            let took = match way.name {
                BASE => against,
                _ => bench.measure(&way, &mut pictures, false)?,
            };
            let picture = match (way.name, took.other) {
                (BASE, _) => "the base".to_owned(),
                (_, 0) => "the same".to_owned(),
                (_, n) => format!("{} pixels differ", grouped(n)),
            };
            if way.stages.is_some() {
                changed += took.other;
            }
            writeln!(
                out,
                "{:27} {:10.2} {:10.2} {:9.1} {:7.2}x {:>13}  {picture}",
                way.name,
                took.culling_ms,
                took.frame_ms,
                1e3 / took.frame_ms,
                against.frame_ms / took.frame_ms,
                grouped(took.triangles)
            )?;
        }
    }
    Ok(changed)
}

/// Load of the machine, where the system tells it: a time measured beside other work means little.
fn load() -> String {
    let text = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let processors = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    match text.split_whitespace().next() {
        Some(load) => format!("; load {load} on {processors} processors"),
        None => String::new(),
    }
}

struct Bench<'a> {
    gpu: &'a Gpu,
    renderer: &'a mut Renderer,
    world: &'a World,
    views: &'a [View],
}

impl Bench<'_> {
    /// Draws every view in one way; `keep` keeps the pictures, else they are compared with those.
    fn measure(
        &mut self,
        way: &Way,
        pictures: &mut [Vec<[u8; 4]>],
        keep: bool,
    ) -> Result<Took, BenchError> {
        let Gpu { device, queue, .. } = self.gpu;
        let culler = way.stages.as_ref().map(|s| {
            let mut culler = s.culler(crate::task::clock);
            // A renderer asks for neither.
            (culler.reasons, culler.clock) = (false, None);
            culler
        });
        let (mut state, mut visible) = (ViewState::default(), Visible::default());
        let mut sum = Took::default();
        for (view, picture) in self.views.iter().zip(pictures) {
            let mut view = view.clone();
            view.cull_face = way.faces;
            let mut frames = Vec::new();
            for frame in 0..=FRAMES {
                let began = Instant::now();
                if let Some(culler) = &culler {
                    self.world.model.in_cells().cull(culler, &view, &mut state, &mut visible);
                }
                let culled = began.elapsed();
                let pane = Pane {
                    place: [0, 0, SIZE[0], SIZE[1]],
                    view: &view,
                    on_device: false,
                    visible: culler.as_ref().map(|_| &visible),
                    style: Style::default(),
                    over: false,
                    lines: &[],
                    overlay: &[],
                    ghosts: &[],
                };
                self.renderer.draw(device, queue, SIZE, GROUND, &[pane]);
                self.gpu.finish()?;
                if frame > 0 {
                    frames.push((began.elapsed(), culled));
                }
            }
            let (whole, culled) = frames.into_iter().min().unwrap_or_default();
            sum.frame_ms += whole.as_secs_f64() * 1e3;
            sum.culling_ms += culled.as_secs_f64() * 1e3;
            sum.triangles += self.renderer.stats().triangles;
            let (_, pixels) = headless::picture(self.gpu, self.renderer)?;
            if keep {
                *picture = pixels;
            } else {
                sum.other += picture.iter().zip(&pixels).filter(|(a, b)| a != b).count() as u64;
            }
        }
        let count = self.views.len() as f64;
        sum.culling_ms /= count;
        sum.frame_ms /= count;
        sum.triangles /= self.views.len() as u64;
        Ok(sum)
    }
}
