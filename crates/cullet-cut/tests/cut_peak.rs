//! Peak memory of cutting: at most twice the input and the output together.

use cullet::bounds::Plane;
use cullet_cut::{CapOptions, CutInput, CutOptions, Keep, box_planes, cut};
use cullet_testkit::memory::{Counting, peak_of};
use cullet_testkit::soups::ball_at;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

// One test alone in this file: another thread's allocations would be counted too.
#[test]
fn a_cut_holds_at_most_twice_what_comes_in_and_goes_out() {
    const STRIDE: usize = 8;
    let (positions, indices) = ball_at([0.0; 3], 1.0, 250);
    let attributes = vec![0.5; positions.len() * STRIDE];
    let plane = vec![Plane::new([0.48, 0.6, 0.64], 0.05)];
    let cube = box_planes([-0.6, -0.5, -0.7], [0.5, 0.6, 0.4]).to_vec();
    for (planes, stride) in [(&plane, 0), (&cube, 0), (&plane, STRIDE), (&cube, STRIDE)] {
        for keep in [Keep::Inside, Keep::Outside] {
            for caps in [None, Some(CapOptions::default())] {
                let attributes = &attributes[..positions.len() * stride];
                let input =
                    CutInput { positions: &positions, indices: &indices, attributes, stride };
                let vertex = 12 + stride * 4;
                let options = CutOptions { keep, caps };
                let (done, held) = peak_of(|| cut(&input, planes, &options).unwrap());
                let came = positions.len() * vertex + indices.len() * 4;
                let went =
                    done.positions.len() * vertex + (done.indices.len() + done.origin.len()) * 4;
                let share = (came + held) as f64 / (came + went) as f64;
                println!("{} planes, {stride} attributes, {options:?}: {share:.2}", planes.len());
                assert!(share <= 2.0, "{held} bytes for {came} in and {went} out: {share:.2}");
            }
        }
    }
}
