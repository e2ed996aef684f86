//! Triangles under construction, and places on the screen of the first view.

use glam::DVec3;

use crate::Rng;

/// Distance of the near plane of the first view.
pub(super) const NEAR: f64 = 0.125;

/// Screen of the first view of an adversary, which stands at the origin and looks along −Z: pixels
/// are a power of two wide at a distance of 1, so that corners of pixels are exact positions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Screen {
    pub(super) size: [u32; 2],
    /// Whether lines of sight are parallel.
    pub(super) parallel: bool,
}

impl Screen {
    /// Size of a pixel at a distance of 1.
    fn pixel(&self) -> f64 {
        // Some 70 degrees from edge to edge, or more.
        (1.0 / f64::from(self.size[0].next_power_of_two())) * 2.0
    }

    /// Half of the window at a distance of 1.
    pub(super) fn half(&self) -> [f64; 2] {
        self.size.map(|s| f64::from(s) * 0.5 * self.pixel() * self.spread())
    }

    /// Parallel lines of sight see as much as the others do at a distance of 8.
    fn spread(&self) -> f64 {
        if self.parallel { 8.0 } else { 1.0 }
    }

    /// The point at a place of the screen, in pixels from the top left, `w` before the eye.
    pub(super) fn point(&self, [x, y]: [f64; 2], w: f64) -> DVec3 {
        let [wide, high] = self.size.map(f64::from);
        let scale = self.pixel() * if self.parallel { self.spread() } else { w };
        DVec3::new((x - wide * 0.5) * scale, (high * 0.5 - y) * scale, -w)
    }
}

/// The next f32 beyond a number, away from zero.
pub(super) fn beyond(v: f64) -> f64 {
    let v = v as f32;
    f64::from(if v < 0.0 { v.next_down() } else { v.next_up() })
}

/// In the cube from −`reach` to `reach`.
pub(super) fn anywhere(rng: &mut Rng, reach: f64) -> DVec3 {
    let mut v = || rng.range(-reach, reach);
    DVec3::new(v(), v(), v())
}

/// Somewhere before the first view.
pub(super) fn ahead(rng: &mut Rng) -> DVec3 {
    let w = rng.range(1.0, 16.0);
    DVec3::new(rng.range(-0.8, 0.8) * w, rng.range(-0.5, 0.5) * w, -w)
}

/// One of some.
pub(super) fn one<T: Copy>(rng: &mut Rng, of: &[T]) -> T {
    of[rng.below(of.len())]
}

/// How far apart things that should meet are, for a size of 1: from a thousandth to nothing.
pub(super) fn hairline(rng: &mut Rng) -> f64 {
    one(rng, &[0.0, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, -1e-5, -1e-3])
}

/// Triangles that may share corners.
#[derive(Clone, Debug, Default)]
pub(super) struct Draft {
    pub(super) positions: Vec<DVec3>,
    pub(super) triangles: Vec<[u32; 3]>,
}

impl Draft {
    pub(super) fn point(&mut self, p: DVec3) -> u32 {
        self.positions.push(p);
        self.positions.len() as u32 - 1
    }

    pub(super) fn triangle(&mut self, corners: [DVec3; 3]) {
        let corners = corners.map(|p| self.point(p));
        self.triangles.push(corners);
    }

    /// Two triangles, cut along either diagonal.
    pub(super) fn quad(&mut self, rng: &mut Rng, corners: [DVec3; 4]) {
        let corners = corners.map(|p| self.point(p));
        self.quad_of(rng.chance(0.5), corners);
    }

    /// The same of corners that are there.
    pub(super) fn quad_of(&mut self, other_way: bool, [a, b, c, d]: [u32; 4]) {
        self.triangles.extend(if other_way {
            [[a, b, d], [b, c, d]]
        } else {
            [[a, b, c], [a, c, d]]
        });
    }

    /// `n` × `m` quads over a parallelogram, each corner moved by up to `bump`, each quad left out
    /// with a probability of `holes`.
    pub(super) fn sheet(
        &mut self,
        rng: &mut Rng,
        [origin, u, v]: [DVec3; 3],
        [n, m]: [u32; 2],
        bump: f64,
        holes: f64,
    ) {
        let first = self.positions.len() as u32;
        for j in 0..=m {
            for i in 0..=n {
                let at = u * (f64::from(i) / f64::from(n)) + v * (f64::from(j) / f64::from(m));
                let moved = if bump > 0.0 { anywhere(rng, bump) } else { DVec3::ZERO };
                self.point(origin + at + moved);
            }
        }
        for j in 0..m {
            for i in 0..n {
                let a = first + j * (n + 1) + i;
                let other_way = rng.chance(0.5);
                if !rng.chance(holes) {
                    self.quad_of(other_way, [a, a + 1, a + n + 2, a + n + 1]);
                }
            }
        }
    }

    /// A closed box, wound outward.
    pub(super) fn block(&mut self, low: DVec3, high: DVec3) {
        let corner = |i: u32| {
            let axis = |a: usize| if i >> a & 1 == 1 { high[a] } else { low[a] };
            DVec3::new(axis(0), axis(1), axis(2))
        };
        let corners: [u32; 8] = std::array::from_fn(|i| self.point(corner(i as u32)));
        for quad in
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
        {
            self.quad_of(false, quad.map(|i: usize| corners[i]));
        }
    }

    /// Turns some of the triangles over.
    pub(super) fn turn_some(&mut self, rng: &mut Rng, probability: f64) {
        for t in &mut self.triangles {
            if rng.chance(probability) {
                t.swap(1, 2);
            }
        }
    }

    /// Triangles that show their front to the eye of the first view, for those that would not.
    pub(super) fn face_the_origin(&mut self) {
        for t in &mut self.triangles {
            let [a, b, c] = t.map(|v| self.positions[v as usize]);
            if (b - a).cross(c - a).dot(a) > 0.0 {
                t.swap(1, 2);
            }
        }
    }
}
