//! The oracle of the walk: a ray through cells, one after the other, until something stops it.
//! Slow.

use glam::DVec3;

use crate::cell::{CellGraph, CellShapes};

/// Where a ray ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RayEnd {
    /// At the border of the last cell, where no open portal is.
    Border([f64; 3]),
    /// Nearer to the edge of an opening than the margin, or after the most steps: nothing is known
    /// beyond.
    Doubt,
}

/// The cells that a ray sees in turn, from an eye in the first: calls `each` with every one, the
/// point in which the ray comes into it, and that in which it leaves; mirrors reflect it, at most
/// `mirrors` times. An opening counts where the ray passes it farther than `margin` from its edges;
/// where it comes nearer, the ray ends.
pub fn ray_cells_ref(
    (graph, shapes): (&CellGraph, &CellShapes),
    cell: u32,
    eye: [f64; 3],
    direction: [f64; 3],
    (mirrors, margin): (u32, f64),
    mut each: impl FnMut(u32, [f64; 3], [f64; 3]),
) -> RayEnd {
    let (mut cell, mut at, mut mirrors) = (cell, DVec3::from(eye), mirrors);
    let Some(mut along) = DVec3::from(direction).try_normalize() else { return RayEnd::Doubt };
    for _ in 0..256 {
        let out = at + along * way_out(shapes, cell, at, along);
        each(cell, at.into(), out.into());
        // Where the ray leaves the cell, or a hair beside: corners of a portal may be a little off.
        let crosses = |plane: &cullet::bounds::Plane| {
            let speed = along.dot(plane.normal.into());
            let t = -plane.distance(at) / speed;
            let p = at + along * t;
            (t.is_finite() && (p - out).length() <= 1e-6 * (1.0 + out.length()))
                .then_some((p, speed))
        };
        let mut next = None;
        for &portal in graph.portals_of(cell) {
            let Some((p, speed)) = crosses(graph.plane(portal)) else { continue };
            let of = &graph.portals()[portal as usize];
            let inside = inset(&of.polygon, graph.plane(portal), p);
            if inside > -margin && inside < margin {
                return RayEnd::Doubt;
            }
            // It comes from the side of its own cell.
            let outward = if of.cells[0] == cell { speed < 0.0 } else { speed > 0.0 };
            if inside >= margin
                && outward
                && let Some(beyond) = graph.beyond(portal, cell)
            {
                next = Some((beyond, p, along));
            }
        }
        for (number, mirror) in (0..).zip(graph.mirrors()).filter(|(_, m)| m.cell == cell) {
            let plane = graph.mirror_plane(number);
            let Some((p, speed)) = crosses(plane) else { continue };
            let inside = inset(&mirror.polygon, plane, p);
            if inside > -margin && inside < margin {
                return RayEnd::Doubt;
            }
            if inside >= margin && speed < 0.0 && mirrors > 0 {
                mirrors -= 1;
                let normal = DVec3::from(plane.normal);
                next = Some((cell, p, along - normal * (2.0 * along.dot(normal))));
            }
        }
        let Some(step) = next else { return RayEnd::Border(out.into()) };
        (cell, at, along) = step;
    }
    RayEnd::Doubt
}

/// How far a ray goes within the pieces of a cell.
fn way_out(shapes: &CellShapes, cell: u32, from: DVec3, along: DVec3) -> f64 {
    let mut reached = 0.0;
    loop {
        // From a hair farther on, which may be in the next piece.
        let ahead = reached + 1e-9 * (1.0 + from.length() + reached);
        let p = from + along * ahead;
        let mut farther = reached;
        for number in 0..shapes.piece_count() {
            let (of, planes) = shapes.piece(number);
            if of != cell || planes.iter().any(|plane| plane.distance(p) > 1e-9) {
                continue;
            }
            let exits = planes.iter().filter_map(|plane| {
                let speed = along.dot(plane.normal.into());
                (speed > 1e-12).then(|| -plane.distance(from) / speed)
            });
            farther = farther.max(exits.fold(f64::INFINITY, f64::min));
        }
        if farther <= ahead {
            return reached;
        }
        reached = farther;
    }
}

/// How far a point of a polygon's plane is within its edges; below zero outside.
fn inset(polygon: &[[f64; 3]], plane: &cullet::bounds::Plane, p: DVec3) -> f64 {
    let normal = DVec3::from(plane.normal);
    let edges = polygon.iter().zip(polygon.iter().cycle().skip(1));
    let insets = edges.filter_map(|(a, b)| {
        let [a, b] = [a, b].map(|c| DVec3::from(*c));
        Some(normal.cross(b - a).try_normalize()?.dot(p - a))
    });
    insets.fold(f64::INFINITY, f64::min)
}
