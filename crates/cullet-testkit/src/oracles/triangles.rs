//! Sides and areas of transformed triangles, by exact arithmetic.

use cullet::cull::backface::Facing;
use cullet::{Transform, View};

use super::exact::Exact;

/// Returns which side of a triangle is seen, by the exact sign of the determinant of its corners in
/// clip space, with no rounding from the matrices on. Slow. [`Facing::Edge`] means edge-on and nothing
/// else; also where a number is not finite, or the transform is singular.
#[must_use]
pub fn facing_ref(view: &View, transform: &Transform, corners: &[[f32; 3]; 3]) -> Facing {
    let finite = corners.iter().flatten().all(|v| v.is_finite());
    if !(finite && transform.is_finite()) {
        return Facing::Edge;
    }
    let exact = |v: f64| Exact::from(v);
    let m = view.clip_from_world();
    let clip = corners.map(|p| {
        let world: Vec<Exact> = (0..3)
            .map(|i| {
                let [x, y, z] = transform.linear.map(|column| exact(f64::from(column[i])));
                let t = exact(transform.translation[i]);
                let [px, py, pz] = p.map(|v| exact(f64::from(v)));
                Exact::dot(&[x, y, z, t], &[px, py, pz, exact(1.0)])
            })
            .chain([exact(1.0)])
            .collect();
        [0, 1, 3].map(|row| Exact::dot(&[0, 4, 8, 12].map(|c| exact(m[c + row])), &world))
    });
    let [[ax, ay, aw], [bx, by, bw], [cx, cy, cw]] = clip;
    let minor = |p: &Exact, q: &Exact, r: &Exact, s: &Exact| p.times(s).minus(&q.times(r));
    let determinant = Exact::dot(
        &[ax, ay, aw],
        &[minor(&by, &bw, &cy, &cw), minor(&bw, &bx, &cw, &cx), minor(&bx, &by, &cx, &cy)],
    );
    let handed = match (transform.rank(), transform.is_mirrored()) {
        (0..3, _) => 0,
        (_, true) => -1,
        (_, false) => 1,
    };
    let mirror = if view.is_mirrored() { -1 } else { 1 };
    let sign = determinant.sign() * mirror * handed;
    Facing::from_value(f64::from(sign), 0.0, view.front_face)
}

/// Returns whether a transformed triangle has no area, from the exact images of its corners. Slow.
#[must_use]
pub fn flattens_ref(transform: &Transform, corners: &[[f32; 3]; 3]) -> bool {
    if !(transform.is_finite() && corners.iter().flatten().all(|v| v.is_finite())) {
        return false;
    }
    let images = corners.map(|p| {
        [0, 1, 2].map(|i| {
            let row = transform.linear.map(|column| Exact::from(f64::from(column[i])));
            Exact::dot(&row, &p.map(|v| Exact::from(f64::from(v))))
        })
    });
    let edge = |end: usize| [0, 1, 2].map(|i| images[end][i].minus(&images[0][i]));
    let (ab, ac) = (edge(1), edge(2));
    (0..3).all(|i| {
        let (u, v) = ((i + 1) % 3, (i + 2) % 3);
        ab[u].times(&ac[v]).minus(&ab[v].times(&ac[u])).sign() == 0
    })
}
