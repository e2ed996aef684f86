//! Sizes in pixels: of instances, and of what levels of detail are off by.

use cullet::bounds::Aabb;
use cullet::cull::detail::{Detail, Measure};
use cullet::lod::{LevelEye, Lod, PixelScale};
use cullet::view::ViewError;
use cullet::{Transform, View};

use crate::{Computed, Entry, end_of, number};

pub(crate) const ENTRIES: &[Entry] = &[
    ("detail-1", pixels_of_a_metre),
    ("detail-2", farthest_of_two_pixels),
    ("detail-3", cable),
    ("levels-1", pixels_of_an_error),
    ("levels-2", nearest_of_a_level),
];

/// 1080 pixels for 60 degrees, from the origin along −Z.
fn view() -> Result<View, ViewError> {
    let fov = 60_f64.to_radians();
    View::perspective([0.0; 3], [0.0, 0.0, -1.0], fov, 0.1, 10_000.0, [1920, 1080])
}

/// How many pixels high something upright of 1 m is.
fn height(view: &View, distance: f64) -> f64 {
    let z = -distance as f32;
    let sheet = Aabb::new([-0.5, -0.5, z], [0.5, 0.5, z]);
    view.project_box(&sheet, [0.0; 3]).map_or(f64::INFINITY, |rect| rect.height())
}

fn pixels_of_a_metre() -> Computed {
    number(height(&view()?, 100.0))
}

fn farthest_of_two_pixels() -> Computed {
    let view = view()?;
    number(end_of(1.0, 10_000.0, |distance| height(&view, distance) >= 2.0))
}

fn cable() -> Computed {
    let measure = Measure::WidthAndHeight;
    let detail = Detail::default().with_measure(measure).with_threshold_px(4.0);
    Ok(if detail.is_small_size([0.5, 40.0], 1.0) { "dropped" } else { "kept" }.to_owned())
}

/// The error that is a pixel at a distance.
fn error_of_a_pixel(eye: &LevelEye, distance: f64) -> f64 {
    f64::from(eye.allowed([0.0, 0.0, -distance as f32], 0.0))
}

fn level_eye() -> Result<LevelEye, ViewError> {
    let lod = Lod::default().with_pixels(1.0);
    Ok(LevelEye::new(&lod, &PixelScale::of(&view()?, false), &Transform::IDENTITY, None))
}

fn pixels_of_an_error() -> Computed {
    number(0.02 / error_of_a_pixel(&level_eye()?, 50.0))
}

fn nearest_of_a_level() -> Computed {
    let eye = level_eye()?;
    number(end_of(1.0, 1000.0, |distance| error_of_a_pixel(&eye, distance) < 0.02))
}
