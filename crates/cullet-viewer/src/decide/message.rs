//! What is asked and what is decided as bytes: they go between a page and the worker that keeps its scene.
//!
//! As of a packed model both sides run the same program, so this is no file format; every count is held against the
//! bytes there are all the same.

use std::sync::Arc;

use cullet::cull::detail::{Detail, Measure};
use cullet::cull::occlusion::Occlusion;
use cullet::{
    Backface, CullFace, Culler, Depth, FrontFace, FrustumWork, Funnel, FunnelRow, OcclusionTimes,
    OcclusionWork, Output, Reason, Stage, Unit, View, Visible,
};

use super::{Decision, Request};
use crate::task::clock;
use crate::web::bytes::{Reader, Writer};
use crate::web::packed::UnpackError;
use crate::world::World;

const DEPTHS: [Depth; 2] = [Depth::Standard, Depth::Reversed];
const FRONTS: [FrontFace; 2] = [FrontFace::CounterClockwise, FrontFace::Clockwise];
const FACES: [CullFace; 3] = [CullFace::None, CullFace::Back, CullFace::Front];
const BACKFACES: [Backface; 3] = [Backface::Off, Backface::Fast, Backface::Exact];
const OUTPUTS: [Output; 3] = [Output::Instances, Output::Clusters, Output::Triangles];
const MEASURES: [Measure; 3] = [Measure::WidthAndHeight, Measure::Area, Measure::Diameter];
const UNITS: [Unit; 3] = [Unit::Instances, Unit::Clusters, Unit::Triangles];

/// The place of a value among all that it can be.
fn place<T: PartialEq>(all: &[T], value: &T) -> u32 {
    // One that is not among them is refused by who unpacks it.
    all.iter().position(|v| v == value).map_or(u32::MAX, |place| place as u32)
}

fn at<T: Copy>(all: &[T], place: u32, what: &str) -> Result<T, UnpackError> {
    let found = usize::try_from(place).ok().and_then(|place| all.get(place));
    found.copied().ok_or_else(|| UnpackError::Damaged(format!("{what} {place}")))
}

impl Request {
    /// Packs all of it but the scene, which the other side has.
    #[must_use]
    pub fn pack(&self) -> Vec<u8> {
        let Self { world: _, view, culler, buffer, number } = self;
        let mut out = Writer::default();
        out.pod(*number);
        out.pod(u32::from(*buffer));
        let [width, height] = view.viewport();
        out.pod(view.clip_from_world());
        out.pod([width, height, view.layers]);
        out.pod([
            place(&DEPTHS, &view.depth()),
            place(&FRONTS, &view.front_face),
            place(&FACES, &view.cull_face),
        ]);
        let Culler {
            frustum,
            frustum_exact,
            backface,
            degenerate,
            detail,
            occlusion,
            output,
            reasons,
            // The best of the machine: the answer is the same at every level.
            level: _,
            clock,
        } = culler;
        let switches = [*frustum, *frustum_exact, *degenerate, *reasons, clock.is_some()];
        out.pod(switches.map(u32::from));
        out.pod([place(&BACKFACES, backface), place(&OUTPUTS, output)]);
        out.pod(u32::from(detail.is_some()));
        if let Some(Detail { measure, threshold_px }) = detail {
            out.pod(place(&MEASURES, measure));
            out.pod(*threshold_px);
        }
        out.pod(u32::from(occlusion.is_some()));
        if let Some(Occlusion { width, budget }) = occlusion {
            out.pod(*width);
            out.pod(*budget);
        }
        out.bytes
    }

    /// The request that was packed, of the other side's scene. A culler that kept time keeps that of this side.
    ///
    /// # Errors
    /// If the bytes are none that [`pack`](Self::pack) wrote.
    pub fn unpack(bytes: &[u8], world: Arc<World>) -> Result<Self, UnpackError> {
        let from = &mut Reader::new(bytes, 0);
        let number = from.pod()?;
        let buffer = flag(from)?;
        let matrix: [f64; 16] = from.pod()?;
        let [width, height, layers]: [u32; 3] = from.pod()?;
        let [depth, front, face]: [u32; 3] = from.pod()?;
        let mut view = View::from_matrix(&matrix, at(&DEPTHS, depth, "depth")?, [width, height])
            .map_err(|e| UnpackError::Damaged(e.to_string()))?;
        view.layers = layers;
        view.front_face = at(&FRONTS, front, "front face")?;
        view.cull_face = at(&FACES, face, "faces to cull")?;
        let [frustum, frustum_exact, degenerate, reasons, timed] =
            from.pod::<[u32; 5]>()?.map(|bit| bit == 1);
        let [backface, output]: [u32; 2] = from.pod()?;
        let detail = if flag(from)? {
            let measure = at(&MEASURES, from.pod()?, "measure")?;
            Some(Detail { measure, threshold_px: from.pod()? })
        } else {
            None
        };
        let occlusion = if flag(from)? {
            Some(Occlusion { width: from.pod()?, budget: from.pod()? })
        } else {
            None
        };
        let culler = Culler {
            frustum,
            frustum_exact,
            backface: at(&BACKFACES, backface, "way to cull back faces")?,
            degenerate,
            detail,
            occlusion,
            output: at(&OUTPUTS, output, "output")?,
            reasons,
            clock: timed.then_some(clock),
            ..Culler::default()
        };
        Ok(Self { world, view, culler, buffer, number })
    }
}

fn flag(from: &mut Reader<'_>) -> Result<bool, UnpackError> {
    Ok(from.pod::<u32>()? == 1)
}

impl Decision {
    /// Packs the answer, with the number of the request that it answers. The occlusion buffer is left out.
    #[must_use]
    pub fn pack(&self) -> Vec<u8> {
        let Self { request, visible, occluders, buffer: _, milliseconds, number: _ } = self;
        let Visible {
            whole,
            partial,
            triangle_ranges,
            triangles,
            reasons,
            funnel,
            triangle_count,
            instance_count,
        } = visible;
        let mut out = Writer::default();
        out.pod(request.number);
        out.pod(*milliseconds);
        out.pod([*triangle_count, *instance_count]);
        out.pods(occluders);
        out.pods(whole);
        out.pods(partial);
        out.pods(triangle_ranges);
        out.pods(triangles);
        out.pod(reasons.len() as u64);
        // No stage has the number 0.
        let two = |reason: &Option<Reason>| reason.map_or([0; 2], |r| [r.stage as u8, r.detail]);
        out.bytes.extend(reasons.iter().flat_map(two));
        pack_funnel(funnel, &mut out);
        out.bytes
    }

    /// The decision of a request that was packed elsewhere, without an occlusion buffer, in the memory of an answer
    /// that is needed no more; its own number is 0.
    ///
    /// # Errors
    /// If the bytes are none that [`pack`](Self::pack) wrote, or answer another request.
    pub fn unpack(
        bytes: &[u8],
        request: Request,
        mut visible: Visible,
    ) -> Result<Self, UnpackError> {
        let from = &mut Reader::new(bytes, 0);
        let number: u64 = from.pod()?;
        if number != request.number {
            let text = format!("an answer to request {number} in place of {}", request.number);
            return Err(UnpackError::Damaged(text));
        }
        let milliseconds = from.pod()?;
        [visible.triangle_count, visible.instance_count] = from.pod()?;
        let occluders = from.pods()?;
        from.pods_into(&mut visible.whole)?;
        from.pods_into(&mut visible.partial)?;
        from.pods_into(&mut visible.triangle_ranges)?;
        from.pods_into(&mut visible.triangles)?;
        visible.reasons.clear();
        let count = from.count(2)?;
        visible.reasons.reserve(count);
        for pair in from.take(count * 2)?.chunks_exact(2) {
            visible.reasons.push(match pair[0].checked_sub(1) {
                Some(stage) => {
                    let stage = at(&Stage::ALL, stage.into(), "stage")?;
                    Some(Reason { stage, detail: pair[1] })
                }
                None => None,
            });
        }
        unpack_funnel(from, &mut visible.funnel)?;
        Ok(Self { request, visible, occluders, buffer: None, milliseconds, number: 0 })
    }
}

/// The number of the request that a packed decision answers.
#[cfg_attr(not(target_arch = "wasm32"), expect(dead_code, reason = "only a page asks a worker"))]
pub(super) fn number_of(bytes: &[u8]) -> Option<u64> {
    Reader::new(bytes, 0).pod().ok()
}

fn pack_funnel(funnel: &Funnel, out: &mut Writer) {
    let Funnel { rows, frustum, occlusion } = funnel;
    out.list(rows, |out, row| {
        let FunnelRow { stage, unit, entered, left, nanoseconds } = row;
        out.pod([place(&Stage::ALL, stage), place(&UNITS, unit)]);
        out.pod([*entered, *left, u64::from(nanoseconds.is_some()), nanoseconds.unwrap_or(0)]);
    });
    let FrustumWork { nodes, blocks, plane_tests, remembered, swept } = frustum;
    out.pod([*nodes, *blocks, *plane_tests, *remembered, *swept]);
    let OcclusionWork { offered, chosen, drawn, tests, times } = occlusion;
    out.pod([*offered, *chosen, *drawn, *tests, u64::from(times.is_some())]);
    let OcclusionTimes { choosing, drawing, asking } = times.unwrap_or_default();
    out.pod([choosing, drawing, asking]);
}

fn unpack_funnel(from: &mut Reader<'_>, funnel: &mut Funnel) -> Result<(), UnpackError> {
    funnel.rows = from.list(|from| {
        let [stage, unit]: [u32; 2] = from.pod()?;
        let [entered, left, timed, nanoseconds]: [u64; 4] = from.pod()?;
        let (stage, unit) = (at(&Stage::ALL, stage, "stage")?, at(&UNITS, unit, "unit")?);
        let nanoseconds = (timed == 1).then_some(nanoseconds);
        Ok(FunnelRow { stage, unit, entered, left, nanoseconds })
    })?;
    let [nodes, blocks, plane_tests, remembered, swept]: [u64; 5] = from.pod()?;
    funnel.frustum = FrustumWork { nodes, blocks, plane_tests, remembered, swept };
    let [offered, chosen, drawn, tests, timed]: [u64; 5] = from.pod()?;
    let [choosing, drawing, asking]: [u64; 3] = from.pod()?;
    let times = (timed == 1).then_some(OcclusionTimes { choosing, drawing, asking });
    funnel.occlusion = OcclusionWork { offered, chosen, drawn, tests, times };
    Ok(())
}
