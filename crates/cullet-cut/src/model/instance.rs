//! The cut of one instance.

use cullet::bounds::Plane;
use cullet::{Mesh, Transform};
use cullet_io::Attributes;
use glam::DVec3;

use super::caps::caps;
use super::options::ModelOptions;
use super::report::ModelReport;
use crate::mesh::cut_mesh;
use crate::options::CutOptions;

/// The outlines of one instance at one plane, in world space.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Number of the plane.
    pub plane: usize,
    /// The material of the mesh's first part.
    pub material: u32,
    /// Each outline by its points; the last is joined to the first.
    pub outlines: Vec<Vec<[f64; 3]>>,
}

/// One instance that planes touch.
pub(super) struct InstanceCut<'a> {
    pub(super) options: &'a ModelOptions<'a>,
    /// Whether this one is closed.
    pub(super) cap: bool,
    pub(super) mesh: &'a Mesh,
    /// Number of the instance in the scene.
    pub(super) number: usize,
    pub(super) name: &'a str,
    pub(super) attributes: &'a Attributes,
    pub(super) transform: &'a Transform,
    /// Planes with their numbers, in the space of the mesh.
    pub(super) planes: &'a [(usize, Plane)],
}

/// An instance's mesh after a cut.
pub(super) struct Remainder {
    pub(super) mesh: Mesh,
    pub(super) attributes: Attributes,
    /// Original triangle of each triangle.
    pub(super) origin: Vec<u32>,
}

impl InstanceCut<'_> {
    /// Cuts; `None` if nothing is left. An error says in words what is wrong with the mesh.
    pub(super) fn run(
        &self,
        cap_material: u32,
        report: &mut ModelReport,
        sections: &mut Vec<Section>,
    ) -> Result<Option<Remainder>, String> {
        let linear = self.transform.linear.map(|c| c.map(f64::from));
        let scale = linear.iter().flatten().map(|v| v * v).sum::<f64>().sqrt() / 3f64.sqrt();
        let [heal, weld] = [self.options.heal, self.options.weld]
            .map(|distance| if distance > 0.0 { (distance / scale) as f32 } else { 0.0 });
        let wanted = self.cap || self.options.outlines;
        let caps = wanted.then(|| caps(self.attributes, heal, weld));
        let options = CutOptions { keep: self.options.keep, caps };
        let (numbers, stride) = (self.attributes.interleaved(), self.attributes.stride());
        let planes: Vec<Plane> = self.planes.iter().map(|p| p.1).collect();
        let done = cut_mesh(self.mesh, &numbers, stride, &planes, &options, cap_material)
            .map_err(|e| e.to_string())?;
        report.add(self.number, self.name, self.mesh, &done.cut.report);
        let world = |p: [f32; 3]| -> [f64; 3] {
            let p = p.map(f64::from);
            std::array::from_fn(|i| {
                (0..3).map(|c| linear[c][i] * p[c]).sum::<f64>() + self.transform.translation[i]
            })
        };
        let material = self.mesh.parts().first().map_or(0, |p| p.material);
        for cap in done.cut.caps.iter().filter(|_| self.options.outlines) {
            let outlines = done.cut.outlines(cap);
            let outlines =
                outlines.iter().map(|o| o.points.iter().map(|&p| world(p)).collect()).collect();
            sections.push(Section { plane: self.planes[cap.plane].0, material, outlines });
        }
        let mut data = done.data;
        let caps: usize = done.cut.caps.iter().map(|c| c.triangles.len()).sum();
        let walls = data.indices.len() - caps * 3;
        if self.cap {
            report.cap_triangles += caps as u64;
            for t in data.indices[walls..].chunks_exact(3) {
                let [a, b, c] =
                    [0, 1, 2].map(|i| DVec3::from(world(data.positions[t[i] as usize])));
                report.cap_area += (b - a).cross(c - a).length() * 0.5;
            }
        } else if caps > 0 {
            data.indices.truncate(walls);
            data.parts.pop();
        }
        if self.options.show_insides && (!self.cap || done.cut.report.open_edges > 0) {
            data.parts.iter_mut().for_each(|p| p.two_sided = true);
        }
        if data.indices.is_empty() {
            return Ok(None);
        }
        let mesh = Mesh::new(data).map_err(|e| e.to_string())?;
        let attributes = self.attributes.like(&done.cut.attributes);
        Ok(Some(Remainder { mesh, attributes, origin: done.origin }))
    }
}
