//! Why a camera draws a node or not, in words.

use std::fmt::Write as _;

use cullet::explain::{Evidence, Explanation, PlaneTest};
use cullet::scene::BoundsOverride;
use cullet::view::FrustumPlane;
use cullet::{Culler, Stage};
use godot::classes::{Camera3D, Node3D};
use godot::obj::InstanceId;
use godot::prelude::*;

use crate::frame::culler;
use crate::item::Item;
use crate::look::{Bounds, Casts, Kind};
use crate::mirror::{Mirror, item_and_part, world_box};
use crate::registry::Registry;
use crate::shown::Shown;
use crate::views::{self, Eye};
use crate::world::CulletWorld;

/// Names of nodes beyond this number are only counted.
const MOST_NAMES: usize = 4;

#[godot_api(secondary)]
impl CulletWorld {
    /// Says in plain English why `camera` draws `node` or not: the first of layers, frustum and
    /// occlusion that leaves it out, with its numbers and the nodes that hide it; then whether the
    /// node hides others. It is worked out from the scene as the last frame had it, for a cull of
    /// the whole scene. A camera that drew nothing in it counts with the size of its viewport.
    #[func]
    fn explain(&mut self, camera: Gd<Camera3D>, node: Gd<Node3D>) -> GString {
        let Some(eye) = self.eye_of(&camera) else {
            return format!("{} shows no volume, so that all is drawn.", camera.get_name())
                .as_str()
                .into();
        };
        let settings = self.settings();
        let item = self.mirror().index(node.instance_id()).and_then(|i| self.mirror().item(i));
        let shown = item.map_or(Shown::Whole, |item| item.shown);
        let text = text(self.registry(), &culler(settings.occlusion), &eye, &node, shown);
        text.as_str().into()
    }

    /// The nodes that hide `node` from `camera`, the nearest first; none where it is not hidden by
    /// others. It costs a cull of the whole scene.
    #[func]
    fn hidden_by(&mut self, camera: Gd<Camera3D>, node: Gd<Node3D>) -> Array<Gd<Node3D>> {
        let Some(eye) = self.eye_of(&camera) else { return Array::new() };
        let culler = culler(self.settings().occlusion);
        hiders(self.registry(), &culler, &eye, node.instance_id())
    }
}

impl CulletWorld {
    /// Returns what a camera showed in the last frame, or would show now.
    fn eye_of(&mut self, camera: &Gd<Camera3D>) -> Option<Eye> {
        let id = camera.instance_id();
        let drew = self.frame().answers().find(|(eye, _)| eye.camera == id);
        if let Some((eye, _)) = drew {
            return Some(eye.clone());
        }
        self.up_to_date()?;
        views::of_size(camera, views::pixels(&camera.get_viewport()?))
    }
}

/// Returns the nodes that hide a node in a view, the nearest first and each once.
pub(crate) fn hiders(
    registry: &Registry,
    culler: &Culler,
    eye: &Eye,
    node: InstanceId,
) -> Array<Gd<Node3D>> {
    let mut nodes = Array::new();
    if let Some(explanation) = explanation(registry, culler, eye, node) {
        of_slots(&registry.mirror, &explanation.hidden_by).iter().for_each(|node| nodes.push(node));
    }
    nodes
}

/// Returns why a node is drawn or not in a view; `shown` says how it is drawn in all.
pub(crate) fn text(
    registry: &Registry,
    culler: &Culler,
    eye: &Eye,
    node: &Gd<Node3D>,
    shown: Shown,
) -> String {
    let (mirror, name) = (&registry.mirror, node.get_name());
    let Some(item) = mirror.index(node.instance_id()).and_then(|index| mirror.item(index)) else {
        return format!(
            "{name} is left to Godot: only nodes that draw, in the world of this CulletWorld, are culled."
        );
    };
    let explained = explanation(registry, culler, eye, node.instance_id());
    let mut text = match (&explained, item.kind) {
        (_, Kind::Grid) => {
            format!("{name} is drawn always: the cells of a GridMap cannot be hidden.")
        }
        (None, _) => format!("{name} is drawn always."),
        (Some(explanation), _) => headline(mirror, item, explanation),
    };
    if shown == Shown::ShadowOnly {
        text.push_str("\nIt stays in shadow maps, for its shadow may be seen.");
    }
    text.push('\n');
    text.push_str(hiding(mirror, item));
    text
}

fn explanation(
    registry: &Registry,
    culler: &Culler,
    eye: &Eye,
    node: InstanceId,
) -> Option<Explanation> {
    let (mirror, view) = (&registry.mirror, &eye.view);
    let handle = mirror.item(mirror.index(node)?)?.handle?;
    let explained = match registry.pvs.mask_once(view, mirror) {
        Some(mask) => culler.explain_among(&mirror.scene, view, &mask, &[handle]).ok()?.pop(),
        None => culler.explain(&mirror.scene, view, handle).ok(),
    };
    explained
}

/// Returns the first sentences: whether the node is drawn, and why.
fn headline(mirror: &Mirror, item: &Item, explanation: &Explanation) -> String {
    let name = item.node.get_name();
    let Some(reason) = explanation.reason else { return drawn(item, explanation) };
    let mut text = format!("{name} is not drawn: ");
    let _ = match reason.stage {
        Stage::Layer if !item.is_visible => {
            write!(text, "its own `visible`, or that of a node above it, is off.")
        }
        Stage::Layer => write!(text, "it shares no layer with the camera's cull mask."),
        Stage::Frustum => write!(text, "{}.", outside(explanation)),
        Stage::Occlusion => {
            let by = of_slots(mirror, &explanation.hidden_by);
            write!(text, "it lies behind {}.", names(&by))
        }
        Stage::Pvs => {
            write!(text, "the baked sets say that it cannot be seen from where the camera is.")
        }
        stage => write!(text, "the stage `{}` left it out.", stage.name()),
    };
    text
}

/// Says why a node is drawn: what did not leave it out.
fn drawn(item: &Item, explanation: &Explanation) -> String {
    let name = item.node.get_name();
    if item.look.bounds == Bounds::Unknown {
        return format!("{name} is drawn always: {}.", why_unknown(item));
    }
    if matches!(world_box(item), BoundsOverride::None) && item.mesh.is_none() {
        return format!("{name} is drawn always: its place or its bounds are not finite.");
    }
    let mut text = format!("{name} is drawn: its bounds reach into the camera's picture");
    let of = |stage| explanation.steps.iter().find(|step| step.stage == stage);
    let _ = match of(Stage::Occlusion).map(|step| &step.evidence) {
        Some(Evidence::Cover(cover)) => {
            let [w, h] = [0, 1].map(|a| cover.max[a].saturating_sub(cover.min[a]) + 1);
            let at = cover.open.map(|pixel| {
                let of =
                    |a: usize| 100.0 * (f64::from(pixel[a]) + 0.5) / f64::from(cover.buffer[a]);
                format!(
                    " First such place: {:.0} % from the left, {:.0} % from the top.",
                    of(0),
                    of(1)
                )
            });
            write!(
                text,
                ", and the nodes that hide others do not cover all of them, {w} × {h} pixels of the \
                 occlusion buffer of {} × {}.{}",
                cover.buffer[0],
                cover.buffer[1],
                at.unwrap_or_default()
            )
        }
        Some(Evidence::NearPlane) => {
            write!(text, ", and begin before its near plane, so that nothing can be in front.")
        }
        Some(Evidence::Cost) => {
            write!(
                text,
                "; whether others hide it was not tested, for that would cost more than it saves."
            )
        }
        _ => write!(text, "; nothing was tested to hide it."),
    };
    text
}

/// Says on which side of the picture a node lies: behind the camera, or else the side that it is
/// farthest from.
fn outside(explanation: &Explanation) -> String {
    let near = FrustumPlane::Near as u8;
    let steps = explanation.steps.iter().filter(|step| step.stage == Stage::Frustum);
    let tests = steps.filter_map(|step| match &step.evidence {
        Evidence::Planes(tests) => Some(tests),
        _ => None,
    });
    let outside = tests.flatten().filter(|test| test.nearest > 0.0);
    let rank = |test: &PlaneTest| (test.plane == near, test.nearest);
    let farthest = outside.max_by(|a, b| {
        let ((a, far), (b, from)) = (rank(a), rank(b));
        a.cmp(&b).then(far.total_cmp(&from))
    });
    let Some(test) = farthest else { return "it lies outside of the camera's picture".to_owned() };
    let by = round(test.nearest);
    match FrustumPlane::ALL.get(usize::from(test.plane)) {
        Some(FrustumPlane::Near) => format!("it lies {by} units behind the camera's near plane"),
        Some(FrustumPlane::Far) => format!("it lies {by} units beyond the camera's far distance"),
        Some(side) => format!("it lies {by} units outside of the picture's {} side", side.name()),
        None => format!("it lies {by} units outside of the camera's picture"),
    }
}

/// Returns a length in three digits or so.
fn round(length: f64) -> String {
    let digits = if length < 1.0 {
        3
    } else if length < 100.0 {
        1
    } else {
        0
    };
    format!("{length:.digits$}")
}

/// Says why a node has no bounds.
fn why_unknown(item: &Item) -> &'static str {
    let is_told = item.drawn.as_ref().is_some_and(|d| d.node.is_ignoring_occlusion_culling());
    match item.kind {
        _ if is_told => "its `ignore_occlusion_culling` is on",
        Kind::Other => "particles, soft bodies and geometry of other extensions are never hidden",
        _ => {
            "a material of it is drawn through walls, or its vertices move and it has no custom box"
        }
    }
}

/// Says whether a node hides others.
fn hiding(mirror: &Mirror, item: &Item) -> &'static str {
    if item.mesh.is_some() || !item.parts.is_empty() {
        return "It hides what lies behind it.";
    }
    if item.is_waiting {
        return "It will hide what lies behind it: its occluder is being made.";
    }
    let node = item.drawn.as_ref().map(|drawn| &drawn.node);
    match item.look.hides {
        Some(_) => "It hides nothing: it is mirrored, or its mesh has no use as an occluder.",
        None if mirror.marks.of(&item.node).never_hides => {
            "It hides nothing: a NoCulletOccluder says so."
        }
        None if item.look.casts == Casts::Only => {
            "It hides nothing: it is drawn into shadow maps alone."
        }
        None if node.is_some_and(|n| n.get_transparency() > 0.0) => {
            "It hides nothing: it has transparency."
        }
        None if node.is_some_and(|n| n.get_visibility_range_end() > 0.0) => {
            "It hides nothing: it has a visibility range."
        }
        None => {
            "It hides nothing: its material is not opaque or is a shader, its vertices move, or it has \
             no mesh of triangles. A CulletOccluder below it says that it does hide."
        }
    }
}

/// Returns the nodes of slots, each once, in the order of the slots.
fn of_slots(mirror: &Mirror, slots: &[u32]) -> Vec<Gd<Node3D>> {
    let mut nodes: Vec<Gd<Node3D>> = Vec::new();
    for &slot in slots {
        let (index, _) = item_and_part(mirror.scene.user_data(slot));
        if let Some(item) = mirror.item(index)
            && item.node.is_instance_valid()
            && !nodes.contains(&item.node)
        {
            nodes.push(item.node.clone());
        }
    }
    nodes
}

/// Returns names as a list in a sentence.
fn names(nodes: &[Gd<Node3D>]) -> String {
    let all: Vec<String> =
        nodes.iter().take(MOST_NAMES).map(|n| n.get_name().to_string()).collect();
    let more = nodes.len().saturating_sub(MOST_NAMES);
    match (all.as_slice(), more) {
        ([], _) => "other nodes".to_owned(),
        ([one], 0) => one.clone(),
        ([most @ .., last], 0) => format!("{} and {last}", most.join(", ")),
        (all, more) => format!("{} and {more} more", all.join(", ")),
    }
}
