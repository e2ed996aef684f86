//! `CULLET_baked`: what was baked of meshes. What each member means is in the book's page on
//! baking, and in `docs/schema/CULLET_baked.schema.json`.
//!
//! Nothing here is an error of the file, for the plain mesh beside is right whatever this says:
//! what is damaged, of another version or of another mesh is left out with a warning.

use std::borrow::Cow;
use std::collections::HashMap;

use super::baked_items::{MeasuredItem, NAME, check, form, item, measured, sum, table};
use super::buffers::Buffers;
use super::impostor::ImpostorItem;
use super::json::{Index, Integer, Root};
use super::notes::Notes;
use super::stand_ins;
use super::uri::shorten;
use crate::Attributes;
use crate::baked::{
    Baked, BakedError, BakedLevels, BakedMesh, LevelKind, LevelTables, MOST_LEVELS, Measured,
    Occluders, StandInTables, VERSION, geometry_hash_of, occluder_sum, root_sum, sum_of,
};
use crate::from_json;
use crate::json::{FromJson, Json, Object};
use cullet::{MeshData, Scene};
use cullet_mesh::Impostor;

from_json! {
    /// The fields of a mesh that are read here.
    pub(super) struct Extended<'a> {
        name: Option<Cow<'a, str>> = get("name"),
        baked: Option<Json<'a>> = extension(NAME),
    }

    /// Its version, which is read before all else.
    struct VersionItem {
        version: Integer = need("version"),
    }

    struct RootItem<'a> {
        generator: Option<Cow<'a, str>> = get("generator"),
        hash: Cow<'a, str> = need("hash"),
        chunks: Vec<ChunkItem<'a>> = need("chunks"),
    }

    struct ChunkItem<'a> {
        mesh: Index = need("mesh"),
        bytes: Integer = need("bytes"),
        hash: Cow<'a, str> = need("hash"),
    }

    pub(super) struct MeshItem<'a> {
        geometry: Cow<'a, str> = need("geometry"),
        levels: Vec<LevelsItem<'a>> = or_default("levels"),
        occluders: Option<OccludersItem<'a>> = get("occluders"),
        impostor: Option<ImpostorItem<'a>> = get("impostor"),
    }

    pub(super) struct OccludersItem<'a> {
        table: Index = need("table"),
        hash: Cow<'a, str> = need("hash"),
    }

    pub(super) struct LevelsItem<'a> {
        kind: Cow<'a, str> = need("kind"),
        parts: Vec<Integer> = need("parts"),
        indices: Index = need("indices"),
        clusters: Index = need("clusters"),
        groups: Index = need("groups"),
        /// For people, and for who looks at the list alone.
        errors: Option<[f64; 2]> = get("errors"),
        measured: MeasuredItem = need("measured"),
    }
}

/// The extension's object at the root of a document, if there is one.
pub(super) fn of_root<'a>(root: &Root<'a>) -> Option<Json<'a>> {
    Object::from_json(root.extensions?).ok()?.get(NAME).ok()?
}

/// Baked data of a file, free of the file's bytes; levels are not made yet.
#[derive(Debug, Default)]
pub(super) struct Found {
    generator: String,
    meshes: Vec<FoundMesh>,
    stand_ins: Option<(Measured, Vec<StandInTables>)>,
    problem: Option<BakedError>,
}

#[derive(Debug, Default)]
struct FoundMesh {
    mesh: BakedMesh,
    levels: Vec<(LevelKind, Measured, LevelTables)>,
    impostor: Option<(Measured, Impostor)>,
}

/// Reads what is baked of the meshes that are drawn: `drawn` has the file's number of each, `data`
/// what was decoded of it.
pub(super) fn read(
    root: &Root<'_>,
    buffers: &Buffers<'_>,
    drawn: &[u32],
    data: &[(String, MeshData)],
    details: bool,
    notes: &mut Notes,
) -> Option<Found> {
    let raw = of_root(root)?;
    let (generator, chunks) = match head(raw) {
        Ok(found) => found,
        Err(problem) => {
            notes.push(NAME, format!("{problem}; levels are left out"));
            return Some(Found { problem: Some(problem), ..Found::default() });
        }
    };
    let mut found = Found { generator, ..Found::default() };
    // Each view is of one table, so that no few bytes can stand for many levels.
    let mut left: usize = buffers.views.iter().map(super::buffers::View::len).sum();
    for (number, &file_mesh) in drawn.iter().enumerate() {
        let (name, data) = &data[number];
        if data.deformable {
            continue;
        }
        let raw = root.meshes.as_ref().and_then(|all| all.get(file_mesh as usize));
        let own = raw.and_then(|raw| Extended::from_json(*raw).ok()?.baked);
        let chunk = chunks.get(&u64::from(file_mesh));
        let read = match (own, chunk) {
            (None, None) => continue,
            (Some(own), Some(chunk)) => mesh(own, *chunk, data, buffers, &mut left),
            (None, Some(_)) => {
                Err(form("is in the table of chunks, but the mesh has nothing baked"))
            }
            (Some(_), None) => Err(form("is not in the table of chunks")),
        };
        let mut one = read.unwrap_or_else(|problem| {
            notes.push(name, format!("{NAME}: {problem}; its levels are left out"));
            let mesh = BakedMesh { problem: Some(problem), ..BakedMesh::default() };
            FoundMesh { mesh, ..FoundMesh::default() }
        });
        one.mesh.mesh = number as u32;
        found.meshes.push(one);
    }
    match stand_ins::read(raw, buffers, details, &mut left) {
        Ok(all) => found.stand_ins = all,
        Err(problem) => notes.push(NAME, format!("{problem}; merged groups are left out")),
    }
    Some(found)
}

/// The generator and the chunks, by the number of their mesh: bytes and sum.
pub(super) fn head(raw: Json<'_>) -> Result<(String, HashMap<u64, [u64; 2]>), BakedError> {
    let VersionItem { version } = item(raw)?;
    if version.0 != u64::from(VERSION) {
        return Err(BakedError::Version { found: version.0 });
    }
    let RootItem { generator, hash, chunks } = item(raw)?;
    let mut rows = Vec::with_capacity(chunks.len());
    for chunk in &chunks {
        rows.push([chunk.mesh.0, chunk.bytes.0, sum(&chunk.hash)?]);
    }
    check("its table of chunks", root_sum(&rows), sum(&hash)?)?;
    let generator = generator.map_or_else(String::new, |name| shorten(&name));
    Ok((generator, rows.into_iter().map(|[mesh, bytes, sum]| (mesh, [bytes, sum])).collect()))
}

/// Reads the baked data of a mesh. `left` is the number of bytes that tables may still take.
fn mesh(
    raw: Json<'_>,
    [bytes, expected]: [u64; 2],
    data: &MeshData,
    buffers: &Buffers<'_>,
    left: &mut usize,
) -> Result<FoundMesh, BakedError> {
    let MeshItem { geometry, levels, occluders, impostor } = item(raw)?;
    if levels.len() > MOST_LEVELS {
        return Err(form(format!(
            "has {} sets of levels; at most {MOST_LEVELS} are read",
            levels.len()
        )));
    }
    let geometry = sum(&geometry)?;
    let found = geometry_hash_of(data);
    if found != geometry {
        return Err(BakedError::Geometry { found, expected: geometry });
    }
    let mut tables = Vec::with_capacity(levels.len());
    let mut taken = 0;
    for levels in &levels {
        let kind = LevelKind::of(&levels.kind);
        let kind =
            kind.ok_or_else(|| form(format!("levels of kind {:?}", shorten(&levels.kind))))?;
        let views = [levels.indices, levels.clusters, levels.groups];
        let mut bytes: [&[u8]; 3] = [&[]; 3];
        for (bytes, view) in bytes.iter_mut().zip(views) {
            *bytes = table(buffers, view, left)?;
            taken += bytes.len() as u64;
        }
        let parts = levels.parts.iter().map(|n| u32::try_from(n.0));
        let parts: Result<Vec<u32>, _> = parts.collect();
        let parts = parts.map_err(|_| form("a part has more than 2^32 triangles"))?;
        tables.push((kind, measured(&levels.measured)?, parts, bytes));
    }
    let own = sum_of(
        geometry,
        tables.iter().map(|(kind, m, parts, bytes)| (*kind, m, &parts[..], *bytes)),
    );
    check("what is baked of it", own, expected)?;
    if taken != bytes {
        return Err(BakedError::Count {
            what: "bytes of its tables",
            found: taken,
            expected: bytes,
        });
    }
    let mut out = FoundMesh {
        mesh: BakedMesh { geometry, bytes, ..BakedMesh::default() },
        levels: Vec::with_capacity(tables.len()),
        impostor: None,
    };
    if let Some(OccludersItem { table: view, hash }) = occluders {
        let bytes = table(buffers, view, left)?;
        check("its occluders", occluder_sum(geometry, bytes), sum(&hash)?)?;
        out.mesh.occluders = Some(Occluders::from_bytes(bytes)?);
    }
    if let Some(item) = impostor {
        let (measured, impostor, bytes) = super::impostor::read(&item, geometry, buffers, left)?;
        out.mesh.bytes += bytes;
        out.impostor = Some((measured, impostor));
    }
    for (kind, measured, parts, bytes) in tables {
        out.levels.push((kind, measured, LevelTables::from_bytes(parts, bytes)?));
    }
    Ok(out)
}

impl Found {
    /// The same without the impostors.
    pub(super) fn without_impostors(mut self) -> Self {
        self.meshes.iter_mut().for_each(|one| one.impostor = None);
        self
    }

    /// Makes the levels and gives them to the scene, whose meshes are those that were read; the
    /// meshes that hold them come after all others.
    pub(super) fn give(
        self,
        scene: &mut Scene,
        names: &mut Vec<String>,
        attributes: &mut Vec<Attributes>,
        notes: &mut Notes,
    ) -> Baked {
        let mut baked =
            Baked { generator: self.generator, problem: self.problem, ..Baked::default() };
        for FoundMesh { mesh: mut one, levels, impostor } in self.meshes {
            let base = one.mesh;
            let own = names.get(base as usize).cloned().unwrap_or_default();
            for (kind, measured, tables) in levels {
                let made =
                    tables.build(&scene.meshes()[base as usize]).and_then(|(mesh, levels)| {
                        let held_by = scene.add_mesh(mesh);
                        names.push(format!("{own}, {}", kind.name()));
                        scene.add_levels(base, held_by, levels)?;
                        Ok(held_by)
                    });
                match made {
                    Ok(held_by) => one.levels.push(BakedLevels { kind, held_by, measured }),
                    Err(problem) => {
                        notes.push(&own, format!("{NAME}: {}: {problem}; left out", kind.name()));
                        one.problem = Some(problem);
                    }
                }
            }
            if let Some((measured, impostor)) = impostor {
                match impostor.add_to(scene, base) {
                    Ok(held_by) => {
                        let kind = LevelKind::Impostor;
                        names.push(format!("{own}, {}", kind.name()));
                        one.levels.push(BakedLevels { kind, held_by, measured });
                    }
                    Err(problem) => {
                        notes.push(&own, format!("{NAME}: impostor: {problem}; left out"));
                        one.problem = Some(problem.into());
                    }
                }
            }
            baked.meshes.push(one);
        }
        if let Some((measured, all)) = self.stand_ins {
            match StandInTables::give(all, scene, names, attributes) {
                Ok(()) => baked.stand_ins = Some(measured),
                Err(problem) => {
                    notes.push(NAME, format!("{problem}; merged groups are left out"));
                }
            }
            scene.sort();
        }
        baked
    }
}
