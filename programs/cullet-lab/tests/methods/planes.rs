//! Planes in 8 and 16 bytes: never a front face, the same at every level, and a floor on how much
//! they cull.

use cullet::cull::Indices;
use cullet_lab::methods::{Bulk, Planes16, Planes32};
use cullet_testkit::vectors::{dot, front};
use cullet_testkit::{Rng, at_every_level};

/// One form of the planes, as built and by its oracle.
trait Form: Bulk<[f64; 4]> {
    fn of(positions: &[[f32; 3]], indices: &[u32]) -> Self;
    fn oracle(&self, eye: [f64; 4]) -> Vec<u64>;
}

macro_rules! forms {
    ($($planes:ty),*) => {$(
        impl Form for $planes {
            fn of(positions: &[[f32; 3]], indices: &[u32]) -> Self {
                Self::new(positions, indices)
            }
            fn oracle(&self, eye: [f64; 4]) -> Vec<u64> {
                self.cull_ref(eye)
            }
        }
    )*};
}
forms!(Planes16, Planes32);

#[test]
fn nothing_in_front_is_culled_and_hardly_anything_else_kept() {
    check::<Planes16>();
    check::<Planes32>();
}

fn check<P: Form>() {
    let mut rng = Rng(11);
    // Triangles of all sizes and directions, some thin and some points.
    let positions: Vec<[f32; 3]> = (0..900)
        .flat_map(|i| {
            let p = rng.vector(1.0);
            let size = [0.1, 1e-3, 0.0][usize::from(i % 9 == 0) + usize::from(i % 81 == 0)];
            [p, rng.vector(1.0), rng.vector(1.0)]
                .map(|v| [0, 1, 2].map(|k| (p[k] + (v[k] - p[k]) * size) as f32))
        })
        .collect();
    let indices: Vec<u32> = (0..positions.len() as u32).collect();
    let planes = P::of(&positions, &indices);
    assert_eq!(planes.count_all(), 900);
    let (mut culled, mut exact) = (0, 0);
    for round in 0..100 {
        let far = 0.3 + f64::from(round) * 0.05;
        let d = rng.direction();
        let weight = f64::from(round % 7 != 0);
        let eye = [d[0] * far, d[1] * far, d[2] * far, weight];
        let expected = planes.oracle(eye);
        let ones: u64 = expected.iter().map(|w| u64::from(w.count_ones())).sum();
        let bit = |t: usize| expected[t / 64] >> (t % 64) & 1 == 1;
        at_every_level!(|name, level| {
            let (mut mask, mut kept) = (vec![!0; 100], Indices::new());
            planes.cull(level, eye, &mut mask);
            assert_eq!(mask, expected, "{name}");
            assert_eq!(planes.count(level, eye), ones, "{name}");
            planes.keep(level, eye, &mut kept);
            let list = (0..900).filter(|&t| !bit(t)).map(|t| t as u32);
            assert!(kept.iter().copied().eq(list), "{name}");
            // Runs over the ends of words, single words, all, none; and bits of words that are not
            // there.
            for words in [u64::MAX, 0, 0x7ff1, 0b100_0000_0101] {
                planes.keep_in(level, eye, &[words], &mut kept);
                let wanted = |t: &usize| words >> (t / 64) & 1 == 1;
                let list = (0..900).filter(|t| wanted(t) && !bit(*t)).map(|t| t as u32);
                assert!(kept.iter().copied().eq(list), "{name}, {words:x}");
            }
        });
        for t in 0..900 {
            let corners = [0, 1, 2].map(|k| positions[t * 3 + k]);
            let (value, size) = front(corners, eye);
            assert!(!bit(t) || value <= size * 1e-12, "triangle {t} from {eye:?}: {value}");
            exact += u64::from(value < 0.0);
        }
        culled += ones;
        assert!(dot(d, d) > 0.9);
    }
    assert!(culled * 1000 > exact * 960, "{culled} of {exact}");
}
