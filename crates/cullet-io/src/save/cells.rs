//! Cells and portals of a GLB.

use std::collections::HashMap;

use serde_json::{Map, Value, json};

use crate::cells::{CellGraph, box_planes};

/// The extension's object, as the reader has it. `node_of` has the node of each instance that is
/// written, by the index of its handle.
pub(super) fn extension(cells: &CellGraph, node_of: &HashMap<u32, usize>) -> Value {
    let mut out = Map::new();
    let named = |name: &str| {
        let mut item = Map::new();
        if !name.is_empty() {
            item.insert("name".into(), json!(name));
        }
        item
    };
    let list = cells.cells.iter().map(|cell| {
        let mut item = named(&cell.name);
        for (member, pieces) in [("pieces", &cell.pieces), ("skin", &cell.skins)] {
            if !pieces.is_empty() {
                let pieces: Vec<Value> = pieces.iter().map(|planes| piece(planes)).collect();
                item.insert(member.into(), pieces.into());
            }
        }
        Value::Object(item)
    });
    out.insert("cells".into(), list.collect());
    let list: Vec<Value> = cells
        .portals
        .iter()
        .map(|portal| {
            let mut item = named(&portal.name);
            item.insert("cells".into(), json!(portal.cells));
            item.insert("polygon".into(), json!(portal.polygon));
            if portal.closed {
                item.insert("open".into(), json!(false));
            }
            if portal.one_way {
                item.insert("oneWay".into(), json!(true));
            }
            if let Some(node) = portal.door.and_then(|door| node_of.get(&door.index)) {
                item.insert("node".into(), json!(node));
            }
            Value::Object(item)
        })
        .collect();
    // As everywhere in glTF, lists are left out rather than empty.
    if !list.is_empty() {
        out.insert("portals".into(), list.into());
    }
    let list: Vec<Value> = cells
        .mirrors
        .iter()
        .map(|mirror| {
            let mut item = named(&mirror.name);
            item.insert("cell".into(), json!(mirror.cell));
            item.insert("polygon".into(), json!(mirror.polygon));
            Value::Object(item)
        })
        .collect();
    if !list.is_empty() {
        out.insert("mirrors".into(), list.into());
    }
    if cells.walls > 0.0 {
        out.insert("walls".into(), json!(cells.walls));
    }
    if cells.sealed {
        out.insert("sealed".into(), json!(true));
    }
    Value::Object(out)
}

/// A piece: two corners of what is a box along the axes, else its planes.
fn piece(planes: &[[f64; 4]]) -> Value {
    if let [low_x, high_x, low_y, high_y, low_z, high_z] = planes {
        let min = [-low_x[3], -low_y[3], -low_z[3]];
        let max = [high_x[3], high_y[3], high_z[3]];
        if box_planes(min, max) == planes {
            return json!({ "box": [min, max] });
        }
    }
    json!({ "planes": planes })
}
