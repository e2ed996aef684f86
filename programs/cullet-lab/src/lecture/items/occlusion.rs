//! What is hidden behind others, and systems that find it.

use cullet::query::{SightOptions, line_of_sight};
use cullet::{Backface, Culler, Stage};
use cullet_bake::pvs::{PvsSettings, bake};

use crate::lecture::finding::Finding;
use crate::lecture::geometry::{Random, Vec3, verified};
use crate::lecture::item::{BLANK, Item, Live, ucsd};
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{SIZE, grouped, other};

pub(super) const ITEMS: &[Item] = &[
    Item {
        number: 78,
        title: "Hidden behind an occluder",
        places: &[ucsd("Occlusion Culling")],
        claim: "Geometry behind an occluder cannot be seen. To find all that is hidden so is hard, and there are many methods.",
        command: "cullet picture hidden plant --path walk --views 8 --view 2",
        live: Some(Live {
            scene: "city:cells=12,objects=1500",
            state: "camera.target=[0,3,0]&camera.distance=60&camera.pitch=-3&camera.yaw=0&layout=split&ghosts.form=solid&map=false",
        }),
        chapter: "occlusion.md#what-hidden-means-here",
        check: behind_an_occluder,
        ..BLANK
    },
    Item {
        number: 79,
        title: "A product that bakes visibility",
        places: &[ucsd("Video (Umbra 3)")],
        claim: "A film on Umbra 3 stands for the products: they find out beforehand what can be seen from where, keep it in sets of \
                cells, and answer queries in the frame.",
        command: "cullet pvs quake-libre/lqdm1.bsp",
        live: Some(Live {
            scene: "office",
            state: "layout=split&structure.cells=true&structure.portals=true",
        }),
        chapter: "kinds.md#systems-that-products-sell",
        check: baked_sets,
        ..BLANK
    },
];

/// What occlusion culling drops owns no pixel, and a line from the eye to its middle meets something before it.
fn behind_an_occluder(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene("city:cells=12,objects=1500")?;
    let scene = &model.scene;
    let culler = Culler { backface: Backface::Off, ..Culler::exact() };
    let (mut hidden, mut lines, mut blocked, mut lost, mut triangles) = (0, 0, 0, 0, 0);
    for view in lab.views(&model, "walk", 4, SIZE)? {
        let [x, y, z, w] = view.eye();
        let found = verified(&culler, scene, &view);
        lost += found.false_culls.len();
        triangles += found.funnel.dropped(Stage::Occlusion).triangles;
        for slot in scene.slots() {
            let reason = found.result.reasons[slot as usize];
            if reason.is_none_or(|r| r.stage != Stage::Occlusion) {
                continue;
            }
            hidden += 1;
            let (middle, origin) = (scene.bounds(slot).center(), scene.origin());
            let to: Vec3 = std::array::from_fn(|axis| middle[axis] + origin[axis]);
            // What is said of an instance is said of the lines of sight within the picture.
            let on_screen = view.project_point(to).is_some_and(|[x, y, _]| {
                (0.0..=f64::from(SIZE[0])).contains(&x) && (0.0..=f64::from(SIZE[1])).contains(&y)
            });
            if !on_screen {
                continue;
            }
            lines += 1;
            let options =
                SightOptions { ignored: [scene.handle(slot), None], ..SightOptions::default() };
            let sight = line_of_sight(scene, [x / w, y / w, z / w], to, &options);
            blocked += u32::from(sight.is_blocked());
        }
    }
    Ok(Finding::if_so(
        lines > 100 && blocked == lines && lost == 0,
        format!(
            "{} instances are found hidden in four views, {} triangles with those of parts; of {} lines of sight to their middles {} are \
             blocked, and {lost} triangles that are seen are lost",
            grouped(hidden),
            grouped(triangles),
            grouped(lines),
            grouped(blocked)
        ),
    ))
}

/// Sets of an office, baked and used: nothing that is seen is lost, and lines of sight agree.
fn baked_sets(lab: &Lab) -> Result<Finding, LabError> {
    let mut model = cullet_scenes::build("office:rooms=4,corridors=2,floors=1")?;
    model.scene.commit();
    let graph = model.scene.cell_graph().ok_or_else(|| other("the office has no cells"))?.clone();
    let pvs = bake(&graph, &PvsSettings::default(), 1);
    let sets = pvs.sets();
    let cells = graph.cell_count();
    let seen: u64 = (0..cells).map(|cell| u64::from(sets.count(cell))).sum();
    model.scene.set_visible_sets(sets).map_err(other)?;
    let scene = &model.scene;
    let (mut dropped, mut all, mut lost) = (0, 0, 0);
    for view in lab.views(&model, "walk", 4, SIZE)? {
        let found = verified(&Culler::exact().only(Stage::Pvs), scene, &view);
        dropped += found.funnel.dropped(Stage::Pvs).instances;
        all += u64::from(scene.instance_count());
        lost += found.false_culls.len();
    }
    // Lines between points of cells that do not see each other.
    let sets = scene.visible_sets().ok_or_else(|| other("the sets are gone"))?;
    let extent = scene.extent();
    let (low, high, origin) =
        (extent.min.map(f64::from), extent.max.map(f64::from), scene.origin());
    let mut random = Random::new(79);
    let (mut lines, mut open) = (0, 0);
    for _ in 0..2000 {
        let [a, b] = [(); 2].map(|()| -> [f64; 3] {
            std::array::from_fn(|axis| origin[axis] + random.between(low[axis], high[axis]))
        });
        let (Some(from), Some(to)) = (scene.cell_of(a), scene.cell_of(b)) else { continue };
        if !sets.sees(from, to) {
            lines += 1;
            let sight = line_of_sight(scene, a, b, &SightOptions::default());
            open += u32::from(!sight.is_blocked());
        }
    }
    Ok(Finding::if_so(
        dropped > 0 && lost == 0 && lines > 0 && open == 0,
        format!(
            "of {} pairs of {cells} cells {} may see each other; of {} instances in four views {} are dropped by that, {lost} seen \
             triangles with them, and of {lines} lines between cells that may not {open} are open",
            grouped(cells * cells),
            grouped(seen),
            grouped(all),
            grouped(dropped)
        ),
    ))
}
