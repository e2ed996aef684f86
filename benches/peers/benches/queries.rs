//! Queries of the city of 400 houses: lines of sight beside every triangle one by one, and beside every instance's
//! box; cells hidden from cells; a thousand lamps: `cargo bench --no-default-features --bench queries`, in `benches/peers`.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use cullet::bounds::Aabb;
use cullet::cull::occlusion::Occlusion;
use cullet::cull::shadow::Light;
use cullet::{Culler, Scene, ViewState, Visible};
use cullet_cells::query::{
    BlockingSides, BoxSight, Find, LightAnswer, LightOptions, Segment, Sight, SightOptions,
    VolumeOptions, box_to_box, cull_lights, lines_of_sight,
};
use cullet_testkit::Rng;
use cullet_testkit::oracles::sight::sight_ref;
use cullet_testkit::scenes::city;
use cullet_testkit::views::look;

const REACH: f64 = 230.0;

fn scene() -> Scene {
    let mut scene = city(20, 4, 2000);
    scene.commit(&cullet::Culler::default());
    scene
}

fn sight(c: &mut Criterion) {
    let (scene, mut rng) = (scene(), Rng(2));
    let mut lines = |reach: f64| -> Vec<Segment> {
        let mut one = || {
            let from = [rng.range(-REACH, REACH), 1.7, rng.range(-REACH, REACH)];
            let step = [rng.range(-reach, reach), rng.range(-1.0, 8.0), rng.range(-reach, reach)];
            Segment { from, to: std::array::from_fn(|a| from[a] + step[a]) }
        };
        (0..1000).map(|_| one()).collect()
    };
    let sets = [("near", lines(25.0)), ("far", lines(REACH))];
    let mut group = c.benchmark_group("sight");
    group.throughput(Throughput::Elements(1000));
    for (name, lines) in &sets {
        let mut answers = Vec::new();
        for (find, how) in [(Find::Nearest, "nearest"), (Find::Any, "any")] {
            let both = BlockingSides::Both;
            let options = SightOptions { find, sides: both, ..SightOptions::default() };
            let mut results = Vec::new();
            group.bench_function(format!("{name}/{how}"), |b| {
                b.iter(|| lines_of_sight(&scene, lines, &options, &mut results));
            });
            let blocked: Vec<bool> = results.iter().map(Sight::is_blocked).collect();
            println!("{name}: {} blocked", blocked.iter().filter(|b| **b).count());
            answers.push(blocked);
        }
        assert_eq!(answers[0], answers[1]);
    }
    group.sample_size(10).throughput(Throughput::Elements(1));
    let options = SightOptions { sides: BlockingSides::Both, ..SightOptions::default() };
    let line = sets[1].1[0];
    group.bench_function("brute force", |b| {
        b.iter(|| sight_ref(&scene, line.from, line.to, &options).len());
    });
    group.finish();
}

fn volume(c: &mut Criterion) {
    let (scene, mut rng) = (scene(), Rng(3));
    let mut cell = |half: f64| {
        let [x, z] = [(); 2].map(|()| rng.range(-REACH, REACH));
        let end = |sign: f64| [x + sign * half, 1.7 + sign, z + sign * half].map(|v| v as f32);
        Aabb::new(end(-1.0), end(1.0))
    };
    let pairs: Vec<_> = (0..1000).map(|_| (cell(0.5), cell(1.5))).collect();
    let mut group = c.benchmark_group("volume");
    group.throughput(Throughput::Elements(1000));
    for splits in [0, 4, 8] {
        let options = VolumeOptions { splits, ..VolumeOptions::default() };
        let hidden = || {
            let is = |(a, b): &(Aabb, Aabb)| box_to_box(&scene, a, b, &options);
            pairs.iter().filter(|p| matches!(is(p), BoxSight::Hidden(_))).count()
        };
        println!("{splits} splits: {} of 1000 hidden", hidden());
        group.bench_function(format!("{splits} splits"), |b| b.iter(hidden));
    }
    group.finish();
}

fn lights(c: &mut Criterion) {
    let (scene, mut rng) = (scene(), Rng(4));
    let view = look([2.0, 1.7, 235.0], [0.0, 3.0, 0.0], [1280, 720]);
    let lamps: Vec<Light> = (0..1000)
        .map(|_| Light::Point {
            position: [rng.range(-REACH, REACH), 4.0, rng.range(-REACH, REACH)],
            range: 12.0,
        })
        .collect();
    let (mut state, mut visible) = (ViewState::default(), Visible::default());
    let culler = Culler::default().with_occlusion(Occlusion::default());
    culler.cull_one(&scene, &view, &mut state, &mut visible);
    let mut group = c.benchmark_group("lights");
    group.throughput(Throughput::Elements(1000));
    let hidden = LightOptions { buffer: state.occlusion_buffer(), ..LightOptions::default() };
    let all = LightOptions { visible: Some(&visible), ..hidden };
    let each = [("frustum", LightOptions::default()), ("occlusion", hidden), ("receivers", all)];
    for (name, options) in each {
        let mut answer = LightAnswer::default();
        group.bench_function(name, |b| {
            b.iter(|| cull_lights(&scene, &view, &lamps, black_box(&options), &mut answer));
        });
        println!("{name}: {:?}", answer.rows.iter().map(|r| r.left).collect::<Vec<_>>());
    }
    group.finish();
}

criterion_group!(benches, sight, volume, lights);
criterion_main!(benches);
