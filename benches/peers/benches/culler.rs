//! A frame through the culler, to each depth of its answer: `cargo bench --no-default-features --bench culler`, in `benches/peers`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use cullet::{Culler, Output, ViewState, Visible, prepared::Preparation};
use cullet_testkit::oracles::visible::visible_ref;
use cullet_testkit::scenes::city;
use cullet_testkit::views::look;
use cullet_testkit::{answers, at_every_level};

fn bench(c: &mut Criterion) {
    let mut scene = city(12, 3, 1000);
    scene.prepare(Preparation::ALL);
    let view = look([60.0, 30.0, 160.0], [0.0, 2.0, 0.0], [1280, 720]);
    let mut group = c.benchmark_group("culler");
    group.throughput(Throughput::Elements(u64::from(scene.instance_count())));
    for output in [Output::Instances, Output::Clusters, Output::Triangles] {
        let culler = Culler::default().with_output(output);
        let (mut state, mut visible) = (ViewState::default(), Visible::default());
        group.bench_function(format!("{output:?}").to_lowercase(), |b| {
            b.iter(|| culler.cull_one(&scene, &view, &mut state, &mut visible));
        });
        culler.cull_one(&scene, &view, &mut state, &mut visible);
        at_every_level!(|level| {
            let mut other = Visible::default();
            let culler = culler.clone().with_simd(level);
            culler.cull_one(&scene, &view, &mut ViewState::default(), &mut other);
            assert_eq!(answers::slots(&visible), answers::slots(&other));
        });
        if output == Output::Triangles {
            let listed = answers::listed(&visible);
            let missing = visible_ref(&scene, &view).into_iter().find(|t| !listed.contains(t));
            assert_eq!(missing, None, "slot and triangle");
        }
    }
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
