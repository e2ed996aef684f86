//! The probability of a cluster, its expected cost, and when two are merged: items 56 to 60.

use std::ops::ControlFlow;

use crate::calibrate;
use crate::methods::cluster::{Bound, CullingRegion, NormalBox};
use crate::shapes::fibonacci;
use cullet::MeshData;
use cullet::cull::backface::ClusterPlanes;
use cullet::mesh::Clustering;
use cullet_bake::clusters::{ClusterOptions, Probability, Quality, Report, build, build_reported};
use cullet_scenes::knobbly_ball;

use super::body::Body;
use super::bound::FINENESS;
use crate::lecture::finding::Finding;
use crate::lecture::items::subject::{dot, one_sided};
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{grouped, other};

/// Point `i` of a sequence that fills the unit cube evenly (M. Roberts, *The Unreasonable Effectiveness of
/// Quasirandom Sequences*, 2018).
fn even(i: usize) -> [f64; 3] {
    // The root of x⁴ = x + 1.
    const ROOT: f64 = 1.220_744_084_605_759_5;
    [1, 2, 3].map(|k| (0.5 + (i + 1) as f64 / ROOT.powi(k)).fract())
}

pub(super) fn probability(_: &Lab) -> Result<Finding, LabError> {
    const POINTS: usize = 4000;
    const RADII: f64 = 4.0;
    let body = Body::new(FINENESS, [0.0; 3])?;
    let (centre, radius) = (body.subject.centre(), body.subject.radius());
    let room = |radii: f64| [-1.0, 1.0].map(|side| centre.map(|v| v + side * radii * radius));
    let eyes: Vec<[f64; 4]> = (0..POINTS)
        .map(|i| {
            let at = even(i).map(|v| (2.0 * v - 1.0) * RADII * radius);
            [centre[0] + at[0], centre[1] + at[1], centre[2] + at[2], 1.0]
        })
        .collect();
    let volume_of = |bound: &NormalBox, radii: f64| {
        let [low, high] = room(radii);
        CullingRegion::of_normal_box(bound, low, high).volume()
    };
    let whole = (2.0 * RADII * radius).powi(3);
    let (mut worst, mut most, mut tried, mut growth): (f64, f64, _, f64) =
        (0.0, 0.0, 0, f64::INFINITY);
    for planes in &body.planes {
        let Some(bound) = NormalBox::fit(planes) else { continue };
        let share = volume_of(&bound, RADII) / whole;
        if share == 0.0 {
            continue;
        }
        let counted = eyes.iter().filter(|eye| bound.is_behind(**eye)).count();
        worst = worst.max((counted as f64 / POINTS as f64 - share).abs());
        most = most.max(share);
        // Of the room, twice as large and twice as large again: the volume itself has no end.
        growth = growth.min(volume_of(&bound, RADII * 4.0) / volume_of(&bound, RADII * 2.0));
        tried += 1;
    }
    let measured = format!(
        "the exact volumes of {tried} clusters, cut to a room of {RADII} radii, are up to {:.0} % of it and within {:.1} points of the share of \
         {} eyes that cull them; uncut they have no end: in a room of twice the size each is at least {growth:.1} times as large",
        most * 100.0,
        worst * 100.0,
        grouped(POINTS)
    );
    let shown = tried > 20 && worst < 0.02 && most > 0.2 && growth > 6.0;
    Ok(if shown { Finding::mended(measured) } else { Finding::fails(measured) })
}

/// Clusters of a mesh as greedy merging leaves them.
fn merged(data: &MeshData, options: &ClusterOptions) -> Result<(Clustering, Report), LabError> {
    let options = ClusterOptions { rounds: 0, ..*options };
    build_reported(data, &options, |_| ControlFlow::Continue(())).map_err(other)
}

pub(super) fn boxes(_: &Lab) -> Result<Finding, LabError> {
    const DISTANCE: f64 = 3.0;
    let (positions, indices) = knobbly_ball(FINENESS);
    let data = one_sided(positions, indices);
    let ways = [
        Probability::Views,
        Probability::SceneBox { scale: 4.0 },
        Probability::NearBox { diagonals: 4.0 },
    ];
    let (mut costs, mut ideals) = ([0.0; 3], [0.0; 3]);
    for (i, probability) in ways.into_iter().enumerate() {
        let (clustering, report) =
            merged(&data, &ClusterOptions { probability, ..ClusterOptions::default() })?;
        costs[i] = report.expected_cost;
        ideals[i] = Quality::of(&data, &clustering, DISTANCE).ideal * 100.0;
    }
    let near = |i: usize| costs[i] < costs[0] * 1.1 && ideals[i] > ideals[0] * 0.8;
    Ok(Finding::if_so(
        near(1) && near(2) && costs.iter().all(|cost| *cost < 1.0),
        format!(
            "clusters by the volume in a scene's box cost {:.3} of all triangles drawn, by that in a box near the cluster {:.3}, by sampled eyes \
             {:.3}; from {DISTANCE} radii {:.0}, {:.0} and {:.0} % of the triangles are in clusters that face away",
            costs[1], costs[2], costs[0], ideals[1], ideals[2], ideals[0]
        ),
    ))
}

pub(super) fn expected(_: &Lab) -> Result<Finding, LabError> {
    const EYES: usize = 500;
    const TEST: f64 = 4.0;
    let (positions, indices) = knobbly_ball(FINENESS);
    let data = one_sided(positions, indices);
    let options = ClusterOptions { test_cost: TEST, ..ClusterOptions::fast() };
    let going = |_| ControlFlow::Continue(());
    let (clustering, report) = build_reported(&data, &options, going).map_err(other)?;
    let mesh = cullet::Mesh::with_clusters(data, &clustering).map_err(other)?;
    let tested = mesh.clusters().len() - report.never_culled as usize;
    let planes: Vec<ClusterPlanes> =
        mesh.clusters().iter().map(|c| super::body::planes_of(&mesh, c)).collect();
    let radius = cullet::bounds::Sphere::from_points(mesh.positions()).radius;
    // What each of many other eyes pays: a test of each cluster that is tested, and the triangles that are left.
    let mut paid = 0.0;
    for i in 0..EYES {
        let far = options.distances[i % options.distances.len()] * f64::from(radius);
        let [x, y, z] = fibonacci(i, EYES).map(|v| v * far);
        for (n, (cluster, planes)) in mesh.clusters().iter().zip(&planes).enumerate() {
            let is_tested = n < tested;
            let culled = is_tested && planes.is_behind([x, y, z, 1.0]);
            paid += if is_tested { TEST } else { 0.0 };
            paid += if culled { 0.0 } else { f64::from(cluster.triangle_count) };
        }
    }
    let paid = paid / (EYES as f64 * f64::from(report.triangles));
    let off = (report.expected_cost / paid - 1.0) * 100.0;
    Ok(Finding::if_so(
        off.abs() < 3.0 && paid < 1.0 && tested > 0,
        format!(
            "for t/r = {TEST}, {} clusters of {} triangles are expected to cost {:.4} of all triangles drawn; {EYES} other eyes pay {paid:.4}, \
             {:.1} % off",
            mesh.clusters().len(),
            grouped(report.triangles),
            report.expected_cost,
            off.abs()
        ),
    ))
}

/// Two triangles with a common edge along z, folded by an angle.
fn hinge(fold: f64) -> MeshData {
    let (sin, cos) = fold.sin_cos();
    let wing = [cos as f32, -sin as f32, 0.5];
    let positions = vec![[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.5], wing];
    one_sided(positions, vec![0, 2, 1, 0, 1, 3])
}

pub(super) fn merging(_: &Lab) -> Result<Finding, LabError> {
    const EYES: usize = 4000;
    let (mut merges, mut keeps, mut wrong) = (0, 0, 0);
    for fold in (10..=170).step_by(20) {
        let data = hinge(f64::from(fold).to_radians());
        let mesh = cullet::Mesh::new(data.clone()).map_err(other)?;
        let planes =
            [0..1, 1..2, 0..2].map(|range| ClusterPlanes::new(range.map(|t| mesh.corners(t))));
        // Parallel views from everywhere: the fold alone decides.
        let share = |planes: &ClusterPlanes| {
            let eye = |i: usize| fibonacci(i, EYES);
            let behind = |i: &usize| planes.half_spaces().all(|(n, _)| dot(n, eye(*i)) < 0.0);
            (0..EYES).filter(behind).count() as f64 / EYES as f64
        };
        let [a, b, both] = planes.each_ref().map(share);
        for ratio in [0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4] {
            let bound = (a + b - ratio) / 2.0;
            // The two forms: what the clusters cost, and the inequality.
            let pays = ratio + (1.0 - both) * 2.0 < 2.0 * ratio + (1.0 - a) + (1.0 - b);
            wrong += usize::from(pays != (both > bound));
            // Too near for the views that the engine samples.
            if (both - bound).abs() < 0.02 {
                continue;
            }
            let options = ClusterOptions {
                test_cost: ratio,
                vertex_cost: 0.0,
                views: 1024,
                distances: [f64::INFINITY; 4],
                rounds: 0,
                ..ClusterOptions::default()
            };
            let clusters = build(&data, &options).map_err(other)?.clusters.len();
            wrong += usize::from((clusters == 1) != pays);
            merges += usize::from(pays);
            keeps += usize::from(!pays);
        }
    }
    // On a whole body: the more a test costs, the fewer clusters.
    let (positions, indices) = knobbly_ball(16);
    let data = one_sided(positions, indices);
    let mut counts = Vec::new();
    for test_cost in [0.5, 4.0, 32.0] {
        let (clustering, _) =
            merged(&data, &ClusterOptions { test_cost, ..ClusterOptions::default() })?;
        counts.push(clustering.clusters.len());
    }
    Ok(Finding::if_so(
        wrong == 0 && merges > 10 && keeps > 10 && counts.is_sorted_by(|a, b| a > b),
        format!(
            "of two triangles folded by 10 to 170 degrees, for t/r of 0.05 to 0.4, the engine merges {merges} pairs and leaves {keeps}, each as \
             the inequality says; a knobbly ball of 3,072 triangles becomes {}, {} and {} clusters for t/r of 0.5, 4 and 32",
            counts[0], counts[1], counts[2]
        ),
    ))
}

pub(super) fn calibrated(_: &Lab) -> Result<Finding, LabError> {
    // Other work disturbs times, so there are three tries; it never makes a test as slow as drawing.
    const TRIES: usize = 3;
    let mut measured = String::new();
    for _ in 0..TRIES {
        let costs = calibrate::measured(1);
        let costs = costs.ok_or_else(|| LabError::Other("the measurement was stopped".into()))?;
        if costs.check().is_err() {
            continue;
        }
        let ratio = costs.t_over_r();
        let options = ClusterOptions::from_costs(&costs);
        let (positions, indices) = knobbly_ball(8);
        let clusters = build(&one_sided(positions, indices), &options).map_err(other)?.clusters;
        measured = format!(
            "measured in one round: t/r = {ratio:.4} with the reference renderer, and with a draw for each cluster over a rejected triangle \
             {:.1}, for which clusters are made",
            options.test_cost
        );
        if ratio > 0.0 && ratio < 0.2 && !clusters.is_empty() {
            return Ok(Finding::holds(measured));
        }
    }
    Ok(Finding::fails(measured))
}
