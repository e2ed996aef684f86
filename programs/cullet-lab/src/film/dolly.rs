//! Levels of detail while the eye moves away.

use cullet::{Culler, Output, Scene, Stage, View, ViewState, Visible};
use cullet_command::exit::Failure;
use cullet_command::inputs;
use cullet_draw::{LevelSteps, Picture, palette};
use cullet_io::{Model, shell_word};
use glam::DVec3;

use super::args::FilmArgs;
use super::path::{Lens, Stand, ease};
use super::script::{Script, plain};

/// So many times as far is the eye in the end.
const FAR: f64 = 48.0;
/// From where it looks.
const FROM: DVec3 = DVec3::new(0.45, 0.28, 1.0);
const FOV: f64 = 0.68;
/// The side of the picture of what the eye sees, as a share of the height.
const INSET: u32 = 3;

/// The film.
pub(super) struct Dolly<'a> {
    scene: &'a Scene,
    steps: LevelSteps<'a>,
    culler: Culler,
    pixels: f64,
    state: ViewState,
    visible: Visible,
    lens: Lens,
    middle: DVec3,
    /// How far off the eye is first.
    first: f64,
}

impl<'a> Dolly<'a> {
    pub(super) fn new(model: &'a Model, args: &FilmArgs) -> Result<Self, Failure> {
        let scene = &model.scene;
        let mut culler = inputs::culler(&args.cull);
        let Some(lod) = culler.lod else {
            return Err(Failure::usage(
                "--of dolly: give --lod PX, by how many pixels levels of detail may be off; try --lod 1",
            ));
        };
        if !inputs::has_levels(scene) {
            return Err(Failure::input(format!(
                "{}: no mesh has levels of detail; `cullet bake {} -o baked.glb` writes a file that has them",
                model.name,
                shell_word(&args.scene.scene)
            )));
        }
        // What hides what, and what faces away, would be of the far eye: the near one is to see all
        // of it.
        culler = culler.only(Stage::Lod).with_lod(lod).with_output(Output::Triangles);
        let extent = scene.extent();
        let middle = DVec3::from(scene.origin()) + DVec3::from(extent.center());
        let radius = DVec3::from(extent.half_extent()).length().max(f64::MIN_POSITIVE);
        let aspect = f64::from(args.size[0]) / f64::from(args.size[1]);
        let first = radius / (FOV * 0.5).sin() / aspect.min(1.0);
        let lens = Lens { fov_y_radians: FOV, near: first * 1e-3, size: args.size };
        Ok(Self {
            scene,
            steps: LevelSteps::new(scene),
            culler,
            pixels: lod.pixels,
            state: ViewState::default(),
            visible: Visible::default(),
            lens,
            middle,
            first,
        })
    }

    /// The view from so many times as far as at first.
    fn view(&self, times: f64) -> Result<View, Failure> {
        let eye = self.middle + FROM.normalize() * (self.first * times);
        self.lens.view(Stand { eye, target: self.middle })
    }
}

impl Script for Dolly<'_> {
    fn frame(&mut self, share: f64) -> Result<Picture, Failure> {
        // Away and back again, twice as far in equal times.
        let t = ease(1.0 - (2.0 * share - 1.0).abs());
        let times = FAR.powf(t);
        let (near, far) = (self.view(1.0)?, self.view(times)?);
        self.culler.cull_one(self.scene, &far, &mut self.state, &mut self.visible);
        let mut picture = cullet_draw::even_levels(self.scene, &near, &self.visible, &self.steps);
        let seen = cullet_draw::even_levels(self.scene, &far, &self.visible, &self.steps);
        inset(&mut picture, &seen);
        let (left, all) = (self.visible.triangle_count, self.scene.triangle_count());
        let words = format!(
            "{times:.1} times as far: {} of {} triangles, off by {} px at the most",
            plain(left),
            plain(all),
            self.visible.lod_pixels.unwrap_or(self.pixels)
        );
        cullet_draw::caption(&mut picture, &words);
        let counts = self.steps.count(&self.visible);
        let keys: Vec<([u8; 3], String)> = (0..)
            .zip(&counts)
            .filter(|(_, n)| **n > 0)
            .map(|(step, _)| {
                let words = if step == 0 { "in full".to_owned() } else { format!("level {step}") };
                (palette::level_color(step), words)
            })
            .collect();
        cullet_draw::key_strip(&mut picture, &keys);
        Ok(picture)
    }
}

/// Lays the middle of a picture into the upper right corner of another, at its own size.
fn inset(picture: &mut Picture, seen: &Picture) {
    let side = picture.height / INSET;
    let (left, top) = (i64::from(picture.width - side) - 10, 10);
    picture.fill([left - 2, top - 2], [i64::from(side) + 4; 2], palette::INK, 1.0);
    let [x0, y0] = [seen.width, seen.height].map(|v| v.saturating_sub(side) / 2);
    for y in 0..side {
        for x in 0..side {
            let place = [left + i64::from(x), top + i64::from(y)];
            picture.fill(place, [1, 1], seen.pixel(x0 + x, y0 + y), 1.0);
        }
    }
}
