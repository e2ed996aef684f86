//! One frame's draw calls.

use std::ops::Range;

use cullet::Depth;
use eframe::wgpu::*;

use super::culling::DeviceCulling;
use super::frame::{Paint, Pane};
use super::list::{Item, What};
use super::pane::{PaneState, Picks, culled, is_pulled};
use super::pipelines::{Mix, Near, PipelineKey, Pipelines, VertexSource};
use super::upload::Uploaded;

/// Resources for drawing one pane.
pub(super) struct PaneDraw<'a> {
    pub(super) device: &'a Device,
    pub(super) pipelines: &'a mut Pipelines,
    pub(super) pane: &'a Pane<'a>,
    pub(super) samples: u32,
    /// The device's decision, where that is drawn.
    pub(super) on_device: Option<&'a DeviceCulling>,
    /// Whether some colours of instances are translucent.
    pub(super) translucent: bool,
    pub(super) triangles: u64,
    pub(super) impostors: u64,
    pub(super) draws: u32,
}

/// Vertices of the caller, in the frame's buffer.
#[derive(Clone, Debug, Default)]
pub(super) struct Extras {
    pub(super) lines: Range<u32>,
    pub(super) ghosts: Range<u32>,
    pub(super) overlay: Range<u32>,
}

impl PaneDraw<'_> {
    fn way(&self, source: VertexSource, mix: Mix, near: Near) -> PipelineKey {
        let reversed = self.pane.view.depth() == Depth::Reversed;
        // One pipeline does for all that paints nothing.
        let paint = if source.is_painted() { self.pane.style.paint } else { Paint::default() };
        PipelineKey {
            source,
            paint,
            cut: false,
            mix,
            near,
            cull: None,
            reversed,
            samples: self.samples,
        }
    }

    fn set(&mut self, pass: &mut RenderPass<'_>, way: PipelineKey) {
        pass.set_pipeline(&self.pipelines.get(self.device, way));
    }

    /// Empties the pane: its colour, and the depth of what other panes left there.
    pub(super) fn clear(&mut self, pass: &mut RenderPass<'_>) {
        let way = self.way(VertexSource::Clear, Mix::Replace, Near::Overwrite);
        self.set(pass, way);
        pass.draw(0..3, 0..1);
    }

    /// Draws the scene.
    pub(super) fn scene(&mut self, pass: &mut RenderPass<'_>, scene: &Uploaded, state: &PaneState) {
        let style = self.pane.style;
        if style.fill || style.wireframe {
            let overdraw = style.paint == Paint::Overdraw;
            // Colours that mean something are not mixed.
            let blends = style.paint == Paint::Material && style.fill;
            let (mix, near) = match overdraw {
                true => (Mix::Add, Near::Ignore),
                false => (Mix::Replace, Near::Write),
            };
            let source =
                if is_pulled(&style) { VertexSource::Pulled } else { VertexSource::Indexed };
            let by_alpha = style.paint == Paint::Instances || style.fade;
            let holes = by_alpha && self.translucent || style.going;
            let cut = style.wireframe || holes;
            let mut way = PipelineKey { cut, ..self.way(source, mix, near) };
            self.items(pass, scene, state, way, blends.then_some(false));
            self.boxes(pass, scene, state, way, blends.then_some(false));
            if blends {
                (way.mix, way.near) = (Mix::Alpha, Near::Test);
                self.items(pass, scene, state, way, Some(true));
                self.boxes(pass, scene, state, way, Some(true));
            }
        }
        for (wanted, source) in [
            (style.face_normals, VertexSource::FaceNormals),
            (style.vertex_normals, VertexSource::VertexNormals),
        ] {
            if wanted {
                let way = self.way(source, Mix::Replace, Near::Write);
                self.items(pass, scene, state, way, None);
            }
        }
    }

    /// Draws the items of a list in one way; of `blended` parts alone, or of those that are not, if
    /// set.
    fn items(
        &mut self,
        pass: &mut RenderPass<'_>,
        scene: &Uploaded,
        state: &PaneState,
        way: PipelineKey,
        blended: Option<bool>,
    ) {
        if let Some(decided) = self.on_device {
            self.listed(pass, scene, decided, way, blended);
            return;
        }
        let (mut bound_chunk, mut bound_cull) = (None, None);
        let slots = u32::from(way.source == VertexSource::Indexed);
        pass.set_vertex_buffer(slots, state.slots.buffer.slice(..));
        for item in &state.list.items {
            let kind = &scene.instances.groups[item.group as usize].kind;
            if scene.geometry.impostors.has(kind.mesh) {
                continue;
            }
            let mesh = &scene.geometry.meshes[kind.mesh as usize];
            let chunk = &scene.chunks[mesh.chunk as usize];
            for run in &mesh.runs {
                if blended.is_some_and(|b| b != (run.blended || kind.transparent)) {
                    continue;
                }
                let Some(cull) = culled(self.pane, kind, run.two_sided) else { continue };
                let what = within(item, &run.triangles, &state.list.picked);
                let (What::Triangles(range) | What::Picked(range)) = &what;
                if range.is_empty() {
                    continue;
                }
                if bound_chunk != Some(mesh.chunk) {
                    if way.source == VertexSource::Indexed {
                        pass.set_vertex_buffer(0, chunk.vertices.slice(..));
                    } else {
                        let Some(group) = chunk.group() else { continue };
                        pass.set_bind_group(1, group, &[]);
                    }
                    bound_chunk = Some(mesh.chunk);
                }
                if bound_cull != Some(cull) {
                    // Lines have no sides.
                    let lines = matches!(
                        way.source,
                        VertexSource::FaceNormals | VertexSource::VertexNormals
                    );
                    let cull = if lines { None } else { cull };
                    self.set(pass, PipelineKey { cull, ..way });
                }
                bound_cull = Some(cull);
                let entries = item.entries.clone();
                let count =
                    u64::from(range.end - range.start) * u64::from(entries.end - entries.start);
                if way.source.is_painted() {
                    self.triangles += count;
                }
                self.draws += 1;
                let from =
                    |r: &Range<u32>| r.start + mesh.first_triangle..r.end + mesh.first_triangle;
                let times = |r: Range<u32>, n: u32| r.start * n..r.end * n;
                match (way.source, what) {
                    (VertexSource::Indexed, What::Triangles(r)) => {
                        pass.set_index_buffer(chunk.indices.slice(..), IndexFormat::Uint32);
                        pass.draw_indexed(times(from(&r), 3), 0, entries);
                    }
                    (VertexSource::Indexed, What::Picked(r)) => {
                        picked(pass, state, Picks::Indices, times(r, 3), entries);
                    }
                    (VertexSource::Pulled, What::Triangles(r)) => {
                        pass.draw(times(from(&r), 3), entries);
                    }
                    (VertexSource::Pulled, What::Picked(r)) => {
                        picked(pass, state, Picks::Corners, times(r, 3), entries);
                    }
                    (VertexSource::FaceNormals, What::Triangles(r)) => {
                        pass.draw(times(from(&r), 2), entries);
                    }
                    (VertexSource::FaceNormals, What::Picked(r)) => {
                        picked(pass, state, Picks::Lines, times(r, 2), entries);
                    }
                    // Of an instance of which some triangles are drawn, all vertices are.
                    (_, What::Triangles(r)) => pass.draw(times(mesh.vertices(&r), 2), entries),
                    (_, What::Picked(_)) => {
                        pass.draw(times(mesh.vertices(&run.triangles), 2), entries);
                    }
                }
            }
        }
    }

    /// Draws what the device listed in one way, as [`items`](Self::items) does what a list says.
    fn listed(
        &mut self,
        pass: &mut RenderPass<'_>,
        scene: &Uploaded,
        decided: &DeviceCulling,
        way: PipelineKey,
        blended: Option<bool>,
    ) {
        if !way.source.is_painted() {
            return;
        }
        let is_indexed = way.source == VertexSource::Indexed;
        let (mut bound_chunk, mut bound_cull) = (None, None);
        for draw in decided.draws() {
            if blended.is_some_and(|b| b != draw.blended) {
                continue;
            }
            let Some(cull) = culled(self.pane, &draw.kind, draw.two_sided) else { continue };
            if bound_chunk != Some(draw.chunk) {
                let chunk = &scene.chunks[draw.chunk as usize];
                if is_indexed {
                    pass.set_vertex_buffer(0, chunk.vertices.slice(..));
                    pass.set_index_buffer(chunk.indices.slice(..), IndexFormat::Uint32);
                } else {
                    let Some(group) = chunk.group() else { continue };
                    pass.set_bind_group(1, group, &[]);
                }
                bound_chunk = Some(draw.chunk);
            }
            if bound_cull != Some(cull) {
                self.set(pass, PipelineKey { cull, ..way });
            }
            bound_cull = Some(cull);
            self.draws += 1;
            decided.draw(pass, draw, is_indexed);
        }
    }

    /// Draws the impostors of a list, each by the far sides of its whole box, whichever triangles
    /// of that were left: what is seen lies before them. Of transparent instances alone, or of
    /// those that are not, if set.
    fn boxes(
        &mut self,
        pass: &mut RenderPass<'_>,
        scene: &Uploaded,
        state: &PaneState,
        way: PipelineKey,
        transparent: Option<bool>,
    ) {
        let Some(group) = scene.impostors().filter(|_| self.on_device.is_none()) else { return };
        let (mut bound_chunk, mut bound_cull) = (None, None);
        pass.set_vertex_buffer(1, state.slots.buffer.slice(..));
        for item in &state.list.items {
            let kind = &scene.instances.groups[item.group as usize].kind;
            if !scene.geometry.impostors.has(kind.mesh)
                || transparent.is_some_and(|t| t != kind.transparent)
            {
                continue;
            }
            let mesh = &scene.geometry.meshes[kind.mesh as usize];
            let chunk = &scene.chunks[mesh.chunk as usize];
            let mirrored = self.pane.view.is_mirrored() != kind.mirrored;
            let cull = Some(if mirrored { Face::Back } else { Face::Front });
            if bound_cull != Some(cull) {
                let source = VertexSource::Impostors;
                self.set(pass, PipelineKey { source, cut: false, cull, ..way });
                pass.set_bind_group(1, group, &[]);
                bound_cull = Some(cull);
            }
            if bound_chunk != Some(mesh.chunk) {
                pass.set_vertex_buffer(0, chunk.vertices.slice(..));
                pass.set_index_buffer(chunk.indices.slice(..), IndexFormat::Uint32);
                bound_chunk = Some(mesh.chunk);
            }
            let first = mesh.first_triangle * 3;
            let count = u64::from(item.entries.end - item.entries.start);
            self.impostors += count;
            self.triangles += count * u64::from(mesh.whole);
            self.draws += 1;
            pass.draw_indexed(first..first + mesh.whole * 3, 0, item.entries.clone());
        }
    }

    /// Draws what the caller gave besides.
    pub(super) fn extras(&mut self, pass: &mut RenderPass<'_>, buffer: &Buffer, extras: &Extras) {
        for (range, source, near) in [
            (&extras.lines, VertexSource::Lines, Near::Write),
            (&extras.ghosts, VertexSource::Ghosts, Near::Test),
            (&extras.overlay, VertexSource::Lines, Near::Ignore),
        ] {
            if !range.is_empty() {
                let way = self.way(source, Mix::Alpha, near);
                self.set(pass, way);
                pass.set_vertex_buffer(0, buffer.slice(..));
                pass.draw(range.clone(), 0..1);
                self.draws += 1;
            }
        }
    }
}

fn picked(
    pass: &mut RenderPass<'_>,
    state: &PaneState,
    picks: Picks,
    indices: Range<u32>,
    entries: Range<u32>,
) {
    pass.set_index_buffer(state.picks(picks).buffer.slice(..), IndexFormat::Uint32);
    pass.draw_indexed(indices, 0, entries);
}

/// Cuts the triangles of an item to a range of its mesh.
fn within(item: &Item, run: &Range<u32>, picked: &[u32]) -> What {
    match &item.what {
        What::Triangles(r) => What::Triangles(r.start.max(run.start)..r.end.min(run.end)),
        What::Picked(r) => {
            // They ascend in the mesh's order, as its runs do.
            let own = &picked[r.start as usize..r.end as usize];
            let start = own.partition_point(|&t| t < run.start) as u32;
            let end = own.partition_point(|&t| t < run.end) as u32;
            What::Picked(r.start + start..r.start + end)
        }
    }
}
