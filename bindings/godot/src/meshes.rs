//! Godot's meshes as the engine's, with occluders made of them.

use std::collections::HashMap;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

use cullet::mesh::Part;
use cullet::prepared::{Preparation, Prepared};
use cullet::{MeshData, MeshId, Scene};
use godot::classes::mesh::{ArrayType, PrimitiveType};
use godot::classes::{ImmediateMesh, Mesh, PlaceholderMesh, RenderingServer};
use godot::obj::{InstanceId, Singleton};
use godot::prelude::*;

use crate::inbox::{Event, Inbox};
use crate::levels;

/// Facts of a mesh that take no look at its triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct MeshFacts {
    pub(crate) surfaces: i32,
    /// Skins or blend shapes move its vertices.
    pub(crate) deforms: bool,
    /// It has triangles, and they stay as they are.
    pub(crate) hides: bool,
    /// Rises with each change of any mesh.
    pub(crate) version: u64,
    triangles: i64,
    has_levels: bool,
}

/// A mesh and whether both sides of its triangles are drawn.
type Key = (InstanceId, bool);

/// State of the engine's mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wanted {
    Here(MeshId),
    /// It is made on another thread.
    Soon,
    Nothing,
}

/// The meshes of a world.
#[derive(Default)]
pub(crate) struct Meshes {
    facts: HashMap<InstanceId, (MeshFacts, Callable)>,
    made: HashMap<Key, Wanted>,
    version: u64,
    worker: Option<Worker>,
    waiting: usize,
}

/// Meshes of no more triangles are made at once: it takes less time than a frame.
const AT_ONCE: i64 = 4096;
/// More triangles than this hide nothing: making and drawing their occluders takes too long.
const MOST_TRIANGLES: i64 = 2_000_000;

impl Meshes {
    /// Returns what is known of a mesh, and listens to its changes from the first time on.
    pub(crate) fn facts(&mut self, mesh: &Gd<Mesh>, inbox: &Inbox) -> MeshFacts {
        let id = mesh.instance_id();
        if let Some((facts, _)) = self.facts.get(&id) {
            // Clearing a mesh emits no signal.
            if facts.surfaces == mesh.get_surface_count() {
                return *facts;
            }
            self.forget(id);
        }
        let facts = MeshFacts { version: self.version, ..facts(mesh) };
        let callable = inbox.callable(Event::Resource(id));
        mesh.clone().connect("changed", &callable);
        self.facts.insert(id, (facts, callable));
        facts
    }

    /// Forgets a mesh that changed. Returns whether it was known.
    pub(crate) fn forget(&mut self, id: InstanceId) -> bool {
        let Some((_, callable)) = self.facts.remove(&id) else { return false };
        disconnect(id, &callable);
        self.version += 1;
        for two_sided in [false, true] {
            // Of one that is being made, the result would be of the mesh as it was.
            self.made.remove(&(id, two_sided));
        }
        true
    }

    /// Stops listening.
    pub(crate) fn disconnect(&mut self) {
        self.facts.drain().for_each(|(id, (_, callable))| disconnect(id, &callable));
        self.made.clear();
    }

    /// Returns the engine's mesh, and begins to make it where there is none.
    pub(crate) fn want(&mut self, scene: &mut Scene, mesh: &Gd<Mesh>, two_sided: bool) -> Wanted {
        let key = (mesh.instance_id(), two_sided);
        if let Some(wanted) = self.made.get(&key) {
            return *wanted;
        }
        let facts = self.facts.get(&key.0).map(|(facts, _)| *facts).unwrap_or_default();
        let wanted = match levels_of(mesh, two_sided) {
            Some(levels) if !facts.has_levels && facts.triangles <= AT_ONCE => made(levels)
                .map_or(Wanted::Nothing, |(mesh, prepared)| {
                    Wanted::Here(scene.add_prepared_mesh(mesh, prepared))
                }),
            Some(levels) => {
                let worker = self.worker.get_or_insert_with(Worker::new);
                if worker.send(key, levels) {
                    self.waiting += 1;
                    Wanted::Soon
                } else {
                    Wanted::Nothing
                }
            }
            None => Wanted::Nothing,
        };
        self.made.insert(key, wanted);
        wanted
    }

    /// Takes over meshes that were made since the last call. Returns whether there were any.
    pub(crate) fn receive(&mut self, scene: &mut Scene) -> bool {
        let Some(worker) = self.worker.as_ref().filter(|_| self.waiting > 0) else { return false };
        let mut any = false;
        while let Ok((key, made)) = worker.results.try_recv() {
            self.waiting -= 1;
            // One that changed meanwhile is not waited for any more.
            if self.made.get(&key) == Some(&Wanted::Soon) {
                let id = made.map(|(mesh, prepared)| scene.add_prepared_mesh(mesh, prepared));
                self.made.insert(key, id.map_or(Wanted::Nothing, Wanted::Here));
                any = true;
            }
        }
        any
    }

    /// Returns how many meshes are being made.
    pub(crate) fn waiting(&self) -> usize {
        self.waiting
    }
}

fn disconnect(id: InstanceId, callable: &Callable) {
    if let Ok(mut mesh) = Gd::<Mesh>::try_from_instance_id(id)
        && mesh.is_connected("changed", callable)
    {
        mesh.disconnect("changed", callable);
    }
}

type Levels = Vec<MeshData>;
type Made = Option<(cullet::Mesh, Prepared)>;

/// A thread that makes occluders. It ends with what it is at when it is dropped.
struct Worker {
    jobs: Option<Sender<(Key, Levels)>>,
    results: Receiver<(Key, Made)>,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    fn new() -> Self {
        let (jobs, todo) = channel::<(Key, Levels)>();
        let (done, results) = channel();
        let work = move || {
            for (key, levels) in todo {
                if done.send((key, made(levels))).is_err() {
                    return;
                }
            }
        };
        let thread = std::thread::Builder::new().name("cullet occluders".into()).spawn(work).ok();
        Self { jobs: Some(jobs), results, thread }
    }

    fn send(&self, key: Key, levels: Levels) -> bool {
        self.jobs.as_ref().is_some_and(|jobs| jobs.send((key, levels)).is_ok())
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.jobs = None;
        // What waits is not made any more: results have no receiver.
        let (_, gone) = channel();
        self.results = gone;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Makes the engine's mesh of the finest level, with an occluder that every level holds.
fn made(levels: Levels) -> Made {
    let mut levels = levels.into_iter().map(cullet::Mesh::new);
    let fine = levels.next()?.ok()?;
    let coarse = levels.collect::<Result<Vec<_>, _>>().ok()?;
    if coarse.is_empty() {
        let wanted = Preparation { occluder: true, ..Preparation::NONE };
        let prepared = Prepared::of(&fine, wanted);
        return Some((fine, prepared));
    }
    let occluder = levels::inside_all(&fine, &coarse)?;
    Some((fine, Prepared::default().with_occluder(occluder)))
}

/// Asks Godot's server of a mesh.
fn facts(mesh: &Gd<Mesh>) -> MeshFacts {
    let mut server = RenderingServer::singleton();
    let rid = mesh.get_rid();
    // Asking a mesh that makes itself for its surfaces makes them.
    let surfaces = mesh.get_surface_count();
    let blends = server.mesh_get_blend_shape_count(rid) > 0;
    let mut facts =
        MeshFacts { surfaces, deforms: blends, hides: surfaces > 0, ..MeshFacts::default() };
    let is_fleeting = mesh.clone().try_cast::<ImmediateMesh>().is_ok()
        || mesh.clone().try_cast::<PlaceholderMesh>().is_ok();
    facts.hides &= !is_fleeting;
    for surface in 0..surfaces {
        let info = server.mesh_get_surface(rid, surface);
        let number = |name: &str| info.get(name).and_then(|v| v.try_to::<i64>().ok());
        let format = number("format").unwrap_or(0);
        facts.deforms |= format >> ArrayType::BONES.ord() & 1 != 0;
        facts.hides &= number("primitive") == Some(i64::from(PrimitiveType::TRIANGLES.ord()));
        let corners = number("index_count").filter(|&n| n > 0).or_else(|| number("vertex_count"));
        facts.triangles += corners.unwrap_or(0) / 3;
        facts.has_levels |= info.get("lods").is_some_and(|l| has_any(&l));
    }
    facts.hides &= !facts.deforms && (1..=MOST_TRIANGLES).contains(&facts.triangles);
    facts
}

fn has_any(list: &Variant) -> bool {
    !list.try_to::<VarArray>().is_ok_and(|list| list.is_empty())
}

/// Returns the triangles of each level of a mesh, the finest first; `None` where they cannot be
/// told.
fn levels_of(mesh: &Gd<Mesh>, two_sided: bool) -> Option<Levels> {
    let mut server = RenderingServer::singleton();
    let mut positions = Vec::new();
    // By surface, then by level.
    let mut lists: Vec<Vec<Vec<u32>>> = Vec::new();
    for surface in 0..mesh.get_surface_count() {
        let info = server.mesh_get_surface(mesh.get_rid(), surface);
        let arrays = mesh.surface_get_arrays(surface);
        let points = arrays.get(ArrayType::VERTEX.ord() as usize)?;
        let points = points.try_to::<PackedVector3Array>().ok()?;
        let first = positions.len() as u32;
        positions.extend(points.as_slice().iter().map(|p| [p.x, p.y, p.z]));
        let list = arrays.get(ArrayType::INDEX.ord() as usize);
        let list = list.and_then(|list| list.try_to::<PackedInt32Array>().ok());
        let own = match &list {
            Some(list) if !list.is_empty() => {
                turned(list.as_slice().iter().map(|&i| i as u32), first)
            }
            _ => turned(0..points.len() as u32, first),
        };
        let count = own.len();
        let mut levels = vec![own];
        if let Some(lods) = info.get("lods").filter(has_any) {
            let bytes = info.get("index_data")?.try_to::<PackedByteArray>().ok()?.len();
            let wide = bytes >= count * 4;
            for lod in lods.try_to::<VarArray>().ok()?.iter_shared() {
                let lod = lod.try_to::<VarDictionary>().ok()?;
                let bytes = lod.get("index_data")?.try_to::<PackedByteArray>().ok()?;
                levels.push(turned(indices(bytes.as_slice(), wide), first));
            }
        }
        lists.push(levels);
    }
    let most = lists.iter().map(Vec::len).max()?;
    // Surfaces choose their levels by themselves; those of equal number are taken together, and a
    // surface with fewer stays at its coarsest. Boxes inside each of these are inside any mixture
    // only if the surfaces are closed one by one, so a mesh of several is taken surface by surface.
    if most > 1 && lists.len() > 1 {
        return None;
    }
    let data = (0..most).map(|level| {
        let of = |levels: &Vec<Vec<u32>>| levels[level.min(levels.len() - 1)].clone();
        let indices: Vec<u32> = lists.iter().flat_map(of).collect();
        let triangle_count = indices.len() as u32 / 3;
        let part = Part { triangle_count, two_sided, ..Part::default() };
        MeshData { positions: positions.clone(), indices, parts: vec![part], ..MeshData::default() }
    });
    Some(data.collect())
}

/// Returns triangles wound counter-clockwise; Godot's fronts are clockwise.
fn turned(indices: impl IntoIterator<Item = u32>, first: u32) -> Vec<u32> {
    let mut list: Vec<u32> = indices.into_iter().map(|i| first + i).collect();
    list.truncate(list.len() / 3 * 3);
    list.chunks_exact_mut(3).for_each(|t| t.swap(1, 2));
    list
}

fn indices(bytes: &[u8], wide: bool) -> Vec<u32> {
    if wide {
        let word = |b: &[u8]| u32::from_le_bytes([b[0], b[1], b[2], b[3]]);
        bytes.chunks_exact(4).map(word).collect()
    } else {
        bytes.chunks_exact(2).map(|b| u32::from(u16::from_le_bytes([b[0], b[1]]))).collect()
    }
}
