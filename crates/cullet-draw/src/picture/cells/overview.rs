//! All cells of a storey from above, and which of them are reached.

use cullet::View;
use cullet_cells::InCells;
use cullet_cells::portal::Reached;
use glam::DVec4;

use super::super::Picture;
use super::super::canvas::caption;
use super::super::canvas::{LINE, grouped, keys, keys_height};
use super::super::font::{text_size, text_width};
use super::super::palette::NEIGHBOURS;
use super::super::palette::{INK, PAPER, mix};
use super::plan::{Plan, draw_eye, lay, write_numbers};
use super::sight::Sight;
use super::{OPEN, SHUT};

/// Places in sight.
const IN_SIGHT: [u8; 3] = [0xFF, 0xD2, 0x3F];
/// The rest of the cells that are reached.
const REACHED: [u8; 3] = [0xF4, 0xAE, 0x6E];

/// A plan of the scene's cells with their numbers: portals green where they are open and red where
/// shut, the eye, the cells that the walk through portals reached, and what of them is in sight. It
/// is cut level where the eye is, so of several storeys it shows that of the eye; at the nearest
/// portal where no cell is so high.
///
/// `reached` is [`CellView::reached`](cullet_cells::CellView::reached) after a cull of the view.
/// `size` is that of the picture, at least 320 × 200. Words alone where the scene has no cells.
/// Cost: the cell of a point for each of four times as many pixels.
#[must_use]
pub fn cells(
    world: InCells<'_>,
    view: &View,
    reached: Option<&Reached>,
    size: [u32; 2],
) -> Picture {
    let [width, height] = [size[0].max(320), size[1].max(200)];
    let mut picture = Picture::new(width, height, PAPER);
    let Some(graph) = world.graph() else {
        caption(&mut picture, "the scene has no cells");
        return picture;
    };
    let text = text_size(width);
    let line = (text * LINE).round() as i64;
    let eye = DVec4::from(view.eye());
    let eye = (eye.w != 0.0).then(|| eye.truncate());
    let sight = Sight::new(graph, reached);
    let gap = i64::from(width) / 60;
    let room = i64::from(width) - 2 * gap;
    let mut entries = vec![
        (IN_SIGHT, "in sight, at this height".to_owned()),
        (REACHED, "reached".to_owned()),
        (faint(NEIGHBOURS[1]), "not reached".to_owned()),
        (OPEN, "open portal".to_owned()),
        (SHUT, "shut portal".to_owned()),
    ];
    if reached.is_none() {
        entries.drain(..2);
    }
    let below = keys_height(room, text, &entries) + gap;
    // In a narrow picture the caption takes two lines.
    let above = line * if width < 900 { 2 } else { 1 } + 2 * gap;
    let shown = [room.max(8) as u32, (i64::from(height) - above - below - gap).max(64) as u32];
    let plan = Plan::new(world, graph, eye, shown);
    let color = |cell: u32, p: [f64; 3]| {
        let own = NEIGHBOURS[cell.wrapping_mul(2_654_435_761) as usize >> 13 & 7];
        match (sight.depth_of(cell), sight.depth_at(cell, p)) {
            (Some(_), Some(_)) => IN_SIGHT,
            (Some(_), None) => REACHED,
            _ => faint(own),
        }
    };
    let mut drawn = plan.paint(color);
    let counts = plan.draw_portals(&mut drawn, graph);
    if let Some(eye) = eye {
        draw_eye(&mut drawn, plan.at(eye.into()));
    }
    let place = [gap, above];
    lay(&mut picture, place, &drawn.halved());
    let ink = |cell: u32| {
        if sight.depth_of(cell).is_some() { INK } else { mix(INK, PAPER, 0.35) }
    };
    let without = write_numbers(&mut picture, (&plan, eye), place, text, ink, graph.cell_count());

    let at = if plan.is_at_eye { "where the eye is" } else { "at the portals nearest to the eye" };
    let mut words = format!("Cells from above, cut at a height of {:.2}, {at}.", plan.height);
    match (reached, eye.and_then(|e| world.cell_of(e.into()))) {
        (Some(_), Some(cell)) => {
            let all = grouped(u64::from(graph.cell_count()));
            words += &format!(" From cell {cell}, {} of {all} are reached.", sight.count());
        }
        (_, None) => words += " The eye is in no cell: portals hide nothing.",
        (None, Some(cell)) => words += &format!(" The eye is in cell {cell}."),
    }
    if without > 0 {
        words += &format!(" {without} are too small for their number.");
    }
    let mut left = String::new();
    let mut top = gap;
    for sentence in words.split_inclusive(". ") {
        if !left.is_empty() && text_width(&(left.clone() + sentence), text) > room {
            picture.text([gap, top], &std::mem::take(&mut left), text, INK);
            top += line;
        }
        left += sentence;
    }
    picture.text([gap, top], &left, text, INK);
    if counts[3] > 0 {
        entries.push((PAPER, "dashed: to another storey".to_owned()));
    }
    if counts[2] > 0 {
        entries.push((PAPER, "arrow: one way".to_owned()));
    }
    keys(&mut picture, [gap, i64::from(height) - below], gap + room, text, INK, &entries);
    picture
}

fn faint(color: [u8; 3]) -> [u8; 3] {
    mix(color, [0xEA, 0xE9, 0xE5], 0.82)
}
