//! Ways to make clusters, and the quality of each.

use std::ops::ControlFlow;
use std::time::Instant;

use cullet::mesh::Clustering;
use cullet::{Mesh, MeshData};
use cullet_bake::clusters::{ClusterOptions, Probability, Report, build_reported};
use cullet_command::console::{Console, interrupted};
use cullet_command::exit::Failure;
use serde::Serialize;

use super::bounds::Clusters;
use super::meshlets::meshlets;

/// How large the box of viewers is, in sizes of the mesh's box.
pub(super) const SCENE_SCALE: f64 = 4.0;
/// How far viewers are from a cluster's box, in its diagonals.
pub(super) const NEAR_DIAGONALS: f64 = 4.0;

/// Clusters, and what making them took.
pub(super) struct Made {
    pub(super) mesh: Mesh,
    /// Report on our own clusters.
    pub(super) report: Option<Report>,
    pub(super) seconds: f64,
}

/// One way to estimate how often a cluster is culled.
#[derive(Clone, Debug, Serialize)]
pub(super) struct ProbabilityRow {
    pub(super) name: &'static str,
    pub(super) what: String,
    pub(super) clusters: usize,
    pub(super) ideal_percent: f64,
    /// Expected, in triangles drawn for each triangle of the mesh; over the same view points for
    /// all.
    pub(super) cost: f64,
    pub(super) seconds: f64,
}

/// Cost of keeping clusters from crossing materials.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct MaterialRow {
    pub(super) parts: usize,
    pub(super) clusters_split: u32,
    pub(super) clusters_joined: u32,
    pub(super) cost_split: f64,
    pub(super) cost_joined: f64,
}

/// Our clusters against as many of meshoptimizer's.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct MeshoptRow {
    pub(super) clusters: usize,
    pub(super) ideal_percent: f64,
    /// At that number of clusters, between the limits that make just fewer and just more; `None`
    /// where no limit makes more.
    pub(super) meshopt_ideal_percent: Option<f64>,
    /// The weight of facing that does best there.
    pub(super) cone_weight: Option<f32>,
}

fn failed(e: impl ToString) -> Failure {
    Failure::input(e)
}

/// Our clusters. `None` where Ctrl-C stopped it.
pub(super) fn ours(
    what: &'static str,
    data: &MeshData,
    options: &ClusterOptions,
    console: &Console,
) -> Result<Option<Made>, Failure> {
    let mut bar = console.progress(what, 100);
    let mut done = 0;
    let start = Instant::now();
    let (clustering, report) = build_reported(data, options, |p| {
        while done < (p.share * 100.0) as u32 {
            bar.step();
            done += 1;
        }
        if interrupted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })
    .map_err(failed)?;
    let seconds = start.elapsed().as_secs_f64();
    bar.finish();
    if !report.complete {
        return Ok(None);
    }
    Ok(Some(Made { mesh: mesh(data, &clustering)?, report: Some(report), seconds }))
}

fn mesh(data: &MeshData, clustering: &Clustering) -> Result<Mesh, Failure> {
    Mesh::with_clusters(data.clone(), clustering).map_err(failed)
}

impl MaterialRow {
    /// From the report of clusters that were made both ways.
    pub(super) fn of(report: &Report, parts: usize) -> Option<Self> {
        let one = report.as_one_part?;
        Some(Self {
            parts,
            clusters_split: one.clusters_split,
            clusters_joined: one.clusters,
            cost_split: one.expected_cost_split,
            cost_joined: one.expected_cost,
        })
    }
}

/// Clusters as greedy merging leaves them, with each estimate. Fewer than three where Ctrl-C came.
pub(super) fn probabilities(
    data: &MeshData,
    eyes: &[[f64; 4]],
    base: &ClusterOptions,
    console: &Console,
) -> Result<Vec<ProbabilityRow>, Failure> {
    let ways = [
        ("views", "sampled view points".to_owned(), Probability::Views),
        (
            "scene_box",
            format!("culling volume in a scene {SCENE_SCALE} times the model"),
            Probability::SceneBox { scale: SCENE_SCALE },
        ),
        (
            "near_box",
            format!("culling volume within {NEAR_DIAGONALS} diagonals of the cluster"),
            Probability::NearBox { diagonals: NEAR_DIAGONALS },
        ),
    ];
    let mut rows = Vec::new();
    for (name, what, probability) in ways {
        let options = ClusterOptions { probability, rounds: 0, ..*base };
        let Some(made) = ours("clustering in other ways", data, &options, console)? else { break };
        rows.push(ProbabilityRow {
            name,
            what,
            clusters: made.mesh.clusters().len(),
            ideal_percent: Clusters::new(&made.mesh).ideal_percent(eyes),
            cost: made.report.map_or(1.0, |r| r.expected_cost),
            seconds: made.seconds,
        });
    }
    Ok(rows)
}

/// Meshoptimizer's clusters of 64 vertices and 124 triangles, with its usual weight of facing.
pub(super) fn meshopt(data: &MeshData) -> Result<Made, Failure> {
    let start = Instant::now();
    let clustering = meshlets(data, 124, 0.5).map_err(failed)?;
    let seconds = start.elapsed().as_secs_f64();
    Ok(Made { mesh: mesh(data, &clustering)?, report: None, seconds })
}

/// Compares our clusters with as many of meshoptimizer's, whose limit of triangles is lowered until
/// it makes as many; the better of two weights of facing counts.
pub(super) fn against_meshopt(
    data: &MeshData,
    ours: &Mesh,
    eyes: &[[f64; 4]],
) -> Result<MeshoptRow, Failure> {
    let clusters = ours.clusters().len();
    let mut best: Option<(f64, f32)> = None;
    for weight in [0.5, 1.0] {
        let mut before: Option<(f64, f64)> = None;
        for most in (4..=124).rev().step_by(4) {
            let mesh = mesh(data, &meshlets(data, most, weight).map_err(failed)?)?;
            let (count, ideal) =
                (mesh.clusters().len() as f64, Clusters::new(&mesh).ideal_percent(eyes));
            if count < clusters as f64 {
                before = Some((count, ideal));
                continue;
            }
            // As many just so, or in between; with more than ours at its limit nothing is known.
            let at = match before {
                Some((fewer, less)) => {
                    Some(less + (ideal - less) * (clusters as f64 - fewer) / (count - fewer))
                }
                None => (count == clusters as f64).then_some(ideal),
            };
            if let Some(at) = at.filter(|at| best.is_none_or(|b| *at > b.0)) {
                best = Some((at, weight));
            }
            break;
        }
    }
    Ok(MeshoptRow {
        clusters,
        ideal_percent: Clusters::new(ours).ideal_percent(eyes),
        meshopt_ideal_percent: best.map(|b| b.0),
        cone_weight: best.map(|b| b.1),
    })
}
