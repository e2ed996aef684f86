//! Scenes cut open in the picture: which depths of a line of sight are drawn, and which meshes have
//! cut faces there.
//!
//! A plane of the world is one of clip space, so along the line of sight through a sample it bounds
//! the depth. What lies outside of the part that is kept is not drawn. A closed mesh winds around
//! each point within it: where the line of sight enters the part that is kept, as many of its
//! surfaces lie beyond that face away as face the eye, and one more if that point is inside. There
//! the mesh has a cut face, with the depth of the plane.

use cullet::bounds::Side;
use cullet::{Mesh, Scene, View};
use cullet_mesh::Topology;
use glam::{DMat4, DVec3, DVec4};

use crate::clip::{HalfSpace, Region};
use crate::frame::{Frame, PixelId, RenderOptions, Selection};
use crate::geometry::Lens;
use crate::parallel;
use crate::prepare::{Item, Stage};
use crate::render::{Target, frame_samples};
use crate::sample::Samples;
use crate::sort;

/// Part of a scene that is drawn.
#[derive(Clone, Debug)]
pub(crate) struct Cut {
    /// Convex region of the world.
    pub(crate) region: Region<f64, 3>,
    /// Whether what is outside of the region is kept, instead of what is inside.
    pub(crate) outside: bool,
    /// A point in the open: a mesh around it has no cut faces, so that one looks into it.
    pub(crate) hollow: Option<[f64; 3]>,
}

/// Numbers of cut faces, in place of those of triangles: for the plane 0 the greatest number, and
/// down from there.
pub(crate) fn cut_face(slot: u32, plane: usize) -> PixelId {
    PixelId { slot, triangle: !(plane as u32) }
}

/// The plane of a cut face; what owns a pixel of a frame that is not cut has none that exists.
pub(crate) fn cut_plane(id: PixelId) -> Option<usize> {
    (id != PixelId::NONE).then_some(!id.triangle as usize)
}

/// How a closed mesh tells its inside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Closed {
    /// The surface winds around the inside.
    Wound,
    /// Triangles wound both ways: every second crossing leads inside.
    Crossed,
}

impl Closed {
    /// `None` for a mesh that is open, or not opaque.
    fn of(mesh: &Mesh) -> Option<Self> {
        let opaque = mesh.parts().iter().all(|p| p.alpha == cullet::mesh::Alpha::Opaque);
        let topology = Topology::of_mesh(mesh);
        let closed = opaque && topology.triangles > 0 && topology.boundary_edges == 0;
        closed.then_some(if topology.misoriented_edges > 0 { Self::Crossed } else { Self::Wound })
    }

    /// Whether a point is inside, of which this many more surfaces that face away than others lie
    /// beyond.
    pub(crate) fn holds(self, winding: i32) -> bool {
        match self {
            Self::Wound => winding != 0,
            Self::Crossed => winding % 2 != 0,
        }
    }

    /// Whether a mesh winds around a point: by the triangles that a line from there crosses.
    fn is_around(self, mesh: &Mesh, p: DVec3) -> bool {
        // No direction of a modelled edge.
        let along = DVec3::new(0.288_675, 0.913_871, 0.285_714);
        let mut winding = 0;
        for t in 0..mesh.triangle_count() {
            let [a, b, c] = mesh.corners(t).map(|c| DVec3::from(c.map(f64::from)) - p);
            // Twice the volumes between the line and the edges: of one sign where it goes through
            // the triangle.
            let sides = [along.dot(a.cross(b)), along.dot(b.cross(c)), along.dot(c.cross(a))];
            let through = sides.iter().all(|v| *v > 0.0) || sides.iter().all(|v| *v < 0.0);
            let normal = (b - a).cross(c - a);
            if through && normal.dot(a) * normal.dot(along) > 0.0 {
                winding += if sides[0] > 0.0 { 1 } else { -1 };
            }
        }
        self.holds(winding)
    }
}

impl Cut {
    /// Where an instance lies: inside or outside of the part that is kept, or on its border.
    pub(crate) fn side(&self, scene: &Scene, slot: u32) -> Side {
        let bounds = scene.mesh(slot).bounds();
        if scene.is_removed(slot) || bounds.is_empty() {
            return Side::Outside;
        }
        let to_world = to_world(scene, slot);
        let corners = bounds.corners().map(|c| world(&to_world, c));
        let mut side = Side::Inside;
        for (_, plane) in self.region.sides() {
            match corners.iter().filter(|c| plane.height(c) > 0.0).count() {
                0 => {}
                8 => {
                    side = Side::Outside;
                    break;
                }
                _ => side = Side::Straddling,
            }
        }
        match side {
            Side::Inside if self.outside => Side::Outside,
            Side::Outside if self.outside => Side::Inside,
            side => side,
        }
    }
}

/// A cut in the space of a view.
pub(crate) struct CutLens<'a> {
    samples: &'a Samples,
    /// Depths that are drawn.
    range: [f64; 2],
    /// Number and coefficients of each plane: positive outside.
    planes: Vec<(usize, DVec4)>,
    outside: bool,
    /// For a slot whether its mesh is closed.
    pub(crate) closed: &'a (dyn Fn(u32) -> Option<Closed> + Sync),
}

/// Surfaces so near to a plane, as a share of their depth, lie in it: they are drawn if what they
/// bound is kept.
const SLACK: f64 = 1e-6;

impl CutLens<'_> {
    /// The depths between which the line of sight through a sample is inside of all planes, and the
    /// plane at each end.
    fn inside(&self, [column, row]: [u32; 2]) -> [(f64, usize); 2] {
        let [x, y] = self.samples.at(column, row);
        let (mut low, mut high) = ((f64::NEG_INFINITY, 0), (f64::INFINITY, 0));
        for &(number, q) in &self.planes {
            let at_zero = q.x * x + q.y * y + q.w;
            let depth = -at_zero / q.z;
            if q.z < 0.0 && depth > low.0 {
                low = (depth, number);
            } else if q.z > 0.0 && depth < high.0 {
                high = (depth, number);
            } else if q.z == 0.0 && at_zero > 0.0 {
                // Along the plane, and outside.
                low.0 = f64::INFINITY;
            }
        }
        [low, high]
    }

    /// A surface in a plane goes with what it bounds: one that faces the eye with what is beyond
    /// it.
    pub(crate) fn beside(depth: f64, front: bool) -> f64 {
        let slack = SLACK * depth.abs();
        if front { depth + slack } else { depth - slack }
    }

    /// Whether a surface is drawn at a sample.
    pub(crate) fn keeps(&self, sample: [u32; 2], depth: f64, front: bool) -> bool {
        let [low, high] = self.inside(sample);
        let depth = Self::beside(depth, front);
        (low.0 <= depth && depth <= high.0) != self.outside
    }

    /// Depth at which the line of sight through a sample enters the part that is kept, and at which
    /// plane; `None` where it begins there, or never does.
    pub(crate) fn entry(&self, sample: [u32; 2]) -> Option<(f64, usize)> {
        let [low, high] = self.inside(sample);
        let entry = if self.outside { high } else { low };
        (low.0 <= high.0 && entry.0 >= self.range[0] && entry.0 <= self.range[1]).then_some(entry)
    }
}

/// Draws what is kept of a scene, with the [cut faces](cut_face) of closed meshes. Blended
/// triangles are not drawn.
pub(crate) fn render_cut(scene: &Scene, view: &View, cut: &Cut, options: &RenderOptions) -> Frame {
    let stage = Stage::new(scene);
    let (lens, samples) = (Lens::new(view), frame_samples(view, options));
    let mut items = stage.items(&lens, &samples, Selection::All).opaque;
    let sides: Vec<Side> = (0..scene.slot_count()).map(|slot| cut.side(scene, slot)).collect();
    let side = |item: &Item| sides[item.slot as usize];
    items.retain(|item| side(item) != Side::Outside);
    let mut wanted = vec![false; scene.meshes().len()];
    for item in items.iter().filter(|item| side(item) == Side::Straddling) {
        wanted[item.mesh as usize] = true;
    }
    let closed = parallel::map(wanted.len(), &|mesh| {
        if wanted[mesh] { Closed::of(&scene.meshes()[mesh]) } else { None }
    });
    let closed = |slot: u32| match sides.get(slot as usize) {
        Some(Side::Straddling) => closed[scene.mesh_id(slot) as usize],
        _ => None,
    };
    // One looks into a closed mesh where it has no cut face.
    items.iter_mut().for_each(|item| item.two_sided |= closed(item.slot).is_some());
    let solids: Vec<Item> = items.iter().filter(|i| closed(i.slot).is_some()).copied().collect();
    let solids = sort::sorted_by(&solids, |item| item.slot.into());
    let mut capped = Vec::new();
    for of_slot in solids.chunk_by(|a, b| a.slot == b.slot) {
        let slot = of_slot[0].slot;
        let around = |p| closed(slot).is_some_and(|closed| is_around(scene, slot, closed, p));
        if !cut.hollow.is_some_and(around) {
            capped.extend_from_slice(of_slot);
        }
    }
    // n·p − d = q·(M p) for q = M⁻ᵀ (n, −d).
    let inverse = DMat4::from_cols_array_2d(&lens.rows).inverse();
    let plane = |(number, side): (usize, &HalfSpace<f64, 3>)| {
        (number, inverse * DVec3::from(side.normal()).extend(-side.d()))
    };
    let cut = CutLens {
        samples: &samples,
        range: lens.range,
        planes: cut.region.sides().map(plane).collect(),
        outside: cut.outside,
        closed: &closed,
    };
    let mut target = Target::new(samples.clone(), |_| true, false);
    target.draw_cut(&stage, &lens, &cut, &capped, &items);
    target.into_frame(&lens)
}

/// Whether a closed instance is around a point of the world.
fn is_around(scene: &Scene, slot: u32, closed: Closed, p: [f64; 3]) -> bool {
    let p = to_world(scene, slot).inverse().transform_point3(p.into());
    let bounds = scene.mesh(slot).bounds();
    let within = |a: usize| f64::from(bounds.min[a]) <= p[a] && p[a] <= f64::from(bounds.max[a]);
    within(0) && within(1) && within(2) && closed.is_around(scene.mesh(slot), p)
}

pub(crate) fn to_world(scene: &Scene, slot: u32) -> DMat4 {
    DMat4::from_cols_array(&scene.transform(slot).to_matrix())
}

/// A point of a mesh in the world.
pub(crate) fn world(to_world: &DMat4, p: [f32; 3]) -> [f64; 3] {
    to_world.transform_point3(DVec3::from(p.map(f64::from))).to_array()
}

#[cfg(test)]
mod tests {
    use cullet::bounds::Plane;
    use cullet::{Camera, Depth, Instance, MeshData, Projection, Transform};
    use cullet_testkit::{meshes, soups};

    use super::*;
    use crate::render::render;

    /// From z = 10 towards −z; at a distance of w a pixel is w / 50 wide.
    fn view() -> View {
        let fov_y_radians = std::f64::consts::FRAC_PI_2;
        let projection =
            Projection::Perspective { fov_y_radians, aspect: 1.0, near: 0.5, far: f64::INFINITY };
        let camera = Camera::look_at([0.0, 0.0, 10.0], [0.0; 3], projection);
        View::new(&camera, Depth::Reversed, [100; 2]).unwrap()
    }

    fn scene(meshes: impl IntoIterator<Item = Mesh>) -> Scene {
        let mut scene = Scene::new();
        for mesh in meshes {
            let mesh = scene.add_mesh(mesh);
            scene.add(Instance::new(mesh, Transform::IDENTITY)).unwrap();
        }
        scene
    }

    fn cube() -> Mesh {
        meshes::block([-1.0; 3], [1.0; 3])
    }

    /// A cut that keeps what is behind the plane z = `at`: by a region that holds it, or by one
    /// that holds the rest.
    fn behind(at: f64, outside: bool) -> Cut {
        let plane = Plane::new([0.0, 0.0, 1.0], at);
        let side = HalfSpace::try_from(if outside { plane.flipped() } else { plane }).unwrap();
        Cut { region: Region::new([side]).unwrap(), outside, hollow: None }
    }

    fn drawn(scene: &Scene, cut: &Cut) -> Frame {
        render_cut(scene, &view(), cut, &RenderOptions::default())
    }

    /// The distance from the eye at a pixel: 0.5 / w is the depth.
    fn distance(frame: &Frame, x: u32, y: u32) -> f64 {
        0.5 / frame.depth[(y * frame.width + x) as usize]
    }

    #[test]
    fn a_solid_has_a_cut_face_in_the_plane_and_nothing_before_it() {
        for outside in [false, true] {
            let (scene, cut) = (scene([cube()]), behind(0.25, outside));
            let frame = drawn(&scene, &cut);
            // The plane is 9.75 from the eye, so that the face ends 5.128 pixels from the middle.
            for (x, y) in [(50, 50), (45, 54), (54, 45)] {
                assert_eq!(frame.id(x, y), cut_face(0, 0), "{x}, {y}");
                assert!((distance(&frame, x, y) - 9.75).abs() < 1e-9);
            }
            let near = render(&scene, &view(), Selection::All, &RenderOptions::default());
            // At 9 from the eye, the cube that is not cut reaches 5.556 pixels from the middle.
            for (x, y) in [(55, 50), (50, 44), (44, 50)] {
                assert_ne!(near.id(x, y), PixelId::NONE, "{x}, {y}");
                assert_eq!(frame.id(x, y), PixelId::NONE, "{x}, {y}");
            }
        }
        // Beyond the cube nothing is left, and before it all.
        assert!(drawn(&scene([cube()]), &behind(-1.5, false)).visible().is_empty());
        let whole = drawn(&scene([cube()]), &behind(1.5, false));
        let plain = render(&scene([cube()]), &view(), Selection::All, &RenderOptions::default());
        assert_eq!((whole.ids, whole.depth), (plain.ids, plain.depth));
    }

    #[test]
    fn a_cut_face_hides_what_is_within_the_solid() {
        let inner = meshes::block([-0.5, -0.5, -0.75], [0.5, 0.5, -0.25]);
        let frame = drawn(&scene([inner, cube()]), &behind(0.0, false));
        assert_eq!(frame.id(50, 50), cut_face(1, 0));
        // Where both are cut, the lower slot has the face.
        let inner = meshes::block([-0.5; 3], [0.5; 3]);
        let frame = drawn(&scene([inner, cube()]), &behind(0.0, false));
        assert_eq!((frame.id(50, 50), frame.id(54, 54)), (cut_face(0, 0), cut_face(1, 0)));
    }

    #[test]
    fn one_looks_into_an_open_mesh_and_into_a_shell_around_the_eye() {
        let (positions, mut indices) = soups::block([-1.0; 3], [1.0; 3]);
        let all = indices.len();
        // Without what lies at x = 1.
        indices = indices
            .chunks_exact(3)
            .filter(|t| t.iter().any(|&i| positions[i as usize][0] < 0.0))
            .flatten()
            .copied()
            .collect();
        assert_eq!(indices.len(), all - 6);
        let open = Mesh::new(MeshData { positions, indices, ..MeshData::default() }).unwrap();
        let shell = Cut { hollow: Some([0.5, 0.5, -0.5]), ..behind(0.0, false) };
        for (mesh, cut) in [(open, behind(0.0, false)), (cube(), shell.clone())] {
            let frame = drawn(&scene([mesh]), &cut);
            assert!(frame.id(50, 50).triangle < 12);
            assert!((distance(&frame, 50, 50) - 11.0).abs() < 1e-9);
        }
        // A point that is not within has no say.
        let beside = Cut { hollow: Some([0.5, 0.5, -1.5]), ..shell };
        assert_eq!(drawn(&scene([cube()]), &beside).id(50, 50), cut_face(0, 0));
    }

    #[test]
    fn triangles_wound_both_ways_still_bound_an_inside() {
        let (positions, mut indices) = soups::block([-1.0; 3], [1.0; 3]);
        indices.chunks_exact_mut(3).step_by(3).for_each(|t| t.swap(0, 1));
        let mesh = Mesh::new(MeshData { positions, indices, ..MeshData::default() }).unwrap();
        assert!(cullet_mesh::solid(&mesh).is_err());
        let frame = drawn(&scene([mesh]), &behind(0.0, false));
        assert!((46..54).all(|x| frame.id(x, 50) == cut_face(0, 0)));
    }

    #[test]
    fn a_face_in_the_plane_goes_with_what_it_bounds() {
        let top = |frame: &Frame| frame.id(50, 50);
        for outside in [false, true] {
            let below = scene([meshes::block([-1.0, -1.0, -1.0], [1.0, 1.0, 0.0])]);
            let frame = drawn(&below, &behind(0.0, outside));
            assert!(top(&frame).triangle < 12 && (distance(&frame, 50, 50) - 10.0).abs() < 1e-9);
            let above = scene([meshes::block([-1.0, -1.0, 0.0], [1.0, 1.0, 1.0])]);
            assert_eq!(top(&drawn(&above, &behind(0.0, outside))), PixelId::NONE);
        }
    }

    #[test]
    fn of_several_planes_each_has_its_own_faces() {
        // Opens the corner towards +X, +Y and +Z, in which the eye is.
        let planes = [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
        let sides = planes.map(|n| HalfSpace::new(n, 0.0).unwrap());
        let cut = Cut { region: Region::new(sides).unwrap(), outside: true, hollow: None };
        let frame = drawn(&scene([cube()]), &cut);
        // Lines of sight go away from the axis, so that only the face in z = 0 is seen of the
        // three.
        assert_eq!(frame.id(52, 47), cut_face(0, 2));
        assert!((distance(&frame, 52, 47) - 10.0).abs() < 1e-9);
        assert!(frame.id(47, 47).triangle < 12 && frame.id(52, 52).triangle < 12);
        assert!((distance(&frame, 47, 47) - 9.0).abs() < 1e-9);
    }
}
