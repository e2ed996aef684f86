//! The slow twin of the renderer: every triangle tested at every sample, in the order of the scene.

use cullet::mesh::Alpha;
use cullet::{Scene, View};

use crate::frame::{Frame, PixelId, RenderOptions, Selection};
use crate::geometry::{Clip, Lens, Surface, has_area, is_flat};
use crate::prepare::part_of;
use crate::render::frame_samples;
use crate::sample::Samples;

/// Draws as [`render`](crate::render) does, by a plain loop over all triangles and all pixels: no
/// tiles, no rejects, no threads. The oracle of its tests; the frame is the same, bit for bit.
///
/// Cost: some nanoseconds a triangle and pixel, so keep to small scenes.
#[must_use]
pub fn render_ref(
    scene: &Scene,
    view: &View,
    selection: Selection,
    options: &RenderOptions,
) -> Frame {
    render_samples(scene, view, selection, &frame_samples(view, options), options.count_layers)
}

/// Splits a triangle into those that are drawn in its place. Arguments: its slot, its corners in
/// the mesh and in clip space, and the list that takes the new triangles.
pub(crate) type Split<'a> = &'a mut dyn FnMut(u32, &[[f32; 3]; 3], &[Clip; 3], &mut Vec<[Clip; 3]>);

pub(crate) fn render_samples(
    scene: &Scene,
    view: &View,
    selection: Selection,
    samples: &Samples,
    count_layers: bool,
) -> Frame {
    let mut whole =
        |_: u32, _: &_, clip: &[Clip; 3], triangles: &mut Vec<[Clip; 3]>| triangles.push(*clip);
    render_split(scene, view, selection, samples, count_layers, &mut whole)
}

/// [`render_samples`] where each triangle is drawn as those that `split` makes of it.
pub(crate) fn render_split(
    scene: &Scene,
    view: &View,
    selection: Selection,
    samples: &Samples,
    count_layers: bool,
    split: Split<'_>,
) -> Frame {
    let lens = Lens::new(view);
    let [width, height] = samples.size;
    let pixels = width as usize * height as usize;
    let mut frame = Frame {
        width,
        height,
        ids: vec![PixelId::NONE; pixels],
        depth: vec![f64::INFINITY; pixels],
        layers: vec![0; if count_layers { pixels } else { 0 }],
        ..Frame::default()
    };
    let (mut blended, mut triangles) = (Vec::new(), Vec::new());
    for opaque in [true, false] {
        for slot in scene.slots() {
            let transform = scene.transform(slot);
            if scene.layers(slot) & view.layers == 0 || !transform.is_finite() || is_flat(transform)
            {
                continue;
            }
            let (mesh, flags) = (scene.mesh(slot), scene.flags(slot));
            let object = lens.object(transform);
            for t in 0..mesh.triangle_count() {
                let triangle = mesh.original_triangle()[t as usize];
                let part = part_of(mesh, triangle);
                let is_opaque = part.alpha == Alpha::Opaque && !flags.transparent;
                let corners = mesh.corners(t);
                if is_opaque != opaque || !has_area(corners) || !selected(&selection, slot, t) {
                    continue;
                }
                let clip = corners.map(|p| object.clip(p));
                triangles.clear();
                split(slot, &corners, &clip, &mut triangles);
                // The first sample, by row and column, of all of them.
                let mut passed = None;
                let id = PixelId { slot, triangle };
                for corners in &triangles {
                    let Some((surface, counter_clockwise)) = Surface::new(*corners) else {
                        continue;
                    };
                    if object.draws(counter_clockwise, part.two_sided || flags.double_sided) {
                        let at = draw(&mut frame, &surface, id, &lens, samples, opaque);
                        let earlier = |a: [u32; 2], b: [u32; 2]| {
                            if (a[1], a[0]) <= (b[1], b[0]) { a } else { b }
                        };
                        passed = match (passed, at) {
                            (Some(a), Some(b)) => Some(earlier(a, b)),
                            (a, b) => a.or(b),
                        };
                    }
                }
                blended.extend(passed.map(|at| (id, at)));
            }
        }
    }
    frame.set_blended(&blended);
    frame.depth.iter_mut().for_each(|d| *d = lens.ndc_depth(*d));
    frame.count();
    frame
}

fn selected(selection: &Selection, slot: u32, triangle: u32) -> bool {
    match selection {
        Selection::All => true,
        Selection::Visible(visible) => visible.triangle_ranges.iter().any(|r| {
            // A range that reaches beyond the list means what of it is there.
            let end = (r.first as usize + r.count as usize).min(visible.triangles.len());
            let entries = visible.triangles.get(r.first as usize..end);
            r.slot == slot && entries.is_some_and(|t| t.contains(&triangle))
        }),
    }
}

/// Draws an opaque surface, or tests a blended one: the first sample where it passed.
fn draw(
    frame: &mut Frame,
    surface: &Surface,
    id: PixelId,
    lens: &Lens,
    samples: &Samples,
    opaque: bool,
) -> Option<[u32; 2]> {
    let [low, high] = lens.range;
    let mut passed = None;
    for row in 0..frame.height {
        for column in 0..frame.width {
            let [x, y] = samples.at(column, row);
            let e = surface.at(x, y);
            if !surface.covers(e) {
                continue;
            }
            let depth = surface.depth(e);
            if !(depth >= low && depth <= high) {
                continue;
            }
            let at = row as usize * frame.width as usize + column as usize;
            if let Some(n) = frame.layers.get_mut(at) {
                *n += 1;
            }
            let held = frame.depth[at];
            if !opaque {
                if depth <= held {
                    passed = passed.or(Some([column, row]));
                }
            } else if depth < held || (depth == held && id < frame.ids[at]) {
                frame.depth[at] = depth;
                frame.ids[at] = id;
            }
        }
    }
    passed
}
