//! Queries that the page calls.

use super::{Mutex, VIEWS, answer, ended, of_scene, of_view, there, with_scratch};
use crate::fault::{Code, Fault};
use crate::queries::{LineSettings, Queries, REGION_NUMBERS, VolumeSettings};
use crate::scene::SceneSet;
use crate::view::SceneView;
use crate::view::lights::LIGHT_NUMBERS;

static QUERIES: Mutex<Option<Queries>> = Mutex::new(None);

/// Asks by the first `count` numbers of the scratch; the answer is the ids.
fn ask(
    scene: u32,
    count: usize,
    with: impl FnOnce(&mut Queries, &SceneSet, &[f64]) -> Result<(), Fault>,
) -> u32 {
    of_scene(scene, |scene| {
        let mut queries = QUERIES.lock();
        let queries = queries.get_or_insert_default();
        with_scratch(count * 8, |bytes| with(queries, scene, bytemuck::cast_slice(bytes)))?;
        answer(queries.ids());
        Ok(())
    })
}

/// The settings of a region at the head of the numbers, and the numbers behind them.
fn settings(numbers: &[f64]) -> Result<(&[f64; REGION_NUMBERS], &[f64]), Fault> {
    let short = || Fault::new(Code::Argument, "the settings are not all there");
    numbers.split_first_chunk().ok_or_else(short)
}

/// `count` lines lie in the scratch, six f64 each; the answer is an id for each.
#[unsafe(no_mangle)]
extern "C" fn query_lines(
    scene: u32,
    count: usize,
    layers: u32,
    flags: u32,
    first: u32,
    second: u32,
) -> u32 {
    let settings = LineSettings { layers, flags, ignored: [first, second] };
    ask(scene, count * 6, |queries, scene, lines| queries.lines(scene, lines, &settings))
}

/// `count` pairs of boxes lie in the scratch, twelve f64 each; the answer is an id for each.
#[unsafe(no_mangle)]
extern "C" fn query_boxes(
    scene: u32,
    count: usize,
    layers: u32,
    splits: u32,
    from: f64,
    to: f64,
) -> u32 {
    let settings = VolumeSettings { layers, splits, motion: [from, to] };
    ask(scene, count * 12, |queries, scene, pairs| queries.boxes(scene, pairs, &settings))
}

/// The settings lie in the scratch, then six f64 of a box; a view of 0 is none. The answer is the
/// ids.
#[unsafe(no_mangle)]
extern "C" fn query_region(scene: u32, view: u32) -> u32 {
    let query = |view: Option<&SceneView>| {
        ask(scene, REGION_NUMBERS + 6, |queries, scene, numbers| {
            let (head, rest) = settings(numbers)?;
            let eyes = rest.first_chunk().copied().unwrap_or([f64::NAN; 6]);
            queries.region(scene, &eyes, head, view)
        })
    };
    if view == 0 {
        return query(None);
    }
    match there(VIEWS.lock().get(view)) {
        Ok(view) => query(Some(view)),
        Err(fault) => ended(Err(fault)),
    }
}

/// The settings lie in the scratch, then four f64 of the way and three for each of its `points`.
/// The answer is the ids.
#[unsafe(no_mangle)]
extern "C" fn query_motion(scene: u32, points: usize) -> u32 {
    ask(scene, REGION_NUMBERS + 4 + points * 3, |queries, scene, numbers| {
        let (head, rest) = settings(numbers)?;
        let (way, points) = rest.split_first_chunk().unwrap_or((&[f64::NAN; 4], &[]));
        queries.motion(scene, points, head, way)
    })
}

/// Further answers of the last query: 0 its numbers, 1 its states.
#[unsafe(no_mangle)]
extern "C" fn query_more(which: u32) {
    match (&*QUERIES.lock(), which) {
        (None, _) => answer::<f64>(&[]),
        (Some(queries), 0) => answer(queries.numbers()),
        (Some(queries), _) => answer(queries.states()),
    }
}

/// `count` ids lie in the scratch; the answer is the ids.
#[unsafe(no_mangle)]
extern "C" fn view_cull_among(view: u32, scene: u32, count: usize) -> u32 {
    of_view(view, scene, |view, scene| {
        with_scratch(count * 4, |bytes| view.cull_among(scene, bytemuck::cast_slice(bytes)))?;
        answer(view.ids());
        Ok(())
    })
}

/// `count` lights lie in the scratch, nine f64 each; the answer is the numbers of those kept.
#[unsafe(no_mangle)]
extern "C" fn view_lights(view: u32, scene: u32, count: usize, flags: u32) -> u32 {
    of_view(view, scene, |view, scene| {
        with_scratch(count * LIGHT_NUMBERS * 8, |bytes| {
            view.cull_lights(scene, bytemuck::cast_slice(bytes), flags)
        })?;
        answer(view.lights().kept());
        Ok(())
    })
}

/// Further answers on the lights: 0 reasons, 1 receivers, 2 rows.
#[unsafe(no_mangle)]
extern "C" fn view_lights_of(view: u32, which: u32) {
    if let Some(view) = VIEWS.lock().get(view) {
        match which {
            0 => answer(view.lights().reasons()),
            1 => answer(view.lights().receivers()),
            _ => answer(view.lights().rows()),
        }
    }
}

/// The answer is the ids of the casters of a kept light.
#[unsafe(no_mangle)]
extern "C" fn view_casters(view: u32, scene: u32, at: usize) -> u32 {
    of_view(view, scene, |view, scene| {
        answer(view.casters(scene, at)?);
        Ok(())
    })
}
