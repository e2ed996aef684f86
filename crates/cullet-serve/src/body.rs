//! The body of an answer: bytes in memory, or a file that is read as it is sent.

use std::io::{self, Read};
use std::pin::Pin;
use std::task::{Context, Poll};

use bytes::Bytes;
use http_body::{Body, Frame, SizeHint};
use tokio::sync::mpsc::{self, Receiver};

/// Read, and sent, at a time.
const BLOCK: usize = 128 << 10;
/// Blocks read ahead of the client.
const AHEAD: usize = 4;

/// What an answer carries.
#[derive(Debug)]
pub(crate) enum Answer {
    /// All of it, or nothing any more.
    Whole(Option<Bytes>),
    /// Blocks from a thread that reads; how many bytes are still to come, where it is known.
    Blocks(Receiver<io::Result<Bytes>>, Option<u64>),
}

impl Answer {
    /// Bytes in memory.
    pub(crate) fn whole(bytes: impl Into<Bytes>) -> Self {
        Self::Whole(Some(bytes.into()))
    }

    /// Reads `source` to its end in a thread for blocking work; a client that goes away ends that.
    pub(crate) fn reading(mut source: impl Read + Send + 'static, length: Option<u64>) -> Self {
        let (send, receive) = mpsc::channel(AHEAD);
        tokio::task::spawn_blocking(move || {
            loop {
                let mut block = vec![0; BLOCK];
                let read = match source.read(&mut block) {
                    Ok(0) => return,
                    Ok(n) => {
                        block.truncate(n);
                        Ok(Bytes::from(block))
                    }
                    Err(e) if e.kind() == io::ErrorKind::Interrupted => continue,
                    Err(e) => Err(e),
                };
                let failed = read.is_err();
                if send.blocking_send(read).is_err() || failed {
                    return;
                }
            }
        });
        Self::Blocks(receive, length)
    }
}

impl Body for Answer {
    type Data = Bytes;
    type Error = io::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<io::Result<Frame<Bytes>>>> {
        match &mut *self {
            Self::Whole(bytes) => Poll::Ready(bytes.take().map(|b| Ok(Frame::data(b)))),
            Self::Blocks(receive, left) => receive.poll_recv(context).map(|block| {
                let block = block?;
                if let (Ok(block), Some(left)) = (&block, left) {
                    *left = left.saturating_sub(block.len() as u64);
                }
                Some(block.map(Frame::data))
            }),
        }
    }

    fn is_end_stream(&self) -> bool {
        matches!(self, Self::Whole(None) | Self::Blocks(_, Some(0)))
    }

    fn size_hint(&self) -> SizeHint {
        match self {
            Self::Whole(bytes) => {
                SizeHint::with_exact(bytes.as_ref().map_or(0, |b| b.len() as u64))
            }
            Self::Blocks(_, Some(left)) => SizeHint::with_exact(*left),
            Self::Blocks(_, None) => SizeHint::default(),
        }
    }
}
