//! Materials: what of them bears on visibility.

use cullet::mesh::Alpha;

use super::json::{self, MaterialItem, Root};
use super::notes::Notes;
use super::uri::shorten;
use crate::{ErrorKind, Material};

/// A material, and what it makes of a part.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    pub(super) material: Material,
    pub(super) two_sided: bool,
    pub(super) alpha: Alpha,
}

/// Reads all materials.
///
/// # Errors
/// If one is malformed.
pub(super) fn read(root: &Root<'_>, notes: &mut Notes) -> Result<Vec<Surface>, ErrorKind> {
    let mut all = Vec::new();
    for (i, json) in json::all(&root.materials).iter().enumerate() {
        all.push(surface(json::item(*json, "material", i)?, i, notes));
    }
    Ok(all)
}

/// The material of a primitive that names none: opaque, grey, one-sided as the specification has
/// it.
pub(super) fn default() -> Surface {
    Surface {
        material: Material { name: "default".into(), color: [1.0; 4] },
        two_sided: false,
        alpha: Alpha::Opaque,
    }
}

fn surface(item: MaterialItem<'_>, index: usize, notes: &mut Notes) -> Surface {
    let name = match item.name.as_deref() {
        Some(name) if !name.is_empty() => shorten(name),
        _ => format!("material {index}"),
    };
    let mut alpha = match item.alpha_mode.as_deref() {
        None | Some("OPAQUE") => Alpha::Opaque,
        Some("MASK") => Alpha::Masked,
        Some("BLEND") => Alpha::Blended,
        Some(other) => {
            let other = shorten(other);
            // Taken for opaque it might hide what can be seen through it.
            notes.push(&name, format!("its alphaMode {other:?} is unknown: taken for BLEND"));
            Alpha::Blended
        }
    };
    let clear = item.transmission.is_some_and(|t| t.transmission_factor > 0.0);
    if clear && alpha == Alpha::Opaque {
        notes.push(&name, "lets light through (KHR_materials_transmission): taken for BLEND");
        alpha = Alpha::Blended;
    }
    let glossy = item.glossiness.and_then(|g| g.diffuse_factor);
    let base = item.pbr_metallic_roughness.and_then(|pbr| pbr.base_color_factor);
    let color = base.or(glossy).unwrap_or([1.0; 4]);
    Surface { material: Material { name, color }, two_sided: item.double_sided, alpha }
}
