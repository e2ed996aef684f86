//! Queries of a scene that games and tools make: lines of sight, and boxes from boxes.

use cullet_cells::query::{
    BlockingSides, BoxSight, Find, Sight as EngineSight, SightOptions as EngineOptions,
    VolumeOptions, box_to_box, line_of_sight,
};
use engine::cull::occlusion::Visibility;

use crate::instance::Handle;
use crate::memory::{Out, Plain, read, reserved, value};
use crate::occlusion::{Box3, number_of};
use crate::scene::{SCENES, Scene};
use crate::status::{Error, Result, Status, call};

/// Two points in world space: from where one looks, and what is looked at.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    /// The start.
    pub from: [f64; 3],
    /// The end.
    pub to: [f64; 3],
}

impl Plain for Segment {}

/// Settings of lines of sight. Set them to zero before their fields.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SightOptions {
    /// Layers that do not block, as bits; an instance that is in others too does.
    pub ignored_layers: u32,
    /// 1 where both sides of one-sided triangles block; 0 for the side that is drawn.
    pub both_sides: u32,
    /// 1 for any blocker, which ends the search as soon as there is one; 0 for the nearest.
    pub any: u32,
    /// How many of `ignored` are there, up to 2.
    pub ignored_count: u32,
    /// Instances that do not block, such as who looks and who is looked at. One that names nothing
    /// is no error.
    pub ignored: [Handle; 2],
}

impl Plain for SightOptions {}

/// Result for one line of sight.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Sight {
    /// 1 where something opaque blocks; 0 where nothing is known to, and then all else is 0.
    pub blocked: u32,
    /// Slot of the blocker.
    pub slot: u32,
    /// Handle of the blocker.
    pub handle: Handle,
    /// Triangle of the blocker, as numbered in the mesh that was added.
    pub triangle: u32,
    /// 0.
    pub reserved: u32,
    /// How far along the way it is crossed, from 0 at the start to 1 at the end.
    pub share: f64,
    /// Where, in world space.
    pub point: [f64; 3],
}

fn options_of(options: &SightOptions) -> Result<EngineOptions> {
    let switch = |name: &str, value: u32| match value {
        0 => Ok(false),
        1 => Ok(true),
        _ => Err(Error::value(format!("options->{name} is {value}: it must be 0 or 1"))),
    };
    let count = options.ignored_count as usize;
    if count > options.ignored.len() {
        let message = format!("options->ignored_count is {count}: it must be 0 to 2");
        return Err(Error::value(message));
    }
    let ignored = |at: usize| (at < count).then(|| options.ignored[at].into());
    Ok(EngineOptions {
        layers: !options.ignored_layers,
        sides: match switch("both_sides", options.both_sides)? {
            true => BlockingSides::Both,
            false => BlockingSides::AsDrawn,
        },
        find: if switch("any", options.any)? { Find::Any } else { Find::Nearest },
        ignored: [ignored(0), ignored(1)],
    })
}

/// Finds what blocks lines of sight, and writes a result for each segment. Exact: nothing slips
/// through between two triangles that share an edge, and an end on a surface is not blocked by it.
/// What deforms, is blended or cut out does not block, and nothing does where a number is not
/// finite. `options` may be NULL. Cost: what each segment comes near; allocates nothing. Reads the
/// scene: give each thread its own part of the segments. Commit the scene for it to be quick.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_lines_of_sight(
    scene: Scene,
    segments: *const Segment,
    count: usize,
    options: *const SightOptions,
    results: *mut Sight,
) -> Status {
    call("cullet_lines_of_sight", || {
        // SAFETY: as the header asks of the caller.
        let segments = unsafe { read("segments", segments, count) }?;
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::array("results", results, count) }?;
        let options = if options.is_null() {
            EngineOptions::default()
        } else {
            // SAFETY: as the header asks of the caller.
            options_of(&unsafe { value("options", options) }?)?
        };
        let scene = SCENES.get(scene.id)?;
        for (at, segment) in segments.iter().enumerate() {
            let found = line_of_sight(&scene, segment.from, segment.to, &options);
            out.set(at, sight_of(&found));
        }
        Ok(())
    })
}

fn sight_of(found: &EngineSight) -> Sight {
    let clear = Sight {
        blocked: 0,
        slot: 0,
        handle: Handle { index: 0, generation: 0 },
        triangle: 0,
        reserved: 0,
        share: 0.0,
        point: [0.0; 3],
    };
    match found {
        EngineSight::Clear => clear,
        EngineSight::Blocked(by) => Sight {
            blocked: 1,
            slot: by.slot,
            handle: by.handle.into(),
            triangle: by.triangle,
            share: by.share,
            point: by.point,
            ..clear
        },
    }
}

/// Settings of `cullet_box_to_box`. Set them to zero before their fields.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct BoxSightOptions {
    /// Layers that hide nothing, as bits; an instance that is in others too does.
    pub ignored_layers: u32,
    /// How often boxes may be halved, 0 to 16, to find a proof for each half: several occluders may
    /// hide together what none hides alone.
    pub splits: u32,
    /// 0.
    pub reserved: u32,
}

impl Plain for BoxSightOptions {}

/// Tests for each box of `to` whether all of it is hidden from all of the box `from`, all relative
/// to the scene's origin, and writes a `cullet_found`, one byte each: outside where one of the two
/// boxes is empty. Hidden is a proof that no segment between the two is free; visible is that there
/// is none, and the answer for numbers that are not finite. Convex occluders alone hide here, as
/// made by `cullet_scene_commit` or baked. `options` may be NULL. Cost: what lies between the
/// middles of the boxes; twice as much for each split. Allocates nothing, and reads the scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_box_to_box(
    scene: Scene,
    from: *const Box3,
    to: *const Box3,
    count: usize,
    options: *const BoxSightOptions,
    results: *mut u8,
) -> Status {
    call("cullet_box_to_box", || {
        // SAFETY: as the header asks of the caller.
        let from = unsafe { value("from", from) }?;
        // SAFETY: as the header asks of the caller.
        let to = unsafe { read("to", to, count) }?;
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::array("results", results, count) }?;
        let mut settings = VolumeOptions::default();
        if !options.is_null() {
            // SAFETY: as the header asks of the caller.
            let options = unsafe { value("options", options) }?;
            reserved("options->reserved", options.reserved)?;
            if options.splits > 16 {
                let message = format!("options->splits is {}: it must be 0 to 16", options.splits);
                return Err(Error::value(message));
            }
            (settings.layers, settings.splits) = (!options.ignored_layers, options.splits);
        }
        let scene = SCENES.get(scene.id)?;
        for (at, b) in to.iter().enumerate() {
            let found = match box_to_box(&scene, &from.to_engine(), &b.to_engine(), &settings) {
                BoxSight::Empty => Visibility::Outside,
                BoxSight::Visible => Visibility::Visible,
                BoxSight::Hidden(_) => Visibility::Hidden,
            };
            out.set(at, number_of(found));
        }
        Ok(())
    })
}

/// Writes the cell of a point in world space, in a scene whose file brought cells, as maps and baked
/// files do; `UINT32_MAX` where the point is in none, or the scene has none. Reads the scene.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_scene_cell_of(
    scene: Scene,
    point: *const f64,
    cell: *mut u32,
) -> Status {
    call("cullet_scene_cell_of", || {
        // SAFETY: as the header asks of the caller.
        let point: [f64; 3] = unsafe { value("point", point.cast()) }?;
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::one("cell", cell) }?;
        let scene = SCENES.get(scene.id)?;
        out.set(0, scene.all().cell_of(point).unwrap_or(u32::MAX));
        Ok(())
    })
}
