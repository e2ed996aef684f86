//! Describes the frame to draw, between those who decide and those who draw. Neither knows the
//! other.

use cullet::{View, Visible, view::CullFace};

/// One picture: a view of the scene in a part of the target.
#[derive(Clone, Copy, Debug)]
pub struct Pane<'a> {
    /// Where in the target, in pixels from the top left corner: x, y, width, height.
    pub place: [u32; 4],
    /// From where it is seen; its viewport is the size of `place`.
    pub view: &'a View,
    /// The part of the scene that is drawn; `None` draws all of it that is in the view's layers.
    /// Where it lists triangles, these are drawn, else its instances and clusters.
    pub visible: Option<&'a Visible>,
    /// Whether what the [device decided](DeviceView) is drawn in place of `visible`, wherever it
    /// decides: whole instances in full, without lines along their normals.
    pub on_device: bool,
    /// How it is drawn.
    pub style: Style,
    /// Whether it is drawn into what the pane before it left, of the same place and view, rather
    /// than over it.
    pub over: bool,
    /// Things drawn over the scene, hidden by it where they lie behind it.
    pub lines: &'a [LineVertex],
    /// Lines that are drawn over all.
    pub overlay: &'a [LineVertex],
    /// Translucent triangles (ghosts, frusta, clip planes), after the scene, three vertices each.
    pub ghosts: &'a [LineVertex],
}

impl<'a> Pane<'a> {
    /// The pane that a device decides for: all of its view's viewport.
    pub(super) fn of_device(by: &DeviceView<'a>) -> Self {
        let [width, height] = by.view.viewport();
        Self {
            place: [0, 0, width, height],
            view: by.view,
            visible: None,
            on_device: false,
            style: Style { paint: Paint::Depth, cull_face: by.faces, ..Style::default() },
            over: false,
            lines: &[],
            overlay: &[],
            ghosts: &[],
        }
    }
}

/// A view for which the graphics device decides what is drawn.
#[derive(Clone, Copy, Debug)]
pub struct DeviceView<'a> {
    /// Its viewport is the size of the picture that is decided for.
    pub view: &'a View,
    /// Whether what lies outside the view is culled.
    pub frustum: bool,
    /// Whether what lies behind something is.
    pub occlusion: bool,
    /// Faces that the hardware drops, as [`Style::cull_face`] of the panes that draw it: such faces
    /// hide nothing.
    pub faces: CullFace,
    /// Where in the target a level of the depth pyramid is shown, and which: 0 is half as wide as
    /// the picture.
    pub pyramid: Option<([u32; 4], u32)>,
}

/// Figures of a device's decision.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DeviceFigures {
    /// Number of the frame: it rises by one with each; 0 before any is known.
    pub frame: u64,
    /// Instances in the view.
    pub in_view: u32,
    /// Instances among them that are not hidden.
    pub visible: u32,
    /// Triangles of the visible ones.
    pub triangles: u64,
    /// Triangles of what was visible in the frame before and is in the view: those of the depth
    /// that the rest is tested against.
    pub early_triangles: u64,
    /// Draws that are handed in.
    pub draws: u32,
    /// Draws among them with an instance.
    pub draws_in_use: u32,
    /// Times, where the device has a clock.
    pub times: Option<DeviceTimes>,
}

/// Milliseconds that the steps of culling take on a device.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DeviceTimes {
    /// All instances against the planes, and the list of those that were visible before.
    pub early: f32,
    /// The depth of these.
    pub depth: f32,
    /// The pyramid of that depth.
    pub pyramid: f32,
    /// Boxes against the pyramid, and the list of what is visible.
    pub late: f32,
}

impl DeviceTimes {
    /// All of it.
    #[must_use]
    pub fn sum(&self) -> f32 {
        self.early + self.depth + self.pyramid + self.late
    }
}

/// The quantity that colours the scene's triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Paint {
    /// The colour of the material, lit by a lamp at the eye.
    #[default]
    Material,
    /// Front faces in one colour, back faces in another.
    Sides,
    /// A colour for each cluster.
    Clusters,
    /// A colour for each instance, from
    /// [`Renderer::set_instance_colours`](super::Renderer::set_instance_colours).
    Instances,
    /// How many triangles cover each pixel, hidden ones too: from black over dark red to white.
    Overdraw,
    /// How many pixels a triangle covers: the colours of [`heat`](cullet_draw::palette::heat) from
    /// 4096 and more (0) to 1 and less (1), by powers of two.
    TriangleSize,
    /// Distance, from white to black; half dark half a radius of the scene away.
    Depth,
    /// How often triangles were simplified: the colours of
    /// [`level_color`](cullet_draw::palette::level_color).
    Levels,
}

/// Levels of detail that [`Paint::Levels`] tells apart at the most.
pub(super) const LEVELS: u32 = 13;

/// How the scene is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Style {
    /// The quantity that colours triangles.
    pub paint: Paint,
    /// Whether triangles are filled.
    pub fill: bool,
    /// Whether edges of triangles are drawn.
    pub wireframe: bool,
    /// Faces that the graphics hardware drops, of every mesh. Besides these it drops those of
    /// one-sided parts that the view does not draw (its own [`cull_face`](View::cull_face)), so
    /// that what is drawn without culling is what a culler may assume.
    pub cull_face: CullFace,
    /// Whether faces that are clockwise on the screen are the front ones; they are, too, where the
    /// view's own [`front_face`](View::front_face) says so.
    pub clockwise: bool,
    /// A line along the normal from the middle of each face, at most 16 pixels long.
    pub face_normals: bool,
    /// A line along the smooth normal from each vertex, at most 16 pixels long.
    pub vertex_normals: bool,
    /// Whether instances are drawn by the alpha of their
    /// [colour](super::Renderer::set_instance_colours), whatever paints them: as a pattern of
    /// pixels, so that what fades needs no order.
    pub fade: bool,
    /// Whether just those pixels are drawn that [`fade`](Self::fade) leaves out: of what goes while
    /// something else comes in its place by that share. Both together draw each pixel once.
    pub going: bool,
    /// Samples a pixel: 1, or 4 for more. All panes of a frame have as many as the one with the
    /// most.
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
            fade: false,
            going: false,
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

/// Statistics of a drawn frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DrawStats {
    /// Triangles handed to the graphics hardware.
    pub triangles: u64,
    /// Impostors among what was drawn: each the triangles of its box.
    pub impostors: u64,
    /// Draw calls.
    pub draws: u32,
    /// Bytes uploaded for this frame.
    pub uploaded: u64,
    /// Milliseconds the last finished frame took on the device, where it has a clock.
    pub device_ms: Option<f32>,
}
