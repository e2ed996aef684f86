//! Costs of drawing: the only way in which time enters a decision.

/// Costs of drawing with a renderer, and of occlusion culling beside it, in nanoseconds of one
/// thread. Plain data that the caller passes in: nothing here reads a clock, so the same costs give
/// the same decisions anywhere. The program `cullet calibrate` measures them.
///
/// They scale what is decided and never what is right: with any values every exact test stays
/// conservative. Those that are not finite and above 0 say nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Costs {
    /// An opaque triangle drawn, with its share of the pixels.
    pub opaque_triangle_ns: f64,
    /// One more instance, or range of triangles, drawn by itself: a draw call.
    pub draw_ns: f64,
    /// Occlusion culling itself. `cullet calibrate` leaves them at their default, for which
    /// occluders are chosen depends on them: with the same costs the same ones are, on every
    /// machine.
    #[cfg_attr(feature = "serde", serde(default))]
    pub occluders: OccluderCosts,
}

impl Default for Costs {
    /// A renderer on a GPU, as a guess and not a measurement: ten nanoseconds a triangle with its
    /// share of the pixels, a microsecond a draw.
    fn default() -> Self {
        let occluders = OccluderCosts::default();
        Self { opaque_triangle_ns: 10.0, draw_ns: 1000.0, occluders }
    }
}

/// Costs of occlusion culling: of drawing occluders of each kind, and of testing.
/// [`Culler::costs`](crate::Culler::costs) has the choice of occluders go by them, and whether
/// there is one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct OccluderCosts {
    /// Convex bodies and polygons.
    pub convex: DrawingCosts,
    /// Patches of a surface.
    pub patch: DrawingCosts,
    /// Looking at a shape, whether it is chosen or not.
    pub look_ns: f64,
    /// Testing an instance or a cluster, its share of the nodes above it included.
    pub test_ns: f64,
    /// Emptying the buffer and taking samples of what is left, however little that is.
    pub begin_ns: f64,
}

/// Costs of drawing one shape into an occlusion buffer, in nanoseconds: `base_ns` + `edge_ns` · its
/// edges + `outline_ns` · √ its pixels + `pixel_ns` · its pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct DrawingCosts {
    /// However small it is.
    pub base_ns: f64,
    /// For each edge.
    pub edge_ns: f64,
    /// For each pixel of the root of its area: the outline.
    pub outline_ns: f64,
    /// For each pixel.
    pub pixel_ns: f64,
}

impl Default for OccluderCosts {
    /// Fitted to the fastest of six to eight draws of each of 4,000 boxes, and of 5,500 patches of
    /// a castle and a hall, at 640 pixels across: half are off by less than a tenth. The facets of
    /// a patch cost, those around it too.
    fn default() -> Self {
        Self {
            convex: DrawingCosts { base_ns: 330.0, edge_ns: 5.0, outline_ns: 5.0, pixel_ns: 0.02 },
            patch: DrawingCosts { base_ns: 650.0, edge_ns: 7.0, outline_ns: 2.0, pixel_ns: 0.03 },
            look_ns: 30.0,
            test_ns: 20.0,
            begin_ns: 10_000.0,
        }
    }
}
