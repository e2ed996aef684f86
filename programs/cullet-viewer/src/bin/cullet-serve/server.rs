//! Listening, the limits of a connection, and stopping.

use std::convert::Infallible;
use std::io;
use std::net::SocketAddr;
use std::pin::pin;
use std::rc::Rc;
use std::task::Poll;
use std::time::Duration;

use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::TokioIo;
use hyper_util::server::graceful::GracefulShutdown;
use tokio::net::TcpListener;
use tokio::task::LocalSet;

use crate::answer::Answers;
use crate::places::{Places, Progress, Watched};
use crate::site::Site;

/// Threads that read scenes, and compress them. Each works on one block at a time, whoever's it is,
/// so that no client holds one.
const READERS: usize = 4;

/// Limits on clients. The defaults suit browsers, which send headers of one or two kilobytes.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub(crate) struct Limits {
    /// Bytes of a request's head, at least 8192 (hyper's own least); more is answered with 431.
    pub head_bytes: usize,
    /// Headers of a request; more is answered with 431.
    pub headers: usize,
    /// Bytes of an address with its query; more is answered with 414.
    pub target_bytes: usize,
    /// How long a request's head may take to arrive whole, from the moment the connection is
    /// accepted; cut off after.
    pub head_time: Duration,
    /// How long a client may take nothing of its answer; cut off after.
    pub stall_time: Duration,
    /// Connections at a time. One more takes the place of the one that has waited longest for its
    /// request's head, else of one that has taken nothing of its answer for a while; while all take
    /// their answers it waits. An answer holds at most 128 KiB of a scene, beside what the system
    /// keeps for the connection, and two file handles.
    pub connections: usize,
    /// How long answers may go on once the server was told to stop.
    pub stop_time: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            head_bytes: 16 << 10,
            headers: 64,
            target_bytes: 2 << 10,
            head_time: Duration::from_secs(5),
            stall_time: Duration::from_secs(30),
            connections: 128,
            stop_time: Duration::from_secs(2),
        }
    }
}

/// A server that listens and has yet to be run.
#[derive(Debug)]
pub(crate) struct Server {
    runtime: tokio::runtime::Runtime,
    listener: TcpListener,
    address: SocketAddr,
    site: Site,
    limits: Limits,
}

impl Server {
    /// Listens on `address`; port 0 takes a free one, which [`address`](Self::address) tells.
    ///
    /// # Errors
    /// If the address cannot be listened on.
    pub(crate) fn bind(address: SocketAddr, site: Site, limits: Limits) -> io::Result<Self> {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .max_blocking_threads(READERS)
            .build()?;
        let listener = runtime.block_on(TcpListener::bind(address))?;
        let address = listener.local_addr()?;
        Ok(Self { runtime, listener, address, site, limits })
    }

    /// The address listened on.
    #[cfg(test)]
    pub(crate) fn address(&self) -> SocketAddr {
        self.address
    }

    /// The page's address, with the scene.
    #[must_use]
    pub(crate) fn url(&self) -> String {
        // An address that stands for all of a machine's is none to go to.
        let mut shown = self.address;
        if shown.ip().is_unspecified() {
            let here: std::net::IpAddr = match shown {
                SocketAddr::V4(_) => std::net::Ipv4Addr::LOCALHOST.into(),
                SocketAddr::V6(_) => std::net::Ipv6Addr::LOCALHOST.into(),
            };
            shown.set_ip(here);
        }
        format!("http://{shown}/{}", self.site.fragment())
    }

    /// Serves until Ctrl-C, or a request to terminate, then lets answers that are under way end for
    /// a short while.
    pub(crate) fn run(self) {
        self.run_until(asked_to_stop());
    }

    /// Serves until `stop` is done. A body of a request is never read; see [`Limits`] for the rest.
    pub(crate) fn run_until(self, stop: impl Future<Output = ()>) {
        let Self { runtime, listener, address, site, limits } = self;
        let answers = Answers { site, ip: address.ip(), max_target: limits.target_bytes };
        LocalSet::new().block_on(&runtime, serve(listener, answers, limits, stop));
        // Threads that read for a client who went away end by themselves.
        runtime.shutdown_timeout(limits.stop_time);
    }
}

async fn serve(
    listener: TcpListener,
    answers: Answers,
    limits: Limits,
    stop: impl Future<Output = ()>,
) {
    let graceful = GracefulShutdown::new();
    let places = Rc::new(Places::default());
    let answers = Rc::new(answers);
    let mut http = http1::Builder::new();
    // One request a connection: none is kept idle, and each is either waited for or answered. A
    // page is a handful of files, and a new connection costs nothing beside any of them.
    http.keep_alive(false).max_headers(limits.headers).max_buf_size(limits.head_bytes.max(8192));
    let accept = async {
        loop {
            let stream = match listener.accept().await {
                Ok((stream, _)) => stream,
                // A client that is gone again.
                Err(e) if e.kind() == io::ErrorKind::ConnectionAborted => continue,
                Err(_) => {
                    // Out of file handles, most likely: fewer connections help, and it does not end
                    // the server.
                    places.cut_one();
                    tokio::time::sleep(Duration::from_millis(50)).await;
                    continue;
                }
            };
            places.room(limits.connections).await;
            let progress = Rc::new(Progress::new());
            let service = {
                let (answers, progress) = (Rc::clone(&answers), Rc::clone(&progress));
                service_fn(move |request| {
                    progress.answered();
                    let answer = answers.to(&request);
                    async move { Ok::<_, Infallible>(answer) }
                })
            };
            let stream = Watched { stream, progress: Rc::clone(&progress) };
            let connection = http.serve_connection(TokioIo::new(stream), service);
            let connection = in_time(graceful.watch(connection), Rc::clone(&progress), limits);
            places.take(progress, connection);
            // Whoever sent its request with its connection is heard before the next is accepted.
            tokio::task::yield_now().await;
        }
    };
    first_of(stop, accept).await;
    let _ = tokio::time::timeout(limits.stop_time, graceful.shutdown()).await;
}

/// Serves a connection to its end, or until its client is too slow. A broken connection or a bad
/// request is no error of the server.
async fn in_time(connection: impl Future, progress: Rc<Progress>, limits: Limits) {
    let mut connection = pin!(connection);
    loop {
        let deadline = progress.deadline(limits.head_time, limits.stall_time);
        let ended = tokio::time::timeout_at(deadline, connection.as_mut()).await;
        // The deadline moves when the client gets further.
        if ended.is_ok() || progress.deadline(limits.head_time, limits.stall_time) <= deadline {
            return;
        }
    }
}

/// Waits for either of two, and drops the other.
async fn first_of(a: impl Future<Output = ()>, b: impl Future<Output = ()>) {
    let (mut a, mut b) = (pin!(a), pin!(b));
    std::future::poll_fn(|context| {
        let done = a.as_mut().poll(context).is_ready() || b.as_mut().poll(context).is_ready();
        if done { Poll::Ready(()) } else { Poll::Pending }
    })
    .await;
}

#[cfg(unix)]
async fn asked_to_stop() {
    use tokio::signal::unix::{SignalKind, signal};
    let (Ok(mut interrupt), Ok(mut terminate)) =
        (signal(SignalKind::interrupt()), signal(SignalKind::terminate()))
    else {
        // Where no handler can be set, a signal ends the program as it would have without one.
        return std::future::pending().await;
    };
    let one = async {
        interrupt.recv().await;
    };
    let other = async {
        terminate.recv().await;
    };
    first_of(one, other).await;
}

#[cfg(not(unix))]
async fn asked_to_stop() {
    if tokio::signal::ctrl_c().await.is_err() {
        std::future::pending::<()>().await;
    }
}
