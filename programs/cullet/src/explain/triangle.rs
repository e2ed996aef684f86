//! One triangle against every test that is made of triangles and of their cluster.

use cullet::cull::backface::{ClusterEye, Facing, ObjectEye};
use cullet::view::FrustumPlane;
use cullet::{Scene, Stage, View, Visible, explain::PlaneTest};
use cullet_command::console::count;
use cullet_command::exit::Failure;
use cullet_draw::{Frame, PixelId};
use glam::{DMat3, DVec3, DVec4};

use super::record::{ConeRecord, TriangleRecord};

/// Explains an original triangle of an instance that is drawn by its own mesh.
pub(super) fn explain(
    scene: &Scene,
    view: &View,
    result: &Visible,
    frame: &Frame,
    (slot, original): (u32, u32),
) -> Result<TriangleRecord, Failure> {
    let mesh = scene.mesh(slot);
    let place = mesh.original_triangle().iter().position(|&o| o == original);
    let Some(t) = place.map(|t| t as u32) else {
        return Err(Failure::usage(format!(
            "--triangle {original}: the mesh has {}, numbered from 0",
            count(u64::from(mesh.triangle_count()), "triangle", "triangles")
        )));
    };
    let transform = scene.transform(slot);
    let linear = DMat3::from_cols_array_2d(&transform.linear.map(|c| c.map(f64::from)));
    let local = mesh.corners(t);
    let corners =
        local.map(|p| linear * DVec3::from(p.map(f64::from)) + DVec3::from(transform.translation));
    let [a, b, c] = corners;
    let cross = (b - a).cross(c - a);
    let planes = view.frustum();
    let planes: Vec<PlaneTest> = planes
        .planes()
        .map(|(number, plane)| {
            let distances = corners.map(|p| plane.distance(p));
            PlaneTest {
                plane: number as u8,
                nearest: distances.iter().copied().fold(f64::INFINITY, f64::min),
                farthest: distances.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            }
        })
        .collect();
    let eye = DVec4::from(view.eye());
    let normal = cross.normalize_or_zero();
    let facing = (normal != DVec3::ZERO).then(|| normal.dot(eye.truncate() - a * eye.w));
    let object = ObjectEye::of_view(view, transform);
    let side = match object.facing(&local) {
        Facing::Front => "front",
        Facing::Back => "back",
        Facing::Edge => "edge",
    };
    let cluster = mesh.clusters().iter().position(|c| c.triangles().contains(&t));
    let stage = result.stage_of(slot, t);
    let id = PixelId { slot, triangle: original };
    let owned_pixels = frame.ids.iter().filter(|&&other| other == id).count() as u64;
    let mut record = TriangleRecord {
        triangle: original,
        cluster: cluster.map(|c| c as u32),
        corners: corners.map(Into::into),
        area: cross.length() * 0.5,
        planes,
        facing,
        side,
        cone: cluster.and_then(|cluster| cone(scene, slot, cluster, &object)),
        owned_pixels,
        drawn: stage.is_none(),
        stage,
        sentence: String::new(),
    };
    record.sentence = sentence(&record);
    Ok(record)
}

/// The cone of a cluster against the eye, where the mesh has cones for the side that is culled.
fn cone(scene: &Scene, slot: u32, cluster: usize, object: &ObjectEye) -> Option<ConeRecord> {
    let prepared = scene.prepared_of(slot);
    let cone = prepared.cluster_cones(object.culled_side())?.get(cluster)?;
    let eye = prepared.backfaces()?.eye(object)?;
    let eye = ClusterEye::new(eye.homogeneous())?;
    let way = DVec3::from(eye.way_from(cone.apex).map(f64::from));
    let [along, s, t] =
        [cone.axis, cone.s, cone.t].map(|axis| DVec3::from(axis.map(f64::from)).dot(way));
    let within = along * along - (s * s + t * t);
    Some(ConeRecord { along, within, behind: cone.is_behind_eye(&eye) })
}

fn sentence(record: &TriangleRecord) -> String {
    let number = record.triangle;
    let Some(stage) = record.stage else {
        let pixels = count(record.owned_pixels, "pixel", "pixels");
        return format!("triangle {number} is drawn; it owns {pixels}");
    };
    let why = match (stage, record.facing) {
        (Stage::Backface, Some(value)) => {
            format!("the eye is {:.4} units behind its plane", -value)
        }
        (Stage::Frustum, _) => {
            let outside = record.planes.iter().filter(|p| p.nearest > 0.0);
            let farthest = outside.max_by(|a, b| a.nearest.total_cmp(&b.nearest));
            farthest.map_or_else(
                || "its cluster or its instance is outside".to_owned(),
                |p| {
                    format!(
                        "it is {:.4} units outside the {} plane",
                        p.nearest,
                        plane_name(p.plane)
                    )
                },
            )
        }
        (Stage::Degenerate, _) => format!("its area is {:e}", record.area),
        _ => "its cluster or its instance was".to_owned(),
    };
    format!("triangle {number} is dropped by {}: {why}", stage.name())
}

/// The name of a plane of the frustum.
pub(super) fn plane_name(number: u8) -> String {
    let plane = FrustumPlane::ALL.get(usize::from(number));
    plane.map_or_else(|| format!("extra {number}"), |p| p.name().to_owned())
}
