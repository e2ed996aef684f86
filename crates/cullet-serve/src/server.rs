//! Listening, the limits of a connection, and stopping.

use std::convert::Infallible;
use std::io;
use std::net::SocketAddr;
use std::pin::pin;
use std::sync::Arc;
use std::task::Poll;
use std::time::Duration;

use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::GracefulShutdown;
use tokio::net::TcpListener;
use tokio::sync::Semaphore;

use crate::Site;
use crate::answer::Answers;

/// What a client may ask for. The defaults suit browsers, which send headers of one or two kilobytes.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Limits {
    /// Bytes of a request's head, at least 8192 (hyper's own least); more is answered with 431.
    pub head_bytes: usize,
    /// Headers of a request; more is answered with 431.
    pub headers: usize,
    /// Bytes of an address with its query; more is answered with 414.
    pub target_bytes: usize,
    /// How long a request's head may take to arrive, and an idle connection to ask again.
    pub head_time: Duration,
    /// Connections at a time; more wait.
    pub connections: usize,
    /// How long answers may go on once the server was asked to stop.
    pub stop_time: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            head_bytes: 16 << 10,
            headers: 64,
            target_bytes: 2 << 10,
            head_time: Duration::from_secs(30),
            connections: 64,
            stop_time: Duration::from_secs(2),
        }
    }
}

/// A server that listens and has yet to be run.
#[derive(Debug)]
pub struct Server {
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
    pub fn bind(address: SocketAddr, site: Site, limits: Limits) -> io::Result<Self> {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let listener = runtime.block_on(TcpListener::bind(address))?;
        let address = listener.local_addr()?;
        Ok(Self { runtime, listener, address, site, limits })
    }

    /// The address listened on.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// The page's address, with the scene.
    #[must_use]
    pub fn url(&self) -> String {
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

    /// Serves until Ctrl-C, or a request to terminate, then lets answers that are under way end for a short
    /// while.
    pub fn run(self) {
        self.run_until(asked_to_stop());
    }

    /// Serves until `stop` is done. A body of a request is never read; see [`Limits`] for the rest.
    pub fn run_until(self, stop: impl Future<Output = ()>) {
        let Self { runtime, listener, address, site, limits } = self;
        let answers = Arc::new(Answers { site, ip: address.ip(), max_target: limits.target_bytes });
        runtime.block_on(serve(listener, answers, limits, stop));
        // Threads that read for a client who went away end by themselves.
        runtime.shutdown_timeout(limits.stop_time);
    }
}

async fn serve(
    listener: TcpListener,
    answers: Arc<Answers>,
    limits: Limits,
    stop: impl Future<Output = ()>,
) {
    let graceful = GracefulShutdown::new();
    let places = Arc::new(Semaphore::new(limits.connections));
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new())
        .header_read_timeout(limits.head_time)
        .max_headers(limits.headers)
        .max_buf_size(limits.head_bytes.max(8192));
    let accept = async {
        loop {
            // The semaphore is never closed, so this only waits.
            let Ok(place) = Arc::clone(&places).acquire_owned().await else { return };
            let stream = match listener.accept().await {
                Ok((stream, _)) => stream,
                Err(_) => {
                    // Out of file handles, or a client that is gone: neither ends the server.
                    tokio::time::sleep(Duration::from_millis(50)).await;
                    continue;
                }
            };
            let answers = Arc::clone(&answers);
            let service = service_fn(move |request| {
                let answer = answers.to(&request);
                async move { Ok::<_, Infallible>(answer) }
            });
            let connection = graceful.watch(http.serve_connection(TokioIo::new(stream), service));
            tokio::spawn(async move {
                // A client that breaks off, or asks wrongly, is its own affair.
                let _ = connection.await;
                drop(place);
            });
        }
    };
    first_of(stop, accept).await;
    let _ = tokio::time::timeout(limits.stop_time, graceful.shutdown()).await;
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
