//! Queries of a scene by arrays: lines of sight, boxes to boxes, regions of eyes and motions.

use alloc::borrow::ToOwned;
use alloc::format;
use alloc::vec::Vec;

use cullet::bounds::Aabb;
use cullet_cells::query::{
    self, BlockingSides, BoxSight, EyeBox, Find, Motion, MotionQuery, Needed, RegionCuller,
    RegionError, RegionState, RegionVisible, Segment, Sight, SightOptions, VolumeOptions,
};

use crate::fault::{Code, Fault, has_room};
use crate::listing::Ascending;
use crate::scene::SceneSet;
use crate::view::SceneView;

/// Stands for no instance where an id is expected.
pub const NONE: u32 = u32::MAX;

/// Memory and answers of queries. It may be used for any scene.
#[derive(Debug, Default)]
pub struct Queries {
    segments: Vec<Segment>,
    sights: Vec<Sight>,
    state: RegionState,
    visible: RegionVisible,
    needed: Vec<Needed>,
    ascending: Ascending,
    ids: Vec<u32>,
    numbers: Vec<f64>,
    states: Vec<u8>,
}

/// Settings of lines of sight as a page sends them.
#[derive(Clone, Copy, Debug)]
pub struct LineSettings {
    /// Layers of what blocks.
    pub layers: u32,
    /// Bit 0: both sides of one-sided triangles block; bit 1: any blocker will do.
    pub flags: u32,
    /// Ids that do not block; [`NONE`] for fewer.
    pub ignored: [u32; 2],
}

/// Settings of volume queries as a page sends them.
#[derive(Clone, Copy, Debug)]
pub struct VolumeSettings {
    /// Layers of what hides.
    pub layers: u32,
    /// How often boxes may be halved.
    pub splits: u32,
    /// How far each box may move along each axis, in world units, at least 0: first the box that
    /// looks, then the one that is looked at.
    pub motion: [f64; 2],
}

/// How many numbers the settings of a region are: layers, `cell_world`, `most_cells`, `width`,
/// `most_bodies` and `near_world`.
pub const REGION_NUMBERS: usize = 6;

/// Returns the settings of a region query from their numbers.
///
/// # Errors
/// If memory does not suffice for a buffer of the width. The engine checks the ranges.
fn region_settings(numbers: &[f64; REGION_NUMBERS]) -> Result<RegionCuller, Fault> {
    let [layers, cell_world, most_cells, width, most_bodies, near_world] = *numbers;
    let culler = RegionCuller {
        layers: layers as u32,
        cell_world,
        most_cells: most_cells as u32,
        width: width as u32,
        most_bodies: most_bodies as u32,
        near_world,
        ..RegionCuller::default()
    };
    // A buffer takes f32 depth, and half of that for its levels and masks.
    if culler.width <= 4096 && !has_room((culler.width as usize).pow(2) * 8) {
        let message = format!("no memory for squares of width {}", culler.width);
        return Err(Fault::new(Code::Memory, message));
    }
    Ok(culler)
}

impl Queries {
    /// Finds what blocks each line of sight; six numbers a line, from and to. The ids of blockers
    /// lie at [`ids`](Self::ids), [`NONE`] for a clear line. Five numbers a line lie at
    /// [`numbers`](Self::numbers): triangle, share of the way and point, zeros for a clear line.
    ///
    /// # Errors
    /// If an ignored id names no instance.
    pub fn lines(
        &mut self,
        set: &SceneSet,
        lines: &[f64],
        settings: &LineSettings,
    ) -> Result<(), Fault> {
        if !has_room(lines.len().saturating_mul(32)) {
            return Err(Fault::new(Code::Memory, "no memory for as many lines"));
        }
        let mut options = SightOptions {
            layers: settings.layers,
            sides: match settings.flags & 1 {
                0 => BlockingSides::AsDrawn,
                _ => BlockingSides::Both,
            },
            find: if settings.flags & 2 == 0 { Find::Nearest } else { Find::Any },
            ..SightOptions::default()
        };
        for (ignored, id) in options.ignored.iter_mut().zip(settings.ignored) {
            *ignored = if id == NONE { None } else { Some(set.handle(id)?) };
        }
        let segments = lines
            .as_chunks::<6>()
            .0
            .iter()
            .map(|&[a, b, c, x, y, z]| Segment { from: [a, b, c], to: [x, y, z] });
        self.segments.clear();
        self.segments.extend(segments);
        query::lines_of_sight(set.scene(), &self.segments, &options, &mut self.sights);
        self.ids.clear();
        self.numbers.clear();
        for sight in &self.sights {
            let (id, numbers) = match sight {
                Sight::Blocked(by) => {
                    let [x, y, z] = by.point;
                    (by.handle.index, [f64::from(by.triangle), by.share, x, y, z])
                }
                Sight::Clear => (NONE, [0.0; 5]),
            };
            self.ids.push(id);
            self.numbers.extend(numbers);
        }
        Ok(())
    }

    /// Tests whether boxes are hidden from boxes; twelve numbers a pair in world space, each box
    /// with its least and its greatest corner. A byte a pair lies at [`states`](Self::states):
    /// 0 visible, 1 hidden, 2 one of them is empty. The ids of what hides lie at
    /// [`ids`](Self::ids), [`NONE`] where nothing does, and the number of its shape at
    /// [`numbers`](Self::numbers).
    ///
    /// A box that may move is tested as the box around all places that it may move to.
    ///
    /// # Errors
    /// If memory does not suffice.
    pub fn boxes(
        &mut self,
        set: &SceneSet,
        pairs: &[f64],
        settings: &VolumeSettings,
    ) -> Result<(), Fault> {
        if !has_room(pairs.len().saturating_mul(4)) {
            return Err(Fault::new(Code::Memory, "no memory for as many boxes"));
        }
        let options = VolumeOptions { layers: settings.layers, splits: settings.splits };
        let scene = set.scene();
        self.ids.clear();
        self.numbers.clear();
        self.states.clear();
        for pair in pairs.as_chunks::<12>().0 {
            let [from, to] = [0, 1].map(|i| {
                let (boxes, _) = pair.as_chunks::<6>();
                grown(&boxes[i], settings.motion[i], scene.origin())
            });
            let (state, id, shape) = match query::box_to_box(scene, &from, &to, &options) {
                BoxSight::Visible => (0, NONE, 0),
                BoxSight::Hidden(by) => (1, by.handle.index, by.shape),
                BoxSight::Empty => (2, NONE, 0),
            };
            self.states.push(state);
            self.ids.push(id);
            self.numbers.push(shape.into());
        }
        Ok(())
    }

    /// Finds what may be seen from anywhere in a box of eyes in world space, by a view's
    /// orientation and projection if one is given. The ids lie at [`ids`](Self::ids), ascending.
    ///
    /// # Errors
    /// For a setting out of its range, a view without a camera, and an orthographic one.
    pub fn region(
        &mut self,
        set: &SceneSet,
        eyes: &[f64; 6],
        settings: &[f64; REGION_NUMBERS],
        view: Option<&SceneView>,
    ) -> Result<(), Fault> {
        let culler = region_settings(settings)?;
        let [a, b, c, x, y, z] = *eyes;
        let eyes = EyeBox::new([a, b, c], [x, y, z]);
        let (scene, state, visible) = (set.scene(), &mut self.state, &mut self.visible);
        match view {
            Some(view) => culler.cull_view(scene, &eyes, view.camera()?, state, visible),
            None => culler.cull(scene, &eyes, state, visible),
        }
        .map_err(|error| refused(&error))?;
        let ids = visible.handles(scene).map(|handle| handle.index);
        self.ascending.fill(culler.simd, set.id_count(), ids);
        self.ids.clear();
        self.ids.extend(self.ascending.list());
        Ok(())
    }

    /// Lists what will be needed along a way of points in world space, three numbers each, by the
    /// distance at which it first may be seen. Ids lie at [`ids`](Self::ids), distances at
    /// [`numbers`](Self::numbers). `way` is radius, reach and step in world units, then how many
    /// steps there may be.
    ///
    /// # Errors
    /// For a setting out of its range.
    pub fn motion(
        &mut self,
        set: &SceneSet,
        points: &[f64],
        settings: &[f64; REGION_NUMBERS],
        way: &[f64; 4],
    ) -> Result<(), Fault> {
        let [radius_world, reach_world, step_world, most_steps] = *way;
        let region = region_settings(settings)?;
        let query = MotionQuery { region, step_world, most_steps: most_steps as u32 };
        let motion = Motion { points: points.as_chunks::<3>().0, radius_world, reach_world };
        query
            .needed(set.scene(), &motion, &mut self.state, &mut self.needed)
            .map_err(|error| refused(&error))?;
        self.ids.clear();
        self.ids.extend(self.needed.iter().map(|n| n.handle.index));
        self.numbers.clear();
        self.numbers.extend(self.needed.iter().map(|n| n.distance));
        Ok(())
    }

    /// The ids of the last answer.
    pub fn ids(&self) -> &[u32] {
        &self.ids
    }

    /// The numbers of the last answer.
    pub fn numbers(&self) -> &[f64] {
        &self.numbers
    }

    /// The states of the last boxes.
    pub fn states(&self) -> &[u8] {
        &self.states
    }
}

/// Returns a box in world space, grown by a motion and rounded outward, relative to an origin. An
/// empty box stays empty; a number that is not finite makes a box that nothing hides.
fn grown(b: &[f64; 6], motion: f64, origin: [f64; 3]) -> Aabb {
    let [min, max] = [0, 3].map(|i| [b[i], b[i + 1], b[i + 2]]);
    if b.iter().any(|v| v.is_nan()) {
        return Aabb::EVERYTHING;
    }
    if (0..3).any(|a| min[a] > max[a]) {
        return Aabb::EMPTY;
    }
    // Two roundings each, of half a unit in the last place of the largest term at the most.
    let slack =
        |a: usize, v: f64| (v.abs() + motion.abs() + origin[a].abs()) * (2.0 * f64::EPSILON);
    let low = core::array::from_fn(|a| min[a] - origin[a] - motion - slack(a, min[a]));
    let high = core::array::from_fn(|a| max[a] - origin[a] + motion + slack(a, max[a]));
    Aabb::rounded_out(low, high)
}

/// The fault of a region, with settings named as a page has them.
fn refused(error: &RegionError) -> Fault {
    let RegionError::Setting { what, value, must } = error else {
        let message =
            "an orthographic view has no eye that a box could hold; use a perspective view";
        return Fault::new(Code::Camera, message);
    };
    let mut words = what.split('_');
    let mut name = words.next().unwrap_or_default().to_owned();
    for word in words {
        name.push_str(&word[..1].to_ascii_uppercase());
        name.push_str(&word[1..]);
    }
    // The page writes the digits where the module has none: as the engine leaves them to it.
    #[cfg(target_arch = "wasm32")]
    let value = format_args!("\u{1}q{:x};", value.to_bits());
    Fault::new(Code::Argument, format!("{name} is {value}; it must be {must}"))
}
