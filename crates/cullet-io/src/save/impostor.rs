//! The impostor of a mesh in `CULLET_baked`.

use cullet_mesh::Impostor;
use serde_json::{Value, json};

use super::buffer::File;
use crate::Model;
use crate::baked::{BakedMesh, LevelKind, Measured, impostor_sum, impostor_to_bytes};

/// The object of the impostor of a mesh, if it has one.
pub(super) fn write(model: &Model, one: &BakedMesh, file: &mut File) -> Option<Value> {
    let own = one.levels.iter().find(|levels| levels.kind == LevelKind::Impostor)?;
    let all = model.scene.levels(one.mesh);
    let impostor = Impostor::of(all.iter().find(|of| of.mesh == own.held_by)?)?;
    // Parts without triangles are not written, so the others have other numbers in the file.
    let parts = model.scene.meshes()[one.mesh as usize].parts();
    let number = |part: u16| {
        let before = parts.iter().take(part.into());
        before.filter(|p| p.triangle_count > 0).count() as u16
    };
    let shape = impostor.shape().iter().map(|&w| w & 0xf0ff | number(w >> 8 & 15) << 8).collect();
    let sizes = [impostor.grid(), impostor.texels()];
    let normals = impostor.normals().to_vec();
    let written = Impostor::new(
        sizes,
        (impostor.bounds(), impostor.radius()),
        impostor.error(),
        shape,
        normals,
    )
    .ok()?;
    let bytes = impostor_to_bytes(&written);
    let hash = impostor_sum(one.geometry, &own.measured, &bytes);
    let Measured { points, quantile, most_over, seed, .. } = own.measured;
    Some(json!({
        "grid": impostor.grid(),
        "texels": impostor.texels(),
        "error": impostor.error(),
        "atlas": file.table(&bytes),
        "hash": format!("{hash:016x}"),
        "measured": {
            "directions": points, "quantile": quantile, "mostOver": most_over, "seed": seed,
        },
    }))
}
