//! `bindgen FILE.wasm OUT_DIR`: writes the JavaScript that loads a wasm-bindgen module, and the
//! module it loads.
//!
//! It does what the program `wasm-bindgen --target web` does. Here its version stands in the same
//! lock file as the library's, so that the two cannot part; as a program of its own, behind a
//! feature, it is built only where a page is.
#![forbid(unsafe_code)]

use std::path::PathBuf;
use std::process::ExitCode;

fn main() -> ExitCode {
    let mut args = std::env::args_os().skip(1).map(PathBuf::from);
    let (Some(input), Some(out), None) = (args.next(), args.next(), args.next()) else {
        eprintln!("usage: bindgen FILE.wasm OUT_DIR");
        return ExitCode::from(2);
    };
    let mut bindgen = wasm_bindgen_cli_support::Bindgen::new();
    // Names of functions are a fifth of the module, for traces that no visitor reads; a panic says
    // its place all the same.
    bindgen.remove_name_section(true).remove_producers_section(true);
    // Without the default path `init()` of the written module would need to be told where its wasm
    // lies.
    let written = bindgen
        .input_path(&input)
        .web(true)
        .and_then(|b| b.typescript(false).omit_default_module_path(false).generate(&out));
    match written {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("bindgen: {}: {error:#}", input.display());
            ExitCode::FAILURE
        }
    }
}
