//! Shadow casters of one light and one view: the region, and the walk of the tree, as the culler's
//! frustum stage does them.

use cullet::bounds::{Aabb, Boxes};
use cullet::cull::frustum::batch::{self, Planes};
use cullet::cull::frustum::tree::Cut;
use cullet::cull::shadow::{CasterRegion, Light};
use cullet::hierarchy::{Nodes, spatial_order};
use cullet::{Simd, View, view::Frustum};

use super::measure::{fastest_of_both, stream};
use super::measured::{Measured, Workload};
use super::options::BenchOptions;
use super::world::{HALF, Layout, size_name};

pub(super) fn run(options: &BenchOptions, each: &mut dyn FnMut(Measured)) {
    for &len in &options.sizes {
        let name_of = |light: &str| format!("shadow/{light}/{}", size_name(len));
        if !lights().iter().any(|(light, _)| options.wants(&name_of(light))) {
            continue;
        }
        let items = Layout::Random.boxes(len);
        let mut boxes = Boxes::new();
        boxes.gather(Simd::best(), &items, &spatial_order(&items));
        let nodes = Nodes::over(Simd::best(), &boxes);
        for (light_name, light) in lights() {
            let name = name_of(light_name);
            if options.wants(&name) {
                run_light(options, name, &light, (&boxes, &nodes), each);
            }
        }
    }
}

/// The view's frustum, and the box in which shadows can fall: on the floor of the cube and what
/// stands on it.
fn view() -> (Frustum, Aabb) {
    let half = f64::from(HALF);
    let (eye, target) = ([0.0, -0.9 * half, 0.0], [0.3 * half, -0.95 * half, -half]);
    let view = View::perspective(eye, target, 1.0, 0.1, 0.5 * half, [1600, 900]);
    let floor = Aabb::new([-HALF; 3], [HALF, -0.8 * HALF, HALF]);
    (view.map_or_else(|_| Frustum::everything(), |v| v.frustum()), floor)
}

fn lights() -> [(&'static str, Light); 3] {
    let half = f64::from(HALF);
    let position = [0.1 * half, -0.8 * half, -0.3 * half];
    [
        ("sun", Light::Directional { direction: [0.5, -1.0, 0.3] }),
        ("lamp", Light::Point { position, range: 0.2 * half }),
        (
            "spot",
            Light::Spot {
                position,
                direction: [0.2, -1.0, 0.1],
                half_angle_radians: 0.6,
                range: 0.3 * half,
            },
        ),
    ]
}

/// The casters of one region: a mask, and what to clear of it.
#[derive(Default)]
struct Casters {
    cut: Cut,
    kept: Vec<u64>,
    touched: Vec<usize>,
}

impl Casters {
    fn cull(&mut self, simd: Simd, region: &CasterRegion, nodes: &Nodes, boxes: &Boxes) {
        self.touched.drain(..).for_each(|word| self.kept[word] = 0);
        self.kept.resize(batch::mask_words(boxes.len()), 0);
        if region.no_receiver() {
            return;
        }
        self.cut.cull(simd, &Planes::new(region.frustum()), nodes, boxes);
        for word in self.cut.touched() {
            let mut visible = self.cut.visible()[word];
            let mut kept = visible;
            while region.has_range() && visible != 0 {
                let bit = visible.trailing_zeros() as usize;
                let beyond = region.is_beyond_range(&boxes.get(word * 64 + bit));
                kept &= !(u64::from(beyond) << bit);
                visible &= visible - 1;
            }
            self.kept[word] = kept;
            self.touched.push(word);
        }
    }

    fn count(&self) -> usize {
        self.touched.iter().map(|&word| self.kept[word].count_ones() as usize).sum()
    }
}

fn run_light(
    options: &BenchOptions,
    name: String,
    light: &Light,
    (boxes, nodes): (&Boxes, &Nodes),
    each: &mut dyn FnMut(Measured),
) {
    let levels = cullet_command::machine::levels();
    let best = levels[0].1;
    let (frustum, floor) = view();
    let region = || CasterRegion::new(&frustum, Some(&floor), light);
    // Box by box, in scalar arithmetic.
    let oracle = region();
    let mut rejecting = vec![batch::VISIBLE; boxes.len()];
    batch::reject_boxes(best, &Planes::new(oracle.frustum()), boxes, 0, &mut rejecting);
    let mut expected = vec![0_u64; batch::mask_words(boxes.len())];
    for (i, &plane) in rejecting.iter().enumerate() {
        let plane = (plane != batch::VISIBLE).then_some(plane);
        let kept = oracle.reason(&boxes.get(i), plane).is_none();
        expected[i / 64] |= u64::from(kept) << (i % 64);
    }
    for (level_name, level) in levels {
        let mut casters = Casters::default();
        casters.cull(level, &region(), nodes, boxes);
        let checked = casters.kept == expected;
        let times = fastest_of_both(
            options.seconds,
            |turn| stream(best, boxes.as_floats(), turn),
            || casters.cull(level, &region(), nodes, boxes),
        );
        let (name, items, visible) = (name.clone(), boxes.len(), casters.count());
        let workload = Workload { name, level: level_name, items, visible, checked };
        each(workload.streaming(24, times));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet::bounds::Plane;
    use cullet::cull::frustum::batch::{mask_boxes, mask_words};
    use cullet::{Culler, Output, ShadowView, ViewState, Visible};
    use cullet_scenes::paths::{Overrides, PathSpec, views};

    fn visible(frustum: &Frustum, boxes: &Boxes) -> Vec<u64> {
        let mut mask = vec![0; mask_words(boxes.len())];
        mask_boxes(Simd::best(), &Planes::new(frustum), boxes, 0, &mut mask);
        mask
    }

    /// How many of `kept` are not `seen`.
    fn unseen(kept: &[u64], seen: &[u64]) -> u64 {
        kept.iter().zip(seen).map(|(k, s)| u64::from((k & !s).count_ones())).sum()
    }

    /// How many slots are kept, and how many of those are not `seen`.
    fn counts(kept: &Visible, seen: &[u64]) -> [u64; 2] {
        let is_seen = |slot: &u32| seen[*slot as usize / 64] >> (slot % 64) & 1 == 1;
        [kept.instance_count, kept.slots().filter(|slot| !is_seen(slot)).count() as u64]
    }

    /// The box along the light around the frustum, open towards the light: what a shadow map of the
    /// view covers.
    fn lights_box(frustum: &Frustum, towards: [f64; 3]) -> Frustum {
        let [x, y, z] = towards;
        let length = (x * x + y * y + z * z).sqrt();
        let back = [x / length, y / length, z / length];
        let flat = (back[0] * back[0] + back[2] * back[2]).sqrt();
        let u = [back[2] / flat, 0.0, -back[0] / flat];
        let v = [
            back[1] * u[2] - back[2] * u[1],
            back[2] * u[0] - back[0] * u[2],
            back[0] * u[1] - back[1] * u[0],
        ];
        let corners = frustum.corners().expect("a plain view");
        let mut all = Frustum::everything();
        for n in [u, u.map(|c| -c), v, v.map(|c| -c), back.map(|c| -c)] {
            let reach = corners.iter().map(|c| n[0] * c[0] + n[1] * c[1] + n[2] * c[2]);
            let d = reach.fold(f64::NEG_INFINITY, f64::max);
            all.push(Plane::new(n, d)).expect("there is room");
        }
        all
    }

    /// The figures of the book: `cargo test -p cullet-lab --lib --release in_the_city --
    /// --nocapture`.
    #[test]
    fn what_is_dropped_in_the_city_has_a_floor() {
        let model = cullet_scenes::build("city:cells=40,objects=20000").expect("a good spec");
        let (boxes, nodes) = (model.scene.boxes(), model.scene.hierarchy().nodes());
        let overrides = Overrides { far: Some(150.0), ..Overrides::default() };
        let walk = views(&model, &PathSpec::Walk, 16, [1600, 900], &overrides).expect("a walk");
        let suns = [("high", [0.5, -1.0, 0.3]), ("low", [0.8, -0.3, 0.5])];
        // All outside the view; of those the light's box, the swept frustum, and the swept
        // receivers.
        let mut sums = [[0; 4]; 2];
        let mut lamps = [0; 3];
        let everything = visible(&Frustum::everything(), boxes);
        let culler = Culler::default().with_output(Output::Instances);
        let (mut state, mut in_view) = (ViewState::default(), Visible::default());
        let (mut of_light, mut casters) = (ViewState::default(), Visible::default());
        let mut in_range = Casters::default();
        for view in &walk {
            let frustum = view.frustum();
            let seen = visible(&frustum, boxes);
            culler.cull_one(&model.scene, view, &mut state, &mut in_view);
            let mut kept = |by_receivers: bool, light: Light| {
                let mut shadows = ShadowView::new(view.clone(), light);
                if by_receivers {
                    let fits = shadows.receiving(&model.scene, &in_view);
                    shadows = fits.expect("the scene stands as it was culled");
                }
                culler.cull_shadow(&model.scene, &shadows, &mut of_light, &mut casters);
                counts(&casters, &seen)
            };
            for ((_, direction), sums) in suns.iter().zip(&mut sums) {
                let sun = Light::Directional { direction: *direction };
                let in_box = visible(&lights_box(&frustum, direction.map(|c| -c)), boxes);
                sums[0] += unseen(&everything, &seen);
                sums[1] += unseen(&in_box, &seen);
                sums[2] += kept(false, sun)[1];
                sums[3] += kept(true, sun)[1];
            }
            // A lamp every 48 m, whose light reaches 20 m.
            for (i, j) in (0..20).flat_map(|i| (0..20).map(move |j| (i, j))) {
                let at = |k: i32| f64::from(k - 10) * 48.0 + 12.0;
                let position = [at(i), 6.0, at(j)];
                let lamp = Light::Point { position, range: 20.0 };
                let region = CasterRegion::new(&Frustum::everything(), None, &lamp);
                in_range.cull(Simd::best(), &region, nodes, boxes);
                lamps[0] += in_range.count() as u64;
                lamps[1] += kept(false, lamp)[0];
                lamps[2] += kept(true, lamp)[0];
            }
        }
        for ((name, _), [all, in_box, swept, with_receivers]) in suns.iter().zip(sums) {
            println!(
                "{name} sun: {all} casters outside the view; the light's box keeps {in_box}, \
                 the swept frustum {swept}, with receivers {with_receivers}"
            );
            assert!(with_receivers * 15 <= in_box && with_receivers * 200 <= all);
            assert!(swept * 3 <= in_box * 2 && with_receivers <= swept);
        }
        let [in_range, swept, with_receivers] = lamps;
        println!(
            "400 lamps: {in_range} casters in their ranges; the swept frustum keeps {swept}, \
             with receivers {with_receivers}"
        );
        assert!(swept * 20 <= in_range && with_receivers <= swept);
    }
}
