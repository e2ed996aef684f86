//! The axes of a tight box around points.

use glam::{DMat3, DVec2, DVec3};

/// Orthonormal axes (columns) of a box of small surface around `points`: the best of the principal
/// axes, of frames spanned by far-apart points, and of the coordinate axes, turned about each of its axes
/// until that helps no more.
///
/// Only a proposal: the caller measures the box on all points.
pub(super) fn tight_axes(points: &[DVec3]) -> DMat3 {
    let extremes = extreme_points(points);
    let mut best = (DMat3::IDENTITY, surface(&DMat3::IDENTITY, points));
    let mut candidates = Vec::new();
    candidates.extend(principal_axes(points));
    // Frames of far-apart points are compared on those points alone: there may be many.
    candidates.extend(
        spanned_frames(&extremes)
            .into_iter()
            .min_by(|a, b| surface(a, &extremes).total_cmp(&surface(b, &extremes))),
    );
    for c in candidates {
        let s = surface(&c, points);
        if s < best.1 {
            best = (c, s);
        }
    }
    for _ in 0..MAX_ROUNDS {
        let before = best.1;
        for axis in 0..3 {
            let turned = turned_about(&best.0, axis, points);
            let s = surface(&turned, points);
            if s < best.1 {
                best = (turned, s);
            }
        }
        if best.1 > before * 0.999 {
            break;
        }
    }
    best.0
}

/// Rounds of turning about all three axes; after a few the gain is in the third digit.
const MAX_ROUNDS: usize = 6;

/// The corners of the parallelepiped with these half edges (columns), around the origin.
pub(super) fn corners(edges: &DMat3) -> [DVec3; 8] {
    let pick = |i: usize, a: usize| if i >> a & 1 == 1 { 1.0 } else { -1.0 };
    std::array::from_fn(|i| {
        edges.x_axis * pick(i, 0) + edges.y_axis * pick(i, 1) + edges.z_axis * pick(i, 2)
    })
}

/// A quarter of the surface of the box with these axes.
fn surface(axes: &DMat3, points: &[DVec3]) -> f64 {
    let to_box = axes.transpose();
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for &p in points {
        let t = to_box * p;
        low = low.min(t);
        high = high.max(t);
    }
    let s = high - low;
    s.x * s.y + s.y * s.z + s.z * s.x
}

/// The points farthest along the axes, the diagonals of the faces and those of the cube.
fn extreme_points(points: &[DVec3]) -> Vec<DVec3> {
    const DIRECTIONS: [[f64; 3]; 13] = [
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 1.0, 0.0],
        [1.0, -1.0, 0.0],
        [1.0, 0.0, 1.0],
        [1.0, 0.0, -1.0],
        [0.0, 1.0, 1.0],
        [0.0, 1.0, -1.0],
        [1.0, 1.0, 1.0],
        [1.0, 1.0, -1.0],
        [1.0, -1.0, 1.0],
        [1.0, -1.0, -1.0],
    ];
    let mut found = [(f64::INFINITY, 0, f64::NEG_INFINITY, 0); DIRECTIONS.len()];
    for (i, p) in points.iter().enumerate() {
        for (best, direction) in found.iter_mut().zip(DIRECTIONS) {
            let t = p.dot(direction.into());
            if t < best.0 {
                (best.0, best.1) = (t, i);
            }
            if t > best.2 {
                (best.2, best.3) = (t, i);
            }
        }
    }
    let mut chosen: Vec<usize> = found.iter().flat_map(|b| [b.1, b.3]).collect();
    chosen.sort_unstable();
    chosen.dedup();
    chosen.into_iter().filter_map(|i| points.get(i).copied()).collect()
}

/// A frame for each edge of a large triangle and of the two tetrahedra on it.
fn spanned_frames(extremes: &[DVec3]) -> Vec<DMat3> {
    let farthest = |measure: &dyn Fn(DVec3) -> f64| {
        extremes.iter().copied().max_by(|a, b| measure(*a).total_cmp(&measure(*b)))
    };
    let Some(&first) = extremes.first() else { return Vec::new() };
    let Some(a) = farthest(&|p| p.distance_squared(first)) else { return Vec::new() };
    let Some(b) = farthest(&|p| p.distance_squared(a)) else { return Vec::new() };
    let Some(c) = farthest(&|p| (p - a).cross(b - a).length_squared()) else { return Vec::new() };
    let normal = (b - a).cross(c - a);
    let Some(top) = farthest(&|p| normal.dot(p)) else { return Vec::new() };
    let Some(bottom) = farthest(&|p| -normal.dot(p)) else { return Vec::new() };
    let mut frames = Vec::new();
    let mut triangle = |p: DVec3, q: DVec3, r: DVec3| {
        let Some(n) = (q - p).cross(r - p).try_normalize() else { return };
        for edge in [q - p, r - q, p - r] {
            if let Some(u) = edge.try_normalize() {
                frames.push(DMat3::from_cols(u, n, u.cross(n)));
            }
        }
    };
    triangle(a, b, c);
    for tip in [top, bottom] {
        triangle(a, b, tip);
        triangle(b, c, tip);
        triangle(c, a, tip);
    }
    // A set in a line has no triangle, and any frame along it will do.
    if let (true, Some(u)) = (frames.is_empty(), (b - a).try_normalize()) {
        let v = u.any_orthonormal_vector();
        frames.push(DMat3::from_cols(u, v, u.cross(v)));
    }
    frames
}

/// The axes along which the points vary most and least: eigenvectors of their covariance, by Jacobi's
/// rotations. `None` where the numbers overflow.
fn principal_axes(points: &[DVec3]) -> Option<DMat3> {
    let count = points.len() as f64;
    let mean = points.iter().sum::<DVec3>() / count;
    let mut m = [[0.0; 3]; 3];
    for &p in points {
        let p = (p - mean).to_array();
        for i in 0..3 {
            for j in 0..3 {
                m[i][j] += p[i] * p[j] / count;
            }
        }
    }
    let mut axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..24 {
        // The largest element off the diagonal goes.
        let (i, j) = [(0, 1), (0, 2), (1, 2)]
            .into_iter()
            .max_by(|a, b| f64::total_cmp(&m[a.0][a.1].abs(), &m[b.0][b.1].abs()))?;
        if m[i][j].abs() <= 1e-14 * (m[i][i] + m[j][j]) {
            break;
        }
        let angle = 0.5 * (2.0 * m[i][j]).atan2(m[i][i] - m[j][j]);
        let (sin, cos) = angle.sin_cos();
        for row in &mut m {
            (row[i], row[j]) = (row[i] * cos + row[j] * sin, row[j] * cos - row[i] * sin);
        }
        for k in 0..3 {
            (m[i][k], m[j][k]) = (m[i][k] * cos + m[j][k] * sin, m[j][k] * cos - m[i][k] * sin);
        }
        for row in &mut axes {
            (row[i], row[j]) = (row[i] * cos + row[j] * sin, row[j] * cos - row[i] * sin);
        }
    }
    let axes = DMat3::from_cols_array_2d(&axes).transpose();
    let x = axes.x_axis.try_normalize()?;
    let y = (axes.y_axis - x * x.dot(axes.y_axis)).try_normalize()?;
    Some(DMat3::from_cols(x, y, x.cross(y)))
}

/// The axes turned about one of them so that the box's surface is least: one side of the smallest
/// rectangle lies along an edge of the outline.
fn turned_about(axes: &DMat3, axis: usize, points: &[DVec3]) -> DMat3 {
    let columns = [axes.x_axis, axes.y_axis, axes.z_axis];
    let (n, u, v) = (columns[axis], columns[(axis + 1) % 3], columns[(axis + 2) % 3]);
    let flat: Vec<DVec2> = points.iter().map(|p| DVec2::new(u.dot(*p), v.dot(*p))).collect();
    let heights = points.iter().map(|p| n.dot(*p));
    let (low, high) =
        heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), t| (l.min(t), h.max(t)));
    let hull = outline(flat);
    let mut best = (DVec2::X, f64::INFINITY);
    for i in 0..hull.len() {
        let edge = hull[(i + 1) % hull.len()] - hull[i];
        let Some(e) = edge.try_normalize() else { continue };
        let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for p in &hull {
            let t = DVec2::new(e.dot(*p), e.perp_dot(*p));
            min = min.min(t);
            max = max.max(t);
        }
        let s = max - min;
        let surface = s.x * s.y + (high - low) * (s.x + s.y);
        if surface < best.1 {
            best = (e, surface);
        }
    }
    let e = best.0;
    let p = (u * e.x + v * e.y).normalize();
    DMat3::from_cols(n, p, n.cross(p))
}

/// The convex outline, counter-clockwise (Andrew's monotone chain), of at most [`MAX_OUTLINE`] points.
fn outline(mut points: Vec<DVec2>) -> Vec<DVec2> {
    drop_inner(&mut points);
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    let mut hull: Vec<DVec2> = Vec::with_capacity(64);
    let mut chain = |points: &mut dyn Iterator<Item = DVec2>| {
        let start = hull.len();
        for p in points {
            while hull.len() >= start + 2
                && (hull[hull.len() - 1] - hull[hull.len() - 2]).perp_dot(p - hull[hull.len() - 1])
                    <= 0.0
            {
                hull.pop();
            }
            hull.push(p);
        }
        hull.pop();
    };
    chain(&mut points.iter().copied());
    chain(&mut points.iter().rev().copied());
    // A round outline has many edges of about the same merit, and each is measured against all.
    if hull.len() > MAX_OUTLINE {
        let step = hull.len() as f64 / MAX_OUTLINE as f64;
        hull = (0..MAX_OUTLINE).map(|i| hull[(i as f64 * step) as usize]).collect();
    }
    hull
}

/// Edges of an outline that are tried; 256 edges squared is a tenth of a millisecond.
const MAX_OUTLINE: usize = 256;

/// Drops the points inside the polygon of those farthest in 16 directions (Akl & Toussaint, *A Fast
/// Convex Hull Algorithm*, 1978), so that few are left to sort.
fn drop_inner(points: &mut Vec<DVec2>) {
    const SIDES: usize = 16;
    if points.len() < 4 * SIDES {
        return;
    }
    let directions: [DVec2; SIDES] =
        std::array::from_fn(|i| DVec2::from_angle(i as f64 * std::f64::consts::TAU / SIDES as f64));
    let mut far = [(f64::NEG_INFINITY, DVec2::ZERO); SIDES];
    for p in points.iter() {
        for (best, direction) in far.iter_mut().zip(directions) {
            let t = direction.dot(*p);
            if t > best.0 {
                *best = (t, *p);
            }
        }
    }
    let mut polygon: Vec<DVec2> = far.iter().map(|f| f.1).collect();
    polygon.dedup();
    // An edge of no length would call every point outer.
    while polygon.len() > 1 && polygon.first() == polygon.last() {
        polygon.pop();
    }
    points.retain(|p| {
        (0..polygon.len()).any(|i| {
            let (a, b) = (polygon[i], polygon[(i + 1) % polygon.len()]);
            (b - a).perp_dot(*p - a) <= 0.0
        })
    });
}
