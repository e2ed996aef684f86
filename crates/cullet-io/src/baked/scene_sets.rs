//! Visible sets of a scene's view cells, as `cullet pvs` bakes them: read, written, and given to
//! the scene that they are of.

use cullet::Scene;
use cullet_cells::Cells;
use cullet_cells::cell::{CellError, CellGraph, CellPiece, CellShapes};
use cullet_cells::pvs::{SetsError, Targets, VisibleSets};
use thiserror::Error;

use super::container::{Container, ContainerError, Tag, write_chunks};
use super::hash::{hash, mix};
use crate::bytes::{of_f32s, put_f32s, put_f64s, put_u32s, to_f32s};

/// The chunks of a file: the hash of the scene and the rays; the cells as boxes; the sets of
/// instances; estimates; marks of the instances.
const HEAD: Tag = *b"PVSS";
const BOXES: Tag = *b"BOXS";
const SETS: Tag = *b"SETS";
const MISSING: Tag = *b"MISS";
const MARKS: Tag = *b"MARK";
/// Bytes of a box, and of a mark.
const BOX: usize = 6 * 8;
const MARK: usize = 8 + 6 * 4;

/// A box in the world, low and high corner: a view cell.
pub type Region = [[f64; 3]; 2];

/// View cells and their sets of instances, as a scene takes them.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneSets {
    /// The cells, as boxes in the world.
    pub cells: Vec<Region>,
    /// A set of instances for each.
    pub sets: VisibleSets<'static>,
    /// For each cell, the estimated share of looks that go to something its set lacks; see
    /// `cullet_bake::sampled::ScenePvs::missing`.
    pub missing: Vec<f32>,
    /// Hash of the scene that they are of; see [`scene_hash`].
    pub scene_hash: u64,
    /// Rays that were traced for them.
    pub rays: u64,
    /// A mark of each instance, by the index of its handle: tells later what an edit changed. Empty
    /// in files that have none.
    pub marks: Vec<InstanceMark>,
}

/// Mark of an instance: tells whether it is still what it was, and if not, where it was.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InstanceMark {
    /// Hash of its mesh, place, layers and flags; 0 where no instance has the index. Two instances
    /// that are alike in all of that have the same hash.
    pub hash: u64,
    /// The box around it in the world, in f32: an aim and no bound.
    pub bounds: [[f32; 3]; 2],
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
    /// Sets to be joined that do not say of which instances they are.
    #[error("tile {tile} does not say of which instances it is; bake it again")]
    Unmarked {
        /// Number of the tile, from 0.
        tile: usize,
    },
    /// An instance of sets to be joined that is not in the scene.
    #[error("instance {instance} of tile {tile} is not in the scene, or not as it was baked")]
    NotThere {
        /// Number of the tile, from 0.
        tile: usize,
        /// Index of the instance in it.
        instance: usize,
    },
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

impl SceneSets {
    /// Whether a file is one of these: that it has their first chunk.
    #[must_use]
    pub fn is_of(file: &Container<'_>) -> bool {
        file.tags().any(|tag| tag == HEAD)
    }

    /// The bytes of a file.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let head = [self.scene_hash, self.rays].map(u64::to_le_bytes).concat();
        let mut boxes = Vec::new();
        put_f64s(&mut boxes, self.cells.as_flattened().as_flattened());
        let missing = of_f32s(&self.missing);
        let sets = self.sets.to_bytes();
        let mut marks = Vec::with_capacity(self.marks.len() * MARK);
        for mark in &self.marks {
            marks.extend(mark.hash.to_le_bytes());
            put_f32s(&mut marks, mark.bounds.as_flattened());
        }
        let chunks =
            [(HEAD, head), (BOXES, boxes), (SETS, sets), (MISSING, missing), (MARKS, marks)];
        write_chunks(&chunks.each_ref().map(|(tag, bytes)| (*tag, &bytes[..])))
    }

    /// Reads the bytes that [`to_bytes`](Self::to_bytes) writes.
    ///
    /// # Errors
    /// If they are no container, of something else, cut short, or were changed.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, SceneSetsError> {
        let file = Container::open(bytes)?;
        let [hash, rays] = file.chunk(HEAD)?.as_chunks::<8>().0 else {
            return Err(SceneSetsError::Odd("its head has not two numbers"));
        };
        let (boxes, []) = file.chunk(BOXES)?.as_chunks::<BOX>() else {
            return Err(SceneSetsError::Odd("bytes are left behind the last box"));
        };
        let number = |bytes: &[u8; BOX], at: usize| f64::from_le_bytes(bytes.as_chunks().0[at]);
        let corner =
            |b: &[u8; BOX], at: usize| [number(b, at), number(b, at + 1), number(b, at + 2)];
        let cells: Vec<Region> = boxes.iter().map(|b| [corner(b, 0), corner(b, 3)]).collect();
        let sets = VisibleSets::from_bytes(file.chunk(SETS)?)?.into_owned();
        if sets.cell_count() as usize != cells.len() || sets.targets() != Targets::Instances {
            return Err(SceneSetsError::Odd("it has not a set of instances for each box"));
        }
        let bytes = file.chunk(MISSING)?;
        let missing = to_f32s(bytes);
        if bytes.len() != cells.len() * 4 {
            return Err(SceneSetsError::Odd("it has not an estimate for each box"));
        }
        if !missing.iter().all(|share| (0.0..=1.0).contains(share)) {
            return Err(SceneSetsError::Odd("an estimate is no share of 0 to 1"));
        }
        let marks = if file.tags().any(|tag| tag == MARKS) { file.chunk(MARKS)? } else { &[] };
        let (marks, []) = marks.as_chunks::<MARK>() else {
            return Err(SceneSetsError::Odd("bytes are left behind the last mark"));
        };
        let mark = |bytes: &[u8; MARK]| {
            let (hash, bounds) = bytes.split_at(8);
            let ends = to_f32s(bounds);
            let corner = |at: usize| core::array::from_fn(|a| ends[at + a]);
            let hash = hash.try_into().map_or(0, u64::from_le_bytes);
            InstanceMark { hash, bounds: [corner(0), corner(3)] }
        };
        let marks: Vec<InstanceMark> = marks.iter().map(mark).collect();
        if !marks.is_empty() && marks.len() != sets.target_count() as usize {
            return Err(SceneSetsError::Odd("it has not a mark for each instance"));
        }
        let [scene_hash, rays] = [hash, rays].map(|n| u64::from_le_bytes(*n));
        Ok(Self { cells, sets, missing, scene_hash, rays, marks })
    }

    /// Mean over the cells of what is estimated to be [missing](Self::missing), and the most of a
    /// cell.
    #[must_use]
    pub fn stated_error(&self) -> [f64; 2] {
        let shares = || self.missing.iter().map(|&share| f64::from(share));
        [shares().sum::<f64>() / self.missing.len().max(1) as f64, shares().fold(0.0, f64::max)]
    }

    /// Returns cells of the scene that the sets are of. [`Culler::pvs`](cullet::Culler::pvs) culls
    /// by them while the eye is in one of the boxes.
    ///
    /// # Errors
    /// If they are of another scene, or one of the boxes is none.
    pub fn place_in(self, scene: &mut Scene) -> Result<Cells, SceneSetsError> {
        let (found, expected) = (self.scene_hash, scene_hash(scene));
        if found != expected {
            return Err(SceneSetsError::OtherScene { found, expected });
        }
        let graph = CellGraph::new(self.cells.len() as u32, Vec::new())?;
        let piece = |(cell, [min, max]): (u32, &Region)| CellPiece::from_box(cell, *min, *max);
        let shapes = CellShapes::new(&graph, (0..).zip(&self.cells).map(piece).collect())?;
        let mut cells = Cells::new(scene, graph, shapes);
        cells.set_visible_sets(self.sets)?;
        Ok(cells)
    }
}

/// Hash of what sets of a scene depend on: meshes, sides and alpha modes, and where instances
/// stand. The same on every machine; the order of slots is none of it. O(triangles of the meshes).
#[must_use]
pub fn scene_hash(scene: &Scene) -> u64 {
    let mut sum = scene.instance_count().into();
    for (index, mark) in (0_u64..).zip(instance_marks(scene)) {
        // A sum, for indices may be left out.
        if mark.hash != 0 {
            sum = mix(mark.hash ^ mix(index + 1)).wrapping_add(sum);
        }
    }
    mix(sum)
}

/// Marks of the instances of a scene, by the index of their handles. O(triangles of the meshes).
#[must_use]
pub fn instance_marks(scene: &Scene) -> Vec<InstanceMark> {
    let mut bytes = Vec::new();
    let mut meshes = Vec::with_capacity(scene.meshes().len());
    for mesh in scene.meshes() {
        bytes.clear();
        put_f32s(&mut bytes, mesh.positions().as_flattened());
        put_u32s(&mut bytes, mesh.indices());
        for c in mesh.clusters() {
            put_u32s(&mut bytes, &[c.first_triangle, c.triangle_count, c.part]);
        }
        for p in mesh.parts() {
            let deformable = mesh.is_deformable();
            bytes.extend([u8::from(p.two_sided), p.alpha as u8, u8::from(deformable)]);
        }
        meshes.push(hash(&bytes));
    }
    let origin = scene.origin();
    let mut marks = Vec::new();
    for slot in scene.slots() {
        let Some(handle) = scene.handle(slot) else { continue };
        let (t, flags) = (scene.transform(slot), scene.flags(slot));
        bytes.clear();
        bytes.extend(meshes[scene.mesh_id(slot) as usize].to_le_bytes());
        put_f32s(&mut bytes, t.linear.as_flattened());
        put_f64s(&mut bytes, &t.translation);
        bytes.extend(scene.layers(slot).to_le_bytes());
        bytes.extend([flags.transparent, flags.double_sided, scene.is_rigid(slot)].map(u8::from));
        let at = handle.index as usize;
        if marks.len() <= at {
            marks.resize(at + 1, InstanceMark::default());
        }
        let b = scene.bounds(slot);
        let corner = |v: [f32; 3]| core::array::from_fn(|a| (f64::from(v[a]) + origin[a]) as f32);
        marks[at] = InstanceMark { hash: hash(&bytes).max(1), bounds: [b.min, b.max].map(corner) };
    }
    marks
}
