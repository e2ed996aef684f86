//! Tiles that stand in for those below them, against what they stand for.

use std::collections::BTreeSet;

use cullet::{
    Camera, Culler, Depth, Mesh, Projection, Scene, View, ViewState, prepared::Preparation,
};
use cullet_bake::stand_in::{StandInOptions, StandIns};
use cullet_draw::surface::SurfaceTree;
use cullet_draw::surface::surface_points;
use cullet_draw::{PixelId, RenderOptions, Selection, VerifyOptions};
use cullet_io::{Attributes, LoadOptions, Model};
use cullet_maps::TileInput;
use cullet_maps::TileStandIn;
use cullet_maps::TilesWritten;
use cullet_maps::WriteTiles;
use cullet_maps::load;
use cullet_maps::write_tiles;
use cullet_maps::write_tiles_with;
use cullet_testkit::Folder;
use cullet_tiles::{FolderTiles, Settings, TileId, TileSource, World, choose};

const CITY: &str = "city:cells=6,objects=400,ground=0";

fn options() -> LoadOptions {
    LoadOptions { prepare: Preparation::NONE, ..LoadOptions::default() }
}

/// Small enough that there are many tiles.
fn small() -> WriteTiles {
    let mut small = WriteTiles::default();
    (small.triangles, small.instances) = (3000, 60);
    small
}

/// A city in a folder, with stand-ins of so many triangles.
fn written(folder: &Folder, triangles: u64) -> (Model, TilesWritten) {
    let city = cullet_scenes::build(CITY).unwrap();
    let of_triangles = StandInOptions::default().with_triangles(triangles);
    let stand_ins = StandIns::new(&city.scene, &[], of_triangles);
    let stand_in = |slots: &[u32], least: f64| {
        stand_ins.of(slots, least).map(|made| TileStandIn {
            mesh: Mesh::new(made.mesh).unwrap(),
            attributes: Attributes::default(),
            origin: made.origin,
            error: made.error,
        })
    };
    let input = TileInput::default().with_stand_ins(&stand_in);
    let written = write_tiles_with(&city, folder.root(), &small(), &input, |_| true);
    let written = written.unwrap().unwrap();
    (city, written)
}

fn open(folder: &Folder) -> FolderTiles {
    FolderTiles::open(&folder.root().join("tileset.json"), &options()).unwrap()
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

/// The tiles below a tile that have none below them, or it alone.
fn finest(tiles: &FolderTiles, tile: u32) -> Vec<u32> {
    let node = &tiles.tree().tiles()[tile as usize];
    match &node.children[..] {
        [] => vec![tile],
        children => children.iter().flat_map(|&child| finest(tiles, child)).collect(),
    }
}

/// Positions around the origin of the world, and indices.
fn surface(scene: &Scene, slot: u32) -> (Vec<[f32; 3]>, Vec<u32>) {
    let (mesh, m) = (scene.mesh(slot), scene.transform(slot).to_matrix());
    let place = |p: &[f32; 3]| -> [f32; 3] {
        let [x, y, z] = p.map(f64::from);
        std::array::from_fn(|a| (m[a] * x + m[4 + a] * y + m[8 + a] * z + m[12 + a]) as f32)
    };
    (mesh.positions().iter().map(place).collect(), mesh.indices().to_vec())
}

#[test]
fn a_tile_that_is_replaced_stands_for_all_below_it_within_its_error() {
    let folder = Folder::new("stand-ins");
    let (city, written) = written(&folder, 1500);
    assert!(written.stand_ins > 3 && written.stand_in_triangles > 1000, "{written:?}");
    let tiles = open(&folder);
    let (mut stand_ins, mut left_out, mut instances) = (0, 0, 0);
    for (number, node) in (0..).zip(tiles.tree().tiles()) {
        assert!(!node.adds);
        if node.children.is_empty() {
            instances += tiles.info(TileId(number.into())).instances;
            continue;
        }
        for &child in &node.children {
            assert!(tiles.tree().tiles()[child as usize].error <= node.error);
        }
        if node.is_empty() {
            continue;
        }
        stand_ins += 1;
        let coarse = tiles.tree().load(number).unwrap().scene;
        assert_eq!((coarse.instance_count(), coarse.slots().count()), (1, 1));
        assert!(coarse.triangle_count() <= 1500);
        let content = tiles.load(TileId(number.into())).unwrap();
        assert!(content.instances.iter().all(|i| i.flags.no_occlusion), "it hides nothing");
        let (positions, indices) = surface(&coarse, coarse.slots().next().unwrap());
        let tree = SurfaceTree::new(&positions, &indices);
        for leaf in finest(&tiles, number) {
            let fine = tiles.tree().load(leaf).unwrap().scene;
            for slot in fine.slots() {
                let (positions, indices) = surface(&fine, slot);
                let points = surface_points(&positions, &indices, 20, 1);
                let far = points.iter().map(|p| tree.nearest(p.point, f32::INFINITY).unwrap().0);
                let far = f64::from(far.fold(0.0, f32::max));
                let b = fine.bounds(slot);
                let across = (0..3).map(|a| f64::from(b.max[a] - b.min[a]).powi(2)).sum::<f64>();
                let room = node.error * 1.0001 + 1e-3;
                assert!(far <= room || across.sqrt() <= room, "{far} of {}", node.error);
                left_out += u32::from(far > room);
            }
        }
    }
    assert_eq!(stand_ins, written.stand_ins);
    assert_eq!(instances, city.scene.instance_count());
    assert!(left_out > 100, "small ones are left out: {left_out}");
    // Whoever reads it whole has everything once, and no stand-in.
    let back = load(&folder.root().join("tileset.json"), &options()).unwrap();
    assert_eq!(places(&back.scene), places(&city.scene));
}

#[test]
fn each_place_is_in_one_tile_of_every_cut_and_the_budget_is_kept() {
    let folder = Folder::new("stand-ins");
    written(&folder, 1500);
    let tiles = open(&folder);
    let all: BTreeSet<u32> = finest(&tiles, 0).into_iter().collect();
    let mut sizes = BTreeSet::new();
    for budget in [1 << 20, 2 << 20, 4 << 20, 64 << 20] {
        for pixels in [0.0, 4.0, 60.0] {
            let settings = Settings::default().with_budget(budget).with_pixels(pixels);
            let cut = choose(&tiles, &[[0.0, 2.0, 0.0]], &settings, &|_| false).unwrap();
            assert!(cut.bytes <= budget);
            sizes.insert(cut.tiles.len());
            let of: Vec<u32> = cut.tiles.iter().flat_map(|t| finest(&tiles, t.0 as u32)).collect();
            assert_eq!(of.len(), all.len(), "none twice");
            assert_eq!(of.into_iter().collect::<BTreeSet<_>>(), all, "none missing");
        }
    }
    assert!(sizes.len() > 1, "{sizes:?}");
}

/// The share of pixels of the whole city's picture that a world shows, whatever instance it is that it shows there.
fn shown(world: &World, whole: &Scene, view: &View) -> f64 {
    let covered = |scene: &Scene| {
        let options = RenderOptions::default();
        let picture = cullet_draw::render(scene, view, Selection::All, &options);
        picture.ids.iter().map(|id| *id != PixelId::NONE).collect::<Vec<bool>>()
    };
    let (own, all) = (covered(world.scene()), covered(whole));
    let both = own.iter().zip(&all).filter(|&(a, b)| *a && *b).count();
    both as f64 / all.iter().filter(|b| **b).count().max(1) as f64
}

#[test]
fn what_is_far_away_is_shown_coarse_instead_of_not_at_all_and_hides_nothing() {
    let (coarse, plain) = (Folder::new("stand-ins"), Folder::new("stand-ins"));
    let (city, _) = written(&coarse, 1500);
    write_tiles(&city, plain.root(), &small(), |_| true).unwrap().unwrap();
    let extent = city.scene.extent();
    let reach = f64::from(extent.max[0] - extent.min[0]);
    let eye = [reach * 1.5, reach * 0.3, 0.0];
    let projection =
        Projection::Perspective { fov_y_radians: 0.6, aspect: 1.5, near: 1.0, far: f64::INFINITY };
    let camera = Camera::look_at(eye, [0.0; 3], projection);
    let view = View::new(&camera, Depth::Reversed, [240, 160]).unwrap();
    // Just enough for the coarsest tile.
    let coarsest = choose(&open(&coarse), &[], &Settings::default(), &|_| true).unwrap();
    let settings = Settings::default().with_budget(coarsest.bytes + 4096).with_pixels(2.0);
    let settle = |folder: &Folder| {
        let mut world = World::new(open(folder), &settings).unwrap();
        world.look(eye, [0.0; 3]);
        world.settle();
        assert!(world.status().failed.is_empty(), "{:?}", world.status().failed);
        world
    };
    let [with, without] = [&coarse, &plain].map(settle);
    let share = |world: &World| shown(world, &city.scene, &view);
    let (with_share, without_share) = (share(&with), share(&without));
    assert!(with_share > 0.8, "{with_share}");
    assert!(with_share > without_share + 0.1, "{with_share} {without_share}");
    let culler = Culler::balanced();
    let options = VerifyOptions::default();
    for world in [&with, &without] {
        let state = &mut ViewState::default();
        let found = cullet_draw::verify(world.scene(), &view, &culler, state, &options);
        assert!(found.visible > 0 && found.false_culls.is_empty());
    }
}
