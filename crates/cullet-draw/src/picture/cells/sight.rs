//! An eye's sight through portals, as pictures need it: places in sight, polygons on the screen,
//! doors that are shut.

use cullet::View;
use cullet::bounds::Plane;
use cullet_cells::cell::CellGraph;
use cullet_cells::portal::{Reached, Visit};
use glam::{DMat4, DVec3, DVec4};

use crate::sort;

/// The part of its cell that each visit shows.
pub(super) struct Sight {
    /// Visits of each cell: depth, eye and planes.
    of_cells: Vec<Vec<(u32, DVec3, Vec<Plane>)>>,
}

impl Sight {
    pub(super) fn new(graph: &CellGraph, reached: Option<&Reached>) -> Self {
        let mut of_cells = vec![Vec::new(); graph.cell_count() as usize];
        if let Some(reached) = reached {
            for visit in reached.visits() {
                if let Some(of) = of_cells.get_mut(visit.cell as usize) {
                    let planes = reached.planes(visit).collect();
                    of.push((visit.depth, DVec3::from(visit.eye), planes));
                }
            }
        }
        Self { of_cells }
    }

    /// Through how many portals a cell is reached, at the least.
    pub(super) fn depth_of(&self, cell: u32) -> Option<u32> {
        self.of_cells.get(cell as usize)?.iter().map(|visit| visit.0).min()
    }

    /// Through how many portals a place of a cell is seen, at the least; `None` where it is beside
    /// all of them.
    pub(super) fn depth_at(&self, cell: u32, p: [f64; 3]) -> Option<u32> {
        let is_in = |eye: &DVec3, planes: &[Plane]| {
            let from_eye = DVec3::from(p) - *eye;
            planes.iter().all(|plane| plane.distance(from_eye) <= 1e-9)
        };
        let visits = self.of_cells.get(cell as usize)?.iter();
        visits.filter(|(_, eye, planes)| is_in(eye, planes)).map(|visit| visit.0).min()
    }

    /// How many cells are reached.
    pub(super) fn count(&self) -> usize {
        self.of_cells.iter().filter(|visits| !visits.is_empty()).count()
    }
}

/// The part of a portal that is seen in a view.
#[derive(Clone, Debug, PartialEq)]
pub struct ShownPortal {
    /// Visit of [`Reached::visits`] that it leads to.
    pub visit: u32,
    /// The portal.
    pub portal: u32,
    /// From which cell it is seen, and into which.
    pub cells: [u32; 2],
    /// How many portals the chain has that it ends.
    pub depth: u32,
    /// Its corners in world space, clipped by all portals before it; none where the eye is in it.
    pub polygon: Vec<[f64; 3]>,
    /// The same on the screen, in pixels of the view from the top left.
    pub screen: Vec<[f64; 2]>,
}

/// A shut portal of a cell that is seen, where it would be seen if it were open.
#[derive(Clone, Debug, PartialEq)]
pub struct DoorInView {
    /// The portal.
    pub portal: u32,
    /// From which cell it is seen, and into which it leads.
    pub cells: [u32; 2],
    /// Its corners in world space, clipped by the portals before it.
    pub polygon: Vec<[f64; 3]>,
    /// The same on the screen, in pixels of the view from the top left.
    pub screen: Vec<[f64; 2]>,
}

/// The portals that a view is seen through, depth first: each is followed by those that are seen
/// through it.
#[must_use]
pub fn shown_portals(view: &View, reached: &Reached) -> Vec<ShownPortal> {
    let visits = reached.visits();
    let shown = |number: u32| {
        let visit = &visits[number as usize];
        let from = &visits[visit.parent? as usize];
        let polygon: Vec<[f64; 3]> = reached.polygon(visit).collect();
        Some(ShownPortal {
            visit: number,
            portal: visit.portal?,
            cells: [from.cell, visit.cell],
            depth: visit.depth,
            screen: on_screen(view, &polygon),
            polygon,
        })
    };
    walk_order(reached).into_iter().filter_map(shown).collect()
}

/// The visits of a walk, depth first: each is followed by those that it leads to. Numbers of
/// [`Reached::visits`].
#[must_use]
pub fn walk_order(reached: &Reached) -> Vec<u32> {
    let visits = reached.visits();
    let mut children = vec![Vec::new(); visits.len()];
    let mut stack = Vec::new();
    for (number, visit) in (0..).zip(visits) {
        match visit.parent {
            Some(parent) => children[parent as usize].push(number),
            None => stack.push(number),
        }
    }
    stack.reverse();
    let mut order = Vec::with_capacity(visits.len());
    while let Some(visit) = stack.pop() {
        order.push(visit);
        stack.extend(children[visit as usize].iter().rev());
    }
    order
}

/// The shut portals of all cells that a view sees, clipped by what is seen there; each once, as the
/// shortest chain shows it.
#[must_use]
pub fn shut_doors(graph: &CellGraph, view: &View, reached: &Reached) -> Vec<DoorInView> {
    let visits: Vec<&Visit> = reached.visits().iter().collect();
    let visits = sort::sorted_by(&visits, |visit| visit.depth.into());
    let mut doors: Vec<DoorInView> = Vec::new();
    for visit in visits.into_iter().filter(|visit| visit.cell < graph.cell_count()) {
        for &portal in graph.portals_of(visit.cell) {
            if graph.is_open(portal) || doors.iter().any(|door| door.portal == portal) {
                continue;
            }
            let of = &graph.portals()[portal as usize];
            let side = if of.cells[0] == visit.cell { 1.0 } else { -1.0 };
            let eye = DVec3::from(visit.eye);
            if graph.plane(portal).distance(eye) * side <= 0.0 {
                continue;
            }
            let mut polygon: Vec<DVec3> =
                of.polygon.iter().map(|p| DVec3::from(*p) - eye).collect();
            for plane in reached.planes(visit) {
                polygon = cut(&polygon, |p| -plane.distance(*p), |p, q, t| *p + (*q - *p) * t);
            }
            let polygon: Vec<[f64; 3]> = polygon.into_iter().map(|p| (p + eye).into()).collect();
            let screen = on_screen(view, &polygon);
            if screen.len() >= 3 {
                let [a, b] = of.cells;
                let cells = if a == visit.cell { [a, b] } else { [b, a] };
                doors.push(DoorInView { portal, cells, polygon, screen });
            }
        }
    }
    doors
}

/// The part of a polygon where a height is not below zero.
fn cut<P: Copy>(
    polygon: &[P],
    height: impl Fn(&P) -> f64,
    between: impl Fn(&P, &P, f64) -> P,
) -> Vec<P> {
    let mut left = Vec::with_capacity(polygon.len() + 1);
    for (p, q) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
        let (hp, hq) = (height(p), height(q));
        if hp >= 0.0 {
            left.push(*p);
        }
        if (hp >= 0.0) != (hq >= 0.0) {
            left.push(between(p, q, hp / (hp - hq)));
        }
    }
    left
}

/// A polygon of the world on the screen, in pixels from the top left; none where nothing of it is
/// in front of the eye.
fn on_screen(view: &View, polygon: &[[f64; 3]]) -> Vec<[f64; 2]> {
    let m = DMat4::from_cols_array(&view.clip_from_world());
    let [w, h] = view.viewport().map(f64::from);
    let clip: Vec<DVec4> = polygon.iter().map(|p| m * DVec3::from(*p).extend(1.0)).collect();
    // What is nearer than this share of the farthest corner would be anywhere.
    let least = clip.iter().map(|c| c.w).fold(0.0, f64::max) * 1e-4;
    let clip = cut(&clip, |c| c.w - least.max(1e-12), |p, q, t| *p + (*q - *p) * t);
    // Beside the picture there may be something of a portal near the eye.
    let sides: [fn(&DVec4) -> f64; 4] =
        [|c| c.w * 1.01 + c.x, |c| c.w * 1.01 - c.x, |c| c.w * 1.01 + c.y, |c| c.w * 1.01 - c.y];
    let clip =
        sides.into_iter().fold(clip, |left, side| cut(&left, side, |p, q, t| *p + (*q - *p) * t));
    clip.iter().map(|c| [(c.x / c.w * 0.5 + 0.5) * w, (0.5 - c.y / c.w * 0.5) * h]).collect()
}
