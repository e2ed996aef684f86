//! Visible sets: what is packed is what was given, and the stage drops what is in no set and nothing else.

use cullet::{Culler, Handle, Instance, Output, Scene, Stage, Transform, View, ViewState, Visible};
use cullet_cells::cell::{CellGraph, Mirror};
use cullet_cells::pvs::{SetsError, Targets, Tile, VisibleSets, join_tiles};
use cullet_cells::{CellView, Cells, InCells};
use cullet_testkit::answers::cull;
use cullet_testkit::buildings::Building;
use cullet_testkit::{Rng, cases, meshes};

use super::stage::two_rooms;

/// A number smaller than `end`.
fn below(rng: &mut Rng, end: u32) -> u32 {
    rng.below(u64::from(end)) as u32
}

/// Rows of bits, as plain as can be.
fn plain(rng: &mut Rng, cells: u32, targets: u32) -> Vec<Vec<bool>> {
    let mut rows: Vec<Vec<bool>> = Vec::new();
    for cell in 0..cells {
        // Some rows are empty, some full, and some as another; most have a few runs.
        let share = [0.0, 1.0, 0.02, 0.5][below(rng, 4) as usize];
        let row = match below(rng, 5) {
            0 if cell > 0 => rows[below(rng, cell) as usize].clone(),
            1 => (0..targets).map(|_| rng.chance(share)).collect(),
            _ => {
                let mut row = vec![false; targets as usize];
                for _ in 0..below(rng, 6) {
                    let from = below(rng, targets.max(1)) as usize;
                    let to = (from + below(rng, targets / 3 + 1) as usize).min(row.len());
                    row[from.min(to)..to].fill(true);
                }
                row
            }
        };
        rows.push(row);
    }
    rows
}

fn words(row: &[bool]) -> Vec<u64> {
    let word = |bits: &[bool]| (0..).zip(bits).fold(0, |w, (k, &bit)| w | u64::from(bit) << k);
    row.chunks(64).map(word).collect()
}

fn sets_of(rows: &[Vec<bool>], targets: Targets, count: u32) -> VisibleSets<'static> {
    let rows: Vec<Vec<u64>> = rows.iter().map(|row| words(row)).collect();
    VisibleSets::from_rows(targets, count, rows.iter().map(Vec::as_slice))
}

fn numbers(row: impl IntoIterator<Item = bool>) -> Vec<u32> {
    (0..).zip(row).filter(|&(_, bit)| bit).map(|(k, _)| k).collect()
}

#[test]
fn packed_sets_say_what_plain_rows_say() {
    let mut rng = Rng(11);
    let counts = [0, 1, 63, 64, 65, 700, 4_095, 4_096, 4_097, 9_001];
    for case in 0..cases(60) {
        let (cells, count) = (below(&mut rng, 12) + 1, counts[case as usize % counts.len()]);
        let rows = plain(&mut rng, cells, count);
        let kept = sets_of(&rows, Targets::Instances, count);
        assert_eq!((kept.cell_count(), kept.target_count()), (cells, count));
        let bytes = kept.to_bytes();
        // At an odd address they are copied, elsewhere not; they are the same.
        let mut shifted = vec![0; 1];
        shifted.extend(&bytes);
        for read in [VisibleSets::from_bytes(&bytes), VisibleSets::from_bytes(&shifted[1..])] {
            assert_eq!(read.as_ref(), Ok(&kept));
        }
        for _ in 0..200 {
            let (cell, target) = (below(&mut rng, cells), below(&mut rng, count + 3));
            let plain = rows[cell as usize].get(target as usize).copied().unwrap_or(false);
            assert_eq!(kept.sees(cell, target), plain, "{target} of {count} from {cell}");
        }
        let [a, b] = [below(&mut rng, cells), below(&mut rng, cells)];
        let [row_a, row_b] = [a, b].map(|c| &rows[c as usize]);
        assert!(kept.seen_from(a).eq(numbers(row_a.iter().copied())));
        assert_eq!(kept.count(a), row_a.iter().filter(|&&bit| bit).count() as u32);
        let pairs = || row_a.iter().zip(row_b);
        assert!(kept.arriving(a, b).eq(numbers(pairs().map(|(a, b)| *b && !*a))));
        let both: Vec<bool> = pairs().map(|(a, b)| *a || *b).collect();
        assert_eq!(kept.union(&[a, b]), words(&both));
        let target = below(&mut rng, count.max(1));
        let seeing = rows.iter().map(|row| row.get(target as usize).copied().unwrap_or(false));
        assert!(kept.seeing(target).eq(numbers(seeing)));
        let some: Vec<u32> = (0..below(&mut rng, 4)).map(|_| below(&mut rng, count + 1)).collect();
        let any = some.iter().any(|&t| both.get(t as usize).copied().unwrap_or(false));
        assert_eq!(kept.any_sees(&[a, b], &some), any);
        // Of a cell that is not there nothing is known.
        assert!(count == 0 || kept.sees(cells, 0));
        assert_eq!(kept.count(cells), count);
    }
}

#[test]
fn rows_of_few_bits_are_small() {
    let rows: Vec<Vec<u64>> = (0..1000_usize)
        .map(|cell| (0..157).map(|w| u64::from(w == cell % 157)).collect())
        .collect();
    let sets = VisibleSets::from_rows(Targets::Cells, 10_000, rows.iter().map(Vec::as_slice));
    // 157 rows are different, each of three pairs of index words and one more.
    assert_eq!(sets.size(), 1000 * 4 + 157 * 7 * 8);
}

#[test]
fn nonsense_is_refused_or_harmless() {
    let mut rng = Rng(12);
    let rows = plain(&mut rng, 5, 300);
    let good = sets_of(&rows, Targets::Cells, 300).to_bytes();
    for length in 0..good.len() {
        let error = VisibleSets::from_bytes(&good[..length]).unwrap_err();
        assert!(matches!(error, SetsError::Size { .. }), "{error}");
    }
    assert_eq!(
        VisibleSets::from_bytes(&good[..20]).unwrap_err().to_string(),
        format!("20 bytes of visible sets, but their header says {}: cut short?", good.len())
    );
    let (mut refused, mut read) = (0, 0);
    for _ in 0..cases(3000) {
        let mut bytes = good.clone();
        for _ in 0..=below(&mut rng, 3) {
            let at = below(&mut rng, bytes.len() as u32) as usize;
            bytes[at] = below(&mut rng, 256) as u8;
        }
        match VisibleSets::from_bytes(&bytes) {
            Err(_) => refused += 1,
            Ok(sets) => {
                read += 1;
                for cell in 0..6 {
                    let all: Vec<u32> = sets.seen_from(cell).collect();
                    assert!(all.iter().all(|&t| t < sets.target_count()));
                    let _ = (sets.sees(cell, 299), sets.count(cell));
                }
            }
        }
    }
    assert!(refused > cases(3000) / 50 && read > cases(3000) / 2, "{refused} {read}");
}

#[test]
fn a_tile_that_numbers_a_target_past_the_end_is_harmless() {
    let sets = sets_of(&[vec![true; 2]], Targets::Instances, 2);
    let cells = [[[0.0; 3], [1.0; 3]]];
    for past in [64, 65, 128, u32::MAX] {
        let tile = Tile { sets: &sets, cells: &cells, targets: &[3, past], bounds: &[cells[0]; 2] };
        let joined = join_tiles(&[tile], 64).unwrap();
        assert_eq!(joined.sets.target_count(), 64);
        // What no tile numbers may be anywhere, and is kept.
        assert_eq!((joined.sets.count(0), joined.unknown), (64, 63), "{past}");
    }
}

#[test]
fn what_is_within_another_tile_and_seen_by_none_of_its_cells_is_dropped() {
    let sets = sets_of(&[vec![true, false, false]], Targets::Instances, 3);
    let cells = [0.0, 4.0].map(|x| [[[x, 0.0, 0.0], [x + 4.0, 4.0, 4.0]]]);
    // One seen, one not, and one that is not and reaches out.
    let inside = |x: f64| [[x, 0.0, 1.0], [x + 4.0, 1.0, 2.0]];
    let bounds = [0.0, 4.0].map(|x| [inside(x), inside(x), inside(x + 0.5)]);
    let tile =
        |k: usize, targets| Tile { sets: &sets, cells: &cells[k], targets, bounds: &bounds[k] };
    let joined = join_tiles(&[tile(0, &[0, 1, 2]), tile(1, &[3, 4, 5])], 6).unwrap();
    assert!(joined.sets.seen_from(0).eq([0, 3, 5]));
    assert!(joined.sets.seen_from(1).eq([0, 2, 3]));
    assert_eq!(joined.unknown, 2);
}

/// Balls about a building.
fn furnish(rng: &mut Rng, building: &Building) -> (Scene, Vec<Handle>) {
    let mut scene = Scene::new();
    let ball = scene.add_mesh(meshes::ball(4));
    let handles = (0..150).map(|_| add(rng, building, &mut scene, ball)).collect();
    scene.commit(&Culler::default());
    (scene, handles)
}

fn place(rng: &mut Rng, building: &Building) -> Transform {
    let (at, _) = building.point(rng, 0.0);
    Transform::from_scale_translation([rng.range(0.02, 0.6) as f32; 3], at)
}

fn add(rng: &mut Rng, building: &Building, scene: &mut Scene, mesh: u32) -> Handle {
    let at = place(rng, building);
    scene.add(Instance::new(mesh, at)).unwrap()
}

/// In every direction from an eye.
fn around(eye: [f64; 3]) -> [View; 2] {
    [1.0, -1.0].map(|side| {
        let target = [eye[0] + side, eye[1], eye[2]];
        View::perspective(eye, target, 2.0, 1e-4, 900.0, [64, 64]).unwrap()
    })
}

#[test]
fn the_stage_drops_what_is_in_no_set_and_nothing_else() {
    let mut rng = Rng(13);
    let culler = Culler::default().with_output(Output::Instances).with_reasons(true);
    let culler = culler.only(Stage::Pvs);
    let (mut dropped, mut kept) = (0, 0);
    for case in 0..cases(40) {
        let building = Building::new(&mut rng, [4, 2, 4]);
        let (mut scene, mut handles) = furnish(&mut rng, &building);
        let cells = building.graph.cell_count();
        let of_cells = case % 2 == 0;
        let (targets, count) = match of_cells {
            true => (Targets::Cells, cells),
            // Some are not known to the sets at all.
            false => (Targets::Instances, 140),
        };
        let rows = plain(&mut rng, cells, count);
        let mut placed = Cells::new(&mut scene, building.graph.clone(), building.shapes.clone());
        placed.set_visible_sets(sets_of(&rows, targets, count)).unwrap();
        // Moved since the sets were given, and since they were found in cells.
        let (mut moved, mut unfound): (Vec<Handle>, Vec<Handle>) = Default::default();
        let mut states = [(); 2].map(|()| (ViewState::default(), CellView::default()));
        let mut result = Visible::default();
        for _ in 0..12 {
            let action = below(&mut rng, 6);
            match action {
                0 => {
                    let handle = handles[below(&mut rng, handles.len() as u32) as usize];
                    scene.set_transform(handle, place(&mut rng, &building)).unwrap();
                    moved.push(handle);
                    unfound.push(handle);
                }
                1 => {
                    let handle =
                        handles.swap_remove(below(&mut rng, handles.len() as u32) as usize);
                    scene.remove(handle).unwrap();
                }
                2 => {
                    let handle = add(&mut rng, &building, &mut scene, 0);
                    handles.push(handle);
                    moved.push(handle);
                    unfound.push(handle);
                }
                3 => drop(scene.commit(&Culler::default())),
                4 => drop(scene.commit_slice()),
                _ => scene.rebase(rng.vector(5.0)),
            }
            if action >= 3 || rng.chance(0.5) {
                scene.refit();
                placed.update(&scene);
                unfound.clear();
            }
            let free = if of_cells { &unfound } else { &moved };
            let (eye, cell) = building.point(&mut rng, 0.02);
            for (view, (state, among)) in around(eye).iter().zip(&mut states) {
                let among = among.on(&placed);
                culler.cull_among(&scene, view, &among, state, &mut result).unwrap();
                assert_eq!(
                    result,
                    cull(&culler, (&scene, &placed), view),
                    "what was known of the last view"
                );
                for slot in scene.slots() {
                    let handle = scene.handle(slot).unwrap();
                    let is_seen = match of_cells {
                        true => {
                            let own = placed.cells_of(slot);
                            own.iter().any(|&c| rows[cell as usize][c as usize])
                        }
                        false => {
                            let row = &rows[cell as usize];
                            row.get(handle.index as usize).copied().unwrap_or(true)
                        }
                    };
                    let was_dropped = result.reasons[slot as usize].is_some();
                    if is_seen || free.contains(&handle) {
                        assert!(!was_dropped, "slot {slot}");
                        kept += 1;
                    } else if was_dropped {
                        dropped += 1;
                    } else {
                        // Of what is in no set, only what reaches out of the cells is kept.
                        assert!(of_cells, "slot {slot}");
                    }
                }
            }
        }
    }
    assert!(dropped > cases(40) * 500 && kept > cases(40) * 500, "{dropped} {kept}");
}

#[test]
fn what_a_mirror_may_show_is_in_the_sets_of_its_cell() {
    let polygon = vec![[8.0, 0.5, 1.0], [8.0, 0.5, 3.0], [8.0, 2.0, 3.0], [8.0, 2.0, 1.0]];
    let (scene, mut cells, [near, far], view) = two_rooms(vec![Mirror { cell: 1, polygon }]);
    assert_eq!((near.index, far.index), (0, 1));
    let rows = [vec![true, false], vec![true, true]];
    cells.set_visible_sets(sets_of(&rows, Targets::Instances, 2)).unwrap();
    let mut culler = Culler::default().with_output(Output::Instances).only(Stage::Pvs);
    culler.portal = true;
    for mirrors in [0, 1] {
        let mut among = CellView::default();
        among.options.mirrors = mirrors;
        let (mut state, mut result) = (ViewState::default(), Visible::default());
        culler.cull_among(&scene, &view, &among.on(&cells), &mut state, &mut result).unwrap();
        assert_eq!(result.instance_count, u64::from(1 + mirrors), "{mirrors} mirrors");
    }
}

#[test]
fn explanations_name_the_set() {
    let mut rng = Rng(14);
    let building = Building::new(&mut rng, [3, 1, 3]);
    let (mut scene, handles) = furnish(&mut rng, &building);
    let cells = building.graph.cell_count();
    let own: Vec<Vec<bool>> = (0..cells).map(|a| (0..cells).map(|b| a == b).collect()).collect();
    let shapes = building.shapes.clone().sealed();
    let mut placed = Cells::new(&mut scene, building.graph.clone(), shapes);
    placed.set_visible_sets(sets_of(&own, Targets::Cells, cells)).unwrap();
    let (eye, cell) = building.point(&mut rng, 0.02);
    let (mut inside, mut beyond) = (0, 0);
    for &handle in &handles {
        let told = Culler::default().only(Stage::Pvs);
        let told =
            InCells::from((&scene, &placed)).explain(&told, &around(eye)[0], handle).unwrap();
        let words = told.steps.last().unwrap().to_string();
        let slot = scene.slot(handle).unwrap();
        match placed.cells_of(slot).contains(&cell) {
            true => assert!(words.ends_with(&format!(", in the set of cell {cell}")), "{words}"),
            false => assert!(words.contains(", not in the set of cell"), "{words}"),
        }
        *if told.reason.is_some() { &mut beyond } else { &mut inside } += 1;
    }
    assert!(inside > 0 && beyond > 0);
}

#[test]
fn sets_of_other_cells_are_refused() {
    let mut scene = Scene::new();
    let sets = |cells: u32, targets| {
        let rows = vec![vec![true; targets as usize]; cells as usize];
        sets_of(&rows, Targets::Cells, targets)
    };
    let graph = CellGraph::new(3, Vec::new()).unwrap();
    let shapes = cullet_cells::cell::CellShapes::new(&graph, Vec::new()).unwrap();
    let mut placed = Cells::new(&mut scene, graph, shapes);
    for (cells, targets) in [(2, 2), (2, 3), (3, 2)] {
        let refused = placed.set_visible_sets(sets(cells, targets));
        assert_eq!(refused, Err(SetsError::Cells { sets: 2, cells: 3 }));
        assert!(placed.visible_sets().is_none());
    }
    placed.set_visible_sets(sets(3, 3)).unwrap();
    assert_eq!(placed.visible_sets().unwrap().cell_count(), 3);
}
