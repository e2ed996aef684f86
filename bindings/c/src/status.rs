//! Status codes, the message of the last error of a thread, and the wall that no panic passes.

use std::borrow::Cow;
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// How a call went. All but `CULLET_STATUS_OK` leave a message in `cullet_last_error`, and change
/// nothing unless they say so.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// It did what it says.
    Ok = 0,
    /// A pointer is NULL that must not be.
    NullPointer = 1,
    /// A pointer is not aligned to what it points to.
    Alignment = 2,
    /// The `size` of a struct is not the one that this library knows: it was not filled by the
    /// function that fills it, or header and library are of different versions.
    StructSize = 3,
    /// A number is outside its range, or not finite, or a text is not UTF-8.
    InvalidValue = 4,
    /// A handle is 0, so that it was never made.
    NullHandle = 5,
    /// A handle's object was destroyed.
    StaleHandle = 6,
    /// A handle is of another kind of object.
    WrongHandle = 7,
    /// Another thread is using the object in a way that excludes this call. Nothing waits; see the
    /// rules on threads.
    Busy = 8,
    /// An array is too short; the count that is needed was written.
    TooSmall = 9,
    /// A state holds no result yet, or the scene has changed since, or it is of another scene: cull
    /// again.
    NoResult = 10,
    /// An instance handle names no instance of the scene, or a mesh or a slot is not there.
    NotFound = 11,
    /// A mesh is refused: an index beyond the vertices, a position that is not finite.
    Mesh = 12,
    /// The numbers make no view.
    View = 13,
    /// A file, or the bytes of one, cannot be loaded or written, or is of another scene.
    File = 14,
    /// There are as many objects as there can be.
    Full = 15,
    /// A defect of this library: the call was stopped. The object that it was about to change can
    /// only be destroyed.
    Internal = 16,
    /// A bake ended before its end: a callback stopped it, or it was one share of several. The scene
    /// is as it was; what was finished lies in the folder of the bake, if it has one.
    Stopped = 17,
    /// It had to be called before the library allocated memory.
    TooLate = 18,
}

/// Why a call is refused: its code, and words that name the argument, the value, the limit and what
/// to do.
#[derive(Debug)]
pub(crate) struct Error {
    pub(crate) status: Status,
    pub(crate) message: String,
}

impl Error {
    pub(crate) fn new(status: Status, message: impl Into<String>) -> Self {
        Self { status, message: message.into() }
    }

    pub(crate) fn value(message: impl Into<String>) -> Self {
        Self::new(Status::InvalidValue, message)
    }
}

pub(crate) type Result<T = ()> = std::result::Result<T, Error>;

thread_local! {
    static LAST: RefCell<Cow<'static, CStr>> = const { RefCell::new(Cow::Borrowed(c"")) };
}

/// Runs the body of a call: what it refuses, and what panics in it, becomes a status and a message.
pub(crate) fn call(name: &'static str, body: impl FnOnce() -> Result) -> Status {
    let error = match catch_unwind(AssertUnwindSafe(body)) {
        Ok(Ok(())) => return Status::Ok,
        Ok(Err(error)) => error,
        Err(panic) => {
            let words = panic.downcast_ref::<String>().map(String::as_str);
            let words = words.or_else(|| panic.downcast_ref::<&str>().copied());
            let words = words.unwrap_or("no message");
            Error::new(Status::Internal, format!("a defect of cullet, please report it: {words}"))
        }
    };
    let text = format!("{name}: {}", error.message).replace('\0', "?");
    remember(Cow::Owned(CString::new(text).unwrap_or_default()));
    error.status
}

/// Runs the body of a call that allocates nothing, not even a message.
pub(crate) fn call_without_memory(body: impl FnOnce() -> Refused) -> Status {
    match body() {
        Ok(()) => Status::Ok,
        Err((status, text)) => {
            remember(Cow::Borrowed(text));
            status
        }
    }
}

/// Result of a call that allocates nothing.
pub(crate) type Refused = std::result::Result<(), (Status, &'static CStr)>;

fn remember(text: Cow<'static, CStr>) {
    // A thread that is ending has no message any more.
    let _ = LAST.try_with(|last| last.try_borrow_mut().map(|mut last| *last = text));
}

/// The message of the last call of this thread that failed: UTF-8, one line, which names the
/// function, the argument, the value, its limit and what to do. Empty where none failed yet. It
/// stays valid until the next call of this thread that fails. Never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn cullet_last_error() -> *const c_char {
    LAST.try_with(|last| last.try_borrow().map_or(c"".as_ptr(), |last| last.as_ptr()))
        .unwrap_or(c"".as_ptr())
}

/// The name of a status, such as "stale handle"; "unknown status" for a number that is none. Never
/// NULL; lives for ever.
#[unsafe(no_mangle)]
pub extern "C" fn cullet_status_name(status: i32) -> *const c_char {
    let name: &CStr = match status {
        0 => c"ok",
        1 => c"null pointer",
        2 => c"alignment",
        3 => c"struct size",
        4 => c"invalid value",
        5 => c"null handle",
        6 => c"stale handle",
        7 => c"wrong handle",
        8 => c"busy",
        9 => c"too small",
        10 => c"no result",
        11 => c"not found",
        12 => c"mesh",
        13 => c"view",
        14 => c"file",
        15 => c"full",
        16 => c"internal",
        17 => c"stopped",
        18 => c"too late",
        _ => c"unknown status",
    };
    name.as_ptr()
}

/// The version of the library, such as "0.2.0". Never NULL; lives for ever.
#[unsafe(no_mangle)]
pub extern "C" fn cullet_version() -> *const c_char {
    const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "\0");
    VERSION.as_ptr().cast()
}
