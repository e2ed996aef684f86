//! Frustum culling of distinct boxes and spheres, index list out.

use cullet::bounds::{Aabb, Boxes, Side, Sphere, Spheres};
use cullet::cull::frustum::batch::{self, Indices, SpherePlanes};
use cullet::{Simd, view::Frustum};

use super::measure::{fastest_of_both, stream};
use super::measured::{Measured, Workload};
use super::options::BenchOptions;
use super::world::{
    HALF, Layout, Random, camera_over, camera_that_sees, frustum_of, planes_of, size_name,
};

/// Shares of the items that are to be visible, in percent.
const VISIBLE: [usize; 3] = [5, 30, 70];

pub(super) fn run(options: &BenchOptions, each: &mut dyn FnMut(Measured)) {
    for &len in &options.sizes {
        for percent in VISIBLE {
            if options.wants(&name_of("spheres", len, percent)) {
                spheres(options, len, percent, each);
            }
            if options.wants(&name_of("boxes", len, percent)) {
                boxes(options, len, percent, each);
            }
        }
    }
}

fn name_of(kind: &str, len: usize, percent: usize) -> String {
    format!("frustum/{kind}/{}/{percent}%", size_name(len))
}

fn boxes(options: &BenchOptions, len: usize, percent: usize, each: &mut dyn FnMut(Measured)) {
    let items = Layout::Random.boxes(len);
    let batch = Boxes::from_slice(&items);
    let planes = planes_of(&camera_over(percent, &batch));
    let kept = |b: &Aabb| planes.classify_box(b) != Side::Outside;
    let expected: Vec<bool> = items.iter().map(kept).collect();
    let name = name_of("boxes", len, percent);
    let work = Work { name, bytes: 24, floats: batch.as_floats(), expected };
    work.measure(options, each, |level, hits| batch::cull_boxes(level, &planes, &batch, hits));
}

fn spheres(options: &BenchOptions, len: usize, percent: usize, each: &mut dyn FnMut(Measured)) {
    let items = random_spheres(len);
    let batch = Spheres::from_slice(&items);
    let mut hits = Indices::new();
    let count = |frustum: &Frustum| {
        let planes = SpherePlanes::new(frustum);
        batch::cull_spheres(Simd::best(), &planes, &batch, &mut hits);
        hits.len()
    };
    let planes = SpherePlanes::new(&frustum_of(&camera_that_sees(percent, count, len)));
    let expected: Vec<bool> = items.iter().map(|s| !planes.rejects(s)).collect();
    let name = name_of("spheres", len, percent);
    let work = Work { name, bytes: 16, floats: batch.as_floats(), expected };
    work.measure(options, each, |level, hits| batch::cull_spheres(level, &planes, &batch, hits));
}
/// One kind of bounds, as many of it, and which of them are visible.
struct Work<'a> {
    name: String,
    bytes: usize,
    floats: &'a [f32],
    expected: Vec<bool>,
}

impl Work<'_> {
    fn measure(
        &self,
        options: &BenchOptions,
        each: &mut dyn FnMut(Measured),
        cull: impl Fn(Simd, &mut Indices),
    ) {
        let numbers = 0..self.expected.len() as u32;
        let expected: Vec<u32> = numbers.filter(|&i| self.expected[i as usize]).collect();
        for (level_name, level) in cullet_command::machine::levels() {
            let mut visible = Indices::new();
            cull(level, &mut visible);
            let checked = *visible == expected;
            let times = fastest_of_both(
                options.seconds,
                |turn| stream(Simd::best(), self.floats, turn),
                || cull(level, &mut visible),
            );
            let (name, items, visible) = (self.name.clone(), self.expected.len(), visible.len());
            let workload = Workload { name, level: level_name, items, visible, checked };
            each(workload.streaming(self.bytes, times));
        }
    }
}

fn random_spheres(len: usize) -> Vec<Sphere> {
    let mut random = Random::new();
    let sphere = |_| Sphere { center: random.point(HALF), radius: random.next() * 5.0 };
    (0..len).map(sphere).collect()
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
            let planes = planes_of(&camera_over(percent, &boxes));
            let seen = batch::count_boxes(Simd::best(), &planes, &boxes) as f64 / 50.0;
            assert!((seen - percent as f64).abs() < 1.0, "{seen} % for {percent} %");
        }
    }
}
