//! Levels that need no baking.

use cullet::Mesh;
use cullet::lod::{Group, NO_GROUP};
use cullet_io::Model;
use cullet_io::baked::{
    Baked, BakedLevels, BakedMesh, ClusterRow, LevelKind, LevelTables, Measured, geometry_hash,
};

pub(crate) const MEASURED: Measured =
    Measured { points: 1, reverse_points: 4, quantile: 0.999, most_over: 1.1, seed: 7 };

/// Levels by hand: all of the mesh, and of each part its first triangle for all of it.
pub(crate) fn tables(base: &Mesh) -> LevelTables {
    let mut out = LevelTables {
        groups: vec![Group { centre: [0.0; 3], radius: 9.0, error: 0.5 }],
        ..LevelTables::default()
    };
    for part in 0..base.parts().len() as u32 {
        let before = out.indices.len() / 3;
        let own: Vec<_> = base.clusters().iter().filter(|c| c.part == part).collect();
        let coarse = own.first().map(|c| (c.first_triangle..c.first_triangle + 1, 0, NO_GROUP));
        let fine = own.iter().map(|c| (c.triangles(), NO_GROUP, 0));
        for (range, made_from, replaced_by) in fine.chain(coarse) {
            let first_triangle = (out.indices.len() / 3) as u32;
            let triangle_count = range.len() as u32;
            range.for_each(|t| out.indices.extend(base.triangle(t)));
            out.clusters.push(ClusterRow {
                first_triangle,
                triangle_count,
                made_from,
                replaced_by,
            });
        }
        out.parts.push((out.indices.len() / 3 - before) as u32);
    }
    out
}

/// Gives every rigid mesh levels by hand.
#[allow(dead_code, reason = "not all tests bake")]
pub(crate) fn bake(model: &mut Model) {
    let mut baked = Baked { generator: "by hand 1".into(), ..Baked::default() };
    for mesh in 0..model.mesh_names.len() as u32 {
        model.scene.clear_levels(mesh);
        let base = &model.scene.meshes()[mesh as usize];
        if base.is_deformable() {
            continue;
        }
        let geometry = geometry_hash(base);
        let (held, levels) = tables(base).build(base).unwrap();
        let held_by = model.scene.add_mesh(held);
        model.scene.add_levels(mesh, held_by, levels).unwrap();
        let levels = vec![BakedLevels { kind: LevelKind::Chain, held_by, measured: MEASURED }];
        baked.meshes.push(BakedMesh { mesh, geometry, levels, ..BakedMesh::default() });
    }
    model.baked = Some(baked);
}
