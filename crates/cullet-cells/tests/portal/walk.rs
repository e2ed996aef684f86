//! The walk through portals, against rays through cells.

use cullet::View;
use cullet_cells::cell::{CellGraph, CellLocator, CellPiece, CellShapes, Mirror, Portal};
use cullet_cells::portal::{
    PortalClip, PortalOptions, PortalView, Reached, ray_cells_ref, walk_portals,
};
use cullet_testkit::buildings::Building;
use cullet_testkit::{Rng, cases};

/// A view from a point, somewhere.
pub(super) fn look(rng: &mut Rng, eye: [f64; 3]) -> View {
    let towards = rng.direction();
    let target: [f64; 3] = std::array::from_fn(|a| eye[a] + towards[a]);
    let angle = rng.range(0.4, 2.4);
    View::perspective(eye, target, angle, 0.01, 1e3, [320, 200]).expect("a good view")
}

/// A direction within the sides of a view, and not at their very edge.
pub(super) fn into(rng: &mut Rng, view: &View) -> [f64; 3] {
    let pixel = [rng.range(1.0, 319.0), rng.range(1.0, 199.0)];
    view.ray(pixel).expect("a ray").direction
}

/// Whether a visit of a cell has a point within its planes.
fn is_reached(reached: &Reached, cell: u32, p: [f64; 3]) -> bool {
    reached.visits().iter().filter(|visit| visit.cell == cell).any(|visit| {
        let p: [f64; 3] = std::array::from_fn(|a| p[a] - visit.eye[a]);
        let far = p.iter().map(|v| v.abs()).sum::<f64>();
        reached.planes(visit).all(|plane| plane.distance(p) <= 4e-9 * (1.0 + far))
    })
}

#[test]
fn a_ray_sees_no_cell_that_the_walk_does_not_reach() {
    let mut rng = Rng(3);
    let (mut reached, mut rays, mut deep, mut reflected) = (Reached::default(), 0, 0, 0);
    let (mut kept, mut seen) = (0, 0);
    for round in 0..cases(150) {
        // Small ones have more mirrors in sight.
        let size = if round % 3 == 0 { [2, 2, 3] } else { [5, 2, 5] };
        let mut building = Building::new(&mut rng, size);
        let (mut eye, mut cell) = building.point(&mut rng, 1e-6);
        if round % 5 == 0 {
            // In a portal, to the last bit or nearly.
            let portal = rng.index(building.graph.portals().len()) as u32;
            eye = building.middle(portal);
            building.graph.set_open(portal, true);
            let Some(own) = building.shapes.cell_of(eye) else { continue };
            cell = own;
        }
        let view = look(&mut rng, eye);
        let mirrors = rng.below(3) as u32;
        let clip = if rng.chance(0.3) { PortalClip::Rectangles } else { PortalClip::Polygons };
        // Limits now and then.
        let tight = rng.chance(0.2);
        let (depth, visits) = if tight { (2, 7) } else { (64, 4096) };
        let options = PortalOptions { clip, depth, visits, mirrors };
        let of_view = PortalView::new(&view).unwrap();
        walk_portals(&building.graph, &of_view, &[cell], &options, &mut reached);
        let mut found = vec![false; building.graph.cell_count() as usize];
        for ray in 0..150 {
            // Every other through the middle of what is left of some portal: the chains that are long are thin.
            let visit = &reached.visits()[rng.index(reached.visits().len())];
            let corners: Vec<[f64; 3]> = reached.polygon(visit).collect();
            let along = if ray % 2 == 0 && visit.eye == view.eye()[..3] && !corners.is_empty() {
                let middle = |a: usize| corners.iter().map(|c| c[a]).sum::<f64>();
                std::array::from_fn(|a| middle(a) / corners.len() as f64 - eye[a])
            } else {
                into(&mut rng, &view)
            };
            let graph = (&building.graph, &building.shapes);
            let mut steps = 0;
            ray_cells_ref(graph, cell, eye, along, (mirrors, 1e-6), |cell, from, to| {
                let middle = std::array::from_fn(|a| (from[a] + to[a]) * 0.5);
                for p in [from, middle, to] {
                    // In limited walks mirrors end: nothing is promised beyond.
                    let is_known = mirrors == 0 || !reached.is_limited();
                    assert!(
                        !is_known || is_reached(&reached, cell, p),
                        "cell {cell} at {p:?} from {eye:?} along {along:?}, {options:?}"
                    );
                }
                found[cell as usize] = true;
                steps += 1;
            });
            rays += 1;
            deep += u32::from(steps > 3);
        }
        reflected += reached.visits().iter().filter(|v| v.mirror.is_some()).count();
        if clip == PortalClip::Polygons && mirrors == 0 && !tight && round % 5 != 0 {
            let mut cells: Vec<u32> = reached.visits().iter().map(|v| v.cell).collect();
            cells.sort_unstable();
            cells.dedup();
            kept += cells.len();
            seen += found.iter().filter(|f| **f).count();
        }
    }
    assert!(rays > cases(150) * 100 && deep > cases(150) * 2, "{rays} {deep}");
    assert!(reflected > cases(150) as usize / 10, "{reflected}");
    // Few rays see nearly all that is reached.
    assert!(seen * 100 > kept * 80, "{seen} of {kept}");
}

fn row(door: impl Fn(f64) -> [f64; 2], count: u32) -> (CellGraph, CellShapes) {
    let polygon = |x: f64| {
        let [z0, z1] = door(x);
        vec![[x, 0.0, z0], [x, 0.0, z1], [x, 2.0, z1], [x, 2.0, z0]]
    };
    let portals =
        (1..count).map(|i| Portal { cells: [i - 1, i], polygon: polygon(f64::from(i) * 4.0) });
    let graph = CellGraph::new(count, portals.collect()).unwrap();
    let room = |i: u32| {
        CellPiece::from_box(i, [f64::from(i) * 4.0, 0.0, 0.0], [f64::from(i + 1) * 4.0, 3.0, 4.0])
    };
    let shapes = CellShapes::new(&graph, (0..count).map(room).collect()).unwrap();
    (graph, shapes)
}

fn cells_from(graph: &CellGraph, eye: [f64; 3], to: [f64; 3], options: &PortalOptions) -> Vec<u32> {
    let view = View::perspective(eye, to, 1.0, 0.01, 1e3, [200, 200]).unwrap();
    let mut reached = Reached::default();
    let view = PortalView::new(&view).unwrap();
    walk_portals(graph, &view, &[(eye[0] / 4.0) as u32], options, &mut reached);
    reached.visits().iter().map(|visit| visit.cell).collect()
}

#[test]
fn a_shut_door_a_one_way_portal_and_limits_end_a_chain_as_they_say() {
    let (mut graph, _) = row(|_| [1.0, 2.0], 6);
    let (eye, to) = ([1.0, 1.0, 1.5], [2.0, 1.0, 1.5]);
    let all = PortalOptions::default();
    assert_eq!(cells_from(&graph, eye, to, &all), [0, 1, 2, 3, 4, 5]);
    assert_eq!(cells_from(&graph, eye, [0.0, 1.0, 1.5], &all), [0]);
    graph.set_open(2, false);
    assert_eq!(cells_from(&graph, eye, to, &all), [0, 1, 2]);
    graph.set_open(2, true);
    // An eye in a shut door sees both sides.
    graph.set_open(0, false);
    assert_eq!(cells_from(&graph, [4.0, 1.0, 1.5], [3.0, 1.0, 1.5], &all), [1, 0]);
    graph.set_open(0, true);
    graph.set_one_way(1, true);
    assert_eq!(cells_from(&graph, eye, to, &all).len(), 6);
    assert_eq!(cells_from(&graph, [21.0, 1.0, 1.5], [1.0, 1.0, 1.5], &all), [5, 4, 3, 2]);
    for options in [PortalOptions { depth: 2, ..all }, PortalOptions { visits: 3, ..all }] {
        let mut cells = cells_from(&graph, eye, to, &options);
        cells.sort_unstable();
        cells.dedup();
        assert_eq!(cells, [0, 1, 2, 3, 4, 5], "what is behind a limit counts as seen");
    }
}

#[test]
fn doors_out_of_line_hide_what_is_behind_them() {
    let (graph, _) =
        row(|x| if (x as u32 / 4).is_multiple_of(2) { [0.1, 0.6] } else { [3.4, 3.9] }, 6);
    let cells = cells_from(&graph, [0.5, 1.0, 3.5], [1.0, 1.0, 3.4], &PortalOptions::default());
    assert!(cells.len() < 4, "{cells:?}");
}

#[test]
fn nothing_behind_the_plane_of_a_mirror_is_seen_in_it() {
    let (graph, _) = row(|_| [1.0, 3.0], 2);
    let polygon = vec![[0.0, 0.5, 1.0], [0.0, 2.0, 1.0], [0.0, 2.0, 3.0], [0.0, 0.5, 3.0]];
    let graph = graph.with_mirrors(vec![Mirror { cell: 0, polygon }]).unwrap();
    let view = View::perspective([2.0, 1.0, 2.0], [0.0, 1.0, 2.0], 1.0, 0.01, 1e3, [200, 200]);
    let view = PortalView::new(&view.unwrap()).unwrap();
    let options = PortalOptions { mirrors: 1, ..PortalOptions::default() };
    let mut reached = Reached::default();
    walk_portals(&graph, &view, &[0], &options, &mut reached);
    let visit = reached.visits().iter().find(|v| v.mirror == Some(0)).expect("seen in the mirror");
    assert_eq!(visit.eye, [-2.0, 1.0, 2.0]);
    let is_seen = |x: f64| {
        let p = [x - visit.eye[0], 0.1, -0.1];
        reached.planes(visit).all(|plane| plane.distance(p) <= 0.0)
    };
    assert!(is_seen(0.0) && is_seen(0.1) && is_seen(3.9));
    // Between the mirror and the mirrored eye.
    assert!(!is_seen(-0.1) && !is_seen(-1.0) && !is_seen(-1.9));
}

#[test]
fn odd_calls_are_answered() {
    let mut reached = Reached::default();
    let view = View::perspective([0.0; 3], [1.0, 0.0, 0.0], 1.0, 0.1, 9.0, [9, 9]).unwrap();
    let view = PortalView::new(&view).unwrap();
    walk_portals(&CellGraph::default(), &view, &[7], &PortalOptions::default(), &mut reached);
    assert_eq!(reached.visits().len(), 1);
    assert_eq!(reached.chain(9), Vec::<&cullet_cells::portal::Visit>::new());
    let flat = View::orthographic([0.0; 3], [1.0, 0.0, 0.0], 1.0, 0.1, 9.0, [9, 9]).unwrap();
    assert!(PortalView::new(&flat).is_none());
}
