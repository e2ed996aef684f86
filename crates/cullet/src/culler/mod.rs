//! The culler: runs the stages in order and says what is left.

mod answer;
mod candidates;
mod evidence;
mod explain;
mod frame;
mod log;
mod pipeline;
mod run;
mod sets;
mod shadow;
mod stage;
mod standing;
mod threads;
mod with;
mod words;

pub use candidates::{Candidates, Look};
pub use evidence::{CellTest, CoverTest, Evidence, PlaneTest, Sight};
pub use explain::{Explanation, Step};
pub use shadow::ShadowView;

use thiserror::Error;

use crate::Simd;
use crate::costs::Costs;
#[cfg(feature = "lossy")]
use crate::cull::detail::Detail;
use crate::cull::occlusion::{Occlusion, OcclusionBuffer};
use crate::funnel::{Stage, Unit};
use crate::jobs::OneThread;
#[cfg(feature = "lossy")]
use crate::lod::Lod;
use crate::scene::{Scene, SceneError};
use crate::view::View;
use crate::visible::Visible;
#[cfg(any(feature = "candidates", feature = "shadows"))]
use frame::Viewer;
#[cfg(feature = "shadows")]
use standing::Looks;

/// How deep the answer goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Output {
    /// Whole instances: [`Visible::whole`] alone.
    #[cfg_attr(not(feature = "clusters"), default)]
    Instances,
    /// Instances, and of those that straddle the frustum or are one-sided the clusters that are
    /// left.
    #[cfg(feature = "clusters")]
    #[default]
    Clusters,
    /// Triangles of every visible instance, in [`Visible::triangles`].
    #[cfg(feature = "clusters")]
    Triangles,
}

impl Output {
    /// The deepest unit of the answer.
    pub(crate) const fn unit(self) -> Unit {
        match self {
            Self::Instances => Unit::Instances,
            #[cfg(feature = "clusters")]
            Self::Clusters => Unit::Clusters,
            #[cfg(feature = "clusters")]
            Self::Triangles => Unit::Triangles,
        }
    }
}

/// Method of culling the back faces of one-sided parts. All methods apply to rigid instances only.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum Backface {
    /// Culls no back faces.
    Off,
    /// Whole clusters by an elliptic cone, where the output is clusters or triangles; then, for
    /// triangles, each by a plane of four bytes, and the few that are in doubt from their corners.
    /// Cones and planes are [prepared](crate::prepared::Prepared) when the scene is committed; of a
    /// mesh that came since, clusters are kept, and triangles are tested from their corners. The
    /// triangles left are those that `Exact` leaves.
    #[default]
    Fast,
    /// Every triangle from its corners, where the output is triangles: nothing is prepared, and it
    /// takes some fifty times as long.
    Exact,
}

/// Settings of culling; no state. The answer depends on the scene, the view and these alone.
///
/// # Presets
///
/// [`exact`](Self::exact) finds as much as can be proved, [`balanced`](Self::balanced) what pays in
/// most frames, and [`fast`](Self::fast) what is found soonest. None has a stage that is lossy.
/// They differ in these fields alone:
///
/// | field | unit, range | `exact` | `balanced` | `fast` | a higher value |
/// |---|---|---|---|---|---|
/// | `frustum_exact` | on or off | on | off | off | an exact test for each box that straddles |
/// | `occlusion.width` | pixels, 1 to 4,096, at most the viewport's | 1280 | 640 | 320 | clearing and drawing by its square; smaller gaps are seen through less |
/// | `occlusion.budget` | microseconds of the cost model, from 0 | 100,000 | 200 | 80 | draws more occluders |
/// | `occlusion.risk` | share of the cost of what is left to draw, from 0; or none | none | 0.015 | 0.015 | draws occluders in frames that are cheap to draw |
///
/// The others are the same in each: no preset is lossy, nor does one change the `output`, for how
/// finely it draws is the renderer's to choose. `cullet bench pays` measures on a scene whether a
/// preset's occlusion gives back what it takes.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
#[non_exhaustive]
pub struct Culler {
    /// Cull what is outside the frustum. Default on. Cost: at most six planes for each node, and
    /// for each box that straddles the frustum; what a view remembers saves most of them.
    pub frustum: bool,
    /// After the plane test, also test the frustum's corners against the faces of boxes that
    /// straddle: drops big boxes near its corners, at the cost of an exact test for each of them.
    /// Default off.
    pub frustum_exact: bool,
    /// Cull what is not among the [candidates](Candidates) of a mask, or of the visible sets of
    /// cells. Default on; it does nothing without candidates. As conservative as those are. Cost:
    /// none to speak of.
    pub pvs: bool,
    /// Cull what candidates by cells and portals do not see, and of what they see in part the
    /// clusters beside that. Default on; it does nothing without such candidates. Conservative as
    /// far as the cells say what is true.
    pub portal: bool,
    /// How to cull back faces of one-sided parts. Default [`Backface::Fast`]: a cone for each
    /// cluster, and where the output is triangles four bytes each.
    pub backface: Backface,
    /// Cull triangles without area. Default on. Cost: none, for a mesh knows them since it was
    /// made.
    pub degenerate: bool,
    /// Cull what is small on the screen, in pixels from 0: lossy, so off by default. Cost: a bound
    /// of the size of each instance that is not below a node of instances that are all too small.
    #[cfg(feature = "lossy")]
    pub detail: Option<Detail>,
    /// Draw [levels of detail](crate::lod) in place of meshes that [have
    /// some](crate::Scene::add_levels), as coarse as the threshold allows: lossy, so off by
    /// default. Of rigid instances alone. Cost: that of [choosing](crate::lod::Levels::select) for
    /// each of them.
    #[cfg(feature = "lossy")]
    pub lod: Option<Lod>,
    /// Cull instances that lie behind others, and where the output is finer, clusters of rigid
    /// instances that do. Not lossy: what is dropped is proved to be hidden, at every resolution,
    /// or to be beyond an edge of the screen. On by default, as far as it [pays](Occlusion::risk)
    /// by the [`costs`](Self::costs).
    ///
    /// Only what is drawn hides. [Levels](Self::lod) are chosen first: an instance that is drawn by
    /// levels, by an impostor or by a stand-in hides nothing, for the proof is of the mesh in full;
    /// nor does one that [fades](Detail::fade). An instance that hid others keeps the clusters that
    /// [`Detail::clusters`] would drop.
    pub occlusion: Option<Occlusion>,
    /// Costs by which [`occlusion`](Self::occlusion) chooses what to draw, and whether. Default
    /// [`Costs::default`]; give those of your renderer.
    pub costs: Costs,
    /// How deep the answer goes.
    pub output: Output,
    /// Fill [`Visible::reasons`]. Default off. Cost: two bytes a slot.
    pub reasons: bool,
    /// Whether [`Visible::dropped`] is filled too: the triangles that stages took from instances
    /// that they did not take as a whole. It has no effect without [`reasons`](Self::reasons).
    /// Default off.
    pub dropped: bool,
    /// The SIMD level; the answer is the same at every level. Default: the best of the machine.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub simd: Simd,
    /// A clock in nanoseconds, for the times in the funnel. Default none: no times.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub clock: Option<fn() -> u64>,
}

impl Default for Culler {
    /// [`Culler::balanced`].
    fn default() -> Self {
        Self::balanced()
    }
}

/// State of one view that a culler keeps between frames: scratch memory, and results proved of the
/// scene's hierarchy. It notices by itself that the scene is another, or has changed. Dropping it
/// costs time, never an answer.
#[derive(Clone, Debug, Default)]
pub struct ViewState {
    scratch: pipeline::Scratch,
    standing: standing::Standing,
}

impl ViewState {
    /// The occlusion buffer as the last cull of this view left it; `None` before a cull with
    /// [`Culler::occlusion`], and after one that found that it would [not pay](Occlusion::risk). A
    /// later cull without leaves it as it is.
    #[must_use]
    pub fn occlusion_buffer(&self) -> Option<&OcclusionBuffer> {
        self.scratch.caches.occlusion.buffer()
    }

    /// Occluders drawn into that buffer, front to back: slots, and which of the shapes of the
    /// slot's [occluder](crate::prepared::Prepared::occluder).
    #[must_use]
    pub fn occluders_drawn(&self) -> &[(u32, u32)] {
        &self.scratch.caches.occlusion.drawn
    }
}

/// Why a call to a culler is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum CullError {
    /// One state and one result a view.
    #[error("{views} views, but {states} states and {results} results")]
    Counts {
        /// How many views.
        views: usize,
        /// How many states.
        states: usize,
        /// How many results.
        results: usize,
    },
    /// One bit a slot.
    #[error(
        "a mask of {words} words, but {slots} slots take {expected}: of another scene, or an earlier order?"
    )]
    Candidates {
        /// Number of words of the mask.
        words: usize,
        /// Number of words that the scene takes.
        expected: usize,
        /// Number of slots of the scene.
        slots: u32,
    },
    /// Candidates of another scene, or of another order of its slots.
    #[error(
        "candidates of order {found} of a scene, but the scene has order {expected}: update them first"
    )]
    Order {
        /// Order version that the candidates are of.
        found: u64,
        /// Order version of the scene.
        expected: u64,
    },
    /// The handle names no instance.
    #[error(transparent)]
    Scene(#[from] SceneError),
}

impl Culler {
    /// Returns settings that find as much as can be proved: all that a wide buffer and a budget
    /// larger than any frame needs can find. No stage is lossy. They are for tools, and for
    /// renderers to which a triangle costs much: `cullet report --preset exact` shows what there is
    /// to be found.
    #[must_use]
    pub fn exact() -> Self {
        let occlusion = Occlusion { width: 1280, budget: 100_000.0, risk: None };
        Self { frustum_exact: true, occlusion: Some(occlusion), ..Self::balanced() }
    }

    /// Returns settings that pay in most frames: every stage that is not lossy. Where occlusion
    /// finds nothing, it spends no more than [1.5 %](Occlusion::risk) of the cost of drawing what
    /// is left.
    #[must_use]
    pub fn balanced() -> Self {
        Self {
            frustum: true,
            frustum_exact: false,
            pvs: true,
            portal: true,
            backface: Backface::default(),
            degenerate: true,
            #[cfg(feature = "lossy")]
            detail: None,
            #[cfg(feature = "lossy")]
            lod: None,
            occlusion: Some(Occlusion { risk: Some(0.015), ..Occlusion::default() }),
            costs: Costs::default(),
            output: Output::default(),
            reasons: false,
            dropped: false,
            simd: Simd::best(),
            clock: None,
        }
    }

    /// Returns settings for the shortest culling time: occlusion in a narrow buffer, by few
    /// occluders. No stage is lossy. [`detail`](Self::detail) under a pixel was tried: projecting
    /// each of a city's instances took longer than all else together.
    #[must_use]
    pub fn fast() -> Self {
        let occlusion = Occlusion { width: 320, budget: 80.0, risk: Some(0.015) };
        Self { occlusion: Some(occlusion), ..Self::balanced() }
    }

    /// These settings with no stage but one, which is on: with its own settings, or the default
    /// ones where it was off. Layers always apply, for they belong to the view. A stage that does
    /// not exist yet leaves nothing but them.
    #[must_use]
    pub fn only(&self, stage: Stage) -> Self {
        let others = Stage::ALL.into_iter().filter(|&s| s != stage);
        let mut only = others.fold(self.clone(), |culler, other| culler.without(other));
        match stage {
            Stage::Frustum => only.frustum = true,
            Stage::Pvs => only.pvs = true,
            Stage::Portal => only.portal = true,
            #[cfg(feature = "lossy")]
            Stage::Detail => only.detail = self.detail.or_else(|| Some(Detail::default())),
            Stage::Occlusion => {
                only.occlusion = self.occlusion.or_else(|| Some(Occlusion::default()));
            }
            Stage::Backface if self.backface == Backface::Off => only.backface = Backface::Fast,
            Stage::Degenerate => only.degenerate = true,
            #[cfg(feature = "lossy")]
            Stage::Lod => only.lod = self.lod.or_else(|| Some(Lod::default())),
            _ => {}
        }
        only
    }

    /// These settings without one stage. Layers always apply, for they belong to the view.
    #[must_use]
    pub fn without(&self, stage: Stage) -> Self {
        let mut without = self.clone();
        match stage {
            Stage::Frustum => (without.frustum, without.frustum_exact) = (false, false),
            Stage::Pvs => without.pvs = false,
            Stage::Portal => without.portal = false,
            #[cfg(feature = "lossy")]
            Stage::Detail => without.detail = None,
            Stage::Occlusion => without.occlusion = None,
            Stage::Backface => without.backface = Backface::Off,
            Stage::Degenerate => without.degenerate = false,
            #[cfg(feature = "lossy")]
            Stage::Lod => without.lod = None,
            _ => {}
        }
        without
    }

    /// Culls one scene for several views, each as [`cull_one`](Self::cull_one) would; with the
    /// feature `rayon` side by side on the threads of its pool. Walking the nodes once for all
    /// views was tried: nodes are shared, but tests are not, and what a view remembers of its last
    /// frame saves more.
    ///
    /// # Errors
    /// If there is not one state and one result for each view.
    pub fn cull(
        &self,
        scene: &Scene,
        views: &[View],
        states: &mut [ViewState],
        results: &mut [Visible],
    ) -> Result<(), CullError> {
        cull_each(views, states, results, |view, state, result| {
            self.cull_one(scene, view, state, result);
        })
    }

    /// Culls for one view. The result ascends by slot. Allocates nothing once `state` and `result`
    /// have grown to what the scene needs.
    ///
    /// Where scene, view and settings are those of the last two calls with this state, the answer
    /// is copied: some microseconds. The second of these calls keeps it, which takes memory once. A
    /// [clock](Self::clock) prevents that.
    pub fn cull_one(
        &self,
        scene: &Scene,
        view: &View,
        state: &mut ViewState,
        result: &mut Visible,
    ) {
        self.cull_one_on(&OneThread, scene, view, state, result);
    }

    /// Culls one scene for several lights, or for the [cascades](ShadowView::cascades) of one, each
    /// as [`cull_shadow`](Self::cull_shadow) would; with the feature `rayon` side by side on the
    /// threads of its pool.
    ///
    /// # Errors
    /// If there is not one state and one result for each.
    #[cfg(feature = "shadows")]
    pub fn cull_shadows(
        &self,
        scene: &Scene,
        shadows: &[ShadowView],
        states: &mut [ViewState],
        results: &mut [Visible],
    ) -> Result<(), CullError> {
        cull_each(shadows, states, results, |shadow, state, result| {
            self.cull_shadow(scene, shadow, state, result);
        })
    }

    /// Culls for one view among `candidates`, the instances that the caller takes for visible; all
    /// others are dropped after the frustum stage, by the stages of the candidates. The answer is
    /// what is left of [`cull_one`](Self::cull_one)'s, but for what dropped instances would have
    /// hidden. Cost: none to speak of.
    ///
    /// ```
    /// # use cullet::{Culler, Instance, Mesh, MeshData, Scene, Transform, View, ViewState, Visible};
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let positions = vec![[1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0]];
    /// # let indices = vec![0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];
    /// # let mut scene = Scene::new();
    /// # let mesh = scene.add_mesh(Mesh::new(MeshData { positions, indices, ..MeshData::default() })?);
    /// # let mut handles = Vec::new();
    /// # for x in [-3.0, 0.0, 3.0] {
    /// #     handles.push(scene.add(Instance::new(mesh, Transform::from_translation([x, 0.0, -20.0])))?);
    /// # }
    /// # scene.commit(&cullet::Culler::default());
    /// # let view = View::perspective([0.0; 3], [0.0, 0.0, -1.0], 0.8, 0.1, 100.0, [640, 480])?;
    /// # let (culler, mut state, mut visible) = (Culler::default(), ViewState::default(), Visible::default());
    /// // The player has explored the middle alone.
    /// let explored = scene.slot(handles[1])?;
    /// let mut mask = vec![0_u64; scene.slot_count().div_ceil(64) as usize];
    /// mask[explored as usize / 64] |= 1 << (explored % 64);
    /// culler.cull_among(&scene, &view, &mask, &mut state, &mut visible)?;
    /// assert!(visible.slots().eq([explored]));
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// The errors of [`Candidates::check`]; `state` and `result` stay as they are then.
    #[cfg(feature = "candidates")]
    pub fn cull_among(
        &self,
        scene: &Scene,
        view: &View,
        candidates: &dyn Candidates,
        state: &mut ViewState,
        result: &mut Visible,
    ) -> Result<(), CullError> {
        candidates.check(scene)?;
        // Nobody knows here whether candidates are those of before.
        state.standing.forget();
        let viewer = Viewer::Among(view, candidates);
        pipeline::run((self, &OneThread), scene, viewer, None, &mut state.scratch, result);
        Ok(())
    }

    /// Culls for a light: what casts a shadow that its camera sees. The same stages by the same
    /// settings, with the region where a caster can matter in place of a frustum; see
    /// [`ShadowView`]. What the frustum stage took went because its shadow cannot matter, and
    /// [`Reason::caster`](crate::Reason::caster) says why. Conservative: no point of what was
    /// dropped is between the light and a receiver, or what hides it from the light is kept.
    ///
    /// Use one state for each light and camera. Cost: that of a camera's view, and the shadow
    /// region once.
    #[cfg(feature = "shadows")]
    pub fn cull_shadow(
        &self,
        scene: &Scene,
        shadows: &ShadowView,
        state: &mut ViewState,
        result: &mut Visible,
    ) {
        let ViewState { scratch, standing } = state;
        standing.answer((self, scene), Looks::Light(shadows.clone()), result, |result| {
            pipeline::run((self, &OneThread), scene, Viewer::Light(shadows), None, scratch, result);
        });
    }
}

/// Runs `cull_one` for each view, with the feature `rayon` side by side.
fn cull_each<V: Sync>(
    views: &[V],
    states: &mut [ViewState],
    results: &mut [Visible],
    cull_one: impl Fn(&V, &mut ViewState, &mut Visible) + Sync,
) -> Result<(), CullError> {
    if states.len() != views.len() || results.len() != views.len() {
        return Err(CullError::Counts {
            views: views.len(),
            states: states.len(),
            results: results.len(),
        });
    }
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        let all = views.par_iter().zip(states).zip(results);
        all.for_each(|((view, state), result)| cull_one(view, state, result));
    }
    #[cfg(not(feature = "rayon"))]
    for ((view, state), result) in views.iter().zip(states).zip(results) {
        cull_one(view, state, result);
    }
    Ok(())
}
