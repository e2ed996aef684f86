//! Deciding in a thread: natively.

use std::sync::mpsc::{Receiver, Sender, channel};

use cullet::Visible;

use super::{Decision, Memory, Request};

/// A message to the thread.
#[derive(Debug)]
enum Message {
    Request(Box<Request>),
    Spare(Box<Visible>),
}

/// Decides in a thread of its own, or, where none can be started, in [`Decider::latest`].
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
                        Message::Request(request) => wanted = Some(*request),
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
    pub fn request(&mut self, request: Request) {
        if let Some((_, waiting)) = &mut self.inline {
            *waiting = Some(request);
        } else if let Err(lost) = self.requests.send(Message::Request(Box::new(request))) {
            // The thread is gone: from now on without.
            let waiting = match lost.0 {
                Message::Request(request) => Some(*request),
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
