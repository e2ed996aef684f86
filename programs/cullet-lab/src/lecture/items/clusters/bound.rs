//! The bound of a cluster, from rules of minimum and maximum to its volume: items 47 to 53.

use std::collections::BTreeSet;

use crate::methods::Bulk;
use crate::methods::cluster::{
    Bound, ClusterBounds, CullingRegion, NormalBox, NormalBoxAtOrigin, NormalBoxTurned,
};
use cullet::cull::backface::{ClusterPlanes, Facing};
use cullet::{Camera, Depth, Projection, Simd, View};

use super::body::Body;
use crate::lecture::finding::Finding;
use crate::lecture::items::subject::{bit, dot, facings, percent, test_of};
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{cube, draw, grouped, mesh, scene_of, seen};

/// Triangles of the body: 12 · 24².
pub(super) const FINENESS: u16 = 24;

fn greatest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::NEG_INFINITY, f64::max)
}

fn least(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::INFINITY, f64::min)
}

/// The first three of four.
fn place([x, y, z, _]: [f64; 4]) -> [f64; 3] {
    [x, y, z]
}

pub(super) fn rules(_: &Lab) -> Result<Finding, LabError> {
    let body = Body::new(FINENESS, [0.0; 3])?;
    let (mut tried, mut reached, mut bad) = (0, 0, 0);
    for planes in &body.planes {
        let normals: Vec<([f64; 3], f64)> = planes.half_spaces().collect();
        for e in body.eyes(10).into_iter().map(place) {
            // x of a triangle is n·e, y is n·p.
            let x = || normals.iter().map(|(n, _)| dot(*n, e));
            let y = || normals.iter().map(|(_, d)| *d);
            let sum = greatest(x().zip(y()).map(|(x, y)| x + y));
            let difference = greatest(x().zip(y()).map(|(x, y)| x - y));
            let bound = greatest(x()) - least(y());
            bad += usize::from(sum > greatest(x()) + greatest(y()));
            bad += usize::from(difference > bound);
            reached += usize::from(difference == bound);
            tried += 1;
            for (k, &factor) in e.iter().enumerate() {
                let component = || normals.iter().map(|(n, _)| n[k]);
                let scaled = greatest(component().map(|v| factor * v));
                let of = if factor > 0.0 { greatest(component()) } else { least(component()) };
                bad += usize::from(scaled != factor * of);
            }
        }
        // What the engine keeps of a cluster is what the rules ask for, rounded to the safe side.
        let Some(kept) = NormalBox::fit_at(planes, [0.0; 3]) else { continue };
        for k in 0..3 {
            let component = || normals.iter().map(|(n, _)| n[k]);
            let high = f64::from(kept.largest[k]) - greatest(component());
            let low = least(component()) - f64::from(kept.smallest[k]);
            bad += [high, low].iter().filter(|v| !(0.0..1e-5).contains(*v)).count();
        }
        let below = least(normals.iter().map(|(_, d)| *d)) - f64::from(kept.d);
        bad += usize::from(!(0.0..1e-4).contains(&below));
    }
    Ok(Finding::if_so(
        bad == 0 && tried > 500 && reached < tried,
        format!(
            "held in {} clusters for {} eyes; max (x − y) reaches its bound in {:.0} % of {} cases, and the engine's boxes of normals are the \
             maxima and minima to 0.00001",
            body.planes.len(),
            body.eyes(10).len(),
            percent(reached, tried),
            grouped(tried)
        ),
    ))
}

pub(super) fn inverted(_: &Lab) -> Result<Finding, LabError> {
    let (positions, indices) = cube();
    let scene = scene_of(mesh(positions, indices, false)?)?;
    let cube = scene.mesh(0);
    let projection =
        Projection::Perspective { fov_y_radians: 0.8, aspect: 1.6, near: 0.1, far: f64::INFINITY };
    let (mut backs, mut edges, mut bad) = (0, 0, 0);
    // From anywhere, from the plane of a side, and from the line of an edge.
    for eye in [[5.0, 3.0, 4.0], [5.0, 1.0, 0.25], [6.0, 1.0, -1.0], [0.5, -7.0, 0.25]] {
        let test = test_of([eye[0], eye[1], eye[2], 1.0]);
        let camera = Camera::look_at(eye, [0.0; 3], projection);
        let shown = seen(&draw(&scene, &View::new(&camera, Depth::Reversed, [320, 200])?));
        for t in 0..cube.triangle_count() {
            let corners = cube.corners(t);
            let [a, b, c] = corners.map(|p| p.map(f64::from));
            let from_a = |p: [f64; 3]| std::array::from_fn(|k| p[k] - a[k]);
            let (u, v): ([f64; 3], [f64; 3]) = (from_a(b), from_a(c));
            let n =
                [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            // Small whole numbers and quarters: exact. All three corners give the same value.
            let values = [a, b, c].map(|p| dot(n, std::array::from_fn(|k| eye[k] - p[k])));
            bad += usize::from(values[0] != values[1] || values[0] != values[2]);
            let (strict, inverted) = (-values[0] > 0.0, values[0] <= 0.0);
            let facing = test.facing(&corners);
            bad += usize::from(strict != (facing == Facing::Back));
            bad += usize::from(inverted != (facing != Facing::Front));
            backs += usize::from(strict);
            if inverted && !strict {
                edges += 1;
                bad += usize::from(shown.contains(&(0, cube.original_triangle()[t as usize])));
            }
        }
    }
    Ok(Finding::if_so(
        bad == 0 && edges > 0 && backs > 0,
        format!(
            "a cube from four places: both rules take the same {backs} triangles, and n·(e − p) ≤ 0 takes {edges} more that are seen edge-on \
             and fill no pixel; the engine keeps those"
        ),
    ))
}

pub(super) fn steps(_: &Lab) -> Result<Finding, LabError> {
    let body = Body::new(FINENESS, [0.0; 3])?;
    let eyes = body.eyes(30);
    let bounds: Vec<Option<NormalBoxAtOrigin>> =
        body.planes.iter().map(NormalBoxAtOrigin::fit).collect();
    let (mut culled, mut engine, mut bad) = ([0; 3], 0, 0);
    for &eye in &eyes {
        let sides = facings(&body.subject, eye);
        let e = place(eye);
        let clusters = body.subject.mesh.clusters();
        for ((planes, bound), cluster) in body.planes.iter().zip(&bounds).zip(clusters) {
            let normals: Vec<([f64; 3], f64)> = planes.half_spaces().collect();
            let d = least(normals.iter().map(|(_, d)| *d));
            let one = planes.height(eye);
            let two = greatest(normals.iter().map(|(n, _)| dot(*n, e))) - d;
            let three: f64 =
                (0..3).map(|k| greatest(normals.iter().map(|(n, _)| e[k] * n[k]))).sum::<f64>() - d;
            // Upper bounds of each other, but for the last bit.
            bad += usize::from(one > two + 1e-12) + usize::from(two > three + 1e-12);
            for (count, value) in culled.iter_mut().zip([one, two, three]) {
                *count += usize::from(value < 0.0);
            }
            let all_back = cluster.triangles().all(|t| sides[t as usize] == Facing::Back);
            bad += usize::from((one < -1e-9) && !all_back) + usize::from(one > 1e-9 && all_back);
            let by_engine = bound.is_some_and(|bound| bound.is_behind(eye));
            engine += usize::from(by_engine);
            bad += usize::from(by_engine && three >= 0.0);
        }
    }
    let [one, two, three] = culled;
    Ok(Finding::if_so(
        bad == 0 && one > two && two > three && engine <= three && engine * 20 > three * 19,
        format!(
            "of {} tests of clusters, that of all planes, (1), culls {}; with d taken by itself, (2), {}; with each axis by itself, (3), {}, \
             and the engine's bound {}; none of it wrongly",
            grouped(eyes.len() * body.planes.len()),
            grouped(one),
            grouped(two),
            grouped(three),
            grouped(engine)
        ),
    ))
}

/// comb(m′, m; e)·v: the largest of each component where e is positive, else the smallest.
fn comb(largest: [f32; 3], smallest: [f32; 3], e: [f64; 3], v: [f64; 3]) -> f64 {
    (0..3).map(|k| f64::from(if e[k] > 0.0 { largest[k] } else { smallest[k] }) * v[k]).sum()
}

pub(super) fn octants(_: &Lab) -> Result<Finding, LabError> {
    let body = Body::new(FINENESS, [0.0; 3])?;
    let eyes = body.eyes(40);
    let bounds: Vec<Option<NormalBoxAtOrigin>> =
        body.planes.iter().map(NormalBoxAtOrigin::fit).collect();
    let batch: ClusterBounds<NormalBoxAtOrigin> = bounds.iter().copied().collect();
    let (mut octants, mut culled, mut bad) = (BTreeSet::new(), 0, 0);
    for &eye in &eyes {
        let e = place(eye);
        octants.insert(e.map(|v| v > 0.0));
        for (planes, bound) in body.planes.iter().zip(&bounds) {
            let Some(bound) = bound else { continue };
            let value = comb(bound.largest, bound.smallest, e, e) - f64::from(bound.d);
            let goes = bound.is_behind(eye);
            culled += usize::from(goes);
            // The engine's sum is of f32.
            bad += usize::from(value.abs() > 1e-5 && goes != (value < 0.0));
            bad += usize::from(goes && !planes.is_behind(eye));
        }
        for level in Simd::all() {
            let mut words = Vec::new();
            batch.cull(level, eye, &mut words);
            let single = |i: usize| bounds[i].is_some_and(|bound| bound.is_behind(eye));
            bad += (0..bounds.len()).filter(|&i| bit(&words, i) != single(i)).count();
        }
    }
    // The example of the book: −3.9 and 0.3 against d = −0.1.
    let example =
        NormalBoxAtOrigin { largest: [0.3, 1.0, 0.2], smallest: [-0.3, 0.9, -0.2], d: -0.1 };
    let far = [[2.0, -5.0, 0.0, 1.0], [16.0, -5.0, 0.0, 1.0]].map(|eye| example.is_behind(eye));
    Ok(Finding::if_so(
        bad == 0
            && octants.len() == 8
            && culled > 0
            && far == [true, false]
            && size_of::<NormalBoxAtOrigin>() == 28,
        format!(
            "28 bytes a cluster; for {} eyes in all 8 octants the combined vector tells the same as the engine's bound in {} tests, which \
             cull {} and none wrongly",
            eyes.len(),
            grouped(eyes.len() * bounds.len()),
            grouped(culled)
        ),
    ))
}

/// A box around the body, so many of its radii to each side.
fn room(body: &Body, radii: f64) -> [[f64; 3]; 2] {
    let (c, r) = (body.subject.centre(), body.subject.radius() * radii);
    [c.map(|v| v - r), c.map(|v| v + r)]
}

pub(super) fn volume(_: &Lab) -> Result<Finding, LabError> {
    let body = Body::new(FINENESS, [0.0; 3])?;
    let region = |bound: &NormalBox, radii: f64| {
        let [low, high] = room(&body, radii);
        CullingRegion::of_normal_box(bound, low, high)
    };
    let is_closed = |bound: &NormalBox| {
        let region = region(bound, 64.0);
        !region.is_empty() && region.faces().iter().all(|f| f.half_space.is_some())
    };
    let (mut regions, mut closed, mut corners, mut open_axes, mut bad) = (0, 0, 0, 0, 0);
    for planes in &body.planes {
        // Measured from a point well behind all planes, d is positive.
        let Some(apex) = planes.apex(0.0) else { continue };
        let origin = std::array::from_fn(|k| apex.point[k] - apex.axis[k] * planes.radius());
        let Some(bound) = NormalBox::fit_at(planes, origin) else { continue };
        if region(&bound, 64.0).is_empty() {
            continue;
        }
        regions += 1;
        closed += usize::from(is_closed(&bound));
        let (d, c) = (f64::from(bound.d), bound.origin.map(f64::from));
        for k in 0..3 {
            for (m, side) in [(bound.largest[k], 1.0), (bound.smallest[k], -1.0)] {
                let m = f64::from(m);
                let leaves = m * side > 0.0;
                // Where the axis leaves the region, or far along it.
                let along = if leaves { d / m } else { side * 1e4 };
                let mut point = c;
                point[k] += along;
                let gaps = bound.half_spaces().map(|(n, d)| dot(n, point) - d);
                let scale = 1e-9 * along.abs().max(1.0);
                let meet = gaps.iter().filter(|gap| gap.abs() <= scale).count();
                let inside = gaps.iter().all(|gap| *gap <= scale);
                bad += usize::from(d <= 0.0 || !inside || leaves != (meet >= 4));
                corners += usize::from(leaves);
                open_axes += usize::from(!leaves);
            }
        }
    }
    // All normals around a solid: from its middle each triangle is seen from behind.
    let mesh = &body.subject.mesh;
    let all = ClusterPlanes::new((0..mesh.triangle_count()).map(|t| mesh.corners(t)));
    let whole = NormalBox::fit_at(&all, body.subject.centre());
    let whole = whole.ok_or_else(|| LabError::Other("the ball has no planes".into()))?;
    let around = region(&whole, 64.0).volume();
    let whole_is_closed = is_closed(&whole) && whole.is_behind(body.subject.eye([0.0; 3], 0.0));
    let measured = format!(
        "{closed} of {regions} culling volumes are closed, all others reach the sides of a room of 64 radii; {corners} half-axes end at \
         (d/m, 0, 0) and {open_axes} never do; for all normals of the solid, which surround it, it is closed, a volume of {around:.2} around \
         its middle"
    );
    let shown =
        bad == 0 && closed == 0 && regions > 20 && corners > 0 && open_axes > 0 && whole_is_closed;
    Ok(if shown { Finding::mended(measured) } else { Finding::fails(measured) })
}

pub(super) fn local_origin(_: &Lab) -> Result<Finding, LabError> {
    let body = Body::new(FINENESS, [20.0, -12.0, 16.0])?;
    let eyes = body.eyes(40);
    let ideal = body.ideal(&eyes);
    let (mut common, mut middle, mut best) = (0, 0, 0);
    let (mut by_position, mut wrong, mut bad) = (0, 0, 0);
    for planes in &body.planes {
        let at_origin = NormalBoxAtOrigin::fit(planes);
        let (fit, nine) = (NormalBox::fit(planes), NormalBox::fit_best(planes));
        for &eye in &eyes {
            let behind = planes.is_behind(eye);
            for (count, goes) in [
                (&mut common, at_origin.is_some_and(|b| b.is_behind(eye))),
                (&mut middle, fit.is_some_and(|b| b.is_behind(eye))),
                (&mut best, nine.is_some_and(|b| b.is_behind(eye))),
            ] {
                *count += usize::from(goes);
                bad += usize::from(goes && !behind);
            }
            // As written in 2014: the octant is that of e, the vector e − c.
            let Some(bound) = &fit else { continue };
            let e = place(eye);
            let v = std::array::from_fn(|k| e[k] - f64::from(bound.origin[k]));
            let goes = comb(bound.largest, bound.smallest, e, v) < f64::from(bound.d);
            by_position += usize::from(goes);
            wrong += usize::from(goes && !behind);
        }
    }
    let measured = format!(
        "20 units from the origin a common origin culls {:.0} % of what all planes would, the middle of each cluster's box {:.1} % and the \
         best of middle and corners {:.1} %; with the octant of e, {} of {} culls are wrong, with that of e − c none",
        percent(common, ideal),
        percent(middle, ideal),
        percent(best, ideal),
        grouped(wrong),
        grouped(by_position)
    );
    let shown = bad == 0
        && size_of::<NormalBox>() == 40
        && wrong > 0
        && common * 2 < middle
        && best >= middle
        && middle * 2 > ideal;
    Ok(if shown { Finding::mended(measured) } else { Finding::fails(measured) })
}

pub(super) fn rotation(_: &Lab) -> Result<Finding, LabError> {
    let body = Body::new(FINENESS, [0.0; 3])?;
    let eyes = body.eyes(40);
    let ideal = body.ideal(&eyes);
    let (mut plain, mut turned, mut bad) = (0, 0, 0);
    for planes in &body.planes {
        let (fit, own) = (NormalBox::fit(planes), NormalBoxTurned::fit(planes));
        for &eye in &eyes {
            let goes =
                [fit.is_some_and(|b| b.is_behind(eye)), own.is_some_and(|b| b.is_behind(eye))];
            plain += usize::from(goes[0]);
            turned += usize::from(goes[1]);
            bad += usize::from((goes[0] || goes[1]) && !planes.is_behind(eye));
        }
    }
    Ok(Finding::if_so(
        bad == 0 && turned > plain && turned <= ideal,
        format!(
            "yes: with axes along its own normals a cluster's bound culls {:.1} % of what all planes would, with those of the mesh {:.1} %, \
             for 76 bytes instead of 40",
            percent(turned, ideal),
            percent(plain, ideal)
        ),
    ))
}
