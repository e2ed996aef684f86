//! Settings of culling: presets, and the fields that matter.

use engine::cull::detail::Detail;
use engine::cull::occlusion::{Occlusion, OcclusionBuffer};
use engine::lod::Lod;
use engine::{Backface, Culler, Output};

use crate::memory::{Out, Plain};
use crate::status::{Error, Result, Status, call};

/// Settings that go together. None has a stage that is lossy.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub enum Preset {
    /// Everything that can be proved, for tools and for renderers to which a triangle costs much.
    Exact = 0,
    /// Stages that pay in most frames: the default.
    Balanced = 1,
    /// Stages that are fastest to run.
    Fast = 2,
}

/// How deep the answer goes.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub enum OutputDepth {
    /// Whole instances.
    Instances = 0,
    /// Instances, and of those that straddle the frustum or are one-sided the clusters that are
    /// left: the default.
    Clusters = 1,
    /// Triangles of every visible instance.
    Triangles = 2,
}

/// How back faces of one-sided meshes are culled.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub enum Backfaces {
    /// Not at all.
    Off = 0,
    /// Clusters by cones, and where the output is triangles, each by a plane of four bytes: the
    /// default.
    Fast = 1,
    /// Every triangle from its corners, where the output is triangles: some fifty times as long.
    Exact = 2,
}

/// Settings of culling. Filled by `cullet_settings_preset`; then any field may be changed. Switches
/// are 0 or 1.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The size of this struct, by which one that was never filled is known.
    pub size: u32,
    /// Cull what is outside the frustum.
    pub frustum: u32,
    /// An exact test for each box that straddles the frustum: drops big boxes near its corners.
    pub frustum_exact: u32,
    /// Cull by the potentially visible sets of a scene that has some.
    pub pvs: u32,
    /// Cull by the cells and portals of a scene that has some.
    pub portals: u32,
    /// A `cullet_backfaces`.
    pub backfaces: u32,
    /// Cull triangles without area.
    pub degenerate: u32,
    /// Cull what lies behind other instances.
    pub occlusion: u32,
    /// Pixels across the occlusion buffer, 1 to 4096, at most the viewport's. More sees smaller
    /// gaps, and costs its square.
    pub occlusion_width: u32,
    /// Budget for drawing occluders, in microseconds of a cost model, from 0.
    pub occlusion_budget: f32,
    /// Share of the cost of drawing what is left that may be spent where nothing is found, from 0;
    /// below 0 for no limit.
    pub occlusion_risk: f32,
    /// Lossy: cull what is narrower and lower than so many pixels. 0, the default, culls nothing
    /// for its size.
    pub detail_pixels: f32,
    /// Lossy: draw levels of detail that are off by at most so many pixels, in scenes that have
    /// levels. 0, the default, draws everything in full.
    pub lod_pixels: f32,
    /// A `cullet_output`.
    pub output: u32,
    /// Record why each instance was culled, for `cullet_visible_reasons`: two bytes a slot. 0 by
    /// default.
    pub reasons: u32,
    /// Lossy: a budget for levels of detail. Where more triangles than this would be drawn, the
    /// pixels of `lod_pixels` are raised until they are not, as far as there are levels;
    /// `cullet_visible_lod` says to how many. Triangles are counted before occlusion culling, and
    /// those without levels in full. 0, the default, for no budget.
    pub lod_triangles: u32,
}

impl Plain for Settings {}

fn preset(number: u32) -> Result<Culler> {
    match number {
        0 => Ok(Culler::exact()),
        1 => Ok(Culler::balanced()),
        2 => Ok(Culler::fast()),
        _ => Err(Error::value(format!("preset {number}: it must be 0 to 2, a cullet_preset"))),
    }
}

fn of_culler(culler: &Culler) -> Settings {
    let occlusion = culler.occlusion.unwrap_or_default();
    Settings {
        size: size_of::<Settings>() as u32,
        frustum: culler.frustum.into(),
        frustum_exact: culler.frustum_exact.into(),
        pvs: culler.pvs.into(),
        portals: culler.portal.into(),
        backfaces: match culler.backface {
            Backface::Off => 0,
            Backface::Fast => 1,
            Backface::Exact => 2,
        },
        degenerate: culler.degenerate.into(),
        occlusion: culler.occlusion.is_some().into(),
        occlusion_width: occlusion.width,
        occlusion_budget: occlusion.budget,
        occlusion_risk: occlusion.risk.unwrap_or(-1.0),
        detail_pixels: 0.0,
        lod_pixels: 0.0,
        output: match culler.output {
            Output::Instances => 0,
            Output::Clusters => 1,
            Output::Triangles => 2,
        },
        reasons: culler.reasons.into(),
        lod_triangles: 0,
    }
}

/// The engine's settings of some that a caller hands in.
pub(crate) fn to_culler(settings: &Settings) -> Result<Culler> {
    let known = size_of::<Settings>() as u32;
    if settings.size != known {
        let message = format!(
            "settings->size is {}, not {known}: fill the settings by cullet_settings_preset",
            settings.size
        );
        return Err(Error::new(Status::StructSize, message));
    }
    let switch = |name: &str, value: u32| match value {
        0 => Ok(false),
        1 => Ok(true),
        _ => Err(Error::value(format!("settings->{name} is {value}: it must be 0 or 1"))),
    };
    let number = |name: &str, value: f32| {
        let is_right = value.is_finite() && value >= 0.0;
        let message = || format!("settings->{name} is {value}: it must be finite and at least 0");
        if is_right { Ok(value) } else { Err(Error::value(message())) }
    };
    let risk = settings.occlusion_risk;
    if risk.is_nan() {
        return Err(Error::value(
            "settings->occlusion_risk is NaN: it must be a share, or below 0",
        ));
    }
    let (width, limit) = (settings.occlusion_width, OcclusionBuffer::LIMIT);
    let has_occlusion = switch("occlusion", settings.occlusion)?;
    if has_occlusion && !(1..=limit).contains(&width) {
        let message = format!("settings->occlusion_width is {width}: it must be 1 to {limit}");
        return Err(Error::value(message));
    }
    let occlusion = Occlusion::default()
        .with_width(width)
        .with_budget(number("occlusion_budget", settings.occlusion_budget)?)
        .with_risk((risk >= 0.0).then_some(risk));
    let detail = f64::from(number("detail_pixels", settings.detail_pixels)?);
    let lod = f64::from(number("lod_pixels", settings.lod_pixels)?);
    Ok(Culler::balanced()
        .with_frustum(switch("frustum", settings.frustum)?)
        .with_frustum_exact(switch("frustum_exact", settings.frustum_exact)?)
        .with_pvs(switch("pvs", settings.pvs)?)
        .with_portal(switch("portals", settings.portals)?)
        .with_backface(match settings.backfaces {
            0 => Backface::Off,
            1 => Backface::Fast,
            2 => Backface::Exact,
            other => {
                let message = format!("settings->backfaces is {other}: it must be 0 to 2");
                return Err(Error::value(message));
            }
        })
        .with_degenerate(switch("degenerate", settings.degenerate)?)
        .with_occlusion(has_occlusion.then_some(occlusion))
        .with_detail((detail > 0.0).then(|| Detail::default().with_threshold_px(detail)))
        .with_lod((lod > 0.0 || settings.lod_triangles > 0).then(|| {
            let triangles = (settings.lod_triangles > 0).then(|| settings.lod_triangles.into());
            Lod::default().with_pixels(lod).with_triangles(triangles)
        }))
        .with_output(match settings.output {
            0 => Output::Instances,
            1 => Output::Clusters,
            2 => Output::Triangles,
            other => {
                return Err(Error::value(format!(
                    "settings->output is {other}: it must be 0 to 2"
                )));
            }
        })
        .with_reasons(switch("reasons", settings.reasons)?))
}

/// Fills settings from a preset, a `cullet_preset`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_settings_preset(number: u32, settings: *mut Settings) -> Status {
    call("cullet_settings_preset", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::one("settings", settings) }?;
        out.set(0, of_culler(&preset(number)?));
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_preset_comes_back_as_it_was() {
        for number in 0..3 {
            let culler = preset(number).unwrap();
            let again = to_culler(&of_culler(&culler)).unwrap();
            assert_eq!(format!("{again:?}"), format!("{culler:?}"));
        }
    }
}
