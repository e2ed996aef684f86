//! Records of levels of detail: plain data, serialised as it stands.

use cullet::lod::Lod;
use cullet_command::console::{count, grouped, percent};
use cullet_draw::LevelPixels;
use cullet_draw::Measured;
use serde::{Deserialize, Serialize};

/// Levels of detail in one view.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(crate) struct LevelsRecord {
    /// Triangles on the way from all to visible.
    pub(crate) ladder: LadderRecord,
    /// Triangles that are drawn of each level, by how often they were simplified; the first in
    /// full.
    pub(crate) drawn: Vec<u64>,
    /// Level that holds boxes of impostors instead of triangles of a mesh; left out where there is
    /// none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) impostor_level: Option<u32>,
    /// Triangles of each level that would be drawn without any other stage. Empty in a view that
    /// was not verified.
    pub(crate) chosen: Vec<u64>,
    /// How the picture differs from that in full; null in a view that was not verified.
    pub(crate) pixels: Option<PixelRecord>,
    /// How far what is drawn was found to be off; null in a view that was not verified.
    pub(crate) deviation: Option<DeviationRecord>,
}

/// Triangles that are left, step by step; each step includes those before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub(crate) struct LadderRecord {
    pub(crate) all: u64,
    pub(crate) frustum: u64,
    pub(crate) backface: u64,
    /// And sets, portals and detail, where they are on.
    pub(crate) occlusion: u64,
    pub(crate) levels: u64,
    /// Triangles of levels that own a pixel; null in a view that was not verified.
    pub(crate) visible: Option<u64>,
    /// Triangles that own a pixel where all is drawn in full.
    pub(crate) visible_in_full: Option<u64>,
}

/// Pixels that levels change.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub(crate) struct PixelRecord {
    pub(crate) all: u64,
    /// They show another instance, or none, or one where there was none.
    pub(crate) differ: u64,
    /// Differing pixels where only one of the two pictures shows anything.
    pub(crate) silhouette: u64,
    /// Pixels that show something dropped for its size or for the eye's cell, since what is before
    /// it is drawn coarser.
    pub(crate) uncovered: u64,
}

/// How far points of the surfaces are off, in pixels.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub(crate) struct DeviationRecord {
    /// Stated; the largest of the views where a budget chose it.
    pub(crate) threshold_px: f64,
    /// Whether that is held in the image's corners, too.
    pub(crate) at_corners: bool,
    pub(crate) max_px: f64,
    /// Bound that 99.9 % of the random points stay within, of the original and of what is drawn:
    /// the larger of both.
    pub(crate) p999_px: f64,
    pub(crate) points: u64,
    /// Instances that were measured, and those that are drawn at a level.
    pub(crate) instances: [u64; 2],
    /// The instance that is off the most.
    pub(crate) worst: Option<String>,
    /// Whether the threshold is kept: by 99.9 % of the points, and by all of them to 1.2 of it.
    pub(crate) kept: bool,
}

impl DeviationRecord {
    /// Returns the record of a measurement, with the verdict on it.
    pub(crate) fn of(found: &Measured, worst: Option<String>, lod: &Lod) -> Self {
        let &Measured { max_px, p999_px, points, instances, .. } = found;
        Self {
            threshold_px: lod.pixels,
            at_corners: lod.at_corners,
            max_px,
            p999_px,
            points,
            instances,
            worst,
            kept: found.keeps(lod.pixels),
        }
    }

    /// In a line for people.
    pub(crate) fn text(&self) -> String {
        let place = if self.at_corners { "anywhere in the image" } else { "at the image's centre" };
        // A budget comes to thresholds of many digits.
        let threshold = (self.threshold_px * 1e4).round() / 1e4;
        if self.points == 0 {
            return format!("levels of detail: within {threshold} px {place}; none was drawn");
        }
        let [measured, drawn] = self.instances;
        let of = match measured == drawn {
            true => count(drawn, "instance", "instances"),
            false => format!("{} of {} instances", grouped(measured), grouped(drawn)),
        };
        let worst = self.worst.as_ref().map_or_else(String::new, |name| format!(" (“{name}”)"));
        format!(
            "levels of detail: stated {threshold} px {place}; found 99.9 % within {:.3} px, all within {:.3} px{worst}, \
             by {} on {of}: {}",
            self.p999_px,
            self.max_px,
            count(self.points, "point", "points"),
            if self.kept { "kept" } else { "NOT KEPT" },
        )
    }
}

/// Sums over the views.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct LevelsSummary {
    /// Over all views; those that are visible over the views that were verified.
    pub(crate) ladder: LadderRecord,
    pub(crate) drawn: Vec<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) impostor_level: Option<u32>,
    pub(crate) chosen: Vec<u64>,
    pub(crate) pixels: Option<PixelRecord>,
    /// The worst of the views.
    pub(crate) deviation: Option<DeviationRecord>,
    /// Triangles drawn with levels over triangles that are visible in full, in the views that were
    /// verified.
    pub(crate) drawn_over_visible_in_full: Option<f64>,
}

impl LevelsSummary {
    /// Summarises the views of a run; `None` where levels are off.
    pub(crate) fn of<'a>(views: impl Iterator<Item = &'a LevelsRecord>) -> Option<Self> {
        let mut sum: Option<Self> = None;
        let mut verified = [0, 0];
        for v in views {
            let s = sum.get_or_insert_with(|| Self {
                ladder: LadderRecord::default(),
                drawn: Vec::new(),
                impostor_level: v.impostor_level,
                chosen: Vec::new(),
                pixels: None,
                deviation: None,
                drawn_over_visible_in_full: None,
            });
            s.ladder.add(&v.ladder);
            add(&mut s.drawn, &v.drawn);
            add(&mut s.chosen, &v.chosen);
            if let Some(p) = v.pixels {
                let all = s.pixels.get_or_insert_default();
                all.all += p.all;
                all.differ += p.differ;
                all.silhouette += p.silhouette;
                all.uncovered += p.uncovered;
            }
            if let Some(visible) = v.ladder.visible_in_full {
                verified = [verified[0] + v.ladder.levels, verified[1] + visible];
            }
            if let Some(d) = &v.deviation {
                s.deviation = Some(s.deviation.take().map_or_else(|| d.clone(), |old| old.with(d)));
            }
        }
        if let Some(s) = &mut sum {
            let [drawn, visible] = verified;
            s.drawn_over_visible_in_full = (visible > 0).then(|| drawn as f64 / visible as f64);
        }
        sum
    }

    /// Whether what was found contradicts what is stated.
    pub(crate) fn is_broken(&self) -> bool {
        self.deviation.as_ref().is_some_and(|d| !d.kept)
    }

    /// Returns the name for the triangles of a level.
    pub(crate) fn name(&self, level: u32) -> String {
        match level {
            0 => "in full".to_owned(),
            _ if self.impostor_level == Some(level) => "boxes of impostors".to_owned(),
            _ => format!("level {level}"),
        }
    }

    /// In lines for people; per view.
    pub(crate) fn lines(&self, views: u64) -> Vec<String> {
        let l = &self.ladder;
        let n = |v: u64| grouped(v / views.max(1));
        let mut lines = vec![format!(
            "triangles per view: {} all → {} in the frustum → {} not facing away → {} not hidden → {} with levels",
            n(l.all),
            n(l.frustum),
            n(l.backface),
            n(l.occlusion),
            n(l.levels)
        )];
        if let (Some(visible), Some(full)) = (l.visible, l.visible_in_full) {
            lines[0] += &format!(" → {} visible ({} in full)", n(visible), n(full));
        }
        let drawn: u64 = self.drawn.iter().sum();
        let shares = (0..).zip(&self.drawn).filter(|s| *s.1 > 0);
        let shares = shares.map(|(step, &n)| format!("{} {}", self.name(step), percent(n, drawn)));
        lines.push(format!("drawn by level: {}", shares.collect::<Vec<_>>().join(", ")));
        lines.extend(self.deviation.as_ref().map(DeviationRecord::text));
        if let Some(p) = self.pixels {
            lines.push(format!(
                "{} of the pixels show another instance than in full, {} at silhouettes before the background; {} what was taken for \
                 small or out of reach of the eye's cell",
                percent(p.differ, p.all),
                percent(p.silhouette, p.all),
                count(p.uncovered, "pixel shows", "pixels show"),
            ));
        }
        lines
    }
}

impl LadderRecord {
    fn add(&mut self, o: &Self) {
        self.all += o.all;
        self.frustum += o.frustum;
        self.backface += o.backface;
        self.occlusion += o.occlusion;
        self.levels += o.levels;
        let add = |a: &mut Option<u64>, b: Option<u64>| {
            if let Some(b) = b {
                *a = Some(a.unwrap_or(0) + b);
            }
        };
        add(&mut self.visible, o.visible);
        add(&mut self.visible_in_full, o.visible_in_full);
    }
}

impl DeviationRecord {
    /// The worse of both, and the points of both.
    fn with(mut self, o: &Self) -> Self {
        if o.max_px > self.max_px {
            self.worst.clone_from(&o.worst);
            self.max_px = o.max_px;
        }
        self.threshold_px = self.threshold_px.max(o.threshold_px);
        self.p999_px = self.p999_px.max(o.p999_px);
        self.points += o.points;
        self.instances = [0, 1].map(|i| self.instances[i] + o.instances[i]);
        self.kept &= o.kept;
        self
    }
}

impl From<LevelPixels> for PixelRecord {
    fn from(p: LevelPixels) -> Self {
        let LevelPixels { all, differ, silhouette, uncovered } = p;
        Self { all, differ, silhouette, uncovered }
    }
}

/// Adds counts, the shorter list as if it had zeros.
fn add(sum: &mut Vec<u64>, more: &[u64]) {
    sum.resize(sum.len().max(more.len()), 0);
    sum.iter_mut().zip(more).for_each(|(a, b)| *a += b);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(p999_px: f64, max_px: f64) -> DeviationRecord {
        let found = Measured { p999_px, max_px, points: 10, ..Measured::default() };
        DeviationRecord::of(&found, None, &Lod::default().with_pixels(2.0))
    }

    #[test]
    fn a_bound_is_kept_by_nearly_all_and_missed_by_little() {
        for (p999, max, kept) in [
            (2.0, 2.4, true),
            (1.0, 2.0, true),
            (2.01, 2.1, false),
            (1.0, 2.41, false),
            (f64::NAN, 1.0, false),
        ] {
            assert_eq!(found(p999, max).kept, kept, "{p999} {max}");
        }
        let text = found(2.01, 2.1).text();
        assert!(text.contains("stated 2 px") && text.ends_with("NOT KEPT"), "{text}");
    }

    #[test]
    fn sums_take_the_worst_view_and_only_verified_ones_for_ratios() {
        let view = |levels: u64, visible: Option<u64>, max_px: f64| LevelsRecord {
            ladder: LadderRecord {
                all: 100,
                levels,
                visible_in_full: visible,
                ..LadderRecord::default()
            },
            drawn: vec![levels; visible.map_or(1, |_| 2)],
            impostor_level: None,
            chosen: Vec::new(),
            pixels: None,
            deviation: visible.map(|_| found(1.0, max_px)),
        };
        let views = [view(30, Some(10), 2.2), view(50, None, 0.0), view(10, Some(10), 2.6)];
        let sum = LevelsSummary::of(views.iter()).unwrap();
        assert_eq!(sum.drawn_over_visible_in_full, Some(2.0));
        assert_eq!((sum.ladder.levels, &sum.drawn[..]), (90, &[90, 40][..]));
        let d = sum.deviation.as_ref().unwrap();
        assert_eq!((d.max_px, d.points, d.kept), (2.6, 20, false));
        assert!(sum.is_broken());
        assert!(LevelsSummary::of([].into_iter()).is_none());
        let lines = sum.lines(3);
        assert!(lines[0].contains("30 with levels") && lines[1].contains("level 1"), "{lines:?}");
    }
}
