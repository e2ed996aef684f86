//! Frustum culling of 1e5 boxes and spheres, index list out, at every SIMD level:
//! `cargo bench --no-default-features --bench frustum`, in `benches/peers`. For figures against the machine's limit use `cullet bench`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use cullet::bounds::{Boxes, Sphere, Spheres};
use cullet::cull::frustum::batch::{
    Indices, Planes, cull_boxes, cull_boxes_ref, cull_spheres, cull_spheres_ref,
};
use cullet_testkit::scenes::boxes;
use cullet_testkit::views::look;
use cullet_testkit::{Rng, at_every_level};

const ITEMS: usize = 100_000;

fn bench(c: &mut Criterion) {
    let boxes = boxes(&mut Rng(1), ITEMS, 1000.0, 10.0);
    let spheres: Vec<_> = boxes.iter().map(|b| Sphere { center: b.min, radius: 4.0 }).collect();
    let (boxes, spheres) = (Boxes::from_slice(&boxes), Spheres::from_slice(&spheres));
    let planes = Planes::new(&look([-400.0, 200.0, 500.0], [0.0; 3], [1600, 1000]).frustum());
    let mut visible = Indices::new();
    let mut group = c.benchmark_group("frustum");
    group.throughput(Throughput::Elements(ITEMS as u64));
    at_every_level!(|name, level| {
        group.bench_function(format!("boxes/{name}"), |b| {
            b.iter(|| cull_boxes(level, &planes, &boxes, &mut visible));
        });
        cull_boxes(level, &planes, &boxes, &mut visible);
        assert_eq!(*visible, *cull_boxes_ref(&planes, &boxes));
        group.bench_function(format!("spheres/{name}"), |b| {
            b.iter(|| cull_spheres(level, &planes, &spheres, &mut visible));
        });
        cull_spheres(level, &planes, &spheres, &mut visible);
        assert_eq!(*visible, *cull_spheres_ref(&planes, &spheres));
    });
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
