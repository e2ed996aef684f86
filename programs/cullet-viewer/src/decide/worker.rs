//! Deciding on a page, which has one thread, and that draws: the worker that made a scene keeps it,
//! and answers requests.
//!
//! The page decides for itself, when it looks for the answer, where the worker cannot: for a scene
//! that the page made, as a cut one is; where the occlusion buffer is wanted, which is not packed
//! since only its study needs it; and for everything once a worker broke off.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;
use std::sync::{Arc, Weak};

use cullet::Visible;
use js_sys::{Array, Object, Reflect, Uint8Array};
use wasm_bindgen::prelude::*;
use web_sys::{Event, MessageEvent, Worker};

use super::{Decision, Memory, Request};
use crate::web::thrown;
use crate::world::World;

/// Decides in the scene's worker, or by itself.
pub struct Decider {
    /// For what it decides itself.
    memory: Memory,
    /// The newest request, while it waits.
    waiting: Option<Request>,
    line: Option<WorkerLine>,
    /// The number of the newest request that is answered.
    answered: u64,
    decided: u64,
    spare: Visible,
    wake: Rc<dyn Fn()>,
}

impl std::fmt::Debug for Decider {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Decider").field("decided", &self.decided).finish_non_exhaustive()
    }
}

impl Decider {
    /// Begins; `wake` is called when a worker answered.
    pub fn new(wake: impl Fn() + Send + 'static) -> Self {
        Self {
            memory: Memory::default(),
            waiting: None,
            line: None,
            answered: 0,
            decided: 0,
            spare: Visible::default(),
            wake: Rc::new(wake),
        }
    }

    /// Asks; an older request that still waits is forgotten, and so is one about another scene.
    pub fn request(&mut self, request: Request) {
        self.waiting = Some(request);
        self.send();
    }

    /// Gives back an answer that is needed no more: the next one takes its memory.
    pub fn give_back(&mut self, visible: Visible) {
        self.spare = visible;
    }

    /// The newest decision since the last call. A request that no worker can answer is decided now.
    pub fn latest(&mut self) -> Option<Decision> {
        let mut newest = self.receive();
        self.send();
        let line = self.line.as_ref();
        if let Some(request) = self.waiting.take_if(|r| !line.is_some_and(|line| line.can(r))) {
            self.memory.spare = std::mem::take(&mut self.spare);
            newest = Some(self.memory.decide(request));
        }
        // The worker may still have been at one that the page has overtaken since.
        let mut decision = newest.filter(|d| d.request.number > self.answered)?;
        self.answered = decision.request.number;
        self.decided += 1;
        decision.number = self.decided;
        Some(decision)
    }

    /// Sends what waits to the worker of its scene, if that is not at another request.
    fn send(&mut self) {
        let Some(request) = &self.waiting else { return };
        if self.line.as_ref().is_none_or(|line| !line.leads_to(&request.world)) {
            // First: one that ends stops listening to its worker, which may be the same.
            self.line = None;
            self.line = WorkerLine::to(&request.world, &self.wake);
        }
        if let Some(line) = self.line.as_mut().filter(|l| l.asked.is_none() && l.can(request)) {
            match line.post(request) {
                Ok(()) => line.asked = self.waiting.take(),
                Err(why) => line.break_off(&thrown(why)),
            }
        }
    }

    /// The worker's answer, if it came. Of a worker that broke off the request waits again, unless
    /// a newer one does.
    fn receive(&mut self) -> Option<Decision> {
        let line = self.line.as_mut()?;
        loop {
            let said = line.inbox.borrow_mut().pop_front()?;
            let decision = said.and_then(|bytes| {
                let bytes = bytes.to_vec();
                match &line.asked {
                    Some(asked) if Decision::answers(&bytes) == Some(asked.number) => {
                        let spare = std::mem::take(&mut self.spare);
                        let unpacked = Decision::unpack(&bytes, asked.clone(), spare);
                        unpacked.map(Some).map_err(|e| e.to_string())
                    }
                    // It was requested of this scene before another one was shown for a while.
                    _ => Ok(None),
                }
            });
            match decision {
                Ok(None) => {}
                Ok(decision) => {
                    line.asked = None;
                    return decision;
                }
                Err(why) => {
                    line.break_off(&why);
                    let request = line.asked.take();
                    self.waiting = self.waiting.take().or(request);
                }
            }
        }
    }
}

type Reply = Result<Uint8Array, String>;

/// The way to the worker of a scene and back. It is at one request at a time, so that the newest
/// never waits for more than the one before.
struct WorkerLine {
    world: Weak<World>,
    worker: Worker,
    /// The request that it works on.
    asked: Option<Request>,
    /// Replies that are not read yet.
    inbox: Rc<RefCell<VecDeque<Reply>>>,
    /// The browser's callback; not to be dropped before the worker.
    _answered: Closure<dyn Fn(MessageEvent)>,
    _failed: Closure<dyn Fn(Event)>,
    is_broken: bool,
}

impl WorkerLine {
    /// To the scene's worker, if it has one.
    fn to(world: &Arc<World>, wake: &Rc<dyn Fn()>) -> Option<Self> {
        let worker = world.keeper.as_ref()?.worker().clone();
        let inbox = Rc::new(RefCell::new(VecDeque::new()));
        let put = {
            let (inbox, wake) = (Rc::clone(&inbox), Rc::clone(wake));
            Rc::new(move |said: Reply| {
                inbox.borrow_mut().push_back(said);
                wake();
            })
        };
        let answered = {
            let put = Rc::clone(&put);
            Closure::<dyn Fn(_)>::new(move |event: MessageEvent| {
                put(event.data().dyn_into::<Uint8Array>().map_err(thrown));
            })
        };
        let failed = Closure::<dyn Fn(_)>::new(move |event: Event| {
            // It is told, and no error of the page: that goes on without.
            event.prevent_default();
            put(Err(thrown(event.into())));
        });
        worker.set_onmessage(Some(answered.as_ref().unchecked_ref()));
        worker.set_onerror(Some(failed.as_ref().unchecked_ref()));
        Some(Self {
            world: Arc::downgrade(world),
            worker,
            asked: None,
            inbox,
            _answered: answered,
            _failed: failed,
            is_broken: false,
        })
    }

    fn leads_to(&self, world: &Arc<World>) -> bool {
        self.world.as_ptr() == Arc::as_ptr(world)
    }

    /// Whether the worker can answer this, now or after its present request.
    fn can(&self, request: &Request) -> bool {
        self.leads_to(&request.world) && !request.buffer && !self.is_broken
    }

    fn post(&self, request: &Request) -> Result<(), JsValue> {
        let bytes = Uint8Array::from(&request.pack()[..]);
        let message = Object::new();
        Reflect::set(&message, &"request".into(), &bytes)?;
        self.worker.post_message_with_transfer(&message, &Array::of1(&bytes.buffer()))
    }

    fn break_off(&mut self, why: &str) {
        if !std::mem::replace(&mut self.is_broken, true) {
            log::info!("the worker that decides broke off ({why}); the page decides by itself");
        }
    }
}

impl Drop for WorkerLine {
    fn drop(&mut self) {
        // It may still have something to say.
        self.worker.set_onmessage(None);
        self.worker.set_onerror(None);
    }
}

thread_local! {
    /// In the worker: the scene that it made, and what it remembers of the view.
    static KEPT: RefCell<Option<(Arc<World>, Memory)>> = const { RefCell::new(None) };
}

/// The worker's part: keeps a scene to decide about.
pub(crate) fn keep(world: World) {
    KEPT.set(Some((Arc::new(world), Memory::default())));
}

/// The worker's part: a packed request about the scene that it keeps to a packed answer.
///
/// # Errors
/// If it keeps none, or the bytes are no request; as text.
#[wasm_bindgen]
#[expect(unreachable_pub, reason = "the worker's script calls it")]
pub fn decide(request: &[u8]) -> Result<Vec<u8>, JsValue> {
    KEPT.with_borrow_mut(|kept| {
        let (world, memory) = kept.as_mut().ok_or("the worker keeps no scene")?;
        let sides = Request::sides(request).map_err(|e| e.to_string())?;
        let doors = Request::doors(request).map_err(|e| e.to_string())?;
        if world.sides != sides || world.doors != doors {
            // Between two requests it is held here alone.
            let own = Arc::get_mut(world).ok_or("the worker's scene is in use")?;
            own.set_sides(sides)?;
            own.set_doors(&doors);
        }
        let request = Request::unpack(request, Arc::clone(world)).map_err(|e| e.to_string())?;
        let decision = memory.decide(request);
        let packed = decision.pack();
        memory.spare = decision.visible;
        Ok(packed)
    })
}
