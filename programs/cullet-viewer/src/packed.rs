//! A model as bytes, to go from the worker that parsed it to the page that shows it.
//!
//! Geometry is copied as it lies in memory; all else is the engine's and the loader's own types, by
//! `postcard`. Both sides run the same program, so this is no file format: there is no version, and
//! nothing of it outlives a message. Even so every count is held against the bytes there are.

use cullet::bounds::Aabb;
use cullet::cull::occlusion::Occluder;
use cullet::mesh::{Cluster, Clustering, MeshData, Part};
use cullet::{
    Handle, Instance, InstanceFlags, Mesh, Scene, Transform,
    prepared::{Preparation, Prepared},
    scene::BoundsOverride,
};
use cullet_io::{CellGraph, Model, NodeTree, Warning};

use crate::bytes::{Reader, UnpackError, Writer};
use crate::measures::{Measures, at_rest};

/// Packs all of a model but how it moves, which is told as a warning: what moves stands as it is
/// stored. Instances come in the order of their slots, so that they need no second sort; the handle
/// of each is its place among them. Costs a copy of everything.
#[must_use]
pub fn pack(model: &Model) -> Vec<u8> {
    let Model { name, scene, mesh_names, node_tree, materials, cameras, views, .. } = model;
    let slots: Vec<(u32, Handle)> =
        scene.slots().filter_map(|slot| Some((slot, scene.handle(slot)?))).collect();
    let node_of = |handle: Handle| node_tree.node_of_instance.get(handle.index as usize);
    let nodes: Vec<u32> =
        slots.iter().map(|&(_, h)| node_of(h).copied().unwrap_or(NodeTree::NONE)).collect();
    // First, for only the first warnings are shown.
    let warnings: Vec<Warning> = at_rest(model).into_iter().chain(model.warnings.clone()).collect();
    let mut out = Writer::default();
    out.value(&(name, mesh_names, materials, cameras, views, cells(model, &slots), warnings));
    out.value(&(scene.origin(), Measures::of(model)));
    out.pods(&node_tree.parents);
    out.pods(if node_tree.node_of_instance.is_empty() { &[] } else { &nodes });
    out.count(scene.meshes().len());
    scene.meshes().iter().zip(scene.prepared()).for_each(|(m, p)| mesh(&mut out, m, p));
    // As they are called here, where their handles are others.
    out.count(slots.len());
    slots.iter().for_each(|&(_, handle)| out.value(&*model.instance_name(handle)));
    out.count(node_tree.names.len());
    node_tree.names.iter().for_each(|name| out.value(name));
    out.count(slots.len());
    slots.iter().for_each(|&(slot, _)| instance(&mut out, scene, slot));
    out.bytes
}

/// Cells and portals, whose doors have their handles there.
fn cells(model: &Model, slots: &[(u32, Handle)]) -> CellGraph {
    let mut cells = model.cells.clone();
    for portal in &mut cells.portals {
        portal.door = portal.door.map(|door| {
            let place = slots.iter().position(|&(_, handle)| handle == door);
            // A door that is not there any more is none of these.
            Handle { index: place.map_or(u32::MAX, |p| p as u32), generation: 0 }
        });
    }
    cells
}

/// Packs the instance in a slot, with its box in the scene. There may be a million of them, so the
/// long fields of each are copied as they lie in memory.
fn instance(out: &mut Writer, scene: &Scene, slot: u32) {
    let flags = scene.flags(slot);
    let exempt = scene.exempt().get(slot as usize / 64).is_some_and(|w| w >> (slot % 64) & 1 == 1);
    // An instance that its flag exempts needs no other reason.
    let is_unbounded = exempt && !flags.always_visible;
    out.value(&(scene.mesh_id(slot), scene.layers(slot), flags, is_unbounded));
    let Transform { linear, translation } = scene.transform(slot);
    out.pod(linear);
    out.pod(translation);
    out.pod(&scene.bounds(slot));
}

/// Short fields of a mesh beside its long arrays: its parts, how many polygons it had, whether it
/// deforms, its clusters, which take most of the time to build, and its occluder, where one was
/// given.
type Rest<P, C, O> = (P, u32, bool, C, Option<O>);

fn mesh(out: &mut Writer, mesh: &Mesh, prepared: &Prepared) {
    let data = mesh.to_data();
    out.pods(&data.positions);
    out.pods(&data.indices);
    let drawn = (mesh.triangle_count() - mesh.degenerate_count()) as usize;
    out.pods(&mesh.original_triangle()[..drawn]);
    let MeshData { parts, polygons, deformable, .. } = &data;
    let rest: Rest<_, _, _> =
        (parts, *polygons, *deformable, mesh.clusters(), prepared.given_occluder());
    out.value(&rest);
}

/// The fewest bytes of an instance.
const INSTANCE: usize = 92;
/// So many names or instances are one step: some milliseconds at the most.
const BATCH: usize = 4096;

/// The section that is unpacked next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Meshes,
    InstanceNames,
    NodeNames,
    Instances,
    Done,
}

/// Unpacks a model piece by piece.
#[derive(Debug)]
pub struct Unpacker {
    bytes: Vec<u8>,
    at: usize,
    model: Model,
    measures: Measures,
    phase: Phase,
    /// How many are left of what the phase makes.
    left: usize,
}

impl Unpacker {
    /// Reads what is little: everything but meshes, instances and their names.
    ///
    /// # Errors
    /// If the bytes are none that [`pack`] wrote.
    pub fn new(bytes: Vec<u8>) -> Result<Self, UnpackError> {
        let mut from = Reader::new(&bytes, 0);
        let from = &mut from;
        let mut model = Model::default();
        (
            model.name,
            model.mesh_names,
            model.materials,
            model.cameras,
            model.views,
            model.cells,
            model.warnings,
        ) = from.value()?;
        let (origin, measures) = from.value()?;
        // Before there is anything to move.
        model.scene.rebase(origin);
        model.node_tree.parents = from.pods()?;
        model.node_tree.node_of_instance = from.pods()?;
        let left = from.count(1)?;
        let at = from.at();
        Ok(Self { bytes, at, model, measures, phase: Phase::Meshes, left })
    }

    /// Measures of the packed model.
    #[must_use]
    pub fn measures(&self) -> Measures {
        self.measures.clone()
    }

    /// Goes on a little: a mesh, with what culling prepares of it, or some thousand names or
    /// instances; `false` when all is there. Only the nodes over the instances are made all at
    /// once.
    ///
    /// # Errors
    /// If the bytes are none that [`pack`] wrote.
    pub fn step(&mut self) -> Result<bool, UnpackError> {
        let batch = self.left.min(BATCH);
        match self.phase {
            Phase::Meshes if self.left > 0 => {
                self.mesh()?;
                self.left -= 1;
                return Ok(true);
            }
            Phase::InstanceNames | Phase::NodeNames if self.left > 0 => {
                let mut from = Reader::new(&self.bytes, self.at);
                let names = match self.phase {
                    Phase::InstanceNames => &mut self.model.instance_names,
                    _ => &mut self.model.node_tree.names,
                };
                for _ in 0..batch {
                    names.push(from.value()?);
                }
                self.at = from.at();
                self.left -= batch;
                return Ok(true);
            }
            Phase::Instances if self.left > 0 => {
                self.place(batch)?;
                self.left -= batch;
                return Ok(true);
            }
            _ => {}
        }
        let mut from = Reader::new(&self.bytes, self.at);
        (self.phase, self.left) = match self.phase {
            Phase::Meshes => (Phase::InstanceNames, from.count(1)?),
            Phase::InstanceNames => (Phase::NodeNames, from.count(1)?),
            Phase::NodeNames => (Phase::Instances, from.count(INSTANCE)?),
            Phase::Instances => {
                self.model.scene.commit_in_order();
                let damaged =
                    |e: cullet_cells::cell::CellError| UnpackError::Damaged(e.to_string());
                self.model.place_cells().map_err(damaged)?;
                (Phase::Done, 0)
            }
            Phase::Done => (Phase::Done, 0),
        };
        self.at = from.at();
        Ok(self.phase != Phase::Done)
    }

    fn mesh(&mut self) -> Result<(), UnpackError> {
        let damaged = |e: cullet::mesh::MeshError| UnpackError::Damaged(e.to_string());
        let mut from = Reader::new(&self.bytes, self.at);
        let (positions, indices, order) = (from.pods()?, from.pods()?, from.pods()?);
        let (parts, polygons, deformable, clusters, occluder) =
            from.value::<Rest<Vec<Part>, Vec<Cluster>, Occluder>>()?;
        self.at = from.at();
        let data = MeshData { positions, indices, parts, polygons, deformable };
        let clustering = Clustering { order, clusters };
        let mesh = Mesh::with_clusters(data, &clustering).map_err(damaged)?;
        let wanted = Preparation { occluder: occluder.is_none(), ..Preparation::default() };
        let mut prepared = Prepared::of(&mesh, wanted);
        if let Some(occluder) = occluder {
            prepared = prepared.with_occluder(occluder);
        }
        self.model.scene.add_prepared_mesh(mesh, prepared);
        Ok(())
    }

    /// Adds the next instances, with the bounds that they had. Those that were given, as those of
    /// what deforms are, are not those of the mesh.
    fn place(&mut self, count: usize) -> Result<(), UnpackError> {
        let wrong = |e: cullet::SceneError| UnpackError::Damaged(e.to_string());
        let mut from = Reader::new(&self.bytes, self.at);
        let scene = &mut self.model.scene;
        for _ in 0..count {
            let (mesh, layers, flags, is_unbounded): (u32, u32, InstanceFlags, bool) =
                from.value()?;
            let transform = Transform { linear: from.pod()?, translation: from.pod()? };
            let seen: Aabb = from.pod()?;
            let bounds = if is_unbounded { BoundsOverride::None } else { BoundsOverride::Mesh };
            let slot = scene.slot_count();
            let instance = Instance { layers, flags, bounds, ..Instance::new(mesh, transform) };
            let handle = scene.add(instance).map_err(wrong)?;
            if !is_unbounded && scene.bounds(slot) != seen {
                scene.set_bounds(handle, BoundsOverride::World(seen)).map_err(wrong)?;
            }
        }
        self.at = from.at();
        Ok(())
    }

    /// Makes what is left.
    ///
    /// # Errors
    /// If the bytes are none that [`pack`] wrote.
    pub fn finish(mut self) -> Result<Model, UnpackError> {
        while self.step()? {}
        Ok(self.model)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet::cull::occlusion::{Convex, Occlusion, Patch, Shape};
    use cullet::{View, ViewState, Visible};
    use cullet_io::Portal;
    use cullet_maps::load_bytes;

    /// How many triangles are left of a view, and what dropped each instance.
    fn seen(model: &Model) -> (u64, usize, Vec<Option<&'static str>>) {
        let camera = &cullet_scenes::paths::cameras(
            model,
            &cullet_scenes::paths::PathSpec::Orbit,
            3,
            [320, 200],
            &cullet_scenes::paths::Overrides::default(),
        )
        .unwrap()[1];
        let view = View::new(camera, cullet::Depth::Reversed, [320, 200]).unwrap();
        let mut visible = Visible::default();
        // Which facets an occluder has depends on the order of triangles, which comes back in that
        // of the clusters.
        let culler = cullet::Culler::default().with_reasons(true).with_occlusion(None);
        model.in_cells().cull(&culler, &view, &mut ViewState::default(), &mut visible);
        let stage = |slot: u32| visible.reasons[slot as usize].map(|r| r.stage.name());
        let all = model.scene.slots().map(stage).collect();
        (visible.triangle_count, visible.partial.len(), all)
    }

    fn same(model: &Model) {
        let unpacker = Unpacker::new(pack(model)).unwrap();
        assert_eq!(unpacker.measures(), Measures::of(model), "{}", model.name);
        let back = unpacker.finish().unwrap();
        let meshes = |m: &Model| {
            format!("{:?}", m.scene.meshes().iter().map(Mesh::to_data).collect::<Vec<_>>())
        };
        assert_eq!(meshes(&back), meshes(model), "{}", model.name);
        for (a, b) in back.scene.meshes().iter().zip(model.scene.meshes()) {
            assert_eq!(
                (a.clusters(), a.original_triangle()),
                (b.clusters(), b.original_triangle())
            );
        }
        // Slot for slot.
        let placed = |m: &Model| {
            let s = &m.scene;
            let one = |i: u32| {
                let exempt = s.exempt()[i as usize / 64] >> (i % 64) & 1;
                let (mesh, layers, bounds) = (s.mesh_id(i), s.layers(i), s.bounds(i));
                let handle = s.handle(i).unwrap();
                let name = m.instance_name(handle).into_owned();
                let node = m.node_tree.node_of_instance.get(handle.index as usize).copied();
                (name, node, mesh, *s.transform(i), layers, s.flags(i), bounds, exempt)
            };
            (s.origin(), s.slots().map(one).collect::<Vec<_>>())
        };
        assert_eq!(placed(&back), placed(model), "{}", model.name);
        let rest = |m: &Model| {
            let portal = |p: &Portal| {
                let door = p.door.map(|h| m.scene.slot(h));
                (p.cells, p.polygon.clone(), door, p.closed)
            };
            (
                m.name.clone(),
                m.mesh_names.clone(),
                m.node_tree.parents.clone(),
                m.node_tree.names.clone(),
                m.materials.clone(),
                m.cameras.clone(),
                m.views.clone(),
                m.cells.cells.clone(),
                m.cells.portals.iter().map(portal).collect::<Vec<_>>(),
            )
        };
        assert_eq!(rest(&back), rest(model), "{}", model.name);
        assert_eq!(seen(&back), seen(model), "{}", model.name);
    }

    #[test]
    fn a_model_comes_back_as_it_went() {
        for text in ["solids", "city:cells=4,objects=30", "office", "moving", "knobs"] {
            same(&cullet_scenes::build(text).unwrap());
        }
        let far = b"v 1e7 0 0\nv 1e7 1 0\nv 1.00001e7 0 0\nv 1e7 0 9\nf 1 2 3\nf 2 3 4\nf 1 1 2\n";
        let model = load_bytes("far.obj", far, &cullet_io::LoadOptions::default()).unwrap();
        assert_ne!(model.scene.origin(), [0.0; 3]);
        same(&model);
    }

    #[test]
    fn instances_with_bounds_of_their_own_keep_them() {
        let mut model = cullet_scenes::build("solids").unwrap();
        let handles: Vec<_> =
            model.scene.slots().filter_map(|s| model.scene.handle(s)).take(2).collect();
        model.scene.set_bounds(handles[0], BoundsOverride::None).unwrap();
        let given = Aabb { min: [-9.0; 3], max: [9.0; 3] };
        model.scene.set_bounds(handles[1], BoundsOverride::World(given)).unwrap();
        model.scene.commit(&cullet::Culler::default());
        let back = Unpacker::new(pack(&model)).unwrap().finish().unwrap();
        let slot = |n: usize| model.scene.slot(handles[n]).unwrap();
        assert_eq!(back.scene.bounds(slot(1)), given);
        let slot = slot(0) as usize;
        assert_eq!(back.scene.exempt()[slot / 64] >> (slot % 64) & 1, 1);
    }

    /// A wall, and behind it a row of instances.
    fn walled() -> Model {
        let slab = |half: [f32; 3]| {
            let corner =
                |i: usize| [0, 1, 2].map(|a| if i >> a & 1 == 1 { half[a] } else { -half[a] });
            let faces: [[u32; 4]; 6] = [
                [0, 4, 6, 2],
                [1, 3, 7, 5],
                [0, 1, 5, 4],
                [2, 6, 7, 3],
                [0, 2, 3, 1],
                [4, 5, 7, 6],
            ];
            let indices = faces.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect();
            let positions = (0..8).map(corner).collect();
            Mesh::new(MeshData { positions, indices, ..MeshData::default() }).unwrap()
        };
        let mut model = Model { name: "wall".to_owned(), ..Model::default() };
        let wall = model.scene.add_mesh(slab([10.0, 10.0, 0.5]));
        let slab_mesh = model.scene.add_mesh(slab([0.3; 3]));
        model.scene.add(Instance::new(wall, Transform::IDENTITY)).unwrap();
        for x in -8..=8 {
            let place = Transform::from_translation([f64::from(x), 0.0, -20.0]);
            model.scene.add(Instance::new(slab_mesh, place)).unwrap();
        }
        model.scene.commit(&cullet::Culler::default());
        model
    }

    #[test]
    fn a_given_occluder_arrives_and_hides_as_much() {
        let mut model = walled();
        let hidden = |model: &Model| {
            let view = View::perspective([0.0, 0.0, 30.0], [0.0; 3], 1.0, 0.1, 1e3, [320, 200]);
            let culler = cullet::Culler::default().with_occlusion(Occlusion::default());
            let mut visible = Visible::default();
            model.in_cells().cull(&culler, &view.unwrap(), &mut ViewState::default(), &mut visible);
            visible.funnel.dropped(cullet::Stage::Occlusion).instances
        };
        assert_eq!(hidden(&model), 17, "by the wall itself");
        // Its left half, as one baked it; and for near eyes its triangles.
        let half = Aabb::new([-9.0, -9.0, -0.4], [0.0, 9.0, 0.4]);
        let body = Shape::Convex(Convex::from_box(&half).unwrap());
        let wall = &model.scene.meshes()[0];
        let patch = Patch::cut(wall.positions(), wall.indices(), Patch::FACETS, true).unwrap();
        let near = patch.into_iter().map(Shape::Patch).collect();
        let given = Occluder::new(vec![body]).with_sealed(vec![half]).with_near(near);
        model.scene.set_occluder(0, given);
        let by_half = hidden(&model);
        assert!((5..=9).contains(&by_half), "{by_half}");
        let back = Unpacker::new(pack(&model)).unwrap().finish().unwrap();
        let given = |m: &Model| m.scene.prepared()[0].given_occluder().cloned();
        assert!(given(&model).is_some_and(|o| o.shapes().len() == 2));
        assert_eq!(given(&back), given(&model));
        assert!(back.scene.prepared()[1].given_occluder().is_none(), "none was given");
        assert_eq!(hidden(&back), by_half);
    }

    #[test]
    fn bytes_that_end_early_or_lie_are_errors() {
        let bytes = pack(&cullet_scenes::build("solids").unwrap());
        for at in (0..bytes.len()).step_by(997).chain(0..200) {
            let short = Unpacker::new(bytes[..at].to_vec()).and_then(Unpacker::finish);
            assert!(matches!(short, Err(UnpackError::Short(_))), "{at}: {short:?}");
        }
        for at in (0..bytes.len()).step_by(1009) {
            let mut lying = bytes.clone();
            lying[at] ^= 0xff;
            // Whatever comes of it, it is no panic and no vast allocation.
            let _ = Unpacker::new(lying).and_then(Unpacker::finish);
        }
    }
}
