//! The engine's occlusion buffer, as it is measured.

use cullet::bounds::{Aabb, Boxes};
use cullet::cull::frustum::batch::{Planes, mask_boxes, mask_words};
use cullet::cull::occlusion::{Convex, Occluder, OcclusionBuffer, Shape};
use cullet::{Mesh, MeshData, Simd, Transform, View};
use cullet_command::exit::Failure;
use cullet_maps::occscn::Occscn;

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

/// Shapes that stand for a scene: an outline for each mesh that is convex, and for all the others
/// together those of one surface, cut as the engine cuts a mesh. What is convex is found here, as
/// an engine would when it loads.
pub(super) fn shapes(scene: &Occscn, kinds: Kinds) -> Result<Vec<Shape>, Failure> {
    let (mut shapes, mut rest) = (Vec::new(), Vec::new());
    for mesh in &scene.meshes {
        let triangles = scene.triangles_of(mesh);
        match if kinds.triangles { None } else { convex(scene, triangles) } {
            Some(convex) => shapes.push(Shape::Convex(convex)),
            None => rest.extend_from_slice(triangles.as_flattened()),
        }
    }
    shapes.extend(surface(scene, rest, kinds.two_sided)?);
    Ok(shapes)
}

/// The shapes of the surface of some triangles. They do not follow the file's meshes, of which each
/// ends where its number of triangles is reached: neighbours must be known for a seam not to leave
/// a gap.
fn surface(scene: &Occscn, indices: Vec<u32>, two_sided: bool) -> Result<Vec<Shape>, Failure> {
    if indices.is_empty() {
        return Ok(Vec::new());
    }
    let positions = scene.vertices.clone();
    let mut mesh = Mesh::new(MeshData { positions, indices, ..MeshData::default() })
        .map_err(Failure::input)?;
    mesh.set_two_sided(two_sided);
    Ok(Occluder::of_mesh(&mesh).shapes().to_vec())
}

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

/// Draws one shape, where it stands.
fn draw(shape: &Shape, simd: Simd, buffer: &mut OcclusionBuffer) {
    shape.draw(simd, buffer, &Transform::IDENTITY);
}

/// The boxes of shapes.
pub(super) fn bounds(shapes: &[Shape]) -> Vec<Aabb> {
    shapes.iter().map(Shape::bounds).collect()
}

/// An occlusion buffer, and the shapes that are drawn into it.
pub(super) struct Engine<'a> {
    prepared: &'a Prepared,
    shapes: &'a [Shape],
    /// The least pixels that each is drawn with; none where all are.
    least: Vec<f32>,
    simd: Simd,
    buffer: OcclusionBuffer,
    planes: Option<Planes>,
    /// One bit a box: in the frustum; and of those, visible and hidden.
    inside: Vec<u64>,
    visible: Vec<u64>,
    hidden: Vec<u64>,
}

impl<'a> Engine<'a> {
    /// A buffer for a scene in pieces, which are these shapes.
    pub(super) fn new(
        prepared: &'a Prepared,
        shapes: &'a [Shape],
        simd: Simd,
        size: [u32; 2],
    ) -> Result<Self, Failure> {
        Ok(Self {
            prepared,
            shapes,
            least: Vec::new(),
            simd,
            buffer: OcclusionBuffer::new(size).map_err(Failure::usage)?,
            planes: None,
            inside: Vec::new(),
            visible: Vec::new(),
            hidden: Vec::new(),
        })
    }
}

impl Engine<'_> {
    /// The same, which passes over shapes of too few pixels.
    pub(super) fn thrifty(self) -> Self {
        Self { least: self.shapes.iter().map(Shape::worth_pixels).collect(), ..self }
    }
}

impl Rasteriser for Engine<'_> {
    fn clear(&mut self, view: &View) {
        self.buffer.begin(view, [0.0; 3]);
        self.planes = Some(Planes::new(&view.frustum()));
    }

    fn draw(&mut self, pieces: &[u32]) {
        for &i in pieces {
            draw(&self.shapes[i as usize], self.simd, &mut self.buffer);
        }
    }

    fn draw_unless_hidden(&mut self, pieces: &[u32]) -> usize {
        let (level, shapes, boxes) = (self.simd, self.shapes, &self.prepared.pieces.boxes);
        self.buffer.draw_unless_hidden(level, (boxes, &self.least), pieces, |buffer, i| {
            draw(&shapes[i as usize], level, buffer);
        })
    }

    fn is_thrifty(&self) -> bool {
        !self.least.is_empty()
    }

    fn test(&mut self, boxes: &Boxes, answers: &mut [u8]) {
        let Some(planes) = &self.planes else { return };
        let words = mask_words(boxes.len());
        for mask in [&mut self.inside, &mut self.visible, &mut self.hidden] {
            mask.resize(words, 0);
        }
        mask_boxes(self.simd, planes, boxes, 0, &mut self.inside);
        self.buffer.test_boxes(
            self.simd,
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
