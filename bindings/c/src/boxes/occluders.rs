//! Occluders of boxes: boxes, convex hulls and triangles of the caller's.

use std::fmt::Display;

use engine::bounds::Aabb;
use engine::cull::occlusion::{Convex, DynamicSurface, OcclusionBuffer};
use engine::{Simd, Transform as EngineTransform};

use super::{Boxes, SETS};
use crate::memory::{Layout, Plain, read, value, vertices};
use crate::occlusion::transform_of;
use crate::status::{Error, Result, Status, call};
use crate::transform::Transform;

/// Kinds of occluders.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub enum OccluderKind {
    /// Boxes, each within what is opaque: `positions` has a lowest and a highest corner for each,
    /// six floats.
    Boxes = 0,
    /// A closed convex body, of triangles wound counter-clockwise seen from outside: the quickest
    /// kind by far for what is convex. Up to 256 corners.
    Hull = 1,
    /// Triangles that hide from their fronts alone, which are counter-clockwise.
    Triangles = 2,
    /// Triangles that hide from both sides.
    TwoSidedTriangles = 3,
}

/// An occluder, in arrays of the caller's. Set it to zero before its fields.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Occluder {
    /// A `cullet_occluder_kind`.
    pub kind: u32,
    /// Bytes of an index: 4 or 2; 0 for 4.
    pub index_size: u32,
    /// Three floats a vertex, or six a box, each finite.
    pub positions: *const f32,
    /// Bytes from one vertex, or one box, to the next: a multiple of 4.
    pub stride: usize,
    /// How many vertices, or boxes.
    pub position_count: usize,
    /// Three a triangle, each below `position_count`: `uint32_t`, or `uint16_t` by `index_size`. Not
    /// read for boxes.
    pub indices: *const std::ffi::c_void,
    /// How many indices.
    pub index_count: usize,
    /// Where it stands; NULL for the identity. One that is not finite hides nothing.
    pub transform: *const Transform,
}

impl Plain for Occluder {}

/// All occluders of a set.
#[derive(Debug, Default)]
pub(super) struct Occluders {
    all: Vec<Placed>,
    scratch: Scratch,
    /// Complement of nearness, occluder and part, to draw near ones first.
    order: Vec<(u32, u32, u32)>,
}

/// Memory that reading occluders uses again.
#[derive(Debug, Default)]
struct Scratch {
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
}

#[derive(Debug)]
struct Placed {
    shape: Shape,
    transform: EngineTransform,
}

#[derive(Debug)]
enum Shape {
    Convex(Vec<Convex>),
    Surface(Box<DynamicSurface>, Aabb),
}

fn refused(at: usize, error: impl Display) -> Error {
    Error::value(format!("occluder {at}: {error}"))
}

impl Scratch {
    /// Reads positions and indices of occluder `at`.
    ///
    /// # Safety
    /// As the header asks of the caller.
    unsafe fn read(&mut self, at: usize, of: &Occluder) -> Result {
        let Occluder { stride, position_count, .. } = *of;
        if of.kind > 3 {
            let message = format!("kind is {}: it must be 0 to 3, a cullet_occluder_kind", of.kind);
            return Err(refused(at, message));
        }
        self.positions.clear();
        self.indices.clear();
        let is_boxes = of.kind == OccluderKind::Boxes as u32;
        let least = if is_boxes { 24 } else { 12 };
        if stride < least {
            let message = format!("stride is {stride}: it must be at least {least} bytes");
            return Err(refused(at, message));
        }
        let Some(last) = position_count.checked_sub(1) else {
            return Err(refused(at, "it has no positions"));
        };
        let last = u32::try_from(last)
            .map_err(|_| refused(at, format!("{position_count} positions: more than 2^32")))?;
        for part in 0..if is_boxes { 2 } else { 1 } {
            let layout = Layout { stride, second: 4, third: 8 };
            let positions = if part == 0 || of.positions.is_null() {
                of.positions
            } else {
                of.positions.wrapping_add(3)
            };
            let to = &mut self.positions;
            // SAFETY: the caller's promise; of a box there are six floats.
            unsafe {
                vertices(
                    format_args!("positions of occluder {at}"),
                    positions,
                    layout,
                    [0, last],
                    to,
                )
            }?;
        }
        let is_wrong = |p: &[f32; 3]| p.iter().any(|v| !v.is_finite());
        if let Some(number) = self.positions.iter().position(is_wrong) {
            let (item, p) = (if is_boxes { "box" } else { "vertex" }, self.positions[number]);
            let message = format!("{item} {} is not finite: {p:?}", number % position_count);
            return Err(refused(at, message));
        }
        if is_boxes {
            return Ok(());
        }
        let count = of.index_count;
        match of.index_size {
            0 | 4 => {
                let indices = of.indices.cast::<u32>();
                // SAFETY: the caller's promise.
                let given =
                    unsafe { read(format_args!("indices of occluder {at}"), indices, count) }?;
                self.indices.extend_from_slice(given);
            }
            2 => {
                let indices = of.indices.cast::<u16>();
                // SAFETY: the caller's promise.
                let given =
                    unsafe { read(format_args!("indices of occluder {at}"), indices, count) }?;
                self.indices.extend(given.iter().map(|i| u32::from(*i)));
            }
            other => {
                return Err(refused(at, format!("index_size is {other}: it must be 4 or 2")));
            }
        }
        if !count.is_multiple_of(3) || count == 0 {
            return Err(refused(at, format!("{count} indices do not make whole triangles")));
        }
        Ok(())
    }

    /// Makes the shape that was read; uses the memory of `surface`.
    fn shape(&self, at: usize, kind: u32, surface: Option<Box<DynamicSurface>>) -> Result<Shape> {
        let Self { positions, indices } = self;
        match kind {
            0 => {
                let (low, high) = positions.split_at(positions.len() / 2);
                let shapes = low.iter().zip(high).enumerate().map(|(number, (min, max))| {
                    let b = Aabb::new(*min, *max);
                    Convex::from_box(&b)
                        .map_err(|e| refused(at, format!("box {number}, {b:?}: {e}")))
                });
                shapes.collect::<Result<_>>().map(Shape::Convex)
            }
            1 => {
                let is_wrong = |i: &&u32| **i as usize >= positions.len();
                if let Some(index) = indices.iter().find(is_wrong) {
                    let count = positions.len();
                    return Err(refused(
                        at,
                        format!("index {index}, but there are {count} vertices"),
                    ));
                }
                let hull = Convex::from_mesh(positions, indices);
                hull.map(|hull| Shape::Convex(vec![hull])).ok_or_else(|| {
                    refused(
                        at,
                        "the triangles are not the surface of a convex body: closed, wound outward, exactly convex, of at most 256 corners; give them as CULLET_OCCLUDER_KIND_TRIANGLES",
                    )
                })
            }
            _ => {
                let mut surface = surface.unwrap_or_default();
                surface.set(positions, indices, kind == 3).map_err(|e| refused(at, e))?;
                Ok(Shape::Surface(surface, Aabb::from_points(positions)))
            }
        }
    }
}

impl Occluders {
    pub(super) fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Draws all of them into a buffer that was begun with `view`, near ones first.
    pub(super) fn draw(&mut self, simd: Simd, buffer: &mut OcclusionBuffer, view: &engine::View) {
        let Self { all, order, .. } = self;
        let [x, y, z, w] = view.eye();
        // Squared distance in perspective, distance along the view in an orthographic one: either
        // ascends with depth, which is all that it is for.
        let depth = |transform: &EngineTransform, bounds: &Aabb| {
            let bounds = transform.transform_box(bounds, [x * w, y * w, z * w]);
            let [a, b, c] = bounds.center();
            let depth = if w == 0.0 { -(x * a + y * b + z * c) } else { a * a + b * b + c * c };
            key(depth as f32)
        };
        order.clear();
        for (number, Placed { shape, transform }) in all.iter().enumerate() {
            match shape {
                Shape::Convex(parts) => order.extend(parts.iter().enumerate().map(|(at, part)| {
                    (depth(transform, &part.bounds()), number as u32, at as u32)
                })),
                Shape::Surface(_, bounds) => {
                    order.push((depth(transform, bounds), number as u32, 0));
                }
            }
        }
        order.sort_unstable();
        for &(_, number, at) in &*order {
            let Placed { shape, transform } = &mut all[number as usize];
            match shape {
                Shape::Convex(parts) => parts[at as usize].draw(simd, buffer, transform),
                Shape::Surface(surface, _) => surface.draw(simd, buffer, transform),
            }
        }
    }

    fn at(&mut self, number: u32) -> Result<&mut Placed> {
        let count = self.all.len();
        self.all.get_mut(number as usize).ok_or_else(|| {
            let message = format!("occluder {number}: the set has {count}");
            Error::new(Status::NotFound, message)
        })
    }
}

/// A number that ascends with a float.
fn key(v: f32) -> u32 {
    let bits = v.to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}

/// Replaces the occluders of a set: they have the numbers 0, 1, 2, ... in this order. All or none:
/// where one is refused, the message names it and the set keeps those that it had. Their space is
/// the world's, by `transform`. What hides must be opaque, and stand where you draw it. Allocates;
/// `cullet_boxes_move_occluder` and `cullet_boxes_set_occluder` are for every frame.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_boxes_set_occluders(
    boxes: Boxes,
    occluders: *const Occluder,
    count: usize,
) -> Status {
    call("cullet_boxes_set_occluders", || {
        // SAFETY: as the header asks of the caller.
        let given = unsafe { read("occluders", occluders, count) }?;
        let mut own = SETS.get_mut(boxes.id)?;
        let Occluders { all, scratch, .. } = &mut own.occluders;
        let mut made = Vec::with_capacity(count);
        for (at, of) in given.iter().enumerate() {
            // SAFETY: as the header asks of the caller.
            unsafe { scratch.read(at, of) }?;
            // SAFETY: as the header asks of the caller.
            let transform = unsafe { transform_of(of.transform) }?;
            made.push(Placed { shape: scratch.shape(at, of.kind, None)?, transform });
        }
        *all = made;
        Ok(())
    })
}

/// Replaces one occluder of a set, such as triangles that deform. Triangles in the place of
/// triangles allocate nothing once as many were there, and are quickest where the indices are the
/// same as before. What is refused changes nothing, but for triangles in the place of triangles:
/// then the occluder hides nothing until it is set again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_boxes_set_occluder(
    boxes: Boxes,
    number: u32,
    occluder: *const Occluder,
) -> Status {
    call("cullet_boxes_set_occluder", || {
        // SAFETY: as the header asks of the caller.
        let of = unsafe { value("occluder", occluder) }?;
        let mut own = SETS.get_mut(boxes.id)?;
        let at = number as usize;
        own.occluders.at(number)?;
        // SAFETY: as the header asks of the caller.
        unsafe { own.occluders.scratch.read(at, &of) }?;
        // SAFETY: as the header asks of the caller.
        let transform = unsafe { transform_of(of.transform) }?;
        let Occluders { all, scratch, .. } = &mut own.occluders;
        let placed = &mut all[at];
        if of.kind >= 2 {
            let taken = std::mem::replace(&mut placed.shape, Shape::Convex(Vec::new()));
            let surface = match taken {
                Shape::Surface(surface, _) => Some(surface),
                Shape::Convex(parts) => {
                    placed.shape = Shape::Convex(parts);
                    None
                }
            };
            placed.shape = scratch.shape(at, of.kind, surface)?;
        } else {
            placed.shape = scratch.shape(at, of.kind, None)?;
        }
        placed.transform = transform;
        Ok(())
    })
}

/// Moves one occluder of a set; NULL for the identity. Allocates nothing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_boxes_move_occluder(
    boxes: Boxes,
    number: u32,
    transform: *const Transform,
) -> Status {
    call("cullet_boxes_move_occluder", || {
        // SAFETY: as the header asks of the caller.
        let transform = unsafe { transform_of(transform) }?;
        SETS.get_mut(boxes.id)?.occluders.at(number)?.transform = transform;
        Ok(())
    })
}
