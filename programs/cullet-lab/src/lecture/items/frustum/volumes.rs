//! Bounding volumes: what they are and what tests of them are wrong about.

use cullet::bounds::{Aabb, BoxBlock, Side, Sphere, SphereBlock};
use cullet::clip::{ObjectRegion, OutcodeResult};
use cullet::cull::frustum::single::{classify_aabb, classify_sphere};
use cullet::{Frustum, Projection, Scene};

use super::CITY;
use crate::lecture::finding::Finding;
use crate::lecture::geometry::dot;
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{SIZE, grouped, other, placed};

/// Of what is kept though no triangle of it reaches into the frustum, boxes keep less than spheres do.
pub(super) fn boxes_and_spheres(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene(CITY)?;
    let scene = &model.scene;
    let (mut true_ones, mut by_box, mut by_sphere, mut lost) = (0, 0, 0, 0);
    for view in lab.views(&model, "walk", 6, SIZE)? {
        let frustum = view.frustum().relative_to(scene.origin());
        for slot in scene.slots() {
            let reaches = reaches_in(&view.frustum(), scene, slot);
            let kept = [
                classify_aabb(&frustum, &scene.bounds(slot)).0 != Side::Outside,
                classify_sphere(&frustum, &sphere_of(scene, slot)).0 != Side::Outside,
            ];
            true_ones += usize::from(reaches);
            by_box += usize::from(kept[0] && !reaches);
            by_sphere += usize::from(kept[1] && !reaches);
            lost += kept.iter().filter(|&&kept| reaches && !kept).count();
        }
    }
    let [sphere, aabb] = [size_of::<SphereBlock>(), size_of::<BoxBlock>()].map(|bytes| bytes / 16);
    Ok(Finding::if_so(
        by_box < by_sphere && lost == 0 && sphere < aabb,
        format!(
            "{true_ones} times a triangle of an instance is in the frustum; besides those spheres of {sphere} bytes keep {by_sphere} \
             and boxes of {aabb} bytes {by_box}; {lost} are lost"
        ),
    ))
}

/// The smallest sphere around an instance, relative to the scene's origin as its box is.
fn sphere_of(scene: &Scene, slot: u32) -> Sphere {
    let origin = scene.origin();
    let points: Vec<[f32; 3]> = scene
        .mesh(slot)
        .positions()
        .iter()
        .map(|&p| {
            let p = placed(scene.transform(slot), p);
            std::array::from_fn(|axis| (p[axis] - origin[axis]) as f32)
        })
        .collect();
    Sphere::from_points(&points)
}

/// Whether anything of an instance is left when its triangles are cut by the frustum.
fn reaches_in(frustum: &Frustum, scene: &Scene, slot: u32) -> bool {
    let region = ObjectRegion::new(frustum, scene.transform(slot));
    let mesh = scene.mesh(slot);
    (0..mesh.triangle_count()).any(|t| !region.misses(&mesh.corners(t)))
}

/// The box in the space of the mesh touches its vertices on all six sides and holds them; where the frustum rejects it, it
/// rejects each triangle.
pub(super) fn one_box_for_many(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene("solids")?;
    let scene = &model.scene;
    for mesh in scene.meshes() {
        let b = mesh.bounds();
        // An index of a vertex that no triangle uses is none of the mesh.
        let used = mesh.indices().iter().map(|&v| mesh.positions()[v as usize]);
        let (mut min, mut max) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for p in used {
            for axis in 0..3 {
                min[axis] = min[axis].min(p[axis]);
                max[axis] = max[axis].max(p[axis]);
            }
        }
        if b != (Aabb { min, max }) {
            return Ok(Finding::fails(format!("a mesh from {min:?} to {max:?} has the box {b:?}")));
        }
    }
    let (mut boxes, mut triangles, mut wrong) = (0, 0, 0);
    for view in lab.views(&model, "walk", 8, SIZE)? {
        let frustum = view.frustum();
        for slot in scene.slots() {
            let transform = scene.transform(slot);
            let mesh = scene.mesh(slot);
            let own = frustum.to_object_space(transform);
            if classify_aabb(&own, &mesh.bounds()).0 != Side::Outside {
                continue;
            }
            boxes += 1;
            let region = ObjectRegion::new(&frustum, transform);
            for t in 0..mesh.triangle_count() {
                triangles += 1;
                wrong +=
                    u32::from(!matches!(region.test(&mesh.corners(t)), OutcodeResult::Rejected(_)));
            }
        }
    }
    Ok(Finding::if_so(
        boxes > 0 && wrong == 0,
        format!(
            "the box of each of {} meshes ends at its vertices on all six sides; tests of {boxes} boxes stand for {} \
             triangles, of which {wrong} are not outside by themselves",
            scene.meshes().len(),
            grouped(triangles)
        ),
    ))
}

/// The loop of the lecture, in camera space, against the engine's test in the world.
pub(super) fn count_of_six(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene(CITY)?;
    let scene = &model.scene;
    let projection =
        Projection::Perspective { fov_y_radians: 1.0, aspect: 1.6, near: 0.5, far: 60.0 };
    let own = projection.frustum()?;
    let (mut found, mut differ) = ([0; 3], 0);
    for view in lab.views(&model, "walk", 6, SIZE)? {
        let [x, y, z, w] = view.eye();
        let eye = [x / w, y / w, z / w];
        let ray = view.ray([160.0, 100.0]).ok_or_else(|| other("no line of sight"))?;
        let camera =
            cullet::Camera { eye, direction: ray.direction, up: [0.0, 1.0, 0.0], projection };
        let [right, up, back] = camera.basis()?;
        let frustum = camera.frustum()?.relative_to(scene.origin());
        let origin = scene.origin();
        for slot in scene.slots() {
            let sphere = sphere_of(scene, slot);
            let from_eye: [f64; 3] =
                std::array::from_fn(|a| f64::from(sphere.center[a]) + origin[a] - eye[a]);
            let center = [right, up, back].map(|axis| dot(axis, from_eye));
            let side = by_the_loop(&own, center, f64::from(sphere.radius));
            found[side as usize] += 1;
            differ += usize::from(side != classify_sphere(&frustum, &sphere).0);
        }
    }
    let [inside, straddling, outside] = found;
    Ok(Finding::if_so(
        differ == 0 && found.iter().all(|&n| n > 0),
        format!(
            "the loop finds {outside} spheres outside, {straddling} straddling and {inside} inside; the engine's test in the world \
             differs in {differ}"
        ),
    ))
}

/// As the lecture has it.
fn by_the_loop(camera_space: &Frustum, center: [f64; 3], radius: f64) -> Side {
    let mut count = 0;
    for (_, plane) in camera_space.planes() {
        let distance = plane.distance(center);
        if distance > radius {
            return Side::Outside;
        }
        count += u32::from(distance < -radius);
    }
    if count == 6 { Side::Inside } else { Side::Straddling }
}
