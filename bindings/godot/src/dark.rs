//! Lamps that light nothing a camera sees are hidden.
//!
//! Only lamps without shadows: Godot assigns the places of shadow maps in its atlas by which lamps are in
//! a picture, so that a hidden lamp would change the shadows of the others.

use std::collections::HashMap;

use cullet::bounds::Aabb;
use cullet::scene::BoundsOverride;
use godot::classes::{Light3D, OmniLight3D, RenderingServer, SpotLight3D};
use godot::obj::{InstanceId, Singleton};
use godot::prelude::*;

use crate::lights;
use crate::mirror::{self, Mirror};
use crate::told;

/// Lamps beyond this number are all drawn: testing each takes longer than it saves.
const MOST_LAMPS: usize = 256;
/// Pairs of a lamp and a seen node beyond this number: all lamps are drawn.
const MOST_PAIRS: usize = 200_000;

/// Hidden lamps of one world.
#[derive(Debug, Default)]
pub(crate) struct Dark {
    hidden: HashMap<InstanceId, Gd<Light3D>>,
    lamps: Vec<(Gd<Light3D>, Option<Aabb>)>,
    receivers: Vec<Aabb>,
}

impl Dark {
    /// Returns the number of hidden lamps.
    pub(crate) fn len(&self) -> usize {
        self.hidden.len()
    }

    /// Shows all lamps.
    pub(crate) fn give_back(&mut self) {
        self.hidden.drain().for_each(|(_, lamp)| show(lamp));
    }

    /// Hides the lamps of `lights` whose reach holds no node of `seen`, and shows the others.
    pub(crate) fn update(
        &mut self,
        lights: &[Gd<Light3D>],
        world: Rid,
        mirror: &Mirror,
        seen: &[u64],
    ) {
        let dark = self.find(lights, world, mirror, seen);
        let mut before = std::mem::take(&mut self.hidden);
        for lamp in dark {
            let id = lamp.instance_id();
            if before.remove(&id).is_none() {
                RenderingServer::singleton().instance_set_layer_mask(lamp.get_instance(), 0);
            }
            self.hidden.insert(id, lamp);
        }
        before.into_values().for_each(show);
    }

    /// Returns the lamps of `lights` whose reach holds no node of `seen`; none where there are too
    /// many to tell.
    pub(crate) fn find(
        &mut self,
        lights: &[Gd<Light3D>],
        world: Rid,
        mirror: &Mirror,
        seen: &[u64],
    ) -> Vec<Gd<Light3D>> {
        self.collect(lights, world, mirror.is_interpolated);
        if self.lamps.is_empty() || self.lamps.len() > MOST_LAMPS {
            return Vec::new();
        }
        let most = MOST_PAIRS / self.lamps.len();
        if !receivers(mirror, seen, most, &mut self.receivers) {
            return Vec::new();
        }
        let receivers = &self.receivers;
        let is_dark = |reach: Aabb| !receivers.iter().any(|b| touch(b, &reach));
        let lamps = self.lamps.drain(..).filter(|(_, reach)| reach.is_some_and(is_dark));
        lamps.map(|(lamp, _)| lamp).collect()
    }

    fn collect(&mut self, lights: &[Gd<Light3D>], world: Rid, is_interpolated: bool) {
        self.lamps.clear();
        for light in lights {
            let is_lamp = light.clone().try_cast::<OmniLight3D>().is_ok()
                || light.clone().try_cast::<SpotLight3D>().is_ok();
            if !is_lamp || light.has_shadow() || !light.is_visible_in_tree() {
                continue;
            }
            if light.get_world_3d().map(|own| own.get_scenario()) != Some(world) {
                continue;
            }
            let at = if is_interpolated {
                light.clone().get_global_transform_interpolated()
            } else {
                light.get_global_transform()
            };
            self.lamps.push((light.clone(), lights::reach(light, &at)));
        }
    }
}

/// Collects the bounds of the nodes of `seen`. Returns false if one is unknown, or there are more than
/// `most`.
fn receivers(mirror: &Mirror, seen: &[u64], most: usize, boxes: &mut Vec<Aabb>) -> bool {
    boxes.clear();
    let mut is_known = true;
    for (word, (&seen, &here)) in seen.iter().zip(&mirror.told.here).enumerate() {
        told::each(word, seen & here, |index| {
            let Some(item) = mirror.item(index).filter(|item| item.is_visible) else { return };
            match mirror::world_box(item) {
                BoundsOverride::World(bounds) => boxes.push(bounds),
                _ => is_known = false,
            }
        });
        if !is_known || boxes.len() > most {
            return false;
        }
    }
    true
}

/// Gives a lamp back to Godot, with the layers that it says itself.
fn show(lamp: Gd<Light3D>) {
    if lamp.is_instance_valid() {
        let layers = lamp.get_layer_mask();
        RenderingServer::singleton().instance_set_layer_mask(lamp.get_instance(), layers);
    }
}

fn touch(a: &Aabb, b: &Aabb) -> bool {
    let ([ca, cb], [ha, hb]) = ([a.center(), b.center()], [a.half_extent(), b.half_extent()]);
    // A little more, for the rounding of centres.
    (0..3).all(|i| {
        let slack = (ca[i].abs() + cb[i].abs() + ha[i] + hb[i]) * 1e-9;
        (ca[i] - cb[i]).abs() <= ha[i] + hb[i] + slack
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_that_share_a_side_touch() {
        let a = Aabb::rounded_out([0.0; 3], [1.0; 3]);
        let beside = |x: f64| Aabb::rounded_out([x, 0.0, 0.0], [x + 1.0, 1.0, 1.0]);
        assert!(touch(&a, &beside(1.0)) && touch(&a, &beside(-1.0)) && touch(&a, &a));
        assert!(!touch(&a, &beside(1.01)) && !touch(&a, &beside(-2.01)));
    }
}
