//! Tables by which triangles seen from behind are dropped, which the CPU prepares for each instance
//! and frame.

use bytemuck::{Pod, Zeroable};
use cullet::bounds::Sphere;
use cullet::cull::backface::{Facing, ObjectEye, ViewEye};
use cullet::{Simd, Transform, View};
use cullet_mesh::ViewCone;
use glam::{DVec3, DVec4};

use super::masks::{NO_AREA, Shape, Triangles, ratio_of};
use super::rounding::Rounding;

/// Upper bound of the doubt of a plane, shifted by the size of its triangle, so that sums fit 32
/// bits.
const MOST_DOUBT: f64 = (1 << 26) as f64;
/// The largest number of a quantised plane, over that of a unit normal at least, times the largest
/// of a quantised eye.
const UNIT: f64 = 127.0 * 1.732_050_81 * 8191.0;

/// How triangles are tested.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TriangleTest {
    /// Test by the class of the normal: two bytes a triangle, one AND.
    #[default]
    Masks,
    /// Test by the plane: five bytes a triangle, four products; culls nearly all that faces away.
    Planes,
}

/// An eye as it is tested against planes: 32 bytes, as they lie on the device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct PlaneUniform {
    /// Factors of a plane.
    pub eye: [i32; 4],
    /// Error bound of the product itself.
    pub bound: i32,
    /// Additional error bound for the largest triangle.
    pub doubt: i32,
    /// Smallest size code that is tested: smaller triangles are kept; −1 where everything is.
    pub smallest: i32,
    /// Nothing.
    pub padding: i32,
}

/// Tables by which a view tests the triangles of one instance.
#[derive(Clone, Debug, Default)]
pub struct TriangleView {
    test: TriangleTest,
    masks: Vec<[u8; 256]>,
    planes: PlaneUniform,
}

impl TriangleView {
    /// Prepares a view of an instance. Costs a mask for each group, or an eye; nothing is allocated
    /// once it has grown.
    ///
    /// What it culls is seen from the side that the view culls, also after a renderer moved each
    /// vertex: in f32 relative to the eye, as [`IdPass`](super::IdPass) does, and to a grid on the
    /// screen of 8 bits a pixel. So the picture is the one that hardware makes which culls the same
    /// side of whole triangles. Nothing but what has no area is culled where the eye is in the
    /// sphere of a group (by masks), or where the transform or the view is not finite or flattens
    /// space, or the view culls no side.
    pub fn set(
        &mut self,
        triangles: &Triangles,
        test: TriangleTest,
        view: &View,
        transform: &Transform,
    ) {
        self.test = test;
        self.masks.clear();
        self.planes = PlaneUniform { smallest: -1, ..PlaneUniform::default() };
        let seen = Seen::new(triangles.shape(), view, transform);
        match test {
            TriangleTest::Masks => {
                let level = Simd::best();
                self.masks.extend(triangles.groups().iter().map(|sphere| {
                    let cone = seen.as_ref().and_then(|seen| seen.cone(sphere));
                    let mut bytes = *triangles.grid().mask(level, cone.as_ref()).bytes();
                    bytes[usize::from(NO_AREA.byte_offset)] |= NO_AREA.bit_mask;
                    bytes
                }));
            }
            TriangleTest::Planes => {
                if let Some(planes) = seen.and_then(|seen| seen.planes(triangles)) {
                    self.planes = planes;
                }
            }
        }
    }

    /// How triangles are tested.
    #[must_use]
    pub fn test(&self) -> TriangleTest {
        self.test
    }

    /// The mask of each group, where it is masks that test.
    #[must_use]
    pub fn masks(&self) -> &[[u8; 256]] {
        &self.masks
    }

    /// The eye, where it is planes.
    #[must_use]
    pub fn planes(&self) -> &PlaneUniform {
        &self.planes
    }

    /// Whether a triangle is culled. The device's shaders do the same.
    ///
    /// # Panics
    /// If the view was not set for these triangles.
    #[must_use]
    pub fn culls(&self, triangles: &Triangles, triangle: usize, group: u32) -> bool {
        match self.test {
            TriangleTest::Masks => {
                let own = triangles.classes()[triangle];
                self.masks[group as usize][usize::from(own.byte_offset)] & own.bit_mask != 0
            }
            TriangleTest::Planes => {
                let plane = triangles.planes()[triangle];
                self.planes.culls(plane, triangles.sizes()[triangle])
            }
        }
    }
}

impl PlaneUniform {
    /// Whether a triangle with that plane and size is culled.
    fn culls(&self, plane: [u8; 4], size: u8) -> bool {
        if plane == [0; 4] {
            return true;
        }
        if i32::from(size) > self.smallest {
            return false;
        }
        let product: i32 = (0..4).map(|k| (i32::from(plane[k]) - 128) * self.eye[k]).sum();
        let doubt = ((self.doubt * i32::from(4 + (size & 3))) << (size >> 2)) >> 2;
        product + self.bound + doubt + 1 < 0
    }
}

/// An instance as a view sees it.
struct Seen<'a> {
    shape: &'a Shape,
    facing: Facing,
    /// In the space of the mesh.
    eye: [f64; 4],
    /// How far a vertex may be moved there.
    moved: f64,
}

impl<'a> Seen<'a> {
    /// `None` where no side is culled, or nothing is known.
    fn new(shape: &'a Shape, view: &View, transform: &Transform) -> Option<Self> {
        let object: ObjectEye = ViewEye::new(view).in_space_of(transform);
        let (facing, eye) = (object.culled_side(), object.homogeneous()?);
        let moved = Rounding::new(view)?.of(transform, &shape.sphere)?;
        (facing != Facing::Edge).then_some(Self { shape, facing, eye, moved })
    }

    /// Returns the error bound of n·(eye − w·a), in radians times the largest |eye − w·a|, for a
    /// triangle with an inscribed circle of radius 1; for one of radius r, divide it by r. `None`
    /// where r is below 4ρ, for ρ = `moved`.
    ///
    /// With the normal as long as twice the area A it is the determinant of the three corners and
    /// the eye. One corner moved by ρ changes that by ρ times the opposite edge times Q = |eye −
    /// w·a| at most, and all three, with edges that add up to P, by ρ P Q + 3ρ² Q + wρ³. Over 2A =
    /// rP, where P is at least 10.39 r and Q at least wr, and with ρ at most r/4, that is (1 +
    /// 0.073 + 0.002) ρQ/r at most.
    fn doubt(&self, r: f64) -> Option<f64> {
        (self.moved <= r / 4.0).then_some(1.08 * self.moved)
    }

    /// The lines of sight to a group, with the doubt as an angle more, as they are for what is
    /// culled.
    fn cone(&self, sphere: &Sphere) -> Option<ViewCone> {
        let smallest = self.shape.smallest;
        let angle = self.doubt(smallest)? / smallest;
        let mut cone = ViewCone::to_sphere(self.eye, sphere)?;
        cone.sine += angle;
        if self.facing == Facing::Front {
            // Front faces for the eye are back faces for lines of sight that go the other way.
            cone.axis = cone.axis.map(|v| -v);
        }
        Some(cone)
    }

    /// The eye for planes.
    fn planes(&self, triangles: &Triangles) -> Option<PlaneUniform> {
        let planes = triangles.quantised();
        let own = planes.eye(self.eye, self.facing, 0.0)?;
        let size = planes.size_of_eye(self.eye)?;
        let (eye, sphere) = (DVec4::from(self.eye), &self.shape.sphere);
        let centre = DVec3::from(sphere.center.map(f64::from));
        let farthest =
            (eye.truncate() - centre * eye.w).length() + eye.w * f64::from(sphere.radius);
        let largest = self.shape.largest;
        let doubt = (self.doubt(largest)? * farthest / largest * UNIT / size).ceil() + 1.0;
        let certain = |code: &u8| {
            let ratio = ratio_of(*code);
            doubt * 4.0 * ratio < MOST_DOUBT && self.doubt(largest / ratio).is_some()
        };
        // NaN is not certain.
        let smallest = (0..u8::MAX).take_while(certain).count() as i32 - 1;
        let doubt = if smallest < 0 { 0 } else { doubt as i32 };
        let (eye, bound) = (own.numbers(), own.bound());
        Some(PlaneUniform { eye, bound, doubt, smallest, padding: 0 })
    }
}

/// The indices of the triangles that a view does not cull, in order: what the passes list, byte for
/// byte.
///
/// # Panics
/// If the view was not set for these triangles.
#[must_use]
pub fn triangles_ref(triangles: &Triangles, view: &TriangleView) -> Vec<u32> {
    let mut list = Vec::new();
    for block in triangles.blocks() {
        for triangle in (block.first as usize..).take(block.count as usize) {
            if !view.culls(triangles, triangle, block.mask) {
                list.extend_from_slice(&triangles.indices()[triangle * 3..][..3]);
            }
        }
    }
    list
}
