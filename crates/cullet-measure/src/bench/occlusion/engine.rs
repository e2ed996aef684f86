//! The engine's occlusion buffer, as it is measured.

use std::ops::Range;

use cullet::bounds::Boxes;
use cullet::cull::frustum::batch::{Planes, mask_boxes, mask_words};
use cullet::cull::occlusion::{Band, Convex, OcclusionBuffer, Patch};
use cullet::{Simd, Transform, View};
use cullet_command::exit::Failure;
use cullet_io::occscn::Occscn;

use super::rasteriser::{HIDDEN, OUTSIDE, Rasteriser, VISIBLE};
use super::scene::Prepared;

/// Ways to draw meshes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Kinds {
    /// Convex ones as triangles too.
    pub(super) triangles: bool,
    /// Triangles from both sides.
    pub(super) two_sided: bool,
}

/// A mesh as the engine draws it.
enum Occluder {
    /// By its outline.
    Convex(Box<Convex>),
    /// These patches of the surface.
    Patches(Range<usize>),
}

/// The meshes of a scene.
#[derive(Default)]
struct Meshes {
    occluders: Vec<Occluder>,
    patches: Vec<Patch>,
}

impl Meshes {
    fn draw(&self, level: Simd, band: &mut Band<'_>, mesh: u32) {
        match &self.occluders[mesh as usize] {
            Occluder::Convex(convex) => convex.draw(level, band, &Transform::IDENTITY),
            Occluder::Patches(range) => {
                for patch in &self.patches[range.clone()] {
                    patch.draw(level, band, &Transform::IDENTITY);
                }
            }
        }
    }
}

/// An occlusion buffer, and the meshes made ready for it.
pub(super) struct Engine<'a> {
    prepared: &'a Prepared,
    level: Simd,
    buffer: OcclusionBuffer,
    meshes: Meshes,
    planes: Option<Planes>,
    /// One bit a box: in the frustum; and of those, visible and hidden.
    inside: Vec<u64>,
    visible: Vec<u64>,
    hidden: Vec<u64>,
}

impl<'a> Engine<'a> {
    /// Makes the meshes of a scene ready. What is convex is found here, as an engine would when it loads.
    pub(super) fn new(
        prepared: &'a Prepared,
        level: Simd,
        size: [u32; 2],
        kinds: Kinds,
    ) -> Result<Self, Failure> {
        let scene = &prepared.scene;
        let buffer = OcclusionBuffer::new(size).map_err(Failure::usage)?;
        let mut occluders = Vec::with_capacity(scene.meshes.len());
        let mut patches = Vec::new();
        for mesh in &scene.meshes {
            let triangles = scene.triangles_of(mesh);
            let convex = if kinds.triangles { None } else { convex(scene, triangles) };
            if let Some(convex) = convex {
                occluders.push(Occluder::Convex(Box::new(convex)));
                continue;
            }
            // Corners one by one: equal places are one vertex again.
            let corners = triangles.as_flattened().iter();
            let positions: Vec<_> = corners.map(|&v| scene.vertices[v as usize]).collect();
            let (first, indices): (_, Vec<u32>) =
                (patches.len(), (0..positions.len() as u32).collect());
            let cut = Patch::cut(&positions, &indices, Patch::FACETS, kinds.two_sided);
            patches.extend(cut.map_err(Failure::input)?);
            occluders.push(Occluder::Patches(first..patches.len()));
        }
        Ok(Self {
            prepared,
            level,
            buffer,
            meshes: Meshes { occluders, patches },
            planes: None,
            inside: Vec::new(),
            visible: Vec::new(),
            hidden: Vec::new(),
        })
    }

    /// Draws meshes as so many jobs, as [`Rasteriser::draw_unless_hidden`] does; `run` runs each of them.
    pub(super) fn draw_in_jobs(
        &mut self,
        meshes: &[u32],
        jobs: usize,
        run: impl for<'j> FnOnce(Vec<Job<'j>>),
    ) {
        let (level, all, boxes) = (self.level, &self.meshes, &self.prepared.mesh_boxes);
        let draw = |band: &mut Band<'_>, mesh| all.draw(level, band, mesh);
        self.buffer.draw_in_jobs(level, boxes, meshes, jobs, &draw, |jobs| {
            run(jobs.into_iter().map(|job| Box::new(|| job.run()) as Job<'_>).collect());
        });
    }

    /// The nearness of each pixel, as bits.
    pub(super) fn pixels(&self) -> Vec<u32> {
        let [width, height] = self.buffer.size();
        let all = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        all.map(|(x, y)| self.buffer.nearness(x, y).to_bits()).collect()
    }
}

/// A part of the drawing of a list, to be run once, on any thread.
pub(super) type Job<'a> = Box<dyn FnOnce() + Send + 'a>;

/// The convex body that some triangles bound, if they do.
fn convex(scene: &Occscn, triangles: &[[u32; 3]]) -> Option<Convex> {
    let mut vertices: Vec<u32> = triangles.as_flattened().to_vec();
    vertices.sort_unstable();
    vertices.dedup();
    let positions: Vec<[f32; 3]> = vertices.iter().map(|&v| scene.vertices[v as usize]).collect();
    let place = |v: &u32| vertices.binary_search(v).unwrap_or_default() as u32;
    let indices: Vec<u32> = triangles.as_flattened().iter().map(place).collect();
    Convex::from_mesh(&positions, &indices)
}

impl Rasteriser for Engine<'_> {
    fn clear(&mut self, view: &View) {
        self.buffer.begin(view, [0.0; 3]);
        self.planes = Some(Planes::new(&view.frustum()));
    }

    fn draw(&mut self, meshes: &[u32]) {
        for &mesh in meshes {
            self.meshes.draw(self.level, &mut self.buffer.band(), mesh);
        }
    }

    fn draw_unless_hidden(&mut self, meshes: &[u32]) -> usize {
        let (level, all, boxes) = (self.level, &self.meshes, &self.prepared.mesh_boxes);
        self.buffer.draw_unless_hidden(level, boxes, meshes, |band, mesh| {
            all.draw(level, band, mesh);
        })
    }

    fn test(&mut self, boxes: &Boxes, answers: &mut [u8]) {
        let Some(planes) = &self.planes else { return };
        let words = mask_words(boxes.len());
        for mask in [&mut self.inside, &mut self.visible, &mut self.hidden] {
            mask.resize(words, 0);
        }
        mask_boxes(self.level, planes, boxes, 0, &mut self.inside);
        self.buffer.test_boxes(
            self.level,
            boxes,
            0,
            &self.inside,
            &mut self.visible,
            &mut self.hidden,
        );
        for (i, answers) in answers.chunks_mut(8).enumerate() {
            let eight = |mask: &[u64]| spread((mask[i / 8] >> (i % 8 * 8)) as u8);
            let visible = eight(&self.visible) * u64::from(VISIBLE);
            let all = visible | (eight(&self.hidden) * u64::from(HIDDEN));
            answers.copy_from_slice(&all.to_le_bytes()[..answers.len()]);
        }
    }
}

// A box that is neither visible nor hidden has no bit.
const _: () = assert!(OUTSIDE == 0);

/// A byte for each bit, 1 where it is set.
fn spread(bits: u8) -> u64 {
    let apart = (u64::from(bits) * 0x0101_0101_0101_0101) & 0x8040_2010_0804_0201;
    // A byte that is not zero reaches its highest bit.
    (apart + 0x7f7f_7f7f_7f7f_7f7f) >> 7 & 0x0101_0101_0101_0101
}
