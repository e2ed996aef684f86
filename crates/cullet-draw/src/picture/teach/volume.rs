//! A cluster and the region of eyes from which all of it faces away.

use cullet::cull::backface::ClusterPlanes;
use cullet::{Mesh, Scene};
use cullet_methods::cluster::{Bound, CullingRegion, NormalBox};
use glam::{DMat3, DVec3};

use super::sheet::{Flat, Sheet};
use super::surface::{colored, planes_of, whole};
use super::{BACK, KEPT};
use crate::picture::Picture;
use crate::picture::palette::{INK, PROVED, SUBJECT, mix};

/// How far the box reaches from the cluster's middle, in radii of the cluster.
const REACH: f64 = 4.0;
/// A region with a smaller share of the box has no picture.
const LEAST_SHARE: f64 = 0.02;

/// Figures of a picture of a culling volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeFigure {
    /// Which cluster of the mesh.
    pub cluster: u32,
    /// The share of the box from which every triangle faces away.
    pub ideal: f64,
    /// The share that Johannsen and Carter's bound proves.
    pub proved: f64,
}

/// The culling volume of a cluster of the mesh in `slot`, in a box around it: the ideal one in pink,
/// and in green inside of it the one that Johannsen and Carter's box of normals proves. On the left the
/// scene with the cluster marked.
///
/// Without a number the cluster is the one whose normals spread the most of those that still have at
/// least 2 % of the box both ways. `None` if the slot or cluster does not exist, or the cluster has no
/// region. The volume is drawn in the space of the mesh. Cost: a frame, and microseconds a cluster.
#[must_use]
pub fn culling_volume(
    scene: &Scene,
    slot: u32,
    cluster: Option<u32>,
    size: [u32; 2],
) -> Option<(Picture, VolumeFigure)> {
    let mesh = (slot < scene.slot_count()).then(|| scene.mesh(slot))?;
    let cluster = cluster.or_else(|| widest(mesh))?;
    let c = *mesh.clusters().get(cluster as usize)?;
    let planes = planes_of(mesh, c.first_triangle, c.triangle_count);
    let (ideal, proved, room) = regions(&planes)?;
    let figure =
        VolumeFigure { cluster, ideal: ideal.volume() / room, proved: proved.volume() / room };
    let mut sheet = Sheet::new(size);
    sheet.title(format!("Cluster {cluster} and its culling volume"));
    let words = [
        (SUBJECT, "the cluster".to_owned()),
        (BACK, format!("all of it faces away: {:.0} % of the box", figure.ideal * 100.0)),
        (PROVED, format!("proved by Johannsen & Carter: {:.0} %", figure.proved * 100.0)),
    ];
    let words: Vec<_> = words.iter().map(|(c, w)| (*c, w.as_str())).collect();
    sheet.legend(&words);
    let [w, _] = sheet.size();
    let [top, bottom] = sheet.room();
    let marked = |s: u32, t: u32| {
        let inside = s == slot && t.wrapping_sub(c.first_triangle) < c.triangle_count;
        if inside { SUBJECT } else { mix(KEPT, INK, 0.15) }
    };
    let left = [(w * 0.5) as u32 - 20, (bottom - top) as u32];
    let axis = axis(&planes);
    let linear = DMat3::from_cols_array_2d(&scene.transform(slot).linear.map(|c| c.map(f64::from)));
    let seen_from = (linear.inverse().transpose() * axis).normalize_or_zero() + DVec3::Y * 0.25;
    if let Some(view) = whole(scene, seen_from, left) {
        sheet.paste([16, top as u32], &colored(scene, &view, &marked).0);
    }
    // From beside the cluster and a little before it, so that it lies on top of its volume.
    let side = axis.any_orthonormal_vector();
    let toward = axis * 0.35 + side + axis.cross(side) * 0.45;
    let reach = planes.radius() * REACH;
    let scale = (w * 0.5 - 40.0).min(bottom - top - 10.0) / (reach * 3.3);
    let middle = [w * 0.75, (top + bottom) * 0.5];
    let camera = Flat::new(toward, DVec3::from(planes.centre()), middle, scale);
    draw(&mut sheet, &camera, &planes, &ideal, &proved, mesh, c.first_triangle, c.triangle_count);
    Some((sheet.finish(), figure))
}

/// Both regions in the box around a cluster, and the volume of the box.
fn regions(planes: &ClusterPlanes) -> Option<(CullingRegion, CullingRegion, f64)> {
    let bound = NormalBox::fit(planes)?;
    let reach = planes.radius() * REACH;
    let (low, high) = (planes.centre().map(|v| v - reach), planes.centre().map(|v| v + reach));
    let ideal = CullingRegion::of_planes(planes, low, high);
    let proved = CullingRegion::of_normal_box(&bound, low, high);
    (!ideal.is_empty()).then_some((ideal, proved, (2.0 * reach).powi(3)))
}

/// The mean of the normals.
fn axis(planes: &ClusterPlanes) -> DVec3 {
    planes.half_spaces().map(|(n, _)| DVec3::from(n)).sum::<DVec3>().normalize_or(DVec3::Y)
}

/// The cluster with the widest normals that still has a region.
fn widest(mesh: &Mesh) -> Option<u32> {
    let spread = |c: u32| {
        let cluster = mesh.clusters()[c as usize];
        let planes = planes_of(mesh, cluster.first_triangle, cluster.triangle_count);
        let (_, proved, whole) = regions(&planes)?;
        let axis = axis(&planes);
        let least = planes.half_spaces().map(|(n, _)| DVec3::from(n).dot(axis));
        let least = least.fold(1.0, f64::min);
        (proved.volume() > LEAST_SHARE * whole).then_some((least, c))
    };
    let all = (0..mesh.clusters().len() as u32).filter_map(spread);
    all.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, c)| c)
}

#[expect(clippy::too_many_arguments, reason = "the parts of one drawing, called once")]
fn draw(
    sheet: &mut Sheet,
    camera: &Flat,
    planes: &ClusterPlanes,
    ideal: &CullingRegion,
    proved: &CullingRegion,
    mesh: &Mesh,
    first: u32,
    count: u32,
) {
    let reach = planes.radius() * REACH;
    let corner = |i: usize| {
        let side = |k: usize| if i >> k & 1 == 1 { reach } else { -reach };
        DVec3::from(planes.centre()) + DVec3::new(side(0), side(1), side(2))
    };
    let edges = |sheet: &mut Sheet, front: bool| {
        for (i, k) in (0..8usize).flat_map(|i| (0..3).map(move |k| (i, k))) {
            // The edges of the three sides that face the viewer are in front.
            let facing = |axis: usize| (i >> axis & 1 == 1) == (camera.toward[axis] > 0.0);
            let is_front = (0..3).any(|a| a != k && facing(a));
            if i >> k & 1 == 0 && is_front == front {
                let ends = [corner(i), corner(i | 1 << k)].map(|p| camera.point(p));
                let color = if front { INK } else { mix(KEPT, INK, 0.35) };
                sheet.line(ends[0], ends[1], 1.0, color);
            }
        }
    };
    edges(sheet, false);
    faces(sheet, camera, ideal, false, BACK, 0.30);
    faces(sheet, camera, proved, false, PROVED, 0.40);
    faces(sheet, camera, proved, true, PROVED, 0.45);
    faces(sheet, camera, ideal, true, BACK, 0.22);
    let mut triangles: Vec<[DVec3; 3]> = (first..first + count)
        .map(|t| mesh.corners(t).map(|p| DVec3::from(p.map(f64::from))))
        .collect();
    let depth = |t: &[DVec3; 3]| t.iter().map(|p| p.dot(camera.toward)).sum::<f64>();
    triangles.sort_by(|a, b| depth(a).total_cmp(&depth(b)));
    for t in triangles {
        let points = t.map(|p| camera.point(p));
        let n = (t[1] - t[0]).cross(t[2] - t[0]).normalize_or_zero();
        let lit = 0.35 * (1.0 - n.dot(camera.toward).abs());
        sheet.fill(&points, mix(SUBJECT, INK, lit), 1.0);
        sheet.outline(&points, 0.5, mix(SUBJECT, INK, 0.6));
    }
    edges(sheet, true);
}

/// The faces of a region that face the viewer, or those that do not.
fn faces(sheet: &mut Sheet, camera: &Flat, r: &CullingRegion, front: bool, color: [u8; 3], a: f64) {
    for face in r.faces() {
        let at = |i: usize| DVec3::from(r.vertices()[face.vertices[i] as usize]);
        let points: Vec<_> = (0..face.vertices.len()).map(|i| camera.point(at(i))).collect();
        let n: DVec3 =
            (1..points.len() - 1).map(|i| (at(i) - at(0)).cross(at(i + 1) - at(0))).sum();
        if (n.dot(camera.toward) > 0.0) != front {
            continue;
        }
        sheet.fill(&points, color, a);
        let cut = face.half_space.is_some();
        sheet.outline(&points, if cut { 1.2 } else { 0.8 }, mix(color, INK, 0.35));
    }
}
