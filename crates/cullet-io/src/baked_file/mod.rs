//! A baked file whose tables are used as they lie: opened by its JSON alone, however large it is.

mod mapping;
mod slices;

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use thiserror::Error;

use crate::ErrorKind;
use crate::baked::{BakedError, sum_of};
use crate::gltf::{self, Listed};

pub use crate::gltf::{ListedLevels, ListedMesh};
pub use mapping::Mapping;
pub use slices::LevelSlices;

/// Why a file cannot be used as it lies.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BakedFileError {
    /// It cannot be opened or mapped.
    #[error("{}: cannot be mapped: {error}", path.display())]
    Map {
        /// The file.
        path: PathBuf,
        /// Why.
        error: std::io::Error,
    },
    /// It is no GLB, or one that contradicts itself: which item, and what.
    #[error("{0}")]
    File(#[from] ErrorKind),
    /// It is a GLB in which nothing is baked.
    #[error("nothing is baked in it; `cullet bake FILE -o baked.glb` bakes")]
    NothingBaked,
    /// What is baked is of another version, or its table of chunks is damaged.
    #[error("{0}")]
    Baked(#[from] BakedError),
    /// Numbers of this machine have their first byte last, and those of the file theirs first.
    #[error("tables are little-endian, and this machine is not: load the file instead")]
    BigEndian,
}

/// A GLB with `CULLET_baked`, whose tables are slices of its bytes: nothing is copied, and what is never looked at is never
/// read from the disk. `B` is a [`Mapping`], or any bytes that begin at a multiple of 4 in memory.
///
/// What a mesh has is checked by its sum when it is first asked for: bytes that were damaged are never given out. A sum is no
/// proof against malice: whether numbers of a table are within range is for who uses it to check, or for
/// [`LevelTables::build`](crate::baked::LevelTables::build), which checks all of them.
///
/// ```no_run
/// let file = cullet_io::BakedFile::open("baked.glb".as_ref())?;
/// for (at, mesh) in file.meshes().iter().enumerate() {
///     for levels in 0..mesh.levels.len() {
///         let tables = file.levels(at, levels)?;
///         println!("{}: {} clusters in {} groups", mesh.name, tables.clusters.len(), tables.groups.len());
///     }
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct BakedFile<B = Mapping> {
    bytes: B,
    listed: Listed,
    /// For each mesh whether its sum is right, once that is known.
    sound: Vec<OnceLock<Result<(), BakedError>>>,
}

impl BakedFile<Mapping> {
    /// Maps a file and reads its JSON: O(size of the JSON), whatever there is in tables.
    ///
    /// # Errors
    /// If it cannot be mapped, is no GLB, has nothing baked or that of another version, or the table of chunks is damaged.
    pub fn open(path: &Path) -> Result<Self, BakedFileError> {
        let map = Mapping::open(path);
        Self::of(map.map_err(|error| BakedFileError::Map { path: path.to_owned(), error })?)
    }
}

impl<B: AsRef<[u8]>> BakedFile<B> {
    /// Of bytes that are in memory.
    ///
    /// # Errors
    /// As [`open`](BakedFile::open).
    pub fn of(bytes: B) -> Result<Self, BakedFileError> {
        if cfg!(target_endian = "big") {
            return Err(BakedFileError::BigEndian);
        }
        let listed = gltf::list(bytes.as_ref()).map_err(|error| match error {
            gltf::ListError::File(kind) => BakedFileError::File(kind),
            gltf::ListError::Baked(error) => BakedFileError::Baked(error),
        })?;
        let listed = listed.ok_or(BakedFileError::NothingBaked)?;
        let sound = listed.meshes.iter().map(|_| OnceLock::new()).collect();
        Ok(Self { bytes, listed, sound })
    }

    /// What baked it, with its version.
    #[must_use]
    pub fn generator(&self) -> &str {
        &self.listed.generator
    }

    /// Its bytes.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.bytes.as_ref()
    }

    /// The meshes with something baked, by their numbers in the file.
    #[must_use]
    pub fn meshes(&self) -> &[ListedMesh] {
        &self.listed.meshes
    }

    /// Whether all that is baked of the mesh `at` of [`meshes`](Self::meshes) is as it was written. Reads its tables once.
    ///
    /// # Errors
    /// If it is not, or the mesh has a problem; also where there is no such mesh.
    pub fn check(&self, at: usize) -> Result<(), BakedError> {
        let mesh = self.mesh(at)?;
        let check = || {
            let bytes = self.bytes();
            let rows = mesh.levels.iter().map(|l| {
                let tables = l.tables.each_ref().map(|range| &bytes[range.clone()]);
                (l.kind, &l.measured, &l.parts[..], tables)
            });
            let (found, expected) = (sum_of(mesh.geometry, rows), mesh.sum);
            match found == expected {
                true => Ok(()),
                false => {
                    Err(BakedError::Damaged { what: "what is baked of it".into(), found, expected })
                }
            }
        };
        self.sound[at].get_or_init(check).clone()
    }

    /// The tables of the levels `levels` of the mesh `at` of [`meshes`](Self::meshes), as they lie. The first time for each
    /// mesh its sum is checked.
    ///
    /// # Errors
    /// As [`check`](Self::check); where there are no such levels; or if the bytes do not begin where numbers of four bytes
    /// can, as those of a mapping always do.
    pub fn levels(&self, at: usize, levels: usize) -> Result<LevelSlices<'_>, BakedError> {
        self.check(at)?;
        self.levels_unchecked(at, levels)
    }

    /// As [`levels`](Self::levels), whether the sum is right or not: of a file that was checked before.
    ///
    /// # Errors
    /// As [`levels`](Self::levels), but for the sum.
    pub fn levels_unchecked(
        &self,
        at: usize,
        levels: usize,
    ) -> Result<LevelSlices<'_>, BakedError> {
        let mesh = self.mesh(at)?;
        let listed = mesh.levels.get(levels).ok_or_else(|| {
            let count = mesh.levels.len();
            BakedError::Form(format!("levels {levels} of {count}: there are none"))
        })?;
        LevelSlices::new(self.bytes(), listed)
    }

    fn mesh(&self, at: usize) -> Result<&ListedMesh, BakedError> {
        let count = self.listed.meshes.len();
        let mesh = self.listed.meshes.get(at);
        let mesh =
            mesh.ok_or_else(|| BakedError::Form(format!("mesh {at} of {count}: there is none")))?;
        match &mesh.problem {
            Some(problem) => Err(problem.clone()),
            None => Ok(mesh),
        }
    }
}
