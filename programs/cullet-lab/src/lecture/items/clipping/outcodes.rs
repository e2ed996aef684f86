//! Outcodes, as the lecture has its three cases, and as they are right.

use std::collections::BTreeSet;

use cullet::clip::{Clipper, Outcode, OutcodeResult, Window};

use crate::lecture::finding::Finding;
use crate::lecture::geometry::Random;
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{grouped, other};

/// The third case as written takes what is inside; mended each line and triangle is in one case, as clipping says.
pub(super) fn rules(_: &Lab) -> Result<Finding, LabError> {
    const CASES: u32 = 6000;
    let window = Window::new([-1.0, -1.0], [1.0, 1.0]).map_err(other)?;
    let region = window.region();
    let mut random = Random::new(95);
    let mut clipper = Clipper::new();
    let mut regions = BTreeSet::new();
    let (mut inside, mut taken_by_text, mut wrong) = (0, 0, 0);
    let (mut candidates, mut false_positives, mut differ) = (0, 0, 0);
    for i in 0..CASES {
        let size = if i % 3 == 0 { 1.3 } else { 3.0 };
        let corners: [[f64; 2]; 3] = std::array::from_fn(|_| random.point(size));
        // A line in turn with a triangle.
        let points = &corners[..2 + (i % 2) as usize];
        let codes: Vec<u32> = points.iter().map(|p| window.outcode(p)).collect();
        regions.extend(codes.iter().copied());
        let (or, and) = codes.iter().fold((0, u32::MAX), |(or, and), c| (or | c, and & c));
        let is_left = match *points {
            [a, b] => region.clip_line(&a, &b).is_some(),
            _ => !clipper.clip(&region, points).is_empty(),
        };
        let is_whole = match *points {
            [a, b] => region.clip_line(&a, &b) == Some([0.0, 1.0]),
            _ => clipper.clip(&region, points) == points,
        };
        // As written: the third case is AND = 0.
        if or == 0 {
            inside += 1;
            taken_by_text += u32::from(and == 0);
        }
        wrong += u32::from((or == 0) != is_whole);
        wrong += u32::from(and != 0 && is_left);
        if and == 0 && or != 0 {
            candidates += 1;
            false_positives += u32::from(!is_left);
            if let [a, b] = *codes {
                wrong += u32::from(a ^ b != or);
            }
        }
        let expected = match (or, and) {
            (0, _) => OutcodeResult::Accepted,
            (_, 0) => OutcodeResult::Candidate(or),
            _ => OutcodeResult::Rejected(and),
        };
        let codes = codes.iter().map(|&code| Outcode { outside: code, not_inside: code });
        differ += u32::from(OutcodeResult::of(codes) != expected);
    }
    let measured = format!(
        "of {} lines and triangles {} are inside, and the third case as written takes {} of them; mended, clipping contradicts {wrong} \
         and the engine {differ} cases. There are {} regions, and {} of {} candidates miss the window",
        grouped(CASES),
        grouped(inside),
        grouped(taken_by_text),
        regions.len(),
        grouped(false_positives),
        grouped(candidates)
    );
    let shown = inside > 100
        && taken_by_text == inside
        && wrong == 0
        && differ == 0
        && regions.len() == 9
        && false_positives > 0;
    Ok(if shown { Finding::mended(measured) } else { Finding::fails(measured) })
}
