//! Places where rounding decides: the near plane, corners of pixels, edges of the screen; and
//! solids around the eye.

use glam::DVec3;

use super::draft::{Draft, NEAR, Screen, ahead, anywhere, one};
use crate::Rng;

/// Floors, walls and tunnels that run through the near plane and past the eye.
pub(super) fn near_crossers(d: &mut Draft, rng: &mut Rng, _: &Screen) {
    let cells = |rng: &mut Rng| [one(rng, &[1, 3, 12]), one(rng, &[1, 3, 12])];
    for _ in 0..4 {
        let height = rng.range(-2.0, 2.0);
        let lean = rng.range(-0.3, 0.3);
        let o = DVec3::new(-8.0, height, 6.0);
        let (u, v) = (DVec3::new(16.0, lean, 0.0), DVec3::new(0.0, 0.0, -rng.range(8.0, 40.0)));
        let (n, bump) = (cells(rng), one(rng, &[0.0, 0.0, 0.05]));
        d.sheet(rng, [o, u, v], n, bump, 0.05);
    }
    for side in [-1.0, 1.0] {
        let o = DVec3::new(side * rng.range(0.05, 2.0), -3.0, 4.0);
        let (u, v) = (DVec3::new(rng.range(-0.5, 0.5), 0.0, -20.0), DVec3::new(0.0, 6.0, 0.0));
        let n = cells(rng);
        d.sheet(rng, [o, u, v], n, 0.0, 0.05);
    }
    for _ in 0..8 {
        d.triangle([anywhere(rng, 3.0), anywhere(rng, 3.0), ahead(rng)]);
    }
    d.face_the_origin();
}

/// Corners exactly on the near plane of the first view, in the plane of its eye, and at its eye;
/// edges in them.
pub(super) fn on_the_near_plane(d: &mut Draft, rng: &mut Rng, _: &Screen) {
    for _ in 0..30 {
        let mut corners = [ahead(rng), ahead(rng), ahead(rng)];
        for c in &mut corners {
            match rng.below(5) {
                0 | 1 => {
                    let [x, y] = [rng.range(-0.2, 0.2), rng.range(-0.15, 0.15)];
                    *c = DVec3::new(x, y, -NEAR);
                }
                2 => *c = DVec3::new(rng.range(-2.0, 2.0), rng.range(-2.0, 2.0), 0.0),
                3 if rng.chance(0.2) => *c = DVec3::ZERO,
                _ => {}
            }
        }
        d.triangle(corners);
    }
    // A floor with a row of corners in the near plane.
    for height in [-0.1, 0.07] {
        let o = DVec3::new(-4.0, height, -NEAR);
        d.sheet(rng, [o, DVec3::X * 8.0, DVec3::Z * (-8.0 + NEAR)], [8, 6], 0.0, 0.0);
        let o = DVec3::new(-4.0, height, 1.0);
        d.sheet(rng, [o, DVec3::X * 8.0, DVec3::Z * (-1.0 - NEAR)], [8, 1], 0.0, 0.0);
    }
    d.face_the_origin();
}

/// Corners exactly on corners of pixels of the first view, edges along the borders of pixels and of
/// tiles.
pub(super) fn pixel_corners(d: &mut Draft, rng: &mut Rng, screen: &Screen) {
    let place = |rng: &mut Rng| {
        let step = one(rng, &[1.0, 4.0, 8.0, 32.0, 0.5]);
        screen.size.map(|s| (rng.range(-0.1, 1.1) * f64::from(s) / step).round() * step)
    };
    for _ in 0..30 {
        let w = || [1.0, 2.0, 4.0, 8.0];
        let corners = [(); 3].map(|()| {
            let (p, w) = (place(rng), one(rng, &w()));
            screen.point(p, w)
        });
        d.triangle(corners);
    }
    for _ in 0..14 {
        let ([x, y], w) = (place(rng), one(rng, &[2.0, 4.0, 8.0, 16.0]));
        let size = [rng.below(40) as f64 + 1.0, rng.below(24) as f64 + 1.0];
        let corner = |i: f64, j: f64| screen.point([x + size[0] * i, y + size[1] * j], w);
        d.quad(rng, [corner(0.0, 1.0), corner(1.0, 1.0), corner(1.0, 0.0), corner(0.0, 0.0)]);
    }
    // One cell a pixel.
    let ([x, y], w) = (place(rng), 4.0);
    let origin = screen.point([x, y], w);
    let u = screen.point([x + 16.0, y], w) - origin;
    let v = screen.point([x, y - 16.0], w) - origin;
    d.sheet(rng, [origin, u, v], [16, 16], 0.0, 0.1);
    d.face_the_origin();
}

/// Edges and corners on the edges of the screen, and just beside them.
pub(super) fn screen_edges(d: &mut Draft, rng: &mut Rng, screen: &Screen) {
    let [wide, high] = screen.size.map(f64::from);
    for _ in 0..40 {
        let corners = [(); 3].map(|()| {
            let near = |rng: &mut Rng, size: f64| {
                let at = one(rng, &[0.0, 0.0, 1.0, 1.0, 0.5]) * size;
                at + one(rng, &[0.0, 0.0, 1.0, -1.0, 1e-5, -1e-5, 40.0, -40.0])
            };
            let place = [near(rng, wide), near(rng, high)];
            screen.point(place, one(rng, &[1.0, 2.0, 6.0, 9.0]))
        });
        d.triangle(corners);
    }
    let corner = |x: f64, y: f64| screen.point([x * wide, y * high], 32.0);
    d.quad(rng, [corner(0.0, 1.0), corner(1.0, 1.0), corner(1.0, 0.0), corner(0.0, 0.0)]);
    d.face_the_origin();
}

/// Closed boxes that touch, share walls and hold one another; the eye of the first view is in one.
pub(super) fn solids(d: &mut Draft, rng: &mut Rng, _: &Screen) {
    for _ in 0..18 {
        let low = ahead(rng) * 1.5;
        let size = DVec3::new(rng.range(0.1, 4.0), rng.range(0.1, 4.0), rng.range(0.1, 4.0));
        d.block(low, low + size);
        match rng.below(4) {
            // Beside it, wall to wall.
            0 => d.block(DVec3::new(low.x + size.x, low.y, low.z), low + size + DVec3::X * size.x),
            // The same box again.
            1 => d.block(low, low + size),
            2 => d.block(low + size * 0.25, low + size * 0.75),
            _ => {}
        }
    }
    if rng.chance(0.5) {
        d.block(DVec3::splat(-30.0), DVec3::splat(30.0));
        // Seen from within.
        let shell = d.triangles.len() - 12;
        d.triangles[shell..].iter_mut().for_each(|t| t.swap(1, 2));
    }
    d.block(DVec3::splat(-0.5), DVec3::splat(0.5));
}
