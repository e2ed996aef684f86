//! From all triangles to those that are seen, kind of culling after kind of culling: each rung a
//! cull of its own.

use cullet::{Backface, Culler, Scene, Stage, View, ViewState, Visible};

/// The cullers of the lower rungs, each with what its last view left behind.
#[derive(Debug)]
pub(crate) struct Ladder {
    frustum: (Culler, ViewState),
    backfaces: (Culler, ViewState),
    result: Visible,
}

impl Ladder {
    /// The rungs below `culler`: its frustum alone; then what faces away or has no area, too.
    pub(crate) fn new(culler: &Culler) -> Self {
        let plain = culler.clone().with_reasons(false).with_dropped(false).with_clock(None);
        let below = [Stage::Pvs, Stage::Portal, Stage::Detail, Stage::Occlusion, Stage::Lod];
        let backfaces = below.into_iter().fold(plain, |c, stage| c.without(stage));
        let frustum = backfaces.clone().with_backface(Backface::Off).with_degenerate(false);
        let rung = |culler| (culler, ViewState::default());
        Self { frustum: rung(frustum), backfaces: rung(backfaces), result: Visible::default() }
    }

    /// The triangles that the frustum leaves, and those of them that do not face away.
    pub(crate) fn climb(&mut self, scene: &Scene, view: &View) -> [u64; 2] {
        [&mut self.frustum, &mut self.backfaces].map(|(culler, state)| {
            culler.cull_one(scene, view, state, &mut self.result);
            self.result.triangle_count
        })
    }
}

#[cfg(test)]
mod tests {
    use cullet::Output;
    use cullet_testkit::answers::cull;
    use cullet_testkit::scenes::city;
    use cullet_testkit::views::look;

    use super::*;

    #[test]
    fn each_rung_takes_what_it_is_named_for() {
        let mut scene = city(6, 1, 60);
        let culler = Culler::exact().with_output(Output::Triangles);
        scene.prepare(&culler);
        let view = look([5.0, 3.0, 90.0], [30.0, 2.0, 0.0], [160, 90]);
        let [framed, facing] = Ladder::new(&culler).climb(&scene, &view);
        let left = cull(&culler, &scene, &view).triangle_count;
        assert!(scene.triangle_count() > framed && framed > facing && facing > left);
        let only = cull(&culler.only(Stage::Frustum), &scene, &view).triangle_count;
        assert_eq!(framed, only);
    }
}
