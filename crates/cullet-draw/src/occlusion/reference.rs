//! The sampled judge: which boxes, or instances, own a sample of a finer image.
//!
//! A box called visible is visible. One called hidden may still show between the samples: take more
//! of them, or use [`Prover`](crate::Prover).

use cullet::bounds::Aabb;
use cullet::{Scene, Transform, View, Visible};

use crate::bounds::{Extent, ScreenBounds, screen_bounds, triangle_rect};
use crate::frame::Selection;
use crate::geometry::{Clip, Lens, ObjectLens, Surface};
use crate::parallel;
use crate::prepare::Stage;
use crate::render::{Target, in_pool, tiles_in, tiles_of};
use crate::sample::{Jitter, Rect, Samples};
use crate::tile::TILE;
use crate::verify::{MAX_SIDE, VerifyOptions, lost_instances};

/// Tiles drawn at a time: with 64 × 64 samples of 16 bytes, 128 MiB.
const BAND_TILES: usize = 2048;

/// Visibility of a box, by samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Sampled {
    /// It is outside of the view volume.
    Outside = 0,
    /// A sample of it is not behind what hides.
    Visible = 1,
    /// Each of its samples is behind what hides, or it has none.
    Hidden = 2,
    /// A corner is nearer than the near plane: to be taken for visible.
    CrossesNear = 3,
}

/// How boxes are sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleOptions {
    /// N: an image N times wider and higher than the viewport; 0 is 1. A finer image than 65 536
    /// samples wide or high is not drawn: N is lowered.
    pub samples: u32,
    /// Where in its pixel of the finer image a sample lies, from the top left corner: 0.5, 0.5 is
    /// the centre. Clamped to 0..1; NaN is the centre.
    pub jitter: [f64; 2],
    /// A seed for a place of its own in every pixel, instead of `jitter`.
    pub seed: Option<u64>,
    /// Boxes are first moved away from the eye by this part of their distance (of the depth range,
    /// where lines of sight are parallel), so that one that only touches what hides it counts as
    /// hidden. 0, the default, counts it as visible; the reference files of `OCCSCN01` have 1e-6.
    pub tolerance: f64,
    /// How many threads; 0 is those of the pool that the call runs in. The answer is the same.
    pub threads: usize,
}

impl Default for SampleOptions {
    fn default() -> Self {
        Self { samples: 1, jitter: [0.5; 2], seed: None, tolerance: 0.0, threads: 0 }
    }
}

/// Holds boxes, relative to the scene's origin, against samples of what the scene draws opaquely;
/// instances with [`no_occlusion`](cullet::InstanceFlags::no_occlusion) and those in none of the
/// view's layers hide nothing.
///
/// A box is visible if a sample of one of its six faces within the depth range is not farther than
/// what is drawn there. A box that is empty, NaN or infinite is [`Sampled::CrossesNear`], that is,
/// kept.
///
/// Cost: one frame of N² times the pixels, then some microseconds a box in the picture. The city of
/// 120,000 triangles and 100,000 boxes takes a second or so at N = 4 of 1280 × 720.
#[must_use]
pub fn sampled_boxes(
    scene: &Scene,
    view: &View,
    boxes: &[Aabb],
    options: &SampleOptions,
) -> Vec<Sampled> {
    in_pool(options.threads, || boxes_in_pool(scene, view, boxes, options))
}

/// Instances of which a sample is seen at N × N samples a pixel, with the first such pixel of the
/// finer image, by row and then column; ascending by slot. Blended and masked ones are seen where
/// they are not behind what is opaque.
#[must_use]
pub fn sampled_instances(
    scene: &Scene,
    view: &View,
    options: &VerifyOptions,
) -> Vec<(u32, [u32; 2])> {
    in_pool(options.threads, || {
        let samples = finer(view, options.samples, Jitter::Hashed(options.seed));
        lost_instances(&Stage::new(scene), view, &Visible::default(), samples)
    })
}

fn finer(view: &View, n: u32, jitter: Jitter) -> Samples {
    let [width, height] = view.viewport();
    let n = n.clamp(1, (MAX_SIDE / width.max(height)).max(1));
    Samples::new([width * n, height * n], jitter)
}

/// A box that is in the picture and still has to be looked for.
struct Candidate<'a> {
    index: usize,
    bounds: &'a Aabb,
    place: ScreenBounds,
}

fn boxes_in_pool(
    scene: &Scene,
    view: &View,
    boxes: &[Aabb],
    options: &SampleOptions,
) -> Vec<Sampled> {
    let jitter = options.seed.map_or(Jitter::Fixed(options.jitter), Jitter::Hashed);
    let samples = finer(view, options.samples, jitter);
    let lens = Lens::new(view);
    let object = lens.object(&Transform::from_translation(scene.origin()));
    let push = push_away(view, &lens, options.tolerance);
    let seer = Seer { lens: &lens, object: &object, push, mirrored: view.is_mirrored() };
    let places: Vec<Result<ScreenBounds, Sampled>> =
        boxes.iter().map(|b| place(&lens, &object, b, &samples)).collect();
    let mut answers: Vec<Sampled> =
        places.iter().map(|p| p.as_ref().err().copied().unwrap_or(Sampled::Hidden)).collect();
    let mut open: Vec<Candidate> = (boxes.iter().zip(&places).enumerate())
        .filter_map(|(index, (bounds, place))| {
            place.as_ref().ok().map(|place| Candidate { index, bounds, place: *place })
        })
        .collect();

    let stage = Stage::new(scene);
    let mut items = stage.items(&lens, &samples, Selection::All);
    items.blended.clear();
    items.opaque.retain(|i| !scene.flags(i.slot).no_occlusion);
    let [wide, high] = tiles_of(&samples);
    let mut wanted = vec![false; (wide * high) as usize];
    let at = |[column, row]: [u32; 2]| (row * wide + column) as usize;
    for c in &open {
        tiles_in(&c.place.rect).for_each(|tile| wanted[at(tile)] = true);
    }
    let rows = ((BAND_TILES / wide as usize) as u32).max(1);
    for first in (0..high).step_by(rows as usize) {
        let last = (first + rows).min(high) - 1;
        let band = |tile: [u32; 2]| (first..=last).contains(&tile[1]) && wanted[at(tile)];
        let mut target = Target::new(samples.clone(), band, false);
        target.draw(&stage, &lens, Selection::All, &items.within(&|r| tiles_in(r).any(band)));
        let pixels = [first * TILE, (last * TILE + TILE - 1).min(samples.size[1] - 1)];
        let sees = |i: usize| seer.sees(&open[i], &target, &samples, pixels);
        let seen = parallel::map(open.len(), &sees);
        for (c, _) in open.iter().zip(&seen).filter(|(_, seen)| **seen) {
            answers[c.index] = Sampled::Visible;
        }
        open.retain(|c| answers[c.index] == Sampled::Hidden);
    }
    answers
}

/// Offset to the z of a corner that moves it away by `tolerance` of its distance: along its line of
/// sight a point is eye + (1 + t)(p − eye), and clip space is linear, so x, y and w grow by 1 + t
/// alike and z by t(z − z of the eye); divided by 1 + t again, all but z is what it was.
fn push_away(view: &View, lens: &Lens, tolerance: f64) -> f64 {
    let eye = view.eye();
    let t = if tolerance > 0.0 { tolerance } else { 0.0 };
    if eye[3] == 0.0 {
        return t;
    }
    -lens.clip([eye[0], eye[1], eye[2]])[2] * t / (1.0 + t)
}

/// Screen bounds of a box, or a result that needs no samples.
fn place(
    lens: &Lens,
    object: &ObjectLens,
    bounds: &Aabb,
    samples: &Samples,
) -> Result<ScreenBounds, Sampled> {
    if !bounds.is_finite() || bounds.is_empty() {
        return Err(Sampled::CrossesNear);
    }
    let clip = bounds.corners().map(|p| object.clip(p));
    let [low, high] = lens.range;
    let beyond =
        |outside: fn(&Clip, [f64; 2]) -> bool| clip.iter().all(|c| outside(c, [low, high]));
    if beyond(|[x, _, _, w], _| x > w)
        || beyond(|[x, _, _, w], _| -x > *w)
        || beyond(|[_, y, _, w], _| y > w)
        || beyond(|[_, y, _, w], _| -y > *w)
        || beyond(|[_, _, z, w], [low, _]| *z < low * w)
        || beyond(|[_, _, z, w], [_, high]| *z > high * w)
    {
        return Err(Sampled::Outside);
    }
    if clip.iter().any(|[_, _, z, w]| *w <= 0.0 || *z < low * w) {
        return Err(Sampled::CrossesNear);
    }
    // In the picture, but between its samples.
    let extent = Extent { low: bounds.min, high: bounds.max };
    screen_bounds(lens, object, &extent, samples).ok_or(Sampled::Hidden)
}

/// The six faces of a box as two triangles each, by bits of its corners: bit a is axis a.
const FACES: [[usize; 4]; 6] =
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// The corners of a box by bits: bit a chooses the upper side of axis a.
pub(super) fn corners(bounds: &Aabb) -> [[f32; 3]; 8] {
    let [low, high] = [bounds.min, bounds.max];
    std::array::from_fn(|i| std::array::from_fn(|a| if i >> a & 1 == 1 { high[a] } else { low[a] }))
}

/// The triangles of a box as triples of [`corners`], wound outward.
pub(super) fn box_triangles() -> impl Iterator<Item = [usize; 3]> {
    FACES.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
}

/// How boxes are looked at.
struct Seer<'a> {
    lens: &'a Lens,
    object: &'a ObjectLens,
    /// Added to the z of every corner.
    push: f64,
    /// Whether the projection turns windings round.
    mirrored: bool,
}

impl Seer<'_> {
    /// Whether a sample of the box in these rows is not farther than what is drawn.
    fn sees(&self, c: &Candidate, target: &Target, samples: &Samples, rows: [u32; 2]) -> bool {
        let Some(rect) = within(c.place.rect, rows) else { return false };
        if target.hides(&rect, c.place.nearest) {
            return false;
        }
        let clip: [Clip; 8] = corners(c.bounds).map(|p| {
            let [x, y, z, w] = self.object.clip(p);
            [x, y, z + self.push, w]
        });
        // Back faces are behind front faces, so only front faces are tested: all corners are in
        // front of the eye.
        box_triangles().any(|t| {
            let triangle = t.map(|i| clip[i]);
            let Some(rect) = triangle_rect(self.lens, &triangle, samples) else { return false };
            let Some(rect) = within(rect, rows) else { return false };
            let Some((surface, ccw)) = Surface::new(triangle) else { return false };
            ccw != self.mirrored && seen_in(&surface, &rect, self.lens, target, samples)
        })
    }
}

/// The part of a rectangle in these rows.
fn within(rect: Rect, rows: [u32; 2]) -> Option<Rect> {
    let y = [rect.y[0].max(rows[0]), rect.y[1].min(rows[1])];
    (y[0] <= y[1]).then_some(Rect { x: rect.x, y })
}

fn seen_in(
    surface: &Surface,
    rect: &Rect,
    lens: &Lens,
    target: &Target,
    samples: &Samples,
) -> bool {
    let [low, high] = lens.range;
    tiles_in(rect).any(|tile| {
        let columns = (rect.x[0].max(tile[0] * TILE), rect.x[1].min(tile[0] * TILE + TILE - 1));
        let rows = (rect.y[0].max(tile[1] * TILE), rect.y[1].min(tile[1] * TILE + TILE - 1));
        let part = Rect { x: [columns.0, columns.1], y: [rows.0, rows.1] };
        if target.hides(&part, surface.nearest()) {
            return false;
        }
        (rows.0..=rows.1).any(|row| {
            (columns.0..=columns.1).any(|column| {
                let [x, y] = samples.at(column, row);
                let e = surface.at(x, y);
                if !surface.covers(e) {
                    return false;
                }
                let depth = surface.depth(e);
                depth >= low && depth <= high && depth <= target.depth(column, row)
            })
        })
    })
}
