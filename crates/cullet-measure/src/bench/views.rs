//! Several views, and several threads, against one.

use cullet::cull::frustum::batch::{self, Indices, Planes};
use cullet::cull::frustum::tree::{CullJob, Cut, cull_views};
use cullet::hierarchy::Hierarchy;
use cullet::{Camera, Frustum, Level, Projection};
use rayon::prelude::*;

use super::hierarchy::Against;
use super::measure::fastest_of_both;
use super::measured::Measured;
use super::options::BenchOptions;
use super::world::{Layout, camera_over, planes_of, size_name};

/// Where the slices of a cascade end, in units.
const SPLITS: [f64; 5] = [0.1, 60.0, 180.0, 540.0, 1600.0];
/// How far towards the light casters count.
const CASTERS: f64 = 300.0;
/// Where the light comes from.
const LIGHT: [f64; 3] = [-0.4, -0.85, 0.34];
/// Half the distance of two eyes, in units; boxes have sides of up to 10.
const HALF_APART: f64 = 0.5;

/// Rows with two threads, and the share that is visible, in percent.
const THREAD_ROWS: [(&str, usize); 3] =
    [("two threads/10%", 10), ("two threads/50%", 50), ("two threads/100%", 100)];

pub(super) fn run(options: &BenchOptions, each: &mut dyn FnMut(Measured)) {
    for layout in Layout::ALL {
        for &len in options.tree_sizes.iter().filter(|&&len| len <= 1_000_000) {
            let name = format!("views/{}/{}/", layout.name(), size_name(len));
            let wanted = |row: &str| options.wants(&format!("{name}{row}"));
            let threads = THREAD_ROWS.iter().any(|(row, _)| wanted(row));
            let (cascades, stereo) = (wanted("cascades"), wanted("stereo"));
            if !(cascades || stereo || threads) {
                continue;
            }
            let (hierarchy, _) =
                Hierarchy::build(&layout.boxes(len)).expect("fewer than there are slots");
            let world = World { options, name: name.clone(), hierarchy };
            if cascades {
                world.cascades(each);
            }
            if stereo {
                world.stereo(each);
            }
            if threads {
                world.threads(each);
            }
        }
    }
}

struct World<'a> {
    options: &'a BenchOptions,
    name: String,
    hierarchy: Hierarchy,
}

impl World<'_> {
    fn row(&self, what: &str, visible: usize, checked: bool) -> Against {
        Against {
            name: format!("{}{what}", self.name),
            level: batch::levels()[0].0,
            items: self.hierarchy.boxes().len(),
            visible,
            checked,
        }
    }

    fn cull(&self, planes: &Planes, cut: &mut Cut) {
        cut.cull(Level::new(), planes, self.hierarchy.nodes(), self.hierarchy.boxes());
    }

    fn is_swept(&self, planes: &Planes, cut: &Cut) -> bool {
        let (mut swept, mut listed) = (Indices::new(), Indices::new());
        batch::cull_boxes(Level::new(), planes, self.hierarchy.boxes(), &mut swept);
        cut.list(Level::new(), &mut listed);
        *swept == *listed
    }

    /// Four views of a light, of slices of a camera that sees a tenth, in one pass.
    fn cascades(&self, each: &mut dyn FnMut(Measured)) {
        let (nodes, boxes) = (self.hierarchy.nodes(), self.hierarchy.boxes());
        let camera = camera_over(10, boxes);
        let view = planes_of(&camera);
        let lights: Vec<_> =
            SPLITS.windows(2).map(|s| planes_of(&cascade(&camera, s[0], s[1]))).collect();
        let mut one = Cut::new();
        let mut cuts = vec![Cut::new(); lights.len()];
        let mut all = || {
            cull_views(Level::new(), &lights, nodes, boxes, &mut cuts).expect("a cut a light");
        };
        let seconds = self.options.seconds;
        let against_view = fastest_of_both(seconds, |_| self.cull(&view, &mut one), &mut all);
        let mut last = Cut::new();
        let against_last = fastest_of_both(seconds, |_| self.cull(&lights[3], &mut last), &mut all);
        let mut apart = vec![Cut::new(); lights.len()];
        let one_by_one = fastest_of_both(
            seconds,
            |_| lights.iter().zip(&mut apart).for_each(|(l, cut)| self.cull(l, cut)),
            &mut all,
        );
        let visible = cuts.iter().map(Cut::count).sum();
        let checked = lights.iter().zip(&cuts).all(|(l, cut)| self.is_swept(l, cut));
        let row = || self.row("cascades", visible, checked);
        each(row().measured(against_view, "the camera's view"));
        each(row().measured(against_last, "the widest cascade"));
        each(row().measured(one_by_one, "one by one"));
    }

    /// Two eyes: one cull around both, refined for each.
    fn stereo(&self, each: &mut dyn FnMut(Measured)) {
        let boxes = self.hierarchy.boxes();
        let camera = camera_over(10, boxes);
        let eye = |side: f64| {
            let right = camera.basis().expect("a plain camera")[0];
            let eye = std::array::from_fn(|a| camera.eye[a] + side * right[a]);
            Camera { eye, ..camera }.frustum().expect("a plain camera")
        };
        let eyes = [eye(-HALF_APART), eye(HALF_APART)];
        let around = Planes::new(&Frustum::around(&eyes));
        let planes = eyes.each_ref().map(Planes::new);
        let mut alone = [Cut::new(), Cut::new()];
        let (mut both, mut refined) = (Cut::new(), [Cut::new(), Cut::new()]);
        let times = fastest_of_both(
            self.options.seconds,
            |_| planes.iter().zip(&mut alone).for_each(|(p, cut)| self.cull(p, cut)),
            || {
                self.cull(&around, &mut both);
                for (p, cut) in planes.iter().zip(&mut refined) {
                    cut.refine(Level::new(), p, boxes, &both);
                }
            },
        );
        let visible = refined.iter().map(Cut::count).sum();
        let checked = planes.iter().zip(&refined).all(|(p, cut)| self.is_swept(p, cut));
        each(self.row("stereo", visible, checked).measured(times, "each eye by itself"));
    }

    /// One view in jobs on two threads.
    fn threads(&self, each: &mut dyn FnMut(Measured)) {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("two threads");
        let (nodes, boxes) = (self.hierarchy.nodes(), self.hierarchy.boxes());
        for (what, percent) in THREAD_ROWS {
            let planes = planes_of(&camera_over(percent, boxes));
            let (mut one, mut split) = (Cut::new(), Cut::new());
            // Timed from within the pool, as an engine's frame is.
            let times = pool.install(|| {
                fastest_of_both(
                    self.options.seconds,
                    |_| self.cull(&planes, &mut one),
                    || {
                        split.cull_in_jobs(Level::new(), &planes, nodes, boxes, 8, |jobs| {
                            jobs.into_par_iter().map(CullJob::run).collect()
                        });
                    },
                )
            });
            let same = one.visible() == split.visible() && one.inside() == split.inside();
            let row = self.row(what, split.count(), same);
            each(row.measured(times, "one thread"));
        }
    }
}

/// A light's view of what lies in a slice of a camera's frustum, and of what casts shadows there.
fn cascade(camera: &Camera, near: f64, far: f64) -> Camera {
    let mut slice = *camera;
    if let Projection::Perspective { near: n, far: f, .. } = &mut slice.projection {
        (*n, *f) = (near, far);
    }
    let corners = slice.frustum().ok().and_then(|f| f.corners()).expect("a finite slice");
    let projection =
        Projection::Perspective { fov_y_radians: 1.0, aspect: 1.0, near: 1.0, far: 2.0 };
    let light = Camera { eye: [0.0; 3], direction: LIGHT, up: [0.0, 1.0, 0.0], projection };
    let [right, up, back] = light.basis().expect("a light that is not straight up");
    let span = |axis: [f64; 3]| {
        let along = corners.map(|c| (0..3).map(|a| axis[a] * c[a]).sum::<f64>());
        (
            along.into_iter().fold(f64::INFINITY, f64::min),
            along.into_iter().fold(f64::NEG_INFINITY, f64::max),
        )
    };
    let ((left, right), (bottom, top), (low, high)) = (span(right), span(up), span(back));
    let projection =
        Projection::Orthographic { left, right, bottom, top, near: -high - CASTERS, far: -low };
    Camera { projection, ..light }
}
