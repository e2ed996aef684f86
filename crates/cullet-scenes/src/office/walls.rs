//! Cells of a building whose rooms were given up to the middle of their walls.

use cullet::bounds::Plane;
use glam::DVec3;

use cullet_io::reader::{box_planes, numbers};
use cullet_io::{CellGraph, Portal};

/// Takes walls from cells that are boxes up to the middle of their walls: of each cell what is
/// within its walls is left, and for each portal the way through half of the wall that it is in.
/// `boxes` are the lowest and highest corner of each cell; `walls` is half of what is between two
/// cells along each axis. Portals are turned so that they are counter-clockwise as seen from their
/// first cell.
pub(super) fn take_walls(cells: &mut CellGraph, boxes: &[[[f64; 3]; 2]], walls: [f64; 3]) {
    let walls = DVec3::from(walls);
    for (cell, [min, max]) in cells.cells.iter_mut().zip(boxes) {
        let (min, max) = (DVec3::from(*min) + walls, DVec3::from(*max) - walls);
        cell.pieces = vec![box_planes(min.into(), max.into())];
    }
    for portal in &mut cells.portals {
        let middle = |c: u32| {
            let [min, max] = boxes[c as usize].map(DVec3::from);
            (min + max) * 0.5
        };
        let Some(normal) = turn(portal, portal.cells.map(middle)) else { continue };
        let depth = normal.abs().dot(walls);
        for (cell, normal) in portal.cells.into_iter().zip([normal, -normal]) {
            cells.cells[cell as usize].pieces.push(way(&portal.polygon, normal, depth));
        }
    }
    cells.walls = 2.0 * walls.max_element();
}

/// Turns a portal to its first cell, by the middles of both; its normal.
fn turn(portal: &mut Portal, [first, second]: [DVec3; 2]) -> Option<DVec3> {
    let [a, b, c] = *portal.polygon.first_chunk()?;
    let [a, b, c] = [a, b, c].map(DVec3::from);
    let normal = (b - a).cross(c - a).try_normalize()?;
    if normal.dot(first - second) >= 0.0 {
        return Some(normal);
    }
    portal.polygon.reverse();
    Some(-normal)
}

/// The way through an opening, `depth` to the side that `normal` points to.
fn way(polygon: &[[f64; 3]], normal: DVec3, depth: f64) -> Vec<[f64; 4]> {
    let middle = polygon.iter().map(|p| DVec3::from(*p)).sum::<DVec3>() / polygon.len() as f64;
    let edges = polygon.iter().zip(polygon.iter().cycle().skip(1));
    let sides = edges.filter_map(|(a, b)| {
        let out = (DVec3::from(*b) - DVec3::from(*a)).cross(normal);
        let out = if out.dot(middle - DVec3::from(*a)) > 0.0 { -out } else { out };
        Plane::from_point_normal(*a, out)
    });
    let d = normal.dot(middle);
    let [back, end] = [(-normal, -d), (normal, d + depth)].map(|(n, d)| Plane::new(n.into(), d));
    sides.chain([back, end]).map(|plane| numbers(&plane)).collect()
}
