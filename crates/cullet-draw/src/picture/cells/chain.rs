//! The portals of a view, one seen through the other.

use cullet::View;
use cullet_cells::InCells;
use cullet_cells::cell::CellGraph;
use cullet_cells::portal::Reached;
use glam::{DVec3, DVec4};

use super::super::Picture;
use super::super::canvas::caption;
use super::super::canvas::{LINE, keys, keys_height};
use super::super::font::{text_height, text_size, text_width};
use super::super::palette::{CHALK, INK, NIGHT, PAPER, mix};
use super::super::shaded::shaded;
use super::plan::{Plan, draw_eye, lay, write_numbers};
use super::sight::{DoorInView, ShownPortal, Sight, shown_portals, shut_doors};
use super::{SHUT, depth_color, depth_words};
use crate::frame::{RenderOptions, Selection};
use crate::render::render;

/// Cells of the plan that are not reached.
const UNREACHED: [u8; 3] = [0xDA, 0xDB, 0xD9];

/// The view, dimmed, and on it what is seen of each portal of the walk: numbered in its order,
/// depth first, in the colours of how many portals are looked through; doors that are shut are
/// hatched in red. Beneath, a plan of the cells with what is seen of each, and the chain in words.
///
/// `reached` is [`CellView::reached`](cullet_cells::CellView::reached) after a cull of the view.
/// `material_colors` are as for [`shaded`](fn@super::super::shaded). The picture is as wide as the
/// view, at least 480, and higher. Words alone where the scene has no cells, or the eye is in none.
/// Cost: a frame at twice the size, and the plan.
#[must_use]
pub fn portals(
    world: InCells<'_>,
    view: &View,
    reached: Option<&Reached>,
    material_colors: &[[f32; 4]],
) -> Picture {
    let [width, height] = view.viewport();
    let (Some(graph), Some(reached)) = (world.graph(), reached) else {
        let mut picture = Picture::new(width.max(480), height.max(120), PAPER);
        let why = match world.graph() {
            None => "the scene has no cells",
            Some(_) => {
                "portals hide nothing here: the eye, or its near plane, is not in cells alone"
            }
        };
        caption(&mut picture, why);
        return picture;
    };
    let (steps, doors) = (shown_portals(view, reached), shut_doors(graph, view, reached));
    let wide = width.max(480);
    let text = text_size(wide);
    let line = (text * LINE).round() as i64;
    let panel = (u64::from(wide) * 9 / 20).max(300) as i64;
    let mut picture = Picture::new(wide, height + panel as u32, PAPER);
    let options = RenderOptions { scale: 2, ..RenderOptions::default() };
    let frame = render(world.scene, view, Selection::All, &options);
    let lit = shaded(world.scene, &frame, view, material_colors);
    lay(&mut picture, [0, 0], &marked(lit, &steps, &doors));
    let mut badges = Badges { size: text, placed: Vec::new(), room: [width, height] };
    for (number, step) in (1..).zip(&steps) {
        badges.draw(&mut picture, &step.screen, &format!("{number}"), depth_color(step.depth));
    }
    for door in &doors {
        badges.draw(&mut picture, &door.screen, "shut", SHUT);
    }

    let sight = Sight::new(graph, Some(reached));
    let deepest = steps.iter().map(|step| step.depth).max().unwrap_or(0).min(5);
    let mut entries: Vec<([u8; 3], String)> =
        (0..=deepest).map(|d| (depth_color(d), depth_words(d))).collect();
    if !doors.is_empty() {
        entries.push((SHUT, "shut".to_owned()));
    }
    entries.push((UNREACHED, "not reached".to_owned()));
    let gap = i64::from(wide) / 60;
    let room = i64::from(wide) - 2 * gap;
    let legend = keys_height(room, text, &entries);
    let top = i64::from(height) + gap;
    let left = room * 11 / 20;
    let shown = [left as u32, (panel - 3 * gap - legend).max(32) as u32];
    let eye = DVec4::from(view.eye());
    let eye = (eye.w != 0.0).then(|| eye.truncate());
    let plan = Plan::new(world, graph, eye, shown);
    lay(&mut picture, [gap, top], &painted(&plan, graph, &sight, eye));
    let ink = |cell: u32| {
        if sight.depth_of(cell).is_some() { INK } else { mix(INK, PAPER, 0.45) }
    };
    write_numbers(&mut picture, (&plan, eye), [gap, top], text, ink, graph.cell_count());
    let last = top + i64::from(shown[1]);
    keys(&mut picture, [gap, last + gap], gap + room, text, INK, &entries);

    let column = [2 * gap + left, top];
    let start = reached.visits().first().map_or(0, |visit| visit.cell);
    let all = graph.cell_count();
    let title = format!("From cell {start}: {} of {all} cells reached", sight.count());
    picture.text(column, &title, text, INK);
    let rows = ((last - top) / line - 1).max(1) as usize;
    write_chain(&mut picture, [column[0], top + line], (line, text), rows, &steps, &doors);
    picture
}

/// A plan on which each place has the colour of how many portals it is seen through, with the eye.
pub(super) fn painted(
    plan: &Plan,
    graph: &CellGraph,
    sight: &Sight,
    eye: Option<DVec3>,
) -> Picture {
    let mut drawn = plan.paint(|cell, p| match (sight.depth_of(cell), sight.depth_at(cell, p)) {
        (Some(_), Some(depth)) => depth_color(depth),
        (Some(depth), None) => mix(depth_color(depth), PAPER, 0.72),
        _ => UNREACHED,
    });
    plan.draw_portals(&mut drawn, graph);
    if let Some(eye) = eye {
        draw_eye(&mut drawn, plan.at(eye.into()));
    }
    drawn.halved()
}

/// A picture of a view at twice its size, dimmed, with its portals and doors, at its own size.
pub(super) fn marked(mut picture: Picture, steps: &[ShownPortal], doors: &[DoorInView]) -> Picture {
    for v in picture.rgb.chunks_exact_mut(3) {
        let dimmed = mix([v[0], v[1], v[2]], NIGHT, 0.5);
        v.copy_from_slice(&dimmed);
    }
    let doubled = |screen: &[[f64; 2]]| -> Vec<[f64; 2]> {
        screen.iter().map(|p| p.map(|v| v * 2.0)).collect()
    };
    for step in steps {
        let polygon = doubled(&step.screen);
        picture.fill_convex(&polygon, depth_color(step.depth), 0.3);
    }
    for door in doors {
        let polygon = doubled(&door.screen);
        picture.fill_convex(&polygon, SHUT, 0.25);
        hatch(&mut picture, &polygon, SHUT);
        picture.outline(&polygon, 4.0, SHUT, 1.0);
    }
    for step in steps {
        let polygon = doubled(&step.screen);
        picture.outline(&polygon, 4.0, depth_color(step.depth), 1.0);
    }
    picture.halved()
}

/// Fills a convex polygon with slanted lines.
fn hatch(picture: &mut Picture, polygon: &[[f64; 2]], color: [u8; 3]) {
    const STEP: f64 = 18.0;
    let heights = polygon.iter().map(|p| p[0] + p[1]);
    let low = heights.clone().fold(f64::INFINITY, f64::min);
    let high = heights.fold(f64::NEG_INFINITY, f64::max);
    let mut h = (low / STEP).ceil() * STEP;
    while h < high && high - low < 1e5 {
        let mut ends = Vec::new();
        for (p, q) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
            let (a, b) = (p[0] + p[1] - h, q[0] + q[1] - h);
            if (a >= 0.0) != (b >= 0.0) {
                let t = a / (a - b);
                ends.push([p[0] + (q[0] - p[0]) * t, p[1] + (q[1] - p[1]) * t]);
            }
        }
        if let [a, b] = ends[..] {
            picture.line(a, b, 3.0, color, 0.8);
        }
        h += STEP;
    }
}

/// Numbers in discs, none upon another.
struct Badges {
    size: f64,
    /// Middles and half widths.
    placed: Vec<([f64; 2], f64)>,
    room: [u32; 2],
}

impl Badges {
    /// Draws a badge in the middle of a polygon, or as near as there is room, with a line to where
    /// it belongs.
    fn draw(&mut self, picture: &mut Picture, polygon: &[[f64; 2]], words: &str, color: [u8; 3]) {
        if polygon.len() < 3 {
            return;
        }
        let n = polygon.len() as f64;
        let mean = |a: usize| polygon.iter().map(|p| p[a]).sum::<f64>() / n;
        let middle = [mean(0), mean(1)];
        let half =
            (text_width(words, self.size) as f64 * 0.5 + self.size * 0.3).max(self.size * 0.6);
        let high = self.size * 0.6;
        let turns = (0..9).flat_map(|ring| {
            let count = if ring == 0 { 1 } else { 8 * ring };
            (0..count).map(move |k| {
                let (s, c) = (f64::from(k) / f64::from(count) * std::f64::consts::TAU).sin_cos();
                [c * f64::from(ring), s * f64::from(ring)]
            })
        });
        let step = self.size * 0.8;
        let is_free = |p: &[f64; 2]| {
            let inside = p[0] - half > 0.0
                && p[1] - high > 0.0
                && p[0] + half < f64::from(self.room[0])
                && p[1] + high < f64::from(self.room[1]);
            let apart = |(q, other): &([f64; 2], f64)| {
                (p[0] - q[0]).abs() > half + other + 2.0 || (p[1] - q[1]).abs() > 2.0 * high + 2.0
            };
            inside && self.placed.iter().all(apart)
        };
        let mut places = turns.map(|[x, y]| [middle[0] + x * step, middle[1] + y * step]);
        let Some(at) = places.find(is_free) else { return };
        if (at[0] - middle[0]).hypot(at[1] - middle[1]) > half {
            picture.line(middle, at, 1.5, color, 1.0);
        }
        self.placed.push((at, half));
        let corner = [(at[0] - half) as i64, (at[1] - high) as i64];
        let box_size = [(2.0 * half) as i64, (2.0 * high) as i64];
        picture.fill(
            [corner[0] - 1, corner[1] - 1],
            [box_size[0] + 2, box_size[1] + 2],
            NIGHT,
            1.0,
        );
        picture.fill(corner, box_size, color, 1.0);
        let ink = if color == SHUT { CHALK } else { INK };
        let left = at[0] as i64 - text_width(words, self.size) / 2;
        picture.text([left, at[1] as i64 - text_height(self.size) / 2], words, self.size, ink);
    }
}

/// Writes the steps of the walk, indented by how deep they are, and the doors that end it.
fn write_chain(
    picture: &mut Picture,
    [x, y]: [i64; 2],
    (line, size): (i64, f64),
    rows: usize,
    steps: &[ShownPortal],
    doors: &[DoorInView],
) {
    let mut written: Vec<(u32, [u8; 3], String)> = Vec::new();
    for (number, step) in (1..).zip(steps) {
        let [from, to] = step.cells;
        let aside = if step.screen.len() < 3 { " (the eye is in it)" } else { "" };
        let words = format!("{number}   portal {}: cell {from} to {to}{aside}", step.portal);
        written.push((step.depth, depth_color(step.depth), words));
    }
    for door in doors {
        let [from, to] = door.cells;
        written.push((1, SHUT, format!("shut: portal {}, cell {from} to {to}", door.portal)));
    }
    let is_cut = written.len() > rows;
    let left_out = written.len().saturating_sub(rows - usize::from(is_cut));
    written.truncate(rows - usize::from(is_cut));
    let mut top = y;
    for (depth, color, words) in written {
        // Beyond a depth there would be no room for words.
        let left = x + i64::from(depth.clamp(1, 8) - 1) * (size * 0.9) as i64;
        let side = text_height(size);
        picture.fill([left, top], [side; 2], color, 1.0);
        picture.text([left + side + (size * 0.5) as i64, top], &words, size, INK);
        top += line;
    }
    if left_out > 0 {
        picture.text([x, top], &format!("and {left_out} more"), size, mix(INK, PAPER, 0.3));
    }
}
