//! Results of a cull, copied into arrays of the caller's.
//!
//! Every call of this kind goes alike: `count` is always written, what fits is only written where
//! all fits, and an array of none asks for the count.

use std::ffi::{CStr, c_char};

use crate::cull::{Frame, STATES, State};
use crate::instance::Handle;
use crate::memory::{Out, Plain, read};
use crate::scene::{SCENES, Scene};
use crate::status::{Error, Result, Status, call};

/// Why an instance was culled.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reason {
    /// The stage, a `cullet_stage`; 0 for one that is visible.
    pub stage: u8,
    /// For the frustum the number of the plane that it is outside of; 255 where parts went for
    /// different ones.
    pub detail: u8,
}

impl Reason {
    pub(crate) fn of(reason: Option<engine::Reason>) -> Self {
        reason.map_or(Self { stage: 0, detail: 0 }, |r| Self {
            stage: r.stage as u8,
            detail: r.detail,
        })
    }
}

/// Kinds of culling, in the order in which they run.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub enum Stage {
    /// No stage: visible.
    Visible = 0,
    /// Layers that view and instance do not share.
    Layer = 1,
    /// Outside the frustum.
    Frustum = 2,
    /// Not in the potentially visible set of the eye's cell.
    Pvs = 3,
    /// Not seen through any portal.
    Portal = 4,
    /// Too small on the screen.
    Detail = 5,
    /// Another level of detail stands for it.
    Lod = 6,
    /// Behind something.
    Occlusion = 7,
    /// Seen from behind.
    Backface = 8,
    /// Without area.
    Degenerate = 9,
}

/// Numbers of instances, of their clusters and of their triangles.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counts {
    /// Instances.
    pub instances: u64,
    /// Clusters.
    pub clusters: u64,
    /// Triangles.
    pub triangles: u64,
}

/// Counts of one stage at one unit; what leaves a row enters the next.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FunnelRow {
    /// A `cullet_stage`.
    pub stage: u32,
    /// Unit that it tested: 0 instances, 1 clusters, 2 triangles.
    pub unit: u32,
    /// Counts in.
    pub entered: Counts,
    /// Counts out.
    pub left: Counts,
}

/// One indexed indirect draw, as Vulkan, Direct3D 12, Metal and WebGPU read it: 20 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub struct DrawCommand {
    /// How many indices.
    pub index_count: u32,
    /// How many instances.
    pub instance_count: u32,
    /// First index, in the order of `cullet_scene_mesh_read`, plus the place of the mesh.
    pub first_index: u32,
    /// Added to each index.
    pub base_vertex: i32,
    /// First entry of `instances`.
    pub first_instance: u32,
}

/// Two sides are drawn. Bit of `cullet_draw_key.state`.
pub const CULLET_DRAW_TWO_SIDED: u32 = 1;
/// The transform mirrors: fronts are clockwise on the screen. Bit of `cullet_draw_key.state`.
pub const CULLET_DRAW_MIRRORED: u32 = 2;
/// The material is cut out by a threshold. Bit of `cullet_draw_key.state`.
pub const CULLET_DRAW_MASKED: u32 = 4;
/// The material is blended: draws want an order from back to front. Bit of `cullet_draw_key.state`.
pub const CULLET_DRAW_BLENDED: u32 = 8;

/// Properties of a draw command: the same for all its instances.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub struct DrawKey {
    /// `CULLET_DRAW_TWO_SIDED` and so on.
    pub state: u32,
    /// The material.
    pub material: u32,
    /// The mesh.
    pub mesh: u32,
    /// The part of the mesh.
    pub part: u32,
    /// The level of detail.
    pub level: u32,
}

/// Where the renderer's buffers hold a mesh.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub struct MeshPlace {
    /// Where its indices begin.
    pub first_index: u32,
    /// Where its vertices begin.
    pub base_vertex: i32,
}

impl Plain for MeshPlace {}

/// Arrays that draws are written into. Capacities go in, counts come out.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Draws {
    /// Room for commands, sorted by key: opaque ones first, then by material and mesh.
    pub commands: *mut DrawCommand,
    /// Room for as many keys: one for each command.
    pub keys: *mut DrawKey,
    /// How many commands and keys there is room for.
    pub command_capacity: usize,
    /// How many there are.
    pub command_count: usize,
    /// Room for slots: the instances of each command are a range of them.
    pub instances: *mut u32,
    /// How many slots there is room for.
    pub instance_capacity: usize,
    /// How many there are.
    pub instance_count: usize,
    /// Room for indices, where the output is triangles; else not used.
    pub indices: *mut u32,
    /// How many indices there is room for.
    pub index_capacity: usize,
    /// How many there are; 0 where the output is not triangles.
    pub index_count: usize,
}

impl Plain for Draws {}

/// Writes `count` values, if there is room for all of them, and how many there are.
pub(crate) fn write<T: Copy>(
    out: &mut Out<T>,
    count: &mut Out<usize>,
    values: impl Iterator<Item = T>,
    needed: usize,
) -> Result {
    count.set(0, needed);
    if out.room() == 0 {
        return Ok(());
    }
    if out.room() < needed {
        let message = format!("room for {}, but there are {needed}", out.room());
        return Err(Error::new(Status::TooSmall, message));
    }
    for (at, value) in values.enumerate() {
        out.set(at, value);
    }
    Ok(())
}

/// The body of a call that reads one array of a state.
///
/// # Safety
/// As the header asks of the caller: `pointer` has room for `capacity`, and `count` for one.
unsafe fn read_state<T: Copy>(
    name: &'static str,
    state: State,
    (pointer, capacity): (*mut T, usize),
    count: *mut usize,
    body: impl FnOnce(&Frame, &mut Out<T>, &mut Out<usize>) -> Result,
) -> Status {
    call(name, || {
        // SAFETY: the caller's promise.
        let mut out = unsafe { Out::array("the array", pointer, capacity) }?;
        // SAFETY: the caller's promise.
        let mut count = unsafe { Out::one("count", count) }?;
        let frame = STATES.get(state.id)?;
        frame.check()?;
        body(&frame, &mut out, &mut count)
    })
}

/// Writes the slots of which something is visible, ascending, and how many there are. With a
/// capacity of 0 only `count` is written; where the capacity is too small, that alone is, with
/// `CULLET_STATUS_TOO_SMALL`. The instances of a scene are always enough. Slots change with a
/// commit; `cullet_visible_handles` gives names that do not.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_visible_slots(
    state: State,
    slots: *mut u32,
    capacity: usize,
    count: *mut usize,
) -> Status {
    let array = (slots, capacity);
    let body = |frame: &Frame, out: &mut Out<u32>, count: &mut Out<usize>| {
        write(out, count, frame.visible.slots(), frame.slot_count())
    };
    // SAFETY: as the header asks of the caller.
    unsafe { read_state("cullet_visible_slots", state, array, count, body) }
}

/// Returns the same as `cullet_visible_slots`, but handles, in the order of the slots. The scene
/// must be as it was culled.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_visible_handles(
    state: State,
    scene: Scene,
    handles: *mut Handle,
    capacity: usize,
    count: *mut usize,
) -> Status {
    let array = (handles, capacity);
    let body = |frame: &Frame, out: &mut Out<Handle>, count: &mut Out<usize>| {
        let scene = SCENES.get(scene.id)?;
        frame.check_scene(&scene)?;
        let handles = frame.visible.slots().filter_map(|slot| Some(scene.handle(slot)?.into()));
        write(out, count, handles, frame.slot_count())
    };
    // SAFETY: as the header asks of the caller.
    unsafe { read_state("cullet_visible_handles", state, array, count, body) }
}

/// Returns the same as `cullet_visible_slots`, but the callers' numbers (`cullet_instance.user`),
/// in the order of the slots. The scene must be as it was culled.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_visible_users(
    state: State,
    scene: Scene,
    users: *mut u64,
    capacity: usize,
    count: *mut usize,
) -> Status {
    let array = (users, capacity);
    let body = |frame: &Frame, out: &mut Out<u64>, count: &mut Out<usize>| {
        let scene = SCENES.get(scene.id)?;
        frame.check_scene(&scene)?;
        let users = frame.visible.slots().map(|slot| scene.user_data(slot));
        write(out, count, users, frame.slot_count())
    };
    // SAFETY: as the header asks of the caller.
    unsafe { read_state("cullet_visible_users", state, array, count, body) }
}

/// Writes why each slot was culled, one for each slot of the scene: stage 0 for what is visible,
/// and for empty slots. Needs `cullet_settings.reasons`; without, there are none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_visible_reasons(
    state: State,
    reasons: *mut Reason,
    capacity: usize,
    count: *mut usize,
) -> Status {
    let array = (reasons, capacity);
    let body = |frame: &Frame, out: &mut Out<Reason>, count: &mut Out<usize>| {
        let reasons = &frame.visible.reasons;
        write(out, count, reasons.iter().map(|&r| Reason::of(r)), reasons.len())
    };
    // SAFETY: as the header asks of the caller.
    unsafe { read_state("cullet_visible_reasons", state, array, count, body) }
}

/// Writes the counts in and out of each stage that ran; 32 rows are always enough.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_visible_funnel(
    state: State,
    rows: *mut FunnelRow,
    capacity: usize,
    count: *mut usize,
) -> Status {
    let array = (rows, capacity);
    let body = |frame: &Frame, out: &mut Out<FunnelRow>, count: &mut Out<usize>| {
        let rows = &frame.visible.funnel.rows;
        let counts = |c: engine::funnel::Counts| Counts {
            instances: c.instances,
            clusters: c.clusters,
            triangles: c.triangles,
        };
        let row = |row: &engine::funnel::FunnelRow| FunnelRow {
            stage: row.stage as u32,
            unit: row.unit as u32,
            entered: counts(row.entered),
            left: counts(row.left),
        };
        write(out, count, rows.iter().map(row), rows.len())
    };
    // SAFETY: as the header asks of the caller.
    unsafe { read_state("cullet_visible_funnel", state, array, count, body) }
}

/// Writes the draws of the last result: one command for the whole instances of a mesh and part, one
/// for each run of clusters of the others; where the output is triangles, one for each part of each
/// instance, of `indices` to be uploaded with it. `places` says where the renderer's buffers hold
/// meshes 0, 1, ...; for one beyond them commands count from its own first index. The counts are
/// always written; where an array is too small, only they are, with `CULLET_STATUS_TOO_SMALL`; all
/// capacities 0 asks for them. The scene must be as it was culled. Allocates nothing once the state
/// has grown.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_visible_draws(
    state: State,
    scene: Scene,
    places: *const MeshPlace,
    place_count: usize,
    draws: *mut Draws,
) -> Status {
    call("cullet_visible_draws", || {
        // SAFETY: as the header asks of the caller.
        let mut all = unsafe { crate::memory::value("draws", draws) }?;
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::one("draws", draws) }?;
        // SAFETY: as the header asks of the caller.
        let mut commands = unsafe { Out::array("commands", all.commands, all.command_capacity) }?;
        // SAFETY: as the header asks of the caller.
        let mut keys = unsafe { Out::array("keys", all.keys, all.command_capacity) }?;
        // SAFETY: as the header asks of the caller.
        let mut slots = unsafe { Out::array("instances", all.instances, all.instance_capacity) }?;
        // SAFETY: as the header asks of the caller.
        let mut indices = unsafe { Out::array("indices", all.indices, all.index_capacity) }?;
        // SAFETY: as the header asks of the caller; `MeshPlace` has the fields of the engine's, in
        // their order.
        let places = unsafe { read("places", places, place_count) }?;
        let scene = SCENES.get(scene.id)?;
        let mut state = STATES.get_mut(state.id)?;
        state.check_scene(&scene)?;
        let Frame { visible, draws: list, triangles, .. } = &mut *state;
        let places = bytemuck::cast_slice(places);
        if *triangles {
            list.fill_triangles(&scene, visible, places)
        } else {
            list.fill(&scene, visible, places)
        }
        .map_err(crate::instance::scene_error)?;
        all.command_count = list.commands.len();
        all.instance_count = list.instances.len();
        all.index_count = if *triangles { list.indices.len() } else { 0 };
        out.set(0, all);
        if all.command_capacity + all.instance_capacity + all.index_capacity == 0 {
            return Ok(());
        }
        let rooms = [
            ("commands", all.command_capacity, all.command_count),
            ("instances", all.instance_capacity, all.instance_count),
            ("indices", all.index_capacity, all.index_count),
        ];
        if let Some((what, room, needed)) = rooms.iter().find(|(_, room, needed)| room < needed) {
            let message = format!("{what}: room for {room}, but there are {needed}");
            return Err(Error::new(Status::TooSmall, message));
        }
        commands.copy(bytemuck::cast_slice(&list.commands));
        keys.copy(bytemuck::cast_slice(&list.keys));
        slots.copy(&list.instances);
        if *triangles {
            indices.copy(&list.indices);
        }
        Ok(())
    })
}

/// The name of a stage, such as "frustum"; "unknown" for a number that is none. Never NULL; lives
/// for ever.
#[unsafe(no_mangle)]
pub extern "C" fn cullet_stage_name(stage: u32) -> *const c_char {
    let name: &CStr = match stage {
        0 => c"visible",
        1 => c"layer",
        2 => c"frustum",
        3 => c"pvs",
        4 => c"portal",
        5 => c"detail",
        6 => c"lod",
        7 => c"occlusion",
        8 => c"backface",
        9 => c"degenerate",
        _ => c"unknown",
    };
    name.as_ptr()
}

/// The name of a unit of a funnel: "instances", "clusters" or "triangles"; "unknown" else. Never
/// NULL; lives for ever.
#[unsafe(no_mangle)]
pub extern "C" fn cullet_unit_name(unit: u32) -> *const c_char {
    let name: &CStr = match unit {
        0 => c"instances",
        1 => c"clusters",
        2 => c"triangles",
        _ => c"unknown",
    };
    name.as_ptr()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_and_units_have_the_engines_names() {
        // SAFETY: names live for ever.
        let name = |pointer| unsafe { CStr::from_ptr(pointer) }.to_str().unwrap();
        for stage in engine::Stage::ALL {
            assert_eq!(name(cullet_stage_name(stage as u32)), stage.name());
        }
        for unit in [
            engine::funnel::Unit::Instances,
            engine::funnel::Unit::Clusters,
            engine::funnel::Unit::Triangles,
        ] {
            assert_eq!(name(cullet_unit_name(unit as u32)), unit.name());
        }
    }
}
