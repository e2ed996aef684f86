//! Scenes cut open, to show what became of everything in a view.

use cullet::bounds::Plane;
use cullet::{View, Visible};
use cullet_command::console::Console;
use cullet_command::exit::Failure;
use cullet_cut::{CutModel, Keep, ModelOptions};
use cullet_draw::{OpenedScene, Outlook, Picture};
use cullet_io::Model;

use crate::{cutting, standpoint};

/// A model that was cut open, and from where one looks into it.
#[derive(Debug)]
pub(crate) struct Opening {
    left: CutModel,
    from: View,
}

impl Opening {
    /// Cuts a model at these planes, with caps but for shells around `hollow`, and stands before the cut.
    pub(crate) fn new(
        planes: &[Plane],
        keep: Keep,
        hollow: Option<[f64; 3]>,
        model: &Model,
        size: [u32; 2],
        console: &Console,
    ) -> Result<Self, Failure> {
        let options = ModelOptions { planes, keep, caps: true, hollow, ..ModelOptions::default() };
        let left = cutting::cut(model, &options, console)?;
        let from = standpoint::stand(&left.model, &model.scene.extent(), &options, None, size)?;
        Ok(Self { left, from })
    }

    /// Whether nothing of the scene is left.
    pub(crate) fn is_empty(&self) -> bool {
        self.left.model.scene.instance_count() == 0
    }

    /// Draws every triangle in the colour of the stage that culled it, in a view of the whole model.
    pub(crate) fn draw(&self, model: &Model, view: &View, result: &Visible) -> Picture {
        let left = OpenedScene {
            scene: &self.left.model.scene,
            origin: &self.left.origin,
            triangles: &self.left.triangles,
            cut_material: self.left.cap_material,
        };
        cullet_draw::opened(&model.scene, view, result, &left, &self.from)
    }
}

/// A view and its culling from outside: the scene as it is, or cut open where something covers what the view
/// sees; then with the height of the cut. `result` has reasons and triangles.
pub(crate) fn kinds(
    model: &Model,
    view: &View,
    result: &Visible,
    size: [u32; 2],
) -> (Picture, Option<f64>) {
    let Outlook { from, cut_at } = Outlook::new(&model.scene, view, size);
    let opened = cut_at.and_then(|height| {
        let plane = Plane::new([0.0, 1.0, 0.0], height);
        let [x, y, z, w] = view.eye();
        let eye = (w != 0.0).then_some([x, y, z]);
        // A model that cannot be cut is shown from outside.
        Opening::new(&[plane], Keep::Inside, eye, model, size, &Console::new(true, None)).ok()
    });
    match opened.filter(|o| !o.is_empty()) {
        Some(opening) => (opening.draw(model, view, result), cut_at),
        None => (cullet_draw::kinds_of(&model.scene, view, result, &from), None),
    }
}
