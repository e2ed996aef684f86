//! Cells as one view sees them: candidates by visible sets and portals.

mod portal;
mod pvs;
mod stand;

use alloc::vec::Vec;
use core::cell::{Ref, RefCell};

use cullet::{
    CullError, Culler, Handle, Scene, Stage, View, ViewState, Visible,
    candidates::{Candidates, Look},
    explain::{Evidence, Explanation},
    view::Frustum,
};

use crate::bits;
use crate::cell::CellGraph;
use crate::cells::Cells;
use crate::portal::{PortalOptions, Reached};

/// State of one view among cells, kept from frame to frame: where its eye is, which cells it
/// reaches, and the visible sets of those that it is in. Dropping it costs time, never an answer.
#[derive(Clone, Debug, Default)]
pub struct CellView {
    /// How portals are cut.
    pub options: PortalOptions,
    pvs: pvs::Cache,
    portal: portal::Cache,
    late: Late,
}

impl CellView {
    /// Returns the candidates of a scene with cells, for [`Culler::cull_among`].
    pub fn on<'a>(&'a mut self, cells: &'a Cells) -> CellCandidates<'a> {
        CellCandidates { cells, view: RefCell::new(self) }
    }

    /// Culls a scene, among the cells that it may have, as [`Culler::cull_one`] and
    /// [`Culler::cull_among`] do.
    pub fn cull<'a>(
        &mut self,
        world: impl Into<InCells<'a>>,
        culler: &Culler,
        view: &View,
        state: &mut ViewState,
        result: &mut Visible,
    ) {
        let world = world.into();
        let among = world
            .cells
            .map(|cells| culler.cull_among(world.scene, view, &self.on(cells), state, result));
        // Without cells, and where they are not those of the scene.
        if among.is_none_or(|among| among.is_err()) {
            culler.cull_one(world.scene, view, state, result);
        }
    }

    /// Returns the cells that the last cull of this view reached through portals; `None` where
    /// portals did nothing.
    #[must_use]
    pub fn reached(&self) -> Option<&Reached> {
        self.portal.reached()
    }
}

/// A scene with the cells that it may have.
#[derive(Clone, Copy, Debug)]
pub struct InCells<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its cells; none where portals and sets hide nothing.
    pub cells: Option<&'a Cells>,
}

impl<'a> From<&'a Scene> for InCells<'a> {
    fn from(scene: &'a Scene) -> Self {
        Self { scene, cells: None }
    }
}

impl<'a> From<(&'a Scene, &'a Cells)> for InCells<'a> {
    fn from((scene, cells): (&'a Scene, &'a Cells)) -> Self {
        Self::new(scene, Some(cells))
    }
}

impl<'a> InCells<'a> {
    /// Takes cells that are of the scene as it is, but for instances that moved; others hide
    /// nothing.
    #[must_use]
    pub fn new(scene: &'a Scene, cells: Option<&'a Cells>) -> Self {
        Self { scene, cells: cells.filter(|cells| cells.check(scene).is_ok()) }
    }

    /// Returns the graph of the cells, if there are any.
    #[must_use]
    pub fn graph(self) -> Option<&'a CellGraph> {
        self.cells.map(Cells::graph)
    }

    /// Returns the cell of a point in world space, if there are cells; see [`Cells::cell_of`].
    #[must_use]
    pub fn cell_of(self, point: [f64; 3]) -> Option<u32> {
        self.cells?.cell_of(point)
    }

    /// Culls for one view, and finds where that is among the cells each time. A renderer keeps a
    /// [`CellView`] for each view.
    pub fn cull(self, culler: &Culler, view: &View, state: &mut ViewState, result: &mut Visible) {
        CellView::default().cull(self, culler, view, state, result);
    }

    /// Culls for one view and returns the cells that it reaches through portals; `None` where
    /// portals do nothing.
    #[must_use]
    pub fn reached(self, culler: &Culler, view: &View) -> Option<Reached> {
        let (mut own, mut state, mut result) =
            (CellView::default(), ViewState::default(), Visible::default());
        culler.cull_among(self.scene, view, &own.on(self.cells?), &mut state, &mut result).ok()?;
        own.reached().cloned()
    }

    /// Explains an instance for one view, as [`Culler::explain`] does.
    ///
    /// # Errors
    /// If the handle names no instance.
    pub fn explain(
        self,
        culler: &Culler,
        view: &View,
        handle: Handle,
    ) -> Result<Explanation, CullError> {
        Ok(self.explain_many(culler, view, &[handle])?.remove(0))
    }

    /// Explains instances for one view, as [`Culler::explain_many`] and [`Culler::explain_among`]
    /// do.
    ///
    /// # Errors
    /// If a handle names no instance.
    pub fn explain_many(
        self,
        culler: &Culler,
        view: &View,
        handles: &[Handle],
    ) -> Result<Vec<Explanation>, CullError> {
        match self.cells.filter(|cells| cells.check(self.scene).is_ok()) {
            Some(cells) => {
                culler.explain_among(self.scene, view, &CellView::default().on(cells), handles)
            }
            None => culler.explain_many(self.scene, view, handles),
        }
    }
}

/// Instances that a view may see among cells.
#[derive(Debug)]
pub struct CellCandidates<'a> {
    cells: &'a Cells,
    view: RefCell<&'a mut CellView>,
}

impl CellCandidates<'_> {
    fn view(&self) -> Ref<'_, CellView> {
        Ref::map(self.view.borrow(), |view| &**view)
    }
}

impl Candidates for CellCandidates<'_> {
    fn check(&self, scene: &Scene) -> Result<(), CullError> {
        self.cells.check(scene)
    }

    fn stages(&self) -> &[Stage] {
        &[Stage::Pvs, Stage::Portal]
    }

    fn look(&self, stage: Stage, look: &Look<'_>, alive: &[u64], live: &[u32]) {
        let CellView { options, pvs, portal, late } = &mut **self.view.borrow_mut();
        late.find(look.scene, self.cells);
        match stage {
            Stage::Pvs => pvs.look(look, self.cells, look.culler.portal && options.mirrors > 0),
            _ => portal.look(look, self.cells, options, (alive, live)),
        }
    }

    fn word(&self, stage: Stage, word: usize) -> u64 {
        let view = self.view();
        let seen = match stage {
            Stage::Pvs => view.pvs.word(self.cells, word),
            _ => view.portal.word(self.cells, word),
        };
        seen | view.late.word(word)
    }

    fn detail(&self, _: Stage, slot: u32) -> u8 {
        stand::detail(self.cells, slot)
    }

    fn straddling(&self, word: usize) -> u64 {
        let view = self.view();
        view.portal.straddling(self.cells, word) & !view.late.word(word)
    }

    fn frusta(&self, scene: &Scene, slot: u32, each: &mut dyn FnMut(&Frustum)) {
        self.view().portal.frusta((scene, self.cells), slot, each);
    }

    fn explain(&self, stage: Stage, scene: &Scene, slot: u32) -> Evidence {
        let view = self.view();
        let is_late = bits::get(&[view.late.word(slot as usize / 64)], slot as usize % 64);
        match stage {
            Stage::Pvs => view.pvs.evidence((scene, self.cells), slot, is_late),
            _ => view.portal.evidence((scene, self.cells), slot, is_late),
        }
    }
}

/// Instances that moved since the cells were updated: they are seen from everywhere.
#[derive(Clone, Debug, Default)]
struct Late {
    /// One bit a slot; words that are missing are zero.
    words: Vec<u64>,
    are_all: bool,
}

impl Late {
    fn find(&mut self, scene: &Scene, cells: &Cells) {
        self.words.clear();
        self.are_all = false;
        if scene.logged() == cells.logged() {
            return;
        }
        let Some(changes) = scene.changes_since(cells.logged()) else {
            self.are_all = true;
            return;
        };
        for change in changes {
            match change {
                cullet::scene::SceneChange::Moved(slot)
                | cullet::scene::SceneChange::Permuted(slot) => {
                    let words = (slot as usize / 64 + 1).max(self.words.len());
                    self.words.resize(words, 0);
                    bits::set(&mut self.words, slot as usize, true);
                }
                cullet::scene::SceneChange::All => self.are_all = true,
            }
        }
    }

    fn word(&self, word: usize) -> u64 {
        match self.are_all {
            true => u64::MAX,
            false => self.words.get(word).copied().unwrap_or(0),
        }
    }
}
