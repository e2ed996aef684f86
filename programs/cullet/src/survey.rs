//! Culls and verifies view after view, and keeps the tallies that the page and its advice rest on.

use std::time::Instant;

use cullet::{Culler, Handle, Output, Stage, View, ViewState, Visible, funnel::Unit};
use cullet_command::clock::clock;
use cullet_command::exit::Failure;
use cullet_command::inputs;
use cullet_draw::{
    BackfaceTest, BoundsTest, Frame, FrameStats, LevelSteps, LevelsVerification, Meter, PixelId,
    Verification, VerifyOptions, facing_away, pixels_of_meshes,
};
use cullet_io::Model;

use crate::levels::{DeviationRecord, Ladder, LevelsRecord};
use crate::names::{name_of, reason_text};
use crate::record::{
    Counts, DepthRecord, Loss, Removed, StageRecord, ViewRecord, WholeRecord, tightness,
};

/// Counts of one instance over all views.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SlotTally {
    /// Views in which something of it was drawn.
    pub(crate) kept: u32,
    /// Views in which it owned a pixel.
    pub(crate) seen: u32,
    /// Views in which it was drawn in part, because it straddles the frustum.
    pub(crate) straddled: u32,
    /// Over those views, the sum of the share of its clusters that were outside.
    pub(crate) outside: f32,
    /// Triangles drawn over all views; stays at the most that fits.
    pub(crate) drawn: u32,
    /// The longer side of its largest screen rectangle, in pixels; infinite where it came too near.
    pub(crate) largest_px: f32,
}

/// Counts of one mesh over all views.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MeshTally {
    pub(crate) instances: u64,
    pub(crate) kept: u32,
    pub(crate) seen: u32,
    pub(crate) drawn: u64,
    pub(crate) visible: u64,
    pub(crate) facing_away: u64,
    /// Pixels it owns over the views that were verified, and those of them where nothing is proved
    /// to hide.
    pub(crate) pixels: u64,
    pub(crate) open_pixels: u64,
    last_kept: Option<usize>,
    last_seen: Option<usize>,
}

/// A run over views.
#[derive(Debug)]
pub(crate) struct Survey {
    /// Posed at the time of the last view.
    pub(crate) model: Model,
    /// When each view is; empty where the model stands still.
    times: Vec<f64>,
    pub(crate) culler: Culler,
    pub(crate) options: VerifyOptions,
    pub(crate) slots: Vec<SlotTally>,
    pub(crate) meshes: Vec<MeshTally>,
    pub(crate) views: Vec<ViewRecord>,
    bounds: Option<BoundsTest>,
    backfaces: BackfaceTest,
    count_backfaces: bool,
    /// State of the last view.
    pub(crate) state: ViewState,
    /// State of the last view without levels of detail, where those are on.
    pub(crate) full_state: ViewState,
    ladder: Option<Ladder>,
}

/// Random points of a view, each way, by which levels of detail are measured.
const LEVEL_POINTS: usize = 400_000;

/// Results of one view, for pictures and exports.
#[derive(Debug)]
pub(crate) struct Seen {
    /// The visible set.
    pub(crate) result: Visible,
    /// The proof, where the view was verified.
    pub(crate) verification: Option<Verification>,
    /// The same without levels of detail, where those are on.
    pub(crate) full: Option<Box<Self>>,
}

impl Seen {
    fn of(mut verification: Verification) -> Self {
        let result = std::mem::take(&mut verification.result);
        Self { result, verification: Some(verification), full: None }
    }

    /// Returns what was seen without levels of detail.
    pub(crate) fn in_full(&self) -> &Self {
        self.full.as_deref().unwrap_or(self)
    }
}

impl Survey {
    /// Ready for the first view.
    pub(crate) fn new(mut model: Model, mut culler: Culler, options: VerifyOptions) -> Self {
        culler.output = Output::Triangles;
        (culler.reasons, culler.dropped) = (true, true);
        culler.clock = Some(clock);
        model.scene.prepare(&culler);
        let scene = &model.scene;
        let mut meshes = vec![MeshTally::default(); scene.meshes().len()];
        scene.slots().for_each(|s| meshes[scene.mesh_id(s) as usize].instances += 1);
        let slots = vec![SlotTally::default(); scene.slot_count() as usize];
        let ladder = culler.lod.map(|_| Ladder::new(&culler));
        Self {
            model,
            times: Vec::new(),
            culler,
            options,
            slots,
            meshes,
            views: Vec::new(),
            bounds: None,
            backfaces: BackfaceTest::default(),
            count_backfaces: false,
            state: ViewState::default(),
            full_state: ViewState::default(),
            ladder,
        }
    }

    /// Lets the model move: view i is at time i.
    pub(crate) fn move_over(&mut self, times: Vec<f64>) {
        self.times = times;
    }

    /// Also compares boxes with spheres in every view.
    pub(crate) fn compare_bounds(&mut self) {
        self.bounds = BoundsTest::new(&self.model.scene);
    }

    /// Also counts what faces away in every view.
    pub(crate) fn count_backfaces(&mut self) {
        self.count_backfaces = true;
    }

    /// Culls one view, verifies it on request, and adds it to the tallies.
    ///
    /// # Errors
    /// If the model cannot be posed at the view's time.
    pub(crate) fn add(&mut self, view: &View, verify: bool) -> Result<Seen, Failure> {
        self.add_as(self.views.len(), view, verify)
    }

    /// Adds the view with that number like [`add`](Self::add); it need not be the next.
    pub(crate) fn add_as(
        &mut self,
        index: usize,
        view: &View,
        verify: bool,
    ) -> Result<Seen, Failure> {
        if let Some(&seconds) = self.times.get(index) {
            inputs::pose(&mut self.model, seconds)?;
            if self.bounds.is_some() {
                self.bounds = BoundsTest::new(&self.model.scene);
            }
        }
        let start = Instant::now();
        let (seen, levels) = self.see(view, verify);
        self.tally_drawn(view, index, &seen.result);
        let proof = seen.verification.as_ref();
        let seen_instances = proof.map(|v| self.tally_seen(index, &v.seen));
        let full = seen.in_full();
        let full_proof = full.verification.as_ref();
        if let Some(v) = proof {
            self.tally_open(&v.frame);
        }
        let scene = &self.model.scene;
        let backfaces = self.count_backfaces.then_some(&mut self.backfaces);
        let backfaces = backfaces.and_then(|b| b.measure(scene, view, &self.culler, &full.result));
        let all = scene.triangle_count();
        let drawn = seen.result.triangle_count;
        let visible = proof.map(|v| v.visible);
        let mut losses: Vec<Loss> = full_proof.map_or_else(Vec::new, |v| self.losses(index, v));
        if let Some(v) = proof.filter(|_| levels.is_some()) {
            losses.extend(self.losses(index, v).into_iter().map(|loss| Loss {
                reason: format!("{}, at its level of detail", loss.reason),
                ..loss
            }));
        }
        let pixels = view.viewport().iter().map(|&v| u64::from(v)).product();
        let (direction, near, far) = planes(view);
        let eye = view.eye();
        self.views.push(ViewRecord {
            index,
            eye: (eye[3] != 0.0).then_some([eye[0], eye[1], eye[2]]),
            direction,
            near,
            far,
            stages: seen.result.funnel.rows.iter().map(StageRecord::new).collect(),
            hierarchy: seen.result.funnel.frustum,
            whole: whole(&seen.result),
            triangles: Counts { all, potentially_visible: drawn, visible },
            instances: Counts {
                all: u64::from(scene.instance_count()),
                potentially_visible: seen.result.instance_count,
                visible: seen_instances,
            },
            removed: removed(&seen.result),
            tightness: visible.and_then(|v| tightness(drawn, v)),
            verified: proof.is_some(),
            false_culls: losses.len() as u64,
            losses,
            depth_before: full_proof.map(|v| depth(&v.before, all, pixels)),
            depth_after: proof.map(|v| depth(&v.after, drawn, pixels)),
            bounds: self
                .bounds
                .as_mut()
                .map(|b| b.measure(scene, view, &self.culler, clock).into()),
            backfaces: backfaces.map(Into::into),
            levels,
            seconds: start.elapsed().as_secs_f64(),
        });
        Ok(seen)
    }

    /// Culls one view, verifies it on request, and says what levels of detail made of it where they
    /// are on.
    fn see(&mut self, view: &View, verify: bool) -> (Seen, Option<LevelsRecord>) {
        let (scene, world) = (&self.model.scene, self.model.in_cells());
        let cull = |culler: &Culler, state: &mut ViewState| {
            let mut result = Visible::default();
            world.cull(culler, view, state, &mut result);
            result
        };
        let Some((mut lod, ladder)) = self.culler.lod.zip(self.ladder.as_mut()) else {
            let seen = if verify {
                let state = &mut self.state;
                Seen::of(cullet_draw::verify(world, view, &self.culler, state, &self.options))
            } else {
                let result = cull(&self.culler, &mut self.state);
                Seen { result, verification: None, full: None }
            };
            return (seen, None);
        };
        let (mut seen, full, chosen) = if verify {
            let states = [&mut self.full_state, &mut self.state];
            let found =
                cullet_draw::verify_levels(world, view, &self.culler, states, &self.options);
            let LevelsVerification { full, levels, cut, pixels } = found;
            (Seen::of(levels), Seen::of(full), Some((cut, pixels)))
        } else {
            let of = |result| Seen { result, verification: None, full: None };
            let without = self.culler.without(Stage::Lod);
            let full = of(cull(&without, &mut self.full_state));
            (of(cull(&self.culler, &mut self.state)), full, None)
        };
        // What a budget came to is what is stated.
        lod.pixels = seen.result.lod_pixels.unwrap_or(lod.pixels);
        let [frustum, backface] = ladder.climb(scene, view);
        let steps = LevelSteps::new(scene);
        let visible = |seen: &Seen| seen.verification.as_ref().map(|v| v.visible);
        let record = LevelsRecord {
            ladder: crate::levels::LadderRecord {
                all: scene.triangle_count(),
                frustum,
                backface,
                occlusion: full.result.triangle_count,
                levels: seen.result.triangle_count,
                visible: visible(&seen),
                visible_in_full: visible(&full),
            },
            drawn: steps.count(&seen.result),
            impostor_level: steps.impostor(),
            chosen: chosen.as_ref().map_or_else(Vec::new, |(cut, _)| steps.count(cut)),
            pixels: chosen.as_ref().map(|(_, pixels)| (*pixels).into()),
            deviation: chosen.as_ref().map(|(cut, _)| {
                let meter = Meter { points: LEVEL_POINTS, seed: self.options.seed };
                let found = meter.measure(scene, view, &lod, cut, &seen.result);
                let worst = found.worst.map(|slot| name_of(&self.model, slot));
                DeviationRecord::of(&found, worst, &lod)
            }),
        };
        seen.full = Some(Box::new(full));
        (seen, Some(record))
    }

    fn tally_drawn(&mut self, view: &View, index: usize, result: &Visible) {
        let scene = &self.model.scene;
        for range in &result.triangle_ranges {
            if range.count == 0 {
                continue;
            }
            let slot = range.slot as usize;
            let tally = &mut self.slots[slot];
            tally.kept += 1;
            tally.drawn = tally.drawn.saturating_add(range.count);
            if tally.largest_px.is_finite() {
                let rect = view.project_box(&scene.bounds(range.slot), scene.origin());
                let px = rect.map_or(f64::INFINITY, |r| r.width().max(r.height()));
                tally.largest_px = tally.largest_px.max(px as f32);
            }
            let triangles = &result.triangles[range.first as usize..][..range.count as usize];
            let mesh = &mut self.meshes[scene.mesh_id(range.slot) as usize];
            mesh.drawn += u64::from(range.count);
            mesh.facing_away += facing_away(scene, view, [range.slot, range.level], triangles);
            if mesh.last_kept.replace(index) != Some(index) {
                mesh.kept += 1;
            }
        }
        // Of instances that are drawn, the clusters that are outside; what other stages took of
        // them is not.
        for ranges in result.dropped.chunk_by(|a, b| a.slot == b.slot) {
            let slot = ranges[0].slot;
            let clusters = scene.mesh_at(slot, ranges[0].level).clusters();
            let starts = |from: u32| clusters.partition_point(|c| c.first_triangle < from);
            let outside = ranges
                .iter()
                .filter(|d| (d.stage, d.unit) == (Stage::Frustum, Unit::Clusters))
                .map(|d| starts(d.first_triangle + d.triangle_count) - starts(d.first_triangle))
                .sum::<usize>();
            if outside > 0 && result.reasons[slot as usize].is_none() {
                let tally = &mut self.slots[slot as usize];
                tally.straddled += 1;
                tally.outside += outside as f32 / clusters.len() as f32;
            }
        }
    }

    /// Adds the owners of pixels; returns how many instances there are among them.
    fn tally_seen(&mut self, index: usize, seen: &[PixelId]) -> u64 {
        let mut instances = 0;
        for one in seen.chunk_by(|a, b| a.slot == b.slot) {
            instances += 1;
            self.slots[one[0].slot as usize].seen += 1;
            let mesh = &mut self.meshes[self.model.scene.mesh_id(one[0].slot) as usize];
            mesh.visible += one.len() as u64;
            if mesh.last_seen.replace(index) != Some(index) {
                mesh.seen += 1;
            }
        }
        instances
    }

    /// Adds the pixels that each mesh owns, and those where the occlusion buffer has nothing for
    /// it.
    fn tally_open(&mut self, frame: &Frame) {
        let Some(buffer) =
            self.state.occlusion_buffer().filter(|_| self.culler.occlusion.is_some())
        else {
            return;
        };
        let counts = pixels_of_meshes(&self.model.scene, frame, buffer);
        for (mesh, pixels) in self.meshes.iter_mut().zip(counts) {
            mesh.pixels += pixels.owned;
            mesh.open_pixels += pixels.open;
        }
    }

    fn losses(&self, view: usize, v: &Verification) -> Vec<Loss> {
        let loss = |f: &cullet_draw::FalseCull| {
            let handle = self.model.scene.handle(f.slot);
            Loss {
                view,
                instance: name_of(&self.model, f.slot),
                handle: handle.unwrap_or(Handle { index: u32::MAX, generation: 0 }),
                triangle: f.triangle,
                pixel: f.pixel,
                stage: f.reason.map(|r| r.stage),
                reason: f.reason.map_or_else(|| "part of it is drawn".into(), reason_text),
            }
        };
        v.false_culls.iter().map(loss).collect()
    }
}

/// Counts where only whole instances are culled: the rows of instances, the first of the funnel.
fn whole(result: &Visible) -> WholeRecord {
    let work = result.funnel.occlusion;
    let mut record =
        WholeRecord { occluders: [work.considered, work.drawn], ..WholeRecord::default() };
    for row in result.funnel.rows.iter().filter(|row| row.unit == Unit::Instances) {
        let left = [row.left.instances, row.left.triangles];
        if matches!(row.stage, Stage::Layer | Stage::Frustum) {
            record.in_frustum = left;
        }
        record.not_hidden = left;
    }
    record
}

/// How many triangles each stage took, whether with an instance, with a cluster or singly.
fn removed(result: &Visible) -> Removed {
    let taken = Stage::ALL.map(|stage| (stage, result.funnel.dropped(stage).triangles));
    taken.into_iter().filter(|(_, n)| *n > 0).collect()
}

fn depth(stats: &FrameStats, primitives: u64, pixels: u64) -> DepthRecord {
    DepthRecord {
        fragments: stats.fragments,
        covered_pixels: stats.covered_pixels,
        mean_layers: stats.mean_layers,
        max_layers: stats.max_layers,
        primitives_per_pixel: primitives as f64 / pixels.max(1) as f64,
    }
}

/// Where a view looks, and the distances of its near and far planes from the eye.
pub(crate) fn planes(view: &View) -> ([f64; 3], Option<f64>, Option<f64>) {
    use cullet::view::FrustumPlane::{Far, Near};
    let frustum = view.frustum();
    let eye = view.eye();
    let distance =
        |p: &cullet::bounds::Plane| (0..3).map(|a| p.normal[a] * eye[a]).sum::<f64>() - p.d;
    let near = frustum.plane(Near);
    let back = near.map_or([0.0, 0.0, 1.0], |p| p.normal);
    let perspective = eye[3] != 0.0;
    let near = near.filter(|_| perspective).map(distance);
    let far = frustum.plane(Far).filter(|_| perspective).map(|p| -distance(p));
    (back.map(|v| -v), near, far)
}
