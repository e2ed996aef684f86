//! Points, lines and polygons against planes, in exact arithmetic.

use cullet::{Transform, view::Frustum};

use super::exact::Exact;

/// Returns the planes of `frustum` that the image of a point is outside of, by the exact sign of n·x − d, and those
/// that it is not inside of: a bit for each. A point that is not finite is outside of none.
#[must_use]
pub fn outcode_ref(frustum: &Frustum, transform: &Transform, point: [f32; 3]) -> [u32; 2] {
    let [mut outside, mut not_inside] = [0; 2];
    for (i, plane) in frustum.planes() {
        let numbers = plane.normal.iter().chain([&plane.d]);
        let known = transform.is_finite()
            && point.iter().all(|v| v.is_finite())
            && numbers.clone().all(|v| v.is_finite());
        if !known {
            not_inside |= 1 << i;
            continue;
        }
        let x = [0, 1, 2].map(|axis| {
            let row = transform.linear.map(|column| Exact::from(f64::from(column[axis])));
            Exact::dot(&row, &point.map(|v| Exact::from(f64::from(v))))
                .plus(&Exact::from(transform.translation[axis]))
        });
        let distance = Exact::dot(&plane.normal.map(Exact::from), &x).minus(&plane.d.into());
        outside |= u32::from(distance.sign() > 0) << i;
        not_inside |= u32::from(distance.sign() >= 0) << i;
    }
    [outside, not_inside]
}

/// Returns the part of the line from `a` to `b` that is inside of all `planes` n·x ≤ d, as two parameters: exact
/// fractions, rounded once. `None` where nothing is left, and where a number is not finite.
#[must_use]
pub fn clip_line_ref<const D: usize>(
    planes: &[([f64; D], f64)],
    a: &[f64; D],
    b: &[f64; D],
) -> Option<[f64; 2]> {
    if !a.iter().chain(b).all(|v| v.is_finite()) {
        return None;
    }
    // Numerator and denominator, the latter positive.
    let mut ends = [[Exact::from(0.0), Exact::from(1.0)], [Exact::from(1.0), Exact::from(1.0)]];
    let exceeds =
        |p: &[Exact; 2], q: &[Exact; 2]| p[0].times(&q[1]).minus(&q[0].times(&p[1])).sign() > 0;
    let [p, q] = [a, b].map(ExactPoint::new);
    for side in planes {
        let [hp, hq] = [&p, &q].map(|p| p.height(side));
        let zero = Exact::from(0.0);
        match (hp.sign() > 0, hq.sign() > 0) {
            (true, true) => return None,
            (true, false) => {
                let t = [hp.clone(), hp.minus(&hq)];
                if exceeds(&t, &ends[0]) {
                    ends[0] = t;
                }
            }
            (false, true) => {
                let t = [zero.minus(&hp), hq.minus(&hp)];
                if exceeds(&ends[1], &t) {
                    ends[1] = t;
                }
            }
            (false, false) => {}
        }
    }
    let rounded = |t: &[Exact; 2]| t[0].value() / t[1].value();
    (!exceeds(&ends[0], &ends[1])).then(|| [rounded(&ends[0]), rounded(&ends[1])])
}

/// Cuts `polygon` by each of `planes` n·x ≤ d in turn, in exact arithmetic, each number rounded once at the end. A
/// vertex on a plane is inside, and where a plane only touches from outside, nothing is left. Slow, and slower with each plane
/// that really cuts, for the exact numbers double in length; numbers must be finite, else nothing comes of
/// them.
#[must_use]
pub fn clip_polygon_ref<const D: usize>(
    planes: &[([f64; D], f64)],
    polygon: &[[f64; D]],
) -> Vec<[f64; D]> {
    if !polygon.iter().flatten().all(|v| v.is_finite()) {
        return Vec::new();
    }
    let mut points: Vec<ExactPoint<D>> = polygon.iter().map(ExactPoint::new).collect();
    for side in planes {
        let heights: Vec<_> = points.iter().map(|p| p.height(side)).collect();
        let signs: Vec<i32> = heights.iter().map(Exact::sign).collect();
        if signs.contains(&1) && !signs.contains(&-1) {
            return Vec::new();
        }
        let mut next = Vec::new();
        for i in 0..points.len() {
            let j = (i + 1) % points.len();
            if signs[i] <= 0 {
                next.push(points[i].clone());
            }
            if signs[i] * signs[j] < 0 {
                let [p, q] = if signs[i] < 0 { [i, j] } else { [j, i] };
                next.push(ExactPoint::crossing(&points[p], &heights[p], &points[q], &heights[q]));
            }
        }
        points = next;
    }
    if points.len() < 3 {
        return Vec::new();
    }
    points.iter().map(ExactPoint::rounded).collect()
}

/// A point with a common denominator, which is positive: no division, so no rounding.
#[derive(Clone, Debug)]
struct ExactPoint<const D: usize> {
    numerators: [Exact; D],
    denominator: Exact,
}

impl<const D: usize> ExactPoint<D> {
    fn new(p: &[f64; D]) -> Self {
        Self { numerators: p.map(Exact::from), denominator: Exact::from(1.0) }
    }

    /// n·x − d, times the denominator.
    fn height(&self, (normal, d): &([f64; D], f64)) -> Exact {
        Exact::dot(&normal.map(Exact::from), &self.numerators)
            .minus(&self.denominator.times(&(*d).into()))
    }

    /// Where the edge from p, of height below zero, to q, above, crosses.
    fn crossing(p: &Self, height_p: &Exact, q: &Self, height_q: &Exact) -> Self {
        // (p·hq − q·hp) / (hq − hp), and each height carries its point's denominator.
        let blend = |a: &Exact, b: &Exact| a.times(height_q).minus(&b.times(height_p));
        Self {
            numerators: std::array::from_fn(|i| blend(&p.numerators[i], &q.numerators[i])),
            denominator: blend(&p.denominator, &q.denominator),
        }
    }

    fn rounded(&self) -> [f64; D] {
        let w = self.denominator.value();
        std::array::from_fn(|i| self.numerators[i].value() / w)
    }
}
