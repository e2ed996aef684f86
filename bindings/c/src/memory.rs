//! Memory of the caller's: every pointer is checked here, and nowhere else is one followed.
//!
//! What cannot be checked is the caller's to keep: that so many elements are there. Memory that is
//! written to is never borrowed, so that a caller may hand the same array in twice, or one that was
//! never initialised.

#[cfg(feature = "files")]
use std::ffi::{CStr, c_char};
use std::fmt::Display;

use crate::status::{Error, Result, Status};

/// Types that any bytes are a value of, and so can come from C.
pub(crate) trait Plain: Copy + 'static {}

impl Plain for u8 {}
impl Plain for u16 {}
impl Plain for u32 {}
impl Plain for u64 {}
impl Plain for usize {}
impl Plain for f32 {}
impl Plain for f64 {}
impl<T: Plain, const N: usize> Plain for [T; N] {}

/// Refuses a pointer to an array of `len` elements, or to one value without a `len`, that cannot be
/// followed.
fn check<T>(what: impl Display, pointer: *const T, len: Option<usize>) -> Result {
    if pointer.is_null() {
        let message = match len {
            Some(len) => format!("{what} is NULL, but its length is given as {len}"),
            None => format!("{what} is NULL: it must point to a value"),
        };
        return Err(Error::new(Status::NullPointer, message));
    }
    let len = len.unwrap_or(1);
    if !pointer.is_aligned() {
        let to = align_of::<T>();
        let message = format!("{what} is at {pointer:p}, which is no multiple of {to} bytes");
        return Err(Error::new(Status::Alignment, message));
    }
    if len.checked_mul(size_of::<T>()).is_none_or(|bytes| bytes > isize::MAX as usize) {
        return Err(Error::value(format!("{what} has {len} elements: more than there is memory")));
    }
    Ok(())
}

/// The elements of an array that is read. NULL is one of none.
///
/// # Safety
/// If it is not NULL, `pointer` must have `len` initialised elements that nobody changes during
/// `'a`.
pub(crate) unsafe fn read<'a, T: Plain>(
    what: impl Display,
    pointer: *const T,
    len: usize,
) -> Result<&'a [T]> {
    if len == 0 {
        return Ok(&[]);
    }
    check(what, pointer, Some(len))?;
    // SAFETY: it is not NULL, is aligned and no longer than memory, as checked; any bytes are a
    // `Plain`; that there are `len` of them is the caller's promise.
    Ok(unsafe { std::slice::from_raw_parts(pointer, len) })
}

/// The value behind a pointer.
///
/// # Safety
/// If it is not NULL, `pointer` must have an initialised value.
pub(crate) unsafe fn value<T: Plain>(what: impl Display, pointer: *const T) -> Result<T> {
    check(what, pointer, None)?;
    // SAFETY: it is not NULL and aligned, as checked; any bytes are a `Plain`; that there is one is
    // the caller's promise.
    Ok(unsafe { pointer.read() })
}

/// The text behind a pointer.
///
/// # Safety
/// If it is not NULL, `pointer` must have a 0 behind its text, which nobody changes during `'a`.
#[cfg(feature = "files")]
pub(crate) unsafe fn text<'a>(what: impl Display, pointer: *const c_char) -> Result<&'a str> {
    check(&what, pointer, None)?;
    // SAFETY: it is not NULL; that there is a 0 is the caller's promise.
    let text = unsafe { CStr::from_ptr(pointer) };
    text.to_str()
        .map_err(|_| Error::value(format!("{what} is not UTF-8: {}", text.to_string_lossy())))
}

/// Refuses a reserved field that is not 0: a later version may give it a meaning.
pub(crate) fn reserved(what: impl Display, value: u32) -> Result {
    if value == 0 {
        return Ok(());
    }
    let message =
        format!("{what} is {value}: it must be 0; set the struct to zero before its fields");
    Err(Error::value(message))
}

/// Memory that is written to.
pub(crate) struct Out<T> {
    pointer: *mut T,
    len: usize,
}

impl<T: Copy> Out<T> {
    /// An array with room for `len`; NULL is one of none.
    ///
    /// # Safety
    /// If it is not NULL, `pointer` must have room for `len`, which nobody else uses until the call
    /// ends.
    pub(crate) unsafe fn array(what: impl Display, pointer: *mut T, len: usize) -> Result<Self> {
        if len > 0 {
            check(what, pointer, Some(len))?;
        }
        Ok(Self { pointer, len })
    }

    /// Room for one value.
    ///
    /// # Safety
    /// As [`array`](Self::array), for one.
    pub(crate) unsafe fn one(what: impl Display, pointer: *mut T) -> Result<Self> {
        check(what, pointer, None)?;
        Ok(Self { pointer, len: 1 })
    }

    pub(crate) fn room(&self) -> usize {
        self.len
    }

    /// Writes at a place that is within.
    pub(crate) fn set(&mut self, at: usize, value: T) {
        assert!(at < self.len, "{at} of {}", self.len);
        // SAFETY: `at` is within what the maker of `self` promised.
        unsafe { self.pointer.add(at).write(value) };
    }

    /// Writes values of ours from the start on; all of them must fit.
    pub(crate) fn copy(&mut self, values: &[T]) {
        assert!(values.len() <= self.len, "{} into {}", values.len(), self.len);
        if values.is_empty() {
            return;
        }
        // SAFETY: they fit into what the maker of `self` promised, which is no memory of ours.
        unsafe { self.pointer.copy_from_nonoverlapping(values.as_ptr(), values.len()) };
    }
}

impl Out<u8> {
    /// Writes the first `len` bits of `words`, a byte of 0 or 1 each; all of them must fit.
    pub(crate) fn flags(&mut self, words: &[u64], len: usize) {
        assert!(len <= self.len && len <= words.len() * 64, "{len} flags into {}", self.len);
        for (at, word) in words.iter().enumerate() {
            // Each byte gets all eight bits and keeps its own; adding 127 moves it to the top.
            let bytes = word.to_le_bytes().map(|byte| {
                let own = (u64::from(byte) * 0x0101_0101_0101_0101) & 0x8040_2010_0804_0201;
                (((own + 0x7f7f_7f7f_7f7f_7f7f) >> 7) & 0x0101_0101_0101_0101).to_le_bytes()
            });
            let flags = bytes.as_flattened();
            let some = &flags[..flags.len().min(len.saturating_sub(at * 64))];
            // SAFETY: `at * 64 + some.len()` is at most `len`, within what the maker of `self`
            // promised, which is no memory of ours.
            unsafe {
                self.pointer.add(at * 64).copy_from_nonoverlapping(some.as_ptr(), some.len());
            }
        }
    }
}

/// Rows of three numbers in memory of the caller's, at a stride.
pub(crate) struct Rows<T> {
    first: *const T,
    stride: usize,
    count: usize,
}

/// Checks `count` rows of three numbers, `stride` bytes apart.
///
/// # Safety
/// If it is not NULL, `first` must have so many initialised rows, which nobody changes for as long
/// as the result is used.
pub(crate) unsafe fn rows<T: Plain>(
    what: impl Display,
    first: *const T,
    stride: usize,
    count: usize,
) -> Result<Rows<T>> {
    if count == 0 {
        return Ok(Rows { first, stride, count });
    }
    let number = size_of::<T>();
    if stride < 3 * number || !stride.is_multiple_of(align_of::<T>()) {
        let message = format!(
            "the stride of {what} is {stride} bytes: it must be a multiple of {} and at least {}",
            align_of::<T>(),
            3 * number
        );
        return Err(Error::value(message));
    }
    if stride.checked_mul(count).is_none_or(|bytes| bytes > isize::MAX as usize) {
        return Err(Error::value(format!("{what} has {count} rows: more than there is memory")));
    }
    check(what, first, Some(count))?;
    Ok(Rows { first, stride, count })
}

impl<T: Plain> Rows<T> {
    pub(crate) fn iter(&self) -> impl Iterator<Item = [T; 3]> {
        (0..self.count).map(|at| self.get(at))
    }

    /// Number of rows.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// A row that is there. Its numbers are read one by one, so that they stay in registers.
    #[inline(always)]
    pub(crate) fn get(&self, at: usize) -> [T; 3] {
        assert!(at < self.count, "{at} of {}", self.count);
        // SAFETY: the row is there, as the maker of `self` promised; it is aligned, as the first and
        // the stride are.
        unsafe {
            let row = self.first.byte_add(at * self.stride);
            [row.read(), row.add(1).read(), row.add(2).read()]
        }
    }
}

/// Where the numbers of a vertex are: bytes from one vertex to the next, and from x to y and to the
/// third.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    pub(crate) stride: usize,
    pub(crate) second: usize,
    pub(crate) third: usize,
}

/// Three floats of each vertex from `first` to `last`, pushed to `to`.
///
/// # Safety
/// If it is not NULL, `pointer` must have initialised vertices of that layout, up to the last.
pub(crate) unsafe fn vertices(
    what: impl Display,
    pointer: *const f32,
    layout: Layout,
    [first, last]: [u32; 2],
    to: &mut Vec<[f32; 3]>,
) -> Result {
    let Layout { stride, second, third } = layout;
    let end = (last as usize).checked_mul(stride);
    let end = end
        .and_then(|end| end.checked_add(second.max(third)).filter(|e| *e <= isize::MAX as usize));
    if end.is_none() || [stride, second, third].iter().any(|v| v % align_of::<f32>() != 0) {
        let message = format!("{layout:?} of {what}: bytes must be multiples of 4");
        return Err(Error::value(message));
    }
    check(what, pointer, Some(last as usize + 1))?;
    for number in first as usize..=last as usize {
        let at = number * stride;
        // SAFETY: the vertices up to the last are there, as the caller promises, and aligned, as
        // the first and all distances are.
        to.push([at, at + second, at + third].map(|at| unsafe { pointer.byte_add(at).read() }));
    }
    Ok(())
}
