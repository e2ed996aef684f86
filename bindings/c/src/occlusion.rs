//! Occlusion buffers by hand: draw what hides, test what is hidden.

use engine::bounds::{Aabb, Boxes};
use engine::cull::occlusion::{
    Convex, DynamicSurface, OcclusionBuffer, OcclusionError, Visibility,
};
use engine::{Simd, Transform as EngineTransform};

use crate::clip::Clip;
use crate::memory::{Out, Plain, read, value};
use crate::registry::{Kind, Table};
use crate::status::{Error, Result, Status, call};
use crate::transform::Transform;
use crate::view::{View, to_engine};

pub(crate) static BUFFERS: Table<Buffer> = Table::new(Kind::Occlusion);

/// Handle of an occlusion buffer. A plain number: copy it freely; 0 is none.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Occlusion {
    /// Not to be read or made.
    pub id: u64,
}

/// State behind the handle.
#[derive(Debug)]
pub(crate) struct Buffer {
    pub(crate) buffer: OcclusionBuffer,
    pub(crate) begun: bool,
    surface: DynamicSurface,
    /// Memory of tests.
    boxes: Boxes,
    words: [Vec<u64>; 3],
    /// State for triangles in clip space.
    pub(crate) clip: Clip,
}

impl Buffer {
    pub(crate) fn check(&self) -> Result {
        if self.begun {
            return Ok(());
        }
        let message = "the buffer has no view yet: call cullet_occlusion_begin";
        Err(Error::new(Status::NoResult, message))
    }
}

/// Result of a test of an occlusion buffer.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub enum Found {
    /// It may be visible.
    Visible = 0,
    /// It is proved to be hidden.
    Hidden = 1,
    /// It is out of the view.
    Outside = 2,
}

/// A box: its lowest and its highest corner.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Box3 {
    /// The lowest corner.
    pub min: [f32; 3],
    /// The highest corner.
    pub max: [f32; 3],
}

impl Plain for Box3 {}

impl Box3 {
    pub(crate) fn to_engine(self) -> Aabb {
        Aabb::new(self.min, self.max)
    }
}

pub(crate) const fn number_of(visibility: Visibility) -> u8 {
    match visibility {
        Visibility::Visible => 0,
        Visibility::Hidden => 1,
        Visibility::Outside => 2,
    }
}

fn refused(error: OcclusionError) -> Error {
    Error::value(error.to_string())
}

/// Makes an occlusion buffer of so many pixels, 1 to 4096 each way; a quarter or half of the
/// screen's width finds nearly as much as all of it, and is never wrong. Destroy it with
/// `cullet_occlusion_destroy`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_occlusion_create(
    width: u32,
    height: u32,
    buffer: *mut Occlusion,
) -> Status {
    call("cullet_occlusion_create", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::one("buffer", buffer) }?;
        let made = Buffer {
            buffer: OcclusionBuffer::new([width, height]).map_err(refused)?,
            begun: false,
            surface: DynamicSurface::default(),
            boxes: Boxes::new(),
            words: Default::default(),
            clip: Clip::default(),
        };
        out.set(0, Occlusion { id: BUFFERS.insert(made)? });
        Ok(())
    })
}

/// Destroys an occlusion buffer; its handle is stale from then on.
#[unsafe(no_mangle)]
pub extern "C" fn cullet_occlusion_destroy(buffer: Occlusion) -> Status {
    call("cullet_occlusion_destroy", || BUFFERS.remove(buffer.id).map(drop))
}

/// Empties a buffer and turns it to a view. Boxes that are tested later are relative to `origin`,
/// three doubles; NULL for zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_occlusion_begin(
    buffer: Occlusion,
    view: *const View,
    origin: *const f64,
) -> Status {
    call("cullet_occlusion_begin", || {
        // SAFETY: as the header asks of the caller.
        let view = to_engine(&unsafe { value("view", view) }?)?;
        let mut at = [0.0; 3];
        if !origin.is_null() {
            // SAFETY: as the header asks of the caller.
            at = unsafe { value("origin", origin.cast()) }?;
        }
        if at.iter().any(|v: &f64| !v.is_finite()) {
            return Err(Error::value(format!("origin {at:?} is not finite")));
        }
        let mut own = BUFFERS.get_mut(buffer.id)?;
        own.buffer.begin(&view, at);
        own.begun = true;
        Ok(())
    })
}

/// The transform behind a pointer; NULL for the identity.
///
/// # Safety
/// If it is not NULL, there must be a transform.
pub(crate) unsafe fn transform_of(transform: *const Transform) -> Result<EngineTransform> {
    if transform.is_null() {
        return Ok(EngineTransform::IDENTITY);
    }
    // SAFETY: the caller's promise.
    Ok(unsafe { value("transform", transform) }?.to_engine())
}

/// Draws boxes that hide: each must lie within what is opaque. `transform` stands for all of them;
/// NULL for none. Draw near ones first. Allocates a few hundred bytes a box. Boxes that are empty
/// or not finite are refused, and none is drawn.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_occlusion_draw_boxes(
    buffer: Occlusion,
    boxes: *const Box3,
    count: usize,
    transform: *const Transform,
) -> Status {
    call("cullet_occlusion_draw_boxes", || {
        // SAFETY: as the header asks of the caller.
        let boxes = unsafe { read("boxes", boxes, count) }?;
        // SAFETY: as the header asks of the caller.
        let transform = unsafe { transform_of(transform) }?;
        let mut own = BUFFERS.get_mut(buffer.id)?;
        own.check()?;
        let mut shapes = Vec::with_capacity(count);
        for (at, b) in boxes.iter().enumerate() {
            let shape = Convex::from_box(&b.to_engine());
            shapes.push(shape.map_err(|e| Error::value(format!("box {at}, {b:?}: {e}")))?);
        }
        for shape in shapes {
            shape.draw(Simd::best(), &mut own.buffer, &transform);
        }
        Ok(())
    })
}

/// Draws triangles that hide, nearest first, without those that are hidden by then: `positions` has
/// three finite floats a vertex, `indices` three a triangle. `two_sided` is 1 for triangles that
/// hide from both sides, 0 where only their fronts do, which are counter-clockwise. Vertices are
/// one where they have one index: pixels across shared edges count as covered. Allocates nothing
/// once the buffer has seen as many triangles, and is quickest where the indices are those of the
/// last call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_occlusion_draw_triangles(
    buffer: Occlusion,
    positions: *const f32,
    position_count: usize,
    indices: *const u32,
    index_count: usize,
    two_sided: u32,
    transform: *const Transform,
) -> Status {
    call("cullet_occlusion_draw_triangles", || {
        // SAFETY: as the header asks of the caller.
        let positions = unsafe { read("positions", positions.cast::<[f32; 3]>(), position_count) }?;
        // SAFETY: as the header asks of the caller.
        let indices = unsafe { read("indices", indices, index_count) }?;
        // SAFETY: as the header asks of the caller.
        let transform = unsafe { transform_of(transform) }?;
        if !index_count.is_multiple_of(3) {
            let message = format!("{index_count} indices do not make whole triangles");
            return Err(Error::value(message));
        }
        if two_sided > 1 {
            return Err(Error::value(format!("two_sided is {two_sided}: it must be 0 or 1")));
        }
        let mut own = BUFFERS.get_mut(buffer.id)?;
        own.check()?;
        let Buffer { buffer, surface, .. } = &mut *own;
        surface.set(positions, indices, two_sided == 1).map_err(refused)?;
        surface.draw(Simd::best(), buffer, &transform);
        Ok(())
    })
}

/// Tests boxes, relative to the origin of the view, and writes a `cullet_found` for each, one byte.
/// Hidden is proved, at every resolution. Boxes that are not finite or cross the near plane are
/// visible; empty ones are outside. Allocates nothing once as many were tested.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_occlusion_test_boxes(
    buffer: Occlusion,
    boxes: *const Box3,
    count: usize,
    results: *mut u8,
) -> Status {
    call("cullet_occlusion_test_boxes", || {
        // SAFETY: as the header asks of the caller.
        let given = unsafe { read("boxes", boxes, count) }?;
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::array("results", results, count) }?;
        let mut own = BUFFERS.get_mut(buffer.id)?;
        own.check()?;
        let Buffer { buffer, boxes, words: [wanted, visible, hidden], .. } = &mut *own;
        boxes.clear();
        for b in given {
            boxes.push(&b.to_engine());
        }
        for words in [&mut *wanted, &mut *visible, &mut *hidden] {
            words.clear();
            words.resize(count.div_ceil(64), 0);
        }
        wanted.fill(u64::MAX);
        buffer.test_boxes(Simd::best(), boxes, 0, wanted, visible, hidden);
        for at in 0..count {
            let has = |words: &[u64]| words[at / 64] >> (at % 64) & 1 == 1;
            let found = match (has(visible), has(hidden)) {
                (true, _) => Visibility::Visible,
                (_, true) => Visibility::Hidden,
                _ => Visibility::Outside,
            };
            out.set(at, number_of(found));
        }
        Ok(())
    })
}

/// Writes the nearness that covers all of each pixel, row by row from the top left: 1 / w in
/// perspective, 0 where nothing is proved. `capacity` must be at least width times height.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_occlusion_read(
    buffer: Occlusion,
    nearness: *mut f32,
    capacity: usize,
) -> Status {
    call("cullet_occlusion_read", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::array("nearness", nearness, capacity) }?;
        let own = BUFFERS.get(buffer.id)?;
        let [width, height] = own.buffer.size();
        let needed = width as usize * height as usize;
        if capacity < needed {
            let message = format!("room for {capacity} pixels, but {width}x{height} is {needed}");
            return Err(Error::new(Status::TooSmall, message));
        }
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
        for (at, [x, y]) in pixels.enumerate() {
            out.set(at, own.buffer.nearness(x, y));
        }
        Ok(())
    })
}
