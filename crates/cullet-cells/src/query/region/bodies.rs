//! Bodies that hide: which of a scene are drawn for a box of eyes, made smaller by the extent of
//! its cells.

use alloc::vec::Vec;

use cullet::bounds::{Aabb, Boxes};
use cullet::cull::frustum::batch::{Planes, mask_boxes};
use cullet::cull::occlusion::{Convex, OcclusionBuffer, Shape};
use cullet::{Scene, Simd, Transform};

use super::cells::Cell;
use super::shrunk::{is_apart, is_closed, shrunk};
use crate::bits;

/// Bodies of fewer pixels of a square, seen from the middle of the box, hide next to nothing.
const LEAST_PIXELS: f64 = 16.0;

/// A body as it stands, made smaller.
#[derive(Clone, Copy, Debug)]
struct Body {
    slot: u32,
    shape: u32,
    /// Relative to the scene's origin, as are the boxes.
    shrunk: Transform,
    bounds: Aabb,
    /// Before it was made smaller.
    whole: Aabb,
}

/// A body that may be chosen.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    /// Its largest side's area over the square of its distance.
    score: f64,
    slot: u32,
    shape: u32,
}

/// Bodies of a query, and the order in which those of a cell are drawn.
#[derive(Clone, Debug, Default)]
pub(super) struct Bodies {
    candidates: Vec<Candidate>,
    all: Vec<Body>,
    /// Distance from the middle of the cell and index in `all` of each body, the nearest first.
    order: Vec<(f64, u32)>,
    boxes: Boxes,
}

/// Limits within which bodies are chosen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Pixels across a square.
    pub(super) width: u32,
    pub(super) most: u32,
    /// Eyes see what is farther than this.
    pub(super) near: f64,
}

impl Bodies {
    /// Chooses the bodies among the `allowed` slots that are largest as seen from a box of eyes,
    /// and makes them smaller by half the sides of its cells. How many there are.
    pub(super) fn choose(
        &mut self,
        scene: &Scene,
        allowed: &[u64],
        eyes: &Cell,
        by: [f64; 3],
        limits: &Limits,
    ) -> usize {
        self.candidates.clear();
        let pixels = f64::from(limits.width) * 0.5;
        let least = LEAST_PIXELS / (pixels * pixels);
        for slot in bits::in_words(allowed).map(|slot| slot as u32) {
            let bounds = scene.boxes().get(slot as usize);
            if score(&bounds, eyes) < least || !may_hide(scene, slot) {
                continue;
            }
            let prepared = scene.prepared_of(slot);
            let sealed = prepared.occluder().map_or(&[][..], |o| o.sealed());
            let at = scene.transform(slot);
            let is_in = |b: &Aabb| {
                let b = at.transform_box(b, scene.origin());
                eyes.distance(&b) <= limits.near
            };
            if sealed.iter().any(is_in) {
                continue;
            }
            for (shape, convex) in bodies_of(prepared.shapes()) {
                let bounds = at.transform_box(&convex.bounds(), scene.origin());
                let score = score(&bounds, eyes);
                if score >= least {
                    self.candidates.push(Candidate { score, slot, shape });
                }
            }
        }
        let most = limits.most as usize;
        if self.candidates.len() > most {
            // Of one score those of the first slots.
            let place = |c: &Candidate| (c.slot, c.shape);
            self.candidates.select_nth_unstable_by(most, |a, b| {
                b.score.total_cmp(&a.score).then_with(|| place(a).cmp(&place(b)))
            });
            self.candidates.truncate(most);
            self.candidates.sort_unstable_by_key(place);
        }
        self.all.clear();
        for c in &self.candidates {
            let Some(convex) = body_of(scene, c.slot, c.shape) else { continue };
            let at = relative(scene, c.slot);
            if let Some(shrunk) = shrunk(convex, by, &at) {
                let bounds = convex.bounds();
                self.all.push(Body {
                    slot: c.slot,
                    shape: c.shape,
                    shrunk,
                    bounds: shrunk.transform_box(&bounds, [0.0; 3]),
                    whole: at.transform_box(&bounds, [0.0; 3]),
                });
            }
        }
        self.all.len()
    }

    /// Puts those bodies in order that no eye of a cell is in or comes as near to as `near`: from
    /// within a body one looks out through it, and so one does where the near plane of a view cuts
    /// it open. How many there are.
    pub(super) fn order(&mut self, scene: &Scene, cell: &Cell, near: f64) -> usize {
        self.order.clear();
        let point = Cell { half: [0.0; 3], ..*cell };
        for (number, body) in (0..).zip(&self.all) {
            let is_apart = cell.distance(&body.whole) > near * (1.0 + 1e-6)
                || body_of(scene, body.slot, body.shape).is_some_and(|convex| {
                    is_apart(convex, &relative(scene, body.slot), cell.center, cell.half, near)
                });
            if is_apart {
                self.order.push((point.distance(&body.bounds), number));
            }
        }
        self.order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        self.boxes.resize(self.order.len());
        for (i, (_, number)) in self.order.iter().enumerate() {
            self.boxes.set(i, &self.all[*number as usize].bounds);
        }
        self.order.len()
    }

    /// Draws the bodies of the cell that are not outside of some planes, the nearest first, but for
    /// those that are hidden by then; how many those drawn are.
    pub(super) fn draw(
        &self,
        simd: Simd,
        scene: &Scene,
        planes: &Planes,
        buffer: &mut OcclusionBuffer,
    ) -> u64 {
        let mut drawn = 0;
        for word in 0..self.order.len().div_ceil(64) {
            let (mut inside, mut open, mut hidden) = ([0], [0], [0]);
            mask_boxes(simd, planes, &self.boxes, word, &mut inside);
            buffer.test_boxes(simd, &self.boxes, word, &inside, &mut open, &mut hidden);
            for bit in bits::ones(open[0]) {
                let body = &self.all[self.order[word * 64 + bit].1 as usize];
                if let Some(convex) = body_of(scene, body.slot, body.shape) {
                    convex.draw(simd, buffer, &body.shrunk);
                    drawn += 1;
                }
            }
        }
        drawn
    }
}

/// The area of the largest side of a box, over the square of its distance from a box of eyes: about
/// the solid angle.
fn score(b: &Aabb, eyes: &Cell) -> f64 {
    let [x, y, z] = b.half_extent();
    let area = 4.0 * (x * y).max(y * z).max(z * x);
    let distance = eyes.distance(b);
    area / (distance * distance).max(1e-12)
}

/// Whether an instance hides what is behind it, as its mesh says.
fn may_hide(scene: &Scene, slot: u32) -> bool {
    let flags = scene.flags(slot);
    !flags.no_occlusion && !flags.transparent && scene.is_rigid(slot)
}

/// The closed bodies of an occluder.
fn bodies_of(shapes: &[Shape]) -> impl Iterator<Item = (u32, &Convex)> {
    (0..).zip(shapes).filter_map(|(number, shape)| match shape {
        Shape::Convex(convex) if is_closed(convex) => Some((number, convex)),
        _ => None,
    })
}

fn body_of(scene: &Scene, slot: u32, shape: u32) -> Option<&Convex> {
    match scene.prepared_of(slot).shapes().get(shape as usize)? {
        Shape::Convex(convex) => Some(convex),
        Shape::Patch(_) => None,
    }
}

/// The transform of an instance, relative to the scene's origin.
fn relative(scene: &Scene, slot: u32) -> Transform {
    let mut at = *scene.transform(slot);
    for (t, origin) in at.translation.iter_mut().zip(scene.origin()) {
        *t -= origin;
    }
    at
}
