//! Small scenes for the tests.
#![allow(dead_code, reason = "each test file uses some of these")]

use cullet::mesh::{Alpha, Part};
use cullet::{
    Camera, Depth, Instance, InstanceFlags, Mesh, MeshData, Projection, Reason, Scene, Stage,
    Transform, TriangleRange, View, Visible,
};

/// A generator of numbers that is the same everywhere.
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0x1234_5678_9ABC_DEF0)
    }

    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub(crate) fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub(crate) fn below(&mut self, n: u64) -> u64 {
        self.bits() % n
    }

    pub(crate) fn chance(&mut self, p: f64) -> bool {
        self.unit() < p
    }
}

pub(crate) fn mesh(positions: Vec<[f32; 3]>, indices: Vec<u32>, parts: Vec<Part>) -> Mesh {
    Mesh::new(MeshData { positions, indices, parts, ..MeshData::default() }).unwrap()
}

/// The box from `low` to `high`, wound outward, one-sided.
pub(crate) fn cuboid(low: [f32; 3], high: [f32; 3]) -> Mesh {
    let positions: Vec<[f32; 3]> = (0..8)
        .map(|i: usize| std::array::from_fn(|a| if i >> a & 1 == 1 { high[a] } else { low[a] }))
        .collect();
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let indices: Vec<u32> = quads.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect();
    let part = Part { triangle_count: 12, ..Part::default() };
    mesh(positions, indices, vec![part])
}

/// A ball of latitude and longitude, wound outward, one-sided.
pub(crate) fn ball(rings: u32, sides: u32) -> Mesh {
    let mut positions = vec![[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]];
    for r in 1..rings {
        let (s, c) = (std::f64::consts::PI * f64::from(r) / f64::from(rings)).sin_cos();
        for k in 0..sides {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / f64::from(sides)).sin_cos();
            positions.push([(s * cos) as f32, c as f32, (s * sin) as f32]);
        }
    }
    let at = |r: u32, k: u32| 2 + (r - 1) * sides + k % sides;
    let mut indices = Vec::new();
    for k in 0..sides {
        indices.extend([0, at(1, k + 1), at(1, k)]);
        indices.extend([1, at(rings - 1, k), at(rings - 1, k + 1)]);
        for r in 1..rings - 1 {
            let [a, b, c, d] = [at(r, k), at(r, k + 1), at(r + 1, k), at(r + 1, k + 1)];
            indices.extend([a, b, c, b, d, c]);
        }
    }
    let part = Part { triangle_count: indices.len() as u32 / 3, ..Part::default() };
    mesh(positions, indices, vec![part])
}

/// Triangles anywhere, in parts of every kind, some of them sharing edges, some without area.
pub(crate) fn soup(random: &mut Random, triangles: u32) -> Mesh {
    let vertices = triangles + 2;
    let grid = random.chance(0.3);
    let positions = (0..vertices)
        .map(|_| {
            std::array::from_fn(|_| {
                let v = random.range(-3.0, 3.0);
                // On a coarse grid, edges meet samples and planes meet planes.
                (if grid { (v * 2.0).round() * 0.5 } else { v }) as f32
            })
        })
        .collect();
    let indices: Vec<u32> =
        (0..triangles * 3).map(|_| random.below(u64::from(vertices)) as u32).collect();
    let mut parts = Vec::new();
    let mut first = 0;
    while first < triangles {
        let count = (1 + random.below(5) as u32).min(triangles - first);
        parts.push(Part {
            first_triangle: first,
            triangle_count: count,
            material: parts.len() as u32,
            two_sided: random.chance(0.5),
            alpha: [Alpha::Opaque, Alpha::Opaque, Alpha::Masked, Alpha::Blended]
                [random.below(4) as usize],
        });
        first += count;
    }
    mesh(positions, indices, parts)
}

pub(crate) fn transform(random: &mut Random) -> Transform {
    let mut number = |low: f64, high: f64| random.range(low, high);
    let linear = std::array::from_fn(|_| std::array::from_fn(|_| number(-1.2, 1.2) as f32));
    let translation = std::array::from_fn(|_| number(-4.0, 4.0));
    let mut t = Transform { linear, translation };
    match random.below(8) {
        0 => t.linear = Transform::IDENTITY.linear,
        1 => t.linear[2] = [0.0; 3],
        2 => t.linear = [[1.0, 2.0, 0.5], [0.0; 3], [0.0; 3]],
        3 => t.translation[0] = f64::NAN,
        _ => {}
    }
    t
}

/// A view of one of every kind.
pub(crate) fn view(random: &mut Random, viewport: [u32; 2]) -> View {
    let mut number = |low: f64, high: f64| random.range(low, high);
    let eye = [number(-4.0, 4.0), number(-4.0, 4.0), number(-4.0, 4.0)];
    let target = [number(-1.0, 1.0), number(-1.0, 1.0), number(-1.0, 1.0)];
    let aspect = f64::from(viewport[0]) / f64::from(viewport[1]);
    let (near, size) = (number(0.01, 1.0), number(0.3, 4.0));
    let projection = match random.below(5) {
        0 => Projection::Orthographic {
            left: -size * aspect,
            right: size * aspect,
            bottom: -size,
            top: size,
            near: -5.0,
            far: 9.0,
        },
        1 => Projection::OffCentre {
            left: -0.3 * near,
            right: 1.1 * near,
            bottom: -0.2 * near,
            top: 0.9 * near,
            near,
            far: 12.0,
        },
        // Mirrored.
        2 => Projection::OffCentre {
            left: near,
            right: -near,
            bottom: -near,
            top: near,
            near,
            far: f64::INFINITY,
        },
        kind => Projection::Perspective {
            fov_y_radians: size * 0.5,
            aspect,
            near,
            far: if kind == 3 { f64::INFINITY } else { 8.0 },
        },
    };
    let depth = if random.chance(0.5) { Depth::Standard } else { Depth::Reversed };
    let mut view = View::new(&Camera::look_at(eye, target, projection), depth, viewport).unwrap();
    view.front_face = if random.chance(0.8) {
        cullet::FrontFace::CounterClockwise
    } else {
        cullet::FrontFace::Clockwise
    };
    view.cull_face = match random.below(6) {
        0 => cullet::CullFace::None,
        1 => cullet::CullFace::Front,
        _ => cullet::CullFace::Back,
    };
    view.layers = if random.chance(0.2) { 2 } else { u32::MAX };
    view
}

/// A few meshes, a few instances of each kind.
pub(crate) fn scene(random: &mut Random) -> Scene {
    let mut scene = Scene::new();
    let meshes = [
        {
            let n = 1 + random.below(30) as u32;
            soup(random, n)
        },
        {
            let n = 1 + random.below(4) as u32;
            soup(random, n)
        },
        cuboid([-1.0; 3], [1.0, 0.5, 1.5]),
        ball(6, 9),
    ]
    .map(|m| scene.add_mesh(m));
    for _ in 0..1 + random.below(9) {
        let flags = InstanceFlags {
            double_sided: random.chance(0.15),
            transparent: random.chance(0.15),
            ..InstanceFlags::default()
        };
        let mesh = meshes[random.below(4) as usize];
        let layers = 1 + random.below(3) as u32;
        let transform = transform(random);
        let instance = Instance { flags, layers, ..Instance::new(mesh, transform) };
        let handle = scene.add(instance).unwrap();
        // The very same thing twice: every depth is a tie.
        if random.chance(0.1) {
            scene.add(instance).unwrap();
        }
        if random.chance(0.1) {
            scene.remove(handle).unwrap();
        }
    }
    scene
}

/// The same scene and view elsewhere in the world, and at another scale: near 1e7, tiny, or huge.
pub(crate) fn elsewhere(scene: &mut Scene, view: &View, random: &mut Random) -> View {
    let scale = [1.0, 1e-5, 1e5][random.below(3) as usize];
    let shift: [f64; 3] = std::array::from_fn(|_| random.range(-2e7, 2e7).round());
    for slot in 0..scene.slot_count() {
        let Some(handle) = scene.handle(slot) else { continue };
        let mut t = *scene.transform(slot);
        t.linear = t.linear.map(|c| c.map(|v| v * scale as f32));
        t.translation = std::array::from_fn(|a| t.translation[a] * scale + shift[a]);
        scene.set_transform(handle, t).unwrap();
    }
    let mut m = view.clip_from_world();
    m[..12].iter_mut().for_each(|v| *v /= scale);
    for row in 0..4 {
        m[12 + row] -= (0..3).map(|c| m[c * 4 + row] * shift[c]).sum::<f64>();
    }
    let Ok(mut moved) = View::from_matrix(&m, view.depth(), view.viewport()) else {
        return view.clone();
    };
    (moved.layers, moved.front_face, moved.cull_face) =
        (view.layers, view.front_face, view.cull_face);
    moved
}

/// A perspective view with +Y up.
pub(crate) fn look(eye: [f64; 3], target: [f64; 3], viewport: [u32; 2]) -> View {
    let projection = Projection::Perspective {
        fov_y_radians: 60f64.to_radians(),
        aspect: f64::from(viewport[0]) / f64::from(viewport[1]),
        near: 0.5,
        far: 6000.0,
    };
    View::new(&Camera::look_at(eye, target, projection), Depth::Standard, viewport).unwrap()
}

/// The city of the occlusion studies in small: a grid of `n` × `n` buildings as boxes of `sub` × `sub`
/// quads a face, a ground, and `props` balls and boxes among them.
pub(crate) fn city(n: u32, sub: u32, props: u32) -> Scene {
    let mut random = Random::new(7);
    let mut scene = Scene::new();
    let half = f64::from(n) * 12.0;
    let plane = |s: f32| {
        let p = vec![[-s, 0.0, -s], [s, 0.0, -s], [s, 0.0, s], [-s, 0.0, s]];
        mesh(p, vec![0, 2, 1, 0, 3, 2], Vec::new())
    };
    let ground = scene.add_mesh(plane(half as f32 + 200.0));
    scene.add(Instance::new(ground, Transform::IDENTITY)).unwrap();
    let building = scene.add_mesh(divided(sub));
    for x in 0..n {
        for z in 0..n {
            let at = |v: u32| f64::from(v) * 24.0 - half + 12.0;
            let height = (6.0 - 14.0 * (1.0 - random.unit()).ln()).min(120.0);
            let scale =
                [random.range(5.0, 9.0) as f32, height as f32, random.range(5.0, 9.0) as f32];
            let t = Transform::from_scale_translation(scale, [at(x), 0.0, at(z)]);
            scene.add(Instance::new(building, t)).unwrap();
        }
    }
    let prop =
        [scene.add_mesh(cuboid([-1.0, 0.0, -1.0], [1.0, 2.0, 1.0])), scene.add_mesh(ball(5, 7))];
    for _ in 0..props {
        let s = random.range(0.2, 1.0) as f32;
        let p = [random.range(-half, half), f64::from(s), random.range(-half, half)];
        let t = Transform::from_scale_translation([s; 3], p);
        let which = prop[random.below(2) as usize];
        scene.add(Instance::new(which, t)).unwrap();
    }
    scene
}

/// A box from (−1, 0, −1) to (1, 1, 1), its faces cut into `sub` × `sub` quads.
fn divided(sub: u32) -> Mesh {
    let mut positions: Vec<[f32; 3]> = Vec::new();
    let mut indices = Vec::new();
    for (axis, side) in (0..6).map(|f| (f / 2, f % 2)) {
        let first = positions.len() as u32;
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for i in 0..=sub {
            for j in 0..=sub {
                let mut p = [0.0; 3];
                p[axis] = side as f32 * 2.0 - 1.0;
                p[u] = i as f32 / sub as f32 * 2.0 - 1.0;
                p[v] = j as f32 / sub as f32 * 2.0 - 1.0;
                p[1] = p[1] * 0.5 + 0.5;
                positions.push(p);
            }
        }
        let at = |i: u32, j: u32| first + i * (sub + 1) + j;
        for i in 0..sub {
            for j in 0..sub {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                let quad = if side == 1 { [a, b, c, a, c, d] } else { [a, c, b, a, d, c] };
                indices.extend(quad);
            }
        }
    }
    let part = Part { triangle_count: indices.len() as u32 / 3, ..Part::default() };
    mesh(positions, indices, vec![part])
}

/// A visible set as a frustum and back-face culler would make it, by the plainest of means.
pub(crate) fn frustum_kept(scene: &Scene, view: &View) -> Visible {
    let frustum = view.frustum();
    let mut visible = Visible::default();
    for slot in 0..scene.slot_count() {
        let b = scene.bounds(slot);
        let outside = cullet::view::FrustumPlane::ALL.into_iter().position(|plane| {
            frustum.plane(plane).is_some_and(|plane| {
                b.corners().iter().all(|c| plane.distance(c.map(f64::from)) > 1e-3)
            })
        });
        let small =
            view.project_box(&b, scene.origin()).is_some_and(|r| r.width().max(r.height()) < 2.0);
        let reason = match outside {
            Some(plane) => Some(Reason { stage: Stage::Frustum, detail: plane as u8 }),
            None => small.then_some(Reason { stage: Stage::Detail, detail: 0 }),
        };
        visible.reasons.push(reason);
        if reason.is_none() {
            let first = visible.triangles.len() as u32;
            let mesh = scene.mesh(slot);
            let t = scene.transform(slot);
            let eye = view.eye();
            let facing = |&i: &u32| {
                let [a, b, c] = mesh.corners(i).map(|p| {
                    std::array::from_fn::<f64, 3, _>(|r| {
                        (0..3).map(|k| f64::from(t.linear[k][r]) * f64::from(p[k])).sum::<f64>()
                            + t.translation[r]
                    })
                });
                let plane = cullet::bounds::Plane::from_points(a, b, c);
                mesh.parts()[0].two_sided
                    || plane.is_none_or(|p| p.distance([eye[0], eye[1], eye[2]]) > -1e-9)
            };
            visible.triangles.extend((0..mesh.triangle_count()).filter(facing));
            let count = visible.triangles.len() as u32 - first;
            visible.triangle_ranges.push(TriangleRange { slot, first, count });
        }
    }
    visible
}
