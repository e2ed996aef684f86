//! Frustum culling of 1e5 boxes and spheres, index list out, at every SIMD level:
//! `cargo bench --no-default-features --bench frustum`, in `benches/peers`. For figures against the machine's limit use `cullet bench`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use cullet::bounds::{Boxes, Side, Sphere, Spheres};
use cullet::cull::frustum::batch::{Indices, Planes, SpherePlanes, cull_boxes, cull_spheres};
use cullet_testkit::scenes::boxes;
use cullet_testkit::views::look;
use cullet_testkit::{Rng, at_every_level};

const ITEMS: usize = 100_000;

fn bench(c: &mut Criterion) {
    let boxes = boxes(&mut Rng(1), ITEMS, 1000.0, 10.0);
    let spheres: Vec<_> = boxes.iter().map(|b| Sphere { center: b.min, radius: 4.0 }).collect();
    let frustum = look([-400.0, 200.0, 500.0], [0.0; 3], [1600, 1000]).frustum();
    let (planes, sphere_planes) = (Planes::new(&frustum), SpherePlanes::new(&frustum));
    let numbers = 0..ITEMS as u32;
    let is_kept = |i: &u32| planes.classify_box(&boxes[*i as usize]) != Side::Outside;
    let kept: Vec<u32> = numbers.clone().filter(is_kept).collect();
    let is_kept = |i: &u32| !sphere_planes.rejects(&spheres[*i as usize]);
    let kept_spheres: Vec<u32> = numbers.filter(is_kept).collect();
    let (boxes, spheres) = (Boxes::from_slice(&boxes), Spheres::from_slice(&spheres));
    let mut visible = Indices::new();
    let mut group = c.benchmark_group("frustum");
    group.throughput(Throughput::Elements(ITEMS as u64));
    at_every_level!(|name, level| {
        group.bench_function(format!("boxes/{name}"), |b| {
            b.iter(|| cull_boxes(level, &planes, &boxes, &mut visible));
        });
        cull_boxes(level, &planes, &boxes, &mut visible);
        assert_eq!(*visible, kept);
        group.bench_function(format!("spheres/{name}"), |b| {
            b.iter(|| cull_spheres(level, &sphere_planes, &spheres, &mut visible));
        });
        cull_spheres(level, &sphere_planes, &spheres, &mut visible);
        assert_eq!(*visible, kept_spheres);
    });
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
