//! Cameras: what turning, moving and zooming keep.

use cullet::{Camera, Projection};
use cullet_viewer::camera::{Chase, Mode, Rig};
use cullet_viewer::journey::between;
use glam::DVec3;
use proptest::prelude::*;

fn near(a: [f64; 3], b: [f64; 3], tolerance: f64) -> bool {
    DVec3::from(a).distance(DVec3::from(b)) <= tolerance
}

prop_compose! {
    fn rig()(
        target in prop::array::uniform3(-100.0..100.0f64),
        distance in 0.1..100.0f64,
        yaw in -180.0..180.0f64,
        pitch in -80.0..80.0f64,
        fly in any::<bool>(),
    ) -> Rig {
        let mode = if fly { Mode::Fly } else { Mode::Orbit };
        Rig { mode, target, distance, yaw, pitch, ..Rig::default() }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cullet_testkit::cases(200), ..ProptestConfig::default() })]

    #[test]
    fn turning_keeps_the_target_or_the_eye(rig in rig(), yaw in -400.0..400.0f64, pitch in -400.0..400.0f64) {
        let mut turned = rig;
        turned.turn(yaw, pitch);
        prop_assert!(turned.check().is_ok());
        if rig.mode == Mode::Fly {
            prop_assert!(near(turned.eye(), rig.eye(), 1e-9));
        } else {
            prop_assert_eq!(turned.target, rig.target);
            let away = DVec3::from(turned.eye()).distance(DVec3::from(rig.target));
            prop_assert!((away - rig.distance).abs() < 1e-9);
        }
    }

    #[test]
    fn panning_by_the_height_of_the_picture_moves_the_target_out_of_it(rig in rig()) {
        let size = [400, 300];
        let view = rig.view(size).expect("a sound rig");
        let [x, y, _] = view.project_point(rig.target).expect("before the eye");
        prop_assert!((x - 200.0).abs() < 1e-3 && (y - 150.0).abs() < 1e-3, "{} {}", x, y);
        let mut panned = rig;
        panned.pan(0.0, 0.5);
        let view = panned.view(size).expect("a sound rig");
        // The point that was in the middle is now half a picture lower: at its lower edge.
        let [x, y, _] = view.project_point(rig.target).expect("before the eye");
        prop_assert!((x - 200.0).abs() < 1e-3 && (y - 300.0).abs() < 1e-3, "{} {}", x, y);
    }

    #[test]
    fn a_rig_of_its_own_camera_stands_and_looks_alike(rig in rig()) {
        let again = Rig::of(&rig.camera(1.5), rig.distance);
        prop_assert!(near(again.eye(), rig.eye(), 1e-6));
        prop_assert!(near(again.forward(), rig.forward(), 1e-9));
        prop_assert!((again.fov - rig.fov).abs() < 1e-9);
    }

    #[test]
    fn between_two_is_between(a in rig(), b in rig(), t in 0.0..1.0f64) {
        prop_assert!(near(between(&a, &b, 0.0).eye(), a.eye(), 1e-6));
        prop_assert!(near(between(&a, &b, 1.0).eye(), b.eye(), 1e-6));
        let whole = DVec3::from(a.eye()).distance(DVec3::from(b.eye()));
        let first = DVec3::from(a.eye()).distance(DVec3::from(between(&a, &b, t).eye()));
        prop_assert!((first - whole * t).abs() < 1e-6);
    }

    #[test]
    fn from_outside_the_culling_eye_is_seen(rig in rig(), reach in 1.0..1000.0f64) {
        let outside = rig.outside(rig.eye(), reach, &Chase::default());
        prop_assert!(outside.check().is_ok());
        let view = outside.view([500, 500]).expect("a sound rig");
        let [x, y, _] = view.project_point(rig.eye()).expect("before the eye");
        prop_assert!((0.0..500.0).contains(&x) && (0.0..500.0).contains(&y), "{} {}", x, y);
    }
}

#[test]
fn zooming_halves_the_distance_and_refuses_invalid_factors() {
    let mut rig = Rig { distance: 8.0, ..Rig::default() };
    rig.zoom(2.0);
    assert_eq!(rig.distance, 4.0);
    for invalid in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        rig.zoom(invalid);
        assert_eq!(rig.distance, 4.0);
    }
    let mut fly = Rig { mode: Mode::Fly, distance: 8.0, pitch: 0.0, yaw: 0.0, ..Rig::default() };
    let before = fly.eye();
    fly.zoom(2.0);
    assert_eq!(fly.distance, 8.0);
    assert!(near(fly.eye(), [before[0], before[1], before[2] - 4.0], 1e-9));
}

#[test]
fn from_above_north_is_up() {
    let top = Rig { mode: Mode::Top, yaw: 0.0, ..Rig::default() };
    let view = top.view([100, 100]).expect("a sound rig");
    let at = |p| view.project_point(p).expect("in a parallel view all is before the eye");
    assert!(at([0.0, 0.0, -1.0])[1] < 50.0, "-z is up");
    assert!(at([1.0, 0.0, 0.0])[0] > 50.0, "+x is right");
}

#[test]
fn headings_are_those_of_the_documentation() {
    let forward = |yaw| Rig { yaw, pitch: 0.0, ..Rig::default() }.forward();
    assert!(near(forward(0.0), [0.0, 0.0, -1.0], 1e-12));
    assert!(near(forward(90.0), [-1.0, 0.0, 0.0], 1e-12));
    let invalid = Camera {
        eye: [0.0; 3],
        direction: [f64::NAN; 3],
        up: [0.0; 3],
        projection: Projection::OffCentre {
            left: -0.5,
            right: 0.5,
            bottom: -0.5,
            top: 0.5,
            near: 1.0,
            far: 2.0,
        },
    };
    assert!(Rig::of(&invalid, f64::NAN).check().is_ok());
}
