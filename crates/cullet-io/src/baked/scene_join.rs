//! Sets of scenes that were baked apart and are loaded into one.

use std::collections::HashMap;

use cullet::Scene;
use cullet_cells::pvs::{JoinedSets, Tile, join_tiles};

use super::scene_sets::{Region, SceneSets, SceneSetsError, instance_marks, scene_hash};

impl SceneSets {
    /// Joins sets of tiles that were baked apart, each as if it were alone, for a scene into which
    /// all of them were loaded; see [`join_tiles`]. Returns the sets of all cells, and how many
    /// pairs of a cell and an instance are kept because nothing is known of them. Instances are
    /// found again by their marks, whatever their handles are now.
    ///
    /// O(cells · (words + instances of a set)).
    ///
    /// # Errors
    /// If a tile has no marks, or an instance of it is not in the scene, or not as it was.
    pub fn join(tiles: &[Self], scene: &Scene) -> Result<(Self, u64), SceneSetsError> {
        let marks = instance_marks(scene);
        let mut here: HashMap<u64, Vec<u32>> = HashMap::new();
        for (index, mark) in (0..).zip(&marks).filter(|(_, mark)| mark.hash != 0) {
            here.entry(mark.hash).or_default().push(index);
        }
        let origin = scene.origin();
        let mut boxes: Vec<Region> = vec![[[f64::NAN; 3]; 2]; marks.len()];
        for slot in scene.slots() {
            let Some(handle) = scene.handle(slot) else { continue };
            let b = scene.bounds(slot);
            boxes[handle.index as usize] =
                [b.min, b.max].map(|v| std::array::from_fn(|a| f64::from(v[a]) + origin[a]));
        }
        let mut found = Vec::with_capacity(tiles.len());
        for (tile, sets) in tiles.iter().enumerate() {
            let mut taken: HashMap<u64, usize> = HashMap::new();
            let mut targets = Vec::with_capacity(sets.marks.len());
            if sets.marks.is_empty() && sets.sets.target_count() > 0 {
                return Err(SceneSetsError::Unmarked { tile });
            }
            for (instance, mark) in sets.marks.iter().enumerate() {
                if mark.hash == 0 {
                    targets.push(u32::MAX);
                    continue;
                }
                // Those that are alike in everything may stand for each other, in their order.
                let next = taken.entry(mark.hash).or_default();
                let index = here.get(&mark.hash).and_then(|alike| alike.get(*next));
                *next += 1;
                targets.push(*index.ok_or(SceneSetsError::NotThere { tile, instance })?);
            }
            let none = [[f64::NAN; 3]; 2];
            let bounds: Vec<Region> =
                targets.iter().map(|&t| boxes.get(t as usize).copied().unwrap_or(none)).collect();
            found.push((targets, bounds));
        }
        let parts: Vec<Tile<'_>> = (tiles.iter().zip(&found))
            .map(|(tile, (targets, bounds))| Tile {
                sets: &tile.sets,
                cells: &tile.cells,
                targets,
                bounds,
            })
            .collect();
        let JoinedSets { sets, unknown, .. } = join_tiles(&parts, marks.len() as u32)?;
        let joined = Self {
            cells: tiles.iter().flat_map(|tile| tile.cells.iter().copied()).collect(),
            sets,
            missing: tiles.iter().flat_map(|tile| tile.missing.iter().copied()).collect(),
            scene_hash: scene_hash(scene),
            rays: tiles.iter().map(|tile| tile.rays).sum(),
            marks,
        };
        Ok((joined, unknown))
    }
}
