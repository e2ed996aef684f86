//! Extensions that are not read here: what they mean, and what they may change.

use std::collections::HashSet;

use super::json::{Root, Rtc};
use super::uri::shorten;
use crate::json::{FromJson as _, Object};
use crate::{ErrorKind, Unread};

/// Read here.
const READ: [&str; 11] = [
    super::BAKED,
    super::CELLS,
    POINTER,
    "CESIUM_RTC",
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_materials_transmission",
    "KHR_materials_pbrSpecularGlossiness",
];

/// Read as far as it moves nodes and weights.
const POINTER: &str = "KHR_animation_pointer";

/// Part of the picture that an extension may change.
#[derive(Clone, Copy, PartialEq)]
enum Change {
    /// How surfaces look, or what things mean: neither which triangles there are nor where.
    Nothing,
    /// Where things are as time passes, or whether they are there.
    Motion,
    /// The triangles that there are, or their places.
    Triangles,
}

use Change::{Motion, Nothing, Triangles};

/// Extensions by name, what they mean, and what they may change. Those that begin with an
/// underscore are the beginnings of names behind that of their vendor, whoever it is.
const KNOWN: [(&str, &str, Change); 44] = [
    ("KHR_draco_mesh_compression", "packed geometry: the plain copy beside it is read", Nothing),
    ("KHR_techniques_webgl", "shaders, which might move vertices: they stand as stored", Motion),
    ("KHR_blend", LOOKS, Nothing),
    ("KHR_mesh_primitive_restart", "strips and fans cut at an index", Triangles),
    ("KHR_gaussian_splatting", "splats, which are no triangles", Triangles),
    ("KHR_interactivity", "behaviour that may move, show and hide nodes", Motion),
    ("KHR_physics_rigid_bodies", "bodies that a simulation would move", Motion),
    ("KHR_node_hoverability", MEANING, Nothing),
    ("KHR_node_selectability", MEANING, Nothing),
    ("KHR_implicit_shapes", "shapes for collisions, which are not drawn", Nothing),
    ("EXT_mesh_manifold", "a second list of the same triangles, welded", Nothing),
    ("EXT_mesh_primitive_edge_visibility", "lines along edges", Nothing),
    ("EXT_primitive_voxels", "volumes, which are no triangles", Triangles),
    ("CESIUM_primitive_outline", "lines along edges", Nothing),
    ("CESIUM_tile_edges", "triangles that the edges of tiles are closed with", Triangles),
    ("CESIUM_geopose", "a place on the globe: the model stays about its own origin", Nothing),
    ("AGI_articulations", "joints that a program may move, and that rest", Nothing),
    ("AGI_stk_metadata", MEANING, Nothing),
    ("FB_ngon_encoding", "which triangles are one polygon", Nothing),
    ("FB_geometry_metadata", MEANING, Nothing),
    ("MSFT_lod", "coarser forms for what is far away: the finest is shown", Nothing),
    ("MSFT_physics", "bodies that a simulation would move", Motion),
    ("MPEG_", "media that is streamed, which may change meshes and move nodes", Triangles),
    ("OMI_", "bodies, seats and other parts of a game", Motion),
    ("VRM", "an avatar whose hair and clothes a program would move", Motion),
    ("_materials_", LOOKS, Nothing),
    ("_texture_", LOOKS, Nothing),
    ("_lights_", "lamps", Nothing),
    ("_environment", LOOKS, Nothing),
    ("_xmp", MEANING, Nothing),
    ("_audio", "sound", Nothing),
    ("_animation_", "what moves by it stands still", Motion),
    ("_packing_", LOOKS, Nothing),
    ("_mesh_features", MEANING, Nothing),
    ("_instance_features", MEANING, Nothing),
    ("_feature_metadata", MEANING, Nothing),
    ("_structural_metadata", MEANING, Nothing),
    ("_property_", MEANING, Nothing),
    ("_bim_", MEANING, Nothing),
    ("_metadata", MEANING, Nothing),
    ("_collider", "shapes for collisions, which are not drawn", Nothing),
    ("_collision_shapes", "shapes for collisions, which are not drawn", Nothing),
    ("_gaussian_splatting", "splats, which are no triangles", Triangles),
    ("_single_root", MEANING, Nothing),
];

const LOOKS: &str = "how surfaces look: no triangle is moved by it";
const MEANING: &str = "what things mean: no triangle is moved by it";

/// Knowledge of an extension.
fn known(name: &str) -> Option<(&'static str, Change)> {
    let fits = |known: &str| match known.strip_prefix('_') {
        Some(known) => name.split_once('_').is_some_and(|(_, rest)| rest.starts_with(known)),
        None => name.starts_with(known),
    };
    let found =
        KNOWN.iter().filter(|(known, ..)| fits(known)).max_by_key(|(known, ..)| *known == name);
    found.map(|&(_, meaning, change)| (meaning, change))
}

/// The command that unpacks Draco.
pub(super) const UNPACK: &str = "`npx @gltf-transform/cli copy in.glb out.glb`";

/// Judges the required extensions.
///
/// # Errors
/// If one is compression that is not read here, may change triangles, or is unknown.
pub(super) fn check(required: &[String]) -> Result<(), ErrorKind> {
    for name in required.iter().filter(|name| !READ.contains(&name.as_str())) {
        if name == "KHR_draco_mesh_compression" {
            return Err(ErrorKind::Unsupported(draco()));
        }
        if known(name).is_none_or(|(_, change)| change == Triangles) {
            return Err(ErrorKind::Unsupported(format!(
                "requires the extension {}, which is not read here and may change geometry; export \
                 the model without it",
                shorten(name)
            )));
        }
    }
    Ok(())
}

/// The centre of `CESIUM_RTC`, zero where there is none.
///
/// # Errors
/// If it is no three numbers.
pub(super) fn centre(root: &Root<'_>) -> Result<[f64; 3], ErrorKind> {
    let invalid = |message| ErrorKind::invalid("CESIUM_RTC", message);
    let Some(all) = root.extensions.and_then(|all| Object::from_json(all).ok()) else {
        return Ok([0.0; 3]);
    };
    let rtc: Option<Rtc> = all.get("CESIUM_RTC").map_err(invalid)?;
    Ok(rtc.map_or([0.0; 3], |rtc| rtc.center))
}

/// The extensions that a document says it uses, and those at its top, that are not read, each once.
/// `pointer` is one of `KHR_animation_pointer` that is not played.
pub(super) fn unread(root: &Root<'_>, pointer: Option<&str>) -> Vec<Unread> {
    let top = root.extensions.and_then(|all| Object::from_json(all).ok()).unwrap_or_default();
    let top = top.members().map(|(name, _)| name.as_ref());
    let named = root.extensions_required.iter().chain(&root.extensions_used).map(String::as_str);
    let mut seen: HashSet<&str> = READ.into_iter().collect();
    let names: Vec<&str> = named.chain(top).filter(|name| seen.insert(name)).collect();
    let mut unread: Vec<Unread> = names.into_iter().map(judged).collect();
    unread.extend(pointer.map(|pointer| Unread {
        name: POINTER.to_owned(),
        meaning: format!("where it animates other than nodes: {pointer} stands still"),
        may_move: may_move(pointer),
        may_draw: false,
    }));
    unread
}

fn judged(name: &str) -> Unread {
    let (meaning, change) = match known(name) {
        Some((meaning, change)) => (meaning, Some(change)),
        None => {
            ("which is unknown here: it may change what is drawn, where, and how it moves", None)
        }
    };
    Unread {
        name: shorten(name),
        meaning: meaning.to_owned(),
        may_move: change.is_none_or(|change| change != Nothing),
        may_draw: change.is_none_or(|change| change == Triangles),
    }
}

/// Whether what a pointer leads to may move or hide what is drawn.
pub(super) fn may_move(pointer: &str) -> bool {
    let harmless = ["/materials/", "/textures/", "/images/", "/samplers/", "/cameras/"];
    !harmless.iter().any(|part| pointer.starts_with(part)) && !pointer.contains("KHR_lights")
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

    fn required(name: &str) -> Result<(), String> {
        check(&[name.to_owned()]).map_err(|e| e.to_string())
    }

    #[test]
    fn required_extensions_that_cannot_change_triangles_pass() {
        for name in [
            "EXT_mesh_gpu_instancing",
            "KHR_meshopt_compression",
            "KHR_texture_transform",
            "KHR_materials_unlit",
            "ANYBODY_materials_velvet",
            "KHR_animation_pointer",
            "VRMC_vrm",
        ] {
            assert_eq!(required(name), Ok(()), "{name}");
        }
    }

    #[test]
    fn the_rest_is_refused_by_name() {
        assert!(required("KHR_draco_mesh_compression").unwrap_err().contains("gltf-transform"));
        assert!(required("materials_").is_err());
        for name in ["KHR_gaussian_splatting", "KHR_mesh_primitive_restart", "NOBODY_knows"] {
            assert!(required(name).unwrap_err().contains(name));
        }
    }

    #[test]
    fn what_an_extension_may_change_is_told_by_its_name() {
        let of = |name| {
            let Unread { may_move, may_draw, .. } = judged(name);
            (may_move, may_draw)
        };
        assert_eq!(of("KHR_lights_punctual"), (false, false));
        assert_eq!(of("ANYBODY_materials_velvet"), (false, false));
        assert_eq!(of("KHR_interactivity"), (true, false));
        assert_eq!(of("VRMC_springBone"), (true, false));
        assert_eq!(of("KHR_gaussian_splatting_compression_spz"), (true, true));
        assert_eq!(of("NOBODY_knows"), (true, true));
        assert!(may_move("/nodes/0/extensions/KHR_node_visibility/visible"));
        assert!(!may_move("/materials/0/pbrMetallicRoughness/baseColorFactor"));
        assert!(!may_move("/extensions/KHR_lights_punctual/lights/0/color"));
    }
}
