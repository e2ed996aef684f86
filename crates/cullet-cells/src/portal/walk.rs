//! The walk from the cell of an eye through its portals, and what it reaches.

use alloc::vec::Vec;
use core::ops::Range;

use glam::DVec3;

use super::polygon::{Corner, SLACK, cut, rectangle, side};
use super::view::PortalView;
use super::{PortalClip, PortalOptions};
use crate::cell::CellGraph;
use cullet::bounds::Plane;
use cullet::view::Frustum;

/// A cell that is seen, and through what: one step of a chain that begins in the cell of the eye.
#[derive(Clone, Debug, PartialEq)]
pub struct Visit {
    /// The index of the cell.
    pub cell: u32,
    /// The portal that it is seen through; `None` where the walk began, and of one that is seen in
    /// a mirror.
    pub portal: Option<u32>,
    /// The mirror that it is seen in, if that is the last of its chain.
    pub mirror: Option<u32>,
    /// The visit from which it is seen; `None` where the walk began.
    pub parent: Option<u32>,
    /// How many portals and mirrors led here.
    pub depth: u32,
    /// Where the eye seems to be: mirrored, if its chain has mirrors.
    pub eye: [f64; 3],
    /// All of the view is taken to be seen, because a limit was reached.
    pub is_limited: bool,
    /// How many mirrors led here.
    mirrors: u32,
    rows: [DVec3; 3],
    planes: Range<u32>,
    polygon: Range<u32>,
}

/// Cells that are seen from an eye: a tree of visits, in the order of the walk. Memory that walks
/// use again.
#[derive(Clone, Debug, Default)]
pub struct Reached {
    visits: Vec<Visit>,
    /// Relative to the eyes of the visits.
    planes: Vec<(DVec3, f64)>,
    /// Clipped portals, relative to the eyes of the visits.
    polygons: Vec<DVec3>,
    is_limited: bool,
    /// How many visits are of the cells that the walk began in.
    starts: usize,
    // Scratch.
    stack: Vec<u32>,
    polygon: Vec<Corner>,
    cut: Vec<Corner>,
    labels: Vec<u32>,
    flooded: Vec<bool>,
    queue: Vec<u32>,
}

impl Visit {
    /// Whether the walk began here, so that all of the view is seen.
    #[must_use]
    pub fn is_start(&self) -> bool {
        self.parent.is_none() && !self.is_limited
    }
}

impl Reached {
    /// All visits: the cells that the walk began in first, and each before those that it leads to.
    #[must_use]
    pub fn visits(&self) -> &[Visit] {
        &self.visits
    }

    /// Whether a limit was reached, so that cells may be here that nothing is seen of.
    #[must_use]
    pub fn is_limited(&self) -> bool {
        self.is_limited
    }

    /// The planes that bound what is seen at a visit, relative to [its eye](Visit::eye), of unit
    /// length and pointing out. Whatever is seen there is within them.
    pub fn planes(&self, visit: &Visit) -> impl Iterator<Item = Plane> + '_ {
        let planes = &self.planes[visit.planes.start as usize..visit.planes.end as usize];
        planes.iter().map(|(n, d)| Plane::new((*n).into(), *d))
    }

    /// Returns the corners of the visible part of the last portal or mirror of `visit`, in world
    /// space. There are none where the walk began, none at a [limited](Visit::is_limited) visit,
    /// and none where the eye is so near a portal that it sees through all of it.
    pub fn polygon(&self, visit: &Visit) -> impl Iterator<Item = [f64; 3]> + '_ {
        let eye = DVec3::from(visit.eye);
        let polygon = &self.polygons[visit.polygon.start as usize..visit.polygon.end as usize];
        polygon.iter().map(move |p| (*p + eye).into())
    }

    /// The planes of a visit relative to an origin, as other tests take them: moved out by what
    /// they may be off for whatever is nearer to the eye than `reach`.
    #[must_use]
    pub fn frustum(&self, visit: &Visit, origin: [f64; 3], reach: f64) -> Frustum {
        let eye = DVec3::from(visit.eye) - DVec3::from(origin);
        let slack = 4.0 * SLACK * reach + eye.abs().max_element() * 1e-15;
        let planes = &self.planes[visit.planes.start as usize..visit.planes.end as usize];
        let moved = |(n, d): &(DVec3, f64)| Plane::new((*n).into(), d + n.dot(eye) + slack);
        let mut six = [None; 6];
        for (own, plane) in six.iter_mut().zip(planes) {
            *own = Some(moved(plane));
        }
        let mut frustum = Frustum::from_planes(six);
        for plane in planes.iter().skip(6) {
            // There are never more than fit, and one fewer would let more be seen.
            let _ = frustum.push(moved(plane));
        }
        frustum
    }

    /// The chain that leads to a visit: visits from the first on.
    #[must_use]
    pub fn chain(&self, visit: u32) -> Vec<&Visit> {
        let mut chain = Vec::new();
        let mut at = Some(visit);
        while let Some(visit) = at.and_then(|at| self.visits.get(at as usize)) {
            chain.push(visit);
            at = visit.parent;
        }
        chain.reverse();
        chain
    }
}

/// Walks from the cell of the eye through open portals, or from several where it may be in any, and
/// finds the cells of which something may be seen, each with what bounds that. Conservative: a ray
/// from the eye within the sides of the view that meets nothing but open portals reaches each of
/// its cells within the planes of a visit.
///
/// A line passes a portal once, so no chain does so twice: that bounds every cycle. A cell may be
/// reached by several chains, and has a visit for each. An eye that is nearer to a portal than its
/// corners may be off its plane (a five-hundredth of its size) sees through all of it. Near and far
/// planes of the view are not looked at.
///
/// Cost: that of the portals of the cells that are seen. Nothing is allocated once `reached` has
/// grown. A cell that is not there has no portal; without any, nothing is reached.
pub fn walk_portals(
    graph: &CellGraph,
    view: &PortalView,
    cells: &[u32],
    options: &PortalOptions,
    reached: &mut Reached,
) {
    reached.visits.clear();
    reached.planes.clear();
    reached.polygons.clear();
    reached.stack.clear();
    reached.is_limited = false;
    reached.planes.extend(view.sides.iter().flatten().copied());
    reached.queue.clear();
    let planes = 0..reached.planes.len() as u32;
    for &cell in cells {
        reached.visits.push(Visit {
            cell,
            portal: None,
            mirror: None,
            parent: None,
            depth: 0,
            eye: view.eye.into(),
            is_limited: false,
            mirrors: 0,
            rows: view.rows,
            planes: planes.clone(),
            polygon: 0..0,
        });
    }
    reached.starts = reached.visits.len();
    let is_there = |at: &u32| cells[*at as usize] < graph.cell_count();
    reached.stack.extend((0..reached.starts as u32).rev().filter(is_there));
    while let Some(at) = reached.stack.pop() {
        let first = reached.visits.len();
        let visit = &reached.visits[at as usize];
        if visit.depth >= options.depth || first >= options.visits as usize {
            reached.queue.push(visit.cell);
            continue;
        }
        let (cell, mirrors) = (visit.cell, visit.mirrors);
        for &portal in graph.portals_of(cell) {
            reached.pass(graph, view, at, portal, options);
        }
        if mirrors < options.mirrors {
            for (mirror, _) in (0..).zip(graph.mirrors()).filter(|(_, m)| m.cell == cell) {
                reached.reflect(graph, at, mirror, options);
            }
        }
        // The first of them next.
        reached.stack.extend((first as u32..reached.visits.len() as u32).rev());
    }
    if !reached.queue.is_empty() {
        reached.flood(graph, view);
    }
}

/// Labels from here on are edges of the opening itself.
const OWN: u32 = 1 << 31;
/// The most planes of a visit: as many as a [`Frustum`] has room for.
const MOST_PLANES: usize = Frustum::MAX_PLANES;

/// A portal or mirror on the way.
struct Opening<'a> {
    polygon: &'a [[f64; 3]],
    /// Whether the eye sees its corners counter-clockwise.
    is_front: bool,
    /// How far its plane may be off.
    slack: f64,
    /// How far the eye is before its plane.
    height: f64,
}

impl Opening<'_> {
    /// Whether the eye is in it, as far as one can tell, so that all of it is seen through.
    fn holds_eye(&self) -> bool {
        self.height <= self.slack
    }
}

impl Reached {
    /// Goes on through a portal, if something is seen through it.
    fn pass(
        &mut self,
        graph: &CellGraph,
        view: &PortalView,
        from: u32,
        portal: u32,
        options: &PortalOptions,
    ) {
        let visit = &self.visits[from as usize];
        let Some(beyond) = graph.if_open(portal, visit.cell) else { return };
        let (of, eye) = (&graph.portals()[portal as usize], DVec3::from(visit.eye));
        // All is seen of the cells that the walk began in.
        if visit.mirrors == 0 && self.visits[..self.starts].iter().any(|v| v.cell == beyond) {
            return;
        }
        let is_front = visit.cell == of.cells[0];
        let distance = graph.plane(portal).distance(eye);
        let opening = Opening {
            polygon: &of.polygon,
            is_front,
            slack: 2.0 * graph.tolerance(portal),
            height: if is_front { distance } else { -distance },
        };
        // It is behind the eye's back, as the cell sees it; or was passed, as a line does but once;
        // or is shut.
        if opening.height < -opening.slack
            || self.has_passed(visit, portal)
            || !(graph.is_open(portal) || is_near(&of.polygon, eye, view.door_reach))
        {
            return;
        }
        let Visit { depth, rows, mirrors, .. } = *visit;
        let planes = visit.planes.clone();
        if !self.see(&opening, eye, &planes) {
            return;
        }
        let (planes, polygon) = match opening.holds_eye() {
            true => (planes, 0..0),
            false => (self.bound(&opening, eye, planes, &rows, options.clip), self.keep_polygon()),
        };
        self.visits.push(Visit {
            cell: beyond,
            portal: Some(portal),
            mirror: None,
            parent: Some(from),
            depth: depth + 1,
            eye: eye.into(),
            is_limited: false,
            mirrors,
            rows,
            planes,
            polygon,
        });
    }

    /// Goes on in a mirror, if something of it is seen: in the same cell, with the eye behind the
    /// mirror.
    fn reflect(&mut self, graph: &CellGraph, from: u32, mirror: u32, options: &PortalOptions) {
        let visit = &self.visits[from as usize];
        let (polygon, eye) = (&graph.mirrors()[mirror as usize].polygon, DVec3::from(visit.eye));
        let plane = graph.mirror_plane(mirror);
        let opening = Opening {
            polygon,
            is_front: true,
            slack: 2.0 * graph.mirror_tolerance(mirror),
            height: plane.distance(eye),
        };
        if opening.height < -opening.slack || visit.mirror == Some(mirror) {
            return;
        }
        let Visit { cell, depth, rows, mirrors, .. } = *visit;
        let planes = visit.planes.clone();
        if !self.see(&opening, eye, &planes) {
            return;
        }
        let normal = DVec3::from(plane.normal);
        let reflected = |v: DVec3| v - normal * (2.0 * v.dot(normal));
        let seen_from = eye - normal * (2.0 * opening.height);
        let bounded = match opening.holds_eye() {
            true => planes,
            false => self.bound(&opening, eye, planes, &rows, options.clip),
        };
        // A point is seen in the mirror where its image is seen behind it. All of it is before the
        // mirror.
        let first = self.planes.len() as u32;
        for i in bounded {
            let (n, d) = self.planes[i as usize];
            self.planes.push((reflected(n), d));
        }
        if (self.planes.len() - first as usize) < MOST_PLANES {
            self.planes.push((-normal, opening.slack - opening.height));
        }
        let planes = first..self.planes.len() as u32;
        for corner in &mut self.polygon {
            corner.p += eye - seen_from;
        }
        let polygon = self.keep_polygon();
        self.visits.push(Visit {
            cell,
            portal: None,
            mirror: Some(mirror),
            parent: Some(from),
            depth: depth + 1,
            eye: seen_from.into(),
            is_limited: false,
            mirrors: mirrors + 1,
            rows: rows.map(reflected),
            planes,
            polygon,
        });
    }

    /// Whether a chain passed a portal since its last mirror.
    fn has_passed(&self, visit: &Visit, portal: u32) -> bool {
        let mut at = visit;
        loop {
            if at.portal == Some(portal) {
                return true;
            }
            match at.parent {
                Some(parent) if at.mirror.is_none() => at = &self.visits[parent as usize],
                _ => return false,
            }
        }
    }

    /// Clips an opening by planes; whether something of it is left, in `self.polygon`.
    fn see(&mut self, opening: &Opening<'_>, eye: DVec3, planes: &Range<u32>) -> bool {
        self.polygon.clear();
        let mut size = 0.0_f64;
        for (i, p) in (0..).zip(opening.polygon) {
            let p = DVec3::from(*p) - eye;
            size = size.max(p.abs().max_element());
            self.polygon.push(Corner { p, plane: OWN | i });
        }
        // Where the eye is in the opening, that may be off its plane by as much as it is seen from
        // aside.
        let slack =
            4.0 * SLACK * size + if opening.holds_eye() { 2.0 * opening.slack } else { 0.0 };
        planes.clone().all(|label| {
            let (n, d) = self.planes[label as usize];
            cut(&mut self.polygon, (n, d + slack), label, &mut self.cut)
        })
    }

    /// The planes that bound what is seen through what is left of an opening.
    fn bound(
        &mut self,
        opening: &Opening<'_>,
        eye: DVec3,
        planes: Range<u32>,
        rows: &[DVec3; 3],
        clip: PortalClip,
    ) -> Range<u32> {
        let first = self.planes.len() as u32;
        if clip == PortalClip::Polygons {
            self.labels.clear();
            for corner in &self.polygon {
                if !self.labels.contains(&corner.plane) {
                    self.labels.push(corner.plane);
                }
            }
            if self.labels.len() <= MOST_PLANES {
                for &label in &self.labels {
                    if label & OWN == 0 {
                        self.planes.push(self.planes[label as usize]);
                        continue;
                    }
                    let i = (label & !OWN) as usize;
                    let next = opening.polygon[(i + 1) % opening.polygon.len()];
                    let [a, b] = [opening.polygon[i], next].map(|p| DVec3::from(p) - eye);
                    let normal = if opening.is_front { side(a, b) } else { side(b, a) };
                    self.planes.extend(normal.map(|n| (n, 0.0)));
                }
                return first..self.planes.len() as u32;
            }
        }
        match rectangle(&self.polygon, rows) {
            Some(sides) => self.planes.extend(sides.map(|n| (n, 0.0))),
            None => return planes,
        }
        first..self.planes.len() as u32
    }

    /// Keeps the clipped polygon.
    fn keep_polygon(&mut self) -> Range<u32> {
        let first = self.polygons.len() as u32;
        self.polygons.extend(self.polygon.iter().map(|corner| corner.p));
        first..self.polygons.len() as u32
    }

    /// Visits all that is behind the cells in the queue, as if all of the view were seen there.
    fn flood(&mut self, graph: &CellGraph, view: &PortalView) {
        self.is_limited = true;
        self.flooded.clear();
        self.flooded.resize(graph.cell_count() as usize, false);
        let Visit { eye, rows, ref planes, .. } = self.visits[0];
        // In a mirror, not even the sides of the view bound it.
        let in_mirror = self.visits.iter().any(|visit| visit.mirrors > 0);
        let planes = if in_mirror { 0..0 } else { planes.clone() };
        while let Some(cell) = self.queue.pop() {
            if core::mem::replace(&mut self.flooded[cell as usize], true) {
                continue;
            }
            self.visits.push(Visit {
                cell,
                portal: None,
                mirror: None,
                parent: None,
                depth: 0,
                eye,
                is_limited: true,
                mirrors: 0,
                rows,
                planes: planes.clone(),
                polygon: 0..0,
            });
            for &portal in graph.portals_of(cell) {
                let polygon = &graph.portals()[portal as usize].polygon;
                if graph.is_open(portal) || is_near(polygon, view.eye, view.door_reach) {
                    self.queue.extend(graph.if_open(portal, cell));
                }
            }
        }
    }
}

/// Whether the box around a polygon is nearer to an eye than `reach`.
fn is_near(polygon: &[[f64; 3]], eye: DVec3, reach: f64) -> bool {
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for p in polygon {
        (min, max) = (min.min((*p).into()), max.max((*p).into()));
    }
    (min - eye).max(eye - max).max(DVec3::ZERO).length() <= reach
}
