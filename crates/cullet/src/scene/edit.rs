//! Adding, moving and removing instances, and what follows for their slots.

use super::{BoundsOverride, Instance, InstanceFlags, Scene, SceneError};
use crate::array::{self, Each};
use crate::bits;
use crate::bounds::{Aabb, Boxes};
use crate::hierarchy::Handle;
use crate::mesh::Mesh;
use crate::transform::Transform;

impl Scene {
    /// Adds an instance, in a new slot.
    ///
    /// # Errors
    /// If the mesh does not exist (any more) or the scene is full.
    pub fn add(&mut self, mut instance: Instance) -> Result<Handle, SceneError> {
        if instance.has_no_mesh() {
            let known = self.no_mesh;
            instance.mesh = known.unwrap_or_else(|| self.add_mesh(Mesh::default()));
            self.no_mesh = Some(instance.mesh);
        }
        self.find_mesh(instance.mesh)?;
        let handle = self.hierarchy.insert(&Aabb::EMPTY)?;
        self.mesh.push(instance.mesh);
        self.transforms.push(instance.transform);
        self.layers.push(instance.layers);
        self.flags.push(instance.flags);
        self.overrides.push(instance.bounds);
        self.size_weights.push(instance.size_weight);
        self.user_data.push(instance.user_data);
        self.tallies.add(self.mesh.len() - 1, instance.mesh, instance.layers);
        self.exempt.resize(self.mesh.len().div_ceil(64), 0);
        self.exempt_words.resize(self.exempt.len().div_ceil(64), 0);
        self.collapsed.resize(self.mesh.len().div_ceil(64), 0);
        self.update_slot(self.slot_count() - 1);
        self.change += 1;
        Ok(handle)
    }

    /// Removes an instance. Its slot stays empty until [`commit`](Self::commit).
    ///
    /// # Errors
    /// If the handle names no instance.
    pub fn remove(&mut self, handle: Handle) -> Result<(), SceneError> {
        let slot = self.slot(handle)?;
        self.hierarchy.remove(handle)?;
        let at = slot as usize;
        self.leave_stand_ins(slot);
        // Those that stand for others are in no count of layers.
        let layers = (!self.is_stand_in(slot)).then_some(self.layers[at]);
        self.tallies.remove(at, self.mesh[at], layers);
        self.layers[slot as usize] = 0;
        self.flags.set(at, InstanceFlags::default());
        bits::set(&mut self.exempt, slot as usize, false);
        bits::set(&mut self.collapsed, slot as usize, false);
        self.change += 1;
        Ok(())
    }

    /// Moves an instance.
    ///
    /// # Errors
    /// If the handle names no instance.
    pub fn set_transform(
        &mut self,
        handle: Handle,
        transform: Transform,
    ) -> Result<(), SceneError> {
        let slot = self.slot(handle)?;
        self.transforms[slot as usize] = transform;
        self.leave_stand_ins(slot);
        self.update_slot(slot);
        self.change += 1;
        Ok(())
    }

    /// Sets the layers of an instance.
    ///
    /// # Errors
    /// If the handle names no instance, or one that [stands for others](Self::stand_for): that is
    /// in no layer, and drawn in those of the others.
    pub fn set_layers(&mut self, handle: Handle, layers: u32) -> Result<(), SceneError> {
        let slot = self.slot(handle)?;
        let at = slot as usize;
        if self.is_stand_in(slot) {
            return Err(SceneError::StandIn(handle));
        }
        self.leave_stand_ins(slot);
        self.tallies.change_layers(self.mesh[at], self.layers[at], layers);
        self.layers[at] = layers;
        self.change += 1;
        Ok(())
    }

    /// Sets the flags of an instance.
    ///
    /// # Errors
    /// If the handle names no instance.
    pub fn set_flags(&mut self, handle: Handle, flags: InstanceFlags) -> Result<(), SceneError> {
        let slot = self.slot(handle)?;
        self.flags.set(slot as usize, flags);
        self.leave_stand_ins(slot);
        self.update_slot(slot);
        self.change += 1;
        Ok(())
    }

    /// Sets by how much the size of an instance counts; see [`Instance::size_weight`]. It changes
    /// nothing of how the instance looks, so what [stands for it](Self::stand_for) stays.
    ///
    /// # Errors
    /// If the handle names no instance.
    pub fn set_size_weight(&mut self, handle: Handle, weight: f32) -> Result<(), SceneError> {
        let slot = self.slot(handle)?;
        self.size_weights.set(slot as usize, weight);
        self.change += 1;
        Ok(())
    }

    /// Gives an instance bounds of the caller's.
    ///
    /// # Errors
    /// If the handle names no instance.
    pub fn set_bounds(&mut self, handle: Handle, bounds: BoundsOverride) -> Result<(), SceneError> {
        let slot = self.slot(handle)?;
        self.overrides.set(slot as usize, bounds);
        self.leave_stand_ins(slot);
        self.update_slot(slot);
        self.change += 1;
        Ok(())
    }

    /// Writes bounds in world space of many instances straight to their slots: for what the caller
    /// moves by means of its own (see [`BoundsOverride::World`]). Fits the nodes above them when
    /// `write` returns. The cost is that of what was written, and at most O(n), once through all
    /// nodes. The first bounds that a scene is given make room for those of all slots: 28 bytes
    /// each.
    pub fn write_bounds(&mut self, write: impl FnOnce(&mut SceneBoundsMut<'_>)) {
        // A guard that the caller owned could be leaked, which would leave nodes that do not hold
        // their boxes. This one is dropped even if `write` panics.
        write(&mut SceneBoundsMut { scene: self });
    }

    /// Moves the origin, and with it the point around which f32 bounds are finest. O(instances).
    /// World-space override boxes are relative to the origin, so they are shifted, and grow by
    /// their rounding.
    pub fn rebase(&mut self, origin: [f64; 3]) {
        let shift: [f64; 3] = array::from_fn(|a| self.origin[a] - origin[a]);
        for o in self.overrides.each_mut() {
            if let BoundsOverride::World(b) = o {
                let moved = |v: [f32; 3]| array::from_fn(|a| f64::from(v[a]) + shift[a]);
                *b = Aabb::rounded_out(moved(b.min), moved(b.max));
            }
        }
        self.origin = origin;
        // No instance moves, though all have other bounds.
        (0..self.slot_count()).for_each(|slot| self.derive_slot(slot));
        self.log_all();
        self.hierarchy.refit();
        self.change += 1;
    }

    pub(super) fn world_box(&self, slot: usize) -> Aabb {
        let transform = &self.transforms[slot];
        let mesh = || {
            let b = self.meshes[self.mesh[slot] as usize].bounds();
            // A mesh without a drawable triangle is somewhere all the same: at its own origin.
            let b = if b.is_empty() { Aabb::new([0.0; 3], [0.0; 3]) } else { b };
            transform.transform_box(&b, self.origin)
        };
        let b = match self.overrides.get(slot) {
            _ if !transform.is_finite() => Aabb::EVERYTHING,
            BoundsOverride::None => Aabb::EVERYTHING,
            BoundsOverride::Mesh => mesh(),
            BoundsOverride::World(b) => b,
            BoundsOverride::Margin(m) if m.is_nan() => Aabb::EVERYTHING,
            BoundsOverride::Margin(m) => {
                let b = mesh();
                // A box that shrinks would no longer hold its mesh.
                let m = f64::from(m.max(0.0));
                let grow = |v: [f32; 3], by: f64| v.each(|v| f64::from(v) + by);
                Aabb::rounded_out(grow(b.min, -m), grow(b.max, m))
            }
        };
        // What culling takes for the whole of space is that for everyone who asks.
        let beyond = |v: f32| v.abs() >= Boxes::LIMIT;
        if b.min.iter().chain(&b.max).any(|&v| beyond(v)) && !b.is_empty() {
            return Aabb::EVERYTHING;
        }
        b
    }

    /// Recomputes what is derived from a slot's transform, flags and override.
    pub(super) fn update_slot(&mut self, slot: u32) {
        self.log_moved(slot);
        self.derive_slot(slot);
    }

    fn derive_slot(&mut self, slot: u32) {
        if self.is_removed(slot) {
            return;
        }
        let at = slot as usize;
        let b = self.world_box(at);
        self.hierarchy.set_slot(at, &self.box_to_find(at));
        let finite = self.transforms[at].is_finite();
        let no_bounds = self.overrides.get(at) == BoundsOverride::None || !b.is_finite();
        let exempt = self.flags.get(at).always_visible || no_bounds || !finite;
        bits::set(&mut self.exempt, at, exempt);
        if exempt {
            bits::set(&mut self.exempt_words, at / 64, true);
        }
        let flat = finite && self.transforms[at].rank() <= 1 && self.is_rigid(slot);
        // Of an instance of bounds alone the engine does not know what is drawn.
        let has_mesh = self.no_mesh != Some(self.mesh[at]);
        let nothing = has_mesh && self.mesh(slot).clusters().is_empty();
        bits::set(&mut self.collapsed, at, flat || nothing);
    }
}

/// The bounds of a scene while [`Scene::write_bounds`] runs.
#[derive(Debug)]
pub struct SceneBoundsMut<'a> {
    scene: &'a mut Scene,
}

impl SceneBoundsMut<'_> {
    /// Gives the instance of a slot this box, relative to the scene's origin, in place of its
    /// mesh's. An empty slot stays empty.
    ///
    /// # Panics
    /// If there is no such slot.
    #[inline]
    pub fn set(&mut self, slot: u32, bounds: &Aabb) {
        let scene = &mut *self.scene;
        let at = slot as usize;
        let known = matches!(scene.overrides.get(at), BoundsOverride::World(_));
        scene.overrides.set(at, BoundsOverride::World(*bounds));
        scene.leave_stand_ins(slot);
        let is_present = bits::get(scene.hierarchy.present(), at);
        if !is_present || scene.is_stand_in(slot) {
            return;
        }
        // Neither exempt, whatever its flags, nor collapsed, if it was not: that is worked out
        // once. Bits of many slots lie in one line of the cache, so that this reads nothing else of
        // a slot that the cache may not have.
        if known && bounds.is_finite() && !bits::get(&scene.exempt, at) {
            scene.hierarchy.write(at, bounds);
            scene.log_moved(slot);
        } else {
            scene.update_slot(slot);
        }
    }
}

impl Drop for SceneBoundsMut<'_> {
    fn drop(&mut self) {
        self.scene.hierarchy.refit_written();
        self.scene.change += 1;
    }
}
