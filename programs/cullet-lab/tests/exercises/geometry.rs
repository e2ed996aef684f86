//! Frusta, hierarchies and clipping.

use cullet::bounds::{Aabb, Boxes, Plane, Side, Sphere};
use cullet::cull::frustum::batch::Planes;
use cullet::cull::frustum::tree::Cut;
use cullet::hierarchy::Nodes;
use cullet::view::{FrustumPlane, ViewError};
use cullet::{Camera, Depth, Projection, Simd, view::Frustum};
use cullet_draw::clip::{HalfSpace, Outcode, OutcodeResult, Window, space};

use crate::{Computed, Entry, number, word};

pub(crate) const ENTRIES: &[Entry] = &[
    ("frustum-1", distance_of_a_point),
    ("frustum-2", side_of_a_sphere),
    ("frustum-3", distance_of_the_p_vertex),
    ("frustum-4", up_times_direction),
    ("hierarchy-1", levels_of_nodes),
    ("hierarchy-2", planes_that_are_left),
    ("clipping-1", outcode),
    ("clipping-2", cut_by_a_side),
    ("clipping-3", cut_in_clip_space),
    ("clipping-4", past_the_corner),
];

/// 90 degrees both ways.
const PROJECTION: Projection = Projection::Perspective {
    fov_y_radians: std::f64::consts::FRAC_PI_2,
    aspect: 1.0,
    near: 1.0,
    far: 100.0,
};

/// The right plane of what the camera in the origin sees.
fn right() -> Result<Plane, ViewError> {
    Ok(*PROJECTION.frustum()?.plane(FrustumPlane::Right).expect("a perspective has a right plane"))
}

fn distance_of_a_point() -> Computed {
    number(right()?.distance([3.0, 0.0, -10.0]))
}

fn side_of_a_sphere() -> Computed {
    word(Sphere::new([12.0, 0.0, -10.0], 1.5).side(&right()?))
}

fn distance_of_the_p_vertex() -> Computed {
    let b = Aabb::new([3.0, -2.0, -9.0], [5.0, 2.0, -3.0]);
    assert_eq!((b.center(), b.half_extent()), ([4.0, 0.0, -6.0], [1.0, 2.0, 3.0]));
    number(b.span(&right()?)[1])
}

/// The engine's right is direction × up.
fn up_times_direction() -> Computed {
    let (direction, up) = ([0.0, 0.0, -1.0], [0.0, 1.0, 0.0]);
    let [right, ..] = Camera { eye: [0.0; 3], direction, up, projection: PROJECTION }.basis()?;
    number(-right[0])
}

fn levels_of_nodes() -> Computed {
    let boxes: Vec<Aabb> = (0..65_536)
        .map(|i| [(i % 256) as f32, (i / 256) as f32, 0.0])
        .map(|low| Aabb::new(low, low.map(|v| v + 1.0)))
        .collect();
    let boxes = Boxes::from_slice(&boxes);
    let nodes = Nodes::over(Simd::best(), &boxes);
    number(nodes.levels().len() as f64)
}

/// Counts the tests of a walk over two nodes, of which one straddles, less those of a walk in which
/// both are inside.
fn planes_that_are_left() -> Computed {
    let projection = Projection::Orthographic {
        left: -10.0,
        right: 10.0,
        bottom: -10.0,
        top: 10.0,
        near: -10.0,
        far: 10.0,
    };
    let frustum = projection.frustum()?;
    let (straddling, inside) = (sixteen(2.5), sixteen(-3.0));
    let tests = |first: &[Aabb], second: &[Aabb]| {
        let boxes = Boxes::from_slice(&[first, second].concat());
        let mut cut = Cut::new();
        let nodes = Nodes::over(Simd::best(), &boxes);
        cut.cull(Simd::best(), &Planes::new(&frustum), &nodes, &boxes);
        assert_eq!(cut.swept(), 0);
        cut.plane_tests()
    };
    let of_children = tests(&straddling, &inside) - tests(&inside, &inside);
    assert_eq!(straddled(&frustum, &straddling), of_children as usize);
    number(of_children as f64)
}

/// The children of a node: four rows of four boxes, with steps of so much from the origin.
fn sixteen(step: f32) -> Vec<Aabb> {
    let place = |i: u8| [f32::from(i % 4) * step, f32::from(i / 4) * step, 0.0];
    (0..16).map(place).map(|low| Aabb::new(low, low.map(|v| v + 3.0))).collect()
}

/// How many planes the box around some boxes straddles; it is inside the others.
fn straddled(frustum: &Frustum, boxes: &[Aabb]) -> usize {
    let node = boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(b));
    let sides: Vec<Side> = frustum.planes().map(|(_, plane)| node.side(plane)).collect();
    assert!(sides.len() == 6 && !sides.contains(&Side::Outside));
    sides.iter().filter(|side| **side == Side::Straddling).count()
}

/// The window of the exercises.
fn window() -> Window<f64, 2> {
    Window::new([-1.0; 2], [1.0; 2]).expect("low is below high")
}

fn outcode() -> Computed {
    number(f64::from(window().outcode(&[2.0, -3.0])))
}

fn cut_by_a_side() -> Computed {
    let side = HalfSpace::new([1.0, 0.0], 1.0)?;
    number(side.clip_line(&[0.0, 0.0], &[4.0, 2.0]).ok_or("nothing is left")?[1])
}

fn cut_in_clip_space() -> Computed {
    let volume = space::full::<f64>(Depth::Standard);
    let left = volume.clip_line(&[1.0, 0.0, 1.0, 4.0], &[4.0, 0.0, 1.0, 2.0]);
    number(left.ok_or("nothing is left")?[1])
}

fn past_the_corner() -> Computed {
    let (window, ends) = (window(), [[-2.0, 0.5], [-0.5, 2.0]]);
    // No end is on a side, so that what is not outside is inside.
    let codes = ends.map(|end| window.outcode(&end));
    let codes = codes.map(|code| Outcode { outside: code, not_inside: code });
    assert_eq!(window.cohen_sutherland(&ends[0], &ends[1]), None, "it passes the corner");
    Ok(match OutcodeResult::of(codes) {
        OutcodeResult::Accepted => "accepted",
        OutcodeResult::Rejected(_) => "rejected",
        OutcodeResult::Candidate(_) => "candidate",
    }
    .to_owned())
}
