//! Built-in scenes: the same everywhere, as described, and solid where they say so.

use std::collections::{BTreeMap, HashMap};

use cullet::mesh::Alpha;
use cullet::{Mesh, Transform};
use cullet_io::{Cell, CellGraph, Model};
use cullet_scenes::{self, SceneSpecError};
use cullet_testkit::{Rng, cases};

/// FNV-1a over everything that geometry is made of.
fn fingerprint(model: &Model) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325u64;
    let mut eat = |bits: u64| {
        for byte in bits.to_le_bytes() {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
        }
    };
    for mesh in model.scene.meshes() {
        mesh.positions().iter().flatten().for_each(|v| eat(u64::from(v.to_bits())));
        // In the order in which they were made: clusters are not the scene's affair.
        let mut order: Vec<u32> = (0..mesh.triangle_count()).collect();
        order.sort_by_key(|t| mesh.original_triangle()[*t as usize]);
        order.iter().flat_map(|t| mesh.triangle(*t)).for_each(|i| eat(u64::from(i)));
    }
    for slot in made(model) {
        let t = model.scene.transform(slot);
        eat(u64::from(model.scene.mesh_id(slot)));
        t.linear.iter().flatten().for_each(|v| eat(u64::from(v.to_bits())));
        t.translation.iter().for_each(|v| eat(v.to_bits()));
    }
    hash
}

/// The slots in the order in which their instances were made.
fn made(model: &Model) -> Vec<u32> {
    let mut slots: Vec<_> = model.scene.slots().collect();
    slots.sort_by_key(|&slot| model.scene.handle(slot));
    slots
}

/// Why a mesh is not closed, consistently wound and outward, judged on welded positions.
fn fault(mesh: &Mesh) -> Option<String> {
    let mut ids: HashMap<[u32; 3], u32> = HashMap::new();
    let mut edges: HashMap<(u32, u32), u32> = HashMap::new();
    let mut volume = 0.0;
    for t in 0..mesh.triangle_count() {
        let corners = mesh.corners(t);
        let [a, b, c] = corners.map(|p| glam::DVec3::from(p.map(f64::from)));
        volume += a.dot(b.cross(c)) / 6.0;
        let v = corners.map(|p| {
            let next = ids.len() as u32;
            *ids.entry(p.map(f32::to_bits)).or_insert(next)
        });
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            *edges.entry((v[i], v[j])).or_insert(0) += 1;
        }
    }
    let bad = edges.iter().find(|((a, b), n)| **n != 1 || edges.get(&(*b, *a)) != Some(&1));
    if let Some(((a, b), n)) = bad {
        let back = edges.get(&(*b, *a)).copied().unwrap_or(0);
        return Some(format!("edge {a}-{b} runs {n} times forward, {back} times back"));
    }
    (volume <= 0.0).then(|| format!("volume {volume}"))
}

fn count_of(model: &Model, mesh_name: &str) -> usize {
    let is = |slot: &u32| model.mesh_names[model.scene.mesh_id(*slot) as usize] == mesh_name;
    model.scene.slots().filter(is).count()
}

#[test]
fn the_same_text_gives_the_same_scene_everywhere() {
    // Recorded: a change here changes every figure that was ever measured on these scenes.
    let recorded = [
        ("city:cells=20,objects=3000", "5a16908649c329a5"),
        ("solids:n=60", "ecb25c20308e374f"),
        ("office:floors=2", "77b0e19ac6dfa177"),
        ("plant:bays=2,floors=2,kinds=2", "12940e6477ed4d58"),
        ("forest:n=20000", "f43dc8b850eab4b4"),
        ("moving:n=40,t=1500", "a03e6079a86b3ea0"),
    ];
    let made = recorded.map(|(text, _)| {
        let hash = fingerprint(&cullet_scenes::build(text).unwrap());
        let other = fingerprint(&cullet_scenes::build(&format!("{text},seed=2")).unwrap());
        assert_ne!(hash, other, "{text}: the seed changes nothing");
        (text, format!("{hash:016x}"))
    });
    assert_eq!(made, recorded.map(|(text, hash)| (text, hash.to_owned())));
    let knobs = fingerprint(&cullet_scenes::build("knobs:n=20").unwrap());
    assert_eq!(format!("{knobs:016x}"), "6f9defce50b01ea0", "knobs:n=20");
}

#[test]
fn every_scene_can_be_built_and_is_complete() {
    for text in [
        "city:cells=10,objects=500",
        "solids",
        "office",
        "plant:bays=3,floors=2,kinds=3",
        "forest:n=5000",
        "moving:t=2000",
        "knobs",
    ] {
        let model = cullet_scenes::build(text).unwrap();
        assert!(cullet_scenes::is_builtin(text));
        assert_eq!(model.name.split(':').next(), text.split(':').next());
        assert_eq!(model.mesh_names.len(), model.scene.meshes().len());
        assert!(model.warnings.is_empty());
        assert!(model.scene.extent().is_finite());
        for (mesh, name) in model.scene.meshes().iter().zip(&model.mesh_names) {
            assert!(!name.is_empty());
            assert_eq!(mesh.degenerate_count(), 0, "{text}: {name}");
            for part in mesh.parts() {
                let material = &model.materials[part.material as usize];
                let blended = material.color[3] < 1.0;
                assert_eq!(part.alpha == Alpha::Blended, blended, "{text}: {name}");
            }
            // One-sided means solid; what is no solid is seen from both sides.
            let one_sided = mesh.parts().iter().any(|p| !p.two_sided);
            let fault = fault(mesh);
            assert_eq!(one_sided, fault.is_none(), "{text}: {name}: {fault:?}");
        }
        if let Some(&fourth) = made(&model).get(3) {
            let name = model.instance_name(model.scene.handle(fourth).unwrap());
            assert!(name.ends_with(" 3"), "{name}");
        } else {
            assert_eq!((text, model.scene.instance_count()), ("knobs", 1));
        }
    }
}

#[test]
fn defaults_and_names() {
    for info in cullet_scenes::list() {
        assert!(!info.about.is_empty());
        for key in info.keys {
            assert!(key.min <= key.default && key.default <= key.max, "{}", key.name);
        }
    }
    assert_eq!(cullet_scenes::build("office:closed=25,floors=1").unwrap().name, "office:floors=1");
    assert!(!cullet_scenes::is_builtin("city.glb") && !cullet_scenes::is_builtin(""));
    let error = cullet_scenes::build("city:buildings=100").unwrap_err();
    assert!(matches!(error, SceneSpecError::UnknownKey { .. }));
    assert!(error.to_string().contains("cells (1 to 1000)"), "{error}");
}

#[test]
fn the_city_is_as_specified() {
    let model = cullet_scenes::build("city:ground=0").unwrap();
    let scene = &model.scene;
    assert_eq!(scene.instance_count(), 110_000);
    let buildings: Vec<u32> =
        scene.slots().filter(|&s| mesh_name(&model, s).ends_with("building")).collect();
    assert_eq!(buildings.len(), 10_000);
    let triangles: u32 = buildings.iter().map(|&s| scene.mesh(s).triangle_count()).sum();
    assert_eq!(triangles, 120_000);
    let mut heights = 0.0;
    let mut cells = BTreeMap::new();
    for &s in &buildings {
        let t = scene.transform(s);
        let [w, h, d] = [t.linear[0][0], t.linear[1][1], t.linear[2][2]];
        assert!(
            (10.0..=18.0).contains(&w) && (10.0..=18.0).contains(&d) && (6.0..=120.0).contains(&h)
        );
        heights += f64::from(h);
        *cells
            .entry([0, 2].map(|a| ((t.translation[a] + 1200.0) / 24.0).floor() as i64))
            .or_insert(0) += 1;
    }
    assert!(cells.len() == 10_000 && cells.values().all(|n| *n == 1));
    // Mean 20 m, less what the cut at 120 m takes away.
    assert!((heights / 10_000.0 - 20.0).abs() < 0.5, "{}", heights / 10_000.0);

    let (mut roof, mut air) = (0, 0);
    for s in scene.slots().filter(|&s| !mesh_name(&model, s).ends_with("building")) {
        let (t, b) = (scene.transform(s), scene.bounds(s));
        let size: [f64; 3] = std::array::from_fn(|a| f64::from(b.max[a]) - f64::from(b.min[a]));
        assert!(size[0] >= 0.399 && size[0] <= 2.001 && (size[0] - size[2]).abs() < 2e-3);
        assert!(size[1] >= 0.299 && size[1] <= 2.501);
        roof += u32::from(mesh_name(&model, s) == "vent");
        air += u32::from(mesh_name(&model, s) == "balloon");
        assert!(t.translation[1] == 0.0 || ["vent", "balloon"].contains(&mesh_name(&model, s)));
    }
    // A third of the ground is built on, and 15 % of what falls there goes on a roof.
    assert!((5_000..15_000).contains(&roof), "{roof}");
    assert!((20_000..26_000).contains(&air), "{air}");
    // As many as a report of sixteen verified views can draw in half a minute.
    assert!(scene.triangle_count() < 2_000_000, "{}", scene.triangle_count());
    assert_eq!(model.cameras.len(), 32);

    let dense = cullet_scenes::build("city:cells=10,sub=3,objects=0").unwrap();
    assert_eq!(dense.scene.triangle_count(), 100 * 108 + 2);
    assert_eq!(
        cullet_scenes::build("city:cells=10,objects=0,ground=0").unwrap().scene.instance_count(),
        100
    );
}

fn mesh_name(model: &Model, slot: u32) -> &str {
    &model.mesh_names[model.scene.mesh_id(slot) as usize]
}

#[test]
fn solids_are_of_many_kinds() {
    let model = cullet_scenes::build("solids").unwrap();
    assert_eq!(model.scene.instance_count(), 226);
    assert!(model.mesh_names.len() >= 25);
    let pipe = model.mesh_names.iter().position(|n| n == "80-face pipe").unwrap();
    assert_eq!(model.scene.meshes()[pipe].triangle_count(), 80);
    let mirrored = |s: &u32| model.scene.transform(*s).determinant() < 0.0;
    let mirrored = model.scene.slots().filter(mirrored).count();
    assert!((40..70).contains(&mirrored), "{mirrored}");
    // None touches another: their boxes are apart, and above the floor.
    let boxes: Vec<_> = made(&model).into_iter().map(|s| model.scene.bounds(s)).collect();
    for (mesh, name) in model.scene.meshes().iter().zip(&model.mesh_names) {
        let b = mesh.bounds();
        let fits = b.min.iter().chain(&b.max).all(|v| v.abs() <= 1.0 + 1e-6);
        assert!(fits, "{name}: {b:?}");
    }
    assert!(boxes[1..].iter().all(|b| b.min[1] > 0.05));
}

/// A room of the office with half of its walls and slabs.
fn whole(cell: &Cell) -> [[f64; 3]; 2] {
    let [min, max] = cell.main_bounds().unwrap();
    let half = [0.1, 0.15, 0.1];
    [std::array::from_fn(|k| min[k] - half[k]), std::array::from_fn(|k| max[k] + half[k])]
}

#[test]
fn cells_of_the_office_meet_at_their_portals() {
    let model = cullet_scenes::build("office:floors=3,closed=50").unwrap();
    let CellGraph { cells, portals, .. } = &model.cells;
    let rooms = 8 * 2 * 3;
    assert_eq!(cells.len(), 3 * (rooms + 3 + 2));
    // Cells do not overlap, up to the middle of their walls.
    let boxes: Vec<_> = cells.iter().map(whole).collect();
    for (i, a) in boxes.iter().enumerate() {
        for (j, b) in boxes[..i].iter().enumerate() {
            let apart = (0..3).any(|k| a[1][k] <= b[0][k] + 1e-9 || b[1][k] <= a[0][k] + 1e-9);
            assert!(apart, "{} and {}", cells[i].name, cells[j].name);
        }
    }
    let mut reached = vec![false; cells.len()];
    reached[0] = true;
    for _ in 0..cells.len() {
        for p in portals {
            let [a, b] = p.cells.map(|c| c as usize);
            let either = reached[a] || reached[b];
            (reached[a], reached[b]) = (either, either);
        }
    }
    assert!(reached.iter().all(|r| *r), "some cell has no way in");
    for p in portals {
        assert_ne!(p.cells[0], p.cells[1]);
        for c in p.cells {
            let [min, max] = boxes[c as usize];
            for v in &p.polygon {
                let inside = (0..3).all(|k| v[k] >= min[k] - 1e-9 && v[k] <= max[k] + 1e-9);
                assert!(inside, "{v:?} is not of {}", cells[c as usize].name);
            }
        }
        assert!(p.door.is_some() || !p.closed);
        if let Some(door) = p.door {
            let slot = model.scene.slot(door).unwrap();
            assert_eq!(mesh_name(&model, slot), "door");
            // A shut leaf covers its whole opening; an open one does not.
            let b = model.scene.bounds(slot);
            let covers = p.polygon.iter().all(|v| {
                (0..3).all(|k| {
                    f64::from(b.min[k]) <= v[k] + 1e-5 && v[k] - 1e-5 <= f64::from(b.max[k])
                })
            });
            assert_eq!(covers, p.closed);
        }
    }
    let doors = portals.iter().filter(|p| p.door.is_some()).count();
    let shut = portals.iter().filter(|p| p.closed).count();
    assert_eq!(count_of(&model, "door"), doors);
    assert!((doors * 3 / 10..doors * 7 / 10).contains(&shut), "{shut} of {doors}");
    let all_open = cullet_scenes::build("office:closed=0").unwrap();
    assert!(all_open.cells.portals.iter().all(|p| !p.closed));
}

#[test]
fn between_cells_one_sees_through_portals_alone() {
    // The walls close every way from cell to cell but the portals: a segment that crosses the middle of
    // a wall away from all portals hits a wall, a slab or a shut door.
    let model = cullet_scenes::build("office:furniture=0").unwrap();
    let CellGraph { cells, portals, .. } = &model.cells;
    let opaque: Vec<(Transform, u32)> = model
        .scene
        .slots()
        .filter(|&s| ["wall", "slab"].contains(&mesh_name(&model, s)))
        .map(|s| (*model.scene.transform(s), s))
        .collect();
    let mut rng = Rng(1);
    let mut crossed = 0;
    let boxes: Vec<_> = cells.iter().map(whole).collect();
    for (cell, [low, high]) in cells.iter().zip(&boxes) {
        for _ in 0..cases(400) {
            let p: [f64; 3] = std::array::from_fn(|k| low[k] + (high[k] - low[k]) * rng.unit());
            // Out of the cell through each of its six faces, 0.6 m on: past the wall or slab.
            let axis = (rng.unit() * 3.0) as usize % 3;
            let up = rng.unit() < 0.5;
            let plane = if up { high[axis] } else { low[axis] };
            let at = |d: f64| {
                let mut q = p;
                q[axis] = plane + if up { d } else { -d };
                q
            };
            let middle = at(0.0);
            let through = portals.iter().any(|portal| {
                let (min, max) = portal.polygon.iter().fold(
                    ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]),
                    |(min, max), v| {
                        (
                            std::array::from_fn(|k| min[k].min(v[k])),
                            std::array::from_fn(|k: usize| f64::max(max[k], v[k])),
                        )
                    },
                );
                (0..3).all(|k| middle[k] >= min[k] - 1e-9 && middle[k] <= max[k] + 1e-9)
            });
            let outside = !boxes.iter().any(|[min, max]| {
                let q = at(0.6);
                (0..3).all(|k| q[k] > min[k] && q[k] < max[k])
            });
            if through || outside {
                continue;
            }
            crossed += 1;
            let blocked = opaque.iter().any(|(_, slot)| {
                let b = model.scene.bounds(*slot);
                b.contains(middle.map(|v| v as f32))
            });
            assert!(blocked, "one sees out of {} at {middle:?}", cell.name);
        }
    }
    assert!(crossed > 25 * cases(400), "{crossed}");
}

#[test]
fn the_forest_has_as_many_trees_as_requested() {
    for n in [1u32, 17, 5000] {
        let model = cullet_scenes::build(&format!("forest:n={n}")).unwrap();
        assert_eq!(model.scene.instance_count(), n + 1);
        assert!(model.instance_names.is_empty());
    }
}

#[test]
fn what_moves_stays_within_its_bounds() {
    for t in [0, 300, 1700, 45_250] {
        let model = cullet_scenes::build(&format!("moving:n=200,t={t}")).unwrap();
        let scene = &model.scene;
        // Deformed meshes are stored as they are posed, so the audit needs no other positions.
        assert_eq!(scene.audit(|_| None), Ok(vec![]), "at {t} ms");
        // Bounds come from joints and targets, not from the vertices: they hold with room, but not much.
        let (mut count, mut true_area, mut area) = (0, 0.0, 0.0);
        for slot in scene.slots().filter(|&s| scene.mesh(s).is_deformable()) {
            let around = scene.transform(slot).transform_box(&scene.mesh(slot).bounds(), [0.0; 3]);
            count += 1;
            true_area += around.surface_area();
            area += scene.bounds(slot).surface_area();
        }
        assert_eq!(count, 150);
        assert!(area / true_area < 2.0, "{}", area / true_area);
    }
    let at = |t: u32| fingerprint(&cullet_scenes::build(&format!("moving:n=8,t={t}")).unwrap());
    assert_ne!(at(0), at(1));
}
