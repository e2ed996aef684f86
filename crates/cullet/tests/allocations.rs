//! Culling allocates nothing once its state has grown.

use std::sync::atomic::{AtomicU32, Ordering};

use cullet::bounds::Aabb;
use cullet::cull::frustum::batch::Planes;
use cullet::cull::frustum::tree::Cut;
use cullet::cull::occlusion::{DynamicSurface, Occlusion, OcclusionBuffer};
use cullet::hierarchy::Hierarchy;
use cullet::jobs::{Job, Jobs};
use cullet::{
    Culler, DrawList, Instance, Output, Scene, Simd, Stage, Transform, View, ViewState, Visible,
    prepared::Preparation,
};
use cullet_cells::{CellView, Cells};
use cullet_testkit::buildings::Building;
use cullet_testkit::memory::{Counting, allocations_of};
use cullet_testkit::scenes::random_scene;
use cullet_testkit::views::{looking_down_z, random_view};
use cullet_testkit::{Rng, meshes};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

// One test: each part builds on what the ones before have grown.
#[test]
fn steady_state_allocates_nothing() {
    let mut rng = Rng(11);
    let scene = random_scene(&mut rng, 60);
    let views: Vec<View> = (0..20).map(|_| random_view(&mut rng)).collect();
    for output in [Output::Instances, Output::Clusters, Output::Triangles] {
        let culler =
            Culler::default().with_output(output).with_reasons(true).with_frustum_exact(true);
        let mut state = ViewState::default();
        let mut result = Visible::default();
        let mut list = DrawList::default();
        let mut fill = |result: &Visible| {
            list.fill(&scene, result, &[]).unwrap();
            list.fill_triangles(&scene, result, &[]).unwrap();
        };
        for view in &views {
            culler.cull_one(&scene, view, &mut state, &mut result);
            fill(&result);
        }
        let ((), allocations) = allocations_of(|| {
            for view in &views {
                culler.cull_one(&scene, view, &mut state, &mut result);
                fill(&result);
            }
        });
        assert_eq!(allocations, 0, "{output:?}");
    }
    // Solids beyond the near plane: one that crosses it is cut, which takes memory of its own.
    let mut solids = Scene::new();
    let mesh = solids.add_mesh(meshes::tetrahedron());
    for i in 0..400 {
        let place = [rng.range(-6.0, 6.0), rng.range(-6.0, 6.0), -8.0 - f64::from(i) * 0.1];
        solids.add(Instance::new(mesh, Transform::from_translation(place))).expect("few");
    }
    solids.prepare(Preparation::default());
    let culler = Culler::default()
        .with_occlusion(Occlusion::default())
        .with_output(Output::Triangles)
        .with_reasons(true);
    let (mut state, mut result) = (ViewState::default(), Visible::default());
    let view = looking_down_z();
    let mut beside = view.clone();
    beside.layers = 3;
    let mut frames = |views: &[&View]| {
        for view in views {
            culler.cull_one(&solids, view, &mut state, &mut result);
            assert!(result.funnel.occlusion.drawn > 10, "{:?}", result.funnel.occlusion);
        }
    };
    frames(&[&view, &beside, &view, &beside]);
    assert_eq!(allocations_of(|| frames(&[&view, &beside])).1, 0, "occlusion");
    // A view that stands keeps its answer, once.
    frames(&[&view, &view]);
    assert_eq!(allocations_of(|| frames(&[&view, &view, &beside, &view])).1, 0, "standing");

    // Jobs that run in turn: a pool of threads may allocate what it likes.
    struct InTurn;
    impl Jobs for InTurn {
        fn threads(&self) -> usize {
            3
        }
        fn run(&self, jobs: &mut [Job<'_>]) {
            RUNS.fetch_add(1, Ordering::Relaxed);
            jobs.iter_mut().for_each(|job| job());
        }
    }
    static RUNS: AtomicU32 = AtomicU32::new(0);
    let mut frames = |views: &[&View]| {
        for view in views {
            culler.cull_one_on(&InTurn, &solids, view, &mut state, &mut result);
        }
    };
    frames(&[&view, &beside, &view, &beside]);
    assert_eq!(allocations_of(|| frames(&[&view, &beside])).1, 0, "on threads");
    assert!(RUNS.load(Ordering::Relaxed) > 4);

    // A surface that deforms, and one whose triangles are others each time.
    let ball = meshes::ball(64);
    let mut buffer = OcclusionBuffer::new([320, 200]).expect("a size");
    let mut surface = DynamicSurface::default();
    for turns in [0, 1] {
        let mut indices = ball.indices().to_vec();
        let mut positions = ball.positions().to_vec();
        let mut pass = || {
            for step in 0..4 {
                indices[..3].rotate_left(turns);
                positions.iter_mut().for_each(|p| p[step % 3] *= 1.01);
                surface.set(&positions, &indices, false).expect("a ball");
                buffer.begin(&view, [0.0; 3]);
                let place = Transform::from_translation([0.0, 0.0, -8.0 - step as f64]);
                surface.draw(Simd::best(), &mut buffer, &place);
                assert!(buffer.nearness(160, 100) > 0.0);
            }
        };
        pass();
        pass();
        assert_eq!(allocations_of(pass).1, 0, "dynamic surface");
    }

    let building = Building::new(&mut rng, [5, 2, 5]);
    let mut rooms = Scene::new();
    let mesh = rooms.add_mesh(meshes::ball(16));
    for _ in 0..400 {
        let (place, _) = building.point(&mut rng, 0.1);
        rooms.add(Instance::new(mesh, Transform::from_translation(place))).expect("few");
    }
    rooms.commit(&Culler::default());
    let cells = Cells::new(&mut rooms, building.graph.clone(), building.shapes.clone());
    let mut among = CellView::default();
    let culler = Culler::default().with_reasons(true);
    let eyes: Vec<View> = (0..20)
        .map(|_| {
            let [from, to] = [0.2, 0.1].map(|margin| building.point(&mut rng, margin).0);
            View::perspective(from, to, 1.2, 0.01, 500.0, [320, 200]).expect("a good view")
        })
        .collect();
    let (mut reached, mut dropped) = (0, 0);
    let mut pass = || {
        for view in &eyes {
            let candidates = among.on(&cells);
            let culled = culler.cull_among(&rooms, view, &candidates, &mut state, &mut result);
            culled.expect("cells of the rooms");
            reached += among.reached().map_or(0, |reached| reached.visits().len());
            dropped += result.funnel.dropped(Stage::Portal).instances;
        }
    };
    pass();
    assert_eq!(allocations_of(pass).1, 0, "portals");
    assert!(reached > 100 && dropped > 50, "{reached} {dropped}");

    let boxes: Vec<Aabb> = (0..60_000)
        .map(|_| rng.vector(60.0).map(|v| v as f32))
        .map(|c| Aabb::new(c, c.map(|v| v + 0.2)))
        .collect();
    let (h, _) = Hierarchy::build(&boxes).expect("few");
    let mut cut = Cut::new();
    let mut pass = || {
        for view in &views {
            let planes = Planes::new(&view.frustum());
            cut.cull(Simd::best(), &planes, h.nodes(), h.boxes());
        }
    };
    pass();
    assert_eq!(allocations_of(pass).1, 0, "walk");
}
