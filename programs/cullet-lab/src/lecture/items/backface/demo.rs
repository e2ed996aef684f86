//! The demo of the lecture, feature by feature: what its window shows, by the functions that the viewer shows it with.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use cullet::cull::backface::{Facing, facing_ref};
use cullet::{
    CullFace, Culler, Instance, Mesh, Output, Scene, Stage, Transform, View, ViewState, Visible,
};
use cullet_command::process::cpu_time;
use cullet_draw::{PixelId, RenderOptions, Selection, render};

use crate::lecture::finding::Finding;
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{
    SIZE, cube, cull, cull_triangles, draw_of, grouped, left, mesh, other, percent, scene_of,
};

const BALL: &str = "knobs";

/// A tube of so many sides, open at both ends: as many corners as triangles.
fn tube(sides: u32) -> Result<Mesh, LabError> {
    let corner = |i: u32| {
        let (sin, cos) = (f64::from(i / 2) / f64::from(sides) * std::f64::consts::TAU).sin_cos();
        [cos as f32, if i.is_multiple_of(2) { -1.0 } else { 1.0 }, sin as f32]
    };
    let side = |i: u32| {
        let [a, b, c, d] = [2 * i, 2 * i + 1, 2 * i + 2, 2 * i + 3].map(|v| v % (2 * sides));
        [a, b, c, b, d, c]
    };
    mesh((0..2 * sides).map(corner).collect(), (0..sides).flat_map(side).collect(), false)
}

/// Each built-in scene of the menu can be opened; the counts of two meshes fit their topology.
pub(super) fn counts(lab: &Lab) -> Result<Finding, LabError> {
    let ball = lab.scene(BALL)?;
    let tube = tube(40)?;
    let opens = cullet_scenes::list().iter().filter(|s| cullet_scenes::is_builtin(s.name)).count();
    let counts = |mesh: &Mesh| {
        let t = mesh.topology();
        let euler = i64::from(t.vertices) - i64::from(t.edges) + i64::from(t.triangles);
        (mesh.positions().len(), mesh.triangle_count(), euler, t.boundary_edges)
    };
    let (vertices, faces, euler, boundary) = counts(&ball.scene.meshes()[0]);
    let of_tube = counts(&tube);
    Ok(Finding::if_so(
        // Euler: V − E + F is 2 for a ball and 0 for a tube.
        (euler, boundary) == (2, 0)
            && of_tube == (80, 80, 0, 80)
            && opens == cullet_scenes::list().len(),
        format!(
            "the menu has {opens} scenes; [{}]: {} vertices, {} faces, and with its edges they make the 2 of Euler that a ball has; a tube of 40 \
             sides, open at both ends, has the numbers of the lecture, {} vertices and {} faces",
            ball.name,
            grouped(vertices),
            grouped(faces),
            of_tube.0,
            of_tube.1
        ),
    ))
}

/// The counter against the exact side of each triangle.
pub(super) fn faces_rendered(lab: &Lab) -> Result<Finding, LabError> {
    let ball = lab.scene("knobs:n=24")?;
    let view = lab.views(&ball, "orbit", 4, SIZE)?.swap_remove(1);
    let counter = |scene: &Scene, view: &View| {
        let visible = cull_triangles(&Culler::default(), scene, view);
        (visible.triangle_count, scene.triangle_count())
    };
    let (shown, all) = counter(&ball.scene, &view);
    let mesh = ball.scene.mesh(0);
    let faces = (0..mesh.triangle_count())
        .filter(|&t| facing_ref(&view, ball.scene.transform(0), &mesh.corners(t)) != Facing::Back)
        .count() as u64;
    let tube = scene_of(tube(40)?)?;
    let mut view = View::perspective([1.0, 3.0, 6.0], [0.0; 3], 1.0, 0.1, 100.0, SIZE)?;
    let (fronts, _) = counter(&tube, &view);
    view.cull_face = CullFace::None;
    let (both, of) = counter(&tube, &view);
    Ok(Finding::if_so(
        shown == faces && shown < all && (both, of) == (80, 80) && fronts < 80,
        format!(
            "{shown}/{all} ({}) of a ball with knobs, as many as the exact test leaves; of a tube of 80 faces {both}/{of} with back faces on, as \
             in the lecture, and {fronts}/{of} with back faces off",
            percent(shown, all)
        ),
    ))
}

/// A microsecond a call.
fn tick() -> u64 {
    static TICKS: AtomicU64 = AtomicU64::new(0);
    TICKS.fetch_add(1000, Ordering::Relaxed)
}

/// Whose clock is read, and what culling does for the rate.
pub(super) fn frames_per_second(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene("office")?;
    let scene = &model.scene;
    let view = lab.views(&model, "walk", 4, SIZE)?.swap_remove(1);
    let culler = Culler { output: Output::Triangles, ..Culler::default() };
    let told = cull(&Culler { clock: Some(tick), ..culler.clone() }, scene, &view);
    let silent = cull(&culler, scene, &view);
    let times: Vec<u64> = told.funnel.rows.iter().filter_map(cullet::FunnelRow::time).collect();
    let is_told = times.len() == told.funnel.rows.len()
        && times.iter().sum::<u64>() > 0
        && times.iter().all(|t| t % 1000 == 0)
        && silent.funnel.rows.iter().all(|row| row.time().is_none());

    // Frames by turns: all drawn; culled, and what is left drawn.
    let options = RenderOptions::default();
    let (mut state, mut visible) = (ViewState::default(), Visible::default());
    let mut all = || drop(std::hint::black_box(render(scene, &view, Selection::All, &options)));
    let mut left = || {
        culler.cull_one(scene, &view, &mut state, &mut visible);
        drop(std::hint::black_box(render(scene, &view, Selection::Visible(&visible), &options)));
    };
    let (mut ratio, mut is_faster) = (0.0, false);
    for _ in 0..3 {
        let [of_all, of_left] = least_times([&mut all, &mut left]).map(|t| t.as_secs_f64());
        ratio = of_all / of_left;
        is_faster = ratio > 1.5;
        if is_faster {
            break;
        }
    }
    Ok(Finding::if_so(
        is_told && is_faster,
        format!(
            "the engine tells the time of each of its {} steps by a clock that it is given, and none without; the reference renderer draws \
             {ratio:.1} times as many frames a second of an office where it is culled, culling included",
            times.len()
        ),
    ))
}

/// The least time of the processor that each of two frames takes, by turns.
fn least_times(mut frames: [&mut dyn FnMut(); 2]) -> [Duration; 2] {
    let mut least = [Duration::MAX; 2];
    for _ in 0..5 {
        for (frame, least) in frames.iter_mut().zip(&mut least) {
            let begin = cpu_time();
            frame();
            *least = cpu_time().saturating_sub(begin).min(*least);
        }
    }
    least
}

/// What each switch draws.
pub(super) fn switches(lab: &Lab) -> Result<Finding, LabError> {
    let ball = lab.scene(BALL)?;
    let scene = &ball.scene;
    let mut view = lab.views(&ball, "orbit", 4, SIZE)?.swap_remove(1);
    let frame = |scale| {
        let options = RenderOptions { scale, ..RenderOptions::default() };
        render(scene, &view, Selection::All, &options).stats.covered_pixels
    };
    let [filled, fine] = [frame(1), frame(2)];
    let fronts = cull_triangles(&Culler::default(), scene, &view).triangle_count;
    view.cull_face = CullFace::None;
    let both = cull_triangles(&Culler::default(), scene, &view).triangle_count;
    let topology = scene.mesh(0).topology();

    // The mesh of the lectures that looks closed and is not.
    let (name, as_declared) = match lab.model("stanford-bunny/bun_zipper.ply")? {
        Some(bunny) => ("the bunny", bunny.scene.meshes()[0].clone()),
        None => {
            let (positions, indices) = cube();
            let open = mesh(positions, indices[..30].to_vec(), true)?;
            ("a box without a lid (the bunny is not there)", open)
        }
    };
    let mut one_sided = as_declared.clone();
    one_sided.set_two_sided(false);
    let [as_declared, one_sided] = [scene_of(as_declared)?, scene_of(one_sided)?];
    let extent = one_sided.extent();
    let centre = extent.center();
    let reach = extent.half_extent().into_iter().fold(0.0, f64::max);
    let eye = [centre[0] + reach, centre[1] + 2.0 * reach, centre[2] + 4.0 * reach];
    let near = View::perspective(eye, centre, 0.8, reach * 0.01, f64::INFINITY, SIZE)?;
    let taken = |scene: &Scene| {
        let left = cull_triangles(&Culler::default().only(Stage::Backface), scene, &near);
        left.funnel.dropped(Stage::Backface).triangles
    };
    let [kept_backs, culled_backs] = [&as_declared, &one_sided].map(taken);
    let of = one_sided.triangle_count();
    Ok(Finding::if_so(
        fine.abs_diff(4 * filled) * 100 < 4 * filled
            && fronts < both
            && both == u64::from(topology.triangles)
            && topology.edges * 2 == topology.triangles * 3
            && kept_backs == 0
            && culled_backs * 4 > of,
        format!(
            "filled, a ball covers {} pixels, and in high quality {} samples; {} faces without the back faces and {} with them; {} edges as a \
             wireframe, and a normal for each face. Of {name} no back face is culled, for it is open; as one-sided {} of {} are",
            grouped(filled),
            grouped(fine),
            grouped(fronts),
            grouped(both),
            grouped(topology.edges),
            grouped(culled_backs),
            grouped(of)
        ),
    ))
}

/// Turning and scaling the body, against moving the eye.
pub(super) fn turning(lab: &Lab) -> Result<Finding, LabError> {
    let mesh = lab.scene("knobs:n=16")?.scene.meshes()[0].clone();
    let mut placed = Scene::new();
    let id = placed.add_mesh(mesh);
    let handle = placed.add(Instance::new(id, Transform::IDENTITY)).map_err(other)?;
    placed.commit();
    let culler = Culler::default().only(Stage::Backface);
    let mut kept = |eye: [f64; 3], transform: Transform| -> Result<_, LabError> {
        placed.set_transform(handle, transform).map_err(other)?;
        placed.refit();
        let view = View::perspective(eye, [0.0; 3], 1.0, 0.01, f64::INFINITY, SIZE)?;
        Ok(left(&placed, &cull_triangles(&culler, &placed, &view)))
    };
    let eye = [1.0, 0.5, 3.0];
    let plain = kept(eye, Transform::IDENTITY)?;
    // A quarter about Y: (x, y, z) becomes (z, y, −x).
    let quarter = Transform {
        linear: [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]],
        translation: [0.0; 3],
    };
    let turned = kept([eye[2], eye[1], -eye[0]], quarter)?;
    let moved = kept([-eye[2], eye[1], eye[0]], Transform::IDENTITY)?;
    let turned_only = kept(eye, quarter)?;
    // The lecture's 70 %, about the eye, which changes nothing, and about the middle.
    let about_eye = eye.map(|v| v * 0.3);
    let scaled = kept(eye, Transform::from_scale_translation([0.7; 3], about_eye))?;
    let smaller = kept(eye, Transform::from_scale_translation([0.7; 3], [0.0; 3]))?;
    let mut zoom = Vec::new();
    for distance in [1.5, 3.0, 6.0, 24.0] {
        zoom.push(kept([0.0, 0.0, distance], Transform::IDENTITY)?.len());
    }
    let rises = zoom.windows(2).all(|pair| pair[0] < pair[1]);
    let all = 12 * 16 * 16;
    Ok(Finding::if_so(
        turned == plain
            && moved == turned_only
            && moved != plain
            && scaled == plain
            && smaller.len() > plain.len()
            && rises,
        format!(
            "turned together with the eye, a body of {} faces keeps the same {}; turned alone it keeps what an eye that circles the other way \
             keeps; at 70 % about the eye the same, about its own middle {}; from 1.5, 3, 6 and 24 radii {} are kept",
            grouped(all as u32),
            grouped(plain.len()),
            grouped(smaller.len()),
            zoom.iter().map(|&n| percent(n, all as usize)).collect::<Vec<_>>().join(", ")
        ),
    ))
}

/// Nothing in a scene, and something again.
pub(super) fn clear(_: &Lab) -> Result<Finding, LabError> {
    let mut scene = scene_of(tube(40)?)?;
    let view = View::perspective([1.0, 3.0, 6.0], [0.0; 3], 1.0, 0.1, 100.0, SIZE)?;
    let mut state = ViewState::default();
    let culler = Culler { output: Output::Triangles, ..Culler::default() };
    let mut show = |scene: &Scene| {
        let mut visible = Visible::default();
        culler.cull_one(scene, &view, &mut state, &mut visible);
        let frame = draw_of(scene, &view, Selection::Visible(&visible));
        (visible.triangle_count, frame.ids.iter().filter(|id| **id != PixelId::NONE).count())
    };
    let before = show(&scene);
    let handle = scene.slots().find_map(|slot| scene.handle(slot));
    scene.remove(handle.ok_or_else(|| other("the scene is empty"))?).map_err(other)?;
    scene.commit();
    let cleared = (show(&scene), scene.triangle_count());
    scene.add(Instance::new(0, Transform::IDENTITY)).map_err(other)?;
    scene.commit();
    let again = show(&scene);
    Ok(Finding::if_so(
        before.0 > 0 && before.1 > 1000 && cleared == ((0, 0), 0) && again == before,
        format!(
            "cleared, a scene has 0/0 faces and no pixel, where it had {} faces in view on {} pixels; with the mesh back in it, the same state of \
             the view shows {} and {}",
            before.0,
            grouped(before.1),
            again.0,
            grouped(again.1)
        ),
    ))
}
