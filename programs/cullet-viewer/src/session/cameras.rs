//! Cameras of a session: which one culls, freezing it, going out to look, and fitting it to the
//! scene.

use cullet::View;
use glam::DVec3;

use super::Session;
use crate::camera::{Mode, Rig};
use crate::cutaway::planes;
use crate::state::{GhostForm, Layout, Manner, Part};

impl Session {
    /// The rig that decides what is drawn.
    #[must_use]
    pub fn culling_rig(&self) -> Option<&Rig> {
        self.state.frozen.as_ref().or(self.state.camera.as_ref())
    }

    /// The size of the pane that shows what the culling camera sees.
    #[must_use]
    pub fn culling_size(&self) -> [u32; 2] {
        match self.state.layout {
            Layout::Split | Layout::Buffer => [(self.size[0] / 2).max(1), self.size[1]],
            _ => self.size,
        }
    }

    /// The view that decides what is drawn.
    #[must_use]
    pub fn culling_view(&self) -> Option<View> {
        let mut view = self.culling_rig()?.view(self.culling_size()).ok()?;
        view.cull_face = self.state.look.cull;
        view.front_face = self.state.look.front_face();
        Some(view)
    }

    /// Freezes what is drawn, or lets it follow the flown camera again.
    pub fn toggle_freeze(&mut self) {
        self.state.frozen = match self.state.frozen.take() {
            Some(_) => None,
            None => self.state.camera,
        };
    }

    /// Freezes what is drawn and goes out to look at it; the way back is the frozen camera's place.
    pub fn toggle_outside(&mut self) {
        match self.state.frozen.take() {
            Some(back) => self.state.camera = Some(back),
            None => {
                self.state.frozen = self.state.camera;
                self.state.camera = self.outside();
            }
        }
    }

    /// Shows what was dropped in this form. From where the culler looks nothing of it is to be
    /// seen, so that one flies out.
    pub fn show_ghosts(&mut self, form: GhostForm) {
        self.state.ghosts.form = form;
        let inside = self.state.frozen.is_none() && self.state.layout == Layout::One;
        if form != GhostForm::Off && inside {
            self.toggle_outside();
        }
    }

    /// The camera behind and above the culling one, or beside a scene that it sees from without.
    #[must_use]
    pub fn outside(&self) -> Option<Rig> {
        let world = self.world.as_ref()?;
        Some(self.culling_rig()?.outside(world.centre, world.reach, &self.chase))
    }

    /// Shows a scene for the first time: a small one in such a way that what is culled of it is
    /// seen, unless a link or the user has chosen another way.
    pub(super) fn begin(&mut self) {
        let Some(world) = self.world.clone() else { return };
        let as_it_began = self.is_as_it_began();
        if as_it_began || Manner::of(&self.state) == Manner::default() {
            let manner = world.manner();
            manner.apply(&mut self.state);
            self.manner = Some(manner);
        }
        self.stand();
    }

    /// Puts the flown camera where one begins: before a small scene, and in the midst of a large
    /// one.
    pub(super) fn stand(&mut self) {
        match &self.world {
            Some(world) if world.is_large() => {
                self.state.camera = Some(world.first_sight(self.size));
            }
            _ => self.fit(),
        }
    }

    /// Whether the scene is still shown in the manner that it was shown in at first.
    #[must_use]
    pub fn is_as_it_began(&self) -> bool {
        self.manner.as_ref() == Some(&Manner::of(&self.state))
    }

    /// Fits the flown camera to the scene and to the pane that it is for.
    pub fn fit(&mut self) {
        if let Some(world) = &self.world {
            let mode = self.state.camera.map_or(Mode::Orbit, |c| c.mode);
            let rig = world.overview(self.culling_size());
            self.state.camera = Some(match mode {
                Mode::Top => world.top(&Rig { target: world.centre, distance: 0.0, ..rig }),
                mode => Rig { mode, ..rig },
            });
            self.fitted = self.state.camera.map(|rig| (rig, self.culling_size()));
        }
    }

    /// Fits the camera again where its pane has another size and it was not moved since it was
    /// fitted.
    pub(super) fn fit_again(&mut self) {
        let Some((rig, size)) = self.fitted else { return };
        let still = self.state.camera == Some(rig) && self.state.frozen.is_none();
        if still && size != self.culling_size() {
            self.fit();
        }
    }

    /// How much nearer the flown camera is than the one that shows the whole scene: 1 is that, 2
    /// twice as near.
    #[must_use]
    pub fn scale(&self) -> f64 {
        match (&self.world, &self.state.camera) {
            (Some(world), Some(rig)) => world.reach * 2.0 / rig.distance,
            _ => 1.0,
        }
    }

    /// Looks straight at the cut, from far away through a narrow lens, so that it is drawn almost
    /// to scale.
    pub fn face_cut(&mut self) {
        let Some(world) = self.whole() else { return };
        let Some(plane) = planes(&self.state.cut, world).first().copied() else { return };
        let (reach, centre) = (world.reach, DVec3::from(world.centre));
        let inside = self.state.cut.part == Part::Inside;
        let n = DVec3::from(plane.normal) * if inside { 1.0 } else { -1.0 };
        let foot = centre - DVec3::from(plane.normal) * plane.distance(centre);
        // Looking against the normal; straight down or up there is no heading to keep.
        let d = -n;
        let fov: f64 = 4.0;
        let distance = reach * 1.05 / (fov.to_radians() * 0.5).tan();
        self.state.camera = Some(Rig {
            mode: Mode::Orbit,
            target: foot.into(),
            distance,
            yaw: if d.x.hypot(d.z) > 1e-6 { (-d.x).atan2(-d.z).to_degrees() } else { 0.0 },
            pitch: d.y.clamp(-1.0, 1.0).asin().to_degrees().clamp(-89.0, 89.0),
            fov,
            near: distance * 0.5,
        });
        self.state.frozen = None;
    }
}
