//! The impostor of a mesh in `CULLET_baked`.

use serde_json::{Value, json};

use super::buffer::File;
use crate::Model;
use crate::baked::{BakedMesh, LevelKind, Measured, impostor_sum, impostor_to_bytes};

/// The object of the impostor of a mesh, if it has one.
pub(super) fn write(model: &Model, one: &BakedMesh, file: &mut File) -> Option<Value> {
    let own = one.levels.iter().find(|levels| levels.kind == LevelKind::Impostor)?;
    let all = model.scene.levels(one.mesh);
    let impostor = all.iter().find(|of| of.mesh == own.held_by)?.impostor.as_ref()?;
    let bytes = impostor_to_bytes(impostor);
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
