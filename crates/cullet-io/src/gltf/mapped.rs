//! Where the tables of `CULLET_baked` lie in the bytes of a GLB: of the JSON only what leads there
//! is read, and of the rest nothing.

use std::ops::Range;

use super::baked::{self, Extended, LevelsItem, MeshItem, OccludersItem};
use super::baked_items::{self, form, item};
use super::impostor::{self, ImpostorItem};
use super::json::{self, Index, Root};
use super::mapped_groups::ListedGroups;
use super::mapped_tables::{aligned, level_tables};
use super::stand_ins;
use super::uri::shorten;
use super::{glb, mapped_groups};
use crate::ErrorKind;
use crate::baked::{BakedError, LevelKind, MOST_LEVELS, Measured};

/// Baked data of a file.
#[derive(Debug)]
pub(crate) struct Listed {
    pub(crate) generator: String,
    /// In the order of the file's table of chunks.
    pub(crate) meshes: Vec<ListedMesh>,
    /// Merged groups, or why they cannot be read.
    pub(crate) groups: Result<ListedGroups, BakedError>,
}

/// A mesh with something baked.
#[derive(Clone, Debug, PartialEq)]
pub struct ListedMesh {
    /// Its number in the file.
    pub number: u32,
    /// Its name; empty where it has none.
    pub name: String,
    /// [`geometry_hash`](crate::baked::geometry_hash) of the mesh that it was baked of.
    pub geometry: u64,
    /// Bytes of all of its tables.
    pub bytes: u64,
    /// The sum of what is baked of it, as the file says.
    pub sum: u64,
    /// Its levels; none where there is a problem.
    pub levels: Vec<ListedLevels>,
    /// Its occluders, where they were baked.
    pub occluders: Option<ListedTable>,
    /// Its impostor, if it has one.
    pub impostor: Option<ListedImpostor>,
    /// Why it cannot be read, where it cannot.
    pub problem: Option<BakedError>,
}

/// Levels of a mesh, and where their tables lie.
#[derive(Clone, Debug, PartialEq)]
pub struct ListedLevels {
    /// Kind of the levels.
    pub kind: LevelKind,
    /// How many triangles of all levels each primitive of triangles has; they follow each other.
    pub parts: Vec<u32>,
    /// Least and largest error, as the file says; none where it does not.
    pub errors: Option<[f32; 2]>,
    /// How errors were found.
    pub measured: Measured,
    /// Bytes of the file: indices, clusters, groups.
    pub tables: [Range<usize>; 3],
}

/// A table with a sum of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct ListedTable {
    /// Bytes of the file.
    pub bytes: Range<usize>,
    /// The sum, as the file says.
    pub sum: u64,
}

/// The impostor of a mesh, and where it lies.
#[derive(Clone, Debug, PartialEq)]
pub struct ListedImpostor {
    /// How its error was found; its [`points`](Measured::points) are directions.
    pub measured: Measured,
    /// Its table.
    pub table: ListedTable,
}

/// Finds them; `None` where nothing is baked. O(size of the JSON).
///
/// # Errors
/// If it is no GLB whose parts are within it, or the table of chunks is damaged or of another
/// version. What is wrong with one mesh is told with it.
pub(crate) fn list(bytes: &[u8]) -> Result<Option<Listed>, ListError> {
    let container = glb::parts(bytes)?;
    let Some(bin) = container.bin.filter(|_| container.is_glb) else {
        if container.is_glb {
            return Ok(None);
        }
        let message = "is no GLB: of other files nothing can be used as it lies";
        return Err(ErrorKind::Unsupported(message.to_owned()).into());
    };
    let root = json::parse(&bytes[container.json])?;
    let Some(raw) = baked::of_root(&root) else { return Ok(None) };
    let (generator, chunks) = baked::head(raw)?;
    let mut chunks: Vec<(u64, [u64; 2])> = chunks.into_iter().collect();
    chunks.sort_unstable();
    let mut taken = Vec::new();
    let mut meshes = Vec::with_capacity(chunks.len());
    for (number, chunk) in chunks {
        let mut own = mesh(&root, number, chunk, &bin, &mut taken);
        own.number = u32::try_from(number).unwrap_or(u32::MAX);
        meshes.push(own);
    }
    let groups = stand_ins::list(raw)
        .and_then(|list| mapped_groups::groups(&root, list.as_ref(), &bin, &mut taken));
    // Few bytes that stand for much would be work without end for who reads it all.
    taken.sort_unstable_by_key(|range: &Range<usize>| range.start);
    if taken.windows(2).any(|two| two[0].end > two[1].start) {
        return Err(form("tables share their bytes").into());
    }
    Ok(Some(Listed { generator, meshes, groups }))
}

/// Why a file has no list.
#[derive(Debug)]
pub(crate) enum ListError {
    File(ErrorKind),
    Baked(BakedError),
}

impl From<ErrorKind> for ListError {
    fn from(kind: ErrorKind) -> Self {
        Self::File(kind)
    }
}

impl From<BakedError> for ListError {
    fn from(error: BakedError) -> Self {
        Self::Baked(error)
    }
}

fn mesh(
    root: &Root<'_>,
    number: u64,
    [bytes, sum]: [u64; 2],
    bin: &Range<usize>,
    taken: &mut Vec<Range<usize>>,
) -> ListedMesh {
    let mut out = ListedMesh {
        number: 0,
        name: String::new(),
        geometry: 0,
        bytes,
        sum,
        levels: Vec::new(),
        occluders: None,
        impostor: None,
        problem: None,
    };
    let mut read = || -> Result<(), BakedError> {
        let at = usize::try_from(number).unwrap_or(usize::MAX);
        let raw = root.meshes.as_ref().and_then(|all| all.get(at));
        let count = root.meshes.as_ref().map_or(0, Vec::len);
        let raw = raw.ok_or_else(|| form(format!("is mesh {number} of {count}")))?;
        let own: Extended<'_> = item(*raw)?;
        out.name = own.name.as_deref().map_or_else(String::new, shorten);
        let own = own
            .baked
            .ok_or_else(|| form("is in the table of chunks, but the mesh has nothing baked"))?;
        let MeshItem { geometry, levels, occluders, impostor } = item(own)?;
        if levels.len() > MOST_LEVELS {
            let count = levels.len();
            return Err(form(format!(
                "has {count} sets of levels; at most {MOST_LEVELS} are read"
            )));
        }
        out.geometry = baked_items::sum(&geometry)?;
        let listed = levels.iter().map(|one| levels_of(root, one, bin));
        let listed: Vec<ListedLevels> = listed.collect::<Result<_, _>>()?;
        let found = listed.iter().flat_map(|l| &l.tables).map(|range| range.len() as u64).sum();
        if found != bytes {
            let what = "bytes of its tables";
            return Err(BakedError::Count { what, found, expected: bytes });
        }
        taken.extend(listed.iter().flat_map(|l| l.tables.clone()));
        if let Some(OccludersItem { table, hash }) = occluders {
            out.occluders = Some(one_table(root, table, &hash, "its occluders", bin)?);
        }
        if let Some(ImpostorItem { atlas, hash, measured }) = impostor {
            let table = one_table(root, atlas, &hash, "its impostor", bin)?;
            let measured = impostor::seen(&measured)?;
            out.impostor = Some(ListedImpostor { measured, table });
        }
        taken.extend(out.occluders.iter().map(|t| t.bytes.clone()));
        taken.extend(out.impostor.iter().map(|i| i.table.bytes.clone()));
        out.levels = listed;
        Ok(())
    };
    out.problem = read().err();
    out
}

fn one_table(
    root: &Root<'_>,
    view: Index,
    hash: &str,
    what: &'static str,
    bin: &Range<usize>,
) -> Result<ListedTable, BakedError> {
    let bytes = aligned(root, view, what, bin)?;
    Ok(ListedTable { bytes, sum: baked_items::sum(hash)? })
}

fn levels_of(
    root: &Root<'_>,
    item: &LevelsItem<'_>,
    bin: &Range<usize>,
) -> Result<ListedLevels, BakedError> {
    let kind = LevelKind::of(&item.kind);
    let kind = kind.ok_or_else(|| form(format!("levels of kind {:?}", shorten(&item.kind))))?;
    let parts: Result<Vec<u32>, _> = item.parts.iter().map(|n| u32::try_from(n.0)).collect();
    let parts = parts.map_err(|_| form("a part has more than 2^32 triangles"))?;
    let tables = level_tables(root, [item.indices, item.clusters, item.groups], &parts, bin)?;
    let errors = item.errors.as_ref().map(|all| all.map(|e| e as f32));
    Ok(ListedLevels {
        kind,
        parts,
        errors,
        measured: baked_items::measured(&item.measured)?,
        tables,
    })
}
