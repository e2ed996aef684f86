//! Clipping along the pipeline: in the world, in clip space, and not after the divide.

use cullet::clip::line::clip_line_ref;
use cullet::clip::{GuardBand, Region, space};
use cullet::cull::detail::Detail;
use cullet::view::FrustumPlane;
use cullet::{Backface, Culler, Depth, Output, Stage, Unit, View};
use cullet_draw::{ClipPlace, RenderOptions, Selection, render_clipped, render_ref};

use crate::lecture::finding::Finding;
use crate::lecture::geometry::{Random, in_clip, triangles_in_world, verified};
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{SIZE, grouped, other, placed};

/// Both places give the same picture and the same codes, in clip space by comparisons.
pub(super) fn best_place(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene("city:cells=4,objects=60")?;
    let scene = &model.scene;
    let options = RenderOptions::default();
    let (mut differ, mut corners, mut codes_differ) = (0, 0, 0);
    // Products: in the world, in clip space; and what is projected in clip space and then rejected.
    let (mut by_planes, mut in_clip_space, mut for_nothing, mut triangles) = (0, 0, 0, 0);
    for view in lab.views(&model, "walk", 3, [96, 60])? {
        let whole = render_ref(scene, &view, Selection::All, &options);
        for place in [ClipPlace::World, ClipPlace::Clip] {
            let clipped = render_clipped(scene, &view, place, &options);
            differ += whole.ids.iter().zip(&clipped.ids).filter(|(a, b)| a != b).count();
        }
        let region = Region::<f64, 3>::from(&view.frustum());
        // As wide as the view itself.
        let sides = GuardBand::new(view.depth(), 1.0).map_err(other)?;
        let planes = region.sides().count() as u64;
        for triangle in triangles_in_world(scene) {
            let codes = triangle.map(|p| {
                let (by_plane, by_side) =
                    (region.outcode(&p), sides.outcodes(&in_clip(&view, p))[0]);
                corners += 1;
                // What lies on a plane but for rounding is on either side.
                let on = region.sides().any(|(_, side)| side.height(&p).abs() < 1e-6);
                codes_differ += u32::from(by_plane != by_side && !on);
                by_side
            });
            let is_rejected = codes[0] & codes[1] & codes[2] != 0;
            triangles += 1;
            for_nothing += u32::from(is_rejected);
            // A corner: three a plane, sixteen to project it less those by its fourth number, which is 1.
            by_planes += 3 * (3 * planes + if is_rejected { 0 } else { 12 });
            in_clip_space += 3 * 12;
        }
    }
    let measured = format!(
        "both places give the same picture but for {differ} pixels, and the same codes of {} corners but for {codes_differ}, with {} \
         products in clip space, where comparisons follow, and {} in the world; of {} triangles {} are projected and then rejected",
        grouped(corners),
        grouped(in_clip_space),
        grouped(by_planes),
        grouped(triangles),
        grouped(for_nothing)
    );
    // Fewer products, but some of them for nothing: which of the two counts for more depends on the scene.
    let is_seen = differ == 0 && codes_differ == 0 && for_nothing > 0 && in_clip_space < by_planes;
    Ok(if is_seen { Finding::mended(measured) } else { Finding::fails(measured) })
}

/// Segments that pass the eye: divided first they have another place on the screen, clipped first they keep theirs.
pub(super) fn flip(_: &Lab) -> Result<Finding, LabError> {
    const CASES: u32 = 2000;
    let view = View::perspective([0.0; 3], [0.0, 0.0, -1.0], 1.0, 0.1, 100.0, SIZE)?;
    let near = space::near::<f64>(view.depth());
    let mut random = Random::new(98);
    let (mut behind, mut flipped, mut unclipped, mut right, mut missed) = (0, 0, 0, 0, 0);
    for _ in 0..CASES {
        let front =
            [random.between(-2.0, 2.0), random.between(-2.0, 2.0), random.between(-9.0, -1.0)];
        let back = [random.between(-2.0, 2.0), random.between(-2.0, 2.0), random.between(1.0, 9.0)];
        let [a, b] = [front, back].map(|p| in_clip(&view, p));
        behind += 1;
        unclipped += u32::from(space::divide(&b).is_none());
        // x/w of what is behind has the other sign than x.
        flipped += u32::from((b[0] / b[3] > 0.0) != (b[0] > 0.0));
        let Some([_, t]) = near.clip_line(&a, &b) else { continue };
        let at = |t: f64| -> [f64; 4] { std::array::from_fn(|k| a[k] + t * (b[k] - a[k])) };
        let (Some(start), Some(end)) = (space::divide(&a), space::divide(&at(t))) else { continue };
        let between = |x: f64, end: f64| {
            let (low, high) = (start[0].min(end), start[0].max(end));
            (low - 1e-9..=high + 1e-9).contains(&x)
        };
        // A point of the segment before the near plane, where it is seen.
        let Some(seen) = space::divide(&at(t * 0.5)) else { continue };
        right += u32::from(between(seen[0], end[0]));
        missed += u32::from(!between(seen[0], b[0] / b[3]));
    }
    Ok(Finding::if_so(
        unclipped == behind && flipped == behind && right == behind && missed > behind / 4,
        format!(
            "of {} segments past the eye {} have an end that divides to the wrong side; drawn so {} do not hold a point that is seen of \
             them, clipped first {} do",
            grouped(behind),
            grouped(flipped),
            grouped(missed),
            grouped(right)
        ),
    ))
}

/// The formula of the right side, and its like for the others, against the engine and exact arithmetic.
pub(super) fn clip_space(_: &Lab) -> Result<Finding, LabError> {
    const CASES: u32 = 2000;
    let full = space::full::<f64>(Depth::Standard);
    let right = full.clone().only(1 << FrustumPlane::Right as u32);
    let mut random = Random::new(99);
    let (mut crossed, mut wrong, mut worst) = (0, 0, 0.0_f64);
    for _ in 0..CASES {
        let [a, b]: [[f64; 4]; 2] = [random.point(3.0), random.point(3.0)];
        // Outside is x > w: a comparison.
        for p in [a, b] {
            let [x, y, z, w] = p;
            let past = [x < -w, x > w, y < -w, y > w, z < 0.0, z > w];
            let code = (0..).zip(past).fold(0, |code, (bit, past)| code | u32::from(past) << bit);
            wrong += u32::from(full.outcode(&p) != code);
        }
        let sides = [a, b].map(|p| p[0] > p[3]);
        if sides[0] == sides[1] {
            continue;
        }
        crossed += 1;
        let t = (a[3] - a[0]) / ((a[3] - a[0]) - (b[3] - b[0]));
        match (right.clip_line(&a, &b), clip_line_ref(&right, &a, &b)) {
            (Some(found), Some(exact)) => {
                let found_t = if sides[0] { found[0] } else { found[1] };
                let exact_t = if sides[0] { exact[0] } else { exact[1] };
                worst = worst.max((t - found_t).abs()).max((t - exact_t).abs());
            }
            _ => wrong += 1,
        }
    }
    Ok(Finding::if_so(
        wrong == 0 && crossed > 500 && worst < 1e-9,
        format!(
            "comparisons give the codes of {} points but for {wrong}; {} lines cross x = w where the formula says, the engine and exact \
             arithmetic within {worst:.0e}",
            grouped(2 * CASES),
            grouped(crossed)
        ),
    ))
}

/// All stages together, from instances over clusters to triangles; what is left is clipped, and the picture is the same.
pub(super) fn all_stages(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene("solids")?;
    let scene = &model.scene;
    let detail = Some(Detail { threshold_px: 0.01, ..Detail::default() });
    let culler =
        Culler { detail, backface: Backface::Exact, output: Output::Triangles, ..Culler::exact() };
    let views = lab.views(&model, "walk", 8, SIZE)?;
    let view = views.get(2).ok_or_else(|| other("no third view"))?;
    let found = verified(&culler, scene, view);
    let rows = &found.funnel.rows;
    let chained = rows.windows(2).all(|pair| pair[0].left == pair[1].entered);
    let first = |unit: Unit| rows.iter().position(|row| row.unit == unit);
    let in_order = match (first(Unit::Instances), first(Unit::Clusters), first(Unit::Triangles)) {
        (Some(instances), Some(clusters), Some(triangles)) => {
            instances < clusters && clusters < triangles
        }
        _ => false,
    };
    let of = |unit: Unit| {
        let own = rows.iter().filter(|row| row.unit == unit);
        own.map(|row| row.dropped().triangles).sum::<u64>()
    };
    let units = [Unit::Instances, Unit::Clusters, Unit::Triangles].map(of);
    // What is left and crosses a side of the view.
    let region = space::full::<f64>(view.depth());
    let mut cut = 0;
    for range in &found.result.triangle_ranges {
        let triangles = &found.result.triangles[range.first as usize..][..range.count as usize];
        for &t in triangles {
            let corners = scene.mesh(range.slot).corners(t);
            let clip = corners.map(|p| in_clip(view, placed(scene.transform(range.slot), p)));
            cut += u32::from(clip.iter().any(|p| region.outcode(p) != 0));
        }
    }
    let stages = Stage::ALL.iter().filter(|&&s| found.funnel.dropped(s).triangles > 0).count();
    let dropped: u64 = units.iter().sum();
    Ok(Finding::if_so(
        chained
            && in_order
            && stages >= 3
            && cut > 0
            && found.false_culls.is_empty()
            && dropped + found.potentially_visible == found.all,
        format!(
            "of {} triangles {} go with whole instances, {} with clusters and {} by themselves, by {stages} stages; of the {} left {cut} \
             are cut, and the picture is the same",
            grouped(found.all),
            grouped(units[0]),
            grouped(units[1]),
            grouped(units[2]),
            grouped(found.potentially_visible)
        ),
    ))
}
