//! Clusters of the shared test models: floors on what is culled, and on how full clusters are.

use std::ops::ControlFlow;
use std::time::Instant;

use cullet_bake::clusters::{ClusterOptions, Quality, build_reported};
use cullet_testkit::meshes::one_sided_data;
use cullet_testkit::models::model;

use super::check;

const BUNNY: &str = "stanford-bunny/bun_zipper.ply";
const ARMADILLO: &str = "armadillo/armadillo.obj";
const BUDDHA: &str = "happy-buddha/buddha-100k.obj";

/// Ideal share at 3 radii and triangles a cluster.
fn measure(name: &str, preset: &str, options: &ClusterOptions) -> Option<[f64; 2]> {
    let data = one_sided_data(model(name)?);
    let start = Instant::now();
    let (clustering, report) =
        build_reported(&data, options, |_| ControlFlow::Continue(())).expect("valid");
    let seconds = start.elapsed().as_secs_f64();
    check(&data, &clustering, options);
    let quality = Quality::of(&data, &clustering, 3.0);
    println!(
        "{name} {preset}: {} clusters, {:.1} triangles each, ideal {:.2} %, exact {:.2} %, {} never \
         culled, vertices {:.2} times, {:.2} s a 100,000",
        report.clusters,
        report.triangles_per_cluster(),
        quality.ideal * 100.0,
        quality.exact * 100.0,
        report.never_culled,
        report.vertex_duplication,
        seconds * 1e5 / f64::from(report.triangles),
    );
    assert!(quality.ideal < quality.exact);
    Some([quality.ideal * 100.0, report.triangles_per_cluster()])
}

#[test]
fn clusters_are_full_and_culled() {
    let goals = [(BUNNY, 43.0, 85.0), (ARMADILLO, 30.4, 85.0), (BUDDHA, 29.0, 82.0)];
    for (name, ideal, full) in goals {
        for (preset, options, less) in
            [("fast", ClusterOptions::fast(), 9.0), ("default", ClusterOptions::default(), 0.0)]
        {
            let Some([got, fill]) = measure(name, preset, &options) else { continue };
            assert!(got > ideal && fill > full - less, "{name} {preset}: {got} {fill}");
        }
    }
}

#[test]
fn the_best_preset_is_better() {
    for (name, ideal, full) in [(BUNNY, 43.5, 87.0), (ARMADILLO, 31.0, 86.5)] {
        let Some([got, fill]) = measure(name, "best", &ClusterOptions::best()) else { continue };
        assert!(got > ideal && fill > full, "{name}: {got} {fill}");
    }
}
