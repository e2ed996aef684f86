//! The results as a table for people.

use super::record::AssarssonMollerRecord;
use cullet_command::console::{Console, grouped};

/// Prints it.
pub(super) fn all(console: &Console, record: &AssarssonMollerRecord) {
    console.line(
        "Assarsson & Möller 2000, Optimized View Frustum Culling Algorithms for Bounding Boxes",
    );
    console.line(format!(
        "{}, {} boxes of which a frame sees {:.1} %; {} frames, each turned by {}° and {:.3} units on;\n\
         one thread, {}.",
        record.model,
        grouped(record.boxes),
        record.visible_percent,
        record.frames,
        record.degrees,
        record.stride,
        record.machine.cpu.as_deref().unwrap_or(record.machine.arch)
    ));
    let Some(plain) = record.rows.first() else {
        console.line("\nStopped before the first frame was done.");
        return;
    };
    console.line(
        "\n                        nodes   plane tests    of plain     µs a frame    times as fast\n\
         Binary tree, one box at a time, f64",
    );
    let whole = |v: f64| grouped(v.round() as u64);
    for r in &record.rows {
        console.line(format!(
            "  {:<19} {:>8}      {:>8}     {:>5.1} %       {:>8.1}            {:>5.2}",
            r.variant,
            whole(r.nodes),
            whole(r.plane_tests),
            100.0 / r.fewer_tests,
            r.ns / 1e3,
            r.speedup
        ));
    }
    console
        .line("Tree of sixteen, all children at once, f32 (a test of sixteen counts as sixteen)");
    for r in &record.wide {
        console.line(format!(
            "  {:<19}               {:>8}     {:>5.1} %       {:>8.1}            {:>5.2}",
            r.variant,
            whole(r.plane_tests),
            r.plane_tests * 100.0 / plain.plane_tests,
            r.ns / 1e3,
            r.speedup
        ));
    }
    words(console, record);
    if !record.complete {
        console.line("Stopped early: these are the figures of the frames that were done.");
    }
}

/// Prints the conclusions in words.
fn words(console: &Console, record: &AssarssonMollerRecord) {
    let best = record.rows.iter().max_by(|a, b| a.speedup.total_cmp(&b.speedup));
    if let (Some(best), [wide]) = (best, &record.wide[..]) {
        console.line(format!(
            "\nThe paper claims 2 to 11 times over other ways to cull boxes. Here its best is '{}',\n{:.2} times as fast \
             as plain; sixteen boxes at once are {:.1} times as fast as that.",
            best.variant,
            best.speedup,
            best.ns / wide.ns
        ));
        console.line(
            "What carries over to wide vectors: masking (a node's children are tested only against the planes it\n\
             straddles), and taking or dropping a whole range at once. What does not: the octant test and the\n\
             last rejecting plane save a test of one box by a branch, and sixteen boxes differ in which they\n\
             would need. Nor does motion coherency, but for a view that stands still: groups of 256 boxes that\n\
             remember how far each plane may move made every turn slower.",
        );
    }
    console.line(match (record.frames_differing, record.lost) {
        (0, 0) => format!(
            "All variants agree in every frame; of {} boxes seen in all, f32 keeps {} more at the border.",
            grouped(record.visible_in_all),
            grouped(record.kept_at_the_border)
        ),
        (frames, lost) => format!(
            "ANSWERS DIFFER: {frames} times a variant from plain, {lost} boxes lost: a fault of cullet."
        ),
    });
}
