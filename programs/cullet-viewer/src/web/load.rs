//! Loading on a page: files are fetched, parsed in a worker that keeps the scene, and unpacked
//! between pictures.

use std::cell::RefCell;
use std::sync::Arc;

use cullet_io::Model;
use js_sys::{Array, Object, Promise, Reflect, Uint8Array};
use wasm_bindgen::prelude::*;
use wasm_bindgen_futures::{JsFuture, spawn_local};
use web_sys::{MessageEvent, Response, Worker, WorkerOptions, WorkerType};

use super::worker::{Keeper, thrown};
use crate::bytes::UnpackError;
use crate::measures::Measures;
use crate::packed::{Unpacker, pack};
use crate::state::Alteration;
use crate::task::{SLICE, Task, clock};
use crate::world::{Source, World};

/// Begins to load a scene; `wake` is called when it is there or cannot be had. A path is an address
/// of the server that the page came from (`/scene/model.glb`).
pub(crate) fn load(source: Source, wake: impl FnOnce() + 'static) -> Task<Result<World, String>> {
    let (send, task) = Task::waiting();
    spawn_local(async move {
        // Nobody listens any more when the user has gone on to something else.
        let _ = send.send(world(source).await);
        wake();
    });
    task
}

async fn world(source: Source) -> Result<World, String> {
    let name = source.name();
    if crate::examples::is_example(&name) {
        // The page makes it and decides about it: levels and sets do not go from a worker to the
        // page.
        return World::load(&source);
    }
    let (file, files) = match source {
        Source::Builtin(text) => (text, None),
        Source::Bytes { name, bytes, beside } => {
            let files = Array::new();
            for (name, bytes) in std::iter::once((name.clone(), bytes)).chain(beside) {
                files.push(&given(&name, &Uint8Array::from(&bytes[..])));
            }
            (name, Some(files))
        }
        Source::File(path) => {
            let address = path.to_string_lossy().into_owned();
            let bytes = fetch(&address).await.map_err(|e| format!("{address}: {e}"))?;
            (address.clone(), Some(Array::of1(&given(&address, &bytes))))
        }
    };
    let (packed, keeper) = in_worker(&file, files.as_ref()).await?;
    let (model, measures) = unpack(packed).await.map_err(|e| format!("{file}: {e}"))?;
    Ok(World { keeper: Some(Arc::new(keeper)), ..World::measured(model, name, measures) })
}

/// Begins to make a scene again with other sides or doors, as [`World::altered`] does at once;
/// `wake` is called when it is there. Its worker declares them too, with the first request that
/// tells of them.
pub(crate) fn remake(
    whole: Arc<World>,
    wanted: Alteration,
    wake: impl FnOnce() + 'static,
) -> Task<Result<World, String>> {
    let (send, task) = Task::waiting();
    spawn_local(async move {
        let made = unpack(pack(&whole.model)).await;
        // Nobody listens any more when the user has gone on to something else.
        let _ =
            send.send(made.and_then(|(model, _)| whole.again(model, wanted.sides, &wanted.doors)));
        wake();
    });
    task
}

/// The bytes at an address of the page's own server.
async fn fetch(address: &str) -> Result<Uint8Array, String> {
    // A link must not make the page read from elsewhere.
    if !address.starts_with("/scene/") {
        return Err("a page opens no files by path: drop the file on it, or serve it with \
                    'cullet serve FILE'"
            .to_owned());
    }
    let window = web_sys::window().ok_or("there is no window")?;
    let encoded: String = js_sys::encode_uri(address).into();
    let response = JsFuture::from(window.fetch_with_str(&encoded)).await.map_err(thrown)?;
    let response: Response = response.dyn_into().map_err(thrown)?;
    if !response.ok() {
        return Err(format!("the server answers {} {}", response.status(), response.status_text()));
    }
    let buffer = JsFuture::from(response.array_buffer().map_err(thrown)?).await.map_err(thrown)?;
    Ok(Uint8Array::new(&buffer))
}

/// A file as the worker takes it: its name and its bytes.
fn given(name: &str, bytes: &Uint8Array) -> Array {
    Array::of2(&name.into(), bytes)
}

/// Parses the first of some files, or makes a built-in scene where there are none, in a worker of
/// its own: a fault in it harms nobody. Returns the packed scene, and the worker that keeps it too.
async fn in_worker(file: &str, files: Option<&Array>) -> Result<(Vec<u8>, Keeper), String> {
    let options = WorkerOptions::new();
    options.set_type(WorkerType::Module);
    let keeper = Keeper(Worker::new_with_options("./worker.js", &options).map_err(thrown)?);
    let worker = keeper.worker();
    let answer = Promise::new(&mut |done, failed| {
        worker.set_onmessage(Some(&done));
        worker.set_onerror(Some(&failed));
    });
    let message = Object::new();
    let set = |name: &str, value: &JsValue| Reflect::set(&message, &name.into(), value);
    // The code is compiled already; only its memory is new.
    set("module", &wasm_bindgen::module()).map_err(thrown)?;
    set("name", &file.into()).map_err(thrown)?;
    let carried = Array::new();
    if let Some(files) = files {
        set("files", files).map_err(thrown)?;
        for file in files.iter() {
            carried.push(&Uint8Array::new(&Array::from(&file).get(1)).buffer());
        }
    }
    let sent = worker.post_message_with_transfer(&message, &carried);
    let answered = match sent {
        Ok(()) => JsFuture::from(answer).await,
        Err(e) => Err(e),
    };
    let event: MessageEvent = answered
        .map_err(|e| {
            let why = thrown(e);
            format!("{file}: loading it broke off ({why}); it may need more memory than a page has")
        })?
        .dyn_into()
        .map_err(thrown)?;
    match event.data().dyn_into::<Uint8Array>() {
        Ok(packed) => Ok((copied(&packed).await, keeper)),
        // The error of the file names it.
        Err(error) => Err(thrown(error)),
    }
}

/// Bytes of the browser's in the program's memory, copied a little at a time.
async fn copied(from: &Uint8Array) -> Vec<u8> {
    const BLOCK: usize = 4 << 20;
    let len = from.length() as usize;
    let mut bytes = Vec::with_capacity(len);
    let mut begun = clock();
    while bytes.len() < len {
        let at = bytes.len();
        let end = (at + BLOCK).min(len);
        bytes.resize(end, 0);
        from.subarray(at as u32, end as u32).copy_to(&mut bytes[at..]);
        if clock() - begun > SLICE {
            pause().await;
            begun = clock();
        }
    }
    bytes
}

async fn unpack(packed: Vec<u8>) -> Result<(Model, Measures), String> {
    let mut unpacker = Unpacker::new(packed).map_err(|e| e.to_string())?;
    let mut begun = clock();
    while unpacker.step().map_err(|e| e.to_string())? {
        if clock() - begun > SLICE {
            pause().await;
            begun = clock();
        }
    }
    let measures = unpacker.measures();
    Ok((unpacker.finish().map_err(|e| e.to_string())?, measures))
}

/// Lets the page do what else there is to do.
async fn pause() {
    let later = Promise::new(&mut |done, _| {
        if let Some(window) = web_sys::window() {
            // Without a timer the promise would never be kept; a window always has them.
            let _ = window.set_timeout_with_callback(&done);
        }
    });
    let _ = JsFuture::from(later).await;
}

thread_local! {
    /// In the worker: the scene as the page was given it, until it is [kept](keep).
    static PACKED: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
}

/// A model as bytes, for the page and for the worker itself.
fn hand_over(model: Model) -> Uint8Array {
    let packed = pack(&model);
    // The page's own follows: there need not be three.
    drop(model);
    let bytes = Uint8Array::from(&packed[..]);
    PACKED.set(packed);
    bytes
}

/// The worker's part when the page has its bytes: unpacks the same, so that slots are those of the
/// page, and keeps the scene to decide about.
///
/// # Errors
/// If nothing was packed, as text.
#[wasm_bindgen]
#[expect(unreachable_pub, reason = "the worker's script calls it")]
pub fn keep() -> Result<(), JsValue> {
    let refused = |e: UnpackError| JsValue::from_str(&e.to_string());
    let unpacker = Unpacker::new(PACKED.take()).map_err(refused)?;
    let measures = unpacker.measures();
    let model = unpacker.finish().map_err(refused)?;
    crate::decide::keep(World::measured(model, String::new(), measures));
    Ok(())
}

/// The worker's part: files, each its name and its bytes, to a packed model of the first, which may
/// name the others.
///
/// # Errors
/// As a file's loading has them, as text.
#[wasm_bindgen]
#[expect(unreachable_pub, reason = "the page's script calls it")]
pub fn parse(files: &Array) -> Result<Uint8Array, JsValue> {
    console_error_panic_hook::set_once();
    let mut files: Vec<(String, Vec<u8>)> = files
        .iter()
        .map(|file| {
            let file = Array::from(&file);
            let name = file.get(0).as_string().unwrap_or_default();
            (name, Uint8Array::new(&file.get(1)).to_vec())
        })
        .collect();
    if files.is_empty() {
        return Err(JsValue::from_str("there is no file to read"));
    }
    let beside = files.split_off(1);
    let (name, bytes) = &files[0];
    // The file's own name, not the address it was fetched from.
    let name = name.rsplit('/').next().unwrap_or(name);
    cullet_maps::load_bytes_with(name, bytes, &beside, &cullet_io::LoadOptions::default())
        .map(hand_over)
        .map_err(|e| JsValue::from_str(&e.to_string()))
}

/// The worker's part before: paths of the files that a model names, from its folder; none where
/// that cannot be told, for [`parse`] tells why.
#[wasm_bindgen]
#[must_use]
#[expect(unreachable_pub, reason = "the page's script calls it")]
pub fn named(name: &str, bytes: &[u8]) -> Vec<String> {
    let files = cullet_io::files_named_in(name, bytes).unwrap_or_default();
    files.iter().filter_map(|file| Some(file.to_str()?.to_owned())).collect()
}

/// The worker's part for a built-in scene: its text to a packed model.
///
/// # Errors
/// As [`cullet_scenes::build`] has them, as text.
#[wasm_bindgen]
#[expect(unreachable_pub, reason = "the page's script calls it")]
pub fn build(scene: &str) -> Result<Uint8Array, JsValue> {
    console_error_panic_hook::set_once();
    cullet_scenes::build(scene).map(hand_over).map_err(|e| JsValue::from_str(&e.to_string()))
}
