//! The entry point that Godot looks for. It is the only place where Rust asks for `unsafe`: whoever
//! writes it vouches that nothing else in the library breaks the rules of Godot's interface.
#![expect(unsafe_code, reason = "the trait by which godot-rust names the entry point is unsafe")]

use godot::init::{ExtensionLibrary, gdextension};

struct CulletExtension;

// SAFETY: the library contains no unsafe code of its own.
#[gdextension]
unsafe impl ExtensionLibrary for CulletExtension {}
