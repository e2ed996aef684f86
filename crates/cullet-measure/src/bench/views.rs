//! Several threads against one.

use cullet::Level;
use cullet::cull::frustum::batch::{self, Planes};
use cullet::cull::frustum::tree::{CullJob, Cut};
use cullet::hierarchy::Hierarchy;
use rayon::prelude::*;

use super::measure::fastest_of_both;
use super::measured::{Measured, Workload};
use super::options::BenchOptions;
use super::world::{Layout, camera_over, planes_of, size_name};

/// Rows with two threads, and the share that is visible, in percent.
const THREAD_ROWS: [(&str, usize); 3] =
    [("two threads/10%", 10), ("two threads/50%", 50), ("two threads/100%", 100)];

pub(super) fn run(options: &BenchOptions, each: &mut dyn FnMut(Measured)) {
    for layout in Layout::ALL {
        for &len in options.tree_sizes.iter().filter(|&&len| len <= 1_000_000) {
            let name = format!("views/{}/{}/", layout.name(), size_name(len));
            let wanted = |row: &str| options.wants(&format!("{name}{row}"));
            if !THREAD_ROWS.iter().any(|(row, _)| wanted(row)) {
                continue;
            }
            let (hierarchy, _) =
                Hierarchy::build(&layout.boxes(len)).expect("fewer than there are slots");
            Walks { options, name: name.clone(), hierarchy }.threads(each);
        }
    }
}

/// Walks of one hierarchy.
struct Walks<'a> {
    options: &'a BenchOptions,
    name: String,
    hierarchy: Hierarchy,
}

impl Walks<'_> {
    fn row(&self, what: &str, visible: usize, checked: bool) -> Workload {
        Workload {
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
            each(row.against(times, "one thread"));
        }
    }
}
