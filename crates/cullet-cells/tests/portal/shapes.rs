//! Shapes of cells: which hold a point, which a box touches, and what is refused.

use cullet::bounds::Plane;
use cullet_cells::cell::{
    CellError, CellGraph, CellLocator, CellPiece, CellShapes, PieceProblem, Portal, PortalProblem,
};
use cullet_testkit::buildings::Building;
use cullet_testkit::{Rng, cases};

#[test]
fn a_point_is_in_the_lowest_cell_whose_pieces_hold_it() {
    let mut rng = Rng(1);
    for _ in 0..cases(40) {
        let building = Building::new(&mut rng, [5, 2, 4]);
        let shapes = &building.shapes;
        for _ in 0..100 {
            let (p, cell) = building.point(&mut rng, 1e-3);
            assert_eq!(shapes.cell_of(p), Some(cell));
            let p = rng.vector(60.0);
            let held = (0..shapes.piece_count()).filter_map(|piece| {
                let (cell, planes) = shapes.piece(piece);
                planes.iter().all(|plane| plane.distance(p) <= 0.0).then_some(cell)
            });
            assert_eq!(shapes.cell_of(p), held.min());
        }
    }
    assert_eq!(CellShapes::default().cell_of([0.0; 3]), None);
}

#[test]
fn no_cell_that_a_box_touches_is_missed_and_a_box_within_them_is_known() {
    let mut rng = Rng(2);
    let (mut within, mut one) = (0, 0);
    for _ in 0..cases(40) {
        let building = Building::new(&mut rng, [4, 2, 3]);
        let shapes = building.shapes.clone().with_walls(rng.unit() * 0.5);
        for _ in 0..40 {
            let (p, _) = building.point(&mut rng, 1e-3);
            let half: [f64; 3] = std::array::from_fn(|_| rng.unit() * 2.0);
            let min: [f64; 3] = std::array::from_fn(|a| p[a] - half[a]);
            let max: [f64; 3] = std::array::from_fn(|a| p[a] + half[a]);
            let (mut cells, mut all_in) = (Vec::new(), true);
            shapes.cells_touching(min, max, &mut cells);
            for _ in 0..30 {
                let q = std::array::from_fn(|a| rng.range(min[a], max[a]));
                match shapes.cell_of(q) {
                    Some(cell) => assert!(cells.contains(&cell)),
                    None => all_in = false,
                }
            }
            let is_free = shapes.is_free(min, max);
            assert!(all_in || !is_free, "{min:?} {max:?}");
            assert!(shapes.is_within(min, max) || !is_free);
            within += u32::from(is_free);
            cells.sort_unstable();
            cells.dedup();
            one += u32::from(cells.len() == 1);
        }
    }
    // Both answers come.
    assert!(within > cases(40) * 4 && one > cases(40) * 2, "{within} {one}");
}

fn rooms_graph(portal: [u32; 2], x: f64) -> CellGraph {
    let polygon = [[0.2, 0.2], [0.8, 0.2], [0.8, 0.8], [0.2, 0.8]].map(|[y, z]| [x, y, z]);
    // Counter-clockwise as seen from above x.
    let portal = Portal { cells: portal, polygon: polygon.to_vec() };
    CellGraph::new(2, vec![portal]).expect("a good portal")
}

fn rooms(portal: [u32; 2], x: f64, pieces: Vec<CellPiece>) -> Result<CellShapes, CellError> {
    CellShapes::new(&rooms_graph(portal, x), pieces)
}

#[test]
fn an_eye_in_a_skin_is_in_no_cell_and_what_stands_there_is_in_its_own() {
    let graph = rooms_graph([1, 0], 1.0);
    let low = CellPiece::from_box(0, [0.0; 3], [0.9, 1.0, 1.0]);
    let skin = CellPiece::from_box(0, [0.9, 0.0, 0.0], [1.0, 1.0, 1.0]);
    let high = CellPiece::from_box(1, [1.0, 0.0, 0.0], [2.0, 1.0, 1.0]);
    // The portal is on the border of the skin.
    assert!(CellShapes::new(&graph, vec![low.clone(), high.clone()]).is_err());
    let shapes = CellShapes::with_skins(&graph, vec![low, high], vec![skin]).unwrap();
    let at = |x: f64| [x, 0.5, 0.5];
    assert_eq!([0.5, 0.95, 1.5].map(|x| shapes.cell_of(at(x))), [Some(0), None, Some(1)]);
    let mut cells = Vec::new();
    shapes.cells_touching(at(0.93), at(0.97), &mut cells);
    assert_eq!(cells, [0]);
    assert!(shapes.is_within(at(0.5), at(1.5)) && !shapes.is_within(at(0.5), at(2.5)));
    assert!(!shapes.is_free(at(0.85), at(0.95)) && shapes.is_free(at(0.5), at(0.85)));
    assert_eq!(shapes.piece_count(), 3);
}

/// The bounds of an instance that touches a wall come from f32, rounded outward.
#[test]
fn a_box_that_rounding_moved_beyond_a_wall_is_within() {
    let end = 1000.1;
    let graph = CellGraph::new(1, Vec::new()).unwrap();
    // A slanting wall, at which a box is not cut.
    let mut room = CellPiece::from_box(0, [0.0; 3], [2e3, 3.0, 2e3]);
    let share = 0.5_f64.sqrt();
    room.planes.push(Plane::new([share, 0.0, share], (end + 1.0) * share));
    let shapes = CellShapes::new(&graph, vec![room]).unwrap().with_walls(0.0);
    let rounded = f64::from((end as f32).next_up());
    assert!(rounded > end + 1e-6 && shapes.is_within([0.0; 3], [rounded, 1.0, 1.0]));
    assert!(!shapes.is_within([0.0; 3], [end + 0.01, 1.0, 1.0]));
}

#[test]
fn each_fault_of_a_piece_or_a_border_is_named() {
    let low = || CellPiece::from_box(0, [0.0; 3], [1.0; 3]);
    let high = || CellPiece::from_box(1, [1.0, 0.0, 0.0], [2.0, 1.0, 1.0]);
    assert!(rooms([1, 0], 1.0, vec![low(), high()]).is_ok());
    let piece = |piece: CellPiece| match rooms([1, 0], 1.0, vec![low(), high(), piece]) {
        Err(CellError::Piece { piece: 2, problem }) => problem,
        other => panic!("{other:?}"),
    };
    assert_eq!(
        piece(CellPiece { cell: 2, ..low() }),
        PieceProblem::NoSuchCell { cell: 2, cells: 2 }
    );
    let with = |change: fn(&mut Vec<Plane>)| {
        let mut changed = low();
        change(&mut changed.planes);
        piece(changed)
    };
    assert_eq!(with(|p| p[3] = Plane::new([0.0; 3], 1.0)), PieceProblem::NoPlane(3));
    assert_eq!(with(|p| p[1].d = f64::NAN), PieceProblem::NoPlane(1));
    assert_eq!(with(|p| p.truncate(5)), PieceProblem::Unbounded(CellPiece::REACH));
    assert_eq!(with(Vec::clear), PieceProblem::Unbounded(CellPiece::REACH));
    assert_eq!(with(|p| p[1].d = 0.0), PieceProblem::NoVolume);
    assert_eq!(with(|p| p[1].d = -1.0), PieceProblem::NoVolume);
    assert!(matches!(
        with(|p| p.resize(65, Plane::new([1.0, 0.0, 0.0], 1.0))),
        PieceProblem::TooManyPlanes { planes: 65, limit: 64 }
    ));
    // Off the border, behind it, and with the cells the other way round.
    let portal = |cells, x| match rooms(cells, x, vec![low(), high()]) {
        Err(CellError::Portal { portal: 0, problem }) => problem,
        other => panic!("{other:?}"),
    };
    let off = portal([1, 0], 0.75);
    assert!(
        matches!(off, PortalProblem::OffBorder { cell: 1, distance, .. } if (distance - 0.25).abs() < 1e-9),
        "{off:?}"
    );
    let turned = portal([0, 1], 1.0);
    assert!(matches!(turned, PortalProblem::WrongSide { cell: 0, .. }), "{turned:?}");
    assert!(turned.to_string().contains("wrong order"), "{turned}");
}
