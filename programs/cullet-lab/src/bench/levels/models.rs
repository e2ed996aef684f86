//! Models as one mesh each, and eyes around them.

use std::path::{Path, PathBuf};

use cullet::MeshData;
use cullet::lod::{LevelEye, Lod, PixelScale};
use cullet::mesh::weld;
use cullet::{Scene, Transform};
use cullet_command::args::SceneArgs;
use cullet_command::console::Console;
use cullet_command::exit::Failure;
use cullet_command::inputs;

/// All meshes of a model as they are stored, as one, equal positions welded.
#[derive(Debug)]
pub(super) struct Whole {
    pub(super) name: String,
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) indices: Vec<u32>,
    /// The middle of its box, and the distance of the farthest vertex from there.
    pub(super) middle: [f64; 3],
    pub(super) radius: f64,
}

impl Whole {
    fn new(name: String, scene: &Scene) -> Self {
        let mut positions: Vec<[f32; 3]> = Vec::new();
        let mut corners: Vec<u32> = Vec::new();
        for mesh in scene.meshes() {
            let base = positions.len() as u32;
            positions.extend_from_slice(mesh.positions());
            corners.extend(mesh.indices().iter().map(|i| i + base));
        }
        Self::of(name, positions, &corners)
    }

    /// Builds the whole from triangles in one space.
    pub(super) fn of(name: String, positions: Vec<[f32; 3]>, corners: &[u32]) -> Self {
        let same = weld(&positions);
        let mut indices = Vec::with_capacity(corners.len());
        for t in corners.as_chunks::<3>().0 {
            let [a, b, c] = t.map(|v| same[v as usize]);
            if a != b && b != c && c != a {
                indices.extend([a, b, c]);
            }
        }
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for p in &positions {
            for a in 0..3 {
                low[a] = low[a].min(p[a].into());
                high[a] = high[a].max(p[a].into());
            }
        }
        let middle: [f64; 3] = std::array::from_fn(|a| (low[a] + high[a]) / 2.0);
        let radius = positions.iter().map(|p| apart(p.map(f64::from), middle)).fold(0.0, f64::max);
        Self { name, positions, indices, middle, radius }
    }

    pub(super) fn triangles(&self) -> usize {
        self.indices.len() / 3
    }

    pub(super) fn to_data(&self) -> MeshData {
        let (positions, indices) = (self.positions.clone(), self.indices.clone());
        MeshData { positions, indices, ..MeshData::default() }
    }

    /// The view of an eye so many radii from the middle; pixels are of 1080 lines over 60 degrees.
    pub(super) fn seen(&self, direction: [f64; 3], radii: f64) -> PixelScale {
        let eye = std::array::from_fn(|a| self.middle[a] + direction[a] * radii * self.radius);
        PixelScale { eye: Some(eye), pixels: 540.0 * 3.0_f64.sqrt(), near: self.radius * 1e-3 }
    }
}

/// The eye of a view for a threshold of so many pixels.
pub(super) fn level_eye(view: &PixelScale, pixels: f64) -> LevelEye {
    LevelEye::new(&Lod::default().with_pixels(pixels), view, &Transform::IDENTITY, None)
}

pub(super) fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// Directions that are spread evenly over the sphere: the points of a Fibonacci spiral.
pub(super) fn directions(count: u32) -> impl Iterator<Item = [f64; 3]> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    (0..count).map(move |i| {
        let y = 1.0 - (f64::from(i) + 0.5) * 2.0 / f64::from(count);
        let (around, out) = (golden * f64::from(i), (1.0 - y * y).max(0.0).sqrt());
        [around.cos() * out, y, around.sin() * out]
    })
}

/// The models named, or those of `CULLET_DATA` that are there.
pub(super) fn models(named: &[String], console: &Console) -> Result<Vec<Whole>, Failure> {
    const MODELS: [&str; 4] = [
        "armadillo/armadillo.obj",
        "happy-buddha/buddha-100k.obj",
        "intel-castle/intel-castle.glb",
        "classic-meshes/fandisk.obj",
    ];
    let set = std::env::var_os("CULLET_DATA").filter(|v| !v.is_empty()).map(PathBuf::from);
    let folder = set.unwrap_or_else(|| "../shared/data".into());
    let found = MODELS.iter().map(|m| folder.join(m)).filter(|p| p.exists());
    let paths: Vec<String> = if named.is_empty() {
        found.map(|p| p.display().to_string()).collect()
    } else {
        named.to_vec()
    };
    if paths.is_empty() {
        let folder = folder.display();
        return Err(Failure::usage(format!(
            "no model in {folder} (CULLET_DATA), and none given: cullet bench lod --scene model.glb"
        )));
    }
    let load = |path: &String| {
        let model = inputs::load(&SceneArgs::of(path), console)?;
        let name = Path::new(path).file_stem().map_or(path.clone(), |s| s.to_string_lossy().into());
        Ok(Whole::new(name, &model.scene))
    };
    paths.iter().map(load).collect()
}
