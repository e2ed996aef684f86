//! Files that are served: the page's and a scene's.

use std::collections::BTreeMap;
use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io;
use std::path::{Path, PathBuf};

use bytes::Bytes;
use cullet_io::files_named;
use thiserror::Error;

/// Where a scene's file is found by the page: `/scene/NAME`; and beside it the files that it names.
pub(crate) const SCENE_FOLDER: &str = "/scene/";

/// Help where there is no page.
pub(crate) const PAGE_HELP: &str =
    "build it with 'cargo xtask web --no-serve', or name its folder with --page";

/// A page larger than this is none of ours; it is held in memory.
const MAX_PAGE_BYTES: u64 = 64 << 20;

/// Types by ending; a file of another ending is not part of a page.
const TYPES: &[(&str, &str)] = &[
    ("html", "text/html; charset=utf-8"),
    ("js", "text/javascript; charset=utf-8"),
    ("css", "text/css; charset=utf-8"),
    ("wasm", "application/wasm"),
    ("json", "application/json"),
    ("svg", "image/svg+xml"),
    ("png", "image/png"),
    ("txt", "text/plain; charset=utf-8"),
];

/// Types of scenes; any other is `application/octet-stream`.
const SCENE_TYPES: &[(&str, &str)] = &[
    ("glb", "model/gltf-binary"),
    ("gltf", "model/gltf+json"),
    ("obj", "model/obj"),
    ("mtl", "model/mtl"),
    ("stl", "model/stl"),
];

/// Why nothing can be served.
#[derive(Debug, Error)]
#[non_exhaustive]
pub(crate) enum SiteError {
    /// The folder of the page has no `index.html`.
    #[error("{}: there is no page (index.html) in this folder; {PAGE_HELP}", .0.display())]
    NoPage(PathBuf),
    /// No folder was named, and none was found.
    #[error("the viewer's page is not built: looked in {looked}; {PAGE_HELP}")]
    NotFound {
        /// Where it was looked for.
        looked: String,
    },
    /// The page's files are larger than a page can be.
    #[error("{}: the files come to {bytes} bytes; a page has at most {MAX_PAGE_BYTES}", .folder.display())]
    TooLarge {
        /// The folder.
        folder: PathBuf,
        /// Their size so far.
        bytes: u64,
    },
    /// Neither a file nor a built-in scene.
    #[error("{0}")]
    NoScene(String),
    /// A scene that cannot be had.
    #[error("{scene}: {error}")]
    Scene {
        /// The requested scene.
        scene: String,
        /// Why it cannot be had, and what can.
        error: String,
    },
    /// Something cannot be read.
    #[error("{}: cannot be read: {error}", .path.display())]
    Read {
        /// File or folder that cannot be read.
        path: PathBuf,
        /// Why.
        error: io::Error,
    },
}

/// One file of the page.
#[derive(Debug)]
pub(crate) struct PageFile {
    pub(crate) kind: &'static str,
    pub(crate) bytes: Bytes,
    /// The same with gzip, where the page has it.
    pub(crate) gzip: Option<Bytes>,
    /// Changes with the content.
    pub(crate) tag: u64,
}

/// A scene's file, or one that it names.
#[derive(Debug)]
pub(crate) struct SceneFile {
    pub(crate) path: PathBuf,
    pub(crate) kind: &'static str,
}

/// Files that are served: the page's, read into memory, and at most one scene with the files that
/// it names.
#[derive(Debug)]
pub(crate) struct Site {
    pub(crate) page: BTreeMap<String, PageFile>,
    /// Files of the scene by their names in the address, not encoded.
    pub(crate) scene: BTreeMap<String, SceneFile>,
    warnings: Vec<String>,
    fragment: String,
}

impl Site {
    /// The page in `page`, and a scene: a file, or the text of a built-in scene (`city:seed=3`). Of
    /// the folder, ordinary files with the endings of a page are served (html, js, css, wasm, json,
    /// svg, png, txt); links, folders and hidden files are not. Changes made later are not seen.
    ///
    /// Of what a scene names (buffers of a glTF, material libraries of an OBJ), ordinary files are
    /// served that lie in its folder or below, wherever links lead; a scene that cannot be read is
    /// served alone, for the page tells why.
    ///
    /// # Errors
    /// If the page or the scene is not there or cannot be read.
    pub(crate) fn new(page: &Path, scene: Option<&str>) -> Result<Self, SiteError> {
        let page = read_page(page)?;
        let mut site =
            Self { page, scene: BTreeMap::new(), warnings: Vec::new(), fragment: String::new() };
        let Some(text) = scene else { return Ok(site) };
        let path = Path::new(text);
        // A file wins over a built-in scene of that name, as for every command.
        let named = if !path.exists() && cullet_scenes::is_builtin(text) {
            cullet_scenes::build(text).map_err(|e| no_scene(text, e.to_string()))?.name
        } else {
            let (name, scene) = scene_file(text, path)?;
            site.take_beside(path);
            let named = format!("{SCENE_FOLDER}{name}");
            site.scene.insert(name, scene);
            named
        };
        site.fragment = format!("#scene={}", escape(&named));
        Ok(site)
    }

    /// The fragment that follows the address of the page to open the scene: `#scene=city`,
    /// `#scene=/scene/model.glb`, or nothing where no scene was given.
    #[must_use]
    pub(crate) fn fragment(&self) -> &str {
        &self.fragment
    }

    /// Parts of the scene that the page cannot show: files that it names but that are not in its
    /// folder, or why it cannot be read at all.
    #[must_use]
    pub(crate) fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Serves what a scene names.
    fn take_beside(&mut self, scene: &Path) {
        let Some(folder) = scene.parent() else { return };
        let whole = |path: &Path| fs::canonicalize(path).ok();
        let home = whole(if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
        let Some(home) = home else { return };
        let named = files_named(scene).unwrap_or_else(|e| {
            self.warnings.push(e.to_string());
            Vec::new()
        });
        for file in named {
            // A name that is no text is in no address.
            let Some(name) = file.to_str().map(|n| n.replace('\\', "/")) else { continue };
            // Where it is after all links.
            match whole(&folder.join(&file)).filter(|p| p.starts_with(&home) && p.is_file()) {
                Some(path) => {
                    let kind = scene_kind(&name);
                    self.scene.insert(name, SceneFile { path, kind });
                }
                None => {
                    let scene = scene.display();
                    self.warnings.push(format!("{scene} names {name}, which is not in its folder"));
                }
            }
        }
    }
}

fn no_scene(scene: &str, error: String) -> SiteError {
    SiteError::Scene { scene: scene.to_owned(), error }
}

/// The name of a scene's file, and the file.
fn scene_file(text: &str, path: &Path) -> Result<(String, SceneFile), SiteError> {
    let read = |error| SiteError::Read { path: path.to_owned(), error };
    let meta = match fs::metadata(path) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => {
            return Err(SiteError::NoScene(cullet_scenes::no_such_file(text)));
        }
        meta => meta.map_err(read)?,
    };
    if meta.is_dir() {
        return Err(no_scene(text, "it is a folder; name a file in it".to_owned()));
    }
    if !meta.is_file() {
        return Err(no_scene(text, "it is not a regular file".to_owned()));
    }
    // Said now rather than as a picture that never comes.
    fs::File::open(path).map_err(read)?;
    let name = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let kind = scene_kind(&name);
    // Absolute, so that it stays right wherever the program goes.
    let path = fs::canonicalize(path).map_err(read)?;
    Ok((name, SceneFile { path, kind }))
}

fn scene_kind(name: &str) -> &'static str {
    let ending = ending(name);
    let kind = SCENE_TYPES.iter().find(|(e, _)| *e == ending);
    kind.map_or("application/octet-stream", |(_, kind)| kind)
}

fn ending(name: &str) -> String {
    name.rsplit_once('.').map_or_else(String::new, |(_, e)| e.to_ascii_lowercase())
}

fn read_page(folder: &Path) -> Result<BTreeMap<String, PageFile>, SiteError> {
    let read = |path: &Path, error| SiteError::Read { path: path.to_owned(), error };
    let mut files = BTreeMap::new();
    let mut total = 0;
    let entries = match fs::read_dir(folder) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => {
            return Err(SiteError::NoPage(folder.to_owned()));
        }
        entries => entries.map_err(|e| read(folder, e))?,
    };
    for entry in entries {
        let entry = entry.map_err(|e| read(folder, e))?;
        // The entry's own kind, not that of what a link leads to.
        let kind = entry.file_type().map_err(|e| read(&entry.path(), e))?;
        let Ok(name) = entry.file_name().into_string() else { continue };
        if !kind.is_file() || name.starts_with('.') {
            continue;
        }
        total += entry.metadata().map_err(|e| read(&entry.path(), e))?.len();
        if total > MAX_PAGE_BYTES {
            return Err(SiteError::TooLarge { folder: folder.to_owned(), bytes: total });
        }
        let bytes = fs::read(entry.path()).map_err(|e| read(&entry.path(), e))?;
        files.insert(name, Bytes::from(bytes));
    }
    let mut page = BTreeMap::new();
    for (name, bytes) in &files {
        let ending = ending(name);
        let Some((_, kind)) = TYPES.iter().find(|(e, _)| *e == ending) else { continue };
        let gzip = files.get(&format!("{name}.gz")).cloned();
        let mut hasher = DefaultHasher::new();
        bytes.hash(&mut hasher);
        let tag = hasher.finish();
        page.insert(name.clone(), PageFile { kind, bytes: bytes.clone(), gzip, tag });
    }
    if !page.contains_key("index.html") {
        return Err(SiteError::NoPage(folder.to_owned()));
    }
    Ok(page)
}

/// The folder of the page where none is named: that of the variable `CULLET_PAGE`, `page` beside
/// the program or beside its folder (where a build puts the two), or `target/page` here.
///
/// # Errors
/// If none of them has an `index.html`; the message says where it was looked for and what to do.
pub(crate) fn find_page() -> Result<PathBuf, SiteError> {
    let mut looked: Vec<PathBuf> = Vec::new();
    if let Some(folder) = std::env::var_os("CULLET_PAGE") {
        looked.push(folder.into());
    } else {
        let exe = std::env::current_exe().ok();
        let beside = exe.as_deref().and_then(Path::parent);
        looked.extend(beside.map(|b| b.join("page")));
        looked.extend(beside.and_then(Path::parent).map(|b| b.join("page")));
        looked.push(Path::new("target").join("page"));
    }
    if let Some(found) = looked.iter().find(|p| p.join("index.html").is_file()) {
        return Ok(found.clone());
    }
    let looked: Vec<String> = looked.iter().map(|p| p.display().to_string()).collect();
    Err(SiteError::NotFound { looked: looked.join(", ") })
}

/// A text as part of an address, by percent signs where a byte could be read as something else.
fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for b in text.bytes() {
        if b.is_ascii_alphanumeric() || b"-_.~:,/".contains(&b) {
            out.push(char::from(b));
        } else {
            out.push_str(&format!("%{b:02X}"));
        }
    }
    out
}
