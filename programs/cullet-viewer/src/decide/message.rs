//! Requests and decisions as bytes: they go between a page and the worker that keeps its scene.
//!
//! Settings, the view and the funnel are the engine's own types, by `postcard`. What is as long as
//! the scene is copied as it lies in memory: written one by one, reasons alone would take several
//! times as long as all else. As of a packed model both sides run the same program, so this is no
//! file format; every count is held against the bytes there are all the same.

use std::sync::Arc;

use cullet::view::EyeBall;
use cullet::{Culler, Reason, Stage, View, Visible, draw::DroppedRange, funnel::Funnel};

use super::{Decision, Request};
use crate::bytes::{Reader, UnpackError, Writer};
use crate::state::Sides;
use crate::task::clock;
use crate::world::World;

impl Request {
    /// Packs all of it but the scene, which the other side has, and only has to declare its sides
    /// and doors.
    #[must_use]
    pub fn pack(&self) -> Vec<u8> {
        let Self { world, view, culler, buffer, number } = self;
        let mut out = Writer::default();
        out.value(&world.sides);
        out.value(&world.doors);
        // A culler's level is the best of the machine that culls, and its clock that machine's too.
        // The eyes of a view are no part of it where it is written.
        out.value(&(number, buffer, view, view.eyes, culler, culler.clock.is_some()));
        out.bytes
    }

    /// Reads the sides that the scene of a packed request has: the other side's scene must have
    /// them before it is [unpacked](Self::unpack) and decided.
    ///
    /// # Errors
    /// As [`unpack`](Self::unpack).
    pub fn sides(bytes: &[u8]) -> Result<Sides, UnpackError> {
        Reader::new(bytes, 0).value()
    }

    /// Reads the doors that differ between the scene of a packed request and its file; the other
    /// side's scene must have them likewise.
    ///
    /// # Errors
    /// As [`unpack`](Self::unpack).
    pub fn doors(bytes: &[u8]) -> Result<Vec<u32>, UnpackError> {
        let from = &mut Reader::new(bytes, 0);
        let _: Sides = from.value()?;
        from.value()
    }

    /// The request that was packed, of the other side's scene. A culler that kept time keeps that
    /// of this side.
    ///
    /// # Errors
    /// If the bytes are none that [`pack`](Self::pack) wrote.
    pub fn unpack(bytes: &[u8], world: Arc<World>) -> Result<Self, UnpackError> {
        let from = &mut Reader::new(bytes, 0);
        let _: (Sides, Vec<u32>) = (from.value()?, from.value()?);
        let (number, buffer, mut view, eyes, culler, timed) =
            from.value::<(u64, bool, View, Option<EyeBall>, Culler, bool)>()?;
        view.eyes = eyes;
        let culler = culler.with_clock(timed.then_some(clock));
        Ok(Self { world, view, culler, buffer, number })
    }
}

impl Decision {
    /// The number of the request that a packed decision answers; `None` of too few bytes.
    #[must_use]
    pub fn answers(bytes: &[u8]) -> Option<u64> {
        Reader::new(bytes, 0).value().ok()
    }

    /// Packs the answer, with the number of the request that it answers. The occlusion buffer is
    /// left out.
    #[must_use]
    pub fn pack(&self) -> Vec<u8> {
        let Self { request, visible, occluders, buffer: _, milliseconds, number: _ } = self;
        let Visible {
            version: _,
            whole,
            partial,
            triangle_ranges,
            triangles,
            reasons,
            dropped,
            funnel,
            triangle_count,
            instance_count,
            lod_pixels,
        } = visible;
        // Growing a list of millions would copy it again and again.
        let long = size_of_val(&occluders[..])
            + size_of_val(&whole[..])
            + size_of_val(&partial[..])
            + size_of_val(&triangle_ranges[..])
            + size_of_val(&triangles[..])
            + reasons.len() * 2;
        let mut out = Writer { bytes: Vec::with_capacity(long + 1024) };
        out.value(&request.number);
        out.value(&(milliseconds, triangle_count, instance_count, lod_pixels, funnel, dropped));
        out.pods(occluders);
        out.pods(whole);
        out.pods(partial);
        out.pods(triangle_ranges);
        out.pods(triangles);
        out.count(reasons.len());
        // No stage has the number 0.
        let two = |reason: &Option<Reason>| reason.map_or([0; 2], |r| [r.stage as u8, r.detail]);
        out.bytes.extend(reasons.iter().flat_map(two));
        out.bytes
    }

    /// The decision of a request that was packed elsewhere, without an occlusion buffer, in the
    /// memory of an answer that is needed no more; its own number is 0.
    ///
    /// # Errors
    /// If the bytes are none that [`pack`](Self::pack) wrote, or answer another request.
    pub fn unpack(
        bytes: &[u8],
        request: Request,
        mut visible: Visible,
    ) -> Result<Self, UnpackError> {
        let from = &mut Reader::new(bytes, 0);
        let number: u64 = from.value()?;
        if number != request.number {
            let text = format!("an answer to request {number} in place of {}", request.number);
            return Err(UnpackError::Damaged(text));
        }
        let (milliseconds, triangles, instances, lod_pixels, funnel, dropped) =
            from.value::<(f32, u64, u64, Option<f64>, Funnel, Vec<DroppedRange>)>()?;
        (visible.triangle_count, visible.instance_count) = (triangles, instances);
        visible.lod_pixels = lod_pixels;
        (visible.funnel, visible.dropped) = (funnel, dropped);
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
                Some(number) => Some(Reason { stage: stage(number)?, detail: pair[1] }),
                None => None,
            });
        }
        Ok(Self { request, visible, occluders, buffer: None, milliseconds, number: 0 })
    }
}

fn stage(number: u8) -> Result<Stage, UnpackError> {
    let stage = Stage::ALL.get(usize::from(number)).copied();
    stage.ok_or_else(|| UnpackError::Damaged(format!("stage {number}")))
}

#[cfg(test)]
mod tests {
    use cullet::cull::detail::{Detail, Measure};
    use cullet::cull::occlusion::Occlusion;
    use cullet::{
        Backface, Output,
        funnel::{Counts, FrustumWork, FunnelRow, OcclusionWork, Unit},
        view::{CullFace, FrontFace},
    };

    use super::*;
    use crate::decide::Memory;

    fn world(text: &str) -> Arc<World> {
        Arc::new(World::new(cullet_scenes::build(text).unwrap(), text.to_owned()))
    }

    /// Views that differ in all that a view can differ in.
    fn views(world: &World) -> Vec<View> {
        let size = [320, 200];
        let near = world.first_sight(size).view(size).unwrap();
        let eye = world.overview(size).eye();
        let flat = View::orthographic(eye, world.centre, world.reach, -1.0, 1e4, [201, 99]);
        let mut mirror = near.clip_from_world();
        mirror.iter_mut().step_by(4).for_each(|v| *v = -*v);
        let mut mirrored = View::from_matrix(mirror, near.depth(), size).unwrap();
        mirrored.front_face = FrontFace::Clockwise;
        mirrored.cull_face = CullFace::Front;
        let mut plain = near.clone().with_layers(5);
        plain.cull_face = CullFace::None;
        plain.eyes = Some(EyeBall { centre: [1.0, 2.0, 3.0], radius: 0.5 });
        vec![near, flat.unwrap(), mirrored, plain]
    }

    /// Cullers in whose settings every value of every switch occurs, with every output.
    fn cullers() -> Vec<Culler> {
        let all = Culler::default()
            .with_frustum_exact(true)
            .with_detail(Detail::default().with_measure(Measure::Area).with_threshold_px(2.5))
            .with_occlusion(Occlusion::default())
            .with_reasons(true)
            .with_dropped(true)
            .with_clock(Some(clock));
        let none = Culler::default().with_frustum(false).with_degenerate(false);
        let diameter = Detail::default().with_measure(Measure::Diameter).with_threshold_px(1.0);
        let box_size = Detail::default()
            .with_measure(Measure::WidthAndHeight)
            .with_threshold_px(f64::INFINITY);
        let mut cullers = Vec::new();
        for output in [Output::Instances, Output::Clusters, Output::Triangles] {
            let ways = [Backface::Off, Backface::Fast, Backface::Exact];
            let backfaces =
                ways.map(|backface| all.clone().with_backface(backface).with_output(output));
            cullers.extend(backfaces);
            cullers.push(none.clone().with_output(output).with_backface(Backface::Off));
        }
        let occlusion = Some(Occlusion::default().with_width(128).with_budget(9.5));
        cullers.push(none.with_detail(diameter).with_occlusion(occlusion));
        cullers.push(all.with_detail(box_size));
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
        let culler = culler.clone().with_clock(None);
        format!("{view:?} {culler:?} {timed} {buffer} {number}")
    }

    /// All of an answer but the buffer and the times.
    fn answer(mut decision: Decision) -> (Visible, FrustumWork, OcclusionWork, Vec<u32>) {
        decision
            .visible
            .funnel
            .rows
            .iter_mut()
            .for_each(|row| row.nanoseconds = FunnelRow::NO_TIME);
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
        // In one scene whole instances are culled and are occluders, in the other clusters.
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
        for sides in Sides::ALL.map(|s| s.0) {
            let shown = Arc::new(stored.with_sides(sides).unwrap());
            let request = requests(&shown).swap_remove(0);
            let packed = request.pack();
            assert_eq!(Request::sides(&packed).unwrap(), sides);
            assert!(Request::doors(&packed).unwrap().is_empty());
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
        let units = [Unit::Instances, Unit::Clusters, Unit::Triangles];
        let rows = Stage::ALL.into_iter().zip(units.into_iter().cycle());
        let row = |(stage, unit)| FunnelRow {
            stage,
            unit,
            entered: Counts { instances: u64::MAX, clusters: 7, triangles: 9 },
            left: Counts { instances: 3, clusters: 2, triangles: 1 },
            nanoseconds: 0,
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
