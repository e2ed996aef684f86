//! Facts that the engine found about the scene that a stop of the tour shows: its answers are taken
//! from here.

use cullet::cull::occlusion::Occlusion;
use cullet::{Culler, Output, Reason, Scene, Stage, View, ViewState, Visible, funnel::Unit};
use glam::DVec3;

use super::Session;
use crate::decide::Request;
use crate::numbers::grouped;
use crate::study::Seen;

/// A decision, as the question of a stop is about it.
#[derive(Debug)]
pub(super) struct Facts<'a> {
    session: &'a Session,
    visible: &'a Visible,
    request: &'a Request,
    stages: &'static [Stage],
}

impl<'a> Facts<'a> {
    /// Returns the facts of the newest decision, with figures of the first of some stages; `None`
    /// before any decision.
    pub(super) fn of(session: &'a Session, stages: &'static [Stage]) -> Option<Self> {
        let decision = session.decision.as_ref()?;
        let (visible, request) = (&decision.visible, &decision.request);
        Some(Self { session, visible, request, stages })
    }

    fn scene(&self) -> &'a Scene {
        &self.request.world.model.scene
    }

    /// Triangles of the scene.
    pub(super) fn all(&self) -> u64 {
        self.request.world.counts.triangles
    }

    /// Triangles that are drawn.
    pub(super) fn left(&self) -> u64 {
        if self.session.state.stages.on { self.visible.triangle_count } else { self.all() }
    }

    /// Triangles that came to the stage.
    fn entered(&self) -> u64 {
        let rows = &self.visible.funnel.rows;
        let row = rows.iter().find(|row| self.stages.first() == Some(&row.stage));
        row.map_or(0, |row| row.entered.triangles)
    }

    /// Triangles that it dropped.
    pub(super) fn dropped(&self) -> u64 {
        self.stages.first().map_or(0, |&stage| self.dropped_by(stage))
    }

    fn dropped_by(&self, stage: Stage) -> u64 {
        self.visible.funnel.dropped(stage).triangles
    }

    /// The share of what came to it.
    pub(super) fn share_dropped(&self) -> f64 {
        self.dropped() as f64 / self.entered().max(1) as f64
    }

    /// How many of some ascending bounds a share has passed.
    pub(super) fn band(&self, share: f64, bounds: &[f64]) -> usize {
        bounds.iter().filter(|bound| share > **bound).count()
    }

    /// Returns the index of the number in `to` that a share is nearest to.
    pub(super) fn nearest(&self, share: f64, to: &[f64]) -> usize {
        let apart = |i: &usize| (share - to[*i]).abs();
        (0..to.len()).min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap_or(0)
    }

    /// Whether of the instances that went for their size one is in view and not proved to be
    /// hidden: it may own pixels.
    pub(super) fn drops_what_may_be_seen(&self) -> bool {
        let occlusion = Some(Occlusion::default());
        let others = self.again(&self.culler().without(Stage::Detail).with_occlusion(occlusion));
        let mut both = self.visible.reasons.iter().zip(&others.reasons);
        let is_small = |r: &Option<Reason>| r.is_some_and(|r| r.stage == Stage::Detail);
        both.any(|(reason, other)| is_small(reason) && other.is_none())
    }

    /// 0 where as many triangles go with whole clusters as one by one, 1 where fewer do, 2 where
    /// more.
    pub(super) fn clusters_against_triangles(&self) -> usize {
        let one_by_one = self.again(&self.culler().with_output(Output::Triangles));
        let singly = one_by_one.funnel.dropped(Stage::Backface).triangles;
        match self.dropped_by(Stage::Backface).cmp(&singly) {
            std::cmp::Ordering::Equal => 0,
            std::cmp::Ordering::Less => 1,
            std::cmp::Ordering::Greater => 2,
        }
    }

    /// 0 where the study finds all back faces of what is inspected, 1 where it finds some, 2 where
    /// one of them is a front.
    pub(super) fn masks_against_triangles(&self) -> usize {
        let (Some(figures), Some(inspected)) = (&self.session.figures, &self.session.inspected)
        else {
            return 1;
        };
        let (scene, slot) = (self.scene(), inspected.slot);
        let mesh = scene.mesh(slot);
        let seen = Seen { mesh, transform: scene.transform(slot), view: &self.request.view };
        let Some([x, y, z, w]) = seen.eye() else { return 1 };
        let is_front = |t: &u32| {
            let [a, b, c] = mesh.corners(*t).map(|p| DVec3::from(p.map(f64::from)));
            (b - a).cross(c - a).dot(DVec3::new(x, y, z) - a * w) > 0.0
        };
        if figures.proved.iter().any(is_front) {
            return 2;
        }
        usize::from((figures.proved.len() as u32) < figures.away)
    }

    /// Triangles of caps of the cut.
    pub(super) fn caps(&self) -> u64 {
        self.session.cutting.report.cap_triangles
    }

    /// 0 where the stage comes first, 1 where it comes later with whole instances or clusters, 2
    /// where it goes by triangles.
    pub(super) fn place_in_the_funnel(&self) -> usize {
        let rows = &self.visible.funnel.rows;
        match rows.iter().position(|row| self.stages.first() == Some(&row.stage)) {
            Some(0) => 0,
            Some(at) if rows[at].unit != Unit::Triangles => 1,
            _ => 2,
        }
    }

    /// 0 where no triangle that goes for want of area has any, else 2.
    pub(super) fn pixels_of_degenerate(&self) -> usize {
        let has_area = self.scene().meshes().iter().any(|mesh| {
            let count = mesh.triangle_count();
            (count - mesh.degenerate_count()..count).any(|t| {
                let [a, b, c] = mesh.corners(t).map(|p| DVec3::from(p.map(f64::from)));
                (b - a).cross(c - a) != DVec3::ZERO
            })
        });
        if has_area { 2 } else { 0 }
    }

    /// 0 where the set of the eye's cell leaves more triangles than the walk through portals, 1
    /// where fewer, 2 where as many.
    pub(super) fn set_against_walk(&self) -> usize {
        let left = |stage| self.again(&self.culler().only(stage)).triangle_count;
        match left(Stage::Pvs).cmp(&left(Stage::Portal)) {
            std::cmp::Ordering::Greater => 0,
            std::cmp::Ordering::Less => 1,
            std::cmp::Ordering::Equal => 2,
        }
    }

    /// Returns the index of the stage that dropped the most.
    pub(super) fn greediest(&self) -> usize {
        let most = self.stages.iter().map(|&stage| self.dropped_by(stage)).max();
        let at = self.stages.iter().position(|&stage| Some(self.dropped_by(stage)) == most);
        at.unwrap_or(0)
    }

    fn culler(&self) -> Culler {
        self.request.culler.clone()
    }

    /// The same view, culled in another way.
    fn again(&self, culler: &Culler) -> Visible {
        let view: &View = &self.request.view;
        let mut visible = Visible::default();
        let world = self.request.world.model.in_cells();
        world.cull(culler, view, &mut ViewState::default(), &mut visible);
        visible
    }

    /// A sentence with its figures: of the scene, of the first stage of the stop, of the study and
    /// of the cut.
    pub(super) fn fill(&self, sentence: &str) -> String {
        let study = self.session.figures.as_ref();
        let (entered, dropped) = (self.entered(), self.dropped());
        let figures = [
            ("{all}", self.all()),
            ("{left}", self.left()),
            ("{entered}", entered),
            ("{dropped}", dropped),
            ("{kept}", entered.saturating_sub(dropped)),
            ("{caps}", self.caps()),
            ("{proved}", study.map_or(0, |f| f.proved.len() as u64)),
            ("{away}", study.map_or(0, |f| u64::from(f.away))),
        ];
        figures.iter().fold(sentence.to_owned(), |text, (name, n)| text.replace(name, &grouped(*n)))
    }
}
