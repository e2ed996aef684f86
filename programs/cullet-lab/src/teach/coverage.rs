//! When a pixel counts as covered: pixels of one triangle, of shared edges and of the silhouette on
//! a pixel grid, and a gap that a buffer of samples does not see.

use cullet::cull::occlusion::{Convex, OcclusionBuffer, Patch};
use cullet::{Camera, Depth, Projection, Simd, Transform, View};

use super::sheet::Sheet;
use cullet_draw::Picture;
use cullet_draw::picture::palette::{INK, LOST, PAPER, PROVED, UNSEEN, mix};

/// Pixels of each grid.
const GRID: [u32; 2] = [24, 18];

/// Covered by one triangle alone: a pale shade of what is proved.
fn strict() -> [u8; 3] {
    mix(PROVED, PAPER, 0.55)
}

/// Touched, but not proved.
fn silhouette() -> [u8; 3] {
    mix(UNSEEN, PAPER, 0.35)
}

/// How many pixels of a grid are of each kind.
#[derive(Default)]
struct Counts {
    strict: u32,
    shared: u32,
    open: u32,
    /// Open pixels whose middle lies on a face.
    sampled: u32,
}

/// A shape over the grid, in pixels from the top left.
struct Figure {
    /// Convex faces, each counter-clockwise as the eye sees it, y down.
    faces: Vec<Vec<[f64; 2]>>,
    buffer: OcclusionBuffer,
}

/// Two pixel grids. On the left a mesh: pixels that one triangle covers, pixels that triangles
/// cover together (proved by their edges), and pixels of the silhouette, which stay open. On the
/// right two walls with a gap of a third of a pixel: where the middle of a pixel lies on a wall, a
/// buffer of samples calls the pixel covered, though the gap runs through it.
///
/// Which pixels are covered is what [`OcclusionBuffer`] says. `size` is at least 640 × 360.
#[must_use]
pub fn coverage(size: [u32; 2]) -> Picture {
    let mut sheet = Sheet::new(size);
    sheet.title("When a pixel of the occlusion buffer counts as covered");
    sheet.legend(&[
        (strict(), "within one triangle"),
        (PROVED, "within triangles that share edges"),
        (silhouette(), "on the border: open"),
        (LOST, "open, though its middle is covered"),
    ]);
    let [w, _] = sheet.size();
    let [top, bottom] = sheet.room();
    let em = sheet.text_size();
    // Over each grid what it shows, under it what came of it.
    let words = 4.2 * em;
    let cell =
        ((w - 60.0) * 0.5 / f64::from(GRID[0])).min((bottom - top - words) / f64::from(GRID[1]));
    let (wide, high) = (cell * f64::from(GRID[0]), cell * f64::from(GRID[1]));
    let spare = (w - 2.0 * wide) / 3.0;
    let first = top + (bottom - top - words - high) * 0.5;
    let Some(figures) = mesh().zip(walls()) else { return sheet.finish() };
    let parts =
        [(figures.0, "one surface of many triangles"), (figures.1, "two walls, a narrow gap")];
    for (number, (figure, heading)) in parts.iter().enumerate() {
        let left = spare + (wide + spare) * number as f64;
        let under = first + 1.6 * em + high + 0.7 * em;
        let counts = draw(&mut sheet, figure, [left, first + 1.6 * em], cell, number == 1);
        let middle = left + wide * 0.5;
        sheet.centred([middle, first + 0.3 * em], *heading, INK);
        let Counts { strict, shared, open, sampled } = counts;
        let words = format!(
            "{} pixels proved, {shared} of them by shared edges; {open} open",
            strict + shared
        );
        sheet.centred([middle, under], words, mix(INK, PAPER, 0.25));
        let words = format!("one sample in the middle would cover {sampled} more");
        sheet.centred([middle, under + 1.4 * em], words, mix(INK, PAPER, 0.25));
    }
    sheet.finish()
}

/// Draws a grid, and counts.
fn draw(sheet: &mut Sheet, figure: &Figure, [left, top]: [f64; 2], cell: f64, gap: bool) -> Counts {
    let mut counts = Counts::default();
    let at = |[x, y]: [f64; 2]| [left + x * cell, top + y * cell];
    let square = |x: f64, y: f64| [[x, y], [x + 1.0, y], [x + 1.0, y + 1.0], [x, y + 1.0]];
    let frame = [[0.0, 0.0], [24.0, 0.0], [24.0, 18.0], [0.0, 18.0]].map(at);
    sheet.fill(&frame, PAPER, 1.0);
    for (x, y) in (0..GRID[1]).flat_map(|y| (0..GRID[0]).map(move |x| (x, y))) {
        let corners = square(x.into(), y.into());
        let whole = |face: &Vec<[f64; 2]>| corners.iter().all(|&c| holds(face, c));
        let touched = |face: &Vec<[f64; 2]>| meets(face, &corners);
        let color = if figure.buffer.nearness(x, y) > 0.0 {
            let alone = figure.faces.iter().any(whole);
            *(if alone { &mut counts.strict } else { &mut counts.shared }) += 1;
            if alone { strict() } else { PROVED }
        } else if figure.faces.iter().any(touched) {
            counts.open += 1;
            silhouette()
        } else {
            continue;
        };
        sheet.fill(&corners.map(at), color, 1.0);
    }
    for i in 0..=GRID[0] {
        let x = f64::from(i);
        sheet.line(at([x, 0.0]), at([x, f64::from(GRID[1])]), 0.6, [0xC4, 0xC4, 0xC0]);
    }
    for i in 0..=GRID[1] {
        let y = f64::from(i);
        sheet.line(at([0.0, y]), at([f64::from(GRID[0]), y]), 0.6, [0xC4, 0xC4, 0xC0]);
    }
    for face in &figure.faces {
        let outline: Vec<_> = face.iter().map(|&p| at(p)).collect();
        sheet.outline(&outline, 1.6, INK);
    }
    for (x, y) in (0..GRID[1]).flat_map(|y| (0..GRID[0]).map(move |x| (x, y))) {
        let middle = [f64::from(x) + 0.5, f64::from(y) + 0.5];
        let open = figure.buffer.nearness(x, y) <= 0.0;
        if open && figure.faces.iter().any(|f| holds(f, middle)) {
            sheet.disc(at(middle), cell * 0.17, LOST);
            counts.sampled += 1;
        }
    }
    if gap {
        // The gap, as the line of sight finds it.
        let [from, to] = GAP;
        sheet.line(at(from), at(to), (cell * THIRD * 0.5).max(1.0), PAPER);
    }
    counts
}

/// The width of the gap in pixels, and its middle line.
const THIRD: f64 = 1.0 / 3.0;
const GAP: [[f64; 2]; 2] = [[11.17, 1.4], [13.17, 16.6]];

/// A bent disc of twelve triangles around a middle that is off the grid, and a ring around those.
fn mesh() -> Option<Figure> {
    const SIDES: u32 = 9;
    let middle = [12.3, 8.8];
    let ring = |radius: [f64; 2], turn: f64| {
        (0..SIDES).map(move |i| {
            let angle = (f64::from(i) + turn) / f64::from(SIDES) * std::f64::consts::TAU;
            // Not quite round, as meshes are.
            let uneven = 1.0 + 0.09 * (angle * 2.0 + 0.7).sin();
            [
                middle[0] + angle.cos() * radius[0] * uneven,
                middle[1] + angle.sin() * radius[1] * uneven,
            ]
        })
    };
    let mut points = vec![middle];
    points.extend(ring([5.4, 4.3], 0.0));
    points.extend(ring([10.2, 7.4], 0.5));
    let mut triangles = Vec::new();
    for i in 0..SIDES {
        let (a, b) = (1 + i, 1 + (i + 1) % SIDES);
        let (c, d) = (a + SIDES, b + SIDES);
        triangles.extend([[0, b, a], [a, b, c], [c, b, d]]);
    }
    let position = |p: &[f64; 2], z: f64| world(*p, z);
    let positions: Vec<[f32; 3]> =
        (0..).zip(&points).map(|(i, p)| position(p, if i > SIDES { -1.0 } else { 0.0 })).collect();
    let indices: Vec<u32> = triangles.iter().flatten().copied().collect();
    let patches = Patch::cut(&positions, &indices, Patch::FACETS, true).ok()?;
    let mut buffer = empty()?;
    for patch in &patches {
        patch.draw(Simd::best(), &mut buffer, &Transform::IDENTITY);
    }
    let faces = triangles.iter().map(|t| t.map(|v| points[v as usize]).to_vec()).collect();
    Some(Figure { faces, buffer })
}

/// Two quads with a slanted gap between them.
fn walls() -> Option<Figure> {
    let [[top, y0], [bottom, y1]] = GAP;
    let half = THIRD * 0.5;
    let faces = vec![
        vec![[1.6, y0], [1.6, y1], [bottom - half, y1], [top - half, y0]],
        vec![[top + half, y0], [bottom + half, y1], [22.4, y1], [22.4, y0]],
    ];
    let mut buffer = empty()?;
    for face in &faces {
        let corners: Vec<[f32; 3]> = face.iter().map(|&p| world(p, 0.0)).collect();
        let wall = Convex::from_polygon(&corners).ok()?;
        wall.draw(Simd::best(), &mut buffer, &Transform::IDENTITY);
    }
    Some(Figure { faces, buffer })
}

/// A pixel's place in the world.
fn world([x, y]: [f64; 2], z: f64) -> [f32; 3] {
    [x as f32, (f64::from(GRID[1]) - y) as f32, z as f32]
}

/// A buffer over the grid, seen from in front without perspective.
fn empty() -> Option<OcclusionBuffer> {
    let [right, top] = GRID.map(f64::from);
    let projection =
        Projection::Orthographic { left: 0.0, right, bottom: 0.0, top, near: 1.0, far: 20.0 };
    let camera = Camera {
        eye: [0.0, 0.0, 10.0],
        direction: [0.0, 0.0, -1.0],
        up: [0.0, 1.0, 0.0],
        projection,
    };
    let view = View::new(&camera, Depth::Standard, GRID).ok()?;
    let mut buffer = OcclusionBuffer::new(GRID).ok()?;
    buffer.begin(&view, [0.0; 3]);
    Some(buffer)
}

/// Twice the area on the inner side of an edge.
fn side(a: [f64; 2], b: [f64; 2], p: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
}

/// Whether a convex polygon, wound either way, holds a point.
fn holds(face: &[[f64; 2]], p: [f64; 2]) -> bool {
    let sides = || (0..face.len()).map(|i| side(face[i], face[(i + 1) % face.len()], p));
    sides().all(|s| s >= 0.0) || sides().all(|s| s <= 0.0)
}

/// Whether two convex polygons share a point: no edge of either has the other on its outer side.
fn meets(a: &[[f64; 2]], b: &[[f64; 2]]) -> bool {
    let apart = |a: &[[f64; 2]], b: &[[f64; 2]]| {
        (0..a.len()).any(|i| {
            let (p, q) = (a[i], a[(i + 1) % a.len()]);
            let own = a
                .iter()
                .map(|&c| side(p, q, c))
                .fold(0.0, |m: f64, s| if s.abs() > m.abs() { s } else { m });
            b.iter().all(|&c| side(p, q, c) * own < 0.0)
        })
    };
    !apart(a, b) && !apart(b, a)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gap_is_open_all_along_and_samples_see_none_of_it() {
        let walls = walls().unwrap();
        for y in 2..16 {
            let open: Vec<u32> = (2..22).filter(|&x| walls.buffer.nearness(x, y) <= 0.0).collect();
            assert!(!open.is_empty(), "row {y} hides what one sees through the gap");
        }
        let mut lies = 0;
        for (x, y) in (2..16).flat_map(|y| (2..22).map(move |x| (x, y))) {
            let middle = [f64::from(x) + 0.5, f64::from(y) + 0.5];
            let covered = walls.faces.iter().any(|f| holds(f, middle));
            lies += u32::from(covered && walls.buffer.nearness(x, y) <= 0.0);
        }
        assert!(lies > 8, "{lies}");
    }

    #[test]
    fn inside_a_mesh_shared_edges_leave_no_crack() {
        let mesh = mesh().unwrap();
        for (x, y) in (7..18).flat_map(|x| (5..13).map(move |y| (x, y))) {
            assert!(mesh.buffer.nearness(x, y) > 0.0, "{x}, {y}");
        }
    }

    #[test]
    fn polygons_meet_where_they_share_a_point() {
        let square = |x: f64| vec![[x, 0.0], [x + 1.0, 0.0], [x + 1.0, 1.0], [x, 1.0]];
        assert!(meets(&square(0.0), &square(0.5)));
        assert!(meets(&square(0.0), &square(1.0)));
        assert!(!meets(&square(0.0), &square(1.01)));
    }
}
