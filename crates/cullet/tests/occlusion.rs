//! Boxes reported hidden are hidden: random scenes of boxes against lines of sight, drawn convex and as patches.

use cullet::bounds::Aabb;
use cullet::cull::occlusion::{Convex, Occluder, OcclusionBuffer, Patch, Shape, Visibility};
use cullet::{Camera, Depth, Projection, Simd, Transform, View};
use cullet_testkit::meshes::one_sided;
use cullet_testkit::soups;
use proptest::prelude::*;

/// The triangles of boxes, one after the other, wound outward.
fn triangles(boxes: &[Aabb]) -> (Vec<[f32; 3]>, Vec<u32>) {
    const FACES: [[u32; 4]; 6] =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let positions = boxes.iter().flat_map(Aabb::corners).collect();
    let indices = (0..boxes.len() as u32)
        .flat_map(|b| FACES.iter().flat_map(move |f| [0, 1, 2, 0, 2, 3].map(|k| b * 8 + f[k])))
        .collect();
    (positions, indices)
}

/// Whether the open line from `eye` to `p` meets a box (slabs, in f64).
fn is_blocked(boxes: &[Aabb], eye: [f64; 3], p: [f64; 3]) -> bool {
    boxes.iter().any(|b| {
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        for a in 0..3 {
            let (from, along) = (eye[a], p[a] - eye[a]);
            let (low, high) = (f64::from(b.min[a]), f64::from(b.max[a]));
            if along == 0.0 {
                if from < low || from > high {
                    return false;
                }
            } else {
                let (s, t) = ((low - from) / along, (high - from) / along);
                enter = enter.max(s.min(t));
                leave = leave.min(s.max(t));
            }
        }
        enter <= leave && enter < 1.0
    })
}

fn block() -> impl Strategy<Value = Aabb> {
    (
        (-6.0..6.0_f32),
        (-6.0..6.0_f32),
        (-20.0..-2.0_f32),
        (0.2..4.0_f32),
        (0.2..4.0_f32),
        (0.1..3.0_f32),
    )
        .prop_map(|(x, y, z, w, h, d)| Aabb { min: [x, y, z], max: [x + w, y + h, z + d] })
}

fn view(orthographic: bool, depth: Depth, size: [u32; 2]) -> View {
    let aspect = f64::from(size[0]) / f64::from(size[1]);
    let projection = if orthographic {
        Projection::Orthographic {
            left: -5.0 * aspect,
            right: 5.0 * aspect,
            bottom: -5.0,
            top: 5.0,
            near: 0.1,
            far: 60.0,
        }
    } else {
        Projection::Perspective { fov_y_radians: 1.0, aspect, near: 0.1, far: f64::INFINITY }
    };
    let camera = Camera::look_at([0.3, 0.2, 0.4], [0.1, 0.4, -10.0], projection);
    View::new(&camera, depth, size).unwrap()
}

/// Where a point lies on the screen, in 0..1 both ways, and whether it is in the view.
fn is_seen_there(view: &View, p: [f64; 3]) -> bool {
    let m = view.clip_from_world();
    let [x, y, z, w]: [f64; 4] =
        std::array::from_fn(|r| m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r]);
    w > 0.0 && x.abs() <= w && y.abs() <= w && z >= 0.0 && z <= w
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cullet_testkit::cases(400)))]

    #[test]
    fn no_line_of_sight_reaches_what_is_hidden(
        blocks in prop::collection::vec(block(), 1..24),
        occludees in prop::collection::vec(block(), 1..24),
        size in (1..200_u32, 1..120_u32).prop_map(|(w, h)| [w, h]),
        (orthographic, reversed, as_mesh) in any::<(bool, bool, bool)>(),
        points in prop::collection::vec([0.0..1.0_f64, 0.0..1.0_f64, 0.0..1.0_f64], 60),
    ) {
        let depth = if reversed { Depth::Reversed } else { Depth::Standard };
        let view = view(orthographic, depth, [1280, 720]);
        let mut buffer = OcclusionBuffer::new(size).unwrap();
        buffer.begin(&view, [0.0; 3]);
        let here = Transform::IDENTITY;
        if as_mesh {
            let (positions, indices) = triangles(&blocks);
            // So few that boxes are cut apart.
            for patch in Patch::cut(&positions, &indices, 4, reversed).unwrap() {
                patch.draw(Simd::best(), &mut buffer, &here);
            }
        } else {
            for b in &blocks {
                Convex::from_box(b).unwrap().draw(Simd::best(), &mut buffer, &here);
            }
        }
        let eye = view.eye();
        for occludee in &occludees {
            if buffer.test_box(occludee) != Visibility::Hidden {
                continue;
            }
            for t in &points {
                let p: [f64; 3] = std::array::from_fn(|a| {
                    let (low, high) = (f64::from(occludee.min[a]), f64::from(occludee.max[a]));
                    low + (high - low) * t[a]
                });
                let from = if orthographic {
                    std::array::from_fn(|a| p[a] + eye[a] * 100.0)
                } else {
                    [eye[0], eye[1], eye[2]]
                };
                if is_seen_there(&view, p) {
                    prop_assert!(is_blocked(&blocks, from, p), "{p:?} of {occludee:?} is seen");
                }
            }
        }
    }
}

/// A wall of two abutting boxes with a gap between, and a box behind it.
fn through_a_gap(gap: f32, size: [u32; 2]) -> Visibility {
    let view = view(false, Depth::Reversed, [1280, 720]);
    let mut buffer = OcclusionBuffer::new(size).unwrap();
    buffer.begin(&view, [0.0; 3]);
    for (from, to) in [(-20.0, 0.0), (gap, 20.0)] {
        // Without thickness, for a thick one hides what is seen aslant through so thin a gap.
        let wall = Aabb { min: [from, -20.0, -5.0], max: [to, 20.0, -5.0] };
        Convex::from_box(&wall).unwrap().draw(Simd::best(), &mut buffer, &Transform::IDENTITY);
    }
    buffer.test_box(&Aabb { min: [-1.0, -1.0, -9.0], max: [1.0, 1.0, -8.0] })
}

#[test]
fn a_gap_of_a_thousandth_of_a_pixel_is_seen_through() {
    for size in [[1280, 720], [320, 180], [33, 17], [1, 1]] {
        for gap in [1e-5, 1e-3, 0.1] {
            assert_eq!(through_a_gap(gap, size), Visibility::Visible, "{gap} {size:?}");
        }
    }
}

/// The bolts of a machine are not to be looked at one by one.
#[test]
fn small_bodies_of_a_mesh_stay_in_its_patches() {
    let bodies = |side: f32| {
        let (mut positions, mut indices) = soups::block([-1.0; 3], [1.0; 3]);
        let (corners, faces) = soups::block([2.0; 3], [2.0 + side; 3]);
        indices.extend(faces.iter().map(|i| i + positions.len() as u32));
        positions.extend(corners);
        let occluder = Occluder::of_mesh(&one_sided((positions, indices)));
        occluder.shapes().iter().filter(|shape| matches!(shape, Shape::Convex(_))).count()
    };
    assert_eq!([bodies(1.5), bodies(0.1)], [2, 1]);
}

#[test]
fn a_surface_has_no_cracks() {
    // A bent sheet of many small triangles, cut into patches: what is behind it is hidden through every seam.
    const N: u32 = 40;
    let positions: Vec<[f32; 3]> = (0..=N * (N + 2))
        .map(|i| {
            let (x, y) =
                ((i % (N + 1)) as f32 / N as f32 - 0.5, (i / (N + 1)) as f32 / N as f32 - 0.5);
            [x * 30.0, y * 30.0, -6.0 - (x * 9.0).sin() * (y * 7.0).cos()]
        })
        .collect();
    let indices: Vec<u32> = (0..N * N)
        .flat_map(|i| {
            let v = i / N * (N + 1) + i % N;
            [v, v + 1, v + N + 2, v, v + N + 2, v + N + 1]
        })
        .collect();
    let view = view(false, Depth::Reversed, [1280, 720]);
    for (size, least) in [([640, 360], 1.0), ([160, 90], 1.0), ([40, 23], 0.9)] {
        let mut buffer = OcclusionBuffer::new(size).unwrap();
        buffer.begin(&view, [0.0; 3]);
        for patch in Patch::cut(&positions, &indices, 32, false).unwrap() {
            patch.draw(Simd::best(), &mut buffer, &Transform::IDENTITY);
        }
        let count = size[0] * size[1];
        let covered =
            (0..count).filter(|i| buffer.nearness(i % size[0], i / size[0]) > 0.0).count();
        assert!(covered as f64 >= f64::from(count) * least, "{covered} of {count} at {size:?}");
    }
}

#[test]
fn triangles_of_a_pixel_are_drawn_wherever_on_the_screen_they_are() {
    const N: u32 = 60;
    let view = view(false, Depth::Reversed, [1280, 720]);
    // The screen is 7 units high at this distance, and a step 1.1 pixels.
    for corner in [[-5.0, 2.2], [4.0, -2.9]] {
        let at = |i: u32, a: usize| corner[a] + i as f32 * 0.011;
        let places = (0..(N + 1) * (N + 1)).map(|i| [at(i % (N + 1), 0), at(i / (N + 1), 1), -6.0]);
        let positions: Vec<[f32; 3]> = places.collect();
        let quads = (0..N * N).map(|i| i / N * (N + 1) + i % N);
        let indices: Vec<u32> =
            quads.flat_map(|v| [v, v + 1, v + N + 2, v, v + N + 2, v + N + 1]).collect();
        let mut buffer = OcclusionBuffer::new([1280, 720]).unwrap();
        buffer.begin(&view, [0.0; 3]);
        for patch in Patch::cut(&positions, &indices, 32, false).unwrap() {
            patch.draw(Simd::best(), &mut buffer, &Transform::IDENTITY);
        }
        let all = (0..1280 * 720).map(|i| buffer.nearness(i % 1280, i / 1280));
        let covered = all.filter(|&nearness| nearness > 0.0).count();
        assert!(covered > 4000, "{covered} at {corner:?}");
    }
}
