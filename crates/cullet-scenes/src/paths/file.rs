//! Paths in files.

use std::path::Path;

use cullet::{Camera, Projection};
use cullet_io::reader::{FromJson, Json, Object};
use glam::DVec3;

use super::keys::{Pose, sample, spread};
use super::{Lens, PathError};

/// The most bytes of a path's file.
const LIMIT: u64 = 64 << 20;

/// A far plane from here on is infinite.
const INFINITE: f64 = 1e300;

/// A path's file. What stands at the top holds for every camera that does not say otherwise.
#[derive(Default)]
struct PathFile<'a> {
    shared: Entry,
    /// Cameras to be used as they are.
    views: Vec<Json<'a>>,
    /// Cameras with times, to be moved between.
    keys: Vec<Json<'a>>,
}

impl<'a> FromJson<'a> for PathFile<'a> {
    fn from_json(json: Json<'a>) -> Result<Self, String> {
        // A bare list is one of views.
        if json.text().starts_with('[') {
            return Ok(Self { views: Vec::from_json(json)?, ..Self::default() });
        }
        if !json.text().starts_with('{') {
            return Err(json.unexpected("an object or a list"));
        }
        let all = Object::from_json(json)?;
        all.only(&["up", "fov_degrees", "near", "far", "views", "keys"])?;
        let (views, keys) = (all.or_default("views")?, all.or_default("keys")?);
        Ok(Self { shared: Entry::read(&all)?, views, keys })
    }
}

/// A camera of the file.
#[derive(Clone, Default)]
struct Entry {
    /// Seconds; for keys alone, and ascending.
    time: Option<f64>,
    eye: Option<[f64; 3]>,
    target: Option<[f64; 3]>,
    direction: Option<[f64; 3]>,
    up: Option<[f64; 3]>,
    fov_degrees: Option<f64>,
    orthographic_height: Option<f64>,
    near: Option<f64>,
    far: Option<f64>,
}

/// Members of a camera that are numbers, and those that are places or directions.
const NUMBERS: [&str; 5] = ["time", "fov_degrees", "orthographic_height", "near", "far"];
const PLACES: [&str; 4] = ["eye", "target", "direction", "up"];

impl Entry {
    fn read(all: &Object<'_>) -> Result<Self, String> {
        let mut numbers = [None; 5];
        for (number, name) in numbers.iter_mut().zip(NUMBERS) {
            *number = all.get(name)?;
        }
        let mut places: [Option<[f64; 3]>; 4] = [None; 4];
        for (place, name) in places.iter_mut().zip(PLACES) {
            *place = all.get(name)?;
        }
        let mut all = numbers.iter().flatten().chain(places.iter().flatten().flatten());
        if !all.all(|v| v.is_finite()) {
            return Err("number out of range".to_owned());
        }
        let [time, fov_degrees, orthographic_height, near, far] = numbers;
        let [eye, target, direction, up] = places;
        Ok(Self { time, eye, target, direction, up, fov_degrees, orthographic_height, near, far })
    }
}

impl FromJson<'_> for Entry {
    fn from_json(json: Json<'_>) -> Result<Self, String> {
        let all = Object::from_json(json)?;
        all.only(&[&PLACES[..], &NUMBERS[..]].concat())?;
        Self::read(&all)
    }
}

/// Writes cameras as the text of a path's file.
///
/// The file is an object with the list `views`, of cameras to be used as they are, or the list
/// `keys`, of cameras to be moved between; a bare list is taken as `views`. Each camera has `eye`;
/// `target`, or `direction` of any length; and, if wanted, `up` (default `[0, 1, 0]`, or +Z where
/// the camera looks along Y), `fov_degrees` (vertical, default 60) or `orthographic_height` (of the
/// picture, in scene units), `near` and `far` (default: they fit the scene). A key also has `time`
/// in seconds, ascending: the path is sampled evenly from the first to the last, the eye moving
/// straight and the direction turning along the arc. `up`, `fov_degrees`, `near` and `far` beside
/// the list hold for all cameras that do not say otherwise.
///
/// ```json
/// { "fov_degrees": 50, "keys": [
///   { "time": 0, "eye": [0, 2, 9], "target": [0, 1, 0] },
///   { "time": 4, "eye": [9, 2, 0], "direction": [-1, 0, 0], "near": 0.1 } ] }
/// ```
///
/// JSON has no infinity: a `far` of 1e300 or more is infinite.
///
/// # Errors
/// If a camera is off-centre, which the file cannot say.
pub fn to_json(cameras: &[Camera]) -> Result<String, PathError> {
    let mut views = Vec::with_capacity(cameras.len());
    for (index, c) in cameras.iter().enumerate() {
        let (kind, size, near, far) = match c.projection {
            Projection::Perspective { fov_y_radians, near, far, .. } => {
                ("fov_degrees", fov_y_radians.to_degrees(), near, far.min(INFINITE))
            }
            Projection::Orthographic { left, right, bottom, top, near, far }
                if left == -right && bottom == -top =>
            {
                ("orthographic_height", top - bottom, near, far)
            }
            _ => return Err(PathError::NotWritable(index)),
        };
        let Camera { eye, direction, up, .. } = c;
        let view = format!(
            "    {{ \"eye\": {eye:?}, \"direction\": {direction:?}, \"up\": {up:?}, \"{kind}\": {size:?}, \"near\": {near:?}, \"far\": {far:?} }}"
        );
        // Numbers as Rust writes them are those of JSON, but for what is none.
        views.push(view.replace("NaN", "null").replace("-inf", "null").replace("inf", "null"));
    }
    Ok(format!("{{\n  \"views\": [\n{}\n  ]\n}}", views.join(",\n")))
}

/// The cameras of a file.
pub(super) fn cameras(path: &Path, lens: &Lens, count: usize) -> Result<Vec<Camera>, PathError> {
    let read = |error| PathError::Read { path: path.to_owned(), error };
    let bytes = std::fs::metadata(path).map_err(read)?.len();
    if bytes > LIMIT {
        return Err(PathError::TooLarge { path: path.to_owned(), bytes, limit: LIMIT });
    }
    let text = std::fs::read(path).map_err(read)?;
    parse(&text, path, lens, count)
}

fn parse(text: &[u8], path: &Path, lens: &Lens, count: usize) -> Result<Vec<Camera>, PathError> {
    let json = |error: String| PathError::Json { path: path.to_owned(), error };
    let item = |item: String, message: &str| PathError::Item {
        path: path.to_owned(),
        item,
        message: message.to_owned(),
    };
    let text = std::str::from_utf8(text).map_err(|e| json(e.to_string()))?;
    let file = Json::parse(text).and_then(PathFile::from_json);
    let PathFile { shared, views, keys } = file.map_err(json)?;
    let moving = !keys.is_empty();
    let values = if moving { &keys } else { &views };
    let name = |i: usize| format!("{}[{i}]", if moving { "keys" } else { "views" });
    let mut entries = Vec::with_capacity(values.len());
    for (i, value) in values.iter().enumerate() {
        let place = || format!("line {}, {}", value.line_in(text), name(i));
        entries.push(Entry::from_json(*value).map_err(|message| item(place(), &message))?);
    }
    if entries.is_empty() || (moving && !views.is_empty()) {
        return Err(item("the file".into(), "needs cameras in either 'views' or 'keys'"));
    }
    let mut poses = Vec::with_capacity(entries.len());
    let mut times = Vec::with_capacity(entries.len());
    for (i, e) in entries.iter().enumerate() {
        poses.push(pose(e, &shared).map_err(|message| item(name(i), message))?);
        match e.time {
            Some(_) if !moving => return Err(item(name(i), "has a time, which only keys have")),
            None if moving => return Err(item(name(i), "is a key without time")),
            Some(t) if times.last().is_some_and(|last| t < *last) => {
                return Err(item(name(i), "is earlier than the key before it"));
            }
            t => times.push(t.unwrap_or_default()),
        }
        if e.orthographic_height.is_some() && (e.fov_degrees.is_some() || moving) {
            let message = "orthographic_height goes with neither fov_degrees nor keys";
            return Err(item(name(i), message));
        }
    }
    if moving {
        let at = |(a, b, t): (usize, usize, f64)| {
            let mix = |f: fn(&Entry) -> Option<f64>| match (f(&entries[a]), f(&entries[b])) {
                (Some(x), Some(y)) => Some(x + (y - x) * t),
                (x, y) => x.or(y),
            };
            let entry = Entry {
                fov_degrees: mix(|e| e.fov_degrees),
                near: mix(|e| e.near),
                far: mix(|e| e.far),
                ..Entry::default()
            };
            camera(&entry, &shared, &poses[a].between(&poses[b], t), lens)
        };
        return Ok(sample(&times, count).into_iter().map(at).collect());
    }
    Ok(spread(entries.len(), count)
        .map(|i| camera(&entries[i], &shared, &poses[i], lens))
        .collect())
}

fn pose(e: &Entry, shared: &Entry) -> Result<Pose, &'static str> {
    let eye = DVec3::from(e.eye.ok_or("has no eye")?);
    let direction = match (e.target, e.direction) {
        (Some(target), None) => DVec3::from(target) - eye,
        (None, Some(direction)) => direction.into(),
        (None, None) => return Err("has neither target nor direction"),
        (Some(_), Some(_)) => return Err("has both target and direction; give one"),
    };
    if direction.try_normalize().is_none() {
        return Err("looks nowhere: its direction has no length");
    }
    let along_y = direction.normalize().y.abs() > 0.9999;
    let up = e.up.or(shared.up).unwrap_or(if along_y { [0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0] });
    Ok(Pose { eye, direction, up: up.into() })
}

/// The camera of an entry: the caller's word goes before the entry's, and that before the file's.
fn camera(e: &Entry, shared: &Entry, pose: &Pose, lens: &Lens) -> Camera {
    let o = &lens.overrides;
    let near = o.near.or(e.near).or(shared.near);
    let far = o.far.or(e.far).or(shared.far);
    let far = far.map(|v| if v >= INFINITE { f64::INFINITY } else { v });
    let Pose { eye, direction, up } = *pose;
    let projection = if let Some(height) = e.orthographic_height {
        let [top, right] = [height * 0.5, height * 0.5 * lens.aspect];
        let [fit_near, fit_far] = lens.fit_parallel(eye, direction);
        Projection::Orthographic {
            left: -right,
            right,
            bottom: -top,
            top,
            near: near.unwrap_or(fit_near),
            far: far.unwrap_or(fit_far),
        }
    } else {
        let fov = o.fov_degrees.or(e.fov_degrees).or(shared.fov_degrees);
        let fov_y_radians = fov.unwrap_or(super::DEFAULT_FOV_DEGREES).to_radians();
        let [near, far] = lens.fit(eye, fov_y_radians, near, far);
        Projection::Perspective { fov_y_radians, aspect: lens.aspect, near, far }
    };
    Camera { eye: eye.into(), direction: direction.into(), up: up.into(), projection }
}
