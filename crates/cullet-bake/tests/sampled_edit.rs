//! Sets that go on after an edit: what nobody saw change keeps its bytes, and the rest is found again.

use cullet::mesh::{Alpha, Part};
use cullet::{Handle, Instance, Mesh, MeshData, Scene, Transform};
use cullet_bake::sampled::{
    EditCounts, Granularity, RayTree, RayTreeOptions, SampledBake, SampledError, SampledSettings,
    ScenePvs, SceneSets, ViewCells, bake_sampled,
};
use cullet_bake::work::{RunEnd, RunOptions, UnitFolder};
use cullet_testkit::{Folder, Rng, cases};

/// A square of this half side in the plane z = 0, to be seen from both sides.
fn square(half: f32) -> Mesh {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let positions = corners.map(|[x, y]: [f32; 2]| [x * half, y * half, 0.0]).to_vec();
    let part = Part {
        first_triangle: 0,
        triangle_count: 2,
        material: 0,
        two_sided: true,
        alpha: Alpha::Opaque,
    };
    let indices = vec![0, 1, 2, 0, 2, 3];
    Mesh::new(MeshData { positions, indices, parts: vec![part], ..MeshData::default() })
        .expect("a good mesh")
}

/// Walls at every fourth step of z, and plates between them.
const ROOMS: u32 = 6;
const PLATES: u32 = 5;

/// Instances as they are added: the half side of each and where it stands.
type Row = Vec<(f32, [f64; 3])>;

fn rooms(rng: &mut Rng) -> Row {
    let wall = |room: u32| (60.0, [0.0, 1.0, f64::from(room) * 4.0]);
    let mut row: Row = (0..=ROOMS).map(wall).collect();
    for room in 0..ROOMS {
        for _ in 0..PLATES {
            let z = f64::from(room) * 4.0 + rng.range(0.4, 3.6);
            row.push((0.3, [rng.range(-2.0, 2.0), rng.range(0.0, 2.0), z]));
        }
    }
    row
}

fn scene(row: &Row) -> (Scene, Vec<Handle>) {
    let mut scene = Scene::new();
    let [wall, plate] = [60.0, 0.3].map(|half| scene.add_mesh(square(half)));
    let handles = row
        .iter()
        .map(|&(half, at)| {
            let mesh = if half > 1.0 { wall } else { plate };
            scene.add(Instance::new(mesh, Transform::from_translation(at))).expect("a mesh")
        })
        .collect();
    scene.commit(&cullet::Culler::default());
    (scene, handles)
}

/// A cell for each room.
fn cells() -> ViewCells {
    let high = f64::from(ROOMS) * 4.0;
    ViewCells::grid([[-2.0, 0.0, 0.0], [2.0, 2.0, high]], [1, 1, ROOMS]).expect("a box")
}

fn settings() -> SampledSettings {
    SampledSettings::default().with_rays(400_000).with_missing(0.0)
}

fn whole(scene: &Scene) -> ScenePvs {
    let tree = RayTree::new(scene, &RayTreeOptions::default()).expect("a scene");
    bake_sampled(&tree, &cells(), &settings(), 2).expect("good settings")
}

fn after(scene: &Scene, before: &SceneSets, threads: usize) -> (ScenePvs, EditCounts, u64) {
    let tree = RayTree::new(scene, &RayTreeOptions::default()).expect("a scene");
    let cells = ViewCells::of_boxes(&before.cells).expect("boxes");
    let mut bake = SampledBake::after(&tree, &cells, &settings(), before).expect("marks");
    let options = RunOptions { threads, ..RunOptions::default() };
    assert_eq!(bake.run(&options, &|_| true).expect("no folder"), RunEnd::Whole);
    let (counts, rays) = (bake.edited().expect("an edit"), bake.rays());
    (bake.finish(), counts, rays)
}

/// The cell of the room that holds a place.
fn cell_at(pvs: &ScenePvs, z: f64) -> u32 {
    let holds = |cell: &[[f64; 3]; 2]| cell[0][2] < z && z < cell[1][2];
    pvs.cells.iter().position(holds).expect("a room") as u32
}

#[test]
fn what_saw_nothing_change_keeps_its_set_and_the_rest_is_found_again() {
    let mut rng = Rng(41);
    for case in 0..cases(12) {
        let row = rooms(&mut rng);
        let (mut edited, handles) = scene(&row);
        let before = whole(&edited);
        let room = rng.index(ROOMS as usize) as u32;
        let plates = (ROOMS + 1 + room * PLATES) as usize;
        let mesh = edited.mesh_id(edited.slot(handles[plates]).expect("there"));
        edited.remove(handles[plates]).expect("there");
        let middle = f64::from(room) * 4.0 + 2.0;
        let moved = Transform::from_translation([rng.range(-1.5, 1.5), 1.0, middle]);
        edited.set_transform(handles[plates + 1], moved).expect("there");
        let new = Transform::from_translation([0.0, 0.5, middle + 0.7]);
        let new = edited.add(Instance::new(mesh, new)).expect("a mesh");
        // A wall goes in every other case, and two rooms become one.
        let wall = (room > 0 && case % 2 == 0).then(|| handles[room as usize]);
        if let Some(wall) = wall {
            edited.remove(wall).expect("there");
        }
        edited.commit(&cullet::Culler::default());
        let (again, counts, rays) = after(&edited, &before.to_sets(), 1);
        let fresh = whole(&edited);
        let open: Vec<u32> = (0..ROOMS)
            .filter(|&r| r == room || wall.is_some() && r + 1 == room)
            .map(|r| cell_at(&again, f64::from(r) * 4.0 + 2.0))
            .collect();
        assert_eq!((counts.came, counts.went), (2, 2 + u32::from(wall.is_some())), "case {case}");
        // A wall is so large that every cell keeps it.
        let touched = if wall.is_some() { ROOMS } else { 1 };
        assert_eq!(counts.cells, touched, "case {case}");
        let gone = wall.map_or(0, |wall| 1_u64 << wall.index);
        assert!(rays < 300_000, "{rays}");
        for cell in 0..ROOMS {
            let same = again.visible.row(cell)[0] == before.visible.row(cell)[0] & !gone;
            // What came may have the index of what went.
            assert!(same || open.contains(&cell), "case {case}, cell {cell}");
            let lost = fresh.found.row(cell)[0] & !again.visible.row(cell)[0];
            assert_eq!(lost, 0, "case {case}, cell {cell}");
            assert!(again.visible.has(cell, new.index) == open.contains(&cell) || wall.is_some());
            // The index of what went may be that of what came.
            assert!(
                handles[plates].index == new.index
                    || !again.visible.has(cell, handles[plates].index)
            );
        }
    }
}

#[test]
fn what_went_from_the_middle_of_a_file_only_moves_the_numbers() {
    let mut rng = Rng(42);
    let mut row = rooms(&mut rng);
    let before = whole(&scene(&row).0);
    let gone = (ROOMS + 1 + 2 * PLATES) as usize;
    row.remove(gone);
    let (again, counts, _) = after(&scene(&row).0, &before.to_sets(), 2);
    assert_eq!(counts, EditCounts { came: 0, went: 1, cells: 1 });
    let low = (1_u64 << gone) - 1;
    for cell in 0..ROOMS {
        let old = before.visible.row(cell)[0];
        let moved = old & low | old >> 1 & !low;
        assert_eq!(again.visible.row(cell)[0], moved, "cell {cell}");
    }
}

#[test]
fn without_an_edit_nothing_is_traced_and_nothing_changes() {
    let (scene, _) = scene(&rooms(&mut Rng(43)));
    let tree = RayTree::new(&scene, &RayTreeOptions::default()).expect("a scene");
    let (cells, joined) = (cells(), settings().with_union_radius(Some(0.0)));
    let before = bake_sampled(&tree, &cells, &joined, 2).expect("good settings").to_sets();
    let mut bake = SampledBake::after(&tree, &cells, &joined, &before).expect("marks");
    assert!(bake.is_done());
    let _ = bake.run(&RunOptions::default(), &|_| true);
    assert_eq!(bake.rays(), 0);
    // Joined sets are not joined once more.
    assert_eq!(bake.finish().to_sets(), before);
}

#[test]
fn threads_units_and_the_file_change_nothing() {
    let mut rng = Rng(44);
    let mut row = rooms(&mut rng);
    let before = whole(&scene(&row).0);
    row[9].1[0] += 0.4;
    row.push((0.3, [0.1, 1.0, 9.0]));
    let (edited, _) = scene(&row);
    let sets = SceneSets::from_bytes(&before.to_bytes()).expect("its own bytes");
    assert_eq!(sets, before.to_sets());
    let expected = after(&edited, &before.to_sets(), 1).0;
    assert_eq!(after(&edited, &sets, 3).0, expected);
    let folder = Folder::new("sampled-edit");
    let units = UnitFolder::new(folder.path("units").as_ref()).expect("a folder");
    let tree = RayTree::new(&edited, &RayTreeOptions::default()).expect("a scene");
    let cells = cells();
    for share in [Some([0, 2]), Some([1, 2]), None] {
        let mut bake = SampledBake::after(&tree, &cells, &settings(), &sets).expect("marks");
        let options = RunOptions { folder: Some(&units), share, ..RunOptions::default() };
        bake.run(&options, &|_| true).expect("a folder");
        if share.is_none() {
            assert_eq!(bake.finish(), expected);
        }
    }
    // Twice in a row: the second goes on from the first.
    let sets = expected.to_sets();
    assert_eq!(sets.rays, before.rays + after(&edited, &before.to_sets(), 1).2);
    assert_eq!(after(&edited, &sets, 1).2, 0);
}

#[test]
fn sets_that_do_not_fit_are_refused() {
    let (scene, _) = scene(&rooms(&mut Rng(45)));
    let before = whole(&scene).to_sets();
    let refused = |before: &SceneSets, granularity, cells: &ViewCells| {
        let options = RayTreeOptions { granularity, ..RayTreeOptions::default() };
        let tree = RayTree::new(&scene, &options).expect("a scene");
        let bake = SampledBake::after(&tree, cells, &settings(), before);
        matches!(bake.err(), Some(SampledError::Before))
    };
    let cells = cells();
    assert!(!refused(&before, Granularity::Instance, &cells));
    assert!(refused(&before, Granularity::Cluster, &cells));
    let other = ViewCells::grid([[0.0; 3], [1.0; 3]], [2, 1, 1]).expect("a box");
    assert!(refused(&before, Granularity::Instance, &other));
    let unmarked = SceneSets { marks: Vec::new(), ..before };
    assert!(refused(&unmarked, Granularity::Instance, &cells));
}
