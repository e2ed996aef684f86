//! Casters of shadows, one by one, by linear programming.

use cullet::bounds::{Aabb, Plane};
use cullet::cull::shadow::Light;
use cullet::view::Frustum;
use glam::{DMat4, DVec3, DVec4};

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

/// Returns whether a caster has a point between the light and some point of the frustum that is in `receivers`, within
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
    let (apex, range, cone) = match *light {
        Light::Directional { direction } => (-DVec3::from(direction), f64::INFINITY, None),
        Light::Point { position, range } => (position.into(), range, None),
        Light::Spot { position, direction, half_angle_radians, range } => {
            (position.into(), range, Some((DVec3::from(direction), half_angle_radians)))
        }
        _ => return true,
    };
    let at_infinity = matches!(light, Light::Directional { .. });
    if range <= 0.0 || cone.is_some_and(|(_, half_angle)| half_angle <= 0.0) {
        return false;
    }
    let is_no_way = |v: DVec3| !v.is_finite() || v == DVec3::ZERO;
    if !apex.is_finite()
        || at_infinity && is_no_way(apex)
        || cone.is_some_and(|(axis, _)| is_no_way(axis))
    {
        return true;
    }
    let apex = if at_infinity { apex.normalize() } else { apex };
    if !caster.is_finite() || receivers.is_some_and(|b| !b.is_finite()) {
        return true;
    }
    let mut lit: Vec<Plane> = frustum.planes().map(|(_, p)| *p).collect();
    if let Some((axis, half_angle)) = cone.filter(|c| c.1 < std::f64::consts::FRAC_PI_2) {
        lit.extend(pyramid(apex, axis.normalize(), half_angle));
    }
    if let Some(b) = receivers {
        lit.extend(faces(b.min.map(f64::from), b.max.map(f64::from)));
    }
    if range.is_finite() {
        lit.extend(faces((apex - range).into(), (apex + range).into()));
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
        lit.iter().map(|p| with(p, if at_infinity { 0.0 } else { p.d })).collect();
    for plane in faces(caster.min.map(f64::from), caster.max.map(f64::from)) {
        all.push(with(&plane, apex.dot(plane.normal.into())));
    }
    all.push(start);
    if !at_infinity {
        all.push(Condition::new([0.0; 3], 1.0, 1.0));
    }
    solvable(&all)
}

/// The eight planes around a cone, each of which touches it.
fn pyramid(tip: DVec3, axis: DVec3, half_angle: f64) -> impl Iterator<Item = Plane> {
    let (u, v) = axis.any_orthonormal_pair();
    let (sine, cosine) = half_angle.sin_cos();
    (0..8).map(move |side| {
        let turn = std::f64::consts::TAU * f64::from(side) / 8.0;
        let n = (u * turn.cos() + v * turn.sin()) * cosine - axis * sine;
        Plane { normal: n.into(), d: n.dot(tip) }
    })
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
                    let [a, b, c, d] = four.map(|k| k.a);
                    let rows = DMat4::from_cols(a, b, c, d).transpose();
                    if rows.determinant().abs() < 1e-12 {
                        continue;
                    }
                    let [a, b, c, d] = four.map(|k| k.c);
                    if holds(rows.inverse() * DVec4::new(a, b, c, d)) {
                        return true;
                    }
                }
            }
        }
    }
    false
}
