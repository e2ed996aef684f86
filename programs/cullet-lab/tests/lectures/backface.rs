//! The test of a triangle, its signs, and what becomes of the picture.

use cullet::cull::backface::{Facing, ObjectEye};
use cullet::{
    Camera, Culler, Depth, Mesh, Projection, Stage, Transform, View,
    view::{CullFace, FrontFace},
};
use cullet_draw::{ClipPlace, PixelId, RenderOptions, render_clipped};
use cullet_lab::methods::screen::ndc_normal_z;
use cullet_scenes::knobbly_ball;
use cullet_testkit::oracles::triangles::facing_ref;
use cullet_testkit::soups;

use crate::tools::{
    SIZE, built, data, dot, draw, in_clip, left, minus, normal, placed, scene_of, seen, told,
    triangles, views,
};

/// Items 1 and 7: flat triangles with depths, as the geometry stage leaves them, are all that the
/// rasteriser needs.
#[test]
fn the_rasteriser_fills_the_same_pixels_from_flat_triangles_alone() {
    let mut model = built("city:cells=6,objects=200");
    // Which side is seen would be decided in the geometry stage as well.
    model.scene.edit_meshes(|_, mesh| mesh.set_two_sided(true));
    model.scene.commit(&Culler::default());
    let view = views(&model, "walk", 4).swap_remove(1);
    let whole = draw(&model.scene, &view);
    let handed_on = left(&Culler::default().only(Stage::Frustum), &model.scene, &view);
    let volume = cullet_draw::clip::space::full::<f64>(view.depth());
    let mut clipper = cullet_draw::clip::Clipper::new();
    let (mut positions, mut sources) = (Vec::new(), Vec::new());
    for (slot, t, corners) in triangles(&model.scene) {
        let source = (slot, model.scene.mesh(slot).original_triangle()[t as usize]);
        if !handed_on.contains(&source) {
            continue;
        }
        let corners = corners.map(|p| in_clip(&view, p));
        let divided = clipper.clip(&volume, &corners).iter();
        let flat: Vec<[f32; 3]> = divided
            .filter_map(|p| cullet_draw::clip::space::divide(p).map(|p| p.map(|v| v as f32)))
            .collect();
        for pair in flat.get(1..).unwrap_or_default().windows(2) {
            positions.extend([flat[0], pair[0], pair[1]]);
            sources.push(source);
        }
    }
    let indices = (0..positions.len() as u32).collect();
    let flat = scene_of(Mesh::new(data((positions, indices), true)).expect("triangles"));
    let mut matrix = [0.0; 16];
    (0..4).for_each(|i| matrix[5 * i] = 1.0);
    let screen = View::from_matrix(matrix, view.depth(), SIZE).expect("the identity");
    let raster = draw(&flat, &screen);
    let source = |id: PixelId| match id {
        PixelId::NONE => (u32::MAX, u32::MAX),
        id => sources[id.triangle as usize],
    };
    let owner = |id: PixelId| {
        if id == PixelId::NONE { (u32::MAX, u32::MAX) } else { (id.slot, id.triangle) }
    };
    let alike =
        whole.ids.iter().zip(&raster.ids).filter(|(a, b)| owner(**a) == source(**b)).count();
    // What is as near to another surface as f32 can tell may change owners.
    let pixels = whole.ids.len();
    assert!(alike * 1000 >= pixels * 998 && whole.stats.covered_pixels as usize * 2 > pixels);
    let counts = [handed_on.len(), sources.len(), alike, pixels];
    told(1, &counts.map(|n| n as f64));
    // And it is the same picture wherever triangles were clipped.
    for place in [ClipPlace::World, ClipPlace::Clip] {
        let clipped = render_clipped(&model.scene, &view, place, &RenderOptions::default());
        let changed = clipped.ids.iter().zip(&whole.ids).filter(|(a, b)| a != b).count();
        assert!(changed <= 2, "{place:?}: {changed} samples changed their owner");
    }
}

/// Item 19: v may lead to any one point of the plane, and all give the same sign.
#[test]
fn any_point_of_a_triangle_tells_which_side_is_seen() {
    let model = built("knobs:n=16");
    let scene = &model.scene;
    let (mut decided, mut backs, mut spread) = (0, 0, 0.0f64);
    for view in views(&model, "orbit", 4) {
        let [x, y, z, _] = view.eye();
        let engine = ObjectEye::of_view(&view, scene.transform(0));
        for (_, t, corners) in triangles(scene) {
            let truth = facing_ref(&view, scene.transform(0), &scene.mesh(0).corners(t));
            assert_eq!(engine.facing(&scene.mesh(0).corners(t)), truth);
            if truth == Facing::Edge {
                continue;
            }
            decided += 1;
            backs += usize::from(truth == Facing::Back);
            let [a, b, c] = corners;
            let middle = [0, 1, 2].map(|i| (a[i] + b[i] + c[i]) / 3.0);
            let n = normal(corners);
            let of = |p| dot(n, minus(p, [x, y, z])) / dot(n, n).sqrt();
            let values = [a, b, c, middle].map(of);
            assert!(values.iter().all(|v| (*v > 0.0) == (truth == Facing::Back)), "{values:?}");
            spread = values.iter().fold(spread, |s, v| s.max((v - values[0]).abs()));
        }
    }
    assert!(spread < 1e-12, "{spread}");
    told(19, &[decided as f64, backs as f64]);
}

/// Item 20: as written in 2013, (0, 0, 1), all that is seen goes; (0, 0, −1) is right.
#[test]
fn in_a_parallel_view_along_minus_z_the_direction_of_sight_is_minus_z() {
    let model = built("knobs:n=16");
    let scene = &model.scene;
    let (eye, target) = ([0.0, 1.15, 5.0], [0.0, 1.15, 0.0]);
    let view = View::orthographic(eye, target, 2.6, 0.1, 10.0, SIZE).expect("a view");
    assert_eq!(view.eye().map(|v| v + 0.0), [0.0, 0.0, 1.0, 0.0]);
    let shown = seen(scene, &view);
    let kept = left(&Culler::default().only(Stage::Backface), scene, &view);
    assert!(shown.is_subset(&kept) && kept.len() < scene.triangle_count() as usize);
    let (mut lost, mut wrong, mut decided) = ([0; 2], [0; 2], 0);
    for (_, t, corners) in triangles(scene) {
        let truth = facing_ref(&view, scene.transform(0), &scene.mesh(0).corners(t));
        if truth == Facing::Edge {
            continue;
        }
        decided += 1;
        let is_shown = shown.contains(&(0, scene.mesh(0).original_triangle()[t as usize]));
        for (rule, v) in [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]].into_iter().enumerate() {
            let culls = dot(normal(corners), v) > 0.0;
            wrong[rule] += usize::from(culls != (truth == Facing::Back));
            lost[rule] += usize::from(culls && is_shown);
        }
    }
    assert_eq!((wrong, lost), ([decided, 0], [shown.len(), 0]));
    told(20, &[decided, shown.len(), kept.len()].map(|n| n as f64));
}

/// Item 48: n·(e − p) ≤ 0 also takes what is seen edge-on, which fills no pixel; the engine keeps
/// it.
#[test]
fn the_rule_for_clusters_takes_edge_on_triangles_as_well() {
    let scene =
        scene_of(Mesh::new(data(soups::block([-1.0; 3], [1.0; 3]), false)).expect("a cube"));
    let projection =
        Projection::Perspective { fov_y_radians: 0.8, aspect: 1.6, near: 0.1, far: f64::INFINITY };
    let (mut backs, mut edges) = (0, 0);
    // From anywhere, from the plane of a side, and from the line of an edge; all in small whole
    // numbers and quarters.
    for eye in [[5.0, 3.0, 4.0], [5.0, 1.0, 0.25], [6.0, 1.0, -1.0], [0.5, -7.0, 0.25]] {
        let at = [eye[0], eye[1], eye[2], 1.0];
        let engine = ObjectEye::new(at, &Transform::IDENTITY, FrontFace::default(), CullFace::Back);
        let camera = Camera::look_at(eye, [0.0; 3], projection);
        let view = View::new(&camera, Depth::Reversed, SIZE).expect("a view");
        let shown = seen(&scene, &view);
        for (_, t, corners) in triangles(&scene) {
            let height = dot(normal(corners), minus(eye, corners[0]));
            let facing = engine.facing(&scene.mesh(0).corners(t));
            assert_eq!(
                (height < 0.0, height <= 0.0),
                (facing == Facing::Back, facing != Facing::Front)
            );
            backs += usize::from(height < 0.0);
            edges += usize::from(height == 0.0);
            let original = scene.mesh(0).original_triangle()[t as usize];
            assert!(height > 0.0 || !shown.contains(&(0, original)));
        }
    }
    told(48, &[f64::from(backs as u32), f64::from(edges as u32)]);
}

/// Item 76: as written, negative is a front, all fronts are lost; with positive none is, and no
/// back is kept.
#[test]
fn after_projection_fronts_have_a_positive_third_component() {
    let model = built("solids");
    let scene = &model.scene;
    let perspective =
        Projection::Perspective { fov_y_radians: 1.0, aspect: 1.6, near: 0.5, far: 500.0 };
    let parallel = Projection::Orthographic {
        left: -16.0,
        right: 16.0,
        bottom: -10.0,
        top: 10.0,
        near: 0.5,
        far: 500.0,
    };
    let (mut fronts, mut lost_as_written) = (0, 0);
    for (depth, projection) in [Depth::Standard, Depth::Reversed]
        .into_iter()
        .flat_map(|depth| [(depth, perspective), (depth, parallel)])
    {
        let camera = Camera::look_at([25.0, 18.0, 40.0], [0.0; 3], projection);
        let view = View::new(&camera, depth, SIZE).expect("a view");
        for slot in scene.slots().filter(|&slot| !scene.transform(slot).is_mirrored()) {
            for t in (0..scene.mesh(slot).triangle_count()).step_by(29) {
                let clip = placed(scene, slot, t).map(|p| in_clip(&view, p));
                if clip.iter().any(|p| p[3] <= 0.0) {
                    continue;
                }
                let third = ndc_normal_z(&clip.map(|p| [p[0] / p[3], p[1] / p[3]]));
                // The oracle is exact: what is edge-on to within rounding is on one side all the
                // same.
                if third.abs() < 1e-12 {
                    continue;
                }
                match facing_ref(&view, scene.transform(slot), &scene.mesh(slot).corners(t)) {
                    Facing::Front => {
                        fronts += 1;
                        lost_as_written += usize::from(third >= 0.0);
                        assert!(third > 0.0, "a front is lost");
                    }
                    Facing::Back => assert!(third < 0.0, "a back is kept"),
                    Facing::Edge => {}
                }
            }
        }
    }
    assert_eq!(lost_as_written, fronts);
    told(76, &[f64::from(fronts as u32)]);
}

/// Items 17 and 77: culling backs changes no picture of closed bodies, and one of a bowl that is
/// looked into.
#[test]
fn culling_backs_changes_no_picture_of_solids_and_one_of_an_open_bowl() {
    let mut model = built("solids");
    let pictures = |model: &cullet_io::Model| -> Vec<Vec<PixelId>> {
        views(model, "orbit", 3).iter().map(|view| draw(&model.scene, view).ids).collect()
    };
    let one_sided = pictures(&model);
    model.scene.edit_meshes(|_, mesh| mesh.set_two_sided(true));
    model.scene.commit(&Culler::default());
    assert!(one_sided == pictures(&model));
    // The ball without what lies above its middle, seen from above.
    let (positions, indices) = knobbly_ball(8);
    let is_low = |t: &&[u32; 3]| t.iter().map(|&v| positions[v as usize][1]).sum::<f32>() < 0.0;
    let lower: Vec<u32> =
        indices.as_chunks::<3>().0.iter().filter(is_low).flatten().copied().collect();
    let view = View::perspective([0.0, 3.0, 1.5], [0.0; 3], 1.0, 0.1, 10.0, SIZE).expect("a view");
    let [off, on] = [true, false].map(|two_sided| {
        let bowl = data((positions.clone(), lower.clone()), two_sided);
        draw(&scene_of(Mesh::new(bowl).expect("a bowl")), &view)
    });
    let inside = off.ids.iter().zip(&on.ids).filter(|(a, b)| a != b).count();
    assert!(inside > 1000);
    told(77, &[one_sided.len() as f64, inside as f64]);
}
