//! Views: what the kinds of culling take, and what is seen of it.

use std::collections::BTreeSet;

use cullet::cull::detail::Detail;
use cullet::{Camera, Culler, Depth, Output, Projection, Stage, View, ViewState, Visible};

use super::CITY;
use crate::lecture::finding::Finding;
use crate::lecture::geometry::{ball_with_degenerate, verified};
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{SIZE, cull, grouped, mesh, scene_of};

/// Each kind by itself drops something, and all but the small instances are such as leave the picture as it is.
pub(super) fn five_kinds(lab: &Lab) -> Result<Finding, LabError> {
    let city = lab.scene(CITY)?;
    let mut views = Vec::new();
    for view in lab.views(&city, "walk", 4, SIZE)? {
        views.push((&city.scene, view));
    }
    let ball = ball_with_degenerate(6);
    let ball = scene_of(mesh(ball.positions, ball.indices, false)?)?;
    let close = View::perspective([0.0, 0.0, 4.0], [0.0; 3], 1.0, 0.1, 10.0, SIZE)?;
    views.push((&ball, close));
    let detail = Some(Detail { threshold_px: 4.0, ..Detail::default() });
    let all = Culler { detail, output: Output::Triangles, ..Culler::exact() };
    let kinds =
        [Stage::Frustum, Stage::Detail, Stage::Degenerate, Stage::Backface, Stage::Occlusion];
    let (mut dropped, mut lost) = ([0; 5], 0);
    for (taken, stage) in dropped.iter_mut().zip(kinds) {
        let alone = all.only(stage);
        for (scene, view) in &views {
            if stage == Stage::Detail {
                *taken += cull(&alone, scene, view).funnel.dropped(stage).triangles;
            } else {
                let found = verified(&alone, scene, view);
                *taken += found.funnel.dropped(stage).triangles;
                lost += found.false_culls.len();
            }
        }
    }
    let [frustum, small, degenerate, back, occluded] = dropped;
    Ok(Finding::if_so(
        dropped.iter().all(|&n| n > 0) && lost == 0,
        format!(
            "alone each drops triangles in {} views: {} as outside, {} as small, {} as degenerate, {} as facing away, {} as occluded; \
             {lost} that are seen are lost but for the small ones",
            views.len(),
            grouped(frustum),
            grouped(small),
            grouped(degenerate),
            grouped(back),
            grouped(occluded)
        ),
    ))
}

/// The pictures of both are the same.
pub(super) fn pair_of_pictures(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene(CITY)?;
    let culler = Culler::exact().only(Stage::Frustum);
    let (mut all, mut left, mut pixels, mut differ) = (0, 0, 0, 0);
    for view in lab.views(&model, "walk", 6, SIZE)? {
        let found = verified(&culler, &model.scene, &view);
        all += found.all;
        left += found.potentially_visible;
        pixels += found.frame.ids.len();
        let pairs = found.frame.ids.iter().zip(&found.culled_frame.ids);
        differ += pairs.filter(|(before, after)| before != after).count();
    }
    Ok(Finding::if_so(
        differ == 0 && left < all,
        format!(
            "of {} triangles in six views {} are left, and of {} pixels {differ} differ",
            grouped(all),
            grouped(left),
            grouped(pixels)
        ),
    ))
}

/// An eye that turns once around: the set that is kept by what comes and goes is the one that is found afresh.
pub(super) fn turning(lab: &Lab) -> Result<Finding, LabError> {
    const STEPS: u32 = 36;
    let model = lab.scene(CITY)?;
    let culler = Culler::exact().only(Stage::Frustum);
    let (mut state, mut visible) = (ViewState::default(), Visible::default());
    let mut shown = BTreeSet::new();
    let (mut came, mut went) = (Vec::new(), Vec::new());
    let (mut changes, mut lost, mut differ) = (0, 0, 0);
    for step in 0..=STEPS {
        let angle = f64::from(step) / f64::from(STEPS) * std::f64::consts::TAU;
        let projection = Projection::Perspective {
            fov_y_radians: 1.0,
            aspect: 1.6,
            near: 0.1,
            far: f64::INFINITY,
        };
        let eye = [0.0, 1.7, 0.0];
        let camera = Camera {
            eye,
            direction: [angle.sin(), 0.0, -angle.cos()],
            up: [0.0, 1.0, 0.0],
            projection,
        };
        let view = View::new(&camera, Depth::Reversed, SIZE)?;
        let before = visible.clone();
        culler.cull_one(&model.scene, &view, &mut state, &mut visible);
        visible.changes_since(&before, &mut came, &mut went);
        changes += came.len() + went.len();
        shown.extend(came.iter().copied());
        for slot in &went {
            shown.remove(slot);
        }
        differ +=
            usize::from(!cull(&culler, &model.scene, &view).slots().eq(shown.iter().copied()));
        if step % 6 == 0 {
            lost += verified(&culler, &model.scene, &view).false_culls.len();
        }
    }
    let instances = model.scene.instance_count();
    Ok(Finding::if_so(
        changes > instances as usize && lost == 0 && differ == 0,
        format!(
            "once around in {STEPS} steps {changes} times an instance of {instances} comes or goes; the set kept so differs from the one \
             found afresh in {differ} steps, and {lost} visible triangles are missed"
        ),
    ))
}
