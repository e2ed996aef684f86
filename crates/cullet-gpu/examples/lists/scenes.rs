//! Scenes and views that are the same on every machine: no function of f64 is called but the square root.

use cullet::bounds::{Aabb, Plane};
use cullet::mesh::MeshData;
use cullet::{Depth, Instance, Mesh, Scene, Transform, View, scene::BoundsOverride};
use cullet_gpu::BLOCK;

/// Views of each scene.
const VIEWS: usize = 6;

/// A scene, and what is looked at in it.
#[derive(Debug)]
pub(crate) struct Case {
    /// Feature that the other cases lack.
    pub(crate) name: &'static str,
    /// Ready to be looked at.
    pub(crate) scene: Scene,
    /// Planes that point out, in the space of the scene's boxes, and layers.
    pub(crate) views: Vec<(Vec<Plane>, u32)>,
}

/// Random numbers (`SplitMix64`: Steele, Lea & Flood, *Fast Splittable Pseudorandom Number Generators*, 2014).
struct Rng(u64);

impl Rng {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }

    fn below(&mut self, n: u64) -> u64 {
        self.bits() % n
    }

    /// In −1..1.
    fn signed(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self, reach: f64) -> [f64; 3] {
        [(); 3].map(|()| self.signed() * reach)
    }

    fn direction(&mut self) -> [f64; 3] {
        loop {
            let v = self.vector(1.0);
            let square = dot(v, v);
            if square > 0.01 && square < 1.0 {
                return v.map(|c| c / square.sqrt());
            }
        }
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// All scenes: few and many instances, about as many as a block has, boxes of every kind, and a hundred thousand at once.
pub(crate) fn scenes() -> impl Iterator<Item = Case> {
    let block = BLOCK as u32;
    let counts = [
        ("nothing", 0),
        ("one", 1),
        ("a block less one", block - 1),
        ("a block", block),
        ("a block and one", block + 1),
        ("odd ones", 5000),
        ("many", 100_000),
    ];
    counts.into_iter().zip(1..).map(|((name, count), seed)| case(name, count, &mut Rng(seed)))
}

fn case(name: &'static str, count: u32, rng: &mut Rng) -> Case {
    let mut scene = Scene::new();
    for _ in 0..3 {
        let corners = [(); 4].map(|()| rng.vector(1.0).map(|v| v as f32));
        let data = MeshData {
            positions: corners.to_vec(),
            indices: vec![0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3],
            ..MeshData::default()
        };
        scene.add_mesh(Mesh::new(data).expect("four corners are a mesh"));
    }
    // As dense, however many there are.
    let reach = f64::from(count.max(1)).sqrt() * 0.5;
    let mut handles = Vec::new();
    for _ in 0..count {
        let instance = instance(rng, reach, name == "odd ones");
        handles.push(scene.add(instance).expect("the mesh is there"));
    }
    scene.commit(&cullet::Culler::default());
    if name == "odd ones" {
        for handle in handles.iter().step_by(17) {
            scene.remove(*handle).expect("it is removed once");
        }
    }
    scene.commit(&cullet::Culler::default());
    let views = (0..VIEWS).map(|number| view(rng, number, reach, scene.origin())).collect();
    Case { name, scene, views }
}

/// Turned, sheared, mirrored, of several sizes; where they are odd also flat, not finite, far away, of no layer, never culled.
fn instance(rng: &mut Rng, reach: f64, odd: bool) -> Instance {
    let size = [0.125, 0.5, 0.5, 2.0][rng.below(4) as usize];
    let linear = [(); 3].map(|()| rng.vector(size).map(|v| v as f32));
    let mesh = rng.below(3) as u32;
    let mut made = Instance::new(mesh, Transform { linear, translation: rng.vector(reach) });
    made.layers = 1 << rng.below(3);
    if odd {
        match rng.below(16) {
            0 => made.transform.linear[1] = made.transform.linear[0],
            1 => made.transform.linear = [[0.0; 3]; 3],
            2 => made.transform.translation[0] = f64::NAN,
            3 => made.transform.translation = rng.vector(1e7),
            4 => made.transform.linear[2][2] = f32::INFINITY,
            5 => made.layers = 0,
            6 => made.flags.always_visible = true,
            7 => made.bounds = BoundsOverride::None,
            8 => made.bounds = BoundsOverride::World(Aabb::EMPTY),
            9 => made.bounds = BoundsOverride::Margin(3.0),
            _ => {}
        }
    }
    made
}

fn view(rng: &mut Rng, number: usize, reach: f64, origin: [f64; 3]) -> (Vec<Plane>, u32) {
    let layers = [u32::MAX, 0b101][number % 2];
    let planes = match number {
        // A pyramid, an infinite one, one that is mirrored and lies askew, and a box.
        0..=3 => {
            let matrix = matrix(rng, number, reach);
            let view = View::from_matrix(matrix, Depth::Reversed, [640, 400]);
            let frustum = view.expect("it has a volume").frustum().relative_to(origin);
            frustum.planes().map(|(_, plane)| *plane).collect()
        }
        // Everything.
        4 => Vec::new(),
        // As many planes as a view may have, some of which say nothing.
        _ => {
            let mut all: Vec<Plane> =
                (0..29).map(|_| Plane::new(rng.direction(), reach * 0.5)).collect();
            all.push(Plane::new([f64::NAN, 0.0, 0.0], 0.0));
            all.push(Plane::new([0.0; 3], 1.0));
            all.push(Plane::new([1.0, 0.0, 0.0], f64::INFINITY));
            all
        }
    };
    (planes, layers)
}

/// World to clip space with reversed depth, column-major.
fn matrix(rng: &mut Rng, number: usize, reach: f64) -> [f64; 16] {
    let back = rng.direction();
    let eye = rng.vector(reach * 0.5);
    let up = if back[0].abs() < 0.5 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let side = cross(up, back);
    let right = side.map(|v| v / dot(side, side).sqrt());
    let up = cross(back, right);
    // Rows of the matrix that takes a point relative to the eye to clip space.
    let scaled = |v: [f64; 3], by: f64| v.map(|c| c * by);
    let (near, far) = (0.125, reach * 0.75 + 1.0);
    let rows = match number {
        0 => [
            (scaled(right, 1.25), 0.0),
            (scaled(up, 2.0), 0.0),
            (scaled(back, near / (far - near)), near * far / (far - near)),
            (scaled(back, -1.0), 0.0),
        ],
        1 => [
            (scaled(right, 1.25), 0.0),
            (scaled(up, 2.0), 0.0),
            ([0.0; 3], near),
            (scaled(back, -1.0), 0.0),
        ],
        2 => {
            let askew: [f64; 3] = std::array::from_fn(|a| right[a] * -1.5 + back[a] * 0.25);
            [(askew, 0.0), (scaled(up, 1.5), 0.0), ([0.0; 3], near), (scaled(back, -1.0), 0.0)]
        }
        _ => [
            (scaled(right, 3.0 / reach), 0.0),
            (scaled(up, 4.0 / reach), 0.0),
            (scaled(back, 0.5 / far), 0.5),
            ([0.0; 3], 1.0),
        ],
    };
    let mut matrix = [0.0; 16];
    for (r, (row, w)) in rows.into_iter().enumerate() {
        for c in 0..3 {
            matrix[c * 4 + r] = row[c];
        }
        matrix[12 + r] = w - dot(row, eye);
    }
    matrix
}
