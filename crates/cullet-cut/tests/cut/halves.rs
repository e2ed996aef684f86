//! Cuts, and a check of both halves that does not trust the code under test.

use cullet::bounds::Plane;
use cullet_cut::{CapOptions, CutInput, CutMesh, CutOptions, Keep, cut};
use cullet_testkit::Rng;
use cullet_testkit::soups::{Soup, leaks, volume};

/// A plane that passes near the middle of a box of this centre and half size.
pub(crate) fn plane_near(rng: &mut Rng, centre: [f64; 3], half: [f64; 3]) -> Plane {
    let normal = rng.vector(1.0);
    let d = (0..3).map(|a| normal[a] * (centre[a] + half[a] * rng.signed() * 0.7)).sum();
    Plane::new(normal, d)
}

/// Cuts, with caps.
pub(crate) fn capped(shape: &Soup, planes: &[Plane], keep: Keep) -> CutMesh {
    let input = CutInput { positions: &shape.0, indices: &shape.1, ..CutInput::default() };
    cut(&input, planes, &CutOptions { keep, caps: Some(CapOptions::default()) }).unwrap()
}

/// Cuts, left open.
pub(crate) fn open(shape: &Soup, planes: &[Plane], keep: Keep) -> CutMesh {
    let input = CutInput { positions: &shape.0, indices: &shape.1, ..CutInput::default() };
    cut(&input, planes, &CutOptions { keep, caps: None }).unwrap()
}

/// Both halves of a closed shape must be closed, and their volumes add up. Returns that of the inside.
#[track_caller]
pub(crate) fn check_halves(shape: &Soup, planes: &[Plane], what: &str) -> f64 {
    let whole = volume(&shape.0, &shape.1);
    let halves = [Keep::Inside, Keep::Outside].map(|keep| {
        let half = capped(shape, planes, keep);
        assert_eq!(half.origin.len() * 3, half.indices.len());
        assert_eq!(half.report.open_chains, 0, "{what}, {keep:?}: {:?}", half.report);
        let leaks = leaks(&half.positions, &half.indices);
        assert_eq!(leaks, 0, "{what}, {keep:?}, {planes:?}: {:?}", half.report);
        volume(&half.positions, &half.indices)
    });
    let sum = halves[0] + halves[1];
    assert!(
        (sum - whole).abs() <= whole.abs() * 1e-6 + 1e-12,
        "{what}: {halves:?} is not {whole}, {planes:?}"
    );
    halves[0]
}
