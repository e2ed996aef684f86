//! Where tiles are: transforms, and the frame of a tileset on the globe.

use cullet::math;
use glam::{DMat3, DMat4, DVec3, DVec4};

use super::json::{GltfUp, TileJson, Volume};
use cullet_io::{ErrorKind, Up};

/// Nearer than this to 0 a tileset without a region is not on the globe, in metres.
const NEAR_ZERO: f64 = 3e6;
/// So far above or below the ellipsoid the middle of one on the globe may be, in metres, beside
/// what its size sinks it.
const HEIGHT: f64 = 2e4;
/// Coordinates of maps are so far from their own zero height at the most, in metres.
const LOW: f64 = 1.2e4;
/// The cosine of the angle up to which a tile's z axis stands upright on the ellipsoid.
const UPRIGHT: f64 = 0.9;

/// Half axes of the WGS 84 ellipsoid, in metres.
const EQUATOR: f64 = 6_378_137.0;
const POLE: f64 = 6_356_752.314_245_179;

/// A tile's transform: 16 numbers, by columns.
pub(super) fn matrix(transform: Option<&Vec<f64>>) -> Result<DMat4, ErrorKind> {
    let Some(transform) = transform else { return Ok(DMat4::IDENTITY) };
    let found = transform.len();
    let invalid = |message: String| ErrorKind::invalid("transform", message);
    let numbers: &[f64; 16] = transform
        .as_slice()
        .try_into()
        .map_err(|_| invalid(format!("it has {found} numbers; 16 are a matrix")))?;
    let matrix = DMat4::from_cols_array(numbers);
    if !matrix.is_finite() || matrix.row(3) != DVec4::W {
        return Err(invalid("it is no affine matrix of finite numbers".into()));
    }
    Ok(matrix)
}

/// Returns the matrix that turns glTF to tiles, which are z-up.
pub(super) fn gltf_to_z_up(up: GltfUp) -> DMat4 {
    match up {
        GltfUp::X => DMat4::from_cols(DVec4::Z, DVec4::Y, -DVec4::X, DVec4::W),
        GltfUp::Y => DMat4::from_cols(DVec4::X, DVec4::Z, -DVec4::Y, DVec4::W),
        GltfUp::Z => DMat4::IDENTITY,
    }
}

/// From the space of a tileset to that of a scene, where it is not on the globe.
pub(super) fn plain() -> DMat4 {
    gltf_to_z_up(GltfUp::Y).transpose()
}

/// How a tileset lies in a scene.
#[derive(Debug)]
pub(super) struct Frame {
    /// From the space of the tileset to that of the scene.
    pub(super) frame: DMat4,
    /// Assumption that was made, where the tileset does not say.
    pub(super) note: Option<String>,
    /// Whether the scene is the one that this crate wrote the tileset of, in its own coordinates.
    pub(super) is_ours: bool,
}

/// Finds the frame of a tileset by its root; `up` says that it is not on the globe.
pub(super) fn frame(root: &TileJson<'_>, up: Option<Up>) -> Result<Frame, ErrorKind> {
    let middle = middle(root)?;
    let is_ours = root.extras.0.is_some() && root.transform.is_none();
    let flat = |note: Option<String>| Ok(Frame { frame: plain(), note, is_ours });
    match up {
        Some(Up::Y) => {
            return Ok(Frame { frame: DMat4::IDENTITY, note: None, is_ours: false });
        }
        Some(Up::Z) => return flat(None),
        None => {}
    }
    // A place on the globe that a scene was written for is taken away again.
    if root.extras.0.as_ref().is_some_and(|ours| ours.placed) {
        let frame = plain() * matrix(root.transform.as_ref())?.inverse();
        if frame.is_finite() {
            return Ok(Frame { frame, note: None, is_ours: true });
        }
    }
    let is_said = root.bounding_volume.region.is_some();
    // Those that this crate wrote lie as the scene did, unless somebody moved them since.
    if is_ours || (!is_said && middle.length() < NEAR_ZERO) {
        return flat(None);
    }
    let to_scene = |note: Option<String>| {
        let axes = DMat4::from_mat3(east_north_up(middle)).transpose();
        let frame = plain() * axes * DMat4::from_translation(-middle);
        Ok(Frame { frame, note, is_ours: false })
    };
    if is_said {
        return to_scene(None);
    }
    let transform = matrix(root.transform.as_ref())?;
    let scale = DVec3::new(EQUATOR, EQUATOR, POLE);
    let height = middle.length() * (1.0 - (middle / scale).length_recip());
    let [low, high] = bounds(&root.bounding_volume, &transform, &DMat4::IDENTITY).map(DVec3::from);
    let reach = (high - low).length() * 0.5;
    let place = format!("its middle is {:.0} km from zero", middle.length() * 1e-3);
    if height.abs() > HEIGHT + reach * reach / EQUATOR {
        return flat(Some(format!(
            "{place} and not near the globe: taken as a map's coordinates, z up"
        )));
    }
    // In a map's coordinates heights are small, as they are on the globe at the equator alone.
    let axis = transform.transform_vector3(DVec3::Z).normalize_or_zero();
    if middle.z.abs() < LOW && axis.dot(east_north_up(middle).z_axis) < UPRIGHT {
        return flat(Some(format!(
            "{place}, near the globe's equator, but it does not stand upright there: taken as a \
             map's coordinates, z up; a region as the root's bounding volume says that it is on the \
             globe"
        )));
    }
    to_scene(Some(format!(
        "{place}, near the ellipsoid: taken to be on the globe (WGS 84), and turned so that up is +Y \
         there; --up z (LoadOptions::up) reads it as it lies"
    )))
}

/// Returns the axes of the ellipsoid at a place: east, north and up. On its axis any way is east.
pub(super) fn east_north_up(at: DVec3) -> DMat3 {
    let scale = DVec3::new(EQUATOR, EQUATOR, POLE);
    let up = (at / (scale * scale)).normalize_or(DVec3::Z);
    let east = DVec3::new(-at.y, at.x, 0.0).normalize_or(DVec3::Y);
    let east = (east - up * east.dot(up)).normalize_or(DVec3::Y);
    DMat3::from_cols(east, up.cross(east), up)
}

/// A box around a bounding volume, in the space that the transform leads to; regions are in that of
/// the globe, `frame`. Infinite where the volume is none.
pub(super) fn bounds(volume: &Volume, transform: &DMat4, frame: &DMat4) -> [[f64; 3]; 2] {
    let around =
        |centre: DVec3, half: DVec3| [(centre - half).to_array(), (centre + half).to_array()];
    let found = if let Some(&[west, south, east, north, low, high]) = volume.region.as_deref() {
        let width = if east < west { east + std::f64::consts::TAU - west } else { east - west };
        let at = |x: f64, y: f64, height: f64| {
            frame.transform_point3(on_globe(west + width * x, south + (north - south) * y, height))
        };
        let middle = at(0.5, 0.5, (low + high) * 0.5);
        let steps = [0.0, 0.5, 1.0];
        let places = steps.iter().flat_map(|&x| steps.map(|y| [at(x, y, low), at(x, y, high)]));
        let reach = places.flatten().map(|p| p.distance(middle)).fold(0.0, f64::max);
        // Between those places the globe bulges, of a small region by next to nothing.
        around(middle, DVec3::splat(reach * 1.1))
    } else if let Some(block) = volume.block.as_deref().filter(|block| block.len() == 12) {
        let axes =
            [3, 6, 9].map(|k| transform.transform_vector3(DVec3::from_slice(&block[k..])).abs());
        around(transform.transform_point3(DVec3::from_slice(block)), axes.into_iter().sum())
    } else if let Some(&[x, y, z, radius]) = volume.sphere.as_deref() {
        let reach = DVec3::splat(radius * scale(transform));
        around(transform.transform_point3(DVec3::new(x, y, z)), reach)
    } else {
        around(DVec3::ZERO, DVec3::INFINITY)
    };
    let is_sound = found.iter().flatten().all(|v| v.is_finite());
    if is_sound { found } else { [[f64::NEG_INFINITY; 3], [f64::INFINITY; 3]] }
}

/// Returns the largest factor by which a transform lengthens anything.
pub(super) fn scale(transform: &DMat4) -> f64 {
    let columns = DMat3::from_mat4(*transform);
    [columns.x_axis, columns.y_axis, columns.z_axis]
        .map(DVec3::length)
        .into_iter()
        .fold(0.0, f64::max)
}

/// The middle of the root's bounding volume, in the space of the tileset.
fn middle(root: &TileJson<'_>) -> Result<DVec3, ErrorKind> {
    let volume = &root.bounding_volume;
    let check = |kind: &str, numbers: &[f64], expected: usize| {
        let found = numbers.len();
        if found != expected || !numbers.iter().all(|v| v.is_finite()) {
            let message = format!("it has {found} numbers; {expected} finite ones are a {kind}");
            return Err(ErrorKind::invalid("boundingVolume", message));
        }
        Ok(())
    };
    // Regions are on the globe; a tile's transform does not apply to them.
    if let Some(region) = &volume.region {
        check("region", region, 6)?;
        let [west, south, east, north, low, high] = [0, 1, 2, 3, 4, 5].map(|k| region[k]);
        let width = if east < west { east + std::f64::consts::TAU - west } else { east - west };
        return Ok(on_globe(west + width * 0.5, (south + north) * 0.5, (low + high) * 0.5));
    }
    let transform = matrix(root.transform.as_ref())?;
    let centre = match (&volume.block, &volume.sphere) {
        (Some(block), _) => {
            check("box", block, 12)?;
            DVec3::from_slice(block)
        }
        (None, Some(sphere)) => {
            check("sphere", sphere, 4)?;
            DVec3::from_slice(sphere)
        }
        (None, None) => {
            return Err(ErrorKind::invalid(
                "boundingVolume",
                "it is neither a box, a sphere nor a region; other volumes are not read",
            ));
        }
    };
    Ok(transform.transform_point3(centre))
}

/// A place on the globe: longitude and latitude in radians, height in metres.
pub(super) fn on_globe(longitude: f64, latitude: f64, height: f64) -> DVec3 {
    let squeezed = (POLE / EQUATOR) * (POLE / EQUATOR);
    let (sin, cos) = math::sin_cos(latitude);
    let radius = EQUATOR / (1.0 - (1.0 - squeezed) * sin * sin).sqrt();
    let (sin_long, cos_long) = math::sin_cos(longitude);
    DVec3::new(
        (radius + height) * cos * cos_long,
        (radius + height) * cos * sin_long,
        (radius * squeezed + height) * sin,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_on_the_globe_are_those_that_are_known() {
        let near = |a: DVec3, b: [f64; 3]| assert!(a.distance(b.into()) < 1e-3, "{a} {b:?}");
        near(on_globe(0.0, 0.0, 0.0), [EQUATOR, 0.0, 0.0]);
        near(on_globe(0.0, std::f64::consts::FRAC_PI_2, 10.0), [0.0, 0.0, POLE + 10.0]);
        // Greenwich, by the formula of the textbooks with eccentricity squared 0.00669437999014.
        let (latitude, height) = (51.477_8_f64.to_radians(), 47.0);
        let n = EQUATOR / (1.0 - 0.006_694_379_990_14 * latitude.sin().powi(2)).sqrt();
        let z = (n * (1.0 - 0.006_694_379_990_14) + height) * latitude.sin();
        near(on_globe(0.0, latitude, height), [(n + height) * latitude.cos(), 0.0, z]);
    }

    #[test]
    fn up_is_y_where_a_tileset_is_on_the_globe() {
        let (longitude, latitude) = (0.3_f64, 0.9_f64);
        let root = format!(
            r#"{{"boundingVolume":{{"region":[{},{},{},{},0,0]}},"geometricError":1}}"#,
            longitude - 1e-4,
            latitude - 1e-4,
            longitude + 1e-4,
            latitude + 1e-4
        );
        let root: TileJson<'_> = super::super::json::of_bytes(root.as_bytes(), "root").unwrap();
        let frame = frame(&root, None).unwrap().frame;
        let at = |long, lat, height| frame.transform_point3(on_globe(long, lat, height));
        assert!(at(longitude, latitude, 0.0).length() < 1e-6);
        assert!(at(longitude, latitude, 100.0).distance(DVec3::new(0.0, 100.0, 0.0)) < 1e-6);
        let east = at(longitude + 1e-5, latitude, 0.0);
        assert!(east.x > 30.0 && east.y.abs() < 0.1 && east.z.abs() < 0.1, "{east}");
        let north = at(longitude, latitude + 1e-5, 0.0);
        assert!(north.z < -50.0 && north.x.abs() < 0.1 && north.y.abs() < 0.1, "{north}");
    }
}
