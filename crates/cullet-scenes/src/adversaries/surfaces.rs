//! Surfaces: sheets, folds, bent quads, layers, very large and very small triangles.

use glam::DVec3;

use super::draft::{Draft, Screen, ahead, anywhere, one};
use crate::Rng;

/// Bumpy sheets with holes.
pub(super) fn sheets(d: &mut Draft, rng: &mut Rng, _: &Screen) {
    for _ in 0..14 {
        let (u, v) = (anywhere(rng, 6.0), anywhere(rng, 6.0));
        let cells = [one(rng, &[1, 2, 5, 17]), one(rng, &[1, 2, 5, 17])];
        let bump = one(rng, &[0.0, 0.0, 0.02, 0.3, 1.0]);
        let holes = one(rng, &[0.0, 0.0, 0.1]);
        let origin = ahead(rng);
        d.sheet(rng, [origin, u, v], cells, bump, holes);
    }
    d.turn_some(rng, 0.02);
}

/// Strips that fold back on themselves, to the same place or nearly so.
pub(super) fn folds(d: &mut Draft, rng: &mut Rng, _: &Screen) {
    for _ in 0..16 {
        let (origin, along, across) = (ahead(rng), anywhere(rng, 5.0), anywhere(rng, 3.0));
        let lift = anywhere(rng, 1.0) * one(rng, &[0.0, 1e-6, 1e-3, 0.05, 1.0]);
        let back = one(rng, &[0.0, 0.3, 0.9, 0.999]);
        let mut rows: Vec<[u32; 2]> = Vec::new();
        let mut at = origin;
        for k in 0..rng.below(8) as u32 + 3 {
            rows.push([d.point(at), d.point(at + along)]);
            let step = if k % 2 == 0 { across } else { across * -back };
            at += step + lift;
        }
        for pair in rows.windows(2) {
            d.quad_of(rng.chance(0.5), [pair[0][0], pair[0][1], pair[1][1], pair[1][0]]);
        }
    }
}

/// Quads of two triangles that lie in one plane nearly, or not at all.
pub(super) fn bent_quads(d: &mut Draft, rng: &mut Rng, _: &Screen) {
    for _ in 0..60 {
        let (o, u, v) = (ahead(rng), anywhere(rng, 3.0), anywhere(rng, 3.0));
        let size = (u.length() + v.length()) * 0.5;
        let bend = u.cross(v).normalize_or(DVec3::Z)
            * size
            * one(rng, &[0.0, 1e-7, 1e-5, 1e-3, 0.05, 0.5, -1e-4, -0.3]);
        // Not always a parallelogram: convex, or with a corner that points inward.
        let corner = o + u * rng.range(0.2, 1.4) + v * rng.range(0.2, 1.4);
        d.quad(rng, [o, o + u, corner + bend, o + v]);
    }
}

/// Sheets one close behind the other, of different cells.
pub(super) fn layers(d: &mut Draft, rng: &mut Rng, _: &Screen) {
    for _ in 0..4 {
        let (origin, u, v) = (ahead(rng), anywhere(rng, 5.0), anywhere(rng, 5.0));
        let normal = u.cross(v).normalize_or(DVec3::Z);
        let apart = one(rng, &[0.0, 1e-6, 1e-4, 1e-2, 0.2]);
        for k in 0..6 {
            let cells = [one(rng, &[1, 3, 9]), one(rng, &[1, 4, 10])];
            let shift = u * rng.range(-0.1, 0.1);
            let at = origin + normal * (apart * f64::from(k)) + shift;
            let bump = apart * one(rng, &[0.0, 0.6]);
            d.sheet(rng, [at, u, v], cells, bump, 0.1);
        }
    }
}

/// Triangles far smaller than a pixel.
pub(super) fn tiny(d: &mut Draft, rng: &mut Rng, screen: &Screen) {
    for _ in 0..3 {
        let w = one(rng, &[1.0, 4.0, 16.0]);
        let [wide, high] = screen.size.map(f64::from);
        let corner = [rng.range(0.1, 0.7) * wide, rng.range(0.1, 0.7) * high];
        let pixels = one(rng, &[2.0, 8.0, 24.0]);
        let origin = screen.point(corner, w);
        let u = screen.point([corner[0] + pixels, corner[1] + 0.3], w) - origin;
        let v = screen.point([corner[0] + 0.2, corner[1] - pixels], w) - origin;
        let slope = DVec3::new(0.0, 0.0, rng.range(-0.3, 0.3) * u.length());
        let cell = u.length() / 40.0;
        let bump = cell * one(rng, &[0.0, 0.1, 0.4]);
        let holes = one(rng, &[0.0, 0.02]);
        d.sheet(rng, [origin, u + slope, v], [40, 40], bump, holes);
    }
    for _ in 0..300 {
        let (at, size) = (ahead(rng), one(rng, &[1e-6, 1e-4, 1e-2]));
        d.triangle([at, at + anywhere(rng, size), at + anywhere(rng, size)]);
    }
}

/// Triangles that reach far beyond the screen.
pub(super) fn huge(d: &mut Draft, rng: &mut Rng, _: &Screen) {
    for _ in 0..20 {
        let reach = one(rng, &[30.0, 300.0, 3e4, 1e6]);
        let at = ahead(rng);
        // Through a point ahead, so that it is seen.
        let (u, v) = (anywhere(rng, reach), anywhere(rng, reach));
        d.triangle([at + u, at + v, at - (u + v) * rng.range(0.2, 1.5)]);
    }
    let reach = one(rng, &[100.0, 1e4]);
    let [u, v] = [DVec3::X * reach, DVec3::Y * reach];
    let origin = DVec3::new(0.0, 0.0, -40.0) - (u + v) * 0.5;
    d.sheet(rng, [origin, u, v], [7, 5], 0.0, 0.0);
}

/// Triangles anywhere, some of which share corners.
pub(super) fn soup(d: &mut Draft, rng: &mut Rng, _: &Screen) {
    for _ in 0..160 {
        let size = one(rng, &[0.3, 1.0, 3.0, 10.0]);
        let at = ahead(rng);
        d.triangle([at, at + anywhere(rng, size), at + anywhere(rng, size)]);
    }
    let count = d.positions.len();
    for _ in 0..40 {
        d.triangles.push([(); 3].map(|()| rng.below(count) as u32));
    }
}

/// Ground with hills, below the eye and up to it.
pub(super) fn terrain(d: &mut Draft, rng: &mut Rng, _: &Screen) {
    let n = one(rng, &[8, 24, 40]);
    let side = 40.0;
    let steep = one(rng, &[0.2, 1.0, 3.0]);
    let first = d.positions.len() as u32;
    for j in 0..=n {
        for i in 0..=n {
            let at = |k: u32| (f64::from(k) / f64::from(n) - 0.5) * side;
            let height = rng.range(-1.0, 1.0) * steep - 1.5;
            d.point(DVec3::new(at(i), height, at(j)));
        }
    }
    for j in 0..n {
        for i in 0..n {
            let a = first + j * (n + 1) + i;
            d.quad_of(rng.chance(0.5), [a, a + n + 1, a + n + 2, a + 1]);
        }
    }
}
