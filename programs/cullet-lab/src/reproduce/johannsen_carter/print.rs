//! The results as tables for people, and what they answer.

use super::bounds::BoundRow;
use super::clustering::ProbabilityRow;
use super::hierarchy::HierarchyRow;
use super::record::{Clusterer, JohannsenCarterRecord};
use cullet_command::console::{Console, count};

/// Prints all that was found.
pub(super) fn all(console: &Console, record: &JohannsenCarterRecord) {
    head(console, record);
    bounds(console, record);
    distances(console, record);
    origins(console, record);
    if let Some(h) = &record.hierarchy {
        hierarchy(console, record, h);
    }
    clusterings(console, record);
    let w = record.wrong;
    let lost = record.hierarchy.map_or(0, |h| h.lost);
    console.line(match (w.culls, w.batches + lost) {
        (0, 0) => {
            "\nNo bound culled a cluster that does not wholly face away, and all forms of a test \
                   agree."
                .to_owned()
        }
        (0, n) => format!("\n{n} ANSWERS of two forms of one test DIFFER: a fault of cullet."),
        (n, _) => format!("\n{n} CLUSTERS WERE CULLED WRONGLY: a fault of cullet."),
    });
    if !record.complete {
        console.line("Stopped early: some tables are left out.");
    }
}

fn head(console: &Console, record: &JohannsenCarterRecord) {
    let m = &record.model;
    console.line("Johannsen & Carter 1998, Clustered Backface Culling");
    console.line(format!(
        "{}, {}, every one taken for one-sided{}.",
        m.name,
        count(m.triangles, "triangle", "triangles"),
        m.defect.as_ref().map_or_else(String::new, |d| format!(" though it is not a solid: {d}"))
    ));
    let by = match record.clusters_by {
        Clusterer::Cullet => "cullet",
        Clusterer::Meshopt => "meshoptimizer (64 vertices, 124 triangles, cone weight 0.5)",
    };
    let never = match record.never_culled {
        Some(n) if n > 0 => {
            format!(
                "; {} culled too seldom to test",
                count(u64::from(n), "of them is", "of them are")
            )
        }
        _ => String::new(),
    };
    console.line(format!(
        "{} by {by} in {:.1} s, {:.1} triangles each{never}.",
        count(record.clusters as u64, "cluster", "clusters"),
        record.clustering_seconds,
        record.triangles_per_cluster
    ));
    if matches!(record.clusters_by, Clusterer::Cullet) {
        console.line(format!("They are made for {}.", record.test_cost_from));
    }
}

fn share(row: &BoundRow) -> String {
    row.share_of_ideal_percent.map_or_else(|| "-".into(), |s| format!("{s:.1}"))
}

fn row(console: &Console, r: &BoundRow) {
    console.line(format!(
        "{:<20}{:<36}{:>6}{:>10.2}{:>9.2}{:>9}",
        r.name,
        r.what,
        r.bytes,
        r.ns_per_cluster,
        r.culled_percent,
        share(r)
    ));
}

fn table_head(console: &Console) {
    console.line(format!(
        "{:<20}{:<36}{:>6}{:>10}{:>9}{:>9}",
        "", "", "bytes", "ns each", "culled %", "of ideal"
    ));
}

fn bounds(console: &Console, record: &JohannsenCarterRecord) {
    console.line(format!(
        "\nBounds from {} radii of the model's sphere, means over {}. Exact tests each \
         triangle, ideal\nall planes of a cluster: no bound culls more. Times are of batches, one \
         thread, {}.",
        record.distance_radii,
        count(u64::from(record.directions), "direction", "directions"),
        record.machine.level
    ));
    table_head(console);
    let top = |name: &str, what: &str, value: f64, of: &str| {
        console.line(format!("{name:<20}{what:<36}{:>6}{:>10}{value:>9.2}{of:>9}", "", ""));
    };
    top("exact", "16 bytes a triangle", record.exact_percent, "");
    let all = if record.ideal_percent > 0.0 { "100.0" } else { "-" };
    top("ideal", "16 bytes a triangle", record.ideal_percent, all);
    record.bounds.iter().for_each(|r| row(console, r));
    if record.ideal_percent == 0.0 {
        console.line("No cluster faces wholly away from any of the views, so no bound culls one.");
    }
}

fn distances(console: &Console, record: &JohannsenCarterRecord) {
    console.line("\nCulled, %, from other distances; in brackets the share of the ideal.");
    let line = |name: &str, cell: &dyn Fn(usize) -> String| {
        let cells = (0..record.distances_radii.len()).map(|i| format!("{:>15}", cell(i)));
        console.line(format!("{name:<20}{}", cells.collect::<String>()).trim_end());
    };
    let ideal = &record.ideal_percent_by_distance;
    line("", &|i| format!("{} radii", record.distances_radii[i]));
    line("exact", &|i| format!("{:.2}        ", record.exact_percent_by_distance[i]));
    line("ideal", &|i| format!("{:.2}        ", ideal[i]));
    for r in &record.bounds {
        line(r.name, &|i| {
            let culled = r.culled_percent_by_distance[i];
            match ideal[i] {
                all if all > 0.0 => format!("{culled:.2} ({:>5.1})", culled / all * 100.0),
                _ => format!("{culled:.2}        "),
            }
        });
    }
}

fn origins(console: &Console, record: &JohannsenCarterRecord) {
    console.line(
        "\nJohannsen & Carter's bound, by where its origin c is: the questions that the lectures leave \
         open.",
    );
    table_head(console);
    record.origins.iter().for_each(|r| row(console, r));
    let [global, centre, best, turned] = record.origins.as_slice() else { return };
    if record.ideal_percent == 0.0 {
        console.line("Where nothing can be culled, no origin is better than another.");
        return;
    }
    let points = |a: &BoundRow, b: &BoundRow| a.culled_percent - b.culled_percent;
    console.line(format!(
        "Need c be the cluster's own? One origin for all saves 12 of 40 bytes and culls {:.2} points less.",
        points(centre, global)
    ));
    let gain = points(best, centre);
    console.line(format!(
        "Where is the best c? The best of the middle and the eight corners culls {gain:.2} points more \
         than the\nmiddle: {}.",
        if gain < 0.5 { "take the middle" } else { "on this model the search pays" }
    ));
    let gain = points(turned, centre);
    let elliptic = record.bounds.iter().find(|r| r.name == "elliptic");
    console.line(format!(
        "Does turning the axes achieve something? {gain:+.2} points for 36 more bytes{}.",
        elliptic.map_or_else(String::new, |e| match points(e, turned) {
            more if more > 0.0 => format!(
                "; an elliptic cone culls {more:.2} points more\nthan that, in {} bytes",
                e.bytes
            ),
            _ => String::new(),
        })
    ));
}

fn hierarchy(console: &Console, record: &JohannsenCarterRecord, h: &HierarchyRow) {
    if h.flat_tests_per_frame == 0.0 {
        console.line(
            "\nHierarchy of joint clusters: no cluster faces wholly one way from any view, so there is \
             nothing to join.",
        );
        return;
    }
    console.line(format!(
        "\nHierarchy of joint clusters, elliptic cones for back and front, {} nodes above the clusters, \
         from {} radii:\n{:.1} % of the clusters are proved to face away, {:.1} % to face the eye.",
        h.joint_nodes, record.distance_radii, h.back_percent, h.front_percent
    ));
    let line = |what: &str, tests: f64, us: f64| {
        console.line(format!("{what:<40}{tests:>9.1} tests a frame{us:>9.2} µs"));
    };
    line("tree, where a node saves tests", h.tests_per_frame, h.us_per_frame);
    line("flat, one cluster after the other", h.flat_tests_per_frame, h.flat_us_per_frame);
    line("flat, in batches", h.flat_tests_per_frame, h.batch_us_per_frame);
    let saved = 1.0 - h.tests_per_frame / h.flat_tests_per_frame;
    console.line(format!(
        "The tree saves {:.0} % of the tests; {}.",
        saved * 100.0,
        match h.us_per_frame / h.batch_us_per_frame {
            times if times > 1.0 =>
                format!("a flat sweep in batches is {times:.0} times as fast all the same"),
            times => format!("it is {:.1} times as fast as a flat sweep in batches", 1.0 / times),
        }
    ));
}

fn clusterings(console: &Console, record: &JohannsenCarterRecord) {
    if !record.probabilities.is_empty() {
        console.line(
            "\nHow often is a cluster culled? P of T = t + (1 − P) n r, estimated in three ways; greedy \
             merging alone,\nt/r = 16. The cost is T over all clusters in triangles drawn, for each \
             triangle of the model; 1 is no culling.",
        );
        console.line(format!("{:<62}{:>9}{:>9}{:>8}{:>7}", "", "clusters", "ideal %", "cost", "s"));
        for r in &record.probabilities {
            console.line(format!(
                "{:<62}{:>9}{:>9.2}{:>8.4}{:>7.1}",
                format!("{:<12}{}", r.name, r.what),
                r.clusters,
                r.ideal_percent,
                r.cost,
                r.seconds
            ));
        }
        let cost = |r: &&ProbabilityRow| r.cost;
        let by_cost = |a: &&ProbabilityRow, b: &&ProbabilityRow| cost(a).total_cmp(&cost(b));
        let least = record.probabilities.iter().min_by(by_cost);
        let most = record.probabilities.iter().max_by(by_cost);
        if let (Some(least), Some(most)) = (least, most) {
            let saved = (1.0 - least.cost / most.cost) * 100.0;
            let cheapest = match saved < 0.05 {
                true => "All cost the same.".to_owned(),
                false => format!("Cheapest is {}, {saved:.1} % below {}.", least.name, most.name),
            };
            console.line(format!(
                "{cheapest}{}",
                record.expected_cost.map_or_else(String::new, |cost| format!(
                    " Filled and improved, as in the tables above, it is {} clusters,\nideal {:.2} %, \
                     cost {cost:.4}.",
                    record.clusters, record.ideal_percent
                ))
            ));
        }
    }
    if let Some(m) = &record.materials {
        let more = (m.cost_split / m.cost_joined.max(f64::MIN_POSITIVE) - 1.0) * 100.0;
        console.line(format!(
            "\nClusters do not cross the {} parts (materials of instances): {} clusters, cost \
             {:.4}.\nIf they might, it were {} and {:.4}: the split costs {}.",
            m.parts,
            m.clusters_split,
            m.cost_split,
            m.clusters_joined,
            m.cost_joined,
            // Both are made by chance moves, too.
            if more.abs() < 0.5 { "next to nothing".into() } else { format!("{more:+.1} %") }
        ));
    } else if record.model.parts < 2 {
        console.line("\nThe model has one material, so nothing is lost by not crossing any.");
    }
    if let Some(m) = &record.against_meshopt {
        console.line(match (m.meshopt_ideal_percent, m.cone_weight) {
            (Some(theirs), Some(weight)) => format!(
                "\nAgainst meshoptimizer at the same count, {} clusters of 64 vertices and 124 triangles at \
                 the most: the\nideal culls {:.2} % of ours and {theirs:.2} % of theirs (cone weight \
                 {weight}), {:+.2} points.",
                m.clusters,
                m.ideal_percent,
                m.ideal_percent - theirs
            ),
            _ => format!(
                "\nMeshoptimizer makes more than our {} clusters with every limit, so the two cannot be \
                 compared at one count.",
                m.clusters
            ),
        });
    }
}
