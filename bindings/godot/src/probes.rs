//! Reflection probes: they draw the scene too, at a time of Godot's choosing, so that what is in
//! their reach is not hidden.

use cullet::View;
use godot::classes::ReflectionProbe;
use godot::prelude::*;

use crate::convert;
use crate::views;

/// Collects a view of what each visible probe reaches. Returns false if the reach of one is
/// unknown.
///
/// Godot draws six pictures from the probe's origin, each a right angle wide and as deep as its
/// largest distance, so that they fill a cube. A probe that draws once does so when it first comes
/// into sight, when it is moved, and when it lost its place in the atlas to another: nothing tells
/// when, so that its reach is kept as well.
pub(crate) fn collect(probes: &[Gd<ReflectionProbe>], world: Rid, reach: &mut Vec<View>) -> bool {
    reach.clear();
    let mut is_known = true;
    for probe in probes {
        let own = probe.get_world_3d().map(|world| world.get_scenario());
        if own != Some(world) || !probe.is_visible_in_tree() {
            continue;
        }
        let offset = convert::point(probe.get_origin_offset());
        let size = convert::point(probe.get_size());
        let sides = (0..3).map(|a| size[a].abs() * 0.5 + offset[a].abs());
        let half = sides.fold(f64::from(probe.get_max_distance()), f64::max);
        let at = probe.get_global_transform().translated_local(probe.get_origin_offset());
        match views::of_box(&at, [half; 3], probe.get_cull_mask()) {
            Some(view) => reach.push(view),
            None => is_known = false,
        }
    }
    is_known
}
