//! Shadow casters: what throws a shadow that the view sees is never dropped, and most of the rest is.

use cullet::bounds::{Aabb, Boxes};
use cullet::cull::frustum::batch::{Planes, VISIBLE, reject_boxes};
use cullet::cull::shadow::{CasterReason, CasterRegion, Light};
use cullet::{Simd, View, view::Frustum};
use cullet_testkit::Rng;
use cullet_testkit::oracles::shadow::casts_into_ref;
use cullet_testkit::views::{random_view, view_and_moved};

fn random_light(rng: &mut Rng) -> Light {
    let range = if rng.below(3) == 0 { f64::INFINITY } else { rng.range(1.0, 60.0) };
    let position = rng.vector(25.0);
    match rng.below(3) {
        0 => {
            // Along an axis, planes of boxes lie along the light.
            let mut direction = rng.vector(1.0);
            if rng.below(3) == 0 {
                direction = [0.0, -2.0, 0.0];
            }
            Light::Directional { direction }
        }
        1 => Light::Point { position, range },
        _ => Light::Spot {
            position,
            direction: rng.vector(1.0),
            half_angle_radians: rng.range(0.1, 1.8),
            range,
        },
    }
}

fn random_receivers(rng: &mut Rng) -> Option<Aabb> {
    let centre = rng.vector(15.0);
    let half: [f64; 3] = std::array::from_fn(|_| rng.range(0.0, 20.0));
    let mut b = Aabb::rounded_out(
        std::array::from_fn(|a| centre[a] - half[a]),
        std::array::from_fn(|a| centre[a] + half[a]),
    );
    match rng.below(6) {
        0 => return None,
        1 => b.max[1] = b.min[1],
        2 => b.max[0] = f32::INFINITY,
        _ => {}
    }
    Some(b)
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn mix(a: [f64; 3], b: [f64; 3], t: f64) -> [f64; 3] {
    std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t)
}

/// Whether a light lights a point, if nothing is in the way.
fn lights(light: &Light, y: [f64; 3]) -> bool {
    let from = |p: [f64; 3]| std::array::from_fn(|i| y[i] - p[i]);
    match *light {
        Light::Point { position, range } => length(from(position)) <= range,
        Light::Spot { position, direction, half_angle_radians, range } => {
            let way = from(position);
            length(way) <= range
                && dot(way, direction) >= half_angle_radians.cos() * length(way) * length(direction)
        }
        _ => true,
    }
}

/// A point of the frustum that is in the receivers and lit; `None` if a hundred tries hit none.
fn lit_receiver(
    rng: &mut Rng,
    frustum: &Frustum,
    receivers: Option<&Aabb>,
    light: &Light,
) -> Option<[f64; 3]> {
    let corners = frustum.corners()?;
    (0..100).find_map(|_| {
        let y = match receivers {
            // Often on a face, an edge or a corner of the box, which bound the region.
            Some(b) if b.is_finite() => std::array::from_fn(|a| {
                let (min, max) = (f64::from(b.min[a]), f64::from(b.max[a]));
                match rng.below(4) {
                    0 => min,
                    1 => max,
                    _ => rng.range(min, max),
                }
            }),
            _ => {
                // A mixture of the corners, those at infinity by some way towards them.
                let (mut y, mut sum) = ([0.0; 3], 0.0);
                for c in corners {
                    let w = rng.range(0.0, 1.0).powi(4) + 1e-9;
                    let far = if c[3] == 0.0 { 40.0 } else { 1.0 };
                    (0..3).for_each(|a| y[a] += c[a] * w * far);
                    sum += w * c[3];
                }
                y.map(|v| v / sum)
            }
        };
        let held = receivers.is_none_or(|b| {
            (0..3).all(|a| f64::from(b.min[a]) <= y[a] && y[a] <= f64::from(b.max[a]))
        });
        (frustum.contains(y) && held && lights(light, y)).then_some(y)
    })
}

/// A point on the way from a receiver to the light.
fn on_the_way(rng: &mut Rng, light: &Light, y: [f64; 3]) -> [f64; 3] {
    match *light {
        Light::Directional { direction } => {
            let far = 10f64.powf(rng.range(-3.0, 6.0)) / length(direction);
            std::array::from_fn(|a| y[a] - direction[a] * far)
        }
        Light::Point { position, .. } | Light::Spot { position, .. } => {
            mix(y, position, rng.range(0.0, 1.0))
        }
        _ => y,
    }
}

/// A box with a point in it.
fn box_around(rng: &mut Rng, x: [f64; 3]) -> Aabb {
    let size = 10f64.powf(rng.range(-6.0, 1.5)) * rng.below(2) as f64;
    Aabb::rounded_out(x.map(|v| v - rng.range(0.0, size)), x.map(|v| v + rng.range(0.0, size)))
}

/// Why a caster does not matter, by the region and the planes that the frustum's own test is handed.
fn reason_of(region: &CasterRegion, caster: Aabb) -> Option<CasterReason> {
    let boxes = Boxes::from_slice(&[caster]);
    let mut plane = [VISIBLE];
    reject_boxes(Simd::best(), &Planes::new(region.frustum()), &boxes, 0, &mut plane);
    region.reason(&boxes.get(0), (plane[0] != VISIBLE).then_some(plane[0]))
}

fn keeps(region: &CasterRegion, caster: Aabb) -> bool {
    reason_of(region, caster).is_none()
}

fn wide_view() -> View {
    View::perspective([0.0, 2.0, 0.0], [0.0, 2.0, -1.0], 1.2, 0.1, 50.0, [640, 480]).expect("plain")
}

fn cube(centre: [f32; 3], half: f32) -> Aabb {
    Aabb::new(centre.map(|v| v - half), centre.map(|v| v + half))
}

const SUN: Light = Light::Directional { direction: [0.0, -1.0, 0.0] };

#[test]
fn what_is_between_a_lit_receiver_and_the_light_is_kept() {
    let mut rng = Rng(10);
    let mut tested = [0; 3];
    for _ in 0..3000 {
        let f = random_view(&mut rng).frustum();
        let (light, receivers) = (random_light(&mut rng), random_receivers(&mut rng));
        let region = CasterRegion::new(&f, receivers.as_ref(), &light);
        let grown = region.clone().with_margin(0.5);
        for _ in 0..4 {
            let Some(y) = lit_receiver(&mut rng, &f, receivers.as_ref(), &light) else { break };
            let x = on_the_way(&mut rng, &light, y);
            let b = box_around(&mut rng, x);
            let reason = reason_of(&region, b);
            assert_eq!(reason, None, "{b:?} shades {y:?} from {light:?}, receivers {receivers:?}");
            assert!(keeps(&grown, b));
            tested[match light {
                Light::Directional { .. } => 0,
                Light::Point { .. } => 1,
                _ => 2,
            }] += 1;
        }
    }
    assert!(tested.iter().all(|&n| n > 300), "the test must find casters: {tested:?}");
}

#[test]
fn the_planes_are_almost_as_tight_as_the_oracle() {
    let mut rng = Rng(11);
    let (mut needed, mut not_needed, mut dropped) = (0, 0, 0);
    for _ in 0..400 {
        let f = random_view(&mut rng).frustum();
        let (light, receivers) = (random_light(&mut rng), random_receivers(&mut rng));
        if f.corners().is_none() {
            continue;
        }
        let region = CasterRegion::new(&f, receivers.as_ref(), &light);
        let half = rng.range(0.1, 3.0) as f32;
        // Around what matters, or anywhere.
        let lit = lit_receiver(&mut rng, &f, receivers.as_ref(), &light);
        let middle = lit.map_or([0.0; 3], |y| match light {
            Light::Directional { direction } => {
                let far = rng.range(0.0, 20.0) / length(direction);
                std::array::from_fn(|a| y[a] - direction[a] * far)
            }
            _ => on_the_way(&mut rng, &light, y),
        });
        let aside = rng.vector(8.0);
        let centre: [f32; 3] = std::array::from_fn(|a| (middle[a] + aside[a]) as f32);
        let finite = receivers.filter(Aabb::is_finite);
        let oracle = |half: f32| casts_into_ref(&f, finite.as_ref(), &light, &cube(centre, half));
        // In between, rounding may decide.
        if oracle(half * 0.999) {
            let kept = keeps(&region, cube(centre, half));
            // The oracle knows the range only as a box.
            let in_range = match light {
                Light::Point { position, range } | Light::Spot { position, range, .. } => {
                    let away: [f64; 3] = std::array::from_fn(|a| {
                        (f64::from(centre[a]) - position[a]).abs() - f64::from(half)
                    });
                    length(away.map(|v| v.max(0.0))) < range
                }
                _ => true,
            };
            let reason = reason_of(&region, cube(centre, half));
            assert!(kept || !in_range, "{light:?} {receivers:?} {centre:?} {half}: {reason:?}");
            needed += 1;
        } else if !oracle(half * 1.001) {
            not_needed += 1;
            dropped += u32::from(!keeps(&region, cube(centre, half)));
        }
    }
    println!("{needed} matter; of {not_needed} that do not, {dropped} are dropped");
    assert!(needed > 60 && not_needed > 150, "{needed} {not_needed}");
    assert!(dropped * 100 >= not_needed * 97, "{dropped} of {not_needed}");
}

#[test]
fn a_light_that_is_none_keeps_all_and_one_that_lights_nothing_drops_all() {
    let f = wide_view().frustum();
    let behind = cube([0.0, 2.0, 500.0], 1.0);
    let at = |position, range| Light::Point { position, range };
    let spot = |direction, half_angle_radians, range| Light::Spot {
        position: [0.0; 3],
        direction,
        half_angle_radians,
        range,
    };
    let keep_all = [
        Light::Directional { direction: [0.0; 3] },
        Light::Directional { direction: [f64::NAN, 1.0, 0.0] },
        at([0.0, f64::INFINITY, 0.0], 5.0),
        at([f64::NAN; 3], 5.0),
        spot([0.0; 3], 0.5, 5.0),
        spot([1.0, f64::NAN, 0.0], 0.5, 5.0),
    ];
    for light in keep_all {
        let region = CasterRegion::new(&f, Some(&cube([0.0, 0.0, -9.0], 3.0)), &light);
        assert!(!region.no_receiver() && keeps(&region, behind), "{light:?}");
    }
    let nothing = [
        at([0.0; 3], 0.0),
        at([0.0; 3], -1.0),
        at([0.0, 0.0, 90.0], 5.0),
        spot([0.0, 0.0, -1.0], 0.0, 5.0),
        spot([0.0, 0.0, 1.0], 0.3, f64::INFINITY),
    ];
    for light in nothing {
        let region = CasterRegion::new(&f, None, &light);
        assert!(region.no_receiver() && !keeps(&region, Aabb::EVERYTHING), "{light:?}");
        assert_eq!(reason_of(&region, behind), Some(CasterReason::NoReceiver));
    }
    // A NaN range is none, a NaN angle no cone.
    let region = CasterRegion::new(&f, None, &spot([0.0, 1.0, 0.0], f64::NAN, f64::NAN));
    assert!(!region.no_receiver() && keeps(&region, cube([0.0, 2.0, -20.0], 1.0)));
}

#[test]
fn receivers_that_are_none_drop_all_and_doubtful_ones_are_the_whole_view() {
    let f = wide_view().frustum();
    let light_over = cube([0.0, 90.0, -20.0], 1.0);
    let empty = CasterRegion::new(&f, Some(&Aabb::EMPTY), &SUN);
    assert!(empty.no_receiver() && !keeps(&empty, light_over));
    let beside = CasterRegion::new(&f, Some(&cube([200.0, 0.0, -9.0], 1.0)), &SUN);
    assert!(beside.no_receiver(), "receivers outside the view");
    let whole = CasterRegion::new(&f, None, &SUN);
    for doubtful in [Aabb::EVERYTHING, Aabb::new([f32::NAN; 3], [1.0; 3])] {
        let region = CasterRegion::new(&f, Some(&doubtful), &SUN);
        assert_eq!(region.frustum(), whole.frustum());
    }
    assert!(keeps(&whole, light_over) && !keeps(&whole, cube([0.0, 90.0, 20.0], 1.0)));
}

#[test]
fn bounds_that_are_not_finite_are_kept_and_empty_ones_not() {
    let region = CasterRegion::new(&wide_view().frustum(), None, &SUN);
    let far = Aabb::new([1e30, 0.0, 0.0], [f32::INFINITY, 1.0, 1.0]);
    let nan = Aabb::new([1e6; 3], [f32::NAN; 3]);
    assert!([far, nan, Aabb::EVERYTHING].into_iter().all(|b| keeps(&region, b)));
    assert_eq!(reason_of(&region, Aabb::EMPTY), Some(CasterReason::OutsideSweep(u8::MAX)));
}

#[test]
fn a_lamp_in_the_view_asks_only_for_what_is_in_its_range_and_the_view() {
    let f = wide_view().frustum();
    let lamp = Light::Point { position: [0.0, 3.0, -10.0], range: 4.0 };
    let region = CasterRegion::new(&f, None, &lamp);
    let reason = |b: Aabb| reason_of(&region, b);
    assert_eq!(reason(cube([0.0, 3.0, -10.0], 0.1)), None, "a caster that holds the light");
    assert_eq!(reason(cube([2.0, 3.0, -10.0], 0.1)), None);
    assert_eq!(reason(cube([5.0, 3.0, -10.0], 0.5)), Some(CasterReason::BeyondRange));
    // In the corner of the box around the range.
    assert_eq!(reason(cube([3.0, 5.8, -13.0], 0.1)), Some(CasterReason::BeyondRange));
    assert!(keeps(&region.with_margin(2.0), cube([3.0, 5.8, -13.0], 0.1)));
}

#[test]
fn a_lamp_behind_the_camera_asks_for_what_is_on_its_way_into_the_view() {
    let f = wide_view().frustum();
    let lamp = Light::Point { position: [0.0, 2.0, 20.0], range: f64::INFINITY };
    let receivers = Aabb::new([-2.0, 0.0, -12.0], [2.0, 4.0, -10.0]);
    let region = CasterRegion::new(&f, Some(&receivers), &lamp);
    assert!(keeps(&region, cube([0.0, 2.0, 10.0], 0.2)));
    assert!(keeps(&region, cube([0.0, 2.0, 20.0], 5.0)), "a caster around the light");
    assert!(!keeps(&region, cube([2.0, 2.0, 10.0], 0.2)), "beside the way");
    assert!(!keeps(&region, cube([0.0, 2.0, 22.0], 0.5)), "behind the lamp");
    assert!(!keeps(&region, cube([0.0, 2.0, -14.0], 0.5)), "behind the receivers");
}

#[test]
fn a_spot_asks_only_for_what_is_in_its_cone() {
    let f = wide_view().frustum();
    let spot = Light::Spot {
        position: [0.0, 10.0, -10.0],
        direction: [0.0, -1.0, 0.0],
        half_angle_radians: 0.3,
        range: 30.0,
    };
    let region =
        CasterRegion::new(&f, Some(&Aabb::new([-20.0, 0.0, -40.0], [20.0, 0.5, -1.0])), &spot);
    let reason = |b: Aabb| reason_of(&region, b);
    assert_eq!(reason(cube([0.0, 6.0, -10.0], 0.2)), None);
    assert_eq!(reason(cube([3.0, 6.0, -10.0], 0.2)), Some(CasterReason::OutsideCone));
    assert_eq!(reason(cube([0.0, 11.0, -10.0], 0.2)), Some(CasterReason::OutsideCone));
    let below = reason(cube([0.0, -2.0, -10.0], 0.2));
    assert!(matches!(below, Some(CasterReason::OutsideSweep(_))), "{below:?}");
}

#[test]
fn views_without_end_and_without_perspective_have_regions() {
    let endless =
        View::perspective([0.0, 2.0, 0.0], [0.0, 2.0, -1.0], 1.2, 0.1, f64::INFINITY, [4, 3]);
    let flat = View::orthographic([0.0, 2.0, 0.0], [0.0, 2.0, -1.0], 10.0, 0.1, 50.0, [4, 3]);
    let slanted = Light::Directional { direction: [1.0, -1.0, 0.2] };
    for view in [endless.expect("plain"), flat.expect("plain")] {
        let f = view.frustum();
        for light in [SUN, slanted] {
            let region = CasterRegion::new(&f, None, &light);
            assert!(keeps(&region, cube([0.0, 2.0, -30.0], 0.5)));
            assert!(!keeps(&region, cube([0.0, -90.0, -30.0], 0.5)), "under the view");
            assert!(!keeps(&region, cube([0.0, 90.0, 90.0], 0.5)), "behind the camera");
        }
        let lamp = Light::Point { position: [0.0, 40.0, -20.0], range: f64::INFINITY };
        let region = CasterRegion::new(&f, None, &lamp);
        assert!(keeps(&region, cube([0.0, 30.0, -20.0], 0.5)));
        assert!(!keeps(&region, cube([0.0, 44.0, -20.0], 0.5)), "behind the lamp");
    }
    let lamp = Light::Point { position: [0.0; 3], range: f64::INFINITY };
    let all = CasterRegion::new(&Frustum::everything(), None, &lamp);
    assert!(all.frustum().planes().count() == 0 && keeps(&all, cube([1e6; 3], 1.0)));
}

#[test]
fn a_region_of_many_planes_stays_within_thirty_two() {
    let mut rng = Rng(13);
    for _ in 0..50 {
        // A view through a portal with 26 sides.
        let mut f = wide_view().frustum();
        while f.planes().count() < Frustum::MAX_PLANES {
            let centre = [0.0, 2.0, -10.0];
            let normal = rng.vector(1.0);
            let plane = cullet::bounds::Plane::from_point_normal(centre, normal);
            let Some(plane) = plane else { continue };
            f.push(cullet::bounds::Plane { d: plane.d + 2.0, ..plane }).expect("there is room");
        }
        let light = random_light(&mut rng);
        let region = CasterRegion::new(&f, Some(&cube([0.0, 2.0, -10.0], 4.0)), &light);
        assert!(region.frustum().planes().count() <= Frustum::MAX_PLANES);
        for _ in 0..20 {
            let y: [f64; 3] = std::array::from_fn(|a| [0.0, 2.0, -10.0][a] + rng.range(-2.0, 2.0));
            if f.contains(y) && lights(&light, y) {
                let x = on_the_way(&mut rng, &light, y);
                assert!(keeps(&region, Aabb::rounded_out(x, x)));
            }
        }
    }
}

#[test]
fn far_from_the_origin_nothing_is_lost() {
    let mut rng = Rng(14);
    let mut tested = 0;
    for _ in 0..400 {
        let offset = rng.vector(1e7);
        let (_, view) = view_and_moved(&mut rng, offset);
        let f = view.frustum();
        let light = match random_light(&mut rng) {
            Light::Point { position, range } => {
                Light::Point { position: std::array::from_fn(|a| position[a] + offset[a]), range }
            }
            other => other,
        };
        let region = CasterRegion::new(&f, None, &light);
        if let Some(y) = lit_receiver(&mut rng, &f, None, &light) {
            let x = on_the_way(&mut rng, &light, y);
            assert!(keeps(&region, Aabb::rounded_out(x, x)), "{light:?} {y:?}");
            tested += 1;
        }
    }
    assert!(tested > 150, "{tested}");
}

#[test]
fn the_planes_serve_other_tests() {
    let region = CasterRegion::new(&wide_view().frustum(), None, &SUN);
    let planes = Planes::new(region.frustum());
    let over = Aabb::new([-1.0, 89.0, -10.0], [1.0, 91.0, -8.0]);
    assert_eq!(planes.classify_box(&over), cullet::bounds::Side::Inside);
    let behind = Aabb::new([-1.0, 89.0, 8.0], [1.0, 91.0, 10.0]);
    assert_eq!(planes.classify_box(&behind), cullet::bounds::Side::Outside);
}

#[test]
fn what_is_beside_the_map_goes_and_the_rest_stays() {
    let f = wide_view().frustum();
    let from = [0.0, 40.0, -20.0];
    let map = View::perspective(from, [0.1, 0.0, -20.0], 0.2, 1.0, 60.0, [512, 512]).expect("good");
    let lamp = Light::Point { position: from, range: f64::INFINITY };
    let whole = CasterRegion::new(&f, None, &lamp);
    let region = whole.clone().within_map(&map.frustum());
    let [on_axis, beside] = [[0.0, 20.0, -20.0], [9.0, 20.0, -20.0]].map(|at| cube(at, 0.5));
    assert!(keeps(&whole, on_axis) && keeps(&region, on_axis) && keeps(&whole, beside));
    assert_eq!(reason_of(&region, beside), Some(CasterReason::OutsideMap));
}
