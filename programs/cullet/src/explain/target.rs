//! Selection of the instance to explain, by its name or by a pixel, and what lies behind a pixel.

use cullet::{Scene, Stage, View, Visible, draw::TriangleRange};
use cullet_command::console::count;
use cullet_command::exit::Failure;
use cullet_draw::{Frame, PixelId, RenderOptions, Selection};
use cullet_io::Model;
use glam::{DMat4, DVec3, DVec4};

use crate::names::name_of;

/// Names that are offered in place of one that there is not.
const OFFERED: usize = 5;
/// Culled instances that are listed behind a pixel at the most.
const LISTED: usize = 16;

/// The slot of an instance by its name; or `#N`, slot N.
pub(super) fn by_name(model: &Model, name: &str) -> Result<u32, Failure> {
    let scene = &model.scene;
    let found = scene.slots().find(|&slot| name_of(model, slot) == name);
    let by_slot = || {
        let slot: u32 = name.strip_prefix('#')?.trim().parse().ok()?;
        (slot < scene.slot_count() && !scene.is_removed(slot)).then_some(slot)
    };
    found.or_else(by_slot).ok_or_else(|| no_such(model, name))
}

/// The error for a name that there is not, with those that are most like it.
fn no_such(model: &Model, name: &str) -> Failure {
    let scene = &model.scene;
    let all = scene.slots().map(|slot| name_of(model, slot));
    let mut like: Vec<(f64, String)> =
        all.map(|other| (strsim::jaro_winkler(name, &other), other)).collect();
    like.sort_by(|a, b| b.0.total_cmp(&a.0).then_with(|| a.1.cmp(&b.1)));
    let near: Vec<String> = like.iter().take(OFFERED).map(|(_, n)| format!("'{n}'")).collect();
    let instances = count(u64::from(scene.instance_count()), "instance", "instances");
    Failure::usage(format!(
        "--instance '{name}': {} has {instances}, and none of that name; the nearest are {}",
        model.name,
        near.join(", ")
    ))
}

/// Whether a pixel is in a view, or why it is not.
pub(super) fn check_pixel(pixel: [u32; 2], view: &View) -> Result<(), Failure> {
    let [w, h] = view.viewport();
    if pixel[0] < w && pixel[1] < h {
        return Ok(());
    }
    Err(Failure::usage(format!(
        "--pixel {},{}: the view has {w}x{h} pixels, so from 0,0 to {},{}; --size sets that",
        pixel[0],
        pixel[1],
        w - 1,
        h - 1
    )))
}

/// A culled instance behind a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Behind {
    pub(super) slot: u32,
    /// From the eye along the line of sight through the pixel.
    pub(super) distance: f64,
    pub(super) stage: Stage,
}

/// The culled instances of which a triangle would own a pixel if nothing were before it, the
/// nearest first; and whether there are more than are listed. By the reference renderer: the
/// nearest of them is drawn alone with those behind it, and taken away.
pub(super) fn behind(
    scene: &Scene,
    view: &View,
    result: &Visible,
    pixel: [u32; 2],
) -> (Vec<Behind>, bool) {
    let middle = pixel.map(|v| f64::from(v) + 0.5);
    let is_there = |slot: u32| {
        view.project_box(&scene.bounds(slot), scene.origin()).is_none_or(|r| r.contains(middle))
    };
    let stage = |slot: u32| result.reasons.get(slot as usize).copied().flatten().map(|r| r.stage);
    let mut left: Vec<u32> =
        scene.slots().filter(|&slot| stage(slot).is_some() && is_there(slot)).collect();
    let mut found = Vec::new();
    while !left.is_empty() {
        let all = everything_of(scene, &left);
        let frame =
            cullet_draw::render(scene, view, Selection::Visible(&all), &RenderOptions::default());
        let PixelId { slot, .. } = frame.id(pixel[0], pixel[1]);
        let Some(stage) = stage(slot) else { return (found, false) };
        if found.len() == LISTED {
            return (found, true);
        }
        found.push(Behind { slot, distance: distance_of(view, &frame, pixel), stage });
        left.retain(|&other| other != slot);
    }
    (found, false)
}

/// A visible set of all triangles of some instances, which ascend.
pub(super) fn everything_of(scene: &Scene, slots: &[u32]) -> Visible {
    let mut all = Visible::default();
    for &slot in slots {
        let (first, count) = (all.triangles.len() as u32, scene.mesh(slot).triangle_count());
        all.triangles.extend(0..count);
        all.triangle_ranges.push(TriangleRange { slot, level: 0, first, count });
    }
    all
}

/// How far from the eye the surface of a pixel is; along the line of sight from the near plane for
/// parallel ones.
pub(super) fn distance_of(view: &View, frame: &Frame, [x, y]: [u32; 2]) -> f64 {
    let [w, h] = [frame.width, frame.height].map(f64::from);
    let ndc = [(f64::from(x) + 0.5) * 2.0 / w - 1.0, 1.0 - (f64::from(y) + 0.5) * 2.0 / h];
    let depth = frame.depth[(y * frame.width + x) as usize];
    let inverse = DMat4::from_cols_array(&view.world_from_clip());
    let p = inverse * DVec4::new(ndc[0], ndc[1], depth, 1.0);
    let p = p.truncate() / p.w;
    let eye = DVec4::from(view.eye());
    if eye.w != 0.0 {
        return p.distance(eye.truncate() / eye.w);
    }
    let origin = view.ray([f64::from(x) + 0.5, f64::from(y) + 0.5]).map(|ray| ray.origin);
    origin.map_or(f64::NAN, |origin| p.distance(DVec3::from(origin)))
}
