//! Volumes: the part of space that a light reaches.

use bevy_color::{Color, ColorToComponents};
use bevy_light::{PointLight, SpotLight};
use bevy_math::DVec3;
use bevy_transform::components::GlobalTransform;
use engine::bounds::{Aabb as Bounds, Plane};
use engine::cull::shadow::Light;
use engine::view::Frustum as Region;

/// The part of space that a light reaches.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Volume {
    pub(crate) center: [f64; 3],
    pub(crate) radius: f64,
    planes: Vec<Plane>,
    pub(crate) light: Light,
}

/// How much farther light is taken to reach: the device places pixels by f32.
const REACH: f64 = 1.001;
/// Nearer near planes leave depth too few bits to tell what is before what.
const NEAREST: f32 = 1e-6;
/// How much wider, in radians: the shader knows a spot's direction by two of its coordinates.
pub(crate) const WIDER: f64 = 0.02;

impl Volume {
    /// The reach of a light around a place, with or without a cone. `None` where the numbers make
    /// no light that ends somewhere.
    fn new(at: &GlobalTransform, range: f32, outer_angle: Option<f32>) -> Option<Self> {
        let center = at.translation().as_dvec3();
        let radius = f64::from(range) * REACH + center.abs().max_element() * 1e-5;
        // The shader divides by the square of the range.
        let is_near = center.abs().cmplt(DVec3::splat(1e9)).all();
        if !((1e-9..1e9).contains(&range) && is_near) {
            return None;
        }
        let mut light = Light::Point { position: center.to_array(), range: radius };
        let mut planes = Vec::new();
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let mut normal = [0.0; 3];
                normal[axis] = sign;
                planes.push(Plane { normal, d: sign * center[axis] + radius });
            }
        }
        let angle = outer_angle.map(|angle| f64::from(angle) + WIDER);
        if let Some(angle) = angle.filter(|&angle| angle < std::f64::consts::FRAC_PI_2) {
            let axis = forward(at);
            light = Light::Spot {
                position: center.to_array(),
                direction: axis.to_array(),
                half_angle_radians: angle,
                range: radius,
            };
            let (sin, cos) = angle.sin_cos();
            let side = axis.any_orthonormal_vector();
            let up = axis.cross(side);
            for out in [side, -side, up, -up] {
                let normal = (out * cos - axis * sin).normalize();
                planes.push(Plane {
                    normal: normal.to_array(),
                    d: normal.dot(center) + radius * 1e-3,
                });
            }
        }
        Some(Self { center: center.to_array(), radius, planes, light })
    }

    pub(crate) fn of_point(light: &PointLight, at: &GlobalTransform) -> Option<Self> {
        let PointLight { color, intensity, range, radius, .. } = *light;
        let PointLight { shadow_depth_bias, shadow_normal_bias, shadow_map_near_z, .. } = *light;
        let numbers = [intensity, radius, shadow_depth_bias, shadow_normal_bias];
        let has_depth = (NEAREST..range).contains(&shadow_map_near_z);
        (has_depth && shines(color, &numbers)).then(|| Self::new(at, range, None))?
    }

    pub(crate) fn of_spot(light: &SpotLight, at: &GlobalTransform) -> Option<Self> {
        let SpotLight { color, intensity, range, radius, inner_angle, outer_angle, .. } = *light;
        let SpotLight { shadow_depth_bias, shadow_normal_bias, shadow_map_near_z, .. } = *light;
        let numbers = [intensity, radius, shadow_depth_bias, shadow_normal_bias];
        let is_cone = (NEAREST..range).contains(&shadow_map_near_z)
            && (1e-3..std::f32::consts::FRAC_PI_2).contains(&outer_angle)
            && inner_angle.is_finite()
            && forward(at) != DVec3::ZERO;
        (is_cone && shines(color, &numbers)).then(|| Self::new(at, range, Some(outer_angle)))?
    }

    /// Returns a box around it.
    pub(crate) fn bounds(&self) -> Bounds {
        let [mut min, mut max] = [[0.0; 3]; 2];
        for axis in 0..3 {
            let [below, above] = match self.light {
                Light::Spot { direction, half_angle_radians, .. } => {
                    [-1.0, 1.0].map(|sign| sector(sign * direction[axis], half_angle_radians))
                }
                _ => [1.0; 2],
            };
            // A little more, for the sums are rounded.
            let more = self.radius * 1e-6;
            min[axis] = self.center[axis] - below * self.radius - more;
            max[axis] = self.center[axis] + above * self.radius + more;
        }
        Bounds::rounded_out(min, max)
    }

    /// Returns the half-spaces around it.
    pub(crate) fn region(&self) -> Region {
        let mut region = Region::from_planes(std::array::from_fn(|i| self.planes.get(i).copied()));
        for &plane in self.planes.iter().skip(6) {
            // One that is refused is one fewer to reject by.
            let _ = region.push(plane);
        }
        region
    }
}

/// How far a sector of the unit ball reaches along an axis that makes an angle of cosine `cos` with the sector's
/// own; its tip reaches 0.
fn sector(cos: f64, half_angle: f64) -> f64 {
    let apart = (cos.clamp(-1.0, 1.0).acos() - half_angle).max(0.0);
    apart.cos().max(0.0)
}

/// Whether a light is nothing where it ends. A number that is not one, or infinite, makes colours
/// that are not numbers wherever the light is asked, also where it is zero.
fn shines(color: Color, numbers: &[f32]) -> bool {
    let color = color.to_linear().to_f32_array();
    color.iter().chain(numbers).all(|number| number.abs() < 1e20)
}

/// The way that a light shines; zero where there is none.
pub(crate) fn forward(at: &GlobalTransform) -> DVec3 {
    (-at.affine().matrix3.z_axis.as_dvec3()).normalize_or_zero()
}

/// Whether a box comes as near to a point as this. NaN does.
pub(crate) fn is_near(center: [f64; 3], radius: f64, bounds: &engine::bounds::Aabb) -> bool {
    let mut square = 0.0;
    for axis in 0..3 {
        let [min, max] = [bounds.min[axis], bounds.max[axis]].map(f64::from);
        let apart = (min - center[axis]).max(center[axis] - max).max(0.0);
        square += apart * apart;
    }
    !(square > radius * radius)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_math::{Quat, Vec3};
    use bevy_transform::components::Transform;

    #[test]
    fn the_box_of_a_cone_holds_it_and_is_tight() {
        let mut state = 7u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 40) as f64 / f64::from(1 << 24) * 2.0 - 1.0
        };
        for _ in 0..200 {
            let angle = (random() * 0.5 + 0.5) as f32 * 1.4 + 0.01;
            let turn = Quat::from_euler(
                bevy_math::EulerRot::XYZ,
                random() as f32 * 3.0,
                random() as f32 * 3.0,
                random() as f32 * 3.0,
            );
            let at = Transform::from_translation(Vec3::new(random() as f32 * 9.0, 5.0, -3.0))
                .with_rotation(turn);
            let at = GlobalTransform::from(at);
            let volume = Volume::new(&at, 10.0, Some(angle)).unwrap();
            let bounds = volume.bounds();
            let (axis, center) = (forward(&at), at.translation().as_dvec3());
            let mut found = Bounds::EMPTY;
            for _ in 0..3000 {
                let way = DVec3::new(random(), random(), random()).normalize_or_zero();
                // At the rim too, which random ways seldom meet.
                let aside = (way - axis * way.dot(axis)).normalize_or_zero();
                let (sin, cos) = f64::from(angle).sin_cos();
                for way in [way, axis * cos + aside * sin] {
                    if way.dot(axis) >= cos - 1e-9 {
                        let point = (center + way * 10.0).as_vec3().to_array();
                        assert!(bounds.contains(point), "{point:?} {bounds:?}");
                        found = found.union(&Bounds::new(point, point));
                    }
                }
            }
            found =
                found.union(&Bounds::new(at.translation().to_array(), at.translation().to_array()));
            for axis in 0..3 {
                assert!(found.min[axis] - bounds.min[axis] < 0.5, "{angle} {found:?} {bounds:?}");
                assert!(bounds.max[axis] - found.max[axis] < 0.5, "{angle} {found:?} {bounds:?}");
            }
        }
    }
}
