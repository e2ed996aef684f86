//! Clipping by the near plane, and of connected triangles by a guard band around the screen.

use super::connected::{Connected, Side};
use super::primitives::{Setup, Spots};
use super::screen::{Clip, ObjectScreen};

/// Pixels beyond each edge of the screen up to which places keep their digits.
const BAND: f64 = 4096.0;

/// The guard band.
#[derive(Clone, Copy, Debug)]
pub(super) struct Guard {
    high: [f64; 2],
}

impl Guard {
    pub(super) fn of(size: [u32; 2]) -> Self {
        Self { high: size.map(|s| f64::from(s) + BAND) }
    }

    pub(super) fn holds(&self, place: [f64; 2]) -> bool {
        (0..2).all(|a| place[a] >= -BAND && place[a] <= self.high[a])
    }

    /// How far a point is within each side, times w.
    fn within(&self, c: &Clip) -> [f64; 4] {
        let [right, bottom] = self.high;
        [c.x + BAND * c.w, right * c.w - c.x, c.y + BAND * c.w, bottom * c.w - c.y]
    }

    fn has(&self, c: &Clip) -> bool {
        c.is_in_front() && self.within(c).iter().all(|v| *v >= 0.0)
    }

    /// Clips a polygon by the near plane, then by the four sides.
    fn clip(&self, polygon: &mut Vec<Clip>, other: &mut Vec<Clip>) {
        clip_near(polygon, other);
        for side in 0..4 {
            let height = |c: &Clip| self.within(c)[side];
            clip(polygon, other, height, |inside, outside| {
                let (p, q) = (height(inside), height(outside));
                inside.mix(outside, p / (p - q))
            });
        }
        if !polygon.iter().all(|c| c.spot().is_finite()) {
            polygon.clear();
        }
    }
}

/// Clips a polygon by the near plane.
pub(crate) fn clip_near(polygon: &mut Vec<Clip>, other: &mut Vec<Clip>) {
    clip(polygon, other, Clip::height, Clip::meet_near);
    // Only a view whose near plane goes through its eye leaves such a corner.
    if polygon.iter().any(|c| c.w <= 0.0) {
        polygon.clear();
    }
}

/// Clips a polygon by one plane: what has no height below 0 stays. A polygon of two corners is an edge.
fn clip(
    polygon: &mut Vec<Clip>,
    other: &mut Vec<Clip>,
    height: impl Fn(&Clip) -> f64,
    meet: impl Fn(&Clip, &Clip) -> Clip,
) {
    if polygon.iter().all(|c| height(c) >= 0.0) {
        return;
    }
    other.clear();
    let closing = if polygon.len() == 2 { 1 } else { 0 };
    for (k, corner) in polygon.iter().enumerate().skip(closing) {
        let before = &polygon[(k + polygon.len() - 1) % polygon.len()];
        match (height(before) >= 0.0, height(corner) >= 0.0) {
            (true, false) => {
                if closing == 1 {
                    other.push(*before);
                }
                other.push(meet(before, corner));
            }
            (false, true) => other.extend([meet(corner, before), *corner]),
            (true, true) => other.push(*corner),
            (false, false) => {}
        }
    }
    std::mem::swap(polygon, other);
}

/// Remains of what was clipped; kept for its memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Clipped {
    /// All vertices, then the corners that clipping made; `None` where clipped off.
    pub(super) clips: Vec<Option<Clip>>,
    /// Triangles that were clipped, and the corners of what is left of them.
    triangles: Vec<(u32, [u32; 2])>,
    /// Edges that were clipped, by number, and the corners of what is left of them.
    edges: Vec<(u32, [u32; 2])>,
    /// All vertices, wherever they are.
    all: Vec<Clip>,
    polygon: Vec<Clip>,
    other: Vec<Clip>,
}

impl Clipped {
    pub(super) fn clear(&mut self) {
        self.clips.clear();
        self.triangles.clear();
        self.edges.clear();
    }

    /// Clips triangles and edges. `None` where a number is not finite.
    pub(super) fn make(
        &mut self,
        mesh: &Connected,
        screen: &ObjectScreen,
        guard: &Guard,
    ) -> Option<()> {
        let [xs, ys, zs] = &mesh.places;
        let mut all = std::mem::take(&mut self.all);
        all.clear();
        all.extend((0..xs.len()).map(|v| screen.clip([xs[v], ys[v], zs[v]])));
        let is_finite = all.iter().all(Clip::is_finite);
        if is_finite {
            self.make_of(mesh, &all, guard);
        }
        self.all = all;
        is_finite.then_some(())
    }

    fn make_of(&mut self, mesh: &Connected, all: &[Clip], guard: &Guard) {
        self.clips.extend(all.iter().map(|c| (guard.has(c) && c.spot().is_finite()).then_some(*c)));
        for (number, corners) in mesh.numbered() {
            if corners.iter().any(|&v| self.clips[v as usize].is_none()) {
                let corners = self.clip_off(guard, corners.map(|v| all[v as usize]));
                self.triangles.push((number, corners));
            }
        }
        for (number, &[a, b, ..]) in mesh.edges.iter().enumerate() {
            let ends = [a, b];
            if ends.iter().any(|&v| self.clips[v as usize].is_none()) {
                let ends = self.clip_off(guard, ends.map(|v| all[v as usize]));
                self.edges.push((number as u32, ends));
            }
        }
    }

    /// Adds the corners of what is left of a polygon: the first, and one beyond the last.
    fn clip_off<const N: usize>(&mut self, guard: &Guard, corners: [Clip; N]) -> [u32; 2] {
        self.polygon.clear();
        self.polygon.extend(corners);
        guard.clip(&mut self.polygon, &mut self.other);
        let first = self.clips.len() as u32;
        if self.polygon.len() >= N {
            self.clips.extend(self.polygon.iter().copied().map(Some));
        }
        [first, self.clips.len() as u32]
    }

    /// Remains of an edge; all of it where it was not clipped, `None` where nothing is.
    pub(super) fn edge(&self, number: usize, ends: [u32; 2]) -> Option<[u32; 2]> {
        match self.edges.binary_search_by_key(&(number as u32), |e| e.0) {
            Ok(found) => {
                let [first, end] = self.edges[found].1;
                (end > first).then_some([first, first + 1])
            }
            Err(_) => Some(ends),
        }
    }

    /// Says of each triangle that was clipped which side it shows, what triangles are left of it, and where the near
    /// plane ends it.
    pub(super) fn sort(
        &self,
        setup: &Setup,
        spots: &Spots,
        orient: f32,
        mut found: impl FnMut(
            usize,
            Side,
            &mut dyn Iterator<Item = [u32; 3]>,
            &mut dyn Iterator<Item = [u32; 2]>,
        ),
    ) {
        for &(triangle, [first, end]) in &self.triangles {
            let place = |v: u32| [spots.x[v as usize], spots.y[v as usize]].map(f64::from);
            let next = |v: u32| if v + 1 == end { first } else { v + 1 };
            let (mut area, mut size) = (0.0, 0.0);
            for v in first..end {
                let ([ax, ay], [bx, by], [ox, oy]) = (place(v), place(next(v)), place(first));
                area += (ax - ox) * (by - oy) - (ay - oy) * (bx - ox);
                size += (bx - ax).abs() + (by - ay).abs();
            }
            let doubt = f64::from(setup.doubt);
            let slack = 4.0 * size * doubt + 8.0 * doubt * doubt;
            let area = area * f64::from(orient);
            let side = if area > slack {
                Side::Front
            } else if area < -slack {
                Side::Back
            } else {
                Side::Neither
            };
            let is_near = |v: u32| self.clips[v as usize].is_some_and(|c| c.near == 0.0);
            found(
                triangle as usize,
                side,
                &mut (first + 1..end.max(2) - 1).map(|v| [first, v, v + 1]),
                &mut (first..end).map(|v| [v, next(v)]).filter(|&[a, b]| is_near(a) && is_near(b)),
            );
        }
    }
}
