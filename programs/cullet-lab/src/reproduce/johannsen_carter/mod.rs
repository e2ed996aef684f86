//! Johannsen & Carter, *Clustered Backface Culling* (1998), as taught in Zachmann's lectures:
//! clusters, their bounds, where a bound's origin goes, and hierarchies.

mod bounds;
mod clustering;
mod graph;
mod hierarchy;
mod meshlets;
mod print;
mod record;

use std::path::PathBuf;

use clap::Args;
use cullet_bake::clusters::ClusterOptions;
use cullet_command::console::{Console, interrupted};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::write_json;

use self::bounds::{Clusters, DISTANCES, MAIN, Wrong};
use self::clustering::{Made, MaterialRow};
use self::record::{Clusterer, JohannsenCarterRecord, ModelRecord};
use super::model::Subject;
use super::output::Places;
use crate::calibrate::{ClusterArgs, ClusterCosts};
use cullet_command::machine::Machine;

pub(super) const HELP: &str = "\
Every triangle is taken for one-sided, whatever the file says, and all instances of a scene as they
stand; no cluster crosses an instance or a material. The shares are means over --directions views
spread over a sphere, from 3 radii of the sphere around the model and from 1.1, 1.5, 6 and 20. Of each
bound every answer is held against the ideal test: whether the eye is behind every plane of a cluster.

Examples
  cullet reproduce johannsen-carter                      the built-in solid of 69,312 triangles
  cullet reproduce johannsen-carter bun_zipper.ply
  cullet reproduce johannsen-carter armadillo.obj --clusters meshopt
  cullet reproduce johannsen-carter --json - | jq .bounds";

/// `cullet reproduce johannsen-carter`
#[derive(Debug, Args)]
pub(crate) struct JohannsenCarterArgs {
    /// A file, or a built-in scene [default: a built-in solid]
    model: Option<String>,
    /// Who makes the clusters
    #[arg(long, value_enum, default_value_t = Clusterer::Cullet)]
    clusters: Clusterer,
    #[command(flatten)]
    costs: ClusterArgs,
    /// Folder to write all figures and a chart of the bounds into [default: none]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Also write the results here; - is the standard output
    #[arg(long, value_name = "PATH")]
    pub(super) json: Option<PathBuf>,
    /// How many views, at each distance, the shares are means over
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    directions: u32,
}

/// Runs the command.
pub(super) fn run(args: &JohannsenCarterArgs, console: &Console) -> Outcome {
    let subject = Subject::load(args.model.as_deref(), console)?;
    let data = subject.data();
    let parts = data.parts.iter().filter(|p| p.triangle_count > 0).count();
    let costs = args.costs.options(console)?;
    let options = ClusterOptions { measure_parts: parts > 1, ..costs.options };
    let made = match args.clusters {
        Clusterer::Cullet => clustering::ours("clustering", &data, &options, console)?,
        Clusterer::Meshopt => Some(clustering::meshopt(&data)?),
    };
    let Some(made) = made else {
        console.note("stopped before the clusters were made; nothing was measured");
        return Ok(Exit::Interrupted);
    };
    let mut record = measure(args, &subject, &made, &costs, console)?;
    if !interrupted() {
        more(&mut record, &subject, &made, &costs.options, console)?;
    }
    record.complete = !interrupted();
    print::all(console, &record);
    if let Some(out) = &args.out {
        std::fs::create_dir_all(out).map_err(|e| Failure::write(out, &e))?;
        let places = Places { out, json: args.json.as_deref() };
        places.write("johannsen-carter", "The chart", &graph::chart(&record), &record, console)?;
    } else if let Some(path) = &args.json {
        write_json(path, &record)?;
    }
    let lost = record.hierarchy.map_or(0, |h| h.lost);
    Ok(match record.wrong {
        w if w.culls + w.batches + lost > 0 => Exit::FalseCull,
        _ if !record.complete => Exit::Interrupted,
        _ => Exit::Fine,
    })
}

/// The bounds and their origins.
fn measure(
    args: &JohannsenCarterArgs,
    subject: &Subject,
    made: &Made,
    costs: &ClusterCosts,
    console: &Console,
) -> Result<JohannsenCarterRecord, Failure> {
    const BOUNDS: u64 = 8 + 4;
    let clusters = Clusters::new(&made.mesh);
    let of_views = DISTANCES.len() as u64 * u64::from(args.directions);
    let mut bar = console.progress("exact and ideal tests", of_views);
    let views = clusters.views(subject, args.directions, &mut bar);
    bar.finish();
    let mut bar = console.progress("bounds", BOUNDS);
    let mut wrong = Wrong::default();
    let bounds = clusters.bounds(&views, &mut wrong, || bar.step())?;
    let origins = clusters.origins(&views, &mut wrong, || bar.step());
    bar.finish();
    let mesh = &made.mesh;
    let triangles = u64::from(mesh.triangle_count() - mesh.degenerate_count());
    Ok(JohannsenCarterRecord {
        schema: 1,
        model: ModelRecord {
            name: subject.name.clone(),
            triangles,
            parts: mesh.parts().iter().filter(|p| p.triangle_count > 0).count(),
            defect: subject.defect.clone(),
        },
        clusters_by: args.clusters,
        test_cost: costs.options.test_cost,
        test_cost_from: costs.words.clone(),
        clustering_seconds: made.seconds,
        directions: args.directions,
        distance_radii: DISTANCES[MAIN],
        clusters: clusters.len(),
        triangles_per_cluster: triangles as f64 / clusters.len() as f64,
        never_culled: made.report.as_ref().map(|r| r.never_culled),
        expected_cost: made.report.as_ref().map(|r| r.expected_cost),
        exact_percent: views.exact_percent[MAIN],
        ideal_percent: views.ideal_percent[MAIN],
        bounds,
        origins,
        distances_radii: DISTANCES,
        exact_percent_by_distance: views.exact_percent,
        ideal_percent_by_distance: views.ideal_percent,
        hierarchy: None,
        probabilities: Vec::new(),
        materials: made.report.as_ref().and_then(|r| MaterialRow::of(r, mesh.parts().len())),
        against_meshopt: None,
        wrong,
        machine: Machine::here(),
        complete: false,
    })
}

/// The measurements that take longer: other clusterings, and the hierarchy.
fn more(
    record: &mut JohannsenCarterRecord,
    subject: &Subject,
    made: &Made,
    options: &ClusterOptions,
    console: &Console,
) -> Result<(), Failure> {
    let data = subject.data();
    let eyes = bounds::eyes(subject, record.directions, DISTANCES[MAIN]);
    record.hierarchy = Some(hierarchy::measure(&made.mesh, &Clusters::new(&made.mesh), &eyes));
    record.probabilities = clustering::probabilities(&data, &eyes, options, console)?;
    if !interrupted() {
        let other = match record.clusters_by {
            Clusterer::Cullet => None,
            Clusterer::Meshopt => {
                clustering::ours("clustering as cullet", &data, options, console)?
            }
        };
        let ours = other.as_ref().unwrap_or(made);
        if !interrupted() {
            record.against_meshopt = Some(clustering::against_meshopt(&data, &ours.mesh, &eyes)?);
        }
    }
    Ok(())
}
