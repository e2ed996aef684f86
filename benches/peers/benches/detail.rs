//! Projected bounds of 1e4 boxes, and which of them are too small: `cargo bench --no-default-features --bench detail`, in `benches/peers`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use cullet::bounds::Aabb;
use cullet::cull::detail::{Detail, Measure};
use cullet_testkit::Rng;
use cullet_testkit::scenes::boxes;
use cullet_testkit::views::look;

const ITEMS: usize = 10_000;

fn bench(c: &mut Criterion) {
    let boxes = boxes(&mut Rng(1), ITEMS, 300.0, 10.0);
    let view = look([0.0, 20.0, 500.0], [0.0; 3], [1280, 720]);
    let detail = Detail::default().with_measure(Measure::WidthAndHeight).with_threshold_px(4.0);
    let is_small = |b: &Aabb| detail.is_small(view.project_box(b, [0.0; 3]).as_ref());
    let mut group = c.benchmark_group("detail");
    group.throughput(Throughput::Elements(ITEMS as u64));
    group.bench_function("boxes", |b| b.iter(|| boxes.iter().filter(|b| is_small(b)).count()));
    group.finish();

    // Its corners alone: what is dropped is small, and what is well below the threshold is dropped.
    let mut dropped = 0;
    for b in &boxes {
        let corners = b.corners().map(|c| view.project_point(c.map(f64::from)));
        let extent = corners.iter().copied().collect::<Option<Vec<_>>>().map(|corners| {
            [0, 1].map(|a| {
                let values = corners.iter().map(|p| p[a]);
                values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
            })
        });
        let largest = extent.map_or(f64::INFINITY, |e| e[0].max(e[1]));
        assert!(if is_small(b) { largest < 4.0 } else { largest > 3.99 }, "{b:?}: {largest}");
        dropped += usize::from(is_small(b));
    }
    assert!(dropped > ITEMS / 50 && dropped < ITEMS / 2, "{dropped}");
}

criterion_group!(benches, bench);
criterion_main!(benches);
