//! Boxes in, flags out: culling over the caller's own arrays, with no scene and no meshes.

pub mod arrays;
pub mod occluders;
#[cfg(test)]
mod tests;

use engine::Simd;
use engine::bounds::Boxes as Batch;
use engine::cull::frustum::batch::{Planes, mask_boxes, mask_words};
use engine::cull::occlusion::{Occlusion, OcclusionBuffer};

use crate::memory::{Out, value};
use crate::registry::{Kind, Table};
use crate::status::{Error, Result, Status, call};
use crate::view::{View, to_engine};
use arrays::BoxArrays;
use occluders::Occluders;

pub(crate) static SETS: Table<Set> = Table::new(Kind::Boxes);

/// Handle of a set of boxes. A plain number: copy it freely; 0 is none.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Boxes {
    /// Not to be read or made.
    pub id: u64,
}

/// Set of boxes behind the handle, with what a cull of it uses again in the next frame.
#[derive(Debug)]
pub(crate) struct Set {
    /// The boxes, relative to `origin` and rounded outward.
    batch: Batch,
    origin: [f64; 3],
    /// Width of the occlusion buffer, in pixels.
    width: u32,
    buffer: Option<OcclusionBuffer>,
    occluders: Occluders,
    /// One bit a box: in the frustum, visible, hidden.
    words: [Vec<u64>; 3],
}

impl Set {
    /// Finds the boxes that may be visible; returns one bit for each.
    fn cull(&mut self, view: &engine::View) -> Result<&[u64]> {
        let simd = Simd::best();
        let Self { batch, origin, width, buffer, occluders, words } = self;
        let [within, visible, hidden] = words;
        for words in [&mut *within, &mut *visible, &mut *hidden] {
            words.resize(mask_words(batch.len()), 0);
        }
        let planes = Planes::new(&view.frustum().relative_to(*origin));
        mask_boxes(simd, &planes, batch, 0, within);
        if occluders.is_empty() || within.iter().all(|w| *w == 0) {
            return Ok(within);
        }
        let size = size_of_buffer(*width, view.viewport());
        let buffer = match buffer {
            Some(buffer) if buffer.size() == size => buffer,
            buffer => {
                let made = OcclusionBuffer::new(size).map_err(|e| Error::value(e.to_string()))?;
                buffer.insert(made)
            }
        };
        buffer.begin(view, *origin);
        occluders.draw(simd, buffer, view);
        buffer.test_boxes(simd, batch, 0, within, visible, hidden);
        Ok(visible)
    }
}

/// Size of an occlusion buffer that is `width` pixels wide, or as wide as the viewport where that
/// is less.
fn size_of_buffer(width: u32, viewport: [u32; 2]) -> [u32; 2] {
    let columns = width.min(viewport[0]);
    let rows = (u64::from(viewport[1]) * u64::from(columns)).div_ceil(u64::from(viewport[0]));
    [columns, (rows as u32).clamp(1, OcclusionBuffer::LIMIT)]
}

/// Makes an empty set of boxes, to be culled over your own arrays: `cullet_boxes_set` takes the
/// boxes, `cullet_boxes_set_occluders` what hides them, `cullet_boxes_cull` a view.
/// `occlusion_width` is how many pixels the occlusion buffer has across, up to 4096 and at most the
/// viewport's width; 0 takes 640. Destroy the set with `cullet_boxes_destroy`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_boxes_create(occlusion_width: u32, boxes: *mut Boxes) -> Status {
    call("cullet_boxes_create", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::one("boxes", boxes) }?;
        let limit = OcclusionBuffer::LIMIT;
        if occlusion_width > limit {
            let message = format!("occlusion_width is {occlusion_width}: it must be 0 to {limit}");
            return Err(Error::value(message));
        }
        let width = if occlusion_width == 0 { Occlusion::default().width } else { occlusion_width };
        let made = Set {
            batch: Batch::new(),
            origin: [0.0; 3],
            width,
            buffer: None,
            occluders: Occluders::default(),
            words: Default::default(),
        };
        out.set(0, Boxes { id: SETS.insert(made)? });
        Ok(())
    })
}

/// Destroys a set of boxes; its handle is stale from then on.
#[unsafe(no_mangle)]
pub extern "C" fn cullet_boxes_destroy(boxes: Boxes) -> Status {
    call("cullet_boxes_destroy", || SETS.remove(boxes.id).map(drop))
}

/// Replaces all boxes of a set by those of your arrays, which are copied. A box with a NaN or an
/// infinite number is always visible; one whose lowest corner is above its highest, or whose half
/// size is negative, is empty and never visible. Rounding only ever grows a box. Allocates nothing
/// once the set has held as many. Cost: linear in the boxes; several times that of a cull without
/// occluders, so use `cullet_boxes_update` where few have moved.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_boxes_set(boxes: Boxes, arrays: *const BoxArrays) -> Status {
    call("cullet_boxes_set", || {
        // SAFETY: as the header asks of the caller.
        let arrays = unsafe { value("arrays", arrays) }?;
        // SAFETY: as the header asks of the caller.
        let rows = unsafe { arrays.rows() }?;
        let mut own = SETS.get_mut(boxes.id)?;
        let Set { batch, origin, .. } = &mut *own;
        *origin = rows.middle();
        batch.resize(arrays.count);
        rows.write(*origin, batch, 0);
        Ok(())
    })
}

/// Replaces boxes `first`, `first` + 1 and so on of a set, as many as the arrays have: those that
/// moved. Otherwise as `cullet_boxes_set`. Cost: linear in the boxes that are replaced.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_boxes_update(
    boxes: Boxes,
    first: usize,
    arrays: *const BoxArrays,
) -> Status {
    call("cullet_boxes_update", || {
        // SAFETY: as the header asks of the caller.
        let arrays = unsafe { value("arrays", arrays) }?;
        // SAFETY: as the header asks of the caller.
        let rows = unsafe { arrays.rows() }?;
        let mut own = SETS.get_mut(boxes.id)?;
        let Set { batch, origin, .. } = &mut *own;
        if first.checked_add(arrays.count).is_none_or(|end| end > batch.len()) {
            let (count, all) = (arrays.count, batch.len());
            let message = format!(
                "{count} boxes from box {first} on, but the set has {all}: set them all by cullet_boxes_set first"
            );
            return Err(Error::value(message));
        }
        rows.write(*origin, batch, first);
        Ok(())
    })
}

/// Culls a set of boxes for a view, and writes a flag for each: 1 where the box may be visible, 0
/// where it is proved to be outside the view or behind occluders. `capacity` must be at least the
/// number of boxes. `visible` takes how many flags are 1, unless it is NULL. Layers and faces of the
/// view play no part. Allocates nothing once the set has been culled with a view as large. Cost: the
/// frustum test of all boxes, some nanoseconds each; then, with occluders, drawing those and testing
/// what is left. Needs the set alone: for views side by side, make a set for each thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_boxes_cull(
    boxes: Boxes,
    view: *const View,
    flags: *mut u8,
    capacity: usize,
    visible: *mut usize,
) -> Status {
    call("cullet_boxes_cull", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::array("flags", flags, capacity) }?;
        let write = |words: &[u64], len: usize| {
            room(capacity, len, "flags")?;
            out.flags(words, len);
            Ok(())
        };
        // SAFETY: as the header asks of the caller.
        unsafe { cull(boxes, view, visible, write) }
    })
}

/// Culls as `cullet_boxes_cull` does, and writes bits: bit i mod 64 of word i / 64 is the flag of
/// box i; bits beyond the last box are 0. `capacity`, in words, must be at least a 64th of the
/// number of boxes, rounded up.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_boxes_cull_bits(
    boxes: Boxes,
    view: *const View,
    words: *mut u64,
    capacity: usize,
    visible: *mut usize,
) -> Status {
    call("cullet_boxes_cull_bits", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::array("words", words, capacity) }?;
        let write = |found: &[u64], _: usize| {
            room(capacity, found.len(), "words")?;
            out.copy(found);
            Ok(())
        };
        // SAFETY: as the header asks of the caller.
        unsafe { cull(boxes, view, visible, write) }
    })
}

fn room(capacity: usize, needed: usize, what: &str) -> Result {
    if capacity >= needed {
        return Ok(());
    }
    let message = format!("room for {capacity} {what}, but {needed} are needed");
    Err(Error::new(Status::TooSmall, message))
}

/// Culls, and hands the answer and the number of boxes to `write`.
///
/// # Safety
/// As the header asks of the caller.
unsafe fn cull(
    boxes: Boxes,
    view: *const View,
    visible: *mut usize,
    write: impl FnOnce(&[u64], usize) -> Result,
) -> Result {
    // SAFETY: the caller's promise.
    let view = to_engine(&unsafe { value("view", view) }?)?;
    // SAFETY: the caller's promise.
    let mut total = unsafe { Out::array("visible", visible, usize::from(!visible.is_null())) }?;
    let mut own = SETS.get_mut(boxes.id)?;
    let len = own.batch.len();
    let words = own.cull(&view)?;
    write(words, len)?;
    if total.room() > 0 {
        total.set(0, words.iter().map(|w| w.count_ones() as usize).sum());
    }
    Ok(())
}
