//! Building a model, mesh by mesh, under the limits of the options.

use cullet::mesh::MeshData;
use cullet::{Instance, InstanceFlags, Mesh, MeshId, Transform};

use crate::{ErrorKind, LoadOptions, Material, Model, Up, Warning};

/// A model that is being loaded.
#[derive(Debug)]
pub(crate) struct Builder<'a> {
    options: &'a LoadOptions,
    triangles: u64,
    /// What the file has; finished by [`finish`](Self::finish).
    pub(crate) model: Model,
}

impl<'a> Builder<'a> {
    pub(crate) fn new(name: &str, options: &'a LoadOptions) -> Self {
        let model = Model { name: name.to_owned(), ..Model::default() };
        Self { options, triangles: 0, model }
    }

    /// The rotation that takes the file's up axis to +Y.
    pub(crate) fn up(&self) -> Transform {
        match self.options.up.unwrap_or_default() {
            Up::Y => Transform::IDENTITY,
            Up::Z => Transform {
                linear: [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]],
                ..Transform::IDENTITY
            },
        }
    }

    /// Notes something odd.
    pub(crate) fn warn(&mut self, item: impl Into<String>, message: impl Into<String>) {
        self.model.warnings.push(Warning { item: item.into(), message: message.into() });
    }

    /// Adds a material; returns its number.
    pub(crate) fn material(&mut self, name: impl Into<String>, color: [f32; 4]) -> u32 {
        self.model.materials.push(Material { name: name.into(), color });
        (self.model.materials.len() - 1) as u32
    }

    /// Refuses more triangles than the options allow, counting those of earlier meshes.
    #[inline]
    pub(crate) fn check_triangles(&self, more: usize) -> Result<(), ErrorKind> {
        let count = self.triangles + more as u64;
        over_limit("triangles", count, self.options.max_triangles)
    }

    /// Adds a mesh and decides its sides: as the options say, else one-sided if it is a solid.
    pub(crate) fn mesh(&mut self, name: String, data: MeshData) -> Result<MeshId, ErrorKind> {
        self.check_triangles(data.indices.len() / 3)?;
        self.triangles += (data.indices.len() / 3) as u64;
        let mut mesh = Mesh::new(data)
            .map_err(|e| ErrorKind::invalid(format!("mesh \"{name}\""), e.to_string()))?;
        let two_sided = self.options.two_sided.unwrap_or_else(|| mesh.solid().is_err());
        mesh.set_two_sided(two_sided);
        self.model.mesh_names.push(name);
        Ok(self.model.scene.add_mesh(mesh))
    }

    /// Adds an instance at a transform of the file; its up axis is applied here.
    pub(crate) fn instance(
        &mut self,
        name: String,
        mesh: MeshId,
        transform: &Transform,
        flags: InstanceFlags,
    ) -> Result<cullet::Handle, ErrorKind> {
        let count = u64::from(self.model.scene.slot_count()) + 1;
        over_limit("instances", count, self.options.max_instances)?;
        let instance = Instance { flags, ..Instance::new(mesh, compose(&self.up(), transform)) };
        let handle = self
            .model
            .scene
            .add(instance)
            .map_err(|e| ErrorKind::invalid(format!("instance \"{name}\""), e.to_string()))?;
        self.model.instance_names.push(name);
        Ok(handle)
    }

    /// Adds a mesh with one instance of the same name, where the file has it.
    pub(crate) fn mesh_instance(&mut self, name: String, data: MeshData) -> Result<(), ErrorKind> {
        let mesh = self.mesh(name.clone(), data)?;
        self.instance(name, mesh, &Transform::IDENTITY, InstanceFlags::default())?;
        Ok(())
    }

    /// The model, its scene committed.
    pub(crate) fn finish(mut self) -> Model {
        if self.triangles == 0 {
            self.warn("file", "it has no triangles, so there is nothing to see or cull");
        }
        self.model.scene.commit();
        self.model
    }
}

fn over_limit(item: &str, count: u64, limit: u64) -> Result<(), ErrorKind> {
    if count > limit {
        return Err(ErrorKind::OverLimit { item: item.to_owned(), count, limit });
    }
    Ok(())
}

/// `outer` after `inner`. Exact where `outer` only permutes and flips axes, as that of the up axis does.
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

/// The colour of what has no material.
pub(crate) const GREY: [f32; 4] = [0.8, 0.8, 0.8, 1.0];

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
    fn instances_have_a_limit() {
        let options = LoadOptions { max_instances: 1, ..LoadOptions::default() };
        let mut builder = Builder::new("", &options);
        builder.mesh_instance("a".into(), MeshData::default()).unwrap();
        let error = builder.mesh_instance("b".into(), MeshData::default()).unwrap_err();
        assert_eq!(error.to_string(), "instances: 2 exceeds the limit of 1");
    }
}
