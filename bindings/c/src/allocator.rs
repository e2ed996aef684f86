//! The allocator of the whole library: the system's, or functions of the caller's.
//!
//! All memory must go back to where it came from. The first allocation therefore settles the choice
//! for as long as the process lives.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::UnsafeCell;
use std::ffi::c_void;
use std::mem::MaybeUninit;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::status::{Refused, Status, call_without_memory};

/// Functions that the library takes all its memory from. They are called on every thread that makes
/// calls, several at once, and must not call this library, throw or jump out.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Allocator {
    /// Returns `size` bytes, at least 1, at a multiple of `alignment`, a power of two: up to 64 in this
    /// version. What is in them does not matter. NULL where there is no memory: then the library
    /// writes a line to stderr and aborts the process.
    pub alloc: Option<
        unsafe extern "C" fn(context: *mut c_void, size: usize, alignment: usize) -> *mut c_void,
    >,
    /// Takes memory back that `alloc` or `realloc` returned, with the size and the alignment that it
    /// was asked for with.
    pub free: Option<
        unsafe extern "C" fn(
            context: *mut c_void,
            memory: *mut c_void,
            size: usize,
            alignment: usize,
        ),
    >,
    /// Makes memory larger or smaller, in place or elsewhere, and keeps what is in it up to the lesser
    /// size; NULL where there is no memory, and then the old one stays. NULL for the function itself:
    /// the library then calls `alloc`, copies, and calls `free`.
    pub realloc: Option<
        unsafe extern "C" fn(
            context: *mut c_void,
            memory: *mut c_void,
            old_size: usize,
            size: usize,
            alignment: usize,
        ) -> *mut c_void,
    >,
    /// Handed to each of them.
    pub context: *mut c_void,
}

/// The functions that must be there, once both are.
#[derive(Clone, Copy)]
struct Own {
    alloc: unsafe extern "C" fn(*mut c_void, usize, usize) -> *mut c_void,
    free: unsafe extern "C" fn(*mut c_void, *mut c_void, usize, usize),
    realloc:
        Option<unsafe extern "C" fn(*mut c_void, *mut c_void, usize, usize, usize) -> *mut c_void>,
    context: *mut c_void,
}

/// Nothing was allocated yet.
const OPEN: u32 = 0;
/// A thread is writing the caller's functions down.
const WRITING: u32 = 1;
const SYSTEM: u32 = 2;
const OWN: u32 = 3;

/// Allocates by what was chosen before the first allocation. Costs one load each time.
struct Chosen {
    state: AtomicU32,
    own: UnsafeCell<MaybeUninit<Own>>,
}

// SAFETY: `own` is written by the one thread that took `state` from OPEN to WRITING, and read once it
// is OWN, which it stays. The header says that several threads call the functions with the context.
unsafe impl Sync for Chosen {}

#[global_allocator]
static CHOSEN: Chosen = Chosen::new();

impl Chosen {
    const fn new() -> Self {
        Self { state: AtomicU32::new(OPEN), own: UnsafeCell::new(MaybeUninit::uninit()) }
    }

    /// Returns the caller's functions, or none for the system's; settles on the latter where nobody
    /// chose before.
    #[inline]
    fn get(&self) -> Option<&Own> {
        match self.state.load(Ordering::Acquire) {
            SYSTEM => None,
            // SAFETY: it was written before the state became this.
            OWN => Some(unsafe { (*self.own.get()).assume_init_ref() }),
            _ => self.settle(),
        }
    }

    #[cold]
    fn settle(&self) -> Option<&Own> {
        let _ = self.state.compare_exchange(OPEN, SYSTEM, Ordering::AcqRel, Ordering::Acquire);
        while self.state.load(Ordering::Acquire) == WRITING {
            // Another thread copies four words.
            std::hint::spin_loop();
        }
        self.get()
    }

    /// Chooses the caller's functions; false where something was allocated, or chosen, before.
    fn set(&self, own: Own) -> bool {
        let (before, after) = (Ordering::Acquire, Ordering::Relaxed);
        if self.state.compare_exchange(OPEN, WRITING, before, after).is_err() {
            return false;
        }
        // SAFETY: this thread alone took the state from OPEN, and nobody reads until it is OWN.
        unsafe { (*self.own.get()).write(own) };
        self.state.store(OWN, Ordering::Release);
        true
    }
}

// Never inlined: the choice at each place that frees something made the whole library larger.
//
// SAFETY: each function hands on to one allocator, always the same; that the caller's functions do
// what the header says is the caller's promise.
unsafe impl GlobalAlloc for Chosen {
    #[inline(never)]
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        match self.get() {
            // SAFETY: the promises of whoever calls this.
            None => unsafe { System.alloc(layout) },
            // SAFETY: the promise of the caller in C.
            Some(own) => unsafe {
                (own.alloc)(own.context, layout.size(), layout.align()).cast::<u8>()
            },
        }
    }

    #[inline(never)]
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        if self.get().is_none() {
            // SAFETY: the promises of whoever calls this.
            return unsafe { System.alloc_zeroed(layout) };
        }
        // SAFETY: as above.
        let memory = unsafe { self.alloc(layout) };
        if !memory.is_null() {
            // SAFETY: so many bytes were allocated.
            unsafe { memory.write_bytes(0, layout.size()) };
        }
        memory
    }

    #[inline(never)]
    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        match self.get() {
            // SAFETY: the promises of whoever calls this.
            None => unsafe { System.dealloc(memory, layout) },
            // SAFETY: the promise of the caller in C.
            Some(own) => unsafe {
                (own.free)(own.context, memory.cast(), layout.size(), layout.align());
            },
        }
    }

    #[inline(never)]
    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        let Some(own) = self.get() else {
            // SAFETY: the promises of whoever calls this.
            return unsafe { System.realloc(memory, layout, size) };
        };
        let (old_size, align) = (layout.size(), layout.align());
        if let Some(realloc) = own.realloc {
            // SAFETY: the promise of the caller in C.
            return unsafe { realloc(own.context, memory.cast(), old_size, size, align).cast() };
        }
        // SAFETY: the promises of whoever calls this: the size is one that the alignment allows.
        let to = unsafe { self.alloc(Layout::from_size_align_unchecked(size, align)) };
        if !to.is_null() {
            // SAFETY: both have so many bytes, and the new memory is nobody else's.
            unsafe {
                to.copy_from_nonoverlapping(memory, old_size.min(size));
                self.dealloc(memory, layout);
            }
        }
        to
    }
}

/// Makes the library take all its memory from functions of yours, which are copied, in place of the
/// system's allocator. Call it before all other functions, once: it is refused with
/// `CULLET_STATUS_TOO_LATE`, and nothing changes, where the library has allocated already. Calls that
/// allocate nothing, such as `cullet_version` or this one when it is refused, may come before. The
/// choice is the whole process's, also for other parts of it that use the same library, and holds to
/// its end: a thread that ends, the main thread too, frees its last error message. `alloc` and `free`
/// must be there. Stacks of threads, files that are mapped, and what the system's own functions
/// allocate are not asked for. Cost: with and without it, each allocation costs a load more; with it
/// also an indirect call. Culling allocates nothing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_set_allocator(allocator: *const Allocator) -> Status {
    // SAFETY: as the header asks of the caller.
    call_without_memory(|| unsafe { set(&CHOSEN, allocator) })
}

/// # Safety
/// If it is not NULL, `allocator` must have an initialised value, whose functions do what the header
/// says.
unsafe fn set(chosen: &Chosen, allocator: *const Allocator) -> Refused {
    let null = |text| (Status::NullPointer, text);
    if allocator.is_null() {
        return Err(null(c"cullet_set_allocator: allocator is NULL: it must point to a value"));
    }
    if !allocator.is_aligned() {
        let text = c"cullet_set_allocator: allocator is not aligned as its struct must be";
        return Err((Status::Alignment, text));
    }
    // SAFETY: it is not NULL and aligned; that there is one is the caller's promise.
    let Allocator { alloc, free, realloc, context } = unsafe { allocator.read() };
    let Some(alloc) = alloc else {
        return Err(null(c"cullet_set_allocator: allocator->alloc is NULL: it must be there"));
    };
    let Some(free) = free else {
        return Err(null(c"cullet_set_allocator: allocator->free is NULL: it must be there"));
    };
    if !chosen.set(Own { alloc, free, realloc, context }) {
        let text =
            c"cullet_set_allocator: the library has allocated memory, or has an allocator of \
                     yours: make this the first call of the program";
        return Err((Status::TooLate, text));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    unsafe extern "C" fn none(_: *mut c_void, _: usize, _: usize) -> *mut c_void {
        std::ptr::null_mut()
    }

    unsafe extern "C" fn drop_it(_: *mut c_void, _: *mut c_void, _: usize, _: usize) {}

    const NONE: Allocator = Allocator {
        alloc: Some(none),
        free: Some(drop_it),
        realloc: None,
        context: std::ptr::null_mut(),
    };

    #[test]
    fn the_first_choice_stands() {
        let status = |chosen: &Chosen, of: &Allocator| {
            // SAFETY: the functions are those above, which nobody calls through `CHOSEN`.
            unsafe { set(chosen, of) }.map_err(|(status, _)| status)
        };
        let chosen = Chosen::new();
        assert_eq!(status(&chosen, &Allocator { free: None, ..NONE }), Err(Status::NullPointer));
        assert_eq!(status(&chosen, &Allocator { alloc: None, ..NONE }), Err(Status::NullPointer));
        assert_eq!(status(&chosen, &NONE), Ok(()));
        assert!(chosen.get().is_some());
        assert_eq!(status(&chosen, &NONE), Err(Status::TooLate));
        let used = Chosen::new();
        assert!(used.get().is_none());
        assert_eq!(status(&used, &NONE), Err(Status::TooLate));
        assert!(used.get().is_none());
    }

    #[test]
    fn threads_that_choose_and_allocate_at_once_agree() {
        for _ in 0..200 {
            let chosen = Chosen::new();
            let start = std::sync::Barrier::new(3);
            let (set_it, seen) = std::thread::scope(|scope| {
                let setter = scope.spawn(|| {
                    start.wait();
                    // SAFETY: as above.
                    unsafe { set(&chosen, &NONE) }.is_ok()
                });
                let readers = [(); 2].map(|()| {
                    scope.spawn(|| {
                        start.wait();
                        [(); 20].map(|()| chosen.get().is_some())
                    })
                });
                let seen: Vec<bool> =
                    readers.into_iter().flat_map(|r| r.join().expect("no panic")).collect();
                (setter.join().expect("no panic"), seen)
            });
            assert!(seen.iter().all(|&own| own == set_it), "{set_it}: {seen:?}");
        }
    }
}
