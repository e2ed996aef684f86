//! Files that move: a skinned bar, a morphed blob, and what is both, posed at times; every vertex stays in
//! its bounds, and a bound of another time is found out.

mod figures;

use cullet::bounds::Aabb;
use cullet::{Culler, Handle, View, ViewState, scene::BoundsOverride};
use cullet_draw::VerifyOptions;
use cullet_io::{LoadOptions, Model, load_bytes};
use cullet_scenes::paths::{self, Overrides};
use figures::{figures, twitching};

fn load(bytes: &[u8]) -> Model {
    load_bytes("figures.glb", bytes, &LoadOptions::default()).unwrap()
}

fn handle(model: &Model, name: &str) -> Handle {
    let slots = model.scene.slots().filter_map(|s| model.scene.handle(s));
    slots.into_iter().find(|h| model.instance_name(*h) == name).unwrap()
}

fn bounds(model: &Model, name: &str) -> Aabb {
    model.scene.bounds(model.scene.slot(handle(model, name)).unwrap())
}

/// The box around where an instance truly is.
fn truth(model: &Model, name: &str) -> [[f64; 3]; 2] {
    let slot = model.scene.slot(handle(model, name)).unwrap();
    let m = model.scene.transform(slot).to_matrix();
    let mut b = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for p in model.scene.mesh(slot).positions() {
        let p = p.map(f64::from);
        for a in 0..3 {
            let v = m[a] * p[0] + m[4 + a] * p[1] + m[8 + a] * p[2] + m[12 + a];
            (b[0][a], b[1][a]) = (b[0][a].min(v), b[1][a].max(v));
        }
    }
    b
}

#[track_caller]
fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-4, "{found} is not {expected}");
}

#[test]
fn every_posed_vertex_is_inside_its_bounds() {
    let mut model = load(&figures());
    assert_eq!(model.motion.as_ref().unwrap().seconds(), Some(4.0));
    for step in -3..40 {
        let t = f64::from(step) * 0.23;
        model.pose(t).unwrap();
        let violations = model.scene.audit(|_| None).unwrap();
        assert!(violations.is_empty(), "at {t} s: {violations:?}");
        for name in ["bar", "blob", "both", "cart", "twin"] {
            let (b, [low, high]) = (bounds(&model, name), truth(&model, name));
            assert!(b.is_finite(), "{name} at {t} s has no bounds");
            // Not by keeping everything: no side is farther out than the figures are large.
            for a in 0..3 {
                let loose = (low[a] - f64::from(b.min[a])).max(f64::from(b.max[a]) - high[a]);
                assert!(loose < 2.5, "{name} at {t} s is loose by {loose}");
            }
        }
    }
}

#[test]
fn poses_are_those_of_the_keys() {
    let mut model = load(&figures());
    // Bar: 4 high, its upper half turns about z at y = 2: by 90 degrees at 1 s, so the tip points to -x.
    model.pose(1.0).unwrap();
    let [low, high] = truth(&model, "bar");
    near(low[0], 10.0 - 2.0);
    near(high[1], 2.25);
    // Halfway it is turned by 45 degrees; the tip's corner is 0.25 to the side.
    model.pose(0.5).unwrap();
    let half = std::f64::consts::FRAC_1_SQRT_2;
    near(truth(&model, "bar")[1][1], 2.0 + 2.25 * half);
    // Blob: cubic weights with flat tangents, 0 to 1 over 2 s, pull its top up by 3.
    model.pose(1.0).unwrap();
    near(truth(&model, "blob")[1][1], 1.0 + 1.5);
    model.pose(2.0).unwrap();
    near(truth(&model, "blob")[1][1], 4.0);
    // Cart: it jumps at 2 s, and not before.
    model.pose(1.9).unwrap();
    near(truth(&model, "cart")[0][0], 20.0);
    model.pose(2.0).unwrap();
    near(truth(&model, "cart")[0][0], 26.0);
    // Four seconds later all is as it was; so it is four seconds earlier.
    let at_start = {
        model.pose(0.7).unwrap();
        ["bar", "both", "blob", "cart"].map(|n| truth(&model, n))
    };
    for t in [4.7, -3.3] {
        model.pose(t).unwrap();
        for (name, expected) in ["bar", "both", "blob", "cart"].into_iter().zip(at_start) {
            let found = truth(&model, name);
            (0..3).for_each(|a| near(found[0][a], expected[0][a]));
            (0..3).for_each(|a| near(found[1][a], expected[1][a]));
        }
    }
}

#[test]
fn nodes_that_share_a_mesh_deform_on_their_own() {
    let mut model = load(&figures());
    model.pose(2.0).unwrap();
    // `twin` has the blob's mesh and weights of its own that no animation moves.
    near(truth(&model, "blob")[1][1], 4.0);
    near(truth(&model, "twin")[1][1], 1.0 + 0.5 * 3.0);
    let slots: Vec<u32> = model.scene.slots().collect();
    model.pose(3.0).unwrap();
    assert_eq!(slots, model.scene.slots().collect::<Vec<_>>());
    model.scene.hierarchy().validate().unwrap();
}

#[test]
fn a_bound_of_another_time_is_found() {
    let mut model = load(&figures());
    for name in ["bar", "blob", "both"] {
        model.pose(0.0).unwrap();
        let old = bounds(&model, name);
        model.pose(1.3).unwrap();
        let h = handle(&model, name);
        model.scene.set_bounds(h, BoundsOverride::World(old)).unwrap();
        let violations = model.scene.audit(|_| None).unwrap();
        assert_eq!(violations.len(), 1, "{name}: {violations:?}");
        assert_eq!(violations[0].handle, h);
        assert!(violations[0].excess > 0.5, "{violations:?}");
    }
}

/// How many false culls a view of the upper left of the bar has.
fn lost(model: &Model) -> usize {
    let (size, overrides) = ([160, 90], Overrides::default());
    // Only where the bent bar reaches: the upright one is outside to the right.
    let camera = paths::look_at(model, [8.3, 2.0, 1.0], [8.3, 2.0, 0.0], size, &overrides).unwrap();
    let view = View::new(&camera, overrides.depth, size).unwrap();
    let mut state = ViewState::default();
    let options = VerifyOptions { samples: 2, ..VerifyOptions::default() };
    let v = cullet_draw::verify(&model.scene, &view, &Culler::default(), &mut state, &options);
    assert!(v.visible > 0, "the bar is in sight");
    v.false_culls.len()
}

/// How many false culls the views of an orbit around all have.
fn lost_in_the_open(model: &Model) -> usize {
    let (size, overrides) = ([160, 90], Overrides::default());
    let cameras = paths::cameras(model, &"orbit".parse().unwrap(), 4, size, &overrides).unwrap();
    let mut state = ViewState::default();
    let mut lost = 0;
    for camera in &cameras {
        let view = View::new(camera, overrides.depth, size).unwrap();
        let options = VerifyOptions { samples: 2, ..VerifyOptions::default() };
        let v = cullet_draw::verify(&model.scene, &view, &Culler::default(), &mut state, &options);
        assert!(v.visible > 0, "nothing is in sight");
        lost += v.false_culls.len();
    }
    lost
}

#[test]
fn a_bound_of_another_time_costs_pixels() {
    let mut model = load(&figures());
    model.pose(0.0).unwrap();
    let old = bounds(&model, "bar");
    for t in [0.0, 0.4, 1.0, 1.7, 2.5] {
        model.pose(t).unwrap();
        assert_eq!(lost_in_the_open(&model), 0, "at {t} s");
    }
    model.pose(1.0).unwrap();
    assert_eq!(lost(&model), 0);
    let h = handle(&model, "bar");
    model.scene.set_bounds(h, BoundsOverride::World(old)).unwrap();
    model.scene.refit();
    assert!(!model.scene.audit(|_| None).unwrap().is_empty());
    assert!(lost(&model) > 0, "the stale bound hides nothing");
    model.pose(1.0).unwrap();
    assert_eq!(lost(&model), 0);
}

#[test]
fn models_that_stand_still_stay_as_they_are() {
    let mut model = cullet_scenes::build("solids").unwrap();
    assert!(model.motion.is_none());
    let version = model.scene.change_version();
    model.pose(3.0).unwrap();
    assert_eq!(model.scene.change_version(), version);
}

#[test]
fn the_built_in_scene_is_posed_as_it_is_built() {
    let mut moved = cullet_scenes::build("moving:n=24,t=500").unwrap();
    moved.pose(1.0).unwrap();
    let built = cullet_scenes::build("moving:n=24,t=1500").unwrap();
    assert!(moved.scene.audit(|_| None).unwrap().is_empty());
    for slot in built.scene.slots() {
        let h = built.scene.handle(slot).unwrap();
        let at = moved.scene.slot(h).unwrap();
        assert_eq!(built.scene.bounds(slot), moved.scene.bounds(at));
        assert_eq!(built.scene.transform(slot), moved.scene.transform(at));
        assert_eq!(built.scene.mesh(slot).positions(), moved.scene.mesh(at).positions());
    }
    let error = moved.pose(-9.0).unwrap_err().to_string();
    assert!(error.contains("t=-8500"), "{error}");
    let error = moved.pose(f64::NAN).unwrap_err().to_string();
    assert!(error.contains("finite"), "{error}");
    moved.pose(0.0).unwrap();
}

#[test]
fn a_figure_that_overflows_is_named_and_can_be_posed_again() {
    let mut model = load(&twitching());
    model.pose(0.0).unwrap();
    let error = model.pose(0.9).unwrap_err().to_string();
    assert!(error.starts_with("blob at 0.9 s: vertex"), "{error}");
    model.pose(0.0).unwrap();
    assert!(model.scene.audit(|_| None).unwrap().is_empty());
}
