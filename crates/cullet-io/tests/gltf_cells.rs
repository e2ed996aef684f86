//! Cells and portals in glTF: what is written comes back, fits the schema, and what is wrong is named.

use crate::schema;

use cullet::Scene;
use cullet_io::{LoadOptions, Model, Up, load, load_bytes, save};
use cullet_testkit::Folder;
use schema::held;
use serde_json::{Value, json};

const NAME: &str = "CULLET_cells_portals";

/// The JSON of a GLB.
fn json_of(bytes: &[u8]) -> Value {
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&bytes[20..20 + length]).unwrap()
}

/// Where the doors are.
fn doors(model: &Model) -> Vec<Option<[f64; 3]>> {
    let place = |scene: &Scene, door| scene.transform(scene.slot(door).unwrap()).translation;
    let portals = model.cells.portals.iter();
    portals.map(|p| p.door.map(|door| place(&model.scene, door))).collect()
}

#[test]
fn cells_of_the_office_come_back_from_a_glb() {
    let folder = Folder::new("cells");
    let mut model = cullet_scenes::build("office:floors=2,corridors=1,rooms=3,closed=50").unwrap();
    model.cells.portals[1].one_way = true;
    model.cells.portals[2].name = "the second door".into();
    let [a, b, c, d]: [_; 4] = model.cells.portals[0].polygon.clone().try_into().unwrap();
    let cell = model.cells.portals[0].cells[0];
    let mirror = cullet_io::Mirror { name: "glass".into(), cell, polygon: vec![a, b, c, d] };
    model.cells.mirrors.push(mirror);
    let skin = cullet_io::Cell::from_box("", [-1.0, 0.0, -1.0], [-0.5, 3.0, 9.0]).pieces;
    model.cells.cells[1].skins.clone_from(&skin);
    let path = folder.root().join("office.glb");
    save(&model, &path).unwrap();
    let back = load(&path, &LoadOptions::default()).unwrap();
    assert!(back.warnings.is_empty(), "{:?}", back.warnings);
    assert_eq!(doors(&back), doors(&model));
    assert!(doors(&back).iter().filter(|d| d.is_some()).count() > 5);
    let mut cells = back.cells.clone();
    for (portal, of) in cells.portals.iter_mut().zip(&model.cells.portals) {
        portal.door = of.door;
    }
    assert_eq!(cells, model.cells);
    let graph = back.in_cells().graph().expect("the scene culls by them");
    assert_eq!(graph.cell_count() as usize, model.cells.cells.len());
    assert!(graph.is_one_way(1) && graph.mirrors().len() == 1);
    // Once more, where nodes are those of the file.
    let again = folder.root().join("again.glb");
    save(&back, &again).unwrap();
    let third = load(&again, &LoadOptions::default()).unwrap();
    assert_eq!((doors(&third), &third.cells.cells), (doors(&back), &back.cells.cells));
    let root = json_of(&std::fs::read(&path).unwrap());
    assert_eq!(root["extensionsUsed"], json!([NAME]));
    let found = held(&schema(), &root["extensions"][NAME], "");
    assert!(found.is_empty(), "{found:?}");
}

fn schema() -> Value {
    schema::of(NAME)
}

/// Two rooms and the door between them.
fn rooms() -> Value {
    json!({
        "cells": [
            { "name": "a", "pieces": [{ "box": [[0, 0, 0], [4, 3, 4]] }], "skin": [{ "box": [[-1, 0, 0], [0, 3, 4]] }] },
            { "name": "b", "pieces": [{ "planes": [
                [1, 0, 0, 8], [-1, 0, 0, -4], [0, 1, 0, 3], [0, -1, 0, 0], [0, 0, 1, 4], [0, 0, -1, 0],
            ] }] },
        ],
        "portals": [{
            "cells": [0, 1], "polygon": [[4, 0, 1], [4, 0, 2], [4, 2, 2], [4, 2, 1]], "node": 1,
        }],
    })
}

/// Loads a document with this extension.
fn loaded(extension: &Value, options: &LoadOptions) -> Result<Model, String> {
    let document = json!({
        "asset": { "version": "2.0" },
        "extensionsRequired": [NAME],
        "nodes": [{}, {}],
        "extensions": { NAME: extension },
    });
    load_bytes("a.gltf", document.to_string().as_bytes(), options).map_err(|e| e.to_string())
}

#[test]
fn a_document_by_hand_is_read_and_turned_with_its_scene() {
    assert!(held(&schema(), &rooms(), "").is_empty());
    let model = loaded(&rooms(), &LoadOptions::default()).unwrap();
    let at = |model: &Model, p| model.in_cells().cell_of(p);
    assert_eq!([at(&model, [1.0; 3]), at(&model, [5.0, 1.0, 1.0])], [Some(0), Some(1)]);
    assert_eq!(at(&model, [-0.5, 1.0, 1.0]), None, "no eye is in a skin");
    // The node draws nothing, so there is no door.
    assert_eq!(model.cells.portals[0].door, None);
    let up = LoadOptions { up: Some(Up::Z), ..LoadOptions::default() };
    let turned = loaded(&rooms(), &up).unwrap();
    // (x, y, z) becomes (x, z, −y).
    assert_eq!(at(&turned, [5.0, 1.0, -2.5]), Some(1));
    assert_eq!(at(&turned, [5.0, 2.5, 1.0]), None);
    assert_eq!(turned.cells.portals[0].polygon[2], [4.0, 2.0, -2.0]);
}

#[test]
fn each_fault_names_the_extension_the_item_and_the_value() {
    let with = |pointer: &str, value: Value| {
        let mut extension = rooms();
        match extension.pointer_mut(pointer) {
            Some(at) => *at = value,
            None => extension[&pointer[1..]] = value,
        }
        loaded(&extension, &LoadOptions::default()).map(drop).unwrap_err()
    };
    let cases = [
        ("/portals/0/cells/1", json!(2), "portal 0: names cell 2 of 2"),
        ("/portals/0/cells/1", json!(-1), "portal 0: invalid type: integer `-1`"),
        ("/portals/0/cells/1", json!(0), "portal 0: joins cell 0 with itself"),
        ("/portals/0/cells", json!([0]), "portal 0: invalid length 1"),
        ("/portals/0/node", json!(2), "portal 0: names node 2 of 2"),
        ("/portals/0/polygon/1", json!([4.5, 0, 2]), "portal 0: is not planar: corner"),
        ("/portals/0/polygon/2", json!([4, 0.5, 1.2]), "portal 0: is not convex: corner"),
        ("/portals/0/polygon", json!([[4, 0, 1]]), "portal 0: has 1 corners"),
        ("/portals/0/cells", json!([1, 0]), "wrong order"),
        ("/portals/0", json!(7), "portal 0: expected an object, found 7"),
        ("/cells", json!([]), "it has portals or mirrors, but no cells"),
        (
            "/cells/1/pieces/0/planes/0",
            json!([0, 0, 0, 1]),
            "cell 1, piece 0: has a plane that is none",
        ),
        ("/cells/1/pieces/0/planes/0", json!([1, 0, 0, 3]), "cell 1, piece 0: has no volume"),
        ("/cells/1/pieces/0/planes", json!([[1, 0, 0, 1]]), "cell 1, piece 0: is not closed"),
        ("/cells/1/pieces/0", json!({}), "cell 1, piece 0: has neither a box and planes"),
        ("/cells/1/pieces", json!([]), "portal 0: is not on the border of cell 1"),
        ("/walls", json!(-1), "its walls are -1 thick"),
        ("/mirrors", json!([{ "cell": 5, "polygon": [] }]), "mirror 0: names cell 5 of 2"),
        ("/mirrors", json!([{ "cell": 1 }]), "mirror 0: missing field `polygon`"),
    ];
    for (pointer, value, message) in cases {
        let error = with(pointer, value);
        assert!(error.starts_with(&format!("a.gltf: {NAME}")), "{pointer}: {error}");
        assert!(error.contains(message), "{pointer}: {error}");
    }
    let not_finite = rooms().to_string().replacen("[4,2,2]", "[4,1e999,2]", 1);
    let document = format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[{{}},{{}}],"extensions":{{"{NAME}":{not_finite}}}}}"#
    );
    let error = load_bytes("a.gltf", document.as_bytes(), &LoadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("portal 0: has a corner that is not finite: number 2"));
}

#[test]
fn a_great_many_portals_are_read() {
    let count = 100_000;
    let mut extension = rooms();
    extension["portals"] = vec![extension["portals"][0].clone(); count].into();
    let model = loaded(&extension, &LoadOptions::default()).unwrap();
    assert_eq!(model.in_cells().graph().unwrap().portals().len(), count);
    extension["portals"][count - 1]["cells"][1] = json!(99);
    let error = loaded(&extension, &LoadOptions::default()).map(drop).unwrap_err();
    assert!(error.contains("portal 99999: names cell 99 of 2"), "{error}");
}
