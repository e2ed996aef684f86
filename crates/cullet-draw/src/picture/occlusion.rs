//! Occlusion culling in a view: its buffer beside the truth, which occluder covers which pixels of
//! it, and the instances that it hides.

use cullet::cull::occlusion::{OcclusionBuffer, TILE};
use cullet::{
    Depth, Scene, Simd, Stage, View, ViewState, Visible, draw::TriangleRange, funnel::Unit,
};
use glam::DVec4;

use super::Picture;
use super::canvas::caption;
use super::canvas::{LINE, grouped, keys, keys_height};
use super::font::{text_height, text_size};
use super::palette::NEIGHBOURS;
use super::palette::{INK, LOST, PAPER, PROVED, UNSEEN, heat, mix, reason_color};
use super::shaded::shaded;
use super::space::{Space, pixel_centre};
use crate::frame::{Frame, PixelId, RenderOptions, Selection};
use crate::render::render;
use crate::sort;

/// Where nothing is proved, or nothing is there.
const OPEN: [u8; 3] = [0xDD, 0xDE, 0xDC];
/// Between panes.
const GAP: u32 = 10;
/// How near to the truth counts as the same, as a share of it.
const ALIKE: f64 = 0.02;

/// State and result of a cull of a view, made with [`Culler::reasons`](cullet::Culler::reasons) and
/// [`Culler::dropped`](cullet::Culler::dropped).
#[derive(Clone, Copy, Debug)]
pub struct Culled<'a> {
    /// The state of the view, right after the cull.
    pub state: &'a ViewState,
    /// Its result.
    pub result: &'a Visible,
}

impl Culled<'_> {
    /// The occlusion buffer, where the cull looked for what is hidden.
    fn buffer(&self) -> Option<&OcclusionBuffer> {
        let looked = self.result.funnel.rows.iter().any(|r| r.stage == Stage::Occlusion);
        self.state.occlusion_buffer().filter(|_| looked)
    }

    /// How many instances came to the stage, and how many it dropped.
    fn counts(&self) -> [u64; 2] {
        let mut rows = self.result.funnel.rows.iter();
        let row = rows.find(|r| r.stage == Stage::Occlusion && r.unit == Unit::Instances);
        row.map_or([0; 2], |r| [r.entered.instances, r.dropped().instances])
    }
}

/// A picture of words alone: that there is nothing to show.
fn off(view: &View) -> Picture {
    let [width, height] = view.viewport();
    let mut picture = Picture::new(width.max(480), height.max(120), PAPER);
    caption(&mut picture, "occlusion culling is off");
    picture
}

/// From depths of a frame to the nearness of the buffer.
struct Nearness {
    space: Space,
    /// Takes a point to its distance along the line of view; `None` where lines of sight are
    /// parallel.
    distance: Option<DVec4>,
    reversed: bool,
    size: [u32; 2],
}

impl Nearness {
    fn new(view: &View, frame: &Frame) -> Self {
        let m = view.clip_from_world();
        let row = DVec4::new(m[3], m[7], m[11], m[15]);
        let distance = (!view.is_orthographic()).then(|| row / row.truncate().length());
        let reversed = view.depth() == Depth::Reversed;
        Self { space: Space::new(view), distance, reversed, size: [frame.width, frame.height] }
    }

    fn of(&self, x: u32, y: u32, depth: f64) -> f64 {
        let Some(row) = self.distance else {
            return if self.reversed { depth } else { 1.0 - depth };
        };
        let [x, y] = pixel_centre(x, y, self.size);
        1.0 / row.dot(self.space.point(x, y, depth).extend(1.0))
    }
}

/// Comparison of a pixel of the buffer with the true depth.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Finding {
    Empty,
    Alike,
    Farther,
    Open,
    Wrong,
}

impl Finding {
    const SHOWN: [Self; 5] = [Self::Alike, Self::Farther, Self::Open, Self::Empty, Self::Wrong];

    fn of(truth: Option<f64>, proved: f64) -> Self {
        match truth {
            None if proved > 0.0 => Self::Wrong,
            None => Self::Empty,
            Some(_) if proved <= 0.0 => Self::Open,
            // The buffer rounds away from the eye, a frame's depth to the nearest f64.
            Some(n) if proved > n * (1.0 + 1e-6) + 1e-12 => Self::Wrong,
            Some(n) if proved >= n * (1.0 - ALIKE) => Self::Alike,
            Some(_) => Self::Farther,
        }
    }

    const fn color(self) -> [u8; 3] {
        match self {
            Self::Empty => OPEN,
            Self::Alike => PROVED,
            Self::Farther => [0x8F, 0xD3, 0xBC],
            Self::Open => UNSEEN,
            Self::Wrong => LOST,
        }
    }

    const fn words(self) -> &'static str {
        match self {
            Self::Empty => "nothing there",
            Self::Alike => "proved, as near as it is",
            Self::Farther => "proved, but farther",
            Self::Open => "not proved",
            Self::Wrong => "NEARER THAN THE TRUTH",
        }
    }
}

/// Four panes: the true depth of the view, the occlusion buffer pixel by pixel, its coarse level of
/// tiles, and how the buffer differs from the truth. A pixel that claims more than is there would
/// be red: there must be none.
///
/// The panes share `size[0]`, at least 640; the picture's height follows from the view. Words alone
/// where the cull had no occlusion culling. Cost: a frame, and some 0.1 µs a pixel.
#[must_use]
pub fn occlusion_buffer(
    scene: &Scene,
    view: &View,
    culled: &Culled<'_>,
    size: [u32; 2],
) -> Picture {
    let Some(buffer) = culled.buffer() else { return off(view) };
    let frame = render(scene, view, Selection::All, &RenderOptions::default());
    let width = size[0].clamp(640, 8192);
    let size = text_size(width);
    let strip = (text_height(size) + 16) as u32;
    let wide = (width - 3 * GAP) / 2;
    let high = (wide * frame.height).checked_div(frame.width).unwrap_or(1).clamp(1, 4 * width);
    let nearness = Nearness::new(view, &frame);
    let scaled =
        |x: u32, from: u32, to: u32| (u64::from(x) * u64::from(to) / u64::from(from)) as u32;
    let truth = |x: u32, y: u32| {
        let [x, y] = [scaled(x, wide, frame.width), scaled(y, high, frame.height)];
        let at = y as usize * frame.width as usize + x as usize;
        (frame.ids[at] != PixelId::NONE).then(|| nearness.of(x, y, frame.depth[at]))
    };
    let [columns, rows] = buffer.size();
    let pixel = |x: u32, y: u32| [scaled(x, wide, columns), scaled(y, high, rows)];
    let range = range((0..high).flat_map(|y| (0..wide).filter_map(move |x| truth(x, y))));
    let shade = |n: f64| if n > 0.0 { heat(0.12 + 0.86 * range.share(n)) } else { OPEN };

    let findings: Vec<Finding> = (0..high)
        .flat_map(|y| (0..wide).map(move |x| (x, y)))
        .map(|(x, y)| {
            let [px, py] = pixel(x, y);
            Finding::of(truth(x, y), f64::from(buffer.nearness(px, py)))
        })
        .collect();
    let entries = shares(&findings);
    let room = i64::from(width - 2 * GAP);
    let line = (size * LINE).round() as i64;
    let legend = (keys_height(room, size, &entries) + line) as u32 + 2 * GAP;
    let mut picture = Picture::new(width, 2 * (high + strip) + legend, PAPER);

    let panes: [[u32; 2]; 4] = [[0, 0], [1, 0], [0, 1], [1, 1]];
    for [column, row] in panes {
        let [left, top] = [GAP + column * (wide + GAP), row * (high + strip) + strip];
        for y in 0..high {
            for x in 0..wide {
                let [px, py] = pixel(x, y);
                let color = match (column, row) {
                    (0, 0) => truth(x, y).map_or(OPEN, shade),
                    (1, 0) => shade(f64::from(buffer.nearness(px, py))),
                    (0, _) => shade(f64::from(buffer.tile_nearness(px, py))),
                    _ => findings[(y * wide + x) as usize].color(),
                };
                picture.blend(i64::from(left + x), i64::from(top + y), color, 1.0);
            }
        }
        let title = match (column, row) {
            (0, 0) => "What is there: the true depth".to_owned(),
            (1, 0) => format!("What is proved: {columns} × {rows} pixels"),
            (0, _) => format!("Tested first: the farthest of each {} × {}", TILE[0], TILE[1]),
            _ => "Proof held against truth".to_owned(),
        };
        picture.text([i64::from(left), i64::from(top - strip) + 9], &title, size, INK);
    }
    let gap = i64::from(GAP);
    let mut y = i64::from(2 * (high + strip)) + gap;
    y = keys(&mut picture, [gap, y], gap + room, size, INK, &entries);
    let [entered, hidden] = culled.counts();
    let work = culled.result.funnel.occlusion;
    let mut x = gap;
    x += picture.text([x, y], "far ", size, INK) + 4;
    let ramp = i64::from(width) / 8;
    for i in 0..ramp {
        let color = heat(0.12 + 0.86 * i as f64 / ramp as f64);
        picture.fill([x + i, y], [1, text_height(size)], color, 1.0);
    }
    x += ramp + 8;
    x += picture.text([x, y], "near", size, INK) + 2 * size as i64;
    let words = format!(
        "{} occluders drawn; {} of {} instances hidden",
        grouped(work.drawn),
        grouped(hidden),
        grouped(entered)
    );
    picture.text([x, y], &words, size, INK);
    picture
}

/// Returns the findings that occur, with their shares.
fn shares(findings: &[Finding]) -> Vec<([u8; 3], String)> {
    let count = |f: Finding| findings.iter().filter(|g| **g == f).count();
    let found = Finding::SHOWN.into_iter().map(|f| (f, count(f))).filter(|(_, n)| *n > 0);
    let share = |n: usize| n as f64 / findings.len().max(1) as f64 * 100.0;
    found.map(|(f, n)| (f.color(), format!("{} {:.1} %", f.words(), share(n)))).collect()
}

/// From the far end of a picture's depths to the near one.
struct NearnessRange {
    low: f64,
    high: f64,
}

/// Returns the range of the positive values but for the nearest and the farthest hundredth, which
/// may be anything.
fn range(nearness: impl Iterator<Item = f64>) -> NearnessRange {
    // Bits of numbers that are not negative ascend as they do.
    let mut sorted: Vec<u64> =
        nearness.filter(|n| *n > 0.0 && n.is_finite()).map(f64::to_bits).collect();
    sort::sort(&mut sorted);
    let at = |share: f64| {
        sorted.get((sorted.len() as f64 * share) as usize).copied().map(f64::from_bits)
    };
    let (low, high) = (at(0.01).unwrap_or(1.0), at(0.99).unwrap_or(1.0));
    NearnessRange { low, high: high.max(low * 1.0001) }
}

impl NearnessRange {
    /// Where a nearness lies in it, 0 to 1: even steps are factors, for near surfaces are far apart
    /// in it.
    fn share(&self, n: f64) -> f64 {
        ((n / self.low).ln() / (self.high / self.low).ln()).clamp(0.0, 1.0)
    }
}

/// Returns the nearest of the drawn occluders on each pixel of the buffer; `usize::MAX` where none
/// is proved.
fn owners(scene: &Scene, view: &View, culled: &Culled<'_>, buffer: &OcclusionBuffer) -> Vec<usize> {
    // The result is the same at every SIMD level.
    let level = Simd::best();
    let [columns, rows] = buffer.size();
    let mut best = vec![(0.0, usize::MAX); columns as usize * rows as usize];
    let Ok(mut alone) = OcclusionBuffer::new(buffer.size()) else { return Vec::new() };
    for (number, &(slot, shape)) in culled.state.occluders_drawn().iter().enumerate() {
        let shape = &scene.prepared_of(slot).shapes()[shape as usize];
        let transform = scene.transform(slot);
        alone.begin(view, scene.origin());
        shape.draw(level, &mut alone, transform);
        let bounds = alone.screen_bounds(&transform.transform_box(&shape.bounds(), scene.origin()));
        // A shape that crosses the near plane may be anywhere.
        let [min, max] = bounds.map_or([[0; 2], [columns - 1, rows - 1]], |b| [b.min, b.max]);
        for y in min[1]..=max[1] {
            for x in min[0]..=max[0] {
                let nearness = alone.nearness(x, y);
                let own = &mut best[y as usize * columns as usize + x as usize];
                if nearness > own.0 {
                    *own = (nearness, number);
                }
            }
        }
    }
    best.into_iter().map(|b| b.1).collect()
}

/// The view as a pale ghost, and over it what each drawn occluder is proved to cover: a colour for
/// each instance, thin lines between its shapes. Pixels of the buffer that are left pale are open.
///
/// `material_colors` are as for [`shaded`](fn@super::shaded). Words alone where the cull had no
/// occlusion culling. Cost: a frame at twice the size, and each occluder drawn once more, alone.
#[must_use]
pub fn occluders(
    scene: &Scene,
    view: &View,
    culled: &Culled<'_>,
    material_colors: &[[f32; 4]],
) -> Picture {
    let Some(buffer) = culled.buffer() else { return off(view) };
    let owners = owners(scene, view, culled, buffer);
    let drawn = culled.state.occluders_drawn();
    let (mut picture, _) = pale(scene, view, material_colors, 0.45);
    let [columns, rows] = buffer.size();
    let large = [picture.width, picture.height];
    let owner = |x: u32, y: u32| {
        let px = u64::from(x) * u64::from(columns) / u64::from(large[0]);
        let py = u64::from(y) * u64::from(rows) / u64::from(large[1]);
        owners[(py * u64::from(columns) + px) as usize]
    };
    for y in 0..large[1] {
        for x in 0..large[0] {
            let own = owner(x, y);
            let slot = |n: usize| drawn.get(n).map(|d| d.0);
            if let Some(slot) = slot(own) {
                // Neighbours in the order of slots get colours that are told apart.
                let color = NEIGHBOURS[slot.wrapping_mul(2_654_435_761) as usize >> 7 & 7];
                picture.blend(i64::from(x), i64::from(y), color, 0.55);
            }
            let next = [owner((x + 1).min(large[0] - 1), y), owner(x, (y + 1).min(large[1] - 1))];
            if next.iter().any(|&n| n != own) {
                let apart = next.iter().any(|&n| slot(n) != slot(own));
                picture.blend(i64::from(x), i64::from(y), INK, if apart { 0.6 } else { 0.18 });
            }
        }
    }
    let mut picture = picture.halved();
    let covered = owners.iter().filter(|&&n| n != usize::MAX).count();
    let work = culled.result.funnel.occlusion;
    let words = format!(
        "{} of {} occluders drawn, they cover {:.1} % of the view",
        grouped(work.drawn),
        grouped(work.considered),
        covered as f64 / owners.len().max(1) as f64 * 100.0
    );
    caption(&mut picture, &words);
    picture
}

/// The view with what occlusion culling hid shining through as ghosts, in the colour of that stage.
///
/// `material_colors` are as for [`shaded`](fn@super::shaded). Words alone where the cull had no
/// occlusion culling. Cost: two frames at twice the size.
#[must_use]
pub fn hidden(
    scene: &Scene,
    view: &View,
    culled: &Culled<'_>,
    material_colors: &[[f32; 4]],
) -> Picture {
    if culled.buffer().is_none() {
        return off(view);
    }
    let (mut picture, _) = pale(scene, view, material_colors, 0.30);
    let ghosts = ghosts(scene, culled.result);
    let options = RenderOptions { scale: 2, ..RenderOptions::default() };
    let frame = render(scene, view, Selection::Visible(&ghosts), &options);
    let lit = shaded(scene, &frame, view, &[[0.6; 4]; 1]);
    let color = reason_color(Some(Stage::Occlusion));
    let (width, height) = (frame.width as usize, frame.height as usize);
    for (at, id) in frame.ids.iter().enumerate() {
        if *id == PixelId::NONE {
            continue;
        }
        let [x, y] = [at % width, at / width];
        let light = lit.rgb[at * 3..at * 3 + 3].iter().map(|&v| f64::from(v)).sum::<f64>() / 765.0;
        let tint = mix(mix(color, INK, 0.45), mix(color, PAPER, 0.35), light);
        picture.blend(x as i64, y as i64, tint, 0.5);
        let other = |x: usize, y: usize| {
            x < width && y < height && frame.ids[y * width + x].slot != id.slot
        };
        if other(x + 1, y)
            || other(x, y + 1)
            || x > 0 && other(x - 1, y)
            || y > 0 && other(x, y - 1)
        {
            picture.blend(x as i64, y as i64, mix(color, INK, 0.3), 0.75);
        }
    }
    let mut picture = picture.halved();
    let [entered, dropped] = culled.counts();
    let triangles = grouped(culled.result.funnel.dropped(Stage::Occlusion).triangles);
    let words = match dropped {
        0 => format!(
            "none of {} instances is hidden whole, {triangles} triangles are",
            grouped(entered)
        ),
        n => format!(
            "{} of {} instances hidden behind others, {triangles} triangles with parts of the rest",
            grouped(n),
            grouped(entered)
        ),
    };
    caption(&mut picture, &words);
    picture
}

/// The triangles that were dropped as hidden, with their instances or their clusters.
fn ghosts(scene: &Scene, result: &Visible) -> Visible {
    let mut ghosts = Visible::default();
    let mut parts = result.dropped.chunk_by(|a, b| a.slot == b.slot).peekable();
    for (slot, reason) in (0..).zip(&result.reasons) {
        let first = ghosts.triangles.len() as u32;
        let mut level = 0;
        if let Some(ranges) = parts.next_if(|ranges| ranges[0].slot == slot) {
            level = ranges[0].level;
            for d in ranges.iter().filter(|d| d.stage == Stage::Occlusion) {
                ghosts.triangles.extend(d.first_triangle..d.first_triangle + d.triangle_count);
            }
        } else if reason.is_some_and(|r| r.stage == Stage::Occlusion) {
            ghosts.triangles.extend(0..scene.mesh(slot).triangle_count());
        }
        let count = ghosts.triangles.len() as u32 - first;
        if count > 0 {
            ghosts.triangle_ranges.push(TriangleRange { slot, level, first, count });
        }
    }
    ghosts
}

/// The view at twice its size, so pale; and its frame.
fn pale(scene: &Scene, view: &View, colors: &[[f32; 4]], by: f64) -> (Picture, Frame) {
    let options = RenderOptions { scale: 2, ..RenderOptions::default() };
    let frame = render(scene, view, Selection::All, &options);
    let mut picture = shaded(scene, &frame, view, colors);
    for v in &mut picture.rgb {
        *v = (f64::from(*v) * (1.0 - by) + 250.0 * by).round() as u8;
    }
    (picture, frame)
}

#[cfg(test)]
mod tests {
    use cullet::cull::occlusion::Occlusion;
    use cullet::{Culler, Output};
    use cullet_scenes::paths::{self, Overrides, PathSpec};

    use super::*;

    fn views(scene: &str) -> (Scene, Vec<View>) {
        let model = cullet_scenes::build(scene).unwrap();
        let size = [160, 90];
        let cameras =
            paths::cameras(&model, &PathSpec::Walk, 3, size, &Overrides::default()).unwrap();
        let view = |c| View::new(c, Overrides::default().depth, size).unwrap();
        let views = cameras.iter().map(view).collect();
        (model.scene, views)
    }

    /// Culls a view, and does something with that.
    fn with<T>(
        scene: &Scene,
        view: &View,
        occlusion: Option<Occlusion>,
        what: impl FnOnce(&Culled<'_>) -> T,
    ) -> T {
        let culler = Culler::default()
            .with_occlusion(occlusion)
            .with_output(Output::Triangles)
            .with_reasons(true)
            .with_dropped(true);
        let (mut state, mut result) = (ViewState::default(), Visible::default());
        culler.cull_one(scene, view, &mut state, &mut result);
        what(&Culled { state: &state, result: &result })
    }

    #[test]
    fn the_buffer_never_claims_more_than_is_there() {
        let (scene, views) = views("city:cells=6,objects=100");
        for view in &views {
            let picture = with(&scene, view, Some(Occlusion::default()), |culled| {
                occlusion_buffer(&scene, view, culled, [640, 0])
            });
            let count =
                |color: [u8; 3]| picture.rgb.chunks_exact(3).filter(|c| **c == color).count();
            assert_eq!(count(Finding::Wrong.color()), 0);
            assert!(count(Finding::Alike.color()) > 1000, "next to nothing is proved");
        }
    }

    #[test]
    fn covered_pixels_are_those_of_the_buffer() {
        let (scene, views) = views("city:cells=6,objects=100");
        with(
            &scene,
            &views[1],
            Some(Occlusion::default().with_width(80).with_budget(1e6)),
            |culled| {
                let buffer = culled.buffer().unwrap();
                let owners = owners(&scene, &views[1], culled, buffer);
                for (at, owner) in owners.iter().enumerate() {
                    let proved = buffer.nearness((at % 80) as u32, (at / 80) as u32) > 0.0;
                    // Neighbours drawn one after the other may cover a pixel by the nearer of both
                    // alone.
                    assert_eq!(proved, *owner != usize::MAX, "pixel {at}");
                }
            },
        );
    }

    #[test]
    fn ghosts_are_what_the_stage_took() {
        let (scene, views) = views("city:cells=6,objects=100");
        for view in &views {
            with(&scene, view, Some(Occlusion::default()), |culled| {
                let ghosts = ghosts(&scene, culled.result);
                let taken = culled.result.funnel.dropped(Stage::Occlusion).triangles;
                assert_eq!(ghosts.triangles.len() as u64, taken);
                assert!(ghosts.triangle_ranges.is_sorted_by_key(|range| range.slot));
            });
        }
    }

    #[test]
    fn without_occlusion_culling_there_are_words() {
        let (scene, views) = views("solids");
        let picture = with(&scene, &views[0], None, |c| hidden(&scene, &views[0], c, &[]));
        assert_eq!((picture.width, picture.height), (480, 120));
    }
}
