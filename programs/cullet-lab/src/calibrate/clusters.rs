//! Costs that clusters are made for: a t/r that the user gives, the costs that were measured, or
//! the default.

use std::path::PathBuf;

use clap::Args;
use cullet_bake::clusters::ClusterOptions;
use cullet_command::console::{Console, digits};
use cullet_command::exit::Failure;
use cullet_command::parse;

use cullet_command::measured_costs::MeasuredCosts;
use cullet_command::stored_costs::Stored;

/// Where t/r comes from when a command makes clusters.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Clusters")]
pub struct ClusterArgs {
    /// Make clusters for costs that `cullet calibrate --out` wrote [default: those that `cullet
    /// calibrate` kept]
    #[arg(long, value_name = "FILE", conflicts_with = "test_cost")]
    costs: Option<PathBuf>,
    /// Make clusters for this t/r: the test of a cluster, in triangles drawn [default: by the
    /// costs, else 16]
    #[arg(long, value_name = "N", value_parser = parse::triangles)]
    test_cost: Option<f64>,
}

/// How to make clusters, and who says so.
#[derive(Clone, Debug, PartialEq)]
pub struct ClusterCosts {
    /// The default options with that t/r.
    pub options: ClusterOptions,
    /// The value and where it comes from, for people.
    pub words: String,
}

/// The default options with the t/r of `costs`.
pub(super) const fn options_for(costs: &MeasuredCosts) -> ClusterOptions {
    let MeasuredCosts { cluster_test_ns, draw_ns, rejected_triangle_ns, .. } = *costs;
    ClusterOptions::from_costs(cluster_test_ns, draw_ns, rejected_triangle_ns)
}

impl ClusterArgs {
    /// The t/r of the command line, else that of the costs it names, else of those that are kept;
    /// where there are none, the default. Reads a small file.
    ///
    /// # Errors
    /// If the costs that the user names cannot be used.
    pub fn options(&self, console: &Console) -> Result<ClusterCosts, Failure> {
        if let Some(test_cost) = self.test_cost {
            let options = ClusterOptions { test_cost, ..ClusterOptions::default() };
            let words = format!("t/r = {}, as --test-cost says", digits(test_cost));
            return Ok(ClusterCosts { options, words });
        }
        let without = "clusters for the default t/r";
        let Some((path, stored)) = Stored::find(self.costs.as_deref(), console, without)? else {
            let options = ClusterOptions::default();
            let words = format!(
                "t/r = {}, the default; `cullet calibrate` measures it on this machine",
                digits(options.test_cost)
            );
            return Ok(ClusterCosts { options, words });
        };
        let costs = stored.costs();
        let options = options_for(&costs);
        if options.test_cost > parse::MOST_TRIANGLES {
            return Err(Failure::input(format!(
                "{}: a cluster's test and draw over a rejected triangle make t/r = {:.3e}; clusters are \
                 made for 0 to {:e}; --test-cost sets another",
                path.display(),
                options.test_cost,
                parse::MOST_TRIANGLES
            )));
        }
        let machine = if stored.is_of_here() { "this machine" } else { "another machine" };
        let words = format!(
            "t/r = {}: {} ns for a cluster's test and {} ns for a draw over {} ns for a rejected triangle, \
             as measured on {machine} on {} ({})",
            digits(options.test_cost),
            digits(costs.cluster_test_ns),
            digits(costs.draw_ns),
            digits(costs.rejected_triangle_ns),
            stored.date,
            path.display()
        );
        Ok(ClusterCosts { options, words })
    }
}
