//! The proof for the present view: `cullet verify`, in the background.

use cullet::{Culler, Stage, View, ViewState};
use cullet_draw::{VerifyOptions, verify};
use std::sync::Arc;

use crate::task::{Progress, Task};
use crate::world::World;

/// The longest side of the frames that the proof draws: more would take long and tell little more.
const LONGEST: u32 = 640;

/// Result of the proof.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Finding {
    /// Triangles of all instances.
    pub all: u64,
    /// Triangles that the culler left.
    pub kept: u64,
    /// Triangles that own a pixel.
    pub visible: u64,
    /// Slots of which something visible was dropped; ascending. Empty if culling is right.
    pub lost: Vec<u32>,
    /// One bit a slot: kept, though no pixel shows it.
    pub unseen: Vec<bool>,
    /// How many those are.
    pub unseen_count: u64,
    /// Instances kept.
    pub kept_instances: u64,
    /// The size of the frames that were compared.
    pub size: [u32; 2],
    /// The view that it is about.
    pub view: Option<View>,
}

/// The proof, if one was requested.
#[derive(Debug, Default)]
pub enum Truth {
    /// None was requested.
    #[default]
    None,
    /// Under way.
    Working(Task<Finding>),
    /// Done.
    Done(Box<Finding>),
}

impl Truth {
    /// Begins the proof for a view and settings; `wake` is called when it is done.
    pub fn start(
        world: Arc<World>,
        view: View,
        culler: Culler,
        wake: impl FnOnce() + Send + 'static,
    ) -> Self {
        Self::Working(Task::start(move || find(&world, &view, &culler), wake))
    }

    /// Looks whether it is done; false if it was lost.
    pub fn poll(&mut self) -> bool {
        if let Self::Working(task) = self {
            match task.poll() {
                Progress::Working => {}
                Progress::Done(finding) => *self = Self::Done(Box::new(finding)),
                Progress::Lost => {
                    *self = Self::None;
                    return false;
                }
            }
        }
        true
    }

    /// The result, once the proof is done.
    #[must_use]
    pub fn finding(&self) -> Option<&Finding> {
        match self {
            Self::Done(finding) => Some(finding),
            _ => None,
        }
    }
}

/// Draws the view with and without culling, each without levels of detail, and compares, at most
/// [`LONGEST`] pixels wide and high.
fn find(world: &World, view: &View, culler: &Culler) -> Finding {
    let [w, h] = view.viewport();
    let longest = w.max(h).max(1);
    let share =
        |v: u32| (u64::from(v) * u64::from(LONGEST.min(longest)) / u64::from(longest)) as u32;
    let size = [share(w).max(1), share(h).max(1)];
    // The same frustum on fewer pixels.
    let smaller = View::from_matrix(view.clip_from_world(), view.depth(), size).map(|mut v| {
        (v.layers, v.front_face, v.cull_face) = (view.layers, view.front_face, view.cull_face);
        v
    });
    let small = smaller.unwrap_or_else(|_| view.clone());
    let scene = &world.model.scene;
    // Levels of detail change the picture; all else must not.
    let culler = culler.without(Stage::Lod).with_clock(None);
    let options = VerifyOptions { samples: 2, ..VerifyOptions::default() };
    let found =
        verify(world.model.in_cells(), &small, &culler, &mut ViewState::default(), &options);
    let mut lost: Vec<u32> = found.false_culls.iter().map(|f| f.slot).collect();
    lost.dedup();
    let mut unseen = vec![false; scene.slot_count() as usize];
    let mut kept_instances = 0;
    for slot in found.result.slots() {
        unseen[slot as usize] = true;
        kept_instances += 1;
    }
    for id in &found.seen {
        unseen[id.slot as usize] = false;
    }
    Finding {
        all: found.all,
        kept: found.potentially_visible,
        visible: found.visible,
        lost,
        unseen_count: unseen.iter().filter(|u| **u).count() as u64,
        unseen,
        kept_instances,
        size: small.viewport(),
        view: Some(view.clone()),
    }
}
