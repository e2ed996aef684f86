//! Walks of a hierarchy against flat sweeps of the same boxes.

use cullet::Simd;
use cullet::bounds::Boxes;
use cullet::cull::frustum::batch::{self, Indices};
use cullet::cull::frustum::tree::Cut;
use cullet::hierarchy::Hierarchy;

use super::measure::fastest_of_both;
use super::measured::{Measured, Workload};
use super::options::BenchOptions;
use super::world::{Layout, camera_over, planes_of, size_name};

/// Shares of the boxes that are to be visible, in percent.
const VISIBLE: [usize; 4] = [1, 10, 50, 100];

pub(super) fn run(options: &BenchOptions, each: &mut dyn FnMut(Measured)) {
    for layout in Layout::ALL {
        // For each share, the time a visible box in a smaller world.
        let mut before = [None; VISIBLE.len()];
        for &len in &options.tree_sizes {
            let name = format!("hierarchy/{}/{}/", layout.name(), size_name(len));
            if !VISIBLE.iter().any(|percent| wants(options, &format!("{name}{percent}%/"))) {
                continue;
            }
            let world = World::new(layout, len);
            for (percent, before) in VISIBLE.into_iter().zip(&mut before) {
                let name = format!("{name}{percent}%/");
                if wants(options, &name) {
                    let took = world.run(options, &name, percent, each);
                    *before = world.against_smaller(&name, took, *before, each);
                }
            }
        }
    }
}

fn wants(options: &BenchOptions, below: &str) -> bool {
    let rows = ["list", "sorted sweep", "visible box"];
    rows.iter().any(|row| options.wants(&format!("{below}{row}")))
}

/// Worlds at least so large are compared with ten times smaller ones: below, caches decide.
const LARGE: usize = 10_000_000;

struct World {
    unsorted: Boxes,
    hierarchy: Hierarchy,
}

impl World {
    fn new(layout: Layout, len: usize) -> Self {
        let items = layout.boxes(len);
        let (hierarchy, _) = Hierarchy::build(&items).expect("fewer than there are slots");
        Self { unsorted: Boxes::from_slice(&items), hierarchy }
    }

    /// All rows of one share. Returns the fastest list: nanoseconds, and how many are visible.
    fn run(
        &self,
        options: &BenchOptions,
        name: &str,
        percent: usize,
        each: &mut dyn FnMut(Measured),
    ) -> (f64, usize) {
        let (boxes, nodes) = (self.hierarchy.boxes(), self.hierarchy.nodes());
        let planes = planes_of(&camera_over(percent, &self.unsorted));
        let levels = cullet_command::machine::levels();
        let mut expected = Indices::new();
        batch::cull_boxes(levels[0].1, &planes, boxes, &mut expected);
        let mut flat = Indices::new();
        batch::cull_boxes(levels[0].1, &planes, &self.unsorted, &mut flat);
        // The boxes are the same, so as many are visible, whatever their order.
        let same = flat.len() == expected.len();
        let sweep = |simd: Simd, boxes: &Boxes, list: &mut Indices| {
            batch::cull_boxes(simd, &planes, boxes, list);
        };
        let row = |what: &str, level, checked| Workload {
            name: format!("{name}{what}"),
            level,
            items: boxes.len(),
            visible: expected.len(),
            checked: checked && same,
        };
        let each = &mut |row: Measured| {
            if options.wants(&row.name) {
                each(row);
            }
        };
        let (mut cut, mut list) = (Cut::new(), Indices::new());
        let mut best = f64::INFINITY;
        for &(level_name, level) in &levels {
            let mut walk = || {
                cut.cull(level, &planes, nodes, boxes);
                cut.list(level, &mut list);
            };
            walk();
            let times = fastest_of_both(
                options.seconds,
                |_| sweep(level, &self.unsorted, &mut flat),
                &mut walk,
            );
            best = best.min(times[1]);
            each(row("list", level_name, *list == *expected).against(times, "flat list"));
        }
        let (level_name, level) = levels[0];
        let times = fastest_of_both(
            options.seconds,
            |_| sweep(level, &self.unsorted, &mut flat),
            || sweep(level, boxes, &mut list),
        );
        let checked = *list == *expected;
        each(row("sorted sweep", level_name, checked).against(times, "flat list"));
        (best, expected.len())
    }

    /// The time a visible box against that of a smaller world, if there was one and this is large.
    fn against_smaller(
        &self,
        name: &str,
        (time, visible): (f64, usize),
        before: Option<f64>,
        each: &mut dyn FnMut(Measured),
    ) -> Option<f64> {
        let here = time / visible.max(1) as f64;
        if let Some(before) = before.filter(|_| self.unsorted.len() >= LARGE) {
            let row = Workload {
                name: format!("{name}visible box"),
                level: cullet_command::machine::levels()[0].0,
                items: visible.max(1),
                visible,
                // The walk that it divides has been checked.
                checked: true,
            };
            let all = visible.max(1) as f64;
            each(row.against([before * all, here * all], "one in a smaller world"));
        }
        Some(here)
    }
}
