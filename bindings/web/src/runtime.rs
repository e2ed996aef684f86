//! Allocator and panic handler of a module without the standard library.

use core::panic::PanicInfo;

use dlmalloc::GlobalDlmalloc;

/// The allocator that the standard library has for the web too.
#[global_allocator]
static ALLOCATOR: GlobalDlmalloc = GlobalDlmalloc;

/// Ends the module: the page tells in which call.
#[panic_handler]
fn ended(_: &PanicInfo<'_>) -> ! {
    core::arch::wasm32::unreachable()
}
