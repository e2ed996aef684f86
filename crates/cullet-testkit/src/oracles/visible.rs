//! Potentially visible triangles of a view.

use cullet::{
    Reason, Scene, Stage, View, Visible,
    draw::TriangleRange,
    view::{CullFace, FrontFace},
};

use crate::vectors::multiply;

/// Potentially visible triangles, hidden surfaces included: those (in the order of their mesh) that face it
/// and of which a part is left after clipping in clip space, by a margin that makes it beyond doubt.
pub fn visible_ref(scene: &Scene, view: &View) -> Vec<(u32, u32)> {
    let m = view.clip_from_world();
    let mut seen = Vec::new();
    for slot in scene.slots() {
        if scene.layers(slot) & view.layers == 0 {
            continue;
        }
        let mesh = scene.mesh(slot);
        let t = scene.transform(slot).to_matrix();
        let mirrored = (scene.transform(slot).determinant() < 0.0) != view.is_mirrored();
        for triangle in 0..mesh.triangle_count() {
            let corners = mesh.corners(triangle).map(|p| {
                let p = p.map(f64::from);
                let world = multiply(&t, [p[0], p[1], p[2], 1.0]);
                multiply(&m, world)
            });
            let original = mesh.original_triangle()[triangle as usize];
            let part = mesh
                .parts()
                .iter()
                .find(|p| {
                    (p.first_triangle..p.first_triangle + p.triangle_count).contains(&original)
                })
                .expect("every triangle has a part");
            let one_sided = !part.two_sided && !scene.flags(slot).double_sided;
            let [a, b, c] = corners.map(|v| [v[0], v[1], v[3]]);
            let det = a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
                + a[2] * (b[0] * c[1] - b[1] * c[0]);
            let counter_clockwise = (det > 0.0) != mirrored;
            let front = counter_clockwise == (view.front_face == FrontFace::CounterClockwise);
            let culled = match view.cull_face {
                CullFace::None => false,
                CullFace::Back => !front,
                CullFace::Front => front,
            };
            let size: f64 = corners.iter().flatten().map(|v| v.abs()).sum();
            if det.abs() > size * size * size * 1e-9
                && !(one_sided && culled)
                && survives_clipping(&corners, size * 1e-6)
            {
                seen.push((slot, triangle));
            }
        }
    }
    seen
}

/// Sutherland–Hodgman against |x| ≤ w, |y| ≤ w, 0 ≤ z ≤ w, each moved inward by `margin`.
fn survives_clipping(triangle: &[[f64; 4]; 3], margin: f64) -> bool {
    let mut polygon = triangle.to_vec();
    let planes: [fn([f64; 4]) -> f64; 6] = [
        |v| v[3] + v[0],
        |v| v[3] - v[0],
        |v| v[3] + v[1],
        |v| v[3] - v[1],
        |v| v[2],
        |v| v[3] - v[2],
    ];
    for plane in planes {
        let mut next = Vec::new();
        for i in 0..polygon.len() {
            let (p, q) = (polygon[i], polygon[(i + 1) % polygon.len()]);
            let (dp, dq) = (plane(p) - margin, plane(q) - margin);
            if dp >= 0.0 {
                next.push(p);
            }
            if (dp >= 0.0) != (dq >= 0.0) {
                let t = dp / (dp - dq);
                next.push(std::array::from_fn(|k| p[k] + (q[k] - p[k]) * t));
            }
        }
        polygon = next;
    }
    polygon.len() >= 3
}

/// A visible set as a frustum and back-face culler would make it, by the plainest of means.
pub fn frustum_kept(scene: &Scene, view: &View) -> Visible {
    let frustum = view.frustum();
    let mut visible = Visible::default();
    for slot in 0..scene.slot_count() {
        let b = scene.bounds(slot);
        let outside = cullet::view::FrustumPlane::ALL.into_iter().position(|plane| {
            frustum.plane(plane).is_some_and(|plane| {
                b.corners().iter().all(|c| plane.distance(c.map(f64::from)) > 1e-3)
            })
        });
        let small =
            view.project_box(&b, scene.origin()).is_some_and(|r| r.width().max(r.height()) < 2.0);
        let reason = match outside {
            Some(plane) => Some(Reason { stage: Stage::Frustum, detail: plane as u8 }),
            None => small.then_some(Reason { stage: Stage::Detail, detail: 0 }),
        };
        visible.reasons.push(reason);
        if reason.is_none() {
            let first = visible.triangles.len() as u32;
            let mesh = scene.mesh(slot);
            let t = scene.transform(slot);
            let eye = view.eye();
            let facing = |&i: &u32| {
                let [a, b, c] = mesh.corners(i).map(|p| {
                    std::array::from_fn::<f64, 3, _>(|r| {
                        (0..3).map(|k| f64::from(t.linear[k][r]) * f64::from(p[k])).sum::<f64>()
                            + t.translation[r]
                    })
                });
                let plane = cullet::bounds::Plane::from_points(a, b, c);
                mesh.parts()[0].two_sided
                    || plane.is_none_or(|p| p.distance([eye[0], eye[1], eye[2]]) > -1e-9)
            };
            visible.triangles.extend((0..mesh.triangle_count()).filter(facing));
            let count = visible.triangles.len() as u32 - first;
            visible.triangle_ranges.push(TriangleRange { slot, level: 0, first, count });
        }
    }
    visible
}
