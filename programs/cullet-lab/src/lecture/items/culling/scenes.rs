//! Whole scenes: what is thrown away and what is cut.

use cullet::bounds::Plane;
use cullet::clip::{Clipper, Region};
use cullet::{Backface, Culler, Output, Stage};
use cullet_cut::{CutInput, CutOptions, cut};
use cullet_scenes::knobbly_ball;

use crate::lecture::finding::Finding;
use crate::lecture::geometry::triangles_in_world;
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{SIZE, cull, grouped, other};

/// Every triangle is dropped, taken as it is, or cut; what is cut has its place on the screen afterwards.
pub(super) fn culled_and_clipped(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene("city:cells=6,objects=200")?;
    let (mut culled, mut whole, mut cut_ones, mut without_place, mut off) = (0, 0, 0, 0, 0);
    let mut clipper = Clipper::new();
    for view in lab.views(&model, "walk", 6, SIZE)? {
        let region = Region::<f64, 3>::from(&view.frustum());
        for triangle in triangles_in_world(&model.scene) {
            let left = clipper.clip(&region, &triangle);
            if left.is_empty() {
                culled += 1;
                continue;
            }
            if left == triangle {
                whole += 1;
            } else {
                cut_ones += 1;
                without_place +=
                    u32::from(triangle.iter().any(|&p| view.project_point(p).is_none()));
            }
            for &p in left {
                let on = view.project_point(p).is_some_and(|[x, y, _]| {
                    (-1e-6..320.0 + 1e-6).contains(&x) && (-1e-6..200.0 + 1e-6).contains(&y)
                });
                off += u32::from(!on);
            }
        }
    }
    // The same cut opens a model.
    let (positions, indices) = knobbly_ball(8);
    let input = CutInput { positions: &positions, indices: &indices, ..CutInput::default() };
    let plane = [Plane::new([1.0, 0.0, 0.0], 0.1)];
    let opened = cut(&input, &plane, &CutOptions::default()).map_err(other)?;
    let beyond = opened.positions.iter().filter(|p| p[0] > 0.1 + 1e-6).count();
    Ok(Finding::if_so(
        culled > 0
            && whole > 0
            && without_place > 0
            && off == 0
            && beyond == 0
            && opened.report.cut_triangles > 0,
        format!(
            "of the triangles of six views {} are dropped, {} taken as they are and {} cut, {without_place} of which had a corner \
             without a place on the screen; {off} corners lie off it afterwards. A ball cut open has {} triangles cut and {beyond} \
             corners beyond the plane",
            grouped(culled),
            grouped(whole),
            grouped(cut_ones),
            grouped(opened.report.cut_triangles)
        ),
    ))
}

/// The built-in plant from its floor, by whole instances.
pub(super) fn power_plant(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene("plant:kinds=6")?;
    let scene = &model.scene;
    let exact = Culler { backface: Backface::Off, output: Output::Instances, ..Culler::exact() };
    let views = lab.views(&model, "camera:floor", 1, [640, 360])?;
    let view = views.first().ok_or_else(|| other("no camera on the floor"))?;
    let all = scene.triangle_count();
    let in_frustum = cull(&exact.only(Stage::Frustum), scene, view).triangle_count;
    let left = cull(&exact, scene, view).triangle_count;
    let close = |count: u64, millions: f64, off: f64| (count as f64 / 1e6 - millions).abs() < off;
    let measured = format!(
        "another plant, the built-in one, from its floor: {} triangles, {} in the frustum, {} after occlusion culling",
        grouped(all),
        grouped(in_frustum),
        grouped(left)
    );
    let alike = close(all, 12.0, 0.5) && close(in_frustum, 10.0, 0.5) && close(left, 1.0, 1.0);
    Ok(if alike { Finding::differs(measured) } else { Finding::fails(measured) })
}
