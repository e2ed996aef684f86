//! The page: built with wasm, bound to JavaScript, compressed, measured, served and tested in a browser.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use flate2::Compression;
use flate2::write::GzEncoder;

use crate::tools::{
    Done, cargo, cargo_program, command, install, install_words, is_ci, output, root, run,
};

const TARGET: &str = "wasm32-unknown-unknown";
/// Debian's compiler, library source and cargo, of one version, where rustup cannot fetch the target.
const DEBIAN: &[&str] = &["rustc-web", "cargo-web", "rust-web-src"];
/// What the page may weigh when compressed: it should come in some seconds over an ordinary line.
const MAX_COMPRESSED: u64 = 4 << 20;
/// Sources of the page, from the root; what is in `tests` is none of it.
const SOURCES: &str = "crates/cullet-viewer/web";

/// Where the page is built, and where `cullet-serve` finds it.
pub(crate) fn page() -> PathBuf {
    root().join("target/page")
}

/// Builds the page and serves it, with `scene` if there is one.
pub(crate) fn serve(scene: Option<&str>) -> Done {
    build()?;
    cargo(&["build", "--quiet", "--release", "--package", "cullet-serve"])?;
    let program = root().join("target/release/cullet-serve");
    run(command(&program.to_string_lossy(), scene.as_slice()))
}

/// Builds the page into its folder, which is replaced as a whole once everything is there.
pub(crate) fn build() -> Done {
    let start = Instant::now();
    let wasm = compile()?;
    let new = root().join("target/page.new");
    let fail = |path: &Path, e: std::io::Error| format!("{}: {e}", path.display());
    let _ = fs::remove_dir_all(&new);
    fs::create_dir_all(&new).map_err(|e| fail(&new, e))?;
    let bind = ["run", "--quiet", "--package", "cullet-bindgen", "--"];
    let (wasm, out) = (wasm.to_string_lossy(), new.to_string_lossy());
    cargo(&[&bind[..], &[&wasm, &out]].concat())?;
    let sources = root().join(SOURCES);
    for entry in fs::read_dir(&sources).map_err(|e| fail(&sources, e))?.flatten() {
        let path = entry.path();
        if path.is_file() {
            fs::copy(&path, new.join(entry.file_name())).map_err(|e| fail(&path, e))?;
        }
    }
    let mut total = 0;
    let files: Vec<PathBuf> =
        fs::read_dir(&new).map_err(|e| fail(&new, e))?.flatten().map(|e| e.path()).collect();
    for path in files {
        let (plain, small) = compress(&path).map_err(|e| fail(&path, e))?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        println!("{name:24} {plain:9} bytes, {small:8} compressed");
        total += small;
    }
    if total > MAX_COMPRESSED {
        return Err(format!(
            "the page has {total} bytes compressed; at most {MAX_COMPRESSED} are allowed"
        ));
    }
    let old = page();
    let _ = fs::remove_dir_all(&old);
    fs::rename(&new, &old).map_err(|e| fail(&old, e))?;
    println!(
        "{}: {total} bytes compressed, built in {:.0} s",
        old.display(),
        start.elapsed().as_secs_f64()
    );
    Ok(())
}

/// Writes `NAME.gz` beside a file; returns the sizes of both.
fn compress(path: &Path) -> std::io::Result<(u64, u64)> {
    let bytes = fs::read(path)?;
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder.write_all(&bytes)?;
    let small = encoder.finish()?;
    let mut name = path.as_os_str().to_owned();
    name.push(".gz");
    fs::write(name, &small)?;
    Ok((bytes.len() as u64, small.len() as u64))
}

/// Compiles the viewer for the page; returns the module's path.
fn compile() -> Result<PathBuf, String> {
    // Apart from the native one: another compiler may be at work here.
    let folder = root().join("target/wasm");
    let mut words = vec!["build", "--lib", "--package", "cullet-viewer", "--profile", "web"];
    words.extend(["--target", TARGET]);
    let mut build = if let Compiler::Rustup = compiler()? {
        command(&cargo_program(), &words)
    } else {
        println!("no installed {TARGET}: the standard library is compiled with Debian's rustc-web");
        words.push("-Zbuild-std=std,panic_abort");
        let mut build = command("/usr/bin/cargo", &words);
        build.env("RUSTC", "/usr/bin/rustc").env("RUSTC_BOOTSTRAP", "1");
        build.env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER", linker()?);
        build
    };
    build.env("CARGO_TARGET_DIR", &folder);
    build.env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS", "-Ctarget-feature=+simd128");
    run(build)?;
    Ok(folder.join(TARGET).join("web/cullet_viewer.wasm"))
}

enum Compiler {
    Rustup,
    Debian,
}

/// Finds a compiler for wasm, or installs one where that needs no password.
fn compiler() -> Result<Compiler, String> {
    if let Some(compiler) = installed() {
        return Ok(compiler);
    }
    if output("rustup", &["target", "add", TARGET]).is_none() {
        install(DEBIAN)?;
    }
    installed()
        .ok_or_else(|| format!("there is no compiler for {TARGET}: rustup target add {TARGET}"))
}

/// The compiler for wasm that is there.
fn installed() -> Option<Compiler> {
    let library = output("rustc", &["--print", "target-libdir", "--target", TARGET]);
    if library.is_some_and(|l| Path::new(l.trim()).is_dir()) {
        return Some(Compiler::Rustup);
    }
    let sysroot = output("/usr/bin/rustc", &["--print", "sysroot"])?;
    let source = Path::new(sysroot.trim()).join("lib/rustlib/src/rust/library");
    let is_there = source.is_dir() && Path::new("/usr/bin/cargo").is_file();
    is_there.then_some(Compiler::Debian)
}

/// Debian ships no linker for wasm with its compiler: rustup's, or that of a package `lld-NN`.
fn linker() -> Result<PathBuf, String> {
    let line = |args: &[&str]| output("rustc", args).unwrap_or_default();
    let version = line(&["-vV"]);
    let host = version.lines().find_map(|l| l.strip_prefix("host: ")).unwrap_or_default();
    let sysroot = line(&["--print", "sysroot"]);
    let own = Path::new(sysroot.trim()).join("lib/rustlib").join(host).join("bin/rust-lld");
    if own.is_file() {
        return Ok(own);
    }
    // The newest: one that is older than the compiler does not read what it writes.
    let mut found: Vec<(u32, PathBuf)> = fs::read_dir("/usr/bin")
        .into_iter()
        .flatten()
        .flatten()
        .filter_map(|e| {
            let name = e.file_name().into_string().ok()?;
            Some((name.strip_prefix("wasm-ld-")?.parse().ok()?, e.path()))
        })
        .collect();
    found.sort();
    let newest = found.pop().map(|(_, path)| path);
    newest.ok_or_else(|| "there is no linker for wasm: apt-get install lld-22".to_owned())
}

/// What the page is tested with beside the browser.
const NODE: &[&str] = &["nodejs", "npm"];
/// Playwright's oldest.
const OLDEST_NODE: u32 = 20;
const BROWSER: &str = "/usr/bin/chromium";

/// The step of `test`: the page is built, and used in a browser as a user would.
pub(crate) fn test() -> Done {
    let Some(mut node) = in_browser("page.mjs", "the page is not tested here")? else {
        return Ok(());
    };
    node.args([served(), page()]);
    run(node)
}

/// Draws a picture of the page with a scene in a state.
pub(crate) fn picture(scene: &str, state: &str, out: &Path) -> Done {
    let Some(mut node) = in_browser("picture.mjs", "the page's picture is as it was")? else {
        return Ok(());
    };
    node.args([served(), page()]).args([scene, state]).arg(out);
    run(node)
}

/// The server that scripts start.
fn served() -> PathBuf {
    root().join("target/checked/cullet-serve")
}

/// Builds the page and its server, and readies a script that uses them in a browser; `None` where that cannot be
/// had, once `skipped` and the reason are said.
fn in_browser(script: &str, skipped: &str) -> Result<Option<Command>, String> {
    let browser = std::env::var("CHROMIUM").unwrap_or_else(|_| BROWSER.to_owned());
    if !is_ci() {
        let no_tools = !has_node() || !Path::new(&browser).is_file();
        if no_tools || installed().is_none() {
            let words = install_words(&[NODE, &["chromium"], DEBIAN].concat());
            println!("skipped: {skipped}; {words}");
            return Ok(None);
        }
    }
    if let Err(e) = prepare(&browser) {
        // What cannot be had here is no failure of the page, unless it was said to be one.
        if std::env::var_os("CULLET_REQUIRE_WEB").is_some() {
            return Err(e);
        }
        println!("skipped: {skipped}; {e}");
        return Ok(None);
    }
    build()?;
    cargo(&["build", "--package", "cullet-serve", "--profile", "checked"])?;
    let tests = root().join(SOURCES).join("tests");
    let mut fetch = command("npm", &["ci", "--no-audit", "--no-fund"]);
    fetch.current_dir(&tests);
    run(fetch)?;
    let mut node = command("node", &[script]);
    node.env("CHROMIUM", browser).current_dir(&tests);
    Ok(Some(node))
}

/// Installs what is missing of node, the browser and the compiler.
fn prepare(browser: &str) -> Done {
    if !has_node() {
        install(NODE)?;
        if !has_node() {
            return Err(format!("needed: npm, and node of version {OLDEST_NODE} or newer"));
        }
    }
    if !Path::new(browser).is_file() {
        if browser != BROWSER {
            return Err(format!("{browser}: there is no such browser; it is what CHROMIUM says"));
        }
        install(&["chromium"])?;
    }
    compiler().map(|_| ())
}

fn has_node() -> bool {
    let version = output("node", &["--version"]).unwrap_or_default();
    let major = version.trim().trim_start_matches('v').split('.').next();
    let is_new = major.and_then(|m| m.parse::<u32>().ok()).is_some_and(|m| m >= OLDEST_NODE);
    is_new && output("npm", &["--version"]).is_some()
}
