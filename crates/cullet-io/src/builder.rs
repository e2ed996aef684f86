//! Building a model, mesh by mesh, under the limits of the options.

use cullet::bounds::Aabb;
use cullet::mesh::MeshData;
use cullet::{Instance, Mesh, MeshId, Transform};

use crate::{Attributes, ErrorKind, LoadOptions, Material, Model, Up, Warning};

/// A model that is being loaded: what was read, free of the file's bytes. Meshes and instances are
/// made only by [`finish`](Self::finish), so that the file can be freed before.
#[derive(Debug)]
pub struct Builder<'a> {
    options: &'a LoadOptions,
    /// Whether it is a map: see [`for_map`](Self::for_map).
    map: bool,
    triangles: u64,
    meshes: Vec<(String, MeshData)>,
    instances: Vec<(String, Instance)>,
    /// All else that the file has.
    pub model: Model,
}

impl<'a> Builder<'a> {
    /// A builder of a model of this name.
    pub fn new(name: &str, options: &'a LoadOptions) -> Self {
        let model = Model { name: name.to_owned(), ..Model::default() };
        Self { options, map: false, triangles: 0, meshes: Vec::new(), instances: Vec::new(), model }
    }

    /// For a map: z is up where the options do not say, parts say which sides they have, and a mesh
    /// is a piece of a whole, so that its size says nothing of how exact its corners must be.
    pub fn for_map(self) -> Self {
        Self { map: true, ..self }
    }

    /// The rotation that takes the file's up axis to +Y.
    pub fn up(&self) -> Transform {
        let own = if self.map { Up::Z } else { Up::Y };
        match self.options.up.unwrap_or(own) {
            Up::Y => Transform::IDENTITY,
            Up::Z => Transform {
                linear: [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]],
                ..Transform::IDENTITY
            },
        }
    }

    /// Adds a warning.
    pub fn warn(&mut self, item: impl Into<String>, message: impl Into<String>) {
        self.model.warnings.push(Warning { item: item.into(), message: message.into() });
    }

    /// Adds a material; returns its number.
    pub fn material(&mut self, name: impl Into<String>, color: [f32; 4]) -> u32 {
        self.model.materials.push(Material { name: name.into(), color });
        (self.model.materials.len() - 1) as u32
    }

    /// Refuses more triangles than the options allow, counting those of earlier meshes.
    #[inline]
    pub fn check_triangles(&self, more: usize) -> Result<(), ErrorKind> {
        let count = self.triangles + more as u64;
        over_limit("triangles", count, self.options.max_triangles)
    }

    /// Adds a mesh.
    pub fn mesh(&mut self, name: String, mut data: MeshData) -> Result<MeshId, ErrorKind> {
        self.check_triangles(data.indices.len() / 3)?;
        // A model keeps its arrays; what they were given beyond their need is freed.
        data.positions.shrink_to_fit();
        data.indices.shrink_to_fit();
        self.triangles += (data.indices.len() / 3) as u64;
        self.meshes.push((name, data));
        Ok((self.meshes.len() - 1) as MeshId)
    }

    /// Keeps what the vertices of the mesh that is added next have; those of meshes before it that
    /// brought nothing are empty.
    pub fn attributes(&mut self, mut attributes: Attributes) {
        let bad = attributes.mend();
        if bad > 0 {
            self.warn(
                "file",
                format!("{bad} normals, texture coordinates or colours are not finite: left out"),
            );
        }
        self.model.attributes.resize(self.meshes.len(), Attributes::default());
        self.model.attributes.push(attributes);
    }

    /// Whether attributes are wanted.
    pub fn keeps_details(&self) -> bool {
        self.options.details
    }

    /// Adds an instance as it is in the file, but for the bounds; its up axis is applied here.
    pub fn instance(&mut self, name: String, instance: Instance) -> Result<(), ErrorKind> {
        let count = self.instances.len() as u64 + 1;
        over_limit("instances", count, self.options.max_instances)?;
        let transform = compose(&self.up(), &instance.transform);
        self.instances.push((name, Instance { transform, ..instance }));
        Ok(())
    }

    /// Adds a mesh with one instance of the same name, where the file has it.
    pub fn mesh_instance(&mut self, name: String, data: MeshData) -> Result<(), ErrorKind> {
        self.mesh_instance_at(name, data, [0.0; 3])
    }

    /// Adds a mesh whose positions are from an origin, with one instance there.
    pub fn mesh_instance_at(
        &mut self,
        name: String,
        data: MeshData,
        origin: [f64; 3],
    ) -> Result<(), ErrorKind> {
        let mesh = self.mesh(name.clone(), data)?;
        let transform = Transform { translation: origin, ..Transform::IDENTITY };
        self.instance(name, Instance::new(mesh, transform))
    }

    /// The model, its scene sorted. Decides the sides of each mesh: as the options say, else as its
    /// parts say in a map, else one-sided if it is a solid.
    pub fn finish(mut self) -> Result<Model, ErrorKind> {
        if self.triangles == 0 {
            self.warn("file", "it has no triangles, so there is nothing to see or cull");
        }
        let Self { options, map, meshes, instances, mut model, .. } = self;
        for (name, data) in meshes {
            let invalid = |message: String| ErrorKind::invalid(format!("mesh \"{name}\""), message);
            let mut mesh = Mesh::new(data).map_err(|e| invalid(e.to_string()))?;
            match options.two_sided {
                None if map => {}
                said => {
                    mesh.set_two_sided(said.unwrap_or_else(|| cullet_mesh::solid(&mesh).is_err()));
                }
            }
            if let Some(message) = coarse(&mesh.bounds()).filter(|_| !map) {
                let item = format!("mesh \"{name}\"");
                model.warnings.push(Warning { item, message });
            }
            model.mesh_names.push(name);
            model.scene.add_mesh(mesh);
        }
        for (name, instance) in instances {
            let invalid =
                |message: String| ErrorKind::invalid(format!("instance \"{name}\""), message);
            model.scene.add(instance).map_err(|e| invalid(e.to_string()))?;
            model.instance_names.push(name);
        }
        model.scene.sort();
        Ok(model)
    }
}

/// Warning about a mesh so far from 0 that f32 is coarse for its size; national grids are the usual
/// cause.
fn coarse(bounds: &Aabb) -> Option<String> {
    /// Steps of f32 across the mesh, below which shapes begin to look crumpled.
    const STEPS: f32 = 20_000.0;
    if bounds.is_empty() {
        return None;
    }
    let far = bounds.min.iter().chain(&bounds.max).fold(0.0f32, |m, v| m.max(v.abs()));
    let size = (0..3).fold(0.0f32, |m, a| m.max(bounds.max[a] - bounds.min[a]));
    let step = far.next_up() - far;
    (size > 0.0 && size < step * STEPS).then(|| {
        format!(
            "it is {size} units large but {far} units from 0, where 32-bit coordinates have steps of \
             {step}; move it nearer to 0 before it is exported"
        )
    })
}

fn over_limit(item: &str, count: u64, limit: u64) -> Result<(), ErrorKind> {
    if count > limit {
        return Err(ErrorKind::OverLimit { item: item.to_owned(), count, limit });
    }
    Ok(())
}

/// `outer` after `inner`. Exact where `outer` only permutes and flips axes, as that of the up axis
/// does.
fn compose(outer: &Transform, inner: &Transform) -> Transform {
    let column = |v: [f64; 3]| -> [f64; 3] {
        std::array::from_fn(|r| (0..3).map(|c| f64::from(outer.linear[c][r]) * v[c]).sum())
    };
    let translation = column(inner.translation);
    Transform {
        linear: inner.linear.map(|c| column(c.map(f64::from)).map(|v| v as f32)),
        translation: std::array::from_fn(|r| translation[r] + outer.translation[r]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn z_up_becomes_y_up() {
        let options = LoadOptions { up: Some(Up::Z), ..LoadOptions::default() };
        let up = Builder::new("", &options).up();
        let inner = Transform::from_scale_translation([2.0, 3.0, 4.0], [10.0, 20.0, 30.0]);
        let t = compose(&up, &inner);
        // (x, y, z) becomes (x, z, −y).
        assert_eq!(t.translation, [10.0, 30.0, -20.0]);
        assert_eq!(t.linear, [[2.0, 0.0, 0.0], [0.0, 0.0, -3.0], [0.0, 4.0, 0.0]]);
        assert_eq!(compose(&Transform::IDENTITY, &inner), inner);
    }

    #[test]
    fn meshes_far_from_zero_are_noted() {
        let at =
            |x: f32, size: f32| coarse(&Aabb { min: [x, 0.0, 0.0], max: [x + size, 1.0, 1.0] });
        assert_eq!(at(0.0, 10.0), None);
        assert_eq!(at(447_000.0, 1_000.0), None);
        assert!(at(447_000.0, 30.0).is_some_and(|m| m.contains("steps of 0.03125")));
        assert_eq!(coarse(&Aabb::EMPTY), None);
    }

    #[test]
    fn instances_have_a_limit() {
        let options = LoadOptions { max_instances: 1, ..LoadOptions::default() };
        let mut builder = Builder::new("", &options);
        builder.mesh_instance("a".into(), MeshData::default()).unwrap();
        let error = builder.mesh_instance("b".into(), MeshData::default()).unwrap_err();
        assert_eq!(error.to_string(), "instances: 2 exceeds the limit of 1");
    }
}
