//! How many triangles are drawn on each pixel, as a heat map.

use super::Picture;
use super::canvas::grouped;
use super::font::{text_height, text_size, text_width};
use super::palette::{INK, PAPER, heat};
use crate::frame::Frame;

/// Height of the strip with the legend.
const STRIP: u32 = 76;

/// A heat map of the fragments on each pixel, with a legend below: of one frame, or of the same
/// view without culling (left) and with it (right).
///
/// Both need [`RenderOptions::count_layers`](crate::RenderOptions::count_layers); a frame without
/// counts shows one layer wherever something is. One scale, logarithmic, serves both. Cost:
/// nanoseconds a pixel.
#[must_use]
pub fn depth_complexity(before: &Frame, after: Option<&Frame>) -> Picture {
    let counts = |frame: &Frame| -> Vec<u32> {
        if frame.layers.is_empty() {
            let covered = |d: &crate::PixelId| u32::from(*d != crate::PixelId::NONE);
            return frame.ids.iter().map(covered).collect();
        }
        frame.layers.clone()
    };
    let frames: Vec<(&Frame, Vec<u32>)> =
        std::iter::once(before).chain(after).map(|f| (f, counts(f))).collect();
    let most = frames.iter().flat_map(|f| &f.1).copied().max().unwrap_or(0).max(1);
    let share = |n: u32| f64::from(n).ln_1p() / f64::from(most).ln_1p();
    const GAP: u32 = 8;
    let width: u32 =
        frames.iter().map(|f| f.0.width).sum::<u32>() + GAP * (frames.len() as u32 - 1);
    let high = frames.iter().map(|f| f.0.height).max().unwrap_or(0);
    let size = text_size(width);
    let mut picture = Picture::new(width, high + STRIP, PAPER);
    let mut left = 0;
    for (i, (frame, counts)) in frames.iter().enumerate() {
        for (at, &n) in counts.iter().enumerate() {
            let [x, y] = [at as u32 % frame.width, at as u32 / frame.width];
            let color = heat(share(n));
            let to = (y as usize * width as usize + (left + x) as usize) * 3;
            picture.rgb[to..to + 3].copy_from_slice(&color);
        }
        let title = match (i, frames.len()) {
            (_, 1) => "",
            (0, _) => "without culling: ",
            _ => "with culling: ",
        };
        let stats = &frame.stats;
        // As much of it as there is room for.
        let mut text = format!("{title}mean {:.2}", stats.mean_layers);
        for more in [
            format!(" layers, most {}", stats.max_layers),
            format!(", {} fragments", grouped(stats.fragments)),
        ] {
            if text_width(&text, size) + text_width(&more, size) < i64::from(frame.width) - 8 {
                text += &more;
            }
        }
        let y = i64::from(high) + 10;
        picture.text([i64::from(left) + 8, y], &text, size, INK);
        left += frame.width + GAP;
    }
    legend(&mut picture, i64::from(high) + 36, most, size, &share);
    picture
}

fn legend(picture: &mut Picture, y: i64, most: u32, size: f64, share: &dyn Fn(u32) -> f64) {
    let (left, right) = (8, i64::from(picture.width) - 9);
    let length = (right - left).max(1);
    for x in left..=right {
        let color = heat((x - left) as f64 / length as f64);
        picture.fill([x, y], [1, 8], color, 1.0);
    }
    let mut free = left - 4;
    let mut n = 0;
    // The last tick is the greatest count; others leave it room.
    let last = most.to_string();
    let last_left = right - text_width(&last, size);
    loop {
        let at = left + (share(n) * length as f64).round() as i64;
        let label = n.to_string();
        let from = (at - text_width(&label, size) / 2).max(left);
        if n < most && from > free && from + text_width(&label, size) + 4 < last_left {
            picture.fill([at, y + 8], [1, 3], INK, 1.0);
            picture.text([from, y + 13], &label, size, INK);
            free = from + text_width(&label, size) + 8;
        }
        if n >= most {
            break;
        }
        n = if n == 0 { 1 } else { n.saturating_mul(2) };
    }
    picture.fill([right, y + 8], [1, 3], INK, 1.0);
    picture.text([last_left, y + 13], &last, size, INK);
    debug_assert!(y + 13 + text_height(size) <= i64::from(picture.height));
}
