//! The cells of the built-in office, as its scene culls by them: nothing in sight is dropped, and much that is not.

use cullet::{Culler, Output, Stage, View, ViewState, Visible};
use cullet_cells::CellView;
use cullet_cells::query::{Sight, SightOptions, line_of_sight};
use cullet_testkit::{Rng, cases};

#[test]
fn portals_of_the_office_drop_nothing_that_a_line_of_sight_meets() {
    let mut rng = Rng(1);
    let (mut met, mut through, mut dropped, mut all, mut idle) = (0, 0, 0, 0, 0);
    let specs = ["office", "office:roof=1,floors=3,closed=60,seed=3", "office:roof=1,closed=0"];
    for spec in specs {
        let mut model = cullet_scenes::build(spec).unwrap();
        let culler = Culler::default().with_reasons(true).with_output(Output::Instances);
        let culler = culler.only(Stage::Portal);
        let (mut state, mut result) = (ViewState::default(), Visible::default());
        let mut among = CellView::default();
        for view in 0..cases(150) {
            let cell = rng.index(model.cells.cells.len());
            let [min, max] = model.cells.cells[cell].main_bounds().unwrap();
            let mut eye: [f64; 3] =
                std::array::from_fn(|a| rng.range(min[a] + 0.06, max[a] - 0.06));
            if view % 4 == 0 {
                // In a doorway, now and then shut.
                let portal = &model.cells.portals[rng.index(model.cells.portals.len())];
                let n = portal.polygon.len() as f64;
                eye = std::array::from_fn(|a| {
                    portal.polygon.iter().map(|p| p[a]).sum::<f64>() / n + rng.range(-0.08, 0.08)
                });
            }
            if view == 50 {
                // Every door the other way round.
                for portal in 0..model.cells.portals.len() as u32 {
                    let of = &model.cells.portals[portal as usize];
                    // An open leaf stands beside its hole: it may be called open, but not shut.
                    if of.closed {
                        let placed = model.placed.as_mut().unwrap();
                        placed.set_portal_open(portal, true);
                    }
                }
            }
            let (scene, along) = (&model.scene, rng.direction());
            let target: [f64; 3] = std::array::from_fn(|a| eye[a] + along[a]);
            let angle = rng.range(0.6, 2.2);
            let view = View::perspective(eye, target, angle, 0.05, 500.0, [64, 64]).unwrap();
            let cells = model.placed.as_ref().unwrap();
            let candidates = among.on(cells);
            culler.cull_among(scene, &view, &candidates, &mut state, &mut result).unwrap();
            all += u64::from(scene.instance_count());
            dropped += result.funnel.dropped(Stage::Portal).instances;
            idle += u32::from(among.reached().is_none());
            let near = view.frustum();
            for _ in 0..60 {
                let pixel = [rng.range(0.0, 64.0), rng.range(0.0, 64.0)];
                let ray = view.ray(pixel).unwrap();
                // What the near plane cuts away does not block.
                let begin = near.plane(cullet::view::FrustumPlane::Near).unwrap();
                let speed: f64 = (0..3).map(|a| -begin.normal[a] * ray.direction[a]).sum();
                let start = begin.distance(eye).max(0.0) / speed;
                let [from, to] =
                    [start, 200.0].map(|t| std::array::from_fn(|a| eye[a] + ray.direction[a] * t));
                let sight = line_of_sight(scene, from, to, &SightOptions::default());
                let Sight::Blocked(by) = sight else { continue };
                met += 1;
                let reason = result.reasons[by.slot as usize];
                assert!(reason.is_none(), "{spec}: {} from {eye:?} along {along:?}", {
                    model.instance_name(by.handle)
                });
                let start = among.reached().map(|reached| reached.visits()[0].cell);
                through += u32::from(start.is_some_and(|c| !cells.cells_of(by.slot).contains(&c)));
            }
        }
    }
    let views = cases(150) * specs.len() as u32;
    assert!(
        met > views * 40 && through > views,
        "{met} rays met something, {through} in other cells"
    );
    // Beside a wall and within it the stage does nothing.
    assert!(idle < views / 2, "{idle} of {views}");
    assert!(dropped * 3 > all, "{dropped} of {all}");
}
