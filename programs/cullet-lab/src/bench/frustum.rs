//! Frustum culling of distinct boxes and spheres, index list out.

use cullet::Simd;
use cullet::bounds::{Boxes, Sphere, Spheres};
use cullet::cull::frustum::batch::{self, Indices, Planes};

use super::measure::{fastest_of_both, stream};
use super::measured::{Measured, Workload};
use super::options::BenchOptions;
use super::world::{HALF, Layout, Random, planes_that_see, size_name};

/// Shares of the items that are to be visible, in percent.
const VISIBLE: [usize; 3] = [5, 30, 70];

/// One kind of bounds.
struct Kind<B> {
    name: &'static str,
    bytes: usize,
    batch: B,
    len: usize,
    floats: fn(&B) -> &[f32],
    cull: fn(Simd, &Planes, &B, &mut Indices),
    count: fn(Simd, &Planes, &B) -> usize,
    oracle: fn(&Planes, &B) -> Vec<u32>,
}

pub(super) fn run(options: &BenchOptions, each: &mut dyn FnMut(Measured)) {
    for &len in &options.sizes {
        let wanted =
            |kind: &str| VISIBLE.iter().any(|&percent| options.wants(&name_of(kind, len, percent)));
        if wanted("spheres") {
            let kind = Kind {
                name: "spheres",
                bytes: 16,
                batch: random_spheres(len),
                len,
                floats: Spheres::as_floats,
                cull: batch::cull_spheres,
                count: batch::count_spheres,
                oracle: batch::cull_spheres_ref,
            };
            run_kind(options, &kind, each);
        }
        if wanted("boxes") {
            let kind = Kind {
                name: "boxes",
                bytes: 24,
                batch: Boxes::from_slice(&Layout::Random.boxes(len)),
                len,
                floats: Boxes::as_floats,
                cull: batch::cull_boxes,
                count: batch::count_boxes,
                oracle: batch::cull_boxes_ref,
            };
            run_kind(options, &kind, each);
        }
    }
}

fn name_of(kind: &str, len: usize, percent: usize) -> String {
    format!("frustum/{kind}/{}/{percent}%", size_name(len))
}

fn run_kind<B>(options: &BenchOptions, kind: &Kind<B>, each: &mut dyn FnMut(Measured)) {
    let levels = cullet_command::machine::levels();
    let best = levels[0].1;
    for percent in VISIBLE {
        let name = name_of(kind.name, kind.len, percent);
        if !options.wants(&name) {
            continue;
        }
        let planes = planes_that_see(percent, |p| (kind.count)(best, p, &kind.batch), kind.len);
        let expected = (kind.oracle)(&planes, &kind.batch);
        for &(level_name, level) in &levels {
            let mut visible = Indices::new();
            (kind.cull)(level, &planes, &kind.batch, &mut visible);
            let checked = *visible == *expected;
            let times = fastest_of_both(
                options.seconds,
                |turn| stream(best, (kind.floats)(&kind.batch), turn),
                || (kind.cull)(level, &planes, &kind.batch, &mut visible),
            );
            let (name, items, visible) = (name.clone(), kind.len, visible.len());
            let workload = Workload { name, level: level_name, items, visible, checked };
            each(workload.streaming(kind.bytes, times));
        }
    }
}

fn random_spheres(len: usize) -> Spheres {
    let mut random = Random::new();
    let mut spheres = Spheres::new();
    spheres.resize(len);
    for i in 0..len {
        let center = random.point(HALF);
        spheres.set(i, &Sphere { center, radius: random.next() * 5.0 });
    }
    spheres
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_short() {
        assert_eq!(name_of("boxes", 100_000, 30), "frustum/boxes/1e5/30%");
        assert_eq!(name_of("spheres", 4_000_000, 5), "frustum/spheres/4e6/5%");
        assert_eq!(name_of("boxes", 1234, 5), "frustum/boxes/1234/5%");
    }

    #[test]
    fn the_camera_sees_the_share_that_is_wanted() {
        let boxes = Boxes::from_slice(&Layout::Random.boxes(5000));
        for percent in VISIBLE {
            let count = |p: &Planes| batch::count_boxes(Simd::best(), p, &boxes);
            let seen = count(&planes_that_see(percent, count, 5000)) as f64 / 50.0;
            assert!((seen - percent as f64).abs() < 1.0, "{seen} % for {percent} %");
        }
    }
}
