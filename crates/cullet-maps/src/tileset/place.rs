//! Where tiles are: transforms, and the frame of a tileset on the globe.

use glam::{DMat3, DMat4, DVec3, DVec4};

use super::json::{TileJson, Volume};
use cullet_io::ErrorKind;

/// Farther than this from 0 a tileset is taken to be on the globe, in metres from its middle.
const ON_THE_GLOBE: f64 = 3e6;

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

/// Returns the matrix that turns glTF, y-up, to tiles, z-up.
pub(super) fn y_up_to_z_up() -> DMat4 {
    DMat4::from_cols(DVec4::X, DVec4::Z, -DVec4::Y, DVec4::W)
}

/// From the space of a tileset to that of a scene, where it is not on the globe.
pub(super) fn plain() -> DMat4 {
    y_up_to_z_up().transpose()
}

/// From the space of a tileset to that of a scene.
pub(super) fn frame(root: &TileJson<'_>) -> Result<DMat4, ErrorKind> {
    let z_up_to_y_up = plain();
    let middle = middle(root)?;
    if middle.length() < ON_THE_GLOBE {
        return Ok(z_up_to_y_up);
    }
    // The normal of the ellipsoid; on its axis any way is east.
    let scale = DVec3::new(EQUATOR, EQUATOR, POLE);
    let up = (middle / (scale * scale)).normalize_or(DVec3::Z);
    let east = DVec3::new(-middle.y, middle.x, 0.0).normalize_or(DVec3::Y);
    let east = (east - up * east.dot(up)).normalize_or(DVec3::Y);
    let north = up.cross(east);
    let to_local =
        DMat4::from_cols(east.extend(0.0), north.extend(0.0), up.extend(0.0), DVec4::W).transpose();
    Ok(z_up_to_y_up * to_local * DMat4::from_translation(-middle))
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
                "it is neither a box, a sphere nor a region",
            ));
        }
    };
    Ok(transform.transform_point3(centre))
}

/// A place on the globe: longitude and latitude in radians, height in metres.
pub(super) fn on_globe(longitude: f64, latitude: f64, height: f64) -> DVec3 {
    let squeezed = (POLE / EQUATOR) * (POLE / EQUATOR);
    let (sin, cos) = latitude.sin_cos();
    let radius = EQUATOR / (1.0 - (1.0 - squeezed) * sin * sin).sqrt();
    let (sin_long, cos_long) = longitude.sin_cos();
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
        let frame = frame(&root).unwrap();
        let at = |long, lat, height| frame.transform_point3(on_globe(long, lat, height));
        assert!(at(longitude, latitude, 0.0).length() < 1e-6);
        assert!(at(longitude, latitude, 100.0).distance(DVec3::new(0.0, 100.0, 0.0)) < 1e-6);
        let east = at(longitude + 1e-5, latitude, 0.0);
        assert!(east.x > 30.0 && east.y.abs() < 0.1 && east.z.abs() < 0.1, "{east}");
        let north = at(longitude, latitude + 1e-5, 0.0);
        assert!(north.z < -50.0 && north.x.abs() < 0.1 && north.y.abs() < 0.1, "{north}");
    }
}
