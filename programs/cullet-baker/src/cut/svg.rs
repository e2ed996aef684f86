//! The section as a drawing.

use std::fmt::Write;

use cullet::bounds::Plane;
use cullet::math;
use cullet_cut::{Section, section_frame};
use cullet_io::Model;
use glam::DVec3;

/// Pixels of the longer side.
const SIZE: f64 = 1200.0;

/// So many sizes from zero, a drawing is counted from a place of its own.
const FAR: f64 = 1000.0;

/// Draws every plane's outlines beside each other, each seen from where its normal points, all at
/// one scale. Units are those of the world; the transform of the whole turns them into pixels.
pub(super) fn draw(model: &Model, planes: &[Plane], sections: &[Section]) -> String {
    let mut sheets = Vec::new();
    for (number, plane) in planes.iter().enumerate() {
        let Some([u, v, _]) = section_frame(plane) else { continue };
        let (u, v) = (DVec3::from(u), DVec3::from(v));
        let mut paths = Vec::new();
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for section in sections.iter().filter(|s| s.plane == number) {
            let flat = |p: &[f64; 3]| {
                let p = DVec3::from(*p);
                [p.dot(u), -p.dot(v)]
            };
            let lines: Vec<Vec<[f64; 2]>> =
                section.outlines.iter().map(|o| o.iter().map(flat).collect()).collect();
            for p in lines.iter().flatten() {
                for i in 0..2 {
                    low[i] = low[i].min(p[i]);
                    high[i] = high[i].max(p[i]);
                }
            }
            paths.push((section.material, lines));
        }
        if !paths.is_empty() {
            sheets.push((number, paths, low, [high[0] - low[0], high[1] - low[1]]));
        }
    }
    let gap = sheets.iter().map(|s| s.3[0].max(s.3[1])).fold(0.0, f64::max) * 0.05;
    let width = sheets.iter().map(|s| s.3[0] + gap).sum::<f64>() + gap;
    let height = sheets.iter().map(|s| s.3[1]).fold(0.0, f64::max) + 2.0 * gap;
    let scale = if width.max(height) > 0.0 { SIZE / width.max(height) } else { 1.0 };
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{:.0}\" height=\"{:.0}\">\n\
         <title>Section of {}</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
        (width * scale).max(1.0),
        (height * scale).max(1.0),
        escaped(&model.name)
    );
    let mut left = gap;
    for (number, paths, low, size) in sheets {
        // Programs that draw have f32: far from zero, lines are counted from a place that is said.
        let far = low.iter().any(|v| v.abs() > FAR * size[0].max(size[1]));
        let from = if far { low.map(f64::floor) } else { [0.0; 2] };
        let said =
            if far { format!(" data-from=\"{} {}\"", from[0], from[1]) } else { String::new() };
        // One unit of the world is one unit of the group; only the line's width is in pixels.
        let _ = writeln!(
            text,
            "<g id=\"plane-{number}\"{said} transform=\"scale({scale}) translate({} {})\" stroke=\"#222\" \
             stroke-width=\"{}\" stroke-linejoin=\"round\" fill-rule=\"nonzero\">",
            left - (low[0] - from[0]),
            gap - (low[1] - from[1]),
            0.8 / scale
        );
        for (material, lines) in paths {
            let mut d = String::new();
            for line in &lines {
                for (i, [x, y]) in line.iter().enumerate() {
                    let (x, y) = (x - from[0], y - from[1]);
                    let _ = write!(d, "{}{x:.6} {y:.6}", if i == 0 { "M" } else { "L" });
                }
                d.push('Z');
            }
            let _ = writeln!(text, "<path fill=\"{}\" d=\"{d}\"/>", color(model, material));
        }
        text.push_str("</g>\n");
        left += size[0] + gap;
    }
    text.push_str("</svg>\n");
    text
}

/// Colour of parts without one of their own.
const PALE: &str = "#c98b80";

/// The colour of a material in sRGB; a pale red where there is none, or it is white.
fn color(model: &Model, material: u32) -> String {
    let Some(m) = model.materials.get(material as usize) else { return PALE.into() };
    // White on white shows nothing.
    if m.color[..3].iter().all(|&v| v > 0.85) {
        return PALE.into();
    }
    // A gamma of 2.2 is near enough for a drawing.
    let byte = |v: f32| (math::pow(f64::from(v.clamp(0.0, 1.0)), 1.0 / 2.2) * 255.0).round() as u8;
    let [r, g, b] = [0, 1, 2].map(|i| byte(m.color[i]));
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Names come from files.
fn escaped(text: &str) -> String {
    let plain = |c: char| match c {
        '&' => "&amp;".into(),
        '<' => "&lt;".into(),
        '>' => "&gt;".into(),
        c if c.is_control() => "\u{fffd}".into(),
        c => c.to_string(),
    };
    text.chars().map(plain).collect()
}
