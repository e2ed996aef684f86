//! An answer as draws: a cull of a city beside the arrays that are made of its answer:
//! `cargo bench --no-default-features --bench draws`, in `benches/peers`.

use std::collections::BTreeSet;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use cullet::{Culler, DrawList, Output, Scene, ViewState, Visible, prepared::Preparation};
use cullet_testkit::answers;
use cullet_testkit::scenes::city;
use cullet_testkit::views::look;

/// Slots that some command draws.
fn drawn(draws: &DrawList) -> BTreeSet<u32> {
    let ranges =
        draws.commands.iter().map(|c| c.first_instance..c.first_instance + c.instance_count);
    ranges.flatten().map(|i| draws.instances[i as usize]).collect()
}

/// Indices that all commands draw.
fn indices(draws: &DrawList) -> u64 {
    draws.commands.iter().map(|c| u64::from(c.index_count) * u64::from(c.instance_count)).sum()
}

fn degenerate(scene: &Scene, visible: &Visible) -> u64 {
    answers::slots(visible).iter().map(|&s| u64::from(scene.mesh(s).degenerate_count())).sum()
}

fn bench(c: &mut Criterion) {
    let mut scene = city(60, 3, 100_000);
    scene.prepare(Preparation::ALL);
    let view = look([60.0, 30.0, 160.0], [0.0, 2.0, 0.0], [1280, 720]);
    let mut group = c.benchmark_group("draws");
    for output in [Output::Clusters, Output::Triangles] {
        let culler = Culler::default().with_output(output);
        let (mut state, mut visible) = (ViewState::default(), Visible::default());
        culler.cull_one(&scene, &view, &mut state, &mut visible);
        group.throughput(Throughput::Elements(visible.instance_count));
        let name = format!("{output:?}").to_lowercase();
        group.bench_function(format!("cull/{name}"), |b| {
            b.iter(|| culler.cull_one(&scene, &view, &mut state, &mut visible));
        });
        let mut draws = DrawList::default();
        group.bench_function(format!("fill/{name}"), |b| {
            b.iter(|| {
                match output {
                    Output::Triangles => draws.fill_triangles(&scene, &visible, &[]),
                    _ => draws.fill(&scene, &visible, &[]),
                }
                .expect("the scene stands as it was culled")
            });
        });
        assert!(drawn(&draws).into_iter().eq(answers::slots(&visible)), "{name}");
        assert_eq!(degenerate(&scene, &visible), 0);
        assert_eq!(indices(&draws), visible.triangle_count * 3, "{name}");
    }
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
