//! Portals as they are passed: each twice, once in either direction, with what tests of lines and
//! shafts read.

use cullet_cells::cell::CellGraph;
use cullet_io::baked::graph_hash;
use glam::{DVec3, Vec3};

use super::polygon::Polygon;

/// A portal, passed in one direction.
#[derive(Clone, Debug)]
pub(super) struct Opening {
    /// The cell that is left.
    pub(super) from: u32,
    /// The cell that is entered.
    pub(super) to: u32,
    /// The same portal in the other direction.
    pub(super) reverse: u32,
    /// Number of its portal, and whether that is passed from the first of its cells to the second.
    pub(super) portal: u32,
    pub(super) forward: bool,
    /// Unit normal in the direction of passing; points ahead have n·x > d.
    pub(super) normal: DVec3,
    pub(super) d: f64,
    /// Where its edges begin.
    edges: u32,
}

/// Part of an opening that floods read, half a cache line: where it leads, and a box around it, in
/// f32 about the middle of the graph and wide enough for the rounding.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Bounds {
    pub(super) centre: Vec3,
    pub(super) half: Vec3,
    /// Cell that it leads to, as in [`Opening`].
    pub(super) to: u32,
    pub(super) reverse: u32,
}

/// A plane in f32 with its normal's absolute values, for tests of boxes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane32 {
    pub(super) normal: Vec3,
    pub(super) d: f32,
}

impl Plane32 {
    pub(super) fn new(normal: DVec3, d: f64) -> Self {
        Self { normal: normal.as_vec3(), d: d as f32 }
    }

    /// How far the box reaches to the side of the normal, at the most.
    #[inline]
    pub(super) fn reach(&self, b: &Bounds) -> f32 {
        self.normal.dot(b.centre) - self.d + self.normal.abs().dot(b.half)
    }
}

/// All openings of a graph, those that leave a cell side by side.
#[derive(Debug)]
pub(super) struct Openings {
    list: Vec<Opening>,
    /// Counter-clockwise as seen from ahead.
    polygons: Vec<Polygon>,
    bounds: Vec<Bounds>,
    planes: Vec<Plane32>,
    /// Planes through edges, positive inside.
    edges: Vec<(DVec3, f64)>,
    firsts: Vec<u32>,
    /// The openings of each portal, by the cell that is left.
    places: Vec<[u32; 2]>,
    /// Hash of the graph.
    pub(super) hash: u64,
    /// Added to coordinates here it gives those of the graph.
    pub(super) middle: DVec3,
    /// How thin a window may be before it counts as none.
    pub(super) tolerance: f64,
    /// The same for tests in f32, less what these may be wrong by.
    pub(super) tolerance32: f32,
}

impl Openings {
    /// How many portals there are.
    pub(super) fn portals(&self) -> u32 {
        self.places.len() as u32
    }

    /// Prepares a graph; `tolerance` is a share of its diagonal.
    pub(super) fn new(graph: &CellGraph, tolerance: f64) -> Self {
        let corners = || graph.portals().iter().flat_map(|p| &p.polygon).map(|&v| DVec3::from(v));
        let low = corners().reduce(DVec3::min).unwrap_or_default();
        let high = corners().reduce(DVec3::max).unwrap_or_default();
        let (middle, diagonal) = ((low + high) * 0.5, (high - low).length());
        let mut made = Self {
            list: Vec::with_capacity(graph.portals().len() * 2),
            polygons: Vec::new(),
            bounds: Vec::new(),
            planes: Vec::new(),
            edges: Vec::new(),
            firsts: vec![0],
            places: Vec::new(),
            hash: graph_hash(graph),
            middle,
            tolerance: tolerance * diagonal,
            tolerance32: (tolerance * diagonal - diagonal * ROUNDING) as f32,
        };
        // Where each portal's two openings are.
        let mut places = vec![[0_u32; 2]; graph.portals().len()];
        for cell in 0..graph.cell_count() {
            for &number in graph.portals_of(cell) {
                let portal = &graph.portals()[number as usize];
                let side = usize::from(portal.cells[1] == cell);
                places[number as usize][side] = made.list.len() as u32;
                made.push(graph, number, side, diagonal);
            }
            made.firsts.push(made.list.len() as u32);
        }
        for &[a, b] in &places {
            made.list[a as usize].reverse = b;
            made.list[b as usize].reverse = a;
            made.bounds[a as usize].reverse = b;
            made.bounds[b as usize].reverse = a;
        }
        made.places = places;
        made
    }

    fn push(&mut self, graph: &CellGraph, number: u32, side: usize, diagonal: f64) {
        let portal = &graph.portals()[number as usize];
        let plane = graph.plane(number);
        // The graph's normal points to the first cell, and its polygon is counter-clockwise from
        // there.
        let ahead = side == 1;
        let sign = if ahead { 1.0 } else { -1.0 };
        let normal = DVec3::from(plane.normal) * sign;
        let mut corners: Vec<DVec3> =
            portal.polygon.iter().map(|&v| DVec3::from(v) - self.middle).collect();
        if !ahead {
            corners.reverse();
        }
        let d = plane.d * sign - normal.dot(self.middle);
        let edges = self.edges.len() as u32;
        for (k, &a) in corners.iter().enumerate() {
            let b = corners[(k + 1) % corners.len()];
            if let Some(inward) = normal.cross(b - a).try_normalize() {
                self.edges.push((inward, inward.dot(a)));
            }
        }
        let low = corners.iter().copied().reduce(DVec3::min).unwrap_or_default();
        let high = corners.iter().copied().reduce(DVec3::max).unwrap_or_default();
        let centre = ((low + high) * 0.5).as_vec3();
        let half = (high - centre.as_dvec3()).max(centre.as_dvec3() - low).as_vec3()
            + Vec3::splat((diagonal * 1e-7) as f32);
        self.bounds.push(Bounds { centre, half, to: portal.cells[1 - side], reverse: 0 });
        self.planes.push(Plane32::new(normal, d));
        self.polygons.push(Polygon::around(&corners, normal));
        self.list.push(Opening {
            from: portal.cells[side],
            to: portal.cells[1 - side],
            reverse: 0,
            portal: number,
            forward: side == 0,
            normal,
            d,
            edges,
        });
    }

    pub(super) fn len(&self) -> u32 {
        self.list.len() as u32
    }

    pub(super) fn cells(&self) -> u32 {
        self.firsts.len() as u32 - 1
    }

    /// The opening of a portal, passed from its first cell to its second or the other way; the
    /// first of all where there is no such portal.
    pub(super) fn of_portal(&self, portal: u32, forward: bool) -> u32 {
        self.places.get(portal as usize).map_or(0, |places| places[usize::from(!forward)])
    }

    #[inline]
    pub(super) fn get(&self, opening: u32) -> &Opening {
        &self.list[opening as usize]
    }

    /// The polygon of an opening.
    #[inline]
    pub(super) fn polygon(&self, opening: u32) -> &Polygon {
        &self.polygons[opening as usize]
    }

    /// The openings that leave a cell.
    #[inline]
    pub(super) fn leaving(&self, cell: u32) -> std::ops::Range<u32> {
        self.firsts[cell as usize]..self.firsts[cell as usize + 1]
    }

    #[inline]
    pub(super) fn bounds(&self, opening: u32) -> &Bounds {
        &self.bounds[opening as usize]
    }

    #[inline]
    pub(super) fn plane32(&self, opening: u32) -> &Plane32 {
        &self.planes[opening as usize]
    }

    /// Whether a point of an opening's plane is inside all of its edges, by some distance.
    #[inline]
    pub(super) fn holds(&self, opening: u32, point: DVec3, margin: f64) -> bool {
        let first = self.list[opening as usize].edges as usize;
        let end =
            self.list.get(opening as usize + 1).map_or(self.edges.len(), |o| o.edges as usize);
        self.edges[first..end].iter().all(|(inward, c)| inward.dot(point) - c >= margin)
    }

    /// Bytes in memory, but for little.
    pub(super) fn bytes(&self) -> u64 {
        (self.list.len()
            * (size_of::<Opening>()
                + size_of::<Polygon>()
                + size_of::<Bounds>()
                + size_of::<Plane32>())
            + self.edges.len() * size_of::<(DVec3, f64)>()) as u64
    }
}

/// Error bound of a distance in f32, as a share of the diagonal: some ten roundings of 2⁻²⁴ each.
const ROUNDING: f64 = 6e-7;
