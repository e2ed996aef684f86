//! How a node is taken out of Godot's pictures: by settings that are written to its server alone,
//! so that the node's own properties stay the user's.

use godot::classes::GeometryInstance3D;
use godot::classes::RenderingServer;
use godot::classes::rendering_server::ShadowCastingSetting;
use godot::obj::EngineEnum;
use godot::prelude::*;

use crate::look::Casts;

/// State of a node in Godot's server.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Shown {
    /// Drawn as the node says.
    #[default]
    Whole,
    /// No camera sees it, but its shadow may be seen.
    ShadowOnly,
    /// Neither it nor its shadow is seen. It is in no layer: taking it out of Godot's tree and
    /// putting it back would cost more.
    Gone,
}

/// Returns the state of a node that no camera sees.
pub(crate) fn unseen(casts: Casts, shadow_matters: bool) -> Shown {
    match casts {
        Casts::Off => Shown::Gone,
        _ if !shadow_matters => Shown::Gone,
        Casts::On => Shown::ShadowOnly,
        // Drawing them for shadows alone would make the shadow another, or they are drawn so.
        Casts::DoubleSided | Casts::Only => Shown::Whole,
    }
}

/// Tells Godot's server.
pub(crate) fn tell(
    server: &mut Gd<RenderingServer>,
    rid: Rid,
    node: &Gd<GeometryInstance3D>,
    from: Shown,
    to: Shown,
) {
    if from == to {
        return;
    }
    if from == Shown::Gone {
        server.instance_set_layer_mask(rid, node.get_layer_mask());
    }
    if from == Shown::ShadowOnly {
        let own = ShadowCastingSetting::from_ord(node.get_cast_shadows_setting().ord());
        server.instance_geometry_set_cast_shadows_setting(rid, own);
    }
    match to {
        Shown::Whole => {}
        Shown::Gone => server.instance_set_layer_mask(rid, 0),
        Shown::ShadowOnly => {
            let setting = ShadowCastingSetting::SHADOWS_ONLY;
            server.instance_geometry_set_cast_shadows_setting(rid, setting);
        }
    }
}
