//! Back faces: of triangles, by masks and of clusters; and triangles without area.

use cullet::bounds::Sphere;
use cullet::cull::backface::{Facing, ObjectEye};
use cullet::cull::degenerate::{Flattening, is_zero_area};
use cullet::{
    Transform,
    view::{CullFace, FrontFace},
};
use cullet_draw::clip::{HalfSpace, Region};
use cullet_lab::methods::cluster::{Bound, NormalBox};
use cullet_lab::methods::screen::ndc_normal_z;
use cullet_mesh::{MaskGrid, ViewCone};
use cullet_testkit::soups;

use crate::{Computed, Entry, end_of, number, word};

pub(crate) const ENTRIES: &[Entry] = &[
    ("backface-1", normal),
    ("backface-2", seen_from_below),
    ("backface-3", seen_in_parallel),
    ("backface-4", normal_on_the_screen),
    ("masks-1", classes),
    ("masks-2", largest_grid),
    ("masks-3", arc_of_normals),
    ("clusters-1", farthest_normal),
    ("clusters-2", culling_volume),
    ("clusters-3", another_origin),
    ("clusters-4", merge_that_pays),
    ("degenerate-1", without_area),
    ("degenerate-2", flat_instance),
];

/// The triangle of the exercises, in the plane z = 0.
const TRIANGLE: [[f32; 3]; 3] = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0]];

/// The z of the triangle's normal: it lies in the plane of the screen, where the engine has that of
/// a projected triangle.
fn normal_z() -> f64 {
    ndc_normal_z(&TRIANGLE.map(|[x, y, _]| [f64::from(x), f64::from(y)]))
}

/// Returns the side that a homogeneous eye sees.
fn facing(eye: [f64; 4]) -> Facing {
    let (front, cull) = (FrontFace::CounterClockwise, CullFace::Back);
    ObjectEye::new(eye, &Transform::IDENTITY, front, cull).facing(&TRIANGLE)
}

fn normal() -> Computed {
    number(normal_z())
}

fn seen_from_below() -> Computed {
    word(facing([1.0, 1.0, -5.0, 1.0]))
}

/// d w is zero, and the eye is a unit along z.
fn seen_in_parallel() -> Computed {
    assert_eq!(facing([0.0, 0.0, 1.0, 0.0]), Facing::Front);
    number(-normal_z())
}

fn normal_on_the_screen() -> Computed {
    number(ndc_normal_z(&[[0.0, 0.0], [0.0, 0.5], [0.5, 0.0]]))
}

fn classes() -> Computed {
    number(f64::from(MaskGrid::new(12).ok_or("no such grid")?.classes()))
}

fn largest_grid() -> Computed {
    let largest = (1..100).rev().find(|&n| MaskGrid::new(n).is_some());
    number(f64::from(largest.ok_or("no grid")?))
}

/// A normal may be culled if it is within a right angle of every line of sight.
fn arc_of_normals() -> Computed {
    let cone = ViewCone::to_sphere([0.0, 0.0, 3.0, 1.0], &Sphere::new([0.0; 3], 1.0));
    number(180.0 - 2.0 * cone.ok_or("no cone")?.sine.asin().to_degrees())
}

/// The box of normals of the exercises.
fn normal_box(d: f32) -> NormalBox {
    NormalBox { largest: [0.3, 1.0, 0.2], smallest: [-0.3, 0.9, -0.2], d, origin: [0.0; 3] }
}

fn farthest_normal() -> Computed {
    let (bound, eye) = (normal_box(-0.1), [4.0, -6.0, 1.0]);
    assert!(bound.is_behind([eye[0], eye[1], eye[2], 1.0]));
    let height = |n: [f64; 3]| -> f64 { n.iter().zip(eye).map(|(n, v)| n * v).sum() };
    number(bound.half_spaces().into_iter().map(|(n, _)| height(n)).fold(f64::MIN, f64::max))
}

/// Computes what is left of the axis within all half-spaces of the volume.
fn culling_volume() -> Computed {
    let sides = normal_box(-0.1).half_spaces().map(|(n, d)| HalfSpace::new(n, d));
    let volume = Region::new(sides.into_iter().collect::<Result<Vec<_>, _>>()?)?;
    let (from, to) = ([0.0, 2.0, 0.0], [0.0, -2.0, 0.0]);
    let [enters, leaves] = volume.clip_line(&from, &to).ok_or("the axis misses the volume")?;
    assert_eq!(leaves, 1.0, "it has no end below");
    number(cullet_draw::clip::line::at(&from, &to, enters)[1])
}

fn another_origin() -> Computed {
    let bound = normal_box(0.5);
    number(f64::from(bound.join(&bound, [1.0, 0.0, 0.0]).d))
}

/// The engine merges clusters of meshes, and takes their shares from view points: none of its
/// functions takes given shares. So its cost model, T = t + (1 − P) n r with r = 1, stands here.
fn merge_that_pays() -> Computed {
    let cost = |triangles: f64, culled: f64| 6.0 + (1.0 - culled) * triangles;
    let apart = cost(40.0, 0.5) + cost(20.0, 0.2);
    number(end_of(0.0, 1.0, |culled| cost(60.0, culled) > apart))
}

fn without_area() -> Computed {
    let triangles = [
        [[0.0; 3], [1.0; 3], [2.0; 3]],
        [[0.0; 3], [1.0, 0.0, 0.0], [0.5, 1e-30, 0.0]],
        [[0.0; 3], [1.0, 0.0, 0.0], [0.0; 3]],
    ];
    number(triangles.iter().filter(|&t| is_zero_area(t)).count() as f64)
}

/// Two triangles a side.
fn flat_instance() -> Computed {
    let flat = Flattening::of(&Transform::from_scale_translation([1.0, 0.0, 1.0], [0.0; 3]));
    let (positions, indices) = soups::block([-1.0; 3], [1.0; 3]);
    let flattens = |t: &[u32; 3]| flat.flattens(&t.map(|v| positions[v as usize]));
    let triangles = indices.as_chunks::<3>().0;
    let sides = triangles.as_chunks::<2>().0;
    assert_eq!(sides.len(), 6);
    number(sides.iter().filter(|side| !side.iter().any(flattens)).count() as f64)
}
