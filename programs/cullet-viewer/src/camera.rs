//! Cameras as a user moves them: around a point, free, or from above. Angles in degrees, so that
//! links read well.

use cullet::view::ViewError;
use cullet::{Camera, Depth, Projection, View};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// The steepest pitch: at the pole itself there is no heading.
const MAX_PITCH: f64 = 89.0;

/// How a camera is moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// Turning goes around the target.
    #[default]
    Orbit,
    /// Turning goes around the eye; keys move.
    Fly,
    /// Straight down, parallel, north up.
    Top,
}

/// A camera as a user moves it: a target, and where the eye stands from there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Rig {
    /// How it is moved.
    pub mode: Mode,
    /// The point that it looks at.
    pub target: [f64; 3],
    /// How far the eye is from the target, above 0.
    pub distance: f64,
    /// The heading in degrees: 0 looks along −Z, 90 along −X.
    pub yaw: f64,
    /// Degrees above the horizon that it looks; negative looks down.
    pub pitch: f64,
    /// Vertical field of view in degrees.
    pub fov: f64,
    /// Distance of the near plane, above 0. The far plane is at infinity.
    pub near: f64,
}

impl Default for Rig {
    fn default() -> Self {
        Self {
            mode: Mode::Orbit,
            target: [0.0; 3],
            distance: 10.0,
            yaw: 30.0,
            pitch: -25.0,
            fov: 60.0,
            near: 0.05,
        }
    }
}

impl Rig {
    /// The rig that stands and looks as `camera` does, with its target at `distance`. What cannot
    /// be said of a rig (roll, off-centre windows) is lost.
    #[must_use]
    pub fn of(camera: &Camera, distance: f64) -> Self {
        let d = DVec3::from(camera.direction).normalize_or(DVec3::NEG_Z);
        let distance = if distance > 0.0 && distance.is_finite() { distance } else { 1.0 };
        let pitch = d.y.clamp(-1.0, 1.0).asin().to_degrees().clamp(-MAX_PITCH, MAX_PITCH);
        let (fov, near) = match camera.projection {
            Projection::Perspective { fov_y_radians, near, .. } => {
                (fov_y_radians.to_degrees(), near)
            }
            _ => (60.0, distance * 1e-3),
        };
        Self {
            mode: Mode::Orbit,
            target: (DVec3::from(camera.eye) + d * distance).into(),
            distance,
            yaw: (-d.x).atan2(-d.z).to_degrees(),
            pitch,
            fov,
            near,
        }
    }

    /// Checks every number; the error names the invalid one, its value, and what it must be.
    ///
    /// # Errors
    /// If a number is not finite or out of its range.
    pub fn check(&self) -> Result<(), (&'static str, f64, &'static str)> {
        for v in self.target {
            if !(-1e12..=1e12).contains(&v) {
                return Err(("camera.target", v, "within 1e12 of zero"));
            }
        }
        let range = |what, v: f64, low: f64, high: f64, must| {
            if (low..=high).contains(&v) { Ok(()) } else { Err((what, v, must)) }
        };
        range("camera.distance", self.distance, 1e-9, 1e12, "between 1e-9 and 1e12")?;
        range("camera.yaw", self.yaw, -1e6, 1e6, "an angle in degrees")?;
        range("camera.pitch", self.pitch, -MAX_PITCH, MAX_PITCH, "between -89 and 89 degrees")?;
        range("camera.fov", self.fov, 1.0, 150.0, "between 1 and 150 degrees")?;
        range("camera.near", self.near, 1e-12, 1e9, "between 1e-12 and 1e9")
    }

    /// The unit direction that it looks in.
    #[must_use]
    pub fn forward(&self) -> [f64; 3] {
        if self.mode == Mode::Top {
            return [0.0, -1.0, 0.0];
        }
        let (sin, cos) = self.yaw.to_radians().sin_cos();
        let (up, out) = self.pitch.to_radians().sin_cos();
        [-sin * out, up, -cos * out]
    }

    /// Where the eye is.
    #[must_use]
    pub fn eye(&self) -> [f64; 3] {
        (DVec3::from(self.target) - DVec3::from(self.forward()) * self.distance).into()
    }

    /// Unit vectors to the right and up on the screen.
    #[must_use]
    pub fn axes(&self) -> [[f64; 3]; 2] {
        let (sin, cos) = self.yaw.to_radians().sin_cos();
        let right = DVec3::new(cos, 0.0, -sin);
        let up = right.cross(DVec3::from(self.forward()));
        [right.into(), up.into()]
    }

    /// The camera for pictures of `aspect`, width over height.
    #[must_use]
    pub fn camera(&self, aspect: f64) -> Camera {
        let projection = if self.mode == Mode::Top {
            let (y, x) = (self.distance * 0.5, self.distance * 0.5 * aspect);
            // From as far above as below: a parallel view has no eye to be behind of.
            let depth = self.distance.max(1e-3) * 64.0;
            Projection::Orthographic {
                left: -x,
                right: x,
                bottom: -y,
                top: y,
                near: -depth,
                far: depth,
            }
        } else {
            let fov_y_radians = self.fov.to_radians();
            Projection::Perspective { fov_y_radians, aspect, near: self.near, far: f64::INFINITY }
        };
        Camera { eye: self.eye(), direction: self.forward(), up: self.axes()[1], projection }
    }

    /// The view on a viewport of `size` pixels, with reversed depth.
    ///
    /// # Errors
    /// If the numbers make no view.
    pub fn view(&self, size: [u32; 2]) -> Result<View, ViewError> {
        let aspect = f64::from(size[0].max(1)) / f64::from(size[1].max(1));
        View::new(&self.camera(aspect), Depth::Reversed, size)
    }

    /// Turns by degrees: around the target, or around the eye in flight.
    pub fn turn(&mut self, yaw: f64, pitch: f64) {
        let eye = self.eye();
        self.yaw = (self.yaw + yaw + 180.0).rem_euclid(360.0) - 180.0;
        self.pitch = (self.pitch + pitch).clamp(-MAX_PITCH, MAX_PITCH);
        if self.mode == Mode::Fly {
            self.target = (DVec3::from(eye) + DVec3::from(self.forward()) * self.distance).into();
        }
    }

    /// Moves sideways and up by shares of the picture's height at the target's distance.
    pub fn pan(&mut self, right: f64, up: f64) {
        let height = match self.mode {
            Mode::Top => self.distance,
            _ => 2.0 * self.distance * (self.fov.to_radians() * 0.5).tan(),
        };
        self.shift(right * height, up * height, 0.0);
    }

    /// Moves by world units to the right, up and forward.
    pub fn shift(&mut self, right: f64, up: f64, forward: f64) {
        let [r, u] = self.axes().map(DVec3::from);
        let moved =
            DVec3::from(self.target) + r * right + u * up + DVec3::from(self.forward()) * forward;
        if moved.abs().max_element() < 1e12 {
            self.target = moved.into();
        }
    }

    /// Comes nearer by a factor (above 1) or goes farther (below 1); in flight it moves on instead.
    pub fn zoom(&mut self, factor: f64) {
        if !(factor > 0.0 && factor.is_finite()) {
            return;
        }
        if self.mode == Mode::Fly {
            self.shift(0.0, 0.0, self.distance * (1.0 - 1.0 / factor));
        } else {
            self.distance = (self.distance / factor).clamp(1e-6, 1e11);
        }
    }

    /// A camera behind and above this one, that has its frustum and much of the scene before it;
    /// and where this one is outside of the scene, whose middle is `centre` and whose radius is
    /// `reach`, one that looks at the scene from aside and sees it about as large. The farther out,
    /// from 1 to 1.5 radii, the more of the second.
    #[must_use]
    pub fn outside(&self, centre: [f64; 3], reach: f64, chase: &Chase) -> Self {
        let (eye, centre) = (DVec3::from(self.eye()), DVec3::from(centre));
        let (sin, cos) = self.yaw.to_radians().sin_cos();
        let heading = DVec3::new(-sin, 0.0, -cos);
        let away = eye.distance(centre) / reach;
        let out = ((away - 1.0) * 2.0).clamp(0.0, 1.0);
        const FOV: f64 = 50.0;
        let half = |fov: f64| (fov * 0.5).to_radians().tan();
        let between = |near: f64, far: f64| near + (far - near) * out;
        Self {
            mode: Mode::Orbit,
            target: (eye + heading * (0.25 * reach)).lerp(centre, out).into(),
            distance: reach * between(0.95, away * half(self.fov) / half(FOV)) / chase.nearer,
            yaw: self.yaw + chase.yaw + between(0.0, 75.0),
            pitch: chase.pitch.clamp(-MAX_PITCH, MAX_PITCH),
            fov: FOV,
            near: reach * 1e-3,
        }
    }
}

/// How the camera outside follows the one that culls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chase {
    /// Degrees that it is turned about it.
    pub yaw: f64,
    /// Degrees above the horizon that it looks; negative looks down.
    pub pitch: f64,
    /// Above 1 is nearer.
    pub nearer: f64,
}

impl Chase {
    /// Returns the camera a share of the way from this one to another.
    #[must_use]
    pub fn towards(&self, to: &Self, share: f64) -> Self {
        let between = |a: f64, b: f64| a + (b - a) * share;
        Self {
            yaw: between(self.yaw, to.yaw),
            pitch: between(self.pitch, to.pitch),
            nearer: between(self.nearer, to.nearer),
        }
    }
}

impl Default for Chase {
    fn default() -> Self {
        Self { yaw: 28.0, pitch: -32.0, nearer: 1.0 }
    }
}
