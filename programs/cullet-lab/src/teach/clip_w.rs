//! Clipping and the divide: why the order matters, and where each test has its place.

use cullet::Depth;
use cullet_draw::clip::{line, space};

use super::KEPT;
use super::sheet::Sheet;
use cullet_draw::Picture;
use cullet_draw::picture::palette::{INK, LOST, PAPER, PROVED, SUBJECT, mix};

/// A segment whose second end is behind the eye, seen from above; what the screen shows of it when
/// it is divided first, and when it is clipped first. All numbers are those of the library's clip
/// space. `size` is at least 640 × 360.
#[must_use]
pub fn clip_w(size: [u32; 2]) -> Picture {
    // In the plane of x and w: the eye at the origin, w the distance in front of it, the screen at
    // w = 1.
    const NEAR: f64 = 0.4;
    const A: [f64; 2] = [-0.9, 2.0];
    const B: [f64; 2] = [1.3, -0.9];
    let mut sheet = Sheet::new(size);
    sheet.title("A segment that goes behind the eye");
    sheet.legend(&[
        (SUBJECT, "the segment"),
        (INK, "lines through the eye"),
        (LOST, "shown: wrong"),
        (PROVED, "shown: right"),
    ]);
    let [w, _] = sheet.size();
    let [top, bottom] = sheet.room();
    let em = sheet.text_size();
    // z so that the near plane is z = 0 and z = w far away.
    let lift = |[x, w]: [f64; 2]| [x, 0.0, w - NEAR, w];
    let [a, b] = [A, B].map(lift);
    let cut = space::near::<f64>(Depth::Standard).clip_line(&a, &b);
    let scale = ((w * 0.5 - 40.0) / 4.4).min((bottom - top - 2.5 * em) / 3.2);
    for (column, clipped) in [(0.25, false), (0.75, true)] {
        let c = [w * column, top + scale * 2.15];
        let at = |[x, w]: [f64; 2]| [c[0] + x * scale, c[1] - w * scale];
        let sight = |p: [f64; 2]| [p[0] / p[1], 1.0];
        // The view: what has −w ≤ x ≤ w.
        let view = [[-NEAR, NEAR], [NEAR, NEAR], [2.1, 2.1], [-2.1, 2.1]].map(at);
        sheet.fill(&view, mix(KEPT, PAPER, 0.3), 1.0);
        let thin = mix(INK, PAPER, 0.5);
        for s in [-1.0, 1.0] {
            sheet.line(at([0.0, 0.0]), at([2.1 * s, 2.1]), 1.0, thin);
        }
        sheet.line(at([-2.1, NEAR]), at([2.1, NEAR]), 1.4, INK);
        sheet.text([at([-2.1, NEAR])[0], at([0.0, NEAR])[1] + 6.0], "near", INK);
        sheet.line(at([-2.1, 1.0]), at([2.1, 1.0]), 1.4, INK);
        sheet.text([at([-2.1, 1.0])[0], at([0.0, 1.0])[1] - em], "screen", INK);
        sheet.line(at([-2.1, 0.0]), at([2.1, 0.0]), 1.0, thin);
        sheet.text([at([1.5, 0.0])[0], at([0.0, 0.0])[1] - em], "w = 0", thin);
        sheet.line(at(A), at(B), 2.0, mix(SUBJECT, PAPER, 0.4));
        let (ends, color) = if clipped {
            let t = cut.unwrap_or([0.0, 1.0]);
            let ends = t.map(|t| line::at(&a, &b, t)).map(|[x, _, _, w]| [x, w]);
            sheet.line(at(ends[0]), at(ends[1]), 4.0, SUBJECT);
            (ends, PROVED)
        } else {
            ([A, B], LOST)
        };
        // The segment on the screen between the two divided ends.
        let shown = ends.map(sight);
        for (end, shown) in ends.into_iter().zip(shown) {
            sheet.line(at(end), at(shown), 1.2, INK);
        }
        sheet.line(at(shown[0]), at(shown[1]), 7.0, color);
        for (name, end) in ["A", "B"].into_iter().zip([A, B]) {
            let [x, y] = at(end);
            sheet.disc([x, y], 5.0, SUBJECT);
            sheet.text([x + 10.0, y - 6.0], name, INK);
        }
        for (i, shown) in shown.into_iter().enumerate() {
            let [x, y] = at(shown);
            sheet.disc([x, y], 5.0, INK);
            let name = match (i, clipped) {
                (0, _) => "A'",
                (_, true) => "C'",
                _ => "B'",
            };
            sheet.text([x - 8.0, y - em - 4.0], name, INK);
        }
        if clipped {
            let [x, y] = at(ends[1]);
            sheet.disc([x, y], 5.0, PROVED);
            sheet.text([x + 10.0, y + 4.0], "C", INK);
        }
        sheet.disc(at([0.0, 0.0]), 5.0, INK);
        sheet.text([at([0.0, 0.0])[0] - 50.0, at([0.0, 0.0])[1] + 8.0], "eye", INK);
        let words = if clipped {
            "clipped, then divided: C stands for B"
        } else {
            "divided first: B' is on the wrong side"
        };
        sheet.centred([c[0], bottom - em], words, INK);
    }
    sheet.finish()
}

/// A test in its box: what it is, the benchmark that knows its cost, and what that is the cost of.
type Test = (&'static str, &'static str, &'static str);

const SPACES: [(&str, &str, &[Test]); 4] = [
    (
        "object",
        "before any transform",
        &[
            ("outcodes", "clip/sort/1e5", "triangle"),
            ("back faces: planes", "backface/planes16/1e5/mask", "triangle"),
            ("back faces: masks", "backface/masks/1e5/mask", "triangle"),
            ("clusters: cones", "backface/clusters/elliptic8/mask", "cluster"),
            ("degenerate, cut-aways", "", ""),
        ],
    ),
    (
        "world, eye",
        "after the model matrix",
        &[
            ("layers, size", "", ""),
            ("frustum: boxes", "frustum/boxes/1e5/30%", "box"),
            ("frustum: spheres", "frustum/spheres/1e5/30%", "sphere"),
            ("clip, then project", "clip/place/world", "triangle"),
        ],
    ),
    (
        "clip",
        "projected, not divided",
        &[
            ("winding by x, y, w", "", ""),
            ("project, then clip", "clip/place/clip-space", "triangle"),
            ("cut: near alone", "clip/triangles/near", "triangle"),
            ("cut: guard band", "clip/triangles/guard-band", "triangle"),
            ("cut: full", "clip/triangles/full", "triangle"),
        ],
    ),
    (
        "screen",
        "divided by w",
        &[
            ("coverage of samples", "", ""),
            ("depth test", "", ""),
            ("verify: pixel owners", "", ""),
        ],
    ),
];

/// The transform from each space to the next.
const ARROWS: [&str; 3] = ["model", "projection", "divide"];

/// The names of the benchmarks whose times [`pipeline`] shows.
pub fn pipeline_costs() -> impl Iterator<Item = &'static str> {
    SPACES.iter().flat_map(|s| s.2).map(|t| t.1).filter(|name| !name.is_empty())
}

/// The pipeline, from the space of a mesh to the screen, and in each space the tests of the project
/// that work there, with what one of them costs: `costs` are nanoseconds by the name of a
/// benchmark, those of [`pipeline_costs`]; a test without one has no figure. `size` is at least
/// 1160 × 600, so that the words have room.
#[must_use]
pub fn pipeline(costs: &[(String, f64)], size: [u32; 2]) -> Picture {
    let mut sheet = Sheet::new([size[0].max(1160), size[1].max(600)]);
    sheet.title("Where each test has its place");
    let [w, h] = sheet.size();
    let em = sheet.text_size();
    let step = w / 4.0;
    let soft = mix(INK, PAPER, 0.3);
    for (i, (name, when, tests)) in SPACES.into_iter().enumerate() {
        let (left, right) = (step * i as f64 + 8.0, step * (i as f64 + 1.0) - 8.0);
        let (top, bottom) = (84.0, h - 104.0);
        // The farther along, the darker: no colour of the palette, for none of its meanings is
        // meant.
        let tint = mix(SUBJECT, PAPER, 0.8 - 0.15 * i as f64);
        let frame = [[left, top], [right, top], [right, bottom], [left, bottom]];
        sheet.fill(&frame, mix(tint, PAPER, 0.75), 1.0);
        let head = [[left, top], [right, top], [right, top + 40.0], [left, top + 40.0]];
        sheet.fill(&head, mix(tint, PAPER, 0.2), 1.0);
        sheet.outline(&frame, 1.6, mix(tint, INK, 0.3));
        let middle = (left + right) * 0.5;
        sheet.centred([middle, top + 13.0], name, INK);
        sheet.centred([middle, top + 54.0], when, soft);
        let high = ((bottom - top - 96.0) / 5.0).min(80.0);
        for (row, (test, key, unit)) in (0..).zip(tests) {
            let y = top + 96.0 + high * f64::from(row);
            sheet.text([left + 14.0, y], *test, INK);
            if let Some((_, ns)) = costs.iter().find(|(name, _)| name == key) {
                let words = if *ns < 10.0 { format!("{ns:.2}") } else { format!("{ns:.0}") };
                let words = format!("{words} ns per {unit}");
                sheet.text([left + 14.0 + em, y + 1.3 * em], words, soft);
            }
        }
        if let Some(words) = ARROWS.get(i) {
            let (x, y) = (right + 8.0, bottom + 18.0);
            sheet.arrow([x - 60.0, y], [x + 60.0, y], 3.0, INK);
            sheet.centred([x, y + 14.0], *words, INK);
        }
    }
    let under =
        if costs.is_empty() { "" } else { "and what one costs, on this machine, one thread" };
    sheet.centred([w * 0.5, 52.0], under, soft);
    sheet.centred([w * 0.5, h - 30.0], "each step to the right sees only what is left", INK);
    sheet.finish()
}
