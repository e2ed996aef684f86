//! Sets that were baked apart and joined: nothing that a whole bake sees may be lacking.

use cullet::{Instance, Scene, Transform};
use cullet_bake::pvs::{BitRows, Pvs, PvsSettings, bake};
use cullet_bake::sampled::{
    RayTree, RayTreeOptions, Region, SampledSettings, ScenePvs, SceneSets, ViewCells, bake_sampled,
};
use cullet_cells::cell::{CellGraph, Portal};
use cullet_cells::pvs::{LevelCell, VisibleSets, join_levels};
use cullet_io::baked::SceneSetsError;
use cullet_testkit::{Rng, cases, meshes};

/// Every pair of the rows is one of the sets, with cells renumbered.
fn holds_all(rows: &BitRows, sets: &VisibleSets<'_>, number: impl Fn(u32) -> u32) -> bool {
    let pairs = || (0..rows.rows()).flat_map(|a| (0..rows.rows()).map(move |b| (a, b)));
    pairs().all(|(a, b)| !rows.has(a, b) || sets.sees(number(a), number(b)))
}

#[test]
fn levels_of_rooms_join_to_no_less_than_a_whole_bake() {
    let (mut whole_pairs, mut joined_pairs, mut all_pairs) = (0, 0, 0);
    for case in 0..cases(20) {
        let size = [[6, 3, 1], [4, 3, 2], [8, 2, 1]][case as usize % 3];
        let graph = super::pvs::rooms(u64::from(case) + 300, size);
        let count = graph.cell_count();
        // The left half and the right one.
        let level_of = |cell: u32| u32::from(cell % size[0] >= size[0] / 2);
        let mut counts = [0; 2];
        let numbers: Vec<LevelCell> = (0..count)
            .map(|cell| {
                let level = level_of(cell);
                counts[level as usize] += 1;
                LevelCell { level, cell: counts[level as usize] - 1 }
            })
            .collect();
        let (mut portals, mut borders) = ([Vec::new(), Vec::new()], Vec::new());
        for Portal { cells, polygon } in graph.portals().iter().cloned() {
            let ends = cells.map(|cell| numbers[cell as usize]);
            if ends[0].level == ends[1].level {
                let cells = ends.map(|end| end.cell);
                portals[ends[0].level as usize].push(Portal { cells, polygon });
            } else {
                borders.push(ends);
            }
        }
        let [left, right] = portals;
        let baked: Vec<Pvs> = [left, right]
            .into_iter()
            .zip(counts)
            .map(|(portals, count)| {
                let level = CellGraph::new(count, portals).expect("a part of a graph");
                bake(&level, &PvsSettings::default(), 1)
            })
            .collect();
        let sets: Vec<VisibleSets<'_>> = baked.iter().map(Pvs::sets).collect();
        let joined = join_levels(&sets, &borders).expect("levels");
        assert_eq!(joined.unknown > 0, borders.is_empty());
        let number = |cell: u32| {
            let LevelCell { level, cell } = numbers[cell as usize];
            joined.first_cells[level as usize] + cell
        };
        let whole = bake(&graph, &PvsSettings::default(), 1);
        assert!(holds_all(whole.proven(), &joined.sets, number), "case {case}");
        if !borders.is_empty() {
            whole_pairs += whole.visible_pairs();
            joined_pairs += (0..count).map(|c| u64::from(joined.sets.count(c)) - 1).sum::<u64>();
            all_pairs += u64::from(count) * u64::from(count - 1);
        }
    }
    // It hides, if less.
    assert!(whole_pairs < joined_pairs && joined_pairs * 10 < all_pairs * 9);
}

/// Walls and balls in a box.
fn tile(scene: &mut Scene, [low, high]: Region, rng: &mut Rng) {
    let ball = scene.add_mesh(meshes::ball(6));
    let size: [f64; 3] = std::array::from_fn(|a| high[a] - low[a]);
    for k in 0..26 {
        // Every third is a wall from floor to ceiling.
        let scale = if k % 3 == 0 { [0.2, 1.4, 2.2] } else { [0.15; 3] };
        let scale: [f64; 3] = if k % 2 == 0 { scale } else { [scale[2], scale[1], scale[0]] };
        let mut transform = Transform::from_translation(std::array::from_fn(|a| {
            low[a] + scale[a] + (size[a] - 2.0 * scale[a]).max(0.0) * rng.range(0.0, 1.0)
        }));
        for a in 0..3 {
            transform.linear[a][a] = scale[a] as f32;
        }
        scene.add(Instance::new(ball, transform)).expect("a mesh");
    }
    scene.commit(&cullet::Culler::default());
}

fn sampled(scene: &Scene, cells: &ViewCells, rays: u64) -> ScenePvs {
    let tree = RayTree::new(scene, &RayTreeOptions::default()).expect("a scene");
    let settings = SampledSettings::default().with_rays(rays).with_missing(0.0);
    bake_sampled(&tree, cells, &settings, 2).expect("good settings")
}

#[test]
fn tiles_join_to_no_less_than_a_whole_bake() {
    let mut rng = Rng(61);
    let (mut lacking, mut own, mut across, mut hidden, mut all) = (0, 0, 0, 0, 0);
    for _ in 0..cases(4) {
        let regions: [Region; 2] =
            [[[0.0; 3], [8.0, 3.0, 8.0]], [[8.0, 0.0, 0.0], [16.0, 3.0, 8.0]]];
        let (mut whole, mut baked) = (Scene::new(), Vec::new());
        for region in regions {
            let seed = rng.0;
            let mut alone = Scene::new();
            tile(&mut alone, region, &mut rng);
            tile(&mut whole, region, &mut Rng(seed));
            let cells = ViewCells::grid(region, [3, 1, 3]).expect("a box");
            baked.push(sampled(&alone, &cells, 2_000_000).to_sets());
        }
        let (joined, unknown) = SceneSets::join(&baked, &whole).expect("both are there");
        assert_eq!(joined.cells.len(), 18);
        let cells = ViewCells::of_boxes(&joined.cells).expect("boxes");
        let fresh = sampled(&whole, &cells, 400_000);
        for cell in 0..18 {
            for target in fresh.seen_from(cell) {
                let is_across = (cell < 9) != (target < 26);
                let is_lacking = !joined.sets.sees(cell, target);
                lacking += u32::from(is_lacking && is_across);
                own += u32::from(is_lacking && !is_across);
                across += u32::from(is_across);
            }
            hidden += 52 - joined.sets.count(cell);
            all += 52;
        }
        // Balls reach out of no tile.
        assert_eq!(unknown, 0);
        let _ = joined.clone().place_in(&mut whole).expect("sets of this scene");
        // One tile is moved, or not there.
        let refused = SceneSets::join(&baked, &Scene::new());
        assert!(matches!(refused, Err(SceneSetsError::NotThere { tile: 0, instance: 0 })));
        let unmarked = SceneSets { marks: Vec::new(), ..joined };
        let refused = SceneSets::join(&[unmarked], &whole);
        assert!(matches!(refused, Err(SceneSetsError::Unmarked { tile: 0 })));
    }
    // Lines miss a few of their own tile, joined or not.
    assert!(lacking * 100 < across && own * 50 < across, "{lacking}, {own} of {across}");
    assert!(across > cases(4) * 50 && hidden * 10 > all, "{across} {hidden} {all}");
}
