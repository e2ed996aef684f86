//! Where instances are in the world, in f64, and where 32-bit numbers are too coarse for them.

use cullet::{Scene, Transform};

/// A box in world space: its lowest and its highest corner.
pub type WorldBox = [[f64; 3]; 2];

/// Rounding of a coordinate that 32-bit files may have, as a share of the size of an instance.
const COARSE: f64 = 1.0 / 131_072.0;
/// A local origin must make the rounding so many times smaller, or it is not worth its trouble.
const WORTH: f64 = 4.0;
/// The middle of what is no more of its sizes away is near zero.
const NEAR: f64 = 2.0;
/// Beyond, whole numbers are no longer told apart, and too long for the comment of a file.
const FARTHEST: f64 = 1e15;

/// A point of an instance in world space.
#[must_use]
pub fn world(transform: &Transform, p: [f32; 3]) -> [f64; 3] {
    std::array::from_fn(|a| {
        let linear: f64 = (0..3).map(|c| f64::from(transform.linear[c][a]) * f64::from(p[c])).sum();
        linear + transform.translation[a]
    })
}

/// Returns the box of an instance in world space: that of its mesh, transformed. `None` where its
/// mesh has no triangle with an area, or its transform is not finite.
#[must_use]
pub fn world_box(scene: &Scene, slot: u32) -> Option<WorldBox> {
    let (bounds, transform) = (scene.mesh(slot).bounds(), scene.transform(slot));
    if bounds.is_empty() || !transform.is_finite() {
        return None;
    }
    let axis = |a: usize| {
        let mut span = [transform.translation[a]; 2];
        for c in 0..3 {
            let factor = f64::from(transform.linear[c][a]);
            let [low, high] = [bounds.min[c], bounds.max[c]].map(|v| factor * f64::from(v));
            span = [span[0] + low.min(high), span[1] + low.max(high)];
        }
        span
    };
    let axes = [0, 1, 2].map(axis);
    let corners = [axes.map(|span| span[0]), axes.map(|span| span[1])];
    corners.as_flattened().iter().all(|v| v.is_finite()).then_some(corners)
}

/// Whether 32-bit coordinates, counted from `origin`, are coarse for the size of an instance.
fn is_coarse(of: &WorldBox, origin: [f64; 3]) -> bool {
    let size = size(of);
    size > 0.0 && rounding(of, origin) > COARSE * size
}

/// How far 32-bit coordinates of a box may be off, counted from `origin`; infinite beyond their
/// range.
fn rounding([low, high]: &WorldBox, origin: [f64; 3]) -> f64 {
    let reach = |a: usize| (low[a] - origin[a]).abs().max((high[a] - origin[a]).abs());
    let far = (0..3).map(reach).fold(0.0, f64::max) as f32;
    if far.is_finite() { f64::from(far.next_up() - far) * 0.5 } else { f64::INFINITY }
}

fn size([low, high]: &WorldBox) -> f64 {
    (0..3).map(|a| high[a] - low[a]).fold(0.0, f64::max)
}

/// Whether 32-bit coordinates, counted from `origin`, are coarse for an instance of a scene.
pub(crate) fn is_far(scene: &Scene, origin: [f64; 3]) -> bool {
    scene.slots().filter_map(|slot| world_box(scene, slot)).any(|of| is_coarse(&of, origin))
}

/// Returns the place that the zero of a file with 32-bit coordinates should stand for: zero itself,
/// or whole numbers near the middle of a scene that is so far from zero that f32 is coarse for an
/// instance of it, if that helps.
#[must_use]
pub fn local_origin(scene: &Scene) -> [f64; 3] {
    origin_of(|| scene.slots().filter_map(|slot| world_box(scene, slot)))
}

fn origin_of<I: Iterator<Item = WorldBox>>(boxes: impl Fn() -> I) -> [f64; 3] {
    let zero = [0.0; 3];
    if !boxes().any(|of| is_coarse(&of, zero)) {
        return zero;
    }
    let mut around = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for [low, high] in boxes() {
        for a in 0..3 {
            around[0][a] = around[0][a].min(low[a]);
            around[1][a] = around[1][a].max(high[a]);
        }
    }
    let size = size(&around);
    let middle: [f64; 3] = std::array::from_fn(|a| {
        let middle = around[0][a] * 0.5 + around[1][a] * 0.5;
        // An axis along which all is near zero stays as it is.
        if middle.abs() > size * NEAR { middle.round() } else { 0.0 }
    });
    let helps = rounding(&around, middle) * WORTH <= rounding(&around, zero);
    let helps = helps && middle.iter().all(|v| v.abs() < FARTHEST);
    if helps { middle } else { zero }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_origin_is_moved_only_where_f32_is_coarse_and_it_helps() {
        let cube = |x: f64, size: f64| [[x, 0.0, 0.0], [x + size, size, size]];
        let of = |boxes: &[WorldBox]| origin_of(|| boxes.iter().copied());
        assert_eq!(of(&[]), [0.0; 3]);
        assert_eq!(of(&[cube(5.0, 1.0)]), [0.0; 3]);
        // The middle, rounded to a whole number: half a metre rounds away from zero.
        assert_eq!(of(&[cube(3e8, 1.0)]), [300_000_001.0, 0.0, 0.0]);
        // Far apart, no place is near both.
        assert_eq!(of(&[cube(3e8, 1.0), cube(-3e8, 1.0)]), [0.0; 3]);
        assert_eq!(of(&[cube(-1e6, 2e6)]), [0.0; 3]);
    }
}
