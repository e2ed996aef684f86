//! Outcodes of what is inspected: beyond which planes of the frustum the corners of the triangle
//! that was clicked lie, and what is left of it when it is cut by them.

use cullet::bounds::Plane;
use cullet::view::FrustumPlane;
use cullet::{Mesh, Transform, View};
use cullet_draw::clip::outcode::{Outcode, OutcodeRegion, OutcodeResult};
use cullet_draw::clip::{Clipper, Region};
use cullet_draw::palette;
use glam::DVec3;

use crate::lines::{Lines, tint, to_world};
use crate::structure::WHOLE;

/// A triangle against the planes of a view.
#[derive(Clone, Debug, PartialEq)]
pub struct Coded {
    /// Its corners, in world space, with their outcodes.
    pub corners: [(DVec3, Outcode); 3],
    /// Classification by outcodes alone.
    pub class: OutcodeResult,
    /// The polygon that clipping leaves of it, in world space.
    pub left: Vec<DVec3>,
    /// The planes that the mesh's box is not proved inside of, with their numbers.
    pub planes: Vec<(usize, Plane)>,
}

/// The planes of an outcode by name; "inside" for none.
#[must_use]
pub fn names(code: u32) -> String {
    let all: Vec<&str> = FrustumPlane::ALL
        .into_iter()
        .filter(|p| code >> *p as u8 & 1 == 1)
        .map(FrustumPlane::name)
        .collect();
    if all.is_empty() { "inside".to_owned() } else { all.join(", ") }
}

impl Coded {
    /// The triangle with an original number; `None` for one that is not there.
    #[must_use]
    pub fn new(view: &View, mesh: &Mesh, transform: &Transform, original: u32) -> Option<Self> {
        let t = mesh.original_triangle().iter().position(|&o| o == original)?;
        let frustum = view.frustum();
        let region = OutcodeRegion::new(&frustum, transform);
        let corners = mesh.corners(t as u32);
        let coded = corners.map(|p| (to_world(transform, p), region.outcode(p)));
        let polygon = coded.map(|(p, _)| p.to_array());
        let left = Clipper::new().clip(&Region::<f64, 3>::from(&frustum), &polygon).to_vec();
        let touched =
            mesh.bounds().corners().iter().fold(0, |or, &p| or | region.outcode(p).not_inside);
        let planes = frustum.planes().filter(|(i, _)| touched >> i & 1 == 1);
        Some(Self {
            class: region.test(&corners),
            corners: coded,
            left: left.into_iter().map(DVec3::from).collect(),
            planes: planes.map(|(i, p)| (i, *p)).collect(),
        })
    }

    /// The classification, in words.
    #[must_use]
    pub fn words(&self) -> String {
        match self.class {
            OutcodeResult::Accepted => "accepted: inside of every plane, no clipping".to_owned(),
            OutcodeResult::Rejected(planes) => {
                format!("rejected: all corners beyond {}", names(planes))
            }
            OutcodeResult::Candidate(planes) => {
                format!("clipped by {}: {} corners are left", names(planes), self.left.len())
            }
        }
    }

    /// Adds the planes as squares beside an instance of this middle and radius, and the triangle
    /// with what is left of it.
    pub fn draw(&self, middle: DVec3, radius: f64, lines: &mut Lines, sides: &mut Lines) {
        let blue = palette::reason_color(Some(cullet::Stage::Frustum));
        for (_, plane) in &self.planes {
            let n = DVec3::from(plane.normal);
            let foot = middle - n * plane.distance(middle);
            let (u, v) = n.any_orthonormal_pair();
            let corner = |a: f64, b: f64| foot + (u * a + v * b) * radius * 1.3;
            let square =
                [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
            for i in 0..4 {
                lines.line(square[i], square[(i + 1) % 4], tint(blue, 220));
            }
            // The normal points out, to what is culled.
            lines.line(foot, foot + n * radius * 0.3, tint(blue, 255));
            sides.triangle([square[0], square[1], square[2]], tint(blue, 36));
            sides.triangle([square[0], square[2], square[3]], tint(blue, 36));
        }
        for i in 0..3 {
            let (a, b) = (self.corners[i].0, self.corners[(i + 1) % 3].0);
            lines.line(a, b, tint(palette::UNSEEN, 255));
        }
        for i in 0..self.left.len() {
            lines.line(self.left[i], self.left[(i + 1) % self.left.len()], tint(WHOLE, 255));
        }
    }
}

#[cfg(test)]
mod tests {

    use super::*;
    use crate::camera::Rig;

    #[test]
    fn what_is_left_of_a_triangle_is_inside_of_the_view() {
        let scene = cullet_scenes::build("solids").expect("built in").scene;
        let (mut accepted, mut rejected, mut cut) = (0, 0, 0);
        for slot in scene.slots() {
            let b = scene.bounds(slot);
            let size = DVec3::from(b.half_extent()).length();
            let rig = Rig { target: b.center(), distance: size * 0.9, fov: 30.0, ..Rig::default() };
            let view = rig.view([64, 48]).expect("a view");
            let frustum = view.frustum();
            let (mesh, transform) = (scene.mesh(slot), scene.transform(slot));
            for &original in mesh.original_triangle().iter().take(400) {
                let coded = Coded::new(&view, mesh, transform, original).expect("there");
                let all_in = coded.corners.iter().all(|(p, _)| frustum.contains(p.to_array()));
                match coded.class {
                    OutcodeResult::Accepted => {
                        assert!(all_in && coded.left.len() == 3);
                        accepted += 1;
                    }
                    OutcodeResult::Rejected(planes) => {
                        assert!(coded.left.is_empty() && planes != 0);
                        rejected += 1;
                    }
                    OutcodeResult::Candidate(_) => cut += 1,
                }
                for p in &coded.left {
                    let worst = frustum.planes().map(|(_, f)| f.distance(p.to_array()));
                    assert!(worst.fold(f64::MIN, f64::max) < size * 1e-9);
                }
                assert!(!coded.words().is_empty());
            }
            assert_eq!(Coded::new(&view, mesh, transform, u32::MAX), None);
        }
        assert!(accepted > 0 && rejected > 0 && cut > 0, "{accepted} {rejected} {cut}");
    }

    #[test]
    fn codes_have_names() {
        assert_eq!(names(0), "inside");
        assert_eq!(names(0b01_0001), "left, near");
    }
}
