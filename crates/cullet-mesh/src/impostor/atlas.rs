//! The atlas of an impostor: a grid of frames of texels, its checks and its errors.

use std::sync::Arc;

use cullet::bounds::Aabb;
use cullet::lod::{Group, LevelsError};
use thiserror::Error;

use super::frame::{ImpostorFrame, LEAST_SIDE, length, octahedral, square};

/// The most frames along a side of the grid.
const MOST_GRID: u32 = 64;
/// The most texels along a side of a frame.
const MOST_TEXELS: u32 = 256;
/// The most texels of all frames.
const MOST_ALL: u64 = 1 << 22;
/// Parts that a texel can name.
pub const IMPOSTOR_PARTS: usize = 16;

/// Why something is no impostor, or not one of this mesh.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ImpostorError {
    /// A grid, or frames, of no size that is allowed.
    #[error(
        "a grid of {grid} × {grid} frames of {texels} × {texels} texels: from 2 to {MOST_GRID} frames and from 1 to \
         {MOST_TEXELS} texels along a side are allowed, and {MOST_ALL} texels in all"
    )]
    Size {
        /// Frames along a side of the grid.
        grid: u32,
        /// Texels along a side of a frame.
        texels: u32,
    },
    /// Not as many texels as the grid has.
    #[error("{what} has {found} texels, but the grid has {expected}")]
    Count {
        /// Name of the plane of the atlas.
        what: &'static str,
        /// How many it has.
        found: usize,
        /// How many it should have.
        expected: usize,
    },
    /// A box or an error that is not finite, or of no size.
    #[error(
        "the box {bounds:?} with the radius {radius} and the error {error}: all must be finite, and of some size"
    )]
    NotFinite {
        /// The box.
        bounds: Aabb,
        /// The radius.
        radius: f32,
        /// The error.
        error: f32,
    },
    /// A texel of a part that the mesh has not.
    #[error("texel {texel} is of part {part}, but the mesh has {parts}")]
    NoSuchPart {
        /// Number of the texel.
        texel: usize,
        /// The part.
        part: u32,
        /// How many the mesh has.
        parts: usize,
    },
    /// A mesh that no impostor can stand for.
    #[error("the mesh {why}")]
    Mesh {
        /// Why not.
        why: &'static str,
    },
    /// Its box is not a level of the scene's mesh.
    #[error("its box: {0}")]
    Levels(#[from] LevelsError),
}

/// Contents of one texel of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Texel {
    /// The share of it that the mesh covers, from 0 to 1.
    pub coverage: f64,
    /// How far the surface is towards the viewer of the frame: −1 to 1, in units of
    /// [`ImpostorFrame::half`]. Of a texel that is not covered that of one nearby.
    pub depth: f64,
    /// The unit normal of the side that is seen, in the space of the mesh.
    pub normal: [f64; 3],
    /// The part of the mesh, below [`IMPOSTOR_PARTS`].
    pub part: u32,
}

/// A mesh as it looks from all around.
///
/// Two planes of 16 bits a texel: [`shape`](Self::shape) has coverage, part and depth, which is all
/// that a picture's outlines need; [`normals`](Self::normals) are for its light. With the usual 12
/// × 12 frames of 12 × 12 texels each plane has 41,472 bytes. A clone shares both.
#[derive(Clone, Debug, PartialEq)]
pub struct Impostor {
    bounds: Aabb,
    radius: f32,
    error: f32,
    grid: u32,
    texels: u32,
    shape: Arc<[u16]>,
    normals: Arc<[u16]>,
}

impl Impostor {
    /// An impostor of planes, such as a file has: frame by frame, row by row from the top left
    /// texel.
    ///
    /// `bounds` is the box of the mesh, no point of which is farther than `radius` from the middle
    /// of that; `error` how far what is drawn may be from it, in units of the mesh.
    ///
    /// # Errors
    /// If sizes do not fit, or numbers are not finite.
    pub fn new(
        [grid, texels]: [u32; 2],
        (bounds, radius): (Aabb, f32),
        error: f32,
        shape: Vec<u16>,
        normals: Vec<u16>,
    ) -> Result<Self, ImpostorError> {
        let expected = Self::texel_count([grid, texels])?;
        for (what, found) in [("shape", shape.len()), ("normals", normals.len())] {
            if found != expected {
                return Err(ImpostorError::Count { what, found, expected });
            }
        }
        let sides = bounds.half_extent();
        let is_sound = bounds.is_finite()
            && sides.iter().all(|&v| v >= 0.0)
            && f64::from(f32::MIN_POSITIVE) < length(sides)
            && length(sides) < f64::from(f32::MAX)
            && (f32::MIN_POSITIVE..f32::INFINITY).contains(&radius)
            && (0.0..f32::INFINITY).contains(&error);
        if !is_sound {
            return Err(ImpostorError::NotFinite { bounds, radius, error });
        }
        Ok(Self {
            bounds,
            radius,
            error,
            grid,
            texels,
            shape: shape.into(),
            normals: normals.into(),
        })
    }

    /// How many texels a grid of frames has.
    ///
    /// # Errors
    /// If it is larger or smaller than is allowed.
    pub fn texel_count([grid, texels]: [u32; 2]) -> Result<usize, ImpostorError> {
        let all = u64::from(grid).pow(2).saturating_mul(u64::from(texels).pow(2));
        let fits = (2..=MOST_GRID).contains(&grid)
            && (1..=MOST_TEXELS).contains(&texels)
            && all <= MOST_ALL;
        if fits { Ok(all as usize) } else { Err(ImpostorError::Size { grid, texels }) }
    }

    /// The box of the mesh: nothing is drawn outside of it.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// No point of the mesh is farther from the middle of its box.
    #[must_use]
    pub fn radius(&self) -> f32 {
        self.radius
    }

    /// How far what is drawn may be from the mesh, in units of the mesh.
    #[must_use]
    pub fn error(&self) -> f32 {
        self.error
    }

    /// The same with another error.
    #[must_use]
    pub fn with_error(self, error: f32) -> Self {
        Self { error, ..self }
    }

    /// Frames along a side of the grid.
    #[must_use]
    pub fn grid(&self) -> u32 {
        self.grid
    }

    /// Texels along a side of a frame.
    #[must_use]
    pub fn texels(&self) -> u32 {
        self.texels
    }

    /// Coverage, part and depth of each texel: 4, 4 and 8 bits from the highest down.
    #[must_use]
    pub fn shape(&self) -> &[u16] {
        &self.shape
    }

    /// Normals of the texels, on the octahedral square: 8 bits across and 8 up, from the highest
    /// down.
    #[must_use]
    pub fn normals(&self) -> &[u16] {
        &self.normals
    }

    /// The group of its level: a sphere around its box, and its error.
    #[must_use]
    pub fn group(&self) -> Group {
        let centre = self.bounds.center().map(|v| v as f32);
        let reach =
            |c: [f32; 3]| length([0, 1, 2].map(|a: usize| f64::from(c[a]) - f64::from(centre[a])));
        let radius = self.bounds.corners().map(reach).into_iter().fold(0.0, f64::max);
        // What the box that holds it is grown by, and rounding.
        Group { centre, radius: (radius * (1.0 + 2.0 * LEAST_SIDE)) as f32, error: self.error }
    }

    /// Whether it can stand for a mesh with so many parts.
    pub(super) fn check(&self, parts: usize) -> Result<(), ImpostorError> {
        let part = |word: &u16| u32::from(*word >> 8 & 15);
        match self.shape.iter().position(|word| part(word) as usize >= parts) {
            None => Ok(()),
            Some(texel) => {
                let part = part(&self.shape[texel]);
                Err(ImpostorError::NoSuchPart { texel, part, parts })
            }
        }
    }

    /// A texel by its number.
    ///
    /// # Panics
    /// If there are not as many.
    #[must_use]
    pub fn texel(&self, texel: usize) -> Texel {
        let (word, [u, v]) = (self.shape[texel], self.normals[texel].to_be_bytes());
        Texel {
            coverage: f64::from(word >> 12) / 15.0,
            part: u32::from(word >> 8 & 15),
            depth: f64::from(word & 255) / 127.5 - 1.0,
            normal: octahedral([u, v].map(|v| f64::from(v) / 127.5 - 1.0)),
        }
    }

    /// The two words of a texel.
    #[must_use]
    pub fn pack(texel: &Texel) -> [u16; 2] {
        let byte = |v: f64| ((v + 1.0) * 127.5).round().clamp(0.0, 255.0) as u16;
        // What is covered at all says so.
        let least = if texel.coverage > 0.0 { 1.0 } else { 0.0 };
        let coverage = (texel.coverage * 15.0).round().clamp(least, 15.0) as u16;
        let part = texel.part.min(IMPOSTOR_PARTS as u32 - 1) as u16;
        let [u, v] = square(texel.normal).map(byte);
        [coverage << 12 | part << 8 | byte(texel.depth), u << 8 | v]
    }

    /// The frames of a grid around a mesh, row by row.
    #[must_use]
    pub fn frames(grid: u32, bounds: &Aabb, radius: f32) -> Vec<ImpostorFrame> {
        let step = 2.0 / f64::from(grid.max(2) - 1);
        let frame = |i: u32| {
            let at = [i % grid, i / grid].map(|k| f64::from(k) * step - 1.0);
            ImpostorFrame::towards(octahedral(at), bounds, radius)
        };
        (0..grid * grid).map(frame).collect()
    }

    /// The three frames around a direction towards the viewer, which need not be of unit length,
    /// and their weights, whose sum is 1.
    #[must_use]
    #[inline]
    pub fn frames_around(&self, direction: [f64; 3]) -> [(u32, f64); 3] {
        let last = self.grid - 1;
        let [u, v] = square(direction);
        let [x, y] = [u, v].map(|at| (at + 1.0) * 0.5 * f64::from(last));
        // NaN comes to the first.
        let [i, j] = [x, y].map(|at| (at as u32).min(last - 1));
        let [x, y] = [x - f64::from(i), y - f64::from(j)];
        let at = |di: u32, dj: u32| (j + dj) * self.grid + i + di;
        // The diagonal that runs along the folds of the octahedron, so that a triangle of frames is
        // one of directions too.
        if u * v > 0.0 {
            match x + y < 1.0 {
                true => [(at(0, 0), 1.0 - x - y), (at(1, 0), x), (at(0, 1), y)],
                false => [(at(1, 1), x + y - 1.0), (at(1, 0), 1.0 - y), (at(0, 1), 1.0 - x)],
            }
        } else {
            match x > y {
                true => [(at(0, 0), 1.0 - x), (at(1, 0), x - y), (at(1, 1), y)],
                false => [(at(0, 0), 1.0 - y), (at(0, 1), y - x), (at(1, 1), x)],
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn empty(grid: u32, texels: u32) -> Impostor {
        let count = Impostor::texel_count([grid, texels]).expect("allowed");
        let bounds = Aabb::new([-1.0; 3], [1.0; 3]);
        Impostor::new([grid, texels], (bounds, 1.5), 0.1, vec![0; count], vec![0; count])
            .expect("sound")
    }

    /// Directions all around, none of them of a frame.
    fn directions() -> impl Iterator<Item = [f64; 3]> {
        (0..4000).map(|i| {
            let y = 1.0 - (f64::from(i) + 0.5) / 2000.0;
            let (s, c) = (f64::from(i) * 2.399_963).sin_cos();
            let r = (1.0 - y * y).sqrt();
            [r * c, y, r * s]
        })
    }

    #[test]
    fn a_direction_lies_among_its_three_frames() {
        // The largest angles of the table in the literature, and a little.
        for (grid, most) in [(8, 22.0), (12, 14.5), (16, 10.6)] {
            let impostor = empty(grid, 1);
            let frames = Impostor::frames(grid, &impostor.bounds(), impostor.radius());
            let mut nearest: f64 = 0.0;
            for d in directions() {
                let around = impostor.frames_around(d);
                let sum: f64 = around.iter().map(|f| f.1).sum();
                assert!((sum - 1.0).abs() < 1e-9 && around.iter().all(|f| f.1 >= -1e-9));
                let angle = |f: u32| {
                    let t = frames[f as usize].axes[2];
                    let dot: f64 = (0..3).map(|a| t[a] * d[a]).sum();
                    dot.clamp(-1.0, 1.0).acos().to_degrees()
                };
                let angles = around.map(|f| angle(f.0));
                nearest = nearest.max(angles.into_iter().fold(f64::INFINITY, f64::min));
                let all = angles.into_iter().fold(0.0, f64::max);
                assert!(all < most * 2.0, "{grid}: {d:?} {angles:?}");
                // And from any scale.
                assert_eq!(
                    impostor.frames_around(d.map(|v| v * 2.0)).map(|f| f.0),
                    around.map(|f| f.0)
                );
            }
            assert!(nearest < most && nearest > most * 0.8, "{grid}: {nearest}");
        }
    }

    #[test]
    fn frames_have_right_angles_and_show_the_whole_box() {
        let bounds = Aabb::new([-3.0, 0.0, 2.0], [-1.0, 0.0, 7.0]);
        for frame in Impostor::frames(5, &bounds, 9.0) {
            let [r, u, t] = frame.axes;
            let dot = |a: [f64; 3], b: [f64; 3]| -> f64 { (0..3).map(|k| a[k] * b[k]).sum() };
            for (a, b, expected) in
                [(r, u, 0.0), (u, t, 0.0), (r, r, 1.0), (u, u, 1.0), (t, t, 1.0)]
            {
                assert!((dot(a, b) - expected).abs() < 1e-12);
            }
            let centre = bounds.center();
            for corner in bounds.corners() {
                let to = [0, 1, 2].map(|a: usize| f64::from(corner[a]) - centre[a]);
                for (axis, half) in frame.axes.iter().zip(frame.half) {
                    assert!(dot(to, *axis).abs() <= half + 1e-12);
                }
            }
            let round = ImpostorFrame::towards(t, &bounds, 0.5);
            assert!(round.half.iter().zip(frame.half).all(|(a, b)| *a <= b.min(0.5)));
        }
    }

    #[test]
    fn texels_come_back_from_their_words() {
        let texel = Texel { coverage: 0.6, depth: -0.31, normal: [0.48, -0.6, 0.64], part: 5 };
        let mut impostor = empty(2, 1);
        let words = Impostor::pack(&texel);
        Arc::make_mut(&mut impostor.shape)[3] = words[0];
        Arc::make_mut(&mut impostor.normals)[3] = words[1];
        let back = impostor.texel(3);
        assert_eq!((back.coverage, back.part), (0.6, 5));
        assert!((back.depth - texel.depth).abs() < 1.0 / 255.0 + 1e-9);
        let dot: f64 = (0..3).map(|a| back.normal[a] * texel.normal[a]).sum();
        assert!(dot > 0.9998, "{dot}");
        assert_eq!(Impostor::pack(&Texel { coverage: 0.001, ..texel })[0] >> 12, 1);
        assert_eq!(Impostor::pack(&Texel { coverage: 0.0, ..texel })[0] >> 12, 0);
    }

    #[test]
    fn what_is_no_impostor_is_refused() {
        let bounds = Aabb::new([-1.0; 3], [1.0; 3]);
        let new = |sizes, bounds, error, n| {
            Impostor::new(sizes, (bounds, 1.5), error, vec![0; n], vec![0; n])
        };
        assert!(new([2, 1], bounds, 0.0, 4).is_ok());
        for sizes in [[1, 4], [65, 1], [4, 0], [4, 257], [64, 64], [u32::MAX, u32::MAX]] {
            assert!(matches!(new(sizes, bounds, 0.0, 4), Err(ImpostorError::Size { .. })));
        }
        assert!(matches!(new([2, 1], bounds, 0.0, 5), Err(ImpostorError::Count { .. })));
        for error in [-1.0, f32::NAN, f32::INFINITY] {
            assert!(matches!(new([2, 1], bounds, error, 4), Err(ImpostorError::NotFinite { .. })));
        }
        for bounds in [
            Aabb::EMPTY,
            Aabb::EVERYTHING,
            Aabb::new([1.0; 3], [1.0; 3]),
            Aabb::new([f32::NAN; 3], [1.0; 3]),
            Aabb::new([f32::MIN; 3], [f32::MAX; 3]),
        ] {
            assert!(matches!(new([2, 1], bounds, 0.0, 4), Err(ImpostorError::NotFinite { .. })));
        }
        for radius in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            let made = Impostor::new([2, 1], (bounds, radius), 0.0, vec![0; 4], vec![0; 4]);
            assert!(matches!(made, Err(ImpostorError::NotFinite { .. })));
        }
        let mut odd = empty(2, 1);
        Arc::make_mut(&mut odd.shape)[1] = 3 << 8;
        assert!(odd.check(4).is_ok());
        let wrong = ImpostorError::NoSuchPart { texel: 1, part: 3, parts: 3 };
        assert_eq!(odd.check(3), Err(wrong));
    }
}
