//! Results of a measurement of occlusion culling, for people and as JSON.

use cullet::Simd;
use cullet_command::console::{Console, count, grouped};
use serde::Serialize;

use super::super::measure::{fastest_of_both, stream};
use super::super::measured::{Measured, Workload};
use super::measure::{Found, MODES, Mode, ObjectTests};
use super::scene::Prepared;
use super::truth::Agreement;

/// Results that `cullet bench occlusion` adds: means over views.
#[derive(Clone, Debug, Serialize)]
pub struct Occlusion {
    /// The SIMD level.
    level: &'static str,
    /// Width and height of the buffer.
    resolution: [u32; 2],
    /// How many views were measured.
    views: usize,
    /// Bytes that the same run read a nanosecond at the same level, from the scene's triangles.
    streaming_gb_per_s: f64,
    /// The ways to fill the buffer.
    modes: [Mode; 3],
    /// The tests of objects.
    test: ObjectTests,
    /// Beside what is really hidden.
    references: Vec<Agreement>,
}

/// The streaming rate of this run.
#[derive(Clone, Copy, Debug)]
pub(super) struct Streaming {
    /// Bytes a nanosecond.
    rate: f64,
}

/// Seconds to find the streaming rate in.
const SECONDS: f64 = 0.05;

/// Reads as many bytes as the scene's vertices and triangles have.
pub(super) fn streaming(prepared: &Prepared, simd: Simd) -> Streaming {
    let scene = &prepared.scene;
    let floats = vec![1.0f32; (scene.vertices.len() + scene.triangles.len()) * 3];
    let [time, _] = fastest_of_both(SECONDS, |turn| stream(simd, &floats, turn), || {});
    Streaming { rate: (floats.len() * 4) as f64 / time }
}

/// `1e5`
pub(super) fn power(n: usize) -> String {
    let digits = (n.max(1) as f64).log10().floor() as u32;
    format!("{}e{digits}", n / 10usize.pow(digits))
}

/// The workloads of a scene.
pub(super) fn names(scene: &str) -> [String; 4] {
    let [raw, sorted, interleaved] = MODES;
    [raw, sorted, interleaved, "test"].map(|what| format!("{scene}/{what}"))
}

/// Bytes of a triangle: its indices, and its share of the vertices.
fn bytes_a_triangle(prepared: &Prepared) -> usize {
    let scene = &prepared.scene;
    12 + 12 * scene.vertices.len() / scene.triangles.len().max(1)
}

/// Returns the results as entries of the benchmark's list: an item is a triangle handed over, or an
/// object in the frustum.
pub(super) fn measured(
    scene: &str,
    level: &'static str,
    prepared: &Prepared,
    found: &Found,
    streaming: &Streaming,
    checked: bool,
    each: &mut dyn FnMut(Measured),
) {
    const BOX_BYTES: usize = 24;
    let test = &found.test;
    let modes = found.modes.iter().map(|m| {
        let time = (m.clear_ms + m.render_ms) * 1e6;
        (m.triangles, time, bytes_a_triangle(prepared), m.pieces)
    });
    let tests = (test.in_frustum, test.ns_per_object * test.in_frustum, BOX_BYTES, test.visible);
    for (name, (items, time, bytes, visible)) in names(scene).into_iter().zip(modes.chain([tests]))
    {
        let items = (items.round() as usize).max(1);
        let limit = (items * bytes) as f64 / streaming.rate;
        let visible = visible.round() as usize;
        let workload = Workload { name, level, items, visible, checked };
        each(workload.streaming(bytes, [limit, time]));
    }
}

impl Occlusion {
    /// The results at a SIMD level and resolution.
    pub(super) fn new(
        level: &'static str,
        resolution: [u32; 2],
        found: &Found,
        references: Vec<Agreement>,
        streaming: &Streaming,
    ) -> Self {
        Self {
            level,
            resolution,
            views: found.views,
            streaming_gb_per_s: streaming.rate,
            modes: found.modes,
            test: found.test,
            references,
        }
    }
}

/// Prints the measurement of a file.
pub(super) fn print(name: &str, prepared: &Prepared, o: &Occlusion, console: &Console) {
    let scene = &prepared.scene;
    let rounded = |n: f64| grouped(n.round() as u64);
    let [width, height] = o.resolution;
    console.line(format!(
        "{name}: {} in {}, {}, {} of {width}x{height}; one thread, {}",
        count(scene.triangles.len() as u64, "triangle", "triangles"),
        count(scene.meshes.len() as u64, "mesh", "meshes"),
        count(prepared.objects.len() as u64, "object", "objects"),
        count(o.views as u64, "view", "views"),
        o.level
    ));
    console.line(format!(
        "means over views of the fastest pass, and of the median; streaming {:.1} GB/s in the same run",
        o.streaming_gb_per_s
    ));
    console
        .line("mode         clear ms  render ms  (median)  prepare ms  triangles  ns/triangle  pieces drawn");
    for m in &o.modes {
        let each = (m.clear_ms + m.render_ms) * 1e6 / m.triangles.max(1.0);
        console.line(format!(
            "{:<12} {:>8.4} {:>10.4} {:>9.4} {:>11.4} {:>10} {each:>12.2} {:>13}",
            m.name,
            m.clear_ms,
            m.render_ms,
            m.median_ms,
            m.prepare_ms,
            rounded(m.triangles),
            rounded(m.pieces)
        ));
    }
    let t = &o.test;
    console.line(format!(
        "test         {:.2} ns each of {} objects in the frustum; {:.4} ms for all {}",
        t.ns_per_object,
        rounded(t.in_frustum),
        t.all_ms,
        rounded(prepared.objects.len() as f64)
    ));
    let share = t.culled / t.in_frustum.max(1.0) * 100.0;
    console.line(format!(
        "             {} culled ({share:.2} %), {} visible",
        rounded(t.culled),
        rounded(t.visible)
    ));
    if o.references.is_empty() {
        console
            .line("no reference beside the file; --reference 4 draws one, to hold answers against");
    }
    for v in &o.references {
        console.line(format!(
            "reference {}x{}: {:.2} % of {} hidden objects found; {} false culls of {} visible",
            v.samples,
            if v.jittered { ", jittered" } else { "" },
            v.efficiency,
            grouped(v.hidden),
            grouped(v.false_culls),
            grouped(v.visible)
        ));
    }
}
