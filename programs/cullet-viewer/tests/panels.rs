//! Panels without a window: keys are pressed and buttons clicked as a user would, and what comes of
//! it is read.

mod shown;

use cullet_testkit::soups::lumpy_ball_as_obj;
use cullet_viewer::compose::compose;
use cullet_viewer::draw::DeviceFigures;
use cullet_viewer::link;
use cullet_viewer::session::{Session, funnel_json};
use cullet_viewer::state::GhostForm;
use cullet_viewer::ui::shortcuts::{TABLE, markdown};
use cullet_viewer::world::Source;
use eframe::egui::{self, Key, Pos2};

use shown::Panels;

/// A file's bytes, alone.
fn bytes(name: &str, bytes: &[u8]) -> Source {
    Source::Bytes { name: name.to_owned(), bytes: bytes.to_vec(), beside: Vec::new() }
}

#[test]
fn every_key_does_something() {
    let mut panels = Panels::open("solids", "cut.on=true");
    panels.travel();
    let clear = |panels: &mut Panels| {
        let s = &mut panels.session;
        (s.help, s.refresh, s.shoot) = (false, false, false);
        s.end_tour();
        s.journey.playing = false;
        s.state.cut.on = true;
        panels.copied = None;
    };
    for (key, _) in TABLE.iter().flat_map(|(_, lines)| *lines).flat_map(|line| line.keys) {
        // It would open a dialog on the screen of whoever tests.
        if *key == Key::L {
            continue;
        }
        // Without a scene there is little for a key to do.
        if *key == Key::Backslash {
            continue;
        }
        // They are about portals, of which there are none here.
        if [Key::OpenBracket, Key::CloseBracket, Key::Delete].contains(key) {
            continue;
        }
        clear(&mut panels);
        // Something other than what these set, and something to close.
        match key {
            Key::Num1 => panels.press(Key::Num2),
            Key::Num8 => panels.press(Key::Num9),
            Key::Home => panels.press(Key::ArrowLeft),
            Key::Comma => panels.press(Key::Period),
            Key::Escape => panels.press(Key::H),
            _ => {}
        }
        panels.session.journey.playing = false;
        panels.settle();
        let before = panels.look();
        panels.press(*key);
        let after = panels.look();
        assert_ne!(after, before, "{key:?}");
        if *key == Key::U {
            panels.press(*key);
            assert!(!panels.session.journey.recording);
            assert!(!panels.session.journey.rigs.is_empty());
        }
    }
    panels.session.journey.playing = false;
    panels.settle();
    let bad: Vec<_> = panels.session.notices.iter().filter(|n| n.bad).collect();
    assert!(bad.is_empty(), "{bad:?}");
}

#[test]
fn a_scene_is_cleared_and_another_is_opened() {
    for by_key in [true, false] {
        let mut panels = Panels::open("solids", "look.colour=size&structure.audit=true");
        let colour = panels.session.state.look.colour;
        panels.press(Key::Enter);
        assert!(panels.session.tour.is_some());
        match by_key {
            true => panels.press(Key::Backslash),
            false => panels.click("Clear"),
        }
        (0..4).for_each(|_| panels.frame(Vec::new()));
        let session = &panels.session;
        assert!(session.world.is_none() && session.decision.is_none() && session.tour.is_none());
        assert!(session.is_settled() && session.notices.is_empty(), "{:?}", session.notices);
        assert_eq!((session.state.camera, session.state.frozen), (None, None));
        let said = |panels: &Panels, part: &str| panels.texts.iter().any(|(t, _)| t.contains(part));
        assert!(said(&panels, "Choose a scene on the left"), "{:?}", panels.texts);
        assert!(!panels.texts.iter().any(|(text, _)| text == "Clear"));

        // Its link opens none either.
        let again = Session::new(egui::Context::default(), &panels.session.link(), None);
        assert!(again.world.is_none() && again.loading().is_none() && again.notices.is_empty());

        panels.session.open(Source::of_text("city:cells=6,objects=400"));
        panels.settle();
        let session = &panels.session;
        assert_eq!(session.state.scene, "city:cells=6,objects=400");
        assert!(session.state.camera.is_some() && session.notices.is_empty());
        assert_eq!(session.state.look.colour, colour);
    }
}

#[test]
fn on_a_phone_no_window_is_cut_off_and_the_tour_covers_no_map() {
    let size = egui::vec2(390.0, 844.0);
    let mut panels = Panels::open_in(size, "solids", "");
    let screen = egui::Rect::from_min_size(Pos2::ZERO, size);
    let areas = |panels: &Panels| -> Vec<egui::Rect> {
        let of = |m: &egui::Memory| {
            let layers = m.areas().visible_layer_ids();
            layers.iter().filter_map(|layer| m.area_rect(layer.id)).collect()
        };
        panels.ctx.memory(of)
    };
    let before = areas(&panels).len();
    for (key, name) in [(Key::T, "Clipping playground"), (Key::H, "Help")] {
        panels.press(key);
        (0..4).for_each(|_| panels.frame(Vec::new()));
        let all = areas(&panels);
        assert!(all.len() > before, "{name} is open");
        assert!(all.iter().all(|r| screen.contains_rect(*r)), "{name}: {all:?}");
        panels.press(key);
        panels.frame(Vec::new());
    }
    let has_map = |panels: &Panels| panels.texts.iter().any(|(text, _)| text == "from above");
    assert!(has_map(&panels));
    panels.press(Key::Enter);
    panels.settle();
    assert!(!has_map(&panels), "the tour's card would lie on it");
    let mut wide = Panels::open("solids", "");
    wide.press(Key::Enter);
    wide.settle();
    assert!(has_map(&wide), "there is room for both");
}

#[test]
fn one_click_culls_the_back_faces_of_an_open_mesh() {
    let mut panels = Panels::open("city:sub=1", "");
    panels.session.open(bytes("ball.obj", lumpy_ball_as_obj(2).as_bytes()));
    while panels.session.loading().is_some() {
        panels.frame(Vec::new());
    }
    panels.settle();
    panels.frame(Vec::new());
    let why = "no back face is culled: the mesh is two-sided, since it is open: 4 boundary edges";
    // Beside the figures, and beside the switch.
    assert_eq!(panels.texts.iter().filter(|(text, _)| text == why).count(), 2);
    let left = |p: &Panels| p.session.decision.as_ref().expect("decided").visible.triangle_count;
    let before = left(&panels);
    panels.click("take as one-sided");
    panels.settle();
    assert!(left(&panels) * 10 < before * 6, "{} of {before}", left(&panels));
    panels.frame(Vec::new());
    assert!(panels.texts.iter().all(|(text, _)| text != why && text != "take as one-sided"));
    panels.click("two-sided");
    panels.settle();
    assert_eq!(left(&panels), before);
}

#[test]
fn keys_and_their_switches_do_the_same() {
    let mut panels = Panels::open("city:sub=1", "");
    panels.press(Key::B);
    assert_eq!(panels.session.state.ghosts.form, GhostForm::Boxes);
    assert!(panels.session.state.frozen.is_some(), "from inside nothing of it is to be seen");
    let by_key = panels.session.state.clone();
    let mut panels = Panels::open("city:sub=1", "");
    panels.click("boxes");
    assert_eq!(panels.session.state, by_key);
}

#[test]
fn the_help_sheet_has_every_line_of_the_table() {
    let mut panels = Panels::open("solids", "");
    panels.press(Key::H);
    (0..4).for_each(|_| panels.frame(Vec::new()));
    for line in TABLE.iter().flat_map(|(_, lines)| *lines) {
        let shown = panels.texts.iter().any(|(text, _)| text == line.what);
        assert!(shown, "'{}' is not on the sheet", line.what);
    }
}

/// `CULLET_GOLDEN=new` writes the table into the book anew.
#[test]
fn the_book_has_the_table() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/src/viewer.md");
    let text = std::fs::read_to_string(path).expect("a chapter of the book");
    let (begin, end) = ("<!-- keys -->\n", "<!-- end of keys -->");
    let (before, rest) = text.split_once(begin).expect("where the table begins");
    let (table, after) = rest.split_once(end).expect("where it ends");
    if std::env::var("CULLET_GOLDEN").is_ok_and(|v| v == "new") {
        let anew = format!("{before}{begin}{}{end}{after}", markdown());
        std::fs::write(path, anew).expect("the book can be written");
    } else {
        assert_eq!(table, markdown(), "CULLET_GOLDEN=new writes it anew");
    }
}

#[test]
fn what_is_copied_is_what_is_shown() {
    let mut panels = Panels::open("city:sub=1", "");
    panels.click("Copy");
    let text = panels.copied.take().expect("the funnel is copied");
    let funnel = panels.session.decision.as_ref().expect("decided").visible.funnel.clone();
    assert_eq!(text, funnel_json(&funnel));
    let read: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let rows = read["funnel"].as_array().expect("rows");
    assert_eq!(rows.len(), funnel.rows.len());
    for (json, row) in rows.iter().zip(&funnel.rows) {
        assert_eq!(json["stage"], row.stage.name());
        assert_eq!(json["unit"], row.unit.name());
        let (entered, left) = (row.entered.of(row.unit), row.left.of(row.unit));
        assert_eq!((&json["entered"], &json["left"]), (&entered.into(), &left.into()));
        let triangles = serde_json::json!([row.entered.triangles, row.left.triangles]);
        assert_eq!(json["triangles"], triangles);
        assert!(json["nanoseconds"].is_u64() || json["nanoseconds"].is_null());
    }
    assert!(funnel.rows.iter().any(|row| row.dropped().triangles > 0), "nothing is culled: {text}");

    panels.click("Copy link");
    let link = panels.copied.take().expect("the link is copied");
    let again = link::from_text(&link).expect("a link");
    assert_eq!(again.camera, panels.session.state.camera);

    panels.travel();
    panels.click("Camera path");
    panels.click("Copy as JSON");
    let path = panels.copied.take().expect("the path is copied");
    let cameras: serde_json::Value = serde_json::from_str(&path).expect("JSON");
    assert!(cameras.is_object() || cameras.is_array());
    let count = panels.session.journey.rigs.len();
    assert_eq!(path.matches("\"eye\"").count(), count, "{}", &path[..200]);
}

#[test]
fn an_error_goes_when_the_next_scene_is_there() {
    let mut panels = Panels::open("solids", "stages.frustum=perhaps");
    panels.session.open(bytes("broken.glb", b"glTF broken"));
    panels.settle();
    let said = |p: &Panels| p.session.notices.iter().map(|n| n.text.clone()).collect::<Vec<_>>();
    assert!(said(&panels).iter().any(|t| t.contains("broken.glb")), "{:?}", said(&panels));
    panels.session.open(Source::of_text("office"));
    panels.settle();
    // The fault in the link is still there.
    let left = said(&panels);
    assert!(left.len() == 1 && left[0].contains("The default is shown"), "{left:?}");
}

/// In a room of the office, before its open door.
const ROOM: &str = "camera.target=[26.6,1.7,18.2]&camera.distance=6&camera.yaw=-8&camera.pitch=-4&camera.near=0.05";

#[test]
fn a_student_steps_through_a_chain_of_portals_and_shuts_a_door() {
    let mut panels = Panels::open_in(egui::vec2(1400.0, 3200.0), "office", ROOM);
    panels.press(Key::Slash);
    panels.settle();
    let said = |p: &Panels, part: &str| p.texts.iter().any(|(text, _)| text.contains(part));
    (0..4).for_each(|_| panels.frame(Vec::new()));
    assert!(said(&panels, "in cell "), "{:?}", panels.texts);
    let count = panels.session.cells.chain.as_ref().expect("wanted").steps.len() as u32;
    assert!(count > 1, "{count} portals are seen");
    for step in 1..=count {
        panels.press(Key::CloseBracket);
        assert_eq!(panels.session.state.structure.step, step);
    }
    // After the last, all again; and back.
    panels.press(Key::CloseBracket);
    assert_eq!(panels.session.state.structure.step, 0);
    panels.press(Key::OpenBracket);
    assert_eq!(panels.session.state.structure.step, count);

    panels.session.state.structure.step = 1;
    panels.settle();
    let portal = panels.session.cells.chain.as_ref().expect("shown").steps[0].portal;
    panels.press(Key::Delete);
    panels.settle();
    (0..4).for_each(|_| panels.frame(Vec::new()));
    assert_eq!(panels.session.state.doors, [portal]);
    let chain = panels.session.cells.chain.as_ref().expect("shown");
    assert!(chain.doors.iter().any(|door| door.portal == portal), "{:?}", chain.doors);
    // On the picture it is named where it is, and a click there opens it.
    panels.click("shut");
    panels.settle();
    (0..4).for_each(|_| panels.frame(Vec::new()));
    panels.click("Bake what sees what");
    panels.settle();
    (0..4).for_each(|_| panels.frame(Vec::new()));
    assert!(said(&panels, "pairs of cells can see each other"));
}

#[test]
fn who_decides_is_chosen_where_the_device_can() {
    let mut panels = Panels::open("city:sub=1", "layout=wipe");
    let said = |p: &Panels, part: &str| p.texts.iter().any(|(text, _)| text.contains(part));
    panels.click("device");
    assert!(panels.session.state.device.on);
    // Nobody has made anything ready: the CPU decides, and nothing says otherwise.
    panels.settle();
    assert!(!panels.session.by_device() && said(&panels, "with culling: "));

    panels.session.device.ready = true;
    panels.session.device.figures =
        DeviceFigures { frame: 1, in_view: 23_457, visible: 1_234, ..Default::default() };
    (0..4).for_each(|_| panels.frame(Vec::new()));
    for part in ["decided by the device", "23\u{2009}457", "1\u{2009}234", "without culling: "] {
        assert!(said(&panels, part), "{part}: {:?}", panels.texts);
    }
    panels.click("against the CPU");
    (0..4).for_each(|_| panels.frame(Vec::new()));
    assert!(panels.session.state.device.compare && said(&panels, "decided by the CPU: "));

    panels.press(Key::Num4);
    (0..4).for_each(|_| panels.frame(Vec::new()));
    assert!(said(&panels, "depth pyramid, level 0"), "{:?}", panels.texts);

    panels.session.device.refused = Some("it has no compute shaders".to_owned());
    panels.session.device.ready = false;
    (0..4).for_each(|_| panels.frame(Vec::new()));
    assert!(said(&panels, "The CPU decides: it has no compute shaders."));
    // What cannot be is not chosen; what was is taken back by its key.
    panels.click("CPU");
    assert!(panels.session.state.device.on);
    panels.press(Key::Quote);
    assert!(!panels.session.state.device.on);
}

#[test]
fn panes_draw_what_was_decided_for_them() {
    let mut panels = Panels::open("city:sub=1", "device.on=true");
    panels.session.device.ready = true;
    let drawn = |panels: &mut Panels, link: &str| -> Vec<bool> {
        let scene = panels.session.state.scene.clone();
        let camera = panels.session.state.camera;
        panels.session.state = link::from_text(link).expect("a link");
        panels.session.state.scene = scene;
        panels.session.state.camera = camera;
        panels.settle();
        panels.frame(Vec::new());
        let made = compose(&panels.session);
        let kept = panels.session.decision.as_ref().map(|d| &d.visible);
        let panes = made.panes(kept);
        let by = made.by_device.as_ref();
        assert_eq!(by.is_some(), panes.iter().any(|pane| pane.on_device), "{link}");
        if let Some(by) = by {
            assert_eq!(Some(by), panels.session.culling_view().as_ref(), "{link}");
        }
        panes.iter().map(|pane| pane.on_device).collect()
    };
    for (link, expected) in [
        ("", &[false][..]),
        ("device.on=true", &[true]),
        ("device.on=true&stages.on=false", &[false]),
        ("device.on=true&layout=split", &[true, true]),
        ("device.on=true&layout=wipe", &[true, false]),
        ("device.on=true&layout=buffer", &[true]),
        ("device.on=true&frozen.distance=9", &[true]),
    ] {
        assert_eq!(drawn(&mut panels, link), expected, "{link}");
    }
}
