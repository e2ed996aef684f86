//! A world in tiles: what is shown of it is what is to be loaded for the eye, and it is drawn like
//! any other scene.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use cullet_io::LoadOptions;
use cullet_maps::WriteTiles;
use cullet_maps::write_tiles;
use cullet_tiles::{FolderTiles, Settings, TileSource, choose};
use cullet_viewer::draw::{Pane, Renderer, Style};
use cullet_viewer::session::Session;
use cullet_viewer::state::Sides;
use cullet_viewer::tiles::BUDGET;
use cullet_viewer::world::{Source, World};
use eframe::egui;

use crate::gpu::{BACKGROUND_BYTES, Tier, gpu, pane, shot};

const SIZE: [u32; 2] = [320, 200];

/// A small city as a tileset of many tiles; it goes when it is dropped.
struct Tileset {
    folder: PathBuf,
    instances: u64,
}

impl Tileset {
    fn write(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("cullet-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        let city = cullet_scenes::build("city:cells=8,objects=800").expect("built in");
        let mut small = WriteTiles::default();
        (small.triangles, small.instances) = (3000, 60);
        let written = write_tiles(&city, &folder, &small, |_| true).expect("written");
        assert!(written.expect("not stopped").tiles[0] > 20);
        Self { folder, instances: city.scene.instance_count().into() }
    }

    /// The instances of the tiles that matter for an eye, from what the tileset says of each.
    fn wanted(&self, eye: [f64; 3]) -> u64 {
        let path = self.folder.join("tileset.json");
        let tiles = FolderTiles::open(&path, &LoadOptions::default()).expect("a tileset");
        let settings = Settings::default().with_budget(BUDGET);
        let cut = choose(&tiles, &[eye], &settings, &|_| false).expect("it fits");
        cut.tiles.iter().map(|&tile| u64::from(tiles.info(tile).instances)).sum()
    }
}

impl Drop for Tileset {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// Lets pictures pass until something holds.
fn until(session: &mut Session, holds: impl Fn(&Session) -> bool) {
    let began = Instant::now();
    while !holds(session) {
        session.advance(0.02, SIZE);
        assert!(began.elapsed() < Duration::from_secs(240), "it does not settle");
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn settle(session: &mut Session) {
    session.advance(0.02, SIZE);
    until(session, |s| s.is_settled() && s.loading().is_none());
}

fn shown(session: &Session) -> Arc<World> {
    Arc::clone(session.world.as_ref().expect("loaded"))
}

fn eye(session: &Session) -> [f64; 3] {
    session.culling_rig().expect("a camera").eye()
}

/// Flies away from what is looked at, or towards it.
fn zoom(session: &mut Session, factor: f64) {
    session.state.camera.iter_mut().for_each(|rig| rig.zoom(factor));
}

#[test]
fn a_tileset_is_shown_as_far_as_it_matters_and_drawn() {
    let tileset = Tileset::write("viewer-tiles");
    let source = Some(Source::File(tileset.folder.join("tileset.json")));
    let mut session = Session::new(egui::Context::default(), "map=false", source);
    session.settles = true;
    settle(&mut session);
    let near = shown(&session);
    assert!(near.is_tiled() && session.notices.is_empty(), "{:?}", session.notices);
    assert_eq!(near.counts.instances, tileset.wanted(eye(&session)));
    let figures = session.tile_figures().expect("in tiles");
    assert!(figures.tiles > 1 && figures.wanted == 0 && figures.failure.is_none(), "{figures:?}");

    // From far away less of it matters, and the place that one flies about in stays the same.
    zoom(&mut session, 1.0 / 40.0);
    settle(&mut session);
    let far = shown(&session);
    assert_eq!(far.counts.instances, tileset.wanted(eye(&session)));
    assert!(far.counts.instances < near.counts.instances, "{:?}", far.counts);
    assert_eq!((far.reach, far.centre, far.half), (near.reach, near.centre, near.half));

    // What is frozen keeps its tiles, wherever one flies.
    session.toggle_freeze();
    zoom(&mut session, 160.0);
    settle(&mut session);
    assert!(Arc::ptr_eq(&shown(&session), &far));
    session.toggle_freeze();
    settle(&mut session);
    let close = shown(&session);
    assert_eq!(close.counts.instances, tileset.wanted(eye(&session)));
    assert!(close.counts.instances >= near.counts.instances);
    assert!(close.counts.instances <= tileset.instances);

    // Sides are made of what is there, and what comes has them.
    session.state.sides = Sides::TwoSided;
    settle(&mut session);
    assert_eq!(shown(&session).sides, Sides::TwoSided);
    zoom(&mut session, 1.0 / 4.0);
    settle(&mut session);
    assert_eq!(shown(&session).sides, Sides::TwoSided);
    assert_eq!(shown(&session).counts, near.counts);

    let Some(gpu) = gpu(Tier::Draw) else { return };
    let mut renderer = Renderer::new(&gpu.adapter, &gpu.device);
    renderer.set_scene(&gpu.device, &gpu.queue, &shown(&session).model).expect("it fits");
    let view = session.culling_view().expect("a view");
    let all = shot(gpu, &mut renderer, pane(&view, Style::default()));
    all.save("tiles.png");
    assert!(all.covered(BACKGROUND_BYTES) > 2000 && all.colours() > 3);
    let visible = &session.decision.as_ref().expect("decided").visible;
    let culled = Pane { visible: Some(visible), ..pane(&view, Style::default()) };
    assert_eq!(all.differing(&shot(gpu, &mut renderer, culled)), 0);
}

#[test]
fn tiles_come_while_one_flies_and_go_with_the_scene() {
    let tileset = Tileset::write("viewer-flight");
    // Its folder will do.
    let source = Some(Source::File(tileset.folder.clone()));
    let mut session = Session::new(egui::Context::default(), "", source);
    until(&mut session, |s| s.world.is_some());
    let coarsest = shown(&session);
    // Nothing is waited for: pictures go on with what is there.
    assert!(coarsest.is_tiled());
    until(&mut session, |s| s.is_settled() && shown(s).counts.instances == tileset.wanted(eye(s)));
    assert!(shown(&session).counts.instances > coarsest.counts.instances);
    for _ in 0..50 {
        session.state.camera.iter_mut().for_each(|rig| rig.shift(0.0, 1.0, 5.0));
        session.advance(0.02, SIZE);
        assert!(session.decision.is_some());
    }
    until(&mut session, |s| s.is_settled() && shown(s).counts.instances == tileset.wanted(eye(s)));
    session.clear();
    settle(&mut session);
    assert!(session.world.is_none() && session.tile_figures().is_none());
}
