//! A frame of a small city with occlusion and without: `cargo bench --no-default-features --bench occlusion`, in `benches/peers`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use cullet::cull::occlusion::Occlusion;
use cullet::{Culler, ViewState, Visible, prepared::Preparation};
use cullet_testkit::answers::slots;
use cullet_testkit::scenes::city;
use cullet_testkit::views::look;

fn bench(c: &mut Criterion) {
    let mut scene = city(20, 1, 5000);
    scene.prepare(Preparation::ALL);
    let view = look([0.0, 1.7, 120.0], [0.0, 1.7, 0.0], [1280, 720]);
    let mut group = c.benchmark_group("occlusion");
    group.throughput(Throughput::Elements(u64::from(scene.instance_count())));
    let mut answers = Vec::new();
    for (name, occlusion) in [("off", None), ("on", Some(Occlusion::default()))] {
        let culler = Culler::default().with_occlusion(occlusion);
        let (mut state, mut visible) = (ViewState::default(), Visible::default());
        group.bench_function(name, |b| {
            b.iter(|| culler.cull_one(&scene, &view, &mut state, &mut visible));
        });
        culler.cull_one(&scene, &view, &mut state, &mut visible);
        let mut cold = Visible::default();
        culler.cull_one(&scene, &view, &mut ViewState::default(), &mut cold);
        assert_eq!(slots(&visible), slots(&cold), "warm and cold, {name}");
        answers.push(slots(&cold));
    }
    let [off, on] = &answers[..] else { unreachable!("two answers") };
    assert!(on.iter().all(|slot| off.binary_search(slot).is_ok()));
    assert!(on.len() * 2 < off.len(), "{} of {} are left", on.len(), off.len());
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
