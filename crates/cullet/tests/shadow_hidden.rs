//! Casters hidden from the light: what they would shade is in shadow already.

use cullet::bounds::Aabb;
use cullet::cull::occlusion::{Convex, OcclusionBuffer, Shape};
use cullet::cull::shadow::drop_unlit;
use cullet::{Level, Transform, View};
use cullet_testkit::Rng;

/// Whether the open way from a point towards the light meets a box, which is where it is shaded (slabs, in f64).
fn is_shaded(b: &Aabb, point: [f64; 3], to_light: [f64; 3]) -> bool {
    let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
    for a in 0..3 {
        let (low, high) = (f64::from(b.min[a]), f64::from(b.max[a]));
        if to_light[a] == 0.0 {
            if point[a] < low || point[a] > high {
                return false;
            }
            continue;
        }
        let (s, t) = ((low - point[a]) / to_light[a], (high - point[a]) / to_light[a]);
        enter = enter.max(s.min(t));
        leave = leave.min(s.max(t));
    }
    enter < leave
}

/// Boxes over a floor of 40 × 40.
fn random_box(rng: &mut Rng, size: f64) -> Aabb {
    let low = [rng.range(-18.0, 16.0), rng.range(0.2, 15.0), rng.range(-18.0, 16.0)];
    let side: [f64; 3] = std::array::from_fn(|_| rng.range(0.1, size));
    Aabb::new(
        low.map(|v| v as f32),
        std::array::from_fn::<f32, 3, _>(|a| (low[a] + side[a]) as f32),
    )
}

#[test]
fn a_caster_hidden_from_the_light_shades_nothing_of_its_own() {
    let mut rng = Rng(12);
    let (mut dropped_in_all, mut shaded_points) = (0, 0);
    for _ in 0..40 {
        let casters: Vec<Aabb> =
            (0..60).map(|i| random_box(&mut rng, if i < 8 { 12.0 } else { 2.0 })).collect();
        let to_light = [rng.range(-0.6, 0.6), 1.0, rng.range(-0.6, 0.6)];
        let eye = to_light.map(|v| v * 60.0);
        let light = View::orthographic(eye, [0.0; 3], 80.0, 0.1, 200.0, [1024, 1024]).unwrap();
        let shapes: Vec<Shape> =
            casters.iter().map(|b| Shape::Convex(Convex::from_box(b).unwrap())).collect();
        let occluders: Vec<_> = shapes.iter().map(|s| (s, Transform::IDENTITY)).collect();
        let mut buffer = OcclusionBuffer::new([256, 256]).unwrap();
        let mut kept = vec![u64::MAX];
        let dropped = drop_unlit(
            Level::new(),
            &mut buffer,
            &light,
            [0.0; 3],
            &occluders,
            &casters,
            &mut kept,
        );
        let is_kept = |i: usize| kept[0] >> i & 1 == 1;
        assert_eq!((0..60).filter(|&i| !is_kept(i)).count(), dropped);
        dropped_in_all += dropped;
        // Any point that is in a dropped caster's shadow, and beyond the caster, is in that of one which is left.
        for (i, caster) in casters.iter().enumerate().filter(|(i, _)| !is_kept(*i)) {
            for _ in 0..200 {
                let on: [f64; 3] = std::array::from_fn(|a| {
                    rng.range(f64::from(caster.min[a]), f64::from(caster.max[a]))
                });
                let below = on[1] * rng.range(0.0, 1.0);
                let point = std::array::from_fn(|a| on[a] - to_light[a] * below);
                if is_shaded(caster, point, to_light) {
                    shaded_points += 1;
                    let others = casters.iter().enumerate().filter(|(k, _)| is_kept(*k));
                    let shaded = others.into_iter().any(|(_, b)| is_shaded(b, point, to_light));
                    assert!(shaded, "{point:?} is in the shadow of caster {i} alone");
                }
            }
        }
    }
    println!("{dropped_in_all} dropped, {shaded_points} points in their shadows");
    // Keeping everything would pass the rest.
    assert!(dropped_in_all >= 40, "{dropped_in_all} dropped");
    assert!(shaded_points > 1000, "{shaded_points}");
}

#[test]
fn a_caster_out_of_the_light_or_without_bounds_is_kept() {
    let wall = Aabb { min: [-50.0, 9.0, -50.0], max: [50.0, 10.0, 50.0] };
    let shape = Shape::Convex(Convex::from_box(&wall).unwrap());
    let light = View::orthographic([0.0, 60.0, 0.0], [0.0; 3], 40.0, 0.1, 200.0, [64, 64]).unwrap();
    let casters = [
        Aabb { min: [0.0; 3], max: [1.0; 3] },
        wall,
        Aabb { min: [f32::NAN; 3], max: [1.0; 3] },
        Aabb { min: [-1.0; 3], max: [f32::INFINITY; 3] },
        Aabb { min: [30.0, 0.0, 0.0], max: [31.0, 1.0, 1.0] },
        Aabb { min: [0.0, 20.0, 0.0], max: [1.0, 21.0, 1.0] },
        Aabb { min: [0.0; 3], max: [1.0; 3] },
    ];
    // The last was dropped before: it is neither brought back nor counted.
    let mut kept = vec![0b11_1111];
    let mut buffer = OcclusionBuffer::new([64, 64]).unwrap();
    let occluders = [(&shape, Transform::IDENTITY)];
    let dropped =
        drop_unlit(Level::new(), &mut buffer, &light, [0.0; 3], &occluders, &casters, &mut kept);
    assert_eq!((dropped, kept[0]), (1, 0b11_1110));
}
