//! Measurement of what flips while the eye trembles, and of the cost of keeping everything still.

use cullet::lod::{LevelEye, Levels, Lod, PixelScale, Selection};
use cullet::view::EyeBall;
use cullet::{Simd, Transform};
use serde::Serialize;

use super::models::{Whole, apart, directions};

/// Distances, in bounding radii.
const RADII: [f64; 4] = [1.5, 2.0, 5.0, 10.0];
/// Eyes at each distance, and places where each trembles to.
const EYES: u32 = 8;
const PLACES: u32 = 16;
/// How far it trembles, as a share of its distance from the model.
const SHARE: f64 = 0.02;

/// View of a model at one pixel by an eye that trembles.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Steady {
    pub(super) radii: f64,
    /// Triangles with a ball of eyes over those without, less 1.
    pub(super) more: f64,
    /// Clusters that came or went from one place to the next, with a ball, and without one.
    pub(super) flips: u64,
    pub(super) flips_without: u64,
}

pub(super) fn tremble(whole: &Whole, levels: &Levels) -> Vec<Steady> {
    RADII.iter().map(|&radii| row(whole, levels, radii)).collect()
}

fn row(whole: &Whole, levels: &Levels, radii: f64) -> Steady {
    let mut row = Steady { radii, ..Steady::default() };
    let mut triangles = [0, 0];
    for direction in directions(EYES) {
        let view = whole.seen(direction, radii);
        let centre = view.eye.unwrap_or_default();
        // The nearest that anything can be.
        let amplitude = SHARE * (apart(centre, whole.middle) - whole.radius);
        let mut ball = EyeBall { centre, radius: amplitude * 1.000_001 };
        let mut before: [Option<Vec<u64>>; 2] = [None, None];
        for place in directions(PLACES) {
            let eye: [f64; 3] = std::array::from_fn(|a| centre[a] + place[a] * amplitude);
            ball = ball.follow(eye, ball.radius);
            let view = PixelScale { eye: Some(eye), ..view };
            let with = [Some(ball), None].map(|b| chosen(levels, &view, b));
            for k in 0..2 {
                triangles[k] += with[k].triangle_count();
                let now = with[k].clusters().to_vec();
                if let Some(before) = &before[k] {
                    let flips =
                        before.iter().zip(&now).map(|(a, b)| u64::from((a ^ b).count_ones()));
                    let all = if k == 0 { &mut row.flips } else { &mut row.flips_without };
                    *all += flips.sum::<u64>();
                }
                before[k] = Some(now);
            }
        }
    }
    row.more = triangles[0] as f64 / triangles[1] as f64 - 1.0;
    row
}

fn chosen(levels: &Levels, view: &PixelScale, ball: Option<EyeBall>) -> Selection {
    let mut selection = Selection::default();
    let eye = LevelEye::new(&Lod::default(), view, &Transform::IDENTITY, ball);
    levels.select(Simd::best(), &eye, &mut selection);
    selection
}
