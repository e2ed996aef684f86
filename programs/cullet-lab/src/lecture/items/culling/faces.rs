//! Faces by their planes.

use cullet::CullFace;
use cullet::cull::backface::{Facing, ObjectEye, facing_ref};
use cullet_draw::PixelId;

use crate::lecture::finding::Finding;
use crate::lecture::geometry::{cross, dot};
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{SIZE, draw, grouped, placed};

/// The plane of the face against the engine and against exact arithmetic; and drawn from both sides, no back is seen.
pub(super) fn face_planes(lab: &Lab) -> Result<Finding, LabError> {
    let mut model = cullet_scenes::build("solids")?;
    model.scene.edit_meshes(|_, mesh| mesh.set_two_sided(true));
    model.scene.commit();
    let scene = &model.scene;
    let (mut triangles, mut culled, mut differ, mut inexact) = (0, 0, 0, 0);
    let (mut seen, mut backs_seen) = (0, 0);
    let indices: Vec<Vec<u32>> =
        scene.meshes().iter().map(cullet::Mesh::original_indices).collect();
    for view in lab.views(&model, "orbit", 3, SIZE)? {
        let [x, y, z, w] = view.eye();
        let eye = [x / w, y / w, z / w];
        for slot in scene.slots() {
            // As in glTF, a mirrored instance is not inside out.
            let mirrored = scene.transform(slot).is_mirrored();
            let object = ObjectEye::of_view(&view, scene.transform(slot));
            for t in 0..scene.mesh(slot).triangle_count() {
                let corners = scene.mesh(slot).corners(t);
                let [v0, v1, v2] = corners.map(|p| placed(scene.transform(slot), p));
                let from = |p: [f64; 3]| [p[0] - v0[0], p[1] - v0[1], p[2] - v0[2]];
                let n = cross(from(v1), from(v2)).map(|v| if mirrored { -v } else { v });
                let side = dot(n, eye) - dot(n, v0);
                let found = object.facing(&corners);
                triangles += 1;
                culled += u32::from(side < 0.0);
                if found != Facing::Edge {
                    differ += u32::from((found == Facing::Back) != (side < 0.0));
                }
                if t % 400 == 0 && found != Facing::Edge {
                    let exact = facing_ref(&view, scene.transform(slot), &corners);
                    inexact += u32::from(exact != found);
                }
            }
        }
        for id in draw(scene, &view).visible() {
            let of_mesh = &indices[scene.mesh_id(id.slot) as usize];
            let positions = scene.mesh(id.slot).positions();
            let corners =
                [0, 1, 2].map(|k| positions[of_mesh[id.triangle as usize * 3 + k] as usize]);
            let eye = ObjectEye::of_view(&view, scene.transform(id.slot));
            seen += 1;
            backs_seen += u32::from(eye.facing(&corners) == Facing::Back);
        }
    }
    Ok(Finding::if_so(
        culled > 0 && differ == 0 && inexact == 0 && backs_seen == 0,
        format!(
            "of {} triangles of solids {} have the eye behind their plane; the engine differs in {differ}, exact arithmetic from it in \
             {inexact}; drawn from both sides, {backs_seen} of {} triangles that are seen show their back",
            grouped(triangles),
            grouped(culled),
            grouped(seen)
        ),
    ))
}

/// With fronts culled the same pixels are covered, and all of them by backs.
pub(super) fn front_faces(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene("knobs")?;
    let scene = &model.scene;
    let indices = scene.meshes()[0].original_indices();
    let positions = scene.meshes()[0].positions();
    let (mut covered, mut fronts, mut backs, mut outline) = (0, 0, 0, 0);
    let mut culls = [0_u64; 2];
    for view in lab.views(&model, "orbit", 4, SIZE)? {
        let mut pictures = Vec::new();
        for (cull_face, count) in [CullFace::Back, CullFace::Front].into_iter().zip(&mut culls) {
            let mut view = view.clone();
            view.cull_face = cull_face;
            let eye = ObjectEye::of_view(&view, scene.transform(0));
            let triangles = indices.as_chunks::<3>().0.iter();
            *count +=
                triangles.filter(|t| eye.culls(&t.map(|v| positions[v as usize]))).count() as u64;
            pictures.push(draw(scene, &view));
        }
        let eye = ObjectEye::of_view(&view, scene.transform(0));
        for (front, back) in pictures[0].ids.iter().zip(&pictures[1].ids) {
            outline += u32::from((*front == PixelId::NONE) != (*back == PixelId::NONE));
            if *back == PixelId::NONE {
                continue;
            }
            covered += 1;
            let corners =
                [0, 1, 2].map(|k| positions[indices[back.triangle as usize * 3 + k] as usize]);
            match eye.facing(&corners) {
                Facing::Front => fronts += 1,
                Facing::Back => backs += 1,
                Facing::Edge => {}
            }
        }
    }
    let [culled_backs, culled_fronts] = culls;
    Ok(Finding::if_so(
        covered > 1000 && fronts == 0 && backs == covered && outline == 0 && culled_fronts > 0,
        format!(
            "culling backs takes {} triangles of a ball in four views, culling fronts {}; then {} of {} covered pixels show a back, and \
             {outline} pixels are covered in one of both pictures alone",
            grouped(culled_backs),
            grouped(culled_fronts),
            grouped(backs),
            grouped(covered)
        ),
    ))
}
