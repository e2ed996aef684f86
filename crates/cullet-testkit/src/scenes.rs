//! Scenes of the engine.

use cullet::bounds::Aabb;
use cullet::{Instance, InstanceFlags, Scene, Transform, View, prepared::Preparation};

use crate::meshes::{blob, block, of_all_kinds, of_parts, one_sided, tetrahedron};
use crate::{Rng, soups};

/// So many boxes of up to `size`, in a cube of twice `reach`.
pub fn boxes(rng: &mut Rng, count: usize, reach: f64, size: f64) -> Vec<Aabb> {
    let mut one = || {
        let centre = rng.vector(reach);
        let half: [f64; 3] = std::array::from_fn(|_| rng.range(0.0, size * 0.5));
        let end = |sign: f64| std::array::from_fn(|a| (centre[a] + sign * half[a]) as f32);
        Aabb::new(end(-1.0), end(1.0))
    };
    (0..count).map(|_| one()).collect()
}

/// Turned, sheared, mirrored, of any size; now and then flattened.
pub fn random_transform(rng: &mut Rng) -> Transform {
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

/// So many instances of three blobs and a tetrahedron, prepared, in three layers.
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

fn mixed_transform(rng: &mut Rng) -> Transform {
    let mut number = |low: f64, high: f64| rng.range(low, high);
    let linear = std::array::from_fn(|_| std::array::from_fn(|_| number(-1.2, 1.2) as f32));
    let translation = std::array::from_fn(|_| number(-4.0, 4.0));
    let mut t = Transform { linear, translation };
    match rng.below(8) {
        0 => t.linear = Transform::IDENTITY.linear,
        1 => t.linear[2] = [0.0; 3],
        2 => t.linear = [[1.0, 2.0, 0.5], [0.0; 3], [0.0; 3]],
        3 => t.translation[0] = f64::NAN,
        _ => {}
    }
    t
}

/// A small scene for a renderer: a few meshes, of parts of every kind and alpha among them, and a few instances of each
/// kind, singular and not finite, doubled and removed.
pub fn mixed_scene(rng: &mut Rng) -> Scene {
    let mut scene = Scene::new();
    let meshes = [
        {
            let n = 1 + rng.below(30) as u32;
            of_all_kinds(rng, n)
        },
        {
            let n = 1 + rng.below(4) as u32;
            of_all_kinds(rng, n)
        },
        block([-1.0; 3], [1.0, 0.5, 1.5]),
        one_sided(soups::ball(6, 9)),
    ]
    .map(|m| scene.add_mesh(m));
    for _ in 0..1 + rng.below(9) {
        let flags = InstanceFlags {
            double_sided: rng.chance(0.15),
            transparent: rng.chance(0.15),
            ..InstanceFlags::default()
        };
        let mesh = meshes[rng.below(4) as usize];
        let layers = 1 + rng.below(3) as u32;
        let transform = mixed_transform(rng);
        let size_weight = match rng.below(20) {
            0 => f32::INFINITY,
            1 => rng.range(0.1, 9.0) as f32,
            _ => 1.0,
        };
        let instance = Instance { flags, layers, size_weight, ..Instance::new(mesh, transform) };
        let handle = scene.add(instance).unwrap();
        // The very same instance twice: every depth is a tie.
        if rng.chance(0.1) {
            scene.add(instance).unwrap();
        }
        if rng.chance(0.1) {
            scene.remove(handle).unwrap();
        }
    }
    scene
}

/// The same scene and view elsewhere in the world, and at another scale: near 1e7, tiny, or huge.
pub fn elsewhere(scene: &mut Scene, view: &View, rng: &mut Rng) -> View {
    let scale = [1.0, 1e-5, 1e5][rng.below(3) as usize];
    let shift: [f64; 3] = std::array::from_fn(|_| rng.range(-2e7, 2e7).round());
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
    let Ok(mut moved) = View::from_matrix(m, view.depth(), view.viewport()) else {
        return view.clone();
    };
    (moved.layers, moved.front_face, moved.cull_face) =
        (view.layers, view.front_face, view.cull_face);
    moved
}

/// The city of the occlusion studies in small: a grid of `n` × `n` buildings as boxes of `sub` × `sub`
/// quads a face, a ground, and `props` balls and boxes among them.
pub fn city(n: u32, sub: u32, props: u32) -> Scene {
    // The golden pictures show the city of this seed.
    let mut rng = Rng(0x41B0_026A_E1B5_BA63);
    let mut scene = Scene::new();
    let half = f64::from(n) * 12.0;
    let plane = |s: f32| {
        let p = vec![[-s, 0.0, -s], [s, 0.0, -s], [s, 0.0, s], [-s, 0.0, s]];
        of_parts((p, vec![0, 2, 1, 0, 3, 2]), Vec::new())
    };
    let ground = scene.add_mesh(plane(half as f32 + 200.0));
    scene.add(Instance::new(ground, Transform::IDENTITY)).unwrap();
    let building = scene.add_mesh(one_sided(soups::divided_block(sub)));
    for x in 0..n {
        for z in 0..n {
            let at = |v: u32| f64::from(v) * 24.0 - half + 12.0;
            let height = (6.0 - 14.0 * (1.0 - rng.unit()).ln()).min(120.0);
            let scale = [rng.range(5.0, 9.0) as f32, height as f32, rng.range(5.0, 9.0) as f32];
            let t = Transform::from_scale_translation(scale, [at(x), 0.0, at(z)]);
            scene.add(Instance::new(building, t)).unwrap();
        }
    }
    let prop = [
        scene.add_mesh(block([-1.0, 0.0, -1.0], [1.0, 2.0, 1.0])),
        scene.add_mesh(one_sided(soups::ball(5, 7))),
    ];
    for _ in 0..props {
        let s = rng.range(0.2, 1.0) as f32;
        let p = [rng.range(-half, half), f64::from(s), rng.range(-half, half)];
        let t = Transform::from_scale_translation([s; 3], p);
        let which = prop[rng.below(2) as usize];
        scene.add(Instance::new(which, t)).unwrap();
    }
    scene
}
