//! Tests of the scripts that `examples/cluster` gives to Slurm and Kubernetes, run with a number in
//! the environment as those run them.

#![cfg(unix)]

use std::path::{Path, PathBuf};
use std::process::Command;

use cullet_testkit::{Folder, data};

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/cluster").join(name)
}

/// A shell's command with the program in its path.
fn shell(program: &str, words: &[&str], environment: &[(&str, &str)]) {
    let folder = Path::new(env!("CARGO_BIN_EXE_cullet")).parent().expect("a folder");
    let path = std::env::var("PATH").unwrap_or_default();
    let out = Command::new(program)
        .args(words)
        .env("PATH", format!("{}:{path}", folder.display()))
        .envs(environment.iter().copied())
        .output()
        .expect("a shell");
    assert!(out.status.success(), "{words:?}: {}", String::from_utf8_lossy(&out.stderr));
}

/// The sets as one process bakes them, in a folder with the map.
fn alone(folder: &Folder, map: &str) -> Vec<u8> {
    let sets = folder.root().join("alone.cpvs").display().to_string();
    shell("cullet", &["pvs", map, "--quiet", "-o", &sets], &[]);
    std::fs::read(sets).expect("sets")
}

#[test]
fn a_slurm_array_makes_the_same_bytes_though_a_share_is_lost() {
    let Some(file) = data("portals/gen_small.prt") else { return };
    let folder = Folder::new("slurm");
    let map = folder.root().join("map.prt").display().to_string();
    std::fs::copy(file, &map).expect("copied");
    let expected = alone(&folder, &map);
    let script = example("pvs.sbatch").display().to_string();
    // One of three is never begun.
    for task in ["2", "0"] {
        let array = [("SLURM_ARRAY_TASK_ID", task), ("SLURM_ARRAY_TASK_COUNT", "3")];
        shell("bash", &[&script, &map], &[&array[..], &[("SLURM_CPUS_PER_TASK", "1")]].concat());
    }
    shell("bash", &[&script, &map], &[("JOIN", "1")]);
    assert!(std::fs::read(format!("{map}.cpvs")).expect("sets") == expected);
}

#[test]
fn an_indexed_job_makes_the_same_bytes() {
    let Some(file) = data("portals/gen_small.prt") else { return };
    let folder = Folder::new("kubernetes");
    let map = folder.root().join("map.prt").display().to_string();
    std::fs::copy(file, &map).expect("copied");
    let expected = alone(&folder, &map);
    let job = std::fs::read_to_string(example("pvs-job.yaml")).expect("the example");
    let after = |key: &str| {
        let line = job.lines().find_map(|line| line.trim().strip_prefix(key));
        line.unwrap_or_else(|| panic!("no {key}")).trim().trim_matches('"').to_owned()
    };
    let (pods, shares) = (after("completions:"), after("value:"));
    assert_eq!(pods, shares, "as many shares as pods");
    let command = after("- exec ");
    let units = folder.root().join("units").display().to_string();
    for index in 0..pods.parse().expect("a number") {
        let index: u32 = index;
        let environment = [
            ("JOB_COMPLETION_INDEX", index.to_string()),
            ("SHARES", shares.clone()),
            ("FILE", map.clone()),
            ("UNITS", units.clone()),
        ];
        let environment = environment.each_ref().map(|(name, value)| (*name, value.as_str()));
        shell("sh", &["-c", &command], &environment);
    }
    let out = folder.root().join("map.cpvs").display().to_string();
    shell("cullet", &["pvs", &map, "--quiet", "--resume", "--units", &units, "-o", &out], &[]);
    assert!(std::fs::read(out).expect("sets") == expected);
}
