//! States and their links.

use cullet::Output;
use cullet_viewer::camera::{Mode, Rig};
use cullet_viewer::clipping::{Clipping, SIDES};
use cullet_viewer::link::{MAX_LENGTH, from_text, to_text};
use cullet_viewer::script::{TOGGLES, thrown};
use cullet_viewer::state::{
    By, Colour, CutAway, GhostForm, Layout, OnDevice, Part, Shape, Sides, State, Study,
};
use proptest::prelude::*;

fn rig() -> impl Strategy<Value = Rig> {
    let mode = prop_oneof![Just(Mode::Orbit), Just(Mode::Fly), Just(Mode::Top)];
    let place = prop::array::uniform3(-1e12..1e12f64);
    let shape = (1e-9..1e12f64, -1e6..1e6f64, -89.0..89.0f64, 1.0..150.0f64, 1e-12..1e9f64);
    (mode, place, shape).prop_map(|(mode, target, (distance, yaw, pitch, fov, near))| Rig {
        mode,
        target,
        distance,
        yaw,
        pitch,
        fov,
        near,
    })
}

prop_compose! {
    fn cut()(
        switches in prop::array::uniform5(any::<bool>()),
        normal in prop::array::uniform3(0.1..1.0f64),
        at in -2.0..=2.0f64,
        low in prop::array::uniform3(-2.0..=2.0f64),
        high in prop::array::uniform3(-2.0..=2.0f64),
    ) -> CutAway {
        let [on, caps, outlines, plane, inside] = switches;
        let shape = if plane { Shape::Plane } else { Shape::Box };
        let part = if inside { Part::Inside } else { Part::Outside };
        CutAway { on, shape, normal, at, low, high, part, caps, outlines }
    }
}

prop_compose! {
    fn taught()(
        open in any::<bool>(),
        polygon in prop::collection::vec(prop::array::uniform2(-1.0..=1.0f64), 3..=12),
        sides in SIDES,
        (cube, cells, groups) in (any::<bool>(), 1..=18u32, 1..=1024u32),
        by in prop::sample::select(By::ALL.map(|b| b.0).to_vec()),
    ) -> (Clipping, Study) {
        let step = groups % (sides + 1);
        (Clipping { open, polygon, sides, step }, Study { cube, cells, groups, by })
    }
}

prop_compose! {
    fn state()(
        scene in ".{0,40}",
        camera in prop::option::of(rig()),
        frozen in prop::option::of(rig()),
        layout in prop::sample::select(vec![Layout::One, Layout::Split, Layout::Wipe, Layout::Buffer]),
        wipe in 0.0..=1.0f32,
        switches in prop::array::uniform8(any::<bool>()),
        detail in 0.0..1e6f64,
        depth in prop_oneof![Just(Output::Instances), Just(Output::Clusters), Just(Output::Triangles)],
        colour in prop::sample::select(Colour::ALL.map(|c| c.0).to_vec()),
        hidden in prop::collection::vec(".{0,8}", 0..4),
        level in 0..=64u32,
        cut in cut(),
        (clipping, study) in taught(),
    ) -> State {
        let mut s =
            State { scene, camera, frozen, layout, wipe, cut, clipping, study, ..State::default() };
        [s.map, s.stages.on, s.stages.frustum, s.look.fill, s.look.wireframe, s.structure.cones, s.dark, s.always] =
            switches;
        (s.stages.detail_px, s.stages.depth, s.look.colour) = (detail, depth, colour);
        s.ghosts.form = if level > 30 { GhostForm::Boxes } else { GhostForm::Solid };
        s.ghosts.hidden = hidden;
        s.sides = Sides::ALL[level as usize % 3].0;
        (s.stages.portal, s.structure.portals) = (level % 2 > 0, level % 3 > 0);
        (s.doors, s.structure.step) = ((0..level % 4).collect(), level);
        s.structure.level = level;
        s.device = OnDevice { on: level % 2 > 0, compare: level % 3 > 0, level: level % 16 };
        (s.stages.lod_px, s.stages.lod_steady) = (detail * 0.5, level % 2 > 0);
        (s.stages.lod_triangles, s.stages.lod_ball) = (u64::from(level), f64::from(level) / 64.0);
        s.stages.detail_fade = f64::from(level) * 0.125;
        (s.stages.lod_fade, s.stages.lod_impostors) = (f64::from(level) / 64.0, level % 3 == 0);
        (s.structure.volume, s.structure.outcodes, s.structure.audit) = (level % 2 > 0, level % 3 > 0, level % 5 > 0);
        s
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cullet_testkit::cases(300), ..ProptestConfig::default() })]

    #[test]
    fn a_link_leads_back_to_its_state(state in state()) {
        let text = to_text(&state);
        prop_assert_eq!(from_text(&text), Ok(state.clone()), "{}", text);
        prop_assert_eq!(from_text(&format!("#{text}")), Ok(state));
        let plain = text.bytes().all(|b| b.is_ascii_graphic() && !b"\"<>#\\^`{|}".contains(&b));
        prop_assert!(plain, "{} does not fit an address", text);
    }

    #[test]
    fn no_text_gives_an_invalid_state(text in ".{0,200}") {
        if let Ok(state) = from_text(&text) {
            prop_assert_eq!(from_text(&to_text(&state)), Ok(state));
        }
    }
}

#[test]
fn a_default_state_has_an_empty_link() {
    assert_eq!(to_text(&State::default()), "");
    assert_eq!(from_text(""), Ok(State::default()));
}

#[test]
fn links_are_readable() {
    let mut state = State { scene: "forest:n=1000".to_owned(), ..State::default() };
    state.stages.frustum = false;
    assert_eq!(to_text(&state), "scene=forest:n%3D1000&stages.frustum=false");
}

#[test]
fn an_invalid_value_is_named() {
    for (text, part) in [
        ("scene", "'scene' is not of the form"),
        ("scene=%zz", "'scene=%zz' is not of the form"),
        ("colour=red", "unknown field `colour`"),
        ("stages.frustum=7", "invalid type"),
        ("scene.a.b=1", "'scene.a.b' is not the name of a setting"),
        ("camera.distance=0", "camera.distance is 0; it must be between"),
        ("camera.pitch=90", "camera.pitch is 90"),
        ("camera.target=[1e300,0,0]", "camera.target is 1e"),
        ("camera.near=1e999", "the link cannot be read"),
        ("wipe=2", "wipe is 2"),
        ("scene=city&wipe=%22no%22&dark=false", "cannot be read: wipe=%22no%22: invalid type"),
        ("stages.detail_px=-1", "stages.detail_px is -1"),
        ("stages.lod_px=-1", "stages.lod_px is -1"),
        ("stages.lod_fade=-1", "stages.lod_fade is -1"),
        ("stages.lod_ball=-1", "stages.lod_ball is -1"),
        ("stages.detail_fade=1e9", "stages.detail_fade is 1e9"),
        ("structure.level=65", "structure.level is 65"),
        ("device.level=16", "device.level is 16; it must be 15 at most"),
        ("structure.step=4097", "structure.step is 4097"),
        ("doors=[-1]", "invalid value"),
        ("cut.at=3", "a place of cut is 3; it must be between -2 and 2"),
        ("cut.normal=[0,0,0]", "the length of cut.normal is 0"),
        ("cut.shape=ball", "unknown variant `ball`"),
        ("study.cells=19", "study.cells is 19"),
        ("study.groups=0", "study.groups is 0"),
        ("clipping.polygon=[[0,0],[1,1]]", "the corners of clipping.polygon is 2"),
        ("clipping.polygon=[[0,0],[1,1],[0,1e9]]", "clipping.polygon is 1e9"),
        ("clipping.sides=9", "clipping.sides is 9"),
        ("clipping.step=5", "clipping.step is 5"),
        ("layout=three", "unknown variant `three`"),
    ] {
        let error = from_text(text).expect_err(text).to_string();
        assert!(error.contains(part), "{text}: {error}");
    }
    let long = "a".repeat(MAX_LENGTH + 1);
    assert!(from_text(&long).expect_err("too long").to_string().contains("at most 16384"));
}

/// Every leaf of a state, by its name in links.
fn leaves(value: &serde_json::Value, name: &str, out: &mut Vec<String>) {
    match value {
        serde_json::Value::Object(map) => {
            for (key, value) in map {
                let dot = if name.is_empty() { "" } else { "." };
                leaves(value, &format!("{name}{dot}{key}"), out);
            }
        }
        _ => out.push(name.to_owned()),
    }
}

#[test]
fn the_script_forgets_no_switch() {
    let mut all = Vec::new();
    leaves(&serde_json::to_value(State::default()).expect("plain data"), "", &mut all);
    let script = TOGGLES.join("&");
    for leaf in all {
        let named = script.split('&').any(|p| p.starts_with(&leaf));
        assert!(named, "no step of the script throws {leaf}");
    }
    for toggle in TOGGLES {
        assert!(thrown(&State::default(), toggle).is_some(), "{toggle}");
    }
}
