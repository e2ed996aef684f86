//! Convex solids in f64, cut by planes.

use cullet::bounds::Plane;
use glam::DVec3;

use crate::winding::{Cut, Winding};

/// A convex solid with a volume.
#[derive(Clone, Debug)]
pub struct Convex {
    /// Each face: its plane, of which the normal points out, and its outline, counter-clockwise
    /// from outside.
    faces: Vec<(Plane, Winding)>,
    /// Corners within so much of a plane are on it.
    on: f64,
}

impl Convex {
    /// Returns the body within a box and planes of unit length. `None` where that has no volume.
    /// Planes that touch it nowhere are left out.
    pub fn new(mut planes: Vec<Plane>, min: [f64; 3], max: [f64; 3], on: f64) -> Option<Self> {
        let whole = Self::of_box(min, max, on)?;
        planes.dedup();
        planes.iter().try_fold(whole, |left, plane| left.cut(plane).1)
    }

    /// A box.
    pub fn of_box(min: [f64; 3], max: [f64; 3], on: f64) -> Option<Self> {
        if !(0..3).all(|a| max[a] - min[a] > on) {
            return None;
        }
        let face = |i: usize| {
            let (axis, high) = (i / 2, i % 2 == 1);
            let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
            let mut normal = [0.0; 3];
            normal[axis] = if high { 1.0 } else { -1.0 };
            let corner = |a: bool, b: bool| {
                let mut p = if high { max } else { min };
                p[u] = if a { max[u] } else { min[u] };
                p[v] = if b { max[v] } else { min[v] };
                DVec3::from(p)
            };
            let round = [(false, false), (true, false), (true, true), (false, true)];
            let outline = Winding(round.map(|(a, b)| corner(a, b)).to_vec());
            let d = if high { max[axis] } else { -min[axis] };
            (Plane::new(normal, d), if high { outline } else { outline.reversed() })
        };
        Some(Self { faces: (0..6).map(face).collect(), on })
    }

    /// Its faces: planes that point out, and outlines.
    pub fn faces(&self) -> impl Iterator<Item = (&Plane, &[DVec3])> {
        self.faces.iter().map(|(plane, outline)| (plane, &outline.0[..]))
    }

    /// The parts in front of a plane of unit length and behind it; `None` where there is nothing,
    /// or a sliver.
    pub fn cut(&self, plane: &Plane) -> (Option<Self>, Option<Self>) {
        let heights = self.corners().map(|p| plane.distance(p));
        let (low, high) =
            heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), d| (l.min(d), h.max(d)));
        if high <= self.on {
            return (None, Some(self.clone()));
        }
        if low >= -self.on {
            return (Some(self.clone()), None);
        }
        let (mut front, mut back) = (Vec::new(), Vec::new());
        for (side, outline) in &self.faces {
            match outline.cut_within(plane, self.on) {
                Cut::Front => front.push((*side, outline.clone())),
                Cut::Back => back.push((*side, outline.clone())),
                // It would lie on the border: then nothing is on one side, which was seen above.
                Cut::On => {}
                Cut::Both(before, behind) => {
                    front.push((*side, before));
                    back.push((*side, behind));
                }
            }
        }
        let (centre, reach) = self.middle();
        let mut cap = Some(Winding::square(plane, centre, reach));
        for (side, _) in &self.faces {
            cap = cap.and_then(|cap| cap.behind_within(side, self.on));
        }
        if let Some(cap) = cap {
            let flipped = plane.flipped();
            front.push((flipped, cap.clone().reversed()));
            back.push((*plane, cap));
        }
        let solid = |faces| Self { faces, on: self.on }.kept();
        (solid(front), solid(back))
    }

    /// Returns what is inside this body and outside `other`, in parts that share at most their
    /// borders.
    pub fn without(&self, other: &Self) -> Vec<Self> {
        let mut parts = Vec::new();
        let mut rest = Some(self.clone());
        for (plane, _) in &other.faces {
            let Some(whole) = rest.take() else { return parts };
            let (front, back) = whole.cut(plane);
            parts.extend(front);
            rest = back;
        }
        // Apart altogether: as it was.
        if rest.is_none() { vec![self.clone()] } else { parts }
    }

    /// Corners, each once for each face.
    pub fn corners(&self) -> impl Iterator<Item = DVec3> {
        self.faces.iter().flat_map(|(_, outline)| outline.0.iter().copied())
    }

    /// Lowest and highest corner.
    pub fn bounds(&self) -> Option<[[f64; 3]; 2]> {
        let mut corners = self.corners();
        let first = corners.next()?;
        let [low, high] = corners.fold([first; 2], |[l, h], p| [l.min(p), h.max(p)]);
        Some([low.into(), high.into()])
    }

    /// The mean of its corners, and how far from there any is.
    pub fn middle(&self) -> (DVec3, f64) {
        let count = self.corners().count().max(1) as f64;
        let middle = self.corners().sum::<DVec3>() / count;
        (middle, self.corners().map(|p| p.distance(middle)).fold(0.0, f64::max) + self.on)
    }

    /// Its volume.
    pub fn volume(&self) -> f64 {
        let (middle, _) = self.middle();
        let cone = |(plane, outline): &(Plane, Winding)| {
            -plane.distance(middle) * outline.area().length() / 6.0
        };
        self.faces.iter().map(cone).sum()
    }

    /// Itself, without faces that have no area, if it has a volume.
    fn kept(mut self) -> Option<Self> {
        self.faces.retain(|(_, outline)| outline.0.len() >= 3 && outline.width() > self.on);
        if self.faces.len() < 4 {
            return None;
        }
        let (middle, _) = self.middle();
        let is_inside = self.faces.iter().all(|(plane, _)| plane.distance(middle) < -self.on * 0.5);
        is_inside.then_some(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit() -> Convex {
        Convex::of_box([0.0; 3], [2.0, 3.0, 4.0], 1e-6).unwrap()
    }

    #[test]
    fn parts_have_the_volume_of_the_whole() {
        let whole = unit();
        assert!((whole.volume() - 24.0).abs() < 1e-9);
        let slanted = Plane::new([0.6, 0.8, 0.0], 1.7);
        let (Some(front), Some(back)) = whole.cut(&slanted) else { panic!("it is cut") };
        assert!((front.volume() + back.volume() - 24.0).abs() < 1e-9);
        assert!(front.corners().all(|p| slanted.distance(p) > -1e-6));
        assert!(back.corners().all(|p| slanted.distance(p) < 1e-6));
        assert!(whole.cut(&Plane::new([1.0, 0.0, 0.0], 2.0)).0.is_none());
        assert!(whole.cut(&Plane::new([1.0, 0.0, 0.0], -1.0)).1.is_none());
    }

    #[test]
    fn what_is_taken_away_is_gone() {
        let whole = unit();
        let hole = Convex::of_box([0.5; 3], [1.0, 1.0, 9.0], 1e-6).unwrap();
        let left: f64 = whole.without(&hole).iter().map(Convex::volume).sum();
        assert!((left - (24.0 - 0.25 * 3.5)).abs() < 1e-9, "{left}");
        let apart = Convex::of_box([5.0; 3], [6.0; 3], 1e-6).unwrap();
        assert_eq!(whole.without(&apart).len(), 1);
        assert!(whole.without(&whole).is_empty());
    }

    #[test]
    fn planes_that_leave_nothing_make_no_solid() {
        let none = [Plane::new([1.0, 0.0, 0.0], 0.0), Plane::new([-1.0, 0.0, 0.0], 0.0)];
        assert!(Convex::new(none.to_vec(), [-9.0; 3], [9.0; 3], 1e-6).is_none());
        let thin = [Plane::new([1.0, 0.0, 0.0], 1.0), Plane::new([-1.0, 0.0, 0.0], -0.5)];
        let slab = Convex::new(thin.to_vec(), [-1.0; 3], [1.0; 3], 1e-6).unwrap();
        assert!((slab.volume() - 2.0).abs() < 1e-9);
        let [low, _] = slab.bounds().unwrap();
        assert!((low[0] - 0.5).abs() < 1e-9 && (low[1] + 1.0).abs() < 1e-9);
    }
}
