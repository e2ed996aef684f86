//! Sets of cells against sampled lines of sight, on random rooms and on real maps.

use std::sync::atomic::{AtomicU32, Ordering};

use cullet_bake::pvs::{
    Bake, BitRows, PairState, Pvs, PvsPreset, PvsSettings, bake, check_sight_ref,
};
use cullet_bake::work::{Rounds, RunEnd, RunOptions, UnitFolder, run, split};
use cullet_cells::cell::{CellGraph, Portal};
use cullet_io::baked::PvsFileError;
use cullet_io::baked::{CellSets, Container};
use cullet_testkit::{Folder, cases, data};

/// Random numbers of these tests.
struct Dice(u64);

impl Dice {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Edge of a room.
const ROOM: f64 = 8.0;

/// Rooms on a grid; walls between neighbours have a door, none, or are missing.
pub(crate) fn rooms(seed: u64, size: [u32; 3]) -> CellGraph {
    let mut dice = Dice(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
    let number = |p: [u32; 3]| (p[2] * size[1] + p[1]) * size[0] + p[0];
    let mut portals = Vec::new();
    for z in 0..size[2] {
        for y in 0..size[1] {
            for x in 0..size[0] {
                for axis in 0..3 {
                    let here = [x, y, z];
                    let mut next = here;
                    next[axis] += 1;
                    let kind = dice.unit();
                    if next[axis] >= size[axis] || kind < 0.35 {
                        continue;
                    }
                    let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
                    let mut span = || {
                        let (a, b) = (dice.unit(), dice.unit());
                        if kind > 0.9 { [0.0, ROOM] } else { [a * 4.0, a * 4.0 + 0.3 + b * 3.5] }
                    };
                    let (a, b) = (span(), span());
                    let polygon = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[i, j]: [usize; 2]| {
                        let mut p = here.map(|v| f64::from(v) * ROOM);
                        p[axis] += ROOM;
                        p[u] += a[i];
                        p[v] += b[j];
                        p
                    });
                    // The normal points along the axis, to the next.
                    portals.push(Portal {
                        cells: [number(next), number(here)],
                        polygon: polygon.to_vec(),
                    });
                }
            }
        }
    }
    CellGraph::new(size.iter().product(), portals).unwrap()
}

/// Checks what must hold for every result.
fn check(graph: &CellGraph, pvs: &Pvs, lines: u64) {
    let sampled = check_sight_ref(graph, pvs.visible(), lines, 3, 1e-3, 1);
    assert_eq!(sampled.missed, 0, "{:?}", sampled.first);
    assert_eq!(pvs.prove_again(graph).unwrap(), *pvs.proven());
    for a in 0..graph.cell_count() {
        assert!(pvs.proven().has(a, a) && pvs.visible().has(a, a));
        for b in 0..graph.cell_count() {
            assert_eq!(pvs.state(a, b), pvs.state(b, a));
            assert!(!pvs.proven().has(a, b) || pvs.visible().has(a, b));
        }
    }
}

#[test]
fn no_sampled_line_of_sight_is_missed_in_random_rooms() {
    let (mut undecided, mut pairs, mut candidates) = (0, 0, 0);
    for case in 0..cases(40) {
        let size = [[4, 4, 1], [3, 3, 3], [7, 2, 2], [1, 6, 1]][case as usize % 4];
        let graph = rooms(u64::from(case) + 1, size);
        let pvs = bake(&graph, &PvsSettings::default(), 1);
        check(&graph, &pvs, 4000);
        undecided += pvs.undecided();
        pairs += pvs.visible_pairs();
        candidates += pvs.candidates();
    }
    // It decides, and culls.
    assert!(undecided * 100 <= pairs, "{undecided} undecided of {pairs}");
    assert!(pairs * 10 < candidates * 9, "{pairs} kept of {candidates}");
}

#[test]
fn a_preset_keeps_more_and_misses_nothing() {
    let graph = rooms(5, [4, 4, 2]);
    let full = bake(&graph, &PvsSettings::default(), 1);
    let fast = bake(&graph, &PvsSettings::default().with_preset(PvsPreset::Fast), 1);
    check(&graph, &fast, 20_000);
    assert_eq!(fast.visible_pairs(), fast.candidates());
    assert!(fast.visible_pairs() > full.visible_pairs());
}

#[test]
fn a_slit_is_seen_through_until_it_is_thinner_than_the_tolerance() {
    // A row of rooms along x, whose doors overlap by so much.
    let row = |overlap: f64| {
        let door = |cell: u32, x: f64, low: f64, high: f64| Portal {
            cells: [cell + 1, cell],
            polygon: vec![[x, low, 0.0], [x, high, 0.0], [x, high, 4.0], [x, low, 4.0]],
        };
        let portals = vec![
            door(0, 10.0, 0.0, 2.0),
            door(1, 20.0, 2.0 - overlap, 4.0),
            door(2, 30.0, 0.0, 2.0),
            door(3, 40.0, 2.0 - overlap, 4.0),
        ];
        let graph = CellGraph::new(5, portals).unwrap();
        bake(&graph, &PvsSettings::default(), 1).state(0, 4)
    };
    // Zigzag doors: without overlap a line would have to go along the wall at y = 2.
    assert_eq!(row(-0.01), PairState::Hidden);
    assert_eq!(row(0.0), PairState::Hidden);
    for overlap in [1e-2, 1e-3, 2e-4] {
        assert_ne!(row(overlap), PairState::Hidden, "{overlap}");
    }
    assert_eq!(row(1e-2), PairState::Visible);
}

#[test]
fn graphs_of_next_to_nothing_have_their_sets() {
    let none = bake(&CellGraph::default(), &PvsSettings::default(), 2);
    assert_eq!((none.cell_count(), none.visible_pairs(), none.rows_bytes().len()), (0, 0, 16));
    let lonely = CellGraph::new(3, Vec::new()).unwrap();
    let pvs = bake(&lonely, &PvsSettings::default(), 2);
    assert_eq!((pvs.visible_pairs(), pvs.visible().count()), (0, 3));
    check(&lonely, &pvs, 10);
    let corners: Vec<_> = (0..200)
        .map(|k| (f64::from(k) * std::f64::consts::TAU / 200.0).sin_cos())
        .map(|(s, c)| [0.0, c, s])
        .collect();
    let round = CellGraph::new(2, vec![Portal { cells: [1, 0], polygon: corners }]).unwrap();
    let pvs = bake(&round, &PvsSettings::default(), 2);
    assert_eq!(pvs.state(0, 1), PairState::Visible, "a portal of 200 corners");
}

/// Bakes in shares, one after the other, in an order of their own; then joins them.
fn in_shares(graph: &CellGraph, shares: &[u32], threads: usize) -> Pvs {
    let folder = Folder::new("pvs");
    let units = UnitFolder::new(folder.root()).unwrap();
    let settings = PvsSettings::default();
    for &share in shares {
        let mut part = Bake::new(graph, &settings, 1);
        let options = RunOptions {
            threads,
            folder: Some(&units),
            share: Some([share, shares.len() as u32]),
            ..RunOptions::default()
        };
        assert_eq!(part.run(&options, &|_| true).unwrap(), RunEnd::Share);
    }
    let mut whole = Bake::new(graph, &settings, 1);
    let options = RunOptions { threads, folder: Some(&units), ..RunOptions::default() };
    assert_eq!(whole.run(&options, &|_| true).unwrap(), RunEnd::Whole);
    whole.finish()
}

#[test]
fn what_is_expected_rises_to_all_of_it() {
    for (size, preset) in
        [([4, 4, 2], PvsPreset::Full), ([4, 4, 2], PvsPreset::Fast), ([1, 1, 1], PvsPreset::Full)]
    {
        let settings = PvsSettings::default().with_preset(preset);
        let mut bake = Bake::new(&rooms(15, size), &settings, 1);
        let seen = std::sync::Mutex::new(Vec::new());
        let step = |share| {
            seen.lock().unwrap().push(share);
            true
        };
        assert_eq!(run(&mut bake, &RunOptions::default(), &step).unwrap(), RunEnd::Whole);
        let seen = seen.into_inner().unwrap();
        assert!(seen.is_sorted() && seen.iter().all(|s| (0.0..=1.0).contains(s)), "{seen:?}");
        assert!(seen.last().is_some_and(|&last| last > 0.999_999), "{seen:?}");
    }
}

/// Bakes as strangers would: each holds the work itself, begins at another time, and cuts rounds otherwise.
#[test]
fn units_of_strangers_make_the_same_bytes() {
    let graph = rooms(11, [5, 5, 3]);
    let settings = PvsSettings::default();
    let new = || Bake::new(&graph, &settings, 1);
    let (mut joiner, mut rounds) = (new(), Vec::<Vec<_>>::new());
    while !joiner.costs().is_empty() {
        let round = joiner.round();
        let units = split(&joiner.costs(), 1 + round * 5);
        // Who begins late takes in what was found before from its bytes.
        let mut stranger = new();
        for units in &rounds {
            let read = |(items, bytes): &(std::ops::Range<u32>, Vec<u8>)| {
                stranger.read(items.clone(), bytes).unwrap()
            };
            let parts = units.iter().map(read).collect();
            stranger.merge(parts);
        }
        assert_eq!((stranger.round(), stranger.key()), (round, joiner.key()));
        // Last first.
        let made = units.iter().rev().map(|items| {
            let part = stranger.run_items(items.clone(), 1, &|_| true).unwrap();
            (items.clone(), Bake::bytes_of(&part))
        });
        let mut made: Vec<_> = made.collect();
        made.reverse();
        joiner
            .merge(made.iter().map(|(items, b)| joiner.read(items.clone(), b).unwrap()).collect());
        rounds.push(made);
    }
    assert!(joiner.finish().to_bytes() == bake(&graph, &settings, 2).to_bytes());
}

#[test]
fn a_folder_of_another_split_serves() {
    let graph = rooms(16, [4, 4, 2]);
    let settings = PvsSettings::default();
    let folder = Folder::new("pvs");
    let units = UnitFolder::new(folder.root()).unwrap();
    let with = |units_a_round| RunOptions {
        folder: Some(&units),
        units: units_a_round,
        ..RunOptions::default()
    };
    let steps = AtomicU32::new(0);
    let mut stopped = Bake::new(&graph, &settings, 1);
    let step = |_| steps.fetch_add(1, Ordering::Relaxed) < 50;
    assert_eq!(stopped.run(&with(7), &step).unwrap(), RunEnd::Stopped);
    let files = || std::fs::read_dir(folder.root()).unwrap().count();
    for split in [3, 11] {
        let mut other = Bake::new(&graph, &settings, 1);
        assert_eq!(other.run(&with(split), &|_| true).unwrap(), RunEnd::Whole);
        assert!(other.finish().to_bytes() == bake(&graph, &settings, 1).to_bytes());
    }
    let before = files();
    let mut last = Bake::new(&graph, &settings, 1);
    assert_eq!(last.run(&with(64), &|_| true).unwrap(), RunEnd::Whole);
    assert_eq!(files(), before, "nothing was left to do");
}

#[test]
fn threads_and_units_change_no_byte() {
    let graph = rooms(11, [5, 5, 3]);
    let one = bake(&graph, &PvsSettings::default(), 1).to_bytes();
    for threads in [2, 8] {
        assert!(
            bake(&graph, &PvsSettings::default(), threads).to_bytes() == one,
            "{threads} threads"
        );
    }
    for shares in [&[0][..], &[0, 1, 2], &[2, 0, 1], &[0; 1]] {
        assert!(in_shares(&graph, shares, 2).to_bytes() == one, "shares {shares:?}");
    }
}

#[test]
fn a_stopped_bake_goes_on_from_its_units_even_damaged_ones() {
    let graph = rooms(12, [5, 4, 2]);
    let settings = PvsSettings::default();
    let folder = Folder::new("pvs");
    let units = UnitFolder::new(folder.root()).unwrap();
    let options = RunOptions { threads: 2, folder: Some(&units), ..RunOptions::default() };
    let steps = AtomicU32::new(0);
    let mut stopped = Bake::new(&graph, &settings, 1);
    let end = stopped.run(&options, &|_| steps.fetch_add(1, Ordering::Relaxed) < 60);
    assert_eq!(end.unwrap(), RunEnd::Stopped);
    let files: Vec<_> =
        std::fs::read_dir(folder.root()).unwrap().flatten().map(|f| f.path()).collect();
    assert!(files.len() > 5, "{files:?}");
    // Even what was stopped is conservative.
    check(&graph, &stopped.finish(), 4000);
    std::fs::write(&files[1], b"PVSUNIT1, but no more").unwrap();
    let mut again = Bake::new(&graph, &settings, 1);
    assert_eq!(again.run(&options, &|_| true).unwrap(), RunEnd::Whole);
    assert!(again.finish().to_bytes() == bake(&graph, &settings, 1).to_bytes());
}

#[test]
fn a_file_comes_back_and_a_damaged_or_foreign_one_is_refused() {
    let graph = rooms(13, [3, 3, 1]);
    let pvs = bake(&graph, &PvsSettings::default(), 1);
    let bytes = pvs.to_bytes();
    assert_eq!(Pvs::from_bytes(&bytes), Ok(pvs.clone()));
    for cut in 0..bytes.len() {
        assert!(Pvs::from_bytes(&bytes[..cut]).is_err(), "cut at {cut}");
    }
    for at in (0..bytes.len()).step_by(5) {
        let mut odd = bytes.clone();
        odd[at] ^= 1;
        assert!(Pvs::from_bytes(&odd).is_err(), "odd at {at}");
    }
    for (a, b) in (0..9).flat_map(|a| (0..9).map(move |b| (a, b))) {
        let is_proven = a != b && pvs.state(a, b) == PairState::Visible;
        assert_eq!(pvs.proof(&graph, a, b).unwrap().is_some(), is_proven, "{a} {b}");
    }
    // What is looked up is the same, and lies where the file does.
    let file = Container::open(&bytes).unwrap();
    assert!(CellSets::is_of(&file));
    let stored = CellSets::open(file).unwrap();
    let sets = stored.of_graph(&graph).unwrap();
    assert_eq!(sets, pvs.sets());
    for (a, b) in (0..9).flat_map(|a| (0..9).map(move |b| (a, b))) {
        assert_eq!(sets.sees(a, b), pvs.visible().has(a, b));
    }
    let other = rooms(14, [3, 3, 1]);
    assert!(matches!(stored.of_graph(&other), Err(PvsFileError::OtherGraph { .. })));
    assert!(matches!(pvs.check_graph(&other), Err(PvsFileError::OtherGraph { .. })));
    assert!(pvs.prove_again(&other).is_err());
}

#[test]
fn sets_of_real_maps_hold_what_is_seen_and_little_else() {
    for name in ["gen_small", "lq_e0m9", "lq_e0m4", "lqdm12", "lqdm11"] {
        let Some(path) = data(&format!("portals/{name}.prt")) else { return };
        let graph = cullet_maps::load_prt(&path).unwrap().graph;
        let pvs = bake(&graph, &PvsSettings::default(), 2);
        let sampled = check_sight_ref(&graph, pvs.visible(), 100_000, 1, 0.05, 2);
        assert_eq!(sampled.missed, 0, "{name}: {:?}", sampled.first);
        assert!(pvs.undecided() * 50 <= pvs.visible_pairs(), "{name}: {}", pvs.undecided());
        let vis = std::fs::read(path.with_extension("pvs")).unwrap();
        let vis = BitRows::from_exchange(&vis).unwrap();
        let cells = graph.cell_count();
        let both =
            |a: u32| (0..cells).filter(|&b| a != b && vis.has(a, b) && vis.has(b, a)).count();
        let theirs: usize = (0..cells).map(both).sum();
        let ours = pvs.visible_pairs();
        assert!(ours as f64 <= theirs as f64 * 1.001, "{name}: {ours} pairs, vis has {theirs}");
        let shares = in_shares(&graph, &[0, 1, 2], 2);
        assert!(shares.to_bytes() == pvs.to_bytes(), "{name}");
    }
}
