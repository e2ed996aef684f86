//! Occluders against an oracle that shares no code with them: a ray from any point of a box must meet the
//! mesh, whichever way it goes.

use cullet::bounds::Aabb;
use cullet::mesh::{Alpha, Part};
use cullet::{Mesh, MeshData};
use cullet_bake::occluders::{
    NoOccluders, OccluderError, OccluderOptions, OccluderPolygon, OccluderReport, OccluderSheet,
    Occluders, occluders, validate,
};
use cullet_testkit::meshes::one_sided_data;
use cullet_testkit::soups::{block, bumpy_ball, join, scattered, turned};
use glam::DVec3;
use proptest::prelude::*;

/// The solid angle of a triangle (Van Oosterom & Strackee, *The Solid Angle of a Plane Triangle*, 1983).
fn solid_angle(t: &[DVec3; 3], p: DVec3) -> f64 {
    let [a, b, c] = t.map(|q| q - p);
    let [la, lb, lc] = [a.length(), b.length(), c.length()];
    2.0 * a.dot(b.cross(c)).atan2(la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb)
}

fn triangles(mesh: &Mesh) -> Vec<[DVec3; 3]> {
    (0..mesh.triangle_count())
        .map(|t| mesh.corners(t).map(|p| DVec3::from(p.map(f64::from))))
        .collect()
}

/// How often the whole mesh winds around a point.
fn winding(triangles: &[[DVec3; 3]], p: DVec3) -> f64 {
    triangles.iter().map(|t| solid_angle(t, p)).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

/// Points of a box, its corners among them.
fn points(b: &Aabb, n: u32) -> impl Iterator<Item = DVec3> {
    let [low, high] = [b.min, b.max].map(|p| DVec3::from(p.map(f64::from)));
    (0..n * n * n).map(move |i| {
        let share = DVec3::from([i % n, i / n % n, i / (n * n)].map(f64::from)) / f64::from(n - 1);
        low + (high - low) * share
    })
}

fn make(data: &MeshData, options: &OccluderOptions) -> (Mesh, Occluders, OccluderReport) {
    let mesh = Mesh::new(data.clone()).expect("valid");
    let (made, report) = occluders(&mesh, options).expect("valid options");
    let validation = validate(&mesh, &made, 64);
    assert!(validation.is_valid(), "{validation:?} of {made:?}");
    assert_eq!(validation.proved_boxes as usize, made.boxes.len());
    assert_eq!(made.boxes.len(), report.box_gains.len());
    assert_eq!(made.polygons.len(), report.polygon_gains.len());
    assert_eq!(made.boxes.is_empty(), report.no_boxes.is_some());
    assert_eq!(made.polygons.is_empty(), report.no_polygons.is_some());
    for b in &made.boxes {
        assert!(made.sealed.iter().any(|s| s.contains(b.min)));
    }
    (mesh, made, report)
}

fn two_sided((positions, indices): (Vec<[f32; 3]>, Vec<u32>)) -> MeshData {
    MeshData { positions, indices, ..MeshData::default() }
}

/// A ring of square cross-section, around the y axis.
fn torus(around: u32, radius: f32, thick: f32) -> MeshData {
    let mut positions = Vec::new();
    let mut indices = Vec::new();
    for i in 0..around {
        let (s, c) = (i as f32 / around as f32 * std::f32::consts::TAU).sin_cos();
        for [r, y] in [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]] {
            let r = radius + r * thick;
            positions.push([r * c, y * thick, r * s]);
        }
        for k in 0..4 {
            let at = |i: u32, k: u32| i % around * 4 + k % 4;
            let [a, b, c, d] = [at(i, k), at(i, k + 1), at(i + 1, k + 1), at(i + 1, k)];
            indices.extend([a, b, c, a, c, d]);
        }
    }
    one_sided_data((positions, indices))
}

const QUICK: OccluderOptions = OccluderOptions {
    max_boxes: 8,
    max_polygons: 8,
    max_triangles: 0,
    max_near: 100,
    min_gain: 0.01,
    resolution: 32,
    directions: 8,
};

#[test]
fn a_box_is_its_own_occluder() {
    let cube = block([-1.0, 2.0, 100.0], [3.0, 2.5, 107.0]);
    for data in [one_sided_data(cube.clone()), two_sided(cube)] {
        let (_, made, report) = make(&data, &QUICK);
        assert_eq!((made.boxes.len(), made.polygons.len()), (1, 0));
        assert!(report.efficiency() > 0.99, "{report:?}");
        let b = made.boxes[0];
        assert!(b.min[0] - -1.0 < 1e-6 && 107.0 - b.max[2] < 1e-4, "{b:?}");
    }
}

#[test]
fn a_room_seen_from_outside_hides_nothing_if_its_walls_are_seen_through() {
    let room = turned(block([0.0; 3], [4.0; 3]));
    let (_, made, report) = make(&one_sided_data(room.clone()), &QUICK);
    assert!(made.boxes.is_empty());
    assert_eq!(report.no_boxes, Some(NoOccluders::Thin));
    // Its walls block from within.
    assert_eq!(made.polygons.len(), 6);
    for polygon in &made.polygons {
        assert!(polygon.holds_from([2.0, 2.0, 2.0, 1.0]));
        assert!(!polygon.two_sided && polygon.tolerance == 0.0);
    }
    let outside = |p: &OccluderPolygon| p.holds_from([2.0, 2.0, 9.0, 1.0]);
    assert_eq!(made.polygons.iter().filter(|p| outside(p)).count(), 5);
    // Drawn from both sides they block from outside: then all that is in the room.
    let (_, made, _) = make(&two_sided(room), &QUICK);
    assert_eq!(made.boxes.len(), 1);
    // But not from within it.
    assert!(!made.boxes_hold(&Aabb { min: [3.9; 3], max: [3.95; 3] }));
    assert!(made.boxes_hold(&Aabb { min: [5.0; 3], max: [5.5; 3] }));
    assert!(!made.boxes_hold(&Aabb { min: [f32::NAN; 3], max: [5.5; 3] }));
}

#[test]
fn open_shells_have_no_box_however_small_the_gap() {
    let (positions, mut indices) = block([0.0; 3], [1.0; 3]);
    indices.truncate(33);
    let (_, made, report) = make(&two_sided((positions.clone(), indices.clone())), &QUICK);
    assert_eq!((made.boxes.len(), report.no_boxes), (0, Some(NoOccluders::Open)));
    assert!(made.polygons.len() >= 5 && report.efficiency() > 0.5, "{report:?}");
    // A crack of a hundred-thousandth, between two corners that should be one.
    let (mut positions, mut indices) = block([0.0; 3], [1.0; 3]);
    positions.push([1.0, 1.0, 1.000_01]);
    indices[33..].iter_mut().filter(|i| **i == 7).for_each(|i| *i = 8);
    let (_, made, report) = make(&two_sided((positions, indices)), &QUICK);
    assert_eq!((made.boxes.len(), report.no_boxes), (0, Some(NoOccluders::Open)));
}

/// A house without a floor, its roof a slope to either side.
fn house() -> (Vec<[f32; 3]>, Vec<u32>) {
    let mut positions: Vec<[f32; 3]> = Vec::new();
    for z in [0.0, 7.0] {
        for [x, y] in [[0.0, 0.0], [6.0, 0.0], [6.0, 3.0], [3.0, 5.3], [0.0, 3.0]] {
            positions.push([x, y, z]);
        }
    }
    let walls = [[1, 6, 7, 2], [2, 7, 8, 3], [3, 8, 9, 4], [4, 9, 5, 0]];
    let mut indices: Vec<u32> = walls.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect();
    indices.extend([0, 4, 1, 1, 4, 2, 2, 4, 3, 5, 6, 9, 6, 7, 9, 7, 8, 9]);
    indices = indices.chunks(3).flat_map(|t| [t[0], t[2], t[1]]).collect();
    (positions, indices)
}

#[test]
fn an_open_house_is_stood_for_by_its_own_triangles() {
    let options = OccluderOptions { max_triangles: 64, ..QUICK };
    let (_, made, report) = make(&one_sided_data(house()), &options);
    assert_eq!(report.no_boxes, Some(NoOccluders::Open));
    assert_eq!(report.no_polygons, Some(NoOccluders::Triangles));
    assert_eq!(made.sheets.len(), 1);
    assert_eq!((made.sheets[0].triangles.len(), made.sheets[0].two_sided), (14, false));
    assert!(report.efficiency() == 1.0 && (report.triangle_gain - 1.0).abs() < 1e-9, "{report:?}");
    let engine = made.to_engine().expect("finite");
    assert_eq!(engine.shapes().len(), 1);
    assert_eq!(made.to_data(0, 1).indices.len(), 14 * 3);
    // Without them, walls alone: the roof is no plane that f32 can hold.
    let (_, few, without) = make(&one_sided_data(house()), &QUICK);
    assert!(few.sheets.is_empty() && few.polygons.len() >= 4);
    assert_eq!(without.triangle_gain, 0.0);
}

#[test]
fn triangles_are_taken_only_where_little_else_stands_for_them() {
    let options = OccluderOptions { max_triangles: 64, ..QUICK };
    let solid = one_sided_data(block([0.0; 3], [1.0, 2.0, 3.0]));
    assert!(make(&solid, &options).1.sheets.is_empty(), "a box does");
    let mut room = turned(block([0.0; 3], [4.0; 3]));
    room.1.truncate(30);
    assert!(make(&one_sided_data(room), &options).1.sheets.is_empty(), "polygons do");
    // A ball with a hole has more triangles than may be taken: the largest of them.
    let mut open = one_sided_data(bumpy_ball(16, 0.05));
    open.indices.truncate(open.indices.len() - 3);
    open.parts[0].triangle_count -= 1;
    let (mesh, made, report) = make(&open, &options);
    assert!(mesh.triangle_count() > 64 * 2);
    let count: usize = made.sheets.iter().map(|s| s.triangles.len()).sum();
    assert_eq!(count, 64);
    assert!(report.triangle_gain > 0.05 && report.efficiency() > 0.1, "{report:?}");
}

#[test]
fn fins_and_twins_do_not_open_a_solid() {
    let (mut positions, mut indices) = block([0.0; 3], [1.0; 3]);
    indices.extend_from_within(..6);
    positions.push([-3.0, 0.5, 0.5]);
    indices.extend([0, 1, 8]);
    let (_, made, _) = make(&one_sided_data((positions, indices)), &QUICK);
    assert_eq!(made.boxes.len(), 1);
}

#[test]
fn transparent_masked_and_deforming_meshes_have_none() {
    let cube = block([0.0; 3], [1.0; 3]);
    for alpha in [Alpha::Masked, Alpha::Blended] {
        let mut data = one_sided_data(cube.clone());
        data.parts[0].alpha = alpha;
        let (_, made, report) = make(&data, &QUICK);
        assert!(made.is_empty());
        assert_eq!(report.no_boxes, Some(NoOccluders::Transparent));
        // One face of glass opens it.
        let mut data = one_sided_data(cube.clone());
        data.parts[0].triangle_count = 10;
        data.parts.push(Part { first_triangle: 10, triangle_count: 2, alpha, ..Part::default() });
        let (_, made, report) = make(&data, &QUICK);
        assert!(made.boxes.is_empty());
        assert_eq!(report.no_boxes, Some(NoOccluders::Open));
        assert_eq!((made.polygons.len(), report.transparent_triangles), (5, 2));
    }
    let data = MeshData { deformable: true, ..one_sided_data(cube) };
    let (_, made, report) = make(&data, &QUICK);
    assert!(made.is_empty());
    assert_eq!(report.no_polygons, Some(NoOccluders::Deformable));
}

#[test]
fn solids_that_overlap_act_as_one() {
    // A cross of two bars, which neither fills: the crossing is inside of both.
    let bars = [block([0.0, 4.0, 0.0], [9.0, 5.0, 1.0]), block([4.0, 0.0, 0.0], [5.0, 9.0, 1.0])];
    let (_, made, report) = make(&one_sided_data(join(bars)), &QUICK);
    assert_eq!(made.boxes.len(), 2);
    assert!(report.efficiency() > 0.98, "{}", report.efficiency());
    // A ball within a ball hides nothing more; a cavity is hidden too, for the outer shell is around it.
    let nested = [block([0.0; 3], [9.0; 3]), turned(block([3.0; 3], [6.0; 3]))];
    let (_, made, _) = make(&one_sided_data(join(nested)), &QUICK);
    assert_eq!(made.boxes.len(), 1);
}

#[test]
fn a_ring_keeps_its_hole_and_its_yard() {
    let data = torus(24, 10.0, 1.5);
    let (mesh, made, report) =
        make(&data, &OccluderOptions { resolution: 64, max_boxes: 32, ..QUICK });
    assert!(made.boxes.len() > 4 && report.efficiency() > 0.7, "{report:?}");
    let all = triangles(&mesh);
    for b in &made.boxes {
        points(b, 5).for_each(|p| assert!((winding(&all, p) - 1.0).abs() < 1e-6, "{p}"));
    }
    // An eye in the yard may use the boxes around it.
    assert!(made.boxes_hold(&Aabb { min: [-0.1; 3], max: [0.1; 3] }));
    assert!(!made.boxes_hold(&Aabb { min: [9.9, -0.1, -0.1], max: [10.0, 0.1, 0.1] }));
}

#[test]
fn thin_walls_and_slopes_have_polygons() {
    // A wall of a tent, cut out of triangles, with a hole: 3 × 3 quads, less the middle one.
    let mut indices = Vec::new();
    for q in (0..9).filter(|q| *q != 4) {
        let at = |i: u32, j: u32| i + 4 * j;
        let (i, j) = (q % 3, q / 3);
        indices.extend([
            at(i, j),
            at(i + 1, j),
            at(i + 1, j + 1),
            at(i, j),
            at(i + 1, j + 1),
            at(i, j + 1),
        ]);
    }
    let positions: Vec<_> =
        (0..16).map(|v| [(v % 4) as f32, (v / 4) as f32, (v / 4) as f32 * 0.7]).collect();
    let (_, made, report) = make(&two_sided((positions, indices)), &QUICK);
    assert_eq!(report.no_boxes, Some(NoOccluders::Open));
    assert!((4..=8).contains(&made.polygons.len()), "{made:?}");
    assert!(report.efficiency() > 0.9, "{}", report.efficiency());
    for p in &made.polygons {
        assert!(p.two_sided && p.tolerance < 1e-5);
        // Nothing is in the hole.
        let inside = p.points.iter().all(|c| c[0] <= 1.0) || p.points.iter().all(|c| c[0] >= 2.0);
        let beside = p.points.iter().all(|c| c[1] <= 1.0) || p.points.iter().all(|c| c[1] >= 2.0);
        assert!(inside || beside, "{p:?}");
        // Edge on there is no telling, where the corners were rounded.
        assert!(p.tolerance == 0.0 || !p.holds_from([0.0, 1.0, 0.7, 0.0]));
    }
}

#[test]
fn soup_and_flat_and_empty_and_huge_meshes_are_answered() {
    make(&one_sided_data(scattered(300)), &QUICK);
    let (_, made, report) = make(&MeshData::default(), &QUICK);
    assert_eq!((made, report.no_boxes), (Occluders::default(), Some(NoOccluders::Empty)));
    let line = MeshData {
        positions: vec![[0.0; 3], [1.0; 3], [2.0; 3]],
        indices: vec![0, 1, 2],
        ..MeshData::default()
    };
    assert_eq!(make(&line, &QUICK).2.no_polygons, Some(NoOccluders::Empty));
    for size in [1e-30, 1e-3, 1e7, 1e30] {
        let (_, made, _) = make(&one_sided_data(block([-size; 3], [size; 3])), &QUICK);
        assert_eq!(made.boxes.len(), 1, "{size}");
    }
    // As far from the origin as f32 still has eight places between its corners.
    let (_, made, _) = make(&one_sided_data(block([1e7; 3], [1e7 + 8.0; 3])), &QUICK);
    assert!(made.boxes.len() == 1);
    let max = f32::MAX;
    let (_, made, _) = make(&one_sided_data(block([-max; 3], [max; 3])), &QUICK);
    assert!(made.boxes.iter().all(Aabb::is_finite));
}

#[test]
fn options_out_of_range_are_refused() {
    let mesh = Mesh::new(one_sided_data(block([0.0; 3], [1.0; 3]))).expect("valid");
    let made = |options| occluders(&mesh, &options).map(|m| m.0);
    for resolution in [0, 3, 193, u32::MAX] {
        let refused = made(OccluderOptions { resolution, ..QUICK });
        assert_eq!(refused, Err(OccluderError::Resolution(resolution)));
    }
    for min_gain in [-0.1, 1.1] {
        assert_eq!(
            made(OccluderOptions { min_gain, ..QUICK }),
            Err(OccluderError::MinGain(min_gain))
        );
    }
    assert!(made(OccluderOptions { min_gain: f64::NAN, ..QUICK }).is_err());
    assert!(made(OccluderOptions { directions: 5000, ..QUICK }).is_err());
    let none = OccluderOptions { max_boxes: 0, max_polygons: 0, max_triangles: 0, ..QUICK };
    assert_eq!(made(none), Ok(Occluders::default()));
    for resolution in [4, OccluderOptions::MAX_RESOLUTION] {
        let made = made(OccluderOptions { resolution, ..QUICK }).expect("in range");
        assert_eq!(made.boxes.len(), 1);
    }
}

#[test]
fn what_is_false_is_refuted() {
    let mesh = Mesh::new(one_sided_data(block([0.0; 3], [1.0; 3]))).expect("valid");
    let b = |low: f32, high: f32| Aabb { min: [low; 3], max: [high; 3] };
    let boxes = vec![b(0.1, 0.9), b(0.1, 1.1), b(-0.1, 0.5), b(2.0, 3.0), b(0.0, 1.0)];
    let square = |z: f32| OccluderPolygon {
        points: vec![[0.1, 0.1, z], [0.9, 0.1, z], [0.9, 0.9, z], [0.1, 0.9, z]],
        ..OccluderPolygon::default()
    };
    let mut twice = square(1.0);
    twice.two_sided = true;
    let mut back = square(1.0);
    back.points.reverse();
    // A side of the block, the same from both sides, wound inward, and one that is off by a bit.
    let side = [[0.0; 3], [0.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
    let sheet = |t, two_sided| OccluderSheet { triangles: vec![t], two_sided };
    let mut off = side;
    off[2][1] = 1.0f32.next_down();
    let sheets = [
        sheet(side, false),
        sheet(side, true),
        sheet([side[0], side[2], side[1]], false),
        sheet(off, false),
    ];
    let made = Occluders {
        boxes,
        sealed: Vec::new(),
        polygons: vec![square(1.0), square(0.99), twice, back],
        sheets: sheets[..3].to_vec(),
        near: sheets[3..].to_vec(),
        ..Occluders::default()
    };
    let found = validate(&mesh, &made, 256);
    assert_eq!(found.unproved_boxes, [1, 2, 3, 4]);
    let escapes = format!("{:?}", found.escapes);
    let refuted = [
        "Box { index: 1",
        "Box { index: 2",
        "Box { index: 3",
        "OccluderPolygon { index: 1",
        "OccluderPolygon { index: 2",
        "OccluderPolygon { index: 3",
        "Triangle { sheet: 1",
        "Triangle { sheet: 2",
        "Triangle { sheet: 3",
    ];
    for r in refuted {
        assert!(escapes.contains(r), "{r}: {escapes}");
    }
    assert!(!escapes.contains("Box { index: 0") && !escapes.contains("OccluderPolygon { index: 0"));
    assert!(!escapes.contains("Triangle { sheet: 0") && found.proved_triangles == 1);
}

/// Every eighth mesh of the castle: all is proved, and hides as much as was once measured.
#[test]
fn castle_meshes_hide_most_of_what_they_are() {
    let Some(path) = cullet_testkit::data("intel-castle/intel-castle.glb") else { return };
    let model = cullet_io::load(&path, &cullet_io::LoadOptions::default()).expect("loads");
    let mut sums = [0.0; 2];
    let mut boxes = 0;
    for mesh in model.scene.meshes().iter().step_by(8) {
        let (made, report) = occluders(mesh, &OccluderOptions::default()).expect("valid options");
        let found = validate(mesh, &made, 16);
        assert!(found.is_valid(), "{found:?}");
        boxes += made.boxes.len();
        report.hidden.iter().for_each(|h| sums = [sums[0] + h.occluders, sums[1] + h.mesh]);
    }
    println!("{boxes} boxes hide {:.3}", sums[0] / sums[1]);
    assert!(boxes >= 300 && sums[0] > 0.73 * sums[1], "{boxes} {sums:?}");
}

/// A rotation about a tilted axis.
fn rotate(data: &mut MeshData, angle: f32) {
    let (s, c) = angle.sin_cos();
    for p in &mut data.positions {
        let [x, y, z] = *p;
        let [x, y] = [c * x - s * y, s * x + c * y];
        *p = [x, c * y - s * z, s * y + c * z];
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cullet_testkit::cases(12), failure_persistence: None, ..ProptestConfig::default() })]

    /// Any number of turned, overlapping blocks, some inside out: every point of every box has an outward
    /// block around it, by solid angle.
    #[test]
    fn boxes_are_inside_of_solids(
        solids in prop::collection::vec((prop::array::uniform3(0.0..4.0f32), prop::array::uniform3(0.3..3.0f32), any::<bool>()), 1..5),
        angle in 0.0..1.5f32,
        resolution in 8..40u32,
    ) {
        let blocks: Vec<_> = solids
            .iter()
            .map(|(low, size, inward)| {
                let block = block(*low, [0, 1, 2].map(|a| low[a] + size[a]));
                if *inward { turned(block) } else { block }
            })
            .collect();
        let mut data = one_sided_data(join(blocks));
        rotate(&mut data, angle);
        let (mesh, made, _) = make(&data, &OccluderOptions { resolution, ..QUICK });
        // In the order of the file, a block is 12 triangles.
        let indices = mesh.original_indices();
        let of: Vec<[DVec3; 3]> = indices
            .chunks_exact(3)
            .map(|t| [t[0], t[1], t[2]].map(|v| DVec3::from(mesh.positions()[v as usize].map(f64::from))))
            .collect();
        for b in &made.boxes {
            for p in points(b, 4) {
                let sealed = of.chunks_exact(12).any(|solid| (winding(solid, p) - 1.0).abs() < 1e-6);
                prop_assert!(sealed, "{p} of {b:?}");
            }
        }
    }

    #[test]
    fn boxes_are_inside_of_bumpy_balls(rings in 3..14u32, bump in 0.0..0.2f32, resolution in 6..48u32) {
        let (mesh, made, _) = make(&one_sided_data(bumpy_ball(rings, bump)), &OccluderOptions { resolution, ..QUICK });
        let all = triangles(&mesh);
        for b in &made.boxes {
            for p in points(b, 4) {
                prop_assert!((winding(&all, p) - 1.0).abs() < 1e-6, "{p} of {b:?}");
            }
        }
    }

    /// Sheets of random triangles in turned planes: every polygon is in the union of the triangles.
    #[test]
    fn polygons_are_in_the_surface(
        full in prop::collection::vec(any::<bool>(), 36),
        jitter in prop::collection::vec(-0.3..0.3f32, 98),
        angle in prop::sample::select(vec![0.0, 0.3, 0.9]),
        max_triangles in prop::sample::select(vec![0, 9, 256]),
    ) {
        let at = |i: u32, j: u32| i + 7 * j;
        let positions = (0..49).map(|v| [(v % 7) as f32 + jitter[v], (v / 7) as f32 + jitter[v + 49], 0.0]).collect();
        let indices = full
            .iter()
            .zip(0..)
            .filter(|(f, _)| **f)
            .flat_map(|(_, q)| {
                let (i, j) = (q % 6, q / 6);
                [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i, j + 1)]
            })
            .collect();
        let mut data = two_sided((positions, indices));
        rotate(&mut data, angle);
        let (_, made, report) = make(&data, &OccluderOptions { max_triangles, ..QUICK });
        prop_assert!(made.is_empty() != full.contains(&true));
        prop_assert!(report.efficiency() <= 1.0);
    }
}
