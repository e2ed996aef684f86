//! The connected regions of a model that face away from an eye.

use cullet::cull::backface::ObjectEye;
use cullet::mesh::{Part, Regions};
use cullet::{Instance, Mesh, MeshData, Scene, View};
use glam::DVec3;

use super::surface::{ball_around, colored, whole};
use super::{BACK, KEPT};
use cullet_draw::Picture;
use cullet_draw::PixelId;
use cullet_draw::caption;
use cullet_draw::palette::NEIGHBOURS;
use cullet_draw::picture::canvas::grouped;
use cullet_draw::picture::palette::{INK, mix};
use cullet_draw::picture::space::Space;

/// How much of a region shows through what is before it.
const THROUGH: f64 = 0.5;
/// Colours of all regions but the largest.
const REST: [[u8; 3]; 6] =
    [NEIGHBOURS[0], NEIGHBOURS[1], NEIGHBOURS[2], NEIGHBOURS[5], NEIGHBOURS[3], NEIGHBOURS[4]];

/// The connected regions of the scene that face away from the eye of `view`, and how many there
/// are. Of each instance, [`crate::methods::back_regions`] decides; its largest region is pink, the
/// others have six colours in turn.
///
/// The scene is seen from beside, so that the eye of `view` is on the left, where an arrow shows
/// its direction of sight; the rest of the surface is pale, and what faces away shines through it.
/// Cost: two frames at twice the size, and a copy of what faces away.
#[must_use]
pub fn back_regions(scene: &Scene, view: &View) -> (Picture, usize) {
    let regions: Vec<Regions> = scene
        .slots()
        .map(|slot| {
            let mesh = scene.mesh(slot);
            let eye = ObjectEye::of_view(view, scene.transform(slot));
            crate::methods::back_regions(&eye, mesh.positions(), mesh.indices())
        })
        .collect();
    let count: usize = regions.iter().map(Regions::count).sum();
    let toward = towards_eye_of(scene, view);
    let beside = whole(scene, beside(toward), view.viewport());
    let beside = beside.unwrap_or_else(|| view.clone());

    let mut tints = vec![Vec::new(); scene.slot_count() as usize];
    for (slot, regions) in scene.slots().zip(&regions) {
        tints[slot as usize] = tints_of(regions);
    }
    let (mut picture, frame) = colored(scene, &beside, &|slot, t| tint(&tints, slot, t));
    let (backs, back_tints) = backs(scene, &regions);
    let (lit, back) = colored(&backs, &beside, &|slot, t| tint(&back_tints, slot, t));
    let space = Space::new(&beside);
    for at in 0..frame.ids.len().min(back.ids.len()) {
        let hidden = space.nearer(frame.depth[at], back.depth[at]);
        if back.ids[at] != PixelId::NONE && hidden {
            let (x, y) = (at as u32 % frame.width, at as u32 / frame.width);
            let seen = mix(picture.pixel(x, y), lit.pixel(x, y), THROUGH);
            picture.blend(i64::from(x), i64::from(y), seen, 1.0);
        }
    }
    let mut picture = picture.halved();
    arrow(&mut picture, scene, &space, toward);
    let noun = if count == 1 { "region faces" } else { "regions face" };
    caption(&mut picture, &format!("{} connected {noun} away", grouped(count as u64)));
    (picture, count)
}

/// A colour for each triangle.
fn tints_of(regions: &Regions) -> Vec<[u8; 3]> {
    let count = regions.count();
    let largest = (0..count).max_by_key(|&n| (regions.triangles[n], count - n));
    let tint = |n: u32| match n {
        Regions::NONE => KEPT,
        n if largest == Some(n as usize) => BACK,
        n => REST[n as usize % REST.len()],
    };
    regions.of.iter().map(|n| tint(*n)).collect()
}

fn tint(of_slots: &[Vec<[u8; 3]>], slot: u32, t: u32) -> [u8; 3] {
    of_slots.get(slot as usize).and_then(|of| of.get(t as usize)).copied().unwrap_or(KEPT)
}

/// Back faces as a scene of their own, with the colours of its triangles by slot.
fn backs(scene: &Scene, regions: &[Regions]) -> (Scene, Vec<Vec<[u8; 3]>>) {
    let mut backs = Scene::new();
    let mut made = Vec::new();
    for (slot, regions) in scene.slots().zip(regions) {
        let mesh = scene.mesh(slot);
        let triangles = mesh.indices().as_chunks::<3>().0.iter();
        let kept = triangles.zip(tints_of(regions)).zip(&regions.of);
        let (indices, tints): (Vec<[u32; 3]>, Vec<[u8; 3]>) =
            kept.filter(|(_, n)| **n != Regions::NONE).map(|((t, tint), _)| (*t, tint)).unzip();
        let part = Part { triangle_count: tints.len() as u32, ..Part::default() };
        let (positions, indices) = (mesh.positions().to_vec(), indices.into_flattened());
        let data = MeshData { positions, indices, parts: vec![part], ..MeshData::default() };
        // It all comes from a scene, whose limits it keeps; what breaks one does not shine through.
        let Ok(mesh) = Mesh::new(data) else { continue };
        let tints: Vec<_> = mesh.original_triangle().iter().map(|&t| tints[t as usize]).collect();
        let mesh = backs.add_mesh(mesh);
        if let Ok(handle) = backs.add(Instance::new(mesh, *scene.transform(slot))) {
            made.push((handle, tints));
        }
    }
    backs.commit(&cullet::Culler::default());
    let mut by_slot = vec![Vec::new(); backs.slot_count() as usize];
    for (handle, tints) in made {
        if let Ok(slot) = backs.slot(handle) {
            by_slot[slot as usize] = tints;
        }
    }
    (backs, by_slot)
}

/// The direction from the middle of the scene towards the eye.
fn towards_eye_of(scene: &Scene, view: &View) -> DVec3 {
    let [x, y, z, w] = view.eye();
    (DVec3::new(x, y, z) - ball_around(scene).0 * w).normalize_or(DVec3::Z)
}

/// From where an eye in that direction is on the left; a little above, and on the eye's side, where
/// the regions are many.
fn beside(toward: DVec3) -> DVec3 {
    let left = DVec3::new(toward.x, 0.0, toward.z).normalize_or(DVec3::X);
    DVec3::Y.cross(left) + left * 0.35 + DVec3::Y * 0.25
}

/// An arrow along the direction of sight, before the scene.
fn arrow(picture: &mut Picture, scene: &Scene, space: &Space, toward: DVec3) {
    let (middle, radius) = ball_around(scene);
    let size = [picture.width, picture.height];
    let at = |radii: f64| space.project(middle + toward * (radius * radii), size).map(|p| p.0);
    if let (Some(from), Some(to)) = (at(1.3), at(0.9)) {
        picture.arrow(from, to, f64::from(size[1]) * 0.006, INK);
    }
}
