//! A baked file whose tables are used as they lie: opened by its JSON alone, however large it is.

mod mapping;
mod slices;

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use thiserror::Error;

use crate::ErrorKind;
use crate::baked::{
    BakedError, Measured, attribute_sum, impostor_sum, occluder_sum, sum_of, sum_of_stand_ins,
};
use crate::gltf::{self, Listed};

pub use crate::gltf::{ListedGroup, ListedImpostor, ListedLevels, ListedMesh, ListedTable};
pub use mapping::Mapping;
pub use slices::{GroupSlices, ImpostorSlices, LevelSlices, OccluderSlices};

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
    /// The baked data is of another version, or its table of chunks is damaged.
    #[error("{0}")]
    Baked(#[from] BakedError),
    /// Numbers of this machine have their first byte last, and those of the file theirs first.
    #[error("tables are little-endian, and this machine is not: load the file instead")]
    BigEndian,
}

/// A GLB with `CULLET_baked`, whose tables are slices of its bytes: nothing is copied, and what is
/// never looked at is never read from the disk. `B` is a [`Mapping`], or any bytes that begin at a
/// multiple of 4 in memory.
///
/// What a mesh has is checked by its sum when it is first asked for: bytes that were damaged are
/// never given out. A sum is no proof against malice: whether numbers of a table are within range
/// is for who uses it to check, or for [`LevelTables::build`](crate::baked::LevelTables::build),
/// which checks all of them.
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
    /// And of all merged groups.
    sound_groups: OnceLock<Result<(), BakedError>>,
}

impl BakedFile<Mapping> {
    /// Maps a file and reads its JSON: O(size of the JSON), whatever there is in tables.
    ///
    /// # Errors
    /// If it cannot be mapped, is no GLB, has nothing baked or that of another version, or the
    /// table of chunks is damaged.
    pub fn open(path: &Path) -> Result<Self, BakedFileError> {
        let map = Mapping::open(path);
        Self::of(map.map_err(|error| BakedFileError::Map { path: path.to_owned(), error })?)
    }
}

impl<B: AsRef<[u8]>> BakedFile<B> {
    /// Reads a file from bytes in memory.
    ///
    /// # Errors
    /// As [`open`](BakedFile::open).
    pub fn of(bytes: B) -> Result<Self, BakedFileError> {
        let listed = gltf::list(bytes.as_ref()).map_err(|error| match error {
            gltf::ListError::File(kind) => BakedFileError::File(kind),
            gltf::ListError::Baked(error) => BakedFileError::Baked(error),
        })?;
        let listed = listed.ok_or(BakedFileError::NothingBaked)?;
        let sound = listed.meshes.iter().map(|_| OnceLock::new()).collect();
        Ok(Self { bytes, listed, sound, sound_groups: OnceLock::new() })
    }

    /// Returns the program that baked the file, with its version.
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

    /// Whether all that is baked of the mesh `at` of [`meshes`](Self::meshes) is as it was written.
    /// Reads its tables once.
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
            same("what is baked of it", sum_of(mesh.geometry, rows), mesh.sum)?;
            if let Some(table) = &mesh.occluders {
                let found = occluder_sum(mesh.geometry, &bytes[table.bytes.clone()]);
                same("its occluders", found, table.sum)?;
            }
            if let Some(of) = &mesh.impostor {
                let own = &bytes[of.table.bytes.clone()];
                let found = impostor_sum(mesh.geometry, &of.measured, own);
                same("its impostor", found, of.table.sum)?;
            }
            Ok(())
        };
        self.sound[at].get_or_init(check).clone()
    }

    /// The tables of the levels `levels` of the mesh `at` of [`meshes`](Self::meshes), as they lie.
    /// The first time for each mesh its sum is checked.
    ///
    /// # Errors
    /// As [`check`](Self::check); where there are no such levels; or if the bytes do not begin
    /// where numbers of four bytes can, as those of a mapping always do.
    pub fn levels(&self, at: usize, levels: usize) -> Result<LevelSlices<'_>, BakedError> {
        self.check(at)?;
        self.levels_unchecked(at, levels)
    }

    /// Returns the same as [`levels`](Self::levels), without checking the sum: for a file that was
    /// checked before.
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
        LevelSlices::new(self.bytes(), &listed.parts, &listed.tables)
    }

    /// The occluders of the mesh `at` of [`meshes`](Self::meshes), as they lie, if it has some.
    ///
    /// # Errors
    /// As [`levels`](Self::levels), or if there are more or fewer bytes than they say.
    pub fn occluders(&self, at: usize) -> Result<Option<OccluderSlices<'_>>, BakedError> {
        self.check(at)?;
        self.occluders_unchecked(at)
    }

    /// Returns the same as [`occluders`](Self::occluders), without checking the sum: for a file
    /// that was checked before.
    ///
    /// # Errors
    /// As [`occluders`](Self::occluders), but for the sum.
    pub fn occluders_unchecked(&self, at: usize) -> Result<Option<OccluderSlices<'_>>, BakedError> {
        let listed = self.mesh(at)?.occluders.as_ref();
        listed.map(|of| OccluderSlices::new(self.bytes(), &of.bytes)).transpose()
    }

    /// The impostor of the mesh `at` of [`meshes`](Self::meshes), as it lies, if it has one.
    ///
    /// # Errors
    /// As [`occluders`](Self::occluders).
    pub fn impostor(&self, at: usize) -> Result<Option<ImpostorSlices<'_>>, BakedError> {
        self.check(at)?;
        self.impostor_unchecked(at)
    }

    /// Returns the same as [`impostor`](Self::impostor), without checking the sum: for a file that
    /// was checked before.
    ///
    /// # Errors
    /// As [`impostor`](Self::impostor), but for the sum.
    pub fn impostor_unchecked(&self, at: usize) -> Result<Option<ImpostorSlices<'_>>, BakedError> {
        let listed = self.mesh(at)?.impostor.as_ref();
        listed.map(|of| ImpostorSlices::new(self.bytes(), &of.table.bytes)).transpose()
    }

    /// The merged groups of instances, those below others before them.
    ///
    /// # Errors
    /// If the file says of them what cannot be.
    pub fn groups(&self) -> Result<&[ListedGroup], BakedError> {
        self.listed.groups.as_ref().map(|groups| &groups.all[..]).map_err(Clone::clone)
    }

    /// How errors of merged groups were found; `None` where there are none.
    #[must_use]
    pub fn groups_measured(&self) -> Option<Measured> {
        let groups = self.listed.groups.as_ref().ok()?;
        (!groups.all.is_empty()).then_some(groups.measured)
    }

    /// Whether all that is baked of merged groups is as it was written. Reads their tables once,
    /// for they have one sum.
    ///
    /// # Errors
    /// If it is not, or as [`groups`](Self::groups).
    pub fn check_groups(&self) -> Result<(), BakedError> {
        let groups = self.listed.groups.as_ref().map_err(Clone::clone)?;
        let check = || {
            let bytes = self.bytes();
            let of = |range: &std::ops::Range<usize>| &bytes[range.clone()];
            let rows = groups.heads.iter().zip(&groups.all).map(|(head, one)| {
                let [indices, clusters, groups] = one.tables.each_ref().map(of);
                (head, [of(&one.positions), indices, clusters, groups])
            });
            let rows: Vec<_> = rows.collect();
            if rows.is_empty() {
                return Ok(());
            }
            same("the list of merged groups", sum_of_stand_ins(&rows), groups.sum)?;
            groups.all.iter().filter_map(|one| one.attributes.as_ref()).try_for_each(
                |(ranges, sum)| {
                    let found = attribute_sum(ranges.each_ref().map(of));
                    same("attributes of a merged group", found, *sum)
                },
            )
        };
        self.sound_groups.get_or_init(check).clone()
    }

    /// The tables of a merged group, as they lie. The first time the sum of all groups is checked.
    ///
    /// # Errors
    /// As [`check_groups`](Self::check_groups), or if there is no such group.
    pub fn group(&self, number: usize) -> Result<GroupSlices<'_>, BakedError> {
        self.check_groups()?;
        self.group_unchecked(number)
    }

    /// Returns the same as [`group`](Self::group), without checking the sum: for a file that was
    /// checked before.
    ///
    /// # Errors
    /// As [`group`](Self::group), but for the sum.
    pub fn group_unchecked(&self, number: usize) -> Result<GroupSlices<'_>, BakedError> {
        let all = self.groups()?;
        let missing =
            || BakedError::Form(format!("merged group {number} of {}: there is none", all.len()));
        GroupSlices::new(self.bytes(), all.get(number).ok_or_else(missing)?)
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

fn same(what: &str, found: u64, expected: u64) -> Result<(), BakedError> {
    match found == expected {
        true => Ok(()),
        false => Err(BakedError::Damaged { what: what.into(), found, expected }),
    }
}
