//! Calls on a view beside its cull: candidates, and the lights that can change its picture.

use alloc::vec::Vec;

use cullet::cull::shadow::Light;
use cullet::{ViewState, Visible};
use cullet_cells::query::{
    LightAnswer, LightOptions, LightReason, cull_light_casters, cull_lights,
};

use super::{SceneView, no_camera};
use crate::fault::{Code, Fault, has_room};
use crate::listing::Ascending;
use crate::scene::SceneSet;

/// Numbers of a light: kind, position, direction, half angle in radians, range.
pub(crate) const LIGHT_NUMBERS: usize = 9;

/// Lights of a view, their answer and their casters.
#[derive(Debug, Default)]
pub struct Lights {
    lights: Vec<Light>,
    answer: LightAnswer,
    states: Vec<ViewState>,
    casters: Vec<Visible>,
    reasons: Vec<u8>,
    receivers: Vec<f64>,
    rows: Vec<f64>,
    ascending: Ascending,
    mask: Vec<u64>,
    /// The scene and its state that the casters are of.
    seen: Option<(u64, u64)>,
}

impl Lights {
    /// Bit of the flags: lights what the last cull found visible, instead of any place.
    pub const ON_VISIBLE: u32 = 1;
    /// Bit of the flags: finds the casters of each light.
    pub const CASTERS: u32 = 2;

    /// The numbers of the lights that may matter, ascending.
    pub fn kept(&self) -> &[u32] {
        &self.answer.kept
    }

    /// A byte for each light: 0 kept, else which of [`LightReason::ALL`], from 1.
    pub fn reasons(&self) -> &[u8] {
        &self.reasons
    }

    /// Six numbers for each kept light: the box in world space around all that the view sees and
    /// the light reaches; infinite where that is not known.
    pub fn receivers(&self) -> &[f64] {
        &self.receivers
    }

    /// Three numbers for each stage that ran: its reason as in [`reasons`](Self::reasons), how many
    /// lights came to it, how many it left.
    pub fn rows(&self) -> &[f64] {
        &self.rows
    }
}

fn light_of(&[kind, x, y, z, u, v, w, half_angle_radians, range]: &[f64; LIGHT_NUMBERS]) -> Light {
    let (position, direction) = ([x, y, z], [u, v, w]);
    match kind {
        0.0 => Light::Directional { direction },
        1.0 => Light::Point { position, range },
        _ => Light::Spot { position, direction, half_angle_radians, range },
    }
}

fn number_of(reason: LightReason) -> u8 {
    let at = LightReason::ALL.iter().position(|&r| r == reason);
    at.map_or(0, |at| at as u8 + 1)
}

impl SceneView {
    /// Culls a scene among candidates: instances by ids, in any order. All others are dropped. The
    /// ids of what is visible lie at [`ids`](Self::ids).
    ///
    /// # Errors
    /// If an id names no instance, or there is no camera yet.
    pub fn cull_among(&mut self, set: &SceneSet, candidates: &[u32]) -> Result<(), Fault> {
        let scene = set.scene();
        let mut mask = core::mem::take(&mut self.lights.mask);
        mask.clear();
        mask.resize(scene.slot_count().div_ceil(64) as usize, 0);
        for &id in candidates {
            let handle = set.handle(id)?;
            let slot = scene.slot(handle).map_err(|error| Fault::new(Code::Id, error))?;
            mask[slot as usize / 64] |= 1 << (slot % 64);
        }
        let view = self.view.as_ref().ok_or_else(no_camera)?;
        self.culler
            .cull_among(scene, view, &mask, &mut self.state, &mut self.visible)
            .map_err(|error| Fault::new(Code::Argument, error))?;
        self.lights.mask = mask;
        self.list(set);
        Ok(())
    }

    /// Finds the lights that can change the picture of the last cull; nine numbers a light. The
    /// answer lies at [`lights`](Self::lights).
    ///
    /// # Errors
    /// If the view has no camera; with [`Lights::ON_VISIBLE`], if scene or camera have changed
    /// since the last cull.
    pub fn cull_lights(
        &mut self,
        set: &SceneSet,
        numbers: &[f64],
        flags: u32,
    ) -> Result<(), Fault> {
        if !has_room(numbers.len().saturating_mul(32)) {
            return Err(Fault::new(Code::Memory, "no memory for as many lights"));
        }
        let is_on_visible = flags & Lights::ON_VISIBLE != 0;
        if is_on_visible {
            self.check_culled(set)?;
        }
        let view = self.camera()?.clone();
        let scene = set.scene();
        let mut own = core::mem::take(&mut self.lights);
        own.lights.clear();
        own.lights.extend(numbers.as_chunks::<LIGHT_NUMBERS>().0.iter().map(light_of));
        let options = LightOptions {
            simd: self.culler.simd,
            detail: None,
            buffer: self.state.occlusion_buffer().filter(|_| is_on_visible),
            visible: Some(&self.visible).filter(|_| is_on_visible),
        };
        cull_lights(scene, &view, &own.lights, &options, &mut own.answer);
        own.reasons.clear();
        own.reasons.extend(own.answer.reasons.iter().map(|r| r.map_or(0, number_of)));
        own.receivers.clear();
        let origin = scene.origin();
        for receivers in &own.answer.receivers {
            // One more rounding, outward.
            let corners = receivers.map(|b| [b.min, b.max].map(|p| p.map(f64::from)));
            let [min, max] = corners.unwrap_or([[f64::NEG_INFINITY; 3], [f64::INFINITY; 3]]);
            own.receivers.extend((0..3).map(|a| (min[a] + origin[a]).next_down()));
            own.receivers.extend((0..3).map(|a| (max[a] + origin[a]).next_up()));
        }
        own.rows.clear();
        for row in &own.answer.rows {
            own.rows.extend([number_of(row.stage).into(), row.entered as f64, row.left as f64]);
        }
        own.casters.clear();
        own.seen = Some((scene.id(), scene.change_version()));
        if flags & Lights::CASTERS != 0 {
            let of = (&view, &own.lights[..], &own.answer);
            cull_light_casters(&self.culler, scene, of, &mut own.states, &mut own.casters);
        }
        self.lights = own;
        Ok(())
    }

    /// The answer of [`cull_lights`](Self::cull_lights).
    pub fn lights(&self) -> &Lights {
        &self.lights
    }

    /// The ids of the casters of the `at`th kept light, ascending; none where casters were not
    /// wanted.
    ///
    /// # Errors
    /// If the scene has changed since the lights were culled.
    pub fn casters(&mut self, set: &SceneSet, at: usize) -> Result<&[u32], Fault> {
        let (own, scene) = (&mut self.lights, set.scene());
        let Some(casters) = own.casters.get(at) else { return Ok(&[]) };
        if own.seen != Some((scene.id(), scene.change_version())) {
            let message = "the scene has changed since the lights were culled: call lights() again";
            return Err(Fault::new(Code::Argument, message));
        }
        let ids = casters.slots().filter_map(|slot| Some(scene.handle(slot)?.index));
        own.ascending.fill(self.culler.simd, set.id_count(), ids);
        Ok(own.ascending.list())
    }
}
