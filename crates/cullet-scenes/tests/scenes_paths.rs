//! Camera paths over the built-in scenes.

use std::path::PathBuf;

use cullet::{Camera, Depth, Projection, View};
use cullet_io::{CameraNode, Model};
use cullet_scenes::paths::{self, Overrides, PathError, PathSpec};
use cullet_testkit::cases;
use glam::{DMat3, DMat4, DVec3};

const VIEWPORT: [u32; 2] = [1280, 720];

const SCENES: [&str; 5] = [
    "city:cells=30,objects=9000",
    "city:cells=5,objects=0,ground=0",
    "solids",
    "office:rooms=4,corridors=2",
    "forest:n=20000",
];

fn spec(text: &str) -> PathSpec {
    text.parse().unwrap()
}

fn cameras(model: &Model, path: &str, count: usize) -> Vec<Camera> {
    paths::cameras(model, &spec(path), count, VIEWPORT, &Overrides::default()).unwrap()
}

/// The instances whose closed surface is around a point, by the parity of crossings of a ray: another
/// method than the one under test.
fn around(model: &Model, eye: [f64; 3]) -> Vec<String> {
    let scene = &model.scene;
    let along = DVec3::new(0.6180339, 0.2113248, 0.7548776);
    let inside = |slot: &u32| {
        let mesh = scene.mesh(*slot);
        let solid = mesh.parts().iter().all(|p| !p.two_sided);
        if !solid || !scene.bounds(*slot).contains(eye.map(|v| v as f32)) {
            return false;
        }
        let t = scene.transform(*slot);
        let [x, y, z] = t.linear.map(|c| DVec3::from(c.map(f64::from)));
        let m = DMat3::from_cols(x, y, z);
        let crossings = (0..mesh.triangle_count()).filter(|i| {
            let [a, b, c] = mesh
                .corners(*i)
                .map(|p| m * DVec3::from(p.map(f64::from)) + DVec3::from(t.translation));
            let (e1, e2, s) = (b - a, c - a, DVec3::from(eye) - a);
            let (p, q) = (along.cross(e2), s.cross(e1));
            let det = e1.dot(p);
            let (u, v, d) = (s.dot(p) / det, along.dot(q) / det, e2.dot(q) / det);
            u >= 0.0 && v >= 0.0 && u + v <= 1.0 && d >= 0.0
        });
        crossings.count() % 2 == 1
    };
    let names = scene.slots().filter(inside);
    names.map(|s| model.instance_name(scene.handle(s).unwrap()).into_owned()).collect()
}

#[test]
fn no_path_stands_in_a_wall() {
    for text in SCENES {
        let model = cullet_scenes::build(text).unwrap();
        for path in ["orbit", "walk", "fly", "camera:*"] {
            if path == "camera:*" && model.cameras.is_empty() {
                continue;
            }
            for seed in 0..cases(4).min(3).into() {
                let overrides = Overrides { seed, ..Overrides::default() };
                let cameras =
                    paths::cameras(&model, &spec(path), 32, VIEWPORT, &overrides).unwrap();
                assert_eq!(cameras.len(), 32, "{text} {path}");
                for (i, c) in cameras.iter().enumerate() {
                    let walls = around(&model, c.eye);
                    assert!(walls.is_empty(), "{text} {path} {i}: {:?} in {walls:?}", c.eye);
                }
            }
        }
    }
}

#[test]
fn the_oracle_knows_an_inside() {
    let model = cullet_scenes::build("city:cells=5,objects=0,ground=0").unwrap();
    assert_eq!(around(&model, [0.1, 3.0, 0.2]).len(), 1);
    assert!(around(&model, [12.0, 3.0, 12.0]).is_empty());
}

#[test]
fn a_walk_is_at_eye_height_and_sees_something() {
    for text in ["city:cells=30,objects=9000", "office:rooms=4,corridors=2", "forest:n=20000"] {
        let model = cullet_scenes::build(text).unwrap();
        let cameras = cameras(&model, "walk", 16);
        for c in &cameras {
            if text.starts_with("city") {
                assert!((c.eye[1] - 1.7).abs() < 1e-6, "{text}: {:?}", c.eye);
            }
            if text.starts_with("office") {
                let indoors = model.cells.cells.iter().any(|cell| cell.contains(c.eye));
                assert!(indoors || c.eye[1] < 1.7, "{:?} on the roof", c.eye);
            }
            assert_eq!(c.direction[1], 0.0);
        }
        // Not all at one place.
        let far = |c: &Camera| DVec3::from(c.eye).distance(cameras[0].eye.into());
        assert!(cameras.iter().any(|c| far(c) > 10.0));
    }
}

#[test]
fn an_orbit_fills_the_picture_with_what_is_drawn() {
    // And a cone on its tip, whose box is half empty.
    let mut cone = Model::default();
    let rim = (0..24).map(|i| (f64::from(i) / 24.0 * std::f64::consts::TAU).sin_cos());
    let mut positions: Vec<[f32; 3]> = rim.map(|(s, c)| [s as f32, 0.0, c as f32]).collect();
    positions.push([0.0, -3.0, 0.0]);
    let indices = (0..24).flat_map(|i| [i, (i + 1) % 24, 24]).collect();
    let data = cullet::MeshData { positions, indices, ..cullet::MeshData::default() };
    let mesh = cone.scene.add_mesh(cullet::Mesh::new(data).unwrap());
    let place =
        cullet::Transform { translation: [900.0, -4.0, 7.0], ..cullet::Transform::IDENTITY };
    cone.scene.add(cullet::Instance::new(mesh, place)).unwrap();
    cone.scene.commit(&cullet::Culler::default());
    let models = SCENES.iter().map(|text| cullet_scenes::build(text).unwrap()).chain([cone]);
    for model in models {
        let scene = &model.scene;
        let vertices = || {
            scene.slots().flat_map(|slot| {
                let (m, own) = (scene.transform(slot).to_matrix(), scene.mesh(slot));
                let m = DMat4::from_cols_array(&m);
                // A mesh that deforms may be anywhere within its bounds.
                let set = scene.transform(slot).transform_box(&own.bounds(), scene.origin())
                    != scene.bounds(slot);
                let bounds = scene.bounds(slot).corners().map(|c| DVec3::from(c.map(f64::from)));
                let positions = own.positions().iter().filter(move |_| !set);
                let placed =
                    positions.map(move |p| m.transform_point3(DVec3::from(p.map(f64::from))));
                placed.chain(bounds.into_iter().filter(move |_| set))
            })
        };
        for viewport in [VIEWPORT, [200, 900]] {
            for fov in [20.0, 60.0, 110.0] {
                let overrides = Overrides { fov_degrees: Some(fov), ..Overrides::default() };
                let views =
                    paths::views(&model, &PathSpec::Orbit, 3, viewport, &overrides).unwrap();
                for v in views {
                    let m = DMat4::from_cols_array(&v.clip_from_world());
                    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
                    let mut nearest = f64::INFINITY;
                    for p in vertices() {
                        let p = m * p.extend(1.0);
                        assert!(p.z >= 0.0 && p.z <= p.w, "{}: clipped by near or far", model.name);
                        for (k, v) in [p.x / p.w, p.y / p.w].into_iter().enumerate() {
                            (low[k], high[k]) = (low[k].min(v), high[k].max(v));
                        }
                        nearest = nearest.min(p.w);
                    }
                    // One way the picture is full, the other way its contents are in the middle.
                    let full = [0, 1].map(|k| high[k].max(-low[k]));
                    let both = full[0].max(full[1]);
                    let what = format!("{} {fov} {viewport:?}: {low:?} {high:?}", model.name);
                    // Or else the eye would come too near to something.
                    let close = nearest
                        < 0.1001
                            * DVec3::from(scene.extent().half_extent().map(f64::from)).length();
                    assert!(both < 0.9501 && (both > 0.9499 || close), "{what}");
                    assert!((0..2).all(|k| (high[k] + low[k]).abs() < 0.03), "{what}");
                }
            }
        }
    }
}

#[test]
fn near_and_far_fit_unless_given() {
    let model = cullet_scenes::build("city:cells=10,objects=100").unwrap();
    for path in ["orbit", "walk", "fly"] {
        for c in cameras(&model, path, 9) {
            let [near, far] = paths::range(&c.projection);
            let b = model.scene.extent();
            let corner = |v: [f32; 3]| DVec3::from(v.map(f64::from));
            let eye = DVec3::from(c.eye);
            let nearest = eye.distance(eye.clamp(corner(b.min), corner(b.max)));
            let size = corner(b.min).distance(corner(b.max));
            assert!(near > 0.0 && (near < nearest || near <= 1.0001e-5 * size), "{path}: {near}");
            let farthest =
                b.corners().map(|p| corner(p).distance(eye)).into_iter().fold(0.0, f64::max);
            assert!(far >= farthest && far < farthest * 1.1, "{path}: {far} {farthest}");
        }
    }
    let given = Overrides {
        near: Some(0.25),
        far: Some(f64::INFINITY),
        fov_degrees: Some(40.0),
        depth: Depth::Reversed,
        seed: 0,
    };
    let cameras = paths::cameras(&model, &PathSpec::Walk, 2, VIEWPORT, &given).unwrap();
    let Projection::Perspective { fov_y_radians, aspect, near, far } = cameras[1].projection else {
        panic!("{:?}", cameras[1]);
    };
    assert_eq!((fov_y_radians.to_degrees().round(), near, far), (40.0, 0.25, f64::INFINITY));
    assert_eq!(aspect, 1280.0 / 720.0);
    let views = paths::views(&model, &PathSpec::Walk, 2, VIEWPORT, &given).unwrap();
    assert_eq!(views[0].depth(), Depth::Reversed);
    // One of the two alone never contradicts the other.
    for (near, far) in [(Some(1e6), None), (None, Some(1e-6))] {
        let o = Overrides { near, far, ..Overrides::default() };
        paths::views(&model, &PathSpec::Orbit, 2, VIEWPORT, &o).unwrap();
    }
}

#[test]
fn the_same_seed_gives_the_same_path() {
    let model = cullet_scenes::build("office:rooms=3,corridors=1").unwrap();
    let with = |path: &str, seed| {
        let o = Overrides { seed, ..Overrides::default() };
        paths::cameras(&model, &spec(path), 8, VIEWPORT, &o).unwrap()
    };
    for path in ["orbit", "walk", "fly"] {
        assert_eq!(with(path, 3), with(path, 3));
        assert_ne!(with(path, 3), with(path, 4), "{path}");
    }
}

/// A directory of its own for a test's files.
fn scratch(name: &str) -> PathBuf {
    let dir = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&dir).unwrap();
    dir
}

fn from_file(name: &str, text: &str, count: usize) -> Result<Vec<Camera>, PathError> {
    let file = scratch("paths").join(name);
    std::fs::write(&file, text).unwrap();
    let model = cullet_scenes::build("solids:n=4").unwrap();
    paths::cameras(&model, &PathSpec::File(file), count, VIEWPORT, &Overrides::default())
}

#[test]
fn a_path_comes_back_from_its_file() {
    let model = cullet_scenes::build("solids:n=9").unwrap();
    let o = Overrides { far: Some(f64::INFINITY), ..Overrides::default() };
    let mut sent = paths::cameras(&model, &PathSpec::Fly, 5, VIEWPORT, &o).unwrap();
    sent.extend(cameras(&model, "orbit", 4));
    let h = 3.0;
    let w = h * 1280.0 / 720.0;
    sent.push(Camera {
        projection: Projection::Orthographic {
            left: -w,
            right: w,
            bottom: -h,
            top: h,
            near: -5.0,
            far: 40.0,
        },
        ..sent[0]
    });
    let back = from_file("round.json", &paths::to_json(&sent).unwrap(), 100).unwrap();
    assert_eq!(back.len(), sent.len());
    let matrix = |c: &Camera| View::new(c, Depth::Standard, VIEWPORT).unwrap().clip_from_world();
    for (a, b) in sent.iter().zip(&back) {
        assert_eq!((a.eye, a.up), (b.eye, b.up));
        for (x, y) in matrix(a).into_iter().zip(matrix(b)) {
            assert!((x - y).abs() <= 1e-12 * x.abs().max(1.0), "{a:?} {b:?}");
        }
    }
    let (near, far) = (0.1, 9.0);
    let projection =
        Projection::OffCentre { left: -0.5, right: 0.5, bottom: -1.0, top: 1.0, near, far };
    let off = Camera { projection, ..sent[0] };
    let off = Camera {
        projection: match off.projection {
            Projection::OffCentre { bottom, top, near, far, .. } => {
                Projection::OffCentre { left: 0.0, right: 1.0, bottom, top, near, far }
            }
            other => other,
        },
        ..off
    };
    assert!(matches!(paths::to_json(&[off]), Err(PathError::NotWritable(0))));
}

#[test]
fn a_file_says_cameras_in_several_ways() {
    let list = r#" [{"eye":[0,2,9],"target":[0,1,0]},
        {"eye":[0,9,0],"direction":[0,-2,0],"fov_degrees":30,"near":0.5,"far":1e300}]"#;
    let c = from_file("list.json", list, 16).unwrap();
    assert_eq!(c.len(), 2);
    assert_eq!(c[0].direction, [0.0, -1.0, -9.0]);
    assert_eq!((c[0].up, c[1].up), ([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]));
    assert_eq!(paths::range(&c[1].projection), [0.5, f64::INFINITY]);
    assert_eq!(from_file("one.json", list, 1).unwrap().len(), 1);

    let keys = r#"{"fov_degrees":50,"up":[0,0,1],"keys":[
        {"time":0,"eye":[0,0,0],"direction":[1,0,0]},
        {"time":1,"eye":[2,0,0],"direction":[1,0,0],"fov_degrees":20},
        {"time":3,"eye":[2,4,0],"direction":[0,1,0],"fov_degrees":40}]}"#;
    let c = from_file("keys.json", keys, 7).unwrap();
    assert_eq!(c.len(), 7);
    assert_eq!((c[1].eye, c[4].eye, c[6].eye), ([1.0, 0.0, 0.0], [2.0, 2.0, 0.0], [2.0, 4.0, 0.0]));
    assert!((c[4].direction[0] - 0.5f64.sqrt()).abs() < 1e-12);
    let fov = |c: &Camera| match c.projection {
        Projection::Perspective { fov_y_radians, .. } => fov_y_radians.to_degrees(),
        _ => f64::NAN,
    };
    assert!((fov(&c[4]) - 30.0).abs() < 1e-9);
    assert_eq!(c[0].up, [0.0, 0.0, 1.0]);
}

#[test]
fn a_wrong_file_is_explained() {
    for (text, expected) in [
        ("", "EOF"),
        ("[]", "needs cameras"),
        ("{}", "needs cameras"),
        ("7", "invalid type"),
        (r#"[{"eye":[0,0,0],"tarjet":[1,0,0]}]"#, "unknown field `tarjet`"),
        (r#"[{"eye":[0,0],"target":[1,0,0]}]"#, "line 1"),
        (r#"[{"target":[1,0,0]}]"#, "views[0]: has no eye"),
        (r#"[{"eye":[0,0,0]}]"#, "neither target nor direction"),
        (r#"[{"eye":[0,0,0],"target":[0,0,0]}]"#, "looks nowhere"),
        (r#"[{"eye":[0,0,0],"target":[1,0,0],"direction":[1,0,0]}]"#, "both"),
        (r#"[{"eye":[0,0,0],"target":[1,0,0],"time":3}]"#, "only keys have"),
        (r#"{"keys":[{"eye":[0,0,0],"target":[1,0,0]}]}"#, "keys[0]: is a key without time"),
        (
            r#"{"keys":[{"time":1,"eye":[0,0,0],"target":[1,0,0]},{"time":0,"eye":[0,0,0],"target":[1,0,0]}]}"#,
            "earlier",
        ),
        (r#"[{"eye":[0,0,0],"target":[1,0,0],"fov_degrees":0}]"#, "field of view"),
        (r#"[{"eye":[0,0,0],"target":[1,0,0],"near":-1}]"#, "near"),
        (r#"[{"eye":[0,0,0],"target":[1,0,0],"orthographic_height":0}]"#, "window"),
        (
            r#"[{"eye":[0,0,0],"target":[1,0,0],"orthographic_height":1,"fov_degrees":3}]"#,
            "neither",
        ),
        (r#"[{"eye":[0,0,0],"target":[0,1,0],"up":[0,2,0]}]"#, "span no plane"),
        (r#"[{"eye":[1e999,0,0],"target":[0,1,0]}]"#, "number out of range"),
    ] {
        let message = from_file("wrong.json", text, 3).unwrap_err().to_string();
        assert!(message.contains(expected), "{text}: {message}");
        assert!(message.contains("wrong.json"), "{message}");
    }
    let missing = PathSpec::File(scratch("paths").join("missing.json"));
    let model = cullet_scenes::build("solids:n=1").unwrap();
    let error = paths::views(&model, &missing, 1, VIEWPORT, &Overrides::default()).unwrap_err();
    assert!(error.to_string().contains("missing.json: cannot be read"), "{error}");
}

#[test]
fn cameras_of_the_model() {
    let mut model = cullet_scenes::build("city:cells=8,objects=50").unwrap();
    let one = cameras(&model, "camera:street 03", 16);
    assert_eq!(one.len(), 1);
    assert_eq!(paths::range(&one[0].projection), [0.5, 6000.0]);
    assert!((one[0].eye[1] - 1.7).abs() < 1e-9);
    assert_eq!(cameras(&model, "camera:*", 100).len(), 32);
    assert_eq!(cameras(&model, "camera:*", 5).len(), 5);

    let (first, second) = (model.cameras[0].keys[0].1, model.cameras[1].keys[0].1);
    model.cameras.push(CameraNode {
        name: "ride".into(),
        projection: model.cameras[0].projection,
        keys: vec![(2.0, second), (1.0, first)],
    });
    model.cameras.push(CameraNode {
        name: "nowhere".into(),
        keys: vec![],
        ..model.cameras[0].clone()
    });
    let ride = cameras(&model, "camera:ride", 5);
    assert_eq!(ride.len(), 5);
    assert_eq!((ride[0].eye, ride[4].eye), (first.translation, second.translation));

    let none = |path: &str| {
        paths::cameras(&model, &spec(path), 2, VIEWPORT, &Overrides::default()).unwrap_err()
    };
    assert!(none("camera:street 99").to_string().contains("it has street 00, street 01"));
    assert!(matches!(none("camera:nowhere"), PathError::NoKeys(_)));
}

#[test]
fn wrong_paths_are_explained() {
    for text in ["", "orbits", "file:", "camera:", "walk:3"] {
        let error = text.parse::<PathSpec>().unwrap_err().to_string();
        assert!(error.contains("orbit, walk, fly, file:PATH and camera:NAME"), "{error}");
    }
    for text in ["orbit", "walk", "fly", "file:a:b.json", "camera:Main camera"] {
        assert_eq!(spec(text).to_string(), text);
    }
    let empty = Model::default();
    for path in ["orbit", "walk", "fly"] {
        let error = paths::views(&empty, &spec(path), 4, VIEWPORT, &Overrides::default());
        assert!(matches!(error, Err(PathError::Empty)), "{path}");
    }
    let model = cullet_scenes::build("solids:n=1").unwrap();
    for (count, viewport, fov) in
        [(0, VIEWPORT, 60.0), (1, [0, 5], 60.0), (1, VIEWPORT, 180.0), (1, VIEWPORT, f64::NAN)]
    {
        let o = Overrides { fov_degrees: Some(fov), ..Overrides::default() };
        for path in ["orbit", "walk", "fly"] {
            let result = paths::views(&model, &spec(path), count, viewport, &o);
            assert!(result.is_err(), "{path} {count} {viewport:?} {fov}");
        }
    }
    let look =
        |target| paths::look_at(&model, [1.0, 2.0, 3.0], target, VIEWPORT, &Overrides::default());
    assert!(look([0.0; 3]).is_ok() && look([1.0, 2.0, 3.0]).is_err());
}

#[test]
fn each_built_in_scene_has_a_path_that_suits_it() {
    let walked: Vec<&str> = (cullet_scenes::list().iter().map(|s| s.name))
        .filter(|name| paths::of_builtin(name) == PathSpec::Walk)
        .collect();
    assert_eq!(walked, ["city", "office", "plant", "forest", "moving"]);
    assert_eq!(paths::of_builtin(" city:cells=4"), PathSpec::Walk);
    assert_eq!(paths::of_builtin("knobs"), PathSpec::Orbit);
    assert_eq!(paths::of_builtin("model.glb"), PathSpec::Orbit);
}
