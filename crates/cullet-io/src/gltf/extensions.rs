//! Required extensions that a loader of geometry may ignore.

use crate::ErrorKind;

use super::notes::Notes;
use super::uri::shorten;

/// Read here.
const READ: [&str; 8] = [
    super::BAKED,
    super::CELLS,
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_materials_transmission",
    "KHR_materials_pbrSpecularGlossiness",
];

/// They say how surfaces look, what nodes mean, or how they move, not where triangles are:
/// whoever's they are, so the vendor before the first underscore does not count.
const HARMLESS_PREFIXES: [&str; 12] = [
    "materials_",
    "texture_",
    "lights_",
    "xmp",
    "audio",
    "animation_",
    "packing_",
    "mesh_features",
    "instance_features",
    "feature_metadata",
    "structural_metadata",
    "property_",
];

/// The same, by their whole names.
const HARMLESS: [&str; 7] = [
    "AGI_articulations",
    "AGI_stk_metadata",
    "CESIUM_primitive_outline",
    "FB_ngon_encoding",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "MSFT_lod",
];

/// The command that unpacks Draco.
pub(super) const UNPACK: &str = "`npx @gltf-transform/cli copy in.glb out.glb`";

/// Judges the required extensions: those that cannot change geometry are passed over with a note.
///
/// # Errors
/// If one is compression that is not read here, or is unknown.
pub(super) fn check(required: &[String], notes: &mut Notes) -> Result<(), ErrorKind> {
    for name in required {
        let name = name.as_str();
        if READ.contains(&name) {
            continue;
        }
        let harmless = HARMLESS.contains(&name)
            || name
                .split_once('_')
                .is_some_and(|(_, rest)| HARMLESS_PREFIXES.iter().any(|p| rest.starts_with(p)));
        if harmless {
            notes.push(name, "is required but cannot change geometry, and is not read");
            continue;
        }
        let name = shorten(name);
        return Err(ErrorKind::Unsupported(match name.as_str() {
            "KHR_draco_mesh_compression" => draco(),
            "KHR_meshopt_compression" => format!(
                "its geometry is packed by {name}; unpack it with {UNPACK}, or pack it by EXT_meshopt_compression"
            ),
            _ => format!(
                "requires the extension {name}, which is not read here and may change geometry; \
                 export the model without it"
            ),
        }));
    }
    Ok(())
}

/// The refusal of Draco.
pub(super) fn draco() -> String {
    format!(
        "its geometry is packed by KHR_draco_mesh_compression, which is not read here; unpack it with {UNPACK}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judge(name: &str) -> Result<usize, String> {
        let mut notes = Notes::default();
        check(&[name.to_owned()], &mut notes).map_err(|e| e.to_string())?;
        Ok(notes.into_warnings().len())
    }

    #[test]
    fn what_is_read_needs_no_note_and_what_is_harmless_gets_one() {
        assert_eq!(judge("EXT_mesh_gpu_instancing"), Ok(0));
        assert_eq!(judge("KHR_texture_transform"), Ok(1));
        assert_eq!(judge("KHR_materials_unlit"), Ok(1));
        assert_eq!(judge("ANYBODY_materials_velvet"), Ok(1));
    }

    #[test]
    fn the_rest_is_refused_by_name() {
        assert!(judge("KHR_draco_mesh_compression").unwrap_err().contains("gltf-transform"));
        assert!(judge("materials_").is_err());
        assert!(judge("KHR_gaussian_splatting").unwrap_err().contains("KHR_gaussian_splatting"));
    }
}
