//! What was baked of the meshes of a GLB.

use serde_json::{Value, json};

use super::buffer::File;
use crate::Model;
use crate::baked::{
    BakedLevels, BakedMesh, LevelKind, LevelTables, Measured, VERSION, geometry_hash, root_sum,
    sum_of,
};
use crate::gltf::BAKED;

/// Puts what was baked of the meshes that are written beside them; the extension's object of the root, if there is anything.
/// `number` is that of each mesh in the file. Levels of a mesh that was changed since are left out.
pub(super) fn write(
    model: &Model,
    number: &[Option<usize>],
    file: &mut File,
    meshes: &mut [Value],
) -> Option<Value> {
    let baked = model.baked.as_ref()?;
    let mut chunks = Vec::new();
    for one in &baked.meshes {
        let written = number.get(one.mesh as usize).copied().flatten();
        let Some(at) = written.filter(|_| !one.levels.is_empty()) else { continue };
        let base = &model.scene.meshes()[one.mesh as usize];
        if geometry_hash(base) == one.geometry
            && let Some((object, [bytes, sum])) = mesh(model, one, file)
        {
            meshes[at]["extensions"] = json!({ BAKED: object });
            chunks.push([at as u64, bytes, sum]);
        }
    }
    if chunks.is_empty() {
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
    Some(json!({ "version": VERSION, "generator": generator, "hash": hash, "chunks": rows }))
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
    let mut object = json!({ "geometry": digits(one.geometry), "levels": levels });
    if let Some(impostor) = super::impostor::write(model, one, file) {
        object["impostor"] = impostor;
    }
    Some((object, [count, sum]))
}

fn levels(of: &BakedLevels, made: &LevelTables, bytes: &[Vec<u8>; 3], file: &mut File) -> Value {
    let [indices, clusters, groups] = bytes.each_ref().map(|bytes| file.table(bytes));
    let errors = made.groups.iter().map(|g| g.error);
    let least = errors.clone().fold(f32::INFINITY, f32::min);
    let Measured { points, reverse_points, quantile, most_over, seed } = of.measured;
    json!({
        "kind": of.kind.name(),
        "parts": made.parts,
        "indices": indices,
        "clusters": clusters,
        "groups": groups,
        "errors": [least, errors.fold(0.0, f32::max)],
        "measured": {
            "points": points, "reversePoints": reverse_points, "quantile": quantile,
            "mostOver": most_over, "seed": seed,
        },
    })
}

fn digits(sum: u64) -> String {
    format!("{sum:016x}")
}
