//! A scene made again with other sides or doors, beside the one that is shown.

use std::sync::Arc;

use crate::state::Alteration;
use crate::task::{Progress, Task};
use crate::world::World;

/// A scene being made again with other sides or doors, beside the one that is shown.
#[derive(Debug, Default)]
pub struct Remaking {
    task: Option<(Alteration, Task<Result<World, String>>)>,
    /// An alteration that the scene could not be given; it is not tried again.
    refused: Option<Alteration>,
}

impl Remaking {
    /// Whether a scene is as it is wanted, or cannot be.
    #[must_use]
    pub fn is_settled(&self, whole: &World, wanted: &Alteration) -> bool {
        self.task.is_none() && (is_of(wanted, whole) || self.refused.as_ref() == Some(wanted))
    }

    /// Goes on towards what is wanted of a whole scene: begins to make it again, and returns it
    /// once it is made, or what the user is to be told. `wake` is called when it is.
    pub fn advance(
        &mut self,
        whole: &Arc<World>,
        wanted: &Alteration,
        wake: impl FnOnce() + Send + 'static,
    ) -> Option<Result<Arc<World>, String>> {
        if let Some((made_as, task)) = &self.task {
            let made = match task.poll() {
                Progress::Working => return None,
                Progress::Done(made) => made,
                Progress::Lost => Err("The other sides or doors ended without a result".to_owned()),
            };
            let is_wanted = made_as == wanted;
            self.task = None;
            // Another may be wanted by now.
            if is_wanted {
                if made.is_err() {
                    self.refused = Some(wanted.clone());
                }
                return Some(made.map(Arc::new));
            }
        }
        if !self.is_settled(whole, wanted) {
            self.task = Some((wanted.clone(), remake(Arc::clone(whole), wanted.clone(), wake)));
        }
        None
    }
}

/// Whether a scene is altered so.
fn is_of(wanted: &Alteration, world: &World) -> bool {
    world.sides == wanted.sides && world.doors == wanted.doors
}

#[cfg(not(target_arch = "wasm32"))]
fn remake(
    whole: Arc<World>,
    wanted: Alteration,
    wake: impl FnOnce() + Send + 'static,
) -> Task<Result<World, String>> {
    Task::start(move || whole.altered(wanted.sides, &wanted.doors), wake)
}

#[cfg(target_arch = "wasm32")]
use crate::web::remake;
