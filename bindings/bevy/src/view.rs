//! State of a camera from frame to frame, and what is reported of it.

use bevy_camera::primitives::Frustum;
use bevy_ecs::change_detection::Tick;
use bevy_ecs::prelude::*;
use bevy_math::{Affine3A, Vec3A};
use engine::bounds::Plane;
use engine::cull::frustum::batch::{Planes, classify_boxes};
use engine::cull::frustum::tree::Cut;
use engine::view::Frustum as Region;
use engine::{Scene, Simd};

use crate::bits::slots_of;
use crate::list::Listed;
use crate::mirror::CulletScene;

/// How many entities with a mesh each stage left, for one camera in one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct CulletFunnel {
    /// All that are culled on the CPU.
    pub entities: u64,
    /// Entities that are not outside the frustum, are not hidden by their `Visibility` and share a
    /// layer with the camera.
    pub in_frustum: u64,
    /// Entities among them that are in their visibility range too, what Bevy itself would list, and that
    /// [`CulletCandidates`](crate::CulletCandidates) do not leave out.
    pub in_range: u64,
    /// Entities among them that are not behind others: what is drawn.
    pub visible: u64,
}

/// State and results of a camera; required by `Camera`, so that each has one.
#[derive(Component, Debug, Default)]
pub struct CulletView {
    /// Counts of the last frame in which the camera was active.
    pub funnel: CulletFunnel,
    pub(crate) cut: Cut,
    /// One bit a slot: in the frustum and the layers.
    found: Vec<u64>,
    /// Slots that are asked one by one.
    doubtful: Vec<u32>,
    /// Seen in the last frame, ranges and occlusion included.
    pub(crate) listed: Listed,
    pub(crate) next: Vec<u64>,
    /// Inputs that `listed` was found from.
    pub(crate) known: Option<Known>,
    /// Rises with each frame in which `listed` may have changed.
    pub(crate) version: u64,
    pub(crate) hidden: crate::occlusion::Hidden,
    /// When `VisibleEntities` was written last, by us: nobody else wrote to it where it has not
    /// changed since.
    pub(crate) written: Option<Tick>,
    /// Whether its list of meshes is `list` still.
    pub(crate) is_listed: bool,
    /// Entities that are listed among the meshes and are none any more.
    pub(crate) strays: Vec<Entity>,
    /// Somebody else wrote to `VisibleEntities` since the last frame's check.
    pub(crate) is_foreign: bool,
    /// Something is listed that is neither a mesh nor a light, a probe or a decal.
    pub(crate) has_unknown: bool,
}

/// Inputs of the answer: where they are the same as in the last frame, so is the answer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Known {
    pub(crate) scene: u64,
    pub(crate) order: u64,
    pub(crate) change: u64,
    /// See [`CulletScene`].
    pub(crate) step: u64,
    pub(crate) planes: Option<[[f32; 4]; 5]>,
    pub(crate) layers: u32,
    /// When the camera's candidates changed last, where it has some.
    pub(crate) candidates: Option<Tick>,
    /// Matrix and settings of occlusion, where there is some.
    pub(crate) occlusion: Option<([f64; 16], [u32; 2], crate::CulletOcclusion)>,
}

/// The half-spaces that Bevy tests meshes against: all but the far one, which its renderer does not
/// clip at.
pub(crate) fn half_spaces(frustum: &Frustum) -> [[f32; 4]; 5] {
    std::array::from_fn(|i| frustum.half_spaces[i].normal_d().to_array())
}

/// The same region, of planes that point out. One that is not finite rejects nothing.
pub(crate) fn region(half_spaces: &[[f32; 4]]) -> Region {
    let plane = |half_space: &[f32; 4]| {
        let [x, y, z, d] = half_space.map(f64::from);
        Plane { normal: [-x, -y, -z], d }
    };
    Region::from_planes(std::array::from_fn(|i| half_spaces.get(i).map(plane)))
}

/// Whether a box of an entity is outside of one of the half-spaces, by more than f32 rounds.
pub(crate) fn is_outside(
    half_spaces: &[[f32; 4]; 5],
    aabb: &bevy_camera::primitives::Aabb,
    at: &Affine3A,
) -> bool {
    let center = at.transform_point3a(aabb.center);
    let extents = aabb.half_extents.abs();
    let matrix = at.matrix3.transpose();
    // The sums below are off by nine roundings of these sizes at the most, each of half of
    // f32::EPSILON; what f64 allows for is one of f32::EPSILON.
    let m = &at.matrix3;
    let c = aabb.center.abs();
    let reach = |v: Vec3A| m.x_axis.abs() * v.x + m.y_axis.abs() * v.y + m.z_axis.abs() * v.z;
    let sizes = reach(c + extents) + at.translation.abs();
    half_spaces.iter().any(|plane| {
        let normal = Vec3A::new(plane[0], plane[1], plane[2]);
        let beyond = normal.dot(center) + plane[3] + (matrix * normal).abs().dot(extents);
        let slack = (normal.abs().dot(sizes) + plane[3].abs()) * (16.0 * f32::EPSILON) + 1e-30;
        // Also where something is not a number.
        let is_clear = beyond.abs() > slack;
        if is_clear { beyond < 0.0 } else { is_beyond(plane, aabb, at) }
    })
}

/// Whether a box is outside of a half-space, in f64.
fn is_beyond(plane: &[f32; 4], aabb: &bevy_camera::primitives::Aabb, at: &Affine3A) -> bool {
    let m = at.matrix3.as_dmat3();
    let center = m * aabb.center.as_dvec3() + at.translation.as_dvec3();
    let extents = aabb.half_extents.as_dvec3().abs();
    let [x, y, z, d] = plane.map(f64::from);
    let normal = bevy_math::DVec3::new(x, y, z);
    let radius = (m.transpose() * normal).abs().dot(extents);
    let distance = normal.dot(center) + d;
    // The planes themselves are rounded to f32, and so is what the shader makes of the corners.
    let rounding = (normal.abs().dot(center.abs()) + d.abs() + radius) * f64::from(f32::EPSILON);
    distance + radius < -rounding
}

impl Known {
    /// Returns the number of scene steps by which the frustum's result is behind; `None` where it
    /// is found anew.
    fn behind(&self, now: &Self) -> Option<u64> {
        let view = |known: &Self| (known.scene, known.order, known.planes, known.layers);
        // NaN equals nothing, and so is found anew.
        (view(self) == view(now)).then(|| now.step - self.step)
    }
}

impl CulletView {
    /// Finds what of the scene is in the frustum and the layers of `now`, into `next`. Where the
    /// view is that of the last frame, only what changed is asked again.
    pub(crate) fn find(
        &mut self,
        mirror: &CulletScene,
        now: &Known,
        straddles: impl Fn(&[Entity]) -> u64,
    ) {
        let scene = &mirror.scene;
        let words = scene.hierarchy().present().len();
        self.found.resize(words, 0);
        match self.known.as_ref().and_then(|known| known.behind(now)) {
            Some(0) => {}
            Some(1) => self.find_again(mirror, now, &straddles),
            _ => self.find_all(mirror, now, &straddles),
        }
        self.next.clone_from(&self.found);
        self.funnel.entities = u64::from(scene.instance_count());
        self.funnel.in_frustum = self.count();
    }

    /// Asks all words of slots, by the hierarchy.
    fn find_all(
        &mut self,
        mirror: &CulletScene,
        now: &Known,
        straddles: &impl Fn(&[Entity]) -> u64,
    ) {
        let scene = &mirror.scene;
        let hierarchy = scene.hierarchy();
        self.found.fill(0);
        let found = self.found.iter_mut().enumerate();
        let Some(half_spaces) = &now.planes else {
            let words = found.zip(hierarchy.present());
            words.for_each(|((word, found), &all)| *found = in_layers(scene, now, word, all));
            return;
        };
        let planes = Planes::new(&region(half_spaces));
        self.cut.cull(Simd::best(), &planes, hierarchy.nodes(), hierarchy.boxes());
        let cut = &self.cut;
        self.doubtful.clear();
        for (word, found) in found {
            let (visible, inside) = (cut.visible()[word], cut.inside()[word]);
            if visible != 0 || scene.exempt()[word] != 0 {
                *found = sure(scene, now, word, [visible, inside], &mut self.doubtful);
            }
        }
        ask(scene, &mut self.found, &self.doubtful, straddles);
    }

    /// Asks the words in which a slot changed, one by one.
    fn find_again(
        &mut self,
        mirror: &CulletScene,
        now: &Known,
        straddles: &impl Fn(&[Entity]) -> u64,
    ) {
        let scene = &mirror.scene;
        let hierarchy = scene.hierarchy();
        let planes = now.planes.as_ref().map(|planes| Planes::new(&region(planes)));
        self.doubtful.clear();
        for word in mirror.touched() {
            let Some(found) = self.found.get_mut(word) else { continue };
            let Some(planes) = &planes else {
                *found = in_layers(scene, now, word, hierarchy.present()[word]);
                continue;
            };
            let [mut visible, mut inside] = [[0]; 2];
            let boxes = hierarchy.boxes();
            classify_boxes(Simd::best(), planes, boxes, word, &mut visible, &mut inside);
            *found = sure(scene, now, word, [visible[0], inside[0]], &mut self.doubtful);
        }
        ask(scene, &mut self.found, &self.doubtful, straddles);
    }

    /// How many are in `next`.
    pub(crate) fn count(&self) -> u64 {
        self.next.iter().map(|word| u64::from(word.count_ones())).sum()
    }

    /// Makes `next` what is seen, and brings the list after it. Tells whether it changed.
    pub(crate) fn take(&mut self, mirror: &CulletScene, same_order: bool) -> bool {
        self.listed.take(mirror, same_order, &mut self.next)
    }
}

/// The slots of a word that are in the layers of a view.
fn in_layers(scene: &Scene, now: &Known, word: usize, mut bits: u64) -> u64 {
    for slot in slots_of(word, bits) {
        if scene.layers(slot) & now.layers == 0 {
            bits &= !(1 << (slot % 64));
        }
    }
    bits
}

/// The slots of a word that are sure to be seen, of those whose boxes are visible, or inside all
/// half-spaces. Others are put to `doubtful`: the boxes of those that straddle a half-space are
/// looser than those of Bevy, and some are tested against nothing but those.
fn sure(
    scene: &Scene,
    now: &Known,
    word: usize,
    [visible, inside]: [u64; 2],
    doubtful: &mut Vec<u32>,
) -> u64 {
    let (present, exempt) = (scene.hierarchy().present()[word], scene.exempt()[word]);
    let visible = in_layers(scene, now, word, (visible | exempt) & present);
    let asked = visible & (!inside | exempt);
    doubtful.extend(slots_of(word, asked));
    visible & !asked
}

/// Adds the slots to what was found that are seen when they are asked one by one: `straddles` tells
/// it of up to 64 at once.
fn ask(scene: &Scene, found: &mut [u64], doubtful: &[u32], straddles: &impl Fn(&[Entity]) -> u64) {
    for slots in doubtful.chunks(64) {
        let mut entities = [Entity::PLACEHOLDER; 64];
        let each = entities.iter_mut().zip(slots);
        each.for_each(|(to, &slot)| *to = Entity::from_bits(scene.user_data(slot)));
        for at in slots_of(0, straddles(&entities[..slots.len()])) {
            let slot = slots[at as usize];
            found[slot as usize / 64] |= 1 << (slot % 64);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers without a rule, from -1 to 1.
    fn numbers() -> impl FnMut() -> f32 {
        let mut state = 1_u64;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) as f32 / (1_u64 << 30) as f32 - 1.0
        }
    }

    #[test]
    fn outside_is_what_f64_calls_so() {
        let mut next = numbers();
        let mut vector = |size: f32| Vec3A::new(next(), next(), next()) * size;
        let mut found = [0; 2];
        for round in 0..200_000 {
            let size = [1e-3, 1.0, 50.0, 1e5][round % 4];
            let axes = [vector(1.0), vector(1.0), vector(1.0)];
            let matrix3 = bevy_math::Mat3A::from_cols(axes[0], axes[1], axes[2]);
            let at = Affine3A { matrix3, translation: vector(size) };
            let mut aabb = bevy_camera::primitives::Aabb {
                center: vector(size * 0.1),
                half_extents: vector(0.5).abs(),
            };
            if round % 97 == 0 {
                aabb.center.x = [f32::NAN, f32::INFINITY][round % 2];
            }
            let planes: [[f32; 4]; 5] = std::array::from_fn(|side| {
                let normal = vector(1.0).normalize();
                let mut d = vector(size).x;
                // Most touch the box, but for roundings.
                if side > 0 {
                    let center = at.transform_point3a(aabb.center);
                    let radius = (at.matrix3.transpose() * normal).abs().dot(aabb.half_extents);
                    d = -(normal.dot(center) + radius);
                    d += d * (side as f32 - 2.0) * f32::EPSILON;
                }
                [normal.x, normal.y, normal.z, d]
            });
            for plane in planes {
                let expected = is_beyond(&plane, &aabb, &at);
                found[usize::from(expected)] += 1;
                assert_eq!(
                    is_outside(&[plane; 5], &aabb, &at),
                    expected,
                    "{plane:?} {aabb:?} {at:?}"
                );
            }
        }
        assert!(found.iter().all(|&count| count > 20_000), "{found:?}");
    }
}
