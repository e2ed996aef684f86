//! The colours of every picture: one table, one meaning a colour.
//!
//! | colour | meaning |
//! |---|---|
//! | cream, [`SEEN`] | kept, and seen |
//! | yellow, [`UNSEEN`] | kept for want of proof: straddling, not covered, or kept though no pixel shows it |
//! | [`reason_color`] | dropped, by the stage: blue outside the frustum, vermilion hidden, pink facing away, … |
//! | green, [`PROVED`] | proved: wholly inside, accepted, covered |
//! | dark blue, [`SUBJECT`] | what a diagram is about: the cluster, the segment, the polygon |
//! | ink or chalk, [`INK`], [`CHALK`] | the eye, its frustum, lines of sight, and words |
//! | crimson, [`LOST`] | wrong: lost though it is visible |
//!
//! Most hues are those of Okabe & Ito, *Color Universal Design* (2008), told apart by people with
//! any of the common kinds of colour blindness; pictures carry a legend with words besides.

use cullet::Stage;

/// Instances and triangles that are kept and own a pixel.
pub const SEEN: [u8; 3] = [0xF6, 0xF2, 0xE8];
/// Triangles that are kept for lack of proof, or though no pixel shows them: the cost of being
/// conservative.
pub const UNSEEN: [u8; 3] = [0xF2, 0xCC, 0x0C];
/// Certain results of a test: wholly inside, accepted, covered.
pub const PROVED: [u8; 3] = [0x00, 0x9E, 0x73];
/// The subject of a diagram, where that has no fate yet.
pub const SUBJECT: [u8; 3] = [0x00, 0x72, 0xB2];
/// Triangles dropped by an unknown stage.
pub const DROPPED: [u8; 3] = [0x60, 0x66, 0x6E];
/// False culls: visible, but dropped. No picture of a sound culler has this colour.
pub const LOST: [u8; 3] = [0xFF, 0x00, 0x3C];
/// The background of maps.
pub const NIGHT: [u8; 3] = [0x15, 0x19, 0x1F];
/// Text and outlines on it.
pub const CHALK: [u8; 3] = [0xE4, 0xE7, 0xEA];
/// The background of light legends.
pub const PAPER: [u8; 3] = [0xFB, 0xFA, 0xF7];
/// Text and outlines on it.
pub const INK: [u8; 3] = [0x22, 0x26, 0x2B];

/// Colours of neighbours, taken in turn.
pub const NEIGHBOURS: [[u8; 3]; 8] = [
    [0xE6, 0x9F, 0x00],
    [0x56, 0xB4, 0xE9],
    [0x00, 0x9E, 0x73],
    [0xF0, 0xE4, 0x42],
    [0x00, 0x72, 0xB2],
    [0xD5, 0x5E, 0x00],
    [0xCC, 0x79, 0xA7],
    [0xB4, 0xB0, 0xA6],
];

/// The colour of what a stage dropped; of what is kept and seen for `None`.
#[must_use]
pub const fn reason_color(stage: Option<Stage>) -> [u8; 3] {
    match stage {
        None => SEEN,
        Some(Stage::Layer) => [0x8C, 0x93, 0x9B],
        Some(Stage::Frustum) => [0x56, 0xB4, 0xE9],
        Some(Stage::Pvs) => [0x7F, 0xE8, 0x2E],
        Some(Stage::Portal) => [0x0F, 0x6B, 0x75],
        Some(Stage::Detail) => [0x6A, 0x3D, 0x9A],
        Some(Stage::Lod) => [0x7F, 0x8F, 0x2F],
        Some(Stage::Occlusion) => [0xD5, 0x5E, 0x00],
        Some(Stage::Backface) => [0xCC, 0x79, 0xA7],
        Some(Stage::Degenerate) => [0x6E, 0x4A, 0x2F],
    }
}

/// Label of a stage in a legend.
#[must_use]
pub const fn reason_label(stage: Option<Stage>) -> &'static str {
    match stage {
        None => "seen",
        Some(Stage::Layer) => "in no layer of the view",
        Some(Stage::Frustum) => "outside the frustum",
        Some(Stage::Pvs) => "never seen from here",
        Some(Stage::Portal) => "behind no open portal",
        Some(Stage::Detail) => "too small",
        Some(Stage::Lod) => "another level of detail",
        Some(Stage::Occlusion) => "hidden behind others",
        Some(Stage::Backface) => "facing away",
        Some(Stage::Degenerate) => "without area",
    }
}

/// The colour of a level of detail: [`SEEN`] in full, then one for each time that it was
/// simplified, up to twelve; neighbours are told apart by lightness too. Coarser ones have the
/// last.
#[must_use]
pub const fn level_color(step: u32) -> [u8; 3] {
    const COLORS: [[u8; 3]; 13] = [
        SEEN,
        [0x56, 0xB4, 0xE9],
        [0x00, 0x72, 0xB2],
        [0x00, 0x9E, 0x73],
        [0x9B, 0xD7, 0x70],
        [0xF0, 0xE4, 0x42],
        [0xE6, 0x9F, 0x00],
        [0xD5, 0x5E, 0x00],
        [0xE3, 0x9B, 0xBF],
        [0xA2, 0x4A, 0x8C],
        [0x6A, 0x3D, 0x9A],
        [0x8A, 0x6A, 0x4A],
        [0x45, 0x4B, 0x54],
    ];
    COLORS[if step < 12 { step as usize } else { 12 }]
}

/// A colour for a material that has none: of stone, sand, slate and the like, ten of them in turn.
#[must_use]
pub const fn material_color(n: u32) -> [u8; 3] {
    const COLORS: [[u8; 3]; 10] = [
        [0xB4, 0xB0, 0xA6],
        [0xD8, 0xC3, 0x9B],
        [0xC0, 0x7F, 0x5B],
        [0x7C, 0x9A, 0x85],
        [0x8E, 0xA5, 0xBC],
        [0xCB, 0xAA, 0x6A],
        [0xA5, 0x8D, 0x9E],
        [0x9A, 0xA8, 0x6B],
        [0xD0, 0xB7, 0xA8],
        [0x6F, 0x86, 0x97],
    ];
    COLORS[n as usize % COLORS.len()]
}

/// A colour for a share of 0..1, dark to light, even in lightness and safe for the colour-blind: an
/// approximation of *inferno* by N. Smith and S. van der Walt (2015) through eight of its points.
/// NaN is 0.
#[must_use]
pub fn heat(share: f64) -> [u8; 3] {
    const POINTS: [[u8; 3]; 8] = [
        [0, 0, 4],
        [40, 11, 84],
        [101, 21, 110],
        [159, 42, 99],
        [212, 72, 66],
        [245, 125, 21],
        [250, 193, 39],
        [252, 255, 164],
    ];
    let t = if share > 0.0 { share.min(1.0) } else { 0.0 } * 7.0;
    let i = (t as usize).min(6);
    mix(POINTS[i], POINTS[i + 1], t - i as f64)
}

/// A colour between two: `a` at 0, `b` at 1.
#[must_use]
pub fn mix(a: [u8; 3], b: [u8; 3], t: f64) -> [u8; 3] {
    std::array::from_fn(|i| (f64::from(a[i]) * (1.0 - t) + f64::from(b[i]) * t).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// CIE L*a*b* under D65, in which a distance of some 2 is just seen.
    fn lab(rgb: [u8; 3]) -> [f64; 3] {
        let [r, g, b] = rgb.map(|v| {
            let s = f64::from(v) / 255.0;
            if s <= 0.040_45 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
        });
        let f = |t: f64| if t > 0.008_856 { t.cbrt() } else { 7.787 * t + 16.0 / 116.0 };
        let x = f((0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505);
        let y = f(0.2126 * r + 0.7152 * g + 0.0722 * b);
        let z = f((0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089);
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    fn apart(a: [u8; 3], b: [u8; 3]) -> f64 {
        let (a, b) = (lab(a), lab(b));
        (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
    }

    #[test]
    fn levels_next_to_each_other_are_told_apart() {
        for step in 0..12 {
            let [a, b] = [step, step + 1].map(level_color);
            assert!(apart(a, b) > 20.0, "{step}: {}", apart(a, b));
        }
        assert_eq!(level_color(12), level_color(u32::MAX));
    }

    #[test]
    fn no_two_meanings_look_alike() {
        let stages = Stage::ALL.into_iter().map(|s| (s.name(), reason_color(Some(s))));
        let others = [
            ("seen", SEEN),
            ("unseen", UNSEEN),
            ("proved", PROVED),
            ("subject", SUBJECT),
            ("lost", LOST),
        ];
        let all: Vec<_> = stages.chain(others).collect();
        for (i, a) in all.iter().enumerate() {
            for b in &all[..i] {
                assert!(apart(a.1, b.1) > 25.0, "{} and {}: {}", a.0, b.0, apart(a.1, b.1));
            }
        }
        // Colours side by side in a picture of a scene must be told apart in sun and shade.
        let hidden = reason_color(Some(Stage::Occlusion));
        assert!(apart(UNSEEN, hidden) > 50.0);
        assert!(apart(mix(UNSEEN, INK, 0.5), mix(hidden, INK, 0.5)) > 25.0);
    }

    #[test]
    fn every_reason_has_a_label_of_its_own() {
        let all: Vec<Option<Stage>> =
            std::iter::once(None).chain(Stage::ALL.into_iter().map(Some)).collect();
        for (i, &a) in all.iter().enumerate() {
            assert!(all[..i].iter().all(|&b| reason_label(a) != reason_label(b)));
        }
    }

    #[test]
    fn heat_grows_lighter() {
        let light = |c: [u8; 3]| u32::from(c[0]) * 2 + u32::from(c[1]) * 4 + u32::from(c[2]);
        for i in 0..50 {
            assert!(light(heat(f64::from(i) / 50.0)) < light(heat(f64::from(i + 1) / 50.0)));
        }
        assert_eq!(heat(f64::NAN), heat(0.0));
        assert_eq!(heat(9.0), heat(1.0));
    }
}
