//! Models that are saved load again unchanged.

use cullet::{Instance, Transform};
use cullet_io::{LoadOptions, Model, SaveErrorKind, load, save};
use cullet_mesh::{Topology, solid};
use cullet_testkit::Folder;

/// The world-space triangles of all instances, sorted.
fn triangles(model: &Model) -> Vec<[[i64; 3]; 3]> {
    let scene = &model.scene;
    let mut all = Vec::new();
    for slot in scene.slots() {
        let t = scene.transform(slot);
        let mirrored = t.determinant() < 0.0;
        let mesh = scene.mesh(slot);
        for n in 0..mesh.triangle_count() {
            let mut corners = mesh.corners(n).map(|p| {
                [0, 1, 2].map(|i| {
                    let sum: f64 =
                        (0..3).map(|c| f64::from(t.linear[c][i]) * f64::from(p[c])).sum();
                    // A thousandth is far above the rounding of f32 here.
                    ((sum + t.translation[i]) * 1000.0).round() as i64
                })
            });
            if mirrored {
                corners.swap(1, 2);
            }
            let first = (0..3).min_by_key(|&i| corners[i]).unwrap();
            corners.rotate_left(first);
            all.push(corners);
        }
    }
    all.sort_unstable();
    all
}

#[test]
fn every_format_leads_back() {
    let folder = Folder::new("save");
    let mut model = cullet_scenes::build("solids").unwrap();
    let mirrored = Transform::from_scale_translation([-1.0, 2.0, 1.0], [9.0, 1.0, -4.0]);
    model.scene.add(Instance::new(0, mirrored)).unwrap();
    model.scene.commit(&cullet::Culler::default());
    let expected = triangles(&model);
    assert!(expected.len() > 100);
    for name in ["a.glb", "a.PLY", "a.obj", "a.stl"] {
        let path = folder.root().join(name);
        save(&model, &path).unwrap();
        let again = load(&path, &LoadOptions::default()).unwrap();
        let found = triangles(&again);
        assert_eq!(found.len(), expected.len(), "{name}");
        // Rounding may move a coordinate by one step.
        let moved = found.iter().filter(|t| expected.binary_search(t).is_err()).count();
        assert!(moved * 50 < found.len(), "{name}: {moved} of {}", found.len());
        assert!(again.warnings.is_empty(), "{name}: {:?}", again.warnings);
    }
    let again = load(&folder.root().join("a.glb"), &LoadOptions::default()).unwrap();
    assert_eq!(again.scene.instance_count(), model.scene.instance_count());
    let names = |m: &Model| {
        let handles = m.scene.slots().filter_map(|s| m.scene.handle(s));
        let mut names: Vec<_> = handles.map(|h| m.instance_name(h).into_owned()).collect();
        names.sort();
        names
    };
    assert_eq!(names(&again), names(&model));
    let solids = |m: &Model| m.scene.meshes().iter().filter(|m| solid(m).is_ok()).count();
    assert_eq!(solids(&again), solids(&model));
    let sides = |m: &Model| m.scene.meshes().iter().filter(|m| m.is_two_sided()).count();
    assert_eq!(sides(&again), sides(&model));
    let colors = |m: &Model| m.materials.iter().map(|m| m.name.clone()).collect::<Vec<_>>();
    assert!(colors(&again).iter().all(|name| colors(&model).contains(name)));
    let merged = load(&folder.root().join("a.stl"), &LoadOptions::default()).unwrap();
    let mesh = &merged.scene.meshes()[0];
    assert_eq!(Topology::of(mesh.positions(), mesh.indices()).boundary_edges, 0);
}

#[test]
fn an_empty_model_is_saved_and_strange_endings_are_refused() {
    let folder = Folder::new("save");
    let model = Model::default();
    for name in ["none.glb", "none.ply", "none.obj", "none.stl"] {
        save(&model, &folder.root().join(name)).unwrap();
    }
    let again = load(&folder.root().join("none.glb"), &LoadOptions::default()).unwrap();
    assert_eq!(again.scene.instance_count(), 0);
    let error = save(&model, &folder.root().join("a.fbx")).unwrap_err();
    assert!(matches!(error.kind, SaveErrorKind::Unsupported), "{error}");
    assert!(!folder.root().join("a.fbx").exists());
    let error = save(&model, &folder.root().join("no/such/folder.glb")).unwrap_err();
    assert!(matches!(error.kind, SaveErrorKind::Io(_)), "{error}");
}
