//! Recordings: what a frame drew into an occlusion buffer, the boxes that it tested, and the
//! results, to be played again.
//!
//! A wrong answer seen once is a file that fails for ever after: the idea of the frame recorder in
//! Intel's Masked Occlusion Culling. Nothing here reads or writes files; a recording is bytes.

use std::collections::HashMap;

use cullet::bounds::Aabb;
use cullet::cull::occlusion::{OcclusionBuffer, OcclusionError, Shape, Visibility};
use cullet::{Simd, Transform, View};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use thiserror::Error;

const MAGIC: [u8; 8] = *b"CULLOCC3";
/// Most pixels of a buffer in a recording: a file of a few bytes must not take a gibibyte.
const MOST_PIXELS: u64 = 1 << 24;

/// Why bytes are no recording, or one cannot be played.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// It begins otherwise.
    #[error("not a recording: it does not begin with CULLOCC3; cullet verify --record makes one")]
    Magic,
    /// It ends too early, or a number in it cannot be.
    #[error(
        "{what} {number} at byte {at} of {length} is cut off or damaged ({why}); record it again with \
         cullet verify --record"
    )]
    Damaged {
        /// Kind of the item that was being read.
        what: &'static str,
        /// Number of the damaged item.
        number: u32,
        /// Where it begins.
        at: usize,
        /// How many bytes there are in all.
        length: usize,
        /// The defect.
        why: String,
    },
    /// Bytes after the end.
    #[error("{0} bytes after the last call")]
    Trailing(usize),
    /// A shape that the recording does not have.
    #[error("call {call}: shape {shape}, but there are {count}")]
    Shape {
        /// Number of the call.
        call: u32,
        /// Number of the shape.
        shape: u32,
        /// How many there are.
        count: usize,
    },
    /// A buffer that is not made.
    #[error("call {call}: {error}")]
    Buffer {
        /// Number of the call.
        call: u32,
        /// Why.
        error: OcclusionError,
    },
    /// More pixels than a recording may have.
    #[error("call {call}: a buffer of {0}x{1} pixels; recordings have at most {MOST_PIXELS}", size[0], size[1])]
    Pixels {
        /// Number of the call.
        call: u32,
        /// Columns and rows.
        size: [u32; 2],
    },
    /// Something is drawn or tested before there is a view.
    #[error("call {0} comes before the first view")]
    NoView(u32),
}

/// One call, in the order of time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
enum Call {
    Begin { view: Box<View>, origin: [f64; 3], size: [u32; 2] },
    Draw { shape: u32, transform: Transform },
    Test { bounds: Aabb, visibility: Visibility },
}

/// Calls of one buffer, over any number of frames.
///
/// Shapes are kept once, however often they are drawn. Cost: the bytes of what is drawn, and about
/// 60 a call.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    shapes: Vec<Shape>,
    /// Shapes as bytes, to find equal ones.
    known: HashMap<Vec<u8>, u32>,
    calls: Vec<Call>,
}

/// A result that is another when a recording is played.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Number of the call, from 0.
    pub call: u32,
    /// The box that was tested.
    pub bounds: Aabb,
    /// The result then.
    pub was: Visibility,
    /// The result now.
    pub is: Visibility,
}

/// Results of playing a recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Differences {
    /// Views begun.
    pub views: u64,
    /// Occluders drawn.
    pub drawn: u64,
    /// Boxes tested.
    pub tested: u64,
    /// Differences among the [hidden](Visibility::Hidden) shapes.
    pub hidden: u64,
    /// The tests whose results are others than they were, in order.
    pub changed: Vec<Difference>,
}

impl Recording {
    /// How many calls there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.calls.len()
    }

    /// Whether nothing was called.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.calls.is_empty()
    }

    /// Notes [`OcclusionBuffer::begin`] on a buffer of `size`.
    pub fn begin(&mut self, view: &View, origin: [f64; 3], size: [u32; 2]) {
        self.calls.push(Call::Begin { view: Box::new(view.clone()), origin, size });
    }

    /// Notes that a shape was drawn.
    pub fn draw(&mut self, shape: &Shape, transform: &Transform) {
        let next = self.shapes.len() as u32;
        let number = *self.known.entry(encoded(shape)).or_insert(next);
        if number == next {
            self.shapes.push(shape.clone());
        }
        self.calls.push(Call::Draw { shape: number, transform: *transform });
    }

    /// Notes the result of [`OcclusionBuffer::test_box`].
    pub fn test(&mut self, bounds: &Aabb, visibility: Visibility) {
        self.calls.push(Call::Test { bounds: *bounds, visibility });
    }

    /// Plays every call on a new buffer and compares the results.
    ///
    /// # Errors
    /// Where a buffer cannot be made, or the first call is no view.
    pub fn replay(&self, simd: Simd) -> Result<Differences, RecordingError> {
        let mut found = Differences::default();
        let mut buffer: Option<OcclusionBuffer> = None;
        for (call, what) in (0..).zip(&self.calls) {
            if let Call::Begin { size, .. } = what
                && buffer.as_ref().is_none_or(|b| b.size() != *size)
            {
                let new = OcclusionBuffer::new(*size);
                buffer = Some(new.map_err(|error| RecordingError::Buffer { call, error })?);
            }
            let buffer = buffer.as_mut().ok_or(RecordingError::NoView(call))?;
            match what {
                Call::Begin { view, origin, .. } => {
                    buffer.begin(view, *origin);
                    found.views += 1;
                }
                Call::Draw { shape, transform } => {
                    self.shapes[*shape as usize].draw(simd, buffer, transform);
                    found.drawn += 1;
                }
                Call::Test { bounds, visibility } => {
                    let is = buffer.test_box(bounds);
                    found.tested += 1;
                    found.hidden += u64::from(is == Visibility::Hidden);
                    if is != *visibility {
                        let was = *visibility;
                        found.changed.push(Difference { call, bounds: *bounds, was, is });
                    }
                }
            }
        }
        Ok(found)
    }

    /// The recording as bytes: `CULLOCC3`, how many shapes there are, the shapes, how many calls,
    /// the calls; in the encoding of `postcard`.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let mut out = MAGIC.to_vec();
        out.extend(encoded(&(self.shapes.len() as u32)));
        self.shapes.iter().for_each(|shape| out.extend(encoded(shape)));
        out.extend(encoded(&(self.calls.len() as u32)));
        self.calls.iter().for_each(|call| out.extend(encoded(call)));
        out
    }

    /// Reads what [`encode`](Self::encode) wrote. Any bytes give an error or a recording that can
    /// be played; no count is trusted beyond the bytes that there are.
    ///
    /// # Errors
    /// Names what is wrong, where, and the limit.
    pub fn decode(bytes: &[u8]) -> Result<Self, RecordingError> {
        let left = bytes.strip_prefix(&MAGIC).ok_or(RecordingError::Magic)?;
        let mut reader = Reader { length: bytes.len(), left };
        let mut recording = Self::default();
        for number in 0..reader.next("the number of shapes", 0)? {
            let shape: Shape = reader.next("shape", number)?;
            recording.known.entry(encoded(&shape)).or_insert(number);
            recording.shapes.push(shape);
        }
        let count = recording.shapes.len();
        for call in 0..reader.next("the number of calls", 0)? {
            let next: Call = reader.next("call", call)?;
            match next {
                Call::Draw { shape, .. } if shape as usize >= count => {
                    return Err(RecordingError::Shape { call, shape, count });
                }
                Call::Begin { size: size @ [width, height], .. }
                    if u64::from(width) * u64::from(height) > MOST_PIXELS =>
                {
                    return Err(RecordingError::Pixels { call, size });
                }
                next => recording.calls.push(next),
            }
        }
        match reader.left.len() {
            0 => Ok(recording),
            more => Err(RecordingError::Trailing(more)),
        }
    }
}

/// A value as bytes.
fn encoded<T: Serialize>(value: &T) -> Vec<u8> {
    // Only a value of unknown length is refused, or a writer that is full: there are neither here.
    postcard::to_allocvec(value).unwrap_or_default()
}

/// Bytes that are left.
struct Reader<'a> {
    length: usize,
    left: &'a [u8],
}

impl Reader<'_> {
    fn next<T: DeserializeOwned>(
        &mut self,
        what: &'static str,
        number: u32,
    ) -> Result<T, RecordingError> {
        let Self { length, left } = *self;
        let (value, after) = postcard::take_from_bytes(left).map_err(|e| {
            let at = length - left.len();
            RecordingError::Damaged { what, number, at, length, why: e.to_string() }
        })?;
        self.left = after;
        Ok(value)
    }
}
