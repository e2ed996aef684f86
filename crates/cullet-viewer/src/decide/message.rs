//! What is asked and what is decided as bytes: they go between a page and the worker that keeps its scene.
//!
//! As of a packed model both sides run the same program, so this is no file format; every count is held against the
//! bytes there are all the same.

use std::sync::Arc;

use cullet::cull::detail::{Detail, Measure};
use cullet::cull::occlusion::Occlusion;
use cullet::{
    Backface, Counts, CullFace, Culler, Depth, DroppedRange, FrontFace, FrustumWork, Funnel,
    FunnelRow, OcclusionTimes, OcclusionWork, Output, Reason, Stage, Unit, View, Visible,
};

use super::{Decision, Request};
use crate::sides::Sides;
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
const SIDES: [Sides; 3] = [Sides::Automatic, Sides::OneSided, Sides::TwoSided];
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
    /// Packs all of it but the scene, which the other side has, and only has to declare its sides.
    #[must_use]
    pub fn pack(&self) -> Vec<u8> {
        let Self { world, view, culler, buffer, number } = self;
        let mut out = Writer::default();
        out.pod(place(&SIDES, &world.sides));
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
            dropped,
            // The best of the machine: the answer is the same at every level.
            level: _,
            clock,
        } = culler;
        let switches = [*frustum, *frustum_exact, *degenerate, *reasons, *dropped, clock.is_some()];
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

    /// Which sides the scene of a packed request has: those that the other side's must have before it is
    /// [unpacked](Self::unpack) and decided.
    ///
    /// # Errors
    /// As [`unpack`](Self::unpack).
    pub fn sides(bytes: &[u8]) -> Result<Sides, UnpackError> {
        at(&SIDES, Reader::new(bytes, 0).pod()?, "sides")
    }

    /// The request that was packed, of the other side's scene. A culler that kept time keeps that of this side.
    ///
    /// # Errors
    /// If the bytes are none that [`pack`](Self::pack) wrote.
    pub fn unpack(bytes: &[u8], world: Arc<World>) -> Result<Self, UnpackError> {
        let from = &mut Reader::new(bytes, 0);
        let _: u32 = from.pod()?;
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
        let [frustum, frustum_exact, degenerate, reasons, dropped, timed] =
            from.pod::<[u32; 6]>()?.map(|bit| bit == 1);
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
            dropped,
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
    /// The number of the request that a packed decision answers; `None` of too few bytes.
    #[must_use]
    pub fn answers(bytes: &[u8]) -> Option<u64> {
        Reader::new(bytes, 0).pod().ok()
    }

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
            dropped,
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
        out.list(dropped, |out, range| {
            let DroppedRange { slot, first_triangle, triangle_count, stage, unit } = range;
            out.pod([*slot, *first_triangle, *triangle_count]);
            out.pod([place(&Stage::ALL, stage), place(&UNITS, unit)]);
        });
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
        visible.dropped = from.list(|from| {
            let [slot, first_triangle, triangle_count]: [u32; 3] = from.pod()?;
            let [stage, unit]: [u32; 2] = from.pod()?;
            let (stage, unit) = (at(&Stage::ALL, stage, "stage")?, at(&UNITS, unit, "unit")?);
            Ok(DroppedRange { slot, first_triangle, triangle_count, stage, unit })
        })?;
        unpack_funnel(from, &mut visible.funnel)?;
        Ok(Self { request, visible, occluders, buffer: None, milliseconds, number: 0 })
    }
}

fn pack_funnel(funnel: &Funnel, out: &mut Writer) {
    let Funnel { rows, frustum, occlusion } = funnel;
    out.list(rows, |out, row| {
        let FunnelRow { stage, unit, entered, left, nanoseconds } = row;
        out.pod([place(&Stage::ALL, stage), place(&UNITS, unit)]);
        out.pod([*entered, *left]);
        out.pod([u64::from(nanoseconds.is_some()), nanoseconds.unwrap_or(0)]);
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
        let [entered, left]: [Counts; 2] = from.pod()?;
        let [timed, nanoseconds]: [u64; 2] = from.pod()?;
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

#[cfg(test)]
mod tests {
    use cullet_io::scenes;

    use super::*;
    use crate::decide::Memory;

    fn world(text: &str) -> Arc<World> {
        Arc::new(World::new(scenes::build(text).unwrap(), text.to_owned()))
    }

    /// Views that differ in all that a view can differ in.
    fn views(world: &World) -> Vec<View> {
        let size = [320, 200];
        let near = world.first_sight(size).view(size).unwrap();
        let eye = world.overview(size).eye();
        let flat = View::orthographic(eye, world.centre, world.reach, -1.0, 1e4, [201, 99]);
        let mut mirror = near.clip_from_world();
        mirror.iter_mut().step_by(4).for_each(|v| *v = -*v);
        let mut mirrored = View::from_matrix(&mirror, near.depth(), size).unwrap();
        mirrored.front_face = FrontFace::Clockwise;
        mirrored.cull_face = CullFace::Front;
        let mut plain = near.clone().with_layers(5);
        plain.cull_face = CullFace::None;
        vec![near, flat.unwrap(), mirrored, plain]
    }

    /// Cullers in whose settings every value of every switch occurs, with every output.
    fn cullers() -> Vec<Culler> {
        let all = Culler {
            frustum_exact: true,
            detail: Some(Detail { measure: Measure::Area, threshold_px: 2.5 }),
            occlusion: Some(Occlusion::default()),
            reasons: true,
            dropped: true,
            clock: Some(clock),
            ..Culler::default()
        };
        let none = Culler { frustum: false, degenerate: false, ..Culler::default() };
        let diameter = Detail { measure: Measure::Diameter, threshold_px: 1.0 };
        let box_size = Detail { measure: Measure::WidthAndHeight, threshold_px: f64::INFINITY };
        let mut cullers = Vec::new();
        for output in OUTPUTS {
            let backfaces = BACKFACES.map(|backface| Culler { backface, output, ..all.clone() });
            cullers.extend(backfaces);
            cullers.push(Culler { output, backface: Backface::Off, ..none.clone() });
        }
        let occlusion = Some(Occlusion { width: 128, budget: 9.5 });
        cullers.push(Culler { detail: Some(diameter), occlusion, ..none });
        cullers.push(Culler { detail: Some(box_size), ..all });
        cullers
    }

    fn requests(world: &Arc<World>) -> Vec<Request> {
        let mut requests = Vec::new();
        for view in views(world) {
            for culler in cullers() {
                let number = requests.len() as u64 + 7;
                let (world, view) = (Arc::clone(world), view.clone());
                requests.push(Request {
                    world,
                    view,
                    culler,
                    buffer: number.is_multiple_of(3),
                    number,
                });
            }
        }
        requests
    }

    /// All of a request in words, but its scene.
    fn words(Request { view, culler, buffer, number, .. }: &Request) -> String {
        let timed = culler.clock.is_some();
        let culler = Culler { clock: None, ..culler.clone() };
        format!("{view:?} {culler:?} {timed} {buffer} {number}")
    }

    /// All of an answer but the buffer and the times.
    fn answer(mut decision: Decision) -> (Visible, FrustumWork, OcclusionWork, Vec<u32>) {
        decision.visible.funnel.rows.iter_mut().for_each(|row| row.nanoseconds = None);
        decision.visible.funnel.occlusion.times = None;
        let Decision { visible, occluders, .. } = decision;
        let (frustum, occlusion) = (visible.funnel.frustum, visible.funnel.occlusion);
        (visible, frustum, occlusion, occluders)
    }

    #[test]
    fn requests_and_answers_come_back_as_they_went() {
        let (mut here, mut there) = (Memory::default(), Memory::default());
        let mut spare = Visible::default();
        let (mut partial, mut triangles, mut drawn, mut dropped, mut ranges) = (0, 0, 0, 0, 0);
        // Of the one whole things are dropped and are occluders, of the other clusters.
        let worlds = ["city:cells=4,objects=300", "knobs"].map(world);
        for request in worlds.iter().flat_map(requests) {
            let back = Request::unpack(&request.pack(), Arc::clone(&request.world)).unwrap();
            assert_eq!(words(&back), words(&request));
            assert_eq!(back.view, request.view);
            let wanted = here.decide(request.clone());
            let made = there.decide(back);
            let packed = made.pack();
            assert_eq!(Decision::answers(&packed), Some(request.number));
            let came = Decision::unpack(&packed, request, spare).unwrap();
            // First as it was packed, with its times.
            assert_eq!(came.milliseconds, made.milliseconds);
            assert_eq!(came.visible, made.visible);
            assert_eq!(came.visible.funnel.occlusion, made.visible.funnel.occlusion);
            assert!(came.buffer.is_none());
            partial += came.visible.partial.len();
            triangles += came.visible.triangles.len();
            drawn += came.occluders.len();
            dropped += came.visible.reasons.iter().flatten().count();
            ranges += came.visible.dropped.len();
            spare = came.visible.clone();
            assert!(answer(came) == answer(wanted), "another answer");
        }
        let all = [partial, triangles, drawn, dropped, ranges];
        assert!(!all.contains(&0), "nothing to compare: {all:?}");
    }

    #[test]
    fn who_keeps_the_scene_learns_its_sides_from_a_request() {
        let stored = world("solids");
        for sides in SIDES {
            let shown = Arc::new(stored.with_sides(sides).unwrap());
            let request = requests(&shown).swap_remove(0);
            let packed = request.pack();
            assert_eq!(Request::sides(&packed).unwrap(), sides);
            // As the worker does with the scene that it keeps.
            let mut kept = stored.with_sides(Sides::Automatic).unwrap();
            kept.set_sides(Request::sides(&packed).unwrap()).unwrap();
            let asked = Request::unpack(&packed, Arc::new(kept)).unwrap();
            let answer = Memory::default().decide(asked).visible.triangle_count;
            let wanted = Memory::default().decide(request).visible.triangle_count;
            assert!(answer == wanted && wanted > 0, "{sides:?}");
        }
    }

    #[test]
    fn every_stage_is_a_reason_that_comes_back() {
        let world = world("solids");
        let request = requests(&world).swap_remove(0);
        let reasons = Stage::ALL.map(|stage| Some(Reason { stage, detail: Reason::MIXED }));
        let rows = Stage::ALL.into_iter().zip(UNITS.into_iter().cycle());
        let row = |(stage, unit)| FunnelRow {
            stage,
            unit,
            entered: Counts { instances: u64::MAX, clusters: 7, triangles: 9 },
            left: Counts { instances: 3, clusters: 2, triangles: 1 },
            nanoseconds: Some(0),
        };
        let mut decision = Memory::default().decide(request.clone());
        decision.visible.reasons = [&[None], &reasons[..]].concat();
        decision.visible.funnel.rows = rows.map(row).collect();
        let came = Decision::unpack(&decision.pack(), request, Visible::default()).unwrap();
        assert_eq!(came.visible, decision.visible);
    }

    #[test]
    fn bytes_that_end_early_or_lie_are_errors() {
        let world = world("solids");
        let request = requests(&world).swap_remove(0);
        let packed = request.pack();
        for at in 0..packed.len() {
            let short = Request::unpack(&packed[..at], Arc::clone(&world));
            assert!(matches!(short, Err(UnpackError::Short(_))), "{at}: {short:?}");
            let mut lying = packed.clone();
            lying[at] ^= 0xff;
            // Whatever comes of it, it is no panic.
            let _ = Request::unpack(&lying, Arc::clone(&world));
        }
        let packed = Memory::default().decide(request.clone()).pack();
        for at in 0..packed.len() {
            let unpack =
                |bytes: &[u8]| Decision::unpack(bytes, request.clone(), Visible::default());
            let short = unpack(&packed[..at]);
            assert!(matches!(short, Err(UnpackError::Short(_))), "{at}: {short:?}");
            let mut lying = packed.clone();
            lying[at] ^= 0xff;
            let _ = unpack(&lying);
        }
        let other = Request { number: request.number + 1, ..request };
        let wrong = Decision::unpack(&packed, other, Visible::default());
        assert!(matches!(wrong, Err(UnpackError::Damaged(_))), "{wrong:?}");
    }
}
