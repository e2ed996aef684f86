//! Targets that stand near each other: next to a visible target there is most often another one.

use glam::DVec3;

use super::tree::RayTree;

/// Neighbours of a target that are known.
const NEIGHBOURS: usize = 8;

/// Targets in a leaf of the search.
const LEAF: usize = 8;

/// Nearest targets of each target, by their middles.
#[derive(Debug)]
pub(super) struct NearTargets {
    /// [`NEIGHBOURS`] for each target, the nearest first; itself where there are no more.
    near: Vec<[u32; NEIGHBOURS]>,
    /// Middles, in the order of a tree, and its cuts.
    places: Vec<(DVec3, u32)>,
    cuts: Vec<(u8, f64)>,
}

impl NearTargets {
    /// Finds the neighbours of all targets that take part. O(n log n) for places that are spread
    /// out; of many at one place an arbitrary few are taken.
    pub(super) fn new(tree: &RayTree<'_>) -> Self {
        let count = tree.targets().count();
        let mut near: Vec<[u32; NEIGHBOURS]> = (0..count).map(|t| [t; NEIGHBOURS]).collect();
        let mut places: Vec<(DVec3, u32)> =
            (0..count).filter_map(|t| Some((tree.ball(t)?.center, t))).collect();
        let mut cuts = Vec::new();
        order(&mut places, &mut cuts, 0);
        for &(place, target) in &places {
            let mut nearest = Nearest { of: Some(target), place, found: Vec::new() };
            nearest.search(&places, &cuts, 0);
            for (slot, &(_, other)) in near[target as usize].iter_mut().zip(&nearest.found) {
                *slot = other;
            }
        }
        Self { near, places, cuts }
    }

    /// Returns the targets whose middles are nearest to a point, the nearest first, with the
    /// squares of their distances. O(log n).
    pub(super) fn at(&self, place: DVec3) -> Vec<(f64, u32)> {
        let mut nearest = Nearest { of: None, place, found: Vec::with_capacity(NEIGHBOURS + 1) };
        nearest.search(&self.places, &self.cuts, 0);
        nearest.found
    }

    /// Returns the targets near a target, the nearest first.
    pub(super) fn of(&self, target: u32) -> impl Iterator<Item = u32> + '_ {
        self.near[target as usize].iter().copied().filter(move |&other| other != target)
    }
}

/// Brings places in the order of a tree: each range is halved at its middle along its longest side,
/// which is noted for the range's number. Ranges at the same depth differ in length by one at the
/// most.
fn order(places: &mut [(DVec3, u32)], cuts: &mut Vec<(u8, f64)>, number: usize) {
    if places.len() <= LEAF {
        return;
    }
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = places.iter().fold(none, |(l, h), p| (l.min(p.0), h.max(p.0)));
    let size = high - low;
    let axis = (0..3).fold(0, |best, a| if size[a] > size[best] { a } else { best });
    let half = places.len() / 2;
    // Of equal places the lower number first, so that the order is one.
    places.select_nth_unstable_by(half, |a, b| a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1)));
    if cuts.len() <= number {
        cuts.resize(number + 1, (0, 0.0));
    }
    cuts[number] = (axis as u8, places[half].0[axis]);
    let (below, above) = places.split_at_mut(half);
    order(below, cuts, 2 * number + 1);
    order(above, cuts, 2 * number + 2);
}

/// The nearest found yet, with the squares of their distances, ascending.
struct Nearest {
    /// None of it itself.
    of: Option<u32>,
    place: DVec3,
    found: Vec<(f64, u32)>,
}

impl Nearest {
    fn reach(&self) -> f64 {
        if self.found.len() < NEIGHBOURS { f64::INFINITY } else { self.found[NEIGHBOURS - 1].0 }
    }

    fn search(&mut self, places: &[(DVec3, u32)], cuts: &[(u8, f64)], number: usize) {
        if places.len() <= LEAF {
            for &(place, target) in places {
                let entry = (place.distance_squared(self.place), target);
                // Equal ones by their number, for the order of leaves is no order of theirs.
                let is_before =
                    |a: &(f64, u32)| a.0.total_cmp(&entry.0).then(a.1.cmp(&entry.1)).is_lt();
                if Some(target) != self.of && entry.0 <= self.reach() {
                    let at = self.found.partition_point(is_before);
                    self.found.insert(at, entry);
                    self.found.truncate(NEIGHBOURS);
                }
            }
            return;
        }
        let (axis, at) = cuts[number];
        let (below, above) = places.split_at(places.len() / 2);
        let off = self.place[axis as usize] - at;
        let sides = [(below, 2 * number + 1), (above, 2 * number + 2)];
        let near = usize::from(off >= 0.0);
        self.search(sides[near].0, cuts, sides[near].1);
        if off * off <= self.reach() {
            self.search(sides[1 - near].0, cuts, sides[1 - near].1);
        }
    }
}

#[cfg(test)]
mod tests {
    use cullet::{Instance, Scene, Transform};
    use cullet_testkit::Rng;

    use super::*;
    use crate::sampled::RayTreeOptions;

    #[test]
    fn neighbours_are_the_nearest_of_all() {
        let mut rng = Rng(4);
        let mut scene = Scene::new();
        let ball = scene.add_mesh(cullet_testkit::meshes::ball(4));
        for k in 0..200 {
            // Some at one place.
            let place = if k % 9 == 0 { [1.0; 3] } else { rng.vector(20.0) };
            scene.add(Instance::new(ball, Transform::from_translation(place))).expect("a mesh");
        }
        scene.commit(&cullet::Culler::default());
        let tree = RayTree::new(&scene, &RayTreeOptions::default()).expect("a scene");
        let near = NearTargets::new(&tree);
        let place = |t: u32| tree.ball(t).expect("takes part").center;
        for t in 0..200 {
            let mut all: Vec<(f64, u32)> = (0..200)
                .filter(|&o| o != t)
                .map(|o| (place(o).distance_squared(place(t)), o))
                .collect();
            all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            assert!(near.of(t).eq(all[..NEIGHBOURS].iter().map(|&(_, o)| o)), "{t}");
            let at = near.at(place(t));
            assert!(at.iter().any(|&(far, o)| far == 0.0 && (o == t || t % 9 == 0)), "{t}");
        }
    }
}
