//! Outcodes of points, lines and polygons clipped: `cargo bench --no-default-features --bench clip`, in `benches/peers`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use cullet::Transform;
use cullet_draw::clip::{Clipper, HalfSpace, OutcodeRegion, Region};
use cullet_testkit::Rng;
use cullet_testkit::oracles::clip::{clip_line_ref, clip_polygon_ref, outcode_ref};
use cullet_testkit::views::look;

const ITEMS: usize = 10_000;

fn bench(c: &mut Criterion) {
    let mut rng = Rng(1);
    let mut group = c.benchmark_group("clip");
    group.throughput(Throughput::Elements(ITEMS as u64));

    let points: Vec<[f32; 3]> = (0..ITEMS).map(|_| rng.vector(600.0).map(|v| v as f32)).collect();
    let frustum = look([-400.0, 200.0, 500.0], [0.0; 3], [1600, 1000]).frustum();
    let region = OutcodeRegion::new(&frustum, &Transform::IDENTITY);
    let codes = |points: &[[f32; 3]]| -> Vec<u32> {
        points.iter().map(|&p| region.outcode(p).outside).collect()
    };
    group.bench_function("outcodes", |b| b.iter(|| codes(&points)));
    let codes = codes(&points);
    for (code, point) in codes.iter().zip(&points) {
        // Outside is a proof; the other way round, rounding may keep.
        let exact = outcode_ref(&frustum, &Transform::IDENTITY, *point)[0];
        assert_eq!(code & !exact, 0, "{point:?}");
    }
    assert!(codes.iter().filter(|c| **c != 0).count() > ITEMS * 2 / 5);

    let cube = (0..6).map(|side| {
        let mut normal = [0.0; 3];
        normal[side / 2] = [-1.0, 1.0][side % 2];
        HalfSpace::new(normal, 1.0).expect("a normal")
    });
    let cube = Region::new(cube).expect("six sides");
    let lines: Vec<_> = (0..ITEMS).map(|_| [rng.vector(2.0), rng.vector(2.0)]).collect();
    group.bench_function("lines", |b| {
        b.iter(|| lines.iter().filter(|[p, q]| cube.clip_line(p, q).is_some()).count());
    });
    for [p, q] in lines.iter().step_by(10) {
        let (found, exact) = (cube.clip_line(p, q), clip_line_ref(&cube.planes(), p, q));
        let (found, exact) = (found.unwrap_or_default(), exact.unwrap_or_default());
        assert!((0..2).all(|i| (found[i] - exact[i]).abs() < 1e-9), "{p:?} {q:?}");
    }

    let triangles: Vec<[[f64; 3]; 3]> =
        (0..ITEMS).map(|_| std::array::from_fn(|_| rng.vector(2.0))).collect();
    let mut clipper = Clipper::new();
    group.bench_function("triangles", |b| {
        b.iter(|| triangles.iter().map(|t| clipper.clip(&cube, t).len()).sum::<usize>());
    });
    for t in triangles.iter().step_by(100) {
        let (found, exact) = (clipper.clip(&cube, t), clip_polygon_ref(&cube.planes(), t));
        assert_eq!(found.len(), exact.len(), "{t:?}");
        let near = |p: &[f64; 3], q: &[f64; 3]| (0..3).all(|a| (p[a] - q[a]).abs() < 1e-9);
        assert!(found.iter().zip(&exact).all(|(p, q)| near(p, q)), "{t:?}");
    }
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
