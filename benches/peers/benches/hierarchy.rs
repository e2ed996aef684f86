//! The hierarchy over 1e5 boxes: built and walked, with the flat sweep beside it:
//! `cargo bench --no-default-features --bench hierarchy`, in `benches/peers`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use cullet::cull::frustum::batch::{Indices, Planes, cull_boxes};
use cullet::cull::frustum::tree::Cut;
use cullet::hierarchy::Hierarchy;
use cullet_testkit::scenes::boxes;
use cullet_testkit::views::look;
use cullet_testkit::{Rng, at_every_level};

const ITEMS: usize = 100_000;

fn bench(c: &mut Criterion) {
    let items = boxes(&mut Rng(1), ITEMS, 1000.0, 10.0);
    let (hierarchy, _) = Hierarchy::build(&items).expect("few");
    hierarchy.validate().expect("valid");
    let (nodes, boxes) = (hierarchy.nodes(), hierarchy.boxes());
    let frustum = look([-400.0, 200.0, 500.0], [0.0; 3], [1600, 1000]).frustum();
    let planes = Planes::new(&frustum);
    let mut group = c.benchmark_group("hierarchy");
    group.throughput(Throughput::Elements(ITEMS as u64));
    group.sample_size(10);
    group.bench_function("build", |b| b.iter(|| Hierarchy::build(&items)));
    group.sample_size(100);
    at_every_level!(|name, level| {
        let (mut swept, mut listed) = (Indices::new(), Indices::new());
        group.bench_function(format!("sweep/{name}"), |b| {
            b.iter(|| cull_boxes(level, &planes, boxes, &mut swept));
        });
        let mut cut = Cut::new();
        group.bench_function(format!("walk/{name}"), |b| {
            b.iter(|| cut.cull(level, &planes, nodes, boxes));
        });
        cull_boxes(level, &planes, boxes, &mut swept);
        cut.cull(level, &planes, nodes, boxes);
        cut.list(level, &mut listed);
        assert_eq!(*listed, *swept);
    });
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
