//! Back faces of a ball of 1e5 triangles: from their corners, from quantised planes, from normal masks:
//! `cargo bench --no-default-features --bench backface`, in `benches/peers`.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use cullet::Transform;
use cullet::bounds::Sphere;
use cullet::cull::Indices;
use cullet::cull::backface::{Facing, ObjectEye, Planes8};
use cullet_mesh::{MaskGrid, NormalMasks, ViewCone};
use cullet_testkit::at_every_level;
use cullet_testkit::oracles::triangles::facing_ref;
use cullet_testkit::soups::bumpy_ball;
use cullet_testkit::views::look;

const EYE: [f64; 3] = [0.5, 1.0, 3.0];

fn bench(c: &mut Criterion) {
    let (positions, indices) = bumpy_ball(160, 0.03);
    let count = indices.len() / 3;
    let eye = [EYE[0], EYE[1], EYE[2], 1.0];
    let mut group = c.benchmark_group("backface");
    group.throughput(Throughput::Elements(count as u64));

    let view = look(EYE, [0.0; 3], [640, 480]);
    let triangles = ObjectEye::of_view(&view, &Transform::IDENTITY);
    let mut kept = Vec::new();
    group.bench_function("corners", |b| {
        b.iter(|| {
            kept.clear();
            triangles.keep_into(&positions, &indices, 0..count as u32, &mut kept)
        });
    });
    kept.clear();
    triangles.keep_into(&positions, &indices, 0..count as u32, &mut kept);
    for t in (0..count).step_by(97) {
        let corners = [0, 1, 2].map(|k| positions[indices[t * 3 + k] as usize]);
        let is_back = facing_ref(&view, &Transform::IDENTITY, &corners) == Facing::Back;
        assert!(is_back || kept.binary_search(&(t as u32)).is_ok(), "triangle {t} faces the eye");
    }
    assert!(kept.len() < count * 7 / 10, "{} of {count}", kept.len());

    let planes = Planes8::new(&positions, &indices);
    let seen = planes.eye(eye, Facing::Back, 0.0).expect("an eye");
    let grid = MaskGrid::new(4).expect("a size that there is");
    let mut masks = NormalMasks::default();
    masks.resize(count);
    for (t, corners) in indices.chunks_exact(3).enumerate() {
        let corners = [0, 1, 2].map(|k| positions[corners[k] as usize]);
        masks.set(t, grid.encode_triangle(corners));
    }
    let cone = ViewCone::to_sphere(eye, &Sphere { center: [0.0; 3], radius: 1.2 });
    let (mut culled, mut listed) = (vec![0; count.div_ceil(64)], Indices::new());
    at_every_level!(|name, level| {
        group.bench_function(format!("planes/{name}"), |b| {
            b.iter(|| planes.cull_words(level, &seen, 0, &mut culled));
        });
        planes.cull_words(level, &seen, 0, &mut culled);
        assert_eq!(culled, planes.cull_ref(&seen));
        let mask = grid.mask(level, cone.as_ref());
        group.bench_function(format!("masks/{name}"), |b| {
            b.iter(|| masks.cull_words(level, &mask, 0, &mut culled));
        });
        masks.cull_words(level, &mask, 0, &mut culled);
        assert_eq!(culled, masks.cull_ref(&mask));
        group.bench_function(format!("list/{name}"), |b| {
            b.iter(|| {
                listed.clear();
                listed.append_ones(level, &culled, 0);
            });
        });
        let ones: u32 = culled.iter().map(|word| word.count_ones()).sum();
        assert_eq!(listed.len(), ones as usize);
    });
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
