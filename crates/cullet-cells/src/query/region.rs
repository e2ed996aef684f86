//! Visible set of a region: what may be seen from anywhere in a box of eyes.
//!
//! The box is cut into cells. From the middle of each cell the scene is looked at in all
//! directions, six squares of a cube, and into an occlusion buffer for each bodies are drawn that
//! have been made smaller: every face moved inward by as far as the cell reaches along its normal.
//! What is hidden from the middle behind such bodies is hidden from every eye of the cell behind
//! the bodies themselves. For let c be the middle, c′ an eye, q a point, and r where the segment
//! from c to q meets a shrunk body, a share t along it. The point at t of the segment from c′ to q
//! is r + (1 − t)(c′ − c): it lies within the cell's extent of r, hence in the body. So the union
//! over the cells is conservative, and bodies that hide something only together, none of them
//! alone, are counted as the buffer counts them.
//!
//! Peter Wonka, Michael Wimmer & Dieter Schmalstieg, *Visibility Preprocessing with Occluder Fusion
//! for Urban Walkthroughs*, 2000, shrink occluders by the radius of a ball of eyes. A box of eyes
//! takes less: a wall that stands along an axis moves by half a side of the cell and not by half
//! its diagonal, and eyes that all are at one height take nothing off a roof.

mod bodies;
mod cells;
mod open;
mod shrunk;

pub use cells::EyeBox;

use alloc::vec::Vec;

use cullet::cull::frustum::batch::{Planes, mask_boxes};
use cullet::cull::occlusion::OcclusionBuffer;
use cullet::{
    Camera, Depth, Handle, Mesh, Projection, Reason, Scene, Simd, Stage, View,
    funnel::{Counts, Funnel, FunnelRow, Unit},
};
use thiserror::Error;

use crate::bits;
use bodies::{Bodies, Limits};
use cells::{Carried, Cell, Cells};
use open::OpenTest;

/// The least distance at which anything is looked at, in world units.
const LEAST_NEAR: f64 = 1e-6;

/// How much wider than a right angle the squares are, so that nothing falls between two of them.
const OVERLAP: f64 = 1e-4;

/// Settings of queries for what is seen from a box of eyes.
///
/// Only closed convex bodies hide anything here: boxes, solids that are convex, and the convex
/// bodies of baked occluders. Polygons and surfaces have no thickness that could be taken off, so
/// walls that are sheets hide nothing. Neither do instances that the [`Culler`](cullet::Culler)
/// takes no occluder of.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct RegionCuller {
    /// SIMD level; the answer is the same at every level. Default: the best of the machine.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub simd: Simd,
    /// Layers that the eyes see, of what is seen and of what hides. A [view](Self::cull_view)
    /// brings its own. Default all.
    pub layers: u32,
    /// Longest side of a cell, in world units, above 0. Bodies lose half of it on every side, so
    /// that it must be smaller than what is to hide is thick. A smaller one drops more, and costs
    /// with its third power. Default 2: about a tenth of a house.
    pub cell_world: f64,
    /// No more cells than this, at least 1; a larger box has longer cells. Cost is in proportion.
    /// Default 64.
    pub most_cells: u32,
    /// Pixels across each of the six squares, 8 to 4096. More drop more of what is far and small,
    /// at a cost that rises more slowly than the pixels. Default 512.
    pub width: u32,
    /// No more bodies than this are drawn for a query, those that look largest from the box.
    /// Default 2048.
    pub most_bodies: u32,
    /// The farthest that a point of a view's near rectangle may be from its eye, in world units, at
    /// least 0. A body that comes nearer to a cell hides nothing from it, for a view's near plane
    /// may cut it open. A [view](Self::cull_view) that needs more has it. Default 0.25, for near
    /// planes up to 0.1 and fields of view up to 120 degrees across.
    pub near_world: f64,
    /// Whether [`RegionVisible::reasons`] is filled. Default no.
    pub reasons: bool,
}

impl Default for RegionCuller {
    fn default() -> Self {
        Self {
            simd: Simd::best(),
            layers: u32::MAX,
            cell_world: 2.0,
            most_cells: 64,
            width: 512,
            most_bodies: 2048,
            near_world: 0.25,
            reasons: false,
        }
    }
}

/// Why a region, or a motion, is not looked from.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RegionError {
    /// A setting out of its range.
    #[error("{what} is {value}; it must be {must}")]
    Setting {
        /// Which.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The range that it must lie in.
        must: &'static str,
    },
    /// A view whose lines of sight are parallel: it has no eye that could stand elsewhere.
    #[error("an orthographic view has no eye that a box could hold; use a perspective view")]
    Orthographic,
}

/// Memory of region queries: kept, they allocate nothing once it has grown, but for bodies that the
/// near plane of a square cuts. It holds no answer.
#[derive(Clone, Debug, Default)]
pub struct RegionState {
    buffer: Option<OcclusionBuffer>,
    bodies: Bodies,
    test: OpenTest,
    /// One bit a slot each: in a layer that is seen; still sought; found to be visible; in a
    /// frustum.
    layers: Vec<u64>,
    sought: Vec<u64>,
    found: Vec<u64>,
    framed: Vec<u64>,
    wanted: Vec<u64>,
    mask: Vec<u64>,
    work: RegionWork,
}

/// Work of a query.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RegionWork {
    /// Cells that were looked from: fewer than there are where everything was found by then.
    pub cells: u64,
    /// Squares that were drawn and tested, at most six a cell.
    pub squares: u64,
    /// Bodies that were chosen and made smaller.
    pub bodies: u64,
    /// Times that one was drawn.
    pub drawn: u64,
}

/// Answer of a region query: the slots of a scene that may be seen.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RegionVisible {
    /// One bit a slot, as of the scene's order when the query was made.
    pub words: Vec<u64>,
    /// Why the other slots were dropped, where [wanted](RegionCuller::reasons): one a slot, `None`
    /// for those that may be seen and for empty slots. A box without eyes sees nothing by its
    /// frustum.
    pub reasons: Vec<Option<Reason>>,
    /// Counts in and out of each stage: layers, the frusta where a view was given, occlusion.
    pub funnel: Funnel,
    /// Work that it took.
    pub work: RegionWork,
}

impl RegionVisible {
    /// Whether the instance of a slot may be seen; false for slots that there were not.
    #[must_use]
    pub fn has(&self, slot: u32) -> bool {
        self.words.get(slot as usize / 64).is_some_and(|w| w >> (slot % 64) & 1 == 1)
    }

    /// The slots, ascending.
    pub fn slots(&self) -> impl Iterator<Item = u32> + '_ {
        bits::in_words(&self.words).map(|slot| slot as u32)
    }

    /// The instances, ascending by slot; `scene` must be the one of the query, in the same order.
    pub fn handles<'a>(&'a self, scene: &'a Scene) -> impl Iterator<Item = Handle> + 'a {
        self.slots().filter_map(|slot| scene.handle(slot))
    }
}

impl RegionCuller {
    /// Finds what may be seen from any eye in a box, in any direction, by perspective views that
    /// draw the fronts of what they draw.
    ///
    /// No instance is dropped of which such an eye sees anything. Kept as well are those flagged
    /// always visible, without bounds or with a mesh that can deform; what comes within
    /// [`near_world`](Self::near_world) of the box; and everything in the layers where the box is
    /// not finite or beyond 1e18 units. An empty box sees nothing.
    ///
    /// Cost: a look at every slot, and for each cell six buffers to draw and to test.
    ///
    /// # Errors
    /// [`RegionError::Setting`] for a setting out of its range.
    pub fn cull(
        &self,
        scene: &Scene,
        eyes: &EyeBox,
        state: &mut RegionState,
        visible: &mut RegionVisible,
    ) -> Result<(), RegionError> {
        self.run(scene, eyes, None, state, visible)
    }

    /// Finds what may be seen from any eye in a box, like [`cull`](Self::cull), for eyes that all
    /// look as `view` does: with its orientation, projection and layers, carried to each point of
    /// the box. Drops what is outside of all their frusta too.
    ///
    /// # Errors
    /// [`RegionError::Setting`] for a setting out of its range, and [`RegionError::Orthographic`]
    /// for a view whose lines of sight are parallel.
    pub fn cull_view(
        &self,
        scene: &Scene,
        eyes: &EyeBox,
        view: &View,
        state: &mut RegionState,
        visible: &mut RegionVisible,
    ) -> Result<(), RegionError> {
        self.run(scene, eyes, Some(view), state, visible)
    }

    fn run(
        &self,
        scene: &Scene,
        eyes: &EyeBox,
        view: Option<&View>,
        state: &mut RegionState,
        visible: &mut RegionVisible,
    ) -> Result<(), RegionError> {
        let outlook = Outlook::new(self, view)?;
        state.begin(scene, outlook.layers);
        self.find(scene, eyes, &outlook, state);
        visible.words.clone_from(&state.found);
        visible.work = state.work;
        state.count(scene, view.is_some() || eyes.is_empty(), &mut visible.funnel);
        visible.reasons.clear();
        if self.reasons {
            visible.reasons.extend((0..scene.slot_count()).map(|s| state.reason(scene, s)));
        }
        Ok(())
    }

    /// Adds to what is found what may be seen of what is sought.
    pub(super) fn find(
        &self,
        scene: &Scene,
        eyes: &EyeBox,
        outlook: &Outlook,
        state: &mut RegionState,
    ) {
        if eyes.is_empty() {
            return;
        }
        let most = self.most_cells;
        let Some(cells) = Cells::new(eyes, scene.origin(), self.cell_world, most) else {
            return state.find_all();
        };
        let hierarchy = scene.hierarchy();
        state.keep(scene);
        // What is nearer to a cell's middle than the squares begin is in none of them.
        let (whole, near) = (cells.whole(), outlook.near);
        let reach = whole.center.iter().map(|v| v.abs()).fold(0.0, f64::max);
        let margin = near * 1.001 + reach * 1e-12;
        let RegionState { sought, found, framed, wanted, mask, .. } = state;
        wanted.clone_from(sought);
        if let Some(carried) = &outlook.carried {
            mask_boxes(self.simd, &Planes::new(&carried.to(&whole)), hierarchy.boxes(), 0, mask);
            both(wanted, mask);
        }
        mask_boxes(self.simd, &Planes::new(&whole.grown(margin)), hierarchy.boxes(), 0, mask);
        for (i, word) in found.iter_mut().enumerate() {
            *word |= wanted[i] & mask[i];
            framed[i] |= *word;
        }
        let limits = Limits { width: self.width, most: self.most_bodies, near };
        let bodies = match outlook.draws_fronts && near.is_finite() {
            true => state.bodies.choose(scene, &state.layers, &whole, cells.half(), &limits),
            false => 0,
        };
        state.work.bodies += bodies as u64;
        for cell in cells.iter() {
            let RegionState { sought, found, framed, wanted, mask, .. } = state;
            wanted.clear();
            wanted.extend(sought.iter().zip(&*found).map(|(sought, found)| sought & !found));
            if wanted.iter().all(|w| *w == 0) {
                break;
            }
            if let Some(carried) = &outlook.carried {
                let planes = Planes::new(&carried.to(&cell));
                mask_boxes(self.simd, &planes, hierarchy.boxes(), 0, mask);
                both(wanted, mask);
            }
            framed.iter_mut().zip(&*wanted).for_each(|(framed, wanted)| *framed |= wanted);
            state.work.cells += 1;
            if bodies == 0 || state.bodies.order(scene, &cell, near) == 0 {
                state.find_wanted();
            } else {
                self.look_around(scene, &cell, outlook, state);
            }
        }
    }

    /// Looks from the middle of a cell in all directions.
    fn look_around(&self, scene: &Scene, cell: &Cell, outlook: &Outlook, state: &mut RegionState) {
        let size = [self.width; 2];
        if state.buffer.as_ref().is_none_or(|b| b.size() != size) {
            // Never refused: the size is within the limits.
            state.buffer = OcclusionBuffer::new(size).ok();
        }
        let Some(mut buffer) = state.buffer.take() else { return state.find_wanted() };
        let hierarchy = scene.hierarchy();
        for direction in DIRECTIONS {
            let Some(view) = square(cell.center, direction, outlook.near, size) else {
                state.find_wanted();
                break;
            };
            // By the sides of the square: what is beside it may cross the plane in which it begins,
            // and would be open.
            let planes = Planes::new(&view.frustum());
            let RegionState { test, found, wanted, mask, bodies, work, .. } = &mut *state;
            mask_boxes(self.simd, &planes, hierarchy.boxes(), 0, mask);
            both(mask, wanted);
            if mask.iter().all(|w| *w == 0) {
                continue;
            }
            buffer.begin(&view, [0.0; 3]);
            work.squares += 1;
            work.drawn += bodies.draw(self.simd, scene, &planes, &mut buffer);
            test.find(self.simd, &buffer, hierarchy, mask, found);
            wanted.iter_mut().zip(&*found).for_each(|(wanted, found)| *wanted &= !found);
        }
        state.buffer = Some(buffer);
    }

    fn check(&self) -> Result<(), RegionError> {
        let range = |what, value: f64, ok: bool, must| match ok {
            true => Ok(()),
            false => Err(RegionError::Setting { what, value, must }),
        };
        let (cell, near) = (self.cell_world, self.near_world);
        range("cell_world", cell, cell > 0.0 && cell.is_finite(), "above 0 and finite")?;
        range("most_cells", self.most_cells.into(), self.most_cells > 0, "at least 1")?;
        let width = (8..=4096).contains(&self.width);
        range("width", self.width.into(), width, "from 8 to 4096 pixels")?;
        range("near_world", near, (0.0..1e18).contains(&near), "from 0 to 1e18")
    }
}

/// How the eyes look.
#[derive(Clone, Debug)]
pub(super) struct Outlook {
    /// The frustum that they all have; none where they look in all directions.
    carried: Option<Carried>,
    pub(super) layers: u32,
    /// Whether they draw the fronts of bodies.
    draws_fronts: bool,
    /// They see what is farther than this; infinite where that is not known.
    near: f64,
}

impl Outlook {
    /// Makes the outlook of all eyes that look as `view` does, or in all directions where it is
    /// `None`. Returns the errors of [`RegionCuller::cull_view`].
    pub(super) fn new(culler: &RegionCuller, view: Option<&View>) -> Result<Self, RegionError> {
        culler.check()?;
        let near = culler.near_world.max(LEAST_NEAR);
        let Some(view) = view else {
            return Ok(Self { carried: None, layers: culler.layers, draws_fronts: true, near });
        };
        let carried = Carried::new(view).ok_or(RegionError::Orthographic)?;
        let near = near.max(carried.near);
        let draws_fronts = view.draws_fronts();
        Ok(Self { carried: Some(carried), layers: view.layers, draws_fronts, near })
    }
}

impl RegionState {
    /// Nothing is found yet, and everything in some layers is sought.
    pub(super) fn begin(&mut self, scene: &Scene, layers: u32) {
        let words = scene.hierarchy().present().len();
        for mask in [&mut self.found, &mut self.framed, &mut self.wanted, &mut self.mask] {
            mask.clear();
            mask.resize(words, 0);
        }
        self.layers.clear();
        self.layers.extend_from_slice(scene.hierarchy().present());
        for (i, word) in self.layers.iter_mut().enumerate() {
            for bit in bits::ones(*word) {
                if scene.layers((i * 64 + bit) as u32) & layers == 0 {
                    *word &= !(1 << bit);
                }
            }
        }
        self.sought.clone_from(&self.layers);
        self.work = RegionWork::default();
    }

    /// Work since it began.
    pub(super) fn work(&self) -> RegionWork {
        self.work
    }

    /// Takes what was found since the last call: it is sought no more. Calls `each` with its slots,
    /// ascending.
    pub(super) fn take_found(&mut self, mut each: impl FnMut(u32)) {
        bits::in_words(&self.found).for_each(|slot| each(slot as u32));
        for (sought, found) in self.sought.iter_mut().zip(&mut self.found) {
            *sought &= !core::mem::take(found);
        }
    }

    /// Finds what is sought and kept whatever hides it.
    fn keep(&mut self, scene: &Scene) {
        let kept = self.found.iter_mut().zip(&self.sought).zip(scene.exempt());
        kept.for_each(|((found, sought), exempt)| *found |= sought & exempt);
        if scene.meshes().iter().any(Mesh::is_deformable) {
            for slot in bits::in_words(&self.sought) {
                if scene.mesh(slot as u32).is_deformable() {
                    bits::set(&mut self.found, slot, true);
                }
            }
        }
    }

    fn find_all(&mut self) {
        self.found.clone_from(&self.sought);
        self.framed.clone_from(&self.sought);
    }

    fn find_wanted(&mut self) {
        self.found.iter_mut().zip(&self.wanted).for_each(|(found, wanted)| *found |= wanted);
    }

    /// Counts in and out of each stage.
    fn count(&self, scene: &Scene, has_frustum: bool, funnel: &mut Funnel) {
        *funnel = Funnel { rows: core::mem::take(&mut funnel.rows), ..Funnel::default() };
        funnel.rows.clear();
        let counts = |mask| counts_of(scene, bits::in_words(mask).map(|slot| slot as u32));
        let mut entered = counts_of(scene, scene.slots());
        let mut row = |stage, left: Counts| {
            let nanoseconds = FunnelRow::NO_TIME;
            let unit = Unit::Instances;
            funnel.rows.push(FunnelRow { stage, unit, entered, left, nanoseconds });
            entered = left;
        };
        row(Stage::Layer, counts(&self.layers));
        if has_frustum {
            row(Stage::Frustum, counts(&self.framed));
        }
        row(Stage::Occlusion, counts(&self.found));
    }

    fn reason(&self, scene: &Scene, slot: u32) -> Option<Reason> {
        let is_in = |mask: &[u64]| bits::get(mask, slot as usize);
        let (stage, detail) = match () {
            () if scene.is_removed(slot) || is_in(&self.found) => return None,
            () if !is_in(&self.layers) => (Stage::Layer, 0),
            // Each eye may have its own plane.
            () if !is_in(&self.framed) => (Stage::Frustum, Reason::MIXED),
            () => (Stage::Occlusion, 0),
        };
        Some(Reason { stage, detail })
    }
}

/// Returns how many clusters and triangles the instances of `slots` have.
fn counts_of(scene: &Scene, slots: impl Iterator<Item = u32>) -> Counts {
    slots.fold(Counts::default(), |sum, slot| {
        let mesh = scene.mesh(slot);
        Counts {
            instances: sum.instances + 1,
            clusters: sum.clusters + mesh.clusters().len() as u64,
            triangles: sum.triangles + u64::from(mesh.triangle_count()),
        }
    })
}

/// Leaves what is in both masks.
fn both(mask: &mut [u64], other: &[u64]) {
    mask.iter_mut().zip(other).for_each(|(a, b)| *a &= b);
}

/// The six directions, each with one that is up.
const DIRECTIONS: [[[f64; 3]; 2]; 6] = [
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]],
    [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0]],
    [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    [[0.0, -1.0, 0.0], [0.0, 0.0, 1.0]],
];

/// A side of the cube around an eye, which begins at `near` and has no end; `None` where f64 has no
/// room for it.
fn square(
    eye: [f64; 3],
    [direction, up]: [[f64; 3]; 2],
    near: f64,
    size: [u32; 2],
) -> Option<View> {
    let edge = near * (1.0 + OVERLAP);
    let projection = Projection::OffCentre {
        left: -edge,
        right: edge,
        bottom: -edge,
        top: edge,
        near,
        far: f64::INFINITY,
    };
    View::new(&Camera { eye, direction, up, projection }, Depth::Reversed, size).ok()
}
