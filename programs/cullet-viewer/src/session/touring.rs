//! The tour: what each kind of culling does, one after the other, on scenes that show it, for those
//! who see it for the first time; and a question about each. Afterwards all is as it was.

use std::sync::Arc;

use super::Session;
use super::tour_facts::Facts;
use super::tour_steps::{STOPS, Stop};
use crate::camera::Chase;
use crate::journey::Journey;
use crate::link;
use crate::state::State;
use crate::world::{Source, World};

/// Seconds that the camera outside takes from where it stood to where it stands next.
const FLIGHT: f64 = 0.9;

/// How far a tour has come, and what it goes back to.
#[derive(Debug)]
pub struct Tour {
    at: usize,
    phase: Phase,
    given: Option<Given>,
    /// From where to where the camera outside flies, and how much of the way is done, from 0 to 1.
    flight: Option<([Chase; 2], f64)>,
    before: Before,
}

/// How far a stop has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// Its scene is loaded.
    Coming,
    /// Its scene is there, and is not yet decided about.
    Fresh,
    /// All is there to be looked at.
    Ready,
}

/// The answer that was given, and what the engine says to it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Given {
    /// The number of the choice.
    pub choice: usize,
    /// Index of the right one.
    pub right: usize,
    /// Why, in a sentence.
    pub because: String,
}

impl Given {
    /// Whether it was the right one.
    #[must_use]
    pub fn is_right(&self) -> bool {
        self.choice == self.right
    }
}

/// State when the tour began.
#[derive(Debug)]
struct Before {
    state: Box<State>,
    world: Option<Arc<World>>,
    chase: Chase,
    journey: Journey,
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

    /// The answer to its question, once one was given.
    #[must_use]
    pub fn given(&self) -> Option<&Given> {
        self.given.as_ref()
    }

    /// Whether its scene is there and an answer can be given.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        self.phase == Phase::Ready
    }

    /// Whether nothing moves of its own accord, and all is there.
    pub(super) fn is_settled(&self) -> bool {
        self.is_ready() && self.flight.is_none()
    }

    /// Whether the scene that is there next is the tour's own.
    pub(super) fn is_coming(&self) -> bool {
        self.phase == Phase::Coming
    }
}

impl Session {
    /// Begins the tour, goes on with it, or ends it after its last stop.
    pub fn tour_on(&mut self) {
        match self.tour.as_ref().map(|t| t.at + 1) {
            // What is being loaded is what the user wants to see first.
            None if self.loading().is_none() => self.tour_to(0),
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

    /// Answers the question of the stop, once: later answers, and numbers that no choice has, are
    /// not heard.
    pub fn answer(&mut self, choice: usize) {
        let Some(tour) = self.tour.as_ref().filter(|t| t.is_ready() && t.given.is_none()) else {
            return;
        };
        let stop = tour.stop();
        let Some(facts) = Facts::of(self, stop.stages).filter(|_| choice < stop.choices.len())
        else {
            return;
        };
        let (right, because) = ((stop.right)(&facts), facts.fill(stop.because));
        if let Some(tour) = &mut self.tour {
            tour.given = Some(Given { choice, right, because });
        }
    }

    /// Ends the tour. Scene, cameras and switches are again as they were; light and panels stay as
    /// they are.
    pub fn end_tour(&mut self) {
        let Some(Tour { before, phase, .. }) = self.tour.take() else { return };
        if phase == Phase::Coming {
            self.stop_loading();
        }
        let State { dark, panels, always, hover_turns, .. } = self.state;
        self.state = State { dark, panels, always, hover_turns, ..*before.state };
        self.chase = before.chase;
        let shown = self.whole().map(Arc::as_ptr);
        if shown != before.world.as_ref().map(Arc::as_ptr) {
            self.enter_again(before.world);
        }
        self.journey = before.journey;
    }

    /// The stop in words, for readers of a screen: the question with its choices, or whether the
    /// answer was right.
    #[must_use]
    pub fn tour_in_words(&self) -> Option<String> {
        let tour = self.tour.as_ref()?;
        let stop = tour.stop();
        let Some(given) = &tour.given else {
            let choices = (1..).zip(stop.choices).map(|(n, choice)| format!(" {n}: {choice}."));
            let (at, all) = (tour.at + 1, STOPS.len());
            let Stop { title, words, question, .. } = stop;
            let choices: String = choices.collect();
            return Some(format!(
                "Step {at} of {all}: {title}. {words} Question: {question}{choices}"
            ));
        };
        let (said, because) = (given.in_words(stop), &given.because);
        Some(format!("{said} {because}"))
    }

    fn tour_to(&mut self, at: usize) {
        let Ok(State { scene, .. }) = link::from_text(STOPS[at].state) else { return };
        let tour = self.tour.take().unwrap_or_else(|| {
            let world = self.whole().cloned();
            let state = Box::new(self.state.clone());
            let journey = std::mem::take(&mut self.journey);
            let before = Before { state, world, chase: self.chase, journey };
            Tour { at, phase: Phase::Coming, given: None, flight: None, before }
        });
        self.tour = Some(Tour { at, phase: Phase::Coming, given: None, flight: None, ..tour });
        self.inspected = None;
        self.stop_loading();
        if self.whole().is_some_and(|world| world.name == scene) {
            self.arrive(false);
        } else {
            self.load(Source::of_text(&scene));
        }
    }

    /// Shows the stop of the tour, whose scene is there; `anew` if another one was there before.
    pub(super) fn arrive(&mut self, anew: bool) {
        let (Some(tour), Some(world)) =
            (&mut self.tour, self.cutting.whole.as_ref().or(self.world.as_ref()))
        else {
            return;
        };
        let stop = tour.stop();
        let Ok(wanted) = link::from_text(stop.state) else { return };
        let State { dark, panels, always, hover_turns, .. } = self.state;
        self.state = State { dark, panels, always, hover_turns, ..wanted };
        let usual = Chase::default();
        let (around, nearer) = stop.outside;
        // A small scene is looked at from aside already, all of it.
        let (around, nearer) = if world.is_large() { (around, nearer) } else { (0.0, 1.0) };
        let chase = Chase { yaw: usual.yaw + around, nearer: usual.nearer * nearer, ..usual };
        tour.phase = Phase::Fresh;
        let jumps = anew || self.calm || chase == self.chase;
        tour.flight = (!jumps).then_some(([self.chase, chase], 0.0));
        if jumps {
            self.chase = chase;
        }
        if self.state.camera.is_none() {
            self.stand();
        }
    }

    /// Goes on with the stop: flies, and does what is to be done once it is decided what is drawn.
    pub(super) fn follow_tour(&mut self, dt: f64) {
        let Some(tour) = &mut self.tour else { return };
        if let Some(([from, to], done)) = &mut tour.flight {
            *done = (*done + dt / FLIGHT).min(1.0);
            // Gently off, and gently in.
            let t = *done * *done * (3.0 - 2.0 * *done);
            self.chase = from.towards(to, t);
            if *done >= 1.0 {
                tour.flight = None;
            }
            self.ctx.request_repaint();
        }
        if tour.phase == Phase::Fresh && self.is_decided() {
            let Some(tour) = &mut self.tour else { return };
            tour.phase = Phase::Ready;
            (tour.stop().order)(self);
            self.ctx.request_repaint();
        }
    }

    /// Inspects the instance in sight that has the most triangles.
    pub(super) fn inspect_finest(&mut self) {
        let (Some(world), Some(decision)) = (&self.world, &self.decision) else { return };
        let scene = &world.model.scene;
        let kept = scene.slots().filter(|&slot| {
            decision.visible.reasons.get(slot as usize).is_some_and(Option::is_none)
        });
        if let Some(slot) = kept.max_by_key(|&slot| scene.mesh(slot).triangle_count()) {
            self.inspect_slot(slot);
        }
    }
}

impl Given {
    /// Whether it was right, and if not what is.
    #[must_use]
    pub fn in_words(&self, stop: &Stop) -> String {
        match stop.choices.get(self.right) {
            Some(right) if !self.is_right() => format!("Not quite. Right is: {right}."),
            _ => "Right.".to_owned(),
        }
    }
}
