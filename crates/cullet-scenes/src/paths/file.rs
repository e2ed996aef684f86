//! Paths in files.

use std::path::Path;

use cullet::{Camera, Projection};
use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::keys::{Pose, sample, spread};
use super::{Lens, PathError};

/// The most bytes of a path's file.
const LIMIT: u64 = 64 << 20;

/// A far plane from here on is infinite.
const INFINITE: f64 = 1e300;

/// A path's file. What stands at the top holds for every camera that does not say otherwise.
#[derive(Deserialize, Serialize, Default)]
#[serde(deny_unknown_fields, default)]
struct PathFile {
    #[serde(skip_serializing_if = "Option::is_none")]
    up: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fov_degrees: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    near: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    far: Option<f64>,
    /// Cameras to be used as they are.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    views: Vec<Entry>,
    /// Cameras with times, to be moved between.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    keys: Vec<Entry>,
}

/// A camera of the file.
#[derive(Deserialize, Serialize, Clone, Default)]
#[serde(deny_unknown_fields, default)]
struct Entry {
    /// Seconds; for keys alone, and ascending.
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    eye: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    target: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    direction: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    up: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fov_degrees: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    orthographic_height: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    near: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    far: Option<f64>,
}

/// Writes cameras as the text of a path's file.
///
/// The file is an object with the list `views`, of cameras to be used as they are, or the list `keys`, of
/// cameras to be moved between; a bare list is taken as `views`. Each camera has
/// `eye`; `target`, or `direction` of any length; and, if wanted, `up` (default `[0, 1, 0]`, or +Z where
/// the camera looks along Y), `fov_degrees` (vertical, default 60) or `orthographic_height` (of the
/// picture, in scene units), `near` and `far`
/// (default: they fit the scene). A key also has `time` in seconds, ascending: the path is sampled evenly
/// from the first to the last, the eye moving straight and the direction turning along the arc. `up`,
/// `fov_degrees`, `near` and `far` beside the list hold for all cameras that do not say otherwise.
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
    let mut file = PathFile::default();
    for (index, c) in cameras.iter().enumerate() {
        let mut entry = Entry {
            eye: Some(c.eye),
            direction: Some(c.direction),
            up: Some(c.up),
            ..Entry::default()
        };
        match c.projection {
            Projection::Perspective { fov_y_radians, near, far, .. } => {
                entry.fov_degrees = Some(fov_y_radians.to_degrees());
                (entry.near, entry.far) = (Some(near), Some(far.min(INFINITE)));
            }
            Projection::Orthographic { left, right, bottom, top, near, far }
                if left == -right && bottom == -top =>
            {
                entry.orthographic_height = Some(top - bottom);
                (entry.near, entry.far) = (Some(near), Some(far));
            }
            _ => return Err(PathError::NotWritable(index)),
        }
        file.views.push(entry);
    }
    // Plain numbers and lists always have a text.
    serde_json::to_string_pretty(&file)
        .map_err(|error| PathError::Json { path: "path".into(), error })
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
    let json = |error| PathError::Json { path: path.to_owned(), error };
    let item = |item: String, message: &str| PathError::Item {
        path: path.to_owned(),
        item,
        message: message.to_owned(),
    };
    // A list and an object are told apart by their first character, so that errors name their line.
    let list = text.iter().find(|b| !b.is_ascii_whitespace()) == Some(&b'[');
    let file = if list {
        let views: Vec<Entry> = serde_json::from_slice(text).map_err(json)?;
        PathFile { views, ..PathFile::default() }
    } else {
        serde_json::from_slice(text).map_err(json)?
    };
    let moving = !file.keys.is_empty();
    let entries = if moving { &file.keys } else { &file.views };
    let name = |i: usize| format!("{}[{i}]", if moving { "keys" } else { "views" });
    if entries.is_empty() || (moving && !file.views.is_empty()) {
        return Err(item("the file".into(), "needs cameras in either 'views' or 'keys'"));
    }
    let mut poses = Vec::with_capacity(entries.len());
    let mut times = Vec::with_capacity(entries.len());
    for (i, e) in entries.iter().enumerate() {
        poses.push(pose(e, &file).map_err(|message| item(name(i), message))?);
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
            camera(&entry, &file, &poses[a].between(&poses[b], t), lens)
        };
        return Ok(sample(&times, count).into_iter().map(at).collect());
    }
    Ok(spread(entries.len(), count).map(|i| camera(&entries[i], &file, &poses[i], lens)).collect())
}

fn pose(e: &Entry, file: &PathFile) -> Result<Pose, &'static str> {
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
    let up = e.up.or(file.up).unwrap_or(if along_y { [0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0] });
    Ok(Pose { eye, direction, up: up.into() })
}

/// The camera of an entry: the caller's word goes before the entry's, and that before the file's.
fn camera(e: &Entry, file: &PathFile, pose: &Pose, lens: &Lens) -> Camera {
    let o = &lens.overrides;
    let near = o.near.or(e.near).or(file.near);
    let far = o.far.or(e.far).or(file.far);
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
        let fov = o.fov_degrees.or(e.fov_degrees).or(file.fov_degrees);
        let fov_y_radians = fov.unwrap_or(super::DEFAULT_FOV_DEGREES).to_radians();
        let [near, far] = lens.fit(eye, fov_y_radians, near, far);
        Projection::Perspective { fov_y_radians, aspect: lens.aspect, near, far }
    };
    Camera { eye: eye.into(), direction: direction.into(), up: up.into(), projection }
}
