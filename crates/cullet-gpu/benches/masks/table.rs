//! Table 1 of a model: what masks of each size cull and save, with the hardware's own culling on; the hardware's states; groups.

use std::time::Instant;

use cullet::mesh::MeshData;
use cullet_gpu::{Gpu, TriangleTest};
use serde_json::{Value, json};

use super::Failure;
use super::pair::{Pair, State, VIEWS, Way};
use super::timing::{fastest, turns};

/// Cells along an edge of the cube, and what the paper prints for them: per cent culled, milliseconds a frame.
pub(crate) const PAPER: [(u32, f64, f64); 9] = [
    (2, 27.5, 469.5),
    (4, 35.1, 425.1),
    (6, 38.2, 396.3),
    (8, 39.9, 388.3),
    (10, 40.9, 391.3),
    (12, 41.6, 393.8),
    (14, 42.2, 386.2),
    (16, 42.6, 378.6),
    (18, 43.0, 371.9),
];
/// The paper's choice.
const CELLS: u32 = 16;
const GROUPS: [usize; 6] = [1, 4, 16, 64, 256, 1024];

/// A set of triangles and how it is tested.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub(crate) cells: u32,
    groups: usize,
    pub(crate) culled_percent: f64,
    pub(crate) ms: f64,
    /// Part of that time spent on the lists.
    lists_ms: f64,
    /// On the CPU, for masks or eyes.
    prepare_ms: f64,
}

/// Measurements of one model.
pub(crate) struct Table {
    pub(crate) name: &'static str,
    pub(crate) triangles: usize,
    empty_ms: f64,
    /// The hardware alone, and after masks.
    states: Vec<(State, f64, f64)>,
    pub(crate) rows: Vec<Row>,
    planes: Row,
    groups: Vec<Row>,
}

/// Measures all of a model; an error where a picture is not the hardware's own.
pub(crate) fn measure(gpu: &Gpu, name: &'static str, data: MeshData) -> Result<Table, Failure> {
    let mut pair = Pair::new(gpu, data)?;
    let mut sets = Vec::new();
    for (cells, ..) in PAPER {
        sets.push((cells, 1, TriangleTest::Masks, pair.add(cells, 1)?));
    }
    let sixteen = sets[7].3;
    sets.push((CELLS, 1, TriangleTest::Planes, sixteen));
    for groups in GROUPS {
        sets.push((CELLS, groups, TriangleTest::Masks, pair.add(CELLS, groups)?));
    }
    let mut ways = vec![Way::Empty];
    for state in State::ALL {
        ways.push(Way::Whole(state));
        ways.push(Way::Listed(state, sixteen, TriangleTest::Masks));
    }
    let first_set = ways.len();
    ways.extend(sets.iter().map(|(.., test, set)| Way::Listed(State::Back, *set, *test)));
    let first_lists = ways.len();
    ways.extend(sets.iter().map(|(.., test, set)| Way::ListsAlone(*set, *test)));
    let mut sums = vec![0.0; ways.len()];
    let (mut culled, mut prepared) = (vec![0; sets.len()], vec![0.0; sets.len()]);
    for number in 0..VIEWS {
        let view = pair.view(number)?;
        check(&mut pair, &ways, &view, name)?;
        let times = turns(gpu, ways.len(), |way| {
            pair.frame(&view, ways[way]);
            Ok(())
        })?;
        sums.iter_mut().zip(&times).for_each(|(sum, times)| *sum += fastest(times));
        for (i, (.., test, set)) in sets.iter().enumerate() {
            culled[i] += pair.culled(&view, *set, *test);
            let mut best = f64::INFINITY;
            for _ in 0..20 {
                let began = Instant::now();
                pair.prepare(&view, *set, *test);
                best = best.min(began.elapsed().as_secs_f64() * 1e3);
            }
            prepared[i] += best;
        }
    }
    let mean = |way: usize| sums[way] / VIEWS as f64;
    let rows: Vec<Row> = (0..)
        .zip(&sets)
        .map(|(i, (cells, groups, ..))| Row {
            cells: *cells,
            groups: *groups,
            culled_percent: culled[i] as f64 * 100.0 / (pair.triangles() * VIEWS) as f64,
            ms: mean(first_set + i),
            lists_ms: mean(first_lists + i),
            prepare_ms: prepared[i] / VIEWS as f64,
        })
        .collect();
    Ok(Table {
        name,
        triangles: pair.triangles(),
        empty_ms: mean(0),
        states: (0..).zip(State::ALL).map(|(i, s)| (s, mean(1 + 2 * i), mean(2 + 2 * i))).collect(),
        planes: rows[PAPER.len()].clone(),
        groups: rows[PAPER.len() + 1..].to_vec(),
        rows: rows[..PAPER.len()].to_vec(),
    })
}

/// Draws a view in every way, and fails where a picture is not that of the hardware alone.
fn check(
    pair: &mut Pair<'_>,
    ways: &[Way],
    view: &cullet::View,
    name: &str,
) -> Result<(), Failure> {
    for &way in ways {
        let Way::Listed(state, ..) = way else { continue };
        // Without its back faces a body with holes looks another.
        if state == State::None && !pair.is_solid() {
            continue;
        }
        pair.frame(view, Way::Whole(state));
        let expected = pair.picture()?;
        pair.frame(view, way);
        if pair.picture()? != expected {
            return Err(format!("{name}: the picture of {way:?} is another").into());
        }
    }
    Ok(())
}

impl Table {
    /// A frame of the hardware's back-face culling alone.
    pub(crate) fn alone_ms(&self) -> f64 {
        self.states[1].1
    }

    pub(crate) fn speedup(&self, row: &Row) -> f64 {
        self.alone_ms() / row.ms
    }

    pub(crate) fn print(&self, t_over_r: f64) {
        println!(
            "\n{}: two copies, {} triangles; {:.2} ms a frame with the hardware's back-face culling alone, of which {:.2} for an empty one",
            self.name,
            self.triangles,
            self.alone_ms(),
            self.empty_ms
        );
        println!("hardware culls      alone, ms   after masks, ms   times as fast");
        for (state, alone, listed) in &self.states {
            println!("{:18} {alone:10.2} {listed:17.2} {:15.2}", state.name(), alone / listed);
        }
        println!(
            "  N classes   culled, %  paper   ms a frame   lists, ms   masks, ms   times as fast"
        );
        let line = |row: &Row, paper: &str| {
            println!(
                "{:>3} {:>7} {:>10.1} {paper:>7} {:>12.2} {:>11.2} {:>11.4} {:>15.2}",
                row.cells,
                6 * row.cells * row.cells,
                row.culled_percent,
                row.ms,
                row.lists_ms,
                row.prepare_ms,
                self.speedup(row)
            );
        };
        for (row, paper) in self.rows.iter().zip(PAPER) {
            line(row, &format!("{:.1}", paper.1));
        }
        println!("by planes of five bytes a triangle in place of masks:");
        line(&self.planes, "");
        println!("groups, N = {CELLS}   culled, %   ms a frame   masks, ms   times as fast");
        for row in &self.groups {
            let speedup = self.speedup(row);
            println!(
                "{:>14} {:>11.1} {:>12.2} {:>11.4} {speedup:>15.2}",
                row.groups, row.culled_percent, row.ms, row.prepare_ms
            );
        }
        let own = self.groups.first().map_or(f64::NAN, |row| self.speedup(row));
        let none = self.states[0].1 / self.alone_ms();
        println!("claim                                              said          found");
        println!("masks, N = {CELLS}, over hardware alone (the paper)    1.6 to 1.8    {own:.2}");
        println!("the same (lectures)                                1.5           {own:.2}");
        println!("hardware culling over none (\"sometimes double\")    2             {none:.2}");
        println!("one mask test over one triangle drawn, t/r         -             {t_over_r:.3}");
    }

    pub(crate) fn json(&self) -> Value {
        let row = |r: &Row| {
            json!({
                "n": r.cells, "classes": 6 * r.cells * r.cells, "groups": r.groups,
                "culled_percent": r.culled_percent, "ms_per_frame": r.ms, "lists_ms": r.lists_ms,
                "prepare_ms": r.prepare_ms, "speedup": self.speedup(r),
            })
        };
        let all = |rows: &[Row]| rows.iter().map(row).collect::<Vec<_>>();
        let state = |(state, alone, listed): &(State, f64, f64)| {
            let name = state.name();
            json!({"hardware_culls": name, "alone_ms": alone, "after_masks_ms": listed})
        };
        json!({
            "name": self.name, "copies": 2, "triangles": self.triangles, "views": VIEWS,
            "empty_ms": self.empty_ms,
            "states": self.states.iter().map(state).collect::<Vec<_>>(),
            "rows": all(&self.rows), "planes": row(&self.planes), "groups": all(&self.groups),
            "claims": {"paper": [1.6, 1.8], "lectures": 1.5, "sometimes_double": 2.0},
        })
    }
}
