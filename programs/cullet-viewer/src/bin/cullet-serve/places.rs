//! The places that connections take, and which of them makes room when all are taken.
//!
//! A connection carries one request. It first waits for the request's head; once that is whole it
//! is answered. Time alone never tells a good client from a bad one, so a connection is cut early
//! only where another wants its place: first whichever has waited longest for its head, then
//! whichever has longest taken nothing of its answer. One that takes what it is sent keeps its
//! place.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::io;
use std::pin::Pin;
use std::rc::Rc;
use std::task::{Context, Poll};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;
use tokio::sync::Notify;
use tokio::task::{AbortHandle, spawn_local};
use tokio::time::Instant;

/// How long a client must have taken nothing of its answer before another may have its place:
/// longer than the pauses of a network that works. Nobody is cut for such a pause while there are
/// places.
const BLOCKED: Duration = Duration::from_millis(100);

/// How far one connection has come.
#[derive(Debug)]
pub(crate) struct Progress {
    /// Whether its request's head is whole.
    answered: Cell<bool>,
    /// When it last got further: it was accepted, its head became whole, or it took bytes of its
    /// answer.
    moved: Cell<Instant>,
    /// Since when it has taken nothing though bytes are there for it.
    blocked: Cell<Option<Instant>>,
}

impl Progress {
    /// Starts the progress of a connection that was accepted just now.
    pub(crate) fn new() -> Self {
        let moved = Cell::new(Instant::now());
        Self { answered: Cell::new(false), moved, blocked: Cell::new(None) }
    }

    /// The request's head is whole.
    pub(crate) fn answered(&self) {
        self.answered.set(true);
        self.moved.set(Instant::now());
    }

    /// When the connection is to be cut if it gets no further.
    pub(crate) fn deadline(&self, head_time: Duration, stall_time: Duration) -> Instant {
        self.moved.get() + if self.answered.get() { stall_time } else { head_time }
    }

    fn took(&self, taken: &Poll<io::Result<usize>>) {
        match taken {
            Poll::Ready(Ok(1..)) => {
                // An answer that is sent before the head is whole refuses the request, and does not
                // extend the deadline.
                if self.answered.get() {
                    self.moved.set(Instant::now());
                }
                self.blocked.set(None);
            }
            Poll::Ready(_) => {}
            Poll::Pending if self.blocked.get().is_none() => self.blocked.set(Some(Instant::now())),
            Poll::Pending => {}
        }
    }
}

/// The connections that are open.
#[derive(Debug, Default)]
pub(crate) struct Places {
    /// In the order in which they came.
    open: RefCell<BTreeMap<u64, (Rc<Progress>, AbortHandle)>>,
    next: Cell<u64>,
    left: Notify,
}

impl Places {
    /// Serves `connection`, which gives its place back when it ends, however it does.
    pub(crate) fn take(
        self: &Rc<Self>,
        progress: Rc<Progress>,
        connection: impl Future<Output = ()> + 'static,
    ) {
        let number = self.next.replace(self.next.get() + 1);
        let place = Place { number, places: Rc::clone(self) };
        let task = spawn_local(async move {
            connection.await;
            drop(place);
        });
        // The task does not run before this one waits.
        self.open.borrow_mut().insert(number, (progress, task.abort_handle()));
    }

    /// Waits until fewer than `most` places are taken, cutting connections off where one may be
    /// cut.
    pub(crate) async fn room(&self, most: usize) {
        while self.open.borrow().len() >= most.max(1) {
            if !self.cut_one() {
                let _ = tokio::time::timeout(BLOCKED / 5, self.left.notified()).await;
            }
        }
    }

    /// Cuts the connection off that another may best replace; false if all take what they are sent.
    pub(crate) fn cut_one(&self) -> bool {
        let mut open = self.open.borrow_mut();
        let now = Instant::now();
        let oldest = open.iter().find(|(_, (p, _))| !p.answered.get()).map(|(n, _)| *n);
        let number = oldest.or_else(|| {
            let since = |p: &Progress| p.blocked.get().filter(|b| now - *b >= BLOCKED);
            let blocked = open.iter().filter_map(|(n, (p, _))| Some((since(p)?, *n)));
            blocked.min().map(|(_, n)| n)
        });
        let Some((_, task)) = number.and_then(|n| open.remove(&n)) else { return false };
        task.abort();
        true
    }
}

/// A place that is taken.
struct Place {
    number: u64,
    places: Rc<Places>,
}

impl Drop for Place {
    fn drop(&mut self) {
        self.places.open.borrow_mut().remove(&self.number);
        self.places.left.notify_one();
    }
}

/// A connection's stream, which tells how far the client comes.
#[derive(Debug)]
pub(crate) struct Watched {
    pub(crate) stream: TcpStream,
    pub(crate) progress: Rc<Progress>,
}

impl AsyncRead for Watched {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_read(context, buffer)
    }
}

impl AsyncWrite for Watched {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let taken = Pin::new(&mut self.stream).poll_write(context, bytes);
        self.progress.took(&taken);
        taken
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let taken = Pin::new(&mut self.stream).poll_write_vectored(context, bytes);
        self.progress.took(&taken);
        taken
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Connections that have come as far as told; which of them are cut, in order.
    async fn cut(connections: &[(bool, Option<u64>)]) -> Vec<usize> {
        let places = Rc::new(Places::default());
        let start = Instant::now();
        tokio::time::sleep(Duration::from_secs(10)).await;
        for &(answered, blocked) in connections {
            let progress = Progress::new();
            progress.answered.set(answered);
            progress.blocked.set(blocked.map(|ms| start + Duration::from_millis(ms)));
            places.take(Rc::new(progress), std::future::pending());
        }
        let open = || places.open.borrow().keys().copied().collect::<Vec<_>>();
        let mut order = Vec::new();
        loop {
            let before = open();
            if !places.cut_one() {
                return order;
            }
            let after = open();
            order.extend(before.into_iter().filter(|n| !after.contains(n)).map(|n| n as usize));
        }
    }

    /// Runs `test` with a clock that goes on at once where all wait.
    fn run(test: impl Future<Output = ()>) {
        let mut runtime = tokio::runtime::Builder::new_current_thread();
        let runtime = runtime.enable_time().start_paused(true).build().unwrap();
        tokio::task::LocalSet::new().block_on(&runtime, test);
    }

    #[test]
    fn heads_make_room_first_and_whoever_takes_its_answer_never() {
        run(async {
            let (head, moving) = ((false, None), (true, None));
            let blocked = |ms| (true, Some(ms));
            let all = [moving, blocked(500), head, blocked(100), blocked(9_950), head];
            assert_eq!(cut(&all).await, [2, 5, 3, 1], "heads by age, then the longest blocked");
            assert!(cut(&[moving, blocked(9_950)]).await.is_empty(), "a short pause costs nothing");
            assert!(cut(&[]).await.is_empty());
        });
    }

    #[test]
    fn places_come_back_when_connections_end_or_are_cut() {
        run(async {
            let places = Rc::new(Places::default());
            for _ in 0..3 {
                places.take(Rc::new(Progress::new()), async {});
            }
            assert_eq!(places.open.borrow().len(), 3);
            places.room(1).await;
            tokio::task::yield_now().await;
            assert!(places.open.borrow().is_empty());
            // All take their answers: the next waits until one ends.
            let progress = Progress::new();
            progress.answered();
            places.take(Rc::new(progress), tokio::time::sleep(Duration::from_secs(7)));
            let asked = Instant::now();
            places.room(1).await;
            assert_eq!(asked.elapsed().as_secs(), 7);
        });
    }
}
