//! Frustum culling of distinct boxes and spheres, index list out.

use cullet::bounds::{Aabb, Boxes, Sphere, Spheres};
use cullet::cull::frustum::batch::{self, Indices, Planes};
use cullet::{Camera, Level, Projection};

use super::measure::{fastest_of_both, stream};
use super::{BenchOptions, Measured};

/// Shares of the items that are to be visible, in percent.
const VISIBLE: [usize; 3] = [5, 30, 70];

/// Half the side of the cube that the items lie in.
const HALF: f32 = 1000.0;

/// One kind of bounds.
struct Kind<B> {
    name: &'static str,
    bytes: usize,
    batch: B,
    len: usize,
    floats: fn(&B) -> &[f32],
    cull: fn(Level, &Planes, &B, &mut Indices),
    count: fn(Level, &Planes, &B) -> usize,
    oracle: fn(&Planes, &B) -> Vec<u32>,
}

pub(super) fn run(options: &BenchOptions, each: &mut dyn FnMut(Measured)) {
    for &len in &options.sizes {
        let wanted = |kind: &str| {
            VISIBLE.iter().any(|&percent| is_wanted(options, &name_of(kind, len, percent)))
        };
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
                batch: random_boxes(len),
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

fn is_wanted(options: &BenchOptions, name: &str) -> bool {
    options.filter.as_ref().is_none_or(|part| name.contains(part.as_str()))
}

fn name_of(kind: &str, len: usize, percent: usize) -> String {
    let power = len.checked_ilog10().unwrap_or(0);
    let size = match len / 10_usize.pow(power) {
        digit if digit * 10_usize.pow(power) == len => format!("{digit}e{power}"),
        _ => len.to_string(),
    };
    format!("frustum/{kind}/{size}/{percent}%")
}

fn run_kind<B>(options: &BenchOptions, kind: &Kind<B>, each: &mut dyn FnMut(Measured)) {
    let levels = batch::levels();
    let best = levels[0].1;
    for percent in VISIBLE {
        let name = name_of(kind.name, kind.len, percent);
        if !is_wanted(options, &name) {
            continue;
        }
        let planes = planes_that_see(percent, |p| (kind.count)(best, p, &kind.batch), kind.len);
        let expected = (kind.oracle)(&planes, &kind.batch);
        for &(level_name, level) in &levels {
            let mut visible = Indices::new();
            (kind.cull)(level, &planes, &kind.batch, &mut visible);
            let checked = *visible == *expected;
            let [limit, time] = fastest_of_both(
                options.seconds,
                |turn| stream(best, (kind.floats)(&kind.batch), turn),
                || (kind.cull)(level, &planes, &kind.batch, &mut visible),
            );
            each(Measured {
                name: name.clone(),
                level: level_name,
                items: kind.len,
                visible: visible.len(),
                ns_per_item: time / kind.len as f64,
                bytes_per_item: kind.bytes,
                limit_ns_per_item: limit / kind.len as f64,
                limit_ratio: time / limit,
                checked,
                versus: None,
            });
        }
    }
}

/// The planes of a camera that sees about `percent` of the items: it moves back from the far corner of
/// their cube until it does.
pub(crate) fn planes_that_see(
    percent: usize,
    count: impl Fn(&Planes) -> usize,
    len: usize,
) -> Planes {
    let half = f64::from(HALF);
    let at = |back: f64| {
        let along = [0.6, -0.3, -0.742];
        let eye = along.map(|v| -v * back);
        let projection = Projection::Perspective {
            fov_y_radians: 1.0,
            aspect: 16.0 / 9.0,
            near: 0.1,
            far: 10.0 * half,
        };
        let camera = Camera { eye, direction: along, up: [0.0, 1.0, 0.0], projection };
        Planes::new(&camera.frustum().expect("a plain perspective"))
    };
    let (mut low, mut high) = (-2.0 * half, 6.0 * half);
    for _ in 0..24 {
        let middle = (low + high) / 2.0;
        if count(&at(middle)) * 100 < percent * len {
            low = middle;
        } else {
            high = middle;
        }
    }
    at(high)
}

/// Numbers in 0..1 (Marsaglia, *Xorshift RNGs*, 2003).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }

    fn point(&mut self) -> [f32; 3] {
        std::array::from_fn(|_| (self.next() * 2.0 - 1.0) * HALF)
    }
}

pub(crate) fn random_boxes(len: usize) -> Boxes {
    let mut random = Random(0x1234_5678_9abc_def1);
    let mut boxes = Boxes::new();
    boxes.resize(len);
    for i in 0..len {
        let min = random.point();
        let max = min.map(|v| v + random.next() * 10.0);
        boxes.set(i, &Aabb { min, max });
    }
    boxes
}

fn random_spheres(len: usize) -> Spheres {
    let mut random = Random(0x1234_5678_9abc_def1);
    let mut spheres = Spheres::new();
    spheres.resize(len);
    for i in 0..len {
        let center = random.point();
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
    fn the_camera_sees_what_is_asked() {
        let boxes = random_boxes(5000);
        for percent in VISIBLE {
            let count = |p: &Planes| batch::count_boxes(Level::new(), p, &boxes);
            let seen = count(&planes_that_see(percent, count, 5000)) as f64 / 50.0;
            assert!((seen - percent as f64).abs() < 1.0, "{seen} % for {percent} %");
        }
    }
}
