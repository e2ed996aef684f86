//! One instance of a view, and what came of it.

use cullet::{Scene, Stage, View, Visible, draw::TriangleRange};
use glam::DVec3;

use super::Picture;
use super::canvas::LINE;
use super::font::{text_height, text_size, text_width};
use super::outside::{Outlook, draw_frustum, from_outside};
use super::palette::{INK, PAPER, SUBJECT, mix, reason_color};
use super::shaded::shaded;
use super::space::{Space, corners};
use crate::frame::{Frame, PixelId, RenderOptions, Selection};
use crate::render::render;

/// An instance that stands out, and what is told of it.
#[derive(Clone, Copy, Debug)]
pub struct Highlight<'a> {
    /// Its slot; none, to show the view and the pixel alone.
    pub slot: Option<u32>,
    /// The stage that dropped it, for its colour.
    pub stage: Option<Stage>,
    /// Slots of what hides it.
    pub hidden_by: &'a [u32],
    /// Its screen bounds in pixels of the view: the first corner and the last.
    pub bounds: Option<[[f64; 2]; 2]>,
    /// A pixel to point at.
    pub pixel: Option<[u32; 2]>,
    /// Lines of words, beneath the picture.
    pub words: &'a [String],
}

/// How much of their colour all others lose.
const PALE: f64 = 0.55;

impl Highlight<'_> {
    /// In its own view: the instance in the colour of what dropped it, also where something is
    /// before it, with its box and its screen bounds; what hides it darker than the rest. Has the
    /// size of the view, and beneath it the words. Cost: two frames of four times the view's
    /// pixels, and 0.3 µs for each of those.
    #[must_use]
    pub fn in_view(&self, scene: &Scene, view: &View, material_colors: &[[f32; 4]]) -> Picture {
        let mut picture = self.drawn(scene, view, material_colors).0;
        let space = Space::new(view);
        let size = [picture.width, picture.height];
        self.draw_box(&mut picture, scene, &space, size);
        if let Some([[x0, y0], [x1, y1]]) = self.bounds {
            let rectangle = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
            picture.outline(&rectangle, 3.4, PAPER, 0.8);
            picture.outline(&rectangle, 1.6, INK, 1.0);
        }
        if let Some([x, y]) = self.pixel.map(|p| p.map(|v| f64::from(v) + 0.5)) {
            for (width, color) in [(4.0, PAPER), (1.6, INK)] {
                for [dx, dy] in [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]] {
                    let at = |d: f64| [x + dx * d, y + dy * d];
                    picture.line(at(4.0), at(16.0), width, color, 1.0);
                }
            }
        }
        self.with_words(&picture)
    }

    /// From outside of the view, with its frustum: for what is beside it.
    #[must_use]
    pub fn from_outside(
        &self,
        scene: &Scene,
        view: &View,
        material_colors: &[[f32; 4]],
    ) -> Picture {
        let from = Outlook::new(scene, view, view.viewport()).from;
        let from = from_outside(&from);
        let (mut picture, frame) = self.drawn(scene, &from, material_colors);
        draw_frustum(&mut picture, scene, view, &from, &frame);
        let size = [picture.width, picture.height];
        self.draw_box(&mut picture, scene, &Space::new(&from), size);
        self.with_words(&picture)
    }

    /// A view with all pale but the instance and what hides it, and its frame at twice the size.
    fn drawn(&self, scene: &Scene, view: &View, colors: &[[f32; 4]]) -> (Picture, Frame) {
        let options = RenderOptions { scale: 2, ..RenderOptions::default() };
        let frame = render(scene, view, Selection::All, &options);
        let mut picture = shaded(scene, &frame, view, colors);
        let alone = self.slot.map(|slot| {
            let count = scene.mesh(slot).triangle_count();
            let own = TriangleRange { slot, level: 0, first: 0, count };
            let all = Visible {
                triangle_ranges: vec![own],
                triangles: (0..count).collect(),
                ..Visible::default()
            };
            render(scene, view, Selection::Visible(&all), &options)
        });
        let color = self.color();
        for (at, rgb) in picture.rgb.as_chunks_mut::<3>().0.iter_mut().enumerate() {
            let owner = frame.ids[at].slot;
            let is_there = alone.as_ref().is_some_and(|alone| alone.ids[at] != PixelId::NONE);
            let before = *rgb;
            *rgb = match (Some(owner) == self.slot, self.hidden_by.contains(&owner)) {
                (true, _) => mix(before, color, 0.6),
                (_, true) => mix(before, INK, 0.35),
                _ => mix(before, PAPER, PALE),
            };
            if is_there && Some(owner) != self.slot {
                // Behind something: as a ghost.
                *rgb = mix(*rgb, color, 0.5);
            }
        }
        (picture.halved(), frame)
    }

    fn color(&self) -> [u8; 3] {
        self.stage.map_or(SUBJECT, |stage| reason_color(Some(stage)))
    }

    /// The edges of its box.
    fn draw_box(&self, picture: &mut Picture, scene: &Scene, space: &Space, size: [u32; 2]) {
        let Some(slot) = self.slot else { return };
        let bounds = scene.bounds(slot);
        if !bounds.is_finite() || bounds.is_empty() {
            return;
        }
        let all = corners(scene, &bounds);
        for (width, color) in [(3.6, PAPER), (1.8, mix(self.color(), INK, 0.3))] {
            for (i, k) in (0..8usize).flat_map(|i| (0..3).map(move |k| (i, k))) {
                if i >> k & 1 == 1 {
                    continue;
                }
                if let Some([a, b]) = segment(space, all[i], all[i | 1 << k], size) {
                    picture.line(a, b, width, color, 0.9);
                }
            }
        }
    }

    /// The picture with a sheet of words beneath it.
    fn with_words(&self, picture: &Picture) -> Picture {
        const MARGIN: i64 = 12;
        let size = text_size(picture.width);
        let room = i64::from(picture.width) - 2 * MARGIN;
        let widest = self.words.iter().map(|words| text_width(words, size)).max().unwrap_or(0);
        // Smaller where a line would not fit.
        let size = (size * room as f64 / widest.max(1) as f64).clamp(9.0, size);
        let line = (size * LINE).round() as i64;
        let below = line * self.words.len() as i64 + 2 * MARGIN - line + text_height(size);
        let mut all = Picture::new(picture.width, picture.height + below.max(0) as u32, PAPER);
        all.rgb[..picture.rgb.len()].copy_from_slice(&picture.rgb);
        let top = i64::from(picture.height) + MARGIN;
        all.fill([0, i64::from(picture.height)], [4, below], self.color(), 1.0);
        for (words, row) in self.words.iter().zip(0..) {
            all.text([MARGIN, top + row * line], words, size, INK);
        }
        all
    }
}

/// A segment on a picture, as far as it is in front of the eye.
fn segment(space: &Space, a: DVec3, b: DVec3, size: [u32; 2]) -> Option<[[f64; 2]; 2]> {
    const STEPS: u32 = 64;
    let at = |k: u32| space.project(a.lerp(b, f64::from(k) / f64::from(STEPS)), size);
    let first = (0..=STEPS).find_map(&at)?;
    let last = (0..=STEPS).rev().find_map(at)?;
    Some([first.0, last.0])
}

#[cfg(test)]
mod tests {
    use cullet_testkit::views::look;

    use super::*;

    #[test]
    fn who_is_told_of_stands_out() {
        let scene = cullet_scenes::build("solids:n=20").unwrap().scene;
        let view = look([0.0, 1.0, 9.0], [0.0, 0.5, 0.0], [160, 90]);
        let frame = render(&scene, &view, Selection::All, &RenderOptions::default());
        let slot = frame.ids.iter().map(|id| id.slot).find(|s| *s != u32::MAX).unwrap();
        let words = ["who".to_owned(), "and why".to_owned()];
        let of = |slot, stage| Highlight {
            slot,
            stage,
            hidden_by: &[],
            bounds: None,
            pixel: Some([80, 45]),
            words: &words,
        };
        let blue = |p: &Picture| {
            let is_blue = |c: &&[u8; 3]| i32::from(c[2]) - i32::from(c[0]) > 60;
            p.rgb.as_chunks::<3>().0.iter().filter(is_blue).count()
        };
        let shown = of(Some(slot), None).in_view(&scene, &view, &[]);
        let none = of(None, None).in_view(&scene, &view, &[]);
        assert!(shown.width == 160 && shown.height > 90);
        assert!(blue(&shown) > blue(&none) + 10, "{} {}", blue(&shown), blue(&none));
        let outside = of(Some(slot), Some(Stage::Frustum)).from_outside(&scene, &view, &[]);
        assert_eq!([outside.width >= 160, outside.height > 90], [true; 2]);
    }
}
