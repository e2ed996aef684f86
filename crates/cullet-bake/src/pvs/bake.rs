//! The rounds of a bake.

use cullet::cell::CellGraph;

use super::flood::candidates;
use super::flow::{Flow, Known, Work};
use super::lines::{Found, Line, Random, prove};
use super::openings::Openings;
use super::rows::{BitRows, clear, count, has, ones};
use super::threads;

#[derive(Clone, Debug)]
pub struct Settings {
    pub seed: u64,
    pub tolerance: f64,
    pub threads: usize,
    pub stages: usize,
    pub local: u32,
    pub aimed: u32,
    pub tries: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Self { seed: 1, tolerance: 1e-6, threads: 1, stages: 16, local: 4, aimed: 8, tries: 16 }
    }
}

#[derive(Debug)]
pub struct Pvs {
    pub rows: BitRows,
    pub proven: BitRows,
    pub work: String,
    pub candidates: u64,
}

/// What one cell's work gave.
struct Done {
    hidden: Vec<u64>,
    closed: Vec<(u32, Vec<u64>)>,
    found: Found,
    work: Work,
}

pub fn bake(graph: &CellGraph, settings: &Settings) -> Pvs {
    let mut log = String::new();
    let openings = Openings::new(graph, settings.tolerance);
    let cells = graph.cell_count();
    let mut clock = std::time::Instant::now();
    let mut lap = |what: &str, log: &mut String| {
        *log += &format!("{what} {:.3}  ", clock.elapsed().as_secs_f64());
        clock = std::time::Instant::now();
    };
    let mut known = Known {
        might: BitRows::new(openings.len(), cells),
        possible: BitRows::new(cells, cells),
        visible: BitRows::new(cells, cells),
    };
    let mut stack = vec![];
    for o in 0..openings.len() {
        candidates(&openings, o, known.might.row_mut(o), &mut stack);
    }
    for cell in 0..cells {
        known.possible.set(cell, cell);
        known.visible.set(cell, cell);
        for o in openings.leaving(cell) {
            let row = known.might.row(o).to_vec();
            known.possible.row_mut(cell).iter_mut().zip(row).for_each(|(a, b)| *a |= b);
        }
    }
    *&mut log += &format!("cand {} ", known.possible.count());
    known.possible.keep_symmetric();
    *&mut log += &format!("sym {} ", known.possible.count());
    lap("flood", &mut log);
    tighten(&openings, &mut known);
    tighten(&openings, &mut known);
    let candidate_count = known.possible.count() - u64::from(cells);
    *&mut log += &format!("tight {} ", known.possible.count());
    lap("tighten", &mut log);
    // Local lines.
    let mut work = Work::default();
    let done = threads::run(
        settings.threads,
        cells as usize,
        || Flow::new(&openings, &known),
        |flow, cell| {
            let cell = cell as u32;
            flow.begin(cell, &vec![0; known.visible.width()], Random::new(settings.seed, [0, cell]));
            let leaving = openings.leaving(cell);
            for a in leaving.clone() {
                for b in leaving.clone().filter(|&b| b > a) {
                    for _ in 0..settings.local {
                        let (r, s) = (flow.random.three(), flow.random.three());
                        let point = openings.get(b).polygon.point(r);
                        let start = openings.get(a).polygon.point(s);
                        if let Some(direction) = (point - start).try_normalize() {
                            flow.try_line(&Line { opening: b, point, direction });
                        }
                    }
                }
            }
            std::mem::take(&mut flow.found)
        },
        || true,
    )
    .unwrap();
    for found in &done {
        for (_, line) in found.iter() {
            prove(&mut known.visible, line);
        }
    }
    *&mut log += &format!("seen {} ", known.visible.count());
    lap("local", &mut log);
    // Order.
    let mut order: Vec<(u64, u32)> = (0..cells)
        .map(|cell| {
            let undecided: u64 = known.possible.row(cell).iter().zip(known.visible.row(cell)).map(|(p, v)| u64::from((p & !v).count_ones())).sum();
            let _ = undecided;
            (count(known.possible.row(cell)), cell)
        })
        .collect();
    order.sort_unstable();
    let mut position = vec![0; cells as usize];
    for (k, &(_, cell)) in order.iter().enumerate() {
        position[cell as usize] = k;
    }
    for pass in 0..2 {
        let chunk = (cells as usize).div_ceil(settings.stages);
        for stage in 0..settings.stages {
            let from = (stage * chunk).min(order.len());
            let batch = &order[from..(from + chunk).min(order.len())];
            let results = threads::run(
                settings.threads,
                batch.len(),
                || Flow::new(&openings, &known),
                |flow, k| {
                    let cell = batch[k].1;
                    let mut wanted: Vec<u64> = known.possible.row(cell).iter().zip(known.visible.row(cell)).map(|(p, v)| p & !v).collect();
                    let mine = position[cell as usize];
                    for other in ones(&wanted.clone()) {
                        if (position[other as usize] < mine) != (pass == 1) {
                            clear(&mut wanted, other);
                        }
                    }
                    flow.work = Work::default();
                    flow.tries = settings.tries;
                    flow.begin(cell, &wanted, Random::new(settings.seed, [1 + pass, cell]));
                    if pass == 0 {
                        flow.aim(settings.aimed);
                    }
                    let mut closed = vec![];
                    for door in openings.leaving(cell) {
                        let before: Vec<u64> = flow.wanted.iter().zip(known.might.row(door)).map(|(w, m)| w & m).collect();
                        flow.through(door);
                        let lost: Vec<u64> = before.iter().zip(&flow.wanted).map(|(w, m)| w & m).collect();
                        closed.push((door, lost));
                    }
                    Done { hidden: flow.wanted.clone(), closed, found: std::mem::take(&mut flow.found), work: flow.work }
                },
                || true,
            )
            .unwrap();
            for (k, done) in results.iter().enumerate() {
                let cell = batch[k].1;
                for other in ones(&done.hidden) {
                    known.possible.clear(cell, other);
                    known.possible.clear(other, cell);
                }
                for (door, lost) in &done.closed {
                    known.might.row_mut(*door).iter_mut().zip(lost).for_each(|(m, l)| *m &= !l);
                }
                for (_, line) in done.found.iter() {
                    prove(&mut known.visible, line);
                }
                work.lines += done.work.lines;
                work.nodes += done.work.nodes;
                work.clips += done.work.clips;
                work.floods += done.work.floods;
                work.flood_tests += done.work.flood_tests;
            }
            narrow(&openings, &mut known);
        }
        *&mut log += &format!("{work:?} ");
        lap("pass", &mut log);
    }
    let lost = ones_lost(&known);
    *&mut log += &format!("visible but impossible {lost} ");
    let mut rows = known.possible.clone();
    rows.words_mut().iter_mut().zip(known.visible.words()).for_each(|(a, b)| *a |= b);
    Pvs { rows, proven: known.visible, work: log, candidates: candidate_count }
}

fn ones_lost(known: &Known) -> u64 {
    known.visible.words().iter().zip(known.possible.words()).map(|(v, p)| u64::from((v & !p).count_ones())).sum()
}

/// Whatever is hidden from a cell is not seen through its openings, nor through those that lead to it.
fn narrow(openings: &Openings, known: &mut Known) {
    for number in 0..openings.len() {
        let opening = openings.get(number);
        let (a, b) = (known.possible.row(opening.from), known.possible.row(opening.to));
        for (k, word) in known.might.row_mut(number).iter_mut().enumerate() {
            *word &= a[k] & b[k];
        }
    }
}

fn tighten(openings: &Openings, known: &mut Known) {
    narrow(openings, known);
    let cells = known.possible.rows();
    for number in 0..openings.len() {
        let opening = openings.get(number);
        for cell in ones(&known.might.row(number).to_vec()) {
            let sees = |o: u32| {
                let row = known.might.row(o);
                has(row, opening.from) && (cell == opening.to || has(row, opening.to))
            };
            if !openings.leaving(cell).any(sees) {
                clear(known.might.row_mut(number), cell);
            }
        }
    }
    for cell in 0..cells {
        let mut row = vec![0; known.possible.width()];
        super::rows::set(&mut row, cell);
        for o in openings.leaving(cell) {
            row.iter_mut().zip(known.might.row(o)).for_each(|(a, b)| *a |= b);
        }
        known.possible.row_mut(cell).iter_mut().zip(row).for_each(|(a, b)| *a &= b);
    }
    known.possible.keep_symmetric();
    narrow(openings, known);
}
