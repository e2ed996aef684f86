//! A small ellipse around points of the plane.

use glam::{DMat2, DVec2};

/// An ellipse of small area around points: its centre and two half-axes.
///
/// Khachiyan's iteration (Todd & Yıldırım, *On Khachiyan's algorithm for the computation of minimum-volume
/// enclosing ellipsoids*, 2007), stopped early; then grown until it holds every point.
pub(super) fn smallest_ellipse(points: &[DVec2]) -> (DVec2, [DVec2; 2]) {
    let n = points.len();
    let mut weight = vec![1.0 / n as f64; n];
    let mean = points.iter().sum::<DVec2>() / n as f64;
    let spread = points.iter().map(|p| p.distance(mean)).fold(0.0, f64::max);
    if spread < 1e-12 {
        return (mean, [DVec2::X * spread, DVec2::Y * spread]);
    }
    let moments = |weight: &[f64]| {
        let centre: DVec2 = points.iter().zip(weight).map(|(p, w)| *p * *w).sum();
        let mut m = DMat2::ZERO;
        for (p, w) in points.iter().zip(weight) {
            let d = *p - centre;
            m += DMat2::from_cols(d * d.x, d * d.y) * *w;
        }
        // Points on a line have no area: a sliver of width instead.
        let floor = spread * spread * 1e-12;
        (centre, m + DMat2::from_diagonal(DVec2::splat(floor)))
    };
    for _ in 0..60 {
        let (centre, m) = moments(&weight);
        let inverse = m.inverse();
        let (far, distance) = points
            .iter()
            .map(|p| (*p - centre).dot(inverse * (*p - centre)))
            .enumerate()
            .fold((0, 0.0), |a, b| if b.1 > a.1 { b } else { a });
        // At the optimum every weighted point is at squared distance 2, the dimension.
        if distance <= 2.0 * 1.002 {
            break;
        }
        let step = (distance - 2.0) / (3.0 * distance);
        weight.iter_mut().for_each(|w| *w *= 1.0 - step);
        weight[far] += step;
    }
    let (centre, m) = moments(&weight);
    let inverse = m.inverse();
    let reach = points
        .iter()
        .map(|p| (*p - centre).dot(inverse * (*p - centre)))
        .fold(0.0, f64::max)
        .sqrt();
    // Half-axes are eigenvectors of m, as long as the roots of its eigenvalues, times the reach.
    let (a, b, d) = (m.x_axis.x, m.x_axis.y, m.y_axis.y);
    let (half_sum, half_difference) = ((a + d) * 0.5, (a - d) * 0.5);
    let root = half_difference.hypot(b);
    let angle = 0.5 * b.atan2(half_difference);
    let direction = DVec2::from_angle(angle);
    let grow = reach * (1.0 + 1e-9);
    let long = direction * ((half_sum + root).max(0.0).sqrt() * grow);
    let short = direction.perp() * ((half_sum - root).max(0.0).sqrt() * grow);
    (centre, [long, short])
}
