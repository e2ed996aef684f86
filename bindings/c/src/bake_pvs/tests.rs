//! Bakes through the C interface beside the crates that they are of: the same bytes.

use std::ptr::{null, null_mut};

use cullet_bake::levels::{ChainOptions, build_chain};
use cullet_bake::pvs::{PvsSettings as CellsBakeSettings, bake};
use cullet_bake::sampled::{SampledSettings, bake_sampled};
use engine::mesh::Part;
use engine::{Culler, Instance, Mesh, MeshData, Transform};

use super::*;
use crate::bake_meshes::cullet_bake_levels;
use crate::pvs::cullet_pvs_write;

/// A cube, wound outward.
fn cube() -> Mesh {
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let data = MeshData {
        positions: (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|v| v as f32 - 0.5)).collect(),
        indices: quads.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect(),
        parts: vec![Part { triangle_count: 12, two_sided: false, ..Part::default() }],
        ..MeshData::default()
    };
    Mesh::new(data).unwrap()
}

/// Hills of some hundred triangles.
fn hills() -> Mesh {
    const SIDE: u32 = 24;
    let height = |x: u32, z: u32| ((x * 7 + z * 3) % 11) as f32 * 0.05 + (x * z % 5) as f32 * 0.01;
    let all = (0..SIDE).flat_map(|z| (0..SIDE).map(move |x| (x, z)));
    let positions = all.clone().map(|(x, z)| [x as f32, height(x, z), z as f32]).collect();
    let cells = all.filter(|&(x, z)| x + 1 < SIDE && z + 1 < SIDE);
    let indices = cells.flat_map(|(x, z)| {
        let a = z * SIDE + x;
        [a, a + SIDE, a + 1, a + 1, a + SIDE, a + SIDE + 1]
    });
    Mesh::new(MeshData { positions, indices: indices.collect(), ..MeshData::default() }).unwrap()
}

/// Two rooms of walls, with something in each.
fn rooms() -> engine::Scene {
    let walls: [[[f64; 3]; 2]; 10] = [
        [[-9.0, -1.0, -5.0], [9.0, 0.0, 5.0]],
        [[-9.0, 3.0, -5.0], [9.0, 4.0, 5.0]],
        [[-9.0, -1.0, -5.0], [-8.0, 4.0, 5.0]],
        [[8.0, -1.0, -5.0], [9.0, 4.0, 5.0]],
        [[-9.0, -1.0, -5.0], [9.0, 4.0, -4.0]],
        [[-9.0, -1.0, 4.0], [9.0, 4.0, 5.0]],
        [[-0.5, -1.0, -4.5], [0.5, 4.0, -1.0]],
        [[-0.5, -1.0, 1.0], [0.5, 4.0, 4.5]],
        [[5.0, 0.0, -3.0], [5.5, 1.0, -2.0]],
        [[-5.0, 0.0, -3.0], [-5.5, 1.0, -2.0]],
    ];
    let mut scene = engine::Scene::new();
    let mesh = scene.add_mesh(cube());
    for [low, high] in walls {
        let mut transform =
            Transform::from_translation(std::array::from_fn(|a| (low[a] + high[a]) / 2.0));
        for a in 0..3 {
            transform.linear[a][a] = (high[a] - low[a]) as f32;
        }
        scene.add(Instance::new(mesh, transform)).unwrap();
    }
    scene.commit(&Culler::default());
    scene
}

fn handle(scene: engine::Scene) -> Scene {
    Scene { id: SCENES.insert(InCells::new(scene)).unwrap() }
}

fn options(threads: u32) -> BakeOptions {
    BakeOptions {
        threads,
        share: 0,
        share_count: 0,
        reserved: 0,
        folder: null(),
        step: None,
        context: null_mut(),
    }
}

/// Bytes that are baked of a scene, as a C program reads them.
fn baked(scene: Scene, settings: *const PvsSettings, threads: u32) -> Vec<u8> {
    let (mut pvs, mut size, options) = (Pvs { id: 0 }, 0, options(threads));
    // SAFETY: pointers are of values that live on, or NULL.
    unsafe {
        assert_eq!(cullet_bake_pvs(scene, settings, &options, &mut pvs), Status::Ok);
        assert_eq!(cullet_pvs_write(pvs, null_mut(), 0, &mut size), Status::Ok);
        let mut bytes = vec![0; size];
        assert_eq!(cullet_pvs_write(pvs, bytes.as_mut_ptr(), size, &mut size), Status::Ok);
        bytes
    }
}

#[test]
fn sets_of_view_cells_are_those_of_the_crate() {
    let scene = rooms();
    let region = [[-7.0, 0.5, -3.0], [7.0, 2.5, 3.0]];
    let tree = RayTree::new(&scene, &RayTreeOptions::default()).unwrap();
    let cells = ViewCells::grid(region, [3, 1, 2]).unwrap();
    let settings = SampledSettings::default()
        .with_rays(30_000)
        .with_seed(5)
        .with_missing(0.0)
        .with_union_radius(Some(0.5))
        .with_keep_angle(1.0);
    let expected = bake_sampled(&tree, &cells, &settings, 1).unwrap().to_bytes();
    let eyes = EyeBox { min: region[0], max: region[1] };
    let settings = PvsSettings {
        boxes: &eyes,
        box_count: 1,
        boxes_are_cells: 0,
        cells: 0,
        grid: [3, 1, 2],
        reserved: 0,
        rays: 30_000,
        seed: 5,
        missing: -1.0,
        keep_angle: 1.0,
        join: 0.5,
    };
    for threads in [1, 3] {
        assert!(baked(handle(rooms()), &settings, threads) == expected, "{threads} threads");
    }
    let boxes: Vec<EyeBox> =
        (0..cells.len()).map(|c| cells.bounds(c)).map(|[min, max]| EyeBox { min, max }).collect();
    let given = ViewCells::of_boxes(&boxes.iter().map(|b| [b.min, b.max]).collect::<Vec<_>>());
    let plain = SampledSettings::default().with_rays(30_000);
    let expected = bake_sampled(&tree, &given.unwrap(), &plain, 1).unwrap().to_bytes();
    let settings = PvsSettings {
        boxes: boxes.as_ptr(),
        box_count: boxes.len(),
        boxes_are_cells: 1,
        grid: [0; 3],
        seed: 0,
        missing: 0.0,
        keep_angle: 0.0,
        join: 0.0,
        ..settings
    };
    assert!(baked(handle(rooms()), &settings, 2) == expected, "cells that were given");
}

#[test]
fn cells_and_their_sets_are_those_of_the_crate() {
    let (scene, mut count) = (handle(rooms()), 0);
    let find = FindOptions::default().with_voxel(0.25);
    let found = find_cells(&rooms(), &find, 1, |_| true, || true).unwrap();
    let (graph, _) = found.into_graph().build().unwrap();
    let settings = CellsSettings { voxel: 0.25, ignored: null(), ignored_count: 0 };
    // SAFETY: pointers are of values that live on.
    let done = unsafe { cullet_bake_cells(scene, &settings, &options(2), &mut count) };
    assert_eq!((done, count), (Status::Ok, graph.cell_count()));
    assert!(count >= 3);
    let expected = bake(&graph, &CellsBakeSettings::default(), 1).to_bytes();
    assert!(baked(scene, null(), 2) == expected);
}

#[test]
fn levels_are_those_of_the_crate() {
    let data = hills().to_data();
    let (held, levels) =
        build_chain(&data, &ChainOptions::default()).unwrap().into_levels().unwrap();
    let mut scene = engine::Scene::new();
    scene.add_mesh(hills());
    let (scene, mut count) = (handle(scene), 0);
    // SAFETY: the pointers are of values that live on.
    assert_eq!(unsafe { cullet_bake_levels(scene, &options(2), &mut count) }, Status::Ok);
    assert_eq!(count, 1);
    let own = SCENES.get(scene.id).unwrap();
    let [found] = own.levels(0) else { panic!("one chain") };
    let of = &own.meshes()[found.mesh as usize];
    assert!(levels.group_count() > 2);
    assert_eq!(found.levels, levels);
    assert_eq!((of.positions(), of.indices()), (held.positions(), held.indices()));
    assert_eq!(of.clusters(), held.clusters());
}
