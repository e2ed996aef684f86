//! Recordings: what a frame drew, what it asked, and what it was told, to be played again.
//!
//! A wrong answer seen once is a file that fails for ever after: the idea of the frame recorder in Intel's Masked
//! Occlusion Culling. Nothing here reads or writes files; a recording is bytes.

use std::collections::HashMap;

use fearless_simd::Level;
use thiserror::Error;

use super::{Convex, OccluderError, OcclusionBuffer, OcclusionError, Patch, Shape, Verdict};
use crate::bounds::Aabb;
use crate::transform::Transform;
use crate::view::{Depth, View, ViewError};

const MAGIC: [u8; 8] = *b"CULLOCC1";
/// Pixels of a buffer that a recording may ask for: a file of a few bytes must not take a gibibyte.
const MOST_PIXELS: u64 = 1 << 24;
/// What the drawing of a patch is made for.
const MOST_OWN: u32 = 65_536;

/// Why bytes are no recording, or one cannot be played.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// It begins otherwise.
    #[error("not a recording: it does not begin with CULLOCC1; cullet verify --record makes one")]
    Magic,
    /// It ends too early.
    #[error(
        "it ends at byte {length}, but at byte {at} {needed} bytes of {what} are due; it was cut off"
    )]
    Short {
        /// What was being read.
        what: &'static str,
        /// Where it begins.
        at: usize,
        /// How many bytes it has.
        needed: u64,
        /// How many bytes there are in all.
        length: usize,
    },
    /// A byte that means nothing.
    #[error("{what} at byte {at} is {value}, at most {most}")]
    Value {
        /// What was being read.
        what: &'static str,
        /// Where.
        at: usize,
        /// What is there.
        value: u64,
        /// The limit.
        most: u64,
    },
    /// Bytes after the end.
    #[error("{0} bytes after the last call")]
    Trailing(usize),
    /// A shape that cannot be drawn.
    #[error("shape {shape}: {error}")]
    Shape {
        /// Which.
        shape: u32,
        /// Why.
        error: OccluderError,
    },
    /// Numbers that make no view.
    #[error("call {call}: {error}")]
    View {
        /// Which call.
        call: u32,
        /// Why.
        error: ViewError,
    },
    /// A buffer that is not made.
    #[error("call {call}: {error}")]
    Buffer {
        /// Which call.
        call: u32,
        /// Why.
        error: OcclusionError,
    },
    /// More pixels than a recording may have.
    #[error("call {call}: a buffer of {0}x{1} pixels; recordings have at most {MOST_PIXELS}", size[0], size[1])]
    Pixels {
        /// Which call.
        call: u32,
        /// Columns and rows.
        size: [u32; 2],
    },
    /// Something is drawn or asked before there is a view.
    #[error("call {0} comes before the first view")]
    NoView(u32),
}

/// One call, in the order of time.
#[derive(Clone, Debug, PartialEq)]
enum Call {
    Begin { view: View, origin: [f64; 3], size: [u32; 2] },
    Draw { shape: u32, transform: Transform },
    Ask { bounds: Aabb, verdict: Verdict },
}

/// The calls of one buffer, over any number of frames.
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

/// What is told otherwise when a recording is played.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Which call, from 0.
    pub call: u32,
    /// What was asked about.
    pub bounds: Aabb,
    /// What was told then.
    pub was: Verdict,
    /// What is told now.
    pub is: Verdict,
}

/// What playing a recording came to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Differences {
    /// Views begun.
    pub views: u64,
    /// Occluders drawn.
    pub drawn: u64,
    /// Questions asked.
    pub asked: u64,
    /// Of those answered with [`Verdict::Hidden`].
    pub hidden: u64,
    /// The questions that are answered otherwise than they were, in order.
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
        self.calls.push(Call::Begin { view: view.clone(), origin, size });
    }

    /// Notes that a shape was drawn.
    pub fn draw(&mut self, shape: &Shape, transform: &Transform) {
        let mut bytes = Vec::new();
        put_shape(&mut bytes, shape);
        let next = self.shapes.len() as u32;
        let number = *self.known.entry(bytes).or_insert(next);
        if number == next {
            self.shapes.push(shape.clone());
        }
        self.calls.push(Call::Draw { shape: number, transform: *transform });
    }

    /// Notes what [`OcclusionBuffer::ask_box`] said of a box.
    pub fn ask(&mut self, bounds: &Aabb, verdict: Verdict) {
        self.calls.push(Call::Ask { bounds: *bounds, verdict });
    }

    /// Plays every call on a new buffer and compares what it says.
    ///
    /// # Errors
    /// Where a buffer cannot be made, or the first call is no view.
    pub fn replay(&self, level: Level) -> Result<Differences, RecordingError> {
        let mut found = Differences::default();
        let mut buffer: Option<OcclusionBuffer> = None;
        for (call, what) in (0..).zip(&self.calls) {
            match what {
                Call::Begin { view, origin, size } => {
                    if buffer.as_ref().is_none_or(|b| b.size() != *size) {
                        let new = OcclusionBuffer::new(*size);
                        buffer = Some(new.map_err(|error| RecordingError::Buffer { call, error })?);
                    }
                    let buffer = buffer.as_mut().ok_or(RecordingError::NoView(call))?;
                    buffer.begin(view, *origin);
                    found.views += 1;
                }
                Call::Draw { shape, transform } => {
                    let buffer = buffer.as_mut().ok_or(RecordingError::NoView(call))?;
                    match &self.shapes[*shape as usize] {
                        Shape::Convex(convex) => buffer.draw_convex(level, convex, transform),
                        Shape::Patch(patch) => buffer.draw_patch(level, patch, transform),
                    }
                    found.drawn += 1;
                }
                Call::Ask { bounds, verdict } => {
                    let buffer = buffer.as_ref().ok_or(RecordingError::NoView(call))?;
                    let is = buffer.ask_box(bounds);
                    found.asked += 1;
                    found.hidden += u64::from(is == Verdict::Hidden);
                    if is != *verdict {
                        found.changed.push(Difference { call, bounds: *bounds, was: *verdict, is });
                    }
                }
            }
        }
        Ok(found)
    }

    /// The recording as bytes, little-endian: `CULLOCC1`, how many shapes and calls there are, the
    /// shapes, the calls.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let mut out = MAGIC.to_vec();
        put_counts(&mut out, [self.shapes.len(), self.calls.len()]);
        self.shapes.iter().for_each(|s| put_shape(&mut out, s));
        for call in &self.calls {
            match call {
                Call::Begin { view, origin, size } => {
                    out.push(0);
                    view.clip_from_world().iter().for_each(|v| out.extend(v.to_le_bytes()));
                    out.push(u8::from(view.depth() == Depth::Reversed));
                    view.viewport().iter().for_each(|v| out.extend(v.to_le_bytes()));
                    origin.iter().for_each(|v| out.extend(v.to_le_bytes()));
                    size.iter().for_each(|v| out.extend(v.to_le_bytes()));
                }
                Call::Draw { shape, transform } => {
                    out.push(1);
                    out.extend(shape.to_le_bytes());
                    transform.linear.iter().flatten().for_each(|v| out.extend(v.to_le_bytes()));
                    transform.translation.iter().for_each(|v| out.extend(v.to_le_bytes()));
                }
                Call::Ask { bounds, verdict } => {
                    out.push(2);
                    put_points(&mut out, [bounds.min, bounds.max].into_iter());
                    out.push(match verdict {
                        Verdict::Outside => 0,
                        Verdict::Visible => 1,
                        Verdict::Hidden => 2,
                    });
                }
            }
        }
        out
    }

    /// Reads what [`encode`](Self::encode) wrote. Any bytes give an error or a recording that can be played;
    /// nothing is allocated for a count that the bytes cannot hold.
    ///
    /// # Errors
    /// Names what is wrong, where, and the limit.
    pub fn decode(bytes: &[u8]) -> Result<Self, RecordingError> {
        let mut reader = Reader { bytes, at: 0 };
        if !bytes.starts_with(&MAGIC) {
            return Err(RecordingError::Magic);
        }
        reader.at = MAGIC.len();
        let shapes = reader.u32("the number of shapes")?;
        let calls = reader.u32("the number of calls")?;
        let mut recording = Self::default();
        reader.fits("shapes", u64::from(shapes) * 9 + u64::from(calls) * 26)?;
        for number in 0..shapes {
            let begin = reader.at;
            let shape = reader.shape(number)?;
            recording.known.entry(bytes[begin..reader.at].to_vec()).or_insert(number);
            recording.shapes.push(shape);
        }
        for call in 0..calls {
            recording.calls.push(reader.call(call, shapes)?);
        }
        match bytes.len() - reader.at {
            0 => Ok(recording),
            more => Err(RecordingError::Trailing(more)),
        }
    }
}

fn put_counts<const N: usize>(out: &mut Vec<u8>, counts: [usize; N]) {
    counts.iter().for_each(|&c| out.extend((c as u32).to_le_bytes()));
}

fn put_points(out: &mut Vec<u8>, points: impl Iterator<Item = [f32; 3]>) {
    points.flatten().for_each(|v| out.extend(v.to_le_bytes()));
}

fn put_shape(out: &mut Vec<u8>, shape: &Shape) {
    match shape {
        Shape::Convex(convex) => {
            out.push(0);
            put_counts(out, [convex.vertices().len(), convex.face_count()]);
            put_points(out, convex.vertices().iter().copied());
            for face in 0..convex.face_count() {
                put_counts(out, [convex.face(face).len()]);
                convex.face(face).iter().for_each(|v| out.extend(v.to_le_bytes()));
            }
        }
        Shape::Patch(patch) => {
            out.push(1 + u8::from(patch.two_sided));
            put_counts(
                out,
                [patch.vertices().len(), patch.triangles().count(), patch.triangle_count()],
            );
            put_points(out, patch.vertices());
            patch.triangles().flatten().for_each(|v| out.extend(v.to_le_bytes()));
        }
    }
}

/// Bytes, and how far they were read.
struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Reader<'_> {
    fn fits(&self, what: &'static str, needed: u64) -> Result<(), RecordingError> {
        let length = self.bytes.len();
        if needed > (length - self.at) as u64 {
            return Err(RecordingError::Short { what, at: self.at, needed, length });
        }
        Ok(())
    }

    fn take<const N: usize>(&mut self, what: &'static str) -> Result<[u8; N], RecordingError> {
        self.fits(what, N as u64)?;
        let part = std::array::from_fn(|i| self.bytes[self.at + i]);
        self.at += N;
        Ok(part)
    }

    fn u8(&mut self, what: &'static str, most: u8) -> Result<u8, RecordingError> {
        let [value] = self.take(what)?;
        self.at_most(what, 1, u64::from(value), u64::from(most))?;
        Ok(value)
    }

    fn u32(&mut self, what: &'static str) -> Result<u32, RecordingError> {
        self.take(what).map(u32::from_le_bytes)
    }

    fn at_most(
        &self,
        what: &'static str,
        size: usize,
        value: u64,
        most: u64,
    ) -> Result<(), RecordingError> {
        if value > most {
            return Err(RecordingError::Value { what, at: self.at - size, value, most });
        }
        Ok(())
    }

    fn f32s<const N: usize>(&mut self, what: &'static str) -> Result<[f32; N], RecordingError> {
        let mut values = [0.0; N];
        for v in &mut values {
            *v = f32::from_le_bytes(self.take(what)?);
        }
        Ok(values)
    }

    fn f64s<const N: usize>(&mut self, what: &'static str) -> Result<[f64; N], RecordingError> {
        let mut values = [0.0; N];
        for v in &mut values {
            *v = f64::from_le_bytes(self.take(what)?);
        }
        Ok(values)
    }

    fn u32s(&mut self, what: &'static str, count: u32) -> Result<Vec<u32>, RecordingError> {
        self.fits(what, u64::from(count) * 4)?;
        (0..count).map(|_| self.u32(what)).collect()
    }

    fn points(&mut self, count: u32) -> Result<Vec<[f32; 3]>, RecordingError> {
        self.fits("vertices", u64::from(count) * 12)?;
        (0..count).map(|_| self.f32s("a vertex")).collect()
    }

    fn shape(&mut self, shape: u32) -> Result<Shape, RecordingError> {
        let refused = |error| RecordingError::Shape { shape, error };
        let kind = self.u8("the kind of a shape", 2)?;
        let vertices = self.u32("the number of vertices")?;
        let count = self.u32("the number of faces")?;
        if kind == 0 {
            // What can close over so few vertices.
            let most = Convex::MAX_VERTICES as u64;
            self.at_most("a number of vertices", 8, u64::from(vertices), most)?;
            self.at_most("a number of faces", 4, u64::from(count), most * 2)?;
            let positions = self.points(vertices)?;
            let mut loops = Vec::new();
            for _ in 0..count {
                let corners = self.u32("the number of corners")?;
                if corners < 3 {
                    return Err(refused(OccluderError::Empty));
                }
                self.at_most("a number of corners", 4, u64::from(corners), most)?;
                let corners = self.u32s("corners", corners)?;
                if let Some(&v) = corners.iter().find(|&&v| v >= vertices) {
                    return Err(refused(OccluderError::Index(v, vertices as usize)));
                }
                loops.push(corners);
            }
            return Convex::from_loops(positions, &loops).map(Shape::Convex).map_err(refused);
        }
        let own = self.u32("the number of own triangles")?;
        self.at_most(
            "a number of own triangles",
            4,
            u64::from(own),
            u64::from(MOST_OWN.min(count)),
        )?;
        let positions = self.points(vertices)?;
        self.fits("triangles", u64::from(count) * 12)?;
        let indices = self.u32s("corners", count * 3)?;
        let patches = Patch::cut(&positions, &indices, std::slice::from_ref(&(0..own)), kind == 2);
        let patch = patches.map_err(refused)?.pop().ok_or_else(|| refused(OccluderError::Empty))?;
        Ok(Shape::Patch(patch))
    }

    fn call(&mut self, call: u32, shapes: u32) -> Result<Call, RecordingError> {
        match self.u8("the kind of a call", 2)? {
            0 => {
                let matrix = self.f64s("a matrix")?;
                let depth = match self.u8("a depth", 1)? {
                    0 => Depth::Standard,
                    _ => Depth::Reversed,
                };
                let viewport = [self.u32("a viewport")?, self.u32("a viewport")?];
                let origin = self.f64s("an origin")?;
                let size = [self.u32("a size")?, self.u32("a size")?];
                if u64::from(size[0]) * u64::from(size[1]) > MOST_PIXELS {
                    return Err(RecordingError::Pixels { call, size });
                }
                let view = View::from_matrix(&matrix, depth, viewport);
                let view = view.map_err(|error| RecordingError::View { call, error })?;
                Ok(Call::Begin { view, origin, size })
            }
            1 => {
                let shape = self.u32("a shape")?;
                let known = u64::from(shapes).saturating_sub(1);
                self.at_most("a shape", 4, u64::from(shape), known)?;
                if shapes == 0 {
                    let at = self.at - 4;
                    return Err(RecordingError::Value {
                        what: "a shape of none",
                        at,
                        value: 0,
                        most: 0,
                    });
                }
                let [a, b, c] = [
                    self.f32s("a transform")?,
                    self.f32s("a transform")?,
                    self.f32s("a transform")?,
                ];
                let translation = self.f64s("a transform")?;
                Ok(Call::Draw { shape, transform: Transform { linear: [a, b, c], translation } })
            }
            _ => {
                let (min, max) = (self.f32s("a box")?, self.f32s("a box")?);
                let verdict = match self.u8("an answer", 2)? {
                    0 => Verdict::Outside,
                    1 => Verdict::Visible,
                    _ => Verdict::Hidden,
                };
                Ok(Call::Ask { bounds: Aabb { min, max }, verdict })
            }
        }
    }
}
