//! How long the viewer's decider takes for a camera that stands, turns and flies: the time that the
//! window shows beside the faces, and where in it the stages are.

use std::io::{self, Write};
use std::sync::Arc;

use cullet::{Output, Stage};

use crate::camera::{Mode, Rig};
use crate::decide::{Decider, Decision, Request};
use crate::numbers::grouped;
use crate::state::Stages;
use crate::task::clock;
use crate::world::World;

/// The picture's size.
const SIZE: [u32; 2] = [1280, 720];
/// Decisions of each way to move, after some that fill what is remembered.
const DECISIONS: usize = 60;
const BEFORE: usize = 5;

/// A way to move, from one decision to the next.
type Move = (&'static str, fn(&mut Rig, f64));

const MOVES: [Move; 3] = [
    ("stands", |_, _| {}),
    ("turns", |rig, _| rig.turn(1.0, 0.0)),
    ("flies", |rig, reach| rig.shift(0.0, 0.0, reach * 0.16 / 60.0)),
];

/// Measures a scene from where the viewer begins, with the default settings and without occlusion,
/// down to clusters and for whole instances, and writes a table to `out`: milliseconds, the median
/// and the worst of 60 decisions.
///
/// # Errors
/// If the table cannot be written.
pub fn run(world: World, out: &mut impl Write) -> io::Result<()> {
    let instances = grouped(world.counts.instances);
    let triangles = grouped(world.counts.triangles);
    writeln!(out, "{}: {triangles} triangles of {instances} instances, {SIZE:?}", world.name)?;
    writeln!(
        out,
        "\n{:30} {:7} {:>8} {:>8} {:>9}  of the median, by stage",
        "stages", "camera", "median", "worst", "instances"
    )?;
    let world = Arc::new(world);
    let deep = |depth, stages: Stages| Stages { depth, ..stages };
    for (name, stages) in [
        ("default", Stages::default()),
        ("default, whole instances", deep(Output::Instances, Stages::default())),
        ("without occlusion", Stages::without_occlusion()),
        ("frustum, whole instances", Stages::frustum_only()),
    ] {
        for (moves, by) in MOVES {
            let mut took = decisions(&world, &stages, by);
            took.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
            let ((median, row), worst) = (&took[took.len() / 2], took[took.len() - 1].0);
            writeln!(
                out,
                "{name:30} {moves:7} {median:8.2} {worst:8.2} {:>9}  {}",
                grouped(row.kept),
                row.stages
            )?;
        }
    }
    Ok(())
}

/// Figures of a decision that the panels show.
struct Row {
    kept: u64,
    stages: String,
}

fn decisions(world: &Arc<World>, stages: &Stages, by: fn(&mut Rig, f64)) -> Vec<(f32, Row)> {
    let mut decider = Decider::new(|| {});
    let mut rig = Rig { mode: Mode::Fly, ..world.first_sight(SIZE) };
    let mut took = Vec::new();
    for number in 0..(BEFORE + DECISIONS) as u64 {
        by(&mut rig, world.reach);
        let Ok(view) = rig.view(SIZE) else { break };
        let culler = stages.culler(clock);
        decider.request(Request { world: Arc::clone(world), view, culler, buffer: false, number });
        let decision = loop {
            match decider.latest() {
                Some(decision) => break decision,
                None => std::thread::yield_now(),
            }
        };
        if number >= BEFORE as u64 {
            took.push((decision.milliseconds, row(&decision)));
        }
        // As a session does.
        decider.give_back(decision.visible);
    }
    took
}

fn row(decision: &Decision) -> Row {
    let mut stages = String::new();
    for stage in Stage::ALL {
        let rows = decision.visible.funnel.rows.iter().filter(|r| r.stage == stage);
        let took: u64 = rows.filter_map(cullet::funnel::FunnelRow::time).sum();
        if took > 0 {
            stages.push_str(&format!("{} {:.2}  ", stage.name(), took as f64 * 1e-6));
        }
    }
    Row { kept: decision.visible.instance_count, stages }
}
