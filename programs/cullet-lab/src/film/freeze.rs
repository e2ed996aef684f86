//! The eye goes along a street; culling freezes, and the eye that looks flies out.

use std::borrow::Cow;

use cullet::{Culler, Output, Projection, View, ViewState, Visible};
use cullet_command::exit::Failure;
use cullet_command::inputs;
use cullet_draw::{FrozenView, Outlook, Picture};
use cullet_io::Model;
use cullet_scenes::paths::{self, Overrides, PathSpec};
use glam::{DQuat, DVec3};

use super::args::FilmArgs;
use super::path::{Lens, Stand, ease, free_ahead, stand_of};
use super::script::{Script, plain};

/// When the eye stands, when the other flies, and when that has arrived, as shares of the film.
const STANDS: f64 = 0.26;
const FLIES: f64 = 0.34;
const ARRIVED: f64 = 0.80;
/// How far the eye goes of what is free before it.
const OF_FREE: f64 = 0.45;
/// And at the most, as a share of how far the scene reaches.
const OF_SCENE: f64 = 0.12;
/// How far the outer eye goes round in the end, in degrees.
const ROUND: f64 = 12.0;

/// The film.
pub(super) struct Freeze<'a> {
    model: &'a Model,
    colors: Vec<[f32; 4]>,
    culler: Culler,
    lens: Lens,
    state: ViewState,
    /// Where the walk begins and where culling freezes.
    walk: [Stand; 2],
    /// From where all is seen in the end.
    outside: Stand,
    outside_fov: f64,
    frozen: Option<(FrozenView<'a>, Vec<Key>)>,
}

/// A colour, and what it means.
type Key = ([u8; 3], String);

impl<'a> Freeze<'a> {
    pub(super) fn new(model: &'a Model, args: &FilmArgs) -> Result<Self, Failure> {
        let scene = &model.scene;
        let overrides = Overrides { seed: args.seed, ..Overrides::default() };
        // The place of the picture of kinds: the third of eight.
        let cameras = paths::cameras(model, &PathSpec::Walk, 8, args.size, &overrides);
        let camera = cameras.map_err(Failure::input)?[2];
        let view = View::new(&camera, overrides.depth, args.size).map_err(Failure::usage)?;
        let [near, _] = paths::range(&camera.projection);
        let fov_y_radians = match camera.projection {
            Projection::Perspective { fov_y_radians, .. } => fov_y_radians,
            _ => paths::DEFAULT_FOV_DEGREES.to_radians(),
        };
        let nowhere = || Failure::input("the walk of this scene has no eye to stand at");
        let reach = DVec3::from(scene.extent().half_extent()).length();
        let way = (free_ahead(scene, &view) * OF_FREE).min(reach * OF_SCENE);
        let start = stand_of(&view, reach * 0.2).ok_or_else(nowhere)?;
        let along = (start.target - start.eye).normalize_or_zero() * way;
        let end = Stand { eye: start.eye + along, target: start.target + along };
        let lens = Lens { fov_y_radians, near, size: args.size };
        let last = lens.view(end)?;
        let from = Outlook::new(scene, &last, args.size).from;
        let far = stand_of(&from, 1.0).ok_or_else(nowhere)?;
        let outside = stand_of(&from, far.eye.distance(end.eye)).ok_or_else(nowhere)?;
        let culler = inputs::culler(&args.cull)
            .with_output(Output::Triangles)
            .with_reasons(true)
            .with_dropped(true)
            .with_lod(None);
        Ok(Self {
            model,
            colors: inputs::colors(model),
            culler,
            lens,
            state: ViewState::default(),
            walk: [start, end],
            outside,
            outside_fov: OUTSIDE_FOV,
            frozen: None,
        })
    }

    /// Culls a view.
    fn cull(&mut self, view: &View) -> Visible {
        let mut visible = Visible::default();
        self.model.in_cells().cull(&self.culler, view, &mut self.state, &mut visible);
        visible
    }

    /// Where the outer eye is at a share of its flight, and how wide it sees.
    fn flight(&self, share: f64, round: f64) -> (Stand, f64) {
        let [_, from] = self.walk;
        let t = ease(share);
        // Up first, out of the street, and then away.
        let above = DVec3::new(from.eye.x, self.outside.eye.y, from.eye.z);
        let eye = from.eye.lerp(above, t).lerp(above.lerp(self.outside.eye, t), t);
        let target = from.target.lerp(self.outside.target, t);
        let turned = DQuat::from_rotation_y((ROUND * round).to_radians());
        let eye = target + turned * (eye - target);
        let fov = self.lens.fov_y_radians * (1.0 - t) + self.outside_fov * t;
        (Stand { eye, target }, fov)
    }
}

/// Field of view of pictures from outside.
const OUTSIDE_FOV: f64 = 48.0 * std::f64::consts::PI / 180.0;

impl Script for Freeze<'_> {
    fn frame(&mut self, share: f64) -> Result<Picture, Failure> {
        let model = self.model;
        let scene = &model.scene;
        if share < FLIES {
            let t = ease(share / STANDS);
            let [start, end] = self.walk;
            let stand =
                Stand { eye: start.eye.lerp(end.eye, t), target: start.target.lerp(end.target, t) };
            let view = self.lens.view(stand)?;
            let visible = self.cull(&view);
            let mut picture = cullet_draw::even(scene, &view, &visible, &self.colors);
            let (left, all) = (plain(visible.triangle_count), plain(scene.triangle_count()));
            let now = if share < STANDS { "culled every frame" } else { "culling is frozen" };
            cullet_draw::caption(&mut picture, &format!("{now}: {left} of {all} triangles drawn"));
            return Ok(picture);
        }
        if self.frozen.is_none() {
            let view = self.lens.view(self.walk[1])?;
            let visible = self.cull(&view);
            let frozen = FrozenView::new(scene, Cow::Owned(view), Cow::Owned(visible));
            let keys =
                frozen.counts().into_iter().map(|(color, words, _)| (color, words.to_owned()));
            let keys = keys.collect();
            self.frozen = Some((frozen, keys));
        }
        let Some((frozen, keys)) = &self.frozen else {
            return Err(Failure::input("nothing was frozen"));
        };
        let flown = (share - FLIES) / (ARRIVED - FLIES);
        let round = ease((share - ARRIVED) / (1.0 - ARRIVED));
        let (stand, fov_y_radians) = self.flight(flown, round);
        let from = Lens { fov_y_radians, ..self.lens }.view(stand)?;
        let mut picture = frozen.draw(&from);
        cullet_draw::key_strip(&mut picture, keys);
        Ok(picture)
    }
}
