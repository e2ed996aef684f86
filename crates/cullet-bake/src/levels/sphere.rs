//! Spheres around points and spheres.

use glam::DVec3;

/// A sphere: middle and radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ball {
    pub(crate) centre: [f32; 3],
    pub(crate) radius: f32,
}

/// How often the middle moves towards what is farthest. With 20 steps the radius is within some 5 %
/// of the least.
const STEPS: usize = 20;

/// A sphere around spheres (points where the radius is 0), nearly the smallest; 0 around none.
/// Encloses them by more than rounding. Bădoiu & Clarkson, *Smaller Core-Sets for Balls*, 2003.
pub(crate) fn around(balls: &[Ball]) -> Ball {
    let point = |b: &Ball| DVec3::from_array(b.centre.map(f64::from));
    let points: Vec<DVec3> = balls.iter().map(point).collect();
    let are_points = balls.iter().all(|b| b.radius == 0.0);
    let farthest = |c: DVec3| {
        if are_points {
            let far = |best: (f64, usize), (i, p): (usize, &DVec3)| {
                let r = (*p - c).length_squared();
                if r > best.0 { (r, i) } else { best }
            };
            let (squared, at) = points.iter().enumerate().fold((0.0, 0), far);
            return (squared.sqrt(), at);
        }
        let reach = |b: &Ball| (point(b) - c).length() + f64::from(b.radius);
        let far = |best: (f64, usize), (i, b): (usize, &Ball)| {
            let r = reach(b);
            if r > best.0 { (r, i) } else { best }
        };
        balls.iter().enumerate().fold((0.0, 0), far)
    };
    let Some(first) = balls.first() else { return Ball { centre: [0.0; 3], radius: 0.0 } };
    // From the middle of the box.
    let (mut low, mut high) = (point(first), point(first));
    for b in balls {
        let r = DVec3::splat(f64::from(b.radius));
        (low, high) = (low.min(point(b) - r), high.max(point(b) + r));
    }
    let mut centre = (low + high) * 0.5;
    let mut best = (farthest(centre).0, centre);
    for step in 1..=STEPS {
        let (reach, at) = farthest(centre);
        if reach < best.0 {
            best = (reach, centre);
        }
        let ball = &balls[at];
        let to = point(ball) - centre;
        let apart = to.length();
        if apart <= 0.0 {
            break;
        }
        // Towards the farthest point of the farthest sphere.
        centre += to / apart * (reach / (step as f64 + 1.0));
    }
    let centre = best.1.as_vec3();
    let reach = farthest(centre.as_dvec3()).0;
    // More than the rounding of a sum and of a root, so that it also encloses them in f64
    // arithmetic.
    Ball { centre: centre.to_array(), radius: (reach * (1.0 + 1e-12)).next_up() as f32 }
        .grown(reach)
}

impl Ball {
    /// The radius as the next f32 that is not below the reach.
    fn grown(mut self, reach: f64) -> Self {
        while f64::from(self.radius) < reach * (1.0 + 1e-12) {
            self.radius = self.radius.next_up();
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_testkit::{Rng, cases};

    #[test]
    fn it_encloses_and_is_nearly_the_smallest() {
        let mut rng = Rng(3);
        for _ in 0..cases(200) {
            let n = rng.index(12) + 1;
            let mut at = || rng.range(-5.0, 9.0) as f32;
            let balls: Vec<Ball> = (0..n)
                .map(|_| Ball { centre: [at(), at(), at()], radius: at().max(0.0) })
                .collect();
            let sphere = around(&balls);
            let point = |b: &Ball| DVec3::from_array(b.centre.map(f64::from));
            for b in &balls {
                let reach = (point(b) - point(&sphere)).length() + f64::from(b.radius);
                assert!(reach <= f64::from(sphere.radius));
            }
            // No sphere is smaller than half of the largest distance across two.
            let mut least = 0.0_f64;
            for a in &balls {
                for b in &balls {
                    let across = (point(a) - point(b)).length() + f64::from(a.radius + b.radius);
                    least = least.max(across / 2.0);
                }
            }
            assert!(f64::from(sphere.radius) <= least * 1.18 + 1e-6, "{sphere:?} {least}");
        }
        let one = Ball { centre: [1.0, 2.0, 3.0], radius: 0.0 };
        assert_eq!(around(&[one; 3]).centre, one.centre);
        assert_eq!(around(&[]).radius, 0.0);
    }
}
