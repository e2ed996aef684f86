//! The cameras of a GLB, each where its first key is.

use cullet::Projection;
use glam::DMat4;
use serde_json::{Value, json};

use crate::Model;

/// The cameras, and a node for each. Projections that glTF does not have are left out: windows that
/// are not centred, and parallel ones from behind the camera.
pub(super) fn write(model: &Model, nodes: &mut Vec<Value>, roots: &mut Vec<usize>) -> Vec<Value> {
    let mut cameras = Vec::new();
    for camera in &model.cameras {
        let Some((_, place)) = camera.keys.first() else { continue };
        let place = DMat4::from_cols_array(&place.to_matrix());
        let Some(mut object) = projection(&camera.projection).filter(|_| place.is_finite()) else {
            continue;
        };
        object["name"] = json!(camera.name);
        roots.push(nodes.len());
        nodes.push(json!({
            "name": camera.name, "camera": cameras.len(), "matrix": place.to_cols_array(),
        }));
        cameras.push(object);
    }
    cameras
}

fn projection(projection: &Projection) -> Option<Value> {
    match *projection {
        Projection::Perspective { fov_y_radians, aspect, near, far } => {
            let mut numbers = json!({ "yfov": fov_y_radians, "znear": near });
            if aspect > 0.0 {
                numbers["aspectRatio"] = json!(aspect);
            }
            if far.is_finite() {
                numbers["zfar"] = json!(far);
            }
            Some(json!({ "type": "perspective", "perspective": numbers }))
        }
        Projection::Orthographic { left, right, bottom, top, near, far }
            if left == -right && bottom == -top && near >= 0.0 =>
        {
            let numbers = json!({ "xmag": right, "ymag": top, "znear": near, "zfar": far });
            Some(json!({ "type": "orthographic", "orthographic": numbers }))
        }
        _ => None,
    }
}
