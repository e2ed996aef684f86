//! Small maps: what they say, and rows that are written into them.

use crate::bsp_seeds;

use bsp_seeds::{of, small};
use cullet_io::{ErrorKind, LoadOptions};
use cullet_maps::bsp::{Bsp, ClusterRows, Contents, with_visibility};
use cullet_maps::load_bytes;

#[test]
fn small_maps_say_what_they_are() {
    for (name, bytes) in small() {
        let map = Bsp::parse(&bytes).unwrap();
        let model = load_bytes("a.bsp", &bytes, &LoadOptions::default()).unwrap();
        let quake3 = name == "quake3";
        let cells = if name == "one-cell" { 1 } else { 2 };
        assert_eq!((map.cell_count(), map.has_visibility()), (cells, name != "unbaked"), "{name}");
        let told = model.warnings.iter().any(|w| w.item == "lump visibility");
        assert_eq!(told, name == "unbaked", "{name}");
        // Six walls of two triangles; the curved one of more.
        let triangles = model.scene.triangle_count();
        assert!(triangles == 12 || quake3 && (13..=60).contains(&triangles), "{name}: {triangles}");
        assert!(model.instance_names.contains(&"func_wall *1".to_owned()), "{name}");
        assert_eq!(model.cameras[0].name, "info_player_start");
        let contents = |x: f64| map.leafs()[map.leaf_at([x, 1.0, 2.0]) as usize].contents;
        let [front, back] = [contents(5.0), contents(-5.0)];
        assert_eq!(front, Contents::Open, "{name}");
        assert_eq!(back, if quake3 { Contents::Open } else { Contents::Liquid }, "{name}");
        assert_eq!(contents(99.0), Contents::Solid, "{name}");
        // One portal between the two cells, as large as the room is.
        let graph = map.cells().unwrap();
        assert_eq!(graph.portals().len(), cells as usize - 1, "{name}");
        for portal in graph.portals() {
            assert_eq!(
                portal.cells,
                [map.cell_at([5.0; 3]).unwrap(), map.cell_at([-5.0; 3]).unwrap()]
            );
            let off = |p: &[f64; 3]| {
                let sizes = [0.0, 64.0, 64.0];
                (0..3).map(|a| (p[a].abs() - sizes[a]).abs()).fold(0.0, f64::max)
            };
            assert!(portal.polygon.iter().all(|p| off(p) < 1e-9), "{name}: {portal:?}");
            assert!(graph.plane(0).normal[0] > 0.99);
        }
        assert_eq!(map.leafs_seen_from(1), [1, 2], "{name}");
        // Seen from within, walls face the eye: all are front faces there, and none from outside.
        let mut facing = [0, 0];
        for slot in model.scene.slots() {
            let mesh = model.scene.mesh(slot);
            for t in 0..mesh.triangle_count() {
                let [a, b, c] = mesh.corners(t).map(glam::Vec3::from);
                facing[usize::from((b - a).cross(c - a).dot(-a) < 0.0)] += 1;
            }
        }
        assert_eq!(facing[1], 0, "{name}: {facing:?}");
    }
}

#[test]
fn rows_that_no_map_can_have_are_refused() {
    let bytes = of("quake");
    let with = |bytes: &[u8], clusters, of_leaf: &[u32], rows: &[u8]| {
        let rows = ClusterRows { clusters, of_leaf, rows };
        with_visibility(bytes, &rows).map(drop).map_err(|e: ErrorKind| e.to_string())
    };
    assert_eq!(with(&bytes, 2, &[0, 1], &[3, 3]), Ok(()));
    let short = with(&bytes, 2, &[0, 1], &[3]).unwrap_err();
    assert_eq!(short, "rows: 1 bytes; 2 rows of 1 bytes have 2");
    let few = with(&bytes, 2, &[0], &[3, 3]).unwrap_err();
    assert_eq!(few, "leafs: clusters of 1 leafs are given; the map has 2");
    let beyond = with(&bytes, 2, &[0, 2], &[3, 3]).unwrap_err();
    assert_eq!(beyond, "leaf 2: it is in cluster 2, of 2");
    let blind = with(&bytes, 2, &[0, 1], &[3, 1]).unwrap_err();
    assert!(blind.starts_with("row 1: it does not see itself"), "{blind}");
    let other = with(&of("quake3"), 3, &[], &[7, 7, 7]).unwrap_err();
    assert_eq!(other, "clusters: 3 are given; the map has 2");
    assert_eq!(with(&of("quake3"), 2, &[], &[3, 3]), Ok(()));
}

#[test]
fn a_map_without_visibility_gets_one_and_what_follows_moves() {
    let mut bytes = of("unbaked");
    // A BSPX directory behind the last lump, with one entry behind that.
    let at = bytes.len();
    bytes.extend(b"BSPX");
    bytes.extend(1u32.to_le_bytes());
    bytes.extend(b"NOTES".iter().copied().chain([0; 19]));
    bytes.extend((at as u32 + 40).to_le_bytes());
    bytes.extend(4u32.to_le_bytes());
    bytes.extend(b"note");
    let rows = ClusterRows { clusters: 2, of_leaf: &[0, 1], rows: &[1, 2] };
    let written = with_visibility(&bytes, &rows).unwrap();
    let map = Bsp::parse(&written).unwrap();
    assert_eq!((map.leafs_seen_from(1), map.leafs_seen_from(2)), (vec![1], vec![2]));
    assert_eq!(map.cell_count(), 2);
    let moved = written.len() - bytes.len();
    let word = |at: usize| u32::from_le_bytes(written[at..at + 4].try_into().unwrap()) as usize;
    assert!(written[at + moved..].starts_with(b"BSPX"));
    let note = word(at + moved + 32);
    assert_eq!(&written[note..][..4], b"note");
    // All of one size: written twice is the same to the byte.
    assert_eq!(with_visibility(&written, &rows).unwrap(), written);
}

#[test]
fn rows_of_quake_2_come_back_with_what_is_heard() {
    let bytes = of("quake2");
    // Each of two clusters sees itself alone, so that it hears itself alone.
    let rows = ClusterRows { clusters: 2, of_leaf: &[], rows: &[1, 2] };
    let written = with_visibility(&bytes, &rows).unwrap();
    let map = Bsp::parse(&written).unwrap();
    assert_eq!((map.leafs_seen_from(1), map.leafs_seen_from(2)), (vec![1], vec![2]));
    let word = |at: usize| u32::from_le_bytes(written[at..at + 4].try_into().unwrap()) as usize;
    let lump = word(8 + 8 * 3);
    let row = |number: usize| written[lump + word(lump + 4 + 4 * number)];
    assert_eq!([0, 1, 2, 3].map(row), [1, 1, 2, 2], "seen and heard of each");
    // The first sees the second, which sees itself alone.
    let rows = ClusterRows { clusters: 2, of_leaf: &[], rows: &[3, 2] };
    let map = Bsp::parse(&with_visibility(&bytes, &rows).unwrap()).unwrap();
    assert_eq!((map.leafs_seen_from(1), map.leafs_seen_from(2)), (vec![1, 2], vec![2]));
}

#[test]
fn maps_of_blue_shift_have_two_lumps_in_each_others_place() {
    let mut bytes = of("halflife");
    let (first, second) = bytes.split_at_mut(12);
    first[4..].swap_with_slice(&mut second[..8]);
    assert_eq!(Bsp::parse(&bytes).unwrap().starts().len(), 1);
    let model = load_bytes("a.bsp", &bytes, &LoadOptions::default()).unwrap();
    assert_eq!(model.scene.triangle_count(), 12);
}

#[test]
fn glass_of_half_life_hides_nothing() {
    let mut bytes = of("halflife");
    // The brush model is of water: make that a wall.
    let water = bytes.windows(6).position(|w| w == b"*water").unwrap();
    bytes[water] = b'a';
    // The entity of the brush model with more pairs; the lumps behind it move.
    let blended = |pairs: &str| {
        let at = bytes.windows(9).position(|w| w == b"func_wall").unwrap();
        let mut changed = bytes.clone();
        let rest = changed[at + 10..].to_vec();
        changed.truncate(at + 10);
        changed.extend(pairs.bytes().chain(rest));
        for lump in 0..15 {
            let [offset, length] = [4, 8].map(|o| 8 * lump + o);
            let word = |at: usize| i32::from_le_bytes(changed[at..at + 4].try_into().unwrap());
            let (place, grows) = (word(offset), lump == 0);
            let by = pairs.len() as i32;
            let moved = if place as usize > at { place + by } else { place };
            let size = word(length) + if grows { by } else { 0 };
            changed[offset..offset + 4].copy_from_slice(&moved.to_le_bytes());
            changed[length..length + 4].copy_from_slice(&size.to_le_bytes());
        }
        let model = load_bytes("a.bsp", &changed, &LoadOptions::default()).unwrap();
        let parts = model.scene.meshes().iter().flat_map(cullet::Mesh::parts);
        parts.filter(|part| part.alpha == cullet::mesh::Alpha::Blended).count()
    };
    let plain = blended("");
    assert_eq!(blended("\n\"rendermode\" \"0\""), plain);
    assert_eq!(blended("\n\"rendermode\" \"4\""), plain);
    assert_eq!(blended("\n\"rendermode\" \"2\""), plain + 1);
    assert_eq!(blended("\n\"alpha\" \"0.5\""), plain + 1);
}
