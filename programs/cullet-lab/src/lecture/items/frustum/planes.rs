//! Planes: distances with a sign, the six of a frustum, and how they are found.

use cullet::bounds::{Plane, Side, Sphere};
use cullet::view::FrustumPlane;
use cullet::{Camera, Depth, Frustum, Projection, View};

use super::CITY;
use crate::lecture::finding::Finding;
use crate::lecture::geometry::{Random, Vec3, along, cross, dot, in_clip};
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{SIZE, draw, grouped, other};

/// Points are put at known distances from planes, and the planes tell them.
pub(super) fn signed_distance(_: &Lab) -> Result<Finding, LabError> {
    const CASES: u32 = 2000;
    let mut random = Random::new(66);
    let (mut worst, mut wrong) = (0.0_f64, 0);
    for _ in 0..CASES {
        let (p, n): (Vec3, Vec3) = (random.point(100.0), random.point(1.0));
        let plane = Plane::from_point_normal(p, n).ok_or_else(|| other("no plane"))?;
        let distance = random.between(-50.0, 50.0);
        // Along the plane in some direction, then off it.
        let on = along(p, random.between(-50.0, 50.0), cross(plane.normal, random.point(1.0)));
        let x = along(on, distance, plane.normal);
        worst = worst.max((plane.distance(x) - distance).abs());
        worst = worst.max((dot(plane.normal, along(x, -1.0, p)) - distance).abs());
        let side = if distance > 0.0 { Side::Outside } else { Side::Inside };
        wrong += u32::from(plane.side_of(x) != side);
        // On the plane, as nearly as numbers are: neither side is proved.
        wrong += u32::from(plane.side_of(p) != Side::Straddling);
    }
    Ok(Finding::if_so(
        worst < 1e-12 * 200.0 && wrong == 0,
        format!(
            "{CASES} points at known distances up to 50 from planes are told within {worst:.0e}, on the right side but for {wrong}"
        ),
    ))
}

/// A point is outside of a plane by its distance if and only if the projection says so.
pub(super) fn normals_point_out(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene(CITY)?;
    let mut random = Random::new(67);
    let (mut points, mut inside, mut differ, mut planes) = (0, 0, 0, 0);
    for view in lab.views(&model, "walk", 8, SIZE)? {
        let frustum = view.frustum();
        // The middle of the picture is seen, so it is below all planes.
        let ray = view.ray([160.0, 100.0]).ok_or_else(|| other("no line of sight"))?;
        let middle = along(ray.origin, 1.0, ray.direction);
        for (_, plane) in frustum.planes() {
            planes += 1;
            differ += u32::from(plane.distance(middle) >= 0.0);
        }
        for _ in 0..2000 {
            let p = along(middle, 1.0, random.point(100.0));
            let [x, y, z, w] = in_clip(&view, p);
            // Reversed depth: near is z = w, and far z = 0.
            let past = [-x - w, x - w, -y - w, y - w, z - w, -z];
            for (which, past) in FrustumPlane::ALL.into_iter().zip(past) {
                let Some(plane) = frustum.plane(which) else { continue };
                let distance = plane.distance(p);
                // What lies on a plane but for rounding is on either side.
                if distance.abs() > 1e-6 {
                    differ += u32::from((distance > 0.0) != (past > 0.0));
                }
            }
            points += 1;
            inside += u32::from(frustum.contains(p));
        }
    }
    Ok(Finding::if_so(
        differ == 0 && inside > 0 && inside < points,
        format!(
            "of {points} points around eight views {inside} are inside; {planes} planes and the projection differ about {differ} of \
             them"
        ),
    ))
}

/// Spheres that touch a plane are in none of the lecture's cases; all others are in one, the same as the engine's.
pub(super) fn sphere_and_plane(_: &Lab) -> Result<Finding, LabError> {
    /// As the lecture has it.
    fn text(distance: f64, radius: f64) -> Option<Side> {
        if distance > radius {
            Some(Side::Outside)
        } else if distance < -radius {
            Some(Side::Inside)
        } else {
            (-radius < distance && distance < radius).then_some(Side::Straddling)
        }
    }
    let (mut left_open, mut kept, mut touching) = (0, 0, 0);
    for axis in 0..3 {
        for exponent in -8..8 {
            for sign in [-1.0, 1.0] {
                let radius = 2.0_f32.powi(exponent);
                let mut normal = [0.0; 3];
                normal[axis] = 1.0;
                let mut center = [0.0; 3];
                center[axis] = 3.0 + sign * radius;
                let plane = Plane::new(normal, 3.0);
                let distance = plane.distance(center.map(f64::from));
                touching += u32::from(distance.abs() == f64::from(radius));
                left_open += u32::from(text(distance, f64::from(radius)).is_none());
                let side = Sphere::new(center, radius).side(&plane);
                kept += u32::from(side == Side::Straddling);
            }
        }
    }
    let mut random = Random::new(68);
    let (mut others, mut differ) = (0, 0);
    for _ in 0..3000 {
        let plane = Plane::from_point_normal(random.point(9.0), random.point::<3>(1.0));
        let plane = plane.ok_or_else(|| other("no plane"))?;
        let center = random.point::<3>(20.0).map(|v| v as f32);
        let sphere = Sphere::new(center, random.between(0.1, 10.0) as f32);
        let distance = plane.distance(center.map(f64::from));
        others += 1;
        differ += u32::from(text(distance, f64::from(sphere.radius)) != Some(sphere.side(&plane)));
    }
    let measured = format!(
        "of {touching} spheres that touch a plane {left_open} are in none of the three cases, and the engine keeps {kept}; about \
         {others} others it differs in {differ}"
    );
    let shown = touching == 96 && left_open == touching && kept == touching && differ == 0;
    Ok(if shown { Finding::mended(measured) } else { Finding::fails(measured) })
}

/// The construction as written loses all that is seen; mended it gives the planes of the matrix.
pub(super) fn from_the_camera(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene(CITY)?;
    let (mut seen, mut kept_by_text, mut kept_mended) = (0, 0, 0);
    let (mut worst, mut lefts, mut cameras) = (0.0_f64, 0, 0);
    for walk in lab.views(&model, "walk", 6, SIZE)? {
        let [x, y, z, w] = walk.eye();
        let p = [x / w, y / w, z / w];
        let ray = walk.ray([160.0, 100.0]).ok_or_else(|| other("no line of sight"))?;
        let (near, far, fov_y_radians, aspect) = (0.5, 80.0, 1.0_f64, 1.6);
        let projection = Projection::Perspective { fov_y_radians, aspect, near, far };
        let camera = Camera { eye: p, direction: ray.direction, up: [0.0, 1.0, 0.0], projection };
        let view = View::new(&camera, Depth::Reversed, SIZE)?;
        let [_, up, back] = camera.basis()?;
        let d = back.map(|v| -v);
        let height = 2.0 * near * (fov_y_radians / 2.0).tan();
        let (nc, fc) = (along(p, near, d), along(p, far, d));
        // The normal of a side that passes through the eye, and the middle of an edge of the near window.
        let edge = |to: Vec3, half: f64| along(along(nc, half, to), -1.0, p);
        let plane =
            |at: Vec3, n: Vec3| Plane::from_point_normal(at, n).ok_or_else(|| other("no plane"));

        let right = cross(up, d);
        let right_of_text = plane(p, cross(up, edge(right, height * aspect / 2.0)))?;
        let text = [(nc, d), (fc, d.map(|v| -v))].map(|(at, n)| plane(at, n));
        let [near_of_text, far_of_text] = text;
        let none = [None; 6];
        let mut planes = none;
        planes[FrustumPlane::Right as usize] = Some(right_of_text);
        planes[FrustumPlane::Near as usize] = Some(near_of_text?);
        planes[FrustumPlane::Far as usize] = Some(far_of_text?);
        let text = Frustum::from_planes(planes);
        let own = view.frustum();
        let left = own.plane(FrustumPlane::Left).ok_or_else(|| other("no left plane"))?;
        lefts += u32::from(dot(left.normal, right_of_text.normal) > 1.0 - 1e-12);

        let right = cross(d, up);
        let (half, half_up) = (height * aspect / 2.0, height / 2.0);
        let mended = Frustum::from_planes([
            Some(plane(p, cross(up, edge(right, -half)))?),
            Some(plane(p, cross(edge(right, half), up))?),
            Some(plane(p, cross(edge(up, -half_up), right))?),
            Some(plane(p, cross(right, edge(up, half_up)))?),
            Some(plane(nc, d.map(|v| -v))?),
            Some(plane(fc, d)?),
        ]);
        for which in FrustumPlane::ALL {
            for other in [view.frustum(), camera.frustum()?] {
                let (Some(a), Some(b)) = (mended.plane(which), other.plane(which)) else {
                    continue;
                };
                let off = (0..3).map(|i| (a.normal[i] - b.normal[i]).abs());
                worst = off.fold(worst, f64::max).max((a.d - b.d).abs());
            }
        }
        cameras += 1;
        let frame = draw(&model.scene, &view);
        for (at, id) in frame.ids.iter().enumerate() {
            if *id == cullet_draw::PixelId::NONE {
                continue;
            }
            let pixel = [at as u32 % frame.width, at as u32 / frame.width];
            let Some(ray) = view.ray(pixel.map(|v| f64::from(v) + 0.5)) else { continue };
            // A point that is seen: on the line of sight, where the depth says.
            let s = distance_at(&view, ray.origin, ray.direction, frame.depth[at]);
            let point = along(ray.origin, s, ray.direction);
            seen += 1;
            kept_by_text += u32::from(text.contains(point));
            kept_mended += u32::from(mended.contains(point));
        }
    }
    let measured = format!(
        "of {} points seen by {cameras} cameras the planes as written keep {kept_by_text}, and their right plane is the left one \
         {lefts} times; mended they keep {} and are those of the matrix within {worst:.0e}",
        grouped(seen),
        grouped(kept_mended)
    );
    let shown = kept_by_text == 0 && lefts == cameras && kept_mended == seen && worst < 1e-9;
    Ok(if shown { Finding::mended(measured) } else { Finding::fails(measured) })
}

/// How far along a line from the near plane the depth in clip space is reached.
fn distance_at(view: &View, origin: Vec3, direction: Vec3, depth: f64) -> f64 {
    let [_, _, z0, w0] = in_clip(view, origin);
    let [_, _, z1, w1] = in_clip(view, along(origin, 1.0, direction));
    // (z0 + s (z1 − z0)) = depth (w0 + s (w1 − w0)).
    (depth * w0 - z0) / ((z1 - z0) - depth * (w1 - w0))
}
