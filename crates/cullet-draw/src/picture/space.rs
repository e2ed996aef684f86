//! From pixels back to the scene.

use cullet::mesh::Part;
use cullet::{Camera, Depth, Mesh, MeshId, Projection, Scene, View, Visible};
use cullet_mesh::{Impostor, Texel};
use glam::{DMat3, DMat4, DVec3, DVec4};

use crate::cut::cut_plane;
use crate::frame::PixelId;
use crate::prepare::part_of;

/// A view, and the way back from its clip space.
#[derive(Clone, Debug)]
pub struct Space {
    to_clip: DMat4,
    to_world: DMat4,
    near: f64,
    /// Where the eye is, or the direction towards it with w = 0.
    pub eye: DVec4,
}

impl Space {
    /// The space of a view.
    pub fn new(view: &View) -> Self {
        let to_clip = DMat4::from_cols_array(&view.clip_from_world());
        let near = if view.depth() == Depth::Standard { 0.0 } else { 1.0 };
        Self { to_clip, to_world: to_clip.inverse(), near, eye: view.eye().into() }
    }

    /// The point at a place and depth in normalised device coordinates.
    pub fn point(&self, x: f64, y: f64, depth: f64) -> DVec3 {
        let p = self.to_world * DVec4::new(x, y, depth, 1.0);
        p.truncate() / p.w
    }

    /// A point of the near plane, and the unit direction of the line of sight through it.
    pub fn ray(&self, x: f64, y: f64) -> (DVec3, DVec3) {
        let from = self.point(x, y, self.near);
        // Half-way in depth is finite in every view.
        let to = self.point(x, y, 0.5);
        (from, (to - from).normalize_or_zero())
    }

    /// The unit direction from a point towards the viewer.
    pub fn towards_eye(&self, p: DVec3) -> DVec3 {
        (self.eye.truncate() - p * self.eye.w).normalize_or_zero()
    }

    /// The normal of the side that is seen of a surface at a point.
    pub(crate) fn turned(&self, normal: DVec3, p: DVec3) -> DVec3 {
        if normal.dot(self.towards_eye(p)) < 0.0 { -normal } else { normal }
    }

    /// Where a point is on a picture of this size, and its depth in normalised device coordinates;
    /// `None` if it is not in front of the eye.
    pub fn project(&self, p: DVec3, size: [u32; 2]) -> Option<([f64; 2], f64)> {
        let c = self.to_clip * p.extend(1.0);
        if c.w <= 1e-9 || c.w.is_nan() {
            return None;
        }
        let [w, h] = size.map(f64::from);
        Some(([(c.x / c.w * 0.5 + 0.5) * w, (0.5 - c.y / c.w * 0.5) * h], c.z / c.w))
    }

    /// Whether the first depth is nearer.
    pub fn nearer(&self, a: f64, b: f64) -> bool {
        if self.near == 0.0 { a < b } else { a > b }
    }

    /// The point where the line of sight through a place has gone `reach` from the near plane, or
    /// has come to the far plane.
    pub fn along(&self, x: f64, y: f64, reach: f64) -> DVec3 {
        let (from, direction) = self.ray(x, y);
        let far = self.to_world * DVec4::new(x, y, 1.0 - self.near, 1.0);
        let length = (far.truncate() / far.w - from).length();
        // A far plane at infinity has w about 0.
        let end = if length.is_finite() && far.w.abs() > 1e-12 * far.truncate().length() {
            length.min(reach)
        } else {
            reach
        };
        from + direction * end
    }
}

/// A view that looks against `back` and has all these points in its picture, as near as that
/// allows, with a margin of a twentieth. `None` if there is no point, or the numbers make no view.
pub fn framing(points: &[DVec3], back: DVec3, fov_y_radians: f64, size: [u32; 2]) -> Option<View> {
    let aspect = f64::from(size[0]) / f64::from(size[1].max(1));
    let back = back.try_normalize()?;
    let pole = if back.y.abs() > 0.99 { DVec3::NEG_Z } else { DVec3::Y };
    let right = pole.cross(back).normalize();
    let above = back.cross(right);
    let middle = points.iter().copied().sum::<DVec3>() / points.len().max(1) as f64;
    let t = (fov_y_radians * 0.5).tan() * 0.95;
    // A point is in the picture iff |p·right − x| ≤ t (d − p·back), and the like for y: each bounds
    // x and d from both sides, and the bounds meet at the least distance. Returns x and that.
    let fit = |along: DVec3, t: f64| {
        let most = |sign: f64| {
            let bound = |p: &DVec3| (*p - middle).dot(along * sign + back * t);
            points.iter().map(bound).fold(f64::NEG_INFINITY, f64::max)
        };
        let (high, low) = (most(1.0), most(-1.0));
        ((high - low) * 0.5, (high + low) / (2.0 * t))
    };
    // And not upon the nearest of them, which alone would be in a wide picture with the eye on it.
    let spread = points.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
    let front = points.iter().map(|p| (*p - middle).dot(back)).fold(f64::NEG_INFINITY, f64::max);
    let distance = fit(right, t * aspect).1.max(fit(above, t).1).max(front + 0.1 * spread);
    // One way the picture is full; the other way the points are in the middle if they would just
    // fill a narrower picture from as far.
    let centred = |along: DVec3, most: f64| {
        let (mut low, mut high) = (0.0, most);
        for _ in 0..40 {
            let t = (low + high) * 0.5;
            if fit(along, t).1 > distance { low = t } else { high = t }
        }
        fit(along, high).0
    };
    let (x, y) = (centred(right, t * aspect), centred(above, t));
    let eye = middle + right * x + above * y + back * distance;
    // All points are beyond it.
    let nearest = points.iter().map(|p| (eye - *p).dot(back)).fold(f64::INFINITY, f64::min);
    let near = (nearest * 0.5).max(distance * 1e-4);
    let projection = Projection::Perspective { fov_y_radians, aspect, near, far: f64::INFINITY };
    View::new(&Camera::look_at(eye, eye - back, projection), Depth::Reversed, size).ok()
}

/// The corners of a box of the scene, in the world.
pub fn corners(scene: &Scene, bounds: &cullet::bounds::Aabb) -> [DVec3; 8] {
    let origin = DVec3::from(scene.origin());
    bounds.corners().map(|c| DVec3::from(c.map(f64::from)) + origin)
}

/// X and Y of the centre of a pixel in normalised device coordinates.
pub fn pixel_centre(x: u32, y: u32, size: [u32; 2]) -> [f64; 2] {
    let [w, h] = size.map(f64::from);
    [(f64::from(x) + 0.5) * 2.0 / w - 1.0, 1.0 - (f64::from(y) + 0.5) * 2.0 / h]
}

/// From original triangles to normals and materials.
#[derive(Debug)]
pub struct Surfaces<'a> {
    scene: &'a Scene,
    /// For each mesh that the frame shows, the place in the mesh's order of each original triangle.
    order: Vec<Vec<u32>>,
    /// For each slot the level that the frame shows; none for slots beyond, which are shown in
    /// full.
    levels: Vec<u32>,
    /// The normal of each plane at which the frame is cut open.
    cuts: Vec<DVec3>,
}

impl<'a> Surfaces<'a> {
    /// Surfaces of the instances that own pixels.
    pub fn new(scene: &'a Scene, ids: &[PixelId]) -> Self {
        let mut surfaces = Self::empty(scene);
        let mut last = u32::MAX;
        for id in ids {
            if id.slot != last && id.slot < scene.slot_count() {
                last = id.slot;
                surfaces.add(scene.mesh_id(id.slot));
            }
        }
        surfaces
    }

    /// Collects the surfaces of all meshes that have an instance, whatever a frame shows. Costs 4
    /// bytes a stored triangle.
    pub fn of_all(scene: &'a Scene) -> Self {
        let ids: Vec<PixelId> = scene.slots().map(|slot| PixelId { slot, triangle: 0 }).collect();
        Self::new(scene, &ids)
    }

    /// Collects the surfaces that a frame of a visible set shows, each instance at its level.
    pub fn of_visible(scene: &'a Scene, visible: &Visible) -> Self {
        let mut surfaces = Self::empty(scene);
        surfaces.levels.resize(scene.slot_count() as usize, 0);
        for r in visible.triangle_ranges.iter().filter(|r| r.slot < scene.slot_count()) {
            surfaces.levels[r.slot as usize] = r.level;
            surfaces.add(scene.mesh_id_at(r.slot, r.level));
        }
        surfaces
    }

    /// Normals of the planes that the frame is cut open at.
    pub(crate) fn of_cut(scene: &'a Scene, ids: &[PixelId], cuts: Vec<DVec3>) -> Self {
        Self { cuts, ..Self::new(scene, ids) }
    }

    fn empty(scene: &'a Scene) -> Self {
        let order = vec![Vec::new(); scene.meshes().len()];
        Self { scene, order, levels: Vec::new(), cuts: Vec::new() }
    }

    fn add(&mut self, mesh: MeshId) {
        let order = &mut self.order[mesh as usize];
        if order.is_empty() {
            let mesh = &self.scene.meshes()[mesh as usize];
            *order = vec![0; mesh.triangle_count() as usize];
            for (t, &original) in (0..).zip(mesh.original_triangle()) {
                order[original as usize] = t;
            }
        }
    }

    /// The level at which a slot is shown.
    pub fn level(&self, slot: u32) -> u32 {
        self.levels.get(slot as usize).copied().unwrap_or(0)
    }

    fn mesh_of(&self, slot: u32) -> &Mesh {
        self.scene.mesh_at(slot, self.level(slot))
    }

    /// The place of an original triangle in its mesh's order, if the frame that this was made for
    /// shows its mesh.
    pub fn triangle(&self, id: PixelId) -> Option<u32> {
        if self.is_impostor(id) {
            // Any of the box: they are of one cluster, and come and go together.
            return Some(0);
        }
        let in_scene = id.slot < self.scene.slot_count();
        let mesh = in_scene.then(|| self.scene.mesh_id_at(id.slot, self.level(id.slot)))?;
        self.order[mesh as usize].get(id.triangle as usize).copied()
    }

    /// The impostor at which a slot is shown, and the texel of an owner, whose number stands in
    /// place of the triangle's.
    fn texel(&self, id: PixelId) -> Option<Texel> {
        let level = self.level(id.slot);
        if level == 0 || id.slot >= self.scene.slot_count() {
            return None;
        }
        let impostor = Impostor::at(self.scene, id.slot, level)?;
        let texel = id.triangle as usize;
        (texel < impostor.shape().len()).then(|| impostor.texel(texel))
    }

    /// Whether an owner is shown as an impostor.
    pub fn is_impostor(&self, id: PixelId) -> bool {
        self.texel(id).is_some()
    }

    /// The number of the mesh of an owner, at whatever level it is shown.
    pub fn mesh(&self, id: PixelId) -> Option<u32> {
        (id.slot < self.scene.slot_count()).then(|| self.scene.mesh_id(id.slot))
    }

    /// The part of an original triangle.
    pub fn part(&self, id: PixelId) -> Part {
        if let Some(texel) = self.texel(id) {
            let parts = self.scene.mesh(id.slot).parts();
            return parts.get(texel.part as usize).copied().unwrap_or_default();
        }
        part_of(self.mesh_of(id.slot), id.triangle)
    }

    /// The normal of the plane of a cut face.
    pub(crate) fn cut_normal(&self, id: PixelId) -> Option<DVec3> {
        self.cuts.get(cut_plane(id)?).copied()
    }

    /// The unit normal of a triangle in the world, towards the side from which its corners are seen
    /// counter-clockwise; zero where there is none.
    pub fn normal(&self, id: PixelId) -> DVec3 {
        if let Some(normal) = self.cut_normal(id) {
            return normal;
        }
        if let Some(texel) = self.texel(id) {
            let [x, y, z] =
                self.scene.transform(id.slot).linear.map(|c| DVec3::from(c.map(f64::from)));
            let [a, b, c] = texel.normal;
            // By the cofactors, which turn normals as the transform turns planes.
            let n = y.cross(z) * a + z.cross(x) * b + x.cross(y) * c;
            return n.normalize_or_zero();
        }
        let Some(t) = self.triangle(id) else { return DVec3::ZERO };
        let corners = self.mesh_of(id.slot).corners(t);
        let [x, y, z] = self.scene.transform(id.slot).linear.map(|c| DVec3::from(c.map(f64::from)));
        let m = DMat3::from_cols(x, y, z);
        let [a, b, c] = corners.map(|p| m * DVec3::from(p.map(f64::from)));
        (b - a).cross(c - a).normalize_or_zero()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_framing_has_all_points_in_the_picture_and_comes_near() {
        let corner = |i: u32| {
            let side = |k: u32, v: f64| if i >> k & 1 == 1 { v } else { -v };
            DVec3::new(side(0, 1.0), side(1, 3.0), side(2, 0.5)) + DVec3::new(900.0, 0.0, -5.0)
        };
        let points: Vec<DVec3> = (0..8).map(corner).collect();
        for (back, size) in [
            (DVec3::new(1.0, 0.5, 2.0), [320, 200]),
            (DVec3::Y, [200, 320]),
            (DVec3::new(-1.0, -0.2, 0.0), [64, 64]),
        ] {
            let view = framing(&points, back, 0.7, size).unwrap();
            let space = Space::new(&view);
            let share = |p: &DVec3| {
                let [x, y] = space.project(*p, size).unwrap().0;
                let off = |v: f64, n: u32| (v / f64::from(n) * 2.0 - 1.0).abs();
                off(x, size[0]).max(off(y, size[1]))
            };
            let widest = points.iter().map(share).fold(0.0, f64::max);
            assert!((0.94..0.9501).contains(&widest), "{widest}");
        }
        assert!(framing(&[], DVec3::Y, 0.7, [8, 8]).is_none());
        assert!(framing(&points, DVec3::ZERO, 0.7, [8, 8]).is_none());
    }
}
