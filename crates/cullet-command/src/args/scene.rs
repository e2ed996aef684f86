//! Options that choose the scene, and how to read it.

use std::path::{Path, PathBuf};

use clap::Args;
use cullet_io::Up;

use crate::parse;

/// Options that choose the scene, and how to read it.
#[derive(Clone, Debug, Default, Args)]
pub struct SceneArgs {
    /// A file (glb, gltf, obj, ply, stl, off, occscn, bsp), or a built-in scene: NAME or
    /// NAME:key=value,...
    #[arg(default_value = "city")]
    pub scene: String,
    /// Axis of the file that points up [default: what the format says, else y]
    #[arg(long, value_parser = parse::choice(AXES))]
    pub up: Option<Up>,
    /// Take every triangle for one-sided, whatever the file says
    #[arg(long, conflicts_with = "two_sided")]
    pub one_sided: bool,
    /// Take every triangle for two-sided: nothing is back-face culled
    #[arg(long)]
    pub two_sided: bool,
    /// Cut the scene into cells, for portal culling: a model of which each mesh is the volume of a
    /// room, as an IFC space is; or auto, which finds the rooms of a closed interior
    #[arg(long, value_name = "FILE|auto")]
    pub cells: Option<PathBuf>,
    /// Side of the voxels by which --cells auto finds rooms, in units of the scene: at most as
    /// thick as walls [default: half as thick as they are]
    #[arg(long, value_name = "M")]
    pub voxel: Option<f64>,
    /// Refuse files with more triangles than this (exit code 4)
    #[arg(long, value_name = "N")]
    pub max_triangles: Option<u64>,
    /// Cull by the sets that `cullet pvs` baked of this scene or map [default: those that are
    /// stored in a map]
    #[arg(long, value_name = "PATH")]
    pub pvs: Option<PathBuf>,
}

impl SceneArgs {
    /// A file or a built-in scene, read as it says.
    pub fn of(scene: impl Into<String>) -> Self {
        Self { scene: scene.into(), ..Self::default() }
    }

    /// Whether this is a built-in scene. A file of that name wins, for a name can be changed with a
    /// `./`.
    pub fn builtin(&self) -> bool {
        !Path::new(&self.scene).exists() && cullet_scenes::is_builtin(&self.scene)
    }
}

/// The axis that points up.
const AXES: &[(&str, Up, &str)] = &[("y", Up::Y, "+Y"), ("z", Up::Z, "+Z")];
