//! Scenes under ids: meshes and instances of them.

use alloc::format;
use alloc::vec::Vec;

use cullet::mesh::{Alpha, Part};
use cullet::{
    Handle, Instance, InstanceFlags, Mesh, MeshData, Scene, SceneError, Transform, draw::MeshPlace,
};

use crate::cells::Cells;
use crate::fault::{Code, Fault, has_room};

/// A scene, and the instances by their ids: the indices of their handles.
#[derive(Debug)]
pub struct SceneSet {
    pub(crate) scene: Scene,
    pub(crate) cells: Cells,
    handles: Vec<Option<Handle>>,
    pub(crate) places: Vec<MeshPlace>,
    ids: Vec<u32>,
    indices: Vec<u32>,
}

/// Flags of a mesh that a page sends.
#[derive(Clone, Copy, Debug)]
pub struct Kind(pub u32);

impl Kind {
    /// Only fronts are drawn.
    pub const ONE_SIDED: u32 = 1;
    /// Cut out by a threshold.
    pub const MASKED: u32 = 2;
    /// Blended.
    pub const BLENDED: u32 = 4;
    /// Vertices move within the bounds.
    pub const DEFORMABLE: u32 = 8;

    fn alpha(self) -> Alpha {
        match self.0 & (Self::MASKED | Self::BLENDED) {
            0 => Alpha::Opaque,
            Self::MASKED => Alpha::Masked,
            _ => Alpha::Blended,
        }
    }
}

impl SceneSet {
    /// An empty scene, or one that was read.
    pub fn new(scene: Scene) -> Self {
        let mut set = Self {
            scene,
            cells: Cells::default(),
            handles: Vec::new(),
            places: Vec::new(),
            ids: Vec::new(),
            indices: Vec::new(),
        };
        for slot in 0..set.scene.slot_count() {
            if let Some(handle) = set.scene.handle(slot) {
                set.note(handle);
            }
        }
        set
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    fn note(&mut self, handle: Handle) {
        let index = handle.index as usize;
        if self.handles.len() <= index {
            self.handles.resize(index + 1, None);
        }
        self.handles[index] = Some(handle);
    }

    /// The ids that there may be: all are below.
    pub fn id_count(&self) -> usize {
        self.handles.len()
    }

    /// The handle of an id.
    ///
    /// # Errors
    /// If there is no such instance, or it was removed.
    pub fn handle(&self, id: u32) -> Result<Handle, Fault> {
        let found = self.handles.get(id as usize).copied().flatten();
        found.ok_or_else(|| {
            let message = format!(
                "id {id} names no instance of this scene: it was removed, or is of another scene"
            );
            Fault::new(Code::Id, message)
        })
    }

    /// Adds a mesh of triangles. Parts are rows of how many triangles, material and [`Kind`]; none
    /// is one part of material 0 and of the given kind.
    ///
    /// # Errors
    /// If the engine refuses the mesh, or memory does not suffice.
    pub fn add_mesh(
        &mut self,
        positions: &[f32],
        indices: &[u32],
        parts: &[u32],
        kind: Kind,
    ) -> Result<u32, Fault> {
        // What is made of a mesh takes a multiple of what it is made from.
        if !has_room((positions.len() + indices.len()).saturating_mul(16)) {
            return Err(Fault::new(Code::Memory, "no memory for a mesh of this size"));
        }
        let (points, rest) = positions.as_chunks::<3>();
        if !rest.is_empty() {
            let message = format!("{} numbers do not make whole positions", positions.len());
            return Err(Fault::new(Code::Mesh, message));
        }
        let one = [[indices.len() as u32 / 3, 0, kind.0]];
        let rows = if parts.is_empty() { &one[..] } else { parts.as_chunks::<3>().0 };
        let mut first_triangle = 0_u32;
        let parts = rows.iter().map(|&[triangle_count, material, bits]| {
            let kind = Kind(bits);
            let first = first_triangle;
            first_triangle = first_triangle.saturating_add(triangle_count);
            Part {
                first_triangle: first,
                triangle_count,
                material,
                two_sided: bits & Kind::ONE_SIDED == 0,
                alpha: kind.alpha(),
            }
        });
        let data = MeshData {
            parts: parts.collect(),
            positions: points.to_vec(),
            indices: indices.to_vec(),
            deformable: kind.0 & Kind::DEFORMABLE != 0,
            ..MeshData::default()
        };
        let mesh = Mesh::new(data).map_err(|error| Fault::new(Code::Mesh, error))?;
        Ok(self.scene.add_mesh(mesh))
    }

    /// Adds instances of a mesh by column-major matrices; their ids lie at [`ids`](Self::ids).
    ///
    /// # Errors
    /// If there is no such mesh, or no room.
    pub fn add(
        &mut self,
        mesh: u32,
        matrices: &[f64],
        layers: u32,
        flags: u32,
    ) -> Result<(), Fault> {
        if !has_room(matrices.len().saturating_mul(32)) {
            return Err(Fault::new(Code::Memory, "no memory for as many instances"));
        }
        self.ids.clear();
        for matrix in matrices.as_chunks::<16>().0 {
            let instance = Instance {
                layers,
                flags: instance_flags(flags),
                ..Instance::new(mesh, Transform::from_matrix(matrix))
            };
            let handle = self.scene.add(instance).map_err(refused)?;
            self.note(handle);
            self.ids.push(handle.index);
        }
        Ok(())
    }

    /// The ids of the instances that were added last.
    pub fn ids(&self) -> &[u32] {
        &self.ids
    }

    /// Moves instances.
    ///
    /// # Errors
    /// At the first id that names nothing; those before it are moved.
    pub fn set_transforms(&mut self, ids: &[u32], matrices: &[f64]) -> Result<(), Fault> {
        for (&id, matrix) in ids.iter().zip(matrices.as_chunks::<16>().0) {
            let handle = self.handle(id)?;
            self.scene.set_transform(handle, Transform::from_matrix(matrix)).map_err(refused)?;
        }
        Ok(())
    }

    /// Sets layers and flags of an instance.
    ///
    /// # Errors
    /// If the id names nothing.
    pub fn set_state(&mut self, id: u32, layers: u32, flags: u32) -> Result<(), Fault> {
        let handle = self.handle(id)?;
        self.scene.set_layers(handle, layers).map_err(refused)?;
        self.scene.set_flags(handle, instance_flags(flags)).map_err(refused)
    }

    /// Removes an instance. Its id names nothing, until a later one takes it.
    ///
    /// # Errors
    /// If it names nothing already.
    pub fn remove(&mut self, id: u32) -> Result<(), Fault> {
        let handle = self.handle(id)?;
        self.handles[id as usize] = None;
        self.scene.remove(handle).map_err(refused)
    }

    /// Sorts, and prepares meshes that came since.
    pub fn commit(&mut self) {
        self.scene.commit(&cullet::Culler::default());
        self.cells.update(&self.scene);
    }

    /// Fits the nodes to what moved.
    pub fn refit(&mut self) {
        self.scene.refit();
        self.cells.update(&self.scene);
    }

    /// Says where the renderer's buffers hold a mesh.
    ///
    /// # Errors
    /// If there is no such mesh.
    pub fn set_place(
        &mut self,
        mesh: u32,
        first_index: u32,
        base_vertex: i32,
    ) -> Result<(), Fault> {
        self.mesh(mesh)?;
        if self.places.len() <= mesh as usize {
            // As the engine takes those that are not there.
            self.places.resize(mesh as usize + 1, MeshPlace::default());
        }
        self.places[mesh as usize] = MeshPlace { first_index, base_vertex };
        Ok(())
    }

    /// The indices of a mesh in the order that draws refer to.
    ///
    /// # Errors
    /// If there is no such mesh.
    pub fn indices(&mut self, mesh: u32) -> Result<&[u32], Fault> {
        let indices = self.mesh(mesh)?.indices().to_vec();
        self.indices = indices;
        Ok(&self.indices)
    }

    fn mesh(&self, mesh: u32) -> Result<&Mesh, Fault> {
        self.scene
            .meshes()
            .get(mesh as usize)
            .ok_or_else(|| refused(SceneError::NoMesh { mesh, meshes: self.scene.meshes().len() }))
    }
}

fn instance_flags(bits: u32) -> InstanceFlags {
    InstanceFlags {
        always_visible: bits & 1 != 0,
        no_occlusion: bits & 2 != 0,
        double_sided: bits & 4 != 0,
        transparent: bits & 8 != 0,
        dynamic: bits & 16 != 0,
    }
}

fn refused(error: SceneError) -> Fault {
    let code = match error {
        SceneError::NoInstance(_) | SceneError::NoMesh { .. } => Code::Id,
        _ => Code::Argument,
    };
    Fault::new(code, error)
}
