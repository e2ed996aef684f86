//! A segment against a triangle: by exact signs, so that nothing slips through between two
//! triangles.
//!
//! The segment starts at the origin and ends at `along`; corners are relative to its start. With n
//! = (q − p) × (r − p): the line passes p → q on the side that the sign of along · (p × q) tells,
//! and the three of them sum to along · n. It meets the plane at the share p · (q × r) / (along ·
//! n). Every sign is that of the numbers as they are given, without rounding; then two triangles
//! that share an edge get opposite signs for it whatever the order of its ends, and those around a
//! corner agree on which of them the line passes through. (Rounded edge functions are consistent
//! only by edge, in one order of the vertices: Woop, Benthin & Wald, *Watertight Ray/Triangle
//! Intersection*, 2013.)

use crate::exact::Exact;

/// Crossing of a segment and a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Crossing {
    /// Where on the way from its start, 0, to its end, 1: off by less than [`SHARE_ERROR`].
    pub(super) share: f64,
    /// Whether the corners turn counter-clockwise, seen from the start.
    pub(super) from_front: bool,
}

/// No share is off by more, as a part of the whole way.
pub(super) const SHARE_ERROR: f64 = 1e-9;

/// Determinant of three vectors, off by less than its size times this: five roundings a product of
/// three, and those of the sum of six.
const ROUNDING: f64 = 1e-15;

/// A rounded determinant and the sum of its terms' absolute values.
#[derive(Clone, Copy)]
struct Det {
    value: f64,
    size: f64,
}

impl Det {
    /// a · (b × c).
    #[inline(always)]
    fn of(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> Self {
        let (mut value, mut size) = (0.0, 0.0);
        for axis in 0..3 {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let (plus, minus) = (b[u] * c[v], b[v] * c[u]);
            value += (plus - minus) * a[axis];
            size += (plus.abs() + minus.abs()) * a[axis].abs();
        }
        Self { value, size }
    }

    /// Its sign, by `exact` where rounding hides it.
    #[inline(always)]
    fn sign(self, exact: impl FnOnce() -> Exact) -> i32 {
        // Written so that what is not finite goes on.
        if self.value.abs() > self.size * ROUNDING {
            return if self.value > 0.0 { 1 } else { -1 };
        }
        exact().sign()
    }
}

/// a · (b × c) without rounding.
#[cold]
fn exact(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> Exact {
    let mut sum = Exact::from(0.0);
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let product = |x: f64, y: f64| Exact::from(x).times(&Exact::from(y));
        let minor = product(b[u], c[v]).minus(&product(b[v], c[u]));
        sum = sum.plus(&minor.times(&Exact::from(a[axis])));
    }
    sum
}

/// Where the segment from the origin to `along` crosses a triangle: its ends lie on different sides
/// of the triangle's plane, neither on it, and the point between them is in the triangle or on its
/// border. `None` else, also for a triangle that is seen edge-on and for one without area.
///
/// Exact for finite numbers of which no product of three overflows or falls below 1e-270 or so.
#[inline(always)]
pub(super) fn crossing(along: [f64; 3], [p, q, r]: [[f64; 3]; 3]) -> Option<Crossing> {
    let edges = [(p, q), (q, r), (r, p)];
    let dets = edges.map(|(a, b)| Det::of(along, a, b));
    // Most are missed, and by far: two edges are passed on different sides.
    let beyond = |d: &Det, sign: f64| d.value * sign > d.size * ROUNDING;
    if dets.iter().any(|d| beyond(d, 1.0)) && dets.iter().any(|d| beyond(d, -1.0)) {
        return None;
    }
    let mut towards = 0;
    for (det, (a, b)) in dets.iter().zip(edges) {
        let sign = det.sign(|| exact(along, a, b));
        if sign * towards < 0 {
            return None;
        }
        towards = if sign == 0 { towards } else { sign };
    }
    // All zero: the line lies in the plane, or there is no plane.
    if towards == 0 {
        return None;
    }
    let height = Det::of(p, q, r);
    if height.sign(|| exact(p, q, r)) != towards {
        return None;
    }
    let through = Det {
        value: dets.iter().map(|d| d.value).sum(),
        size: dets.iter().map(|d| d.size).sum::<f64>() * 2.0,
    };
    let exact_through =
        || edges.iter().fold(Exact::from(0.0), |sum, &(a, b)| sum.plus(&exact(along, a, b)));
    let rest = Det { value: through.value - height.value, size: through.size + height.size };
    if rest.sign(|| exact_through().minus(&exact(p, q, r))) != towards {
        return None;
    }
    let error = (height.size + through.size) * ROUNDING;
    let share = if error < through.value.abs() * (SHARE_ERROR * 0.25) {
        height.value / through.value
    } else {
        exact(p, q, r).value() / exact_through().value()
    };
    Some(Crossing { share: share.clamp(0.0, 1.0), from_front: towards < 0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_testkit::Rng;

    /// Finds the crossing by whole numbers, which do not round.
    fn crossing_ref(along: [i128; 3], [p, q, r]: [[i128; 3]; 3]) -> Option<(f64, bool)> {
        let det = |a: [i128; 3], b: [i128; 3], c: [i128; 3]| {
            a[0] * (b[1] * c[2] - b[2] * c[1])
                + a[1] * (b[2] * c[0] - b[0] * c[2])
                + a[2] * (b[0] * c[1] - b[1] * c[0])
        };
        let signs = [det(along, p, q), det(along, q, r), det(along, r, p)];
        let (through, height) = (signs.iter().sum::<i128>(), det(p, q, r));
        let within = signs.iter().all(|&s| s >= 0) || signs.iter().all(|&s| s <= 0);
        let between = height.signum() * through.signum() > 0 && height.abs() < through.abs();
        (within && between).then(|| (height as f64 / through as f64, through < 0))
    }

    /// Few different numbers, so that ends, edges and corners are hit all the time; then as many
    /// bits as f64 has, where corners lie in a line with the segment but for the last of them.
    #[test]
    fn crossings_are_those_of_whole_numbers() {
        let mut rng = Rng(3);
        let mut counts = [0; 3];
        for round in 0..200_000 {
            let scale = if round % 2 == 0 { 1 } else { 1 << 38 };
            let mut vector = || [(); 3].map(|()| (rng.below(7) as i128 - 3) * scale);
            let (along, mut corners) = (vector(), [vector(), vector(), vector()]);
            if scale > 1 {
                corners.iter_mut().flatten().for_each(|v| *v += rng.below(3) as i128 - 1);
            }
            let expected = crossing_ref(along, corners);
            let float = |v: [i128; 3]| v.map(|v| v as f64);
            let found = crossing(float(along), corners.map(float));
            assert_eq!(found.is_some(), expected.is_some(), "{along:?} {corners:?}");
            if let (Some(found), Some((share, front))) = (found, expected) {
                assert!((found.share - share).abs() < SHARE_ERROR && found.from_front == front);
                counts[1 + round % 2] += 1;
            } else {
                counts[0] += 1;
            }
        }
        assert!(counts.iter().all(|&n| n > 1000), "{counts:?}");
    }

    #[test]
    fn between_the_triangles_of_a_fan_nothing_slips_through() {
        let mut rng = Rng(5);
        let mut touched = 0;
        for _ in 0..20_000 {
            let count = 4 + rng.index(6);
            let hub = [rng.signed() * 0.1, rng.signed() * 0.1, 1.0 + rng.signed() * 0.3];
            let rim: Vec<[f64; 3]> = (0..count)
                .map(|i| {
                    let turn =
                        (i as f64 + rng.unit() * 0.5) / count as f64 * core::f64::consts::TAU;
                    [turn.cos(), turn.sin(), 1.0 + rng.signed() * 0.3]
                })
                .collect();
            // Through the hub, or a point of a spoke as near as f64 comes to it.
            let (spoke, at) = (rim[rng.index(count)], rng.unit() * rng.below(2) as f64 * 0.9);
            let through: [f64; 3] = core::array::from_fn(|a| hub[a] + (spoke[a] - hub[a]) * at);
            // Twice as far is the very line through it, since doubling rounds nothing.
            let beyond = 2.0 + rng.unit() * rng.below(2) as f64;
            let along = through.map(|v| v * beyond);
            let hits = (0..count)
                .filter(|&i| crossing(along, [hub, rim[i], rim[(i + 1) % count]]).is_some())
                .count();
            assert!(hits > 0, "{hub:?} {rim:?} {along:?}");
            touched += usize::from(hits > 1);
        }
        assert!(touched > 1000, "{touched} went through the very edge");
    }
}
