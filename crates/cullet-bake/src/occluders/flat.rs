//! Convex polygons that lie in the surface: for thin walls, slopes and open meshes.

use glam::{DVec2, DVec3};

use super::OccluderPolygon;
use super::blocks;
use super::grow::cut;
use super::surface::{Edges, Surface, normal};
use super::voxels::Grid;

/// A ray that meets the plane of a polygon at a lower slope than this may pass beside the surface,
/// where the polygon has a tolerance: polygons are drawn in by the tolerance over the slope.
pub(super) const SLOPE: f64 = OccluderPolygon::LEAST_SLOPE;
/// Cells along the longest side of a flat region.
const CELLS: u32 = 64;
/// Flat regions that are looked at, the largest first.
const MOST_REGIONS: usize = 128;
/// Triangles of a region that are tried as they are.
const LARGEST: usize = 4;

/// Triangles joined by edges that lie in one plane within rounding.
#[derive(Debug)]
struct FlatRegion {
    area: f64,
    two_sided: bool,
    /// How far a vertex is off the plane; 0 where it is at right angles to an axis.
    off: f64,
    normal: DVec3,
    origin: DVec3,
    /// Directions of the plane's coordinates.
    u: DVec3,
    v: DVec3,
    /// The axis that all vertices have the same coordinate of.
    flat: Option<usize>,
    triangles: Vec<([DVec2; 3], [DVec3; 3])>,
    /// Edges that are no seam between two of its triangles, one on either side.
    outline: Vec<[DVec2; 2]>,
}

/// A polygon to choose from.
#[derive(Debug)]
struct Candidate {
    region: usize,
    polygon: OccluderPolygon,
    /// Cells of the region's grid that it hides.
    cells: Vec<u32>,
}

/// Polygons in the surface, those first that hide the most that is not hidden `behind` them
/// already; and the share of the whole area that each adds.
pub(super) fn polygons(
    surface: &Surface,
    most: usize,
    min_gain: f64,
    backed: impl Fn(DVec3, DVec3) -> bool,
) -> Vec<(OccluderPolygon, f64)> {
    let area = surface.area();
    if most == 0 || area <= 0.0 {
        return Vec::new();
    }
    let mut regions = regions(surface, min_gain * area);
    regions.sort_by(|a, b| b.area.total_cmp(&a.area));
    regions.truncate(MOST_REGIONS);
    let mut candidates = Vec::new();
    let mut covered = Vec::new();
    let mut cell_area = Vec::new();
    for (i, region) in regions.iter().enumerate() {
        let (grid, full) = region.raster();
        for (polygon, corners) in
            region.candidates(surface, &grid, &full, most, min_gain * area / region.area)
        {
            let cells = cells_within(&grid, &corners);
            candidates.push(Candidate { region: i, polygon, cells });
        }
        let middle = |at: usize| {
            let p = cell_middle(&grid, at);
            region.origin + region.u * p.x + region.v * p.y
        };
        covered.push(
            (0..grid.cells()).map(|c| backed(middle(c), region.normal)).collect::<Vec<bool>>(),
        );
        cell_area.push(grid.cell.x * grid.cell.y);
    }
    let mut chosen = Vec::new();
    while chosen.len() < most {
        let gain = |c: &Candidate| {
            let new = c.cells.iter().filter(|&&at| !covered[c.region][at as usize]).count();
            new as f64 * cell_area[c.region]
        };
        let best = (0..candidates.len())
            .map(|i| (gain(&candidates[i]), i))
            .max_by(|a, b| a.0.total_cmp(&b.0));
        let Some((gain, best)) = best.filter(|b| b.0 > 0.0 && b.0 >= min_gain * area) else {
            break;
        };
        let Candidate { region, polygon, cells } = candidates.swap_remove(best);
        cells.iter().for_each(|&at| covered[region][at as usize] = true);
        chosen.push((polygon, gain / area));
    }
    chosen
}

/// Flat regions of at least some area.
fn regions(surface: &Surface, min_area: f64) -> Vec<FlatRegion> {
    let edges = Edges::of(surface);
    let normals: Vec<DVec3> =
        surface.triangles.iter().map(|t| normal(&surface.corners(t))).collect();
    let mut order: Vec<u32> = (0..normals.len() as u32).collect();
    order.sort_by(|&a, &b| {
        normals[b as usize].length_squared().total_cmp(&normals[a as usize].length_squared())
    });
    let mut taken = vec![false; normals.len()];
    let mut regions = Vec::new();
    // Twice the rounding of a coordinate in f32: the corners of a wall that was rotated lie this
    // far off it.
    let tolerance = surface.reach * f64::from(f32::EPSILON) * 2.0;
    for first in order {
        let Some(axis) = normals[first as usize].try_normalize() else { continue };
        if std::mem::replace(&mut taken[first as usize], true) {
            continue;
        }
        let two_sided = surface.triangles[first as usize].two_sided;
        let origin = surface.corners(&surface.triangles[first as usize])[0];
        // Triangles with the turn that brings them to the side of the first.
        let mut members = vec![(first, false)];
        let mut next = 0;
        while let Some(&(t, _)) = members.get(next) {
            next += 1;
            for e in edges.of_triangle[t as usize] {
                for &(other, _) in edges.triangles(e) {
                    let i = other as usize;
                    let along = normals[i].dot(axis);
                    let triangle = &surface.triangles[i];
                    let fits = !taken[i]
                        && triangle.two_sided == two_sided
                        && along.abs() > 0.99 * normals[i].length()
                        && (along > 0.0 || two_sided)
                        && surface
                            .corners(triangle)
                            .iter()
                            .all(|p| (*p - origin).dot(axis).abs() <= tolerance);
                    if fits {
                        taken[i] = true;
                        members.push((other, along < 0.0));
                    }
                }
            }
        }
        let area = members.iter().map(|m| normals[m.0 as usize].length() * 0.5).sum();
        if area >= min_area {
            regions.push(FlatRegion::new(surface, &members, axis, area));
        }
    }
    regions
}

impl FlatRegion {
    fn new(surface: &Surface, members: &[(u32, bool)], axis: DVec3, area: f64) -> Self {
        let wound: Vec<[u32; 3]> = members
            .iter()
            .map(|&(t, turned)| {
                let [a, b, c] = surface.triangles[t as usize].vertices;
                if turned { [a, c, b] } else { [a, b, c] }
            })
            .collect();
        let mut sides: Vec<(u32, u32, bool)> = wound
            .iter()
            .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
            .map(|(a, b)| (a.min(b), a.max(b), a < b))
            .collect();
        sides.sort_unstable();
        let outline: Vec<[u32; 2]> = sides
            .chunk_by(|a, b| (a.0, a.1) == (b.0, b.1))
            .filter(|same| !(same.len() == 2 && same[0].2 != same[1].2))
            .map(|same| [same[0].0, same[0].1])
            .collect();
        let point = |v: u32| surface.points[v as usize];
        let origin = point(wound[0][0]);
        let flat = (0..3).find(|&a| wound.iter().flatten().all(|&v| point(v)[a] == origin[a]));
        let normal = flat.map_or(axis, |a| DVec3::AXES[a] * axis[a].signum());
        let longest = outline
            .iter()
            .map(|e| point(e[1]) - point(e[0]))
            .max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))
            .unwrap_or(normal.any_orthonormal_vector());
        let u =
            (longest - normal * longest.dot(normal)).normalize_or(normal.any_orthonormal_vector());
        let v = normal.cross(u);
        let off = wound.iter().flatten().map(|&v| (point(v) - origin).dot(normal).abs());
        let off = if flat.is_some() { 0.0 } else { off.fold(0.0, f64::max) };
        let on = |v_: u32| {
            let p = point(v_) - origin;
            DVec2::new(p.dot(u), p.dot(v))
        };
        Self {
            area,
            two_sided: surface.triangles[members[0].0 as usize].two_sided,
            off,
            normal,
            origin,
            u,
            v,
            flat,
            triangles: wound.iter().map(|t| (t.map(on), t.map(point))).collect(),
            outline: outline.iter().map(|e| e.map(on)).collect(),
        }
    }

    /// A grid over the region, and which of its cells are wholly within it.
    fn raster(&self) -> (Grid, Vec<bool>) {
        let points = || self.triangles.iter().flat_map(|t| t.0);
        let low = points().fold(DVec2::INFINITY, DVec2::min);
        let high = points().fold(DVec2::NEG_INFINITY, DVec2::max);
        let mut grid = Grid::new(low.extend(0.0), high.extend(0.0), CELLS);
        // One layer of cells, around the plane.
        (grid.size[2], grid.low.z, grid.cell.z) = (1, -0.5, 1.0);
        let mut full = vec![false; grid.cells()];
        for (t, _) in &self.triangles {
            let [a, b] = [t[0].min(t[1]).min(t[2]), t[0].max(t[1]).max(t[2])];
            let block = grid.block(a.extend(0.0), b.extend(0.0), 0);
            for y in block[1][0]..block[1][1] {
                for x in block[0][0]..block[0][1] {
                    let at = grid.index([x, y, 0]);
                    full[at] |= within(t, cell_middle(&grid, at));
                }
            }
        }
        let half = grid.cell.truncate() * 0.5;
        for edge in &self.outline {
            let [a, b] = [edge[0].min(edge[1]), edge[0].max(edge[1])];
            let block = grid.block((a - half * 0.01).extend(0.0), (b + half * 0.01).extend(0.0), 0);
            for y in block[1][0]..block[1][1] {
                for x in block[0][0]..block[0][1] {
                    let at = grid.index([x, y, 0]);
                    let middle = cell_middle(&grid, at);
                    let across = (edge[1] - edge[0]).perp();
                    full[at] &=
                        (edge[0] - middle).dot(across).abs() > half.dot(across.abs()) * 1.01;
                }
            }
        }
        (grid, full)
    }

    /// Convex polygons within the region, with their corners in the plane.
    fn candidates(
        &self,
        surface: &Surface,
        grid: &Grid,
        full: &[bool],
        most: usize,
        min_gain: f64,
    ) -> Vec<(OccluderPolygon, Vec<DVec2>)> {
        let mut found = Vec::new();
        // Corners of the mesh are exact; those of other polygons are rounded to f32, off the plane
        // too.
        let rounding = surface.reach * f64::from(f32::EPSILON);
        let off = if self.flat.is_some() { 0.0 } else { 2.0 * (self.off + rounding) };
        let inset = off / SLOPE + rounding;
        // All of it, where it is convex but for rounding: what holds is drawn in once more, for the
        // corners that are rounded.
        let points: Vec<DVec2> = self.outline.iter().flatten().copied().collect();
        let outer = drawn_in(&hull(points), inset);
        if self.holds(&outer) {
            let whole = drawn_in(&outer, inset);
            found.push((self.lifted(&whole, off), whole));
        }
        let mut largest: Vec<_> = self.triangles.iter().collect();
        largest.sort_by(|a, b| twice_area(&b.0).total_cmp(&twice_area(&a.0)));
        for (flat, corners) in largest.into_iter().take(LARGEST) {
            let points = corners.iter().map(|p| p.to_array().map(|v| v as f32)).collect();
            found.push((
                OccluderPolygon { points, two_sided: self.two_sided, tolerance: 0.0 },
                flat.to_vec(),
            ));
        }
        for (block, _) in blocks::choose(grid, full, [0.0, 0.0, 1.0], most, min_gain) {
            let [low, high] = grid.bounds(&block).map(DVec3::truncate);
            let [low, high] = self.push_out(low, high, grid.cell.truncate() * 2.0);
            let corners = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
            let corners = drawn_in(&corners, inset);
            if self.holds(&corners) {
                found.push((self.lifted(&corners, off), corners));
            }
        }
        found
    }

    /// Pushes the sides of a rectangle outward to the outline.
    fn push_out(&self, mut low: DVec2, mut high: DVec2, limit: DVec2) -> [DVec2; 2] {
        for axis in 0..2 {
            for up in [true, false] {
                let (mut from, mut to) = (low, high);
                let side = if up { high[axis] } else { low[axis] };
                if up {
                    (from[axis], to[axis]) = (side, side + limit[axis]);
                } else {
                    (from[axis], to[axis]) = (side - limit[axis], side);
                }
                let mut free = limit[axis];
                for edge in &self.outline {
                    let mut part = edge.to_vec();
                    for a in 0..2 {
                        part = cut(&part, |p| p[a] - from[a]);
                        part = cut(&part, |p| to[a] - p[a]);
                    }
                    free = part.iter().fold(free, |m, p| m.min((p[axis] - side).abs()));
                }
                if up { high[axis] += free } else { low[axis] -= free }
            }
        }
        [low, high]
    }

    /// Whether a convex polygon is within the region: no outline passes through it, and a point of
    /// it is in a triangle.
    fn holds(&self, polygon: &[DVec2]) -> bool {
        if polygon.len() < 3 {
            return false;
        }
        let middle = polygon.iter().sum::<DVec2>() / polygon.len() as f64;
        if !self.triangles.iter().any(|t| within(&t.0, middle)) {
            return false;
        }
        // The part of each edge within the polygon, drawn in by far more than f64 rounds and far
        // less than f32 does.
        let size = polygon.iter().fold(0.0, |m: f64, p| m.max((*p - middle).length()));
        let reach = self.origin.length() + size;
        let slack = reach * f64::from(f32::EPSILON) / 256.0;
        self.outline.iter().all(|edge| {
            let mut part = edge.to_vec();
            for (i, &a) in polygon.iter().enumerate() {
                let b = polygon[(i + 1) % polygon.len()];
                let inward = (b - a).perp().normalize_or_zero();
                part = cut(&part, |p| (*p - a).dot(inward) - slack);
            }
            part.is_empty()
        })
    }

    fn lifted(&self, corners: &[DVec2], tolerance: f64) -> OccluderPolygon {
        let points = corners.iter().map(|c| {
            let mut p = self.origin + self.u * c.x + self.v * c.y;
            if let Some(axis) = self.flat {
                p[axis] = self.origin[axis];
            }
            p.to_array().map(|v| v as f32)
        });
        // Rounded up, for it is a bound.
        let tolerance = if tolerance > 0.0 { (tolerance as f32).next_up() } else { 0.0 };
        OccluderPolygon { points: points.collect(), two_sided: self.two_sided, tolerance }
    }
}

fn twice_area(t: &[DVec2; 3]) -> f64 {
    (t[1] - t[0]).perp_dot(t[2] - t[0])
}

/// Whether a point is in a counter-clockwise triangle.
fn within(t: &[DVec2; 3], p: DVec2) -> bool {
    (0..3).all(|k| (t[(k + 1) % 3] - t[k]).perp_dot(p - t[k]) >= 0.0)
}

fn cell_middle(grid: &Grid, at: usize) -> DVec2 {
    let cell = DVec2::new((at % grid.size[0]) as f64, (at / grid.size[0]) as f64);
    grid.low.truncate() + grid.cell.truncate() * (cell + 0.5)
}

/// The cells of a grid whose middles are in a convex, counter-clockwise polygon.
fn cells_within(grid: &Grid, polygon: &[DVec2]) -> Vec<u32> {
    let inside = |p: DVec2| {
        (0..polygon.len()).all(|i| {
            let (a, b) = (polygon[i], polygon[(i + 1) % polygon.len()]);
            (b - a).perp_dot(p - a) >= 0.0
        })
    };
    (0..grid.cells()).filter(|&at| inside(cell_middle(grid, at))).map(|at| at as u32).collect()
}

/// The convex hull, counter-clockwise (Andrew, *Another Efficient Algorithm for Convex Hulls in Two
/// Dimensions*, 1979).
fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    let mut hull: Vec<DVec2> = Vec::new();
    for pass in 0..2 {
        let start = hull.len();
        for &p in &points {
            while hull.len() >= start + 2 && {
                let [a, b] = [hull[hull.len() - 2], hull[hull.len() - 1]];
                (b - a).perp_dot(p - b) <= (b - a).length() * (p - b).length() * 1e-6
            } {
                hull.pop();
            }
            hull.push(p);
        }
        hull.pop();
        if pass == 0 {
            points.reverse();
        }
    }
    hull
}

/// A convex, counter-clockwise polygon less a border; empty if nothing is left.
fn drawn_in(polygon: &[DVec2], border: f64) -> Vec<DVec2> {
    let mut left = polygon.to_vec();
    for (i, &a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        let inward = (b - a).perp().normalize_or_zero();
        left = cut(&left, |p| (*p - a).dot(inward) - border);
    }
    left
}
