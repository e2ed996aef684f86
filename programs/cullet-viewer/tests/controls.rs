//! The controls as readers of a screen are told of them.

mod shown;

use std::collections::BTreeSet;

use cullet_viewer::controls::{request, rows};
use eframe::egui::Event;

use shown::Panels;

/// Rows of a window, each in its fields.
fn listed(panels: &mut Panels) -> Vec<Vec<String>> {
    panels.ctx.enable_accesskit();
    // What opened just now reaches its size after some frames.
    (0..6).for_each(|_| panels.frame(Vec::new()));
    let tree = panels.tree.as_ref().expect("the tree was asked for");
    rows(tree).lines().map(|row| row.split('\t').map(str::to_owned).collect()).collect()
}

fn with_name<'a>(rows: &'a [Vec<String>], name: &str) -> &'a [String] {
    let row = rows.iter().find(|row| row[2] == name);
    row.unwrap_or_else(|| panic!("no control is called '{name}': {rows:#?}"))
}

#[test]
fn every_control_has_a_name_of_its_own_kind() {
    for (scene, link) in [
        ("solids", "cut.on=true&clipping.open=true&stages.depth=triangles&structure.audit=true"),
        ("solids", "cut.on=true&cut.shape=box&study.by=masks&study.cube=true&layout=wipe"),
        ("office", "structure.cells=true&structure.portals=true&layout=split"),
        ("solids", "stages.detail_px=2&stages.detail_fade=0.5&device.on=true&layout=buffer"),
    ] {
        let mut panels = Panels::open(scene, link);
        panels.travel();
        assert!(
            !panels.session.notices.iter().any(|n| n.bad),
            "{link}: {:?}",
            panels.session.notices
        );
        // All that can be unfolded.
        for panel in ["Cut-away", "Camera path", "Structures"] {
            if panels.texts.iter().any(|(text, _)| text == panel) {
                panels.click(panel);
            }
        }
        let rows = listed(&mut panels);
        let controls: Vec<_> = rows.iter().filter(|row| row[1] != "text").collect();
        let numbers = controls.iter().filter(|row| row[1] == "number").count();
        assert!(numbers > 3, "{scene}: only {numbers} numbers");
        assert!(controls.len() > 60, "{scene}: only {} controls", controls.len());
        let units = ["px", "µs", "px wide", "°", "m", "s", "%"];
        for row in &controls {
            let letters = row[2].chars().filter(|c| c.is_alphabetic()).count();
            assert!(
                letters > 1 && !units.contains(&row[2].as_str()),
                "{scene}: not a name: {row:?}"
            );
        }
        // Numbers and choices cannot be told apart but by their names.
        let mut names = BTreeSet::new();
        for row in
            controls.iter().filter(|row| row[1] == "number" || row[3] == "on" || row[3] == "off")
        {
            assert!(names.insert((&row[1], &row[2])), "{scene}: two are called '{}'", row[2]);
        }
    }
}

#[test]
fn what_is_done_to_the_list_is_done_to_the_session() {
    let mut panels = Panels::open("solids", "");
    let rows = listed(&mut panels);
    let frustum = with_name(&rows, "frustum");
    assert_eq!((&*frustum[1], &*frustum[3]), ("checkbox", "on"));
    let click = request(&frustum[0]).expect("a number is a request");
    panels.frame(vec![Event::AccessKitActionRequest(click)]);
    let rows = listed(&mut panels);
    assert_eq!(with_name(&rows, "frustum")[3], "off");
    assert!(!panels.session.state.stages.frustum);

    let off = with_name(&rows, "back faces: off");
    assert_eq!((&*off[1], &*off[3]), ("button", "off"));
    panels.frame(vec![Event::AccessKitActionRequest(request(&off[0]).unwrap())]);
    let rows = listed(&mut panels);
    assert_eq!(with_name(&rows, "back faces: off")[3], "on");

    let width = with_name(&rows, "width of the occlusion buffer in pixels");
    assert_eq!((&*width[1], &*width[4]), ("number", "640"));
    let set = request(&format!("{} 320", width[0])).expect("a number and a value");
    panels.frame(vec![Event::AccessKitActionRequest(set)]);
    assert_eq!(
        with_name(&listed(&mut panels), "width of the occlusion buffer in pixels")[4],
        "320"
    );

    for nonsense in ["", "on", "x 1", "1 y", "-1"] {
        assert!(request(nonsense).is_none(), "{nonsense}");
    }
}
