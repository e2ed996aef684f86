//! The results as tables for people.

use super::record::{Distance, PAPER, PAPER_TRIANGLES, ZhangHoffRecord};
use super::refined::{DISTANCES, SECTORS};
use cullet_command::console::{Console, count, grouped};

/// Prints all tables.
pub(super) fn all(console: &Console, record: &ZhangHoffRecord) {
    table1(console, record);
    others(console, record);
    if record.complete {
        groups(console, record);
        sectors(console, record);
    } else {
        console.line("\nStopped early: the tables of groups and sectors are left out.");
    }
}

fn table1(console: &Console, record: &ZhangHoffRecord) {
    let m = &record.model;
    console.line("Zhang & Hoff 1997, Fast Backface Culling Using Normal Masks");
    console.line(format!(
        "{}, {}, {} in all; means over {}.",
        m.name,
        count(u64::from(m.copies), "copy", "copies"),
        count(m.triangles, "triangle", "triangles"),
        views(record.directions)
    ));
    console.line(format!(
        "\nTable 1, from {:.2} radii of the sphere around both copies. The paper does not say where it \
         stood;\nfrom there masks cull, over N >= 6, what comes nearest to what it printed.",
        record.distance_radii
    ));
    console.line(
        "\n                  triangles          share culled, %         ms a frame       speed-up\n  \
           N classes      kept    culled     masks  paper  exact      ours  paper",
    );
    for r in &record.rows {
        let time = |v: Option<f64>| v.map_or_else(|| "-".into(), |v| format!("{v:.2}"));
        console.line(format!(
            "{:>3} {:>7} {:>9} {:>9}    {:>6.1} {:>6.1} {:>6.1}    {:>6} {:>6.1}         {:>5}",
            r.n,
            r.classes,
            grouped(r.front),
            grouped(r.back),
            r.culled_percent,
            r.paper_percent,
            r.exact_percent,
            time(r.ms_per_frame),
            r.paper_ms,
            time(r.speedup)
        ));
    }
    let worst = record.worst_difference_points;
    console.line(match worst.abs() {
        0.0..=0.5 => format!(
            "\nFor N >= 6 the shares are within {:.1} points of the paper's. The paper's is one view; with \
             cells\nas large as N = 2 a single view may lie some points beside the mean.",
            worst.abs()
        ),
        _ => format!(
            "\nFor N >= 6 a share is {:.1} points off the paper's: no distance gives its table, for this \
             model's\nnormals are spread unlike the bunny's.",
            worst.abs()
        ),
    });
    if let (Some(baseline), Some(empty)) = (record.baseline_ms, record.empty_ms) {
        console.line(format!(
            "Frames: {}, {},\nthe fastest of several passes each. Without masks {baseline:.2} ms, \
             of which {empty:.2} ms for preparing and\nclearing, which no culling saves.",
            record.renderer,
            views(record.frames)
        ));
        if let Some(p) = record.planes8 {
            console.line(format!(
                "The engine's own test, planes in 8 bits (4 bytes a triangle, masks have 2), culls {:.1} %: \
                 {:.2} ms,\n{:.2} times as fast.",
                p.culled_percent, p.ms_per_frame, p.speedup
            ));
            let all = m.triangles as f64;
            let back = all * p.culled_percent / 100.0;
            let (for_back, for_front) = (baseline - p.ms_per_frame, p.ms_per_frame - empty);
            // Of a few triangles it would be the clock's cost.
            if for_back.min(for_front) > 0.2 * empty {
                console.line(format!(
                    "So a back face costs this renderer {:.0} ns, and a front face {:.0} ns.",
                    for_back * 1e6 / back,
                    for_front * 1e6 / (all - back),
                ));
            }
        }
        claim(console, record);
    }
    console.line(match (record.front_faces_lost, record.images_agree) {
        (0, true) => {
            "No front face was culled, and every image is the same with masks as without.".into()
        }
        (0, false) => {
            "AN IMAGE WITH MASKS DIFFERS from that without: a fault of cullet.".to_owned()
        }
        (n, _) => format!("{n} FRONT FACES WERE CULLED: a fault of cullet."),
    });
}

fn views(n: u32) -> String {
    count(u64::from(n), "view", "views")
}

/// Why the paper's speed-up is another.
fn claim(console: &Console, record: &ZhangHoffRecord) {
    // Time of the paper's frame for each triangle that its masks kept.
    let each = PAPER.map(|(_, culled, ms)| ms * 1e3 / (PAPER_TRIANGLES * (1.0 - culled / 100.0)));
    let [least, most] = [f64::min, f64::max].map(|f| each.into_iter().reduce(f).unwrap_or(0.0));
    let even = record.rows.last().map_or(1.0, |r| r.even_speedup);
    console.line(format!(
        "The paper claims a speed-up of 60 to 80 %, lectures quote about 1.5 times. Its times come to \
         {least:.1} to {most:.1} µs\nfor each triangle kept, at every N: there a triangle cost the same, \
         seen from its front or not, and\nthen N = 18 is {even:.2} times as fast. A renderer gains what \
         a back face costs it."
    ));
}

fn others(console: &Console, record: &ZhangHoffRecord) {
    console.line(
        "\nOther distances. Share culled, %: farther away masks cull more, and the exact test less.",
    );
    let columns = |head: &str, value: &dyn Fn(&Distance) -> String| {
        record
            .other_distances
            .iter()
            .fold(format!("{head:>5}"), |line, d| line + &format!("{:>12}", value(d)))
    };
    console.line(columns("N", &|d| format!("{} radii", d.distance_radii)));
    for (i, paper) in PAPER.iter().enumerate() {
        let share = |d: &Distance| format!("{:.1}", d.rows[i].culled_percent);
        console.line(columns(&paper.0.to_string(), &share));
    }
    console.line(columns("exact", &|d| format!("{:.1}", d.rows[0].exact_percent)));
}

fn groups(console: &Console, record: &ZhangHoffRecord) {
    console.line(
        "\nGroups. A viewing cone for each group of triangles (kd split, N = 16; one copy, distances in its \
         own\nradii): smaller groups, narrower cones. Each group costs a mask a frame.",
    );
    let head = DISTANCES.iter().map(|d| format!("{:>22}", format!("{d} radii")));
    console.line(format!("groups{}", head.collect::<String>()));
    for rows in record.groups.chunks(DISTANCES.len()) {
        let columns =
            rows.iter().map(|r| format!("{:>10.1} % {:>7.1} µs", r.culled_percent, r.us_per_frame));
        console.line(format!("{:>6}{}", rows[0].groups, columns.collect::<String>()));
    }
    let exact = record.groups.iter().take(DISTANCES.len());
    let exact = exact.map(|r| format!("{:>10.1} %{:10}", r.exact_percent, ""));
    console.line(format!(" exact{}", exact.collect::<String>()).trim_end());
}

fn sectors(console: &Console, record: &ZhangHoffRecord) {
    console.line(
        "\nSectors. One copy that just fits a square window, N = 16: one mask for the cone around the \
         frustum, one\nfor the cone around the model's sphere, and masks from the lines of sight at the \
         corners of k x k\nsectors; a cluster in several sectors is culled by what they share alone.",
    );
    let head = SECTORS.iter().map(|k| format!("{:>17}", format!("k = {k}")));
    console.line(format!(" field   radii  frustum  sphere{}   exact", head.collect::<String>()));
    for rows in record.sectors.chunks(SECTORS.len()) {
        let columns =
            rows.iter().map(|r| format!("{:>8.1} %{:>5.0} µs", r.culled_percent, r.us_per_frame));
        let columns = columns.collect::<String>();
        let r = rows[0];
        console.line(format!(
            "{:>4} deg {:>5.2} {:>7.1} % {:>6.1} % {columns} {:>6.1} %",
            r.fov_degrees,
            r.distance_copy_radii,
            r.frustum_cone_percent,
            r.sphere_cone_percent,
            r.exact_percent
        ));
    }
}
