//! Cutting every instance of a model.

use cullet::bounds::Plane;
use cullet::clip::cut::{CutOptions, Keep, cut_mesh};
use cullet::{Handle, Instance, Mesh, Scene, Transform};
use cullet_io::{Attributes, Material, Model, NodeTree};
use glam::{DMat3, DVec3};

use super::CutRecord;
use super::caps::caps;
use super::defects::OpenMesh;
use crate::console::{Console, interrupted};
use crate::exit::{Exit, Failure};
use crate::record::SCHEMA;

/// The colour of caps: the red of cut faces in drawings.
const CUT_FACE: [f32; 4] = [0.50, 0.065, 0.04, 1.0];

/// What to do.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Settings<'a> {
    /// In world space.
    pub(crate) planes: &'a [Plane],
    pub(crate) keep: Keep,
    pub(crate) cap: bool,
    /// A point in the open, in world space: what lies around it and is no solid is a shell, and gets no cap, which
    /// would close it.
    pub(crate) hollow: Option<[f64; 3]>,
    /// Whether the outlines are wanted, with caps or without.
    pub(crate) outlines: bool,
    /// In world units.
    pub(crate) heal: f64,
    /// In world units.
    pub(crate) weld: f64,
}

/// The outlines of one instance at one plane, in world space.
#[derive(Debug)]
pub(crate) struct Section {
    pub(crate) plane: usize,
    pub(crate) material: u32,
    pub(crate) outlines: Vec<Vec<[f64; 3]>>,
}

/// What came of it.
#[derive(Debug)]
pub(crate) struct Applied {
    pub(crate) model: Model,
    pub(crate) record: CutRecord,
    pub(crate) sections: Vec<Section>,
    /// Which instance each of what is left is of, by the index of its handle.
    pub(crate) origin: Vec<Handle>,
    /// For each mesh of what is left, which original triangle each of its triangles is of, caps of none; empty
    /// where the mesh is whole.
    pub(crate) triangles: Vec<Vec<u32>>,
    /// The material of caps.
    pub(crate) cap_material: u32,
}

/// Where an instance lies.
enum Place {
    Inside,
    Outside,
    Touched(Vec<Plane>),
}

pub(crate) fn apply(
    model: &Model,
    settings: &Settings<'_>,
    console: &Console,
) -> Result<Applied, Failure> {
    let scene = &model.scene;
    let mut out = Model {
        name: model.name.clone(),
        materials: model.materials.clone(),
        cameras: model.cameras.clone(),
        node_tree: NodeTree { node_of_instance: Vec::new(), ..model.node_tree.clone() },
        ..Model::default()
    };
    out.scene = Scene::new();
    out.scene.rebase(scene.origin());
    let cap_material = out.materials.len() as u32;
    let mut record = CutRecord {
        schema: SCHEMA,
        triangles_before: scene.triangle_count(),
        triangles_after: 0,
        cap_triangles: 0,
        cap_area: 0.0,
        instances_before: u64::from(scene.instance_count()),
        instances_untouched: 0,
        instances_cut: 0,
        instances_dropped: 0,
        duplicates_dropped: 0,
        open_chains: 0,
        open_edges: 0,
        open_meshes: Vec::new(),
        welded: 0,
        healed: 0,
        even_odd_outlines: 0,
        crossings: 0,
        folded_caps: 0,
    };
    let mut sections = Vec::new();
    let mut shared = vec![None; scene.meshes().len()];
    let mut progress = console.progress("cutting", record.instances_before);
    let inside = settings.keep == Keep::Inside;
    let none = Attributes::default();
    // In the order of the file: slots are sorted by place.
    let mut handles: Vec<Handle> = scene.slots().filter_map(|s| scene.handle(s)).collect();
    handles.sort_unstable_by_key(|h| h.index);
    let mut origin = Vec::new();
    let mut triangles = Vec::new();
    for handle in handles {
        let Ok(slot) = scene.slot(handle) else { continue };
        if interrupted() {
            let message = "interrupted; nothing was written".into();
            return Err(Failure { exit: Exit::Interrupted, message });
        }
        let (mesh, transform) = (scene.mesh(slot), scene.transform(slot));
        let number = scene.mesh_id(slot) as usize;
        let name = model.mesh_names.get(number).cloned().unwrap_or_default();
        let attributes = model.attributes.get(number).unwrap_or(&none);
        let made = match place(mesh, transform, settings.planes) {
            Place::Inside if inside => None,
            Place::Outside if !inside => None,
            Place::Inside | Place::Outside => {
                record.instances_dropped += 1;
                progress.step();
                continue;
            }
            Place::Touched(planes) => {
                let around = |p: [f64; 3]| {
                    let (b, origin) = (scene.bounds(slot), scene.origin());
                    (0..3).all(|i| {
                        (f64::from(b.min[i])..=f64::from(b.max[i])).contains(&(p[i] - origin[i]))
                    })
                };
                let shell = settings.hollow.is_some_and(around) && mesh.solid().is_err();
                let cap = settings.cap && !shell;
                let cut =
                    Cut { settings, cap, mesh, number, attributes, transform, planes: &planes };
                Some(cut.run(&name, cap_material, &mut record, &mut sections)?)
            }
        };
        let id = match made {
            None => {
                record.instances_untouched += 1;
                *shared[number].get_or_insert_with(|| {
                    out.mesh_names.push(name);
                    out.attributes.push(attributes.clone());
                    triangles.push(Vec::new());
                    out.scene.add_mesh(mesh.clone())
                })
            }
            Some(None) => {
                record.instances_dropped += 1;
                progress.step();
                continue;
            }
            Some(Some((mesh, attributes, of))) => {
                record.instances_cut += 1;
                out.mesh_names.push(name);
                out.attributes.push(attributes);
                triangles.push(of);
                out.scene.add_mesh(mesh)
            }
        };
        let instance = Instance {
            layers: scene.layers(slot),
            flags: scene.flags(slot),
            ..Instance::new(id, *transform)
        };
        out.scene.add(instance).map_err(|e| Failure::input(e.to_string()))?;
        out.instance_names.push(model.instance_name(handle).into());
        origin.push(handle);
        // Handles count up from 0 in the order of adding.
        let node = model.node_tree.node_of_instance.get(handle.index as usize);
        out.node_tree.node_of_instance.push(node.copied().unwrap_or(NodeTree::NONE));
        progress.step();
    }
    if record.cap_triangles > 0 {
        out.materials.push(Material { name: "cut face".into(), color: CUT_FACE });
    }
    out.scene.commit();
    record.triangles_after = out.scene.triangle_count();
    Ok(Applied { model: out, record, sections, origin, triangles, cap_material })
}

/// Moves the planes into the space of a mesh, and sees whether they touch its box at all.
fn place(mesh: &Mesh, transform: &Transform, planes: &[Plane]) -> Place {
    let columns = transform.linear.map(|c| DVec3::from(c.map(f64::from)));
    let linear = DMat3::from_cols(columns[0], columns[1], columns[2]);
    let b = mesh.bounds();
    let mut moved = Vec::with_capacity(planes.len());
    let mut inside = true;
    for plane in planes {
        let n = DVec3::from(plane.normal);
        let local = linear.transpose() * n;
        let d = plane.d - n.dot(DVec3::from(transform.translation));
        // A transform that flattens everything along the normal, or is not finite: one side holds all.
        if !Plane::new(local.into(), d).is_finite() || local.abs().max_element() < 1e-300 {
            if d < 0.0 {
                return Place::Outside;
            }
            continue;
        }
        let corners = (0..8).map(|i| {
            let pick = |a: usize| f64::from(if i >> a & 1 == 0 { b.min[a] } else { b.max[a] });
            DVec3::new(pick(0), pick(1), pick(2))
        });
        let size = local.abs().dot(DVec3::from(b.min.map(|v| f64::from(v.abs()))))
            + local.abs().dot(DVec3::from(b.max.map(|v| f64::from(v.abs()))))
            + d.abs();
        // Far above any rounding, so that what is near a plane is cut by the exact test.
        let slack = size * 1e-12;
        let span = corners
            .map(|p| local.dot(p) - d)
            .fold([f64::INFINITY, f64::NEG_INFINITY], |s, v| [s[0].min(v), s[1].max(v)]);
        if span[0] > slack {
            return Place::Outside;
        }
        inside &= span[1] < -slack;
        moved.push(Plane::new(local.into(), d));
    }
    if inside || moved.is_empty() { Place::Inside } else { Place::Touched(moved) }
}

/// One instance that planes touch.
struct Cut<'a> {
    settings: &'a Settings<'a>,
    cap: bool,
    mesh: &'a Mesh,
    /// Which of the scene's.
    number: usize,
    attributes: &'a Attributes,
    transform: &'a Transform,
    /// In the space of the mesh.
    planes: &'a [Plane],
}

impl Cut<'_> {
    /// What is left, and which original triangle each of it is of; `None` if nothing is.
    fn run(
        &self,
        name: &str,
        cap_material: u32,
        record: &mut CutRecord,
        sections: &mut Vec<Section>,
    ) -> Result<Option<(Mesh, Attributes, Vec<u32>)>, Failure> {
        let failed = |e: String| Failure::input(format!("mesh `{name}`: {e}"));
        let linear = self.transform.linear.map(|c| c.map(f64::from));
        let scale = linear.iter().flatten().map(|v| v * v).sum::<f64>().sqrt() / 3f64.sqrt();
        let [heal, weld] = [self.settings.heal, self.settings.weld]
            .map(|distance| if distance > 0.0 { (distance / scale) as f32 } else { 0.0 });
        let wanted = self.cap || self.settings.outlines;
        let caps = wanted.then(|| caps(self.attributes, heal, weld));
        let options = CutOptions { keep: self.settings.keep, caps };
        let (numbers, stride) = (self.attributes.interleaved(), self.attributes.stride());
        let done = cut_mesh(self.mesh, &numbers, stride, self.planes, &options, cap_material)
            .map_err(|e| failed(e.to_string()))?;
        let report = &done.cut.report;
        record.duplicates_dropped += report.duplicates as u64;
        record.open_chains += report.open_chains as u64;
        record.open_edges += report.open_edges as u64;
        OpenMesh::note(&mut record.open_meshes, self.number, name, self.mesh, report);
        record.welded += report.welded as u64;
        record.healed += report.healed as u64;
        record.even_odd_outlines += report.even_odd as u64;
        record.crossings += report.crossings as u64;
        record.folded_caps += report.folded as u64;
        let world = |p: [f32; 3]| -> [f64; 3] {
            let p = p.map(f64::from);
            std::array::from_fn(|i| {
                (0..3).map(|c| linear[c][i] * p[c]).sum::<f64>() + self.transform.translation[i]
            })
        };
        let material = self.mesh.parts().first().map_or(0, |p| p.material);
        for cap in done.cut.caps.iter().filter(|_| self.settings.outlines) {
            let outlines = done.cut.outlines(cap);
            let outlines =
                outlines.iter().map(|o| o.points.iter().map(|&p| world(p)).collect()).collect();
            sections.push(Section { plane: cap.plane, material, outlines });
        }
        let mut data = done.data;
        let caps: usize = done.cut.caps.iter().map(|c| c.triangles.len()).sum();
        if self.cap {
            record.cap_triangles += caps as u64;
            for t in data.indices[data.indices.len() - caps * 3..].chunks_exact(3) {
                let [a, b, c] =
                    [0, 1, 2].map(|i| DVec3::from(world(data.positions[t[i] as usize])));
                record.cap_area += (b - a).cross(c - a).length() * 0.5;
            }
        } else if caps > 0 {
            data.indices.truncate(data.indices.len() - caps * 3);
            data.parts.pop();
        }
        if data.indices.is_empty() {
            return Ok(None);
        }
        let mesh = Mesh::new(data).map_err(|e| failed(e.to_string()))?;
        Ok(Some((mesh, self.attributes.like(&done.cut.attributes), done.origin)))
    }
}
