//! A view whose culling stands still while another eye looks at it.

use std::borrow::Cow;

use cullet::{Scene, View, Visible};

use super::Picture;
use super::outside::{draw_frustum, from_outside};
use super::scene_fates::SceneFates;
use super::shaded::light_evenly;
use super::space::Surfaces;
use crate::frame::{Frame, PixelId, RenderOptions, Selection};
use crate::render::render;

/// A view and what was culled for it, to be looked at from anywhere: who looks moves on, what was
/// decided stays.
#[derive(Debug)]
pub struct FrozenView<'a> {
    scene: &'a Scene,
    view: Cow<'a, View>,
    visible: Cow<'a, Visible>,
    /// Owners of pixels, sorted.
    seen: Vec<PixelId>,
    surfaces: Surfaces<'a>,
}

impl<'a> FrozenView<'a> {
    /// Freezes a view. `visible` has reasons and triangles, and what was dropped if single
    /// triangles shall be told apart. Cost: a frame of the view, and 4 bytes a stored triangle.
    #[must_use]
    pub fn new(scene: &'a Scene, view: Cow<'a, View>, visible: Cow<'a, Visible>) -> Self {
        let seen = render(scene, &view, Selection::All, &RenderOptions::default()).visible();
        Self { scene, view, visible, seen, surfaces: Surfaces::of_all(scene) }
    }

    /// The whole scene from another view, in even light, each triangle in the colour of its fate,
    /// with the frozen view's frustum. It has the size of that view. Cost: a frame of four times
    /// its pixels.
    #[must_use]
    pub fn draw(&self, from: &View) -> Picture {
        let fates = self.fates();
        let from = from_outside(from);
        let frame = from_far(self.scene, &from);
        let color = |id: PixelId| fates.color_of(id);
        let mut picture = light_evenly(&frame, &from, &self.surfaces, &color).halved();
        draw_frustum(&mut picture, self.scene, &self.view, &from, &frame);
        picture
    }

    /// The colour and the words of each fate that occurs, and how many triangles have it, in the
    /// order of a legend.
    #[must_use]
    pub fn counts(&self) -> Vec<([u8; 3], &'static str, u64)> {
        let counts = self.fates().counts();
        counts.into_iter().map(|(fate, n)| (fate.color(), fate.label(), n)).collect()
    }

    pub(super) fn fates(&self) -> SceneFates<'_> {
        SceneFates::new(self.scene, &self.visible, &self.seen, &self.surfaces)
    }

    pub(super) fn surfaces(&self) -> &Surfaces<'a> {
        &self.surfaces
    }
}

/// All of a scene in a view, at twice its size.
pub(super) fn from_far(scene: &Scene, from: &View) -> Frame {
    render(scene, from, Selection::All, &RenderOptions { scale: 2, ..RenderOptions::default() })
}

#[cfg(test)]
mod tests {
    use cullet::{Culler, Output};
    use cullet_testkit::answers::cull;
    use cullet_testkit::views::look;

    use super::*;
    use crate::picture::palette::SEEN;

    #[test]
    fn who_looks_moves_and_what_was_decided_stays() {
        let scene = cullet_scenes::build("solids:n=20").unwrap().scene;
        let view = look([0.0, 1.0, 9.0], [0.0, 0.5, 0.0], [160, 90]);
        let culler =
            Culler::default().with_output(Output::Triangles).with_reasons(true).with_dropped(true);
        let visible = cull(&culler, &scene, &view);
        let frozen = FrozenView::new(&scene, Cow::Borrowed(&view), Cow::Borrowed(&visible));
        let counts = frozen.counts();
        let all: u64 = counts.iter().map(|c| c.2).sum();
        assert_eq!(all, scene.triangle_count());
        // From where it was culled, nothing that was dropped is in sight.
        let own = frozen.draw(&view);
        let behind = frozen.draw(&look([0.0, 1.0, -9.0], [0.0, 0.5, 0.0], [160, 90]));
        let hue = |p: &Picture| {
            // What faces away; yellow, which is kept, may be seen between the samples of the view.
            let pink =
                |c: &&[u8; 3]| c[0] > c[1].saturating_add(30) && c[2] > c[1].saturating_add(15);
            p.rgb.as_chunks::<3>().0.iter().filter(pink).count()
        };
        assert_eq!(hue(&own), 0);
        assert!(hue(&behind) > 200, "{}", hue(&behind));
        assert!(counts.iter().any(|c| c.0 == SEEN && c.2 > 0));
        assert_eq!(frozen.draw(&view), own);
    }
}
