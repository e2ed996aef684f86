//! Why one culls, what a frame waits for, and the kinds of culling.

use std::collections::BTreeSet;

use cullet::cull::detail::Detail;
use cullet::{
    Culler, DrawList, Handle, Instance, Output, Scene, Stage, Transform, View, ViewState, Visible,
};
use cullet_cells::cell::{CellGraph, CellPiece, CellShapes, Portal};
use cullet_cells::{Cells, InCells};
use cullet_draw::{RenderOptions, Selection, VerifyOptions, render, verify};
use cullet_scenes::paths::{self, Overrides};
use cullet_testkit::meshes;

use crate::{Computed, Entry, number, word};

pub(crate) const ENTRIES: &[Entry] = &[
    ("why-1", tightness),
    ("why-2", tightness_of_knobs),
    ("why-3", hardly_anything_hidden),
    ("bottleneck-1", between_two_frames),
    ("bottleneck-2", limit_of_a_frame),
    ("kinds-1", behind_a_shut_door),
    ("kinds-2", first_stage),
];

/// No function of the engine takes counts alone: a quotient of two given numbers.
fn tightness() -> Computed {
    number(12_000.0 / 5_000.0)
}

/// Computes the tightness that `cullet verify knobs --views 8 --samples 1` prints: with the preset
/// `balanced`, with occlusion looked for whatever it costs, and the scene's own path.
fn tightness_of_knobs() -> Computed {
    let mut culler = Culler::balanced();
    culler.occlusion = culler.occlusion.map(|own| own.with_risk(None));
    let mut model = cullet_scenes::build("knobs")?;
    model.scene.commit(&Culler::default());
    model.scene.prepare(&culler);
    let path = paths::of_builtin("knobs");
    let views = paths::views(&model, &path, 8, [1280, 720], &Overrides::default())?;
    let options = VerifyOptions { samples: 1, ..VerifyOptions::default() };
    let (mut state, mut left, mut seen) = (ViewState::default(), 0, 0);
    for view in &views {
        let found = verify(&model.scene, view, &culler, &mut state, &options);
        assert!(found.false_culls.is_empty(), "{:?}", found.false_culls);
        left += found.potentially_visible;
        seen += found.visible;
    }
    number(left as f64 / seen as f64)
}

/// Ten squares of 32 × 32 pixels, nine of them in view and one behind: culling of all kinds takes
/// no more than a tenth of the triangles, where each triangle that is left fills hundreds of
/// pixels.
fn hardly_anything_hidden() -> Computed {
    let mut scene = Scene::new();
    let corners =
        vec![[-16.0, -16.0, 0.0], [16.0, -16.0, 0.0], [16.0, 16.0, 0.0], [-16.0, 16.0, 0.0]];
    let square = scene.add_mesh(meshes::one_sided((corners, vec![0, 1, 2, 0, 2, 3])));
    let shown = (0..9).map(|i| [f64::from(i % 3 - 1) * 32.0, f64::from(i / 3 - 1) * 32.0, -10.0]);
    for place in shown.chain([[0.0, 0.0, -20.0]]) {
        scene.add(Instance::new(square, Transform::from_translation(place)))?;
    }
    scene.commit(&Culler::default());
    let view = View::orthographic([0.0; 3], [0.0, 0.0, -1.0], 100.0, 0.1, 100.0, [160, 100])?;
    let options = VerifyOptions { samples: 1, count_layers: true, ..VerifyOptions::default() };
    let found = verify(&scene, &view, &Culler::exact(), &mut ViewState::default(), &options);
    assert_eq!((found.visible * 10, found.before.covered_pixels), (found.all * 9, 9 * 32 * 32));
    assert!(
        found.false_culls.is_empty() && found.after.fragments > 400 * found.potentially_visible
    );
    let saved = found.all - found.potentially_visible;
    Ok(if saved * 10 > found.all { "yes" } else { "no" }.to_owned())
}

/// No function of the engine takes given times: the largest of four.
fn between_two_frames() -> Computed {
    let [application, bus, geometry, rasteriser] = [4.0 + 0.5, 2.0, 11.0 / 2.0, 6.0_f64];
    number(application.max(bus).max(geometry).max(rasteriser))
}

/// Counts the work of each link in a frame, in one of a quarter of the pixels, and in one of half
/// of the triangles: a frame waits for the link whose work changes as the frame does.
fn limit_of_a_frame() -> Computed {
    let work = |words: &str, size: [u32; 2]| -> Result<[f64; 4], Box<dyn std::error::Error>> {
        let mut model = cullet_scenes::build(words)?;
        model.scene.commit(&Culler::default());
        let view =
            paths::views(&model, &"orbit".parse()?, 1, size, &Overrides::default())?.swap_remove(0);
        let scene = &model.scene;
        let culler = Culler::default().only(Stage::Layer).with_output(Output::Instances);
        let (mut visible, mut list) = (Visible::default(), DrawList::default());
        culler.cull_one(scene, &view, &mut ViewState::default(), &mut visible);
        list.fill(scene, &visible, &[])?;
        let bytes = size_of_val(&list.commands[..]) + size_of_val(&list.instances[..]);
        let options = RenderOptions { count_layers: true, ..RenderOptions::default() };
        let frame = render(scene, &view, Selection::All, &options);
        let counts = [list.commands.len() as u64, bytes as u64, scene.triangle_count()];
        let [calls, bytes, triangles] = counts.map(|n| n as f64);
        Ok([calls, bytes, triangles, frame.stats.fragments as f64])
    };
    // 12·n² triangles: twice as many at 17 as at 12.
    let whole = work("knobs:n=17", [640, 400])?;
    let frames = [work("knobs:n=17", [320, 200])?, work("knobs:n=12", [640, 400])?];
    let off = |link: usize| -> f64 {
        let shares = frames.map(|frame| frame[link] / whole[link]);
        shares.iter().zip([1.0, 0.5]).map(|(share, seen)| (share - seen).abs()).sum()
    };
    let links = ["cpu", "bus", "transform", "fill"];
    let limit = (0..4).min_by(|&a, &b| off(a).total_cmp(&off(b))).ok_or("no link")?;
    let all: Vec<f64> = (0..4).map(off).collect();
    assert!((0..4).all(|other| other == limit || all[other] > 10.0 * all[limit]), "{all:?}");
    Ok(links[limit].to_owned())
}

/// A street, a house with a door, and 400 instances in it.
fn behind_a_shut_door() -> Computed {
    let mut scene = Scene::new();
    let chair = scene.add_mesh(meshes::block([-0.1; 3], [0.1; 3]));
    for i in 0..400 {
        let place = [-4.0 + 0.4 * f64::from(i % 20), 1.0, -9.0 + 0.4 * f64::from(i / 20)];
        scene.add(Instance::new(chair, Transform::from_translation(place)))?;
    }
    scene.commit(&Culler::default());
    let polygon = vec![[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0], [0.5, 2.0, 0.0], [-0.5, 2.0, 0.0]];
    let graph = CellGraph::new(2, vec![Portal { cells: [0, 1], polygon }])?;
    let rooms = vec![
        CellPiece::from_box(0, [-20.0, 0.0, 0.0], [20.0, 10.0, 20.0]),
        CellPiece::from_box(1, [-5.0, 0.0, -10.0], [5.0, 3.0, 0.0]),
    ];
    let shapes = CellShapes::new(&graph, rooms)?;
    let mut cells = Cells::new(&mut scene, graph, shapes);
    let view = View::perspective([0.0, 1.7, 15.0], [0.0, 1.7, 0.0], 1.0, 0.1, 100.0, [640, 480])?;
    // Nothing is drawn into a buffer.
    let culler = Culler::default().without(Stage::Occlusion).with_reasons(true);
    let mut stages = |open: bool| -> BTreeSet<Option<Stage>> {
        let mut visible = Visible::default();
        cells.set_portal_open(0, open);
        InCells::new(&scene, Some(&cells)).cull(
            &culler,
            &view,
            &mut ViewState::default(),
            &mut visible,
        );
        visible.reasons.iter().map(|reason| reason.map(|r| r.stage)).collect()
    };
    assert!(stages(true).contains(&None), "through the open door some are seen");
    let mut shut = stages(false).into_iter();
    match (shut.next(), shut.next()) {
        (Some(Some(stage)), None) => word(stage),
        found => Err(format!("they are not all dropped by one stage: {found:?}").into()),
    }
}

/// To the right of the picture, behind a wall there, and 0.3 m wide at 100 m.
fn first_stage() -> Computed {
    let mut scene = Scene::new();
    let wall = scene.add_mesh(meshes::block([100.0, -50.0, -60.0], [200.0, 50.0, -50.0]));
    let small = scene.add_mesh(meshes::block([-0.15; 3], [0.15; 3]));
    scene.add(Instance::new(wall, Transform::IDENTITY))?;
    let place = Transform::from_translation([200.0, 0.0, -100.0]);
    let small = scene.add(Instance::new(small, place))?;
    scene.commit(&Culler::default());
    let fov = 60_f64.to_radians();
    let view = View::perspective([0.0; 3], [0.0, 0.0, -1.0], fov, 0.1, 1000.0, [1280, 720])?;
    let detail = Some(Detail::default().with_threshold_px(4.0));
    let culler = Culler::exact().with_detail(detail);
    let stage = |culler: &Culler, handle: Handle| {
        culler.explain(&scene, &view, handle).map(|told| told.reason.map(|r| r.stage))
    };
    // Another finds it as well.
    assert!(stage(&culler.without(Stage::Frustum), small)?.is_some());
    word(stage(&culler, small)?.ok_or("it is kept")?)
}
