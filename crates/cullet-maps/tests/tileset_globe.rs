//! Tilesets on the globe: where they are, and the horizon occlusion points of their tiles.

use cullet::cull::horizon::{Ellipsoid, Horizon};
use cullet_io::{LoadOptions, Model};
use cullet_maps::{GlobePlace, TileInput, TileStandIn, TileTree, WriteTiles};
use cullet_maps::{load, write_tiles, write_tiles_with};
use cullet_testkit::{Folder, Rng, cases};
use glam::{DMat4, DVec3};
use serde_json::Value;

const NAME: &str = "3DTILES_horizon_occlusion_point";

fn options(place: Option<GlobePlace>) -> WriteTiles {
    let mut options = WriteTiles::default();
    (options.instances, options.triangles, options.place) = (8, 2000, place);
    options
}

fn city() -> Model {
    cullet_scenes::build("city:cells=6,objects=400,ground=0").unwrap()
}

fn read(folder: &Folder) -> Value {
    let text = std::fs::read_to_string(folder.root().join("tileset.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    let all: Vec<f64> = value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    all.try_into().unwrap()
}

fn point(tile: &Value) -> Option<[f64; 3]> {
    let point = &tile["extensions"][NAME]["horizonOcclusionPoint"];
    (!point.is_null()).then(|| numbers(point))
}

/// Corners of the boxes of all instances of a tile and of those below it, on the globe.
fn corners(tile: &Value, folder: &Folder, to_globe: &DMat4, into: &mut Vec<DVec3>) {
    for child in tile["children"].as_array().into_iter().flatten() {
        corners(child, folder, to_globe, into);
    }
    let Some(uri) = tile["content"]["uri"].as_str() else { return };
    let model = load(&folder.root().join(uri), &LoadOptions::default()).unwrap();
    for slot in model.scene.slots() {
        let bounds = model.scene.bounds(slot);
        let at = |v: [f32; 3]| DVec3::from(v.map(f64::from)) + DVec3::from(model.scene.origin());
        let (low, high) = (at(bounds.min), at(bounds.max));
        for k in 0..8 {
            let side = |a: usize| if k >> a & 1 == 0 { low[a] } else { high[a] };
            into.push(to_globe.transform_point3(DVec3::new(side(0), -side(2), side(1))));
        }
    }
}

fn all_tiles(tile: &Value) -> Vec<&Value> {
    let children = tile["children"].as_array().into_iter().flatten();
    std::iter::once(tile).chain(children.flat_map(all_tiles)).collect()
}

/// How far the way from `eye` to `point` stays outside of the ellipsoid: its least distance from the centre in space divided
/// by the radii, less 1.
fn clearance_ref(radii: [f64; 3], eye: DVec3, point: DVec3) -> f64 {
    let (e, p) = (eye / DVec3::from(radii), point / DVec3::from(radii));
    let d = p - e;
    (e + d * (-e.dot(d) / d.length_squared()).clamp(0.0, 1.0)).length() - 1.0
}

/// Writes the city at a place, lower by `depth`, and holds each tile's point to what is seen.
fn hold(place: [f64; 2], height: f64, depth: f64) {
    let folder = Folder::new("tileset-globe");
    let at = GlobePlace::new(place[0], place[1], height).unwrap();
    let written =
        write_tiles(&city(), folder.root(), &options(Some(at)), |_| true).unwrap().unwrap();
    let json = read(&folder);
    let root = &json["root"];
    let tiles = all_tiles(root);
    assert!(tiles.len() > 30, "{}", tiles.len());
    assert_eq!(written.horizon_points, written.tiles[0]);
    assert_eq!(json["extensionsUsed"], serde_json::json!([NAME]));
    assert!(json["extensionsRequired"].is_null());
    let to_globe = DMat4::from_cols_array(&numbers(&root["transform"]));
    let ground = Ellipsoid::WGS84.lowered(depth).radii();
    let mut rng = Rng(9);
    let (mut hidden, mut unseen, mut seen) = (0, 0, 0);
    for tile in tiles {
        let point = point(tile).unwrap_or_else(|| panic!("no point: {tile}"));
        let mut below = Vec::new();
        corners(tile, &folder, &to_globe, &mut below);
        let middle = below.iter().sum::<DVec3>() / below.len() as f64;
        let up = middle.normalize();
        for _ in 0..cases(200) {
            // On and beyond the tile's horizon.
            let aside = up.cross(rng.direction().into()).normalize();
            let over = 10_f64.powf(rng.range(0.0, 5.0));
            let reach = [over, height + 20.0].map(|h| (2.0 * 6.36e6 * h.max(0.0)).sqrt());
            let away = if depth == 0.0 && rng.chance(0.5) {
                (reach[0] + reach[1]) * rng.range(0.98, 1.02)
            } else {
                10_f64.powf(rng.range(3.5, 6.0))
            };
            let way = up * 6.37e6 + aside * away;
            let eye = way / (way / DVec3::from(Ellipsoid::WGS84.radii())).length();
            let eye = eye * (1.0 + over / 6.36e6);
            let horizon = Horizon::from_eye(&Ellipsoid::WGS84, eye.to_array());
            let clear = below
                .iter()
                .map(|p| clearance_ref(ground, eye, *p))
                .fold(f64::NEG_INFINITY, f64::max);
            if horizon.hides_occlusion_point(point) {
                // Boxes of instances are rounded outward to f32.
                assert!(clear < 1e-10, "{point:?} is hidden from {eye}, by {clear:e}");
                hidden += 1;
            }
            unseen += u32::from(clear < 0.0);
            seen += u32::from(clear > 0.0);
        }
    }
    // A tile's point stands for the boxes of the tiles below it, which are larger than their instances.
    let least = if depth > 0.0 { 5 } else { 8 };
    assert!(hidden * 10 > unseen * least && seen > hidden / 10, "{hidden} of {unseen}, {seen}");
}

#[test]
fn where_a_tiles_point_is_hidden_nothing_of_it_is_seen() {
    hold([13.4, 52.5], 34.0, 0.0);
    hold([-179.9, -0.3], 1000.0, 0.0);
    hold([20.0, 90.0], 5.0, 0.0);
}

#[test]
fn ground_below_the_ellipsoid_has_its_points_too() {
    // The Dead Sea, with the lowest instance on its shore; and on the ellipsoid, with the city's own depth.
    hold([35.5, 31.5], -430.0, 432.0);
}

#[test]
fn a_scene_stands_where_it_is_told_to() {
    let folder = Folder::new("tileset-globe-place");
    // As Greenwich is in the test of places: longitude 0, where east is +y.
    let at = "0,51.4778,47".parse().unwrap();
    write_tiles(&city(), folder.root(), &options(Some(at)), |_| true).unwrap().unwrap();
    let to_globe = DMat4::from_cols_array(&numbers(&read(&folder)["root"]["transform"]));
    let origin = to_globe.transform_point3(DVec3::ZERO);
    assert!(origin.distance([3_980_610.484, 0.0, 4_966_861.293].into()) < 0.01, "{origin}");
    // Tiles are z-up: x is east, y north.
    assert!(to_globe.x_axis.truncate().distance(DVec3::Y) < 1e-12);
    let up = to_globe.z_axis.truncate();
    let latitude = 51.4778_f64.to_radians();
    assert!(up.distance(DVec3::new(latitude.cos(), 0.0, latitude.sin())) < 1e-12, "{up}");
    assert!(to_globe.y_axis.z > 0.6);
}

#[test]
fn a_scene_comes_back_from_its_place_as_it_was() {
    let folders = ["a", "b"].map(|name| Folder::new(&format!("tileset-globe-{name}")));
    let at = GlobePlace::new(-70.25, -33.5, 520.0);
    let model = city();
    let [plain, placed] = [(&folders[0], None), (&folders[1], at)].map(|(folder, place)| {
        write_tiles(&model, folder.root(), &options(place), |_| true).unwrap().unwrap();
        let path = folder.root().join("tileset.json");
        let tree = TileTree::open(&path, &LoadOptions::default()).unwrap();
        let model = load(&path, &LoadOptions::default()).unwrap();
        assert!(model.warnings.is_empty(), "{:?}", model.warnings);
        let bounds: Vec<_> = tree.tiles().iter().map(|tile| tile.bounds).collect();
        let places: Vec<[f64; 3]> =
            model.scene.slots().map(|slot| model.scene.transform(slot).translation).collect();
        (bounds, places)
    });
    assert_eq!(plain.0.len(), placed.0.len());
    for (a, b) in plain.0.iter().flatten().flatten().zip(placed.0.iter().flatten().flatten()) {
        assert!((a - b).abs() < 1e-6, "{a} {b}");
    }
    let sorted = |mut all: Vec<[f64; 3]>| {
        all.sort_by(|a, b| a.partial_cmp(b).unwrap());
        all
    };
    let (a, b) = (sorted(plain.1), sorted(placed.1));
    assert!(a.len() > 300 && a.len() == b.len());
    assert!(a.iter().zip(&b).all(|(a, b)| DVec3::from(*a).distance(DVec3::from(*b)) < 1e-3));
    // Where the file does not say that the place is no part of the scene, it is one.
    let path = folders[1].root().join("tileset.json");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replace(r#","placed":true"#, "")).unwrap();
    let moved = load(&path, &LoadOptions::default()).unwrap();
    assert!(!moved.warnings.is_empty());
}

#[test]
fn without_a_place_nothing_says_where_tiles_are() {
    let folder = Folder::new("tileset-globe-none");
    let written = write_tiles(&city(), folder.root(), &options(None), |_| true).unwrap().unwrap();
    assert_eq!(written.horizon_points, 0);
    let text = std::fs::read_to_string(folder.root().join("tileset.json")).unwrap();
    for word in ["extensions", "transform", "placed"] {
        assert!(!text.contains(word), "{word}");
    }
}

#[test]
fn stand_ins_have_points_for_as_much_as_they_are_off() {
    let folder = Folder::new("tileset-globe-stand-ins");
    let model = city();
    let mesh = model.scene.meshes()[0].clone();
    let of = |_: &[u32], least: f64| {
        let mesh = mesh.clone();
        Some(TileStandIn {
            mesh,
            attributes: Default::default(),
            origin: [0.0; 3],
            error: least.max(4e5),
        })
    };
    let at = GlobePlace::new(13.4, 52.5, 0.0);
    let input = TileInput::default().with_stand_ins(&of);
    write_tiles_with(&model, folder.root(), &options(at), &input, |_| true).unwrap().unwrap();
    let json = read(&folder);
    let [inner, leaf] = [true, false].map(|has| {
        let tiles = all_tiles(&json["root"]);
        let of_kind = tiles.iter().filter(|t| t["children"].is_array() == has);
        let lengths = of_kind.map(|t| DVec3::from(point(t).unwrap()).length());
        lengths.fold([f64::INFINITY, 0.0_f64], |[a, b], v| [a.min(v), b.max(v)])
    });
    // 400 km over the ground.
    assert!(inner[0] > 1.06 && leaf[1] < 1.001, "{inner:?} {leaf:?}");
}

#[test]
fn what_is_no_place_is_refused() {
    for text in [
        "",
        "13",
        "13,52,1,2",
        "x,1",
        "181,0",
        "0,91",
        "0,-90.1",
        "nan,0",
        "0,nan",
        "0,0,inf",
        "0,0,200000",
        "0;0",
    ] {
        let error = text.parse::<GlobePlace>().unwrap_err();
        assert!(error.contains("13.4,52.5,34"), "{text}: {error}");
    }
    for text in ["13.4,52.5", "-180, 90 ,-430.5", "180,-90"] {
        assert!(text.parse::<GlobePlace>().is_ok(), "{text}");
    }
}
