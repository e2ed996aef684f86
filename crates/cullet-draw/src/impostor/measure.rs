//! How far an impostor is from its mesh, from directions between its frames.

use cullet::Mesh;
use cullet_mesh::{Impostor, ImpostorError, ImpostorFrame};
use glam::DVec3;

use super::capture::{ImpostorOptions, Studio, scene_of};
use super::trace::Tracer;
use crate::{parallel, sort};

/// Samples along a side of a texel.
const FINE: u32 = 4;
/// The share of samples that may be farther off than the error, as for levels.
const SHARE_OVER: f64 = 1e-3;
/// Bound that no measured point exceeds, as a factor of the error.
const MOST_OVER: f64 = 1.2;
/// How much a difference along the line of sight counts beside one across it. It is seen only where
/// something else stands in between; and where a surface is nearly edge-on, any small step across
/// is a large one along.
const ALONG: f64 = 0.25;

/// How far an impostor was found to be from its mesh, in units of the mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImpostorMeasure {
    /// The error to state: the 99.9 % quantile, or the largest over 1.2, whichever is more, and a
    /// quarter of the distance between samples, between which there are others.
    pub error: f64,
    /// Distance that 99.9 % of samples do not exceed.
    pub p999: f64,
    /// The largest.
    pub max: f64,
    /// Samples of mesh and impostor, each with its distance to the other.
    pub samples: u64,
}

/// An impostor of a mesh, with its measured error.
///
/// # Errors
/// As [`capture_impostor`](super::capture_impostor).
pub fn make_impostor(
    mesh: &Mesh,
    options: &ImpostorOptions,
) -> Result<(Impostor, ImpostorMeasure), ImpostorError> {
    let scene = scene_of(mesh)?;
    let studio = Studio::new(mesh, &scene);
    let made = studio.capture(options)?;
    let found = studio.measure(&made, options.directions, options.seed)?;
    // Rounded up.
    let error = (found.error * (1.0 + f64::from(f32::EPSILON))) as f32;
    Ok((made.with_error(error), found))
}

/// Draws a mesh and its impostor from random directions, by parallel lines of sight and finer than
/// a texel, and looks from each sample of either where the nearest one of the other is: across the
/// picture in full, along the line of sight by a quarter. So pixels are off by the error at the
/// most, and depths by four times as much. Lines of sight of any eye are parallel to some of these.
///
/// What is not in either picture counts as the distance to what is; where one is empty, as the
/// diameter.
///
/// # Errors
/// As [`capture_impostor`](super::capture_impostor).
pub fn measure_impostor(
    mesh: &Mesh,
    impostor: &Impostor,
    directions: u32,
    seed: u64,
) -> Result<ImpostorMeasure, ImpostorError> {
    let scene = scene_of(mesh)?;
    Studio::new(mesh, &scene).measure(impostor, directions, seed)
}

/// A mesh made ready for being held beside its impostor from many sides.
#[derive(Debug)]
pub struct ImpostorJudge {
    scene: cullet::Scene,
    tracer: Tracer,
}

impl ImpostorJudge {
    /// Prepares to judge an impostor of a mesh.
    ///
    /// # Errors
    /// As [`capture_impostor`](super::capture_impostor).
    pub fn new(mesh: &Mesh, impostor: Impostor) -> Result<Self, ImpostorError> {
        Ok(Self { scene: scene_of(mesh)?, tracer: Tracer::new(impostor) })
    }

    /// Distances, as [`measure_impostor`] finds them, from one direction towards the viewer; in
    /// units of the mesh.
    ///
    /// # Errors
    /// As [`capture_impostor`](super::capture_impostor).
    pub fn distances(&self, direction: [f64; 3]) -> Result<Vec<f32>, ImpostorError> {
        let mesh = &self.scene.meshes()[0];
        let studio = Studio::new(mesh, &self.scene);
        let direction = DVec3::from(direction);
        let usable = direction.is_finite() && direction.length() > 0.0;
        let direction = if usable { direction.normalize() } else { DVec3::Y };
        let mut found = studio.distances(&self.tracer, direction)?;
        found.iter_mut().for_each(|d| *d = (f64::from(*d) * studio.radius) as f32);
        Ok(found)
    }
}

/// Heights in radii over the samples of a picture, where there is anything.
struct Heights {
    width: usize,
    /// Distance between samples, in radii.
    pitch: f64,
    of: Vec<Option<f64>>,
}

impl Studio<'_> {
    fn measure(
        &self,
        impostor: &Impostor,
        directions: u32,
        seed: u64,
    ) -> Result<ImpostorMeasure, ImpostorError> {
        let tracer = Tracer::new(impostor.clone());
        let of = |i: usize| self.distances(&tracer, direction(seed, i as u32));
        let all: Result<Vec<Vec<f32>>, ImpostorError> =
            parallel::map(directions as usize, &of).into_iter().collect();
        let mut all = all?.concat();
        if all.is_empty() {
            return Ok(ImpostorMeasure::default());
        }
        let over = (all.len() as f64 * SHARE_OVER) as usize;
        let [p999, max] =
            [over, 0].map(|n| f64::from(sort::largest_but(n, &mut all)) * self.radius);
        let pitch = 2.0 * self.radius / f64::from(impostor.texels() * FINE);
        // Between the samples are others.
        let error = p999.max(max / MOST_OVER).max(pitch * 0.25) + pitch * 0.25;
        Ok(ImpostorMeasure { error, p999, max, samples: all.len() as u64 })
    }

    /// Distances in radii between what is seen of the mesh and of its impostor from a direction,
    /// both ways.
    fn distances(&self, tracer: &Tracer, direction: DVec3) -> Result<Vec<f32>, ImpostorError> {
        let bounds = tracer.impostor.bounds();
        let frame = ImpostorFrame::towards(direction.to_array(), &bounds, tracer.impostor.radius());
        let across = tracer.impostor.texels() * FINE;
        let [x, y] = [frame.half[0], frame.half[1]];
        let pitch = 2.0 * x.max(y) / f64::from(across);
        // A sample of room all around.
        let size = [x, y].map(|v| (2.0 * v / pitch).ceil() as u32 + 2);
        let half = size.map(|n| f64::from(n) * pitch * 0.5);
        let shot = self.shot(frame.axes, half, size)?;
        let [right, up, towards] = frame.axes.map(DVec3::from);
        let width = size[0] as usize;
        let mesh = Heights {
            width,
            pitch: pitch / self.radius,
            of: shot.iter().map(|s| s.map(|s| s.height)).collect(),
        };
        let traced = |at: usize| {
            let place = |i: usize, half: f64| (i as f64 + 0.5) * pitch - half;
            let plane = right * place(at % width, half[0]) - up * place(at / width, half[1]);
            let from = self.centre + plane + towards * (2.0 * self.radius);
            let hit = tracer.trace(from, -towards)?;
            Some((hit.point - self.centre).dot(towards) / self.radius)
        };
        let drawn = Heights { width, pitch: mesh.pitch, of: (0..shot.len()).map(traced).collect() };
        let mut out = Vec::new();
        mesh.to(&drawn, &mut out);
        drawn.to(&mesh, &mut out);
        Ok(out)
    }
}

impl Heights {
    /// Distances of all of these to the nearest of others.
    fn to(&self, other: &Self, out: &mut Vec<f32>) {
        for (at, height) in self.of.iter().enumerate() {
            if let Some(height) = height {
                out.push(other.nearest([at % self.width, at / self.width], *height) as f32);
            }
        }
    }

    /// Distance to the nearest, in rings around a place that grow until none can be nearer; 2 if
    /// there is none.
    fn nearest(&self, [x, y]: [usize; 2], height: f64) -> f64 {
        let rows = self.of.len() / self.width;
        let mut best: f64 = 2.0;
        for ring in 0..self.width.max(rows) {
            if ring as f64 * self.pitch >= best {
                break;
            }
            let [low, high] = [y.saturating_sub(ring), (y + ring).min(rows - 1)];
            for row in low..=high {
                let is_edge = row + ring == y || row == y + ring;
                let step = if is_edge { 1 } else { (2 * ring).max(1) };
                let first = x as isize - ring as isize;
                for column in (first..=first + 2 * ring as isize).step_by(step) {
                    if column < 0 || column as usize >= self.width {
                        continue;
                    }
                    let Some(other) = self.of[row * self.width + column as usize] else { continue };
                    let dx = (column as f64 - x as f64) * self.pitch;
                    let dy = (row as f64 - y as f64) * self.pitch;
                    best =
                        best.min((dx * dx + dy * dy + ((other - height) * ALONG).powi(2)).sqrt());
                }
            }
        }
        best
    }
}

/// A direction, evenly among all, by hashing (Steele, Lea & Flood, *Fast Splittable Pseudorandom
/// Number Generators*, 2014).
fn direction(seed: u64, i: u32) -> DVec3 {
    let mix = |mut z: u64| {
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    };
    // Points of the cube that lie in the ball: without functions that differ between machines.
    let mut state = mix(seed ^ mix(u64::from(i).wrapping_add(0x9E37_79B9_7F4A_7C15)));
    loop {
        let p = DVec3::from(std::array::from_fn(|_| {
            state = mix(state.wrapping_add(0x9E37_79B9_7F4A_7C15));
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }));
        if (0.01..=1.0).contains(&p.length_squared()) {
            return p.normalize();
        }
    }
}
