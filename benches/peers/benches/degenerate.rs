//! Triangles without area, as they are and under a transform that flattens: `cargo bench --no-default-features --bench degenerate`, in `benches/peers`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use cullet::Transform;
use cullet::cull::degenerate::Flattening;
use cullet_testkit::oracles::triangles::flattens_ref;
use cullet_testkit::soups::terrain;

fn bench(c: &mut Criterion) {
    let (positions, mut indices) = terrain(100);
    // One in seven is a line.
    indices.chunks_exact_mut(3).step_by(7).for_each(|t| t[2] = t[1]);
    let count = indices.len() as u32 / 3;
    let flat = Transform {
        linear: [[1.0, 0.5, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        ..Transform::IDENTITY
    };
    let mut group = c.benchmark_group("degenerate");
    group.throughput(Throughput::Elements(u64::from(count)));
    for (name, transform) in [("whole", Transform::IDENTITY), ("flattened", flat)] {
        let flattening = Flattening::of(&transform);
        let mut kept = Vec::new();
        group.bench_function(name, |b| {
            b.iter(|| {
                kept.clear();
                flattening.keep_into(&positions, &indices, 0..count, &mut kept)
            });
        });
        kept.clear();
        flattening.keep_into(&positions, &indices, 0..count, &mut kept);
        let stays = |t: &u32| {
            let corners = [0, 1, 2].map(|k| positions[indices[*t as usize * 3 + k] as usize]);
            !flattens_ref(&transform, &corners)
        };
        assert_eq!(kept, (0..count).filter(stays).collect::<Vec<_>>(), "{name}");
        assert!(kept.len() < count as usize && !kept.is_empty(), "{name}: {}", kept.len());
    }
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
