//! The clipping playground: a polygon that the user draws, cut by a convex window one plane after
//! another, as Sutherland & Hodgman do. What cuts is [`cullet_draw::clip`]; here is only who came
//! from where.

use cullet_draw::clip::outcode::{Outcode, OutcodeResult};
use cullet_draw::clip::{Clipper, HalfSpace, Region, Vertex};
use serde::{Deserialize, Serialize};

/// The most corners that a polygon of the playground has.
pub const MOST_CORNERS: usize = 12;
/// The numbers of sides that a window may have.
pub const SIDES: std::ops::RangeInclusive<u32> = 3..=8;

/// Settings of the clipping playground.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Clipping {
    /// Whether it is open.
    pub open: bool,
    /// The polygon, in a square from −1 to 1, y up.
    pub polygon: Vec<[f64; 2]>,
    /// How many sides the window has.
    pub sides: u32,
    /// How many planes have cut.
    pub step: u32,
}

impl Default for Clipping {
    fn default() -> Self {
        Self {
            open: false,
            polygon: vec![[-0.9, -0.2], [0.1, -0.85], [0.9, 0.1], [0.25, 0.2], [-0.1, 0.9]],
            sides: 4,
            step: 0,
        }
    }
}

impl Clipping {
    /// Checks every number; the error names the invalid one, its value, and what it must be.
    ///
    /// # Errors
    /// If a number is not finite or out of its range.
    pub fn check(&self) -> Result<(), (&'static str, f64, &'static str)> {
        let corners = self.polygon.len();
        if !(3..=MOST_CORNERS).contains(&corners) {
            return Err(("the corners of clipping.polygon", corners as f64, "between 3 and 12"));
        }
        for v in self.polygon.iter().flatten() {
            if !(-1.0..=1.0).contains(v) {
                return Err(("clipping.polygon", *v, "between -1 and 1"));
            }
        }
        if !SIDES.contains(&self.sides) {
            return Err(("clipping.sides", f64::from(self.sides), "between 3 and 8"));
        }
        if self.step > self.sides {
            return Err(("clipping.step", f64::from(self.step), "at most the window's sides"));
        }
        Ok(())
    }

    /// The corners of the window, counter-clockwise; plane i goes from corner i to the next.
    #[must_use]
    pub fn window(&self) -> Vec<[f64; 2]> {
        let n = f64::from(self.sides.clamp(*SIDES.start(), *SIDES.end()));
        // A square stands on a side: the first side is at the bottom.
        let start = -std::f64::consts::FRAC_PI_2 - std::f64::consts::PI / n;
        (0..n as u32)
            .map(|i| {
                let (sin, cos) = (start + f64::from(i) / n * std::f64::consts::TAU).sin_cos();
                [cos * 0.72, sin * 0.72]
            })
            .collect()
    }

    /// The window's planes, pointing out, plane i as bit i of outcodes.
    #[must_use]
    pub fn region(&self) -> Region<f64, 2> {
        let corners = self.window();
        let mut region = Region::everything();
        for (i, a) in corners.iter().enumerate() {
            let b = corners[(i + 1) % corners.len()];
            // To the right of a counter-clockwise edge is out.
            let normal = [b[1] - a[1], a[0] - b[0]];
            if let Ok(side) = HalfSpace::new(normal, normal[0] * a[0] + normal[1] * a[1]) {
                // At most eight of 32: there is room.
                let _ = region.push(side);
            }
        }
        region
    }

    /// Classifies the polygon by its outcodes alone. It need not be convex: all of it is inside a
    /// plane that all its corners are inside of.
    #[must_use]
    pub fn classify(&self) -> OutcodeResult {
        let region = self.region();
        OutcodeResult::of(self.polygon.iter().map(|p| {
            let code = region.outcode(p);
            Outcode { outside: code, not_inside: code }
        }))
    }

    /// The polygon as it came, and as it is after each plane.
    #[must_use]
    pub fn steps(&self) -> Vec<Vec<Corner>> {
        let region = self.region();
        let mut clipper = Clipper::new();
        let came = self.polygon.iter().zip(0..);
        let mut polygon: Vec<Corner> = came
            .map(|(&at, i)| Corner { at, code: region.outcode(&at), from: From::Input(i) })
            .collect();
        let mut steps = vec![polygon.clone()];
        for plane in 0..self.sides {
            let one = region.clone().only(1 << plane);
            polygon = clipper.clip(&one, &polygon).to_vec();
            for corner in &mut polygon {
                if corner.from == From::Fresh {
                    corner.from = From::Cut(plane);
                    // Rounding may leave it a little outside of the planes that have cut; it counts
                    // as on them.
                    corner.code = region.outcode(&corner.at) & !((2 << plane) - 1);
                }
            }
            steps.push(polygon.clone());
        }
        steps
    }

    /// Adds a corner in the middle of the longest edge; nothing where there are as many as there
    /// may be.
    pub fn add_corner(&mut self) {
        let n = self.polygon.len();
        let long = |i: usize| {
            let (a, b) = (self.polygon[i], self.polygon[(i + 1) % n]);
            (a[0] - b[0]).hypot(a[1] - b[1])
        };
        let longest = (0..n).max_by(|&i, &j| long(i).total_cmp(&long(j)));
        if let Some(i) = longest.filter(|_| n < MOST_CORNERS) {
            let (a, b) = (self.polygon[i], self.polygon[(i + 1) % n]);
            let middle = std::array::from_fn(|k| round((a[k] + b[k]) * 0.5));
            self.polygon.insert(i + 1, middle);
        }
    }

    /// Moves a corner, within the square and to a hundredth, so that links stay short.
    pub fn drag(&mut self, corner: usize, to: [f64; 2]) {
        if let Some(p) = self.polygon.get_mut(corner).filter(|_| to.iter().all(|v| v.is_finite())) {
            *p = to.map(|v| round(v.clamp(-1.0, 1.0)));
        }
    }
}

fn round(v: f64) -> f64 {
    (v * 100.0).round() / 100.0
}

/// Where a corner of a polygon that is being cut comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum From {
    /// It is this corner of the polygon that came.
    Input(u32),
    /// It was made by this plane.
    Cut(u32),
    /// It was made by the plane that cuts just now.
    Fresh,
}

/// A corner of a polygon that is being cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// Where it is.
    pub at: [f64; 2],
    /// Bit i: it is outside of plane i.
    pub code: u32,
    /// Where it comes from.
    pub from: From,
}

impl Vertex<f64, 2> for Corner {
    fn position(&self) -> [f64; 2] {
        self.at
    }

    fn between(&self, to: &Self, t: f64) -> Self {
        let at = Vertex::<f64, 2>::between(&self.at, &to.at, t);
        Self { at, code: self.code & to.code, from: From::Fresh }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn area(polygon: &[[f64; 2]]) -> f64 {
        let next = polygon.iter().cycle().skip(1);
        polygon.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>() * 0.5
    }

    #[test]
    fn the_window_is_convex_and_holds_its_middle() {
        for sides in SIDES {
            let c = Clipping { sides, ..Clipping::default() };
            assert_eq!(c.region().present(), (1 << sides) - 1);
            assert_eq!(c.region().outcode(&[0.0, 0.0]), 0);
            assert!(area(&c.window()) > 0.6);
        }
        // A square's sides are level and upright.
        let square = Clipping::default().window();
        assert!((square[0][1] - square[1][1]).abs() < 1e-12 && square[0][0] < square[1][0]);
    }

    #[test]
    fn the_first_step_is_what_came_and_what_each_plane_left_is_inside_of_it() {
        let c = Clipping::default();
        let steps = c.steps();
        assert_eq!(steps.len(), 5);
        assert_eq!(steps[0].iter().map(|p| p.at).collect::<Vec<_>>(), c.polygon);
        assert!(steps[4].iter().any(|p| matches!(p.from, From::Cut(_))));
        assert!(steps[4].iter().all(|p| p.code == 0), "all that is left is inside");
        assert!(matches!(c.classify(), OutcodeResult::Candidate(_)));
        let left = |i: usize| area(&steps[i].iter().map(|p| p.at).collect::<Vec<_>>());
        assert!((1..5).all(|i| left(i) <= left(i - 1) + 1e-12) && left(4) < left(0));
    }

    #[test]
    fn outcodes_decide_what_is_wholly_in_or_out() {
        let inside = vec![[-0.1, -0.1], [0.1, -0.1], [0.0, 0.1]];
        let c = Clipping { polygon: inside, ..Clipping::default() };
        assert_eq!(c.classify(), OutcodeResult::Accepted);
        assert_eq!(c.steps()[4], c.steps()[0]);
        let below = vec![[-0.5, -0.9], [0.5, -0.9], [0.0, -0.8]];
        let c = Clipping { polygon: below, ..Clipping::default() };
        assert_eq!(c.classify(), OutcodeResult::Rejected(1));
        assert!(c.steps()[1].is_empty());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(128))]

        #[test]
        fn one_plane_at_a_time_is_what_the_clipper_does_at_once(
            polygon in prop::collection::vec(prop::array::uniform2(-1.0..=1.0f64), 3..=MOST_CORNERS),
            sides in SIDES,
        ) {
            let c = Clipping { polygon, sides, ..Clipping::default() };
            prop_assert!(c.check().is_ok());
            let steps = c.steps();
            let last: Vec<[f64; 2]> = steps.last().expect("one").iter().map(|p| p.at).collect();
            let mut clipper = Clipper::new();
            let at_once = clipper.clip(&c.region(), &c.polygon).to_vec();
            prop_assert!((area(&last) - area(&at_once)).abs() < 1e-9);
            for p in &last {
                let worst = c.region().sides().map(|(_, s)| s.height(p)).fold(f64::MIN, f64::max);
                prop_assert!(worst < 1e-9, "{p:?} is outside by {worst}");
            }
        }

        #[test]
        fn dragging_leaves_what_a_link_may_hold(
            corner in 0..20usize, to in prop::array::uniform2(prop::num::f64::ANY),
        ) {
            let mut c = Clipping::default();
            c.drag(corner, to);
            for _ in 0..20 {
                c.add_corner();
            }
            prop_assert!(c.check().is_ok());
            prop_assert_eq!(c.polygon.len(), MOST_CORNERS);
        }
    }
}
