//! The page: built with wasm, bound to JavaScript, compressed, measured, served and tested in a
//! browser.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use flate2::Compression;
use flate2::write::GzEncoder;

use crate::checked;
use crate::compiler::{self, Compiler, wasm_linker};
use crate::graphics;
use crate::runner::{End, Ended, Skip, all};
use crate::tools::{
    Done, apart, cargo, cargo_program, command, install, install_words, is_ci, output, root, run,
    target,
};

const TARGET: &str = "wasm32-unknown-unknown";
/// Limit on the compressed size of the page: it should load in some seconds over an ordinary line.
const MAX_COMPRESSED: u64 = 4 << 20;
/// Sources of the page, from the root; what is in `tests` is none of it.
const SOURCES: &str = "programs/cullet-viewer/web";

/// Data that the page of lectures shows, from the root.
const LECTURES: &str = "docs/lectures.json";

/// Where the page is built, and where `cullet-serve` finds it.
pub(crate) fn page() -> PathBuf {
    target().join("page")
}

/// Builds the page and serves it, with `scene` if there is one.
pub(crate) fn serve(scene: Option<&str>) -> Done {
    build()?;
    run(command(&server()?.to_string_lossy(), scene.as_slice()))
}

/// The program that serves it, built without the viewer, as `cullet serve` does.
fn server() -> Result<PathBuf, String> {
    let words =
        ["build", "--quiet", "--release", "--package", "cullet-viewer", "--bin", "cullet-serve"];
    cargo(&[&words[..], &["--no-default-features", "--features", "serve"]].concat())?;
    Ok(target().join("release/cullet-serve"))
}

/// Builds the page into its folder, which is replaced as a whole once everything is there.
pub(crate) fn build() -> Done {
    let start = Instant::now();
    let wasm = compile(&["--package", "cullet-viewer", "--lib"])?.join("cullet_viewer.wasm");
    let new = target().join("page.new");
    let fail = |path: &Path, e: std::io::Error| format!("{}: {e}", path.display());
    let _ = fs::remove_dir_all(&new);
    fs::create_dir_all(&new).map_err(|e| fail(&new, e))?;
    bind(&wasm, &new)?;
    let sources = root().join(SOURCES);
    for entry in fs::read_dir(&sources).map_err(|e| fail(&sources, e))?.flatten() {
        let path = entry.path();
        if path.is_file() {
            fs::copy(&path, new.join(entry.file_name())).map_err(|e| fail(&path, e))?;
        }
    }
    let lectures = root().join(LECTURES);
    fs::copy(&lectures, new.join("lectures.json")).map_err(|e| fail(&lectures, e))?;
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

/// Compiles libraries for a browser; returns the folder with their modules.
fn compile(what: &[&str]) -> Result<PathBuf, String> {
    let folder = apart("wasm");
    let compiler = Compiler::get(TARGET)?;
    let words = [&["build", "--profile", "web"], what].concat();
    let mut build = compiler.cargo(&words, TARGET, &folder);
    if let Compiler::Debian = compiler {
        build.env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER", wasm_linker()?);
    }
    build.env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS", "-Ctarget-feature=+simd128");
    run(build)?;
    Ok(folder.join(TARGET).join("web"))
}

/// Writes a module into a folder, and the JavaScript that loads it.
fn bind(wasm: &Path, out: &Path) -> Done {
    let words =
        ["run", "--quiet", "--package", "xtask", "--features", "bindgen", "--bin", "bindgen"];
    let mut bind = command(&cargo_program(), &words);
    bind.arg("--").args([wasm, out]).env("CARGO_TARGET_DIR", apart("bindgen"));
    run(bind)
}

/// Packages that tests in JavaScript need.
const NODE: &[&str] = &["nodejs", "npm"];
/// Playwright's oldest.
const OLDEST_NODE: u32 = 20;
const BROWSER: &str = "/usr/bin/chromium";

/// The step of `test`: the page is built, and used in a browser as a user would.
pub(crate) fn test() -> Ended {
    match in_browser("page.mjs", "the page, built and used in a browser")? {
        Ok(node) => all(run(node)),
        Err(skip) => Ok(End::Skipped(skip)),
    }
}

/// The step of `test`: the passes of cullet-gpu list in a browser what the CPU lists natively, to
/// the byte.
pub(crate) fn lists() -> Ended {
    let what = "lists of the browser's device, held against the CPU's";
    let browser = match browser(what)? {
        Ok(browser) => browser,
        Err(skip) => return Ok(End::Skipped(skip)),
    };
    // With the page, whose features of its dependencies are more: these are built once.
    let both = ["--package", "cullet-viewer", "--package", "cullet-gpu", "--lib"];
    let folder = compile(&[&both[..], &["--example", "lists_page"]].concat())?;
    let out = target().join("lists");
    bind(&folder.join("examples/lists_page.wasm"), &out)?;
    let program = checked::examples_folder()?.join("lists");
    let answers = out.join("answers.txt");
    let mut first = None;
    for backend in ["vulkan", "gl"] {
        let fail = |e: std::io::Error| format!("{}: {e}", answers.display());
        let mut native = command(&program.to_string_lossy(), &[]);
        // OpenGL may be absent: then the CPU alone lists.
        if backend == "vulkan" && graphics::is_there() && is_ci() {
            native.env("CULLET_REQUIRE_GPU", "1");
        }
        native.env("WGPU_BACKEND", backend).stdout(fs::File::create(&answers).map_err(fail)?);
        run(native)?;
        let text = fs::read_to_string(&answers).map_err(fail)?;
        if first.get_or_insert_with(|| text.clone()) != &text {
            return Err(format!("lists made with {backend} differ from those made with vulkan"));
        }
    }
    match script(&format!("{SOURCES}/tests"), "lists.mjs", what)? {
        Ok(mut node) => {
            node.env("CHROMIUM", browser).args([out, answers]);
            all(run(node))
        }
        Err(skip) => Ok(End::Skipped(skip)),
    }
}

/// Draws a picture of the page with a scene in a state.
pub(crate) fn picture(scene: &str, state: &str, out: &Path) -> Done {
    match in_browser("picture.mjs", "the page's picture")? {
        Ok(mut node) => {
            node.args([scene, state]).arg(out);
            run(node)
        }
        Err(skip) => {
            println!("skipped: {} is as it was; {}", skip.what, skip.cure);
            Ok(())
        }
    }
}

/// Builds the page and its server, and readies a script that uses them in a browser, or says what
/// is skipped where that cannot be had.
fn in_browser(script: &str, what: &str) -> Result<Result<Command, Skip>, String> {
    let browser = match browser(what)? {
        Ok(browser) => browser,
        Err(skip) => return Ok(Err(skip)),
    };
    build()?;
    let serve = server()?;
    let node = self::script(&format!("{SOURCES}/tests"), script, what)?;
    Ok(node.map(|mut node| {
        node.env("CHROMIUM", browser).args([serve, page()]);
        node
    }))
}

/// The browser, where node and a compiler for it are there too; in CI they are installed.
pub(crate) fn browser(what: &str) -> Result<Result<String, Skip>, String> {
    let browser = std::env::var("CHROMIUM").unwrap_or_else(|_| BROWSER.to_owned());
    if !is_ci() {
        let no_tools = !has_node() || !Path::new(&browser).is_file();
        if no_tools || Compiler::installed(TARGET).is_none() {
            let words = install_words(&[NODE, &["chromium"]].concat());
            let cure = format!("{words}; {}", compiler::words(TARGET));
            return Ok(Err(Skip::new(what, cure)));
        }
    }
    if let Err(e) = prepare(&browser) {
        // A missing tool is no failure of what it is needed for, unless it is required.
        if std::env::var_os("CULLET_REQUIRE_WEB").is_some() {
            return Err(e);
        }
        return Ok(Err(Skip::new(what, e)));
    }
    Ok(Ok(browser))
}

/// Installs what is missing of node, the browser and the compiler.
fn prepare(browser: &str) -> Done {
    need_node()?;
    if !Path::new(browser).is_file() {
        if browser != BROWSER {
            return Err(format!("{browser}: there is no such browser; it is what CHROMIUM says"));
        }
        install(&["chromium"])?;
    }
    Compiler::get(TARGET).map(|_| ())
}

/// Installs node and npm where they are missing.
fn need_node() -> Done {
    if !has_node() {
        install(NODE)?;
        if !has_node() {
            return Err(format!("needed: npm, and node of version {OLDEST_NODE} or newer"));
        }
    }
    Ok(())
}

/// A script in a folder of the repository whose packages npm has fetched, of the versions that its
/// list names; or what is skipped where node is missing, which in CI is installed.
pub(crate) fn script(
    folder: &str,
    script: &str,
    what: &str,
) -> Result<Result<Command, Skip>, String> {
    if is_ci() {
        need_node()?;
    } else if !has_node() {
        return Ok(Err(Skip::new(what, install_words(NODE))));
    }
    let folder = root().join(folder);
    let mut fetch = command("npm", &["ci", "--no-audit", "--no-fund"]);
    fetch.current_dir(&folder);
    run(fetch)?;
    let mut node = command("node", &[script]);
    node.current_dir(folder);
    Ok(Ok(node))
}

fn has_node() -> bool {
    let version = output("node", &["--version"]).unwrap_or_default();
    let major = version.trim().trim_start_matches('v').split('.').next();
    let is_new = major.and_then(|m| m.parse::<u32>().ok()).is_some_and(|m| m >= OLDEST_NODE);
    is_new && output("npm", &["--version"]).is_some()
}
