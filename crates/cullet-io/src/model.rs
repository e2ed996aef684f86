//! A model: a scene with names, materials and cameras.

use std::borrow::Cow;

use cullet::{Handle, Projection, Scene, Transform};
use cullet_cells::cell::CellError;
use cullet_cells::pvs::VisibleSets;
use cullet_cells::{Cells, InCells};
use serde::{Deserialize, Serialize};

use crate::baked::Baked;
use crate::motion::{Clip, Rig};
use crate::{Attributes, CellGraph, NodeTree, NodeTreeStatistics};

/// A scene, and what its file says beyond geometry.
#[derive(Debug, Default)]
pub struct Model {
    /// Name for people: the file's, or the built-in scene's.
    pub name: String,
    /// Meshes and instances, committed.
    pub scene: Scene,
    /// The name of each mesh, by its number.
    pub mesh_names: Vec<String>,
    /// Attributes of the vertices of each mesh besides positions, by its number; empty unless
    /// [`LoadOptions::details`](crate::LoadOptions::details) requests them. Meshes beyond the end
    /// have none.
    pub attributes: Vec<Attributes>,
    /// The name of each instance, by the index of its handle; empty where names are made up from
    /// the meshes', as for a scene of millions.
    pub instance_names: Vec<String>,
    /// The nodes of the file and which of them drew each instance; empty where the format has none.
    pub node_tree: NodeTree,
    /// Materials; [`cullet::mesh::Part::material`] is an index into these.
    pub materials: Vec<Material>,
    /// How many textures the file has. They are not read, and so in no file that is written.
    pub textures: u32,
    /// Cameras, fixed or moving.
    pub cameras: Vec<CameraNode>,
    /// Views that the file gives as matrices.
    pub views: Vec<MatrixView>,
    /// Rooms and openings, where the file has them or the scene was made with them.
    pub cells: CellGraph,
    /// The instances in each of those cells, as [`place_cells`](Self::place_cells) found them.
    /// Culling by [`in_cells`](Self::in_cells) reads them.
    pub placed: Option<Cells>,
    /// Visible sets of the cells that the file brings along: of maps that were baked.
    pub cell_sets: Option<VisibleSets<'static>>,
    /// Height of a person's eyes above the ground in the model's units, where the format says what
    /// its units are: of maps.
    pub eye_height: Option<f64>,
    /// How it moves, if it does; see [`Model::pose`](Self::pose).
    pub motion: Option<Motion>,
    /// Baked data of its meshes, where the file has any: the kinds of the scene's levels, and how
    /// they were measured.
    pub baked: Option<Baked>,
    /// The number that each mesh has in its file, where the format numbers them (glTF). Meshes
    /// beyond the end are of no file. One that nodes deform is there once for each of them.
    pub file_meshes: Vec<u32>,
    /// Extensions that the file uses and that were not read. Each is among the warnings too.
    pub unread: Vec<Unread>,
    /// Defects of the file that did not stop it from loading.
    pub warnings: Vec<Warning>,
}

impl Model {
    /// The name of the instance of a handle: its own, or its mesh's with the handle's index (`oak
    /// 12`) where it has none. A handle that names no instance has the name `instance 12`.
    #[must_use]
    pub fn instance_name(&self, handle: Handle) -> Cow<'_, str> {
        if let Some(name) = self.instance_names.get(handle.index as usize).filter(|n| !n.is_empty())
        {
            return Cow::Borrowed(name);
        }
        let mesh = self.scene.slot(handle).ok().and_then(|slot| {
            self.mesh_names.get(self.scene.mesh_id(slot) as usize).filter(|n| !n.is_empty())
        });
        Cow::Owned(format!("{} {}", mesh.map_or("instance", String::as_str), handle.index))
    }

    /// Finds what is in the model's [cells](Self::cells), if there are any, in place of those that
    /// were [placed](Self::placed).
    ///
    /// # Errors
    /// If [`CellGraph::build`] refuses them; those that were placed stay.
    pub fn place_cells(&mut self) -> Result<(), CellError> {
        if !self.cells.cells.is_empty() {
            let (graph, shapes) = self.cells.build()?;
            self.placed = Some(Cells::new(&mut self.scene, graph, shapes));
        }
        Ok(())
    }

    /// Returns the scene with its placed cells, to cull by both.
    #[must_use]
    pub fn in_cells(&self) -> InCells<'_> {
        InCells::new(&self.scene, self.placed.as_ref())
    }

    /// Finds again which instances are in which cells, after the scene changed. The cost is that of
    /// what changed, but after a commit.
    pub fn update_cells(&mut self) {
        if let Some(placed) = &mut self.placed {
            placed.update(&self.scene);
        }
    }

    /// Measures the node tree; `None` if it is none: a file's is one, but one that was written by
    /// hand may have a loop. O(nodes + instances).
    #[must_use]
    pub fn node_tree_statistics(&self) -> Option<NodeTreeStatistics> {
        let handles = self.scene.slots().filter_map(|slot| self.scene.handle(slot));
        self.node_tree.statistics(handles.map(|handle| handle.index))
    }
}

/// A material, as far as visibility and simple pictures care.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Material {
    /// Its name.
    pub name: String,
    /// Linear base colour and alpha.
    pub color: [f32; 4],
}

impl Material {
    /// The colour of what has no material.
    pub const GREY: [f32; 4] = [0.8, 0.8, 0.8, 1.0];
}

/// A camera of a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraNode {
    /// Its name.
    pub name: String,
    /// Its projection. The aspect is the file's, or 0 where the file leaves it to the viewport.
    pub projection: Projection,
    /// Where it is, at each key time in seconds: one key for a fixed camera. It looks along its −Z.
    pub keys: Vec<(f64, Transform)>,
}

/// A fixed view that a file gives as a matrix.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MatrixView {
    /// Its name.
    pub name: String,
    /// World to clip space, column-major for column vectors; depth 0 (near) to 1, y up.
    pub clip_from_world: [f64; 16],
    /// Where the eye is.
    pub eye: [f64; 3],
    /// Distance of the near plane, in the units of clip w.
    pub near: f64,
}

/// An extension that a file uses and that was not read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unread {
    /// Its name.
    pub name: String,
    /// Its meaning, and what follows of not reading it.
    pub meaning: String,
    /// Whether it may move or hide what is drawn, so that nobody can say that nothing moves.
    pub may_move: bool,
    /// Whether it may bring triangles, or change where they are.
    pub may_draw: bool,
}

/// A defect of a file that did not stop it from loading: which item, and what about it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Warning {
    /// The item: a line, a node, an accessor.
    pub item: String,
    /// The defect, with the values.
    pub message: String,
}

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.item, self.message)
    }
}

/// How a model moves: the animations, skins and morph targets of a glTF, or a built-in scene's
/// time.
#[derive(Debug)]
pub struct Motion {
    pub(crate) kind: MotionKind,
}

pub(crate) enum MotionKind {
    /// Animations, skins and morph targets of a file.
    Rig(Rig),
    /// A model that is made anew at each time.
    Made(Make),
}

/// Makes a model as it is at a number of seconds; an error is a sentence.
type Make = Box<dyn Fn(f64) -> Result<Model, String> + Send + Sync>;

impl std::fmt::Debug for MotionKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Rig(rig) => f.debug_tuple("Rig").field(rig).finish(),
            Self::Made(_) => f.write_str("Made"),
        }
    }
}

impl Motion {
    /// The motion of a model that is made by rule: `make` gives it as it is after a number of
    /// seconds, with the same instances and meshes.
    #[must_use]
    pub fn made(make: impl Fn(f64) -> Result<Model, String> + Send + Sync + 'static) -> Self {
        Self { kind: MotionKind::Made(Box::new(make)) }
    }

    /// For how many seconds it moves before it has shown everything: the longest animation. 0 where
    /// skins and morph targets stand still, `None` where it does not end.
    #[must_use]
    pub fn seconds(&self) -> Option<f64> {
        match &self.kind {
            MotionKind::Rig(rig) => Some(rig.clips.iter().map(Clip::seconds).fold(0.0, f64::max)),
            MotionKind::Made(_) => None,
        }
    }

    /// Whether anything moves as time passes: skins and morph targets may only stand.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.seconds() != Some(0.0)
    }
}
