//! The scene from above, every instance coloured by its fate.

use std::cmp::Reverse;

use cullet::{Scene, Stage, View, Visible};
use glam::DVec3;

use super::Picture;
use super::canvas::{LINE, grouped, hull};
use super::font::{text_height, text_size, text_width};
use super::outside::contents;
use super::palette::{CHALK, DROPPED, NIGHT, SEEN, UNSEEN, mix, reason_color, reason_label};
use super::space::Space;
use crate::frame::PixelId;

/// Fate of an instance: dropped, and by which stage, or kept, and seen or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Fate {
    Dropped(Option<Stage>),
    Unseen,
    Seen,
}

impl Fate {
    pub(crate) fn color(self) -> [u8; 3] {
        match self {
            Self::Seen => SEEN,
            Self::Unseen => UNSEEN,
            Self::Dropped(Some(stage)) => reason_color(Some(stage)),
            Self::Dropped(None) => DROPPED,
        }
    }

    pub(crate) fn label(self) -> &'static str {
        match self {
            Self::Seen => "kept, and seen",
            Self::Unseen => "kept, not seen",
            Self::Dropped(Some(stage)) => reason_label(Some(stage)),
            Self::Dropped(None) => "dropped",
        }
    }
}

/// Fate of every slot: `None` for an empty one. A kept instance is seen if it is in `seen`, which must be
/// sorted.
pub(crate) fn fates(scene: &Scene, visible: &Visible, seen: &[PixelId]) -> Vec<Option<Fate>> {
    let mut kept = vec![false; scene.slot_count() as usize];
    let mut keep = |slot: u32| {
        if let Some(k) = kept.get_mut(slot as usize) {
            *k = true;
        }
    };
    visible.triangle_ranges.iter().filter(|r| r.count > 0).for_each(|r| keep(r.slot));
    visible.whole.iter().flat_map(|r| r.first..r.first.saturating_add(r.count)).for_each(&mut keep);
    visible.partial.iter().for_each(|r| keep(r.slot));
    (0..scene.slot_count())
        .map(|slot| {
            let reason = visible.reasons.get(slot as usize).copied().flatten();
            let fate = match reason {
                _ if scene.is_removed(slot) => return None,
                Some(reason) => Fate::Dropped(Some(reason.stage)),
                None if !kept[slot as usize] => Fate::Dropped(None),
                None => {
                    let i = seen.partition_point(|id| id.slot < slot);
                    let is_seen = seen.get(i).is_some_and(|id| id.slot == slot);
                    if is_seen { Fate::Seen } else { Fate::Unseen }
                }
            };
            Some(fate)
        })
        .collect()
}

/// A map of the scene from above: the outline of every instance coloured by the stage that dropped it, or
/// by whether it is seen; the outline of the frustum; and a legend with counts.
///
/// `visible` must have reasons; `seen` is the exact visible set ([`Frame::visible`](crate::Frame::visible)),
/// sorted. `size` is the width and height of the picture, legend included, at least 320 × 200. What
/// has no finite bounds is not drawn, and counted. Cost: under a microsecond an instance, and its pixels.
#[must_use]
pub fn top_down(
    scene: &Scene,
    view: &View,
    visible: &Visible,
    seen: &[PixelId],
    size: [u32; 2],
) -> Picture {
    let [width, height] = [size[0].max(320), size[1].max(200)];
    let size = text_size(width);
    let fates = fates(scene, visible, seen);
    let legend_width = Legend::width(size) as u32 + 40;
    let map = Map::new(scene, view, [width - legend_width.min(width / 2), height]);

    let mut picture = Picture::new(width, height, NIGHT);
    let space = Space::new(view);
    let frustum = map.frustum(&space);
    picture.fill_convex(&frustum, CHALK, 0.13);

    let mut places: Vec<(Fate, u32, Vec<[f64; 2]>)> = (0..)
        .zip(&fates)
        .filter_map(|(slot, fate)| {
            let place = map.outline(scene, slot)?;
            (*fate).map(|fate| (fate, slot, place))
        })
        .collect();
    // Dropped instances lie below kept ones, and large ones below small ones.
    let area = |p: &[[f64; 2]]| {
        let term = |i: usize| {
            let (a, b) = (p[i], p[(i + 1) % p.len()]);
            a[0] * b[1] - b[0] * a[1]
        };
        (0..p.len()).map(term).sum::<f64>().abs() * 0.5
    };
    let whole = f64::from(map.size[0]) * f64::from(map.size[1]);
    let is_large = |p: &[[f64; 2]]| area(p) > 0.15 * whole;
    // Alone on the map, even a large instance covers no other.
    let crowded = places.iter().any(|(_, _, place)| !is_large(place));
    let is_ground = |p: &[[f64; 2]]| crowded && is_large(p);
    // Bits of numbers that are not negative ascend as they do.
    places.sort_by_cached_key(|(fate, slot, place)| {
        (Reverse(is_ground(place)), *fate, Reverse(area(place).to_bits()), *slot)
    });
    for (fate, _, place) in &places {
        draw_place(&mut picture, place, *fate, area(place), is_ground(place));
    }
    picture.outline(&frustum, 1.6, CHALK, 0.9);
    if space.eye.w != 0.0 {
        let [x, y] = map.at(space.eye.truncate());
        for (r, color) in [(6.0, NIGHT), (4.5, CHALK)] {
            let circle: Vec<[f64; 2]> = (0..24)
                .map(|k| (f64::from(k) * std::f64::consts::TAU / 24.0).sin_cos())
                .map(|(s, c)| [x + c * r, y + s * r])
                .collect();
            picture.fill_convex(&circle, color, 1.0);
        }
    }
    // The drawing may have spilled beyond the map.
    let [left, legend] = [map.size[0], width - map.size[0]].map(i64::from);
    picture.fill([left, 0], [legend, i64::from(height)], NIGHT, 1.0);
    picture.fill([left, 0], [1, i64::from(height)], CHALK, 0.35);
    let counts = counts(&fates);
    let legend = Legend { at: [left + 20, 20], size, ink: CHALK, paper: NIGHT };
    let total: u64 = counts.iter().map(|c| c.1).sum();
    legend.draw(&mut picture, "seen from above", &plural(total, "instance"), &counts);
    picture
}

fn draw_place(picture: &mut Picture, place: &[[f64; 2]], fate: Fate, area: f64, ground: bool) {
    let color = fate.color();
    if ground {
        // So large that it would drown the rest.
        picture.fill_convex(place, color, 0.06);
        picture.outline(place, 1.0, color, 0.6);
    } else if area < 5.0 {
        // A dot, at least.
        let middle = |axis: usize| {
            let sum: f64 = place.iter().map(|p| p[axis]).sum();
            (sum / place.len() as f64).floor() as i64
        };
        let side = if fate == Fate::Seen { 3 } else { 2 };
        picture.fill([middle(0), middle(1)], [side, side], color, 0.9);
    } else {
        picture.fill_convex(place, color, 0.92);
        if area > 40.0 {
            picture.outline(place, 0.8, mix(color, NIGHT, 0.6), 0.8);
        }
    }
}

impl Fate {
    /// The place in a legend: what is kept, and then what was dropped in the order of the stages.
    fn place(self) -> (u32, Option<Stage>) {
        match self {
            Self::Seen => (0, None),
            Self::Unseen => (1, None),
            Self::Dropped(stage) => (2, stage),
        }
    }
}

/// How many there are of each fate that occurs, in the order of a legend.
pub(crate) fn counts(fates: &[Option<Fate>]) -> Vec<(Fate, u64)> {
    let mut sorted: Vec<Fate> = fates.iter().copied().flatten().collect();
    sorted.sort_unstable_by_key(|f| f.place());
    sorted.chunk_by(|a, b| a == b).map(|run| (run[0], run.len() as u64)).collect()
}

/// Brings counts into the order of a legend.
pub(crate) fn sort_counts(counts: &mut [(Fate, u64)]) {
    counts.sort_unstable_by_key(|c| c.0.place());
}

/// So many of something, in words.
pub(crate) fn plural(n: u64, noun: &str) -> String {
    format!("{} {noun}{}", grouped(n), if n == 1 { "" } else { "s" })
}

/// A title, what is counted, and a square, words and a count for each fate.
pub(crate) struct Legend {
    pub(crate) at: [i64; 2],
    /// Of the text, in pixels an em.
    pub(crate) size: f64,
    pub(crate) ink: [u8; 3],
    pub(crate) paper: [u8; 3],
}

impl Legend {
    /// From one line to the next.
    fn line(&self) -> i64 {
        (self.size * LINE).round() as i64
    }

    /// How wide the widest legend is, from the left of its squares.
    pub(crate) fn width(size: f64) -> i64 {
        let labels = Stage::ALL.into_iter().map(|s| reason_label(Some(s)));
        let widest = labels.map(|label| text_width(label, size)).max().unwrap_or(0);
        widest.max(text_width("the view and its culling", size)) + Self::indent(size)
    }

    /// From the left of a square to the words beside it.
    fn indent(size: f64) -> i64 {
        (size * 1.6) as i64
    }

    /// How high it is with so many entries.
    pub(crate) fn height(&self, entries: usize) -> i64 {
        self.line() * (5 + 5 * entries as i64) / 2
    }

    pub(crate) fn draw(
        &self,
        picture: &mut Picture,
        title: &str,
        counted: &str,
        counts: &[(Fate, u64)],
    ) {
        let ([x, y], size, line) = (self.at, self.size, self.line());
        let soft = mix(self.ink, self.paper, 0.3);
        picture.text([x, y], title, size, self.ink);
        picture.text([x, y + line], counted, size, soft);
        let total: u64 = counts.iter().map(|c| c.1).sum();
        let mut top = y + line * 5 / 2;
        for (fate, n) in counts {
            let side = text_height(size) + 4;
            picture.fill([x, top - 2], [side; 2], mix(self.ink, self.paper, 0.45), 1.0);
            picture.fill([x + 1, top - 1], [side - 2; 2], fate.color(), 1.0);
            let left = x + Self::indent(size);
            picture.text([left, top], fate.label(), size, self.ink);
            let percent = *n as f64 / total.max(1) as f64 * 100.0;
            let text = format!("{}   {percent:.1} %", grouped(*n));
            picture.text([left, top + line], &text, size, soft);
            top += line * 5 / 2;
        }
    }
}

/// From the world to the picture: x to the right, z down.
pub(super) struct Map {
    pub(super) size: [u32; 2],
    middle: [f64; 2],
    pixels: f64,
    /// As far as anything on the map can be.
    reach: f64,
}

impl Map {
    pub(super) fn new(scene: &Scene, view: &View, size: [u32; 2]) -> Self {
        let origin = DVec3::from(scene.origin());
        let extent = contents(scene);
        let (mut low, mut high) = match extent.is_empty() {
            true => (DVec3::splat(-1.0), DVec3::splat(1.0)),
            false => (
                DVec3::from(extent.min.map(f64::from)) + origin,
                DVec3::from(extent.max.map(f64::from)) + origin,
            ),
        };
        let diagonal = (high - low).length();
        let eye = glam::DVec4::from(view.eye());
        // The eye belongs on the map unless it is so far off that the scene would shrink to a dot.
        let e = eye.truncate();
        if eye.w != 0.0 && (e - (low + high) * 0.5).length() < 1.5 * diagonal {
            (low, high) = (low.min(e), high.max(e));
        }
        let room = (high - low).max(DVec3::splat(diagonal * 1e-3).max(DVec3::splat(1e-9)));
        let fit = |length: f64, pixels: u32| f64::from(pixels) * 0.92 / length;
        let pixels = fit(room.x, size[0]).min(fit(room.z, size[1]));
        let middle = (low + high) * 0.5;
        Self { size, middle: [middle.x, middle.z], pixels, reach: room.length() * 2.0 }
    }

    pub(super) fn at(&self, p: DVec3) -> [f64; 2] {
        [
            (p.x - self.middle[0]) * self.pixels + f64::from(self.size[0]) * 0.5,
            (p.z - self.middle[1]) * self.pixels + f64::from(self.size[1]) * 0.5,
        ]
    }

    /// The outline of an instance: the hull of the corners of its mesh's box.
    fn outline(&self, scene: &Scene, slot: u32) -> Option<Vec<[f64; 2]>> {
        let (transform, bounds) = (scene.transform(slot), scene.mesh(slot).bounds());
        if scene.is_removed(slot) || !transform.is_finite() || bounds.is_empty() {
            return None;
        }
        let m = glam::DMat4::from_cols_array(&transform.to_matrix());
        let corner = |c: [f32; 3]| self.at(m.transform_point3(DVec3::from(c.map(f64::from))));
        let place = hull(&bounds.corners().map(corner));
        (!place.is_empty()).then_some(place)
    }

    /// The outline of the frustum, as far as it reaches on the map.
    pub(super) fn frustum(&self, space: &Space) -> Vec<[f64; 2]> {
        let mut points = Vec::new();
        for [x, y] in [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]] {
            points.push(self.at(space.ray(x, y).0));
            points.push(self.at(space.along(x, y, self.reach)));
        }
        hull(&points)
    }
}
