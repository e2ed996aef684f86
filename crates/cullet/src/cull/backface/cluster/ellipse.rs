//! The ellipse around points of the plane that makes the largest elliptic cone.

use alloc::vec::Vec;

use crate::math;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;
use glam::DVec2;

/// An ellipse, as its centre and two half-axes, the longer first.
pub(super) type Ellipse = (DVec2, [DVec2; 2]);

/// An ellipse around all points that leaves its cone nearly the largest region: half of what
/// fitting a cone costs. The points are those of normals at distance 1 along an axis.
///
/// For each direction and ratio of its axes the points are squeezed, and the ellipse is the
/// smallest circle around them; both are sought by steps that are halved when none helps. The
/// smallest *area*, which is easier to find, is the wrong aim: it would make a narrow cone of long
/// normals too long (measured: 0.5 to 4 per cent of the ideal less).
pub(super) fn best_ellipse(points: &[DVec2]) -> Ellipse {
    // Ratios up to e⁶ = 400; what is thinner is widened for rounding anyway.
    const THINNEST: f64 = 6.0;
    let (angle, ratio) = spread(points);
    let mut flat = Vec::with_capacity(points.len());
    let mut value = |at: [f64; 2]| {
        let e = squeezed(points, at, &mut flat);
        (region_lost(&e), at, e)
    };
    let mut best = value([angle, ratio.clamp(0.0, THINNEST)]);
    let mut step = 0.25;
    // The step that led to the best so far: the way back is known to be worse.
    let mut last = [0.0; 2];
    while step > 0.01 {
        let mut next = None;
        for d in [[step, 0.0], [-step, 0.0], [0.0, step], [0.0, -step]] {
            if d == [-last[0], -last[1]] {
                continue;
            }
            let ratio = (best.1[1] + 2.0 * d[1]).clamp(-THINNEST, THINNEST);
            let tried = value([best.1[0] + d[0], ratio]);
            if tried.0 < next.map_or(best.0, |(n, _): (Value, _)| n.0) {
                next = Some((tried, d));
            }
        }
        match next {
            Some((better, d)) => (best, last) = (better, d),
            None => (step, last) = (step * 0.5, [0.0; 2]),
        }
    }
    best.2
}

/// Share that an ellipse leaves unproved, its angle and ratio, and the ellipse.
type Value = (f64, [f64; 2], Ellipse);

/// The angle of the longest axis of the points' moments, and the logarithm of the axes' ratio.
fn spread(points: &[DVec2]) -> (f64, f64) {
    let mean = points.iter().sum::<DVec2>() / points.len() as f64;
    let (mut a, mut b, mut d) = (0.0, 0.0, 0.0);
    for p in points {
        let v = *p - mean;
        (a, b, d) = (a + v.x * v.x, b + v.x * v.y, d + v.y * v.y);
    }
    let root = math::hypot(0.5 * (a - d), b);
    let (long, short) = (0.5 * (a + d) + root, (0.5 * (a + d) - root).max(0.0));
    let ratio = if long > 0.0 { 0.5 * math::ln(long / short.max(long * 1e-6)) } else { 0.0 };
    (0.5 * math::atan2(2.0 * b, a - d), ratio)
}

/// The smallest ellipse around the points with this angle and logarithm of its axes' ratio.
fn squeezed(points: &[DVec2], [angle, ratio]: [f64; 2], flat: &mut Vec<DVec2>) -> Ellipse {
    let (sine, cosine) = math::sin_cos(angle);
    let along = DVec2::new(cosine, sine);
    let across = along.perp();
    let squeeze = math::exp(ratio);
    flat.clear();
    flat.extend(points.iter().map(|p| DVec2::new(p.dot(along), p.dot(across) * squeeze)));
    let (centre, radius) = smallest_circle(flat);
    let centre = along * centre.x + across * (centre.y / squeeze);
    let [s, t] = [along * radius, across * (radius / squeeze)];
    (centre, if squeeze < 1.0 { [t, s] } else { [s, t] })
}

/// The smallest circle around points (Welzl, *Smallest enclosing disks*, 1991, as a loop).
fn smallest_circle(points: &[DVec2]) -> (DVec2, f64) {
    let Some(first) = points.first() else { return (DVec2::ZERO, 0.0) };
    let (mut centre, mut radius) = (*first, 0.0);
    let outside = |p: DVec2, centre: DVec2, radius: f64| {
        p.distance_squared(centre) > radius * radius * (1.0 + 2e-12)
    };
    for (i, p) in points.iter().enumerate() {
        if !outside(*p, centre, radius) {
            continue;
        }
        (centre, radius) = (*p, 0.0);
        for (j, q) in points[..i].iter().enumerate() {
            if !outside(*q, centre, radius) {
                continue;
            }
            centre = (*p + *q) * 0.5;
            radius = p.distance(centre);
            for r in &points[..j] {
                if outside(*r, centre, radius) {
                    (centre, radius) = circle_through(*p, *q, *r).unwrap_or((centre, radius));
                }
            }
        }
    }
    // Rounding, and three points on a line, leave some outside.
    let radius = points.iter().map(|p| p.distance_squared(centre)).fold(0.0, f64::max).sqrt();
    (centre, radius)
}

fn circle_through(p: DVec2, q: DVec2, r: DVec2) -> Option<(DVec2, f64)> {
    let (u, v) = (q - p, r - p);
    let twice = 2.0 * u.perp_dot(v);
    let to_centre = (v.perp() * u.length_squared() - u.perp() * v.length_squared()) / -twice;
    to_centre.is_finite().then(|| (p + to_centre, to_centre.length()))
}

/// How much of the sphere of directions the cone of an ellipse does not prove, but for a constant.
///
/// The region's border in the direction φ across the axis is at the angle whose cotangent is the
/// ellipse's support function H(φ) = c·φ + |(s·φ, t·φ)|, so the region's solid angle is the
/// integral of 1 − H/√(1 + H²).
fn region_lost((centre, [s, t]): &Ellipse) -> f64 {
    DIRECTIONS
        .iter()
        .map(|[x, y]| {
            let d = DVec2::new(*x, *y);
            // An ellipse is the same from both sides, but for its centre.
            // Not hypot, which takes care of sizes that do not occur, and four times as long.
            let half = (s.dot(d) * s.dot(d) + t.dot(d) * t.dot(d)).sqrt();
            let middle = centre.dot(d);
            sine_of_cotangent(middle + half) + sine_of_cotangent(half - middle)
        })
        .sum()
}

fn sine_of_cotangent(h: f64) -> f64 {
    h / (1.0 + h * h).sqrt()
}

/// Sixteen directions of half a turn.
const DIRECTIONS: [[f64; 2]; 16] = [
    [1.0, 0.0],
    [0.980_785_280_403_230_4, 0.195_090_322_016_128_25],
    [0.923_879_532_511_286_7, 0.382_683_432_365_089_8],
    [0.831_469_612_302_545_2, 0.555_570_233_019_602_2],
    [core::f64::consts::FRAC_1_SQRT_2, core::f64::consts::FRAC_1_SQRT_2],
    [0.555_570_233_019_602_2, 0.831_469_612_302_545_2],
    [0.382_683_432_365_089_8, 0.923_879_532_511_286_7],
    [0.195_090_322_016_128_25, 0.980_785_280_403_230_4],
    [0.0, 1.0],
    [-0.195_090_322_016_128_25, 0.980_785_280_403_230_4],
    [-0.382_683_432_365_089_8, 0.923_879_532_511_286_7],
    [-0.555_570_233_019_602_2, 0.831_469_612_302_545_2],
    [-core::f64::consts::FRAC_1_SQRT_2, core::f64::consts::FRAC_1_SQRT_2],
    [-0.831_469_612_302_545_2, 0.555_570_233_019_602_2],
    [-0.923_879_532_511_286_7, 0.382_683_432_365_089_8],
    [-0.980_785_280_403_230_4, 0.195_090_322_016_128_25],
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_circle_holds_all_points() {
        let points: Vec<DVec2> = (0..40)
            .map(|i| DVec2::new((f64::from(i) * 1.7).sin() * 3.0, (f64::from(i) * 2.3).cos()))
            .collect();
        let (centre, radius) = smallest_circle(&points);
        assert!(points.iter().all(|p| p.distance(centre) <= radius * (1.0 + 1e-12)));
        // The widest pair is a lower bound.
        let widest = points
            .iter()
            .flat_map(|p| points.iter().map(move |q| p.distance(*q)))
            .fold(0.0, f64::max);
        assert!(radius >= widest * 0.5 && radius <= widest / 3.0_f64.sqrt() * 1.001, "{radius}");
        let (centre, radius) = circle_through(DVec2::X, DVec2::Y, DVec2::NEG_X).expect("a circle");
        assert!(centre.length() < 1e-12 && (radius - 1.0).abs() < 1e-12);
    }

    #[test]
    fn an_ellipse_of_points_is_found() {
        // Points of an ellipse four times as long as wide, at an angle, off the axis.
        let (along, across) = (DVec2::from_angle(0.7), DVec2::from_angle(0.7).perp());
        let points: Vec<DVec2> = (0..24)
            .map(|i| {
                let (y, x) = (f64::from(i) * 0.2618).sin_cos();
                DVec2::new(0.1, 0.2) + along * (0.4 * x) + across * (0.1 * y)
            })
            .collect();
        let (centre, [s, t]) = best_ellipse(&points);
        assert!(centre.distance(DVec2::new(0.1, 0.2)) < 1e-3, "{centre}");
        assert!((s.length() - 0.4).abs() < 0.01 && (t.length() - 0.1).abs() < 0.01, "{s} {t}");
    }
}
