//! Lines: where they cross, and three ways to clip them.

use cullet::clip::line::{at, clip_line_ref};
use cullet::clip::{HalfSpace, Region, Window};

use crate::lecture::finding::Finding;
use crate::lecture::geometry::Random;
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{grouped, other};

/// Segments against lines by the engine, by the formula and in exact arithmetic; attributes by the same parameter.
pub(super) fn segment(_: &Lab) -> Result<Finding, LabError> {
    const CASES: u32 = 3000;
    let mut random = Random::new(92);
    let (mut crossed, mut one_side, mut wrong) = (0, 0, 0);
    let (mut off_formula, mut off_line, mut off_exact, mut off_carried) =
        (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
    for _ in 0..CASES {
        let (n, d): ([f64; 2], f64) = (random.point(1.0), random.between(-2.0, 2.0));
        let line = HalfSpace::new(n, d).map_err(other)?;
        // A place and what it carries: three numbers that follow the place.
        let carried = |p: [f64; 2]| [p[0], p[1], 3.0 * p[0], p[0] - p[1], 7.0 + p[1]];
        let ends: [[f64; 2]; 2] = [random.point(5.0), random.point(5.0)];
        let heights = ends.map(|p| line.height(&p));
        let clipped = line.clip_line(&ends[0], &ends[1]);
        if (heights[0] > 0.0) == (heights[1] > 0.0) {
            one_side += 1;
            let expected = (heights[0] <= 0.0).then_some([0.0, 1.0]);
            wrong += u32::from(clipped != expected);
            continue;
        }
        crossed += 1;
        let Some([from, to]) = clipped else {
            wrong += 1;
            continue;
        };
        let t = if heights[0] > 0.0 { from } else { to };
        let formula = -heights[0] / (heights[1] - heights[0]);
        off_formula = off_formula.max((t - formula).abs());
        let cut = at(&carried(ends[0]), &carried(ends[1]), t);
        off_line = off_line.max(line.height(&[cut[0], cut[1]]).abs());
        let follows = carried([cut[0], cut[1]]);
        off_carried = (0..5).map(|k| (cut[k] - follows[k]).abs()).fold(off_carried, f64::max);
        let region = Region::new([line]).map_err(other)?;
        match clip_line_ref(&region, &ends[0], &ends[1]) {
            Some(exact) => {
                off_exact = off_exact.max((exact[0] - from).abs()).max((exact[1] - to).abs());
            }
            None => wrong += 1,
        }
    }
    let worst = off_formula.max(off_line).max(off_carried).max(off_exact);
    Ok(Finding::if_so(
        wrong == 0 && crossed > 500 && one_side > 500 && worst < 1e-9,
        format!(
            "of {} segments {} lie on one side; the others cross where the formula says within {off_formula:.0e}, exact arithmetic \
             within {off_exact:.0e}, and what they carry follows within {off_carried:.0e}",
            grouped(CASES),
            grouped(one_side)
        ),
    ))
}

/// Three ways and exact arithmetic, about lines of all kinds around a window; some need no cut at all.
pub(super) fn cohen_sutherland(_: &Lab) -> Result<Finding, LabError> {
    const CASES: u32 = 4000;
    let window = Window::new([-1.0, -1.0], [1.0, 1.0]).map_err(other)?;
    let region = window.region();
    let mut random = Random::new(96);
    let (mut at_once, mut cut, mut missed, mut wrong, mut worst) = (0, 0, 0, 0, 0.0_f64);
    for i in 0..CASES {
        let [mut a, b]: [[f64; 2]; 2] = [random.point(2.5), random.point(2.5)];
        if i % 8 == 0 {
            // Upright, and through a corner.
            a[0] = b[0];
        }
        let ways = [
            window.cohen_sutherland(&a, &b),
            window.liang_barsky(&a, &b),
            region.clip_line(&a, &b),
        ];
        let exact = clip_line_ref(&region, &a, &b);
        for way in ways {
            match (way, exact) {
                (Some(found), Some(exact)) => {
                    worst = (0..2).map(|k| (found[k] - exact[k]).abs()).fold(worst, f64::max);
                }
                (None, None) => {}
                _ => wrong += 1,
            }
        }
        let codes = [a, b].map(|p| window.outcode(&p));
        if codes[0] & codes[1] != 0 {
            at_once += 1;
            wrong += u32::from(exact.is_some());
        } else if codes[0] | codes[1] == 0 {
            at_once += 1;
            wrong += u32::from(exact != Some([0.0, 1.0]));
        } else if exact.is_some() {
            cut += 1;
        } else {
            missed += 1;
        }
    }
    Ok(Finding::if_so(
        wrong == 0 && worst < 1e-12 && at_once > 500 && cut > 500 && missed > 100,
        format!(
            "of {} lines around a window codes decide {} at once, {} are cut, and {} turn out to miss it; Liang and Barsky, Cyrus and \
             Beck and exact arithmetic say the same, within {worst:.0e}",
            grouped(CASES),
            grouped(at_once),
            grouped(cut),
            grouped(missed)
        ),
    ))
}
