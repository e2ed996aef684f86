//! Casters that the light does not reach: their shadows fall within those of what hides them.

use fearless_simd::Level;

use crate::bits;
use crate::bounds::Aabb;
use crate::cull::occlusion::{OcclusionBuffer, Shape, Visibility};
use crate::transform::Transform;
use crate::view::View;

/// Drops from `kept`, a bit for each of `casters`, those that are hidden from the light, and returns how many went.
///
/// `light` is the light's view: orthographic for a directional light, perspective for a spot. `occluders` are
/// drawn into `buffer`, nearest the light first where that is to save time; `casters` and `origin` are as in
/// [`OcclusionBuffer::begin`]. A caster is dropped where every ray of the light meets an occluder before the caster:
/// what it would shade is in shadow already, so no image changes. That holds if each occluder casts a shadow itself
/// (it hides no light that the renderer lets through) and if it stays drawn: one is never hidden by itself.
///
/// What lies outside of the light's view in part is judged by the part within it; casters that are NaN,
/// infinite or through the near plane are kept. What is wholly outside is kept too: its shadow is not this
/// view's to judge. Cost: drawing the occluders, then some tens of nanoseconds a caster.
///
/// # Panics
/// If `kept` has fewer bits than there are casters.
pub fn drop_unlit(
    level: Level,
    buffer: &mut OcclusionBuffer,
    light: &View,
    origin: [f64; 3],
    occluders: &[(&Shape, Transform)],
    casters: &[Aabb],
    kept: &mut [u64],
) -> usize {
    assert!(kept.len() * 64 >= casters.len(), "a bit for each of {} casters", casters.len());
    buffer.begin(light, origin);
    for (shape, transform) in occluders {
        shape.draw(level, &mut buffer.band(), transform);
    }
    let mut dropped = 0;
    for (i, caster) in casters.iter().enumerate() {
        if bits::get(kept, i) && buffer.test_box(caster) == Visibility::Hidden {
            kept[i / 64] &= !(1 << (i % 64));
            dropped += 1;
        }
    }
    dropped
}
