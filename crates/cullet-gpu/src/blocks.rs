//! The instances of a scene in blocks of 256, each with a grid of its own.

use cullet::Scene;
use cullet::bounds::Aabb;

use super::grid::{Grid, GridBox};

/// Instances of a block: as many as a workgroup has invocations.
pub const BLOCK: usize = 256;

/// Boxes of a scene's instances on grids, by slot: 16 bytes an instance.
///
/// Slots are in the hierarchy's order, so that the instances of a block lie near each other, and
/// its grid is fine.
#[derive(Clone, Debug, Default)]
pub struct Blocks {
    /// One box per slot, rounded up to blocks.
    boxes: Vec<GridBox>,
    /// Grid of each block, and the box around those of its instances that have a finite one;
    /// everything, where one has not.
    grids: Vec<(Grid, Aabb)>,
    /// Largest weight that an instance's size has in each block; infinite where the size of one
    /// does not count.
    weights: Vec<f32>,
    slots: u32,
    /// Blocks that changed since they were uploaded, ascending.
    changed: Vec<u32>,
}

impl Blocks {
    /// All instances of a scene. O(slots).
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        let mut made = Self::default();
        made.update(scene);
        made
    }

    /// Follows a scene: what changed since the last time is [known](Self::changed) afterwards.
    /// O(slots) reading; only blocks that differ are written.
    pub fn update(&mut self, scene: &Scene) {
        self.follow(scene.slot_count(), |slot| {
            let layers = if scene.is_removed(slot) { 0 } else { scene.layers(slot) };
            (bounds_of(scene, slot), layers, scene.size_weight(slot))
        });
    }

    /// The same of anything else with a box, layers, and a weight of its size, by its number; in no
    /// layer where there is nothing.
    pub fn follow(&mut self, slots: u32, of: impl Fn(u32) -> (Aabb, u32, f32)) {
        let blocks = (slots as usize).div_ceil(BLOCK);
        let had = self.grids.len();
        self.slots = slots;
        self.grids.resize(blocks, (Grid { origin: [0.0; 3], step: 1.0 }, Aabb::EMPTY));
        self.boxes.resize(blocks * BLOCK, GridBox::default());
        self.weights.resize(blocks, 0.0);
        self.changed.clear();
        let (mut given, mut own) = (Vec::with_capacity(BLOCK), [GridBox::default(); BLOCK]);
        for block in 0..blocks {
            let first = (block * BLOCK) as u32;
            given.clear();
            given.extend((first..slots.min(first + BLOCK as u32)).map(&of));
            let grid = fill(&given, &mut own);
            // What is no weight is of something that is never small.
            let weight = |most: f32, (_, _, own): &(Aabb, u32, f32)| {
                if *own >= 0.0 { most.max(*own) } else { f32::INFINITY }
            };
            self.weights[block] = given.iter().fold(0.0, weight);
            let boxes = &mut self.boxes[block * BLOCK..][..BLOCK];
            if block >= had || self.grids[block] != grid || boxes != own {
                self.grids[block] = grid;
                boxes.copy_from_slice(&own);
                self.changed.push(block as u32);
            }
        }
    }

    /// How many slots the scene has.
    #[must_use]
    pub fn slot_count(&self) -> u32 {
        self.slots
    }

    /// Boxes by slot; behind the last slot there is none.
    #[must_use]
    pub fn boxes(&self) -> &[GridBox] {
        &self.boxes
    }

    /// Returns the grid of each block, and a box around all of its instances.
    #[must_use]
    pub fn grids(&self) -> &[(Grid, Aabb)] {
        &self.grids
    }

    /// Returns the largest weight that an instance's size has in each block.
    pub(crate) fn weights(&self) -> &[f32] {
        &self.weights
    }

    /// Blocks that the last [update](Self::update) changed, ascending.
    #[must_use]
    pub fn changed(&self) -> &[u32] {
        &self.changed
    }
}

/// Boxes and layers on the finest grid that has them all.
fn fill(given: &[(Aabb, u32, f32)], own: &mut [GridBox; BLOCK]) -> (Grid, Aabb) {
    own.fill(GridBox::default());
    let mut around = Aabb::EMPTY;
    let mut always = false;
    for (bounds, ..) in given.iter().filter(|(_, layers, _)| *layers != 0) {
        let is_box = bounds.is_finite() && !bounds.is_empty();
        if is_box {
            around = around.union(bounds);
        }
        // What is not a number is not empty.
        let is_nan = bounds.min.iter().chain(&bounds.max).any(|v| v.is_nan());
        always |= is_nan || !is_box && !bounds.is_empty();
    }
    let grid = Grid::around(&around);
    for (own, (bounds, layers, _)) in own.iter_mut().zip(given).filter(|(_, (_, l, _))| *l != 0) {
        // All of them lie on a grid that was made around them.
        let found = grid.round_out(bounds).unwrap_or(GridBox::ALWAYS);
        *own = GridBox { layers: found.layers & layers, ..found };
    }
    (grid, if always { Aabb::new([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]) } else { around })
}

/// The box of an instance; of one that is never culled, everything.
pub(crate) fn bounds_of(scene: &Scene, slot: u32) -> Aabb {
    if is_exempt(scene, slot) {
        Aabb::new([f32::NEG_INFINITY; 3], [f32::INFINITY; 3])
    } else {
        scene.bounds(slot)
    }
}

/// Whether an instance is never culled.
pub(crate) fn is_exempt(scene: &Scene, slot: u32) -> bool {
    scene.exempt().get(slot as usize / 64).is_some_and(|w| w >> (slot % 64) & 1 != 0)
}
