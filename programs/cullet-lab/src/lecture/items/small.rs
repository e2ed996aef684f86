//! What is too small, and what has no area.

use std::collections::BTreeMap;

use cullet::cull::degenerate::is_zero_area;
use cullet::cull::detail::Detail;
use cullet::mesh::is_degenerate;
use cullet::{Culler, Stage, View};

use crate::lecture::finding::Finding;
use crate::lecture::geometry::{ball_with_degenerate, cross, verified};
use crate::lecture::item::{BLANK, Item, Live, ucsd};
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{SIZE, cull, draw, grouped, mesh, scene_of};

pub(super) const ITEMS: &[Item] = &[
    Item {
        number: 72,
        title: "Small instances",
        places: &[ucsd("Small Object Culling")],
        claim: "An instance is culled if the box around its picture is smaller than a threshold in pixels.",
        command: "cullet picture kinds city --detail 12 --path walk --views 8 --view 2",
        live: Some(Live { scene: "city", state: "stages.detail_px=8&look.colour=pops" }),
        chapter: "detail.md",
        check: small_instances,
        ..BLANK
    },
    Item {
        number: 73,
        title: "Degenerate triangles",
        places: &[ucsd("Degenerate Culling")],
        claim: "A degenerate triangle has no area, so its normal is zero: its corners lie in one line or in one place. It is never \
                seen.",
        command: "cullet info city-rotterdam/delfshaven.glb",
        chapter: "degenerate.md",
        check: degenerate,
        ..BLANK
    },
];

/// What is dropped is what each box says by itself, and covers no more than the square of the threshold.
fn small_instances(lab: &Lab) -> Result<Finding, LabError> {
    const THRESHOLD: f64 = 4.0;
    let model = lab.scene("city:cells=12,objects=1500")?;
    let scene = &model.scene;
    let detail = Detail { threshold_px: THRESHOLD, ..Detail::default() };
    let culler = Culler { detail: Some(detail), reasons: true, ..Culler::exact() };
    let culler = culler.only(Stage::Detail);
    let (mut small, mut differ, mut seen, mut largest) = (0, 0, 0, 0);
    for view in lab.views(&model, "walk", 4, SIZE)? {
        let visible = cull(&culler, scene, &view);
        let mut covered = BTreeMap::new();
        for id in &draw(scene, &view).ids {
            *covered.entry(id.slot).or_insert(0) += 1;
        }
        for slot in scene.slots() {
            let rect = view.project_box(&scene.bounds(slot), scene.origin());
            let is_small = rect.is_some_and(|r| r.width() < THRESHOLD && r.height() < THRESHOLD);
            let dropped = visible.reasons[slot as usize].is_some_and(|r| r.stage == Stage::Detail);
            differ += u32::from(is_small != dropped);
            small += u32::from(dropped);
            if dropped {
                let pixels = covered.get(&slot).copied().unwrap_or(0);
                seen += u32::from(pixels > 0);
                largest = largest.max(pixels);
            }
        }
    }
    Ok(Finding::if_so(
        small > 0 && differ == 0 && f64::from(largest) <= THRESHOLD * THRESHOLD,
        format!(
            "{} instances of four views are dropped under 4 pixels, {differ} others than their boxes say; {seen} of them are seen, \
             none in more than {largest} pixels",
            grouped(small)
        ),
    ))
}

/// Each form is found, a sliver is none, and nothing of them is seen.
fn degenerate(lab: &Lab) -> Result<Finding, LabError> {
    let [o, x] = [[0.0, 0.0, 0.0_f32], [1.0, 0.0, 0.0]];
    // All in one place; two in one place; in a line, which is exact in these numbers.
    let flat = [[x, x, x], [o, x, o], [[1.0, 2.0, 4.0], [1.5, 3.0, 6.0], [3.0, 6.0, 12.0]]];
    let sliver = [o, x, [0.5, 1e-30, 0.0]];
    let zero_normals = flat.iter().filter(|&t| normal(t) == [0.0; 3]).count();
    let found = flat.iter().filter(|&t| is_zero_area(t)).count();
    if zero_normals != flat.len() || found != flat.len() || is_zero_area(&sliver) {
        return Ok(Finding::fails(format!("{found} of {} forms are found", flat.len())));
    }
    let ball = ball_with_degenerate(8);
    let added = ball.positions.len() as u32;
    let scene = scene_of(mesh(ball.positions, ball.indices, false)?)?;
    let aside = scene.meshes()[0].degenerate_count();
    let view = View::perspective([0.0, 1.0, 4.0], [0.0; 3], 1.0, 0.1, 10.0, SIZE)?;
    let drawn = verified(&Culler::exact().only(Stage::Degenerate), &scene, &view);
    let dropped = drawn.funnel.dropped(Stage::Degenerate).triangles;
    let lost = drawn.false_culls.len();

    let real = lab.model("city-rotterdam/delfshaven.glb")?;
    let (mut listed, mut counted, mut triangles) = (0, 0, 0);
    for mesh in real.iter().flat_map(|model| model.scene.meshes()) {
        triangles += mesh.triangle_count();
        counted += mesh.degenerate_count();
        // Of the original list, by the rule.
        let indices = mesh.original_indices();
        let corners = indices.as_chunks::<3>().0.iter();
        listed += corners.filter(|&&t| is_degenerate(t, mesh.positions())).count() as u32;
    }
    let of_real = match real {
        Some(_) => format!("; a city of {} has {}", grouped(triangles), grouped(counted)),
        None => String::new(),
    };
    Ok(Finding::if_so(
        aside == added && dropped == u64::from(added) && lost == 0 && listed == counted,
        format!(
            "all {found} forms have a normal of zero, a sliver of 1e-30 has not; of a ball the {} that were added go, and {lost} seen \
             triangles{of_real}",
            grouped(dropped)
        ),
    ))
}

fn normal(corners: &[[f32; 3]; 3]) -> [f64; 3] {
    let [a, b, c] = corners.map(|p| p.map(f64::from));
    let from_a = |p: [f64; 3]| [p[0] - a[0], p[1] - a[1], p[2] - a[2]];
    cross(from_a(b), from_a(c))
}
