//! The cut-away: a scene cut by a plane or a box, its solids closed by caps, as a scene of its own.
//! It is culled, drawn and clicked like any other.

use std::ops::ControlFlow;
use std::sync::Arc;

use cullet::bounds::Plane;
use cullet::prepared::Preparation;
use cullet_cut::{CutModel, Keep, ModelError, ModelOptions, ModelReport, box_planes, cut_model};
use glam::DVec3;

use crate::state::{CutAway, Part, Shape};
use crate::task::{Progress, Task};
use crate::world::World;

/// The most triangles of things that a plane goes through: each becomes a mesh of its own. A page
/// has less memory, and waits while it cuts.
pub const MOST_CUT: u64 = if cfg!(target_arch = "wasm32") { 400_000 } else { 4_000_000 };
/// An outline of a cut, in world space.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// The plane that it lies in.
    pub plane: Plane,
    /// Its points; the last is joined to the first.
    pub points: Vec<[f64; 3]>,
}

/// The planes of a cut, in world space, pointing out of what [`Part::Inside`] keeps.
#[must_use]
pub fn planes(how: &CutAway, world: &World) -> Vec<Plane> {
    let (centre, half) = (DVec3::from(world.centre), DVec3::from(world.half));
    match how.shape {
        Shape::Plane => {
            let n = DVec3::from(how.normal).normalize_or(DVec3::X);
            let d = n.dot(centre) + how.at * n.abs().dot(half);
            vec![Plane::new(n.into(), d)]
        }
        Shape::Box => {
            let (a, b) = (DVec3::from(how.low), DVec3::from(how.high));
            let at = |v: DVec3| (centre + v * half).to_array();
            box_planes(at(a.min(b)), at(a.max(b))).to_vec()
        }
    }
}

/// A cut scene.
#[derive(Debug)]
pub struct CutWorld {
    /// The scene.
    pub world: Arc<World>,
    /// The outlines, if they are wanted.
    pub outlines: Vec<Outline>,
    /// Report of the cut.
    pub report: ModelReport,
    /// Milliseconds that it took.
    pub milliseconds: f32,
}

/// Cuts every instance of a scene, as [`cut_model`] does. Of a mesh that is left open, because it
/// has no cap, both sides are shown. Bounds are those of the meshes, whatever they were set to.
///
/// # Errors
/// The text of what is wrong, for the user: more than [`MOST_CUT`] triangles to cut, or nothing
/// left.
pub fn cut(whole: &World, how: &CutAway) -> Result<CutWorld, String> {
    let began = crate::task::clock();
    let planes = planes(how, whole);
    let options = ModelOptions {
        planes: &planes,
        keep: match how.part {
            Part::Inside => Keep::Inside,
            Part::Outside => Keep::Outside,
        },
        caps: how.caps,
        outlines: how.outlines,
        show_insides: true,
        most_triangles: Some(MOST_CUT),
        ..ModelOptions::default()
    };
    let done =
        cut_model(&whole.model, &options, || ControlFlow::Continue(())).map_err(|e| match e {
            ModelError::TooLarge { triangles, limit } => format!(
                "The cut goes through things with {triangles} triangles, more than the {limit} that are cut while \
                 you look. Move it, or try a smaller scene; cullet cut has no such limit"
            ),
            e => e.to_string(),
        })?;
    let CutModel { mut model, report, sections, .. } = done;
    model.scene.prepare(Preparation::default());
    if model.scene.instance_count() == 0 {
        return Err("The cut leaves nothing of the scene".to_owned());
    }
    let outlines = sections.into_iter().flat_map(|section| {
        let plane = planes[section.plane];
        section.outlines.into_iter().map(move |points| Outline { plane, points })
    });
    let outlines = outlines.collect();
    // The camera, the map and the cut itself go by the whole scene.
    let World { reach, centre, half, sides, .. } = *whole;
    let world = World { reach, centre, half, sides, ..World::new(model, whole.name.clone()) };
    let milliseconds = (crate::task::clock() - began) as f32 * 1e-6;
    Ok(CutWorld { world: Arc::new(world), outlines, report, milliseconds })
}

/// The cut under way, and what is shown of the last one.
#[derive(Debug, Default)]
pub struct Cutting {
    /// The scene before it was cut, while a cut is shown or made.
    pub whole: Option<Arc<World>>,
    /// The outlines of what is shown.
    pub outlines: Vec<Outline>,
    /// Report of the last cut.
    pub report: ModelReport,
    /// Milliseconds that it took.
    pub milliseconds: f32,
    /// The cut that was made last, or found impossible.
    done: Option<CutAway>,
    task: Option<(CutAway, Task<Result<CutWorld, String>>)>,
}

impl Cutting {
    /// Whether a cut is being made.
    #[must_use]
    pub fn is_working(&self) -> bool {
        self.task.is_some()
    }

    /// Whether what is shown is what is wanted.
    #[must_use]
    pub fn is_settled(&self, wanted: &CutAway) -> bool {
        let shown =
            if wanted.on { self.done.as_ref() == Some(wanted) } else { self.whole.is_none() };
        shown && self.task.is_none()
    }

    /// Goes on towards what is wanted of the scene that is shown: begins a cut, one at a time, and
    /// returns the scene to show in its place, or what the user is to be told. `wake` is called
    /// when a cut is done.
    pub fn advance(
        &mut self,
        shown: &Arc<World>,
        wanted: &CutAway,
        wake: impl FnOnce() + Send + 'static,
    ) -> Option<Result<Arc<World>, String>> {
        if !wanted.on {
            let whole = self.whole.take();
            // A cut that is under way is about nothing any more.
            *self = Self::default();
            return whole.filter(|w| !Arc::ptr_eq(w, shown)).map(Ok);
        }
        let came = match self.task.as_ref().map(|(_, task)| task.poll()) {
            Some(Progress::Working) => return None,
            Some(Progress::Done(result)) => Some(result),
            Some(Progress::Lost) => Some(Err("The cut ended without a result".to_owned())),
            None => None,
        };
        if let Some(result) = came {
            self.done = self.task.take().map(|(how, _)| how);
            return Some(result.map(|made| {
                (self.outlines, self.report) = (made.outlines, made.report);
                self.milliseconds = made.milliseconds;
                made.world
            }));
        }
        if self.done.as_ref() != Some(wanted) {
            let whole = Arc::clone(self.whole.get_or_insert_with(|| Arc::clone(shown)));
            let how = wanted.clone();
            self.task = Some((wanted.clone(), Task::start(move || cut(&whole, &how), wake)));
        }
        None
    }
}

#[cfg(test)]
mod tests {

    use super::*;
    use crate::lines::to_world;

    fn world(text: &str) -> World {
        World::new(cullet_scenes::build(text).expect("built in"), text.to_owned())
    }

    /// The volume of all meshes of a scene, by the theorem of Gauss; of closed ones it is right.
    fn volume(world: &World) -> f64 {
        let scene = &world.model.scene;
        scene
            .slots()
            .flat_map(|slot| {
                let (mesh, t) = (scene.mesh(slot), *scene.transform(slot));
                (0..mesh.triangle_count()).map(move |i| {
                    let [a, b, c] = mesh.corners(i).map(|p| to_world(&t, p));
                    a.dot(b.cross(c)) / 6.0
                })
            })
            .sum()
    }

    #[test]
    fn two_halves_with_caps_have_the_volume_of_the_whole() {
        let whole = world("solids");
        for how in [
            CutAway { normal: [0.3, 1.0, 0.2], at: 0.1, ..CutAway::default() },
            CutAway { shape: Shape::Box, low: [-0.4; 3], high: [0.5; 3], ..CutAway::default() },
        ] {
            let inside = cut(&whole, &how).expect("cut");
            let outside = cut(&whole, &CutAway { part: Part::Outside, ..how }).expect("cut");
            assert!(inside.report.instances_cut > 0 && inside.report.cap_area > 0.0);
            assert_eq!(inside.report.open_edges, 0);
            let (sum, all) = (volume(&inside.world) + volume(&outside.world), volume(&whole));
            assert!((sum - all).abs() < all * 1e-4, "{sum} {all}");
            assert!(volume(&inside.world) > 0.0 && volume(&inside.world) < all);
        }
    }

    #[test]
    fn what_is_shown_lies_on_the_side_that_is_kept() {
        let whole = world("solids");
        let how = CutAway { normal: [1.0, 0.5, 0.0], at: -0.2, ..CutAway::default() };
        let plane = planes(&how, &whole)[0];
        let made = cut(&whole, &how).expect("cut");
        let scene = &made.world.model.scene;
        for slot in scene.slots() {
            let mesh = scene.mesh(slot);
            for p in mesh.positions() {
                let height = plane.distance(to_world(scene.transform(slot), *p));
                assert!(height < 1e-4 * whole.reach, "{height}");
            }
        }
        for outline in &made.outlines {
            for p in &outline.points {
                assert!(plane.distance(*p).abs() < 1e-4 * whole.reach);
            }
        }
        assert!(!made.outlines.is_empty());
    }

    #[test]
    fn without_caps_both_sides_of_what_is_open_are_shown() {
        let whole = world("solids");
        let made = cut(&whole, &CutAway { caps: false, ..CutAway::default() }).expect("cut");
        assert_eq!(made.report.cap_triangles, 0);
        assert!(!made.outlines.is_empty(), "outlines need no caps");
        let scene = &made.world.model.scene;
        assert!(scene.slots().any(|s| scene.mesh(s).is_two_sided()));
    }

    #[test]
    fn a_cut_beside_the_scene_leaves_it_or_nothing() {
        let whole = world("solids");
        let far = CutAway { at: 2.0, ..CutAway::default() };
        let made = cut(&whole, &far).expect("cut");
        assert_eq!(made.report.instances_untouched, whole.counts.instances);
        assert_eq!(made.world.counts, whole.counts);
        let error = cut(&whole, &CutAway { part: Part::Outside, ..far }).expect_err("nothing");
        assert!(error.contains("leaves nothing"), "{error}");
    }
}
