//! A level of detail fades into the next: at half time each pixel is of one or the other, and none
//! of neither.

use std::time::{Duration, Instant};

use cullet::lod::Lod;
use cullet::{Culler, Instance, Scene, Stage, Transform, View, ViewState, Visible};
use cullet_gpu::{Tier, testing};
use cullet_io::baked::{Baked, BakedLevels, BakedMesh, LevelKind, Measured, geometry_hash};
use cullet_io::{Model, save};
use cullet_testkit::Folder;
use cullet_testkit::steps::Balls;
use cullet_viewer::compose::{compose, instance_colours};
use cullet_viewer::decide::pick;
use cullet_viewer::draw::{Pane, Renderer, Style};
use cullet_viewer::fades::{Cut, Fades};
use cullet_viewer::headless::{self, Gpu};
use cullet_viewer::session::Session;
use cullet_viewer::world::Source;
use eframe::egui;

const SIZE: [u32; 2] = [300, 200];
const GROUND: [f32; 3] = [0.1, 0.12, 0.15];

/// A baked file with a ball and its chain of levels.
fn file() -> Source {
    let mut scene = Scene::new();
    let mesh = Balls::new(&[40, 20, 10, 6], 1.0).add_to(&mut scene);
    scene.add(Instance::new(mesh, Transform::IDENTITY)).unwrap();
    scene.sort();
    let measured =
        Measured { points: 1, reverse_points: 1, quantile: 0.999, most_over: 1.2, seed: 1 };
    let levels = vec![BakedLevels { kind: LevelKind::Chain, held_by: 1, measured }];
    let geometry = geometry_hash(&scene.meshes()[0]);
    let one = BakedMesh { mesh, geometry, levels, ..BakedMesh::default() };
    let baked = Some(Baked { meshes: vec![one], ..Baked::default() });
    let model = Model { scene, mesh_names: vec!["ball".into()], baked, ..Model::default() };
    let folder = Folder::new("fading");
    let path = folder.root().join("ball.glb");
    save(&model, &path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    Source::Bytes { name: "ball.glb".into(), bytes, beside: Vec::new() }
}

/// Lets frames of `dt` seconds pass until something is so.
fn until(session: &mut Session, dt: f64, is_so: impl Fn(&Session) -> bool) {
    let began = Instant::now();
    while !is_so(session) {
        assert!(began.elapsed() < Duration::from_secs(240), "it never comes");
        session.advance(dt, SIZE);
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// The ball from near and then from afar, where the new level has just begun to come.
fn begun(link: &str) -> Session {
    let mut session = Session::new(egui::Context::default(), link, Some(file()));
    until(&mut session, 0.02, Session::is_settled);
    assert!(session.fades.is_empty(), "the first picture comes at once");
    let levels = session.world.as_ref().map(|w| w.model.scene.levels(0).len());
    assert_eq!(levels, Some(1));
    let mut rig = session.state.camera.expect("fitted");
    rig.distance *= 3.0;
    session.state.camera = Some(rig);
    let before = session.decision.as_ref().map(|d| d.number);
    until(&mut session, 0.0, |s| s.decision.as_ref().map(|d| d.number) != before);
    session
}

type Picture = Vec<[u8; 3]>;

fn picture(gpu: &Gpu, renderer: &mut Renderer, panes: &[Pane<'_>]) -> Picture {
    renderer.draw(&gpu.device, &gpu.queue, SIZE, GROUND, panes);
    let (_, pixels) = headless::picture(gpu, renderer).expect("the device is there");
    pixels.into_iter().map(|[r, g, b, _]| [r, g, b]).collect()
}

#[test]
fn at_half_time_there_are_pixels_of_both_and_no_hole() {
    let Some(gpu) = testing::device(Tier::Draw, cullet_testkit::skip) else { return };
    let link = "layout=one&stages.lod_px=1&stages.lod_fade=0.5&look.colour=levels";
    let mut session = begun(link);
    assert_eq!(session.fades.len(), 1);
    assert!(!session.is_settled());
    session.advance(0.25, SIZE);
    assert_eq!(session.fades.shares().collect::<Vec<_>>(), [(0, 0.5)]);
    let world = session.world.clone().expect("loaded");
    let mut renderer = Renderer::new(&gpu.adapter, &gpu.device);
    renderer.set_scene(&gpu.device, &gpu.queue, &world.model).unwrap();
    renderer.set_instance_colours(&gpu.queue, &instance_colours(&session));
    let made = compose(&session);
    let decided = session.decision.as_ref().map(|d| &d.visible);
    let panes = made.panes(decided);
    assert_eq!(panes.len(), 2);
    let half = picture(gpu, &mut renderer, &panes);
    let style = Style { fade: false, going: false, ..panes[0].style };
    let mut alone = |visible: Option<&Visible>| {
        let pane = Pane { visible, style, lines: &[], overlay: &[], ghosts: &[], ..panes[0] };
        picture(gpu, &mut renderer, &[pane])
    };
    let (old, new) = (alone(Some(session.fades.going())), alone(decided));
    let ground = old[0];
    let (mut of_old, mut of_new, mut all, mut neither) = (0, 0, 0, 0);
    for ((&old, &new), &half) in old.iter().zip(&new).zip(&half) {
        assert!(half != ground || old == ground || new == ground, "a hole");
        if old != ground && new != ground && old != new {
            all += 1;
            of_old += usize::from(half == old);
            of_new += usize::from(half == new);
            neither += usize::from(half != old && half != new);
        }
    }
    let told = format!("of {all} pixels {of_old} old, {of_new} new, {neither} neither");
    assert!(all > 400 && neither == 0, "{told}");
    assert!(of_old * 20 > all * 9 && of_new * 20 > all * 9, "{told}");

    session.advance(0.26, SIZE);
    assert!(session.fades.is_empty() && session.refresh);
    let made = compose(&session);
    let panes = made.panes(session.decision.as_ref().map(|d| &d.visible));
    assert_eq!(panes.len(), 1);
    renderer.set_instance_colours(&gpu.queue, &instance_colours(&session));
    assert_eq!(picture(gpu, &mut renderer, &panes), new);
}

#[test]
fn nothing_fades_where_that_is_not_asked_for() {
    let session = begun("layout=one&stages.lod_px=1");
    assert!(session.fades.is_empty());
    assert!(instance_colours(&session).iter().all(|c| c[3] == 255));
    // Nor where the camera moves and the level stays.
    let mut session = begun("layout=one&stages.lod_px=64&stages.lod_fade=0.5");
    until(&mut session, 0.0, Session::is_settled);
    assert!(session.fades.is_empty());
}

/// Three balls in a row, and a large one that stands for them from afar.
fn group() -> Scene {
    let mut scene = Scene::new();
    let ball = Balls::new(&[40, 20, 10, 6], 1.0).add_to(&mut scene);
    let large = Balls::new(&[24, 12, 6], 1.0).add_to(&mut scene);
    let mut at = |mesh, scale, x| {
        let place = Transform::from_scale_translation([scale; 3], [x, 0.0, 0.0]);
        scene.add(Instance::new(mesh, place)).unwrap()
    };
    let members = [-2.0, 0.0, 2.0].map(|x| at(ball, 1.0, x));
    let own = at(large, 3.0, 0.0);
    scene.stand_for(own, &members).unwrap();
    scene.commit(&Culler::default());
    scene
}

/// Decides for an eye that looks along the line to the group or away from it, and returns that with
/// what levels alone draw.
fn decided(scene: &Scene, distance: f64, away: bool) -> [Visible; 2] {
    let target = [0.0, 0.0, if away { distance * 2.0 } else { 0.0 }];
    let view = View::perspective([0.0, 0.0, distance], target, 1.0, 0.1, 1e5, SIZE).unwrap();
    let all = Culler::default().with_lod(Lod::default()).with_reasons(true);
    let mut alone = all.only(Stage::Lod);
    alone.lod = Some(Lod::default().with_stand_ins(false));
    [all, alone].map(|culler| {
        let mut visible = Visible::default();
        culler.cull_one(scene, &view, &mut ViewState::default(), &mut visible);
        visible
    })
}

#[test]
fn groups_and_their_members_fade_into_each_other() {
    let scene = group();
    let own = scene.stand_in_slots().next().unwrap();
    let members: Vec<u32> = scene.slots().collect();
    let [near, far] = [20.0, 600.0].map(|distance| decided(&scene, distance, false));
    let away = decided(&scene, 600.0, true);
    assert!(near[0].slots().eq(members.iter().copied()));
    assert!(far[0].slots().eq([own]) && away[0].slots().next().is_none());
    let cut = |[visible, alone]: &'static [Visible; 2]| Cut { visible, alone };
    let [near, far, away] = [near, far, away].map(|d| cut(Box::leak(Box::new(d))));
    let mut fades = Fades::default();
    fades.follow(&scene, [near, far], |_| false);
    assert_eq!(fades.len(), 4);
    assert!(fades.going().slots().eq(members.iter().copied()), "all members go");
    fades.clear();
    fades.follow(&scene, [far, near], |_| false);
    assert!(fades.len() == 4 && fades.going().slots().eq([own]), "the group goes");
    for turned in [[away, far], [away, near], [near, away]] {
        fades.clear();
        fades.follow(&scene, turned, |_| false);
        assert!(fades.is_empty(), "what comes into the picture or leaves it does not fade");
    }
}

#[test]
fn a_click_finds_a_group() {
    let scene = group();
    let view = View::perspective([0.0, 0.0, 50.0], [0.0; 3], 1.0, 0.1, 1e5, SIZE).unwrap();
    let ray = view.ray([150.0, 100.0]).unwrap();
    let hit = |wanted: &dyn Fn(u32) -> bool| pick(&scene, &ray, wanted).map(|hit| hit.slot);
    let own = scene.stand_in_slots().next();
    assert_eq!(hit(&|slot| scene.is_stand_in(slot)), own);
    assert!(hit(&|slot| !scene.is_stand_in(slot)).is_some_and(|slot| Some(slot) != own));
}
