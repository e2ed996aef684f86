//! The npm package: six WebAssembly modules, types, bundles, and both hosts, Node and a browser.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::golden;
use crate::compiler::{Compiler, wasm_linker};
use crate::runner::{End, Ended, Skip, all};
use crate::tools::{Done, alone, apart, cache, command, root, run, target};
use crate::web::browser;

const TARGET: &str = "wasm32-unknown-unknown";
const SOURCES: &str = "bindings/web";

/// Builds the package and tests it in Node and in a browser, by itself, under three.js and under
/// 3d-tiles-renderer.
pub(crate) fn test() -> Ended {
    let browser = match browser("the npm package, in Node and in a browser")? {
        Ok(browser) => browser,
        Err(Skip { what, cure }) => return Ok(End::Skipped(Skip::new(what, cure))),
    };
    all(build_and_test(&browser))
}

fn build_and_test(browser: &str) -> Done {
    let packages = fetch()?;
    let package = build_with(&packages)?;
    let mut files = tests(&root().join(SOURCES).join("test"))?;
    for host in ["three", "tiles"] {
        files.extend(tests(&root().join(SOURCES).join("test").join(host))?);
    }
    // Each with a browser of its own, whose scripts have one thread.
    let mut node = command("node", &["--test", "--test-concurrency=2"]);
    node.args(files).env("CHROMIUM", browser);
    node.env("CULLET_PACKAGE", package).env("CULLET_NODE_MODULES", packages);
    if golden::folder().join("golden.json").is_file() {
        node.env("CULLET_GOLDEN", golden::folder());
    }
    run(node)
}

/// Builds the package into a folder of the target folder.
pub(crate) fn build() -> Result<PathBuf, String> {
    build_with(&fetch()?)
}

/// The same, made smaller by what lies in a folder of packages.
fn build_with(packages: &Path) -> Result<PathBuf, String> {
    let _alone = alone("npm")?;
    let out = target().join("npm/cullet");
    let mut node = command("node", &[&format!("{SOURCES}/build.mjs"), &out.to_string_lossy()]);
    node.env("CARGO_TARGET_DIR", apart("npm"));
    node.env("CULLET_WASM_OPT", packages.join("node_modules/.bin/wasm-opt"));
    if let Compiler::Debian = Compiler::get(TARGET)? {
        node.env("CULLET_CARGO", "/usr/bin/cargo")
            .env("CULLET_CARGO_ARGS", "-Zbuild-std=std,panic_abort");
        node.env("RUSTC", "/usr/bin/rustc").env("RUSTC_BOOTSTRAP", "1");
        node.env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER", wasm_linker()?);
    }
    run(node)?;
    Ok(out)
}

/// Fetches what the tests need into the cache, of the versions that their list names; the folder
/// with `node_modules`.
fn fetch() -> Result<PathBuf, String> {
    let folder = cache().join("npm-web");
    let list = root().join(SOURCES).join("test/tools/package.json");
    let fail = |path: &Path, e: std::io::Error| format!("{}: {e}", path.display());
    let wanted = fs::read_to_string(&list).map_err(|e| fail(&list, e))?;
    let kept = folder.join("package.json");
    if fs::read_to_string(&kept).is_ok_and(|kept| kept == wanted) {
        println!("npm packages: as fetched before, in {}", folder.display());
        return Ok(folder);
    }
    // The list is put there last, so that what was interrupted is fetched again.
    let new = cache().join("npm-web.new");
    let _ = fs::remove_dir_all(&new);
    fs::create_dir_all(&new).map_err(|e| fail(&new, e))?;
    fs::copy(&list, new.join("package.json")).map_err(|e| fail(&new, e))?;
    let words = ["install", "--no-audit", "--no-fund", "--no-package-lock", "--ignore-scripts"];
    let mut npm: Command = command("npm", &words);
    npm.current_dir(&new);
    run(npm)?;
    let _ = fs::remove_dir_all(&folder);
    fs::rename(&new, &folder).map_err(|e| fail(&folder, e))?;
    println!("installed: the npm packages of {}, in {}", list.display(), folder.display());
    Ok(folder)
}

/// The tests of a folder; none where there is no such folder.
fn tests(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let Ok(entries) = fs::read_dir(folder) else { return Ok(Vec::new()) };
    let mut files: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
    files.retain(|path| path.to_string_lossy().ends_with(".test.mjs"));
    files.sort();
    Ok(files)
}
