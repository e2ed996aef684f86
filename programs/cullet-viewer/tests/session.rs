//! A session without a window: what it shows is what the culler says, whatever was switched before.

use std::time::{Duration, Instant};

use cullet::cull::occlusion::Occlusion;
use cullet::{Culler, Output, ViewState, Visible, funnel::FunnelRow};
use cullet_viewer::compose::{Composition, Role, compose, instance_colours};
use cullet_viewer::nearness;
use cullet_viewer::script::{TOGGLES, thrown};
use cullet_viewer::session::Session;
use cullet_viewer::state::{By, CutAway, GhostForm, Layout, Part, Stages, Study};
use cullet_viewer::task::clock;
use cullet_viewer::ui::{self, Shown};
use cullet_viewer::world::Source;
use eframe::egui;

const SIZE: [u32; 2] = [480, 300];

/// A file's bytes, alone.
fn bytes(name: &str, bytes: &[u8]) -> Source {
    Source::Bytes { name: name.to_owned(), bytes: bytes.to_vec(), beside: Vec::new() }
}

fn begin(link: &str, scene: &str) -> Session {
    let ctx = egui::Context::default();
    let mut session = Session::new(ctx, link, Some(Source::of_text(scene)));
    settle(&mut session);
    session
}

/// Lets frames pass until all is decided.
fn settle(session: &mut Session) {
    let began = Instant::now();
    loop {
        session.advance(0.02, SIZE);
        if session.is_settled() && session.loading().is_none() {
            return;
        }
        assert!(began.elapsed() < Duration::from_secs(240), "it does not settle");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// The result of a culler without memory for the session's view.
fn direct(session: &Session) -> Visible {
    let world = session.world.as_ref().expect("loaded");
    let view = session.culling_view().expect("a view");
    let mut visible = Visible::default();
    let culler = session.state.stages.culler(clock);
    culler.cull_one(&world.model.scene, &view, &mut ViewState::default(), &mut visible);
    without_times(visible)
}

/// The same without what a clock said.
fn without_times(mut visible: Visible) -> Visible {
    visible.funnel.rows.iter_mut().for_each(|row| row.nanoseconds = FunnelRow::NO_TIME);
    visible
}

#[test]
fn every_switch_leaves_what_a_fresh_culler_says() {
    let mut session = begin("", "city:sub=1");
    let start = session.state.clone();
    for toggle in TOGGLES {
        session.state = thrown(&start, toggle).expect("a part of a link");
        settle(&mut session);
        let fresh = direct(&session);
        let shown = session.decision.as_ref().expect("decided").visible.clone();
        // Thousands of slots are no message.
        assert!(without_times(shown) == fresh, "{toggle}: another answer than a fresh culler's");
        let made = compose(&session);
        assert!(!made.panels.is_empty(), "{toggle}");
        for panel in &made.panels {
            assert_eq!(panel.view.viewport(), [panel.place[2], panel.place[3]], "{toggle}");
            let inside = panel.place[0] + panel.place[2] <= SIZE[0]
                && panel.place[1] + panel.place[3] <= SIZE[1];
            assert!(inside, "{toggle}: {:?}", panel.place);
        }
        let slots = session.world.as_ref().expect("loaded").model.scene.slot_count();
        assert_eq!(instance_colours(&session).len(), slots as usize);
    }
    assert!(session.notices.is_empty(), "{:?}", session.notices);
}

#[test]
fn every_switch_is_shown_without_a_window() {
    let ctx = egui::Context::default();
    let mut session = Session::new(ctx.clone(), "", Some(Source::of_text("solids")));
    let run = |session: &mut Session| {
        let screen = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(960.0, 600.0));
        let input = egui::RawInput { screen_rect: Some(screen), ..Default::default() };
        let mut out = ctx.run_ui(input, |ui| {
            ui::show(ui, session, |session, size| {
                session.advance(0.02, size);
                // At this size half of the window is left for the picture.
                assert!(size[0] >= 400 && size[1] >= 450, "{size:?}");
                (Shown::default(), compose(session))
            });
        });
        out.textures_delta.clear();
        assert!(!out.shapes.is_empty());
    };
    let began = Instant::now();
    while !session.is_settled() || session.world.is_none() {
        run(&mut session);
        assert!(began.elapsed() < Duration::from_secs(240));
    }
    let start = session.state.clone();
    session.help = true;
    run(&mut session);
    session.help = false;
    for toggle in TOGGLES {
        session.state = thrown(&start, toggle).expect("a part of a link");
        (0..3).for_each(|_| run(&mut session));
    }
    assert!(session.notices.is_empty(), "{:?}", session.notices);
}

#[test]
fn counters_are_those_of_a_report() {
    let mut session = begin("stages.depth=triangles", "city:sub=1");
    settle(&mut session);
    let world = session.world.as_ref().expect("loaded");
    let view = session.culling_view().expect("a view");
    // As `cullet report` sets it where nothing is said on the command line.
    let culler =
        Culler::default().with_output(Output::Triangles).with_occlusion(Occlusion::default());
    let mut visible = Visible::default();
    culler.cull_one(&world.model.scene, &view, &mut ViewState::default(), &mut visible);
    let shown = without_times(session.decision.as_ref().expect("decided").visible.clone());
    assert!(shown.funnel.same_counts(&visible.funnel));
    assert_eq!(shown.triangle_count, visible.triangle_count);
    assert!(visible.funnel.occlusion.drawn > 0, "nothing of a city is drawn as occluder");
}

#[test]
fn a_report_is_ordered_with_the_settings_that_are_shown() {
    let mut session = begin("stages.occlusion_width=320&stages.frustum=false", "city:sub=1");
    let order = session.order().expect("a scene and a camera");
    let (cameras, out) = (std::path::Path::new("it's here.json"), std::path::Path::new("out"));
    assert_eq!(
        order.command(cameras, out),
        r"cullet report city:sub=1 --path 'file:it'\''s here.json' --views 1 --size 480x300 --out out --occlusion-width 320 --occlusion-budget 200 --no-frustum"
    );
    session.travel(cullet_scenes::paths::PathSpec::Orbit);
    while session.journey.is_making() {
        session.advance(0.02, SIZE);
        std::thread::sleep(Duration::from_millis(2));
    }
    // A camera that moves on is never decided for.
    session.journey.playing = false;
    settle(&mut session);
    let cameras = session.journey.rigs.len();
    let order = session.order().expect("a path");
    assert!(order.views == 16 && cameras > 16);
    session.measure();
    settle(&mut session);
    let costs = session.measured.costs().expect("measured").clone();
    assert_eq!(costs.all.len(), cameras);
    assert!(
        costs.least < costs.most
            && costs.most <= session.world.as_ref().expect("loaded").counts.triangles
    );
    // The figures shown at a camera of the path are those measured there.
    session.state.layout = Layout::One;
    session.state.camera = Some(session.journey.rigs[40]);
    settle(&mut session);
    let shown = session.decision.as_ref().expect("decided").visible.triangle_count;
    assert_eq!(costs.all[40].triangles, shown);
}

#[test]
fn the_buffer_is_painted_as_depth_is() {
    let mut session = begin("layout=buffer", "city:sub=1");
    let decision = session.decision.as_ref().expect("decided");
    let buffer = decision.buffer.as_ref().expect("wanted");
    assert!(!decision.occluders.is_empty());
    let view = &decision.request.view;
    let paint = |tiles, over| nearness::paint(buffer, view, 100.0, tiles, over);
    let (fine, coarse, over) = (paint(false, false), paint(true, false), paint(false, true));
    assert_eq!(fine.size, buffer.size().map(|v| v as usize));
    assert_eq!(coarse.size, [fine.size[0].div_ceil(8), fine.size[1].div_ceil(4)]);
    let [w, h] = buffer.size();
    let mut covered = 0;
    for (i, (y, x)) in (0..h).flat_map(|y| (0..w).map(move |x| (y, x))).enumerate() {
        let near = buffer.nearness(x, y);
        let [r, g, b, a] = fine.pixels[i];
        assert_eq!(over.pixels[i][3] == 0, near == 0.0);
        if near > 0.0 {
            covered += 1;
            // A point seen at w, on a ray of its own, is where the shader measures its distance.
            let ray = view.ray([f64::from(x) + 0.5, f64::from(y) + 0.5]).expect("a ray");
            let ahead =
                view.ray([f64::from(w) * 0.5, f64::from(h) * 0.5]).expect("a ray").direction;
            let cos: f64 = (0..3).map(|k| ray.direction[k] * ahead[k]).sum();
            let want = 50.0 / (50.0 + 1.0 / f64::from(near) / cos) * 255.0;
            assert!((f64::from(r) - want).abs() <= 1.0 && r == g && g == b && a == 255);
        } else {
            assert_eq!([r, g, b], nearness::OPEN);
        }
    }
    assert!(covered > 1000, "a city covers more than {covered} pixels");
    session.state.stages.occlusion = false;
    settle(&mut session);
    let decision = session.decision.as_ref().expect("decided");
    assert!(decision.buffer.is_none() && decision.occluders.is_empty());
}

#[test]
fn an_invalid_link_shows_the_default_and_says_so() {
    let session = begin("stages.frustum=perhaps", "solids");
    assert_eq!(session.state.stages, Stages::default());
    let notice = &session.notices[0];
    assert!(notice.bad && notice.text.contains("The default is shown"), "{notice:?}");
}

#[test]
fn what_cannot_be_opened_is_told_and_what_was_open_stays() {
    let mut session = begin("", "solids");
    let camera = session.state.camera;
    for (source, part) in [
        (Source::File("no/such/file.glb".into()), "there is no file no/such/file.glb"),
        (bytes("a.glb", b"glTF broken"), "a.glb"),
        (bytes("notes.txt", b"hello"), "notes.txt"),
        (Source::Builtin("city:sub=999999".to_owned()), "sub"),
    ] {
        session.notices.clear();
        session.open(source);
        settle(&mut session);
        let told = &session.notices.last().expect("told").text;
        assert!(told.contains(part) && told.contains("stays open"), "{told}");
        assert_eq!(session.world.as_ref().expect("still open").name, "solids");
        assert_eq!(session.state.camera, camera);
    }
    session.open(Source::of_text("office"));
    settle(&mut session);
    assert_eq!(session.state.scene, "office");
    assert_ne!(session.state.camera, camera);
}

#[test]
fn a_missing_tileset_says_what_to_try() {
    let empty = std::env::temp_dir().join(format!("cullet-no-tiles-{}", std::process::id()));
    std::fs::create_dir_all(&empty).expect("a folder of ours");
    for path in [std::path::PathBuf::from("no/such/tileset.json"), empty.clone()] {
        let name = path.display().to_string();
        let source = Some(Source::File(path));
        let mut session = Session::new(egui::Context::default(), "", source);
        settle(&mut session);
        let [notice] = &session.notices[..] else { panic!("{:?}", session.notices) };
        let has = |part: &str| notice.text.contains(part);
        assert!(notice.bad && has(&name) && has("tileset.json"), "{notice:?}");
        assert!(has("cullet tiles SCENE -o FOLDER") && has("city:n=1e8"), "{notice:?}");
    }
    std::fs::remove_dir_all(&empty).expect("ours to remove");
}

#[test]
fn a_city_that_is_larger_than_memory_opens_by_its_coarsest_tiles() {
    let session = begin("", "city:n=2e7");
    let world = session.world.as_ref().expect("loaded");
    assert!(world.is_tiled() && world.is_large() && !world.model.materials.is_empty());
    assert_eq!(session.state.scene, "city:n=2e7");
    let figures = session.tile_figures().expect("in tiles");
    assert!(figures.tiles > 0 && figures.bytes <= figures.budget, "{figures:?}");
    // One begins above the roofs of what is around the middle, whatever the size of the city.
    let [x, y, z] = session.culling_rig().expect("a camera").eye();
    assert!(x.hypot(z) < 500.0 && (20.0..300.0).contains(&y), "{x} {y} {z}");
    assert!(!begin("", "city:n=1000").world.expect("loaded").is_tiled());
}

#[test]
fn freezing_keeps_what_is_drawn_and_flying_out_comes_back() {
    let mut session = begin("", "city:sub=1");
    let before = session.decision.as_ref().expect("decided").visible.clone();
    let camera = session.state.camera;
    session.toggle_outside();
    settle(&mut session);
    assert_ne!(session.state.camera, camera);
    assert!(session.decision.as_ref().expect("decided").visible == before);
    if let Some(rig) = &mut session.state.camera {
        rig.turn(50.0, -10.0);
    }
    settle(&mut session);
    assert!(session.decision.as_ref().expect("decided").visible == before);
    session.toggle_outside();
    assert_eq!(session.state.camera, camera);
    assert_eq!(session.state.frozen, None);
}

fn middle(made: &Composition, role: Role) -> [f64; 2] {
    let panel = made.panels.iter().find(|p| p.role == role).expect("shown");
    let [x, y, w, h] = panel.place.map(f64::from);
    [x + w * 0.5, y + h * 0.5]
}

#[test]
fn a_click_tells_why_a_thing_is_drawn_or_not() {
    let mut session = begin("map=false", "city:sub=1");
    let made = compose(&session);
    let panel = made.at(middle(&made, Role::Flown)).expect("a pane").clone();
    session.inspect(&panel.view, [240.0, 150.0]);
    let alive = session.inspected.clone().expect("the city fills the middle");
    assert_eq!(alive.explanation.reason, None);
    assert!(alive.explanation.steps.iter().all(|s| s.left > 0 && !s.to_string().is_empty()));
    // From inside the city most of it is outside of the frustum; from outside, its ghosts can be
    // clicked.
    let target = session.world.as_ref().expect("loaded").centre;
    if let Some(rig) = &mut session.state.camera {
        (rig.target, rig.distance) = (target, 5.0);
    }
    session.state.ghosts.form = GhostForm::Solid;
    session.toggle_outside();
    settle(&mut session);
    let made = compose(&session);
    let panel = made.panels[0].clone();
    let mut dead = None;
    for x in (20..480).step_by(40) {
        for y in (20..300).step_by(40) {
            session.inspect(&panel.view, [f64::from(x), f64::from(y)]);
            dead = dead.or(session.inspected.clone().filter(|i| i.explanation.reason.is_some()));
        }
    }
    let dead = dead.expect("something that was dropped is seen from outside");
    let shown = &session.decision.as_ref().expect("decided").visible;
    assert_eq!(shown.reasons[dead.slot as usize], dead.explanation.reason);
    assert_eq!(dead.explanation.steps.last().map(|s| s.left), Some(0));
}

#[test]
fn the_two_halves_of_a_wipe_are_one_picture() {
    let mut session = begin("map=false", "city:sub=1");
    session.state.layout = Layout::One;
    let whole = compose(&session).panels[0].view.clone();
    session.state.layout = Layout::Wipe;
    session.state.wipe = 0.25;
    let made = compose(&session);
    let target = session.state.camera.expect("fitted").target;
    let [x, y, _] = whole.project_point(target).expect("before the eye");
    for panel in &made.panels {
        let [u, v, _] = panel.view.project_point(target).expect("before the eye");
        assert!((u + f64::from(panel.place[0]) - x).abs() < 1e-6 && (v - y).abs() < 1e-6);
    }
}

#[test]
fn the_proof_finds_nothing_lost_and_colours_what_is_hidden() {
    let mut session = begin("", "city:sub=1");
    session.prove();
    settle(&mut session);
    let found = session.truth.finding().expect("proved");
    assert!(found.lost.is_empty());
    assert!(found.visible > 0 && found.visible <= found.kept && found.kept <= found.all);
    assert!(found.unseen_count > 0, "some of a city hides the rest");
    let unseen = cullet_draw::palette::UNSEEN;
    let orange = instance_colours(&session).iter().filter(|c| c[..3] == unseen).count();
    assert_eq!(orange as u64, found.unseen_count);
}

#[test]
fn a_cut_is_a_scene_of_its_own_and_goes_as_it_came() {
    let mut session = begin("map=false", "city:sub=1");
    let whole = session.world.clone().expect("loaded");
    let before = session.decision.as_ref().expect("decided").visible.clone();
    let camera = session.state.camera;
    session.state.cut = CutAway { on: true, at: 0.1, ..CutAway::default() };
    settle(&mut session);
    let cut = session.world.clone().expect("cut");
    assert!(cut.counts.instances < whole.counts.instances && cut.counts.instances > 0);
    assert!(session.cutting.report.cap_triangles > 0 && !session.cutting.outlines.is_empty());
    assert_eq!((cut.reach, cut.centre), (whole.reach, whole.centre));
    let shown = session.decision.as_ref().expect("decided").visible.clone();
    assert!(without_times(shown) == direct(&session), "another answer than a fresh culler's");
    // Another cut is of the whole scene, not of what is left.
    session.state.cut.part = Part::Outside;
    settle(&mut session);
    let other = session.world.as_ref().expect("cut").counts;
    let both = other.instances + cut.counts.instances;
    assert_eq!(both, whole.counts.instances + session.cutting.report.instances_cut);
    session.face_cut();
    settle(&mut session);
    assert!(!compose(&session).panels.is_empty());
    (session.state.cut.on, session.state.camera) = (false, camera);
    settle(&mut session);
    assert!(std::sync::Arc::ptr_eq(&whole, session.world.as_ref().expect("whole")));
    let after = session.decision.as_ref().expect("decided").visible.clone();
    assert!(without_times(after) == without_times(before));
    assert!(session.notices.is_empty(), "{:?}", session.notices);
}

#[test]
fn a_cut_that_leaves_nothing_is_told_and_what_was_shown_stays() {
    let mut session = begin("cut.on=true&cut.at=2&cut.part=outside", "solids");
    let told = &session.notices.last().expect("told").text;
    assert!(told.contains("leaves nothing") && told.contains("stays"), "{told}");
    assert!(session.world.as_ref().expect("whole").counts.instances > 0);
    // The next scene is cut too.
    session.notices.clear();
    session.state.cut = CutAway { on: true, ..CutAway::default() };
    session.open(Source::of_text("city:sub=1"));
    settle(&mut session);
    assert!(session.cutting.report.instances_cut > 0 && session.notices.is_empty());
    assert_eq!(session.state.scene, "city:sub=1");
}

#[test]
fn what_is_studied_of_a_thing_is_there_as_long_as_it_is_inspected() {
    let mut session = begin("map=false", "solids");
    session.state.study = Study { cube: true, by: By::Masks, ..Study::default() };
    session.state.structure.outcodes = true;
    session.state.structure.volume = true;
    settle(&mut session);
    assert!(session.figures.is_none() && session.coded().is_none());
    let of_view = session.cube().expect("a view has lines of sight");
    let world = session.world.clone().expect("loaded");
    let scene = &world.model.scene;
    let slot = scene.slots().max_by_key(|&s| scene.mesh(s).triangle_count()).expect("some");
    let handle = scene.handle(slot).expect("some");
    let plain = compose(&session);
    session.inspect_handle(handle, 0);
    settle(&mut session);
    let figures = session.figures.clone().expect("studied");
    assert!(figures.proved.len() as u32 <= figures.away && figures.away < figures.triangles);
    assert_ne!(session.cube().expect("outside of it").cone, of_view.cone);
    assert!(!figures.proved.is_empty());
    assert_eq!(session.coded().expect("a triangle").corners.len(), 3);
    let made = compose(&session);
    let ghosts = |c: &Composition| c.panes(None).iter().map(|p| p.ghosts.len()).sum::<usize>();
    assert!(made.volume.is_some());
    assert!(ghosts(&made) >= ghosts(&plain) + figures.proved.len() * 3);
    // It follows the eye.
    if let Some(rig) = &mut session.state.camera {
        rig.turn(180.0, 0.0);
    }
    settle(&mut session);
    assert_ne!(session.figures.as_ref().expect("studied").proved, figures.proved);
    session.inspected = None;
    settle(&mut session);
    assert!(session.figures.is_none());
}

#[test]
fn the_audit_tells_that_bounds_hold() {
    let mut session = begin("structure.audit=true", "solids");
    assert_eq!(session.audit.found(), Some(&[][..]));
    session.open(Source::of_text("office"));
    settle(&mut session);
    assert_eq!(session.audit.found(), Some(&[][..]));
    session.state.structure.audit = false;
    settle(&mut session);
    assert_eq!(session.audit.found(), None);
}

#[test]
fn a_door_that_is_shut_hides_what_was_behind_it() {
    let room = "camera.target=[26.6,1.7,18.2]&camera.distance=6&camera.yaw=-8&camera.pitch=-4&camera.near=0.05\
                &stages.occlusion=false&structure.portals=true&structure.cells=true";
    let mut session = begin(room, "office");
    let chain = |session: &Session| session.cells.chain.clone().expect("wanted");
    let kept =
        |session: &Session| session.decision.as_ref().expect("decided").visible.instance_count;
    let (open, left) = (chain(&session), kept(&session));
    let reached = open.reached.as_ref().expect("in a room").len();
    assert!(reached > 1 && !open.steps.is_empty(), "{open:?}");

    // Every portal out of the room.
    for step in open.steps.iter().filter(|step| step.depth == 1) {
        session.toggle_portal(step.portal);
    }
    settle(&mut session);
    session.advance(0.02, SIZE);
    let shut = chain(&session);
    assert_eq!(shut.reached.as_deref(), open.cell.map(|cell| vec![cell]).as_deref());
    assert!(shut.steps.is_empty() && !shut.doors.is_empty());
    assert!(kept(&session) < left, "{} of {left}", kept(&session));
    // A link says so.
    assert!(session.link().contains("doors=["), "{}", session.link());

    session.state.doors.clear();
    settle(&mut session);
    session.advance(0.02, SIZE);
    assert_eq!((chain(&session).steps, kept(&session)), (open.steps, left));
    // Without the stage, what is beyond walls is kept.
    session.state.stages.portal = false;
    settle(&mut session);
    assert!(kept(&session) > left, "{} of {left}", kept(&session));
    session.toggle_portal(u32::MAX);
    assert!(session.state.doors.is_empty());
}

#[test]
fn what_pops_is_marked_and_what_fades_does_not_come_at_once() {
    let mut session = begin("stages.detail_px=8&look.colour=pops", "city:sub=1");
    let near = session.state.camera.expect("fitted");
    let mut far = near;
    far.distance *= 1.3;
    session.state.camera = Some(far);
    settle(&mut session);
    let went = session.pops.went.clone();
    assert!(went.len() > 20, "{}", session.pops.text());
    let reasons = &session.decision.as_ref().expect("decided").visible.reasons;
    let small =
        |slot: &u32| reasons[*slot as usize].map(|r| r.stage) == Some(cullet::Stage::Detail);
    assert!(went.iter().all(small));
    session.state.camera = Some(near);
    settle(&mut session);
    // The way back is the same way.
    assert_eq!((&session.pops.came, session.pops.went.len()), (&went, 0));
    let green =
        instance_colours(&session).iter().filter(|c| c[1] > c[0].saturating_add(90)).count();
    assert_eq!(green, went.len());

    // Those that just came are hardly drawn, those that are large are drawn in full.
    session.state.stages.detail_fade = 1.0;
    session.state.camera = Some(far);
    settle(&mut session);
    session.state.camera = Some(near);
    settle(&mut session);
    let colours = instance_colours(&session);
    let came = session.pops.came.iter().map(|&slot| colours[slot as usize][3]);
    let (least, most) = (came.clone().min().unwrap_or(0), came.max().unwrap_or(255));
    assert!(least < 40 && most < 200, "{least} {most}");
    assert!(colours.iter().any(|c| c[3] == 255));
    assert!(compose(&session).panels.iter().all(|p| p.role == Role::Flown));
}
