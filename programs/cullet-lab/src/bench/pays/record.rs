//! Results of `cullet bench pays`, for people and as JSON.

use cullet_command::console::{Console, digits};
use serde::Serialize;

use super::rounds::{Arm, OneView, Ratio, Timing};
use cullet_command::machine::Machine;

/// All results of one run.
#[derive(Debug, Serialize)]
pub(super) struct Record {
    pub(super) schema: u32,
    pub(super) machine: Machine,
    /// Nanoseconds of a triangle, and of a draw.
    pub(super) triangle_ns: f64,
    pub(super) draw_ns: f64,
    pub(super) size: [u32; 2],
    pub(super) path: String,
    pub(super) rows: Vec<Row>,
    /// Models that cannot be loaded, with the reason.
    pub(super) skipped: Vec<String>,
}

/// A scene with the stage on, by one of the settings, against off.
#[derive(Debug, Serialize)]
pub(super) struct Row {
    pub(super) scene: String,
    pub(super) settings: &'static str,
    /// Cull and draw of all views together, on over off.
    pub(super) mean: f64,
    /// The same of the view where it is highest.
    pub(super) worst: f64,
    /// The highest of all views by the lower one of the two halves of the rounds.
    pub(super) sure: f64,
    /// The view where it is highest.
    pub(super) worst_view: usize,
    /// Milliseconds a view: off, on.
    pub(super) cull_ms: [f64; 2],
    pub(super) draw_ms: [f64; 2],
    /// The share of culling in cull and draw with the stage on: of all views, of the worst one.
    pub(super) cull_share: [f64; 2],
    /// Cost of a triangle, with the draws' in proportion, from which the stage pays over all views;
    /// none where it never does, 0 where it takes no time.
    pub(super) even_triangle_ns: Option<f64>,
    /// The most by which the halves of the rounds differ in any view, as a part of cull and draw.
    pub(super) noise: f64,
    pub(super) rounds: usize,
    pub(super) checked: bool,
    /// View by view: off, on.
    pub(super) views: Vec<[OneView; 2]>,
}

impl Row {
    /// Builds the row of a scene's views; a draw costs as much as `triangles_a_draw` triangles.
    pub(super) fn new(
        scene: &str,
        off: &Arm,
        on: &Arm,
        measured: Timing,
        triangles_a_draw: f64,
    ) -> Self {
        let views: Vec<[OneView; 2]> =
            off.views.iter().zip(&on.views).map(|(off, on)| [*off, *on]).collect();
        let ratios = || views.iter().map(|[off, on]| Ratio::of(on, off));
        let sum = |of: fn(&OneView) -> f64| {
            [0, 1].map(|arm| views.iter().map(|v| of(&v[arm])).sum::<f64>())
        };
        let (cull, drawn, all) = (sum(OneView::cull), sum(|v| v.draw_ns), sum(OneView::all));
        let by_ratio = |a: &(usize, Ratio), b: &(usize, Ratio)| a.1.ratio.total_cmp(&b.1.ratio);
        let worst = ratios().enumerate().max_by(by_ratio);
        let (worst_view, worst) = worst.unwrap_or((0, Ratio { ratio: f64::NAN, sure: f64::NAN }));
        let count = views.len().max(1) as f64;
        let [off_triangles, on_triangles] = sum(|v| v.triangles as f64);
        let [off_draws, on_draws] = sum(|v| v.draws as f64);
        let spared = off_triangles - on_triangles + (off_draws - on_draws) * triangles_a_draw;
        Self {
            scene: scene.to_owned(),
            settings: on.name,
            mean: all[1] / all[0],
            worst: worst.ratio,
            sure: ratios().map(|r| r.sure).fold(f64::NAN, f64::max),
            worst_view,
            cull_ms: cull.map(|ns| ns / count * 1e-6),
            draw_ms: drawn.map(|ns| ns / count * 1e-6),
            cull_share: [
                cull[1] / all[1],
                views.get(worst_view).map_or(f64::NAN, |[_, on]| on.cull() / on.all()),
            ],
            even_triangle_ns: (spared > 0.0).then(|| ((cull[1] - cull[0]) / spared).max(0.0)),
            noise: views.iter().flatten().map(OneView::noise).fold(0.0, f64::max),
            rounds: measured.rounds,
            checked: measured.checked,
            views,
        }
    }

    /// Its line.
    fn line(&self) -> String {
        let name = self.scene.rsplit('/').next().unwrap_or(&self.scene);
        let [off, on] = self.cull_ms.map(digits);
        let [draw_off, draw_on] = self.draw_ms.map(digits);
        let [share, at_worst] = self.cull_share.map(|s| format!("{:.0} %", s * 100.0));
        let even = self.even_triangle_ns.map_or_else(|| "never".to_owned(), digits);
        format!(
            "{name:<24} {:<9} {:>6.3} {:>6.3} {:>6.3} {:>4} {off:>8} {on:>8} {draw_off:>8} {draw_on:>8} {share:>6} \
             {at_worst:>6} {even:>7} {:>6.1}{}",
            self.settings,
            self.mean,
            self.worst,
            self.sure,
            self.worst_view,
            self.noise * 100.0,
            if self.checked { "" } else { "  WRONG" }
        )
    }
}

/// Two lines over the columns.
const HEADING: [&str; 2] = [
    "                                                               cull ms           draw ms        cull's share    even",
    "scene                    settings    mean  worst   sure view      off       on      off       on    all  worst  from ns noise %",
];

impl Record {
    /// The heading of the table.
    pub(super) fn begin(&self, console: &Console, source: &str) {
        let m = &self.machine;
        let [width, height] = self.size;
        console.line(format!(
            "{}, one of {} threads, {}; {} ns a triangle, {} a draw ({source})",
            m.cpu.as_deref().unwrap_or(m.arch),
            m.threads,
            m.level,
            digits(self.triangle_ns),
            digits(self.draw_ns)
        ));
        console.line(format!(
            "cull and draw with occlusion over the same without; views of {width}x{height} along {}; this thread's time",
            self.path
        ));
        HEADING.iter().for_each(|line| console.line(line));
    }

    /// Prints and keeps a row.
    pub(super) fn add(&mut self, row: Row, console: &Console) {
        console.line(row.line());
        self.rows.push(row);
    }

    /// The row whose worst view is highest, of each of the settings.
    pub(super) fn worst(&self) -> Vec<&Row> {
        let mut worst: Vec<&Row> = Vec::new();
        for row in &self.rows {
            match worst.iter_mut().find(|w| w.settings == row.settings) {
                Some(held) if row.sure > held.sure => *held = row,
                Some(_) => {}
                None => worst.push(row),
            }
        }
        worst
    }

    /// The end: the worst view of all scenes.
    pub(super) fn end(&self, console: &Console) {
        for row in self.worst() {
            let percent = (row.sure - 1.0) * 100.0;
            let how = if percent > 0.0 { "slower" } else { "faster" };
            console.line(format!(
                "worst view of all by {}: of {}, {:.1} % {how} in both halves of the rounds; by the fastest cull view {} is the worst of it",
                row.settings,
                row.scene,
                percent.abs(),
                row.worst_view
            ));
        }
        for skipped in &self.skipped {
            console.line(format!("skipped: {skipped}"));
        }
    }
}

#[cfg(test)]
mod tests {
    use cullet::Culler;

    use super::*;

    #[test]
    fn a_row_is_of_its_worst_view_and_says_what_a_triangle_must_cost() {
        let view = |cull: f64, triangles: u64, draws: u64| OneView {
            cull_ns: [cull, cull * 2.0],
            triangles,
            draws,
            draw_ns: triangles as f64 + draws as f64,
        };
        let arm = |views: [OneView; 2]| {
            let mut arm = Arm::new("on", Culler::fast());
            arm.views = views.to_vec();
            arm
        };
        let off = arm([view(10.0, 80, 10), view(10.0, 80, 10)]);
        let on = arm([view(20.0, 20, 10), view(40.0, 70, 10)]);
        let timing = Timing { rounds: 9, checked: true };
        let row = Row::new("a/b.glb", &off, &on, timing, 1.0);
        assert_eq!((row.worst, row.worst_view, row.mean), (1.2, 1, 170.0 / 200.0));
        // The half in which the cull took twice as long has it slower still.
        assert_eq!(row.sure, 1.2);
        assert_eq!(row.cull_share, [60.0 / 170.0, 40.0 / 120.0]);
        // 40 ns more for 70 triangles less.
        assert_eq!(row.even_triangle_ns, Some(40.0 / 70.0));
        assert!(row.line().starts_with("b.glb") && !row.line().contains("WRONG"));
        let never = Row::new("b", &off, &off, Timing { checked: false, ..timing }, 1.0);
        assert_eq!((never.even_triangle_ns, never.worst), (None, 1.0));
        assert!(never.line().contains("never") && never.line().ends_with("WRONG"));
    }
}
