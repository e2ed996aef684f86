//! Cells from the volumes of rooms: a house in which nothing in sight is dropped, and what is in other rooms is.

use cullet::{Culler, Stage, View, ViewState};
use cullet_bake::room_volumes::{RoomCells, RoomOptions, cells_of_rooms};
use cullet_draw::{VerifyOptions, verify};
use cullet_io::{LoadOptions, Model, load, load_bytes};
use cullet_testkit::data;

/// A box of an OBJ, with `count` corners before it: its sides, seen from outside.
fn solid(name: &str, low: [f64; 3], high: [f64; 3], count: &mut usize) -> String {
    let mut text = format!("o {name}\n");
    for corner in 0..8 {
        let at = |k: usize| if corner >> k & 1 == 1 { high[k] } else { low[k] };
        text += &format!("v {} {} {}\n", at(0), at(1), at(2));
    }
    for face in [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
    {
        let [a, b, c, d] = face.map(|corner| corner + *count + 1);
        text += &format!("f {a} {b} {c} {d}\n");
    }
    *count += 8;
    text
}

fn model(solids: &[(&str, [f64; 3], [f64; 3])]) -> Model {
    let mut count = 0;
    let text: String =
        solids.iter().map(|(name, low, high)| solid(name, *low, *high, &mut count)).collect();
    load_bytes("a.obj", text.as_bytes(), &LoadOptions::default()).unwrap()
}

/// Two rooms of 4 × 3 × 4 with a wall of 0.2 between them that has a door in it, all closed but for that; and a window in
/// the second.
fn house() -> (Model, Model) {
    let slab = |y: f64| ([-0.2, y, -0.2], [8.4, y + 0.2, 4.2]);
    let (floor, ceiling) = (slab(-0.2), slab(3.0));
    let building = model(&[
        ("floor", floor.0, floor.1),
        ("ceiling", ceiling.0, ceiling.1),
        ("south", [-0.2, 0.0, -0.2], [8.4, 3.0, 0.0]),
        ("north", [-0.2, 0.0, 4.0], [8.4, 3.0, 4.2]),
        ("west", [-0.2, 0.0, 0.0], [0.0, 3.0, 4.0]),
        ("east below", [8.2, 0.0, 0.0], [8.4, 1.0, 4.0]),
        ("east above", [8.2, 2.0, 0.0], [8.4, 3.0, 4.0]),
        ("IfcWindow 1", [8.25, 1.0, 0.0], [8.3, 2.0, 4.0]),
        ("wall left", [4.0, 0.0, 0.0], [4.2, 3.0, 1.0]),
        ("wall right", [4.0, 0.0, 2.0], [4.2, 3.0, 4.0]),
        ("wall above", [4.0, 2.0, 1.0], [4.2, 3.0, 2.0]),
        ("IfcDoor 1", [4.08, 0.0, 1.0], [4.12, 2.0, 2.0]),
    ]);
    let rooms = model(&[
        ("first", [0.0, 0.0, 0.0], [4.0, 3.0, 4.0]),
        ("second", [4.2, 0.0, 0.0], [8.2, 3.0, 4.0]),
    ]);
    (building, rooms)
}

#[test]
fn doors_lead_to_the_next_room_and_windows_to_the_outside() {
    let (building, rooms) = house();
    let RoomCells { cells, warnings } = cells_of_rooms(&building, &rooms, &RoomOptions::default());
    assert!(warnings.is_empty(), "{warnings:?}");
    let names: Vec<&str> = cells.cells.iter().map(|cell| cell.name.as_str()).collect();
    assert_eq!(names, ["first", "second", "outside"]);
    // One portal of the door from either side, and one of the window.
    let mut joined: Vec<[u32; 2]> = cells.portals.iter().map(|portal| portal.cells).collect();
    joined.sort_unstable();
    assert_eq!(joined, [[0, 1], [1, 0], [1, 2]]);
    let door = &cells.portals.iter().find(|portal| portal.cells == [0, 1]).unwrap().polygon;
    for p in door {
        // Around the hole, by a step at the most.
        assert!((p[0] - 4.0).abs() < 1e-6, "{p:?}");
        let off = |v: f64, [low, high]: [f64; 2]| (v - low).abs().min((v - high).abs());
        assert!(off(p[2], [1.0, 2.0]) <= 0.1 && off(p[1], [0.0, 2.0]) <= 0.1, "{p:?}");
        assert!(p[2] <= 1.0 || p[2] >= 2.0);
    }
    cells.build().unwrap();
}

#[test]
fn what_is_no_volume_is_told_and_what_two_share_is_the_firsts() {
    let (building, _) = house();
    let mut rooms = model(&[
        ("first", [0.0, 0.0, 0.0], [4.0, 3.0, 4.0]),
        ("again", [2.0, 0.0, 0.0], [4.0, 3.0, 8.0]),
    ]);
    let flat = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let out = cells_of_rooms(&building, &rooms, &RoomOptions::default());
    assert_eq!(out.warnings.len(), 1, "{:?}", out.warnings);
    assert!(out.warnings[0].message.contains("shares 50 %"), "{:?}", out.warnings);
    assert!((out.cells.cells[1].volume() - 24.0).abs() < 0.2, "{}", out.cells.cells[1].volume());
    rooms = load_bytes("flat.obj", flat, &LoadOptions::default()).unwrap();
    let out = cells_of_rooms(&building, &rooms, &RoomOptions::default());
    assert!(out.warnings[0].message.contains("encloses no volume"), "{:?}", out.warnings);
    assert!(out.cells.portals.is_empty());
}

#[test]
fn nothing_of_the_duplex_is_lost_by_its_rooms() {
    let Some(folder) = data("duplex-bim") else { return };
    let open = |name: &str| load(&folder.join(name), &LoadOptions::default()).unwrap();
    let (mut building, rooms) = (open("duplex.glb"), open("duplex-spaces.glb"));
    let RoomCells { cells, warnings } = cells_of_rooms(&building, &rooms, &RoomOptions::default());
    for warning in &warnings {
        println!("{warning}");
    }
    assert_eq!(cells.cells.len(), 22);
    building.cells = cells;
    building.place_cells().unwrap();
    let of = |cell: u32| building.cells.portals.iter().filter(move |p| p.cells.contains(&cell));
    for (number, cell) in (0..).zip(&building.cells.cells) {
        let to: std::collections::BTreeSet<u32> =
            of(number).flat_map(|p| p.cells).filter(|&c| c != number).collect();
        println!("{number} {}: {:.1} m³, {to:?}", cell.name, cell.volume());
    }
    let options = VerifyOptions { samples: 2, ..VerifyOptions::default() };
    let both = Culler::exact();
    let ways = [Culler::exact().only(Stage::Portal), both.without(Stage::Portal), both];
    let (mut left, mut all, mut idle, mut views) = ([0; 3], 0, 0, 0);
    for cell in &building.cells.cells[..21] {
        let Some([low, high]) = cell.main_bounds() else { continue };
        let eye = [
            (low[0] + high[0]) * 0.5,
            (low[1] + 1.6).min((low[1] + high[1]) * 0.5),
            (low[2] + high[2]) * 0.5,
        ];
        for direction in [[1.0, 0.05, 0.1], [-0.1, -0.2, 1.0], [-1.0, 0.1, -0.2], [0.2, -0.1, -1.0]]
        {
            let target = std::array::from_fn(|k| eye[k] + direction[k]);
            let view = View::perspective(eye, target, 1.4, 0.05, 200.0, [320, 180]).unwrap();
            views += 1;
            for (culler, left) in ways.iter().zip(&mut left) {
                let mut state = ViewState::default();
                let done = verify(building.in_cells(), &view, culler, &mut state, &options);
                assert!(done.false_culls.is_empty(), "{}: {:?}", cell.name, done.false_culls);
                *left += done.potentially_visible;
                if culler.runs(Stage::Portal) && !culler.runs(Stage::Occlusion) {
                    idle += u32::from(building.in_cells().reached(culler, &view).is_none());
                    all += done.all;
                }
            }
        }
    }
    let [portal, occlusion, together] = left;
    println!(
        "{views} views, nothing by portals in {idle}; of {all} triangles portals alone leave {portal}, occlusion \
         {occlusion}, both {together}"
    );
    assert!(idle * 10 <= views, "{idle} of {views}");
    assert!(portal * 5 < all * 3 && together < occlusion);
}
