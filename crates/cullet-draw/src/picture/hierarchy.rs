//! The walk of a scene's hierarchy, level by level, seen from above.

use cullet::bounds::{Aabb, Boxes, Side};
use cullet::cull::frustum::batch::Planes;
use cullet::{Scene, View};
use glam::DVec3;

use super::Picture;
use super::canvas::{LINE, grouped, hull, keys};
use super::font::{text_height, text_size, text_width};
use super::map::Map;
use super::palette::{CHALK, NIGHT, PROVED, UNSEEN, mix, reason_color};
use super::space::Space;
use super::trace::Trace;
use crate::sort;

/// A box this many times as long as the median of its level is one of a node whose children lie
/// apart.
const FAR_APART: f64 = 5.0;

/// A panel for every level of the scene's hierarchy, from the top to the instances: each box that
/// the walk tests, by the answer. What lies under a box that was dropped or taken whole is not
/// tested, so not there. A box much longer than the others of its level, of a node whose children
/// lie far apart, is only outlined.
///
/// `size` is the width and height of the picture, at least 480 × 320. Boxes that are not finite are
/// not drawn.
#[must_use]
pub fn hierarchy(scene: &Scene, view: &View, size: [u32; 2]) -> Picture {
    let [width, height] = [size[0].max(480), size[1].max(320)];
    let tree = scene.hierarchy();
    let planes = Planes::new(&view.frustum().relative_to(scene.origin()));
    let trace = Trace::new(&planes, tree.nodes(), tree.boxes());
    let levels: Vec<&Boxes> = std::iter::once(tree.boxes()).chain(tree.nodes().levels()).collect();
    // One more for the legend.
    let panels = levels.len() as u32 + 1;
    let columns = (1..=panels).find(|c| c * c * 2 >= panels * 3).unwrap_or(panels).min(panels);
    let rows = panels.div_ceil(columns);
    let size = text_size(width).min(f64::from(width / columns) / 24.0);
    let line = (size * LINE).round() as i64;
    let caption = 2 * line + (0.6 * size) as i64;
    let cell = [width / columns, height / rows];

    let mut picture = Picture::new(width, height, NIGHT);
    let mut apart = 0;
    for panel in 0..panels {
        let (column, row) = (panel % columns, panel / columns);
        let at = [i64::from(column * cell[0]), i64::from(row * cell[1])];
        if let Some(level) = (levels.len() - 1).checked_sub(panel as usize) {
            let map_size = [cell[0], (i64::from(cell[1]) - caption) as u32];
            let map = Map::new(scene, view, map_size);
            let mut small = Picture::new(map_size[0], map_size[1], NIGHT);
            let thin = draw_level(&mut small, &map, scene, levels[level], &trace.levels[level]);
            // An instance has no children.
            apart += if level > 0 { thin } else { 0 };
            let frustum = map.frustum(&Space::new(view));
            small.outline(&frustum, 1.4, CHALK, 0.9);
            paste(&mut picture, &small, at);
            let [title, counts] = words(level, levels.len(), &trace.levels[level]);
            let y = at[1] + i64::from(map_size[1]) + (0.3 * size) as i64;
            picture.text([at[0] + 10, y], &title, size, CHALK);
            picture.text([at[0] + 10, y + line], &counts, size * 0.9, mix(CHALK, NIGHT, 0.2));
        } else {
            let tested = |l: &Vec<Option<Side>>| l.iter().flatten().count() as u64;
            let counts = [tested(&trace.levels[0]), trace.levels.iter().map(tested).sum()];
            let all = levels[0].len() as u64;
            draw_legend(&mut picture, at, cell, size, counts, [all, apart]);
        }
        if column > 0 {
            picture.fill(at, [1, i64::from(cell[1])], CHALK, 0.25);
        }
        if row > 0 {
            picture.fill(at, [i64::from(cell[0]), 1], CHALK, 0.25);
        }
    }
    picture
}

fn color(side: Side) -> [u8; 3] {
    match side {
        Side::Outside => reason_color(Some(cullet::Stage::Frustum)),
        Side::Inside => PROVED,
        Side::Straddling => UNSEEN,
    }
}

/// The name of a level with how many of its boxes were tested, and what the answers were.
fn words(level: usize, levels: usize, tested: &[Option<Side>]) -> [String; 2] {
    let name = match level {
        0 => "instances".to_owned(),
        l if l + 1 == levels => format!("level {l}, the top"),
        l => format!("level {l}"),
    };
    let count = |side| tested.iter().filter(|s| **s == Some(side)).count() as u64;
    let [outside, inside, straddling] = [Side::Outside, Side::Inside, Side::Straddling].map(count);
    let [sum, all] = [outside + inside + straddling, tested.len() as u64].map(grouped);
    let [outside, inside, straddling] = [outside, inside, straddling].map(grouped);
    [
        format!("{name}: {sum} of {all} tested"),
        format!("{outside} outside, {inside} inside, {straddling} straddling"),
    ]
}

/// Draws the boxes that were tested; returns how many are so long that they are only outlined.
fn draw_level(
    picture: &mut Picture,
    map: &Map,
    scene: &Scene,
    boxes: &Boxes,
    tested: &[Option<Side>],
) -> u64 {
    let origin = DVec3::from(scene.origin());
    let place = |b: &Aabb| {
        let corner = |c: [f32; 3]| map.at(DVec3::from(c.map(f64::from)) + origin);
        hull(&b.corners().map(corner))
    };
    let drawn: Vec<(Side, Vec<[f64; 2]>)> = (0..boxes.len())
        .filter_map(|i| Some((tested[i]?, boxes.get(i))))
        .filter(|(_, b)| {
            let limited = b.min.iter().chain(&b.max).any(|v| v.abs() >= Boxes::LIMIT);
            !b.is_empty() && !limited
        })
        .map(|(side, b)| (side, place(&b)))
        .collect();
    let across = |place: &[[f64; 2]], axis: usize| {
        let of = |f: fn(f64, f64) -> f64, from| place.iter().map(|p| p[axis]).fold(from, f);
        of(f64::max, f64::NEG_INFINITY) - of(f64::min, f64::INFINITY)
    };
    let length = |place: &[[f64; 2]]| across(place, 0).max(across(place, 1));
    let lengths: Vec<f64> = drawn.iter().map(|(_, place)| length(place)).collect();
    let lengths = sort::sorted_by(&lengths, |&length| sort::bits(length));
    let median = lengths.get(lengths.len() / 2).copied().unwrap_or(0.0);
    let is_apart = |place: &[[f64; 2]]| length(place) > FAR_APART * median && length(place) > 8.0;
    // Those apart below all others; straddling ones on top: they are what the next level is about.
    for (color, place) in drawn.iter().filter(|d| is_apart(&d.1)).map(|d| (color(d.0), &d.1)) {
        picture.outline(place, 0.8, color, 0.35);
    }
    for wanted in [Side::Outside, Side::Inside, Side::Straddling] {
        for (_, place) in drawn.iter().filter(|d| d.0 == wanted && !is_apart(&d.1)) {
            let color = color(wanted);
            if place.len() < 3 || length(place) < 2.5 {
                if let Some(p) = place.first() {
                    picture.fill([p[0] as i64, p[1] as i64], [2, 2], color, 0.85);
                }
            } else {
                // A ground, and all that it lies under, would drown the rest.
                let area = across(place, 0) * across(place, 1);
                let large = area > 0.3 * f64::from(map.size[0] * map.size[1]);
                picture.fill_convex(place, color, if large { 0.03 } else { 0.16 });
                picture.outline(place, 1.0, color, 0.85);
            }
        }
    }
    drawn.iter().filter(|d| is_apart(&d.1)).count() as u64
}

fn paste(picture: &mut Picture, small: &Picture, at: [i64; 2]) {
    for y in 0..small.height {
        for x in 0..small.width {
            let (to_x, to_y) = (at[0] + i64::from(x), at[1] + i64::from(y));
            picture.fill([to_x, to_y], [1, 1], small.pixel(x, y), 1.0);
        }
    }
}

/// The colours, and what the walk came to: how many instances were tested, and how many boxes in
/// all.
fn draw_legend(
    picture: &mut Picture,
    at: [i64; 2],
    cell: [u32; 2],
    size: f64,
    [tested, tests]: [u64; 2],
    [all, apart]: [u64; 2],
) {
    let line = (size * LINE).round() as i64;
    let (left, right) = (at[0] + 16, at[0] + i64::from(cell[0]) - 10);
    let mut top = at[1] + (i64::from(cell[1]) - 9 * line) / 2;
    picture.text([left, top], "the walk of the hierarchy", size * 1.2, CHALK);
    top += 2 * line;
    for (kind, words) in [
        (Side::Outside, "outside: dropped whole"),
        (Side::Inside, "inside: kept whole"),
        (Side::Straddling, "straddling: its children are tested"),
    ] {
        let entry = [(color(kind), words.to_owned())];
        top = keys(picture, [left, top], right, size, CHALK, &entry);
    }
    top += line / 2;
    let soft = mix(CHALK, NIGHT, 0.2);
    let mut say = |words: String| {
        // A line that does not fit is set smaller.
        let room = (right - left) as f64;
        let fit = (room / text_width(&words, size).max(1) as f64).min(1.0);
        picture.text([left, top], &words, size * fit, soft);
        top += line;
    };
    say(format!("{} tests for {} instances,", grouped(tests), grouped(all)));
    say(format!("{} of which were tested themselves", grouped(tested)));
    if apart > 0 {
        let words = if apart == 1 { "long box of a node" } else { "long boxes of nodes" };
        say(format!("thin: {} {words} whose children lie apart", grouped(apart)));
    }
    debug_assert!(text_height(size) < line);
}
