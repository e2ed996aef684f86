//! Baked data: clusters, occluders, levels, rooms and sets.

use cullet::MeshData;
use cullet_bake::clusters;
use cullet_bake::levels::{HierarchyOptions, build_hierarchy};
use cullet_bake::occluders::occluders;
use cullet_bake::pvs::{PvsSettings, bake};
use cullet_bake::rooms::{FindOptions, find_cells};
use cullet_bake::sampled::{RayTree, RayTreeOptions, SampledSettings, ViewCells, bake_sampled};
use cullet_io::Model;

use crate::hash::line;

/// Size of a ball of 10,800 triangles, for the meshes of scenes are small.
const BALL: u16 = 30;

const MESHES: usize = 4;

pub(crate) fn run(name: &str, model: &Model) -> Result<(), String> {
    let scene = &model.scene;
    let meshes = || scene.meshes().iter().take(MESHES);
    let data = || {
        meshes().map(|mesh| MeshData {
            positions: mesh.positions().to_vec(),
            indices: mesh.indices().to_vec(),
            ..MeshData::default()
        })
    };
    line(&format!("{name}: clusters"), |hash| {
        data().for_each(|data| hash.value(&clusters::build(&data, &Default::default())));
    });
    line(&format!("{name}: baked occluders"), |hash| {
        for mesh in meshes() {
            let made = occluders(mesh, &Default::default()).map(|(made, _)| made);
            hash.value(&made);
        }
    });
    levels(name, data());
    if !model.cells.cells.is_empty() {
        let (graph, _) = model.cells.build().map_err(|e| e.to_string())?;
        let pvs = bake(&graph, &PvsSettings::default(), 1);
        line(&format!("{name}: sets through portals"), |hash| {
            hash.whole(pvs.rows_hash());
            hash.value(&pvs.witnesses());
        });
    }
    if ["office", "city"].contains(&name) {
        let fail = |e: cullet_bake::sampled::SampledError| e.to_string();
        let tree = RayTree::new(scene, &RayTreeOptions::default()).map_err(fail)?;
        let [mut low, mut high] = tree.bounds();
        (low[1], high[1]) = (low[1] + 1.0, low[1] + 2.5);
        let cells = ViewCells::adaptive(&tree, &[[low, high]], 8, 1).map_err(fail)?;
        let settings = SampledSettings::default().with_rays(4_000);
        let sets = bake_sampled(&tree, &cells, &settings, 2).map_err(fail)?;
        line(&format!("{name}: sampled sets"), |hash| {
            hash.whole(sets.rows_hash());
            sets.missing.iter().for_each(|&v| hash.number(v));
        });
    }
    if name == "office" {
        let options = FindOptions::default().with_voxel(0.25);
        let found = find_cells(scene, &options, 1, |_| true, || true);
        line(&format!("{name}: rooms found"), |hash| {
            hash.value(&found.map(|found| (found.cells, found.portals)));
        });
    }
    Ok(())
}

fn levels(name: &str, data: impl Iterator<Item = MeshData>) {
    let levels = |data: &MeshData| build_hierarchy(data, None, &HierarchyOptions::default());
    line(&format!("{name}: levels"), |hash| data.for_each(|data| hash.value(&levels(&data))));
    if name == "knobs" {
        let (positions, indices) = cullet_scenes::knobbly_ball(BALL);
        let ball = MeshData { positions, indices, ..MeshData::default() };
        line("ball: levels", |hash| hash.value(&levels(&ball)));
    }
}
