//! Levels of detail in worlds of tiles.

use cullet::lod::Lod;
use cullet::mesh::{MeshData, Part};
use cullet::{
    Camera, Culler, Depth, Instance, Mesh, Projection, Scene, Transform, View, ViewState, Visible,
};
use cullet_bake::levels::{ChainOptions, build_chain};
use cullet_io::baked::{Baked, BakedLevels, BakedMesh, LevelKind, Measured, geometry_hash};
use cullet_io::{LoadOptions, Model};
use cullet_maps::WriteTiles;
use cullet_maps::write_tiles;
use cullet_testkit::{Folder, soups};
use cullet_tiles::{FolderTiles, Settings, World};

#[test]
fn levels_of_baked_meshes_come_with_their_tiles() {
    // A ball of many triangles, ten of it in a row.
    let (positions, indices) = soups::bumpy_ball(24, 0.0);
    // Two-sided: its coarsest level is a triangle, which may face away.
    let triangle_count = indices.len() as u32 / 3;
    let parts = vec![Part { triangle_count, two_sided: true, ..Part::default() }];
    let data = MeshData { positions, indices, parts, ..MeshData::default() };
    let ball = Mesh::new(data.clone()).unwrap();
    let (held, levels) =
        build_chain(&data, &ChainOptions::default()).unwrap().into_levels().unwrap();
    let mut model = Model { mesh_names: vec!["ball".into(), "levels".into()], ..Model::default() };
    let geometry = geometry_hash(&ball);
    let mesh = model.scene.add_mesh(ball);
    let held_by = model.scene.add_mesh(held);
    model.scene.add_levels(mesh, held_by, levels).unwrap();
    for k in 0..10 {
        let at = Transform::from_translation([f64::from(k) * 30.0, 0.0, 0.0]);
        model.scene.add(Instance::new(mesh, at)).unwrap();
    }
    model.scene.commit(&Culler::default());
    let measured =
        Measured { points: 1, reverse_points: 0, quantile: 0.999, most_over: 1.2, seed: 1 };
    let levels = vec![BakedLevels { kind: LevelKind::Chain, held_by, measured }];
    let of = BakedMesh { mesh, geometry, levels, ..BakedMesh::default() };
    model.baked = Some(Baked { meshes: vec![of], ..Baked::default() });

    let folder = Folder::new("tiles");
    let mut options = WriteTiles::default();
    options.instances = 3;
    write_tiles(&model, folder.root(), &options, |_| true).unwrap().unwrap();
    let tiles =
        FolderTiles::open(&folder.root().join("tileset.json"), &LoadOptions::default()).unwrap();
    let mut world = World::new(tiles, &Settings::default().with_pixels(0.0)).unwrap();
    world.look([135.0, 0.0, 500.0], [0.0; 3]);
    world.settle();
    assert!(world.status().failed.is_empty(), "{:?}", world.status().failed);
    assert_eq!(world.scene().instance_count(), 10);
    let camera = Camera::look_at(
        [135.0, 0.0, 500.0],
        [135.0, 0.0, 0.0],
        Projection::Perspective { fov_y_radians: 1.0, aspect: 1.78, near: 0.3, far: f64::INFINITY },
    );
    let view = View::new(&camera, Depth::Reversed, [960, 540]).unwrap();
    let drawn = |scene: &Scene, lod: Option<Lod>| {
        let mut visible = Visible::default();
        let culler = Culler::balanced().with_lod(lod);
        culler.cull_one(scene, &view, &mut ViewState::default(), &mut visible);
        visible.triangle_count
    };
    let [full, coarse] = [None, Some(Lod::default())].map(|lod| drawn(world.scene(), lod));
    assert!(coarse > 0 && coarse * 4 < full, "{coarse} of {full}");
    assert_eq!(coarse, drawn(&model.scene, Some(Lod::default())), "as of the whole");
}
