//! Occluders that were baked, in worlds of tiles.

use cullet::{
    Camera, Culler, Depth, Instance, Mesh, Projection, Scene, Stage, Transform, View, ViewState,
    Visible,
};
use cullet_bake::occluders::{OccluderOptions, occluders};
use cullet_draw::{VerifyOptions, verify};
use cullet_io::baked::{Baked, BakedMesh, Occluders, geometry_hash};
use cullet_io::{LoadOptions, Model};
use cullet_maps::WriteTiles;
use cullet_maps::write_tiles;
use cullet_testkit::{Folder, soups};
use cullet_tiles::{FolderTiles, Settings, World};

/// Two closed boxes beside each other, whose sides are of many small triangles: no convex body, whose outline would be as cheap.
fn slabs() -> Mesh {
    const STEPS: u32 = 16;
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    let size = [1.9, 3.0, 0.5];
    let sides = [-2.0, 2.0].into_iter().flat_map(|x| (0..3).map(move |axis| (x, axis)));
    for ((x, axis), side) in sides.flat_map(|of| [-1.0_f32, 1.0].map(|side| (of, side))) {
        let first = positions.len() as u32;
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for i in 0..=STEPS {
            for k in 0..=STEPS {
                let at = |n: u32| n as f32 / STEPS as f32 * 2.0 - 1.0;
                let mut p = [0.0; 3];
                (p[axis], p[u], p[v]) = (side * size[axis], at(i) * size[u], at(k) * size[v]);
                p[0] += x;
                positions.push(p);
            }
        }
        for i in 0..STEPS {
            for k in 0..STEPS {
                let [a, b] = [i, i + 1].map(|i| first + i * (STEPS + 1) + k);
                // Seen from outside, counter-clockwise.
                let [a, b, c, d] =
                    if side > 0.0 { [a, b, b + 1, a + 1] } else { [a, a + 1, b + 1, b] };
                indices.extend([a, b, c, a, c, d]);
            }
        }
    }
    cullet_testkit::meshes::one_sided((positions, indices))
}

fn tables(mesh: &Mesh) -> Occluders {
    occluders(mesh, &OccluderOptions::default()).unwrap().0
}

/// Slabs in a row, with many small balls behind them; the slabs' occluders are baked.
fn model() -> Model {
    let mut model = Model { mesh_names: vec!["slab".into(), "ball".into()], ..Model::default() };
    let slab = slabs();
    let (geometry, tables) = (geometry_hash(&slab), tables(&slab));
    assert!(tables.efficiency > 0.9, "{tables:?}");
    let slab = model.scene.add_mesh(slab);
    let ball = model.scene.add_mesh(cullet_testkit::meshes::one_sided(soups::ball(4, 8)));
    for k in 0..6 {
        let at = |z: f64, y: f64| [f64::from(k) * 8.0, y, z];
        model.scene.add(Instance::new(slab, Transform::from_translation(at(0.0, 0.0)))).unwrap();
        for row in 0..40 {
            let at = at(-3.0 - f64::from(row % 8), f64::from(row / 8) - 2.0);
            let transform = Transform::from_scale_translation([0.3; 3], at);
            model.scene.add(Instance::new(ball, transform)).unwrap();
        }
    }
    model.scene.commit(&Culler::default());
    let of = BakedMesh { mesh: slab, geometry, occluders: Some(tables), ..BakedMesh::default() };
    model.baked = Some(Baked { meshes: vec![of], ..Baked::default() });
    model
}

fn hidden(scene: &Scene, view: &View) -> u64 {
    let (mut state, mut visible) = (ViewState::default(), Visible::default());
    // Whether it pays is another question.
    Culler::exact().cull_one(scene, view, &mut state, &mut visible);
    let mut all = Visible::default();
    let without = Culler::exact().without(Stage::Occlusion);
    without.cull_one(scene, view, &mut ViewState::default(), &mut all);
    all.instance_count - visible.instance_count
}

#[test]
fn occluders_of_baked_meshes_come_with_their_tiles_and_hide() {
    let model = model();
    let folder = Folder::new("tiles-occluders");
    let mut options = WriteTiles::default();
    options.instances = 50;
    write_tiles(&model, folder.root(), &options, |_| true).unwrap().unwrap();
    let path = folder.root().join("tileset.json");
    let settle = |eye| {
        let tiles = FolderTiles::open(&path, &LoadOptions::default()).unwrap();
        let mut world = World::new(tiles, &Settings::default().with_pixels(0.0)).unwrap();
        world.look(eye, [0.0; 3]);
        world.settle();
        world
    };
    let world = settle([20.0, 0.0, 12.0]);
    assert!(world.status().failed.is_empty(), "{:?}", world.status().failed);
    assert_eq!(world.scene().instance_count(), model.scene.instance_count());
    let scene = world.scene();
    let given = scene
        .slots()
        .filter(|&slot| scene.prepared()[scene.mesh_id(slot) as usize].given_occluder().is_some());
    assert_eq!(given.count(), 6, "those of the slabs");
    let projection =
        Projection::Perspective { fov_y_radians: 1.0, aspect: 1.5, near: 0.3, far: f64::INFINITY };
    let mut all_hidden = 0;
    for eye in [[20.0, 0.0, 12.0], [4.0, 1.0, 9.0], [36.0, -1.0, 20.0], [20.0, 12.0, 3.0]] {
        let camera = Camera::look_at(eye, [20.0, 0.0, -4.0], projection);
        let view = View::new(&camera, Depth::Reversed, [300, 200]).unwrap();
        all_hidden += hidden(scene, &view);
        let options = VerifyOptions::default();
        let proof = verify(scene, &view, &Culler::exact(), &mut ViewState::default(), &options);
        assert!(proof.visible > 0 && proof.false_culls.is_empty(), "{:?}", proof.false_culls);
    }
    assert!(all_hidden > 200, "{all_hidden}");
}
