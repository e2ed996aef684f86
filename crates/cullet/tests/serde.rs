//! Settings and results as data: with the names that files have, back to the last bit, and checked.

use cullet::bounds::Aabb;
use cullet::cull::detail::{Detail, Measure};
use cullet::cull::occlusion::{Convex, Occluder, Occlusion, Patch, Shape};
use cullet::mesh::{Alpha, MeshData, Part};
use cullet::{
    Backface, Camera, Culler, Depth, Handle, Instance, Mesh, Output, Projection, Reason, Scene,
    Simd, Stage, Transform, View, ViewState, Visible,
    funnel::Unit,
    view::{CullFace, FrontFace},
};
use serde::Serialize;
use serde::de::DeserializeOwned;

fn json<T: Serialize>(value: &T) -> String {
    serde_json::to_string(value).unwrap()
}

/// A value as it comes back from a message.
fn back<T: Serialize + DeserializeOwned>(value: &T) -> T {
    postcard::from_bytes(&postcard::to_allocvec(value).unwrap()).unwrap()
}

#[test]
fn names_are_those_of_files_and_links() {
    for stage in Stage::ALL {
        assert_eq!(json(&stage), format!("\"{}\"", stage.name()));
    }
    for unit in [Unit::Instances, Unit::Clusters, Unit::Triangles] {
        assert_eq!(json(&unit), format!("\"{}\"", unit.name()));
    }
    assert_eq!(
        json(&[Backface::Off, Backface::Fast, Backface::Exact]),
        r#"["off","fast","exact"]"#
    );
    let measures = [Measure::WidthAndHeight, Measure::Area, Measure::Diameter];
    assert_eq!(json(&measures), r#"["box","area","diameter"]"#);
    assert_eq!(
        json(&[CullFace::None, CullFace::Back, CullFace::Front]),
        r#"["none","back","front"]"#
    );
    assert_eq!(json(&Handle { index: 3, generation: 7 }), "[3,7]");
    assert_eq!(json(&Reason { stage: Stage::Lod, detail: 2 }), r#"{"stage":"lod","detail":2}"#);
}

#[test]
fn a_cullers_level_and_clock_are_the_readers() {
    let culler = Culler::default()
        .with_detail(Detail::default().with_measure(Measure::Area).with_threshold_px(2.5))
        .with_occlusion(Occlusion::default().with_width(128).with_budget(9.5))
        .with_output(Output::Triangles)
        .with_clock(Some(|| 7));
    let text = json(&culler);
    assert_eq!(
        text,
        "{\"frustum\":true,\"frustum_exact\":false,\"pvs\":true,\
         \"portal\":true,\
         \"backface\":\"fast\",\"degenerate\":true,\
         \"detail\":{\"measure\":\"area\",\"threshold_px\":2.5,\"clusters\":false,\"fade\":0.0},\
         \"lod\":null,\"occlusion\":{\"width\":128,\"budget\":9.5,\"risk\":null},\
         \"costs\":{\"opaque_triangle_ns\":10.0,\"draw_ns\":1000.0,\"occluders\":{\
         \"convex\":{\"base_ns\":330.0,\"edge_ns\":5.0,\"outline_ns\":5.0,\"pixel_ns\":0.02},\
         \"patch\":{\"base_ns\":650.0,\"edge_ns\":7.0,\"outline_ns\":2.0,\"pixel_ns\":0.03},\
         \"look_ns\":30.0,\"test_ns\":20.0,\"begin_ns\":10000.0}},\
         \"output\":\"triangles\",\"reasons\":false,\"dropped\":false}"
    );
    let wanted = culler.with_clock(None).with_simd(Simd::best());
    let read: Culler = serde_json::from_str(&text).unwrap();
    assert_eq!(format!("{read:?}"), format!("{wanted:?}"));
    assert_eq!(format!("{:?}", back(&wanted)), format!("{wanted:?}"));
}

#[test]
fn settings_that_are_left_out_are_the_default_and_unknown_ones_are_refused() {
    let read: Culler = serde_json::from_str(r#"{"degenerate":false}"#).unwrap();
    let wanted = Culler::default().with_degenerate(false);
    assert_eq!(format!("{read:?}"), format!("{wanted:?}"));
    for text in [r#"{"frustrum":true}"#, r#"{"level":"avx2"}"#, r#"{"occlusion":{"width":-1}}"#] {
        assert!(serde_json::from_str::<Culler>(text).is_err(), "{text}");
    }
}

fn views() -> Vec<View> {
    let near = View::perspective([3.0, 4.0, 9.0], [0.0; 3], 1.0, 0.1, f64::INFINITY, [320, 200]);
    let near = near.unwrap();
    let flat = View::orthographic([1e7, 5.0, 0.3], [1e7, 0.0, 0.0], 9.0, -1.0, 50.0, [201, 99]);
    let projection = Projection::OffCentre {
        left: -0.1,
        right: 0.3,
        bottom: -0.2,
        top: 0.1,
        near: 0.1,
        far: 9.0,
    };
    let camera = Camera::look_at([0.0, 1.0, 2.0], [0.0; 3], projection);
    let reversed = View::new(&camera, Depth::Reversed, [64, 64]).unwrap().with_layers(5);
    let mut matrix = near.clip_from_world();
    matrix.iter_mut().step_by(4).for_each(|v| *v = -*v);
    let mut mirrored = View::from_matrix(matrix, near.depth(), [320, 200]).unwrap();
    mirrored.front_face = FrontFace::Clockwise;
    mirrored.cull_face = CullFace::Front;
    vec![near, flat.unwrap(), reversed, mirrored]
}

#[test]
fn a_view_comes_back_to_the_last_bit() {
    for view in views() {
        let again = back(&view);
        assert_eq!(again, view);
        assert_eq!(again.eye().map(f64::to_bits), view.eye().map(f64::to_bits));
        assert_eq!(again.is_mirrored(), view.is_mirrored());
    }
}

#[test]
fn a_view_that_cannot_be_is_refused() {
    let mut value = serde_json::to_value(&views()[0]).unwrap();
    value["viewport"] = serde_json::json!([0, 9]);
    let error = serde_json::from_value::<View>(value.clone()).unwrap_err().to_string();
    assert!(error.contains("viewport 0x9"), "{error}");
    value["viewport"] = serde_json::json!([9, 9]);
    value["clip_from_world"] = serde_json::json!(vec![0.0; 16]);
    let error = serde_json::from_value::<View>(value).unwrap_err().to_string();
    assert!(error.contains("singular"), "{error}");
}

/// A rough sheet of n × n squares.
fn sheet(n: u32) -> MeshData {
    let height = |x: u32, y: u32| ((x * 7 + y * 3) % 5) as f32 * 0.1;
    let vertex =
        |v: u32| [(v % (n + 1)) as f32, height(v % (n + 1), v / (n + 1)), (v / (n + 1)) as f32];
    let square = |s: u32| {
        let v = s / n * (n + 1) + s % n;
        [v, v + n + 1, v + 1, v + 1, v + n + 1, v + n + 2]
    };
    MeshData {
        positions: (0..(n + 1) * (n + 1)).map(vertex).collect(),
        indices: (0..n * n).flat_map(square).collect(),
        ..MeshData::default()
    }
}

/// An occluder with a shape of each kind, with patches of a sheet of n × n squares.
fn occluder(n: u32) -> Occluder {
    let cube = Aabb::new([-1.0; 3], [1.0, 2.0, 3.0]);
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.5], [0.0, 1.0, 0.5]];
    let sheet = sheet(n);
    let patches = Patch::cut(&sheet.positions, &sheet.indices, (n * n / 2) as usize, true).unwrap();
    let convex = [
        Convex::from_box(&cube),
        Convex::from_polygon(&corners),
        Convex::from_one_sided_polygon(&corners),
    ];
    let near = patches.iter().cloned().map(Shape::Patch).collect();
    let shapes = convex.into_iter().map(|c| Shape::Convex(c.unwrap()));
    let shapes = shapes.chain(patches.into_iter().map(Shape::Patch)).collect();
    Occluder::new(shapes).with_sealed(vec![cube, Aabb::EMPTY]).with_near(near)
}

#[test]
fn an_occluder_comes_back_with_all_that_follows_from_its_shapes() {
    let given = occluder(12);
    let again = back(&given);
    assert_eq!(again, given);
    assert_eq!(format!("{again:?}"), format!("{given:?}"));
    let tips = [
        [2.0, 0.0, 0.0],
        [-2.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, 3.0],
        [0.0, 0.0, -3.0],
    ];
    let faces =
        [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    let body = Convex::from_mesh(&tips, faces.as_flattened()).expect("an octahedron is convex");
    assert_eq!(back(&body), body);
    let mesh = Mesh::new(sheet(30)).unwrap();
    let occluder = Occluder::of_mesh(&mesh);
    assert!(occluder.shapes().len() > 1);
    assert_eq!(back(&occluder), occluder);
}

#[test]
fn an_occluder_that_lies_is_an_error_and_no_panic() {
    let bytes = postcard::to_allocvec(&occluder(2)).unwrap();
    let mut refused = 0;
    for at in 0..bytes.len() {
        assert!(postcard::from_bytes::<Occluder>(&bytes[..at]).is_err(), "{at}");
        let mut lying = bytes.clone();
        lying[at] ^= 0xff;
        refused += u32::from(postcard::from_bytes::<Occluder>(&lying).is_err());
    }
    assert!(refused > 100, "{refused}");
    let polygon =
        |faces: &str| format!(r#"{{"vertices":[[0,0,0],[1,0,0],[0,1,0]],"faces":{faces}}}"#);
    for (faces, part) in [
        ("[[0,1,3],[3,1,0]]", "index 3"),
        ("[[0,1],[1,0]]", "at least three corners"),
        ("[[0,1,2],[0,1,2]]", "share each edge"),
        ("[[0,1,2],[2,1,0],[0,1,2],[2,1,0],[0,1,2],[2,1,0],[0,1,2]]", "share each edge"),
        ("[]", "share each edge"),
    ] {
        let read = serde_json::from_str::<Convex>(&polygon(faces));
        let error = read.expect_err(faces).to_string();
        assert!(error.contains(part), "{faces}: {error}");
    }
}

#[test]
fn an_answer_comes_back_as_it_went() {
    let mut scene = Scene::new();
    let mut data = sheet(20);
    data.parts = vec![Part { triangle_count: 800, alpha: Alpha::Opaque, ..Part::default() }];
    let mesh = scene.add_mesh(Mesh::new(data).unwrap());
    for i in 0..90 {
        let at = [f64::from(i % 9) * 30.0 - 120.0, 0.0, f64::from(i / 9) * 30.0 - 150.0];
        scene.add(Instance::new(mesh, Transform::from_translation(at))).unwrap();
    }
    scene.commit(&Culler::default());
    let culler = Culler::default()
        .with_output(Output::Triangles)
        .with_occlusion(Occlusion::default())
        .with_detail(Detail::default().with_threshold_px(9.0))
        .with_reasons(true)
        .with_dropped(true)
        .with_clock(Some(|| 7));
    let mut visible = Visible::default();
    culler.cull_one(&scene, &views()[0], &mut ViewState::default(), &mut visible);
    let some = [
        visible.whole.len(),
        visible.partial.len(),
        visible.triangles.len(),
        visible.dropped.len(),
    ];
    assert!(!some.contains(&0) && visible.reasons.contains(&None), "{some:?}");
    let again = back(&visible);
    assert_eq!(again, visible);
    assert_eq!(format!("{:?}", again.funnel), format!("{:?}", visible.funnel));
    let explained = culler.explain(&scene, &views()[0], scene.handle(0).unwrap()).unwrap();
    assert_eq!(back(&explained), explained);
}
