//! A scene made again with other sides, beside the one that is shown.

use std::sync::Arc;

use crate::state::Sides;
use crate::task::{Progress, Task};
use crate::world::World;

/// A scene being made again with other sides, beside the one that is shown.
#[derive(Debug, Default)]
pub struct Remaking {
    task: Option<(Sides, Task<Result<World, String>>)>,
    /// Sides that the scene could not be given; they are not tried again.
    refused: Option<Sides>,
}

impl Remaking {
    /// Whether a scene has the sides that are wanted, or cannot have them.
    #[must_use]
    pub fn is_settled(&self, whole: &World, wanted: Sides) -> bool {
        self.task.is_none() && (whole.sides == wanted || self.refused == Some(wanted))
    }

    /// Goes on towards the sides that are wanted of a whole scene: begins to make it again, and returns it once it is
    /// made, or what the user is to be told. `wake` is called when it is.
    pub fn advance(
        &mut self,
        whole: &Arc<World>,
        wanted: Sides,
        wake: impl FnOnce() + Send + 'static,
    ) -> Option<Result<Arc<World>, String>> {
        if let Some((sides, task)) = &self.task {
            let made = match task.poll() {
                Progress::Working => return None,
                Progress::Done(made) => made,
                Progress::Lost => Err("The other sides ended without a result".to_owned()),
            };
            let sides = *sides;
            self.task = None;
            // Other sides may be wanted by now.
            if sides == wanted {
                if made.is_err() {
                    self.refused = Some(wanted);
                }
                return Some(made.map(Arc::new));
            }
        }
        if !self.is_settled(whole, wanted) {
            self.task = Some((wanted, remake(Arc::clone(whole), wanted, wake)));
        }
        None
    }
}

#[cfg(not(target_arch = "wasm32"))]
fn remake(
    whole: Arc<World>,
    sides: Sides,
    wake: impl FnOnce() + Send + 'static,
) -> Task<Result<World, String>> {
    Task::start(move || whole.with_sides(sides), wake)
}

#[cfg(target_arch = "wasm32")]
use crate::web::remake;
