//! Worlds that are loaded in part, against all that is there.

use std::sync::atomic::{AtomicU32, Ordering};

use cullet::{Camera, Culler, Depth, Instance, Mesh, Projection, Scene, View, ViewState, Visible};
use cullet_tiles::{
    CityTiles, Settings, TileContent, TileError, TileId, TileInfo, TileSource, World, choose,
};

/// Returns the contents of a scene, in its order.
fn held(scene: &Scene) -> Vec<(u64, u32, [u64; 3])> {
    scene
        .slots()
        .map(|s| {
            (scene.user_data(s), scene.mesh_id(s), scene.transform(s).translation.map(f64::to_bits))
        })
        .collect()
}

fn view(eye: [f64; 3], target: [f64; 3]) -> View {
    let projection =
        Projection::Perspective { fov_y_radians: 1.0, aspect: 1.5, near: 0.2, far: f64::INFINITY };
    View::new(&Camera::look_at(eye, target, projection), Depth::Reversed, [320, 213]).unwrap()
}

fn visible(scene: &Scene, view: &View, culler: &Culler) -> Vec<u64> {
    let (mut state, mut visible) = (ViewState::default(), Visible::default());
    culler.cull_one(scene, view, &mut state, &mut visible);
    let mut names: Vec<u64> = visible.slots().map(|s| scene.user_data(s)).collect();
    names.sort_unstable();
    names
}

fn settled(source: impl TileSource, settings: &Settings, eye: [f64; 3]) -> World {
    let mut world = World::new(source, settings).unwrap();
    world.look(eye, [0.0; 3]);
    world.settle();
    world
}

/// A ground plan of 1 m squares is enough: each point lies in one tile of a cut.
#[test]
fn each_place_is_in_one_tile_of_every_cut() {
    let city = CityTiles::new(2_000_000, 2);
    for (eye, pixels) in [([0.0; 3], 4.0), ([3000.0, 5.0, -900.0], 1.0), ([0.0, 900.0, 0.0], 60.0)]
    {
        let settings = Settings::default().with_pixels(pixels);
        let cut = choose(&city, &[eye], &settings, &|_| false).unwrap();
        let count: u64 = cut.tiles.iter().map(|&t| u64::from(city.info(t).instances)).sum();
        assert!(cut.tiles.is_sorted() && !cut.is_cut_short && count > 1000);
        let reach = city.city().reach();
        let mut point = 0.37;
        for _ in 0..2000 {
            point = (point * 997.31_f64 + 0.113).fract();
            let x = (point - 0.5) * 2.0 * (reach - 3.0);
            point = (point * 997.31_f64 + 0.113).fract();
            let z = (point - 0.5) * 2.0 * (reach - 3.0);
            let within = |t: &&TileId| {
                let [low, high] = city.info(**t).bounds;
                // Bounds are grown by 1 m on every side.
                low[0] + 1.0 <= x && x < high[0] - 1.0 && low[2] + 1.0 <= z && z < high[2] - 1.0
            };
            assert_eq!(cut.tiles.iter().filter(within).count(), 1, "{x} {z}");
        }
        // Where the eye is everything is there; and what is coarse is within its error.
        for &tile in &cut.tiles {
            let info = city.info(tile);
            let nearest = (0..3)
                .map(|a| (info.bounds[0][a] - eye[a]).max(eye[a] - info.bounds[1][a]).max(0.0))
                .map(|d| d * d)
                .sum::<f64>()
                .sqrt();
            assert!(info.error * settings.scale <= settings.pixels * nearest + 1e-9);
        }
    }
}

#[test]
fn bounds_and_counts_are_those_of_what_is_loaded() {
    let city = CityTiles::new(500_000, 5);
    let mut tiles = city.roots();
    let mut at = 0;
    while at < tiles.len() {
        let tile = tiles[at];
        at += 1;
        let before = tiles.len();
        city.children(tile, &mut tiles);
        let info = city.info(tile);
        for &child in &tiles[before..] {
            let [low, high] = city.info(child).bounds;
            let finer = city.info(child).error < info.error;
            assert!(
                finer
                    && (0..3).all(|a| info.bounds[0][a] <= low[a] && high[a] <= info.bounds[1][a])
            );
        }
        let content = city.load(tile).unwrap();
        assert!(content.instances.len() <= info.instances as usize);
        assert_eq!(city.load(tile).unwrap().instances, content.instances);
        let mut scene = Scene::new();
        let ids: Vec<u32> = city.meshes().iter().map(|m| scene.add_mesh(m.clone())).collect();
        assert_eq!(ids.len(), city.meshes().len());
        for &instance in &content.instances {
            scene.add(instance).unwrap();
        }
        scene.commit(&Culler::default());
        let extent = scene.extent();
        for a in 0..3 {
            assert!(f64::from(extent.min[a]) >= info.bounds[0][a] - 1e-2, "{tile:?}");
            assert!(f64::from(extent.max[a]) <= info.bounds[1][a] + 1e-2, "{tile:?}");
        }
    }
    assert!(tiles.len() > 60, "{}", tiles.len());
}

#[test]
fn what_is_wholly_loaded_is_the_whole_city_and_culls_alike() {
    let city = CityTiles::new(40_000, 7);
    let mut whole = Scene::new();
    for mesh in city.meshes() {
        whole.add_mesh(mesh.clone());
    }
    let mut plots = Vec::new();
    for z in 0..city.city().side() {
        for x in 0..city.city().side() {
            city.city().add_all(x, z, &mut plots);
        }
    }
    for (k, placed) in plots.iter().enumerate() {
        let instance =
            Instance { user_data: k as u64, ..Instance::new(placed.mesh, placed.transform) };
        whole.add(instance).unwrap();
    }
    whole.commit(&Culler::default());
    let eye = [12.0, 1.7, 12.0];
    let world = settled(CityTiles::new(40_000, 7), &Settings::default().with_pixels(0.0), eye);
    assert_eq!(world.scene().instance_count(), plots.len() as u32);
    let places = |scene: &Scene| {
        let mut places: Vec<_> =
            held(scene).into_iter().map(|(_, mesh, place)| (mesh, place)).collect();
        places.sort_unstable();
        places
    };
    assert_eq!(places(world.scene()), places(&whole));
    for target in [[300.0, 1.7, 12.0], [12.0, 40.0, -300.0]] {
        let (view, culler) = (view(eye, target), Culler::exact());
        let count = |scene: &Scene| visible(scene, &view, &culler).len();
        let (streamed, all) = (count(world.scene()), count(&whole));
        assert!(streamed * 20 < plots.len() && streamed > 3);
        // Trees of the two differ, so that what is kept for caution may.
        assert!(streamed.abs_diff(all) * 50 <= all + 50, "{streamed} {all}");
    }
}

#[test]
fn nothing_visible_of_what_is_loaded_is_dropped() {
    let settings = Settings::default().with_pixels(30.0);
    let world = settled(CityTiles::new(3_000_000, 3), &settings, [12.0, 1.7, 12.0]);
    assert!(world.tiles().len() > 4 && world.scene().instance_count() > 20_000);
    for (eye, target) in [
        ([12.0, 1.7, 12.0], [400.0, 1.7, 12.0]),
        ([0.0, 60.0, 0.0], [-500.0, 0.0, 300.0]),
        ([0.0, 1500.0, 0.0], [1.0, 0.0, 1.0]),
    ] {
        let (view, culler) = (view(eye, target), Culler::balanced());
        let kept = visible(world.scene(), &view, &culler);
        // What stands in the middle of a pixel of a picture that culls nothing.
        let proof = cullet_draw::verify(
            world.scene(),
            &view,
            &culler,
            &mut ViewState::default(),
            &cullet_draw::VerifyOptions::default(),
        );
        assert!(proof.false_culls.is_empty() && proof.visible > 0, "{:?}", proof.false_culls);
        assert!(kept.len() * 2 < world.scene().instance_count() as usize);
    }
    // What stands in for something finer hides nothing.
    let block = city_block(&world);
    assert!(block > 0);
}

/// Blocks of a scene, none of which may hide anything.
fn city_block(world: &World) -> usize {
    let scene = world.scene();
    let block = cullet_scenes::CityPlots::block();
    let blocks: Vec<u32> = scene.slots().filter(|&s| scene.mesh_id(s) == block).collect();
    assert!(blocks.iter().all(|&s| scene.flags(s).no_occlusion));
    blocks.len()
}

#[test]
fn the_budget_is_kept_and_the_way_there_does_not_matter() {
    let eyes: Vec<[f64; 3]> =
        (0..6).map(|k| [f64::from(k) * 700.0 - 2000.0, 1.7, f64::from(k * k) * 90.0]).collect();
    for budget in [8_u64 << 20, 40 << 20] {
        let settings = Settings::default().with_budget(budget).with_pixels(0.5);
        let mut walker = World::new(CityTiles::new(5_000_000, 1), &settings).unwrap();
        for &eye in &eyes {
            walker.look(eye, [0.0; 3]);
            walker.settle();
            let status = walker.status();
            assert!(status.bytes <= budget && status.bytes > budget / 3, "{status:?}");
            assert!(status.is_cut_short && status.wanted.is_empty());
        }
        let jumper = settled(CityTiles::new(5_000_000, 1), &settings, eyes[5]);
        assert_eq!(walker.tiles(), jumper.tiles());
        assert!(held(walker.scene()) == held(jumper.scene()));
        let (view, culler) = (view(eyes[5], [0.0, 1.7, 0.0]), Culler::balanced());
        assert_eq!(
            visible(walker.scene(), &view, &culler),
            visible(jumper.scene(), &view, &culler)
        );
    }
    let none = Settings::default().with_budget(1000);
    let error = World::new(CityTiles::new(5_000_000, 1), &none).unwrap_err();
    assert!(matches!(error, TileError::Budget { budget: 1000, .. }), "{error}");
}

/// A city of which some tiles cannot be loaded, and others say more than they are.
struct Torn {
    city: CityTiles,
    tries: std::sync::Arc<AtomicU32>,
    heals: bool,
}

impl TileSource for Torn {
    fn meshes(&self) -> &[Mesh] {
        self.city.meshes()
    }

    fn roots(&self) -> Vec<TileId> {
        self.city.roots()
    }

    fn info(&self, tile: TileId) -> TileInfo {
        self.city.info(tile)
    }

    fn children(&self, tile: TileId, out: &mut Vec<TileId>) {
        self.city.children(tile, out);
    }

    fn load(&self, tile: TileId) -> Result<TileContent, TileError> {
        let content = self.city.load(tile)?;
        let is_leaf = self.city.info(tile).error == 0.0;
        if !is_leaf {
            return Ok(content);
        }
        let tries = self.tries.fetch_add(1, Ordering::Relaxed);
        if self.heals && tries > 0 {
            return Ok(content);
        }
        if tile.0.is_multiple_of(2) {
            return Err(TileError::Load { tile: tile.0, reason: "the file is cut short".into() });
        }
        let twice = [&content.instances[..], &content.instances[..]].concat();
        Ok(TileContent { instances: twice, ..TileContent::default() })
    }
}

#[test]
fn a_tile_that_cannot_be_loaded_is_named_once_and_what_is_coarser_stays() {
    let tries = std::sync::Arc::new(AtomicU32::new(0));
    let torn = |heals| Torn { city: CityTiles::new(400_000, 4), tries: tries.clone(), heals };
    let eye = [5.0, 1.7, 5.0];
    let mut world = settled(torn(false), &Settings::default(), eye);
    let leaves = |world: &World| world.tiles().iter().filter(|t| t.0 >> 48 == 0).count();
    assert_eq!(leaves(&world), 0);
    let failed = world.status().failed.clone();
    assert!(!failed.is_empty());
    let texts: Vec<String> = failed.iter().map(ToString::to_string).collect();
    assert!(texts.iter().any(|t| t.contains("cut short") || t.contains("its header")), "{texts:?}");
    let before = tries.load(Ordering::Relaxed);
    world.look([6.0, 1.7, 5.0], [0.0; 3]);
    world.settle();
    assert_eq!(tries.load(Ordering::Relaxed), before, "not tried again");
    assert_eq!(world.status().failed, failed);
    drop(world);
    tries.store(0, Ordering::Relaxed);
    let mut world = settled(torn(true), &Settings::default(), eye);
    assert_eq!(world.status().failed.len(), 1);
    world.forgive();
    world.settle();
    assert!(leaves(&world) > 0 && world.status().failed.is_empty());
}

#[test]
fn eyes_that_are_nowhere_change_nothing() {
    let mut world = settled(CityTiles::new(100_000, 4), &Settings::default(), [0.0; 3]);
    let before = world.tiles().to_vec();
    for eye in [[f64::NAN; 3], [f64::INFINITY, 0.0, 0.0]] {
        world.look(eye, [f64::NAN; 3]);
        world.settle();
        assert_eq!(world.tiles(), before);
    }
    world.look([1e30; 3], [0.0; 3]);
    world.settle();
    assert!(world.tiles().len() < before.len());
}
