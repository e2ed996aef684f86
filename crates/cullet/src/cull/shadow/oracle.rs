//! The slow oracle: one caster, by linear programming.

use glam::{DMat4, DVec4};

use super::light::{Light, Reach};
use crate::array::Each;
use crate::bounds::{Aabb, Plane};
use crate::view::Frustum;

/// The linear condition a·(x, y, z, t) ≤ c, a of unit length.
#[derive(Clone, Copy)]
struct Condition {
    a: DVec4,
    c: f64,
}

impl Condition {
    fn new([x, y, z]: [f64; 3], t: f64, c: f64) -> Self {
        let a = DVec4::new(x, y, z, t);
        Self { a: a / a.length(), c: c / a.length() }
    }
}

/// Whether a caster has a point between the light and some point of the frustum that is in `receivers`, within
/// the light's cone (as the pyramid around it) and in the box around its range.
///
/// Such a point exists iff these conditions have a solution: a receiver y in the frustum and in the boxes, a place t
/// on the way from it to the light L, and y + t L (or y + t (p − y) for a light at p, which is linear in
/// (1 − t) y and t) in the caster. Where they have one at all they have one where four of them are equations. So all
/// fours are tried. Plain f64 with a tolerance of 1e-9 of the sizes; milliseconds.
///
/// True for a caster, receivers or light that is not finite, and for a light that lights nothing it is false.
#[must_use]
pub fn casts_into_ref(
    frustum: &Frustum,
    receivers: Option<&Aabb>,
    light: &Light,
    caster: &Aabb,
) -> bool {
    if caster.is_empty() || receivers.is_some_and(Aabb::is_empty) {
        return false;
    }
    let (apex, range, cone) = match light.reach() {
        Reach::Nothing => return false,
        Reach::Unknown => return true,
        Reach::Lit(lit) => (lit.apex, lit.range, lit.cone()),
    };
    if !caster.is_finite() || receivers.is_some_and(|b| !b.is_finite()) {
        return true;
    }
    let mut lit: Vec<Plane> = frustum.planes().map(|(_, p)| *p).collect();
    lit.extend(cone.iter().flatten());
    if let Some(b) = receivers {
        lit.extend(faces(b.min.each(f64::from), b.max.each(f64::from)));
    }
    if range.is_finite() {
        lit.extend(faces((apex.point - range).into(), (apex.point + range).into()));
    }
    let with = |plane: &Plane, t: f64| Condition::new(plane.normal, t, plane.d);
    let start = Condition::new([0.0; 3], -1.0, 0.0);
    // At t = 1 every way ends in the light, also that of a receiver that does not exist.
    let mut any: Vec<_> = lit.iter().map(|p| with(p, 0.0)).collect();
    any.extend([Condition::new([0.0; 3], 1.0, 0.0), start]);
    if !solvable(&any) {
        return false;
    }
    // Unknowns: z = y and t ≥ 0 for a direction; z = (1 − t) y and 0 ≤ t ≤ 1 for a point.
    let mut all: Vec<_> =
        lit.iter().map(|p| with(p, if apex.at_infinity { 0.0 } else { p.d })).collect();
    for plane in faces(caster.min.each(f64::from), caster.max.each(f64::from)) {
        all.push(with(&plane, apex.point.dot(plane.normal.into())));
    }
    all.push(start);
    if !apex.at_infinity {
        all.push(Condition::new([0.0; 3], 1.0, 1.0));
    }
    solvable(&all)
}

fn faces(min: [f64; 3], max: [f64; 3]) -> impl Iterator<Item = Plane> {
    (0..6).map(move |face| {
        let (axis, high) = (face / 2, face % 2 == 1);
        let mut normal = [0.0; 3];
        normal[axis] = if high { 1.0 } else { -1.0 };
        Plane { normal, d: if high { max[axis] } else { -min[axis] } }
    })
}

fn solvable(all: &[Condition]) -> bool {
    let holds = |v: DVec4| {
        all.iter().all(|k| k.a.dot(v) - k.c <= 1e-9 * (1.0 + k.c.abs() + v.abs().element_sum()))
    };
    let n = all.len();
    for i in 0..n {
        for j in i + 1..n {
            for k in j + 1..n {
                for l in k + 1..n {
                    let four = [&all[i], &all[j], &all[k], &all[l]];
                    let [a, b, c, d] = four.each(|k| k.a);
                    let rows = DMat4::from_cols(a, b, c, d).transpose();
                    if rows.determinant().abs() < 1e-12 {
                        continue;
                    }
                    let [a, b, c, d] = four.each(|k| k.c);
                    if holds(rows.inverse() * DVec4::new(a, b, c, d)) {
                        return true;
                    }
                }
            }
        }
    }
    false
}
