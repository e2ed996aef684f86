//! Sides and first sight: a closed model opens with its back faces culled, an open one says why
//! they are kept and is culled as soon as it is taken for one-sided.

use std::time::{Duration, Instant};

use cullet::{Output, ViewState, Visible};
use cullet_testkit::data;
use cullet_testkit::soups::lumpy_ball_as_obj as ball;
use cullet_viewer::camera::Rig;
use cullet_viewer::compose::{Role, compose};
use cullet_viewer::session::Session;
use cullet_viewer::state::{CutAway, Layout, Manner, Sides, Stages};
use cullet_viewer::task::clock;
use cullet_viewer::world::{Source, World};
use eframe::egui;

const SIZE: [u32; 2] = [900, 600];

fn obj(name: &str, text: &str) -> Source {
    Source::Bytes { name: name.to_owned(), bytes: text.as_bytes().to_vec(), beside: Vec::new() }
}

fn begin(link: &str, source: Source) -> Session {
    let mut session = Session::new(egui::Context::default(), link, Some(source));
    settle(&mut session);
    session
}

/// Lets frames pass until all is decided.
fn settle(session: &mut Session) {
    settle_in(session, SIZE);
}

fn settle_in(session: &mut Session, size: [u32; 2]) {
    let began = Instant::now();
    loop {
        session.advance(0.02, size);
        if session.is_settled() && session.loading().is_none() {
            return;
        }
        assert!(began.elapsed() < Duration::from_secs(240), "it does not settle");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Returns the share of all triangles that is left to draw.
fn left(session: &Session) -> f64 {
    let all = session.world.as_ref().expect("loaded").counts.triangles;
    session.decision.as_ref().expect("decided").visible.triangle_count as f64 / all as f64
}

/// How many triangles a culler leaves that remembers nothing.
fn direct(session: &Session) -> u64 {
    let world = session.world.as_ref().expect("loaded");
    let view = session.culling_view().expect("a view");
    let culler = session.state.stages.culler(clock);
    let mut visible = Visible::default();
    culler.cull_one(&world.model.scene, &view, &mut ViewState::default(), &mut visible);
    visible.triangle_count
}

#[test]
fn a_closed_solid_opens_with_half_of_its_faces_culled_and_seen_to_be() {
    let armadillo = data("armadillo/armadillo.obj").map(Source::File);
    let bunny = data("stanford-bunny/bunny-closed-7k.off").map(Source::File);
    let closed = [Some(obj("ball.obj", &ball(0))), armadillo, bunny];
    for source in closed.into_iter().flatten() {
        let name = source.name();
        let session = begin("", source);
        let left = left(&session);
        assert!((0.35..0.6).contains(&left), "{name}: {left} of the faces are drawn");
        assert_eq!(session.kept_backs(), None, "{name}");
        // Beside what the camera sees there is a view that shows what was dropped: from aside, with
        // all of it.
        let made = compose(&session);
        assert_eq!(
            made.panels.iter().map(|p| p.role).collect::<Vec<_>>(),
            [Role::Culling, Role::Outside]
        );
        let [eye, aside] = [0, 1].map(|i| glam::DVec4::from(made.panels[i].view.eye()).truncate());
        let centre = glam::DVec3::from(session.world.as_ref().expect("loaded").centre);
        let turned = (eye - centre).angle_between(aside - centre).to_degrees();
        assert!((60.0..150.0).contains(&turned), "{name}: {turned}");
        assert_eq!(made.panels[1].view.cull_face, cullet::view::CullFace::None);
    }
}

#[test]
fn an_open_mesh_says_why_and_is_culled_once_it_is_taken_for_one_sided() {
    let mut session = begin("", obj("ball.obj", &ball(2)));
    let before = left(&session);
    assert!(before > 0.9, "{before}");
    let sentence = session.kept_backs().expect("its backs are kept");
    assert_eq!(
        sentence,
        "no back face is culled: the mesh is two-sided, since it is open: 4 boundary edges"
    );
    let stored = session.world.clone().expect("loaded");
    session.state.sides = Sides::OneSided;
    settle(&mut session);
    let after = left(&session);
    assert!((0.4..0.6).contains(&after), "{after}");
    assert_eq!(
        session.decision.as_ref().expect("decided").visible.triangle_count,
        direct(&session)
    );
    assert_eq!(session.kept_backs(), None);
    let world = session.world.clone().expect("loaded");
    assert_eq!(
        (world.counts, world.centre, world.reach),
        (stored.counts, stored.centre, stored.reach)
    );
    assert!(session.link().contains("sides=one-sided"), "{}", session.link());
    session.state.sides = Sides::TwoSided;
    settle(&mut session);
    assert!(session.kept_backs().expect("kept").ends_with("since that was chosen"));
    assert_eq!(left(&session), before);
    session.state.sides = Sides::Automatic;
    settle(&mut session);
    assert_eq!((left(&session), session.kept_backs()), (before, Some(sentence)));
    // Where back faces are not to be culled there is nothing to explain.
    session.state.stages = Stages::frustum_only();
    assert_eq!(session.kept_backs(), None);
    assert!(session.notices.is_empty(), "{:?}", session.notices);
}

#[test]
fn a_link_and_a_report_carry_the_sides_and_the_next_scene_does_not() {
    let mut session = begin("sides=one-sided", obj("ball.obj", &ball(2)));
    assert!((0.4..0.6).contains(&left(&session)));
    let order = session.order().expect("a scene and a camera");
    assert!(order.arguments("c".as_ref(), "o".as_ref()).contains(&"--one-sided".to_owned()));
    session.open(Source::of_text("no/such/file.ply"));
    settle(&mut session);
    assert_eq!(session.state.sides, Sides::OneSided, "what stays open stays as it is");
    session.open(obj("other.obj", &ball(2)));
    settle(&mut session);
    assert_eq!(session.state.sides, Sides::Automatic);
    assert!(left(&session) > 0.9);
}

#[test]
fn a_cut_is_of_the_scene_with_the_sides_that_are_shown() {
    let mut session =
        begin("cut.on=true&cut.caps=false&sides=two-sided", obj("ball.obj", &ball(0)));
    let cut = session.world.clone().expect("cut");
    assert!(!std::sync::Arc::ptr_eq(&cut, session.whole().expect("loaded")));
    assert_eq!(session.whole().expect("loaded").sides, Sides::TwoSided);
    session.state.sides = Sides::OneSided;
    settle(&mut session);
    assert_eq!(session.whole().expect("loaded").sides, Sides::OneSided);
    assert_ne!(
        session.world.as_ref().map(|w| w.counts.triangles),
        session.whole().map(|w| w.counts.triangles)
    );
    session.state.cut = CutAway::default();
    settle(&mut session);
    assert_eq!(session.world.as_ref().map(|w| w.sides), Some(Sides::OneSided));
}

#[test]
fn what_was_chosen_is_not_changed_by_the_first_sight_of_a_scene() {
    let chosen = begin("stages.frustum=false", obj("ball.obj", &ball(0)));
    assert_eq!(chosen.state.layout, Layout::One);
    assert_eq!(chosen.state.stages.depth, Output::Clusters);
    let mut session = begin("", obj("ball.obj", &ball(0)));
    assert_eq!(
        (session.state.layout, session.state.stages.depth),
        (Layout::Split, Output::Triangles)
    );
    // In the midst of a large scene the usual settings show enough; what nobody chose goes again.
    session.open(Source::of_text("city:sub=1"));
    settle(&mut session);
    assert_eq!(Manner::of(&session.state), Manner::default());
    session.open(obj("ball.obj", &ball(0)));
    settle(&mut session);
    session.state.look.wireframe = true;
    session.open(Source::of_text("city:sub=1"));
    settle(&mut session);
    assert!(session.state.look.wireframe && session.state.layout == Layout::Split);
}

/// Whether all of a scene is within the picture of the culling camera.
fn is_in_sight(session: &Session) -> bool {
    let world: &World = session.world.as_ref().expect("loaded");
    let (size, scene) = (session.culling_size().map(f64::from), &world.model.scene);
    let view = session.culling_view().expect("a view");
    scene.mesh(0).positions().iter().all(|p| {
        let [x, y, _] = view.project_point(p.map(f64::from)).expect("before the eye");
        (0.0..size[0]).contains(&x) && (0.0..size[1]).contains(&y)
    })
}

#[test]
fn a_camera_that_nobody_moved_fits_its_pane() {
    let mut session = begin("", obj("ball.obj", &ball(0)));
    let half = session.state.camera.expect("fitted");
    assert!(session.culling_size() == [450, 600] && is_in_sight(&session));
    session.state.layout = Layout::One;
    settle(&mut session);
    let whole = session.state.camera.expect("fitted");
    assert!(whole.distance < half.distance && is_in_sight(&session));
    session.state.layout = Layout::Split;
    settle_in(&mut session, [500, 800]);
    assert!(session.culling_size() == [250, 800] && is_in_sight(&session));
    // One that was moved stays where it is.
    let moved = Rig { yaw: 12.0, ..whole };
    session.state.camera = Some(moved);
    session.state.layout = Layout::Split;
    settle(&mut session);
    assert_eq!(session.state.camera, Some(moved));
    session.fit();
    settle(&mut session);
    assert!(is_in_sight(&session));
}
