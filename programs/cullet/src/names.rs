//! Names of instances and meshes, and reasons in words.

use cullet::{Reason, Stage};
use cullet_io::Model;
pub use cullet_io::mesh_name;

/// The name of a slot's instance; its slot where it has none.
pub fn name_of(model: &Model, slot: u32) -> String {
    let name = model.scene.handle(slot).map(|h| model.instance_name(h)).unwrap_or_default();
    if name.is_empty() { format!("instance {slot}") } else { name.to_string() }
}

/// A reason in words.
pub fn reason_text(reason: Reason) -> String {
    match reason.stage {
        Stage::Layer => "in no layer of the view".into(),
        Stage::Frustum if reason.detail == Reason::MIXED => {
            "outside the frustum, its parts by different planes".into()
        }
        Stage::Frustum => {
            let plane = cullet::view::FrustumPlane::ALL.get(usize::from(reason.detail));
            plane.map_or_else(
                || format!("outside plane {} of the frustum", reason.detail),
                |p| format!("outside the {} plane of the frustum", p.name()),
            )
        }
        Stage::Pvs => "not in the set of the eye's cell".into(),
        Stage::Portal => "not seen through any portal".into(),
        Stage::Detail => "too small on the screen".into(),
        Stage::Lod => "another level of detail is drawn instead".into(),
        Stage::Occlusion => "occluded".into(),
        Stage::Backface => "every triangle faces away".into(),
        Stage::Degenerate => "degenerate: no triangle has area".into(),
    }
}
