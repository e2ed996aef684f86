//! Functions that the page calls. Objects are passed by number; addresses only go out.
#![allow(
    unsafe_code,
    reason = "names are exported by an attribute that counts as unsafe: no two of one name may be"
)]

use alloc::vec::Vec;

use spin::Mutex;

use crate::boxes::BoxSet;
use crate::fault::has_room;

/// Objects under numbers from 1.
struct Slab<T>(Vec<Option<T>>);

impl<T> Slab<T> {
    fn add(&mut self, object: T) -> u32 {
        let free = self.0.iter().position(Option::is_none);
        let at = free.unwrap_or_else(|| {
            self.0.push(None);
            self.0.len() - 1
        });
        self.0[at] = Some(object);
        at as u32 + 1
    }

    fn get(&mut self, number: u32) -> Option<&mut T> {
        self.0.get_mut((number as usize).wrapping_sub(1))?.as_mut()
    }

    fn free(&mut self, number: u32) {
        if let Some(object) = self.0.get_mut((number as usize).wrapping_sub(1)) {
            *object = None;
        }
    }
}

static BOXES: Mutex<Slab<BoxSet>> = Mutex::new(Slab(Vec::new()));
/// Buffer that the page writes arguments into. Its f64 elements align it for every type that is
/// read from it.
static SCRATCH: Mutex<Vec<f64>> = Mutex::new(Vec::new());
/// Address and length of the last answer.
static ANSWER: Mutex<[usize; 2]> = Mutex::new([0; 2]);

fn answer<T>(items: &[T]) {
    *ANSWER.lock() = [items.as_ptr() as usize, items.len()];
}

#[unsafe(no_mangle)]
extern "C" fn answer_at() -> usize {
    ANSWER.lock()[0]
}

#[unsafe(no_mangle)]
extern "C" fn answer_len() -> usize {
    ANSWER.lock()[1]
}

/// The address of at least `bytes` to write arguments into, or 0.
#[unsafe(no_mangle)]
extern "C" fn scratch(bytes: usize) -> usize {
    let mut scratch = SCRATCH.lock();
    let len = bytes.div_ceil(8);
    if scratch.len() < len {
        if !has_room(bytes) {
            return 0;
        }
        scratch.resize(len, 0.0);
    }
    scratch.as_mut_ptr() as usize
}

/// A set of boxes, or 0 where memory does not suffice.
#[unsafe(no_mangle)]
extern "C" fn boxes_new(len: usize) -> u32 {
    BoxSet::new(len).map_or(0, |set| BOXES.lock().add(set))
}

#[unsafe(no_mangle)]
extern "C" fn boxes_free(set: u32) {
    BOXES.lock().free(set);
}

/// Calls `with` a set; 0 for one that is not there.
fn of_boxes(set: u32, with: impl FnOnce(&mut BoxSet) -> usize) -> usize {
    BOXES.lock().get(set).map_or(0, with)
}

#[unsafe(no_mangle)]
extern "C" fn boxes_at(set: u32) -> usize {
    of_boxes(set, |set| set.boxes_mut().as_mut_ptr() as usize)
}

/// The address of the matrices, or 0 where memory does not suffice.
#[unsafe(no_mangle)]
extern "C" fn boxes_matrices(set: u32) -> usize {
    of_boxes(set, |set| set.matrices_mut().map_or(0, |m| m.as_mut_ptr() as usize))
}

/// 1 where the range was there.
#[unsafe(no_mangle)]
extern "C" fn boxes_commit(set: u32, first: usize, count: usize, moved: u32) -> usize {
    of_boxes(set, |set| usize::from(set.commit(first, count, moved != 0)))
}

#[unsafe(no_mangle)]
extern "C" fn boxes_sort(set: u32) {
    of_boxes(set, |set| {
        set.sort();
        0
    });
}

/// Culls by the 24 numbers in the scratch; the answer is the list. 1 where there may be such a
/// view.
#[unsafe(no_mangle)]
extern "C" fn boxes_cull(set: u32, view: usize) -> usize {
    let planes = SCRATCH.lock().first_chunk::<24>().copied();
    let Some(planes) = planes else { return 0 };
    of_boxes(set, |set| {
        let done = set.cull(view, &planes);
        answer(set.visible(view));
        usize::from(done)
    })
}

#[unsafe(no_mangle)]
extern "C" fn boxes_forget(set: u32, view: usize) {
    of_boxes(set, |set| {
        set.forget(view);
        0
    });
}

#[cfg(feature = "occluders")]
mod occluders {
    use super::{ANSWER, BOXES, Mutex, SCRATCH, Slab, Vec, answer};
    use crate::occluders::{Occluders, Refusal};

    static OCCLUDERS: Mutex<Slab<Occluders>> = Mutex::new(Slab(Vec::new()));

    /// The number of an occluder; above those 2³² − 1 for no memory and 2³² − 2 for what is invalid.
    fn number(added: Option<Result<u32, Refusal>>) -> u32 {
        match added {
            Some(Ok(number)) => number,
            Some(Err(Refusal::Memory)) => u32::MAX,
            Some(Err(Refusal::Invalid)) | None => u32::MAX - 1,
        }
    }

    /// Occluders and their buffer, or 0 where memory does not suffice.
    #[unsafe(no_mangle)]
    extern "C" fn occluders_new(width: u32, height: u32) -> u32 {
        Occluders::new([width, height]).map_or(0, |all| OCCLUDERS.lock().add(all))
    }

    #[unsafe(no_mangle)]
    extern "C" fn occluders_free(all: u32) {
        OCCLUDERS.lock().free(all);
    }

    /// Six numbers of f32 lie in the scratch.
    #[unsafe(no_mangle)]
    extern "C" fn occluders_add_box(all: u32) -> u32 {
        let scratch = SCRATCH.lock();
        let corners = bytemuck::cast_slice(&scratch).first_chunk::<6>().copied();
        let mut sets = OCCLUDERS.lock();
        number(sets.get(all).zip(corners).map(|(all, corners)| all.add_box(corners)))
    }

    /// Positions of f32, three numbers each, and indices lie in the scratch.
    #[unsafe(no_mangle)]
    extern "C" fn occluders_add(all: u32, vertices: usize, indices: usize, two_sided: u32) -> u32 {
        let scratch = SCRATCH.lock();
        let (points, _) = bytemuck::cast_slice::<f64, f32>(&scratch).as_chunks::<3>();
        let words: &[u32] = bytemuck::cast_slice(&scratch);
        let (Some(points), Some(words)) =
            (points.get(..vertices), words.get(vertices * 3..vertices * 3 + indices))
        else {
            return u32::MAX - 1;
        };
        let mut sets = OCCLUDERS.lock();
        number(sets.get(all).map(|all| all.add_triangles(points, words, two_sided != 0)))
    }

    /// The matrix of f64 lies in the scratch. 1 where there is such an occluder.
    #[unsafe(no_mangle)]
    extern "C" fn occluders_place(all: u32, number: u32) -> u32 {
        let matrix = SCRATCH.lock().first_chunk::<16>().copied();
        let mut sets = OCCLUDERS.lock();
        let all = sets.get(all).zip(matrix);
        u32::from(all.is_some_and(|(all, matrix)| all.set_matrix(number, &matrix)))
    }

    /// 1 where there was such an occluder.
    #[unsafe(no_mangle)]
    extern "C" fn occluders_remove(all: u32, number: u32) -> u32 {
        u32::from(OCCLUDERS.lock().get(all).is_some_and(|all| all.remove(number)))
    }

    /// The matrix of f64 lies in the scratch. 1 where it shows a volume; the answer's length is the
    /// number of shapes that were drawn.
    #[unsafe(no_mangle)]
    extern "C" fn occluders_draw(all: u32, depth: u32) -> u32 {
        let matrix = SCRATCH.lock().first_chunk::<16>().copied();
        let mut sets = OCCLUDERS.lock();
        let drawn = sets.get(all).zip(matrix);
        let drawn = drawn.and_then(|(all, matrix)| all.draw(matrix, depth).ok());
        *ANSWER.lock() = [0, drawn.unwrap_or(0)];
        u32::from(drawn.is_some())
    }

    /// The answer is the list.
    #[unsafe(no_mangle)]
    extern "C" fn boxes_hide(set: u32, view: usize, occluders: u32) {
        let (mut sets, mut occluders_of) = (BOXES.lock(), OCCLUDERS.lock());
        if let Some((set, all)) = sets.get(set).zip(occluders_of.get(occluders)) {
            set.hide(view, all.buffer());
            answer(set.unhidden(view));
        }
    }
}

#[cfg(feature = "scene")]
mod scenes {
    #[cfg(feature = "queries")]
    mod queries;

    use alloc::string::String;

    use super::{ANSWER, Mutex, SCRATCH, Slab, Vec, answer};
    use crate::fault::{Code, Fault};
    use crate::scene::{Kind, SceneSet};
    use crate::view::{SceneView, Settings};

    static SCENES: Mutex<Slab<SceneSet>> = Mutex::new(Slab(Vec::new()));
    static VIEWS: Mutex<Slab<SceneView>> = Mutex::new(Slab(Vec::new()));
    static MESSAGE: Mutex<String> = Mutex::new(String::new());

    /// 0, or the code of a fault whose message is kept.
    fn ended(result: Result<(), Fault>) -> u32 {
        let Err(fault) = result else { return 0 };
        *MESSAGE.lock() = fault.message;
        fault.code as u32
    }

    /// The message of the last fault becomes the answer.
    #[unsafe(no_mangle)]
    extern "C" fn message() {
        answer(MESSAGE.lock().as_bytes());
    }

    /// That an object is there, which the page's own objects see to.
    fn there<T>(object: Option<&mut T>) -> Result<&mut T, Fault> {
        object.ok_or_else(|| Fault::new(Code::Id, "there is no such object"))
    }

    fn of_scene(number: u32, with: impl FnOnce(&mut SceneSet) -> Result<(), Fault>) -> u32 {
        ended(there(SCENES.lock().get(number)).and_then(with))
    }

    fn of_view(
        view: u32,
        scene: u32,
        with: impl FnOnce(&mut SceneView, &SceneSet) -> Result<(), Fault>,
    ) -> u32 {
        ended(
            there(SCENES.lock().get(scene))
                .and_then(|scene| with(there(VIEWS.lock().get(view))?, scene)),
        )
    }

    /// Hands out parts of the scratch that follow each other: so many numbers, then so many.
    fn with_scratch<R>(
        bytes: usize,
        with: impl FnOnce(&[u8]) -> Result<R, Fault>,
    ) -> Result<R, Fault> {
        let short = || Fault::new(Code::Argument, "the arguments are not all there");
        with(bytemuck::cast_slice(&SCRATCH.lock()).get(..bytes).ok_or_else(short)?)
    }

    #[unsafe(no_mangle)]
    extern "C" fn scene_new() -> u32 {
        SCENES.lock().add(SceneSet::new(cullet::Scene::new()))
    }

    #[unsafe(no_mangle)]
    extern "C" fn scene_free(scene: u32) {
        SCENES.lock().free(scene);
    }

    /// Positions, indices and rows of parts lie in the scratch; the answer's address is the mesh's
    /// number.
    #[unsafe(no_mangle)]
    extern "C" fn scene_add_mesh(
        scene: u32,
        positions: usize,
        indices: usize,
        parts: usize,
        kind: u32,
    ) -> u32 {
        of_scene(scene, |scene| {
            let [a, b] = [positions * 4, (positions + indices) * 4];
            let mesh = with_scratch((positions + indices + parts) * 4, |bytes| {
                let numbers = |bytes: &[u8]| bytemuck::cast_slice::<u8, u32>(bytes).to_vec();
                let points: &[f32] = bytemuck::cast_slice(&bytes[..a]);
                scene.add_mesh(points, &numbers(&bytes[a..b]), &numbers(&bytes[b..]), Kind(kind))
            })?;
            *ANSWER.lock() = [mesh as usize, 0];
            Ok(())
        })
    }

    /// `count` matrices of f64 lie in the scratch; the answer is the ids.
    #[unsafe(no_mangle)]
    extern "C" fn scene_add(scene: u32, mesh: u32, count: usize, layers: u32, flags: u32) -> u32 {
        of_scene(scene, |scene| {
            with_scratch(count * 128, |bytes| {
                scene.add(mesh, bytemuck::cast_slice(bytes), layers, flags)
            })?;
            answer(scene.ids());
            Ok(())
        })
    }

    /// `count` matrices of f64 lie in the scratch, then as many ids.
    #[unsafe(no_mangle)]
    extern "C" fn scene_set_transforms(scene: u32, count: usize) -> u32 {
        of_scene(scene, |scene| {
            with_scratch(count * 132, |bytes| {
                let (matrices, ids) = bytes.split_at(count * 128);
                scene.set_transforms(bytemuck::cast_slice(ids), bytemuck::cast_slice(matrices))
            })
        })
    }

    #[unsafe(no_mangle)]
    extern "C" fn scene_set_state(scene: u32, id: u32, layers: u32, flags: u32) -> u32 {
        of_scene(scene, |scene| scene.set_state(id, layers, flags))
    }

    #[unsafe(no_mangle)]
    extern "C" fn scene_remove(scene: u32, id: u32) -> u32 {
        of_scene(scene, |scene| scene.remove(id))
    }

    #[unsafe(no_mangle)]
    extern "C" fn scene_commit(scene: u32) -> u32 {
        of_scene(scene, |scene| {
            scene.commit();
            Ok(())
        })
    }

    #[unsafe(no_mangle)]
    extern "C" fn scene_refit(scene: u32) -> u32 {
        of_scene(scene, |scene| {
            scene.refit();
            Ok(())
        })
    }

    #[cfg(feature = "clusters")]
    #[unsafe(no_mangle)]
    extern "C" fn scene_set_place(
        scene: u32,
        mesh: u32,
        first_index: u32,
        base_vertex: i32,
    ) -> u32 {
        of_scene(scene, |scene| scene.set_place(mesh, first_index, base_vertex))
    }

    /// The answer is the mesh's indices.
    #[cfg(feature = "clusters")]
    #[unsafe(no_mangle)]
    extern "C" fn scene_indices(scene: u32, mesh: u32) -> u32 {
        of_scene(scene, |scene| scene.indices(mesh).map(answer))
    }

    /// 0: instances; 1: meshes; 2: triangles; 3: ids that there may be.
    #[unsafe(no_mangle)]
    extern "C" fn scene_count(scene: u32, of: u32) -> f64 {
        SCENES.lock().get(scene).map_or(0.0, |scene| match of {
            0 => f64::from(scene.scene().instance_count()),
            1 => scene.scene().meshes().len() as f64,
            2 => scene.scene().triangle_count() as f64,
            _ => scene.id_count() as f64,
        })
    }

    #[unsafe(no_mangle)]
    extern "C" fn view_new(preset: u32, output: u32, flags: u32, draw_us: f64) -> u32 {
        VIEWS.lock().add(SceneView::new(Settings { preset, output, flags, draw_us }))
    }

    #[unsafe(no_mangle)]
    extern "C" fn view_free(view: u32) {
        VIEWS.lock().free(view);
    }

    /// The matrix of f64 lies in the scratch.
    #[unsafe(no_mangle)]
    extern "C" fn view_set_camera(
        view: u32,
        depth: u32,
        width: u32,
        height: u32,
        layers: u32,
    ) -> u32 {
        let matrix = SCRATCH.lock().first_chunk::<16>().copied();
        ended(there(VIEWS.lock().get(view)).and_then(|view| {
            let missing = || Fault::new(Code::Argument, "there is no matrix");
            view.set_camera(matrix.ok_or_else(missing)?, depth, [width, height], layers)
        }))
    }

    /// The answer is the ids.
    #[unsafe(no_mangle)]
    extern "C" fn view_cull(view: u32, scene: u32) -> u32 {
        of_view(view, scene, |view, scene| {
            view.cull(scene)?;
            answer(view.ids());
            Ok(())
        })
    }

    #[cfg(feature = "clusters")]
    #[unsafe(no_mangle)]
    extern "C" fn view_triangles(view: u32) -> f64 {
        let count = |view: &mut SceneView| view.triangle_count() as f64;
        VIEWS.lock().get(view).map_or(0.0, count)
    }

    /// The answer is a byte for each id.
    #[cfg(feature = "clusters")]
    #[unsafe(no_mangle)]
    extern "C" fn view_reasons(view: u32, scene: u32) -> u32 {
        of_view(view, scene, |view, scene| {
            answer(view.reasons(scene)?);
            Ok(())
        })
    }

    /// Fills the draws, which `view_draws_of` then answers with.
    #[cfg(feature = "clusters")]
    #[unsafe(no_mangle)]
    extern "C" fn view_draws(view: u32, scene: u32) -> u32 {
        of_view(view, scene, SceneView::fill_draws)
    }

    /// Returns a filled array: 0 commands, 1 keys, 2 instances, 3 indices.
    #[cfg(feature = "clusters")]
    #[unsafe(no_mangle)]
    extern "C" fn view_draws_of(view: u32, which: u32) {
        if let Some(view) = VIEWS.lock().get(view) {
            let draws = view.draws();
            match which {
                0 => answer(&draws.commands),
                1 => answer(&draws.keys),
                2 => answer(&draws.instances),
                _ => answer(&draws.indices),
            }
        }
    }

    /// The answer is eight f64 a row.
    #[cfg(feature = "clusters")]
    #[unsafe(no_mangle)]
    extern "C" fn view_funnel(view: u32) -> u32 {
        ended(there(VIEWS.lock().get(view)).map(|view| answer(view.fill_funnel())))
    }

    /// The answer is text.
    #[cfg(feature = "clusters")]
    #[unsafe(no_mangle)]
    extern "C" fn view_explain(view: u32, scene: u32, id: u32) -> u32 {
        of_view(view, scene, |view, scene| {
            answer(view.explain(scene, id)?.as_bytes());
            Ok(())
        })
    }

    /// `name` bytes of a file's name lie in the scratch, then its `bytes`; the answer's address is
    /// the scene's number.
    #[cfg(feature = "files")]
    #[unsafe(no_mangle)]
    extern "C" fn file_open(name: usize, bytes: usize) -> u32 {
        let opened = with_scratch(name + bytes, |all| {
            crate::files::open(&String::from_utf8_lossy(&all[..name]), &all[name..])
        });
        // A file is large, and is read once.
        *SCRATCH.lock() = Vec::new();
        ended(opened.map(|set| {
            let number = SCENES.lock().add(set);
            *ANSWER.lock() = [number as usize, 0];
        }))
    }

    /// The text of the last answer about a file.
    #[cfg(feature = "files")]
    static TEXT: Mutex<String> = Mutex::new(String::new());

    #[cfg(feature = "files")]
    fn told(text: Result<String, Fault>) -> u32 {
        *SCRATCH.lock() = Vec::new();
        ended(text.map(|text| {
            let mut kept = TEXT.lock();
            *kept = text;
            answer(kept.as_bytes());
        }))
    }

    /// The arguments of `file_open`; the answer has the files that it names, one a line.
    #[cfg(feature = "files")]
    #[unsafe(no_mangle)]
    extern "C" fn file_beside(name: usize, bytes: usize) -> u32 {
        told(with_scratch(name + bytes, |all| {
            crate::files::beside(&String::from_utf8_lossy(&all[..name]), &all[name..])
        }))
    }

    /// The arguments of `file_open`, then `beside` bytes of the files that it names: the lengths of
    /// a name and of a file as u32, then both. The answer is JSON.
    #[cfg(feature = "files")]
    #[unsafe(no_mangle)]
    extern "C" fn file_info(name: usize, bytes: usize, beside: usize) -> u32 {
        told(with_scratch(name + bytes + beside, |all| {
            let (file, rest) = all[name..].split_at(bytes);
            let beside = packed(rest);
            let short = || Fault::new(Code::Argument, "the files beside it are not all there");
            let beside = beside.ok_or_else(short)?;
            crate::info::info(&String::from_utf8_lossy(&all[..name]), file, &beside)
        }))
    }

    #[cfg(feature = "files")]
    fn packed(mut bytes: &[u8]) -> Option<Vec<(String, Vec<u8>)>> {
        let mut files = Vec::new();
        while !bytes.is_empty() {
            let (name, rest) = bytes.split_first_chunk::<4>()?;
            let (file, rest) = rest.split_first_chunk::<4>()?;
            let (name, rest) = rest.split_at_checked(u32::from_le_bytes(*name) as usize)?;
            let (file, rest) = rest.split_at_checked(u32::from_le_bytes(*file) as usize)?;
            files.push((String::from_utf8_lossy(name).into_owned(), file.to_vec()));
            bytes = rest;
        }
        Some(files)
    }
}
