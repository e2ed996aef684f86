//! Meshes: arrays of the caller's in, arrays in the order of draws out.

use engine::mesh::{Alpha, Part as EnginePart};
use engine::{Mesh, MeshData as EngineData};

use crate::memory::{Out, Plain, read, value};
use crate::scene::{SCENES, Scene};
use crate::status::{Error, Result, Status, call};

/// One-sided: only the fronts of its triangles are drawn, which are counter-clockwise. Only such
/// meshes have back faces to cull. Bit of `cullet_part.flags` and `cullet_mesh_arrays.flags`.
pub const CULLET_ONE_SIDED: u32 = 1;
/// Vertices may move (skinned, morphed): give instances bounds that hold every pose, and no cluster
/// of it is culled by itself. Bit of `cullet_mesh_arrays.flags`.
pub const CULLET_DEFORMABLE: u32 = 2;
/// The material is cut out by a threshold: it never hides anything. Bit of `cullet_part.flags` and
/// `cullet_mesh_arrays.flags`.
pub const CULLET_MASKED: u32 = 4;
/// The material is blended: it never hides anything. Bit of `cullet_part.flags` and
/// `cullet_mesh_arrays.flags`.
pub const CULLET_BLENDED: u32 = 8;

/// A range of a mesh's triangles with one material.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// First triangle of the range.
    pub first_triangle: u32,
    /// How many triangles.
    pub triangle_count: u32,
    /// A number of the caller's for the material; draws are sorted by it.
    pub material: u32,
    /// `CULLET_ONE_SIDED`, `CULLET_MASKED`, `CULLET_BLENDED`.
    pub flags: u32,
}

impl Plain for Part {}

/// A mesh to add: its arrays are copied. A struct of zeros with positions and indices is a mesh of
/// one opaque, two-sided part.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct MeshArrays {
    /// Vertices: three floats each, `3 * position_count` in all, finite.
    pub positions: *const f32,
    /// How many vertices.
    pub position_count: usize,
    /// Three a triangle, each below `position_count`.
    pub indices: *const u32,
    /// How many indices: a multiple of three.
    pub index_count: usize,
    /// Ranges of triangles, in order and without a gap; NULL for one part of all.
    pub parts: *const Part,
    /// How many parts; 0 for one part of all.
    pub part_count: usize,
    /// `CULLET_DEFORMABLE`; without parts also what a part's flags say.
    pub flags: u32,
    /// Material of the mesh where it has no parts.
    pub material: u32,
}

impl Plain for MeshArrays {}

/// How large a mesh of a scene is.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct MeshInfo {
    /// Vertices.
    pub position_count: usize,
    /// Indices: three a triangle, degenerate triangles included.
    pub index_count: usize,
    /// Parts.
    pub part_count: usize,
    /// Clusters: what culling finer than instances takes as a whole.
    pub cluster_count: usize,
    /// The lowest corner of its box.
    pub min: [f32; 3],
    /// The highest corner of its box.
    pub max: [f32; 3],
}

const PART_FLAGS: u32 = CULLET_ONE_SIDED | CULLET_MASKED | CULLET_BLENDED;

fn part(number: usize, part: Part) -> Result<EnginePart> {
    let Part { first_triangle, triangle_count, material, flags } = part;
    let alpha = match flags & (CULLET_MASKED | CULLET_BLENDED) {
        0 => Alpha::Opaque,
        CULLET_MASKED => Alpha::Masked,
        CULLET_BLENDED => Alpha::Blended,
        _ => {
            let message = format!("part {number} is both masked and blended (flags {flags:#x})");
            return Err(Error::value(message));
        }
    };
    if flags & !PART_FLAGS != 0 {
        let message = format!("flags of part {number} are {flags:#x}: there are {PART_FLAGS:#x}");
        return Err(Error::value(message));
    }
    let two_sided = flags & CULLET_ONE_SIDED == 0;
    Ok(EnginePart { first_triangle, triangle_count, material, two_sided, alpha })
}

/// The mesh of a scene.
pub(crate) fn mesh_of(scene: &engine::Scene, mesh: u32) -> Result<&Mesh> {
    let meshes = scene.meshes();
    meshes.get(mesh as usize).ok_or_else(|| {
        let message = format!("mesh {mesh}: the scene has {}", meshes.len());
        Error::new(Status::NotFound, message)
    })
}

/// Adds a mesh that instances may share, and writes its number, from 0 on. Cost: linear in its
/// triangles; what culling needs of it is made by the next `cullet_scene_commit`. Refused with
/// `CULLET_STATUS_MESH` where an index is beyond the vertices, a position is not finite, or the
/// parts do not cover the triangles in order.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_scene_add_mesh(
    scene: Scene,
    arrays: *const MeshArrays,
    mesh: *mut u32,
) -> Status {
    call("cullet_scene_add_mesh", || {
        // SAFETY: as the header asks of the caller.
        let arrays = unsafe { value("arrays", arrays) }?;
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::one("mesh", mesh) }?;
        let positions = arrays.positions.cast::<[f32; 3]>();
        // SAFETY: as the header asks of the caller.
        let positions = unsafe { read("positions", positions, arrays.position_count) }?;
        // SAFETY: as the header asks of the caller.
        let indices = unsafe { read("indices", arrays.indices, arrays.index_count) }?;
        // SAFETY: as the header asks of the caller.
        let given = unsafe { read("parts", arrays.parts, arrays.part_count) }?;
        let (flags, material) = (arrays.flags, arrays.material);
        let of_parts = if given.is_empty() { PART_FLAGS } else { 0 };
        if flags & !(CULLET_DEFORMABLE | of_parts) != 0 {
            let message = format!(
                "flags of the mesh are {flags:#x}: there are {:#x}; those of sides and blending belong to the parts where there are some",
                CULLET_DEFORMABLE | of_parts
            );
            return Err(Error::value(message));
        }
        let mut parts = Vec::new();
        for (number, &of) in given.iter().enumerate() {
            parts.push(part(number, of)?);
        }
        if given.is_empty() {
            let triangle_count = u32::try_from(indices.len() / 3).unwrap_or(u32::MAX);
            let flags = flags & PART_FLAGS;
            let whole = part(0, Part { first_triangle: 0, triangle_count, material, flags })?;
            // A mesh without triangles has no part, and the same flags are refused.
            parts.extend((!indices.is_empty()).then_some(whole));
        }
        let data = EngineData {
            positions: positions.to_vec(),
            indices: indices.to_vec(),
            parts,
            deformable: flags & CULLET_DEFORMABLE != 0,
            ..EngineData::default()
        };
        let made = Mesh::new(data).map_err(|e| Error::new(Status::Mesh, e.to_string()))?;
        out.set(0, SCENES.get_mut(scene.id)?.add_mesh(made));
        Ok(())
    })
}

/// Writes how large a mesh of a scene is.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_scene_mesh_info(
    scene: Scene,
    mesh: u32,
    info: *mut MeshInfo,
) -> Status {
    call("cullet_scene_mesh_info", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::one("info", info) }?;
        let scene = SCENES.get(scene.id)?;
        let mesh = mesh_of(&scene, mesh)?;
        let bounds = mesh.bounds();
        out.set(
            0,
            MeshInfo {
                position_count: mesh.positions().len(),
                index_count: mesh.indices().len(),
                part_count: mesh.parts().len(),
                cluster_count: mesh.clusters().len(),
                min: bounds.min,
                max: bounds.max,
            },
        );
        Ok(())
    })
}

/// Writes the geometry of a mesh as draws count it: its triangles are put into the order of
/// clusters once, when it is added, and `first_index` of a draw is of that order. Upload these
/// indices. `positions` takes three floats a vertex; the capacities are in floats and in indices.
/// Either array may be NULL with a capacity of 0: then it is left out.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_scene_mesh_read(
    scene: Scene,
    mesh: u32,
    positions: *mut f32,
    position_capacity: usize,
    indices: *mut u32,
    index_capacity: usize,
) -> Status {
    call("cullet_scene_mesh_read", || {
        // SAFETY: as the header asks of the caller.
        let mut positions = unsafe { Out::array("positions", positions, position_capacity) }?;
        // SAFETY: as the header asks of the caller.
        let mut indices = unsafe { Out::array("indices", indices, index_capacity) }?;
        let scene = SCENES.get(scene.id)?;
        let mesh = mesh_of(&scene, mesh)?;
        let short = |what, room: usize, needed: usize| {
            if room == 0 || room >= needed {
                return Ok(());
            }
            let message = format!("{what}: room for {room}, but {needed} are needed");
            Err(Error::new(Status::TooSmall, message))
        };
        let flat = mesh.positions().as_flattened();
        short("positions", positions.room(), flat.len())?;
        short("indices", indices.room(), mesh.indices().len())?;
        if positions.room() > 0 {
            positions.copy(flat);
        }
        if indices.room() > 0 {
            indices.copy(mesh.indices());
        }
        Ok(())
    })
}
