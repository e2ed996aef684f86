//! A plan of cells: cut level at one height, each pixel asked for its cell. So it shows what the
//! scene itself says of any place, whatever the cells are made of.

use cullet::Scene;
use cullet_cells::InCells;
use cullet_cells::cell::CellGraph;
use glam::DVec3;

use super::super::Picture;
use super::super::canvas::hull;
use super::super::font::{text_height, text_width};
use super::super::outside::contents;
use super::super::palette::{INK, PAPER};
use super::{OPEN, SHUT};

/// A pixel of no cell.
const NONE: u32 = u32::MAX;
/// Samples along a side of the grid that finds where cells are.
const COARSE: u32 = 192;

/// From the world to a plan of twice the size in which it is shown: x to the right, z down.
#[derive(Debug)]
pub(super) struct Plan {
    /// Size of the plan as it is drawn, in pixels.
    size: [u32; 2],
    middle: [f64; 2],
    pixels: f64,
    /// Where it is cut.
    pub(super) height: f64,
    /// Whether that is where the eye is.
    pub(super) is_at_eye: bool,
    /// The cell of each pixel.
    cells: Vec<u32>,
}

impl Plan {
    /// A plan to be shown at a size, cut where the eye is; at the portal nearest to that if no cell
    /// is so high.
    pub(super) fn new(
        world: InCells<'_>,
        graph: &CellGraph,
        eye: Option<DVec3>,
        size: [u32; 2],
    ) -> Self {
        let (low, high) = extent(world.scene, graph);
        let (mut height, mut is_at_eye) =
            eye.map_or(((low.y + high.y) * 0.5, false), |e| (e.y, true));
        let mut found = occupied(world, low, high, height);
        if found.is_none() {
            let middles = graph.portals().iter().map(|portal| {
                portal.polygon.iter().map(|p| p[1]).sum::<f64>() / portal.polygon.len() as f64
            });
            let nearest = middles.min_by(|a, b| (a - height).abs().total_cmp(&(b - height).abs()));
            (height, is_at_eye) = (nearest.unwrap_or(height), false);
            found = occupied(world, low, high, height);
        }
        let [mut min, mut max] = found.unwrap_or([[low.x, low.z], [high.x, high.z]]);
        // The eye belongs on the plan unless all would shrink to a dot.
        if let Some(eye) = eye.map(|e| [e.x, e.z]) {
            let room = (max[0] - min[0]).max(max[1] - min[1]);
            let off = |a: usize| (min[a] - eye[a]).max(eye[a] - max[a]);
            if off(0).max(off(1)) < 0.5 * room {
                (min, max) = (
                    [min[0].min(eye[0]), min[1].min(eye[1])],
                    [max[0].max(eye[0]), max[1].max(eye[1])],
                );
            }
        }
        let size = size.map(|v| v.max(8) * 2);
        let fit = |a: usize| f64::from(size[a]) * 0.94 / (max[a] - min[a]).max(1e-9);
        let mut plan = Self {
            size,
            middle: [(min[0] + max[0]) * 0.5, (min[1] + max[1]) * 0.5],
            pixels: fit(0).min(fit(1)),
            height,
            is_at_eye,
            cells: Vec::new(),
        };
        let places = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y]));
        plan.cells = places.map(|[x, y]| world.cell_of(plan.place(x, y)).unwrap_or(NONE)).collect();
        plan
    }

    /// The world at a pixel's centre.
    fn place(&self, x: u32, y: u32) -> [f64; 3] {
        let along =
            |v: u32, a: usize| (f64::from(v) + 0.5 - f64::from(self.size[a]) * 0.5) / self.pixels;
        [self.middle[0] + along(x, 0), self.height, self.middle[1] + along(y, 1)]
    }

    /// Where a point is on the plan as it is drawn.
    pub(super) fn at(&self, p: [f64; 3]) -> [f64; 2] {
        [
            (p[0] - self.middle[0]) * self.pixels + f64::from(self.size[0]) * 0.5,
            (p[2] - self.middle[1]) * self.pixels + f64::from(self.size[1]) * 0.5,
        ]
    }

    /// The plan with each place in the colour of its cell, and outlines.
    pub(super) fn paint(&self, color: impl Fn(u32, [f64; 3]) -> [u8; 3]) -> Picture {
        let [width, height] = self.size;
        let mut picture = Picture::new(width, height, PAPER);
        let own = |x: u32, y: u32| self.cells[(y * width + x) as usize];
        for y in 0..height {
            for x in 0..width {
                let cell = own(x, y);
                if cell != NONE {
                    picture.fill([x, y].map(i64::from), [1, 1], color(cell, self.place(x, y)), 1.0);
                }
                let next = [own((x + 2).min(width - 1), y), own(x, (y + 2).min(height - 1))];
                if next.iter().any(|&n| n != cell) {
                    picture.fill([x, y].map(i64::from), [1, 1], INK, 0.75);
                }
            }
        }
        picture
    }

    /// Draws the portals of the plan: green and open, red and shut, with an arrow where one sees
    /// through one way only; dashed those of the floors and ceilings of the cells on it. Returns
    /// how many of each there are: open, shut, one way, level.
    pub(super) fn draw_portals(&self, picture: &mut Picture, graph: &CellGraph) -> [usize; 4] {
        let mut counts = [0; 4];
        let shown = self.shown(graph.cell_count());
        for (number, portal) in (0..).zip(graph.portals()) {
            let color = if graph.is_open(number) { OPEN } else { SHUT };
            if graph.plane(number).normal[1].abs() > 0.7 {
                if portal.cells.iter().any(|&c| shown[c as usize]) {
                    let outline: Vec<[f64; 2]> =
                        portal.polygon.iter().map(|p| self.at(*p)).collect();
                    for (a, b) in outline.iter().zip(outline.iter().cycle().skip(1)) {
                        dashed(picture, *a, *b, 3.0, color);
                    }
                    counts[3] += 1;
                }
                continue;
            }
            let Some([a, b]) = self.across(&portal.polygon) else { continue };
            picture.line(a, b, 9.0, color, 1.0);
            counts[usize::from(!graph.is_open(number))] += 1;
            if graph.is_one_way(number) {
                let n = graph.plane(number).normal;
                let length = n[0].hypot(n[2]).max(1e-9);
                let step = [n[0], n[2]].map(|v| v / length * 22.0);
                let middle = [(a[0] + b[0]) * 0.5, (a[1] + b[1]) * 0.5];
                // It lets see from its first cell, to which the normal points.
                picture.arrow(
                    [middle[0] + step[0], middle[1] + step[1]],
                    [middle[0] - step[0] * 1.4, middle[1] - step[1] * 1.4],
                    4.0,
                    color,
                );
                counts[2] += 1;
            }
        }
        counts
    }

    /// The line in which an upright polygon crosses the plan.
    fn across(&self, polygon: &[[f64; 3]]) -> Option<[[f64; 2]; 2]> {
        let mut points = Vec::new();
        for (p, q) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
            let [hp, hq] = [p[1] - self.height, q[1] - self.height];
            if (hp >= 0.0) != (hq >= 0.0) {
                let t = hp / (hp - hq);
                points.push(self.at([p[0] + (q[0] - p[0]) * t, 0.0, p[2] + (q[2] - p[2]) * t]));
            }
        }
        match hull(&points)[..] {
            [a, b, ..] => Some([a, b]),
            _ => None,
        }
    }

    /// Returns for each cell whether it is on the plan.
    fn shown(&self, count: u32) -> Vec<bool> {
        let mut shown = vec![false; count as usize];
        for &cell in self.cells.iter().filter(|&&cell| cell < count) {
            shown[cell as usize] = true;
        }
        shown
    }

    /// Where the number of each cell is best written, in pixels of the plan as shown, and how far
    /// it is to the cell's border.
    pub(super) fn middles(&self, count: u32) -> Vec<Option<([f64; 2], f64)>> {
        let [width, height] = self.size.map(|v| v as usize);
        let mut far = vec![0.0_f64; self.cells.len()];
        // Distances by a pass down and one up, each from neighbours that were looked at before
        // (Rosenfeld & Pfaltz, 1966).
        let near = |far: &[f64], x: usize, y: usize, steps: [[isize; 2]; 4]| {
            let mut least = f64::INFINITY;
            for [dx, dy] in steps {
                let (Some(u), Some(v)) = (x.checked_add_signed(dx), y.checked_add_signed(dy))
                else {
                    return 1.0;
                };
                let is_own = u < width
                    && v < height
                    && self.cells[v * width + u] == self.cells[y * width + x];
                let length = if dx != 0 && dy != 0 { std::f64::consts::SQRT_2 } else { 1.0 };
                least = least.min(if is_own { far[v * width + u] + length } else { 1.0 });
            }
            least
        };
        let back = [[-1, 0], [0, -1], [-1, -1], [1, -1]];
        for y in 0..height {
            for x in 0..width {
                far[y * width + x] = near(&far, x, y, back);
            }
        }
        for y in (0..height).rev() {
            for x in (0..width).rev() {
                let d = near(&far, x, y, back.map(|[dx, dy]| [-dx, -dy]));
                far[y * width + x] = far[y * width + x].min(d);
            }
        }
        let mut middles: Vec<Option<([f64; 2], f64)>> = vec![None; count as usize];
        for (at, &cell) in self.cells.iter().enumerate().filter(|(_, cell)| **cell < count) {
            let best = &mut middles[cell as usize];
            // A hair more, so that the first of many alike stays.
            if best.is_none_or(|(_, d)| far[at] * 0.5 > d * 1.000_001) {
                let p = [(at % width) as f64 * 0.5, (at / width) as f64 * 0.5];
                *best = Some((p, far[at] * 0.5));
            }
        }
        middles
    }
}

/// Writes the numbers of cells on a plan that stands at a place, beside the eye; returns how many
/// found no room.
pub(super) fn write_numbers(
    picture: &mut Picture,
    (plan, eye): (&Plan, Option<DVec3>),
    [left, top]: [i64; 2],
    size: f64,
    ink: impl Fn(u32) -> [u8; 3],
    count: u32,
) -> usize {
    let mut without = 0;
    let eye = eye.map(|e| plan.at(e.into()).map(|v| v * 0.5));
    for (cell, middle) in (0..).zip(plan.middles(count)) {
        let Some(([x, mut y], room)) = middle else { continue };
        if eye.is_some_and(|e| (e[0] - x).abs().max((e[1] - y).abs()) < size) {
            y += 1.6 * size;
        }
        let words = format!("{cell}");
        let fits = |size: f64| {
            let [w, h] = [text_width(&words, size), text_height(size)].map(|v| v as f64 * 0.5);
            w.hypot(h) <= room + 1.0
        };
        let Some(size) = [1.0, 0.85, 0.7].into_iter().map(|k| k * size).find(|&s| fits(s)) else {
            without += 1;
            continue;
        };
        let at = [
            x as i64 + left - text_width(&words, size) / 2,
            y as i64 + top - text_height(size) / 2,
        ];
        picture.text(at, &words, size, ink(cell));
    }
    without
}

fn dashed(picture: &mut Picture, a: [f64; 2], b: [f64; 2], width: f64, color: [u8; 3]) {
    let length = (b[0] - a[0]).hypot(b[1] - a[1]);
    let steps = (length / 18.0).ceil().clamp(1.0, 2000.0) as u32;
    let at = |t: f64| [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t];
    for i in 0..steps {
        let t = f64::from(i) / f64::from(steps);
        picture.line(at(t), at(t + 0.55 / f64::from(steps)), width, color, 1.0);
    }
}

/// Corners of a box around the scene and its portals.
fn extent(scene: &Scene, graph: &CellGraph) -> (DVec3, DVec3) {
    let corners = graph.portals().iter().flat_map(|portal| &portal.polygon);
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for p in corners {
        (low, high) = (low.min((*p).into()), high.max((*p).into()));
    }
    let contents = contents(scene);
    if !contents.is_empty() {
        let origin = DVec3::from(scene.origin());
        low = low.min(DVec3::from(contents.min.map(f64::from)) + origin);
        high = high.max(DVec3::from(contents.max.map(f64::from)) + origin);
    }
    if low.cmple(high).all() { (low, high) } else { (DVec3::splat(-1.0), DVec3::ONE) }
}

/// A rectangle of x and z around all cells at a height, as far as a grid of samples finds them.
fn occupied(world: InCells<'_>, low: DVec3, high: DVec3, height: f64) -> Option<[[f64; 2]; 2]> {
    let step = [high.x - low.x, high.z - low.z].map(|v| v.max(1e-9) / f64::from(COARSE));
    let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for i in 0..COARSE {
        for j in 0..COARSE {
            let p =
                [low.x + (f64::from(i) + 0.5) * step[0], low.z + (f64::from(j) + 0.5) * step[1]];
            if world.cell_of([p[0], height, p[1]]).is_some() {
                for a in 0..2 {
                    min[a] = min[a].min(p[a] - step[a]);
                    max[a] = max[a].max(p[a] + step[a]);
                }
            }
        }
    }
    (min[0] <= max[0]).then_some([min, max])
}

/// Lays a picture on another, its top left corner at a place.
pub(super) fn lay(picture: &mut Picture, [left, top]: [i64; 2], other: &Picture) {
    for y in 0..other.height {
        for x in 0..other.width {
            picture.blend(left + i64::from(x), top + i64::from(y), other.pixel(x, y), 1.0);
        }
    }
}

/// Draws the eye, at a place of a plan as it is drawn, and the lines to where it looks.
pub(super) fn draw_eye(picture: &mut Picture, [x, y]: [f64; 2]) {
    for (r, color) in [(13.0, PAPER), (10.0, INK), (4.0, PAPER)] {
        let circle: Vec<[f64; 2]> = (0..32)
            .map(|k| (f64::from(k) * std::f64::consts::TAU / 32.0).sin_cos())
            .map(|(s, c)| [x + c * r, y + s * r])
            .collect();
        picture.fill_convex(&circle, color, 1.0);
    }
}
