//! Normal masks and quantised planes: never a front face, the same at every level, and a floor on how
//! much they cull.

use cullet::Level;
use cullet::bounds::Sphere;
use cullet::cull::Indices;
use cullet::cull::backface::{
    BackfaceMask, Facing, MaskGrid, NormalMasks, Planes8, Planes16, ViewCone, count_masked,
    cull_masked, cull_masked_ref, keep_unmasked,
};
use cullet_testkit::vectors::{cross, dot, front};
use cullet_testkit::{Rng, at_every_level};

/// Small triangles all over a sphere, some of them slivers or points, wound outward.
fn triangles(rng: &mut Rng, count: usize) -> (Vec<[f32; 3]>, Vec<u32>) {
    let mut positions = Vec::new();
    for i in 0..count {
        let p = rng.vector(1.0);
        let length = dot(p, p).sqrt().max(1e-9);
        let p = p.map(|v| v / length);
        let (mut u, mut v) = (rng.vector(1.0), rng.vector(1.0));
        let size = if i % 50 == 0 { 1e-7 } else { 0.05 };
        for e in [&mut u, &mut v] {
            let along = dot(*e, p) * 0.7;
            (0..3).for_each(|k| e[k] = (e[k] - p[k] * along) * size);
        }
        if i % 70 == 0 {
            v = u;
        }
        if dot(cross(u, v), p) < 0.0 {
            (u, v) = (v, u);
        }
        let at = |e: [f64; 3]| std::array::from_fn(|k| (p[k] + e[k]) as f32);
        positions.extend([at([0.0; 3]), at(u), at(v)]);
    }
    let indices = (0..positions.len() as u32).collect();
    (positions, indices)
}

fn ones(words: &[u64]) -> u64 {
    words.iter().map(|w| u64::from(w.count_ones())).sum()
}

/// The numbers below `len` whose bits are 0.
fn unset(words: &[u64], len: u32) -> Vec<u32> {
    (0..len).filter(|&i| words[i as usize / 64] >> (i % 64) & 1 == 0).collect()
}

#[test]
fn nothing_in_front_is_culled() {
    let mut rng = Rng(7);
    let (positions, indices) = triangles(&mut rng, 3000);
    let corners = |t: usize| [0, 1, 2].map(|k| positions[t * 3 + k]);
    let grids = [1, 2, 7, 16, 18].map(|n| MaskGrid::new(n).expect("a good N"));
    let masks = grids.each_ref().map(|grid| {
        let mut masks = NormalMasks::default();
        grid.encode_triangles(&positions, &indices, &mut masks);
        masks
    });
    let planes8 = Planes8::new(&positions, &indices);
    let planes16 = Planes16::new(&positions, &indices);
    let sphere = Sphere { center: [0.0; 3], radius: 1.1 };
    let (mut exact, mut by8, mut by16, mut by_mask) = (0, 0, 0, 0);
    for round in 0..200 {
        let far = if round % 10 == 0 { 0.5 } else { 1.2 + f64::from(round) * 0.02 };
        let d = rng.vector(1.0);
        let length = dot(d, d).sqrt();
        let d = d.map(|v| v / length * far);
        let eye = [d[0], d[1], d[2], if round % 7 == 0 { 0.0 } else { 1.0 }];
        let cone = ViewCone::to_sphere(eye, &sphere);
        assert_eq!(cone.is_some(), far > 1.1 || eye[3] == 0.0, "nothing is culled from inside");
        let mut answers: Vec<(&str, Vec<u64>)> = Vec::new();
        at_every_level!(|level_name, level| {
            for (grid, masks) in grids.iter().zip(&masks) {
                let mask = grid.mask(level, cone.as_ref());
                assert!(cone.is_some() || mask == BackfaceMask::NOTHING);
                let (mut culled, mut kept) = (Vec::new(), Indices::new());
                cull_masked(level, masks, &mask, &mut culled);
                assert_eq!(culled, cull_masked_ref(masks, &mask), "{level_name}");
                assert_eq!(count_masked(level, masks, &mask), ones(&culled));
                keep_unmasked(level, masks, &mask, &mut kept);
                assert_eq!(*kept, *unset(&culled, 3000));
                answers.push(("mask", culled));
            }
            let (mut a, mut b) = (vec![!0; 100], Vec::new());
            planes8.cull(level, eye, &mut a);
            planes16.cull(level, eye, &mut b);
            for (mask, count) in [(&a, planes8.count(level, eye)), (&b, planes16.count(level, eye))]
            {
                assert_eq!(ones(mask), count, "{level_name}");
            }
            let mut kept = [Indices::new(), Indices::new()];
            planes8.keep(level, eye, &mut kept[0]);
            planes16.keep(level, eye, &mut kept[1]);
            for (kept, mask) in kept.iter().zip([&a, &b]) {
                assert_eq!(**kept, *unset(mask, 3000), "{level_name}");
            }
            assert_eq!(a, planes8.cull_ref(eye), "{level_name}");
            assert_eq!(b, planes16.cull_ref(eye), "{level_name}");
            answers.extend([("8", a), ("16", b)]);
        });
        for t in 0..3000 {
            let (value, size) = front(corners(t), eye);
            exact += u64::from(value < 0.0);
            for (name, culled) in &answers {
                if culled[t / 64] >> (t % 64) & 1 == 1 {
                    assert!(value <= size * 1e-12, "{name}: triangle {t} from {eye:?}: {value}");
                }
            }
        }
        by8 += ones(&planes8.cull_ref(eye));
        by16 += ones(&planes16.cull_ref(eye));
        let mask = grids[3].mask(Level::new(), cone.as_ref());
        by_mask += count_masked(Level::new(), &masks[3], &mask);
    }
    println!("of {exact}: 16 bits {by16}, 8 bits {by8}, masks {by_mask}");
    // Recorded floors, of the exact count at this seed.
    assert!(by16 * 1000 > exact * 970, "16 bits: {by16} of {exact}");
    assert!(by8 * 1000 > exact * 950, "8 bits: {by8} of {exact}");
    assert!(by_mask * 1000 > exact * 200, "masks: {by_mask} of {exact}");
}

#[test]
fn odd_inputs() {
    assert!([0, 19, u32::MAX].iter().all(|&n| MaskGrid::new(n).is_none()));
    let grid = MaskGrid::new(16).expect("a good N");
    assert_eq!(grid.classes(), 1536);
    for bad in [[0.0; 3], [f64::NAN, 1.0, 0.0], [f64::INFINITY, 0.0, 0.0]] {
        assert_eq!(grid.encode(bad).bit_mask, 0);
    }
    let planes = Planes8::new(&[[0.0; 3]; 3], &[0, 1, 2]);
    let mut culled = Vec::new();
    planes.cull(Level::new(), [f64::NAN; 4], &mut culled);
    assert_eq!(culled, [0]);
    planes.cull(Level::new(), [1.0, 2.0, 3.0, 1.0], &mut culled);
    assert_eq!(culled, [0], "a point has no back");
    assert!(ViewCone::around([0.0; 3], 0.1).is_none());
    assert!(ViewCone::around([1.0, 0.0, 0.0], 2.0).is_none());
}

#[test]
fn some_words_are_listed_as_in_the_whole() {
    let mut rng = Rng(23);
    let (positions, indices) = triangles(&mut rng, 64 * 130 + 7);
    let planes = Planes8::new(&positions, &indices);
    let eye = [2.0, 0.5, -1.0, 1.0];
    let prepared = planes.eye(eye, Facing::Back, 0.0).expect("an eye");
    let culled = planes.cull_ref(eye);
    let all = unset(&culled, planes.len() as u32);
    // Runs over the ends of 64 words, single words, all, none; and bits of words that are not there.
    for words in [[u64::MAX; 3], [0; 3], [0x8000_0000_0000_0001, 0xff00_0000_0000_000d, 0b101]] {
        let wanted = |t: &u32| words[*t as usize / 4096] >> (*t / 64 % 64) & 1 == 1;
        let expected: Vec<u32> = all.iter().copied().filter(wanted).collect();
        at_every_level!(|name, level| {
            let mut kept = Indices::new();
            planes.keep_in_words(level, &prepared, &words, &mut kept);
            assert_eq!(*kept, *expected, "{name}, {words:x?}");
        });
    }
}

#[test]
fn lists_are_appended_in_any_pieces() {
    let mut rng = Rng(29);
    let words: Vec<u64> = (0..40)
        .map(|i| match i % 4 {
            0 => 0,
            1 => u64::MAX,
            _ => (rng.index(1 << 30) as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15),
        })
        .collect();
    let expected: Vec<u32> =
        (0..40 * 64).filter(|&i| words[i as usize / 64] >> (i % 64) & 1 == 1).collect();
    at_every_level!(|name, level| {
        let mut list = Indices::new();
        for piece in [1, 7, 40] {
            list.clear();
            for (i, words) in words.chunks(piece).enumerate() {
                list.append_ones(level, words, (i * piece * 64) as u32);
            }
            assert_eq!(*list, *expected, "{name}, {piece} at once");
        }
    });
}
