//! A shadow map: what it shows, and what of that can matter.

use bevy_camera::primitives::{Aabb, Frustum, Sphere};
use bevy_camera::visibility::{NoFrustumCulling, RenderLayers, VisibleEntityRanges};
use bevy_ecs::change_detection::Tick;
use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::prelude::*;
use bevy_math::Vec3A;
use bevy_transform::components::GlobalTransform;
use engine::Simd;
use engine::bounds::Aabb as Bounds;
use engine::cull::frustum::batch::{Planes, classify_boxes};
use engine::cull::frustum::tree::Cut;
use engine::cull::shadow::{CasterRegion, Light};

use crate::bits::slots_of;
use crate::list::Listed;
use crate::mirror::CulletScene;
use crate::receivers::{Eye, HALVINGS};
use crate::seen::{OfMesh, Seen};
use crate::view::region;
use crate::volume::is_near;
use crate::without;

/// Shadow map: what it lists.
#[derive(Debug, Default)]
pub(crate) struct Map {
    /// One bit a slot: the map shows it, whether it matters or not.
    found: Vec<u64>,
    /// Whether `found` holds also what did not matter.
    is_whole: bool,
    listed: Listed,
    known: Option<Known>,
    /// Something that is drawn may receive a shadow by it.
    pub(crate) has_receivers: bool,
    /// Number of the last frame in which it was drawn.
    pub(crate) frame: u64,
}

/// Shadow maps of a light.
#[derive(Debug, Default)]
pub(crate) struct Maps {
    pub(crate) faces: [Map; 6],
    pub(crate) spot: Map,
    pub(crate) cascades: EntityHashMap<Vec<Map>>,
    /// When each of the three lists was written last, by us.
    pub(crate) written: [Option<Tick>; 3],
}

impl Maps {
    pub(crate) fn all(&self) -> impl Iterator<Item = &Map> {
        let lamps = self.faces.iter().chain([&self.spot]);
        lamps.chain(self.cascades.values().flatten())
    }
}

/// Inputs of a list: where they are the same as in the last frame, so is the list.
#[derive(Clone, Debug, PartialEq)]
struct Known {
    scene: [u64; 3],
    receivers: u64,
    without: u64,
    is_foreign: bool,
    view: View,
}

/// Part of space that a shadow map shows.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct View {
    pub(crate) half_spaces: [[f32; 4]; 6],
    /// Whether casters before the near plane count.
    pub(crate) has_near: bool,
    pub(crate) sphere: Option<[f32; 4]>,
    pub(crate) layers: u32,
    pub(crate) light: Light,
    /// How far beside a receiver the map is read, in world units; `None` where nothing may be left
    /// out for want of receivers.
    pub(crate) margin: Option<f64>,
    /// The camera of a cascade.
    pub(crate) eye: Option<Entity>,
}

/// Memory that is used again for each map.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    cut: Cut,
    allowed: Vec<u64>,
    next: Vec<u64>,
}

/// Inputs from which all maps of a frame are found.
pub(crate) struct Frame<'a, 'w, 's> {
    pub(crate) mirror: &'a CulletScene,
    pub(crate) eyes: &'a [Eye<'a>],
    pub(crate) is_foreign: bool,
    pub(crate) receivers: u64,
    pub(crate) without: &'a without::Known,
    pub(crate) boxes: &'a Boxes<'w, 's>,
    pub(crate) all: &'a Query<'w, 's, Seen, OfMesh>,
    pub(crate) ranges: Option<&'a VisibleEntityRanges>,
}

pub(crate) type Boxes<'w, 's> =
    Query<'w, 's, (Option<&'static Aabb>, &'static GlobalTransform, Has<NoFrustumCulling>), OfMesh>;

/// Number of the near half-space, as Bevy counts them.
const NEAR: usize = 4;

/// The half-spaces of a frustum, the far one included.
pub(crate) fn half_spaces(frustum: &Frustum) -> [[f32; 4]; 6] {
    frustum.half_spaces.map(|half_space| half_space.normal_d().to_array())
}

impl View {
    /// Bevy's own test of an entity with a box.
    fn shows(&self, frame: &Frame<'_, '_, '_>, entity: Entity) -> bool {
        let Ok((aabb, at, no_frustum_culling)) = frame.boxes.get(entity) else { return true };
        let (Some(aabb), false) = (aabb, no_frustum_culling) else { return true };
        let at = at.affine();
        let sphere =
            self.sphere.map(|[x, y, z, radius]| Sphere { center: Vec3A::new(x, y, z), radius });
        let center = at.transform_point3a(aabb.center).extend(1.0);
        sphere.is_none_or(|sphere| sphere.intersects_obb(aabb, &at))
            && self.used().all(|half_space| {
                let [x, y, z, _] = *half_space;
                let radius = aabb.relative_radius(&Vec3A::new(x, y, z), &at.matrix3);
                // As Bevy has it: NaN is inside.
                !(bevy_math::Vec4::from_array(*half_space).dot(center) + radius <= 0.0)
            })
    }

    /// The half-spaces that casters are tested against.
    fn used(&self) -> impl Iterator<Item = &[f32; 4]> {
        let all = self.half_spaces.iter().enumerate();
        all.filter(|&(number, _)| self.has_near || number != NEAR).map(|(_, half_space)| half_space)
    }

    /// Whether the light is sure to reach something whose box has this centre.
    fn is_well_within(&self, bounds: impl FnOnce() -> Bounds) -> bool {
        let Some([x, y, z, radius]) = self.sphere.map(|s| s.map(f64::from)) else { return true };
        let [cx, cy, cz] = bounds().center();
        let square = (cx - x).powi(2) + (cy - y).powi(2) + (cz - z).powi(2);
        // The box is one of f32, and a little larger than it was given.
        let within = radius * (1.0 - 1e-4) - (cx.abs() + cy.abs() + cz.abs()) * 1e-6;
        within > 0.0 && square <= within * within
    }

    /// A box around what an eye sees in the map, or beside it as far as it is read.
    fn receivers(
        &self,
        cut: &Cut,
        frame: &Frame<'_, '_, '_>,
        eye: &Eye<'_>,
        margin: f64,
    ) -> Bounds {
        let boxes = frame.mirror.scene.hierarchy().boxes();
        let mut all = Bounds::EMPTY;
        let reach = self.sphere.map(|[x, y, z, radius]| {
            let radius = f64::from(radius) * 1.001 + margin;
            let [min, max] = [-radius, radius].map(|by| [x, y, z].map(|v| f64::from(v) + by));
            Bounds::rounded_out(min, max)
        });
        for word in cut.touched() {
            let seen = eye.seen.get(word).copied().unwrap_or(0);
            for slot in slots_of(word, cut.visible()[word] & seen) {
                let bounds = boxes.get(slot as usize);
                let is_near = self.sphere.is_none_or(|[x, y, z, radius]| {
                    is_near([x, y, z].map(f64::from), f64::from(radius) + margin, &bounds)
                });
                if !is_near {
                    continue;
                }
                // Of a large receiver the part that is shaded may be hidden.
                let part = reach.map_or(bounds, |reach| bounds.intersection(&reach));
                if reach.is_none() || !eye.is_hidden(&part, HALVINGS) {
                    all = all.union(&part);
                }
            }
        }
        all
    }
}

impl Known {
    /// Returns the number of scene steps by which what a map shows is behind; `None` where it is
    /// found anew.
    fn behind(&self, now: &Self) -> Option<u64> {
        let same = self.scene[..2] == now.scene[..2] && self.without == now.without;
        // NaN equals nothing, and so is found anew.
        (same && self.view == now.view).then(|| now.scene[2] - self.scene[2])
    }
}

impl Map {
    pub(crate) fn slots(&self) -> &[u64] {
        &self.listed.seen
    }

    pub(crate) fn entities(&self) -> &[Entity] {
        &self.listed.list
    }

    pub(crate) fn len(&self) -> u32 {
        self.listed.list.len() as u32
    }

    /// Brings the list after what the map shows. Tells whether it changed.
    pub(crate) fn list(
        &mut self,
        scratch: &mut Scratch,
        frame: &Frame<'_, '_, '_>,
        view: View,
        lod_origin: Option<Entity>,
        layers: &RenderLayers,
    ) -> bool {
        let scene = &frame.mirror.scene;
        let now = Known {
            scene: [scene.id(), scene.order_version(), frame.mirror.step],
            receivers: frame.receivers,
            without: frame.without.version,
            is_foreign: frame.is_foreign,
            view,
        };
        if self.known.as_ref() == Some(&now) && frame.mirror.checked.is_empty() {
            return false;
        }
        let Scratch { cut, allowed, next } = scratch;
        self.has_receivers = true;
        let mut kept = None;
        if let Some(margin) = now.view.margin {
            self.has_receivers = allow(cut, allowed, frame, &now.view, margin);
            if self.has_receivers {
                let each = allowed.iter_mut().zip(scene.exempt());
                each.for_each(|(allowed, exempt)| *allowed |= exempt);
            }
            kept = Some(&allowed[..]);
        }
        self.find(cut, frame, &now, kept);
        next.clone_from(&self.found);
        if let Some(kept) = kept {
            next.iter_mut().zip(kept).for_each(|(next, kept)| *next &= kept);
        }
        if self.has_receivers {
            for &entity in &frame.mirror.checked {
                let slot = frame.mirror.handle(entity).and_then(|handle| scene.slot(handle).ok());
                let (Some(slot), Ok(seen)) = (slot, frame.all.get(entity)) else { continue };
                let is_in_range = !seen.ranged
                    || frame.ranges.is_none_or(|ranges| {
                        lod_origin.is_some_and(|o| ranges.entity_is_in_range_of_view(entity, o))
                    });
                if !is_in_range || !layers.intersects(seen.layers.unwrap_or_default()) {
                    next[slot as usize / 64] &= !(1 << (slot % 64));
                }
            }
        }
        let same_order =
            self.known.as_ref().is_some_and(|known| known.scene[..2] == now.scene[..2]);
        self.known = Some(now);
        self.listed.take(frame.mirror, same_order, next)
    }
}

impl Map {
    /// Finds what the map shows, one bit a slot: all, or what changed since it was found. Of a map
    /// that shows something else than in the last frame only what is `kept`: the next frame is
    /// likely to ask anew.
    fn find(
        &mut self,
        cut: &mut Cut,
        frame: &Frame<'_, '_, '_>,
        now: &Known,
        kept: Option<&[u64]>,
    ) {
        let scene = &frame.mirror.scene;
        let hierarchy = scene.hierarchy();
        self.found.resize(hierarchy.present().len(), 0);
        let behind = self.known.as_ref().and_then(|known| known.behind(now));
        let is_whole = std::mem::replace(&mut self.is_whole, kept.is_none() || behind.is_some());
        let behind = behind.filter(|_| is_whole);
        if behind == Some(0) {
            return;
        }
        let used: Vec<[f32; 4]> = now.view.used().copied().collect();
        let planes = Planes::new(&region(&used));
        if behind == Some(1) {
            for word in frame.mirror.touched() {
                let Some(found) = self.found.get_mut(word) else { continue };
                let [mut visible, mut inside] = [[0]; 2];
                let boxes = hierarchy.boxes();
                classify_boxes(Simd::best(), &planes, boxes, word, &mut visible, &mut inside);
                *found = decide(frame, &now.view, word, [visible[0], inside[0], u64::MAX]);
            }
            return;
        }
        let kept = kept.filter(|_| !self.is_whole);
        cut.cull(Simd::best(), &planes, hierarchy.nodes(), hierarchy.boxes());
        for (word, found) in self.found.iter_mut().enumerate() {
            let kept = kept.map_or(u64::MAX, |kept| kept[word]);
            let bits = [cut.visible()[word], cut.inside()[word], kept];
            *found = decide(frame, &now.view, word, bits);
        }
    }
}

/// The slots of a word that a map shows, of those that are kept and whose boxes are visible, or
/// inside all half-spaces.
fn decide(
    frame: &Frame<'_, '_, '_>,
    view: &View,
    word: usize,
    [visible, inside, kept]: [u64; 3],
) -> u64 {
    let scene = &frame.mirror.scene;
    let exempt = scene.exempt()[word];
    let bits = (visible | exempt) & kept & scene.hierarchy().present()[word];
    let doubtful = !inside | exempt;
    let all_shade = frame.without.is_empty();
    let mut found = 0;
    for slot in slots_of(word, bits) {
        let bit = 1 << (slot % 64);
        if scene.layers(slot) & view.layers == 0 {
            continue;
        }
        let is_sure = doubtful & bit == 0
            && view.is_well_within(|| scene.hierarchy().boxes().get(slot as usize));
        if is_sure && all_shade {
            found |= bit;
            continue;
        }
        let entity = Entity::from_bits(scene.user_data(slot));
        if !frame.without.has(entity) && (is_sure || view.shows(frame, entity)) {
            found |= bit;
        }
    }
    found
}

/// Finds where casters can throw a shadow onto something that is drawn, one bit a slot. `false`
/// where there is nothing of the kind.
fn allow(
    cut: &mut Cut,
    allowed: &mut Vec<u64>,
    frame: &Frame<'_, '_, '_>,
    view: &View,
    margin: f64,
) -> bool {
    let hierarchy = frame.mirror.scene.hierarchy();
    let (nodes, boxes) = (hierarchy.nodes(), hierarchy.boxes());
    allowed.clear();
    allowed.resize(hierarchy.present().len(), 0);
    let eyes = || frame.eyes.iter().filter(|eye| view.eye.is_none_or(|own| own == eye.entity));
    let mut found = Vec::new();
    // The map's sides, as far out as it is read.
    let sides: [[f32; 4]; 4] = std::array::from_fn(|i| {
        let [x, y, z, d] = view.half_spaces[i];
        [x, y, z, d + margin as f32 * 1.0001]
    });
    let sides = region(&sides);
    if eyes().any(|eye| eye.is_known && !frame.is_foreign) {
        cut.cull(Simd::best(), &Planes::new(&sides), nodes, boxes);
    }
    for eye in eyes() {
        let receivers =
            (eye.is_known && !frame.is_foreign).then(|| view.receivers(cut, frame, eye, margin));
        let mut seen = eye.region.clone();
        for (_, side) in sides.planes() {
            // One that is refused is one fewer to reject by.
            let _ = seen.push(*side);
        }
        let region = CasterRegion::new(&seen, receivers.as_ref(), &view.light);
        let region = region.with_margin(margin);
        if !region.no_receiver() {
            found.push(Planes::new(region.frustum()));
        }
    }
    for planes in &found {
        cut.cull(Simd::best(), planes, nodes, boxes);
        cut.touched().for_each(|word| allowed[word] |= cut.visible()[word]);
    }
    !found.is_empty()
}
