//! Regions: what may be seen from anywhere in a box of eyes.

use cullet_cells::query::{EyeBox as EngineBox, RegionCuller, RegionState, RegionVisible};

use crate::memory::{Out, Plain, reserved, value};
use crate::registry::{Kind, Table};
use crate::results::write;
use crate::scene::{SCENES, Scene};
use crate::status::{Error, Result, Status, call};
use crate::view::{EyeBox, View, to_engine};

static REGIONS: Table<Found> = Table::new(Kind::Region);

/// Handle of a region query: its memory, and its last result. A plain number: copy it freely; 0 is
/// none.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Region {
    /// Not to be read or made.
    pub id: u64,
}

#[derive(Debug, Default)]
struct Found {
    state: RegionState,
    visible: RegionVisible,
    is_made: bool,
}

/// Settings of region queries. Set them to zero before their fields: 0 takes the default of each.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct RegionSettings {
    /// Longest side of the cells that the box is cut into, in world units; default 2. Occluders lose
    /// half of it on every side. A smaller one drops more, and costs with its third power.
    pub cell_world: f64,
    /// The farthest that a point of a view's near rectangle is from its eye; default 0.25.
    pub near_world: f64,
    /// No more cells than this; default 64. Cost is in proportion.
    pub most_cells: u32,
    /// Pixels across each of the six squares that are looked at, 8 to 4096; default 512.
    pub width: u32,
    /// No more occluders than this; default 2048.
    pub most_bodies: u32,
    /// Layers that the eyes do not see, as bits. Not read where there is a view, which has its own.
    pub ignored_layers: u32,
    /// 0.
    pub reserved: u32,
}

impl Plain for RegionSettings {}

fn culler_of(settings: &RegionSettings) -> Result<RegionCuller> {
    reserved("settings->reserved", settings.reserved)?;
    let default = RegionCuller::default();
    let or = |value: u32, default: u32| if value == 0 { default } else { value };
    let or_world = |value: f64, default: f64| if value == 0.0 { default } else { value };
    Ok(RegionCuller {
        cell_world: or_world(settings.cell_world, default.cell_world),
        near_world: or_world(settings.near_world, default.near_world),
        most_cells: or(settings.most_cells, default.most_cells),
        width: or(settings.width, default.width),
        most_bodies: or(settings.most_bodies, default.most_bodies),
        layers: !settings.ignored_layers,
        ..default
    })
}

/// Makes the memory of region queries. Destroy it with `cullet_region_destroy`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_region_create(region: *mut Region) -> Status {
    call("cullet_region_create", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::one("region", region) }?;
        out.set(0, Region { id: REGIONS.insert(Found::default())? });
        Ok(())
    })
}

/// Destroys the memory of region queries; its handle is stale from then on.
#[unsafe(no_mangle)]
pub extern "C" fn cullet_region_destroy(region: Region) -> Status {
    call("cullet_region_destroy", || REGIONS.remove(region.id).map(drop))
}

/// Finds what may be seen from any eye in a box, for streaming, for baking, or for a frame whose eye
/// is not known yet; `cullet_region_slots` reads the result. `view` is how all the eyes look, a
/// perspective view carried to each; NULL for any direction. `settings` may be NULL. Nothing that an
/// eye sees is missing. Closed convex bodies alone hide here; walls that are sheets do not. Cost: up
/// to `most_cells` times six occlusion buffers, milliseconds and more. Reads the scene, and needs
/// `region` alone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_region_cull(
    scene: Scene,
    eyes: *const EyeBox,
    view: *const View,
    settings: *const RegionSettings,
    region: Region,
) -> Status {
    call("cullet_region_cull", || {
        // SAFETY: as the header asks of the caller.
        let EyeBox { min, max } = unsafe { value("eyes", eyes) }?;
        let mut culler = RegionCuller::default();
        if !settings.is_null() {
            // SAFETY: as the header asks of the caller.
            culler = culler_of(&unsafe { value("settings", settings) }?)?;
        }
        let mut seen = None;
        if !view.is_null() {
            // SAFETY: as the header asks of the caller.
            seen = Some(to_engine(&unsafe { value("view", view) }?)?);
        }
        let scene = SCENES.get(scene.id)?;
        let mut own = REGIONS.get_mut(region.id)?;
        let Found { state, visible, is_made } = &mut *own;
        let eyes = EngineBox::new(min, max);
        let done = match &seen {
            Some(view) => culler.cull_view(&scene, &eyes, view, state, visible),
            None => culler.cull(&scene, &eyes, state, visible),
        };
        done.map_err(|e| Error::value(e.to_string()))?;
        *is_made = true;
        Ok(())
    })
}

/// Writes the slots that may be seen, ascending, as the scene had them when it was culled;
/// `capacity` and `count` as for `cullet_visible_slots`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_region_slots(
    region: Region,
    slots: *mut u32,
    capacity: usize,
    count: *mut usize,
) -> Status {
    call("cullet_region_slots", || {
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::array("slots", slots, capacity) }?;
        // SAFETY: as the header asks of the caller.
        let mut count = unsafe { Out::one("count", count) }?;
        let own = REGIONS.get(region.id)?;
        if !own.is_made {
            let message = "nothing was culled with this region yet: call cullet_region_cull";
            return Err(Error::new(Status::NoResult, message));
        }
        let needed = own.visible.words.iter().map(|w| w.count_ones() as usize).sum();
        write(&mut out, &mut count, own.visible.slots(), needed)
    })
}
