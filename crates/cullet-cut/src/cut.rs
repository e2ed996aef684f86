//! Cutting plain slices.

use cullet::bounds::Plane;

use crate::options::{CapOptions, CutError, CutInput, CutOptions, Keep, check};
use crate::result::CutMesh;
use crate::weld::weld_within;
use crate::{sides, triangles};

/// The six planes of a box, pointing out: for [`cut`].
#[must_use]
pub fn box_planes(min: [f64; 3], max: [f64; 3]) -> [Plane; 6] {
    std::array::from_fn(|i| {
        let (axis, high) = (i / 2, i % 2 == 1);
        let mut normal = [0.0; 3];
        normal[axis] = if high { 1.0 } else { -1.0 };
        Plane::new(normal, if high { max[axis] } else { -min[axis] })
    })
}

/// Cuts a mesh at a convex region of up to 32 planes whose normals point out (of any length; n·x ≤
/// d is inside), and keeps what is inside of all of them or outside of any, in one pass. No planes:
/// all is inside. An empty result is a value. The rules are at the [crate](crate).
///
/// Cost: O(vertices · planes + triangles), and what the caps take: a sort-like effort over the
/// edges at the cut. Takes 8 bytes a vertex besides the result.
///
/// # Errors
/// If a plane is none, a vertex is not finite, an index is out of range or the attributes do not
/// fit.
pub fn cut(
    input: &CutInput<'_>,
    planes: &[Plane],
    options: &CutOptions,
) -> Result<CutMesh, CutError> {
    check(input, options)?;
    let planes = sides::prepare(planes)?;
    welded(input, options.caps.as_ref(), |input, moved| {
        let sides = sides::Sides::new(input.positions, &planes)?;
        let mut done = triangles::run(input, &planes, &sides, options);
        done.report.welded = moved;
        Ok(done)
    })
}

/// Cuts, and gives both parts: what is inside of all planes, and what is outside of any. Each is
/// what [`cut`] gives; the sides of the vertices are found once.
///
/// # Errors
/// As [`cut`].
pub fn cut_both(
    input: &CutInput<'_>,
    planes: &[Plane],
    caps: Option<&CapOptions>,
) -> Result<[CutMesh; 2], CutError> {
    let [inside, outside] =
        [Keep::Inside, Keep::Outside].map(|keep| CutOptions { keep, caps: caps.cloned() });
    check(input, &inside)?;
    let planes = sides::prepare(planes)?;
    welded(input, caps, |input, moved| {
        let sides = sides::Sides::new(input.positions, &planes)?;
        Ok([&inside, &outside].map(|options| {
            let mut done = triangles::run(input, &planes, &sides, options);
            done.report.welded = moved;
            done
        }))
    })
}

/// Hands on the input with the positions that are wanted, and how many of them moved.
fn welded<R>(
    input: &CutInput<'_>,
    caps: Option<&CapOptions>,
    run: impl FnOnce(&CutInput<'_>, usize) -> R,
) -> R {
    let tolerance = caps.map_or(0.0, |c| c.weld);
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return run(input, 0);
    }
    let to = weld_within(input.positions, tolerance);
    let positions: Vec<[f32; 3]> = to.iter().map(|&v| input.positions[v as usize]).collect();
    drop(to);
    let moved = positions.iter().zip(input.positions).filter(|(p, q)| p != q).count();
    run(&CutInput { positions: &positions, ..*input }, moved)
}
