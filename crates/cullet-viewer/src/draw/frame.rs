//! What is to be drawn: said by those who decide, followed by those who draw. Neither knows the other.

use cullet::{CullFace, View, Visible};

/// One picture: a view of the scene in a part of the target.
#[derive(Clone, Copy, Debug)]
pub struct Pane<'a> {
    /// Where in the target, in pixels from the top left corner: x, y, width, height.
    pub place: [u32; 4],
    /// From where it is seen; its viewport is the size of `place`.
    pub view: &'a View,
    /// What is drawn of the scene; `None` draws all of it.
    pub visible: Option<&'a Visible>,
    /// How it is drawn.
    pub style: Style,
    /// Things drawn over the scene, hidden by it where they lie behind it.
    pub lines: &'a [LineVertex],
    /// Lines that are drawn over all.
    pub overlay: &'a [LineVertex],
    /// Translucent triangles (ghosts, frusta, clip planes), after the scene, three vertices each.
    pub ghosts: &'a [LineVertex],
}

/// What the scene's triangles are painted by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Paint {
    /// The colour of the material, lit by a lamp at the eye.
    #[default]
    Material,
    /// Front faces in one colour, back faces in another.
    Sides,
    /// A colour for each cluster.
    Clusters,
    /// A colour for each instance, from [`Renderer::set_instance_colours`](super::Renderer::set_instance_colours).
    Instances,
    /// How often each pixel is drawn to.
    Overdraw,
    /// How many pixels a triangle covers.
    TriangleSize,
    /// Distance.
    Depth,
}

/// How the scene is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Style {
    /// What triangles are painted by.
    pub paint: Paint,
    /// Whether triangles are filled.
    pub fill: bool,
    /// Whether edges of triangles are drawn.
    pub wireframe: bool,
    /// Which faces the graphics hardware drops, of every mesh.
    pub cull_face: CullFace,
    /// Whether faces that are clockwise on the screen are the front ones.
    pub clockwise: bool,
    /// A line along the normal from the middle of each face.
    pub face_normals: bool,
    /// A line along the normal from each vertex.
    pub vertex_normals: bool,
    /// Samples a pixel: 1 or 4.
    pub samples: u32,
}

impl Default for Style {
    fn default() -> Self {
        Self {
            paint: Paint::Material,
            fill: true,
            wireframe: false,
            cull_face: CullFace::None,
            clockwise: false,
            face_normals: false,
            vertex_normals: false,
            samples: 1,
        }
    }
}

/// A corner of a line or of a translucent triangle, in world space.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct LineVertex {
    /// Where it is.
    pub position: [f32; 3],
    /// Its colour, sRGB with straight alpha.
    pub colour: [u8; 4],
}

/// What a frame took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DrawStats {
    /// Triangles handed to the graphics hardware.
    pub triangles: u64,
    /// Draw calls.
    pub draws: u32,
    /// Bytes uploaded for this frame.
    pub uploaded: u64,
    /// Milliseconds the last finished frame took on the device, where it has a clock.
    pub device_ms: Option<f32>,
}
