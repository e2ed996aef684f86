//! The tour: what each kind of culling does to the scene that is open, one after the other, for those who see it
//! for the first time.

use cullet::{Backface, Output};

use super::Session;
use crate::camera::Chase;
use crate::state::{GhostForm, Ghosts, Layout, Look, Stages};

/// A stop of the tour: what is said, and the switches that show it.
#[derive(Clone, Copy, Debug)]
pub struct Stop {
    /// Its title.
    pub title: &'static str,
    /// Its explanation.
    pub words: &'static str,
    stages: fn() -> Stages,
    ghosts: GhostForm,
    /// Where the camera outside stands: by how many degrees around from where it follows, and how much nearer.
    around: f64,
    nearer: f64,
}

/// All stops, each of which culls what the one before it did, and more.
pub const STOPS: [Stop; 5] = [
    Stop {
        title: "Nothing is culled",
        words: "Left is what the camera sees. Right is the same from outside: the white lines bound what the \
                camera can see. Without culling the renderer is handed all of it, seen or not.",
        stages: Stages::none,
        ghosts: GhostForm::Off,
        around: 0.0,
        nearer: 1.0,
    },
    Stop {
        title: "Frustum culling",
        words: "What lies wholly outside the white lines cannot be in the left picture, so it is dropped: blue on \
                the right. The left picture has not changed.",
        stages: Stages::frustum_only,
        ghosts: GhostForm::Solid,
        around: 0.0,
        nearer: 1.0,
    },
    Stop {
        title: "Back-face culling",
        words: "Of a closed mesh only the near side is seen. Right, from aside and near: the triangles that face away \
                from the camera are culled too, and bodies stand open. The left picture has not changed.",
        stages: faces,
        ghosts: GhostForm::Off,
        around: 62.0,
        nearer: 8.0,
    },
    Stop {
        title: "Occlusion culling",
        words: "What lies behind something nearer is not seen either: orange. Only what is white is left, and the \
                left picture is still the same.",
        stages: hidden,
        ghosts: GhostForm::Solid,
        around: 0.0,
        nearer: 1.0,
    },
    Stop {
        title: "Why is it missing?",
        words: "Click an instance on the right, best an orange one. Inspect, in the panel, says which test culled it, \
                with the numbers, and which occluders hide it; a click on such a name inspects that instance.",
        stages: hidden,
        ghosts: GhostForm::Solid,
        around: 0.0,
        nearer: 1.0,
    },
];

/// Down to triangles: an instance of one cluster loses nothing to back-face culling of clusters.
fn faces() -> Stages {
    Stages { backface: Backface::Fast, depth: Output::Triangles, ..Stages::frustum_only() }
}

fn hidden() -> Stages {
    Stages { depth: Output::Triangles, ..Stages::default() }
}

/// How far a tour has come, and what it goes back to.
#[derive(Clone, Debug)]
pub struct Tour {
    at: usize,
    before: (Stages, Layout, Ghosts, Look, Chase),
}

impl Tour {
    /// The stop's number, from 0.
    #[must_use]
    pub fn at(&self) -> usize {
        self.at
    }

    /// The stop.
    #[must_use]
    pub fn stop(&self) -> &'static Stop {
        &STOPS[self.at]
    }
}

impl Session {
    /// Begins the tour, goes on with it, or ends it after its last stop.
    pub fn tour_on(&mut self) {
        match self.tour.as_ref().map(|t| t.at + 1) {
            None if self.world.is_some() => self.tour_to(0),
            None => {}
            Some(at) if at < STOPS.len() => self.tour_to(at),
            Some(_) => self.end_tour(),
        }
    }

    /// Goes back by a stop; from the first one nowhere.
    pub fn tour_back(&mut self) {
        if let Some(at) = self.tour.as_ref().and_then(|t| t.at.checked_sub(1)) {
            self.tour_to(at);
        }
    }

    /// Ends the tour. Switches are put back to where they were; the camera stays.
    pub fn end_tour(&mut self) {
        let Some(tour) = self.tour.take() else { return };
        let state = &mut self.state;
        (state.stages, state.layout, state.ghosts, state.look, self.chase) = tour.before;
    }

    fn tour_to(&mut self, at: usize) {
        if self.state.frozen.is_some() {
            // Where it culls is where one begins.
            self.toggle_outside();
        }
        let state = &mut self.state;
        let stop = &STOPS[at];
        let chase = self.chase;
        let tour = self.tour.get_or_insert_with(|| {
            let (stages, ghosts, look) =
                (state.stages.clone(), state.ghosts.clone(), state.look.clone());
            Tour { at, before: (stages, state.layout, ghosts, look, chase) }
        });
        tour.at = at;
        state.stages = (stop.stages)();
        state.layout = Layout::Split;
        state.ghosts = Ghosts { form: stop.ghosts, ..Ghosts::default() };
        state.look = Look::default();
        let usual = Chase::default();
        // A small scene is looked at from aside already, all of it.
        let near = self.world.as_ref().is_some_and(|w| w.is_large());
        self.chase = match near {
            true => {
                Chase { yaw: usual.yaw + stop.around, nearer: usual.nearer * stop.nearer, ..usual }
            }
            false => usual,
        };
    }
}
