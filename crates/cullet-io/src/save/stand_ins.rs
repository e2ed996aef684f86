//! Instances that stand for others, beside what was baked of meshes.

use serde_json::{Value, json};

use super::buffer::File;
use crate::Model;
use crate::baked::{StandInTables, attribute_sum, sum_of_stand_ins};

/// The object of all, if there are any, without how they were measured; `number` is that of each
/// mesh that is written.
pub(super) fn write(model: &Model, number: &[Option<usize>], file: &mut File) -> Option<Value> {
    let scene = &model.scene;
    let written = |slot: u32| {
        let has_mesh = number.get(scene.mesh_id(slot) as usize).copied().flatten().is_some();
        has_mesh && scene.transform(slot).is_finite()
    };
    let all = StandInTables::all_of(scene, &model.attributes, written);
    if all.is_empty() {
        return None;
    }
    let bytes: Vec<[Vec<u8>; 4]> = all.iter().map(StandInTables::to_bytes).collect();
    let rows: Vec<_> = all
        .iter()
        .zip(&bytes)
        .map(|(one, bytes)| (one, bytes.each_ref().map(Vec::as_slice)))
        .collect();
    let hash = format!("{:016x}", sum_of_stand_ins(&rows));
    let items = all.iter().zip(&bytes).map(|(one, bytes)| {
        let [positions, indices, clusters, groups] =
            bytes.each_ref().map(|bytes| file.table(bytes));
        let mut object = json!({
            "origin": one.origin,
            "instances": one.instances,
            "standIns": one.stand_ins,
            "like": one.like,
            "triangles": one.triangles,
            "parts": one.levels.parts,
            "positions": positions,
            "indices": indices,
            "clusters": clusters,
            "groups": groups,
        });
        if !one.attributes.is_empty() {
            object["attributes"] = attributes(one, file);
        }
        object
    });
    let items: Vec<Value> = items.collect();
    Some(json!({ "hash": hash, "all": items }))
}

/// Attributes of the vertices of one that has some, under a sum of their own: older readers pass
/// over them.
fn attributes(one: &StandInTables, file: &mut File) -> Value {
    let bytes = one.attributes_to_bytes();
    let hash = format!("{:016x}", attribute_sum(bytes.each_ref().map(Vec::as_slice)));
    let mut object = json!({ "hash": hash });
    for (name, bytes) in ["uvs", "colors"].into_iter().zip(&bytes) {
        if !bytes.is_empty() {
            object[name] = json!(file.table(bytes));
        }
    }
    object
}
