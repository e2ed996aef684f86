//! Frustum culling of 1e5 boxes and spheres, index list out, at every SIMD level:
//! `cargo bench -p cullet --bench frustum_batch`. For figures against the machine's limit use
//! `cullet bench`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use cullet::bounds::{Aabb, Boxes, Sphere, Spheres};
use cullet::cull::frustum::batch::{
    Indices, Planes, cull_boxes, cull_boxes_ref, cull_spheres, cull_spheres_ref, levels,
};
use cullet::{Camera, Projection};

const ITEMS: usize = 100_000;

fn boxes() -> Vec<Aabb> {
    let mut state = 0x1234_5678_9abc_def1_u64;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 40) as f32 / (1 << 24) as f32
    };
    let mut one = || {
        let min: [f32; 3] = std::array::from_fn(|_| next() * 2000.0 - 1000.0);
        Aabb::new(min, min.map(|v| v + 5.0))
    };
    (0..ITEMS).map(|_| one()).collect()
}

fn planes() -> Planes {
    let projection =
        Projection::Perspective { fov_y_radians: 1.0, aspect: 1.6, near: 0.1, far: 1e4 };
    let camera = Camera::look_at([-400.0, 200.0, 500.0], [0.0; 3], projection);
    Planes::new(&camera.frustum().expect("a plain perspective"))
}

fn bench(c: &mut Criterion) {
    let boxes = boxes();
    let spheres: Vec<_> = boxes.iter().map(|b| Sphere { center: b.min, radius: 4.0 }).collect();
    let (boxes, spheres) = (Boxes::from_slice(&boxes), Spheres::from_slice(&spheres));
    let planes = planes();
    let mut visible = Indices::new();
    let mut group = c.benchmark_group("frustum");
    group.throughput(Throughput::Elements(ITEMS as u64));
    for (name, level) in levels() {
        group.bench_function(format!("boxes/{name}"), |b| {
            b.iter(|| cull_boxes(level, &planes, &boxes, &mut visible));
        });
        assert_eq!(*visible, *cull_boxes_ref(&planes, &boxes), "boxes at {name}");
        group.bench_function(format!("spheres/{name}"), |b| {
            b.iter(|| cull_spheres(level, &planes, &spheres, &mut visible));
        });
        assert_eq!(*visible, *cull_spheres_ref(&planes, &spheres), "spheres at {name}");
    }
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
