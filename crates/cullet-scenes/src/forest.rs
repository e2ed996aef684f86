//! A forest: very many instances of very few meshes, on hills.

use cullet::mesh::MeshData;

use super::builder::{SceneBuilder, Sides, turned};
use super::rng::{Rng, morton_grid, sin_cos};
use super::shapes::{Shape, mesh_data};
use super::spec::{KeyInfo, SceneInfo, SceneSpecError, Spec};
use cullet_io::Model;

pub(super) const INFO: SceneInfo = SceneInfo {
    name: "forest",
    about: "trees, bushes, rocks and grass on hills: very many instances of eight small meshes, \
            some 4 square metres for each",
    keys: &[
        KeyInfo { name: "seed", about: "which forest", default: 1, min: 0, max: u64::MAX },
        KeyInfo {
            name: "n",
            about: "how many plants and rocks; 1e7 take some 1.5 GiB",
            default: 1_000_000,
            min: 1,
            max: 20_000_000,
        },
    ],
};

/// Ground for each plant, in square metres.
const AREA: f64 = 4.0;
/// Quads along a side of the terrain.
const TERRAIN: u32 = 128;

/// Hills, sampled at the corners of a square grid of triangles; between them heights are those of
/// the triangles, so that what stands on the ground touches it wherever it is.
struct Terrain {
    reach: f64,
    heights: Vec<f64>,
}

impl Terrain {
    fn new(reach: f64, rng: &mut Rng) -> Self {
        let waves: Vec<[f64; 4]> = (0..5)
            .map(|i| {
                // At least eight quads a wave, so that the grid draws what the waves say.
                let length = (reach / 8.0).max(40.0) * (1.0 + f64::from(i) * 0.8);
                let (s, c) = sin_cos(rng.unit());
                [s / length, c / length, rng.unit(), length * 0.02]
            })
            .collect();
        let heights = (0..=TERRAIN)
            .flat_map(|j| (0..=TERRAIN).map(move |i| [i, j]))
            .map(|at| {
                let [x, z] = at.map(|v| (f64::from(v) / f64::from(TERRAIN) * 2.0 - 1.0) * reach);
                waves.iter().map(|[u, v, w, h]| h * sin_cos(u * x + v * z + w).0).sum()
            })
            .collect();
        Self { reach, heights }
    }

    fn corner(&self, i: u32, j: u32) -> f64 {
        self.heights[(j * (TERRAIN + 1) + i) as usize]
    }

    fn height(&self, p: [f64; 2]) -> f64 {
        let [u, v] = p.map(|c| (c / self.reach + 1.0) * 0.5 * f64::from(TERRAIN));
        let cell = |c: f64| (c.max(0.0) as u32).min(TERRAIN - 1);
        let (i, j) = (cell(u), cell(v));
        let (s, t) = (u - f64::from(i), v - f64::from(j));
        let (a, d) = (self.corner(i, j), self.corner(i + 1, j + 1));
        // The diagonal runs from (0, 0) to (1, 1), as in the mesh.
        if s > t {
            let b = self.corner(i + 1, j);
            a + (b - a) * s + (d - b) * t
        } else {
            let c = self.corner(i, j + 1);
            a + (c - a) * t + (d - c) * s
        }
    }

    fn mesh(&self, material: u32) -> MeshData {
        let mut shape = Shape::default();
        let side = TERRAIN + 1;
        for j in 0..side {
            for i in 0..side {
                let at =
                    |v: u32| ((f64::from(v) / f64::from(TERRAIN) * 2.0 - 1.0) * self.reach) as f32;
                shape.positions.push([at(i), self.corner(i, j) as f32, at(j)]);
            }
        }
        for j in 0..TERRAIN {
            for i in 0..TERRAIN {
                let a = j * side + i;
                shape.indices.extend([a, a + side, a + side + 1, a, a + side + 1, a + 1]);
            }
        }
        mesh_data(&[(shape, material)], true, cullet::mesh::Alpha::Opaque)
    }
}

/// Icosahedra pushed in and out: a rock, or a crown.
fn lump(times: u32, rough: f64, scale: [f64; 3], base: f64, rng: &mut Rng) -> Shape {
    let mut shape = Shape::icosphere(times);
    for p in &mut shape.positions {
        let r = rng.range(1.0 - rough, 1.0);
        *p = std::array::from_fn(|a| (f64::from(p[a]) * r * scale[a]) as f32);
    }
    shape.scaled([1.0; 3], [0.0, base, 0.0])
}

/// Blades in a ring, each a triangle that leans outward: a sheet, seen from both sides.
fn tuft(blades: u32, height: f64, rng: &mut Rng) -> Shape {
    let mut shape = Shape::default();
    for i in 0..blades {
        let turn = (f64::from(i) + rng.range(0.0, 0.6)) / f64::from(blades);
        let (s, c) = sin_cos(turn);
        let lean = rng.range(0.1, 0.4);
        let tip = height * rng.range(0.7, 1.0);
        let at = |across: f64, out: f64, y: f64| {
            [(out * c - across * s) as f32, y as f32, (out * s + across * c) as f32]
        };
        let first = shape.positions.len() as u32;
        shape.positions.extend([at(-0.06, 0.05, 0.0), at(0.06, 0.05, 0.0), at(0.0, lean, tip)]);
        shape.indices.extend([first, first + 1, first + 2]);
    }
    shape
}

/// A fir: a trunk, and three cones that overlap.
fn fir() -> [Shape; 2] {
    let cone = |base: f64, top: f64, radius: f64| Shape::lathe(&[[radius, base], [0.0, top]], 7);
    let trunk = Shape::lathe(&[[0.25, -0.3], [0.18, 2.5]], 5);
    let leaves = cone(1.5, 5.0, 2.0).and(&cone(3.4, 7.0, 1.55)).and(&cone(5.3, 9.0, 1.05));
    [trunk, leaves]
}

pub(super) fn build(spec: &Spec) -> Result<Model, SceneSpecError> {
    let seed = spec.get("seed");
    let n = spec.get("n");
    let mut b = SceneBuilder::new(spec);
    let bark = b.material("bark", 0x6B4F35);
    let pine = b.material("fir needles", 0x2E5E3A);
    let leaf = b.material("leaves", 0x5E8C3A);
    let dark = b.material("bush leaves", 0x48702F);
    let stone = b.material("stone", 0x8D8B86);
    let grass = b.material("grass", 0x86A84F);
    let soil = b.material("meadow", 0x7C8C4A);

    let mut rng = Rng::new(seed, 1);
    let reach = (n as f64 * AREA).sqrt() * 0.5;
    let terrain = Terrain::new(reach, &mut rng);
    let ground = b.mesh_from("terrain", terrain.mesh(soil))?;
    b.add(ground, cullet::Transform::IDENTITY)?;

    let [trunk, needles] = fir();
    let fir = b.mesh("fir", &[(trunk, bark), (needles, pine)], Sides::One)?;
    let trunk = Shape::lathe(&[[0.3, -0.3], [0.2, 4.0]], 6);
    let crown = lump(1, 0.25, [2.4, 2.6, 2.4], 5.0, &mut rng);
    let oak = b.mesh("oak", &[(trunk, bark), (crown, leaf)], Sides::One)?;
    let trunk = Shape::lathe(&[[0.12, -0.3], [0.06, 6.0]], 5);
    let crown = lump(0, 0.1, [1.1, 3.0, 1.1], 5.0, &mut rng);
    let birch = b.mesh("birch", &[(trunk, stone), (crown, leaf)], Sides::One)?;
    let bush =
        b.mesh("bush", &[(lump(0, 0.3, [0.9, 0.7, 0.9], 0.4, &mut rng), dark)], Sides::One)?;
    let boulder =
        b.mesh("boulder", &[(lump(1, 0.3, [0.8, 0.6, 0.9], 0.25, &mut rng), stone)], Sides::One)?;
    let pebble =
        b.mesh("stone", &[(lump(0, 0.35, [0.3, 0.2, 0.3], 0.1, &mut rng), stone)], Sides::One)?;
    let tall = b.mesh("tall grass", &[(tuft(6, 0.8, &mut rng), grass)], Sides::Both)?;
    let low = b.mesh("grass tuft", &[(tuft(4, 0.4, &mut rng), grass)], Sides::Both)?;
    let trees = [fir, fir, oak, birch];

    // Cells of some sixteen plants, in an order that keeps neighbours in slots near each other.
    let mut rng = Rng::new(seed, 2);
    let cells = (n as f64 / 16.0).sqrt().ceil().max(1.0) as u32;
    let pitch = 2.0 * reach / f64::from(cells);
    let total = u64::from(cells) * u64::from(cells);
    for (i, (x, z)) in (0u64..).zip(morton_grid(cells)) {
        let corner = [x, z].map(|c| f64::from(c) * pitch - reach);
        // Woods and clearings, some hundred metres across.
        let [u, v] = corner.map(|c| c / 130.0);
        let wood =
            sin_cos(u + 0.6 * sin_cos(v * 0.7).0).0 + sin_cos(v + 0.5 * sin_cos(u * 0.9).0).0;
        let wooded = (0.16 + 0.16 * wood).clamp(0.01, 0.4);
        for _ in (i * n / total)..((i + 1) * n / total) {
            let at = corner.map(|c| rng.range(c, c + pitch));
            let pick = rng.unit();
            let (mesh, least, most) = if pick < wooded {
                (trees[rng.below(4)], 0.6, 1.4)
            } else if pick < wooded + 0.1 {
                (bush, 0.6, 1.5)
            } else if pick < wooded + 0.13 {
                (boulder, 0.4, 1.8)
            } else if pick < wooded + 0.2 {
                (pebble, 0.5, 1.5)
            } else if pick < wooded + 0.4 {
                (tall, 0.7, 1.3)
            } else {
                (low, 0.7, 1.3)
            };
            let size = rng.range(least, most);
            let y = terrain.height(at) - 0.02;
            b.add(mesh, turned(rng.unit(), [size; 3], [at[0], y, at[1]]))?;
        }
    }
    Ok(b.finish())
}
