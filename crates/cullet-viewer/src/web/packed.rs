//! A model as bytes, to go from the worker that parsed it to the page that shows it.
//!
//! Both run the same program, so this is no file format: there is no version, and nothing of it outlives a
//! message. Even so every count is held against the bytes there are.

use cullet::bounds::Aabb;
use cullet::mesh::{Alpha, Cluster, Clustering, MeshData, Part};
use cullet::{
    BoundsOverride, Handle, Instance, InstanceFlags, Mesh, Preparation, Projection, Transform,
};
use cullet_io::{CameraNode, Cell, Material, MatrixView, Model, NodeTree, Portal, Warning};
use thiserror::Error;

use super::bytes::{Reader, Writer};
use crate::sides::KeptBacks;
use crate::world::{Counts, Measures, at_rest};

/// Why bytes make no model, nor anything else that was packed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum UnpackError {
    /// They end before what they promise.
    #[error("the packed bytes end early, at byte {0}")]
    Short(usize),
    /// What they say cannot be.
    #[error("the packed bytes are damaged: {0}")]
    Damaged(String),
}

/// Packs all of a model but how it moves, which is told as a warning: what moves stands as it is stored. Instances come
/// in the order of their slots, so that nobody need sort them again; the handle of each is its place among them.
/// Costs a copy of everything.
#[must_use]
pub fn pack(model: &Model) -> Vec<u8> {
    let Model { name, scene, mesh_names, node_tree, .. } = model;
    let slots: Vec<(u32, Handle)> =
        scene.slots().filter_map(|slot| Some((slot, scene.handle(slot)?))).collect();
    let node_of = |handle: Handle| node_tree.node_of_instance.get(handle.index as usize);
    let nodes: Vec<u32> =
        slots.iter().map(|&(_, h)| node_of(h).copied().unwrap_or(NodeTree::NONE)).collect();
    let mut out = Writer::default();
    out.text(name);
    out.texts(mesh_names);
    out.pods(&node_tree.parents);
    out.pods(if node_tree.node_of_instance.is_empty() { &[] } else { &nodes });
    out.list(&model.materials, |out, m| {
        out.text(&m.name);
        out.pod(m.color);
    });
    out.list(&model.cameras, |out, c| {
        out.text(&c.name);
        let (kind, values) = numbers(&c.projection);
        out.pod(kind);
        out.pod(values);
        out.list(&c.keys, |out, (time, at)| {
            out.pod(*time);
            transform(out, at);
        });
    });
    out.list(&model.views, |out, v| {
        out.text(&v.name);
        out.pod(v.clip_from_world);
        out.pod(v.eye);
        out.pod(v.near);
    });
    out.list(&model.cells.cells, |out, c| {
        out.text(&c.name);
        out.pod([c.min, c.max]);
    });
    out.list(&model.cells.portals, |out, p| {
        out.pod(p.cells);
        out.pods(&p.polygon);
        let place = |h| slots.iter().position(|&(_, handle)| handle == h);
        // A door that is not there any more is none of these.
        out.pod(p.door.map_or([0; 2], |h| [1, place(h).map_or(u32::MAX, |p| p as u32)]));
        out.pod(u32::from(p.closed));
    });
    // First, for only the first warnings are shown.
    let warnings: Vec<Warning> = at_rest(model).into_iter().chain(model.warnings.clone()).collect();
    out.list(&warnings, |out, w| {
        out.text(&w.item);
        out.text(&w.message);
    });
    out.pod(scene.origin());
    let Measures { counts, reach, centre, half, kept_backs } = Measures::of(model);
    let Counts { meshes, instances, vertices, triangles, clusters } = counts;
    out.pod([meshes, instances, vertices, triangles, clusters]);
    out.pod([reach, centre[0], centre[1], centre[2], half[0], half[1], half[2]]);
    let KeptBacks { two_sided, moving, meshes, most, why } = kept_backs;
    out.pod([two_sided, moving, meshes]);
    out.text(&most);
    out.text(&why);
    out.list(scene.meshes(), mesh);
    // As they are called here, where their handles are others.
    out.list(&slots, |out, &(_, handle)| out.text(&model.instance_name(handle)));
    out.texts(&node_tree.names);
    out.list(&slots, |out, &(slot, _)| {
        let flags = scene.flags(slot);
        let bits = [
            flags.always_visible,
            flags.no_occlusion,
            flags.double_sided,
            flags.transparent,
            flags.dynamic,
            scene.exempt().get(slot as usize / 64).is_some_and(|w| w >> (slot % 64) & 1 == 1),
        ];
        let bits = bits.iter().rev().fold(0u32, |all, &bit| all << 1 | u32::from(bit));
        out.pod([scene.mesh_id(slot), scene.layers(slot), bits]);
        transform(out, scene.transform(slot));
        let bounds = scene.bounds(slot);
        out.pod([bounds.min, bounds.max]);
    });
    out.bytes
}

fn numbers(projection: &Projection) -> (u32, [f64; 6]) {
    match *projection {
        Projection::Perspective { fov_y_radians, aspect, near, far } => {
            (0, [fov_y_radians, aspect, near, far, 0.0, 0.0])
        }
        Projection::OffCentre { left, right, bottom, top, near, far } => {
            (1, [left, right, bottom, top, near, far])
        }
        Projection::Orthographic { left, right, bottom, top, near, far } => {
            (2, [left, right, bottom, top, near, far])
        }
    }
}

fn projection(kind: u32, [left, right, bottom, top, near, far]: [f64; 6]) -> Option<Projection> {
    Some(match kind {
        0 => Projection::Perspective { fov_y_radians: left, aspect: right, near: bottom, far: top },
        1 => Projection::OffCentre { left, right, bottom, top, near, far },
        2 => Projection::Orthographic { left, right, bottom, top, near, far },
        _ => return None,
    })
}

fn transform(out: &mut Writer, t: &Transform) {
    out.pod(t.linear);
    out.pod(t.translation);
}

fn mesh(out: &mut Writer, mesh: &Mesh) {
    let data = mesh.to_data();
    out.pods(&data.positions);
    out.pods(&data.indices);
    out.list(&data.parts, |out, p| {
        let alpha = match p.alpha {
            Alpha::Opaque => 0,
            Alpha::Masked => 1,
            Alpha::Blended => 2,
        };
        out.pod([p.first_triangle, p.triangle_count, p.material, u32::from(p.two_sided), alpha]);
    });
    out.pod([data.polygons, u32::from(data.deformable)]);
    // Cut into clusters already: making them takes most of the time.
    let drawn = (mesh.triangle_count() - mesh.degenerate_count()) as usize;
    out.pods(&mesh.original_triangle()[..drawn]);
    out.list(mesh.clusters(), |out, c| out.pod([c.first_triangle, c.triangle_count, c.part]));
}

/// Bytes of an instance.
const INSTANCE: usize = 96;
/// So many names or instances are one step: some milliseconds at the most.
const BATCH: usize = 4096;

/// What is unpacked next.
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
        let mut model = Model { name: from.text()?, mesh_names: from.texts()?, ..Model::default() };
        model.node_tree.parents = from.pods()?;
        model.node_tree.node_of_instance = from.pods()?;
        model.materials =
            from.list(|from| Ok(Material { name: from.text()?, color: from.pod()? }))?;
        model.cameras = from.list(|from| {
            let name = from.text()?;
            let (kind, values) = (from.pod()?, from.pod()?);
            let projection = projection(kind, values)
                .ok_or_else(|| UnpackError::Damaged(format!("projection {kind}")))?;
            let keys = from.list(|from| Ok((from.pod()?, place(from)?)))?;
            Ok(CameraNode { name, projection, keys })
        })?;
        model.views = from.list(|from| {
            let name = from.text()?;
            let (clip_from_world, eye, near) = (from.pod()?, from.pod()?, from.pod()?);
            Ok(MatrixView { name, clip_from_world, eye, near })
        })?;
        model.cells.cells = from.list(|from| {
            let name = from.text()?;
            let [min, max] = from.pod()?;
            Ok(Cell { name, min, max })
        })?;
        model.cells.portals = from.list(|from| {
            let (cells, polygon) = (from.pod()?, from.pods()?);
            let [some, index]: [u32; 2] = from.pod()?;
            let door = (some == 1).then_some(Handle { index, generation: 0 });
            Ok(Portal { cells, polygon, door, closed: from.pod::<u32>()? == 1 })
        })?;
        model.warnings =
            from.list(|from| Ok(Warning { item: from.text()?, message: from.text()? }))?;
        let origin = from.pod()?;
        // Before there is anything to move.
        model.scene.rebase(origin);
        let [meshes, instances, vertices, triangles, clusters]: [u64; 5] = from.pod()?;
        let [reach, x, y, z, w, h, d]: [f64; 7] = from.pod()?;
        let counts = Counts { meshes, instances, vertices, triangles, clusters };
        let [two_sided, moving, meshes]: [u64; 3] = from.pod()?;
        let kept_backs =
            KeptBacks { two_sided, moving, meshes, most: from.text()?, why: from.text()? };
        let measures = Measures { counts, reach, centre: [x, y, z], half: [w, h, d], kept_backs };
        let left = from.count(8)?;
        let at = from.at();
        Ok(Self { bytes, at, model, measures, phase: Phase::Meshes, left })
    }

    /// What the packed model measured.
    #[must_use]
    pub fn measures(&self) -> Measures {
        self.measures.clone()
    }

    /// Goes on a little: a mesh, with what culling prepares of it, or some thousand names or instances; `false` when
    /// all is there. Only the nodes over the instances are made all at once.
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
                    names.push(from.text()?);
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
            Phase::Meshes => (Phase::InstanceNames, from.count(8)?),
            Phase::InstanceNames => (Phase::NodeNames, from.count(8)?),
            Phase::NodeNames => (Phase::Instances, from.count(INSTANCE)?),
            Phase::Instances => {
                self.model.scene.commit_in_order();
                self.model.scene.prepare(Preparation::default());
                (Phase::Done, 0)
            }
            Phase::Done => (Phase::Done, 0),
        };
        self.at = from.at();
        Ok(self.phase != Phase::Done)
    }

    fn mesh(&mut self) -> Result<(), UnpackError> {
        let mut from = Reader::new(&self.bytes, self.at);
        let (positions, indices) = (from.pods()?, from.pods()?);
        let parts = from.list(|from| {
            let [first_triangle, triangle_count, material, two_sided, alpha]: [u32; 5] =
                from.pod()?;
            let alpha = match alpha {
                0 => Alpha::Opaque,
                1 => Alpha::Masked,
                _ => Alpha::Blended,
            };
            Ok(Part { first_triangle, triangle_count, material, two_sided: two_sided == 1, alpha })
        })?;
        let [polygons, deformable]: [u32; 2] = from.pod()?;
        let order = from.pods()?;
        let clusters = from.list(|from| {
            let [first_triangle, triangle_count, part] = from.pod()?;
            Ok(Cluster { first_triangle, triangle_count, part })
        })?;
        self.at = from.at();
        let data = MeshData { positions, indices, parts, polygons, deformable: deformable == 1 };
        let mesh = Mesh::with_clusters(data, &Clustering { order, clusters })
            .map_err(|e| UnpackError::Damaged(e.to_string()))?;
        self.model.scene.add_mesh(mesh);
        Ok(())
    }

    /// Adds the next instances, with the bounds that they had. Those that were given, as those of what deforms are, are
    /// not those of the mesh.
    fn place(&mut self, count: usize) -> Result<(), UnpackError> {
        let wrong = |e: cullet::SceneError| UnpackError::Damaged(e.to_string());
        let mut from = Reader::new(&self.bytes, self.at);
        let scene = &mut self.model.scene;
        for _ in 0..count {
            let Packed { instance, none, bounds } = Packed::read(&mut from)?;
            let own = if none { BoundsOverride::None } else { BoundsOverride::Mesh };
            let slot = scene.slot_count();
            let handle = scene.add(Instance { bounds: own, ..instance }).map_err(wrong)?;
            if !none && scene.bounds(slot) != bounds {
                scene.set_bounds(handle, BoundsOverride::World(bounds)).map_err(wrong)?;
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

/// An instance, and the box that the scene had for it.
struct Packed {
    instance: Instance,
    /// Whether it has no bounds.
    none: bool,
    bounds: Aabb,
}

impl Packed {
    fn read(from: &mut Reader<'_>) -> Result<Self, UnpackError> {
        let [mesh, layers, bits]: [u32; 3] = from.pod()?;
        let bit = |n: u32| bits >> n & 1 == 1;
        let flags = InstanceFlags {
            always_visible: bit(0),
            no_occlusion: bit(1),
            double_sided: bit(2),
            transparent: bit(3),
            dynamic: bit(4),
        };
        let place = place(from)?;
        let [min, max] = from.pod()?;
        let instance = Instance { layers, flags, ..Instance::new(mesh, place) };
        // What is exempt by its flag needs no other reason.
        let none = bit(5) && !flags.always_visible;
        Ok(Self { instance, none, bounds: Aabb { min, max } })
    }
}

fn place(from: &mut Reader<'_>) -> Result<Transform, UnpackError> {
    Ok(Transform { linear: from.pod()?, translation: from.pod()? })
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet::{View, ViewState, Visible};
    use cullet_io::{load_bytes, scenes};

    /// How many triangles are left of a view, and what dropped each instance.
    fn seen(model: &Model) -> (u64, usize, Vec<Option<&'static str>>) {
        let camera = &cullet_io::paths::cameras(
            model,
            &cullet_io::paths::PathSpec::Orbit,
            3,
            [320, 200],
            &cullet_io::paths::Overrides::default(),
        )
        .unwrap()[1];
        let view = View::new(camera, cullet::Depth::Reversed, [320, 200]).unwrap();
        let mut visible = Visible::default();
        let culler = cullet::Culler { reasons: true, ..cullet::Culler::default() };
        culler.cull_one(&model.scene, &view, &mut ViewState::default(), &mut visible);
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
            same(&scenes::build(text).unwrap());
        }
        let far = b"v 1e7 0 0\nv 1e7 1 0\nv 1.00001e7 0 0\nv 1e7 0 9\nf 1 2 3\nf 2 3 4\nf 1 1 2\n";
        let model = load_bytes("far.obj", far, &cullet_io::LoadOptions::default()).unwrap();
        assert_ne!(model.scene.origin(), [0.0; 3]);
        same(&model);
    }

    #[test]
    fn instances_with_bounds_of_their_own_keep_them() {
        let mut model = scenes::build("solids").unwrap();
        let handles: Vec<_> =
            model.scene.slots().filter_map(|s| model.scene.handle(s)).take(2).collect();
        model.scene.set_bounds(handles[0], BoundsOverride::None).unwrap();
        let given = Aabb { min: [-9.0; 3], max: [9.0; 3] };
        model.scene.set_bounds(handles[1], BoundsOverride::World(given)).unwrap();
        model.scene.commit();
        let back = Unpacker::new(pack(&model)).unwrap().finish().unwrap();
        let slot = |n: usize| model.scene.slot(handles[n]).unwrap();
        assert_eq!(back.scene.bounds(slot(1)), given);
        let slot = slot(0) as usize;
        assert_eq!(back.scene.exempt()[slot / 64] >> (slot % 64) & 1, 1);
    }

    #[test]
    fn bytes_that_end_early_or_lie_are_errors() {
        let bytes = pack(&scenes::build("solids").unwrap());
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
