//! Quantised planes: never a front face, the same at every level, and a floor on how
//! much they cull.

use cullet::cull::Indices;
use cullet::cull::backface::{Facing, Planes8};
use cullet_testkit::soups::facets;
use cullet_testkit::vectors::{dot, front};
use cullet_testkit::{Rng, at_every_level};

fn ones(words: &[u64]) -> u64 {
    words.iter().map(|w| u64::from(w.count_ones())).sum()
}

#[test]
fn nothing_in_front_is_culled() {
    let mut rng = Rng(7);
    let (positions, indices) = facets(&mut rng, 3000);
    let corners = |t: usize| [0, 1, 2].map(|k| positions[t * 3 + k]);
    let planes8 = Planes8::new(&positions, &indices);
    let (mut exact, mut by8) = (0, 0);
    for round in 0..200 {
        let far = if round % 10 == 0 { 0.5 } else { 1.2 + f64::from(round) * 0.02 };
        let d = rng.vector(1.0);
        let length = dot(d, d).sqrt();
        let d = d.map(|v| v / length * far);
        let eye = [d[0], d[1], d[2], if round % 7 == 0 { 0.0 } else { 1.0 }];
        let mut answers: Vec<Vec<u64>> = Vec::new();
        at_every_level!(|level_name, level| {
            let prepared = planes8.eye(eye, Facing::Back, 0.0).expect("an eye");
            let mut culled = vec![!0; 47];
            planes8.cull_words(level, &prepared, 0, &mut culled);
            assert_eq!(culled, planes8.cull_ref(&prepared), "{level_name}");
            // A word by itself is as in the whole.
            let mut word = [0];
            planes8.cull_words(level, &prepared, 46, &mut word);
            assert_eq!(word[0], culled[46], "{level_name}");
            answers.push(culled);
        });
        for t in 0..3000 {
            let (value, size) = front(corners(t), eye);
            exact += u64::from(value < 0.0);
            for culled in &answers {
                if culled[t / 64] >> (t % 64) & 1 == 1 {
                    assert!(value <= size * 1e-12, "triangle {t} from {eye:?}: {value}");
                }
            }
        }
        let prepared = planes8.eye(eye, Facing::Back, 0.0).expect("an eye");
        by8 += ones(&planes8.cull_ref(&prepared));
    }
    println!("of {exact}: {by8}");
    // A recorded floor, of the exact count at this seed.
    assert!(by8 * 1000 > exact * 950, "8 bits: {by8} of {exact}");
}

#[test]
fn invalid_inputs() {
    let planes = Planes8::new(&[[0.0; 3]; 3], &[0, 1, 2]);
    assert_eq!(planes.eye([f64::NAN; 4], Facing::Back, 0.0), None);
    let eye = planes.eye([1.0, 2.0, 3.0, 1.0], Facing::Back, 0.0).expect("an eye");
    assert_eq!(planes.cull_ref(&eye), [0], "a point has no back");
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
        for count in [1, 7, 40] {
            list.clear();
            for (i, words) in words.chunks(count).enumerate() {
                list.append_ones(level, words, (i * count * 64) as u32);
            }
            assert_eq!(*list, *expected, "{name}, {count} at once");
        }
    });
}
