//! What is visible, and sets that hold it.

use cullet::{Culler, Depth, Scene, Stage, TriangleRange, View, ViewState, Visible};
use cullet_draw::{
    ClipPlace, Frame, PixelId, RenderOptions, Selection, VerifyOptions, render, render_clipped,
    verify,
};

use crate::lecture::finding::Finding;
use crate::lecture::item::{BLANK, Item, Live, zachmann};
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{
    SIZE, all_triangles, cube, cull_triangles, draw, draw_of, grouped, left, mesh, percent,
    scene_of, seen, sheets,
};

pub(super) const ITEMS: &[Item] = &[
    Item {
        number: 7,
        title: "Three classes of problems",
        places: &[zachmann("slide 3")],
        claim: "Removing hidden surfaces says which parts are covered by others, clipping which parts are within the picture, culling which \
                primitives cannot be visible. The first two make the picture right, the third makes it fast; the boundary is blurred.",
        command: "cullet verify solids:n=6 --views 3 --size 320x200",
        live: Some(Live { scene: "solids:n=9", state: "layout=wipe" }),
        chapter: "kinds.md#culling-clipping-hidden-surface-removal",
        check: three_classes,
        ..BLANK
    },
    Item {
        number: 8,
        title: "All primitives and the visible ones",
        places: &[zachmann("slide 4")],
        claim: "Without culling a frame costs at least as much as there are primitives, |A|, however few are visible, |S|. That is no problem \
                where |S| is near |A|, or where primitives are few beside the pixels.",
        command: "cullet report city --path walk --views 4 --size 640x360",
        live: Some(Live { scene: "city:cells=12,objects=1500", state: "layout=split" }),
        chapter: "why.md#a-s-and-c",
        check: all_and_visible,
        ..BLANK
    },
    Item {
        number: 9,
        title: "Depth complexity",
        places: &[zachmann("slide 4")],
        claim: "Depth complexity is how many surfaces lie behind a pixel, one in front of the other: so often is it filled.",
        command: "cullet picture depth office --path walk --views 4 --view 1",
        live: Some(Live { scene: "office", state: "look.colour=overdraw" }),
        chapter: "first-report.md#reading-the-page",
        check: depth_complexity,
        ..BLANK
    },
    Item {
        number: 10,
        title: "Culling as an optimisation",
        places: &[zachmann("slide 5"), zachmann("slide 6")],
        claim: "In complex scenes far fewer primitives are visible than there are. Culling finds primitives of C = A ∖ S, or a superset \
                of S, and changes no picture.",
        command: "cullet verify city --path walk --views 4 --size 640x360",
        live: Some(Live {
            scene: "city:cells=12,objects=1500",
            state: "layout=split&ghosts.form=boxes",
        }),
        chapter: "why.md",
        check: culling_as_optimisation,
        ..BLANK
    },
    Item {
        number: 11,
        title: "Potentially visible sets",
        places: &[zachmann("slide 6")],
        claim: "A potentially visible set S′ is any superset of S. It should be as small as possible for as little effort as possible; the \
                trivial one, for no effort, is A.",
        command: "cullet verify office --path walk --views 4 --size 640x360",
        live: Some(Live { scene: "office", state: "layout=split&structure.cells=true" }),
        chapter: "why.md#potentially-visible-sets",
        check: potentially_visible,
        ..BLANK
    },
    Item {
        number: 12,
        title: "Kinds of culling",
        places: &[zachmann("slide 7")],
        claim: "There are five kinds: what is outside the view, too small, facing away, in rooms that cannot be seen into, or behind something. \
                Each takes what no other does.",
        command: "cullet picture kinds office --path walk --views 8 --view 3 --detail 40",
        live: Some(Live {
            scene: "office",
            state: "layout=split&look.colour=reason&stages.detail_px=40",
        }),
        chapter: "kinds.md",
        check: five_kinds,
        ..BLANK
    },
];

/// The three, each against an oracle that has nothing of it.
fn three_classes(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene("solids:n=6")?;
    let scene = &model.scene;
    let view = lab.views(&model, "orbit", 3, [160, 100])?.swap_remove(1);
    let options = RenderOptions::default();
    let whole = draw(scene, &view);

    // Hidden surfaces: of the instances drawn one by one, the nearest one.
    let nearest = nearest_of_each(scene, &view);
    let unhidden = whole.ids.iter().zip(&nearest).filter(|(id, slot)| id.slot == **slot).count();
    let pixels = whole.ids.len();
    // Clipping, in either place.
    let places = [ClipPlace::World, ClipPlace::Clip];
    let changed: usize = places
        .iter()
        .map(|&place| {
            let clipped = render_clipped(scene, &view, place, &options);
            clipped.ids.iter().zip(&whole.ids).filter(|(a, b)| a != b).count()
        })
        .sum();
    let culled = cull_triangles(&Culler::default(), scene, &view);
    let after = render(scene, &view, Selection::Visible(&culled), &options);
    let all = scene.triangle_count();
    Ok(Finding::if_so(
        // A sample on an edge to the last bit may change owners.
        changed <= 2 && unhidden == pixels && after.ids == whole.ids && culled.triangle_count < all,
        format!(
            "of {} covered samples {} pixels keep the nearest; clipping before or after projection changes {changed} pixels, and culling \
             {} of {} triangles none",
            grouped(whole.stats.fragments),
            grouped(whole.stats.covered_pixels),
            grouped(all - culled.triangle_count),
            grouped(all)
        ),
    ))
}

/// The slot of the nearest instance at each pixel, by a picture of each instance alone.
fn nearest_of_each(scene: &Scene, view: &View) -> Vec<u32> {
    let [width, height] = view.viewport();
    let mut nearest = vec![(f64::INFINITY, u32::MAX); (width * height) as usize];
    for slot in scene.slots() {
        let frame = alone(scene, view, slot);
        let at = frame.ids.iter().zip(&frame.depth).zip(&mut nearest);
        for ((_, depth), held) in at.filter(|((id, _), _)| **id != PixelId::NONE) {
            let depth = match view.depth() {
                Depth::Standard => *depth,
                Depth::Reversed => -depth,
            };
            if depth < held.0 {
                *held = (depth, slot);
            }
        }
    }
    nearest.into_iter().map(|(_, slot)| slot).collect()
}

/// A picture of one instance.
fn alone(scene: &Scene, view: &View, slot: u32) -> Frame {
    let count = scene.mesh(slot).triangle_count();
    let range = TriangleRange { slot, level: 0, first: 0, count };
    let triangles = (0..count).collect();
    let one = Visible { triangle_ranges: vec![range], triangles, ..Visible::default() };
    draw_of(scene, view, Selection::Visible(&one))
}

fn all_and_visible(lab: &Lab) -> Result<Finding, LabError> {
    // The same city, of as much ground again in either direction.
    let mut sizes = Vec::new();
    for words in ["city:cells=12,objects=800", "city:cells=24,objects=3200"] {
        let model = lab.scene(words)?;
        let views = lab.views(&model, "walk", 8, SIZE)?;
        let mean = |of: &dyn Fn(&View) -> u64| views.iter().map(of).sum::<u64>() / 8;
        let visible = mean(&|view| draw(&model.scene, view).visible().len() as u64);
        let kept =
            mean(&|view| cull_triangles(&Culler::exact(), &model.scene, view).triangle_count);
        sizes.push([model.scene.triangle_count(), kept, visible]);
    }
    let grows = |i: usize| sizes[1][i] as f64 / sizes[0][i] as f64;

    let front = View::orthographic([0.0; 3], [0.0, 0.0, -1.0], 2.0, 0.1, 10.0, SIZE)?;
    let sheet = sheets(1, [40, 40])?;
    let all_seen = [
        sheet.triangle_count(),
        cull_triangles(&Culler::default(), &sheet, &front).triangle_count,
        seen(&draw(&sheet, &front)).len() as u64,
    ];
    let (positions, indices) = cube();
    let block = scene_of(mesh(positions, indices, false)?)?;
    let near = View::perspective([2.0, 1.5, 3.0], [0.0; 3], 1.0, 0.1, 100.0, SIZE)?;
    let culled = cull_triangles(&Culler::default(), &block, &near);
    let [before, after] = [Selection::All, Selection::Visible(&culled)]
        .map(|selection| draw_of(&block, &near, selection).stats.fragments);
    let [all, kept, visible] = sizes[1];
    Ok(Finding::if_so(
        grows(0) > 3.0
            && grows(1) < 0.75 * grows(0)
            && all > 20 * visible
            && all_seen[0] == all_seen[1]
            && all_seen[0] == all_seen[2]
            && culled.triangle_count < 12
            && before == after,
        format!(
            "a city of four times the ground has {:.1} times the triangles and {:.1} times those that are left after culling, {} of {}, of \
             which {} are visible; of a sheet all {} are visible and all are left; of a block culling takes {} of 12 triangles and none of \
             its {} samples",
            grows(0),
            grows(1),
            grouped(kept),
            grouped(all),
            grouped(visible),
            grouped(all_seen[0]),
            12 - culled.triangle_count,
            grouped(before)
        ),
    ))
}

fn depth_complexity(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene("office")?;
    let scene = &model.scene;
    let view = lab.views(&model, "walk", 4, [160, 100])?.swap_remove(1);
    let whole = draw(scene, &view);
    // Each instance alone: what it covers adds up.
    let mut sum = vec![0; whole.layers.len()];
    for slot in scene.slots() {
        let frame = alone(scene, &view, slot);
        frame.layers.iter().zip(&mut sum).for_each(|(n, sum)| *sum += n);
    }
    let culled = cull_triangles(&Culler::exact(), scene, &view);
    let after = draw_of(scene, &view, Selection::Visible(&culled)).stats;
    let before = whole.stats;
    Ok(Finding::if_so(
        sum == whole.layers
            && after.mean_layers < before.mean_layers
            && before.max_layers > 2
            && after.covered_pixels == before.covered_pixels,
        format!(
            "in an office {} samples on {} pixels are {:.2} layers on average and {} at the most, as instances drawn one by one add up to; after culling {:.2}",
            grouped(before.fragments),
            grouped(before.covered_pixels),
            before.mean_layers,
            before.max_layers,
            after.mean_layers
        ),
    ))
}

fn culling_as_optimisation(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene("city:cells=12,objects=800")?;
    let scene = &model.scene;
    let (mut all, mut kept, mut visible, mut lost) = (0, 0, 0, 0);
    for view in lab.views(&model, "walk", 4, SIZE)? {
        let options = VerifyOptions { samples: 1, ..VerifyOptions::default() };
        let proof = verify(scene, &view, &Culler::default(), &mut ViewState::default(), &options);
        // Of all four views together.
        all += proof.all;
        kept += proof.potentially_visible;
        visible += proof.visible;
        let dropped = &all_triangles(scene) - &left(scene, &proof.result);
        lost += dropped.intersection(&seen(&proof.frame)).count() + proof.false_culls.len();
    }
    let unseen = all - visible;
    Ok(Finding::if_so(
        lost == 0 && visible * 10 < all && (all - kept) * 2 > unseen,
        format!(
            "in four views of a city {} of {} triangles are visible ({}); culling drops {} of those in A ∖ S and {lost} of those in S",
            grouped(visible),
            grouped(all),
            percent(visible, all),
            percent(all - kept, unseen)
        ),
    ))
}

/// The ladder from all to what is visible.
fn potentially_visible(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene("office")?;
    let scene = &model.scene;
    let stages = [Stage::Frustum, Stage::Portal, Stage::Backface, Stage::Occlusion];
    let full = Culler::exact();
    // Each rung has one stage more.
    let rung = |steps: usize| {
        let others = stages[steps..].iter().chain([&Stage::Degenerate, &Stage::Pvs]);
        others.fold(full.clone(), |culler, &stage| culler.without(stage))
    };
    let (mut sizes, mut efforts) = (vec![0; stages.len() + 1], vec![0; stages.len() + 1]);
    let (mut visible, mut nested) = (0, true);
    for view in lab.views(&model, "walk", 4, SIZE)? {
        let truth = seen(&draw(scene, &view));
        visible += truth.len() as u64;
        let mut before = all_triangles(scene);
        for steps in 0..=stages.len() {
            let result = cull_triangles(&rung(steps), scene, &view);
            let set = left(scene, &result);
            nested &= set.is_subset(&before) && truth.is_subset(&set);
            sizes[steps] += set.len() as u64;
            let rows = result.funnel.rows.iter().filter(|row| row.stage != Stage::Layer);
            efforts[steps] += rows.map(|row| row.entered.of(row.unit)).sum::<u64>();
            before = set;
        }
    }
    let is_smaller = sizes.windows(2).all(|pair| pair[1] < pair[0]);
    let rungs: Vec<String> = ["A", "frustum", "+ portals", "+ back faces", "+ occlusion"]
        .iter()
        .zip(sizes.iter().zip(&efforts))
        .map(|(name, (size, effort))| {
            format!("{name} {} ({} tests)", grouped(size / 4), grouped(effort / 4))
        })
        .collect();
    Ok(Finding::if_so(
        nested && is_smaller && efforts[0] == 0 && sizes[4] >= visible,
        format!(
            "in an office, each a superset of the next: {}; S itself {} triangles a view",
            rungs.join(", "),
            grouped(visible / 4)
        ),
    ))
}

fn five_kinds(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene("office")?;
    let scene = &model.scene;
    let detail = cullet::cull::detail::Detail { threshold_px: 11.0, ..Default::default() };
    let all = Culler { detail: Some(detail), ..Culler::exact() };
    let kinds = [
        ("frustum", Stage::Frustum),
        ("detail", Stage::Detail),
        ("back faces", Stage::Backface),
        ("portals", Stage::Portal),
        ("occlusion", Stage::Occlusion),
    ];
    let (mut taken, mut own, mut total, mut together) = ([0u64; 5], [0u64; 5], 0, 0);
    for view in lab.views(&model, "walk", 8, SIZE)? {
        let result = cull_triangles(&all, scene, &view);
        let kept = left(scene, &result);
        total += scene.triangle_count();
        let takes = |(_, stage)| result.funnel.dropped(stage).triangles > 0;
        together += u32::from(kinds.into_iter().all(takes));
        for (at, (_, stage)) in kinds.into_iter().enumerate() {
            taken[at] += result.funnel.dropped(stage).triangles;
            let more = left(scene, &cull_triangles(&all.without(stage), scene, &view));
            own[at] += more.difference(&kept).count() as u64;
        }
    }
    let each: Vec<String> = kinds
        .iter()
        .zip(taken.iter().zip(&own))
        .map(|((name, _), (taken, own))| {
            format!("{name} {} ({} that no other takes)", percent(*taken, total), grouped(*own))
        })
        .collect();
    Ok(Finding::if_so(
        together > 0 && own.iter().all(|&n| n > 0),
        format!(
            "in eight views of an office, {together} of them with all five kinds, of {} triangles: {}",
            grouped(total),
            each.join(", ")
        ),
    ))
}
