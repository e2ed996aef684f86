//! A mesh as it is seen by parallel lines of sight, and its impostor.

use cullet::mesh::Alpha;
use cullet::{Camera, Depth, Instance, Mesh, Projection, Scene, Transform, View};
use cullet_mesh::{IMPOSTOR_PARTS, Impostor, ImpostorError, ImpostorFrame, Texel};
use glam::DVec3;

use crate::frame::{PixelId, RenderOptions, Selection};
use crate::parallel;
use crate::prepare::{Stage, part_of};
use crate::render::render_stage;

/// How an impostor is made and measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImpostorOptions {
    /// Frames along a side of the octahedral grid.
    pub grid: u32,
    /// Texels along a side of a frame.
    pub texels: u32,
    /// Samples along a side of a texel.
    pub samples: u32,
    /// From how many directions its error is measured.
    pub directions: u32,
    /// Seed of those.
    pub seed: u64,
}

impl Default for ImpostorOptions {
    fn default() -> Self {
        Self { grid: 12, texels: 12, samples: 4, directions: 256, seed: 0x696d_706f_7374 }
    }
}

/// How far a line of sight goes before and behind the centre, in radii.
const REACH: f64 = 2.0;
/// Distance in sides of a texel within which all of its samples are of one surface.
const ONE_SURFACE: f64 = 1.0;

/// A mesh alone, about as large as 1, where it is drawn just so.
#[derive(Debug)]
pub(super) struct Studio<'a> {
    mesh: &'a Mesh,
    stage: Stage<'a>,
    indices: Vec<u32>,
    /// Centre and radius of its box.
    pub(super) centre: DVec3,
    pub(super) radius: f64,
}

/// Surface that a parallel view shows at a sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    /// Towards the viewer from the centre, in radii.
    pub(super) height: f64,
    /// Normal of the side that is seen.
    normal: DVec3,
    part: u32,
}

/// The scene of a studio.
pub(super) fn scene_of(mesh: &Mesh) -> Result<Scene, ImpostorError> {
    let not = |why| Err(ImpostorError::Mesh { why });
    let bounds = mesh.bounds();
    if mesh.triangle_count() == mesh.degenerate_count() {
        return not("has no triangle with an area");
    }
    if mesh.is_deformable() {
        return not("may move");
    }
    if mesh.parts().iter().any(|p| p.alpha != Alpha::Opaque) {
        return not("is not opaque");
    }
    if mesh.parts().len() > IMPOSTOR_PARTS {
        return not("has more than 16 parts");
    }
    let scale = scale_of(mesh);
    if !(bounds.is_finite() && scale.is_normal()) {
        return not("is too large or too small");
    }
    let to = bounds.center().map(|v| -v * f64::from(scale));
    let mut scene = Scene::new();
    let own = scene.add_mesh(mesh.clone());
    match scene.add(Instance::new(own, Transform::from_scale_translation([scale; 3], to))) {
        Ok(_) => Ok(scene),
        Err(_) => not("is too large or too small"),
    }
}

fn scale_of(mesh: &Mesh) -> f32 {
    (1.0 / DVec3::from(mesh.bounds().half_extent()).length()) as f32
}

impl<'a> Studio<'a> {
    /// Prepares captures of a mesh and its [scene](scene_of).
    pub(super) fn new(mesh: &'a Mesh, scene: &'a Scene) -> Self {
        Self {
            mesh,
            stage: Stage::new(scene),
            indices: mesh.original_indices(),
            centre: mesh.bounds().center().into(),
            radius: 1.0 / f64::from(scale_of(mesh)),
        }
    }

    /// A picture of so many samples: of `half` to each side of the centre, in units of the mesh.
    pub(super) fn shot(
        &self,
        axes: [[f64; 3]; 3],
        half: [f64; 2],
        size: [u32; 2],
    ) -> Result<Vec<Option<Seen>>, ImpostorError> {
        let [x, y] = half.map(|v| v / self.radius);
        let projection = Projection::Orthographic {
            left: -x,
            right: x,
            bottom: -y,
            top: y,
            near: -REACH,
            far: REACH,
        };
        let camera =
            Camera { eye: [0.0; 3], direction: axes[2].map(|v| -v), up: axes[1], projection };
        let view = View::new(&camera, Depth::Standard, size);
        let view = view.map_err(|_| ImpostorError::Mesh { why: "is too thin to be looked at" })?;
        let frame = render_stage(&self.stage, &view, Selection::All, &RenderOptions::default());
        let towards = DVec3::from(axes[2]);
        let seen = |(&id, &depth): (&PixelId, &f64)| {
            (id != PixelId::NONE).then(|| {
                let normal = self.normal(id.triangle);
                Seen {
                    height: REACH - 2.0 * REACH * depth,
                    normal: if normal.dot(towards) < 0.0 { -normal } else { normal },
                    part: self.part(id.triangle),
                }
            })
        };
        Ok(frame.ids.iter().zip(&frame.depth).map(seen).collect())
    }

    fn normal(&self, triangle: u32) -> DVec3 {
        let at = triangle as usize * 3;
        let corner = |k: usize| {
            let p = self.mesh.positions()[self.indices[at + k] as usize];
            // As large as 1, so that no product is lost.
            (DVec3::from(p.map(f64::from)) - self.centre) / self.radius
        };
        let [a, b, c] = [0, 1, 2].map(corner);
        (b - a).cross(c - a).normalize_or_zero()
    }

    /// How far from the centre the farthest corner is, rounded up.
    fn reach(&self) -> f32 {
        let far = |&v: &u32| {
            let p = self.mesh.positions()[v as usize];
            (DVec3::from(p.map(f64::from)) - self.centre).length()
        };
        let most = self.indices.iter().map(far).fold(0.0, f64::max);
        (most * (1.0 + f64::from(f32::EPSILON))) as f32
    }

    fn part(&self, triangle: u32) -> u32 {
        let first = part_of(self.mesh, triangle).first_triangle;
        let own = |p: &cullet::mesh::Part| p.first_triangle == first && p.triangle_count > 0;
        self.mesh.parts().iter().position(own).unwrap_or(0) as u32
    }

    /// The texels of a frame.
    fn texels(
        &self,
        frame: &ImpostorFrame,
        options: &ImpostorOptions,
    ) -> Result<Vec<Texel>, ImpostorError> {
        let (across, fine) = (options.texels as usize, options.samples.clamp(1, 16) as usize);
        let size = [(across * fine) as u32; 2];
        let half = [frame.half[0], frame.half[1]];
        let shot = self.shot(frame.axes, half, size)?;
        let mut texels = Vec::with_capacity(across * across);
        let mut samples = Vec::with_capacity(fine * fine);
        for at in 0..across * across {
            let (column, row) = (at % across * fine, at / across * fine);
            samples.clear();
            for y in 0..fine {
                for x in 0..fine {
                    if let Some(seen) = shot[(row + y) * across * fine + column + x] {
                        // How far the middle of the texel is, in radii.
                        let off = |v: usize| (fine as f64 * 0.5 - v as f64 - 0.5) / fine as f64;
                        let [dx, dy] = [off(x), off(y)];
                        let step = half.map(|v| 2.0 * v / across as f64 / self.radius);
                        samples.push((seen, [dx * step[0], -dy * step[1]]));
                    }
                }
            }
            let share = samples.len() as f64 / (fine * fine) as f64;
            texels.push(self.texel(frame, half, across, share, &mut samples));
        }
        pad(&mut texels, across);
        Ok(texels)
    }

    /// A texel of its samples, each with how far the middle of the texel is from it.
    fn texel(
        &self,
        frame: &ImpostorFrame,
        half: [f64; 2],
        across: usize,
        coverage: f64,
        samples: &mut [(Seen, [f64; 2])],
    ) -> Texel {
        if samples.is_empty() {
            return Texel::default();
        }
        // The surface in the middle of all depths is that of most samples, where there are two.
        samples.sort_by(|a, b| a.0.height.total_cmp(&b.0.height));
        let middle = samples[samples.len() / 2].0;
        let side = half[0].max(half[1]) * 2.0 / across as f64 / self.radius;
        let [right, up, towards] = frame.axes.map(DVec3::from);
        let (mut normal, mut height, mut count) = (DVec3::ZERO, 0.0, 0.0);
        for (seen, [dx, dy]) in samples.iter() {
            let is_same = (seen.height - middle.height).abs() <= ONE_SURFACE * side;
            if is_same && seen.part == middle.part {
                normal += seen.normal;
                // Along its plane to the middle of the texel; not far where that is steep.
                let lean = -(seen.normal.dot(right) * dx + seen.normal.dot(up) * dy);
                let most = side * 0.5;
                height +=
                    seen.height + (lean / seen.normal.dot(towards).max(1e-3)).clamp(-most, most);
                count += 1.0;
            }
        }
        let normal = normal.try_normalize().unwrap_or(middle.normal);
        let depth = height / count * self.radius / frame.half[2];
        Texel { coverage, depth, normal: normal.to_array(), part: middle.part }
    }
}

/// Gives texels that are not covered what a neighbour has, so that nothing else is mixed into the
/// edge of what is.
fn pad(texels: &mut [Texel], across: usize) {
    let mut known: Vec<bool> = texels.iter().map(|t| t.coverage > 0.0).collect();
    if !known.contains(&true) {
        return;
    }
    while known.contains(&false) {
        let before = known.clone();
        for at in 0..texels.len() {
            if before[at] {
                continue;
            }
            let (x, y) = (at % across, at / across);
            let neighbours = [
                (x > 0).then(|| at - 1),
                (x + 1 < across).then(|| at + 1),
                (y > 0).then(|| at - across),
                (y + 1 < across).then(|| at + across),
            ];
            if let Some(from) = neighbours.into_iter().flatten().find(|&n| before[n]) {
                texels[at] = Texel { coverage: 0.0, ..texels[from] };
                known[at] = true;
            }
        }
    }
}

/// Looks at a mesh from all around. The error of what comes out is 0, for nothing has been measured
/// yet; see [`make_impostor`](super::make_impostor).
///
/// The same mesh and options give the same bytes, with any number of threads. Cost: `grid²`
/// pictures, each some 0.1 µs a triangle.
///
/// # Errors
/// If the mesh may move, is not opaque, has no triangles or too many parts, or a size is not
/// allowed.
pub fn capture_impostor(mesh: &Mesh, options: &ImpostorOptions) -> Result<Impostor, ImpostorError> {
    let scene = scene_of(mesh)?;
    Studio::new(mesh, &scene).capture(options)
}

impl Studio<'_> {
    pub(super) fn capture(&self, options: &ImpostorOptions) -> Result<Impostor, ImpostorError> {
        let sizes = [options.grid, options.texels];
        let count = Impostor::texel_count(sizes)?;
        let bounds = self.mesh.bounds();
        let radius = self.reach();
        let frames = Impostor::frames(options.grid, &bounds, radius);
        let frames: Result<Vec<Vec<Texel>>, ImpostorError> =
            parallel::map(frames.len(), &|i| self.texels(&frames[i], options))
                .into_iter()
                .collect();
        let (mut shape, mut normals) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for texel in frames?.iter().flatten() {
            let [s, n] = Impostor::pack(texel);
            shape.push(s);
            normals.push(n);
        }
        Impostor::new(sizes, (bounds, radius), 0.0, shape, normals)
    }
}
