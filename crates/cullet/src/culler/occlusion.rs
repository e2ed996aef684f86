//! The stage that drops what lies behind something.

use super::run::{Pass, Scratch};
use super::{Culler, Output};
use crate::bits;
use crate::bounds::Aabb;
use crate::cull::occlusion::{
    Candidate, Footprint, Occlusion, OcclusionBuffer, Shape, Verdict, choose,
};
use crate::scene::Scene;
use crate::view::{CullFace, FrontFace, View};
use crate::visible::{OcclusionWork, Reason, Stage, Unit, Visible};

/// Smaller occluders hide next to nothing.
const LEAST_PIXELS: f32 = 16.0;

/// What a view keeps of its occlusion buffer.
#[derive(Clone, Debug, Default)]
pub(super) struct OcclusionState {
    pub(super) buffer: Option<OcclusionBuffer>,
    candidates: Vec<Candidate>,
    /// Slots and shapes that were drawn.
    pub(super) drawn: Vec<(u32, u32)>,
    footprints: Vec<(u32, Footprint)>,
}

impl OcclusionState {
    /// Why an instance is hidden or not, in words: which pixel lets it through, or what covers it.
    pub(super) fn finding(&self, scene: &Scene, slot: u32) -> String {
        let Some(buffer) = &self.buffer else { return String::new() };
        let [width, height] = buffer.size();
        let Some(footprint) = buffer.footprint_of(&scene.bounds(slot)) else {
            return "crosses the near plane, or has no bounds: never hidden".to_owned();
        };
        let Footprint { min: [x0, y0], max: [x1, y1], nearness } = footprint;
        let place = format!(
            "pixels {x0}..={x1} x {y0}..={y1} of {width} x {height}, nearness {nearness:e}"
        );
        match buffer.first_open(&footprint) {
            Some([x, y]) => format!(
                "{place}: pixel ({x}, {y}) lets it through, covered only at {:e}",
                buffer.nearness(x, y)
            ),
            None => format!("{place}: all covered by what is nearer"),
        }
    }

    /// The instances of which something covers a footprint alone or in part, front to back.
    pub(super) fn blockers(
        &self,
        culler: &Culler,
        scene: &Scene,
        view: &View,
        slot: u32,
    ) -> Vec<u32> {
        let (Some(buffer), mut found) = (&self.buffer, Vec::new()) else { return Vec::new() };
        let Some(footprint) = buffer.footprint_of(&scene.bounds(slot)) else { return found };
        let Ok(mut alone) = OcclusionBuffer::new(buffer.size()) else { return found };
        for &(by, shape) in &self.drawn {
            alone.begin(view, scene.origin());
            draw(
                &mut alone,
                culler,
                scene,
                by,
                &scene.mesh(by).occluder().shapes()[shape as usize],
            );
            let Footprint { min, max, nearness } = footprint;
            let covers = (min[1]..=max[1])
                .any(|y| (min[0]..=max[0]).any(|x| alone.nearness(x, y) > nearness));
            if covers && !found.contains(&by) {
                found.push(by);
            }
        }
        found
    }
}

/// Draws a shape of an instance.
fn draw(buffer: &mut OcclusionBuffer, culler: &Culler, scene: &Scene, slot: u32, shape: &Shape) {
    let transform = scene.transform(slot);
    match shape {
        Shape::Convex(convex) => buffer.draw_convex(culler.level, convex, transform),
        Shape::Patch(patch) => buffer.draw_patch(culler.level, patch, transform),
    }
}

impl Pass<'_> {
    /// Drops instances whose boxes are hidden.
    pub(super) fn occlusion(&mut self, settings: &Occlusion) {
        let entered = self.alive_count();
        if let Some(slot) = self.only {
            self.occlusion_of(slot);
        } else {
            self.occlusion_of_all(settings);
        }
        let left = self.alive_count();
        self.row(Stage::Occlusion, Unit::Instances, entered, left);
    }

    fn occlusion_of_all(&mut self, settings: &Occlusion) {
        let mut state = std::mem::take(&mut self.scratch.occlusion);
        let size = settings.size(self.view.viewport());
        if state.buffer.as_ref().is_none_or(|b| b.size() != size) {
            // Never refused: the size is within the limits.
            state.buffer = OcclusionBuffer::new(size).ok();
        }
        if let Some(mut buffer) = state.buffer.take() {
            buffer.begin(self.view, self.scene.origin());
            self.gather(&buffer, &mut state);
            let offered = state.candidates.len() as u64;
            choose(&mut state.candidates, settings.budget);
            let chosen = state.candidates.len() as u64;
            self.draw(&mut buffer, &mut state);
            self.result.funnel.occlusion =
                OcclusionWork { offered, chosen, drawn: state.drawn.len() as u64 };
            for &(slot, footprint) in &state.footprints {
                if buffer.covers(&footprint) {
                    self.scratch.alive[slot as usize / 64] &= !(1 << (slot % 64));
                    self.drop_slot(slot, Reason { stage: Stage::Occlusion, detail: 0 });
                }
            }
            state.buffer = Some(buffer);
        }
        self.scratch.occlusion = state;
    }

    /// The footprint of every instance that may be dropped, and the shapes that may hide it.
    fn gather(&mut self, buffer: &OcclusionBuffer, state: &mut OcclusionState) {
        let scene = self.scene;
        state.candidates.clear();
        state.footprints.clear();
        let fronts_are_drawn = fronts_are_drawn(self.view);
        let near = near_box(self.view, scene.origin());
        let (live, alive) = (&self.scratch.live, &self.scratch.alive);
        buffer.footprints(self.culler.level, scene.boxes(), live, alive, &mut state.footprints);
        let mut known = state.footprints.iter().peekable();
        for &word in live {
            for bit in bits::ones(alive[word as usize]) {
                let slot = word * 64 + bit as u32;
                let footprint = known.next_if(|(s, _)| *s == slot).map(|(_, f)| *f);
                if footprint.is_none_or(|f| f.pixels() >= LEAST_PIXELS) {
                    let candidates = &mut state.candidates;
                    let first = candidates.len();
                    offer(scene, buffer, slot, footprint, fronts_are_drawn, candidates);
                    if candidates.len() > first && is_within(scene, slot, &near) {
                        let shapes = scene.mesh(slot).occluder().shapes();
                        let is_left = |c: &Candidate| !is_body(&shapes[c.shape as usize]);
                        let left: Vec<_> = candidates.drain(first..).filter(is_left).collect();
                        candidates.extend(left);
                    }
                }
            }
        }
        let is_exempt = |slot: u32| scene.exempt()[slot as usize / 64] >> (slot % 64) & 1 == 1;
        state.footprints.retain(|&(slot, _)| !is_exempt(slot));
    }

    /// Draws the chosen, front to back; one that is hidden by then adds nothing.
    fn draw(&self, buffer: &mut OcclusionBuffer, state: &mut OcclusionState) {
        state.drawn.clear();
        for c in &state.candidates {
            let shape = &self.scene.mesh(c.slot).occluder().shapes()[c.shape as usize];
            if c.footprint.is_some_and(|f| buffer.covers(&f)) {
                continue;
            }
            draw(buffer, self.culler, self.scene, c.slot, shape);
            state.drawn.push((c.slot, c.shape));
        }
    }

    /// One slot alone: what hides it is everything else, so all of the scene is culled to know.
    fn occlusion_of(&mut self, slot: u32) {
        let all =
            Culler { output: Output::Instances, reasons: true, clock: None, ..self.culler.clone() };
        let (mut scratch, mut result) = (Scratch::default(), Visible::default());
        Pass::new(&all, self.scene, self.view, &mut scratch, &mut result).run();
        let hidden = Reason { stage: Stage::Occlusion, detail: 0 };
        if result.reasons[slot as usize] == Some(hidden) {
            self.scratch.alive[slot as usize / 64] &= !(1 << (slot % 64));
            self.drop_slot(slot, hidden);
        }
        self.scratch.occlusion = scratch.occlusion;
        self.result.funnel.occlusion = result.funnel.occlusion;
    }
}

/// Whether the view draws the fronts of one-sided meshes: where it draws their backs alone, as some shadow passes
/// do, their fronts hide nothing.
fn fronts_are_drawn(view: &View) -> bool {
    matches!(
        (view.cull_face, view.front_face),
        (CullFace::None, _)
            | (CullFace::Back, FrontFace::CounterClockwise)
            | (CullFace::Front, FrontFace::Clockwise)
    )
}

/// A box around the view's eye and its near rectangle, relative to an origin: what the near plane cuts away
/// hides nothing. Everything, where a corner is not known.
fn near_box(view: &View, origin: [f64; 3]) -> Aabb {
    let Some(corners) = view.frustum().corners() else { return Aabb::EVERYTHING };
    let eye = view.eye();
    let points = corners[..4].iter().chain((eye[3] != 0.0).then_some(&eye));
    let (mut min, mut max) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in points {
        for a in 0..3 {
            let v = p[a] / p[3] - origin[a];
            if !v.is_finite() {
                return Aabb::EVERYTHING;
            }
            // Corners are off by their rounding.
            let slack = (p[a].abs() + origin[a].abs()) * 1e-9;
            min[a] = min[a].min(v - slack);
            max[a] = max[a].max(v + slack);
        }
    }
    Aabb::rounded_out(min, max)
}

/// Whether the view may begin within what the occluder of an instance seals off.
fn is_within(scene: &Scene, slot: u32, near: &Aabb) -> bool {
    let sealed = scene.mesh(slot).occluder().sealed().iter();
    sealed.map(|b| scene.transform(slot).transform_box(b, scene.origin())).any(|b| {
        // A NaN is no proof that they are apart.
        !(0..3).any(|a| near.min[a] > b.max[a] || near.max[a] < b.min[a])
    })
}

/// Whether a shape is a closed body.
fn is_body(shape: &Shape) -> bool {
    matches!(shape, Shape::Convex(convex) if convex.face_count() > 2)
}

/// Offers the shapes of an instance.
fn offer(
    scene: &Scene,
    buffer: &OcclusionBuffer,
    slot: u32,
    footprint: Option<Footprint>,
    fronts_are_drawn: bool,
    candidates: &mut Vec<Candidate>,
) {
    let flags = scene.flags(slot);
    if flags.no_occlusion || flags.transparent || !scene.is_rigid(slot) {
        return;
    }
    let shapes = scene.mesh(slot).occluder().shapes();
    for (number, shape) in shapes.iter().enumerate() {
        if !(fronts_are_drawn || shape.is_two_sided()) {
            continue;
        }
        let own = match shapes {
            [_] => footprint,
            _ => buffer.footprint_of(&world_box(scene, slot, shape)),
        };
        let (pixels, nearness) = match own {
            Some(f) => (f.pixels(), f.nearness),
            None if buffer.ask_box(&world_box(scene, slot, shape)) == Verdict::Outside => continue,
            None => (buffer.size().iter().map(|&s| s as f32).product(), f32::INFINITY),
        };
        if pixels >= LEAST_PIXELS {
            let cost = Candidate::cost(shape, pixels);
            let shape = number as u32;
            candidates.push(Candidate { pixels, nearness, footprint: own, slot, shape, cost });
        }
    }
}

/// The box of a shape relative to the scene's origin.
pub(super) fn world_box(scene: &Scene, slot: u32, shape: &Shape) -> Aabb {
    scene.transform(slot).transform_box(&shape.bounds(), scene.origin())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cull::occlusion::{Convex, Occluder};
    use crate::mesh::{Mesh, MeshData};
    use crate::scene::Instance;
    use crate::transform::Transform;
    use crate::view::{Camera, Depth, Projection};
    use crate::{ViewState, Visible};

    fn cube(half: f32) -> Mesh {
        let b = Aabb::new([-half; 3], [half; 3]);
        let faces: [[u32; 4]; 6] =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        Mesh::new(MeshData {
            positions: b.corners().to_vec(),
            indices: faces.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect(),
            ..MeshData::default()
        })
        .unwrap()
    }

    #[test]
    fn a_box_hides_nothing_from_within_what_it_was_baked_in() {
        let mut scene = Scene::new();
        let mut room = cube(10.0);
        // Something solid in the room's middle, as a bake would find it from outside.
        let body = Convex::from_box(&Aabb::new([-5.0; 3], [5.0; 3])).unwrap();
        let sealed = vec![Aabb::new([-10.0; 3], [10.0; 3])];
        room.set_occluder(Occluder::new(vec![Shape::Convex(body)]).with_sealed(sealed));
        let mut thing = cube(0.5);
        thing.set_occluder(Occluder::default());
        let [room, thing] = [room, thing].map(|m| scene.add_mesh(m));
        scene.add(Instance::new(room, Transform::IDENTITY)).unwrap();
        let behind = Transform::from_translation([0.0, 0.0, -8.0]);
        scene.add(Instance::new(thing, behind)).unwrap();
        let culler = Culler {
            occlusion: Some(Occlusion::default()),
            output: Output::Instances,
            ..Culler::default()
        };
        let drawn = |z: f64| {
            let lens =
                Projection::Perspective { fov_y_radians: 1.0, aspect: 1.0, near: 0.1, far: 100.0 };
            let camera = Camera::look_at([0.0, 0.0, z], [0.0; 3], lens);
            let view = View::new(&camera, Depth::Reversed, [256, 256]).unwrap();
            let (mut state, mut visible) = (ViewState::default(), Visible::default());
            culler.cull_one(&scene, &view, &mut state, &mut visible);
            assert!(state.occlusion_buffer().is_some());
            (state.occluders_drawn().len(), visible.instance_count)
        };
        assert_eq!(drawn(40.0), (1, 1));
        assert_eq!(drawn(8.0), (0, 2));
        // The near rectangle comes in before the eye does.
        assert_eq!(drawn(10.05), (0, 2));
    }
}
