//! An allocator that counts, for tests of what runs without allocating, and of what loading holds at once.
//!
//! A test program that measures memory says so, and has one test alone: what another thread holds would be counted too.
//! Allocations are counted by thread, for the thread that runs tests allocates whenever it likes.
//!
//! ```
//! use cullet_testkit::memory::{Counting, allocations_of, peak_of};
//!
//! #[global_allocator]
//! static ALLOCATOR: Counting = Counting;
//!
//! let (list, peak) = peak_of(|| vec![0_u8; 1000]);
//! assert_eq!((list.len(), peak), (1000, 1000));
//! assert_eq!(allocations_of(|| Box::new(1)).1, 1);
//! ```

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The system's allocator, counted.
#[derive(Clone, Copy, Debug)]
pub struct Counting;

static NOW: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

thread_local! {
    /// Allocations of this thread. It needs no memory of its own, nor anything at the thread's end.
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: every call is handed on to the system's allocator as it came. `realloc` is left to the
// default, which holds the old block and the new one at once: the worst that an allocator does.
#[expect(
    unsafe_code,
    reason = "an allocator is unsafe to write; this one stands here once for all tests"
)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = COUNT.try_with(|count| count.set(count.get() + 1));
        let now = NOW.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        PEAK.fetch_max(now, Ordering::Relaxed);
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        NOW.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: the caller keeps the contract of `dealloc`.
        unsafe { System.dealloc(at, layout) }
    }
}

/// Result of `run`, and the most bytes that were held at once beyond those held before.
///
/// # Panics
///
/// Where [`Counting`] is not the allocator of the program: nothing would be counted.
pub fn peak_of<T>(run: impl FnOnce() -> T) -> (T, usize) {
    check();
    let before = NOW.load(Ordering::Relaxed);
    PEAK.store(before, Ordering::Relaxed);
    let result = run();
    (result, PEAK.load(Ordering::Relaxed) - before)
}

/// Result of `run`, and how often it allocated on this thread.
///
/// # Panics
///
/// As [`peak_of`].
pub fn allocations_of<T>(run: impl FnOnce() -> T) -> (T, u64) {
    check();
    let before = COUNT.get();
    let result = run();
    (result, COUNT.get() - before)
}

fn check() {
    let before = COUNT.get();
    drop(std::hint::black_box(Box::new(0_u8)));
    assert!(
        COUNT.get() > before,
        "nothing is counted: the test needs `#[global_allocator] static ALLOCATOR: Counting = Counting;`"
    );
}
