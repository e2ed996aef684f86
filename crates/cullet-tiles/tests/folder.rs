//! Worlds in folders: written as 3D Tiles, loaded tile by tile.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use cullet::{Culler, Scene, ViewState, Visible, prepared::Preparation};
use cullet_io::{LoadOptions, Model};
use cullet_maps::WriteTiles;
use cullet_maps::load;
use cullet_maps::write_tiles;
use cullet_scenes::paths::{self, Overrides, PathSpec};
use cullet_tiles::{FolderTiles, Settings, TileId, TileSource, World, choose};

/// A folder that goes when it is dropped.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("cullet-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        Self(path)
    }

    fn tileset(&self) -> PathBuf {
        self.0.join("tileset.json")
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn options() -> LoadOptions {
    LoadOptions { prepare: Preparation::NONE, ..LoadOptions::default() }
}

/// Small enough that there are many tiles.
fn small() -> WriteTiles {
    let mut small = WriteTiles::default();
    (small.triangles, small.instances) = (3000, 60);
    small
}

fn written(name: &str) -> (Folder, Model) {
    let (folder, city) =
        (Folder::new(name), cullet_scenes::build("city:cells=6,objects=400").unwrap());
    let written = write_tiles(&city, &folder.0, &small(), |_| true).unwrap().unwrap();
    assert!(written.tiles[0] > 20 && written.depth > 1, "{written:?}");
    (folder, city)
}

/// Where instances are, and of how many triangles; near enough, for transforms are composed anew.
fn places(scene: &Scene) -> Vec<([i64; 3], u32)> {
    let near = |v: f64| (v * 100.0).round() as i64;
    let place =
        |slot| (scene.transform(slot).translation.map(near), scene.mesh(slot).triangle_count());
    let mut places: Vec<_> = scene.slots().map(place).collect();
    places.sort_unstable();
    places
}

fn all(path: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut files: Vec<_> = [path.to_owned(), path.join("tiles")]
        .iter()
        .flat_map(|folder| std::fs::read_dir(folder).unwrap())
        .map(|entry| entry.unwrap().path())
        .filter(|file| file.is_file())
        .map(|file| (file.strip_prefix(path).unwrap().to_owned(), std::fs::read(&file).unwrap()))
        .collect();
    files.sort();
    files
}

#[test]
fn what_is_written_is_read_whole_and_written_again_the_same() {
    let (folder, city) = written("tiles-whole");
    let back = load(&folder.tileset(), &options()).unwrap();
    assert_eq!(places(&back.scene), places(&city.scene));
    let again = Folder::new("tiles-again");
    write_tiles(&city, &again.0, &small(), |_| true).unwrap().unwrap();
    assert!(all(&folder.0) == all(&again.0));
    // One that is stopped says so.
    let stopped = Folder::new("tiles-stopped");
    assert_eq!(write_tiles(&city, &stopped.0, &small(), |_| false).unwrap(), None);
    assert!(!stopped.tileset().exists());
}

#[test]
fn boxes_hold_all_below_them_and_errors_shrink() {
    let (folder, city) = written("tiles-boxes");
    let tiles = FolderTiles::open(&folder.tileset(), &options()).unwrap();
    let nodes = tiles.tree().tiles();
    let mut count = 0;
    for (number, node) in nodes.iter().enumerate() {
        let content = tiles.load(TileId(number as u64)).unwrap();
        let info = tiles.info(TileId(number as u64));
        assert_eq!(content.instances.len(), info.instances as usize, "as was said");
        count += info.instances;
        let [low, high] = node.bounds;
        for instance in &content.instances {
            let at = instance.transform.translation;
            let mesh = &content.meshes[instance.mesh as usize];
            let reach = 1e-3
                + 2.0 * f64::from(mesh.bounds().max.iter().fold(0.0_f32, |a, v| a.max(v.abs())));
            assert!((0..3).all(|a| low[a] - reach <= at[a] && at[a] <= high[a] + reach));
        }
        for &child in &node.children {
            let child = &nodes[child as usize];
            assert!(child.error <= node.error);
            let inside = |a: usize| {
                low[a] - 1e-6 <= child.bounds[0][a] && child.bounds[1][a] <= high[a] + 1e-6
            };
            assert!((0..3).all(inside));
        }
    }
    assert_eq!(count, city.scene.instance_count());
}

#[test]
fn everything_is_loaded_where_all_is_wanted_and_little_from_afar() {
    let (folder, city) = written("tiles-world");
    let open = || FolderTiles::open(&folder.tileset(), &options()).unwrap();
    let mut world = World::new(open(), &Settings::default().with_pixels(0.0)).unwrap();
    world.look([0.0, 2.0, 0.0], [0.0; 3]);
    world.settle();
    assert!(world.status().failed.is_empty(), "{:?}", world.status().failed);
    assert_eq!(places(world.scene()), places(&city.scene));
    world.look([0.0, 2.0, 1e6], [0.0; 3]);
    let mut far = World::new(open(), &Settings::default()).unwrap();
    far.look([0.0, 2.0, 1e5], [0.0; 3]);
    far.settle();
    assert!(far.scene().instance_count() < city.scene.instance_count() / 4);

    // The same tiles make the same scene, whenever each came.
    let mut walked = World::new(open(), &Settings::default().with_pixels(30.0)).unwrap();
    for step in 0..8 {
        walked.look([f64::from(step) * 40.0 - 160.0, 2.0, 0.0], [20.0, 0.0, 0.0]);
        walked.settle();
    }
    let mut at_once = World::new(open(), &Settings::default().with_pixels(30.0)).unwrap();
    at_once.look([120.0, 2.0, 0.0], [20.0, 0.0, 0.0]);
    at_once.settle();
    assert_eq!(walked.tiles(), at_once.tiles());
    let bounds = |scene: &Scene| scene.slots().map(|s| scene.bounds(s)).collect::<Vec<_>>();
    assert_eq!(bounds(walked.scene()), bounds(at_once.scene()));
}

#[test]
fn a_tile_is_shown_with_all_that_it_adds_to_and_the_budget_is_kept() {
    let (folder, _) = written("tiles-budget");
    let tiles = FolderTiles::open(&folder.tileset(), &options()).unwrap();
    let mut parent = vec![None; tiles.tree().tiles().len()];
    for (number, node) in tiles.tree().tiles().iter().enumerate() {
        node.children.iter().for_each(|&child| parent[child as usize] = Some(number as u64));
    }
    let mut sizes = BTreeSet::new();
    for budget in [40_000, 160_000, 640_000, 64 << 20] {
        let settings = Settings::default().with_budget(budget).with_pixels(1.0);
        let Ok(cut) = choose(&tiles, &[[0.0, 2.0, 0.0]], &settings, &|_| false) else { continue };
        assert!(cut.bytes <= budget);
        sizes.insert(cut.tiles.len());
        let shown: BTreeSet<TileId> = cut.tiles.iter().copied().collect();
        assert_eq!(shown.len(), cut.tiles.len(), "none twice");
        for tile in &cut.tiles {
            let above = parent[tile.0 as usize].map(TileId);
            assert!(above.is_none_or(|above| shown.contains(&above)));
        }
    }
    assert!(sizes.len() > 1, "{sizes:?}");
}

#[test]
fn nothing_visible_of_what_is_loaded_is_dropped() {
    let (folder, city) = written("tiles-proof");
    let tiles = FolderTiles::open(&folder.tileset(), &options()).unwrap();
    let mut world = World::new(tiles, &Settings::default().with_pixels(4.0)).unwrap();
    let size = [160, 90];
    let spec: PathSpec = "walk".parse().unwrap();
    let cameras = paths::cameras(&city, &spec, 3, size, &Overrides::default()).unwrap();
    let culler = Culler::balanced()
        .with_output(cullet::Output::Triangles)
        .with_dropped(true)
        .with_reasons(true);
    let mut culled = 0;
    for camera in cameras {
        let view = cullet::View::new(&camera, Overrides::default().depth, size).unwrap();
        let eye = view.eye();
        world.look([eye[0], eye[1], eye[2]], [0.0; 3]);
        world.settle();
        let (mut state, mut visible) = (ViewState::default(), Visible::default());
        culler.cull_one(world.scene(), &view, &mut state, &mut visible);
        culled += u64::from(world.scene().instance_count()) - visible.instance_count;
        let options = cullet_draw::VerifyOptions::default();
        let found = cullet_draw::verify(world.scene(), &view, &culler, &mut state, &options);
        assert!(found.false_culls.is_empty());
    }
    assert!(culled > 100);
}

#[test]
fn a_tile_that_is_missing_or_larger_than_was_said_is_named_and_the_rest_is_shown() {
    let (folder, _) = written("tiles-missing");
    let text = std::fs::read_to_string(folder.tileset()).unwrap();
    let tiles = FolderTiles::open(&folder.tileset(), &options()).unwrap();
    let leaf =
        (0..).zip(tiles.tree().tiles()).filter(|(_, n)| n.children.is_empty()).last().unwrap().0;
    std::fs::remove_file(folder.0.join(format!("tiles/{leaf}.glb"))).unwrap();
    let show = || {
        let tiles = FolderTiles::open(&folder.tileset(), &options()).unwrap();
        let mut world = World::new(tiles, &Settings::default().with_pixels(0.0)).unwrap();
        world.look([0.0, 2.0, 0.0], [0.0; 3]);
        world.settle();
        let failed: Vec<String> = world.status().failed.iter().map(ToString::to_string).collect();
        (world.scene().instance_count(), failed)
    };
    let (shown, failed) = show();
    assert!(failed.len() == 1 && failed[0].contains(&format!("tiles/{leaf}.glb")), "{failed:?}");
    assert!(shown > 100);
    let lies = text.replacen("\"instances\":", "\"instances\":0,\"were\":", 400);
    assert!(lies != text);
    std::fs::write(folder.tileset(), lies).unwrap();
    // The coarsest tile is loaded before all, and an error of it is one of the world.
    let (_, failed) = show();
    assert!(failed.iter().any(|f| f.contains("more than was said")), "{failed:?}");
}
