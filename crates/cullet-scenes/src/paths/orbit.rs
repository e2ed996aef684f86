//! The path around a model.

use cullet::bounds::Boxes;
use cullet::{Camera, Scene};
use glam::{DMat3, DVec3};

use super::{Lens, PathError};
use crate::sin_cos;
use cullet_io::Model;

/// How far the eye stays from what is nearest, in halves of the diagonal: one vertex alone would be
/// in a wide picture with the eye on it.
const CLEAR: f64 = 0.1;

/// Where the eye looks from in one view, and the two directions of its picture.
struct Stand {
    back: DVec3,
    right: DVec3,
    above: DVec3,
}

/// Around the middle of the extent, now lower, now higher, and higher for a flat model, which from
/// low down would be a streak; the eye moves sideways and back until all that is drawn just fills
/// the picture. Costs some 0.4 ms a view of a hundred thousand instances, and nanoseconds a vertex
/// of those at the rim.
pub(super) fn orbit(model: &Model, lens: &Lens, count: usize) -> Result<Vec<Camera>, PathError> {
    let [low, high] = lens.extent()?;
    let centre = (low + high) * 0.5;
    let half = ((high - low) * 0.5).max(DVec3::splat(f64::MIN_POSITIVE));
    // A margin of a twentieth on each side.
    let t = lens.tangents(lens.fov_radians()) * 0.95;
    // The golden ratio keeps the starts of many seeds apart; the first shows three quarters.
    let start = 0.1 + lens.overrides.seed as f64 * 0.618_033_988_749_894_9;
    // In degrees: 20 for a tower, 37 for a plain.
    let elevation = 20.0 + 17.0 * (1.0 - half.y / half.max_element());
    let stand = |i: usize| {
        let turn = i as f64 / count as f64;
        let (sin, cos) = sin_cos(start + turn);
        let (up, out) = sin_cos((elevation + 12.0 * sin_cos(turn * 3.0).0) / 360.0);
        let back = DVec3::new(sin * out, up, cos * out);
        let right = DVec3::Y.cross(back).normalize();
        Stand { back, right, above: back.cross(right) }
    };
    let stands: Vec<Stand> = (0..count).map(stand).collect();
    let extents = Extents::new(&model.scene, centre, half);
    let reach = |tangents: &[[f64; 2]]| -> Vec<[Fit; 2]> {
        let bounds = |(s, t): (&Stand, &[f64; 2])| {
            let (x, y) = (s.back * t[0], s.back * t[1]);
            [s.right + x, x - s.right, s.above + y, y - s.above]
        };
        let directions: Vec<DVec3> = stands.iter().zip(tangents).flat_map(bounds).collect();
        let far = extents.farthest(&directions);
        let fits = far.as_chunks::<4>().0.iter().zip(tangents);
        fits.map(|([r, l, a, b], t)| [Fit::new(t[0], *r, *l), Fit::new(t[1], *a, *b)]).collect()
    };
    let tight = reach(&vec![[t.x, t.y]; count]);
    // One way the picture is full. The other way the eye is farther off than it must be; there the
    // contents are in the middle if they would just fill a narrower picture from that far.
    let backs: Vec<DVec3> = stands.iter().map(|s| s.back).collect();
    let nearest = extents.farthest(&backs);
    let distances: Vec<f64> = (tight.iter().zip(&nearest))
        .map(|([x, y], near)| x.distance.max(y.distance).max(near + CLEAR * half.length()))
        .collect();
    let mut brackets: Vec<[Bracket; 2]> =
        tight.into_iter().map(|fits| fits.map(Bracket::new)).collect();
    for _ in 0..CENTRINGS {
        let next = |(axes, d): (&[Bracket; 2], &f64)| [0, 1].map(|k| axes[k].next(*d));
        let tried = reach(&brackets.iter().zip(&distances).map(next).collect::<Vec<_>>());
        for ((axes, fits), d) in brackets.iter_mut().zip(tried).zip(&distances) {
            axes.iter_mut().zip(fits).for_each(|(axis, fit)| axis.narrow(fit, *d));
        }
    }
    let camera = |((s, [x, y]), d): ((&Stand, &[Bracket; 2]), &f64)| {
        let eye = centre + s.right * x.shift(*d) + s.above * y.shift(*d) + s.back * *d;
        lens.look_along(eye, -s.back)
    };
    Ok(stands.iter().zip(&brackets).zip(&distances).map(camera).collect())
}

/// Where the eye must be, one way of the picture, for all to be in it.
struct Fit {
    /// Half the picture at distance 1.
    tangent: f64,
    distance: f64,
    /// To the side.
    shift: f64,
}

impl Fit {
    /// A point p is in the picture iff |p·right − x| ≤ t (d − p·back): each point bounds x and d
    /// from both sides, and the bounds, of which these are the greatest, meet at the least
    /// distance.
    fn new(tangent: f64, most: f64, least: f64) -> Self {
        Self { tangent, distance: (most + least) / (2.0 * tangent), shift: (most - least) * 0.5 }
    }
}

/// Steps that find the middle; a fit's distance is convex in one over its tangent, so few are
/// enough.
const CENTRINGS: usize = 6;

/// Two fits with one between them that the eye's distance is that of.
struct Bracket {
    /// All is in the picture from there.
    wide: Fit,
    narrow: Option<Fit>,
}

impl Bracket {
    fn new(wide: Fit) -> Self {
        Self { wide, narrow: None }
    }

    /// The tangent to try next, for a distance `d`.
    fn next(&self, d: f64) -> f64 {
        let wide = 1.0 / self.wide.tangent;
        let Some(narrow) = &self.narrow else {
            // Ever narrower, until the distance is more than that.
            return self.wide.tangent * 0.6;
        };
        let slope = (1.0 / narrow.tangent - wide) / (narrow.distance - self.wide.distance);
        let tangent = 1.0 / (wide + (d - self.wide.distance).max(0.0) * slope);
        if tangent > 0.0 { tangent } else { self.wide.tangent }
    }

    /// How far the eye goes to the side, between the two.
    fn shift(&self, d: f64) -> f64 {
        let Some(narrow) = &self.narrow else { return self.wide.shift };
        let share = (d - self.wide.distance) / (narrow.distance - self.wide.distance);
        self.wide.shift + (narrow.shift - self.wide.shift) * share.clamp(0.0, 1.0)
    }

    fn narrow(&mut self, fit: Fit, d: f64) {
        if fit.distance <= d {
            self.wide = fit;
        } else {
            self.narrow = Some(fit);
        }
    }
}

/// A box as its middle, from the scene's, and half its extent.
type Middled = (DVec3, DVec3);

/// How far a box reaches in a direction.
fn at_most((middle, half): Middled, d: DVec3) -> f64 {
    middle.dot(d) + half.dot(d.abs())
}

/// How far a scene reaches from its middle.
struct Extents<'a> {
    scene: &'a Scene,
    centre: DVec3,
    half: DVec3,
    /// Boxes that bound something, with their slots.
    boxes: Vec<(u32, Middled)>,
    /// Boxes around so many of those each: neighbours by slot mostly are ones in space.
    groups: Vec<Middled>,
}

/// Boxes in a group.
const GROUP: usize = 64;

impl<'a> Extents<'a> {
    fn new(scene: &'a Scene, centre: DVec3, half: DVec3) -> Self {
        let origin = DVec3::from(scene.origin());
        let limit = f64::from(Boxes::LIMIT);
        let bounds = |slot: u32| {
            let b = scene.boxes().get(slot as usize);
            let [low, high] = [b.min, b.max].map(|v| DVec3::from(v.map(f64::from)));
            let bounded =
                low.cmple(high).all() && low.min_element() > -limit && high.max_element() < limit;
            bounded.then(|| (slot, ((low + high) * 0.5 + origin - centre, (high - low) * 0.5)))
        };
        let boxes: Vec<(u32, Middled)> = scene.slots().filter_map(bounds).collect();
        let around = |group: &[(u32, Middled)]| {
            let low = group.iter().map(|(_, (m, h))| *m - *h).fold(DVec3::INFINITY, DVec3::min);
            let high =
                group.iter().map(|(_, (m, h))| *m + *h).fold(DVec3::NEG_INFINITY, DVec3::max);
            // Rounding must not move a corner outside.
            ((low + high) * 0.5, (high - low) * (0.5 + 1e-12))
        };
        let groups = boxes.chunks(GROUP).map(around).collect();
        Self { scene, centre, half, boxes, groups }
    }

    /// How far the scene reaches in each direction, times the direction's length: of meshes the
    /// vertices, of instances whose bounds were set those. Where there is nothing, its box.
    fn farthest(&self, directions: &[DVec3]) -> Vec<f64> {
        let groups = || self.groups.iter().zip(self.boxes.chunks(GROUP));
        // First those whose boxes reach the farthest: few others can then reach beyond.
        let mut wanted = Vec::new();
        for (k, &d) in directions.iter().enumerate() {
            let mut first = (f64::NEG_INFINITY, None);
            for (group, boxes) in groups() {
                if at_most(*group, d) <= first.0 {
                    continue;
                }
                for of_box in boxes {
                    let most = at_most(of_box.1, d);
                    if most > first.0 {
                        first = (most, Some(*of_box));
                    }
                }
            }
            wanted.extend(first.1.map(|of_box| (of_box, k)));
        }
        let mut best = vec![f64::NEG_INFINITY; directions.len()];
        wanted.sort_unstable_by_key(|((slot, _), k)| (*slot, *k));
        for alike in wanted.chunk_by(|a, b| a.0.0 == b.0.0) {
            let numbers: Vec<usize> = alike.iter().map(|w| w.1).collect();
            self.widen(alike[0].0, directions, &numbers, &mut best);
        }
        for (group, boxes) in groups() {
            let beyond = |bounds: Middled, k: usize| at_most(bounds, directions[k]) > best[k];
            let numbers: Vec<usize> =
                (0..directions.len()).filter(|k| beyond(*group, *k)).collect();
            for of_box in boxes.iter().filter(|_| !numbers.is_empty()) {
                let beyond = |k: &usize| at_most(of_box.1, directions[*k]) > best[*k];
                let numbers: Vec<usize> = numbers.iter().copied().filter(beyond).collect();
                if !numbers.is_empty() {
                    self.widen(*of_box, directions, &numbers, &mut best);
                }
            }
        }
        for (best, d) in best.iter_mut().zip(directions) {
            if !best.is_finite() {
                *best = self.half.dot(d.abs());
            }
        }
        best
    }

    /// Widens `best` by an instance, in the directions of these numbers.
    fn widen(
        &self,
        (slot, bounds): (u32, Middled),
        directions: &[DVec3],
        numbers: &[usize],
        best: &mut [f64],
    ) {
        let (mesh, transform) = (self.scene.mesh(slot), self.scene.transform(slot));
        let own = transform.transform_box(&mesh.bounds(), self.scene.origin());
        if own != self.scene.bounds(slot) {
            // Set by hand, as of what deforms: it may come to be anywhere within.
            for &k in numbers {
                best[k] = best[k].max(at_most(bounds, directions[k]));
            }
            return;
        }
        let linear = DMat3::from_cols_array_2d(&transform.linear.map(|c| c.map(f64::from)));
        let moved = DVec3::from(transform.translation) - self.centre;
        let local: Vec<(usize, DVec3, f64)> = numbers
            .iter()
            .map(|&k| (k, linear.transpose() * directions[k], moved.dot(directions[k])))
            .collect();
        for p in mesh.positions() {
            let p = DVec3::from(p.map(f64::from));
            for &(k, d, offset) in &local {
                let reach = p.dot(d) + offset;
                // False for NaN.
                if reach > best[k] {
                    best[k] = reach;
                }
            }
        }
    }
}
