//! Visible sets say what is loaded first.

use std::collections::BTreeSet;

use cullet::{Scene, prepared::Preparation};
use cullet_cells::pvs::{Targets, VisibleSets};
use cullet_io::{LoadOptions, Model};
use cullet_maps::TileInput;
use cullet_maps::TileSets;
use cullet_maps::TileTree;
use cullet_maps::WriteTiles;
use cullet_maps::write_tiles;
use cullet_maps::write_tiles_with;
use cullet_testkit::{Folder, Rng};
use cullet_tiles::{Cut, FolderTiles, Settings, TileId, TileSource, World, choose};

fn options() -> LoadOptions {
    LoadOptions { prepare: Preparation::NONE, ..LoadOptions::default() }
}

/// Small enough that a tile is a small part of all.
fn small() -> WriteTiles {
    let mut small = WriteTiles::default();
    (small.triangles, small.instances) = (3000, 15);
    small
}

/// Two cells side by side, along x.
const CELLS: [[[f64; 3]; 2]; 2] =
    [[[-400.0, -5.0, -400.0], [0.0, 90.0, 400.0]], [[0.0, -5.0, -400.0], [400.0, 90.0, 400.0]]];

/// For each cell the indices of the instances on one side of z = 0, and some of the others: what a wall along z = 0 would let through.
fn sets(scene: &Scene) -> [BTreeSet<u32>; 2] {
    let mut rng = Rng(3);
    let mut all: [BTreeSet<u32>; 2] = Default::default();
    for slot in scene.slots() {
        let (index, z) = (scene.handle(slot).unwrap().index, scene.transform(slot).translation[2]);
        for (cell, set) in all.iter_mut().enumerate() {
            if (z < 0.0) == (cell == 0) || rng.below(2000) == 0 {
                set.insert(index);
            }
        }
    }
    all
}

fn written(folder: &Folder) -> (Model, [BTreeSet<u32>; 2]) {
    let city = cullet_scenes::build("city:cells=6,objects=400,ground=0").unwrap();
    let of = sets(&city.scene);
    let count = city.scene.instance_count();
    let rows: Vec<Vec<u64>> = of
        .iter()
        .map(|set| {
            let mut row = vec![0; (count as usize).div_ceil(64)];
            set.iter().for_each(|&k| row[k as usize / 64] |= 1_u64 << (k % 64));
            row
        })
        .collect();
    let rows = rows.iter().map(Vec::as_slice);
    let visible = VisibleSets::from_rows(Targets::Instances, count, rows);
    let input = TileInput::default().with_sets(TileSets { cells: &CELLS, sets: &visible });
    let written = write_tiles_with(&city, folder.root(), &small(), &input, |_| true);
    assert_eq!(written.unwrap().unwrap().cells, 2);
    (city, of)
}

fn open(folder: &Folder) -> FolderTiles {
    FolderTiles::open(&folder.root().join("tileset.json"), &options()).unwrap()
}

/// A place for each instance, by which it is told after it was written and read.
fn place(scene: &Scene, slot: u32) -> [i64; 3] {
    scene.transform(slot).translation.map(|v| (v * 100.0).round() as i64)
}

#[test]
fn a_tile_is_seen_where_something_in_it_or_below_it_is() {
    let folder = Folder::new("sight");
    let (city, of) = written(&folder);
    let tiles = open(&folder);
    let seen: Vec<BTreeSet<[i64; 3]>> = of
        .iter()
        .map(|set| {
            let slots = city.scene.slots();
            let slots = slots.filter(|&s| set.contains(&city.scene.handle(s).unwrap().index));
            slots.map(|slot| place(&city.scene, slot)).collect()
        })
        .collect();
    fn has(tiles: &TileTree, tile: u32, seen: &BTreeSet<[i64; 3]>) -> bool {
        let own = tiles.load(tile).unwrap().scene;
        own.slots().any(|slot| seen.contains(&place(&own, slot)))
            || tiles.tiles()[tile as usize].children.iter().any(|&c| has(tiles, c, seen))
    }
    let mut counts = [0; 2];
    for number in 0..tiles.tree().tiles().len() as u32 {
        for cell in 0..2 {
            let expected = has(tiles.tree(), number, &seen[cell as usize]);
            assert_eq!(tiles.is_seen(TileId(number.into()), &[cell]), expected, "{number} {cell}");
            counts[usize::from(expected)] += 1;
        }
        let both = [0, 1].map(|cell| tiles.is_seen(TileId(number.into()), &[cell]));
        assert_eq!(tiles.is_seen(TileId(number.into()), &[0, 1]), both[0] || both[1]);
    }
    assert!(counts[0] > 10 && counts[1] > 10, "{counts:?}");
    assert_eq!(tiles.cells_of(&[[-5.0, 2.0, 3.0], [5.0, 2.0, 3.0]]), [0, 1]);
    let nowhere = [[-5.0, 2.0, 3.0], [5.0, 200.0, 3.0]];
    assert!(tiles.cells_of(&nowhere).is_empty(), "one that is in no cell knows nothing");
}

/// The instances of a cut that are seen from a cell.
fn seen_instances(tiles: &FolderTiles, cut: &Cut, cell: u32) -> u64 {
    let seen = cut.tiles.iter().filter(|&&tile| tiles.is_seen(tile, &[cell]));
    seen.map(|&tile| u64::from(tiles.info(tile).instances)).sum()
}

#[test]
fn with_half_of_the_budget_what_is_visible_is_finer_and_with_all_of_it_nothing_is_another() {
    let folder = Folder::new("sight");
    written(&folder);
    let (with, without) = (open(&folder), open(&folder).without_sight());
    let eye = [[-60.0, 2.0, 0.0]];
    let settings = Settings::default().with_pixels(2.0);
    let cut = |tiles: &FolderTiles, budget: u64| {
        choose(tiles, &eye, &settings.with_budget(budget), &|_| false).unwrap()
    };
    let whole = cut(&without, 1 << 30);
    assert!(!whole.is_cut_short);
    assert_eq!(cut(&with, 1 << 30).tiles, whole.tiles);
    let half = (with.bytes() + whole.bytes) / 2;
    let (own, plain) = (cut(&with, half), cut(&without, half));
    assert!(own.bytes <= half && plain.bytes <= half && own.is_cut_short && plain.is_cut_short);
    let [own, plain, all] = [own, plain, whole].map(|cut| seen_instances(&with, &cut, 0));
    assert!(own * 10 > plain * 11 && own <= all, "{own} of {all}, {plain} without");
}

#[test]
fn the_same_eye_has_the_same_tiles_whichever_way_it_came() {
    let folder = Folder::new("sight");
    written(&folder);
    let settings = Settings::default().with_pixels(2.0).with_budget(600 << 10);
    let mut walker = World::new(open(&folder), &settings).unwrap();
    for step in 0..8 {
        walker.look([f64::from(step) * 30.0 - 120.0, 2.0, 4.0], [0.0; 3]);
        walker.settle();
        assert!(walker.status().bytes <= 600 << 10);
    }
    let mut jumper = World::new(open(&folder), &settings).unwrap();
    jumper.look([90.0, 2.0, 4.0], [0.0; 3]);
    jumper.settle();
    assert_eq!(walker.tiles(), jumper.tiles());
    assert!(jumper.tiles().len() > 3);
}

#[test]
fn rows_that_are_damaged_or_missing_are_named() {
    let folder = Folder::new("sight");
    written(&folder);
    let (path, file) = (folder.root().join("tileset.json"), folder.root().join("sight.bin"));
    let good = std::fs::read(&file).unwrap();
    let error = |bytes: &[u8]| {
        std::fs::write(&file, bytes).unwrap();
        let error = FolderTiles::open(&path, &options()).unwrap_err().to_string();
        assert!(error.contains("sight.bin"), "{error}");
        error
    };
    for at in (0..good.len()).step_by(7) {
        let _ = error(&good[..at]);
        let mut odd = good.clone();
        odd[at] ^= 8;
        let _ = error(&odd);
    }
    assert!(error(&good[..good.len() - 1]).contains("damaged"));
    std::fs::remove_file(&file).unwrap();
    let error = FolderTiles::open(&path, &options()).unwrap_err().to_string();
    assert!(error.contains("sight.bin") && error.contains("missing"), "{error}");
    // A tileset without any is as ever.
    let plain = Folder::new("sight");
    let city = cullet_scenes::build("city:cells=6,objects=400,ground=0").unwrap();
    write_tiles(&city, plain.root(), &small(), |_| true).unwrap().unwrap();
    let tiles = open(&plain);
    assert!(tiles.tree().sight().is_none() && tiles.cells_of(&[[0.0, 2.0, 0.0]]).is_empty());
}
