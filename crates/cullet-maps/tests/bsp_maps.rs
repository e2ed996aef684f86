//! Real maps: what loads, what their trees say beside the portals of their compiler, and that visibility which is written is
//! read again.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use cullet_io::{LoadOptions, Up};
use cullet_maps::bsp::{Bsp, ClusterRows, Version, clusters_of_leafs, with_visibility};
use cullet_maps::load;
use cullet_maps::load_bytes;
use cullet_testkit::{Rng, data};
use glam::DVec3;

/// A map, its leafs, cells, triangles, brush models that are placed, and cameras.
type Figures = (&'static str, u32, u32, u64, usize, usize);

const QUAKE: [Figures; 6] = [
    ("start", 524, 50, 2_194, 23, 11),
    ("lqdm2", 863, 116, 8_125, 0, 13),
    ("lqdm1", 1_118, 253, 9_444, 2, 13),
    ("lq_e0m1", 1_307, 699, 8_831, 14, 7),
    ("lq_e0m3", 1_431, 1_025, 9_852, 5, 13),
    ("lq_e1m2", 3_708, 562, 25_623, 49, 19),
];
const QUAKE3: [Figures; 3] = [
    ("aggressor", 759, 330, 3_310, 0, 7),
    ("oa_bases3", 665, 250, 2_384, 0, 47),
    ("oa_dm1", 1_123, 422, 7_532, 6, 9),
];

fn file(folder: &Path, name: &str) -> PathBuf {
    folder.join(name).with_extension("bsp")
}

/// Files of the maps, and what they must have.
fn maps() -> Vec<(PathBuf, Figures)> {
    let of = |folder: &str, maps: &[Figures]| -> Vec<(PathBuf, Figures)> {
        let Some(folder) = data(folder) else { return Vec::new() };
        maps.iter().map(|m| (file(&folder, m.0), *m)).collect()
    };
    [of("quake-libre", &QUAKE), of("quake3-openarena", &QUAKE3)].concat()
}

#[test]
fn maps_load_with_all_they_have() {
    let (mut placed_as, mut expected) = (Vec::new(), Vec::new());
    for (path, (name, leafs, cells, triangles, brushes, cameras)) in maps() {
        let map = Bsp::open(&path).unwrap();
        let model = load(&path, &LoadOptions::default()).unwrap();
        assert_eq!((map.leafs().len() as u32, map.cell_count()), (leafs, cells), "{name}");
        assert_eq!(model.scene.triangle_count(), triangles, "{name}");
        let placed = model.instance_names.iter().filter(|n| n.contains('*')).count();
        placed_as.push((name, placed, model.cameras.len()));
        expected.push((name, brushes, cameras));
        // That map was stripped of its lamps.
        assert_eq!(map.lamps().is_empty(), name == "oa_dm1", "{name}");
        assert!(map.has_visibility(), "{name}");
        // Every start is in a cell, and sees its own leaf and fewer than all.
        for start in map.starts() {
            if start.class.ends_with("intermission") {
                continue;
            }
            let leaf = map.leaf_at(start.origin);
            assert!(map.cell_at(start.origin).is_some(), "{name}: {start:?}");
            let seen = map.leafs_seen_from(leaf);
            assert!(seen.binary_search(&leaf).is_ok() && seen.len() < leafs as usize, "{name}");
        }
        // A point in a leaf is behind all its planes, and within its box.
        for number in 0..map.leafs().len() as u32 {
            let leaf = &map.leafs()[number as usize];
            let [low, high] = leaf.bounds;
            let middle = [0, 1, 2].map(|a| (low[a] + high[a]) * 0.5);
            let at = map.leaf_at(middle);
            // All rock of Quake is leaf 0.
            if leaf.cell.is_some() && map.leafs()[at as usize].cell.is_some() {
                let planes = map.tree().planes_of_leaf(at);
                assert!(planes.iter().all(|p| p.distance(middle) <= 1e-9), "{name}: {at}");
            }
        }
    }
    assert_eq!(placed_as, expected);
}

#[test]
fn walls_are_one_sided_and_z_points_up() {
    let Some(folder) = data("quake-libre") else { return };
    let path = file(&folder, "start");
    let with = |up, two_sided| {
        load(&path, &LoadOptions { up, two_sided, ..LoadOptions::default() }).unwrap()
    };
    let (own, as_written, both) =
        (with(None, None), with(Some(Up::Y), None), with(None, Some(true)));
    let size = |m: &cullet_io::Model| m.scene.extent().half_extent();
    let ([x, y, z], [a, b, c]) = (size(&own), size(&as_written));
    assert_eq!([x, y, z], [a, c, b]);
    let sides = |m: &cullet_io::Model| {
        m.scene.meshes().iter().flat_map(cullet::Mesh::parts).filter(|p| p.two_sided).count()
    };
    let parts: usize = own.scene.meshes().iter().map(|m| m.parts().len()).sum();
    assert_eq!((sides(&own), sides(&both)), (0, parts));
}

/// Portals of a `.prt` file, by the clusters' numbers, lower first.
fn compiled(path: &Path) -> BTreeMap<[u32; 2], Vec<Vec<DVec3>>> {
    let text = std::fs::read_to_string(path).unwrap().replace(['(', ')'], " ");
    let mut words = text.split_ascii_whitespace();
    assert_eq!(words.next(), Some("PRT2"));
    let mut number = || words.next().unwrap().parse::<f64>().unwrap();
    let [_leafs, _clusters, portals] = [(); 3].map(|()| number() as usize);
    let mut between: BTreeMap<_, Vec<_>> = BTreeMap::new();
    for _ in 0..portals {
        let [count, a, b] = [(); 3].map(|()| number() as u32);
        let polygon = (0..count).map(|_| [(); 3].map(|()| number()).into()).collect();
        between.entry([a.min(b), a.max(b)]).or_default().push(polygon);
    }
    between
}

/// Twice the area of a polygon, along its normal.
fn area(polygon: &[DVec3]) -> DVec3 {
    (1..polygon.len() - 1)
        .map(|i| (polygon[i] - polygon[0]).cross(polygon[i + 1] - polygon[0]))
        .sum()
}

/// How many of some points of a polygon have both of two cells near them, one on each side.
fn joining(map: &Bsp, polygon: &[DVec3], cells: [u32; 2], rng: &mut Rng) -> usize {
    let normal = area(polygon).normalize();
    let beside = |p: DVec3| [0.05, -0.05].map(|d| map.cell_at((p + normal * d).into()));
    let point = |rng: &mut Rng| {
        let weights: Vec<f64> = polygon.iter().map(|_| rng.unit()).collect();
        let sum: DVec3 = polygon.iter().zip(&weights).map(|(p, w)| *p * *w).sum();
        sum / weights.iter().sum::<f64>()
    };
    let [a, b] = cells.map(Some);
    (0..200).filter(|_| [[a, b], [b, a]].contains(&beside(point(rng)))).count()
}

#[test]
fn cells_and_portals_are_those_of_the_compiler() {
    let Some(folder) = data("quake-libre") else { return };
    let mut rng = Rng(5);
    for (name, ..) in QUAKE {
        let path = file(&folder, name);
        let map = Bsp::open(&path).unwrap();
        let theirs = compiled(&path.with_extension("prt"));
        let graph = map.cells().unwrap();
        let mut ours: BTreeMap<[u32; 2], Vec<Vec<DVec3>>> = BTreeMap::new();
        for portal in graph.portals() {
            let [a, b] = portal.cells;
            let polygon: Vec<DVec3> = portal.polygon.iter().map(|p| DVec3::from(*p)).collect();
            // Each leads from a cell to the other, and its normal points into the first.
            let found = joining(&map, &polygon, portal.cells, &mut rng);
            assert!(found > 80 || area(&polygon).length() < 50.0, "{name}: {portal:?} {found}");
            ours.entry([a.min(b), a.max(b)]).or_default().push(polygon);
        }
        // Cells have the numbers of the compiler's clusters. Neighbours that are missing have detail all over what the
        // compiler has between them; those that only we have are slits below its own tolerance.
        let missing: Vec<_> = theirs.keys().filter(|c| !ours.contains_key(*c)).collect();
        for cells in &missing {
            for polygon in &theirs[*cells] {
                assert_eq!(joining(&map, polygon, **cells, &mut rng), 0, "{name}: {cells:?}");
            }
        }
        let size = |polygons: &[Vec<DVec3>]| -> f64 {
            polygons.iter().map(|p| area(p).length() * 0.5).sum()
        };
        let more: Vec<f64> =
            ours.iter().filter(|(c, _)| !theirs.contains_key(*c)).map(|(_, p)| size(p)).collect();
        let larger = |(c, p): &(&[u32; 2], &Vec<Vec<DVec3>>)| {
            theirs.get(*c).is_some_and(|t| size(p) > size(t) * 1.001 + 1.0)
        };
        let compiled: usize = theirs.values().map(Vec::len).sum();
        println!(
            "{name}: {} cells, {} portals between {} pairs; {compiled} portals between {} pairs by the \
             compiler; {} pairs not here, {} not there: {more:?}",
            graph.cell_count(),
            graph.portals().len(),
            ours.len(),
            theirs.len(),
            missing.len(),
            more.len()
        );
        assert!(more.len() <= 5 && more.iter().all(|area| *area < 3.0), "{name}");
        // Detail only takes away.
        assert_eq!(ours.iter().filter(larger).count(), 0, "{name}");
    }
}

/// Rows of a map by its own cells.
fn rows(map: &Bsp) -> Vec<u8> {
    let mut rows = Vec::new();
    (0..map.cell_count()).for_each(|cell| map.cell_row_into(cell, &mut rows));
    rows
}

#[test]
fn rows_that_are_written_are_read_again() {
    for (path, (name, ..)) in maps() {
        let bytes = std::fs::read(&path).unwrap();
        let map = Bsp::parse(&bytes).unwrap();
        let (of_leaf, own) = (clusters_of_leafs(&map), rows(&map));
        let with = |rows: &[u8]| {
            let rows = ClusterRows { clusters: map.cell_count(), of_leaf: &of_leaf, rows };
            with_visibility(&bytes, &rows).unwrap()
        };
        let again = with(&own);
        let read = Bsp::parse(&again).unwrap();
        for leaf in 0..map.leafs().len() as u32 {
            assert_eq!(map.leafs_seen_from(leaf), read.leafs_seen_from(leaf), "{name}: {leaf}");
        }
        assert_eq!(rows(&read), own, "{name}");
        // What the map's own compiler wrote comes back to the byte where it packs rows as we do.
        println!("{name}: {} bytes, written {}", bytes.len(), again.len());
        let all = vec![0xFF; own.len()];
        let seen = with(&all);
        let open = Bsp::parse(&seen).unwrap();
        let in_cells = map.leafs().iter().filter(|leaf| leaf.cell.is_some()).count();
        let start = map.leaf_at(map.starts()[0].origin);
        assert_eq!(open.leafs_seen_from(start).len(), in_cells, "{name}");
        assert!((0..open.cell_count()).all(|c| {
            let mut row = Vec::new();
            open.cell_row_into(c, &mut row);
            row.iter().map(|b| b.count_ones()).sum::<u32>() == open.cell_count()
        }));
        untouched(&bytes, &again, map.version());
        untouched(&bytes, &seen, map.version());
        // And the map is a map: the same scene.
        let triangles = |bytes: &[u8]| {
            load_bytes("a.bsp", bytes, &LoadOptions::default()).unwrap().scene.triangle_count()
        };
        assert_eq!(triangles(&bytes), triangles(&seen), "{name}");
    }
}

/// Every lump but that of visibility, and of Quake's leafs where their rows are, is the same to the byte.
fn untouched(before: &[u8], after: &[u8], version: Version) {
    let (directory, visibility, leafs) =
        if version == Version::Quake3 { (8, 16, 17) } else { (4, 4, 10) };
    let lump = |bytes: &[u8], i: usize| {
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        let [offset, length] = [0, 4].map(|o| word(directory + 8 * i + o));
        bytes[offset..][..length].to_vec()
    };
    for i in (0..if version == Version::Quake3 { 17 } else { 15 }).filter(|i| *i != visibility) {
        let (mut a, mut b) = (lump(before, i), lump(after, i));
        if i == leafs {
            for lump in [&mut a, &mut b] {
                lump.chunks_exact_mut(28).for_each(|leaf| leaf[4..8].fill(0));
            }
        }
        assert!(a == b, "lump {i}");
    }
}
