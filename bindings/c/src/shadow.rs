//! Lights: which of them matter for a view, and what casts their shadows.

use cullet_cells::query::{LightOptions, LightReason as EngineReason, cull_lights};
use engine::ShadowView;
use engine::cull::shadow::Light as EngineLight;

use crate::cull::{Asked, Frame, STATES, State, given, settings_of};
use crate::memory::{Out, Plain, read, reserved, value};
use crate::scene::{SCENES, Scene};
use crate::settings::Settings;
use crate::status::{Error, Result, Status, call};
use crate::view::{View, to_engine};

/// Kinds of lights.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub enum LightKind {
    /// Parallel rays, as of the sun.
    Directional = 0,
    /// A light that shines all around.
    Point = 1,
    /// A light that shines into a cone.
    Spot = 2,
}

/// A light that casts shadows, in world space. Numbers that make no light keep every caster.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Light {
    /// A `cullet_light_kind`.
    pub kind: u32,
    /// 0.
    pub reserved: u32,
    /// Where it is; not read for a directional light.
    pub position: [f64; 3],
    /// The way the light travels, of any length above 0; not read for a point light.
    pub direction: [f64; 3],
    /// How far it reaches, in world units: `INFINITY` for no limit; one that is not above 0 lights
    /// nothing. Not read for a directional light.
    pub range: f64,
    /// Spot: the angle between the axis and the side of the cone, in radians.
    pub half_angle: f64,
}

impl Plain for Light {}

impl Light {
    fn to_engine(self, name: std::fmt::Arguments<'_>) -> Result<EngineLight> {
        let Self { position, direction, range, half_angle, .. } = self;
        reserved(format_args!("{name} reserved"), self.reserved)?;
        match self.kind {
            0 => Ok(EngineLight::Directional { direction }),
            1 => Ok(EngineLight::Point { position, range }),
            2 => {
                let half_angle_radians = half_angle;
                Ok(EngineLight::Spot { position, direction, half_angle_radians, range })
            }
            kind => {
                let message =
                    format!("{name} kind is {kind}: it must be 0 to 2, a cullet_light_kind");
                Err(Error::value(message))
            }
        }
    }
}

/// The shadows of a light that are wanted. Set it to zero before its fields.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Shadow {
    /// The light.
    pub light: Light,
    /// The view that the shadow map is drawn with; NULL where it is not known yet. With one, what is
    /// outside of it or hidden in it is dropped too, and layers, faces and sizes are those of it.
    pub map: *const View,
    /// The state of the camera's own cull of the scene as it is: then only what casts a shadow on
    /// what that found visible is kept. 0 for shadows on any place that the camera shows.
    pub receivers: State,
    /// Shadows may be wrong by so much to every side, in world units, for blurred edges; at least 0.
    pub margin: f64,
    /// A cascade of the camera, by distance along its direction: where it begins. Both 0 for all of
    /// what the camera sees.
    pub slice_near: f64,
    /// Where the cascade ends; INFINITY in perspective for no end.
    pub slice_far: f64,
}

impl Plain for Shadow {}

/// Culls a scene for a light: what must be drawn into its shadow map so that the picture of
/// `camera` has its shadows. `cullet_visible_slots` and its like read the result. For the cascades
/// of a sun call it once for each, with one state each. Conservative: what is dropped casts no
/// shadow that the camera sees. The same stages by the same `settings` (NULL for
/// `CULLET_PRESET_BALANCED`) as `cullet_cull`; of a culled instance, stage `CULLET_STAGE_FRUSTUM`
/// says that its shadow cannot matter. Portals and visible sets play no part. Cost: that of a view.
/// Allocates nothing once `state` has grown. Reads the scene and `receivers`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_cull_shadow(
    scene: Scene,
    camera: *const View,
    shadow: *const Shadow,
    settings: *const Settings,
    state: State,
) -> Status {
    call("cullet_cull_shadow", || {
        // SAFETY: as the header asks of the caller.
        let camera = unsafe { value("camera", camera) }?;
        // SAFETY: as the header asks of the caller.
        let shadow = unsafe { value("shadow", shadow) }?;
        let culler = settings_of(settings)?;
        let light = shadow.light.to_engine(format_args!("shadow->light"))?;
        if shadow.margin.is_nan() || shadow.margin < 0.0 {
            let message = format!("shadow->margin is {}: it must be at least 0", shadow.margin);
            return Err(Error::value(message));
        }
        let mut seen = to_engine(&camera)?;
        if shadow.slice_near != 0.0 || shadow.slice_far != 0.0 {
            seen = seen
                .slice(shadow.slice_near, shadow.slice_far)
                .map_err(|e| Error::new(Status::View, format!("the slice of the shadow: {e}")))?;
        }
        let mut shadows = ShadowView::new(seen, light);
        shadows.margin_world = shadow.margin;
        if !shadow.map.is_null() {
            // SAFETY: as the header asks of the caller.
            shadows.map = Some(to_engine(&unsafe { value("shadow->map", shadow.map) }?)?);
        }
        let scene = SCENES.get(scene.id)?;
        if shadow.receivers.id != 0 {
            if shadow.receivers.id == state.id {
                let message = "shadow->receivers is the state that takes the shadow: take another";
                return Err(Error::value(message));
            }
            let receivers = STATES.get(shadow.receivers.id)?;
            receivers.check_camera(&scene)?;
            shadows = shadows
                .receiving(&scene, &receivers.visible)
                .map_err(|e| Error::new(Status::NoResult, e.to_string()))?;
        }
        let mut state = STATES.get_mut(state.id)?;
        let asked = (Asked::Shadow, camera, given(settings)?);
        state.answer(&scene, asked, &culler, |own, visible| {
            culler.cull_shadow(&scene, &shadows, own, visible);
            Ok(())
        })
    })
}

/// Why a light does not matter for a view.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub enum LightReason {
    /// It may matter.
    Kept = 0,
    /// It lights nothing at all.
    Unlit = 1,
    /// Everything that it reaches is outside the view.
    Frustum = 2,
    /// Everything that it reaches is hidden.
    Occlusion = 3,
    /// It reaches nothing that the view was found to see.
    NoReceiver = 4,
}

fn reason_of(reason: Option<EngineReason>) -> u8 {
    let found = match reason {
        Some(EngineReason::Unlit) => LightReason::Unlit,
        Some(EngineReason::Frustum) => LightReason::Frustum,
        Some(EngineReason::Occlusion) => LightReason::Occlusion,
        Some(EngineReason::NoReceiver) => LightReason::NoReceiver,
        // Lossy reasons are off, and one that is not known here is none to drop a light for.
        _ => LightReason::Kept,
    };
    found as u8
}

/// Finds the lights that can change the picture of the view that `state` was last culled for by
/// `cullet_cull` or `cullet_cull_among`, and writes a `cullet_light_reason` for each, one byte: 0 is
/// kept. Uses what that cull found visible, and its occlusion buffer. The scene must be as it was
/// culled. Conservative: what is dropped lights no point that the view sees; light that is
/// scattered on its way, as in fog, is not thought of. Cost: a few tests a light, and a walk of the
/// hierarchy for each that is left. Allocates nothing once `state` has seen as many. Reads the
/// scene, and needs `state` alone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_cull_lights(
    scene: Scene,
    state: State,
    lights: *const Light,
    count: usize,
    reasons: *mut u8,
) -> Status {
    call("cullet_cull_lights", || {
        // SAFETY: as the header asks of the caller.
        let given = unsafe { read("lights", lights, count) }?;
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::array("reasons", reasons, count) }?;
        let scene = SCENES.get(scene.id)?;
        let mut own = STATES.get_mut(state.id)?;
        let (view, has_buffer) = own.check_camera(&scene)?;
        let view = to_engine(&view)?;
        let Frame { view: state, visible, lights, light_answer, .. } = &mut *own;
        lights.clear();
        for (at, light) in given.iter().enumerate() {
            lights.push(light.to_engine(format_args!("lights[{at}]"))?);
        }
        let buffer = state.occlusion_buffer().filter(|_| has_buffer);
        let options = LightOptions { buffer, visible: Some(&*visible), ..LightOptions::default() };
        cull_lights(&scene, &view, lights, &options, light_answer);
        for (at, reason) in light_answer.reasons.iter().enumerate() {
            out.set(at, reason_of(*reason));
        }
        Ok(())
    })
}
