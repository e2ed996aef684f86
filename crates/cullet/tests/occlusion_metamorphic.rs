//! Changes that must not alter a result, or may alter it in one direction alone: order, threads, SIMD levels,
//! mirrors and origins; more occluders, smaller boxes.

use cullet::bounds::{Aabb, Boxes};
use cullet::cull::occlusion::{Convex, OcclusionBuffer, Patch, Visibility};
use cullet::{Camera, Depth, Projection, Simd, Transform, View};
use cullet_testkit::at_every_level;
use proptest::prelude::*;

/// An occluder of any kind, and where it stands.
#[derive(Clone, Debug)]
enum Drawn {
    Convex(Box<Convex>, Transform),
    Patch(Vec<Patch>, Transform),
}

impl Drawn {
    fn draw_in(&self, simd: Simd, buffer: &mut OcclusionBuffer) {
        match self {
            Self::Convex(convex, t) => convex.draw(simd, buffer, t),
            Self::Patch(patches, t) => patches.iter().for_each(|p| p.draw(simd, buffer, t)),
        }
    }

    fn draw(&self, simd: Simd, buffer: &mut OcclusionBuffer, moved: [f64; 3]) {
        let placed = |t: &Transform| Transform {
            translation: std::array::from_fn(|a| t.translation[a] + moved[a]),
            ..*t
        };
        match self {
            Self::Convex(convex, t) => convex.draw(simd, buffer, &placed(t)),
            Self::Patch(patches, t) => {
                patches.iter().for_each(|p| p.draw(simd, buffer, &placed(t)));
            }
        }
    }
}

impl Drawn {
    fn bounds(&self) -> Aabb {
        match self {
            Self::Convex(convex, t) => t.transform_box(&convex.bounds(), [0.0; 3]),
            Self::Patch(patches, t) => {
                let of = |p: &Patch| t.transform_box(&p.bounds(), [0.0; 3]);
                patches.iter().map(of).fold(Aabb::EMPTY, |a, b| a.union(&b))
            }
        }
    }
}

/// A sheet of n × n bumpy squares with shared edges, cut into patches, about two units wide.
fn sheet(n: u32, bump: f32, phase: f32, two_sided: bool) -> Vec<Patch> {
    let row = n + 1;
    let positions: Vec<[f32; 3]> = (0..row * row)
        .map(|v| {
            let (x, y) = ((v % row) as f32 / n as f32, (v / row) as f32 / n as f32);
            [x * 2.0 - 1.0, y * 2.0 - 1.0, bump * ((x * 9.0 + phase).sin() * (y * 7.0).cos())]
        })
        .collect();
    let indices: Vec<u32> = (0..n * n)
        .flat_map(|i| {
            let v = i / n * row + i % n;
            [v, v + 1, v + row + 1, v, v + row + 1, v + row]
        })
        .collect();
    Patch::cut(&positions, &indices, 24, two_sided).unwrap()
}

fn transform() -> impl Strategy<Value = Transform> {
    let small = || -0.3..0.3_f32;
    (
        [small(), small(), small(), small(), small(), small()],
        [0.3..4.0_f32, 0.3..4.0_f32, 0.3..2.0_f32],
        any::<bool>(),
        [-4.0..4.0_f64, -3.0..3.0_f64, -18.0..-1.0_f64],
    )
        .prop_map(|(off, [x, y, z], mirror, translation)| Transform {
            linear: [
                [if mirror { -x } else { x }, off[0], off[1]],
                [off[2], y, off[3]],
                [off[4], off[5], z],
            ],
            translation,
        })
}

fn occluder() -> impl Strategy<Value = Drawn> {
    let unit = Aabb { min: [-1.0; 3], max: [1.0; 3] };
    prop_oneof![
        transform().prop_map(move |t| Drawn::Convex(Box::new(Convex::from_box(&unit).unwrap()), t)),
        (1..12_u32, 0.0..0.4_f32, 0.0..6.0_f32, any::<bool>(), transform())
            .prop_map(|(n, bump, phase, two, t)| Drawn::Patch(sheet(n, bump, phase, two), t)),
    ]
}

fn occludee() -> impl Strategy<Value = Aabb> {
    ([-6.0..6.0_f32, -4.0..4.0_f32, -30.0..-1.0_f32], [0.01..2.0_f32, 0.01..2.0_f32, 0.01..2.0_f32])
        .prop_map(|(min, size)| Aabb { min, max: std::array::from_fn(|a| min[a] + size[a]) })
}

fn camera(kind: u8, eye: [f64; 3]) -> Camera {
    let projection = match kind {
        0 => Projection::Perspective {
            fov_y_radians: 0.9,
            aspect: 1.7,
            near: 0.1,
            far: f64::INFINITY,
        },
        1 => Projection::OffCentre {
            left: -0.05,
            right: 0.11,
            bottom: -0.07,
            top: 0.03,
            near: 0.1,
            far: 70.0,
        },
        _ => Projection::Orthographic {
            left: -5.0,
            right: 4.0,
            bottom: -3.0,
            top: 3.5,
            near: 0.1,
            far: 70.0,
        },
    };
    Camera { eye, direction: [0.0, 0.0, -1.0], up: [0.0, 1.0, 0.0], projection }
}

fn depth(reversed: bool) -> Depth {
    if reversed { Depth::Reversed } else { Depth::Standard }
}

fn view(kind: u8, reversed: bool) -> View {
    View::new(&camera(kind, [0.0; 3]), depth(reversed), [1280, 720]).unwrap()
}

fn buffer<'a>(
    view: &View,
    size: [u32; 2],
    simd: Simd,
    drawn: impl IntoIterator<Item = &'a Drawn>,
) -> OcclusionBuffer {
    let mut buffer = OcclusionBuffer::new(size).unwrap();
    buffer.begin(view, [0.0; 3]);
    drawn.into_iter().for_each(|d| d.draw(simd, &mut buffer, [0.0; 3]));
    buffer
}

fn pixels(b: &OcclusionBuffer) -> Vec<u32> {
    let [w, h] = b.size();
    (0..w * h).map(|i| b.nearness(i % w, i / w).to_bits()).collect()
}

fn tiles(b: &OcclusionBuffer) -> Vec<u32> {
    let [w, h] = b.size();
    (0..w * h).map(|i| b.tile_nearness(i % w, i / w).to_bits()).collect()
}

/// Everything that a buffer says.
fn all(b: &OcclusionBuffer, occludees: &[Aabb]) -> (Vec<u32>, Vec<u32>, Vec<Visibility>) {
    (pixels(b), tiles(b), results(b, occludees))
}

fn results(b: &OcclusionBuffer, occludees: &[Aabb]) -> Vec<Visibility> {
    occludees.iter().map(|t| b.test_box(t)).collect()
}

fn size() -> impl Strategy<Value = [u32; 2]> {
    [1..180_u32, 1..110_u32]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cullet_testkit::cases(96)))]

    #[test]
    fn every_simd_level_has_the_same_bits(
        drawn in prop::collection::vec(occluder(), 1..10),
        occludees in prop::collection::vec(occludee(), 20),
        (kind, reversed, size) in (0..3_u8, any::<bool>(), size()),
    ) {
        let view = view(kind, reversed);
        let best = all(&buffer(&view, size, Simd::best(), &drawn), &occludees);
        at_every_level!(|level| {
            let other = all(&buffer(&view, size, level, &drawn), &occludees);
            prop_assert!(other == best, "{level:?}");
        });
    }

    #[test]
    fn neither_order_nor_sharing_out_changes_a_bit(
        drawn in prop::collection::vec(occluder(), 1..12),
        order in prop::collection::vec(0..1000_usize, 12),
        occludees in prop::collection::vec(occludee(), 20),
        (kind, reversed, size) in (0..3_u8, any::<bool>(), size()),
    ) {
        let view = view(kind, reversed);
        let straight = all(&buffer(&view, size, Simd::best(), &drawn), &occludees);
        let mut shuffled: Vec<usize> = (0..drawn.len()).collect();
        shuffled.sort_by_key(|&i| order[i]);
        let again = buffer(&view, size, Simd::best(), shuffled.iter().map(|&i| &drawn[i]));
        prop_assert!(all(&again, &occludees) == straight);
        // Occluders already hidden are left out, and are not missed.
        let bounds: Vec<Aabb> = drawn.iter().map(Drawn::bounds).collect();
        let order: Vec<u32> = shuffled.iter().map(|&i| i as u32).collect();
        let boxes = Boxes::from_slice(&bounds);
        at_every_level!(|level| {
            let mut some = buffer(&view, size, level, []);
            let draw = |b: &mut OcclusionBuffer, i: u32| drawn[i as usize].draw_in(level, b);
            let count = some.draw_unless_hidden(level, (&boxes, &[]), &order, draw);
            prop_assert!(count <= drawn.len() && all(&some, &occludees) == straight);
        });
    }

    #[test]
    fn an_occluder_more_makes_nothing_visible(
        drawn in prop::collection::vec(occluder(), 2..12),
        occludees in prop::collection::vec(occludee(), 40),
        (kind, reversed, size) in (0..3_u8, any::<bool>(), size()),
    ) {
        let view = view(kind, reversed);
        let fewer = buffer(&view, size, Simd::best(), &drawn[1..]);
        let more = buffer(&view, size, Simd::best(), &drawn);
        for (a, b) in results(&fewer, &occludees).iter().zip(results(&more, &occludees)) {
            prop_assert!(*a == b || (*a, b) == (Visibility::Visible, Visibility::Hidden));
        }
        for (a, b) in pixels(&fewer).iter().zip(pixels(&more)) {
            prop_assert!(f32::from_bits(*a) <= f32::from_bits(b));
        }
    }

    #[test]
    fn what_shrinks_stays_hidden(
        drawn in prop::collection::vec(occluder(), 1..12),
        occludees in prop::collection::vec(occludee(), 40),
        (kind, reversed, size) in (0..3_u8, any::<bool>(), size()),
        (low, high) in (0.01..0.5_f32, 0.5..0.99_f32),
    ) {
        let view = view(kind, reversed);
        let buffer = buffer(&view, size, Simd::best(), &drawn);
        for occludee in &occludees {
            let at = |t: f32| {
                let [a, b] = [occludee.min, occludee.max];
                std::array::from_fn(|k| a[k] + (b[k] - a[k]) * t)
            };
            let small = Aabb { min: at(low), max: at(high) };
            match buffer.test_box(occludee) {
                // In part it may be out of the view.
                Visibility::Hidden => prop_assert_ne!(buffer.test_box(&small), Visibility::Visible),
                Visibility::Outside => prop_assert_eq!(buffer.test_box(&small), Visibility::Outside),
                Visibility::Visible => {}
            }
        }
    }

    #[test]
    fn a_world_and_camera_that_move_together_keep_their_answers(
        drawn in prop::collection::vec(occluder(), 1..10),
        occludees in prop::collection::vec(occludee(), 40),
        (kind, reversed, size) in (0..3_u8, any::<bool>(), size()),
        (power, axis, negative) in (0..24_u32, 0..3_usize, any::<bool>()),
    ) {
        let here = buffer(&view(kind, reversed), size, Simd::best(), &drawn);
        let mut by = [0.0; 3];
        by[axis] = f64::from(1_u32 << power) * if negative { -1.0 } else { 1.0 };
        let moved = View::new(&camera(kind, by), depth(reversed), [1280, 720]).unwrap();
        let mut there = OcclusionBuffer::new(size).unwrap();
        there.begin(&moved, by);
        drawn.iter().for_each(|d| d.draw(Simd::best(), &mut there, by));
        prop_assert_eq!(results(&there, &occludees), results(&here, &occludees));
    }

    #[test]
    fn mirrored_views_cover_the_same_pixels(
        drawn in prop::collection::vec(occluder(), 1..10),
        (kind, reversed, size) in (0..3_u8, any::<bool>(), size()),
        mirror in prop::sample::select(vec![vec![0_usize], vec![1], vec![0, 1]]),
    ) {
        // Whole tiles, so that they are tiles from either side.
        let size = [size[0].next_multiple_of(8), size[1].next_multiple_of(4)];
        let view = view(kind, reversed);
        let mut m = view.clip_from_world();
        mirror.iter().for_each(|r| (0..4).for_each(|c| m[c * 4 + r] = -m[c * 4 + r]));
        let mirrored = View::from_matrix(m, view.depth(), view.viewport()).unwrap();
        // Tiles have one nearness, and places are rounded from one corner, so not to the last bit.
        let [one, other] = [&view, &mirrored].map(|v| buffer(v, size, Simd::best(), &drawn));
        let flip = |v: u32, a: usize| if mirror.contains(&a) { size[a] - 1 - v } else { v };
        let differ = (0..size[0] * size[1]).filter(|i| {
            let (x, y) = (i % size[0], i / size[0]);
            let [a, b] = [one.nearness(x, y), other.nearness(flip(x, 0), flip(y, 1))];
            // Near the far plane a tile may be open by its farthest corner.
            a.min(b) <= 0.0 && a.max(b) > 0.05
        });
        prop_assert!(differ.count() <= 2);
    }

    #[test]
    fn what_a_coarse_buffer_hides_a_finer_one_hides(
        drawn in prop::collection::vec(occluder(), 1..10),
        occludees in prop::collection::vec(occludee(), 40),
        (kind, reversed, size) in (0..3_u8, any::<bool>(), size()),
        times in 2..5_u32,
    ) {
        // Of convex occluders alone: a pixel on a seam of patches is covered by all that meets in it, which a
        // finer pixel need not hold.
        let drawn: Vec<_> = drawn.iter().filter(|d| matches!(d, Drawn::Convex(..))).collect();
        let view = view(kind, reversed);
        let coarse = buffer(&view, size, Simd::best(), drawn.iter().copied());
        let fine = buffer(&view, size.map(|s| s * times), Simd::best(), drawn.iter().copied());
        // Where a box just touches what is before it, the rounding of depths decides, and each size has its own.
        let pairs = results(&coarse, &occludees).into_iter().zip(results(&fine, &occludees));
        let lost = pairs.filter(|(a, b)| *a == Visibility::Hidden && *b != Visibility::Hidden);
        prop_assert!(lost.count() <= 1);
    }
}

#[test]
fn what_is_behind_or_beside_is_not_drawn() {
    let view = view(0, true);
    let wall = |z: f32, x: f32| Aabb { min: [x - 2.0, -2.0, z - 0.2], max: [x + 2.0, 2.0, z] };
    // Near, behind it, beyond the edge, across the near plane.
    let boxes = [wall(-4.0, 0.0), wall(-9.0, 0.0), wall(-4.0, 90.0), wall(0.0, 0.0)];
    let all = Boxes::from_slice(&boxes);
    // What crosses the near plane has no size, and is drawn.
    for (least, expected) in [(&[][..], vec![0, 3]), (&[1e4; 4], vec![3]), (&[1.0; 4], vec![0, 3])]
    {
        let mut order = Vec::new();
        let mut buffer = buffer(&view, [160, 90], Simd::best(), []);
        let numbers = [0, 1, 2, 3];
        let count = buffer.draw_unless_hidden(Simd::best(), (&all, least), &numbers, |b, i| {
            order.push(i);
            let convex = Convex::from_box(&boxes[i as usize]).unwrap();
            convex.draw(Simd::best(), b, &Transform::IDENTITY);
        });
        assert_eq!((count, order), (expected.len(), expected));
    }
}
