//! Planes and the convex regions between them.

use cullet::bounds::{Plane, Side};
use cullet::clip::{HalfSpace, ObjectRegion, Region};
use cullet::cull::frustum::exact::ExactFrustum;
use cullet::cull::frustum::single::classify_aabb;
use cullet::view::FrustumPlane;
use cullet::{Camera, Depth, Projection, View};

use crate::lecture::finding::Finding;
use crate::lecture::geometry::{Random, Vec3, along, dot};
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{SIZE, grouped, other};

/// The same line at several lengths of its normal: heights on it are zero, and d is the distance at length 1 only.
pub(super) fn implicit_planes(_: &Lab) -> Result<Finding, LabError> {
    const CASES: u32 = 1000;
    let mut random = Random::new(85);
    let (mut on_line, mut off, mut stretched) = (0.0_f64, 0.0_f64, 0);
    for _ in 0..CASES {
        let angle: f64 = random.between(0.0, std::f64::consts::TAU);
        let (n, d) = ([angle.cos(), angle.sin()], random.between(0.1, 9.0));
        let line = HalfSpace::new(n, d).map_err(other)?;
        let s = random.between(-50.0, 50.0);
        let p = [d * n[0] - s * n[1], d * n[1] + s * n[0]];
        on_line = on_line.max(line.height(&p).abs());
        // No point of the line is nearer to the origin than d·n.
        off = off.max(d - p[0].hypot(p[1]));

        let normal: Vec3 = random.point(1.0);
        let plane = Plane::from_point_normal(along([0.0; 3], d, normal), normal);
        let plane = plane.ok_or_else(|| other("no plane"))?;
        let nearest = along([0.0; 3], plane.d, plane.normal);
        on_line = on_line.max(plane.distance(nearest).abs());
        off = off.max((dot(nearest, nearest).sqrt() - plane.d.abs()).abs());
        // The same plane, written with a normal of another length.
        let long = Plane::new(plane.normal.map(|v| v * 7.0), plane.d * 7.0);
        let again = long.normalized().ok_or_else(|| other("no plane"))?;
        off = off.max((again.d - plane.d).abs());
        stretched += u32::from((long.d - plane.d).abs() > 1e-9);
    }
    Ok(Finding::if_so(
        on_line < 1e-12 && off < 1e-12 && stretched == CASES,
        format!(
            "T·p is below {on_line:.0e} for points on {CASES} lines and planes, and the nearest of them to the origin is d away within \
             {off:.0e}; with normals of length 7 it is not, {stretched} times"
        ),
    ))
}

/// Regions of a frustum and two planes more: midpoints of what is inside are inside, and boxes are where their points are.
pub(super) fn convex(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene("city:cells=6,objects=200")?;
    let scene = &model.scene;
    let mut random = Random::new(86);
    let (mut pairs, mut dents, mut wrong) = (0, 0, 0);
    let mut sides = [0; 3];
    let middle = along(scene.origin(), 1.0, scene.extent().center());
    for view in lab.views(&model, "orbit", 4, SIZE)? {
        let mut frustum = view.frustum();
        for _ in 0..2 {
            let normal: Vec3 = random.point(1.0);
            let at = along(middle, 1.0, random.point(30.0));
            let plane = Plane::from_point_normal(at, normal).ok_or_else(|| other("no plane"))?;
            frustum.push(plane)?;
        }
        let region = Region::<f64, 3>::from(&frustum);
        let inside: Vec<Vec3> = (0..4000)
            .map(|_| along(middle, 1.0, random.point(100.0)))
            .filter(|p| region.outcode(p) == 0)
            .collect();
        for pair in inside.windows(2) {
            pairs += 1;
            let between = along(pair[0].map(|v| v * 0.5), 0.5, pair[1]);
            dents += u32::from(region.outcode(&between) != 0);
        }
        let relative = frustum.relative_to(scene.origin());
        for slot in scene.slots() {
            let b = scene.bounds(slot);
            let side = classify_aabb(&relative, &b).0;
            sides[side as usize] += 1;
            for i in 0..5_u32.pow(3) {
                let p: Vec3 = std::array::from_fn(|axis| {
                    let t = f64::from(i / 5_u32.pow(axis as u32) % 5) / 4.0;
                    f64::from(b.min[axis]) * (1.0 - t) + f64::from(b.max[axis]) * t
                });
                let is_in = relative.contains(p);
                wrong += u32::from(match side {
                    Side::Inside => !is_in,
                    Side::Outside => is_in,
                    Side::Straddling => false,
                });
            }
        }
    }
    let [inside, straddling, outside] =
        [Side::Inside, Side::Straddling, Side::Outside].map(|side| sides[side as usize]);
    Ok(Finding::if_so(
        pairs > 100 && dents == 0 && wrong == 0 && inside > 0 && straddling > 0,
        format!(
            "of {} pairs of points inside {dents} have a midpoint outside; {outside} boxes are outside, {straddling} straddle and \
             {inside} are inside, and {wrong} of 125 points in each say otherwise",
            grouped(pairs)
        ),
    ))
}

/// Boxes first; only what straddles is tested by its triangles, and the answer is that of testing all triangles.
pub(super) fn cheap_first(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene("city:cells=6,objects=200")?;
    let scene = &model.scene;
    let (mut boxes, mut undecided, mut exactly, mut triangles, mut all, mut differ) =
        (0, 0, 0, 0, 0, 0);
    for view in lab.views(&model, "walk", 6, SIZE)? {
        let frustum = view.frustum();
        let relative = frustum.relative_to(scene.origin());
        let exact = ExactFrustum::new(&relative);
        for slot in scene.slots() {
            let region = ObjectRegion::new(&frustum, scene.transform(slot));
            let mesh = scene.mesh(slot);
            let mut tests = 0;
            let mut reaches = || {
                (0..mesh.triangle_count()).any(|t| {
                    tests += 1;
                    !region.misses(&mesh.corners(t))
                })
            };
            let truth = reaches();
            all += tests;
            boxes += 1;
            let kept = match classify_aabb(&relative, &scene.bounds(slot)).0 {
                Side::Outside => false,
                Side::Inside => true,
                Side::Straddling => {
                    undecided += 1;
                    exactly += u32::from(exact.is_outside_beyond_planes(&scene.bounds(slot)));
                    triangles += tests;
                    truth
                }
            };
            differ += u32::from(kept != truth);
        }
    }
    Ok(Finding::if_so(
        undecided > 0 && undecided * 4 < boxes && triangles < all && differ == 0,
        format!(
            "of {} tests of boxes {undecided} do not decide, of which {exactly} the exact test of the box does; {} tests of triangles \
             follow in place of {}, and {differ} results differ",
            grouped(boxes),
            grouped(triangles),
            grouped(all)
        ),
    ))
}

/// Planes by the rows of the matrix, by the engine, and by the geometry of the camera.
pub(super) fn from_the_matrix(_: &Lab) -> Result<Finding, LabError> {
    const CAMERAS: u32 = 200;
    let mut random = Random::new(89);
    let (mut worst, mut corners, mut planes) = (0.0_f64, 0.0_f64, 0);
    for i in 0..CAMERAS {
        let (near, far) = (0.5, random.between(20.0, 200.0));
        let [left, bottom] = [-2.0, -1.0].map(|low| random.between(low, -0.1));
        let [right, top] = [2.0, 1.0].map(|high| random.between(0.1, high));
        let projection = match i % 3 {
            0 => Projection::Perspective {
                fov_y_radians: random.between(0.3, 2.0),
                aspect: random.between(0.5, 2.0),
                near,
                far,
            },
            1 => Projection::OffCentre { left, right, bottom, top, near, far },
            _ => Projection::Orthographic { left, right, bottom, top, near, far },
        };
        let camera = Camera::look_at(random.point(50.0), random.point(50.0), projection);
        let view = View::new(&camera, Depth::Standard, SIZE)?;
        let m = view.clip_from_world();
        let row = |r: usize| [m[r], m[4 + r], m[8 + r], m[12 + r]];
        let [x, y, z, w] = [0, 1, 2, 3].map(row);
        let plus = |a: [f64; 4], s: f64, b: [f64; 4]| -> [f64; 4] {
            std::array::from_fn(|k| a[k] + s * b[k])
        };
        // Inside is w + x ≥ 0, w − x ≥ 0, and so on; out is the other way.
        let rows = [plus(w, 1.0, x), plus(w, -1.0, x), plus(w, 1.0, y), plus(w, -1.0, y), z]
            .into_iter()
            .chain([plus(w, -1.0, z)]);
        let (own, geometric) = (view.frustum(), camera.frustum()?);
        for (which, [a, b, c, d]) in FrustumPlane::ALL.into_iter().zip(rows) {
            let plane = Plane::new([-a, -b, -c], d).normalized();
            let found = [plane, own.plane(which).copied(), geometric.plane(which).copied()];
            let [Some(by_rows), Some(own), Some(geometric)] = found else {
                return Err(other(format!("no {} plane", which.name())));
            };
            planes += 1;
            for p in [own, geometric] {
                let off = (0..3).map(|k| (p.normal[k] - by_rows.normal[k]).abs());
                worst = off.fold(worst, f64::max).max((p.d - by_rows.d).abs());
            }
        }
        // And the corners are where the inverse puts those of the clip volume.
        let inverse = view.world_from_clip();
        for (number, corner) in own.corners().ok_or_else(|| other("no corners"))?.iter().enumerate()
        {
            let at = [0, 1, 2].map(|bit| f64::from(number as u32 >> bit & 1));
            let clip = [at[0] * 2.0 - 1.0, at[1] * 2.0 - 1.0, at[2], 1.0];
            let p: [f64; 4] =
                std::array::from_fn(|r| (0..4).map(|k| inverse[4 * k + r] * clip[k]).sum());
            for axis in 0..3 {
                corners = corners.max((p[axis] / p[3] - corner[axis] / corner[3]).abs());
            }
        }
    }
    Ok(Finding::if_so(
        worst < 1e-8 && corners < 1e-6,
        format!(
            "{planes} planes of {CAMERAS} cameras of three kinds by the rows of the matrix, by the engine and by the geometry of the \
             camera agree within {worst:.0e}, their corners within {corners:.0e}"
        ),
    ))
}
