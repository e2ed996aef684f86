//! The test of single triangles, and its settings.

use crate::methods::screen::{flips_winding, screen_facing};
use cullet::cull::backface::{Facing, ObjectEye, facing_ref};
use cullet::{CullFace, Culler, FrontFace, Stage, View};

use super::normal;
use crate::lecture::finding::Finding;
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{SIZE, cull_triangles, draw, grouped, left, placed, seen, times};

const BALL: &str = "knobs:n=16";

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] - b[i])
}

/// The formula at each corner and in the middle, the engine, and arithmetic without rounding.
pub(super) fn any_point(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene(BALL)?;
    let scene = &model.scene;
    let (mut decided, mut backs, mut astray, mut wrong, mut spread) = (0, 0, 0, 0, 0.0f64);
    for view in lab.views(&model, "orbit", 4, SIZE)? {
        let [x, y, z, _] = view.eye();
        let object = ObjectEye::of_view(&view, scene.transform(0));
        for t in 0..scene.mesh(0).triangle_count() {
            let corners = scene.mesh(0).corners(t);
            let truth = facing_ref(&view, scene.transform(0), &corners);
            wrong += usize::from(object.facing(&corners) != truth);
            if truth == Facing::Edge {
                continue;
            }
            decided += 1;
            backs += usize::from(truth == Facing::Back);
            let [a, b, c] = corners.map(|p| placed(scene.transform(0), p));
            let middle = [0, 1, 2].map(|i| (a[i] + b[i] + c[i]) / 3.0);
            let n = normal(&corners);
            let size = dot(n, n).sqrt();
            let values = [a, b, c, middle].map(|p| dot(n, minus(p, [x, y, z])) / size);
            let low = values.into_iter().fold(f64::INFINITY, f64::min);
            let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
            spread = spread.max(high - low);
            astray += values.iter().filter(|&&v| (v > 0.0) != (truth == Facing::Back)).count();
        }
    }
    let seen = wrong == 0 && astray == 0 && spread < 1e-6 && backs * 3 > decided && backs < decided;
    let measured = format!(
        "of {} triangles in four views {} face away; n·(p − eye) has that sign at each corner and in the middle of each, but for {astray}, and \
         these four values are apart by {spread:.0e} at the most; the engine is wrong of {wrong}",
        grouped(decided),
        grouped(backs)
    );
    Ok(if seen { Finding::mended(measured) } else { Finding::fails(measured) })
}

/// Both signs, in a view along −Z.
pub(super) fn parallel(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene(BALL)?;
    let scene = &model.scene;
    let (eye, target) = ([0.0, 1.15, 5.0], [0.0, 1.15, 0.0]);
    let view = View::orthographic(eye, target, 2.6, 0.1, 10.0, SIZE)?;
    // Not −0.
    let towards = view.eye().map(|v| v + 0.0);
    let shown = seen(&draw(scene, &view));
    let culled = cull_triangles(&Culler::default().only(Stage::Backface), scene, &view);
    let kept = left(scene, &culled);
    let mesh = scene.mesh(0);
    let (mut lost, mut wrong, mut decided) = ([0; 2], [0; 2], 0);
    for t in 0..mesh.triangle_count() {
        let corners = mesh.corners(t);
        let truth = facing_ref(&view, scene.transform(0), &corners);
        if truth == Facing::Edge {
            continue;
        }
        decided += 1;
        let is_shown = shown.contains(&(0, mesh.original_triangle()[t as usize]));
        for (rule, v) in [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]].into_iter().enumerate() {
            let culls = dot(normal(&corners), v) > 0.0;
            wrong[rule] += usize::from(culls != (truth == Facing::Back));
            lost[rule] += usize::from(culls && is_shown);
        }
    }
    let engine = shown.is_subset(&kept) && kept.len() < mesh.triangle_count() as usize;
    let is_right = wrong == [decided, 0] && lost == [shown.len(), 0];
    let measured = format!(
        "in a parallel view along −Z, whose eye is ({}, {}, {}, {}), v = (0, 0, 1) is wrong for {} of {} triangles and drops all {} that are \
         visible, and v = (0, 0, −1) is wrong for {}; the engine keeps {} and loses none",
        towards[0],
        towards[1],
        towards[2],
        towards[3],
        grouped(wrong[0]),
        grouped(decided),
        grouped(lost[0]),
        wrong[1],
        grouped(kept.len())
    );
    let eye_is_right = towards == [0.0, 0.0, 1.0, 0.0];
    let seen = engine && is_right && eye_is_right;
    Ok(if seen { Finding::mended(measured) } else { Finding::fails(measured) })
}

/// Each setting against the winding of each triangle on the screen, as graphics hardware has it.
pub(super) fn settings(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene(BALL)?;
    let scene = &model.scene;
    let mut view = lab.views(&model, "orbit", 4, SIZE)?.swap_remove(1);
    let flipped = flips_winding(&view, scene.transform(0));
    let clip = |p: [f32; 3]| {
        let [x, y, z] = placed(scene.transform(0), p);
        times(&view.clip_from_world(), [x, y, z, 1.0])
    };
    let mesh_in_clip_space: Vec<_> =
        (0..scene.mesh(0).triangle_count()).map(|t| scene.mesh(0).corners(t).map(clip)).collect();
    let mesh = scene.mesh(0);
    let culler = Culler::default().only(Stage::Backface);
    let (mut differ, mut counts) = (0, Vec::new());
    for front_face in [FrontFace::CounterClockwise, FrontFace::Clockwise] {
        for cull_face in [CullFace::None, CullFace::Back, CullFace::Front] {
            (view.front_face, view.cull_face) = (front_face, cull_face);
            let kept = left(scene, &cull_triangles(&culler, scene, &view));
            let gone = match cull_face {
                CullFace::None => Facing::Edge,
                CullFace::Back => Facing::Back,
                CullFace::Front => Facing::Front,
            };
            for (corners, &original) in mesh_in_clip_space.iter().zip(mesh.original_triangle()) {
                let facing = screen_facing(corners, flipped, front_face);
                let goes = facing == gone && facing != Facing::Edge;
                let is_kept = kept.contains(&(0, original));
                differ += usize::from(is_kept == goes);
            }
            counts.push(kept.len());
        }
    }
    let [all, fronts, backs, all_again, turned_fronts, turned_backs] = counts[..] else {
        return Ok(Finding::fails("settings are missing"));
    };
    let edges = (fronts + backs).saturating_sub(all);
    let is_turned = (all_again, turned_fronts, turned_backs) == (all, backs, fronts);
    Ok(Finding::if_so(
        differ == 0 && is_turned && fronts < all && backs < all && fronts + backs >= all,
        format!(
            "of {} triangles {} are left without back faces and {} without front faces ({edges} are edge-on and in both), the other way \
             around where clockwise is front, and {} with culling off; the winding on the screen says the same of each",
            grouped(all),
            grouped(fronts),
            grouped(backs),
            grouped(all_again)
        ),
    ))
}
