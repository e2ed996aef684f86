//! Sampled sets as a file, and in a scene that is culled by them.

use cullet::Scene;
use cullet::cell::{CellError, CellGraph, CellPiece, CellShapes};
use cullet::cull::pvs::{SetsError, Targets as SetTargets, VisibleSets};
use thiserror::Error;

use super::cells::Region;
use super::sets::{ScenePvs, scene_hash};
use crate::container::{Container, ContainerError, Tag, write_chunks};

/// The chunks of a file: the hash of the scene and the rays; the cells as boxes; the sets of instances; estimates.
const HEAD: Tag = *b"PVSS";
const BOXES: Tag = *b"BOXS";
const SETS: Tag = *b"SETS";
const MISSING: Tag = *b"MISS";
/// Bytes of a box.
const BOX: usize = 6 * 8;

/// View cells and their sets of instances, as a scene takes them.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneSets {
    /// The cells, as boxes in the world.
    pub cells: Vec<Region>,
    /// A set of instances for each.
    pub sets: VisibleSets<'static>,
    /// Of each cell, the share of looks that is estimated to go to what its set lacks; see [`ScenePvs::missing`].
    pub missing: Vec<f32>,
    /// Hash of the scene that they are of; see [`scene_hash`].
    pub scene_hash: u64,
}

/// Reason for which bytes are no sets of a scene, or not those of this one.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SceneSetsError {
    /// They are no baked file, or of something else.
    #[error(transparent)]
    Container(#[from] ContainerError),
    /// Their rows are none.
    #[error(transparent)]
    Sets(#[from] SetsError),
    /// A box is none.
    #[error(transparent)]
    Cell(#[from] CellError),
    /// They contradict themselves.
    #[error("{0}: written by another program?")]
    Odd(&'static str),
    /// They are of another scene.
    #[error(
        "it was baked from another scene, or from this one before it was changed: hash {found:016x}, this one has {expected:016x}; bake it again"
    )]
    OtherScene {
        /// Hash of the scene that was baked.
        found: u64,
        /// Hash of this one.
        expected: u64,
    },
}

impl ScenePvs {
    /// The sets as a scene takes them. Of an instance that was baked by clusters, the set holds it where it holds any of them.
    #[must_use]
    pub fn to_sets(&self) -> SceneSets {
        let count = (0..).take_while(|&index| self.targets.range(index).is_some()).count() as u32;
        let rows: Vec<Vec<u64>> = (0..self.visible.rows())
            .map(|cell| {
                let mut row = vec![0; (count as usize).div_ceil(64)];
                for index in 0..count {
                    let mut range = self.targets.range(index).into_iter().flatten();
                    if range.any(|target| self.visible.has(cell, target)) {
                        row[index as usize / 64] |= 1_u64 << (index % 64);
                    }
                }
                row
            })
            .collect();
        let rows = rows.iter().map(Vec::as_slice);
        SceneSets {
            cells: self.cells.clone(),
            sets: VisibleSets::from_rows(SetTargets::Instances, count, rows),
            missing: self.missing.clone(),
            scene_hash: self.scene_hash,
        }
    }

    /// The bytes of a file: a [container](crate::container).
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        self.to_sets().to_bytes(self.rays)
    }
}

impl SceneSets {
    /// Whether a file is one of these: that it has their first chunk.
    #[must_use]
    pub fn is_of(file: &Container<'_>) -> bool {
        file.tags().any(|tag| tag == HEAD)
    }

    /// The bytes of a file, as [`ScenePvs::to_bytes`] writes it, of sets that took so many rays.
    #[must_use]
    pub fn to_bytes(&self, rays: u64) -> Vec<u8> {
        let head = [self.scene_hash, rays].map(u64::to_le_bytes).concat();
        let boxes: Vec<u8> =
            self.cells.iter().flatten().flatten().flat_map(|v| v.to_le_bytes()).collect();
        let missing: Vec<u8> = self.missing.iter().flat_map(|v| v.to_le_bytes()).collect();
        let sets = self.sets.to_bytes();
        let chunks = [(HEAD, head), (BOXES, boxes), (SETS, sets), (MISSING, missing)];
        write_chunks(&chunks.each_ref().map(|(tag, bytes)| (*tag, &bytes[..])))
    }

    /// Reads the bytes that [`ScenePvs::to_bytes`] writes.
    ///
    /// # Errors
    /// If they are no container, of something else, cut short, or were changed.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, SceneSetsError> {
        let file = Container::open(bytes)?;
        let [hash, _] = file.chunk(HEAD)?.as_chunks::<8>().0 else {
            return Err(SceneSetsError::Odd("its head has not two numbers"));
        };
        let (boxes, []) = file.chunk(BOXES)?.as_chunks::<BOX>() else {
            return Err(SceneSetsError::Odd("bytes are left behind the last box"));
        };
        let corner = |bytes: &[u8; BOX], k: usize| {
            std::array::from_fn(|a| {
                f64::from_le_bytes(std::array::from_fn(|i| bytes[(k * 3 + a) * 8 + i]))
            })
        };
        let cells: Vec<Region> = boxes.iter().map(|b| [corner(b, 0), corner(b, 1)]).collect();
        let sets = VisibleSets::from_bytes(file.chunk(SETS)?)?.into_owned();
        if sets.cell_count() as usize != cells.len() || sets.targets() != SetTargets::Instances {
            return Err(SceneSetsError::Odd("it has not a set of instances for each box"));
        }
        let (missing, rest) = file.chunk(MISSING)?.as_chunks::<4>();
        let missing: Vec<f32> = missing.iter().map(|v| f32::from_le_bytes(*v)).collect();
        if missing.len() != cells.len() || !rest.is_empty() {
            return Err(SceneSetsError::Odd("it has not an estimate for each box"));
        }
        if !missing.iter().all(|share| (0.0..=1.0).contains(share)) {
            return Err(SceneSetsError::Odd("an estimate is no share of 0 to 1"));
        }
        Ok(Self { cells, sets, missing, scene_hash: u64::from_le_bytes(*hash) })
    }

    /// Mean over the cells of what is estimated to be [missing](Self::missing), and the most of a cell.
    #[must_use]
    pub fn stated_error(&self) -> [f64; 2] {
        let shares = || self.missing.iter().map(|&share| f64::from(share));
        [shares().sum::<f64>() / self.missing.len().max(1) as f64, shares().fold(0.0, f64::max)]
    }

    /// Gives them to the scene that they are of, in the place of any cells that it has. From then on
    /// [`Culler::pvs`](cullet::Culler::pvs) culls by them while the eye is in one of the boxes.
    ///
    /// # Errors
    /// If they are of another scene, or one of the boxes is none; the scene is as before then.
    pub fn place_in(self, scene: &mut Scene) -> Result<(), SceneSetsError> {
        let (found, expected) = (self.scene_hash, scene_hash(scene));
        if found != expected {
            return Err(SceneSetsError::OtherScene { found, expected });
        }
        let graph = CellGraph::new(self.cells.len() as u32, Vec::new())?;
        let piece = |(cell, [min, max]): (u32, &Region)| CellPiece::from_box(cell, *min, *max);
        let shapes = CellShapes::new(&graph, (0..).zip(&self.cells).map(piece).collect())?;
        scene.set_cells(graph, shapes);
        Ok(scene.set_visible_sets(self.sets)?)
    }
}
