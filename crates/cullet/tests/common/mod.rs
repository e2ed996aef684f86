//! Random scenes and views, and an oracle of what a view can see, shared by the tests.
#![allow(dead_code, unreachable_pub, reason = "each test uses a part of it")]

use std::collections::BTreeSet;

use cullet::bounds::{Aabb, Plane};
use cullet::cull::detail::{Detail, Measure};
use cullet::cull::frustum::batch::Planes;
use cullet::cull::occlusion::Occlusion;
use cullet::mesh::Part;
use cullet::{
    Backface, Camera, CullFace, Culler, Depth, FrontFace, Frustum, Instance, Level, Mesh, MeshData,
    Preparation, Projection, Scene, Transform, View, Visible,
};

/// `SplitMix64`.
pub struct Rng(pub u64);

impl Rng {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }

    /// Uniform in low..high.
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }

    pub fn vector(&mut self, size: f64) -> [f64; 3] {
        std::array::from_fn(|_| self.range(-size, size))
    }
}

/// Every SIMD level of this machine, best last; the scalar one where it was compiled in.
pub fn levels() -> Vec<Level> {
    let mut levels = Vec::new();
    #[cfg(feature = "force_support_fallback")]
    levels.push(Level::fallback());
    let best = Level::new();
    #[cfg(target_arch = "x86_64")]
    {
        levels.extend(best.as_sse2().map(Level::Sse2));
        levels.extend(best.as_sse4_2().map(Level::Sse4_2));
        levels.extend(best.as_avx2().map(Level::Avx2));
    }
    levels.push(best);
    levels
}

pub fn tetrahedron() -> Mesh {
    Mesh::new(MeshData {
        positions: vec![[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0]],
        indices: vec![0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3],
        parts: vec![Part { triangle_count: 4, ..Part::default() }],
        ..MeshData::default()
    })
    .expect("a good mesh")
}

/// A bumpy sphere of some hundred triangles, one-sided or not, sometimes with degenerate triangles.
pub fn blob(rng: &mut Rng) -> Mesh {
    let (rings, segments) = (6 + rng.below(8) as u32, 6 + rng.below(10) as u32);
    let mut positions = Vec::new();
    for i in 0..=rings {
        for j in 0..segments {
            let (a, b) = (
                std::f64::consts::PI * f64::from(i) / f64::from(rings),
                std::f64::consts::TAU * f64::from(j) / f64::from(segments),
            );
            let r = rng.range(0.8, 1.2);
            positions.push(
                [r * a.sin() * b.cos(), r * a.cos(), r * a.sin() * b.sin()].map(|v| v as f32),
            );
        }
    }
    let mut indices = Vec::new();
    for i in 0..rings {
        for j in 0..segments {
            let k = (j + 1) % segments;
            let (a, b) = (i * segments + j, i * segments + k);
            let (c, d) = (a + segments, b + segments);
            indices.extend([a, b, c, b, d, c]);
        }
    }
    if rng.below(3) == 0 {
        indices.extend([0, 0, 1, 2, 3, 2]);
    }
    let triangles = (indices.len() / 3) as u32;
    let half = triangles / 2;
    let parts = vec![
        Part { triangle_count: half, two_sided: rng.below(3) == 0, ..Part::default() },
        Part {
            first_triangle: half,
            triangle_count: triangles - half,
            material: 1,
            two_sided: rng.below(3) == 0,
            ..Part::default()
        },
    ];
    Mesh::new(MeshData { positions, indices, parts, ..MeshData::default() }).expect("a good mesh")
}

/// A one-sided ball of `rings` × 2 `rings` quads, of many clusters.
pub fn ball(rings: u32) -> Mesh {
    let around = rings * 2;
    let at = |i: u32, j: u32| i * around + j % around;
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for i in 0..=rings {
        for j in 0..around {
            let a = std::f64::consts::PI * f64::from(i) / f64::from(rings);
            let b = std::f64::consts::TAU * f64::from(j) / f64::from(around);
            let p = [a.sin() * b.sin(), a.cos(), a.sin() * b.cos()];
            positions.push(p.map(|v| v as f32));
            if i < rings {
                let [p, q, r, s] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
                indices.extend([p, s, q, q, s, r]);
            }
        }
    }
    let triangle_count = (indices.len() / 3) as u32;
    let parts = vec![Part { triangle_count, ..Part::default() }];
    Mesh::new(MeshData { positions, indices, parts, ..MeshData::default() }).expect("a good mesh")
}

fn random_transform(rng: &mut Rng) -> Transform {
    let size = 10f64.powf(rng.range(-1.0, 0.7));
    let mut t = Transform {
        linear: std::array::from_fn(|_| rng.vector(size).map(|v| v as f32)),
        translation: rng.vector(12.0),
    };
    match rng.below(12) {
        0 => t.linear[1] = t.linear[0],
        1 => t.linear[2] = [0.0; 3],
        2 => t.linear[2] = t.linear[2].map(|v| v * 1e-6),
        _ => {}
    }
    t
}

pub fn random_scene(rng: &mut Rng, instances: usize) -> Scene {
    let mut scene = Scene::new();
    for _ in 0..3 {
        scene.add_mesh(blob(rng));
    }
    scene.add_mesh(tetrahedron());
    scene.prepare(Preparation::ALL);
    for _ in 0..instances {
        let mesh = rng.below(4) as u32;
        let mut instance = Instance::new(mesh, random_transform(rng));
        instance.flags.double_sided = rng.below(6) == 0;
        instance.layers = 1 << rng.below(3);
        scene.add(instance).expect("the mesh exists");
    }
    scene
}

fn random_camera(rng: &mut Rng) -> Camera {
    let far = match rng.below(3) {
        0 => f64::INFINITY,
        _ => rng.range(5.0, 60.0),
    };
    let near = 10f64.powf(rng.range(-2.0, 0.5));
    let (w, h) = (near * rng.range(0.2, 2.0), near * rng.range(0.2, 2.0));
    let (x, y) = (w * rng.range(-0.5, 0.5), h * rng.range(-0.5, 0.5));
    let projection = match rng.below(3) {
        0 => Projection::Perspective {
            fov_y_radians: rng.range(0.1, 2.5),
            aspect: rng.range(0.3, 3.0),
            near,
            far,
        },
        1 => Projection::OffCentre {
            left: x - w,
            right: x + w,
            bottom: y - h,
            top: y + h,
            near,
            far,
        },
        _ => {
            let (w, h) = (rng.range(1.0, 15.0), rng.range(1.0, 15.0));
            Projection::Orthographic {
                left: -w,
                right: w * 0.7,
                bottom: -h,
                top: h * 0.8,
                near: rng.range(-5.0, 1.0),
                far: rng.range(5.0, 40.0),
            }
        }
    };
    Camera { eye: rng.vector(14.0), direction: rng.vector(1.0), up: rng.vector(1.0), projection }
}

fn dress(mut view: View, choice: u64) -> View {
    view.front_face =
        if choice & 1 == 0 { FrontFace::CounterClockwise } else { FrontFace::Clockwise };
    view.cull_face = [CullFace::Back, CullFace::Back, CullFace::Front, CullFace::None]
        [(choice >> 1) as usize % 4];
    view.layers = if choice >> 3 & 3 == 0 { 3 } else { u32::MAX };
    view
}

fn depth(choice: u64) -> Depth {
    if choice >> 8 & 1 == 0 { Depth::Standard } else { Depth::Reversed }
}

/// A view of any kind: a third of them mirrored.
pub fn random_view(rng: &mut Rng) -> View {
    let choice = rng.next();
    let camera = random_camera(rng);
    let view = View::new(&camera, depth(choice), [640, 480]).expect("a good camera");
    if choice.is_multiple_of(3) {
        let mut m = view.clip_from_world();
        (0..4).for_each(|c| m[c * 4] = -m[c * 4]);
        let mirrored = View::from_matrix(&m, depth(choice), [640, 480]).expect("a good matrix");
        return dress(mirrored, choice >> 16);
    }
    dress(view, choice >> 16)
}

/// A view, and the same one moved by `offset`.
pub fn view_and_moved(rng: &mut Rng, offset: [f64; 3]) -> (View, View) {
    let choice = rng.next();
    let camera = random_camera(rng);
    let moved = Camera { eye: std::array::from_fn(|a| camera.eye[a] + offset[a]), ..camera };
    let make = |c: &Camera| {
        dress(View::new(c, depth(choice), [640, 480]).expect("a good camera"), choice >> 16)
    };
    (make(&camera), make(&moved))
}

pub fn looking_down_z() -> View {
    let projection =
        Projection::Perspective { fov_y_radians: 1.0, aspect: 1.0, near: 0.1, far: 100.0 };
    let camera = Camera::look_at([0.0; 3], [0.0, 0.0, -1.0], projection);
    View::new(&camera, Depth::Standard, [100, 100]).expect("a good camera")
}

/// All slots of an answer, as they come.
pub fn slots(v: &Visible) -> Vec<u32> {
    let mut slots: Vec<u32> = v.whole.iter().flat_map(|r| r.first..r.first + r.count).collect();
    let mut partial: Vec<u32> = v.partial.iter().map(|d| d.slot).collect();
    partial.dedup();
    slots.extend(partial);
    slots.sort_unstable();
    slots
}

pub fn listed_in_order(v: &Visible) -> Vec<(u32, u32)> {
    v.triangle_ranges
        .iter()
        .flat_map(|r| {
            v.triangles[r.first as usize..(r.first + r.count) as usize].iter().map(|&t| (r.slot, t))
        })
        .collect()
}

pub fn listed(v: &Visible) -> BTreeSet<(u32, u32)> {
    listed_in_order(v).into_iter().collect()
}

/// What a view can see, hidden surfaces included: triangles (in the order of their mesh) that face it
/// and of which a piece is left after clipping in clip space, by a margin that makes it beyond doubt.
pub fn visible_ref(scene: &Scene, view: &View) -> Vec<(u32, u32)> {
    let m = view.clip_from_world();
    let mut seen = Vec::new();
    for slot in scene.slots() {
        if scene.layers(slot) & view.layers == 0 {
            continue;
        }
        let mesh = scene.mesh(slot);
        let t = scene.transform(slot).to_matrix();
        let mirrored = (scene.transform(slot).determinant() < 0.0) != view.is_mirrored();
        for triangle in 0..mesh.triangle_count() {
            let corners = mesh.corners(triangle).map(|p| {
                let p = p.map(f64::from);
                let world = multiply(&t, [p[0], p[1], p[2], 1.0]);
                multiply(&m, world)
            });
            let original = mesh.original_triangle()[triangle as usize];
            let part = mesh
                .parts()
                .iter()
                .find(|p| {
                    (p.first_triangle..p.first_triangle + p.triangle_count).contains(&original)
                })
                .expect("every triangle has a part");
            let one_sided = !part.two_sided && !scene.flags(slot).double_sided;
            let [a, b, c] = corners.map(|v| [v[0], v[1], v[3]]);
            let det = a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
                + a[2] * (b[0] * c[1] - b[1] * c[0]);
            let counter_clockwise = (det > 0.0) != mirrored;
            let front = counter_clockwise == (view.front_face == FrontFace::CounterClockwise);
            let culled = match view.cull_face {
                CullFace::None => false,
                CullFace::Back => !front,
                CullFace::Front => front,
            };
            let size: f64 = corners.iter().flatten().map(|v| v.abs()).sum();
            if det.abs() > size * size * size * 1e-9
                && !(one_sided && culled)
                && survives_clipping(&corners, size * 1e-6)
            {
                seen.push((slot, triangle));
            }
        }
    }
    seen
}

fn multiply(m: &[f64; 16], v: [f64; 4]) -> [f64; 4] {
    std::array::from_fn(|r| (0..4).map(|c| m[c * 4 + r] * v[c]).sum())
}

/// Sutherland–Hodgman against |x| ≤ w, |y| ≤ w, 0 ≤ z ≤ w, each moved inward by `margin`.
fn survives_clipping(triangle: &[[f64; 4]; 3], margin: f64) -> bool {
    let mut polygon = triangle.to_vec();
    let planes: [fn([f64; 4]) -> f64; 6] = [
        |v| v[3] + v[0],
        |v| v[3] - v[0],
        |v| v[3] + v[1],
        |v| v[3] - v[1],
        |v| v[2],
        |v| v[3] - v[2],
    ];
    for plane in planes {
        let mut next = Vec::new();
        for i in 0..polygon.len() {
            let (p, q) = (polygon[i], polygon[(i + 1) % polygon.len()]);
            let (dp, dq) = (plane(p) - margin, plane(q) - margin);
            if dp >= 0.0 {
                next.push(p);
            }
            if (dp >= 0.0) != (dq >= 0.0) {
                let t = dp / (dp - dq);
                next.push(std::array::from_fn(|k| p[k] + (q[k] - p[k]) * t));
            }
        }
        polygon = next;
    }
    polygon.len() >= 3
}

/// A box of any kind: mostly plain, sometimes one that is no box.
pub fn random_box(rng: &mut Rng) -> Aabb {
    let centre = rng.vector(100.0).map(|v| v as f32);
    let half = rng.range(0.0, 6.0) as f32;
    let mut b = Aabb::new(centre.map(|c| c - half), centre.map(|c| c + half));
    match rng.below(60) {
        0 => b = Aabb::EMPTY,
        1 => b.min[1] = f32::NAN,
        2 => b = Aabb::EVERYTHING,
        3 => b.min[0] = b.max[0] + 1.0,
        4 => b.max[2] = f32::INFINITY,
        5 => b = Aabb::new([1e30; 3], [2e30; 3]),
        6 => b = Aabb::new(centre, centre),
        _ => {}
    }
    b
}

/// Planes of a view, of a region of up to 32 planes, or none.
pub fn random_planes(rng: &mut Rng) -> Planes {
    if rng.below(2) == 0 {
        return Planes::new(&random_view(rng).frustum());
    }
    let mut frustum = Frustum::everything();
    for _ in 0..rng.below(33) {
        let normal = rng.vector(1.0);
        let _ = frustum.push(Plane::new(normal, rng.range(-20.0, 120.0)));
    }
    Planes::new(&frustum)
}

/// Every stage on or off, in every way.
pub fn random_culler(rng: &mut Rng) -> Culler {
    let detail = Detail { measure: Measure::WidthAndHeight, threshold_px: rng.range(1.0, 60.0) };
    Culler {
        frustum: rng.below(6) > 0,
        frustum_exact: rng.below(3) == 0,
        backface: [Backface::Off, Backface::Fast, Backface::Masks, Backface::Exact]
            [rng.below(4) as usize],
        degenerate: rng.below(5) > 0,
        detail: (rng.below(3) == 0).then_some(detail),
        occlusion: (rng.below(2) == 0).then(Occlusion::default),
        ..Culler::default()
    }
}
