//! Graph 1: the share culled and the speed-up, against the number of classes.

use std::fmt::Write;

use super::table::{PAPER, Table};

const SHARE: &str = "#0072b2";
const SPEED: &str = "#d55e00";
const FAINT: &str = "#8a9199";
const INK: &str = "#20262c";
/// The rectangle of the curves: left, top, right, bottom.
const PLOT: [f64; 4] = [70.0, 90.0, 830.0, 450.0];
/// Times as fast, at the bottom and the top; per cent culled go from 0 to 60.
const SPEEDS: [f64; 2] = [0.4, 2.2];

/// The graph as a file.
pub(crate) fn svg(table: &Table, device: &str) -> String {
    let x = |n: u32| PLOT[0] + f64::from(n - 1) / 18.0 * (PLOT[2] - PLOT[0]);
    let y = |share: f64| PLOT[3] - share * (PLOT[3] - PLOT[1]);
    let culled = |percent: f64| y(percent / 60.0);
    let speed = |times: f64| y((times - SPEEDS[0]) / (SPEEDS[1] - SPEEDS[0]));
    let mut svg = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 900 580\" width=\"900\" height=\"580\" \
         font-family=\"sans-serif\" font-size=\"14\" role=\"img\" \
         aria-label=\"Share culled by normal masks and speed-up, by number of classes\">\n\
         <rect width=\"900\" height=\"580\" fill=\"#fffdf8\"/>\n",
    );
    let text = |svg: &mut String, at: [f64; 2], anchor: &str, fill: &str, words: &str| {
        let words = words.replace('&', "&amp;").replace('<', "&lt;");
        let [x, y] = at;
        // Writing to a string cannot fail.
        let _ = writeln!(
            svg,
            "<text x=\"{x:.0}\" y=\"{y:.0}\" text-anchor=\"{anchor}\" fill=\"{fill}\">{words}</text>"
        );
    };
    let line = |svg: &mut String, points: &[[f64; 2]], style: &str| {
        let points: Vec<String> = points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
        let points = points.join(" ");
        let _ = writeln!(svg, "<polyline points=\"{points}\" fill=\"none\" {style}/>");
    };
    let title = format!("Normal masks on the device: 2 x {}", table.name);
    text(&mut svg, [PLOT[0], 28.0], "start", INK, &title);
    text(&mut svg, [PLOT[0], 50.0], "start", FAINT, device);
    text(&mut svg, [PLOT[0], 78.0], "middle", SHARE, "% culled");
    text(&mut svg, [PLOT[2], 78.0], "middle", SPEED, "times as fast");
    for step in 0..=6 {
        let at = f64::from(step) / 6.0;
        line(&mut svg, &[[PLOT[0], y(at)], [PLOT[2], y(at)]], "stroke=\"#dddbd5\"");
        text(&mut svg, [PLOT[0] - 8.0, y(at) + 5.0], "end", SHARE, &format!("{}", step * 10));
        let times = SPEEDS[0] + at * (SPEEDS[1] - SPEEDS[0]);
        text(&mut svg, [PLOT[2] + 8.0, y(at) + 5.0], "start", SPEED, &format!("{times:.1}"));
    }
    let (x0, x1) = (x(1), x(19));
    let claims = "stroke-width=\"2\" stroke-dasharray=\"8 6\" stroke=\"#d55e00\" opacity=\"0.5\"";
    for claimed in [1.6, 1.8] {
        line(&mut svg, &[[x0, speed(claimed)], [x1, speed(claimed)]], claims);
    }
    line(&mut svg, &[[x0, speed(1.0)], [x1, speed(1.0)]], "stroke=\"#8a9199\" stroke-width=\"2\"");
    let style = |color: &str, dashed: bool| {
        let dashes = if dashed { "stroke-dasharray=\"3 5\"" } else { "" };
        format!("stroke=\"{color}\" stroke-width=\"3\" {dashes}")
    };
    let points = |value: &dyn Fn(usize) -> f64| -> Vec<[f64; 2]> {
        (0..table.rows.len()).map(|i| [x(table.rows[i].cells), value(i)]).collect()
    };
    line(&mut svg, &points(&|i| culled(PAPER[i].1)), &style(SHARE, true));
    line(&mut svg, &points(&|i| culled(table.rows[i].culled_percent)), &style(SHARE, false));
    let times = |i: usize| speed(table.speedup(&table.rows[i]).clamp(SPEEDS[0], SPEEDS[1]));
    line(&mut svg, &points(&times), &style(SPEED, false));
    for row in &table.rows {
        let classes = format!("{}", 6 * row.cells * row.cells);
        text(&mut svg, [x(row.cells), PLOT[3] + 22.0], "middle", INK, &classes);
    }
    text(&mut svg, [PLOT[2], PLOT[3] + 44.0], "end", INK, "classes of normals");
    let legend = [
        (SHARE, false, "share culled"),
        (SHARE, true, "share culled, as the paper prints it"),
        (
            SPEED,
            false,
            "frame of the hardware's back-face culling alone over one with masks before it",
        ),
        (SPEED, true, "what the paper claims: 1.6 to 1.8"),
    ];
    for (i, (color, dashed, words)) in (0..).zip(legend) {
        let at = PLOT[3] + 60.0 + 20.0 * f64::from(i);
        line(&mut svg, &[[PLOT[0], at - 5.0], [PLOT[0] + 40.0, at - 5.0]], &style(color, dashed));
        text(&mut svg, [PLOT[0] + 52.0, at], "start", INK, words);
    }
    svg.push_str("</svg>\n");
    svg
}
