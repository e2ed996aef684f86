//! Back faces, studied: the directions that face away as a mask on the cube of directions, and how
//! much of the inspected instance each bound proves to be seen from behind.

use cullet::cull::backface::ClusterEye;
use cullet::cull::backface::Facing;
use cullet::cull::backface::{ClusterPlanes, EllipticCone};
use cullet::cull::backface::{ObjectEye, ViewEye};
use cullet::{Mesh, Simd, Transform, View};
use cullet_lab::methods::Groups;
use cullet_lab::methods::cluster::{Bound, CullingRegion, NormalBox, NormalCone, Pyramid};
use cullet_mesh::{BackfaceMask, MaskGrid, ViewCone};
use glam::{DMat3, DVec3};

use crate::lines::{Lines, tint, to_world};
use crate::state::{By, Study};
use crate::structure::WHOLE;

/// The largest mesh that is studied at every step of the eye.
pub const MOST_TRIANGLES: u32 = 100_000;
/// The mask on the cube of directions, for a view or for an instance that it sees.
#[derive(Clone, Debug)]
pub struct Cube {
    /// The lines of sight.
    pub cone: ViewCone,
    /// The cells.
    pub grid: MaskGrid,
    /// Mask of the triangles that face away from all of the lines of sight.
    pub mask: BackfaceMask,
    /// How many those are.
    pub away: u32,
}

impl Cube {
    /// The cube of `cells` for lines of sight; `None` where there are none, as where the eye is
    /// within the instance.
    #[must_use]
    pub fn new(cells: u32, cone: Option<ViewCone>) -> Option<Self> {
        let (grid, cone) = (MaskGrid::new(cells)?, cone?);
        let mask = grid.mask(Simd::best(), Some(&cone));
        let away = mask.bytes().iter().map(|b| b.count_ones()).sum();
        Some(Self { cone, grid, mask, away })
    }

    /// Whether a cell faces away: of the face across `axis`, on its positive side or not, the cell
    /// that begins at these two numbers.
    #[must_use]
    pub fn is_away(&self, axis: usize, positive: bool, cell: [u32; 2]) -> bool {
        let n = f64::from(self.grid.cells());
        let middle = cell.map(|i| (f64::from(i) + 0.5) / n * 2.0 - 1.0);
        self.mask.culls(self.grid.encode(on_cube(axis, positive, middle).into()))
    }
}

/// The point of the cube's face across `axis` with these two coordinates, from −1 to 1.
#[must_use]
pub fn on_cube(axis: usize, positive: bool, [u, v]: [f64; 2]) -> DVec3 {
    let mut p = [0.0; 3];
    p[axis] = if positive { 1.0 } else { -1.0 };
    p[(axis + 1) % 3] = u;
    p[(axis + 2) % 3] = v;
    p.into()
}

/// All lines of sight of a view.
#[must_use]
pub fn sight(view: &View) -> Option<ViewCone> {
    let [w, h] = view.viewport().map(f64::from);
    let middle = DVec3::from(view.ray([w * 0.5, h * 0.5])?.direction);
    let corners = [[0.0, 0.0], [w, 0.0], [0.0, h], [w, h]];
    let angles = corners.map(|p| view.ray(p).map(|r| middle.angle_between(r.direction.into())));
    let widest = angles.into_iter().flatten().fold(0.0, f64::max);
    ViewCone::around(middle.into(), widest)
}

/// An instance as a view sees its back faces.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    /// Its mesh.
    pub mesh: &'a Mesh,
    /// Where it stands.
    pub transform: &'a Transform,
    /// The view.
    pub view: &'a View,
}

impl Seen<'_> {
    /// The homogeneous eye in the space of the mesh; `None` where the transform has no inverse.
    #[must_use]
    pub fn eye(&self) -> Option<[f64; 4]> {
        let inverse = self.linear().inverse();
        let [x, y, z, w] = self.view.eye();
        let eye = inverse * (DVec3::new(x, y, z) - DVec3::from(self.transform.translation) * w);
        eye.is_finite().then_some([eye.x, eye.y, eye.z, w])
    }

    fn linear(&self) -> DMat3 {
        DMat3::from_cols_array_2d(&self.transform.linear.map(|c| c.map(f64::from)))
    }

    /// The corners of a triangle, wound so that what is culled is seen clockwise in the space of
    /// the mesh; `None` where the view culls no side. A mirror in the transform changes nothing:
    /// outside stays outside.
    fn wound(&self, t: u32) -> Option<[[f32; 3]; 3]> {
        let [a, b, c] = self.mesh.corners(t);
        match ViewEye::new(self.view).culled_side() {
            Facing::Edge => None,
            Facing::Back => Some([a, b, c]),
            Facing::Front => Some([a, c, b]),
        }
    }

    /// The planes of a cluster.
    fn planes(&self, cluster: usize) -> ClusterPlanes {
        let range = self.mesh.clusters()[cluster].triangles();
        ClusterPlanes::new(range.filter_map(|t| self.wound(t)))
    }

    /// The lines of sight to all of it.
    #[must_use]
    pub fn cone(&self) -> Option<ViewCone> {
        let sphere = cullet::bounds::Sphere::from_points(self.mesh.positions());
        ViewCone::to_sphere(self.eye()?, &sphere)
    }

    /// The triangles, in the mesh's order, that `by` proves to be seen from behind.
    fn proved(&self, study: &Study) -> Vec<u32> {
        let Some(eye) = self.eye() else { return Vec::new() };
        match study.by {
            By::None => Vec::new(),
            By::Masks => self.masked(study, eye),
            By::Cones => self.bounded::<NormalCone>(eye),
            By::Elliptic => self.bounded::<EllipticCone>(eye),
            By::Boxes => self.bounded::<NormalBox>(eye),
            By::Pyramids => self.bounded::<Pyramid<4>>(eye),
        }
    }

    fn bounded<B: Bound>(&self, eye: [f64; 4]) -> Vec<u32> {
        let Some(eye) = ClusterEye::new(eye) else { return Vec::new() };
        let clusters = 0..self.mesh.clusters().len();
        let behind =
            |&i: &usize| B::fit(&self.planes(i)).is_some_and(|bound| bound.is_behind_eye(&eye));
        clusters.filter(behind).flat_map(|i| self.mesh.clusters()[i].triangles()).collect()
    }

    fn masked(&self, study: &Study, eye: [f64; 4]) -> Vec<u32> {
        let (mesh, Some(grid)) = (self.mesh, MaskGrid::new(study.cells)) else { return Vec::new() };
        let groups = Groups::kd(mesh.positions(), mesh.indices(), study.groups as usize);
        let mut all = Vec::new();
        for (range, mask) in groups.ranges().iter().zip(groups.masks(Simd::best(), &grid, eye)) {
            let triangles = &groups.order()[range.start as usize..range.end as usize];
            let behind = |t: &&u32| {
                self.wound(**t).is_some_and(|corners| mask.culls(grid.encode_triangle(corners)))
            };
            all.extend(triangles.iter().filter(behind).copied());
        }
        all
    }

    /// Studies it.
    #[must_use]
    pub fn study(&self, study: &Study) -> Figures {
        let triangles = self.mesh.triangle_count();
        if triangles > MOST_TRIANGLES {
            return Figures { triangles, too_large: true, ..Figures::default() };
        }
        let eye = ObjectEye::of_view(self.view, self.transform);
        let away = (0..triangles).filter(|&t| eye.culls(&self.mesh.corners(t))).count() as u32;
        let proved = self.proved(study);
        Figures { triangles, away, proved, too_large: false }
    }

    /// Adds the region of eyes that see a cluster wholly from behind, within three times the mesh's
    /// box. False where there is none: the normals span half of space or more.
    pub fn volume(&self, cluster: usize, lines: &mut Lines, sides: &mut Lines) -> bool {
        if cluster >= self.mesh.clusters().len() {
            return false;
        }
        let b = self.mesh.bounds();
        let (centre, half) = (DVec3::from(b.center()), DVec3::from(b.half_extent()));
        // A flat mesh has a region above and below it.
        let half = half.max(DVec3::splat(half.max_element() * 0.5)) * 3.0;
        let region = CullingRegion::of_planes(
            &self.planes(cluster),
            (centre - half).into(),
            (centre + half).into(),
        );
        let world = |v: u32| {
            let p = DVec3::from(region.vertices()[v as usize]);
            self.linear() * p + DVec3::from(self.transform.translation)
        };
        for face in region.faces() {
            let corners: Vec<DVec3> = face.vertices.iter().map(|&v| world(v)).collect();
            // The box is where the picture ends, not the region.
            let alpha = if face.half_space.is_some() { 40 } else { 14 };
            for i in 0..corners.len() {
                let next = corners[(i + 1) % corners.len()];
                lines.line(corners[i], next, tint(WHOLE, if alpha > 20 { 255 } else { 90 }));
                if i > 0 && i + 1 < corners.len() {
                    sides.triangle([corners[0], corners[i], next], tint(WHOLE, alpha));
                }
            }
        }
        !region.is_empty()
    }

    /// Adds triangles of the mesh's order.
    pub fn faces(&self, triangles: &[u32], colour: [u8; 4], sides: &mut Lines) {
        for &t in triangles {
            sides.triangle(self.mesh.corners(t).map(|p| to_world(self.transform, p)), colour);
        }
    }
}

/// Counts that a study found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Figures {
    /// Triangles of the mesh.
    pub triangles: u32,
    /// Triangles among these that are seen from behind.
    pub away: u32,
    /// Triangles among those that the bound proves, in the mesh's order.
    pub proved: Vec<u32>,
    /// Whether the mesh is too large to be studied; all else is then zero.
    pub too_large: bool,
}

#[cfg(test)]
mod tests {
    use cullet::{Depth, Scene};

    use super::*;
    use crate::camera::Rig;

    fn solids() -> Scene {
        cullet_scenes::build("solids").expect("built in").scene
    }

    fn view(scene: &Scene, slot: u32, yaw: f64) -> View {
        let b = scene.bounds(slot);
        let far = DVec3::from(b.half_extent()).length() * 3.0;
        let rig = Rig { target: b.center(), distance: far, yaw, pitch: -20.0, ..Rig::default() };
        rig.view([64, 48]).expect("a view")
    }

    #[test]
    fn what_a_bound_proves_is_seen_from_behind() {
        let scene = solids();
        let mut most = [0; By::ALL.len()];
        for slot in scene.slots() {
            for yaw in [0.0, 77.0, 200.0] {
                let view = view(&scene, slot, yaw);
                let seen =
                    Seen { mesh: scene.mesh(slot), transform: scene.transform(slot), view: &view };
                let exact = ObjectEye::of_view(&view, seen.transform);
                for (i, (by, name, _)) in By::ALL.into_iter().enumerate() {
                    let found = seen.study(&Study { by, ..Study::default() });
                    assert!(found.proved.len() as u32 <= found.away, "{name}: {found:?}");
                    let wrong = found.proved.iter().find(|&&t| !exact.culls(&seen.mesh.corners(t)));
                    assert_eq!(wrong, None, "{name}, slot {slot}");
                    most[i] += found.proved.len();
                }
            }
        }
        assert_eq!(most[0], 0);
        assert!(most[1..].iter().all(|&m| m > 0), "some bound proves nothing: {most:?}");
    }

    #[test]
    fn it_holds_in_a_mirror_and_for_the_other_winding() {
        let scene = solids();
        let slot = scene.slots().next().expect("some");
        let mut view = view(&scene, slot, 30.0);
        let mut mirrored = *scene.transform(slot);
        mirrored.linear[0] = mirrored.linear[0].map(|v| -v);
        for clockwise in [false, true] {
            if clockwise {
                view.front_face = cullet::view::FrontFace::Clockwise;
            }
            let seen = Seen { mesh: scene.mesh(slot), transform: &mirrored, view: &view };
            let exact = ObjectEye::of_view(&view, &mirrored);
            let found = seen.study(&Study { by: By::Masks, cells: 18, ..Study::default() });
            assert!(found.proved.iter().all(|&t| exact.culls(&seen.mesh.corners(t))));
            assert!(found.away > 0);
        }
        view.cull_face = cullet::view::CullFace::None;
        let seen = Seen { mesh: scene.mesh(slot), transform: &mirrored, view: &view };
        let found = seen.study(&Study { by: By::Elliptic, ..Study::default() });
        assert_eq!((found.away, found.proved.len()), (0, 0));
    }

    #[test]
    fn more_cells_leave_less_in_doubt() {
        let cone = ViewCone::around([0.3, -0.2, -1.0], 0.5);
        let share = |n: u32| {
            let cube = Cube::new(n, cone).expect("a cone");
            f64::from(cube.away) / f64::from(cube.grid.classes())
        };
        assert!(share(1) <= share(6) && share(6) < share(16) && share(16) < 0.5);
        let cube = Cube::new(6, cone).expect("a cone");
        let mut counted = 0;
        for axis in 0..3 {
            for positive in [false, true] {
                let cells = (0..36).map(|k| [k % 6, k / 6]);
                counted += cells.filter(|&c| cube.is_away(axis, positive, c)).count();
            }
        }
        assert_eq!(counted as u32, cube.away);
        assert!(Cube::new(6, None).is_none() && Cube::new(0, cone).is_none());
    }

    #[test]
    fn the_sight_of_a_view_holds_its_corners() {
        let view = Rig::default().view([160, 90]).expect("a view");
        let cone = sight(&view).expect("a cone");
        let cosine = (1.0 - cone.sine * cone.sine).sqrt();
        for p in [[0.0, 0.0], [160.0, 90.0], [80.0, 45.0]] {
            let d = DVec3::from(view.ray(p).expect("a ray").direction);
            assert!(d.dot(cone.axis.into()) >= cosine - 1e-9);
        }
        let camera = Rig { mode: crate::camera::Mode::Top, ..Rig::default() }.camera(1.0);
        let top = View::new(&camera, Depth::Reversed, [64, 64]).expect("a view");
        assert!(sight(&top).expect("parallel").sine < 1e-6);
    }
}
