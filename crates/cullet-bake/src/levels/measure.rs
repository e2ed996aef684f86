//! The error of a group: how far sample points of the original are from what was made of them, and
//! how far points of that are from the original.

use glam::Vec3;

use cullet_draw::surface::LargestDistances;
use cullet_draw::surface::SurfaceTree;
use cullet_draw::surface::inner_points;

/// Sample points of the original surface that triangles stand for, triangle by triangle, so that
/// neighbours follow each other.
#[derive(Clone, Debug, Default)]
pub(super) struct Carried {
    pub(super) points: Vec<[f32; 3]>,
    /// How many each triangle has.
    pub(super) counts: Vec<u32>,
}

/// Input of a measurement.
pub(super) struct Task<'a> {
    /// Positions that both index lists refer to.
    pub(super) positions: &'a [[f32; 3]],
    /// The triangles before, and the points that they stand for.
    pub(super) before: &'a [u32],
    pub(super) carried: &'a [&'a Carried],
    /// The triangles after.
    pub(super) after: &'a [u32],
    /// The original surface.
    pub(super) original: &'a SurfaceTree,
    /// The error of the triangles before.
    pub(super) floor: f32,
    /// Vertices of triangles that are further off are named.
    pub(super) offends: Option<f32>,
    /// Points on each triangle whose distance from the original is measured.
    pub(super) reverse_points: u32,
    /// The share of points that may exceed the error, and by what factor.
    pub(super) share: f64,
    pub(super) excess: f32,
    pub(super) seed: u64,
}

/// Result of a measurement.
#[derive(Clone, Debug, Default)]
pub(super) struct Measured {
    pub(super) error: f32,
    /// Points of the triangles after.
    pub(super) carried: Carried,
    /// Vertices before whose triangles are further off than wanted: some of them more than once.
    pub(super) offenders: Vec<u32>,
}

/// A triangle with a point that is farther off than this share of the error so far is looked at
/// more closely.
const WARM: f32 = 0.7;

/// How far it is looked towards other points of the triangle, first far, then near.
const STEPS: [f32; 10] = [0.6, 0.5, 0.4, 0.4, 0.3, 0.3, 0.2, 0.2, 0.1, 0.1];

/// The error so far, and what may be left unknown because it is below it.
struct Bar {
    largest: LargestDistances,
    excess: f32,
    now: f32,
}

impl Bar {
    fn push(&mut self, distance: f32) {
        self.largest.push(distance);
        self.now = self.largest.quantile().max(self.largest.max() / self.excess);
    }
}

/// Measures with a search that stops at the first triangle within the error so far: only what is
/// further off has its distance taken.
pub(super) fn measure(task: &Task<'_>) -> Measured {
    let tree = SurfaceTree::new(task.positions, task.after);
    let corners = |t: u32| {
        let i = t as usize * 3;
        [0, 1, 2].map(|k| task.positions[task.after[i + k] as usize])
    };
    // Triangles that stay as they are: their points are where they were.
    let mut kept: Vec<([u32; 3], u32)> =
        task.after.as_chunks().0.iter().copied().zip(0..).collect();
    kept.iter_mut().for_each(|t| t.0 = crate::corners::turned(t.0));
    kept.sort_unstable();
    let mut stays = vec![false; task.after.len() / 3];
    let same = |t: [u32; 3]| {
        let t = crate::corners::turned(t);
        let at = kept.partition_point(|k| k.0 < t);
        kept.get(at).filter(|k| k.0 == t).map(|k| k.1)
    };
    let stayed: Vec<Option<u32>> = task.before.as_chunks().0.iter().map(|t| same(*t)).collect();
    stayed.iter().flatten().for_each(|&t| stays[t as usize] = true);
    let changed = stays.iter().filter(|s| !**s).count();
    let count: usize = task.carried.iter().map(|c| c.points.len()).sum();
    let all = count + changed * task.reverse_points as usize;
    let largest = LargestDistances::new(all, task.share, task.floor);
    let mut bar = Bar { largest, excess: task.excess, now: task.floor };
    let offends = task.offends.unwrap_or(f32::INFINITY);
    let mut offenders = Vec::new();
    let mut found = Vec::with_capacity(count);
    let mut before = stayed.iter().zip(task.before.as_chunks::<3>().0);
    for carried in task.carried {
        let mut points = carried.points.iter();
        for &n in &carried.counts {
            let (stayed, from) = before.next().map_or((None, [0; 3]), |b| (*b.0, *b.1));
            let mut hint = stayed;
            for point in points.by_ref().take(n as usize) {
                let limit = bar.now.min(offends);
                let near = |t: u32| stayed.is_some() || is_within(*point, corners(t), limit);
                let at = hint.filter(|t| near(*t)).or_else(|| tree.within(*point, limit));
                let at = at.unwrap_or_else(|| {
                    // There is one, for a group without triangles is none, and points are finite.
                    let (distance, t) = tree.nearest(*point, f32::INFINITY).unwrap_or_default();
                    bar.push(distance);
                    if distance > offends {
                        let is_there = |v: &u32| task.positions[*v as usize] == *point;
                        match from.iter().find(|v| is_there(v)) {
                            Some(&v) => offenders.push(v),
                            None => offenders.extend(from),
                        }
                    }
                    t
                });
                hint = Some(at);
                found.push(at);
            }
        }
    }
    let mut astray = Vec::new();
    for t in (0..).zip(&stays).filter(|t| !t.1).map(|t| t.0) {
        if let Some(point) = reverse(task, t, corners(t), &mut bar) {
            astray.push(point);
        }
    }
    if !astray.is_empty() {
        let of_before = SurfaceTree::new(task.positions, task.before);
        for (_, t) in astray.iter().filter_map(|p| of_before.nearest(*p, f32::INFINITY)) {
            offenders.extend(&task.before[t as usize * 3..][..3]);
        }
    }
    let carried = hand_over(task, &found);
    Measured { error: bar.now, carried, offenders }
}

/// Measures points of one of the triangles after. Where one is nearly as far off as the farthest of
/// the group, goes on from it to where the triangle is farther off. The farthest point, if it is
/// farther off than wanted.
fn reverse(
    task: &Task<'_>,
    triangle: u32,
    corners: [[f32; 3]; 3],
    bar: &mut Bar,
) -> Option<[f32; 3]> {
    let offends = task.offends.unwrap_or(f32::INFINITY);
    let mut points =
        inner_points(corners, task.seed, triangle, task.reverse_points + STEPS.len() as u32);
    let off = |bar: &mut Bar, p: [f32; 3], near: f32| {
        if task.original.within(p, near).is_some() {
            return 0.0;
        }
        let distance = task.original.nearest(p, f32::INFINITY).map_or(0.0, |n| n.0);
        if distance > bar.now {
            bar.push(distance);
        }
        distance
    };
    let mut best = (0.0, [0.0; 3]);
    for p in points.by_ref().take(task.reverse_points as usize) {
        let distance = off(bar, p, (bar.now.min(offends) * WARM).max(best.0));
        if distance > best.0 {
            best = (distance, p);
        }
    }
    // Nothing was that far off.
    if best.0 <= 0.0 {
        return None;
    }
    for (q, step) in points.zip(STEPS) {
        // Between the two, so within the triangle.
        let p = std::array::from_fn(|a| best.1[a] + (q[a] - best.1[a]) * step);
        let distance = off(bar, p, best.0);
        if distance > best.0 {
            best = (distance, p);
        }
    }
    (best.0 > offends).then_some(best.1)
}

/// The points in the order of the triangles that were found for them.
fn hand_over(task: &Task<'_>, found: &[u32]) -> Carried {
    let mut counts = vec![0u32; task.after.len() / 3];
    found.iter().for_each(|&t| counts[t as usize] += 1);
    let mut next = 0;
    let mut place: Vec<u32> = counts
        .iter()
        .map(|n| {
            next += n;
            next - n
        })
        .collect();
    let mut points = vec![[0.0; 3]; found.len()];
    let all = task.carried.iter().flat_map(|c| &c.points);
    for (point, &t) in all.zip(found) {
        let place = &mut place[t as usize];
        points[*place as usize] = *point;
        *place += 1;
    }
    Carried { points, counts }
}

/// Whether a point is surely at most so far from a triangle, but for the last digits: a look at the
/// triangle where the last point was, before the tree is searched. Says no to some that are, along
/// the edges.
#[inline]
fn is_within(point: [f32; 3], corners: [[f32; 3]; 3], limit: f32) -> bool {
    let p = Vec3::from_array(point);
    let [a, b, c] = corners.map(|q| Vec3::from_array(q) - p);
    let normal = (b - a).cross(c - a);
    let area = normal.length_squared();
    // Above the inside, and near the plane.
    let height = normal.dot(a);
    let inside = |a: Vec3, b: Vec3| a.cross(b).dot(normal) >= 0.0;
    height * height <= limit * limit * area && inside(a, b) && inside(b, c) && inside(c, a)
        || a.length_squared().min(b.length_squared()).min(c.length_squared()) <= limit * limit
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_draw::surface::nearest_ref;
    use cullet_testkit::{Rng, cases};

    #[test]
    fn a_triangle_that_is_said_to_be_near_is() {
        let mut rng = Rng(11);
        let mut yes = 0;
        for _ in 0..cases(4000) {
            let mut at = || [0; 3].map(|_| rng.range(-1.0, 1.0) as f32);
            let (corners, point) = ([at(), at(), at()], at());
            let limit = rng.range(0.0, 0.6) as f32;
            let truth = nearest_ref(&corners, &[0, 1, 2], point).expect("one").0;
            if is_within(point, corners, limit) {
                yes += 1;
                assert!(truth <= f64::from(limit) * (1.0 + 1e-5), "{truth} {limit}");
            }
        }
        assert!(yes * 20 > cases(4000), "{yes}");
    }
}
