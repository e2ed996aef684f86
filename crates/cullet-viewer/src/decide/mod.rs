//! Who decides what is drawn: the culler on the CPU, in a thread of its own natively. Drawing never waits
//! for it: it draws the last decision there is, and of requests that wait only the newest is answered.

mod pick;

pub use pick::{Hit, pick};

use std::sync::Arc;

use cullet::cull::occlusion::OcclusionBuffer;
use cullet::{Culler, View, ViewState, Visible};

use crate::task::clock;
use crate::world::World;

/// What is asked.
#[derive(Clone, Debug)]
pub struct Request {
    /// Of which scene.
    pub world: Arc<World>,
    /// The view that culls.
    pub view: View,
    /// With which settings.
    pub culler: Culler,
    /// Whether the occlusion buffer is wanted too: copying it takes a tenth of a millisecond or so.
    pub buffer: bool,
    /// Tells this request from others of the same asker.
    pub number: u64,
}

/// What was decided.
#[derive(Clone, Debug)]
pub struct Decision {
    /// What was asked.
    pub request: Request,
    /// What is left, with reasons and the funnel.
    pub visible: Visible,
    /// The slots of which something was drawn into the occlusion buffer, ascending; empty without that stage.
    pub occluders: Vec<u32>,
    /// The occlusion buffer, where it was wanted and made.
    pub buffer: Option<OcclusionBuffer>,
    /// How long it took.
    pub milliseconds: f32,
    /// Rises by one with each.
    pub number: u64,
}

/// Decides with what it remembers of the view.
#[derive(Debug, Default)]
struct Memory {
    state: ViewState,
    decided: u64,
    /// An earlier answer, whose memory the next one takes: that of a million things is some megabytes, which the
    /// system would hand out page by page.
    spare: Visible,
}

impl Memory {
    fn decide(&mut self, request: Request) -> Decision {
        let began = clock();
        let mut visible = std::mem::take(&mut self.spare);
        let Request { world, view, culler, buffer, .. } = &request;
        culler.cull_one(&world.model.scene, view, &mut self.state, &mut visible);
        self.decided += 1;
        let milliseconds = (clock() - began) as f32 * 1e-6;
        // A buffer of an earlier view stays in the memory when the stage is switched off.
        let made = culler.occlusion.is_some();
        let drawn = if made { self.state.occluders_drawn() } else { &[] };
        let mut occluders: Vec<u32> = drawn.iter().map(|d| d.0).collect();
        occluders.sort_unstable();
        occluders.dedup();
        let buffer = self.state.occlusion_buffer().filter(|_| made && *buffer).cloned();
        Decision { request, visible, occluders, buffer, milliseconds, number: self.decided }
    }
}

#[cfg(not(target_arch = "wasm32"))]
mod threaded {
    use std::sync::mpsc::{Receiver, Sender, channel};

    use cullet::Visible;

    use super::{Decision, Memory, Request};

    /// What the thread is sent.
    #[derive(Debug)]
    enum Message {
        Ask(Box<Request>),
        Spare(Box<Visible>),
    }

    /// Decides in a thread of its own, or, where there is none to be had, when asked.
    #[derive(Debug)]
    pub struct Decider {
        requests: Sender<Message>,
        decisions: Receiver<Decision>,
        /// Without a thread.
        inline: Option<(Memory, Option<Request>)>,
    }

    impl Decider {
        /// Begins; `wake` is called after each decision.
        pub fn new(wake: impl Fn() + Send + 'static) -> Self {
            let (requests, inbox) = channel::<Message>();
            let (outbox, decisions) = channel();
            let run = move || {
                let mut memory = Memory::default();
                while let Ok(first) = inbox.recv() {
                    // Of requests that wait, the newest.
                    let mut wanted = None;
                    for message in std::iter::once(first).chain(inbox.try_iter()) {
                        match message {
                            Message::Ask(request) => wanted = Some(*request),
                            Message::Spare(visible) => memory.spare = *visible,
                        }
                    }
                    let Some(request) = wanted else { continue };
                    if outbox.send(memory.decide(request)).is_err() {
                        return;
                    }
                    wake();
                }
            };
            let thread = std::thread::Builder::new().name("cullet decider".to_owned()).spawn(run);
            let inline = thread.is_err().then(Default::default);
            Self { requests, decisions, inline }
        }

        /// Asks; an older request that still waits is forgotten.
        pub fn ask(&mut self, request: Request) {
            if let Some((_, waiting)) = &mut self.inline {
                *waiting = Some(request);
            } else if let Err(lost) = self.requests.send(Message::Ask(Box::new(request))) {
                // The thread is gone: from now on without.
                let waiting = match lost.0 {
                    Message::Ask(request) => Some(*request),
                    Message::Spare(_) => None,
                };
                self.inline = Some((Memory::default(), waiting));
            }
        }

        /// Gives back an answer that is needed no more: the next one takes its memory.
        pub fn give_back(&mut self, visible: Visible) {
            match &mut self.inline {
                Some((memory, _)) => memory.spare = visible,
                None => {
                    // Without the thread it is simply freed.
                    let _ = self.requests.send(Message::Spare(Box::new(visible)));
                }
            }
        }

        /// The newest decision since the last call.
        pub fn latest(&mut self) -> Option<Decision> {
            if let Some((memory, waiting)) = &mut self.inline {
                return waiting.take().map(|request| memory.decide(request));
            }
            self.decisions.try_iter().last()
        }
    }
}

#[cfg(target_arch = "wasm32")]
mod inline {
    use cullet::Visible;

    use super::{Decision, Memory, Request};

    /// Decides when asked: a page has no threads.
    #[derive(Debug)]
    pub struct Decider {
        memory: Memory,
        waiting: Option<Request>,
    }

    impl Decider {
        /// Begins; `wake` is not needed.
        pub fn new(_wake: impl Fn() + Send + 'static) -> Self {
            Self { memory: Memory::default(), waiting: None }
        }

        /// Asks; an older request that still waits is forgotten.
        pub fn ask(&mut self, request: Request) {
            self.waiting = Some(request);
        }

        /// Gives back an answer that is needed no more: the next one takes its memory.
        pub fn give_back(&mut self, visible: Visible) {
            self.memory.spare = visible;
        }

        /// The newest decision since the last call.
        pub fn latest(&mut self) -> Option<Decision> {
            self.waiting.take().map(|request| self.memory.decide(request))
        }
    }
}

#[cfg(target_arch = "wasm32")]
pub use inline::Decider;
#[cfg(not(target_arch = "wasm32"))]
pub use threaded::Decider;
