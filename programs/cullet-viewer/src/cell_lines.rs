//! Cells and portals as lines and faces, from outside.

use glam::DVec3;

use cullet_draw::depth_color;

use crate::cells::{IN_SET, OWN, REACHED, SHUT};
use crate::lines::{Lines, tint};
use crate::session::Session;

/// Cells that are neither reached nor in the set.
const OTHER: [u8; 3] = [0x8C, 0x93, 0x9B];

/// Adds cells and the chain of portals as they are seen from outside.
pub(crate) fn draw(session: &Session, lines: &mut Lines, faces: &mut Lines) {
    let s = &session.state.structure;
    let (Some(chain), Some(decision)) = (&session.cells.chain, &session.decision) else { return };
    let boxes = session.cells.boxes.as_ref().filter(|_| s.cells);
    for (cell, found) in (0..).zip(boxes.map_or(&[][..], |(_, boxes)| boxes)) {
        let Some([low, high]) = *found else { continue };
        let in_set = || {
            let sets = session.cells.sets();
            chain.cell.zip(sets).is_some_and(|(own, sets)| sets.sees(own, cell))
        };
        let reached = chain.reached.as_ref();
        let colour = match cell {
            cell if chain.cell == Some(cell) => tint(OWN, 255),
            cell if reached.is_some_and(|r| r.binary_search(&cell).is_ok()) => tint(REACHED, 255),
            _ if in_set() => tint(IN_SET, 220),
            _ => tint(OTHER, 110),
        };
        wire(low, high, colour, lines);
    }
    if !s.portals {
        return;
    }
    let [x, y, z, _] = decision.request.view.eye();
    let eye = DVec3::new(x, y, z);
    let shown = chain.shown(s.step);
    for (number, step) in (1..).zip(shown) {
        let colour = depth_color(step.depth);
        let corners: Vec<DVec3> = step.polygon.iter().map(|p| DVec3::from(*p)).collect();
        ring(&corners, tint(colour, 255), lines);
        // What is seen through the last of a chosen few: a pyramid from the eye.
        if number == s.step as usize {
            corners.iter().for_each(|&c| lines.line(eye, c, tint(colour, 160)));
            fan(&corners, tint(colour, 90), faces);
        }
    }
    for door in &chain.doors {
        let corners: Vec<DVec3> = door.polygon.iter().map(|p| DVec3::from(*p)).collect();
        ring(&corners, tint(SHUT, 255), lines);
        fan(&corners, tint(SHUT, 120), faces);
    }
}

fn ring(corners: &[DVec3], colour: [u8; 4], lines: &mut Lines) {
    for (a, b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        lines.line(*a, *b, colour);
    }
}

fn fan(corners: &[DVec3], colour: [u8; 4], faces: &mut Lines) {
    for i in 2..corners.len() {
        faces.triangle([corners[0], corners[i - 1], corners[i]], colour);
    }
}

/// The edges of a box of the world.
fn wire(low: DVec3, high: DVec3, colour: [u8; 4], lines: &mut Lines) {
    let corner = |i: usize| {
        let of = |a: usize| if i >> a & 1 == 1 { high[a] } else { low[a] };
        DVec3::new(of(0), of(1), of(2))
    };
    for i in 0..8_usize {
        for a in (0..3).filter(|a| i >> a & 1 == 0) {
            lines.line(corner(i), corner(i | 1 << a), colour);
        }
    }
}
