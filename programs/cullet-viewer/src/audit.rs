//! The audit of bounds: which instances leave the boxes that culling tests, and so may vanish while
//! they are visible.

use std::sync::Arc;

use cullet::Scene;
use cullet::scene::BoundsViolation;

use crate::lines::{Lines, tint};
use crate::task::{Progress, Task};
use crate::world::World;

/// The audit of a scene, made once for each.
#[derive(Debug, Default)]
pub struct Audit {
    /// Scene that is audited.
    of: Option<Arc<World>>,
    task: Option<Task<Result<Vec<BoundsViolation>, String>>>,
    found: Option<Vec<BoundsViolation>>,
}

/// The bounds violations of a scene, with its instances where they stand now.
///
/// # Errors
/// None that a scene gives rise to; the text for the user.
pub fn find(scene: &Scene) -> Result<Vec<BoundsViolation>, String> {
    scene.audit(|_| None).map_err(|e| e.to_string())
}

impl Audit {
    /// The bounds violations, once the audit is done.
    #[must_use]
    pub fn found(&self) -> Option<&[BoundsViolation]> {
        self.found.as_deref()
    }

    /// Whether nothing is to be waited for.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        self.task.is_none()
    }

    /// Begins, goes on or forgets, as `wanted`; what the user is to be told is returned. `wake` is
    /// called when it is done.
    pub fn advance(
        &mut self,
        shown: &Arc<World>,
        wanted: bool,
        wake: impl FnOnce() + Send + 'static,
    ) -> Option<String> {
        if !wanted {
            *self = Self::default();
            return None;
        }
        if !self.of.as_ref().is_some_and(|w| Arc::ptr_eq(w, shown)) {
            let world = Arc::clone(shown);
            let task = Task::start(move || find(&world.model.scene), wake);
            *self = Self { of: Some(Arc::clone(shown)), task: Some(task), found: None };
        }
        let result = match self.task.as_ref()?.poll() {
            Progress::Working => return None,
            Progress::Done(result) => result,
            Progress::Lost => Err("the audit of bounds ended without a result".to_owned()),
        };
        self.task = None;
        match result {
            Ok(found) => {
                self.found = Some(found);
                None
            }
            Err(text) => Some(text),
        }
    }

    /// Adds the boxes of what was found, and a line from each to its vertex farthest outside.
    pub fn draw(&self, scene: &Scene, most: usize, lines: &mut Lines) {
        draw(scene, self.found().unwrap_or_default(), most, lines);
    }
}

fn draw(scene: &Scene, violations: &[BoundsViolation], most: usize, lines: &mut Lines) {
    let red = tint(cullet_draw::palette::LOST, 255);
    for violation in violations.iter().take(most) {
        let b = scene.bounds(violation.slot);
        lines.edges(&b, scene.origin(), red);
        let origin = glam::DVec3::from(scene.origin());
        let [middle, vertex] =
            [b.center(), violation.position].map(|p| glam::DVec3::from(p) + origin);
        lines.line(middle, vertex, red);
    }
}

#[cfg(test)]
mod tests {
    use cullet::bounds::Aabb;
    use cullet::scene::BoundsOverride;

    use super::*;

    #[test]
    fn what_leaves_its_bounds_is_found_and_drawn() {
        let mut scene = cullet_scenes::build("solids").expect("built in").scene;
        assert_eq!(find(&scene), Ok(Vec::new()));
        let slot = scene.slots().next().expect("some");
        let handle = scene.handle(slot).expect("some");
        let centre = scene.bounds(slot).center().map(|v| v as f32);
        let small = Aabb::new(centre, centre.map(|v| v + 0.01));
        scene.set_bounds(handle, BoundsOverride::World(small)).expect("there");
        scene.commit(&cullet::Culler::default());
        let found = find(&scene).expect("sound");
        assert_eq!(found.iter().map(|s| s.handle).collect::<Vec<_>>(), [handle]);
        let mut lines = Lines::default();
        draw(&scene, &found, 10, &mut lines);
        assert_eq!(lines.0.len(), 26, "a box and a line");
        draw(&scene, &found, 0, &mut lines);
        assert_eq!(lines.0.len(), 26);
    }
}
