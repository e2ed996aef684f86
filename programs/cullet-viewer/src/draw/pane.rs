//! A pane as the device needs it: the numbers of its view and style, and its list of slots.

use cullet::{
    Depth,
    view::{CullFace, FrontFace},
};
use eframe::wgpu::{BufferUsages, Device, Face, Queue};
use glam::{DMat4, DVec3, DVec4};

use super::frame::{Paint, Pane, Style};
use super::geometry::{linear, list_width};
use super::groups::Kind;
use super::list::DrawList;
use super::textures::GrowingBuffer;
use super::upload::{Uploaded, split};

/// The shader's `Pane`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Numbers {
    clip: [[f32; 4]; 4],
    eye_high: [f32; 4],
    eye_low: [f32; 4],
    sight: [f32; 4],
    background: [f32; 4],
    size: [f32; 2],
    flags: u32,
    shift: u32,
    far: f32,
    pad: [f32; 3],
}

const _: () = assert!(size_of::<Numbers>() == 160);

/// Offsets into a uniform buffer are multiples of this on every device.
pub(super) const STRIDE: u64 = 256;

impl Numbers {
    /// The numbers of a pane, for a scene of some radius.
    pub(super) fn new(pane: &Pane<'_>, background: [f32; 3], radius: f32, max_side: u32) -> Self {
        let (view, style) = (pane.view, &pane.style);
        let matrix = DMat4::from_cols_array(&view.clip_from_world());
        let far = if view.depth() == Depth::Reversed { 0.0 } else { 1.0 };
        let [x, y, z, w] = view.eye();
        let eye = if w == 0.0 {
            let near = DMat4::from_cols_array(&view.world_from_clip())
                * DVec4::new(0.0, 0.0, 1.0 - f64::from(far), 1.0);
            near.truncate() / near.w
        } else {
            DVec3::new(x, y, z)
        };
        let eye = if eye.is_finite() { eye } else { DVec3::ZERO };
        let clip = matrix * DMat4::from_translation(eye);
        let pixel = 2.0 / (f64::from(pane.place[3].max(1)) * matrix.row(1).truncate().length());
        let [high, low] = split(&eye.to_array());
        let with = |v: [f32; 3], w: f32| [v[0], v[1], v[2], w];
        let sight = [x as f32, y as f32, z as f32];
        // Layers are added up from black.
        let background =
            if style.paint == Paint::Overdraw { [0.0; 3] } else { background.map(to_linear) };
        let flags =
            [flips(pane), style.clockwise, style.fill, style.wireframe, style.fade, style.going];
        Self {
            clip: clip.as_mat4().to_cols_array_2d(),
            eye_high: with(high, pixel as f32),
            eye_low: with(low, radius * 0.5),
            sight: if w == 0.0 { with(sight, 1.0) } else { [0.0; 4] },
            background: with(background, 1.0),
            size: [pane.place[2] as f32, pane.place[3] as f32],
            flags: flags.iter().rev().fold(0, |n, &bit| n * 2 + u32::from(bit)),
            shift: list_width(max_side).ilog2(),
            far,
            pad: [0.0; 3],
        }
    }
}

/// A share of sRGB to linear; what is not within 0 and 1 goes to the nearer end.
pub(super) fn to_linear(v: f32) -> f32 {
    linear((v.clamp(0.0, 1.0) * 255.0).round() as u8)
}

/// Whether faces that are clockwise on the screen are front ones, of instances that are not
/// mirrored.
fn flips(pane: &Pane<'_>) -> bool {
    let clockwise = pane.style.clockwise || pane.view.front_face == FrontFace::Clockwise;
    pane.view.is_mirrored() != clockwise
}

/// The faces that the hardware is to cull of one kind of instance: `None` if no face is left to
/// draw.
pub(super) fn culled(pane: &Pane<'_>, kind: &Kind, two_sided: bool) -> Option<Option<Face>> {
    let wanted = [pane.style.cull_face, pane.view.cull_face];
    let wanted = &wanted[..if two_sided || kind.two_sided { 1 } else { 2 }];
    let (back, front) = (wanted.contains(&CullFace::Back), wanted.contains(&CullFace::Front));
    // The hardware's front is counter-clockwise on the screen.
    let flipped = flips(pane) != kind.mirrored;
    match (back != flipped && (back || front), back && front) {
        (_, true) => None,
        (true, _) => Some(Some(Face::Back)),
        (false, _) if back || front => Some(Some(Face::Front)),
        _ => Some(None),
    }
}

/// Where the triangles of a list come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Picks {
    /// Three indices of vertices each.
    Indices,
    /// Three corners each.
    Corners,
    /// Two ends of a line each.
    Lines,
}

/// State of a pane, kept from frame to frame.
#[derive(Debug)]
pub(super) struct PaneState {
    pub(super) list: DrawList,
    pub(super) slots: GrowingBuffer,
    picks: [GrowingBuffer; 3],
    fresh: [bool; 3],
    scratch: Vec<u32>,
}

impl PaneState {
    pub(super) fn new(device: &Device) -> Self {
        let index = |label| GrowingBuffer::new(device, label, BufferUsages::INDEX);
        Self {
            list: DrawList::default(),
            slots: GrowingBuffer::new(device, "slots", BufferUsages::VERTEX),
            picks: [index("picked triangles"), index("picked corners"), index("picked lines")],
            fresh: [false; 3],
            scratch: Vec::new(),
        }
    }

    /// Follows the pane; returns the bytes uploaded.
    pub(super) fn update(
        &mut self,
        device: &Device,
        queue: &Queue,
        scene: &Uploaded,
        pane: &Pane<'_>,
    ) -> u64 {
        let mut uploaded = 0;
        let (geometry, instances) = (&scene.geometry, &scene.instances);
        if self.list.update(geometry, instances, pane.visible, pane.view.layers) {
            self.fresh = [false; 3];
            self.slots.reserve(device, self.list.entries.len() as u64 * 4);
            let buffer = &self.slots.buffer;
            self.list.take_dirty(|range, entries| {
                queue.write_buffer(buffer, range.start as u64 * 4, bytemuck::cast_slice(entries));
                uploaded += size_of_val(entries) as u64;
            });
        }
        for picks in needed(&pane.style).into_iter().flatten() {
            uploaded += self.pick(device, queue, scene, picks);
        }
        uploaded
    }

    /// The index buffer of the list's triangles.
    pub(super) fn picks(&self, picks: Picks) -> &GrowingBuffer {
        &self.picks[picks as usize]
    }

    fn pick(&mut self, device: &Device, queue: &Queue, scene: &Uploaded, picks: Picks) -> u64 {
        if self.list.picked.is_empty() || std::mem::replace(&mut self.fresh[picks as usize], true) {
            return 0;
        }
        self.scratch.clear();
        for (mesh, triangles) in self.list.picked_meshes(&scene.instances) {
            let place = &scene.geometry.meshes[mesh as usize];
            let indices = &scene.geometry.chunks[place.chunk as usize].indices;
            for &t in triangles {
                let t = t + place.first_triangle;
                match picks {
                    Picks::Indices => self.scratch.extend(&indices[t as usize * 3..][..3]),
                    Picks::Corners => self.scratch.extend([t * 3, t * 3 + 1, t * 3 + 2]),
                    Picks::Lines => self.scratch.extend([t * 2, t * 2 + 1]),
                }
            }
        }
        self.picks[picks as usize].write(device, queue, &self.scratch)
    }
}

/// Returns the kinds of picked triangles that a style draws.
fn needed(style: &Style) -> [Option<Picks>; 2] {
    let filled = style.fill || style.wireframe;
    let triangles = if is_pulled(style) { Picks::Corners } else { Picks::Indices };
    [filled.then_some(triangles), style.face_normals.then_some(Picks::Lines)]
}

/// Whether a style's triangles must know their corners.
pub(super) fn is_pulled(style: &Style) -> bool {
    style.wireframe || style.paint == Paint::TriangleSize
}
