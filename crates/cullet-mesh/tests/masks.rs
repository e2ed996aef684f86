//! Normal masks: never a front face, the same at every level, and a floor on how much they cull.

use cullet::Simd;
use cullet::bounds::Sphere;
use cullet_mesh::{BackfaceMask, MaskGrid, NormalMasks, ViewCone};
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
    let grids = [1, 2, 7, 16, 18].map(|n| MaskGrid::new(n).expect("a good N"));
    let masks = grids.each_ref().map(|grid| {
        let mut masks = NormalMasks::default();
        grid.encode_triangles(&positions, &indices, &mut masks);
        masks
    });
    let sphere = Sphere { center: [0.0; 3], radius: 1.1 };
    let (mut exact, mut by_mask) = (0, 0);
    for round in 0..200 {
        let far = if round % 10 == 0 { 0.5 } else { 1.2 + f64::from(round) * 0.02 };
        let d = rng.vector(1.0);
        let length = dot(d, d).sqrt();
        let d = d.map(|v| v / length * far);
        let eye = [d[0], d[1], d[2], if round % 7 == 0 { 0.0 } else { 1.0 }];
        let cone = ViewCone::to_sphere(eye, &sphere);
        assert_eq!(cone.is_some(), far > 1.1 || eye[3] == 0.0, "nothing is culled from inside");
        let mut answers: Vec<Vec<u64>> = Vec::new();
        at_every_level!(|level_name, level| {
            for (grid, masks) in grids.iter().zip(&masks) {
                let mask = grid.mask(level, cone.as_ref());
                assert!(cone.is_some() || mask == BackfaceMask::NOTHING);
                let mut culled = vec![!0; 47];
                masks.cull_words(level, &mask, 0, &mut culled);
                assert_eq!(culled, masks.cull_ref(&mask), "{level_name}");
                answers.push(culled);
            }
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
        let mask = grids[3].mask(Simd::best(), cone.as_ref());
        by_mask += ones(&masks[3].cull_ref(&mask));
    }
    println!("of {exact}: {by_mask}");
    // A recorded floor, of the exact count at this seed.
    assert!(by_mask * 1000 > exact * 200, "{by_mask} of {exact}");
}

#[test]
fn invalid_inputs() {
    assert!([0, 19, u32::MAX].iter().all(|&n| MaskGrid::new(n).is_none()));
    let grid = MaskGrid::new(16).expect("a good N");
    assert_eq!(grid.classes(), 1536);
    for bad in [[0.0; 3], [f64::NAN, 1.0, 0.0], [f64::INFINITY, 0.0, 0.0]] {
        assert_eq!(grid.encode(bad).bit_mask, 0);
    }
    assert!(ViewCone::around([0.0; 3], 0.1).is_none());
    assert!(ViewCone::around([1.0, 0.0, 0.0], 2.0).is_none());
}
