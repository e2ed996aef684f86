//! The plane test of single triangles, in the space of their mesh.
//!
//! The eye E of a view is the point that the x, y and w rows of its matrix send to zero. Through an
//! instance with linear part L and translation t the eye of object space is adj(L)(E.xyz − E.w t)
//! with weight det(L) E.w, up to a positive factor once it is multiplied by the sign of det(L); so
//! a mirrored instance needs nothing more, and no matrix is inverted.

use alloc::vec::Vec;
use core::ops::Range;

use glam::{DMat4, DVec3};

use super::Facing;
use crate::array::Each;
use crate::transform::Transform;
use crate::view::{CullFace, FrontFace, View};

/// The vertices of a mesh may be moved by so many units of rounding of world space before a
/// triangle is called front- or back-facing: enough for whoever transforms and projects them in
/// f64, in an order of operations of their own. Each such chain has some twenty operations, each of
/// half an epsilon.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

/// The eye of a view, prepared for the triangles of one instance.
///
/// Where nothing can be decided it decides nothing, and every triangle is kept: a transform that is
/// singular (or too nearly so for f64) or not finite, an eye that is not finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectEye {
    /// The eye in object space, scaled; positive values of n·(eye − weight · p) are
    /// counter-clockwise.
    pub(super) eye: DVec3,
    pub(super) weight: f64,
    /// How far a vertex may be off, in object space: a constant, and per unit of its coordinates.
    pub(super) reach: [f64; 2],
    /// How far `eye − weight · p` may be off for that and for its own rounding, likewise.
    pub(super) eye_error: [f64; 2],
    front_face: FrontFace,
    cull: CullFace,
}

/// The eye of a view before it is moved into the space of an instance: the part of
/// [`ObjectEye::of_view`] that is the same for all instances, made once a view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewEye {
    eye: (DVec3, DVec3),
    weight: (f64, f64),
    far: f64,
    sides: (FrontFace, CullFace),
}

impl ViewEye {
    /// The eye of `view`, with its own front face and culled face.
    #[must_use]
    pub fn new(view: &View) -> Self {
        let m = DMat4::from_cols_array(&view.clip_from_world());
        let rows = [m.row(0), m.row(1), m.row(3)];
        // Each entry a determinant of three columns: its value, and the same with all signs
        // positive, which bounds its error.
        let minor = |i: usize, j: usize, k: usize| {
            let [x, y, w] = rows.each(|r| DVec3::new(r[i], r[j], r[k]));
            let size = |a: DVec3, b: DVec3| {
                let (a, b) = (a.abs(), b.abs());
                DVec3::new(a.y * b.z + a.z * b.y, a.z * b.x + a.x * b.z, a.x * b.y + a.y * b.x)
            };
            let error = size(x, y).dot(w.abs()) * (8.0 * f64::EPSILON) + f64::MIN_POSITIVE;
            // Three columns of zeros are zero without error; those of a parallel view are.
            let zero = w == DVec3::ZERO;
            (x.cross(y).dot(w), if zero { 0.0 } else { error })
        };
        let sign = if view.is_mirrored() { -1.0 } else { 1.0 };
        let [x, y, z, w] = [minor(1, 2, 3), minor(0, 2, 3), minor(0, 1, 3), minor(0, 1, 2)];
        let eye = DVec3::new(x.0, -y.0, z.0) * sign;
        // In world units, what a renderer's translation to the eye cancels.
        let offset = |r: glam::DVec4| {
            let n = r.truncate().abs().element_sum();
            if n > 0.0 { r.w.abs() / n } else { 0.0 }
        };
        Self {
            eye: (eye, DVec3::new(x.1, y.1, z.1)),
            weight: (-w.0 * sign, w.1),
            far: offset(rows[0]).max(offset(rows[1])),
            sides: (view.front_face, view.cull_face),
        }
    }

    /// Makes the left and the right eye of a stereo view. A plane that both see from behind, all
    /// between them do.
    pub(crate) fn of_stereo(view: &View) -> [Self; 2] {
        let (middle, half) = (Self::new(view), DVec3::from(view.eyes_apart()));
        [-half, half].each(|half| {
            let (eye, error) = middle.eye;
            let (weight, weight_error) = middle.weight;
            let moved = eye + half * weight;
            let rounding = (eye.abs() + moved.abs()) * f64::EPSILON;
            Self { eye: (moved, error + half.abs() * weight_error + rounding), ..middle }
        })
    }

    /// Returns the side of counter-clockwise triangles that is culled where it is seen; `Edge`
    /// where no side is culled.
    #[must_use]
    pub fn culled_side(&self) -> Facing {
        culled_side(self.sides.0, self.sides.1)
    }

    /// This eye in the space of an instance; the transform is relative to the same origin as the
    /// view.
    #[must_use]
    pub fn in_space_of(&self, transform: &Transform) -> ObjectEye {
        ObjectEye::prepare(self.eye, self.weight, self.far, transform, self.sides)
    }
}

/// Returns the side of counter-clockwise triangles that is culled; `Edge` where no side is culled.
#[inline]
fn culled_side(front_face: FrontFace, cull: CullFace) -> Facing {
    match (cull, front_face) {
        (CullFace::None, _) => Facing::Edge,
        (CullFace::Back, FrontFace::CounterClockwise) | (CullFace::Front, FrontFace::Clockwise) => {
            Facing::Back
        }
        _ => Facing::Front,
    }
}

impl ObjectEye {
    /// The eye of `view` in the space of an instance, with the view's own front face and culled
    /// face.
    ///
    /// The transform is relative to the same origin as the view.
    #[must_use]
    pub fn of_view(view: &View, transform: &Transform) -> Self {
        ViewEye::new(view).in_space_of(transform)
    }

    /// A homogeneous eye in the space of an instance: (position, 1) in perspective, or (direction
    /// from the scene towards the viewer, 0) in orthographic. It is taken as exact.
    #[must_use]
    pub fn new(
        eye: [f64; 4],
        transform: &Transform,
        front_face: FrontFace,
        cull: CullFace,
    ) -> Self {
        let sign = if eye[3] < 0.0 { -1.0 } else { 1.0 };
        let xyz = DVec3::new(eye[0], eye[1], eye[2]) * sign;
        let zero = (xyz, DVec3::ZERO);
        Self::prepare(zero, (eye[3] * sign, 0.0), 0.0, transform, (front_face, cull))
    }

    fn prepare(
        (eye, eye_error): (DVec3, DVec3),
        (weight, weight_error): (f64, f64),
        far: f64,
        transform: &Transform,
        (front_face, cull): (FrontFace, CullFace),
    ) -> Self {
        const U: f64 = f64::EPSILON;
        let undecided = Self {
            eye: DVec3::ZERO,
            weight: 0.0,
            reach: [0.0; 2],
            eye_error: [f64::INFINITY; 2],
            front_face,
            cull,
        };
        let l = transform.linear_f64();
        let t = DVec3::from(transform.translation);
        // Rows of the adjugate. Products of f32 are exact, so each entry is rounded once.
        let rows = [l.y_axis.cross(l.z_axis), l.z_axis.cross(l.x_axis), l.x_axis.cross(l.y_axis)];
        let det = l.x_axis.dot(rows[0]);
        let det_error = l.x_axis.abs().dot(rows[0].abs()) * (4.0 * U);
        // An eye that may as well be on the other side of infinity decides nothing either.
        let near_infinity = weight != 0.0 && weight.abs() <= 2.0 * weight_error;
        let invertible = det.abs() > 4.0 * det_error;
        if !invertible || near_infinity {
            return undecided;
        }
        let v = eye - weight * t;
        let v_error =
            eye_error + weight_error * t.abs() + (eye.abs() + (weight * t).abs()) * (2.0 * U);
        let p = DVec3::from(rows.each(|r| r.dot(v)));
        let p_error = rows
            .each(|r| r.abs().dot(v_error + v.abs() * (4.0 * U)))
            .into_iter()
            .fold(f64::MIN_POSITIVE, f64::max);
        let w = det * weight;
        let w_error = det_error * weight.abs() + det.abs() * weight_error + w.abs() * U;
        // How far a move of world space can reach in object space.
        let inverse =
            rows.each(|r| r.abs().element_sum()).into_iter().fold(0.0, f64::max) / det.abs();
        let size = (l.x_axis.abs() + l.y_axis.abs() + l.z_axis.abs()).max_element();
        let distance = if weight == 0.0 { 0.0 } else { (eye / weight).abs().element_sum() };
        let world = t.abs().element_sum() + far.max(distance);
        let reach = [ROUNDING * world * inverse, ROUNDING * size * inverse];
        let result = Self {
            eye: p * det.signum(),
            weight: w * det.signum(),
            reach,
            eye_error: [
                w.abs() * reach[0] + p_error + p.abs().max_element() * (4.0 * U),
                w.abs() * reach[1] + w_error + w.abs() * (4.0 * U),
            ],
            ..undecided
        };
        if result.eye.is_finite() && result.weight.is_finite() { result } else { undecided }
    }

    /// Returns the side of the triangle `corners` that the eye sees, or [`Facing::Edge`] where that
    /// is not proved.
    #[inline]
    #[must_use]
    pub fn facing(&self, corners: &[[f32; 3]; 3]) -> Facing {
        let (value, error) = self.value(corners);
        Facing::from_value(value, error, self.front_face)
    }

    /// Whether the view does not draw this triangle if it is one-sided. A triangle that is not
    /// finite is kept.
    #[inline]
    #[must_use]
    pub fn culls(&self, corners: &[[f32; 3]; 3]) -> bool {
        let (value, error) = self.value(corners);
        value * self.direction() > error
    }

    /// The eye in the space of the mesh, up to a positive factor: (position, 1) in perspective, or
    /// (direction towards the viewer, 0). `None` where it decides nothing.
    #[must_use]
    pub fn homogeneous(&self) -> Option<[f64; 4]> {
        let decides = self.eye_error[0].is_finite();
        decides.then(|| self.eye.extend(self.weight).to_array())
    }

    /// Whether there is an eye at all, and faces that it culls. If not, every triangle is kept.
    #[must_use]
    pub(crate) fn culls_any(&self) -> bool {
        self.eye_error[0].is_finite() && self.cull != CullFace::None
    }

    /// The sign of what is culled; 0 where nothing is.
    #[inline]
    fn direction(&self) -> f64 {
        match culled_side(self.front_face, self.cull) {
            Facing::Back => -1.0,
            Facing::Front => 1.0,
            Facing::Edge => 0.0,
        }
    }

    /// Returns the culled side, as [`ViewEye::culled_side`] does.
    #[must_use]
    pub fn culled_side(&self) -> Facing {
        culled_side(self.front_face, self.cull)
    }

    /// n·(eye − weight · a), and a bound of its error.
    ///
    /// Let S be more than |b − a| + |c − a| (sums of absolute coordinates) and Q = |eye − weight ·
    /// a|. The value is the determinant of (b − a, c − a, eye − weight · a). Moving every vertex by
    /// `reach` changes each of the first two columns by at most twice that and the third by
    /// |weight| · reach, hence the value by at most 2 · reach · S · Q + S² · |weight| · reach. The
    /// rounding of this function is below that of moving the vertices, since `reach` holds 32
    /// epsilon of their size.
    #[inline]
    fn value(&self, corners: &[[f32; 3]; 3]) -> (f64, f64) {
        let [a, b, c] = corners.each(|p| DVec3::from(p.each(f64::from)));
        let (ab, ac) = (b - a, c - a);
        let to_eye = self.eye - self.weight * a;
        let value = ab.cross(ac).dot(to_eye);
        let edges = ab.abs().element_sum() + ac.abs().element_sum();
        let size = a.abs().element_sum() + edges;
        let reach = self.reach[0] + self.reach[1] * size;
        let s = edges + 12.0 * reach;
        let error = s
            * (2.0 * reach * to_eye.abs().element_sum()
                + s * (self.eye_error[0] + self.eye_error[1] * size));
        (value, error + f64::MIN_POSITIVE)
    }

    /// Sets bit i of `kept` for each triangle i of `indices` that is not culled, and clears the
    /// others; the bits beyond the last triangle are 0. Returns how many are kept.
    ///
    /// `kept` becomes ⌈triangles / 64⌉ words, and grows only if it never was as large. A triangle
    /// with an index out of range is kept.
    pub fn mask_into(&self, positions: &[[f32; 3]], indices: &[u32], kept: &mut Vec<u64>) -> usize {
        kept.clear();
        let mut count = 0;
        for block in indices.chunks(64 * 3) {
            let mut word = 0;
            for (i, triangle) in block.chunks_exact(3).enumerate() {
                word |= u64::from(!self.culls_indexed(positions, triangle)) << i;
            }
            count += word.count_ones() as usize;
            kept.push(word);
        }
        // Indices that make no whole triangle may have opened a block of their own.
        kept.truncate((indices.len() / 3).div_ceil(64));
        count
    }

    /// Appends the numbers of those triangles of `range` that are not culled, ascending. Returns
    /// how many that were. `indices` is the whole index list; a triangle beyond it is left out, and
    /// one whose vertices are out of range is kept. At most `range.len()` are appended.
    pub fn keep_into(
        &self,
        positions: &[[f32; 3]],
        indices: &[u32],
        range: Range<u32>,
        kept: &mut Vec<u32>,
    ) -> usize {
        let before = kept.len();
        let end = (range.end as usize).min(indices.len() / 3);
        let start = (range.start as usize).min(end);
        // Half the triangles face away, in no order that a branch could guess: write every number,
        // and step past those that are kept.
        kept.resize(before + (end - start), 0);
        let mut next = before;
        for (triangle, t) in indices[start * 3..end * 3].chunks_exact(3).zip(range.start..) {
            kept[next] = t;
            next += usize::from(!self.culls_indexed(positions, triangle));
        }
        kept.truncate(next);
        next - before
    }

    #[inline]
    fn culls_indexed(&self, positions: &[[f32; 3]], triangle: &[u32]) -> bool {
        let at = |i: usize| positions.get(triangle[i] as usize).copied();
        match (at(0), at(1), at(2)) {
            (Some(a), Some(b), Some(c)) => self.culls(&[a, b, c]),
            _ => false,
        }
    }
}
