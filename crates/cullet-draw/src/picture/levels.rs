//! Levels of detail: which are drawn, and what that changes.

use cullet::{Scene, View, Visible};
use glam::DVec3;

use super::Picture;
use super::canvas::{grouped, keys, keys_height};
use super::font::{text_height, text_size};
use super::palette::{INK, PAPER, heat, level_color};
use super::shaded::{light_evenly, light_through, linear};
use super::space::Surfaces;
use crate::frame::{Frame, PixelId, RenderOptions, Selection};
use crate::render::render;
use crate::steps::LevelSteps;

/// Space around the legend.
const MARGIN: i64 = 10;
/// Between pictures that stand side by side.
const GAP: u32 = 8;
/// Differences up to this are not painted: they are no more than rounding.
const SAME: u8 = 3;

/// Draws what a culler left of a scene, each triangle in the colour of its level of detail: how
/// often it was simplified. A legend below it counts the drawn triangles of each level. `visible`
/// must have its triangles.
///
/// Cost: a frame of four times the view's pixels, and 0.3 µs for each of those.
#[must_use]
pub fn levels(scene: &Scene, view: &View, visible: &Visible) -> Picture {
    let steps = LevelSteps::new(scene);
    let lit = of_levels(scene, view, visible, &steps, |frame, surfaces, color| {
        // Colours carry the meaning: no haze.
        light_through(0.0, scene, frame, view, surfaces, color)
    });
    let counts = steps.count(visible);
    let total: u64 = counts.iter().sum();
    let shown = (0..).zip(&counts).filter(|c| *c.1 > 0);
    let entries: Vec<([u8; 3], String)> = shown
        .map(|(step, &n)| {
            let name = match step {
                0 => "in full".to_owned(),
                _ if steps.impostor() == Some(step) => "boxes of impostors".to_owned(),
                _ => format!("level {step}"),
            };
            let share = n as f64 / total.max(1) as f64 * 100.0;
            (level_color(step), format!("{name}: {} ({share:.1} %)", grouped(n)))
        })
        .collect();
    let size = text_size(lit.width);
    let room = i64::from(lit.width) - 2 * MARGIN;
    let title = text_height(size) * 2;
    let below = title + keys_height(room, size, &entries) + 2 * MARGIN;
    let mut picture = Picture::new(lit.width, lit.height + below as u32, PAPER);
    picture.rgb[..lit.rgb.len()].copy_from_slice(&lit.rgb);
    let y = i64::from(lit.height) + MARGIN;
    let words = format!("{} triangles, by how often they were simplified", grouped(total));
    picture.text([MARGIN, y], &words, size, INK);
    keys(&mut picture, [MARGIN, y + title], MARGIN + room, size, INK, &entries);
    picture
}

/// Draws what a culler left of a scene, each triangle in the colour of its level of detail, in even
/// light and from anywhere: the levels are those of the view that was culled. Cost: a frame of four
/// times the pixels of `from`.
#[must_use]
pub fn even_levels(scene: &Scene, from: &View, visible: &Visible, steps: &LevelSteps) -> Picture {
    of_levels(scene, from, visible, steps, |frame, surfaces, color| {
        light_evenly(frame, from, surfaces, color)
    })
}

/// A frame of what a culler left, lit in the colours of levels.
fn of_levels(
    scene: &Scene,
    view: &View,
    visible: &Visible,
    steps: &LevelSteps,
    light: impl FnOnce(&Frame, &Surfaces, &(dyn Fn(PixelId) -> DVec3 + Sync)) -> Picture,
) -> Picture {
    let options = RenderOptions { scale: 2, ..RenderOptions::default() };
    let frame = render(scene, view, Selection::Visible(visible), &options);
    let surfaces = Surfaces::of_visible(scene, visible);
    let color = |id: PixelId| {
        let triangle = surfaces.triangle(id).unwrap_or_default();
        let step = steps.of(id.slot, surfaces.level(id.slot), triangle);
        DVec3::from(level_color(step).map(linear))
    };
    light(&frame, &surfaces, &color).halved()
}

/// Where two pictures of one size differ, and by how much: dark as they are alike, brighter the
/// more the channel differs that differs most. Of pictures that are not of one size the part that
/// both have.
#[must_use]
pub fn difference(a: &Picture, b: &Picture) -> Picture {
    let (width, height) = (a.width.min(b.width), a.height.min(b.height));
    let mut rgb = Vec::with_capacity(width as usize * height as usize * 3);
    for y in 0..height {
        for x in 0..width {
            let (p, q) = (a.pixel(x, y), b.pixel(x, y));
            let most = (0..3).map(|k| p[k].abs_diff(q[k])).max().unwrap_or(0);
            let color = if most > SAME {
                // From dark red up: the first colours of the scale are as dark as what is alike.
                heat(0.4 + 0.6 * f64::from(most) / 255.0)
            } else {
                let grey = p.iter().map(|v| u32::from(*v)).sum::<u32>() / 3 / 5;
                [grey as u8; 3]
            };
            rgb.extend(color);
        }
    }
    Picture { width, height, rgb }
}

/// Pictures side by side, each with its words below.
#[must_use]
pub fn beside(pictures: &[(&Picture, &str)]) -> Picture {
    let gaps = GAP * (pictures.len() as u32).saturating_sub(1);
    let width = pictures.iter().map(|p| p.0.width).sum::<u32>() + gaps;
    let height = pictures.iter().map(|p| p.0.height).max().unwrap_or(0);
    let size = text_size(width);
    let strip = (text_height(size) + 2 * MARGIN) as u32;
    let mut all = Picture::new(width, height + strip, PAPER);
    let mut left = 0;
    for (picture, words) in pictures {
        for y in 0..picture.height {
            let row = picture.width as usize * 3;
            let from = y as usize * row;
            let to = (y as usize * width as usize + left as usize) * 3;
            all.rgb[to..to + row].copy_from_slice(&picture.rgb[from..from + row]);
        }
        all.text([i64::from(left) + 4, i64::from(height) + MARGIN], words, size, INK);
        left += picture.width + GAP;
    }
    all
}

#[cfg(test)]
mod tests {
    use cullet::lod::Lod;
    use cullet::{Culler, Instance, Output, Transform};
    use cullet_testkit::answers::cull;
    use cullet_testkit::steps::Balls;
    use cullet_testkit::views::look;

    use super::*;
    use crate::picture::{shaded, shaded_levels};

    #[test]
    fn each_level_has_its_colour_and_the_legend_has_those() {
        let mut scene = Scene::new();
        let mesh = Balls::new(&[64, 16, 8], 1.0).add_to(&mut scene);
        for x in [-1.1, 1.1] {
            scene.add(Instance::new(mesh, Transform::from_translation([x, 0.0, 0.0]))).unwrap();
        }
        scene.commit(&Culler::default());
        let view = look([0.0, 0.0, 6.0], [0.0, 0.0, 0.0], [320, 200]);
        let of = |pixels: f64| {
            let lod = Some(Lod::default().with_pixels(pixels));
            cull(&Culler::default().with_lod(lod).with_output(Output::Triangles), &scene, &view)
        };
        for (pixels, step) in [(1e-3, 0), (1.0, 1), (9.0, 2)] {
            let picture = levels(&scene, &view, &of(pixels));
            assert!(picture.width == 320 && picture.height > 200);
            let below = (200..picture.height).flat_map(|y| (0..320).map(move |x| (x, y)));
            let keys: Vec<[u8; 3]> = below.map(|(x, y)| picture.pixel(x, y)).collect();
            for other in 0..3 {
                assert_eq!(keys.contains(&level_color(other)), other == step, "{pixels} {other}");
            }
        }
    }

    #[test]
    fn what_is_drawn_is_shaded_by_its_own_triangles() {
        let mut scene = Scene::new();
        let mesh = Balls::new(&[64, 32, 4], 1.0).add_to(&mut scene);
        scene.add(Instance::new(mesh, Transform::IDENTITY)).unwrap();
        scene.commit(&Culler::default());
        let view = look([0.0, 0.0, 4.0], [0.0, 0.0, 0.0], [160, 100]);
        let of = |pixels: f64| {
            let lod = Some(Lod::default().with_pixels(pixels));
            let culler = Culler::default().with_lod(lod).with_output(Output::Triangles);
            let visible = cull(&culler, &scene, &view);
            let options = RenderOptions::default();
            let frame = render(&scene, &view, Selection::Visible(&visible), &options);
            shaded_levels(&scene, &frame, &view, &visible, &[])
        };
        let frame = render(&scene, &view, Selection::All, &RenderOptions::default());
        let full = shaded(&scene, &frame, &view, &[]);
        let [none, near, far] = [0.0, 0.5, 99.0].map(of);
        assert_eq!(none, full);
        let changed = |p: &Picture| {
            let painted = difference(&full, p);
            let is_grey = |c: &&[u8; 3]| c[0] == c[1] && c[1] == c[2];
            16_000 - painted.rgb.as_chunks::<3>().0.iter().filter(is_grey).count()
        };
        assert_eq!(changed(&none), 0);
        assert!(changed(&far) > 0);
        let off = |p: &Picture| -> u32 {
            full.rgb.iter().zip(&p.rgb).map(|(a, b)| u32::from(a.abs_diff(*b))).sum()
        };
        assert!(off(&near) > 0 && off(&near) * 3 < off(&far), "{} {}", off(&near), off(&far));
        let all = beside(&[(&full, "before"), (&far, "after")]);
        assert_eq!(all.width, 328);
        assert_eq!(
            (all.pixel(80, 50), all.pixel(248, 50)),
            (full.pixel(80, 50), far.pixel(80, 50))
        );
    }
}
