//! Jobs of a plan, held in several places, against a bake in one.

use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use cullet_bake::job::{CellSource, Job, Made, Plan, Product, Settings, WorkError};
use cullet_bake::pvs::bake;
use cullet_testkit::{Folder, data};

fn goes_on() -> Arc<AtomicBool> {
    Arc::new(AtomicBool::new(false))
}

fn of_scene() -> Settings {
    let mut settings = Settings::default();
    settings.scene.view_cells = Some(12);
    settings.scene.heights = Some([0.5, 3.0]);
    settings.scene.rays = Some(300_000);
    settings
}

/// Runs a plan on some jobs in turn, each round cut into so many units, the last unit first.
fn on_jobs(plan: &Plan, path: &str, jobs: usize, units: u32) -> Made {
    let plan = Plan::parse(&plan.to_text()).expect("its own text");
    let open = || Job::open(&plan, path, 1).expect("the same file");
    let mut jobs: Vec<Job> = (0..jobs).map(|_| open()).collect();
    while !jobs[0].is_done() {
        let missing = jobs[0].missing(&[], units);
        let run = |(k, items): (usize, &Range<u32>)| {
            let bytes = jobs[k % jobs.len()].run(items.clone(), 1, &goes_on()).expect("its items");
            (items.clone(), bytes.expect("nobody stops it"))
        };
        let found: Vec<_> = missing.iter().enumerate().rev().map(run).collect();
        for job in &mut jobs {
            job.merge(found.clone()).expect("all units");
        }
    }
    jobs.swap_remove(0).finish().expect("all rounds")
}

#[test]
fn any_number_of_jobs_makes_the_same_sets_of_a_scene() {
    let plan = Plan::new("city:objects=120", &of_scene()).expect("a scene");
    assert_eq!(plan.product, Product::ViewCells);
    let one = on_jobs(&plan, "city:objects=120", 1, 1);
    assert_eq!(one.cells, 12);
    for (jobs, units) in [(2, 5), (3, 40)] {
        let made = on_jobs(&plan, "city:objects=120", jobs, units);
        assert!(made.sets == one.sets, "{jobs} jobs, {units} units");
    }
}

#[test]
fn any_number_of_jobs_makes_the_same_sets_of_a_map() {
    let Some(file) = data("portals/gen_small.prt") else { return };
    let text = file.display().to_string();
    let plan = Plan::new(&text, &Settings::default()).expect("a graph");
    assert_eq!(plan.product, Product::Cells);
    let graph = CellSource::open(&file).expect("a graph").graph;
    let whole = bake(&graph, &Settings::default().of_cells(), 2);
    for (jobs, units) in [(1, 1), (2, 7)] {
        let made = on_jobs(&plan, &text, jobs, units);
        assert!(made.sets == whole.to_bytes(), "{jobs} jobs, {units} units");
        assert_eq!(made.visible_pairs, whole.visible_pairs());
    }
}

#[test]
fn what_does_not_fit_is_refused_and_changes_nothing() {
    let plan = Plan::new("city:objects=60", &of_scene()).expect("a scene");
    let mut job = Job::open(&plan, "city:objects=60", 1).expect("a scene");
    let (all, round) = (0..job.item_count(), job.round());
    let bytes = job.run(all.clone(), 1, &goes_on()).expect("its items").expect("not stopped");
    assert!(job.is_whole(all.clone(), bytes.clone()).expect("a job"));
    let cut = bytes[..bytes.len() - 1].to_vec();
    assert!(!job.is_whole(all.clone(), cut.clone()).expect("a job"));
    let damaged = job.merge(vec![(all.clone(), cut)]);
    assert!(matches!(damaged, Err(WorkError::Damaged { start: 0, .. })), "{damaged:?}");
    let twice = job.merge(vec![(all.clone(), bytes.clone()), (all.clone(), bytes.clone())]);
    assert!(matches!(twice, Err(WorkError::Incomplete { missing: 0, .. })), "{twice:?}");
    let none = job.merge(Vec::new());
    assert!(matches!(none, Err(WorkError::Incomplete { .. })), "{none:?}");
    let beyond = job.run(all.end..all.end + 1, 1, &goes_on());
    assert!(matches!(beyond, Err(WorkError::Items { .. })), "{beyond:?}");
    assert!(
        job.run(all.clone(), 1, &Arc::new(AtomicBool::new(true))).expect("its items").is_none()
    );
    assert_eq!(job.round(), round);
    job.merge(vec![(all, bytes)]).expect("whole");
    assert_eq!(job.round(), round + 1);
    assert!(matches!(job.finish(), Err(WorkError::Unfinished { .. })));
}

#[test]
fn another_file_or_version_is_named() {
    let folder = Folder::new("work");
    let file = folder.root().join("a.off");
    let off = |z: u32| {
        let text = format!("OFF\n4 2 0\n0 0 0\n1 0 0\n0 1 {z}\n1 1 1\n3 0 1 2\n3 1 3 2\n");
        std::fs::write(&file, text).expect("written");
    };
    off(0);
    let text = file.display().to_string();
    let plan = Plan::new(&text, &of_scene()).expect("a scene");
    off(1);
    let other = Job::open(&plan, &text, 1).expect_err("another file").to_string();
    assert!(other.contains("a.off") && other.contains("plan was made of"), "{other}");
    assert!(matches!(Plan::parse("{}"), Err(WorkError::Plan(_))));
    let newer = plan.to_text().replace("\"version\":1", "\"version\":2");
    let newer = Plan::parse(&newer).expect_err("newer").to_string();
    assert!(newer.contains("version 2"), "{newer}");
    let gone = Plan::new("nowhere.prt", &Settings::default()).expect_err("no file").to_string();
    assert!(gone.contains("nowhere.prt"), "{gone}");
    let moved = plan.to_text().replace(&format!("\"key\":{}", plan.key), "\"key\":7");
    off(0);
    let error =
        Job::open(&Plan::parse(&moved).expect("a plan"), &text, 1).expect_err("another key");
    assert!(matches!(error, WorkError::OtherWork { expected: 7, .. }), "{error:?}");
    assert!(Path::new(&text).exists());
}
