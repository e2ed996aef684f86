//! The kinds of culling, one by one.

use cullet::cull::detail::Detail;
use cullet::{Culler, Output, Scene, Stage, View, ViewState, Visible};
use cullet_draw::{RenderOptions, Selection, VerifyOptions, render, verify};

use crate::lecture::finding::Finding;
use crate::lecture::item::{BLANK, Item, Live, zachmann};
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{
    SIZE, all_triangles, cull, cull_triangles, draw, grouped, left, percent, placed, seen,
};

pub(super) const ITEMS: &[Item] = &[
    Item {
        number: 13,
        title: "View-frustum culling",
        places: &[zachmann("slide 7")],
        claim: "View-frustum culling drops what lies outside the volume that the camera sees.",
        command: "cullet picture map city --path walk --views 4 --view 1",
        live: Some(Live {
            scene: "city:cells=12,objects=1500",
            state: "layout=split&stages.backface=off&ghosts.form=boxes",
        }),
        chapter: "frustum.md",
        check: frustum,
        ..BLANK
    },
    Item {
        number: 14,
        title: "Detail culling",
        places: &[zachmann("slide 7")],
        claim: "Detail culling drops what is too small on the screen to matter. Of the five kinds it alone may change the picture, by \
                as much as one says.",
        command: "cullet report city --path walk --views 4 --size 640x360 --detail 4",
        live: Some(Live {
            scene: "city:cells=12,objects=1500",
            state: "layout=split&look.colour=reason&stages.detail_px=4",
        }),
        chapter: "detail.md#detail-culling",
        check: detail,
        ..BLANK
    },
    Item {
        number: 15,
        title: "Portal culling",
        places: &[zachmann("slide 7")],
        claim: "Portal culling drops what stands in rooms that cannot be seen into through any chain of doors and windows.",
        command: "cullet picture portals office --path walk --views 8 --view 3",
        live: Some(Live { scene: "office", state: "structure.portals=true&layout=split" }),
        chapter: "portals.md#the-walk",
        check: portals,
        ..BLANK
    },
    Item {
        number: 16,
        title: "Occlusion culling",
        places: &[zachmann("slide 7")],
        claim: "Occlusion culling drops what is in the view but lies behind something else.",
        command: "cullet picture hidden city --path walk --views 4 --view 1",
        live: Some(Live {
            scene: "city:cells=12,objects=1500",
            state: "camera.target=[0,3,0]&camera.distance=60&camera.pitch=-3&camera.yaw=0&layout=split&ghosts.form=solid",
        }),
        chapter: "occlusion.md#what-hidden-means-here",
        check: occlusion,
        ..BLANK
    },
];

const CITY: &str = "city:cells=6,objects=200";

/// The corners of an instance in the world.
fn corners(scene: &Scene, slot: u32) -> Vec<[f64; 3]> {
    let place = scene.transform(slot);
    scene.mesh(slot).positions().iter().map(|&p| placed(place, p)).collect()
}

/// The slots of which a result has nothing.
fn dropped<'a>(scene: &'a Scene, visible: &Visible) -> impl Iterator<Item = u32> + use<'a> {
    let kept: Vec<u32> = visible.slots().collect();
    scene.slots().filter(move |slot| kept.binary_search(slot).is_err())
}

/// Triangles of which a picture shows something though a culler dropped them, in some views; and how many it dropped, and of how many.
fn lost(scene: &Scene, views: &[View], culler: &Culler) -> (usize, [u64; 2]) {
    let (mut lost, mut counts) = (0, [0; 2]);
    for view in views {
        let kept = left(scene, &cull_triangles(culler, scene, view));
        let all = all_triangles(scene);
        lost += seen(&draw(scene, view)).difference(&kept).count();
        counts[0] += (all.len() - kept.len()) as u64;
        counts[1] += all.len() as u64;
    }
    (lost, counts)
}

fn frustum(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene(CITY)?;
    let scene = &model.scene;
    let views = lab.views(&model, "walk", 4, SIZE)?;
    let culler = Culler::default().only(Stage::Frustum);
    let (mut unproved, mut gone, mut missed, mut all) = (0, 0, 0, 0);
    for view in &views {
        let visible = cull(&Culler { output: Output::Instances, ..culler.clone() }, scene, view);
        let frustum = view.frustum();
        // By all corners of its triangles: one plane has them all outside.
        let is_outside = |slot: u32| {
            let corners = corners(scene, slot);
            frustum.planes().any(|(_, plane)| corners.iter().all(|&p| plane.distance(p) > 0.0))
        };
        let slots: Vec<u32> = dropped(scene, &visible).collect();
        unproved += slots.iter().filter(|&&slot| !is_outside(slot)).count();
        missed += visible.slots().filter(|&slot| is_outside(slot)).count();
        gone += slots.len();
        all += scene.instance_count();
    }
    let (lost, _) = lost(scene, &views, &culler);
    Ok(Finding::if_so(
        lost == 0 && unproved == 0 && gone > 20 * missed && gone as u32 * 4 > all,
        format!(
            "in four views of a city {} of {} instances are dropped, each with every corner outside one plane, and {missed} are kept that \
             are outside; of what is seen {lost} triangles are lost",
            grouped(gone),
            grouped(all)
        ),
    ))
}

fn detail(lab: &Lab) -> Result<Finding, LabError> {
    const LIMIT: f64 = 4.0;
    let model = lab.scene(CITY)?;
    let scene = &model.scene;
    let views = lab.views(&model, "walk", 4, SIZE)?;
    let detail = Detail { threshold_px: LIMIT, ..Detail::default() };
    let culler = Culler { detail: Some(detail), ..Culler::default().only(Stage::Detail) };
    let (mut gone, mut widest, mut changed, mut most) = (0, 0.0f64, 0, 0);
    for view in &views {
        let visible = cull_triangles(&culler, scene, view);
        let slots: Vec<u32> = dropped(scene, &visible).collect();
        for &slot in &slots {
            let mut rect = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
            for p in corners(scene, slot) {
                // What has no place on the screen is never small.
                let p = view.project_point(p).unwrap_or([f64::INFINITY; 3]);
                for axis in 0..2 {
                    rect[0][axis] = rect[0][axis].min(p[axis]);
                    rect[1][axis] = rect[1][axis].max(p[axis]);
                }
            }
            widest = widest.max(rect[1][0] - rect[0][0]).max(rect[1][1] - rect[0][1]);
        }
        let options = RenderOptions::default();
        let [before, after] = [Selection::All, Selection::Visible(&visible)]
            .map(|selection| render(scene, view, selection, &options));
        changed += before.ids.iter().zip(&after.ids).filter(|(a, b)| a != b).count();
        // Samples within a width and a height below four.
        most += slots.len() * 16;
        gone += slots.len();
    }
    Ok(Finding::if_so(
        gone > 0 && widest < LIMIT && changed > 0 && changed <= most,
        format!(
            "with a threshold of 4 pixels {} instances go in four views of a city, the widest {widest:.2} pixels, and {} of {} pixels change",
            grouped(gone),
            grouped(changed),
            grouped(views.len() as u64 * u64::from(SIZE[0] * SIZE[1]))
        ),
    ))
}

fn portals(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene("office")?;
    let scene = &model.scene;
    let views = lab.views(&model, "walk", 4, SIZE)?;
    let culler = Culler::default().only(Stage::Portal);
    let cells = scene.cell_graph().map_or(0, cullet::cell::CellGraph::cell_count);
    let (lost, [gone, all]) = lost(scene, &views, &culler);
    let mut reached = 0;
    for view in &views {
        let mut state = ViewState::default();
        culler.cull_one(scene, view, &mut state, &mut Visible::default());
        let visits = state.reached().map_or(&[][..], |reached| reached.visits());
        let visited: std::collections::BTreeSet<u32> = visits.iter().map(|v| v.cell).collect();
        reached += visited.len();
    }
    let frustum = cull_all(scene, &views, &Culler::default().only(Stage::Frustum));
    let both = Culler { frustum: true, ..culler };
    let with_portals = cull_all(scene, &views, &both);
    Ok(Finding::if_so(
        lost == 0 && gone * 2 > all && with_portals < frustum && reached > 0,
        format!(
            "in four views of an office {} of {cells} cells are reached on average, and {} of {} triangles dropped, none of those that are \
             seen; of what the frustum leaves portals take {}",
            reached / views.len(),
            grouped(gone),
            grouped(all),
            percent(frustum - with_portals, frustum)
        ),
    ))
}

/// How many triangles are left in all views.
fn cull_all(scene: &Scene, views: &[View], culler: &Culler) -> u64 {
    views.iter().map(|view| cull_triangles(culler, scene, view).triangle_count).sum()
}

fn occlusion(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene(CITY)?;
    let scene = &model.scene;
    let culler = Culler { frustum: true, ..Culler::exact().only(Stage::Occlusion) };
    let (mut hidden, mut in_view, mut lost) = (0, 0, 0);
    for view in lab.views(&model, "walk", 4, SIZE)? {
        // Sixteen samples a pixel: something may be seen between the centres of pixels.
        let options = VerifyOptions { samples: 4, ..VerifyOptions::default() };
        let proof = verify(scene, &view, &culler, &mut ViewState::default(), &options);
        lost += proof.false_culls.len();
        hidden += proof.funnel.dropped(Stage::Occlusion).triangles;
        in_view += proof.all - proof.funnel.dropped(Stage::Frustum).triangles;
    }
    Ok(Finding::if_so(
        lost == 0 && hidden * 10 > in_view,
        format!(
            "in four views of a city {} of {} triangles within the frustum are dropped because they are hidden ({}), of which {lost} are seen \
             at sixteen samples a pixel",
            grouped(hidden),
            grouped(in_view),
            percent(hidden, in_view)
        ),
    ))
}
