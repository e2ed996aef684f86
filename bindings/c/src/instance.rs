//! Instances of a scene: added, changed, removed and found again.

use engine::bounds::Aabb;
use engine::{Handle as EngineHandle, InstanceFlags, SceneError, scene::BoundsOverride};

use crate::memory::{Out, Plain, read, reserved};
use crate::scene::{SCENES, Scene};
use crate::status::{Error, Result, Status, call};
use crate::transform::Transform;

/// Handle of an instance in its scene: stays the same until the instance is removed.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Handle {
    /// Index, from 0 in the order in which instances are added, used again after a removal.
    pub index: u32,
    /// How often that index was used before.
    pub generation: u32,
}

impl Plain for Handle {}

impl From<Handle> for EngineHandle {
    fn from(Handle { index, generation }: Handle) -> Self {
        Self { index, generation }
    }
}

impl From<EngineHandle> for Handle {
    fn from(EngineHandle { index, generation }: EngineHandle) -> Self {
        Self { index, generation }
    }
}

/// No stage but the layers may cull it. Bit of `cullet_instance.flags`.
pub const CULLET_ALWAYS_VISIBLE: u32 = 1;
/// It never hides anything. Bit of `cullet_instance.flags`.
pub const CULLET_NO_OCCLUSION: u32 = 2;
/// Both sides of its triangles are drawn, whatever its mesh says. Bit of `cullet_instance.flags`.
pub const CULLET_TWO_SIDED: u32 = 4;
/// It is blended, whatever its mesh says. Bit of `cullet_instance.flags`.
pub const CULLET_TRANSPARENT: u32 = 8;
/// It is going to move: a hint that keeps nodes of what stands tight. Bit of
/// `cullet_instance.flags`.
pub const CULLET_DYNAMIC: u32 = 16;

/// An instance to add: a mesh with a transform.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Instance {
    /// Where it is.
    pub transform: Transform,
    /// Number of its mesh.
    pub mesh: u32,
    /// Bits of the layers that it is in; a view sees it where they share a bit. 0 is in none, so
    /// never drawn.
    pub layers: u32,
    /// `CULLET_ALWAYS_VISIBLE` and so on.
    pub flags: u32,
    /// 0.
    pub reserved: u32,
    /// A number of the caller's, such as an entity or an index; `cullet_visible_users` gives it
    /// back.
    pub user: u64,
}

impl Plain for Instance {}

/// Bounds of an instance.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub enum Bounds {
    /// The box of its mesh, transformed.
    Mesh = 0,
    /// None: it is visible to every stage but the layers.
    None = 1,
    /// A box in world space, relative to the scene's origin: what is animated, or placed by a
    /// shader.
    World = 2,
    /// The box of its mesh, grown on every side by a distance: for vertices that a shader
    /// displaces.
    Margin = 3,
}

fn flags(at: usize, flags: u32) -> Result<InstanceFlags> {
    if flags >= 2 * CULLET_DYNAMIC {
        let all = 2 * CULLET_DYNAMIC - 1;
        let message = format!("flags of element {at} are {flags:#x}: there are {all:#x}");
        return Err(Error::value(message));
    }
    let has = |bit| flags & bit != 0;
    Ok(InstanceFlags {
        always_visible: has(CULLET_ALWAYS_VISIBLE),
        no_occlusion: has(CULLET_NO_OCCLUSION),
        double_sided: has(CULLET_TWO_SIDED),
        transparent: has(CULLET_TRANSPARENT),
        dynamic: has(CULLET_DYNAMIC),
    })
}

pub(crate) fn scene_error(error: SceneError) -> Error {
    let status = match error {
        SceneError::Full(_) => Status::Full,
        _ => Status::NotFound,
    };
    Error::new(status, error.to_string())
}

/// Refuses a call as a whole if one of its handles names nothing.
fn check_handles(scene: &engine::Scene, handles: &[Handle]) -> Result {
    for (at, &handle) in handles.iter().enumerate() {
        scene.slot(handle.into()).map_err(|_| {
            let Handle { index, generation } = handle;
            let message = format!(
                "handle {at} of {} (index {index}, generation {generation}) names no instance: it was removed, or is of another scene",
                handles.len()
            );
            Error::new(Status::NotFound, message)
        })?;
    }
    Ok(())
}

/// Adds instances, and writes a handle for each into `handles`, unless that is NULL. All or none:
/// if one has no mesh or an unknown flag, nothing is added. Commit before culling where many were
/// added.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_scene_add(
    scene: Scene,
    instances: *const Instance,
    count: usize,
    handles: *mut Handle,
) -> Status {
    call("cullet_scene_add", || {
        // SAFETY: as the header asks of the caller.
        let instances = unsafe { read("instances", instances, count) }?;
        let room = if handles.is_null() { 0 } else { count };
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::array("handles", handles, room) }?;
        let mut scene = SCENES.get_mut(scene.id)?;
        let mut added = Vec::with_capacity(count);
        for (at, instance) in instances.iter().enumerate() {
            if instance.mesh as usize >= scene.meshes().len() {
                let (mesh, meshes) = (instance.mesh, scene.meshes().len());
                let message = format!("instance {at} has mesh {mesh}: the scene has {meshes}");
                return Err(Error::new(Status::NotFound, message));
            }
            reserved(format_args!("reserved of instance {at}"), instance.reserved)?;
            added.push(engine::Instance {
                layers: instance.layers,
                flags: flags(at, instance.flags)?,
                user_data: instance.user,
                ..engine::Instance::new(instance.mesh, instance.transform.to_engine())
            });
        }
        if scene.slot_count() as usize + count > u32::MAX as usize - 1 {
            let message = format!("{count} more instances: a scene has fewer than 2^32 - 1");
            return Err(Error::new(Status::Full, message));
        }
        for (at, instance) in added.into_iter().enumerate() {
            let handle = scene.add(instance).map_err(scene_error)?;
            if out.room() > 0 {
                out.set(at, handle.into());
            }
        }
        Ok(())
    })
}

/// Calls `change` with each instance and what is new of it, once all handles are known to be good.
fn change<T: Plain>(
    scene: Scene,
    handles: &[Handle],
    values: &[T],
    mut change: impl FnMut(&mut engine::Scene, EngineHandle, T) -> std::result::Result<(), SceneError>,
) -> Result {
    let mut scene = SCENES.get_mut(scene.id)?;
    check_handles(&scene, handles)?;
    for (&handle, &value) in handles.iter().zip(values) {
        change(&mut scene, handle.into(), value).map_err(scene_error)?;
    }
    Ok(())
}

/// Removes instances; their handles are stale from then on. All or none, but that a handle which is
/// there twice is an error after the first was removed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_scene_remove(
    scene: Scene,
    handles: *const Handle,
    count: usize,
) -> Status {
    call("cullet_scene_remove", || {
        // SAFETY: as the header asks of the caller.
        let handles = unsafe { read("handles", handles, count) }?;
        change(scene, handles, handles, |scene, handle, _| scene.remove(handle))
    })
}

/// Moves instances: `transforms` has one for each of `handles`. All or none. Cull on as it is: the
/// answer is right at once, and `cullet_scene_refit` after a frame's moves makes it faster.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_scene_set_transforms(
    scene: Scene,
    handles: *const Handle,
    transforms: *const Transform,
    count: usize,
) -> Status {
    call("cullet_scene_set_transforms", || {
        // SAFETY: as the header asks of the caller.
        let handles = unsafe { read("handles", handles, count) }?;
        // SAFETY: as the header asks of the caller.
        let transforms = unsafe { read("transforms", transforms, count) }?;
        change(scene, handles, transforms, |scene, handle, transform| {
            scene.set_transform(handle, transform.to_engine())
        })
    })
}

/// Sets the layers of instances: `layers` has a mask for each of `handles`. All or none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_scene_set_layers(
    scene: Scene,
    handles: *const Handle,
    layers: *const u32,
    count: usize,
) -> Status {
    call("cullet_scene_set_layers", || {
        // SAFETY: as the header asks of the caller.
        let handles = unsafe { read("handles", handles, count) }?;
        // SAFETY: as the header asks of the caller.
        let layers = unsafe { read("layers", layers, count) }?;
        change(scene, handles, layers, engine::Scene::set_layers)
    })
}

/// Sets the flags of instances: `values` has some for each of `handles`. All or none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_scene_set_flags(
    scene: Scene,
    handles: *const Handle,
    values: *const u32,
    count: usize,
) -> Status {
    call("cullet_scene_set_flags", || {
        // SAFETY: as the header asks of the caller.
        let handles = unsafe { read("handles", handles, count) }?;
        // SAFETY: as the header asks of the caller.
        let values = unsafe { read("values", values, count) }?;
        for (at, &value) in values.iter().enumerate() {
            flags(at, value)?;
        }
        change(scene, handles, values, |scene, handle, value| {
            scene.set_flags(handle, flags(0, value).unwrap_or_default())
        })
    })
}

/// Gives an instance bounds of the caller's. `kind` is a `cullet_bounds`; `numbers` has six floats
/// for `CULLET_BOUNDS_WORLD`, the lowest and the highest corner relative to the scene's origin, one
/// for `CULLET_BOUNDS_MARGIN`, from 0, and is not read for the others. A box that is not finite
/// keeps its instance visible.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_scene_set_bounds(
    scene: Scene,
    handle: Handle,
    kind: u32,
    numbers: *const f32,
) -> Status {
    call("cullet_scene_set_bounds", || {
        let count = match kind {
            2 => 6,
            3 => 1,
            _ => 0,
        };
        // SAFETY: as the header asks of the caller.
        let numbers = unsafe { read("numbers", numbers, count) }?;
        let bounds = match (kind, numbers) {
            (0, _) => BoundsOverride::Mesh,
            (1, _) => BoundsOverride::None,
            (2, &[a, b, c, d, e, f]) => BoundsOverride::World(Aabb::new([a, b, c], [d, e, f])),
            (3, &[margin]) if margin >= 0.0 => BoundsOverride::Margin(margin),
            (3, &[margin]) => {
                let message = format!("the margin is {margin}: it must be at least 0");
                return Err(Error::value(message));
            }
            _ => {
                let message = format!("kind {kind}: it must be 0 to 3, a cullet_bounds");
                return Err(Error::value(message));
            }
        };
        change(scene, &[handle], &[0_u32], |scene, handle, _| scene.set_bounds(handle, bounds))
    })
}

/// Writes the slot of an instance: the index of arrays by slot, until the next commit.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_scene_slot(scene: Scene, handle: Handle, slot: *mut u32) -> Status {
    call("cullet_scene_slot", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::one("slot", slot) }?;
        let scene = SCENES.get(scene.id)?;
        check_handles(&scene, &[handle])?;
        out.set(0, scene.slot(handle.into()).map_err(scene_error)?);
        Ok(())
    })
}

/// Writes the instance of a slot, as draws name it: its mesh, transform, layers, flags and number;
/// and its handle into `handle`, unless that is NULL. `CULLET_STATUS_NOT_FOUND` for an empty slot
/// and one beyond the last.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_scene_instance(
    scene: Scene,
    slot: u32,
    instance: *mut Instance,
    handle: *mut Handle,
) -> Status {
    call("cullet_scene_instance", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::one("instance", instance) }?;
        // SAFETY: as the header asks of the caller.
        let mut named = unsafe { Out::array("handle", handle, usize::from(!handle.is_null())) }?;
        let scene = SCENES.get(scene.id)?;
        let found = scene.handle(slot).ok_or_else(|| {
            let message = format!("no instance is in slot {slot} of {}", scene.slot_count());
            Error::new(Status::NotFound, message)
        })?;
        let (transform, of) = (scene.transform(slot), scene.flags(slot));
        let linear = transform.linear.as_flattened();
        let flags = [
            (of.always_visible, CULLET_ALWAYS_VISIBLE),
            (of.no_occlusion, CULLET_NO_OCCLUSION),
            (of.double_sided, CULLET_TWO_SIDED),
            (of.transparent, CULLET_TRANSPARENT),
            (of.dynamic, CULLET_DYNAMIC),
        ];
        out.set(
            0,
            Instance {
                transform: Transform {
                    linear: std::array::from_fn(|i| linear[i]),
                    translation: transform.translation,
                },
                mesh: scene.mesh_id(slot),
                layers: scene.layers(slot),
                flags: flags.iter().map(|&(is, bit)| if is { bit } else { 0 }).sum(),
                reserved: 0,
                user: scene.user_data(slot),
            },
        );
        if named.room() > 0 {
            named.set(0, found.into());
        }
        Ok(())
    })
}
