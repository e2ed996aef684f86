//! What is kept of a camera from frame to frame, and what is told of it.

use bevy_camera::primitives::Frustum;
use bevy_ecs::prelude::*;
use bevy_math::Affine3A;
use engine::Simd;
use engine::bounds::Plane;
use engine::cull::frustum::batch::Planes;
use engine::cull::frustum::tree::Coherent;
use engine::view::Frustum as Region;

use crate::mirror::CulletScene;

/// How many entities with a mesh each stage left, for one camera in one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct CulletFunnel {
    /// All that are culled on the CPU.
    pub entities: u64,
    /// Those that are not outside the frustum, are not hidden by their `Visibility` and share a layer with the camera.
    pub in_frustum: u64,
    /// Those of them that are in their visibility range too: what Bevy itself would list.
    pub in_range: u64,
    /// Those of them that are not behind others: what is drawn.
    pub visible: u64,
}

/// State and results of a camera; required by `Camera`, so that each has one.
#[derive(Component, Debug, Default)]
pub struct CulletView {
    /// Counts of the last frame in which the camera was active.
    pub funnel: CulletFunnel,
    pub(crate) coherent: Coherent,
    /// One bit a slot: seen by the last frame, ranges and occlusion included.
    pub(crate) seen: Vec<u64>,
    pub(crate) next: Vec<u64>,
    /// The entities of `seen`, sorted.
    pub(crate) list: Vec<Entity>,
    /// What `seen` was found from.
    pub(crate) known: Option<Known>,
    pub(crate) scratch: Vec<Entity>,
    pub(crate) hidden: crate::occlusion::Hidden,
}

/// What the answer depends on: where it is the same as in the last frame, so is the answer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Known {
    pub(crate) scene: u64,
    pub(crate) order: u64,
    pub(crate) change: u64,
    pub(crate) planes: Option<[[f32; 4]; 5]>,
    pub(crate) layers: u32,
    /// Matrix and settings of occlusion, where there is some.
    pub(crate) occlusion: Option<([f64; 16], [u32; 2], crate::CulletOcclusion)>,
}

/// The half-spaces that Bevy tests meshes against: all but the far one, which its renderer does not clip at.
pub(crate) fn half_spaces(frustum: &Frustum) -> [[f32; 4]; 5] {
    std::array::from_fn(|i| frustum.half_spaces[i].normal_d().to_array())
}

/// The same region, of planes that point out. One that is not finite rejects nothing.
pub(crate) fn region(half_spaces: &[[f32; 4]; 5]) -> Region {
    let plane = |i: usize| {
        let [x, y, z, d] = half_spaces[i].map(f64::from);
        Plane { normal: [-x, -y, -z], d }
    };
    Region::from_planes(std::array::from_fn(|i| (i < 5).then(|| plane(i))))
}

/// Whether a box of an entity is outside of one of the half-spaces, by more than f32 rounds.
pub(crate) fn is_outside(
    half_spaces: &[[f32; 4]; 5],
    aabb: &bevy_camera::primitives::Aabb,
    at: &Affine3A,
) -> bool {
    let m = at.matrix3.as_dmat3();
    let center = m * aabb.center.as_dvec3() + at.translation.as_dvec3();
    let extents = aabb.half_extents.as_dvec3().abs();
    half_spaces.iter().any(|plane| {
        let [x, y, z, d] = plane.map(f64::from);
        let normal = bevy_math::DVec3::new(x, y, z);
        let radius = (m.transpose() * normal).abs().dot(extents);
        let distance = normal.dot(center) + d;
        // The planes themselves are rounded to f32, and so is what the shader makes of the corners.
        let rounding =
            (normal.abs().dot(center.abs()) + d.abs() + radius) * f64::from(f32::EPSILON);
        distance + radius < -rounding
    })
}

impl CulletView {
    /// Finds what of the scene is in the frustum and the layers, into `next`. `None` for a frustum tests nothing.
    pub(crate) fn find(
        &mut self,
        mirror: &CulletScene,
        half_spaces: Option<&[[f32; 4]; 5]>,
        layers: u32,
        straddles: impl Fn(Entity) -> bool,
    ) {
        let scene = &mirror.scene;
        let hierarchy = scene.hierarchy();
        let present = hierarchy.present();
        self.next.clear();
        self.next.resize(present.len(), 0);
        let next = &mut self.next;
        match half_spaces {
            Some(half_spaces) => {
                let planes = Planes::new(&region(half_spaces));
                let version = hierarchy.change_version();
                let (nodes, boxes) = (hierarchy.nodes(), hierarchy.boxes());
                self.coherent.cull(Simd::best(), &planes, nodes, boxes, version);
                let cut = self.coherent.cut();
                for word in cut.touched() {
                    let visible = cut.visible()[word] & present[word];
                    let mut doubtful = visible & !cut.inside()[word] & !scene.exempt()[word];
                    let mut kept = visible & !doubtful;
                    while doubtful != 0 {
                        let bit = doubtful.trailing_zeros();
                        doubtful &= doubtful - 1;
                        let slot = word as u32 * 64 + bit;
                        let entity = Entity::from_bits(scene.user(slot));
                        kept |= u64::from(straddles(entity)) << bit;
                    }
                    next[word] = kept;
                }
                for (word, next) in next.iter_mut().enumerate() {
                    let exempt = scene.exempt()[word] & present[word];
                    *next &= !exempt;
                    for slot in slots_of(word, exempt) {
                        let keeps = straddles(Entity::from_bits(scene.user(slot)));
                        *next |= u64::from(keeps) << (slot % 64);
                    }
                }
            }
            None => next.copy_from_slice(present),
        }
        for (word, next) in next.iter_mut().enumerate() {
            for slot in slots_of(word, *next) {
                if scene.layers(slot) & layers == 0 {
                    *next &= !(1 << (slot % 64));
                }
            }
        }
        self.funnel.entities = u64::from(scene.instance_count());
        self.funnel.in_frustum = self.count();
    }

    /// How many are in `next`.
    pub(crate) fn count(&self) -> u64 {
        self.next.iter().map(|word| u64::from(word.count_ones())).sum()
    }

    /// Makes `next` what is seen, and brings the list after it: sorted anew where slots were, else by what came and went.
    pub(crate) fn take(&mut self, mirror: &CulletScene, same_order: bool) {
        let entity = |slot| Entity::from_bits(mirror.scene.user(slot));
        if !same_order || self.seen.len() > self.next.len() {
            self.list.clear();
            self.list.extend(slots(&self.next).map(entity));
            self.list.sort_unstable();
            std::mem::swap(&mut self.seen, &mut self.next);
            return;
        }
        self.seen.resize(self.next.len(), 0);
        let mut changed = Vec::new();
        for (word, (old, new)) in self.seen.iter().zip(&self.next).enumerate() {
            let differ = old ^ new;
            changed.extend(slots_of(word, differ).map(entity));
        }
        // An entity is in the old list or among the new ones, never in both: those that are in both lists went.
        changed.sort_unstable();
        merge(&self.list, &changed, &mut self.scratch);
        std::mem::swap(&mut self.list, &mut self.scratch);
        std::mem::swap(&mut self.seen, &mut self.next);
    }
}

/// What is in exactly one of two sorted lists.
fn merge(a: &[Entity], b: &[Entity], out: &mut Vec<Entity>) {
    out.clear();
    out.reserve(a.len() + b.len());
    let mut rest = a;
    for &entity in b {
        let at = rest.partition_point(|&e| e < entity);
        out.extend_from_slice(&rest[..at]);
        rest = &rest[at..];
        if rest.first() == Some(&entity) {
            rest = &rest[1..];
        } else {
            out.push(entity);
        }
    }
    out.extend_from_slice(rest);
}

/// The slots whose bits are set.
pub(crate) fn slots(words: &[u64]) -> impl Iterator<Item = u32> + '_ {
    words.iter().enumerate().flat_map(|(word, &bits)| slots_of(word, bits))
}

fn slots_of(word: usize, mut bits: u64) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        (bits != 0).then(|| {
            let bit = bits.trailing_zeros();
            bits &= bits - 1;
            word as u32 * 64 + bit
        })
    })
}
