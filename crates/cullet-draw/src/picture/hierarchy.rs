//! The walk of a scene's hierarchy, level by level, seen from above.

use cullet::bounds::{Aabb, Boxes, Side};
use cullet::cull::frustum::batch::Planes;
use cullet::cull::frustum::tree::Trace;
use cullet::{Scene, View};
use glam::DVec3;

use super::Picture;
use super::canvas::{grouped, hull, text_height, text_width};
use super::map::Map;
use super::palette::{CHALK, NIGHT, UNSEEN, mix, reason_color};
use super::space::Space;

/// Taken whole: of the hues of the palette the one that stands for nothing else here.
const WHOLE: [u8; 3] = [0x00, 0x9E, 0x73];

/// A panel for every level of the scene's hierarchy, from the top to the instances: each box that the walk
/// asks, by the answer. What lies under a box that was dropped or taken whole is not asked, so not there.
///
/// `size` is the width and height of the picture, at least 480 × 320. Boxes that are not finite are not
/// drawn.
#[must_use]
pub fn hierarchy(scene: &Scene, view: &View, size: [u32; 2]) -> Picture {
    let [width, height] = [size[0].max(480), size[1].max(320)];
    let tree = scene.hierarchy();
    let planes = Planes::new(&view.frustum().relative_to(scene.origin()));
    let trace = Trace::new(&planes, tree.nodes(), tree.boxes());
    let levels: Vec<&Boxes> = std::iter::once(tree.boxes()).chain(tree.nodes().levels()).collect();
    let panels = levels.len() as u32;
    let columns = (1..=panels).find(|c| c * c * 2 >= panels * 3).unwrap_or(panels).min(panels);
    let rows = panels.div_ceil(columns);
    let scale = if width >= 1200 { 2 } else { 1 };
    let caption = text_height(scale) * 2 + 14 * i64::from(scale);
    let legend = text_height(scale) + 10 * i64::from(scale);
    let cell = [
        width / columns,
        ((i64::from(height) - legend) / i64::from(rows)).max(caption + 40) as u32,
    ];

    let mut picture = Picture::new(width, height, NIGHT);
    for (panel, level) in (0..levels.len()).rev().enumerate() {
        let (column, row) = (panel as u32 % columns, panel as u32 / columns);
        let at = [i64::from(column * cell[0]), i64::from(row * cell[1])];
        let map_size = [cell[0], (i64::from(cell[1]) - caption) as u32];
        let map = Map::new(scene, view, map_size);
        let mut small = Picture::new(map_size[0], map_size[1], NIGHT);
        draw_level(&mut small, &map, scene, levels[level], &trace.levels[level]);
        let frustum = map.frustum(&Space::new(view));
        small.outline(&frustum, 1.4, CHALK, 0.9);
        paste(&mut picture, &small, at);
        let words = [name(level, levels.len()), tally(&trace.levels[level])];
        let room = i64::from(cell[0]) - 16;
        let mut y = at[1] + i64::from(map_size[1]) + 4;
        for (line, words) in words.iter().enumerate() {
            // What does not fit at this size may at half of it.
            let scale = if text_width(words, scale) > room { 1 } else { scale };
            let ink = if line == 0 { CHALK } else { mix(CHALK, NIGHT, 0.3) };
            picture.text([at[0] + 8, y], words, scale, ink);
            y += text_height(scale) + 5 * i64::from(scale);
        }
        if column > 0 {
            picture.fill(at, [1, i64::from(cell[1])], CHALK, 0.25);
        }
        if row > 0 {
            picture.fill(at, [i64::from(cell[0]), 1], CHALK, 0.25);
        }
    }
    draw_legend(&mut picture, [8, i64::from(height) - legend + 4], scale);
    picture
}

fn color(side: Side) -> [u8; 3] {
    match side {
        Side::Outside => reason_color(Some(cullet::Stage::Frustum)),
        Side::Inside => WHOLE,
        Side::Straddling => UNSEEN,
    }
}

fn name(level: usize, levels: usize) -> String {
    match level {
        0 => "instances".to_owned(),
        l if l + 1 == levels => format!("level {l}, the top"),
        l => format!("level {l}"),
    }
}

/// How many were asked, and what they said.
fn tally(level: &[Option<Side>]) -> String {
    let count = |side| level.iter().filter(|s| **s == Some(side)).count() as u64;
    let [outside, inside, straddling] = [Side::Outside, Side::Inside, Side::Straddling].map(count);
    format!(
        "{} of {} asked: {} outside, {} inside, {} straddling",
        grouped(outside + inside + straddling),
        grouped(level.len() as u64),
        grouped(outside),
        grouped(inside),
        grouped(straddling)
    )
}

fn draw_level(
    picture: &mut Picture,
    map: &Map,
    scene: &Scene,
    boxes: &Boxes,
    asked: &[Option<Side>],
) {
    let origin = DVec3::from(scene.origin());
    let place = |b: &Aabb| {
        let corner = |c: [f32; 3]| map.at(DVec3::from(c.map(f64::from)) + origin);
        hull(&b.corners().map(corner))
    };
    // Straddling ones on top: they are what the next level is about.
    for wanted in [Side::Outside, Side::Inside, Side::Straddling] {
        let of_kind = (0..boxes.len()).filter(|&i| asked[i] == Some(wanted));
        for bounds in of_kind.map(|i| boxes.get(i)) {
            let limited = bounds.min.iter().chain(&bounds.max).any(|v| v.abs() >= Boxes::LIMIT);
            if bounds.is_empty() || limited {
                continue;
            }
            let place = place(&bounds);
            let color = color(wanted);
            let across = |axis: usize| {
                let of = |f: fn(f64, f64) -> f64, from| place.iter().map(|p| p[axis]).fold(from, f);
                of(f64::max, f64::NEG_INFINITY) - of(f64::min, f64::INFINITY)
            };
            if place.len() < 3 || across(0).max(across(1)) < 2.5 {
                if let Some(p) = place.first() {
                    picture.fill([p[0] as i64, p[1] as i64], [2, 2], color, 0.85);
                }
            } else {
                // A ground, and all that it lies under, would drown the rest.
                let large = across(0) * across(1) > 0.3 * f64::from(map.size[0] * map.size[1]);
                picture.fill_convex(&place, color, if large { 0.03 } else { 0.16 });
                picture.outline(&place, 1.0, color, 0.85);
            }
        }
    }
}

fn paste(picture: &mut Picture, small: &Picture, at: [i64; 2]) {
    for y in 0..small.height {
        for x in 0..small.width {
            let (to_x, to_y) = (at[0] + i64::from(x), at[1] + i64::from(y));
            picture.fill([to_x, to_y], [1, 1], small.pixel(x, y), 1.0);
        }
    }
}

fn draw_legend(picture: &mut Picture, [x, y]: [i64; 2], scale: u32) {
    let side = text_height(scale);
    let mut left = x;
    for (kind, words) in [
        (Side::Outside, "outside: dropped whole"),
        (Side::Inside, "inside: taken whole"),
        (Side::Straddling, "straddling: asks its sixteen children"),
    ] {
        picture.fill([left, y], [side, side], color(kind), 1.0);
        left += side + 6;
        left += picture.text([left, y], words, scale, CHALK).max(text_width(words, scale)) + 24;
    }
}
