//! Writes the baked data of the meshes of a GLB.

use serde_json::{Value, json};

use super::buffer::File;
use super::stand_ins;
use crate::Model;
use crate::baked::{
    BakedLevels, BakedMesh, LevelKind, LevelTables, Measured, VERSION, geometry_hash, occluder_sum,
    root_sum, sum_of,
};

/// The extension's objects.
pub(super) struct Written {
    /// Extension object of the root.
    pub(super) root: Value,
    /// Extension objects of meshes, with the meshes' numbers in the file.
    pub(super) meshes: Vec<(usize, Value)>,
}

/// Puts the tables of what was baked of the meshes that are written into the file; the extension's
/// objects, if there is anything. `number` is that of each mesh in the file. Levels of a mesh that
/// was changed since are left out.
///
/// All tables are put in here, one after another, so that they can be told from the rest of the
/// file and taken out again.
pub(super) fn write(model: &Model, number: &[Option<usize>], file: &mut File) -> Option<Written> {
    let baked = model.baked.as_ref()?;
    let first = file.view_count();
    let (mut chunks, mut meshes) = (Vec::new(), Vec::new());
    for one in &baked.meshes {
        let written = number.get(one.mesh as usize).copied().flatten();
        let any = !one.levels.is_empty() || one.occluders.is_some();
        let Some(at) = written.filter(|_| any) else { continue };
        let base = &model.scene.meshes()[one.mesh as usize];
        if geometry_hash(base) == one.geometry
            && let Some((object, [bytes, sum])) = mesh(model, one, file)
        {
            meshes.push((at, object));
            chunks.push([at as u64, bytes, sum]);
        }
    }
    let stand_ins = stand_ins::write(model, number, file);
    if chunks.is_empty() && stand_ins.is_none() {
        return None;
    }
    chunks.sort_unstable();
    let rows = chunks
        .iter()
        .map(|&[mesh, bytes, sum]| json!({ "mesh": mesh, "bytes": bytes, "hash": digits(sum) }));
    let rows: Vec<Value> = rows.collect();
    let own = concat!("cullet-io ", env!("CARGO_PKG_VERSION"));
    let generator = if baked.generator.is_empty() { own } else { &baked.generator };
    let hash = digits(root_sum(&chunks));
    let count = file.view_count() - first;
    let mut root = json!({
        "version": VERSION,
        "generator": generator,
        "hash": hash,
        "chunks": rows,
        "bufferViews": { "first": first, "count": count },
    });
    if let Some(stand_ins) = stand_ins {
        root["standIns"] = stand_ins;
        root["standIns"]["measured"] = measured(&baked.stand_ins.unwrap_or_default());
    }
    Some(Written { root, meshes })
}

/// The extension's object of a mesh, the bytes of its tables, and the sum of it all.
fn mesh(model: &Model, one: &BakedMesh, file: &mut File) -> Option<(Value, [u64; 2])> {
    let base = &model.scene.meshes()[one.mesh as usize];
    let all = model.scene.levels(one.mesh);
    let mut tables = Vec::new();
    for levels in one.levels.iter().filter(|levels| levels.kind != LevelKind::Impostor) {
        let of = all.iter().find(|of| of.mesh == levels.held_by)?;
        let mut made = LevelTables::of(model.scene.meshes().get(of.mesh as usize)?, &of.levels)?;
        // A view of nothing is forbidden, and levels without groups are none.
        if made.groups.is_empty() || made.indices.is_empty() {
            return None;
        }
        // Parts without triangles are not written, and no level has any of theirs.
        let mut counts = made.parts.iter();
        let mut parts = Vec::new();
        for part in base.parts() {
            let &count = counts.next()?;
            if part.triangle_count > 0 {
                parts.push(count);
            } else if count > 0 {
                return None;
            }
        }
        made.parts = parts;
        tables.push((levels, made));
    }
    let bytes: Vec<[Vec<u8>; 3]> = tables.iter().map(|(_, made)| made.to_bytes()).collect();
    let rows = tables.iter().zip(&bytes).map(|((of, made), bytes)| {
        (of.kind, &of.measured, &made.parts[..], bytes.each_ref().map(Vec::as_slice))
    });
    let sum = sum_of(one.geometry, rows);
    let count = bytes.as_flattened().iter().map(|b| b.len() as u64).sum();
    let levels = tables.iter().zip(&bytes).map(|((of, made), bytes)| levels(of, made, bytes, file));
    let levels: Vec<Value> = levels.collect();
    let mut object = json!({ "geometry": digits(one.geometry) });
    // As everywhere in glTF, lists are left out rather than empty.
    if !levels.is_empty() {
        object["levels"] = json!(levels);
    }
    if let Some(occluders) = &one.occluders {
        let bytes = occluders.to_bytes();
        let hash = digits(occluder_sum(one.geometry, &bytes));
        object["occluders"] = json!({ "table": file.table(&bytes), "hash": hash });
    }
    if let Some(impostor) = super::impostor::write(model, one, file) {
        object["impostor"] = impostor;
    }
    Some((object, [count, sum]))
}

fn levels(of: &BakedLevels, made: &LevelTables, bytes: &[Vec<u8>; 3], file: &mut File) -> Value {
    let [indices, clusters, groups] = bytes.each_ref().map(|bytes| file.table(bytes));
    let errors = made.groups.iter().map(|g| g.error);
    let least = errors.clone().fold(f32::INFINITY, f32::min);
    json!({
        "kind": of.kind.name(),
        "parts": made.parts,
        "indices": indices,
        "clusters": clusters,
        "groups": groups,
        "errors": [least, errors.fold(0.0, f32::max)],
        "measured": measured(&of.measured),
    })
}

/// How errors were found.
fn measured(of: &Measured) -> Value {
    let Measured { points, reverse_points, quantile, most_over, seed } = of;
    json!({
        "points": points, "reversePoints": reverse_points, "quantile": quantile,
        "mostOver": most_over, "seed": seed,
    })
}

fn digits(sum: u64) -> String {
    format!("{sum:016x}")
}
