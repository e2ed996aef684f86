//! The two places of the pipeline where clipping may happen, drawn for comparison.

use cullet::{Depth, Scene, View};

use crate::clip::{Clipper, Region, space};
use crate::frame::{Frame, RenderOptions, Selection};
use crate::geometry::{Clip, Lens};
use crate::reference::render_split;
use crate::render::frame_samples;

/// Where triangles are clipped before they are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ClipPlace {
    /// In the world, by the planes of the frustum, before projection.
    World,
    /// In clip space, by the six sides of the clip volume, after projection and before the divide.
    Clip,
}

/// Draws as [`render_ref`](crate::render_ref) does, but with triangles that are really clipped and
/// cut into fans, in one place of the pipeline or the other.
///
/// The frame is that of the renderer, which clips nothing, but for rounding: a cut moves an edge,
/// and the depth on it, by some 1e-16 of its size, so a sample that lies on an edge to that
/// precision, or as near one surface as another, may go to the other side. Neighbours are cut
/// alike, so no sample falls between them. In clip space the corners that are not cut are those of
/// the renderer, bit for bit; in the world they are rounded once more.
///
/// Cost: that of [`render_ref`](crate::render_ref), some nanoseconds a triangle and pixel.
#[must_use]
pub fn render_clipped(
    scene: &Scene,
    view: &View,
    place: ClipPlace,
    options: &RenderOptions,
) -> Frame {
    let samples = frame_samples(view, options);
    let lens = Lens::new(view);
    let frustum = Region::<f64, 3>::from(&view.frustum());
    let volume = space::full::<f64>(view.depth());
    // The renderer's depths point away from the eye in every view; the clip volume is that of the
    // view.
    let turned = |[x, y, z, w]: Clip| match view.depth() {
        Depth::Standard => [x, y, z, w],
        Depth::Reversed => [x, y, -z, w],
    };
    let (mut world, mut clip) = (Clipper::new(), Clipper::new());
    let fan = |polygon: &mut dyn ExactSizeIterator<Item = Clip>, out: &mut Vec<[Clip; 3]>| {
        let Some(first) = polygon.next() else { return };
        let Some(mut last) = polygon.next() else { return };
        for p in polygon {
            out.push([first, last, p]);
            last = p;
        }
    };
    let mut split =
        |slot: u32, corners: &[[f32; 3]; 3], at: &[Clip; 3], out: &mut Vec<_>| match place {
            ClipPlace::World => {
                let m = scene.transform(slot).to_matrix();
                let placed = corners.map(|p| {
                    let [x, y, z] = p.map(f64::from);
                    [0, 1, 2].map(|r| m[r] * x + m[4 + r] * y + m[8 + r] * z + m[12 + r])
                });
                fan(&mut world.clip(&frustum, &placed).iter().map(|&p| lens.clip(p)), out);
            }
            ClipPlace::Clip => {
                fan(&mut clip.clip(&volume, &at.map(turned)).iter().map(|&p| turned(p)), out);
            }
        };
    render_split(scene, view, Selection::All, &samples, options.count_layers, &mut split)
}
