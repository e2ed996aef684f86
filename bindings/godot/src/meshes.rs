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

use crate::inbox::{self, Event, Inbox};
use crate::levels;
use crate::material::{Facts, Hiding, Materials};

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

/// A mesh as it was at a version, and what of it hides.
type Key = (InstanceId, u64, Hiding);

/// A mesh that is drawn by nodes of the world.
struct Followed {
    facts: MeshFacts,
    on_changed: Callable,
    /// The frames in which its surfaces were last counted, and the facts of its own materials found.
    counted_at: u64,
    materials_at: Option<u64>,
    materials: Vec<Facts>,
    made: Vec<(Hiding, Wanted)>,
}

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
    followed: HashMap<InstanceId, Followed>,
    version: u64,
    frame: u64,
    worker: Option<Worker>,
    waiting: usize,
}

/// Meshes of no more triangles are made at once: it takes less time than a frame.
const AT_ONCE: i64 = 4096;
/// More triangles than this hide nothing: making and drawing their occluders takes too long.
const MOST_TRIANGLES: i64 = 2_000_000;

impl Meshes {
    /// Asks meshes again for what may change without a signal, as a frame begins.
    pub(crate) fn ask_again(&mut self) {
        self.frame += 1;
    }

    /// Returns what is known of a mesh, and listens to its changes from the first time on.
    pub(crate) fn facts(&mut self, mesh: &Gd<Mesh>, inbox: &Inbox) -> MeshFacts {
        let id = mesh.instance_id();
        if let Some(known) = self.followed.get(&id) {
            // Clearing a mesh emits no signal.
            if known.facts.surfaces == mesh.get_surface_count() {
                return known.facts;
            }
            self.forget(id);
        }
        let facts = MeshFacts { version: self.version, ..facts(mesh) };
        let on_changed = inbox.callable(Event::Resource(id));
        inbox::connect(mesh, "changed", &on_changed);
        let (materials, made) = (Vec::new(), Vec::new());
        let (counted_at, materials_at) = (self.frame, None);
        let known = Followed { facts, on_changed, counted_at, materials_at, materials, made };
        self.followed.insert(id, known);
        facts
    }

    /// Whether a mesh is what it was at a version. It is asked once a frame.
    pub(crate) fn is_as_it_was(&mut self, (id, version): (InstanceId, u64)) -> bool {
        let known = self.followed.get_mut(&id).filter(|known| known.facts.version == version);
        let Some(known) = known else { return false };
        if known.counted_at != self.frame {
            let Ok(mesh) = Gd::<Mesh>::try_from_instance_id(id) else { return false };
            if mesh.get_surface_count() != known.facts.surfaces {
                return false;
            }
            known.counted_at = self.frame;
        }
        true
    }

    /// Returns the facts of the materials of a mesh's own surfaces. They are asked once a frame.
    pub(crate) fn own_materials(&mut self, id: InstanceId, materials: &mut Materials) -> &[Facts] {
        let Some(known) = self.followed.get_mut(&id) else { return &[] };
        if known.materials_at != Some(self.frame) {
            known.materials.clear();
            if let Ok(mesh) = Gd::<Mesh>::try_from_instance_id(id) {
                let of = |i| materials.facts(mesh.surface_get_material(i)).of_surface(i);
                known.materials.extend((0..known.facts.surfaces).map(of));
            }
            known.materials_at = Some(self.frame);
        }
        &known.materials
    }

    /// Forgets a mesh that changed. Returns whether it was known.
    pub(crate) fn forget(&mut self, id: InstanceId) -> bool {
        let Some(known) = self.followed.remove(&id) else { return false };
        disconnect(id, &known.on_changed);
        self.version += 1;
        true
    }

    /// Stops listening.
    pub(crate) fn disconnect(&mut self) {
        self.followed.drain().for_each(|(id, known)| disconnect(id, &known.on_changed));
    }

    /// Returns the engine's mesh, and begins to make it where there is none. Its facts must be known.
    pub(crate) fn want(&mut self, scene: &mut Scene, mesh: &Gd<Mesh>, hiding: Hiding) -> Wanted {
        let id = mesh.instance_id();
        let Some(known) = self.followed.get_mut(&id) else { return Wanted::Nothing };
        let all = u64::MAX >> 64_u32.saturating_sub(known.facts.surfaces.max(1) as u32);
        let hiding = Hiding { surfaces: hiding.surfaces & all, ..hiding };
        if let Some((_, wanted)) = known.made.iter().find(|(made, _)| *made == hiding) {
            return *wanted;
        }
        let facts = known.facts;
        let wanted = match shape_of(mesh, hiding) {
            Some(shape) if !facts.has_levels && facts.triangles <= AT_ONCE => made(shape)
                .map_or(Wanted::Nothing, |(mesh, prepared)| {
                    Wanted::Here(scene.add_prepared_mesh(mesh, prepared))
                }),
            Some(shape) => {
                let worker = self.worker.get_or_insert_with(Worker::new);
                if worker.send((id, facts.version, hiding), shape) {
                    self.waiting += 1;
                    Wanted::Soon
                } else {
                    Wanted::Nothing
                }
            }
            None => Wanted::Nothing,
        };
        known.made.push((hiding, wanted));
        wanted
    }

    /// Takes over meshes that were made since the last call. Returns whether there were any.
    pub(crate) fn receive(&mut self, scene: &mut Scene) -> bool {
        let Some(worker) = self.worker.as_ref().filter(|_| self.waiting > 0) else { return false };
        let mut any = false;
        while let Ok(((id, version, hiding), made)) = worker.results.try_recv() {
            self.waiting -= 1;
            // One that changed meanwhile is not waited for any more, or is made anew.
            let known = self.followed.get_mut(&id).filter(|known| known.facts.version == version);
            let mut all = known.into_iter().flat_map(|known| &mut known.made);
            if let Some((_, wanted)) = all.find(|(own, _)| *own == hiding) {
                let id = made.map(|(mesh, prepared)| scene.add_prepared_mesh(mesh, prepared));
                *wanted = id.map_or(Wanted::Nothing, Wanted::Here);
                any = true;
            }
        }
        any
    }

    /// Whether Godot may draw one of the engine's meshes by coarser levels.
    pub(crate) fn has_levels(&self, mesh: MeshId) -> bool {
        let mut of_levels = self.followed.values().filter(|known| known.facts.has_levels);
        of_levels.any(|known| known.made.iter().any(|(_, wanted)| *wanted == Wanted::Here(mesh)))
    }

    /// Whether all that a mesh draws hides what is behind it, no surface left out.
    pub(crate) fn is_all_hiding(&self, (id, _): (InstanceId, u64), hiding: Hiding) -> bool {
        let surfaces = self.followed.get(&id).map_or(64, |known| known.facts.surfaces);
        (0..64).contains(&surfaces) && hiding.surfaces.trailing_ones() >= surfaces as u32
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

/// Hiding part of a mesh at each level, the finest first; and the whole mesh, where some of it does not hide.
struct Shape {
    hiding: Vec<MeshData>,
    whole: Option<MeshData>,
}

type Made = Option<(cullet::Mesh, Prepared)>;

/// A thread that makes occluders. It ends with what it is at when it is dropped.
struct Worker {
    jobs: Option<Sender<(Key, Shape)>>,
    results: Receiver<(Key, Made)>,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    fn new() -> Self {
        let (jobs, todo) = channel::<(Key, Shape)>();
        let (done, results) = channel();
        let work = move || {
            for (key, shape) in todo {
                if done.send((key, made(shape))).is_err() {
                    return;
                }
            }
        };
        let thread = std::thread::Builder::new().name("cullet occluders".into()).spawn(work).ok();
        Self { jobs: Some(jobs), results, thread }
    }

    fn send(&self, key: Key, shape: Shape) -> bool {
        self.jobs.as_ref().is_some_and(|jobs| jobs.send((key, shape)).is_ok())
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

/// Makes the engine's mesh of the finest level, with an occluder that what hides of every level holds.
fn made(shape: Shape) -> Made {
    let mut levels = shape.hiding.into_iter().map(cullet::Mesh::new);
    let fine = levels.next()?.ok()?;
    let coarse = levels.collect::<Result<Vec<_>, _>>().ok()?;
    let prepared = if coarse.is_empty() {
        Prepared::of(&fine, Preparation { occluder: true, ..Preparation::NONE })
    } else {
        Prepared::default().with_occluder(levels::inside_all(&fine, &coarse)?)
    };
    // Its bounds are those of all that is drawn.
    let Some(whole) = shape.whole else { return Some((fine, prepared)) };
    let occluder = prepared.occluder()?.clone();
    Some((cullet::Mesh::new(whole).ok()?, Prepared::default().with_occluder(occluder)))
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

/// A surface: its triangles at each level, and the lengths from which on the coarser ones are drawn.
struct Surface {
    levels: Vec<Vec<u32>>,
    edges: Vec<f32>,
}

/// Returns the triangles of a mesh; `None` where they cannot be told.
fn shape_of(mesh: &Gd<Mesh>, hiding: Hiding) -> Option<Shape> {
    let mut positions = Vec::new();
    let mut surfaces = Vec::new();
    for number in 0..mesh.get_surface_count() {
        surfaces.push(surface_of(mesh, number, &mut positions)?);
    }
    let data = |lists: &mut dyn Iterator<Item = &Vec<u32>>| {
        let indices: Vec<u32> = lists.flatten().copied().collect();
        let triangle_count = indices.len() as u32 / 3;
        let part = Part { triangle_count, two_sided: hiding.two_sided, ..Part::default() };
        MeshData { positions: positions.clone(), indices, parts: vec![part], ..MeshData::default() }
    };
    let hides = |number: usize| number < 64 && hiding.surfaces >> number & 1 == 1;
    let (mut opaque, mut edges) = (Vec::new(), Vec::new());
    for (_, surface) in surfaces.iter().enumerate().filter(|&(number, _)| hides(number)) {
        opaque.push(surface);
        edges.push(surface.edges.clone());
    }
    let mixtures = levels::mixtures(&edges).filter(|_| !opaque.is_empty())?;
    let of = |mixture: &Vec<usize>| {
        data(&mut opaque.iter().zip(mixture).map(|(surface, &level)| &surface.levels[level]))
    };
    let is_all = opaque.len() == surfaces.len();
    let whole = (!is_all).then(|| data(&mut surfaces.iter().map(|surface| &surface.levels[0])));
    Some(Shape { hiding: mixtures.iter().map(of).collect(), whole })
}

fn surface_of(mesh: &Gd<Mesh>, number: i32, positions: &mut Vec<[f32; 3]>) -> Option<Surface> {
    let info = RenderingServer::singleton().mesh_get_surface(mesh.get_rid(), number);
    let arrays = mesh.surface_get_arrays(number);
    let points = arrays.get(ArrayType::VERTEX.ord() as usize)?;
    let points = points.try_to::<PackedVector3Array>().ok()?;
    let first = positions.len() as u32;
    positions.extend(points.as_slice().iter().map(|p| [p.x, p.y, p.z]));
    let list = arrays.get(ArrayType::INDEX.ord() as usize);
    let list = list.and_then(|list| list.try_to::<PackedInt32Array>().ok());
    let own = match &list {
        Some(list) if !list.is_empty() => turned(list.as_slice().iter().map(|&i| i as u32), first),
        _ => turned(0..points.len() as u32, first),
    };
    let count = own.len();
    let (mut levels, mut edges) = (vec![own], Vec::new());
    if let Some(lods) = info.get("lods").filter(has_any) {
        let bytes = info.get("index_data")?.try_to::<PackedByteArray>().ok()?.len();
        let wide = bytes >= count * 4;
        for lod in lods.try_to::<VarArray>().ok()?.iter_shared() {
            let lod = lod.try_to::<VarDictionary>().ok()?;
            let bytes = lod.get("index_data")?.try_to::<PackedByteArray>().ok()?;
            levels.push(turned(indices(bytes.as_slice(), wide), first));
            edges.push(lod.get("edge_length")?.try_to::<f64>().ok()? as f32);
        }
    }
    Some(Surface { levels, edges })
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
