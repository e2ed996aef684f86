//! Pictures by the reference renderer, as arrays and as files.

use cullet_draw::{Picture, RenderOptions, Selection, kinds, render, shaded};
use engine::{Culler, Depth, Output, View, Visible};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::arrays::shaped;
use crate::scene::PyScene;
use crate::{camera, culler};

/// A frame as flat lists, row by row from the top.
struct Image {
    color: Vec<u8>,
    depth: Vec<f64>,
    /// −1 where there is nothing.
    ids: Vec<i32>,
    triangles: Vec<i32>,
}

fn colors(this: &PyScene) -> Vec<[f32; 4]> {
    this.model.materials.iter().map(|m| m.color).collect()
}

/// Distances of pixels along the direction of sight: from the eye, or from the near plane where lines of sight are
/// parallel; infinite where there is nothing.
fn distances(view: &View, depth: &[f64], is_empty: impl Fn(usize) -> bool) -> Vec<f64> {
    let [width, height] = view.viewport().map(|v| v as usize);
    let (m, back) = (view.clip_from_world(), view.world_from_clip());
    let unprojected = |x: f64, y: f64, z: f64| -> [f64; 4] {
        std::array::from_fn(|r| back[r] * x + back[4 + r] * y + back[8 + r] * z + back[12 + r])
    };
    let point = |p: [f64; 4]| [p[0] / p[3], p[1] / p[3], p[2] / p[3]];
    let near = if view.depth() == Depth::Reversed { 1.0 } else { 0.0 };
    // Clip w is the distance, times the length of its row.
    let scale = (m[3] * m[3] + m[7] * m[7] + m[11] * m[11]).sqrt();
    let distance = |at: usize| {
        if is_empty(at) {
            return f64::INFINITY;
        }
        let x = ((at % width) as f64 + 0.5) / width as f64 * 2.0 - 1.0;
        let y = 1.0 - ((at / width) as f64 + 0.5) / height as f64 * 2.0;
        let p = unprojected(x, y, depth[at]);
        if !view.is_orthographic() {
            return 1.0 / (p[3] * scale);
        }
        let (p, q) = (point(p), point(unprojected(x, y, near)));
        (0..3).map(|a| (p[a] - q[a]).powi(2)).sum::<f64>().sqrt()
    };
    (0..width * height).map(distance).collect()
}

fn image(this: &PyScene, view: &View, visible: Option<&Visible>) -> Image {
    let scene = this.scene();
    let selection = visible.map_or(Selection::All, Selection::Visible);
    let frame = render(scene, view, selection, &RenderOptions::default());
    let none = |at: usize| frame.ids[at] == cullet_draw::PixelId::NONE;
    let id = |slot: u32| this.id(slot).map_or(-1, |id| id as i32);
    Image {
        color: shaded(scene, &frame, view, &colors(this)).rgb,
        depth: distances(view, &frame.depth, none),
        ids: frame.ids.iter().map(|p| id(p.slot)).collect(),
        triangles: frame.ids.iter().map(|p| i32::try_from(p.triangle).unwrap_or(-1)).collect(),
    }
}

/// Draws what a camera sees, and the scene from outside by kinds of culling: the bytes of PNG
/// files.
pub(crate) fn pictures<'py>(
    py: Python<'py>,
    this: &PyScene,
    view: &View,
    culler: &Culler,
    width: u32,
) -> PyResult<[Bound<'py, PyBytes>; 2]> {
    // What is drawn from outside has a legend, which takes room.
    let [w, h] = view.viewport();
    let width = width.clamp(320, 4096);
    let height = (u64::from(width) * u64::from(h) / u64::from(w)).clamp(200, 4096) as u32;
    let drawn = py.detach(|| -> Result<[Vec<u8>; 2], engine::view::ViewError> {
        let small = View::from_matrix(view.clip_from_world(), view.depth(), [width, height])?
            .with_layers(view.layers);
        let options = RenderOptions { scale: 2, ..RenderOptions::default() };
        let frame = render(this.scene(), &small, Selection::All, &options);
        let seen = shaded(this.scene(), &frame, &small, &colors(this)).halved();
        let outside = kinds(this.scene(), view, culler, [width, height]);
        Ok([&seen, &outside].map(Picture::to_png))
    });
    Ok(drawn.map_err(crate::value_error)?.map(|bytes| PyBytes::new(py, &bytes)))
}

#[pymethods]
impl PyScene {
    /// Colour, depth, ids and triangles.
    #[pyo3(signature = (camera, culler=None))]
    fn _render<'py>(
        &self,
        py: Python<'py>,
        camera: PyRef<'py, camera::PyCamera>,
        culler: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let culler = culler.map(|c| culler::culler(Some(c))).transpose()?;
        let view = camera.view.clone();
        let Image { color, depth, ids, triangles } = py.detach(|| {
            let visible = culler.map(|culler| {
                let culler = culler.with_output(Output::Triangles);
                let mut visible = Visible::default();
                let world = self.model.in_cells();
                self.with_state(|s| world.cull(&culler, &view, s, &mut visible));
                visible
            });
            image(self, &view, visible.as_ref())
        });
        let [width, height] = view.viewport().map(|v| v as usize);
        let arrays = (
            shaped(py, color, &[height, width, 3])?,
            shaped(py, depth, &[height, width])?,
            shaped(py, ids, &[height, width])?,
            shaped(py, triangles, &[height, width])?,
        );
        Ok(arrays.into_pyobject(py)?.into_any())
    }
}
