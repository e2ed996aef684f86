//! Classes of normals and their masks: what the paper defines, and what the slides write of it.

use std::collections::{BTreeMap, BTreeSet};

use cullet::cull::backface::{Facing, ObjectEye};
use cullet::{
    Camera, Depth, Mesh, Projection, Simd, Transform, View,
    view::{CullFace, FrontFace},
};
use cullet_lab::methods::sectors::{MaskUse, corner_directions, mask_of_corners};
use cullet_lab::reproduce::zhang_hoff::mask_to;
use cullet_mesh::{BackfaceMask, MaskGrid, NormalMask, NormalMasks, ViewCone};
use cullet_testkit::vectors::cross;

use crate::tools::{SIZE, data, dot, fibonacci, knobs, percent, scene_of, seen, told, unit};

/// Cells along an edge of the cube, as the paper usually has them.
const N: u32 = 16;

/// A cell of the cube by its geometry alone: directions to its corners, in the order of a walk
/// around it, and one within it.
struct Cell {
    corners: [[f64; 3]; 4],
    middle: [f64; 3],
}

fn cells(n: u32) -> Vec<Cell> {
    let at = |i: f64| 2.0 * i / f64::from(n) - 1.0;
    let mut all = Vec::new();
    for face in 0..6 {
        let (axis, side) = (face / 2, if face % 2 == 0 { 1.0 } else { -1.0 });
        let point = |u: f64, v: f64| {
            let mut p = [0.0; 3];
            (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, at(u), at(v));
            unit(p)
        };
        for (i, j) in (0..n * n).map(|k| (f64::from(k % n), f64::from(k / n))) {
            let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
            let corners = corners.map(|(u, v)| point(i + u, j + v));
            all.push(Cell { corners, middle: point(i + 0.5, j + 0.5) });
        }
    }
    all
}

impl Cell {
    /// Whether a direction passes through it, by more than rounding: on the inner side of all four
    /// edges.
    fn holds(&self, direction: [f64; 3]) -> bool {
        // No corner of any cell is farther from its middle than that of a whole side, 54.7 degrees.
        dot(self.middle, direction) > 0.5
            && (0..4).all(|i| {
                let n = cross(self.corners[i], self.corners[(i + 1) % 4]);
                dot(n, direction) * dot(n, self.middle).signum() > 1e-12
            })
    }
}

fn grid(n: u32) -> MaskGrid {
    MaskGrid::new(n).expect("a size of the paper")
}

fn key(class: NormalMask) -> (u8, u8) {
    (class.byte_offset, class.bit_mask)
}

/// How many classes a mask culls.
fn count(mask: &BackfaceMask) -> usize {
    mask.bytes().iter().map(|byte| byte.count_ones() as usize).sum()
}

/// Classes of the triangles of a mesh, in its order.
fn classes(grid: &MaskGrid, mesh: &Mesh) -> NormalMasks {
    let mut masks = NormalMasks::default();
    grid.encode_triangles(mesh.positions(), mesh.indices(), &mut masks);
    masks
}

/// How each triangle of a mesh faces an eye, by the exact test.
fn facings(mesh: &Mesh, eye: [f64; 4]) -> Vec<Facing> {
    let test = ObjectEye::new(eye, &Transform::IDENTITY, FrontFace::default(), CullFace::Back);
    (0..mesh.triangle_count()).map(|t| test.facing(&mesh.corners(t))).collect()
}

/// Eyes at so many radii of a body whose sphere is around the origin.
fn eyes(mesh: &Mesh, count: usize, radii: f64) -> impl Iterator<Item = [f64; 4]> {
    let radius = radii * f64::from(cullet::bounds::Sphere::from_points(mesh.positions()).radius);
    (0..count).map(move |i| {
        let [x, y, z] = fibonacci(i, count).map(|v| v * radius);
        [x, y, z, 1.0]
    })
}

/// Items 29 and 31: a class is the cell that the normal's line passes through, and a bit of one of
/// 256 bytes.
#[test]
fn a_normal_has_the_class_of_the_cell_that_it_passes_through() {
    assert_eq!(size_of::<NormalMask>(), 2);
    for n in [1, 2, 5, N, MaskGrid::MAX_CELLS] {
        let (grid, cells) = (grid(n), cells(n));
        let of_cells: Vec<(u8, u8)> = cells.iter().map(|c| key(grid.encode(c.middle))).collect();
        assert!(of_cells.iter().all(|(_, bit)| bit.is_power_of_two()));
        let distinct: BTreeSet<_> = of_cells.iter().collect();
        assert_eq!((grid.classes() as usize, distinct.len()), (cells.len(), cells.len()));
        // But for the first, which lies on an edge, none of an even number is within rounding of
        // one.
        for d in (1..=1000).map(|i| fibonacci(i, 1002)) {
            let through: Vec<usize> = (0..cells.len()).filter(|&c| cells[c].holds(d)).collect();
            assert_eq!(through.len(), 1, "{d:?}");
            assert_eq!(key(grid.encode(d)), of_cells[through[0]], "{d:?}");
        }
    }
    let largest = (1..=40).filter(|&n| MaskGrid::new(n).is_some()).max();
    assert_eq!(largest, Some(MaskGrid::MAX_CELLS));
    let bits = |n: u32| 6 * n * n;
    assert!(bits(MaskGrid::MAX_CELLS) <= 2048 && bits(MaskGrid::MAX_CELLS + 1) > 2048);
    let counts = [1, 2, 5, N, MaskGrid::MAX_CELLS].map(|n| f64::from(grid(n).classes()));
    told(29, &counts);
    told(31, &[counts[3], f64::from(MaskGrid::MAX_CELLS), counts[4]]);
}

/// Item 30: equal pieces of a square's sides are arcs of several widths.
#[test]
fn pieces_of_the_square_make_arcs_that_differ_and_classes_that_do() {
    const STEPS: usize = 200_000;
    let grid = grid(N);
    let mut arcs: BTreeMap<(u8, u8), usize> = BTreeMap::new();
    for i in 0..STEPS {
        let (sin, cos) = ((i as f64 + 0.5) * std::f64::consts::TAU / STEPS as f64).sin_cos();
        *arcs.entry(key(grid.encode([cos, sin, 0.0]))).or_default() += 1;
    }
    let degrees = |steps: Option<&usize>| *steps.expect("arcs") as f64 * 360.0 / STEPS as f64;
    let found = [degrees(arcs.values().min()), degrees(arcs.values().max())];
    // A side from −1 to 1: of its equal pieces the middle one is the widest as seen from the
    // middle.
    let piece = 2.0 / f64::from(N);
    let expected = [45.0 - (1.0 - piece).atan().to_degrees(), piece.atan().to_degrees()];
    assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.01), "{found:?}");
    let mut of_sphere: BTreeMap<(u8, u8), usize> = BTreeMap::new();
    for i in 0..STEPS {
        *of_sphere.entry(key(grid.encode(fibonacci(i, STEPS)))).or_default() += 1;
    }
    let (least, most) = (of_sphere.values().min(), of_sphere.values().max());
    let uneven = *most.expect("classes") as f64 / *least.expect("classes") as f64;
    told(30, &[arcs.len() as f64, found[0], found[1], of_sphere.len() as f64, uneven]);
}

/// Item 32: those classes go whose normals all face away, and nearly half of all do.
#[test]
fn in_a_parallel_view_classes_go_whose_corners_all_face_away() {
    const VIEWS: usize = 20;
    let (mesh, grid, cells) = (knobs(40), grid(N), cells(N));
    let masks = classes(&grid, &mesh);
    let (mut gone, mut culled, mut backs) = (0, 0, 0);
    for sight in (0..VIEWS).map(|i| fibonacci(i, VIEWS)) {
        let mask = grid.mask(Simd::best(), ViewCone::parallel(sight).as_ref());
        for cell in &cells {
            let least = cell.corners.iter().map(|c| dot(*c, sight)).fold(f64::INFINITY, f64::min);
            let culls = mask.culls(grid.encode(cell.middle));
            // The grid's own margin of rounding lies between.
            assert!(if culls { least > 0.0 } else { least < 1e-5 }, "{least}");
        }
        gone += count(&mask);
        let sides = facings(&mesh, [-sight[0], -sight[1], -sight[2], 0.0]);
        for (t, side) in sides.iter().enumerate() {
            let culls = mask.culls(masks.get(t));
            assert!(!(culls && *side == Facing::Front));
            culled += usize::from(culls);
            backs += usize::from(*side == Facing::Back);
        }
    }
    let whole = masks.len() * VIEWS;
    told(32, &[(gone / VIEWS) as f64, percent(culled, whole), percent(backs, whole)]);
}

/// A square window of 90 degrees, at the origin, that looks along −Z.
fn square_view() -> View {
    let projection = Projection::Perspective {
        fov_y_radians: std::f64::consts::FRAC_PI_2,
        aspect: 1.0,
        near: 0.1,
        far: f64::INFINITY,
    };
    let camera = Camera::look_at([0.0; 3], [0.0, 0.0, -1.0], projection);
    View::new(&camera, Depth::Reversed, [256, 256]).expect("a view")
}

/// Item 33: 180 degrees less the angle between two sides of the window loses fronts in its corners;
/// less that between opposite corners none.
#[test]
fn the_angle_between_opposite_corners_is_what_classes_have_to_face_away_from() {
    let (mesh, grid, frustum) = (knobs(24), grid(N), square_view().frustum());
    let masks = classes(&grid, &mesh);
    let half = std::f64::consts::FRAC_PI_4;
    let corner = (half.tan() * 2.0_f64.sqrt()).atan();
    let found = [half, corner]
        .map(|angle| grid.mask(Simd::best(), ViewCone::around([0.0, 0.0, -1.0], angle).as_ref()));
    let radius = f64::from(cullet::bounds::Sphere::from_points(mesh.positions()).radius);
    // The body stands in the corners of the window, thirty of its radii away.
    let (mut lost, mut culled, mut inside) = ([0, 0], [0, 0], 0);
    for (x, y) in [(0.93, 0.93), (-0.93, 0.93), (0.93, -0.93), (-0.93, -0.93)] {
        let at = [x, y, -1.0].map(|v: f64| v * 20.0 * radius);
        for (t, side) in facings(&mesh, [-at[0], -at[1], -at[2], 1.0]).iter().enumerate() {
            let is_in = |p: &[f32; 3]| frustum.contains([0, 1, 2].map(|k| f64::from(p[k]) + at[k]));
            if !mesh.corners(t as u32).iter().all(is_in) {
                continue;
            }
            inside += 1;
            for (which, mask) in found.iter().enumerate() {
                let goes = mask.culls(masks.get(t));
                culled[which] += usize::from(goes);
                lost[which] += usize::from(goes && *side == Facing::Front);
            }
        }
    }
    assert!(lost[0] > 0 && lost[1] == 0 && culled[1] > 0);
    let share = |mask: &BackfaceMask| percent(count(mask), grid.classes() as usize);
    let counts = [inside, culled[0], lost[0], culled[1]].map(|n| n as f64);
    told(33, &[&counts[..], &[share(&found[1]), share(&found[0])]].concat());
}

/// Item 34: what four corners of a cell and four of the window say is exact, and no approximation.
#[test]
fn four_corners_of_a_cell_and_of_the_window_decide_exactly() {
    const TRIED: usize = 5;
    let mix = |[a, b, c, d]: [[f64; 3]; 4], i: usize| {
        let (u, v) = ((i % TRIED) as f64 / 4.0, (i / TRIED) as f64 / 4.0);
        unit(std::array::from_fn(|k| {
            (a[k] * (1.0 - u) + b[k] * u) * (1.0 - v) + (d[k] * (1.0 - u) + c[k] * u) * v
        }))
    };
    let (grid, cells) = (grid(6), cells(6));
    let (mut tried, mut judged) = (0, 0);
    // A cell goes if and only if all its corners are behind, but for the grid's margin of rounding.
    let go = |mask: &BackfaceMask, behind: &dyn Fn([f64; 3]) -> f64| -> Vec<&Cell> {
        let goes = |cell: &&Cell| {
            let least = cell.corners.into_iter().map(behind).fold(f64::INFINITY, f64::min);
            let culls = mask.culls(grid.encode(cell.middle));
            assert!(if culls { least > 0.0 } else { least < 1e-5 }, "{least}");
            culls
        };
        cells.iter().filter(goes).collect()
    };
    for i in 0..24 {
        let (axis, sine) = (fibonacci(i, 24), [0.0, 0.2, 0.5][i % 3]);
        let mask = grid.mask(Simd::best(), Some(&ViewCone { axis, sine }));
        for cell in go(&mask, &|corner| dot(corner, axis) - sine) {
            judged += 1;
            tried += TRIED * TRIED;
            assert!((0..TRIED * TRIED).all(|i| dot(mix(cell.corners, i), axis) >= sine));
        }
    }
    let lines = corner_directions(&square_view().frustum()).expect("four corners");
    let mask = mask_of_corners(&grid, Simd::best(), &lines, MaskUse::Camera).expect("a mask");
    let least = |corner| lines.iter().map(|&line| dot(corner, line)).fold(f64::INFINITY, f64::min);
    for cell in go(&mask, &least) {
        judged += 1;
        for (i, j) in (0..TRIED.pow(4)).map(|k| (k / (TRIED * TRIED), k % (TRIED * TRIED))) {
            tried += 1;
            // The window is flat, so its lines of sight are mixed before they are made units.
            assert!(dot(mix(cell.corners, i), mix(lines, j)) > 0.0);
        }
    }
    told(34, &[f64::from(judged), tried as f64]);
}

/// Item 35: a polygon is drawn where the AND gives 0. As written in 2013, where it gives 1, nearly
/// all fronts are missing.
#[test]
fn a_polygon_is_drawn_where_the_and_gives_nothing() {
    let (mesh, grid) = (knobs(40), grid(N));
    let masks = classes(&grid, &mesh);
    let sphere = cullet::bounds::Sphere::from_points(mesh.positions());
    let (mut fronts, mut drawn, mut missing) = (0, [0; 2], [0; 2]);
    for eye in eyes(&mesh, 12, 3.0) {
        let mask = mask_to(&grid, eye, &sphere);
        for (t, side) in facings(&mesh, eye).iter().enumerate() {
            let class = masks.get(t);
            let and = mask.bytes()[class.byte_offset as usize] & class.bit_mask;
            let is_front = *side == Facing::Front;
            fronts += usize::from(is_front);
            for (year, draws) in [and == 1, and == 0].into_iter().enumerate() {
                drawn[year] += usize::from(draws);
                missing[year] += usize::from(is_front && !draws);
            }
            assert_eq!(mask.culls(class), and != 0);
        }
    }
    let whole = masks.len() * 12;
    assert!(missing[0] * 10 > fronts * 9 && missing[1] == 0 && drawn[1] < whole);
    told(35, &[percent(drawn[0], whole), percent(missing[0], fronts), percent(drawn[1], whole)]);
}

/// Item 38: 1,536 classes follow the limit more closely than 216, and neither goes beyond it.
#[test]
fn finer_classes_follow_the_limit_more_closely() {
    const DIRECTIONS: usize = 50_000;
    let half = 10.0_f64.to_radians();
    let cone = ViewCone::around([-3.0, -2.0, -5.0], half).expect("a cone");
    let directions: Vec<[f64; 3]> = (0..DIRECTIONS).map(|i| fibonacci(i, DIRECTIONS)).collect();
    let is_behind = |d: &[f64; 3]| dot(*d, cone.axis) >= half.sin();
    let limit = percent(directions.iter().filter(|d| is_behind(d)).count(), DIRECTIONS);
    let [coarse, fine] = [6, N].map(|n| {
        let grid = grid(n);
        let mask = grid.mask(Simd::best(), Some(&cone));
        let marked = directions.iter().filter(|d| mask.culls(grid.encode(**d)));
        let marked: Vec<_> = marked.inspect(|d| assert!(is_behind(d))).collect();
        [count(&mask) as f64, percent(marked.len(), DIRECTIONS)]
    });
    assert!(coarse[1] < fine[1] && fine[1] < limit);
    told(38, &[limit, coarse[0], coarse[1], fine[0], fine[1]]);
}

/// Item 44: two bytes a triangle are made once and stay; the mask of a frame is 256 bytes.
#[test]
fn two_bytes_a_triangle_stay_with_the_list_and_a_frame_hands_in_its_mask() {
    let mesh = knobs(40);
    let (radius, triangles) = (1.15, mesh.triangle_count() as usize);
    let scene = scene_of(mesh.clone());
    let (grid, masks) = (grid(N), classes(&grid(N), &mesh));
    let sphere = cullet::bounds::Sphere::from_points(mesh.positions());
    let mut drawn = 0;
    for [x, y, z, w] in eyes(&mesh, 6, 4.0) {
        let view = View::perspective([x, y, z], [0.0; 3], 0.6, radius * 0.5, f64::INFINITY, SIZE);
        let view = view.expect("a view");
        let mask = mask_to(&grid, [x, y, z, w], &sphere);
        let left: BTreeSet<_> = (0..triangles as u32)
            .filter(|&t| !mask.culls(masks.get(t as usize)))
            .map(|t| (0, mesh.original_triangle()[t as usize]))
            .collect();
        assert!(seen(&scene, &view).is_subset(&left));
        drawn += left.len();
    }
    assert_eq!(masks.len(), triangles);
    assert!(drawn < triangles * 6 * 3 / 4);
    let mask = grid.mask(Simd::best(), ViewCone::parallel([1.0, 0.0, 0.0]).as_ref());
    let handed_in = size_of_val(mask.bytes());
    // In immediate mode each frame hands in what is left: three corners of three floats each.
    let counts =
        [triangles * size_of::<NormalMask>(), triangles, handed_in, drawn / 6, drawn / 6 * 36];
    told(44, &counts.map(|n| n as f64));
}

/// Item 45: classes that were made beforehand lose fronts where a mesh deforms; with those of the
/// moved triangles anew none is.
#[test]
fn only_the_triangles_that_moved_need_their_class_anew() {
    let (mesh, grid) = (knobs(30), grid(N));
    let stale = classes(&grid, &mesh);
    // The upper half is sheared, the more the higher.
    let bend = |&[x, y, z]: &[f32; 3]| [x + 1.2 * y.max(0.0).powi(2), y, z];
    let bent: Vec<[f32; 3]> = mesh.positions().iter().map(bend).collect();
    let mut masks = stale.clone();
    let moves = |t: &usize| {
        let corners = mesh.triangle(*t as u32);
        corners.iter().any(|&v| bent[v as usize] != mesh.positions()[v as usize])
    };
    let moved: Vec<usize> = (0..masks.len()).filter(moves).collect();
    for &t in &moved {
        grid.update(&bent, mesh.indices(), t..t + 1, &mut masks);
    }
    let mut anew = NormalMasks::default();
    grid.encode_triangles(&bent, mesh.indices(), &mut anew);
    assert!((0..anew.len()).all(|t| anew.get(t) == masks.get(t)));
    let bent = Mesh::new(data((bent, mesh.indices().to_vec()), false)).expect("a bent ball");
    let sphere = cullet::bounds::Sphere::from_points(bent.positions());
    let [x, y, z] = sphere.center.map(f64::from);
    // Its triangles may lie in another order: by their numbers in the list that was bent.
    let original = bent.original_triangle();
    let mut lost = 0;
    for [a, b, c, w] in eyes(&bent, 12, 3.0) {
        let eye = [x + a, y + b, z + c, w];
        let mask = mask_to(&grid, eye, &sphere);
        for (t, side) in facings(&bent, eye).iter().enumerate() {
            let is_front = *side == Facing::Front;
            let culls = |masks: &NormalMasks| mask.culls(masks.get(original[t] as usize));
            lost += usize::from(is_front && culls(&stale));
            assert!(!is_front || !culls(&masks));
        }
    }
    assert!(lost > 0 && moved.len() < masks.len());
    told(45, &[lost as f64, moved.len() as f64, masks.len() as f64]);
}
