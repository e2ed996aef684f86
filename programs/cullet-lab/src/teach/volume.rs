//! A cluster and the region of eyes from which all of it faces away.

use crate::methods::cluster::{Bound, CullingRegion, NormalBox};
use cullet::cull::backface::ClusterPlanes;
use cullet::mesh::Cluster;
use cullet::{Mesh, Scene};
use glam::{DMat3, DVec3};

use super::sheet::{Flat, Sheet};
use super::surface::{colored, planes_of, whole};
use super::{BACK, KEPT};
use cullet_draw::Picture;
use cullet_draw::picture::palette::{INK, PAPER, PROVED, SEEN, SUBJECT, mix};

/// How far the box reaches from the cluster's middle, in radii of the cluster.
const REACH: f64 = 4.0;
/// The radius of the circle on which an eye goes round a mesh, in radii of that.
const CIRCLE: f64 = 1.7;
/// A region with a smaller share of the box has no picture.
const LEAST_SHARE: f64 = 0.02;

/// Figures of a picture of a culling volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeFigure {
    /// Number of the cluster in the mesh.
    pub cluster: u32,
    /// The share of the box from which every triangle faces away.
    pub ideal: f64,
    /// The share that Johannsen and Carter's bound proves.
    pub proved: f64,
}

/// The culling volume of a cluster: the eyes from which all of it faces away, in a box around it.
/// All is in the space of its mesh.
#[derive(Debug)]
pub struct CullingVolume<'a> {
    mesh: &'a Mesh,
    cluster: u32,
    planes: ClusterPlanes,
    bound: NormalBox,
    ideal: CullingRegion,
    proved: CullingRegion,
    /// How far the box reaches from the middle of the cluster, and its volume.
    reach: f64,
    room: f64,
}

impl<'a> CullingVolume<'a> {
    /// Builds the volume of a cluster of the mesh in `slot`; without a number, of the cluster whose
    /// normals spread the most among those that still have at least 2 % of the box both ways.
    /// `None` if the slot or cluster does not exist, or the cluster has no region.
    #[must_use]
    pub fn new(scene: &'a Scene, slot: u32, cluster: Option<u32>) -> Option<Self> {
        let mesh = (slot < scene.slot_count()).then(|| scene.mesh(slot))?;
        let cluster = cluster.or_else(|| widest(mesh))?;
        let c = *mesh.clusters().get(cluster as usize)?;
        let planes = planes_of(mesh, c.first_triangle, c.triangle_count);
        let (bound, reach) = (NormalBox::fit(&planes)?, planes.radius() * REACH);
        let (ideal, proved, room) = regions(&planes, &bound, reach)?;
        Some(Self { mesh, cluster, planes, bound, ideal, proved, reach, room })
    }

    /// The same in a box in which the whole mesh has room, and an eye that circles it: see
    /// [`circle`](Self::circle).
    #[must_use]
    pub fn around_mesh(self) -> Self {
        let (middle, radius) = self.ball();
        let reach = middle.distance(DVec3::from(self.planes.centre())) + radius * CIRCLE * 1.05;
        match regions(&self.planes, &self.bound, reach) {
            Some((ideal, proved, room)) => Self { ideal, proved, reach, room, ..self },
            None => self,
        }
    }

    /// Its figures.
    #[must_use]
    pub fn figure(&self) -> VolumeFigure {
        let share = |region: &CullingRegion| region.volume() / self.room;
        VolumeFigure {
            cluster: self.cluster,
            ideal: share(&self.ideal),
            proved: share(&self.proved),
        }
    }

    /// A place on a circle around the mesh, through the culling volume: `turn` is 0 to 1, and 0 the
    /// place that is the most before the cluster.
    #[must_use]
    pub fn circle(&self, turn: f64) -> [f64; 3] {
        let (middle, radius) = self.ball();
        let front = axis(&self.planes);
        let side = front.cross(self.upright());
        let (s, c) = (turn * std::f64::consts::TAU).sin_cos();
        (middle + (front * c + side * s) * (radius * CIRCLE)).into()
    }

    /// The mesh as seen from aside, each triangle that faces away from an eye in the colour of back
    /// faces, with the culling volume and the eye, at `size`. Returns too whether all of the
    /// cluster faces away from there, and whether that is proved by Johannsen and Carter's bound.
    /// Cost: a frame of four times the pixels.
    #[must_use]
    pub fn seen_by(&self, eye: [f64; 3], size: [u32; 2]) -> (Picture, [bool; 2]) {
        let eye = DVec3::from(eye);
        let homogeneous = eye.extend(1.0).to_array();
        let is_in = [self.planes.is_behind(homogeneous), self.bound.is_behind(homogeneous)];
        let mut sheet = Sheet::new(size);
        let words = [
            (SUBJECT, "the cluster"),
            (BACK, "faces away from the eye; volume from where all of the cluster does"),
            (PROVED, "proved"),
        ];
        sheet.legend(&words);
        let size = sheet.size();
        let [top, bottom] = sheet.room();
        let (middle, radius) = self.ball();
        let up = self.upright();
        let toward = axis(&self.planes).cross(up) * 0.55 + up * 0.62 + axis(&self.planes) * 0.55;
        let scale = (bottom - top) * 0.5 / (radius * CIRCLE * 0.8);
        let camera = Flat::new(toward, middle, [size[0] * 0.5, (top + bottom) * 0.5], scale);
        box_edges(&mut sheet, &camera, &self.planes, self.reach, false);
        faces(&mut sheet, &camera, &self.ideal, false, BACK, 0.22);
        faces(&mut sheet, &camera, &self.proved, false, PROVED, 0.30);
        let ring: Vec<DVec3> = (0..96).map(|k| self.circle(f64::from(k) / 96.0).into()).collect();
        let is_behind = |p: &DVec3| (*p - middle).dot(camera.toward) < 0.0;
        let draw_ring = |sheet: &mut Sheet, behind: bool| {
            for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                if is_behind(a) == behind {
                    sheet.line(camera.point(*a), camera.point(*b), 1.2, mix(INK, PAPER, 0.3));
                }
            }
        };
        draw_ring(&mut sheet, true);
        self.draw_mesh(&mut sheet, &camera, eye);
        draw_ring(&mut sheet, false);
        faces(&mut sheet, &camera, &self.proved, true, PROVED, 0.12);
        faces(&mut sheet, &camera, &self.ideal, true, BACK, 0.08);
        box_edges(&mut sheet, &camera, &self.planes, self.reach, true);
        let (at, cluster) = (camera.point(eye), camera.point(self.planes.centre().into()));
        sheet.line(at, cluster, 1.2, INK);
        let color = match is_in {
            [_, true] => PROVED,
            [true, _] => BACK,
            _ => SEEN,
        };
        sheet.disc(at, 8.0, INK);
        sheet.disc(at, 6.0, color);
        (sheet.finish(), is_in)
    }

    /// The triangles of the mesh, the farthest first, lit, by which side of them the eye sees.
    fn draw_mesh(&self, sheet: &mut Sheet, camera: &Flat, eye: DVec3) {
        let own = self.range().triangles();
        let mut triangles: Vec<(bool, [DVec3; 3])> = (0..self.mesh.triangle_count())
            .map(|t| {
                (own.contains(&t), self.mesh.corners(t).map(|p| DVec3::from(p.map(f64::from))))
            })
            .collect();
        let depth = |t: &[DVec3; 3]| t.iter().map(|p| p.dot(camera.toward)).sum::<f64>();
        triangles.sort_by(|a, b| depth(&a.1).total_cmp(&depth(&b.1)));
        for (is_own, t) in triangles {
            let n = (t[1] - t[0]).cross(t[2] - t[0]).normalize_or_zero();
            // What a viewer sees of a solid from its back is hidden by its front.
            if n.dot(camera.toward) <= 0.0 && !self.mesh.is_two_sided() {
                continue;
            }
            let color = match (is_own, n.dot(eye - t[0]) < 0.0) {
                (true, _) => SUBJECT,
                (_, true) => BACK,
                _ => SEEN,
            };
            let light = 0.45 * (1.0 - n.dot(camera.toward).abs());
            sheet.fill(&t.map(|p| camera.point(p)), mix(color, INK, light), 1.0);
        }
    }

    /// The middle of the mesh, and how far it reaches from there.
    fn ball(&self) -> (DVec3, f64) {
        let bounds = self.mesh.bounds();
        (DVec3::from(bounds.center()), DVec3::from(bounds.half_extent()).length())
    }

    /// Across the axis of the cluster, as near to upright as that allows.
    fn upright(&self) -> DVec3 {
        let front = axis(&self.planes);
        let up = DVec3::Y - front * front.y;
        if up.length() > 0.2 { up.normalize() } else { front.any_orthonormal_vector() }
    }

    fn range(&self) -> Cluster {
        self.mesh.clusters()[self.cluster as usize]
    }
}

/// The culling volume of a cluster of the mesh in `slot`, in a box around it: the ideal one in
/// pink, and in green inside of it the one that Johannsen and Carter's box of normals proves. On
/// the left the scene with the cluster marked.
///
/// Without a number the cluster is the one whose normals spread the most of those that still have
/// at least 2 % of the box both ways. `None` if the slot or cluster does not exist, or the cluster
/// has no region. The volume is drawn in the space of the mesh. Cost: a frame, and microseconds a
/// cluster.
#[must_use]
pub fn culling_volume(
    scene: &Scene,
    slot: u32,
    cluster: Option<u32>,
    size: [u32; 2],
) -> Option<(Picture, VolumeFigure)> {
    let volume = CullingVolume::new(scene, slot, cluster)?;
    let CullingVolume { mesh, ref planes, ref ideal, ref proved, .. } = volume;
    let (c, cluster, figure) = (volume.range(), volume.cluster, volume.figure());
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
    let axis = axis(planes);
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
    let reach = volume.reach;
    box_edges(&mut sheet, &camera, planes, reach, false);
    faces(&mut sheet, &camera, ideal, false, BACK, 0.30);
    faces(&mut sheet, &camera, proved, false, PROVED, 0.40);
    faces(&mut sheet, &camera, proved, true, PROVED, 0.45);
    faces(&mut sheet, &camera, ideal, true, BACK, 0.22);
    draw_triangles(&mut sheet, &camera, mesh, &c);
    box_edges(&mut sheet, &camera, planes, reach, true);
    Some((sheet.finish(), figure))
}

/// Both regions in a box that reaches so far from the middle of a cluster, and the volume of the
/// box.
fn regions(
    planes: &ClusterPlanes,
    bound: &NormalBox,
    reach: f64,
) -> Option<(CullingRegion, CullingRegion, f64)> {
    let (low, high) = (planes.centre().map(|v| v - reach), planes.centre().map(|v| v + reach));
    let ideal = CullingRegion::of_planes(planes, low, high);
    let proved = CullingRegion::of_normal_box(bound, low, high);
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
        let bound = NormalBox::fit(&planes)?;
        let (_, proved, whole) = regions(&planes, &bound, planes.radius() * REACH)?;
        let axis = axis(&planes);
        let least = planes.half_spaces().map(|(n, _)| DVec3::from(n).dot(axis));
        let least = least.fold(1.0, f64::min);
        (proved.volume() > LEAST_SHARE * whole).then_some((least, c))
    };
    let all = (0..mesh.clusters().len() as u32).filter_map(spread);
    all.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, c)| c)
}

/// The edges of the box that reaches so far from the middle of a cluster: those in front, or those
/// behind.
fn box_edges(sheet: &mut Sheet, camera: &Flat, planes: &ClusterPlanes, reach: f64, front: bool) {
    let corner = |i: usize| {
        let side = |k: usize| if i >> k & 1 == 1 { reach } else { -reach };
        DVec3::from(planes.centre()) + DVec3::new(side(0), side(1), side(2))
    };
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
}

/// The triangles of a cluster, the farthest first.
fn draw_triangles(sheet: &mut Sheet, camera: &Flat, mesh: &Mesh, cluster: &Cluster) {
    let mut triangles: Vec<[DVec3; 3]> = cluster
        .triangles()
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
