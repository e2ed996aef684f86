//! The scene from above, every instance coloured by its fate.

use cullet::{Scene, Stage, View, Visible};
use glam::DVec3;

use super::Picture;
use super::canvas::{LINE, add_hull, grouped, hull};
use super::font::{text_height, text_size, text_width};
use super::outside::contents;
use super::palette::{CHALK, DROPPED, NIGHT, SEEN, UNSEEN, mix, reason_color, reason_label};
use super::space::Space;
use crate::frame::PixelId;
use crate::{parallel, sort};

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

/// Fate of every slot: `None` for an empty one. A kept instance is seen if it is in `seen`, which
/// must be sorted.
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

/// A map of the scene from above: the outline of every instance coloured by the stage that dropped
/// it, or by whether it is seen; the outline of the frustum; and a legend with counts.
///
/// `visible` must have reasons; `seen` is the exact visible set
/// ([`Frame::visible`](crate::Frame::visible)), sorted. `size` is the width and height of the
/// picture, legend included, at least 320 × 200. What has no finite bounds is not drawn, and
/// counted. Cost: under a microsecond an instance, and its pixels.
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

    let outlines = parallel::tasks(fates.len(), 1024, &|slots| {
        let mut outlines = Outlines::default();
        for (slot, fate) in (slots.start as u32..).zip(&fates[slots]) {
            if let Some(fate) = *fate {
                outlines.add(&map, scene, slot, fate);
            }
        }
        outlines
    });
    let places: Vec<Place> = outlines.iter().flat_map(Outlines::places).collect();
    let whole = f64::from(map.size[0]) * f64::from(map.size[1]);
    let is_large = |place: &Place| place.area > 0.15 * whole;
    // Alone on the map, even a large instance covers no other.
    let crowded = places.iter().any(|place| !is_large(place));
    let is_ground = |place: &Place| crowded && is_large(place);
    // Dropped instances lie below kept ones, and large ones below small ones.
    let places = sort::sorted_by(&places, |place| !sort::bits(place.area));
    let places = sort::sorted_by(&places, |place| {
        let fate = match place.fate {
            Fate::Dropped(stage) => stage.map_or(0, |stage| stage as u64),
            Fate::Unseen => 1 << 8,
            Fate::Seen => 2 << 8,
        };
        if is_ground(place) { fate } else { fate + (3 << 8) }
    });
    for place in &places {
        draw_place(&mut picture, place, is_ground(place));
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
    let mut tally = Tally::default();
    fates.iter().flatten().for_each(|&fate| tally.add(fate, 1));
    let counts = tally.entries();
    let legend = Legend { at: [left + 20, 20], size, ink: CHALK, paper: NIGHT };
    let total: u64 = counts.iter().map(|c| c.1).sum();
    legend.draw(&mut picture, "seen from above", &plural(total, "instance"), &counts);
    picture
}

/// An instance on the map.
#[derive(Clone, Copy)]
struct Place<'a> {
    fate: Fate,
    area: f64,
    /// Hull of the corners of its mesh's box.
    outline: &'a [[f64; 2]],
}

/// Outlines of some instances, end to end.
#[derive(Default)]
struct Outlines {
    points: Vec<[f64; 2]>,
    /// Fate and area of each, and where its points end.
    ends: Vec<(Fate, f64, usize)>,
    room: Vec<[f64; 2]>,
}

impl Outlines {
    fn add(&mut self, map: &Map, scene: &Scene, slot: u32, fate: Fate) {
        let (transform, bounds) = (scene.transform(slot), scene.mesh(slot).bounds());
        if scene.is_removed(slot) || !transform.is_finite() || bounds.is_empty() {
            return;
        }
        let m = glam::DMat4::from_cols_array(&transform.to_matrix());
        let corner = |c: [f32; 3]| map.at(m.transform_point3(DVec3::from(c.map(f64::from))));
        let first = self.points.len();
        add_hull(&bounds.corners().map(corner), &mut self.room, &mut self.points);
        let p = &self.points[first..];
        let term = |i: usize| {
            let (a, b) = (p[i], p[(i + 1) % p.len()]);
            a[0] * b[1] - b[0] * a[1]
        };
        let area = (0..p.len()).map(term).sum::<f64>().abs() * 0.5;
        if !p.is_empty() {
            self.ends.push((fate, area, self.points.len()));
        }
    }

    fn places(&self) -> Vec<Place<'_>> {
        let mut first = 0;
        let place = |&(fate, area, end): &(Fate, f64, usize)| {
            let outline = &self.points[first..end];
            first = end;
            Place { fate, area, outline }
        };
        self.ends.iter().map(place).collect()
    }
}

fn draw_place(picture: &mut Picture, place: &Place, ground: bool) {
    let (color, outline) = (place.fate.color(), place.outline);
    if ground {
        // So large that it would drown the rest.
        picture.fill_convex(outline, color, 0.06);
        picture.outline(outline, 1.0, color, 0.6);
    } else if place.area < 5.0 {
        // A dot, at least.
        let middle = |axis: usize| {
            let sum: f64 = outline.iter().map(|p| p[axis]).sum();
            (sum / outline.len() as f64).floor() as i64
        };
        let side = if place.fate == Fate::Seen { 3 } else { 2 };
        picture.fill([middle(0), middle(1)], [side, side], color, 0.9);
    } else {
        picture.fill_convex(outline, color, 0.92);
        if place.area > 40.0 {
            picture.outline(outline, 0.8, mix(color, NIGHT, 0.6), 0.8);
        }
    }
}

/// Counts of each fate, in the order of a legend: what is kept, and then what was dropped in the
/// order of the stages.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally([u64; 3 + Stage::ALL.len()]);

impl Tally {
    /// Adds `n` of a fate.
    pub(crate) fn add(&mut self, fate: Fate, n: u64) {
        let place = match fate {
            Fate::Seen => 0,
            Fate::Unseen => 1,
            Fate::Dropped(stage) => stage.map_or(2, |stage| 2 + stage as usize),
        };
        self.0[place] += n;
    }

    /// Adds what another counted.
    pub(crate) fn join(&mut self, other: &Self) {
        self.0.iter_mut().zip(other.0).for_each(|(n, other)| *n += other);
    }

    /// Fates that occur, and their counts.
    pub(crate) fn entries(&self) -> Vec<(Fate, u64)> {
        let mut entries = Vec::new();
        for (place, &n) in self.0.iter().enumerate().filter(|(_, n)| **n > 0) {
            let fate = match place {
                0 => Fate::Seen,
                1 => Fate::Unseen,
                _ => Fate::Dropped(place.checked_sub(3).map(|stage| Stage::ALL[stage])),
            };
            entries.push((fate, n));
        }
        entries
    }
}

/// So many of something, in words.
pub(crate) fn plural(n: u64, noun: &str) -> String {
    format!("{} {noun}{}", grouped(n), if n == 1 { "" } else { "s" })
}

/// A title, what is counted, and a square, words and a count for each fate.
pub(crate) struct Legend {
    pub(crate) at: [i64; 2],
    /// Size of the text, in pixels an em.
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
    /// Farthest distance at which anything on the map can be.
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
