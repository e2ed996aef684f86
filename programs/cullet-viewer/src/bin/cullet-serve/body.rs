//! The body of an answer: bytes in memory, or a file that is read as it is sent.

use std::fmt;
use std::io::{self, Read};
use std::pin::Pin;
use std::task::{Context, Poll, ready};

use bytes::Bytes;
use http_body::{Body, Frame, SizeHint};
use tokio::task::{JoinHandle, spawn_blocking};

/// Bytes read, and sent, at a time. An answer holds two blocks at most: one on its way, one read
/// ahead.
const BLOCK: usize = 64 << 10;

/// The source of an answer's bytes.
type Source = Box<dyn Read + Send>;

/// Body of an answer.
#[derive(Debug)]
pub(crate) enum Answer {
    /// All of it, or nothing any more.
    Whole(Option<Bytes>),
    /// Blocks that are read one by one; how many bytes are still to come, where it is known.
    Blocks(Blocks, Option<u64>),
}

impl Answer {
    /// Bytes in memory.
    pub(crate) fn whole(bytes: impl Into<Bytes>) -> Self {
        Self::Whole(Some(bytes.into()))
    }

    /// Reads `source` to its end, at the pace of the client. Nothing is read before the first block
    /// is wanted.
    pub(crate) fn reading(source: impl Read + Send + 'static, length: Option<u64>) -> Self {
        Self::Blocks(Blocks(Next::Source(Box::new(source))), length)
    }
}

/// A source read block by block in threads for blocking work. Each block is a task of its own, so
/// that a client who takes nothing holds two blocks and no thread.
pub(crate) struct Blocks(Next);

enum Next {
    /// To be read when wanted.
    Source(Source),
    /// Being read, or read.
    Block(JoinHandle<(Source, io::Result<Bytes>)>),
    /// At its end, or failed.
    End,
}

impl Next {
    fn begin(mut source: Source) -> Self {
        Self::Block(spawn_blocking(move || {
            let mut block = Vec::with_capacity(BLOCK);
            let read = source.by_ref().take(BLOCK as u64).read_to_end(&mut block);
            (source, read.map(|_| Bytes::from(block)))
        }))
    }
}

impl Blocks {
    fn poll(&mut self, context: &mut Context<'_>) -> Poll<Option<io::Result<Bytes>>> {
        loop {
            match &mut self.0 {
                Next::Source(_) => {
                    if let Next::Source(source) = std::mem::replace(&mut self.0, Next::End) {
                        self.0 = Next::begin(source);
                    }
                }
                Next::Block(task) => {
                    let read = ready!(Pin::new(task).poll(context));
                    self.0 = Next::End;
                    let (source, block) = match read {
                        Ok(read) => read,
                        Err(e) => return Poll::Ready(Some(Err(io::Error::other(e)))),
                    };
                    if block.as_ref().is_ok_and(Bytes::is_empty) {
                        return Poll::Ready(None);
                    }
                    if block.is_ok() {
                        self.0 = Next::begin(source);
                    }
                    return Poll::Ready(Some(block));
                }
                Next::End => return Poll::Ready(None),
            }
        }
    }
}

impl fmt::Debug for Blocks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Blocks").finish_non_exhaustive()
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
            Self::Blocks(blocks, left) => blocks.poll(context).map(|block| {
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
