//! The cube of directions, its cells, and which of them face away: items 29 to 34 and 38.

use std::collections::{BTreeMap, BTreeSet};

use crate::methods::sectors::{MaskUse, corner_directions, mask_of_corners};
use crate::shapes::fibonacci;
use crate::teach::normal_mask;
use cullet::cull::backface::{BackfaceMask, Facing, MaskGrid, NormalMask, NormalMasks, ViewCone};
use cullet::{Camera, Depth, Projection, Simd, View};

use crate::lecture::finding::Finding;
use crate::lecture::items::subject::{bunny, dot, facings, knobs, lost, percent, unit};
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{grouped, other};

/// Cells along an edge of the cube, as the paper usually has them.
pub(in crate::lecture::items) const N: u32 = 16;
/// How far a class may be from its limit before it must be culled: the grid's own margin of rounding, and room.
const NEAR: f64 = 1e-5;

/// A cell of the cube by its geometry alone, with no word from the grid.
struct Cell {
    /// Unit directions to its corners, in the order of a walk around it.
    corners: [[f64; 3]; 4],
    /// A direction within it.
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
    /// Whether a direction passes through it, by more than rounding: on the inner side of all four edges.
    fn holds(&self, direction: [f64; 3]) -> bool {
        // No corner of any cell is farther from its middle than that of a whole side, 54.7 degrees.
        dot(self.middle, direction) > 0.5
            && (0..4).all(|i| {
                let n = cross(self.corners[i], self.corners[(i + 1) % 4]);
                let inner = dot(n, self.middle).signum();
                dot(n, direction) * inner > 1e-12
            })
    }
}

fn cross(u: [f64; 3], v: [f64; 3]) -> [f64; 3] {
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

/// A grid of the paper's sizes.
pub(in crate::lecture::items) fn grid(n: u32) -> Result<MaskGrid, LabError> {
    MaskGrid::new(n).ok_or_else(|| LabError::Other(format!("there is no grid of {n} cells")))
}

/// How many classes a mask culls.
fn count(mask: &BackfaceMask) -> usize {
    mask.bytes().iter().map(|byte| byte.count_ones() as usize).sum()
}

/// Cells that a mask culls though a corner is not behind, or keeps though all four are by more than rounding.
fn wrong(
    grid: &MaskGrid,
    cells: &[Cell],
    mask: &BackfaceMask,
    behind: impl Fn([f64; 3]) -> f64,
) -> usize {
    let is_wrong = |cell: &&Cell| {
        let least = cell.corners.into_iter().map(&behind).fold(f64::INFINITY, f64::min);
        let culled = mask.culls(grid.encode(cell.middle));
        if culled { least <= 0.0 } else { least > NEAR }
    };
    cells.iter().filter(is_wrong).count()
}

pub(super) fn classes(_: &Lab) -> Result<Finding, LabError> {
    const DIRECTIONS: usize = 1000;
    let mut right = true;
    for n in [1, 2, 5, N, MaskGrid::MAX_CELLS] {
        let (grid, cells) = (grid(n)?, cells(n));
        let of_cells: Vec<NormalMask> = cells.iter().map(|c| grid.encode(c.middle)).collect();
        let distinct: BTreeSet<_> = of_cells.iter().map(|m| (m.byte_offset, m.bit_mask)).collect();
        right &= grid.classes() == 6 * n * n && distinct.len() == cells.len();
        // But for the first, which lies on an edge, none of an even number is within rounding of one.
        for i in 1..=DIRECTIONS {
            let d = fibonacci(i, DIRECTIONS + 2);
            let mut through = (0..cells.len()).filter(|&c| cells[c].holds(d));
            let only = through.next().filter(|_| through.next().is_none());
            right &= only.is_some_and(|c| of_cells[c] == grid.encode(d));
        }
    }
    Ok(Finding::if_so(
        right,
        format!(
            "N = 1, 2, 5, 16 and 18 give 6, 24, 150, 1,536 and 1,944 classes; each of {} directions passes through one cell of \
             each cube and has its class",
            grouped(DIRECTIONS)
        ),
    ))
}

pub(super) fn circle(_: &Lab) -> Result<Finding, LabError> {
    const STEPS: usize = 200_000;
    let grid = grid(N)?;
    let class = |i: usize| {
        let (sin, cos) = ((i as f64 + 0.5) * std::f64::consts::TAU / STEPS as f64).sin_cos();
        grid.encode([cos, sin, 0.0])
    };
    // Runs of one class, from where a class begins on.
    let begin = (1..STEPS).find(|&i| class(i) != class(i - 1)).unwrap_or(0);
    let mut arcs: Vec<(NormalMask, usize)> = Vec::new();
    for i in begin..begin + STEPS {
        match arcs.last_mut() {
            Some((last, steps)) if *last == class(i) => *steps += 1,
            _ => arcs.push((class(i), 1)),
        }
    }
    let degrees = |steps: usize| steps as f64 * 360.0 / STEPS as f64;
    let least = degrees(arcs.iter().map(|a| a.1).min().unwrap_or(0));
    let most = degrees(arcs.iter().map(|a| a.1).max().unwrap_or(0));
    // A side from −1 to 1: of its equal pieces the middle one is the widest as seen from the middle.
    let piece = 2.0 / f64::from(N);
    let expected = [45.0 - (1.0 - piece).atan().to_degrees(), piece.atan().to_degrees()];
    let near = |a: f64, b: f64| (a - b).abs() < 0.01;
    let mut of_sphere: BTreeMap<(u8, u8), usize> = BTreeMap::new();
    for i in 0..STEPS {
        let m = grid.encode(fibonacci(i, STEPS));
        *of_sphere.entry((m.byte_offset, m.bit_mask)).or_default() += 1;
    }
    let uneven = of_sphere.values().max().copied().unwrap_or(0) as f64
        / of_sphere.values().min().copied().unwrap_or(1) as f64;
    let distinct: BTreeSet<_> = arcs.iter().map(|a| (a.0.byte_offset, a.0.bit_mask)).collect();
    Ok(Finding::if_so(
        arcs.len() == 4 * N as usize
            && distinct.len() == arcs.len()
            && near(least, expected[0])
            && near(most, expected[1])
            && uneven > 2.0,
        format!(
            "16 pieces a side make {} arcs of {least:.1} to {most:.1} degrees around the circle; on the sphere the largest of {} classes \
             has {uneven:.1} times the directions of the smallest",
            arcs.len(),
            grouped(of_sphere.len())
        ),
    ))
}

pub(super) fn two_bytes(lab: &Lab) -> Result<Finding, LabError> {
    let subject = bunny(lab)?;
    let grid = grid(N)?;
    let mut masks = NormalMasks::default();
    grid.encode_triangles(subject.mesh.positions(), subject.mesh.indices(), &mut masks);
    let one_bit = |m: NormalMask| m.bit_mask.is_power_of_two() && usize::from(m.byte_offset) < 192;
    let (with, without): (Vec<NormalMask>, Vec<NormalMask>) =
        (0..masks.len()).map(|i| masks.get(i)).partition(|m| m.bit_mask != 0);
    let largest = (1..=40).filter(|&n| MaskGrid::new(n).is_some()).max().unwrap_or(0);
    let fits = |n: u32| 6 * n * n <= 2048;
    Ok(Finding::if_so(
        size_of::<NormalMask>() == 2
            && with.iter().all(|&m| one_bit(m))
            && without.iter().all(|&m| m == NormalMask::NEVER)
            && with.len() * 100 > masks.len() * 99
            && largest == MaskGrid::MAX_CELLS
            && fits(largest)
            && !fits(largest + 1),
        format!(
            "{} of {} triangles of {} have a byte's number below 192 and one bit in it, those too thin for a class none; 18 cells an edge, \
             1,944 classes, are the most that 2,048 bits hold",
            grouped(with.len()),
            grouped(masks.len()),
            subject.name
        ),
    ))
}

pub(super) fn orthographic(lab: &Lab) -> Result<Finding, LabError> {
    const VIEWS: usize = 20;
    let subject = bunny(lab)?;
    let (grid, cells) = (grid(N)?, cells(N));
    let mut masks = NormalMasks::default();
    grid.encode_triangles(subject.mesh.positions(), subject.mesh.indices(), &mut masks);
    let (mut classes, mut culled, mut backs, mut bad) = (0, 0, 0, 0);
    for i in 0..VIEWS {
        let sight = fibonacci(i, VIEWS);
        let mask = grid.mask(Simd::best(), ViewCone::parallel(sight).as_ref());
        classes += count(&mask);
        bad += wrong(&grid, &cells, &mask, |corner| dot(corner, sight));
        let sides = facings(&subject, [-sight[0], -sight[1], -sight[2], 0.0]);
        bad += lost(|t| mask.culls(masks.get(t)), &sides);
        culled += (0..masks.len()).filter(|&t| mask.culls(masks.get(t))).count();
        backs += sides.iter().filter(|f| **f == Facing::Back).count();
    }
    let whole = masks.len() * VIEWS;
    Ok(Finding::if_so(
        bad == 0 && culled <= backs,
        format!(
            "in {VIEWS} parallel views {} of 1,536 classes face away on average; their bits cull {:.1} % of {}, where {:.1} % face away, \
             and no front face",
            classes / VIEWS,
            percent(culled, whole),
            subject.name,
            percent(backs, whole)
        ),
    ))
}

/// A square window of 90 degrees, at the origin, that looks along −Z.
fn square_view() -> Result<View, LabError> {
    let projection = Projection::Perspective {
        fov_y_radians: std::f64::consts::FRAC_PI_2,
        aspect: 1.0,
        near: 0.1,
        far: f64::INFINITY,
    };
    let camera = Camera::look_at([0.0; 3], [0.0, 0.0, -1.0], projection);
    Ok(View::new(&camera, Depth::Reversed, [256, 256])?)
}

pub(super) fn field_of_view(_: &Lab) -> Result<Finding, LabError> {
    let subject = knobs(24)?;
    let (grid, frustum) = (grid(N)?, square_view()?.frustum());
    let mut masks = NormalMasks::default();
    grid.encode_triangles(subject.mesh.positions(), subject.mesh.indices(), &mut masks);
    let half = std::f64::consts::FRAC_PI_4;
    let corner = (half.tan() * 2.0_f64.sqrt()).atan();
    let of =
        |angle: f64| grid.mask(Simd::best(), ViewCone::around([0.0, 0.0, -1.0], angle).as_ref());
    let found = [half, corner].map(of);
    // The body stands in the corners of the window, thirty of its radii away.
    let (mut losses, mut culled, mut inside) = ([0, 0], [0, 0], 0);
    for (x, y) in [(0.93, 0.93), (-0.93, 0.93), (0.93, -0.93), (-0.93, -0.93)] {
        let at = [x, y, -1.0].map(|v: f64| v * 20.0 * subject.radius());
        let eye = [-at[0], -at[1], -at[2], 1.0];
        let sides = facings(&subject, eye);
        for (t, side) in sides.iter().enumerate() {
            let is_in = subject.mesh.corners(t as u32).iter().all(|p| {
                let p: [f64; 3] = std::array::from_fn(|k| f64::from(p[k]) + at[k]);
                frustum.contains(p)
            });
            if !is_in {
                continue;
            }
            inside += 1;
            for (which, mask) in found.iter().enumerate() {
                let goes = mask.culls(masks.get(t));
                culled[which] += usize::from(goes);
                losses[which] += usize::from(goes && *side == Facing::Front);
            }
        }
    }
    let share = |mask: &BackfaceMask| count(mask) as f64 * 100.0 / f64::from(grid.classes());
    let measured = format!(
        "in the corners of a square window of 90 degrees, where {} triangles are, masks for a cone of 90 degrees cull {} of them, \
         {} of these front faces; for the 109 degrees between opposite corners they cull {} and no front face, by {:.1} % of the classes \
         instead of {:.1} %",
        grouped(inside),
        grouped(culled[0]),
        losses[0],
        grouped(culled[1]),
        share(&found[1]),
        share(&found[0])
    );
    Ok(if losses[0] > 0 && losses[1] == 0 && culled[1] > 0 {
        Finding::mended(measured)
    } else {
        Finding::fails(measured)
    })
}

pub(super) fn four_corners(_: &Lab) -> Result<Finding, LabError> {
    const CONES: usize = 24;
    /// Normals along an edge of a cell, and lines of sight along an edge of the window, that are tried.
    const TRIED: usize = 5;
    let mix = |[a, b, c, d]: [[f64; 3]; 4], i: usize| {
        let (u, v) = ((i % TRIED) as f64 / 4.0, (i / TRIED) as f64 / 4.0);
        unit(std::array::from_fn(|k| {
            (a[k] * (1.0 - u) + b[k] * u) * (1.0 - v) + (d[k] * (1.0 - u) + c[k] * u) * v
        }))
    };
    let (grid, cells) = (grid(6)?, cells(6));
    let (mut tried, mut bad, mut judged) = (0, 0, 0);
    // Cones: four normals decide for all of a cell.
    for i in 0..CONES {
        let (axis, sine) = (fibonacci(i, CONES), [0.0, 0.2, 0.5][i % 3]);
        let mask = grid.mask(Simd::best(), Some(&ViewCone { axis, sine }));
        bad += wrong(&grid, &cells, &mask, |corner| dot(corner, axis) - sine);
        for cell in cells.iter().filter(|c| mask.culls(grid.encode(c.middle))) {
            judged += 1;
            tried += TRIED * TRIED;
            let front = |i: &usize| dot(mix(cell.corners, *i), axis) < sine;
            bad += (0..TRIED * TRIED).filter(front).count();
        }
    }
    // Frusta: four lines of sight decide for all of the window.
    let lines = corner_directions(&square_view()?.frustum());
    let lines = lines.ok_or_else(|| LabError::Other("a window without corners".into()))?;
    let mask = mask_of_corners(&grid, Simd::best(), &lines, MaskUse::Camera);
    let mask = mask.map_err(other)?;
    bad += wrong(&grid, &cells, &mask, |corner| {
        lines.iter().map(|&line| dot(corner, line)).fold(f64::INFINITY, f64::min)
    });
    for cell in cells.iter().filter(|c| mask.culls(grid.encode(c.middle))) {
        judged += 1;
        for (i, j) in (0..TRIED.pow(4)).map(|k| (k / (TRIED * TRIED), k % (TRIED * TRIED))) {
            tried += 1;
            // The window is flat, so its lines of sight are mixed before they are made units.
            bad += usize::from(dot(mix(cell.corners, i), mix(lines, j)) <= 0.0);
        }
    }
    let measured = format!(
        "of {} cells that four corners judge back-facing, {} pairs of a normal within and a line of sight were tried: {bad} are not, and no \
         cell is kept that need not be; so the test is exact",
        grouped(judged),
        grouped(tried)
    );
    Ok(if bad == 0 && judged > 100 { Finding::mended(measured) } else { Finding::fails(measured) })
}

pub(super) fn picture(_: &Lab) -> Result<Finding, LabError> {
    const DIRECTIONS: usize = 50_000;
    let half = 10.0_f64.to_radians();
    let sight = [-3.0, -2.0, -5.0];
    let cone = ViewCone::around(sight, half);
    let cone = cone.ok_or_else(|| LabError::Other("a cone without an axis".into()))?;
    let axis = cone.axis;
    let exact = |d: &[f64; 3]| dot(*d, axis) >= half.sin();
    let directions: Vec<[f64; 3]> = (0..DIRECTIONS).map(|i| fibonacci(i, DIRECTIONS)).collect();
    let limit = percent(directions.iter().filter(|d| exact(d)).count(), DIRECTIONS);
    let (mut shares, mut outside, mut counts) = ([0.0; 2], 0, [0; 2]);
    for (i, n) in [6, N].into_iter().enumerate() {
        let grid = grid(n)?;
        let mask = grid.mask(Simd::best(), Some(&cone));
        let marked: Vec<&[f64; 3]> =
            directions.iter().filter(|d| mask.culls(grid.encode(**d))).collect();
        outside += marked.iter().filter(|d| !exact(d)).count();
        (shares[i], counts[i]) = (percent(marked.len(), DIRECTIONS), count(&mask));
    }
    // With lines of sight all ways nothing is marked, so the pictures differ where classes are.
    let all_ways = ViewCone { axis, sine: 1.0 };
    let [some, none] = [cone, all_ways].map(|c| normal_mask(&c, [640, 360]));
    let pixels = |p: &cullet_draw::Picture| p.rgb.as_chunks::<3>().0.to_vec();
    let marked = pixels(&some).iter().zip(pixels(&none)).filter(|(a, b)| **a != *b).count();
    Ok(Finding::if_so(
        outside == 0 && shares[0] < shares[1] && shares[1] < limit && marked > 2000,
        format!(
            "lines of sight within 10 degrees leave {limit:.1} % of all directions back-facing; {} of 216 classes hold {:.1} %, {} of \
             1,536 hold {:.1} %",
            counts[0], shares[0], counts[1], shares[1]
        ),
    ))
}
