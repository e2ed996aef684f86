//! Saving a model: GLB, PLY, OBJ or STL, by the ending of the file's name.

mod baked;
mod buffer;
mod cameras;
mod cells;
mod glb;
mod impostor;
mod nodes;
mod obj;
mod original;
mod ply;
mod stand_ins;
mod stl;
mod written;

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use cullet::{Scene, Transform};
use glam::{DMat3, DVec3};
use thiserror::Error;

use crate::{Attributes, ErrorKind, Model};

use written::Written;

pub use original::save_original;
pub use written::Saved;

/// Why a model cannot be saved.
#[derive(Debug, Error)]
#[error("{}: {kind}", path.display())]
pub struct SaveError {
    /// The file.
    pub path: PathBuf,
    /// The defect.
    pub kind: SaveErrorKind,
}

/// Reason why a model cannot be saved.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SaveErrorKind {
    /// The file cannot be written.
    #[error("cannot be written: {0}")]
    Io(#[from] std::io::Error),
    /// The ending names no kind of file that is written.
    #[error("is of no kind that is written; use .glb, .ply, .obj or .stl")]
    Unsupported,
    /// The file that it is to be added to cannot be read.
    #[error("the original {}: {kind}", path.display())]
    Original {
        /// That file.
        path: PathBuf,
        /// The defect.
        kind: ErrorKind,
    },
    /// The format's numbers have 32 bits, and where the model is, none of its triangles would have
    /// an area.
    #[error(
        "none of its {triangles} triangles would have an area in the 32-bit numbers of this format; \
         use .glb, .ply or .obj"
    )]
    TooFar {
        /// Triangles of the model.
        triangles: u64,
    },
    /// More than the format's numbers can count.
    #[error("{count} {what} exceed the {limit} that the format can hold")]
    TooMany {
        /// The kind of item of which there are too many.
        what: &'static str,
        /// How many.
        count: u64,
        /// How many at the most.
        limit: u64,
    },
}

/// A kind of file that is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SaveFormat {
    /// Binary glTF 2.0: meshes are shared by their nodes, with names, materials, sidedness and
    /// attributes. Cells and portals are in `CULLET_cells_portals`, levels that the model's
    /// [`baked`](crate::baked) names in `CULLET_baked`. Of the model's node tree the nodes are kept
    /// that lead to an instance; where it has none, there is one node for each instance.
    Glb,
    /// Binary, little-endian: all instances as one mesh in world space, with their attributes;
    /// normals only if all have them. Coordinates are `double` where `float` is coarse for the size
    /// of an instance: far from zero.
    Ply,
    /// Text: a group for each instance, in world space, with attributes, and a file of materials
    /// beside it. Coordinates have the digits of f64 where those of f32 say less than the vertex.
    Obj,
    /// Binary: all instances as one mesh in world space, three vertices a triangle. Where f32 is
    /// coarse for the size of an instance, they are counted from a [place](Saved::origin) nearby.
    Stl,
}

impl SaveFormat {
    /// The kind that the ending of a name stands for, in either case.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        Some(match ending.as_str() {
            "glb" => Self::Glb,
            "ply" => Self::Ply,
            "obj" => Self::Obj,
            "stl" => Self::Stl,
            _ => return None,
        })
    }
}

/// Saves the meshes, instances and materials of a model, and the attributes that it has, and in a
/// GLB its cells, its levels and its cameras, each where its first key is; other views are left
/// out. Every triangle is written, in its original order, degenerate ones too. What is left out all the
/// same is named in the [notes](Saved::notes) of the result: instances whose transforms are not
/// finite, and what the format has no place for. An existing file is replaced when all has been written, so that
/// one half written never takes its place.
///
/// # Errors
/// If the ending is of no kind that is written, the file cannot be written, or the numbers of the
/// format are too small or too coarse.
pub fn save(model: &Model, path: &Path) -> Result<Saved, SaveError> {
    let write = || -> Result<Saved, SaveErrorKind> {
        let format = SaveFormat::of(path).ok_or(SaveErrorKind::Unsupported)?;
        // Counts are held against limits before an existing file is emptied.
        let mut all = Written::of(model, format);
        all.check(format)?;
        replace(path, |out| match format {
            SaveFormat::Glb => glb::write(&mut all, out),
            SaveFormat::Ply => Ok(ply::write(&all, out)?),
            SaveFormat::Obj => Ok(obj::write(&all, path, out)?),
            SaveFormat::Stl => stl::write(&mut all, out),
        })?;
        Ok(all.saved)
    };
    write().map_err(|kind| SaveError { path: path.to_owned(), kind })
}

/// Writes a file beside its place, and puts it there when all has been written and is on the disk.
fn replace(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), SaveErrorKind>,
) -> Result<(), SaveErrorKind> {
    let beside = Beside::of(path);
    let mut out = BufWriter::with_capacity(1 << 16, File::create(&beside.path)?);
    write(&mut out)?;
    let file = out.into_inner().map_err(std::io::IntoInnerError::into_error)?;
    Ok(beside.finish(&file, path)?)
}

/// Where a file is written, before it takes the place of the one that is there.
struct Beside {
    path: PathBuf,
    /// Whether it is another place.
    apart: bool,
}

impl Beside {
    /// Beside `path`; the place itself where that is no file, but a device or a pipe.
    fn of(path: &Path) -> Self {
        let real = std::fs::canonicalize(path);
        let apart = real.as_ref().map_or(true, |real| real.is_file());
        let mut name = real.unwrap_or_else(|_| path.to_owned()).into_os_string();
        if apart {
            // A page is no process, and asking for its number would panic.
            let process = if cfg!(target_family = "wasm") { 0 } else { std::process::id() };
            name.push(format!(".{process}.part"));
        }
        Self { path: name.into(), apart }
    }

    /// Puts it in its place.
    fn finish(mut self, file: &File, path: &Path) -> std::io::Result<()> {
        if self.apart {
            file.sync_all()?;
            // Behind a link it is the file that is replaced.
            let real = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
            std::fs::rename(&self.path, real)?;
            self.apart = false;
        }
        Ok(())
    }
}

impl Drop for Beside {
    fn drop(&mut self) {
        if self.apart {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// Attributes of the vertices of a mesh; a list that has not one entry a vertex is left empty.
fn attributes(model: &Model, mesh: usize) -> Attributes {
    let vertices = model.scene.meshes()[mesh].positions().len();
    let mut kept = model.attributes.get(mesh).cloned().unwrap_or_default();
    let fits = |count: usize| count == vertices;
    kept.normals.truncate(if fits(kept.normals.len()) { vertices } else { 0 });
    kept.uvs.truncate(if fits(kept.uvs.len()) { vertices } else { 0 });
    kept.colors.truncate(if fits(kept.colors.len()) { vertices } else { 0 });
    kept
}

/// The normals of an instance in world space, of unit length.
fn world_normals(transform: &Transform, mesh: &cullet::Mesh, kept: &Attributes) -> Vec<[f32; 3]> {
    let linear = DMat3::from_cols_array_2d(&transform.linear.map(|c| c.map(f64::from)));
    // That of planes; a transform that flattens has none, and normals stay as they are.
    let inverse = linear.inverse().transpose();
    let turn = if inverse.is_finite() { inverse } else { DMat3::IDENTITY };
    let world = |n: [f32; 3]| {
        let n = turn * DVec3::from(n.map(f64::from));
        n.try_normalize().unwrap_or(DVec3::Y).as_vec3().to_array()
    };
    kept.unit_normals(mesh).into_iter().map(world).collect()
}

/// The triangles of an instance in world space: a mirrored one is turned, so that its outside stays
/// out.
fn world_indices(scene: &Scene, slot: u32) -> Vec<u32> {
    let mut indices = scene.mesh(slot).original_indices();
    if scene.transform(slot).determinant() < 0.0 {
        indices.chunks_exact_mut(3).for_each(|t| t.swap(1, 2));
    }
    indices
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write as _;

    #[test]
    fn a_file_that_is_half_written_never_takes_the_place_of_a_good_one() {
        let name = format!("cullet-replace-{}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&folder).expect("a folder of ours");
        let path = folder.join("a.glb");
        let bytes: Vec<u8> = (0..200_000u32).map(|k| k as u8).collect();
        // More than the writer holds, so that some of it is on the disk already.
        for end in [0, 1, 65_535, 65_536, 131_073, bytes.len()] {
            std::fs::write(&path, b"good").expect("ours");
            let stopped = replace(&path, |out| {
                out.write_all(&bytes[..end])?;
                Err(std::io::Error::other("the disk is full").into())
            });
            assert!(matches!(stopped, Err(SaveErrorKind::Io(_))));
            assert_eq!(std::fs::read(&path).expect("ours"), b"good", "stopped at {end}");
            assert_eq!(std::fs::read_dir(&folder).expect("ours").count(), 1, "stopped at {end}");
        }
        replace(&path, |out| Ok(out.write_all(&bytes)?)).expect("written");
        assert_eq!(std::fs::read(&path).expect("ours"), bytes);
        std::fs::remove_dir_all(&folder).expect("ours to remove");
    }
}
