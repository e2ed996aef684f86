//! Batches of boxes get the answer of one box at a time, at every SIMD level, with nodes or without.

use cullet::bounds::{Aabb, Boxes};
use cullet::cull::frustum::batch::mask_words;
use cullet::cull::occlusion::{Convex, OcclusionBuffer, Visibility};
use cullet::hierarchy::{Nodes, spatial_order};
use cullet::{Camera, Depth, Projection, Simd, Transform, View};
use cullet_testkit::at_every_level;
use proptest::prelude::*;

fn view(orthographic: bool, depth: Depth, eye: [f64; 3]) -> View {
    let projection = if orthographic {
        Projection::Orthographic {
            left: -9.0,
            right: 8.0,
            bottom: -5.0,
            top: 5.0,
            near: 0.1,
            far: 60.0,
        }
    } else {
        Projection::Perspective { fov_y_radians: 1.0, aspect: 1.7, near: 0.1, far: f64::INFINITY }
    };
    let at = [eye[0] - 0.2, eye[1] + 0.2, eye[2] - 10.0];
    View::new(&Camera::look_at(eye, at, projection), depth, [1280, 720]).unwrap()
}

fn occludee() -> impl Strategy<Value = Aabb> {
    let corner = (-9.0..9.0_f32, -6.0..6.0_f32, -30.0..3.0_f32);
    let plain = (corner, 0.0..2.0_f32, 0.0..2.0_f32, 0.0..2.0_f32)
        .prop_map(|((x, y, z), w, h, d)| Aabb { min: [x, y, z], max: [x + w, y + h, z + d] });
    let extreme = prop_oneof![
        Just(Aabb::EMPTY),
        Just(Aabb::EVERYTHING),
        Just(Aabb { min: [0.0, f32::NAN, -9.0], max: [1.0, 1.0, -8.0] }),
        Just(Aabb { min: [-1.0, -1.0, -9.0], max: [1.0, f32::INFINITY, -8.0] }),
        Just(Aabb { min: [-1e17, -1e17, -1e17], max: [1e17, 1e17, -20.0] }),
        Just(Aabb { min: [0.5, 0.5, -1e30], max: [0.6, 0.6, -9.0] }),
        Just(Aabb { min: [1e-30, 0.0, -1e-20], max: [2e-30, 0.0, -1e-21] }),
    ];
    prop_oneof![20 => plain, 1 => extreme]
}

/// A wall with a hole, a pillar, and some blocks.
fn occluders(blocks: &[Aabb]) -> Vec<Aabb> {
    let wall = |x0, x1, y0, y1| Aabb { min: [x0, y0, -7.0], max: [x1, y1, -6.5] };
    let mut all =
        vec![wall(-9.0, 1.0, -6.0, 5.0), wall(2.5, 9.0, -6.0, 2.0), wall(0.9, 2.6, -6.0, 0.0)];
    let is_small = |b: &&Aabb| b.min.iter().chain(&b.max).all(|v| v.abs() < 1e3);
    all.extend(blocks.iter().filter(is_small).take(12));
    all
}

fn at(b: &Aabb, by: [f64; 3]) -> Aabb {
    let to = |v: [f32; 3]| [0, 1, 2].map(|a| v[a] + by[a] as f32);
    Aabb { min: to(b.min), max: to(b.max) }
}

/// The oracle.
fn one_by_one(buffer: &OcclusionBuffer, boxes: &Boxes) -> Vec<Visibility> {
    (0..boxes.len()).map(|i| buffer.test_box(&boxes.get(i))).collect()
}

fn is_set(mask: &[u64], i: usize) -> bool {
    mask[i / 64] >> (i % 64) & 1 == 1
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cullet_testkit::cases(150)))]

    #[test]
    fn a_batch_hides_what_is_hidden_alone(
        blocks in prop::collection::vec(occludee(), 0..12),
        occludees in prop::collection::vec(occludee(), 1..600),
        size in (1..400_u32, 1..240_u32).prop_map(|(w, h)| [w, h]),
        (orthographic, reversed) in any::<(bool, bool)>(),
        away in prop_oneof![Just([0.0; 3]), Just([900.0, -40.0, 7000.0]), Just([3e5, 0.0, -2e5])],
        covered in 0..=600_usize,
    ) {
        let depth = if reversed { Depth::Reversed } else { Depth::Standard };
        // The origin stays, so that f32 has few digits left for what is far away.
        let eye = [0.3 + away[0], 0.2 + away[1], 0.4 + away[2]];
        let mut buffer = OcclusionBuffer::new(size).unwrap();
        buffer.begin(&view(orthographic, depth, eye), [0.0; 3]);
        for b in occluders(&blocks) {
            let place = Transform::from_translation(away);
            if let Ok(convex) = Convex::from_box(&b) {
                convex.draw(Simd::best(), &mut buffer, &place);
            }
        }
        let placed: Vec<Aabb> = occludees.iter().map(|b| at(b, away)).collect();
        let order = spatial_order(&placed);
        let sorted: Vec<Aabb> = order.iter().map(|&i| placed[i as usize]).collect();
        for items in [placed, sorted] {
            let boxes = Boxes::from_slice(&items);
            let alone = one_by_one(&buffer, &boxes);
            let words = mask_words(boxes.len());
            let wanted = vec![u64::MAX; words];
            let mut before = None;
            at_every_level!(|name, level| {
                let (mut visible, mut hidden) = (vec![0; words], vec![0; words]);
                buffer.test_boxes(level, &boxes, 0, &wanted, &mut visible, &mut hidden);
                for (i, visibility) in alone.iter().enumerate() {
                    let found = (is_set(&visible, i), is_set(&hidden, i));
                    let right = match visibility {
                        Visibility::Hidden => found.0 != found.1,
                        // A box a little off the screen for f64 may touch it for f32.
                        Visibility::Outside => true,
                        Visibility::Visible => found == (true, false),
                    };
                    prop_assert!(right, "{name}: {:?} is {visibility:?} alone, {found:?}", items[i]);
                }
                // Two halves of the masks are as good as the whole.
                let half = words / 2;
                let (mut a, mut b) = (vec![0; words], vec![0; words]);
                for part in [0..half, half..words] {
                    buffer.test_boxes(
                        level, &boxes, part.start, &wanted[part.clone()],
                        &mut a[part.clone()], &mut b[part],
                    );
                }
                prop_assert_eq!((&a, &b), (&visible, &hidden));
                // Whatever the nodes: over all, and over the first so many.
                let first = Boxes::from_slice(&items[..covered.min(items.len())]);
                for nodes in [Nodes::over(level, &boxes), Nodes::over(level, &first), Nodes::default()] {
                    let mut alive: Vec<u64> = (0..words)
                        .map(|w| u64::MAX >> (64 - (boxes.len() - w * 64).min(64)))
                        .collect();
                    buffer.hide_boxes(level, &nodes, &boxes, &mut alive);
                    for i in 0..boxes.len() {
                        prop_assert_eq!(is_set(&alive, i), is_set(&visible, i), "{} {}", name, i);
                    }
                }
                let answer = (visible, hidden);
                prop_assert_eq!(before.get_or_insert(answer.clone()), &answer, "{}", name);
            });
        }
    }
}

/// The floor: rounding costs a batch next to nothing of what is hidden.
#[test]
fn a_batch_finds_what_one_box_after_the_other_finds() {
    for (orthographic, away) in
        [(false, [0.0; 3]), (true, [0.0; 3]), (false, [2000.0, 0.0, -9000.0])]
    {
        let mut buffer = OcclusionBuffer::new([640, 360]).unwrap();
        let eye = [0.3 + away[0], 0.2 + away[1], 0.4 + away[2]];
        buffer.begin(&view(orthographic, Depth::Reversed, eye), [0.0; 3]);
        for b in occluders(&[]) {
            let place = Transform::from_translation(away);
            Convex::from_box(&b).unwrap().draw(Simd::best(), &mut buffer, &place);
        }
        let items: Vec<Aabb> = (0..20_000)
            .map(|i| {
                let v = [37, 91, 53].map(|step| (i * step % 1009) as f32 / 1009.0);
                let low = [v[0] * 16.0 - 8.0, v[1] * 10.0 - 5.0, -8.0 - 20.0 * v[2]];
                at(&Aabb { min: low, max: low.map(|v| v + 0.3) }, away)
            })
            .collect();
        let boxes = Boxes::from_slice(&items);
        let words = mask_words(items.len());
        let (mut visible, mut hidden) = (vec![0; words], vec![0; words]);
        let wanted = vec![u64::MAX; words];
        buffer.test_boxes(Simd::best(), &boxes, 0, &wanted, &mut visible, &mut hidden);
        let found: u32 = hidden.iter().map(|w| w.count_ones()).sum();
        let all = one_by_one(&buffer, &boxes);
        let all = all.iter().filter(|&&v| v == Visibility::Hidden).count();
        assert!(
            all > 5000 && f64::from(found) >= all as f64 * 0.998,
            "{found} of {all} at {away:?}"
        );
    }
}

#[test]
fn before_a_view_all_is_visible() {
    let buffer = OcclusionBuffer::new([64, 64]).unwrap();
    let boxes = Boxes::from_slice(&[Aabb::new([0.0; 3], [1.0; 3]); 70]);
    let (mut visible, mut hidden) = ([0; 2], [0; 2]);
    buffer.test_boxes(Simd::best(), &boxes, 0, &[u64::MAX; 2], &mut visible, &mut hidden);
    assert_eq!((visible, hidden), ([u64::MAX, 0x3f], [0, 0]));
}
