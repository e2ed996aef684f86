//! Tiles of 3D Tiles 1.0: a glTF behind tables (b3dm), with places of instances (i3dm), or several
//! tiles in one file (cmpt).

use glam::{DMat3, DMat4, DQuat, DVec3};

use super::json::of_bytes;
use super::place::east_north_up;
use cullet_io::ErrorKind;
use cullet_io::reader::{FromJson, Json, Object};

/// Bytes before the tables of a b3dm.
pub(super) const FIRST_TABLE: usize = 28;
/// Bytes before those of an i3dm, and before the tiles of a cmpt.
const INSTANCED: usize = 32;
const COMPOSITE: usize = 16;
/// The most tiles that lie within each other.
const DEEPEST: u32 = 8;
/// The largest numbers of quantised places and of directions.
const LARGEST_U16: f64 = 65_535.0;

/// A part of a tile.
pub(super) enum Part {
    /// A glTF, and where in the space of the tile its instances are.
    Drawn { gltf: Gltf, places: Vec<DMat4> },
    /// Points, which have no surface.
    Points,
}

/// A glTF of a tile.
pub(super) enum Gltf {
    /// Its bytes.
    Inside(Vec<u8>),
    /// Its address, relative to the tile.
    Named(String),
}

/// Returns the parts of a tile that stands in the space of its tileset at `place`.
pub(super) fn parts(bytes: Vec<u8>, place: &DMat4) -> Result<Vec<Part>, ErrorKind> {
    let mut all = Vec::new();
    match bytes.get(..4) {
        Some(b"b3dm" | b"i3dm" | b"pnts" | b"cmpt") => add(&bytes, place, 0, &mut all)?,
        _ => all.push(Part::Drawn { gltf: Gltf::Inside(bytes), places: vec![DMat4::IDENTITY] }),
    }
    Ok(all)
}

/// Adds the parts of a tile, at most [`DEEPEST`] deep in others.
fn add(bytes: &[u8], place: &DMat4, depth: u32, all: &mut Vec<Part>) -> Result<(), ErrorKind> {
    match bytes.get(..4) {
        Some(b"b3dm") => {
            let tables = Tables::of(bytes, FIRST_TABLE, bytes.len() as u64, "b3dm header")?;
            let moved = DMat4::from_translation(tables.features(bytes)?.centre()?);
            let gltf = Gltf::Inside(bytes[tables.end..].to_vec());
            all.push(Part::Drawn { gltf, places: vec![moved] });
        }
        Some(b"i3dm") => {
            let tables = Tables::of(bytes, INSTANCED, bytes.len() as u64, "i3dm header")?;
            let places = instances(&tables.features(bytes)?, place)?;
            let rest = &bytes[tables.end..];
            let gltf = match word(bytes, 7) {
                Some(0) => {
                    let uri = String::from_utf8_lossy(rest);
                    Gltf::Named(uri.trim_matches(['\0', ' ']).to_owned())
                }
                _ => Gltf::Inside(rest.to_vec()),
            };
            all.push(Part::Drawn { gltf, places });
        }
        Some(b"pnts") => all.push(Part::Points),
        Some(b"cmpt") if depth < DEEPEST => {
            let invalid = |message: String| ErrorKind::invalid("cmpt", message);
            let count = word(bytes, 3).ok_or_else(|| invalid("its header is cut short".into()))?;
            let mut rest = bytes.get(COMPOSITE..).unwrap_or_default();
            for k in 0..count {
                let size = word(rest, 2).filter(|&size| size >= 12 && size <= rest.len());
                let Some(size) = size else {
                    let message = format!("tile {k} of {count} does not end within it");
                    return Err(invalid(message));
                };
                let (one, after) = rest.split_at(size);
                add(one, place, depth + 1, all)?;
                rest = after;
            }
        }
        Some(b"cmpt") => {
            let (item, count) = ("cmpt within each other".to_owned(), u64::from(DEEPEST) + 1);
            return Err(ErrorKind::OverLimit { item, count, limit: DEEPEST.into() });
        }
        magic => {
            let magic = String::from_utf8_lossy(magic.unwrap_or_default());
            return Err(ErrorKind::Unsupported(format!(
                "a tile of the kind {magic:?} is not read"
            )));
        }
    }
    Ok(())
}

/// The number at a place that counts words of four bytes.
fn word(bytes: &[u8], k: usize) -> Option<usize> {
    let bytes = bytes.get(4 * k..4 * k + 4)?.first_chunk::<4>()?;
    Some(u32::from_le_bytes(*bytes) as usize)
}

/// The tables before a glTF.
struct Tables {
    /// Where the JSON and the numbers of features begin, and where the latter end.
    features: [usize; 3],
    /// Where the last table ends.
    end: usize,
}

impl Tables {
    /// The tables of a file of so many bytes that begin behind its header, by its first bytes.
    fn of(head: &[u8], first: usize, size: u64, item: &str) -> Result<Self, ErrorKind> {
        let all = || {
            let lengths = [word(head, 3)?, word(head, 4)?, word(head, 5)?, word(head, 6)?];
            let end = lengths.iter().try_fold(first, |a, &b| a.checked_add(b))?;
            let json = first + lengths[0];
            let features = [first, json, json + lengths[1]];
            (end as u64 <= size && first as u64 <= size).then_some(Self { features, end })
        };
        all().ok_or_else(|| {
            ErrorKind::invalid(item, format!("its tables do not end within its {size} bytes"))
        })
    }

    fn features<'a>(&self, bytes: &'a [u8]) -> Result<Features<'a>, ErrorKind> {
        let [first, numbers, end] = self.features;
        let text = &bytes[first..numbers];
        let is_blank = text.iter().all(|&b| b == 0 || b.is_ascii_whitespace());
        let json = if is_blank { Object::default() } else { of_bytes(text, "features")? };
        Ok(Features { json, numbers: &bytes[numbers..end] })
    }
}

/// Returns where the glTF of a b3dm of so many bytes begins, by its first bytes.
pub(super) fn end_of_b3dm_tables(head: &[u8], size: u64) -> Result<usize, ErrorKind> {
    Tables::of(head, FIRST_TABLE, size, "b3dm header").map(|tables| tables.end)
}

/// A table of features: JSON, and numbers that it refers to.
struct Features<'a> {
    json: Object<'a>,
    numbers: &'a [u8],
}

/// How numbers of a table are kept.
#[derive(Clone, Copy)]
enum Kind {
    F32,
    U16,
    U32,
}

impl Features<'_> {
    /// The numbers of a name, `count` of them: in the JSON, or where it says; `None` where there
    /// are none.
    fn get(&self, name: &str, count: usize, kind: Kind) -> Result<Option<Vec<f64>>, ErrorKind> {
        let invalid = |message: String| ErrorKind::invalid(format!("features, {name}"), message);
        let Some(json) = self.json.get::<Json<'_>>(name).map_err(invalid)? else { return Ok(None) };
        let found = match json.text().as_bytes().first() {
            Some(b'[') => Vec::from_json(json).map_err(invalid)?,
            Some(b'{') => {
                let object = Object::from_json(json).map_err(invalid)?;
                let begin = object.need::<u32>("byteOffset").map_err(invalid)? as usize;
                let size = if matches!(kind, Kind::U16) { 2 } else { 4 };
                let end = count.checked_mul(size).and_then(|bytes| bytes.checked_add(begin));
                let bytes = end.and_then(|end| self.numbers.get(begin..end)).ok_or_else(|| {
                    let all = self.numbers.len();
                    invalid(format!("{count} numbers from byte {begin} do not fit its {all} bytes"))
                })?;
                match kind {
                    Kind::F32 => numbers(bytes, |b| f32::from_le_bytes(b).into()),
                    Kind::U32 => numbers(bytes, |b| u32::from_le_bytes(b).into()),
                    Kind::U16 => numbers(bytes, |b| u16::from_le_bytes(b).into()),
                }
            }
            _ => vec![f64::from_json(json).map_err(invalid)?],
        };
        if found.len() != count || !found.iter().all(|v| v.is_finite()) {
            let found = found.len();
            return Err(invalid(format!("{found} numbers; {count} finite ones are expected")));
        }
        Ok(Some(found))
    }

    /// The place that all else is relative to.
    fn centre(&self) -> Result<DVec3, ErrorKind> {
        let centre = self.get("RTC_CENTER", 3, Kind::F32)?;
        Ok(centre.map_or(DVec3::ZERO, |v| DVec3::from_slice(&v)))
    }

    /// Vectors of a name, one for each of `count` instances.
    fn vectors(&self, name: &str, count: usize) -> Result<Option<Vec<DVec3>>, ErrorKind> {
        let all = self.get(name, count.saturating_mul(3), Kind::F32)?;
        Ok(all.map(|all| all.chunks_exact(3).map(DVec3::from_slice).collect()))
    }

    /// Directions of a name, as vectors or on the faces of an octahedron.
    fn directions(&self, name: &str, count: usize) -> Result<Option<Vec<DVec3>>, ErrorKind> {
        let found = self.vectors(name, count)?;
        if found.is_some() {
            return Ok(found);
        }
        let octahedral = format!("{name}_OCT32P");
        let all = self.get(&octahedral, count.saturating_mul(2), Kind::U16)?;
        Ok(all.map(|all| all.chunks_exact(2).map(|v| unfolded(v[0], v[1])).collect()))
    }
}

fn numbers<const N: usize>(bytes: &[u8], of: impl Fn([u8; N]) -> f64) -> Vec<f64> {
    bytes.as_chunks::<N>().0.iter().map(|&b| of(b)).collect()
}

/// The direction of a point of an octahedron that is unfolded to a square.
fn unfolded(x: f64, y: f64) -> DVec3 {
    let [x, y] = [x, y].map(|v| v / LARGEST_U16 * 2.0 - 1.0);
    let z = 1.0 - x.abs() - y.abs();
    let fold = |a: f64, b: f64| if z < 0.0 { (1.0 - b.abs()) * 1.0_f64.copysign(a) } else { a };
    DVec3::new(fold(x, y), fold(y, x), z)
}

/// Where the instances of an i3dm are, in the space of the tile, which stands at `place`.
fn instances(features: &Features<'_>, place: &DMat4) -> Result<Vec<DMat4>, ErrorKind> {
    let missing = |name: &str| ErrorKind::invalid("features", format!("{name} is missing"));
    let length = features.get("INSTANCES_LENGTH", 1, Kind::U32)?;
    let count = length.ok_or_else(|| missing("INSTANCES_LENGTH"))?[0] as usize;
    let centre = features.centre()?;
    let positions = match features.vectors("POSITION", count)? {
        Some(positions) => positions,
        None => {
            let all = features.get("POSITION_QUANTIZED", count.saturating_mul(3), Kind::U16)?;
            let all = all.ok_or_else(|| missing("POSITION"))?;
            let of = |name: &str| -> Result<DVec3, ErrorKind> {
                let v = features.get(name, 3, Kind::F32)?.ok_or_else(|| missing(name))?;
                Ok(DVec3::from_slice(&v))
            };
            let offset = of("QUANTIZED_VOLUME_OFFSET")?;
            let scale = of("QUANTIZED_VOLUME_SCALE")?;
            let at = |v: &[f64]| offset + DVec3::from_slice(v) / LARGEST_U16 * scale;
            all.chunks_exact(3).map(at).collect()
        }
    };
    let up = features.directions("NORMAL_UP", count)?;
    let right = features.directions("NORMAL_RIGHT", count)?;
    let east_north = features.json.get::<bool>("EAST_NORTH_UP").ok().flatten() == Some(true);
    let scales = features.get("SCALE", count, Kind::F32)?;
    let stretches = features.vectors("SCALE_NON_UNIFORM", count)?;
    let turned = DQuat::from_mat4(&upright(place)).normalize();
    let of = |k: usize| {
        let at = centre + positions[k];
        let turn = match (&up, &right) {
            (Some(up), Some(right)) => {
                let (up, right) = (up[k].normalize_or(DVec3::Y), right[k].normalize_or(DVec3::X));
                DMat3::from_cols(right, up, right.cross(up))
            }
            _ if east_north => {
                let globe = east_north_up(place.transform_point3(at));
                DMat3::from_quat(turned.inverse()) * globe
            }
            _ => DMat3::IDENTITY,
        };
        let scale = scales.as_ref().map_or(1.0, |all| all[k]);
        let stretch = stretches.as_ref().map_or(DVec3::ONE, |all| all[k]) * scale;
        DMat4::from_translation(at) * DMat4::from_mat3(turn * DMat3::from_diagonal(stretch))
    };
    Ok((0..positions.len()).map(of).collect())
}

/// The rotation of a transform, without its scale.
fn upright(place: &DMat4) -> DMat4 {
    let [x, y, z] = [place.x_axis, place.y_axis, place.z_axis]
        .map(|axis| axis.truncate().normalize_or(DVec3::ZERO));
    DMat4::from_mat3(DMat3::from_cols(x, y, z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_unfolded_as_they_were_folded() {
        for (x, y, expected) in [
            (32_767.5, 32_767.5, DVec3::Z),
            (LARGEST_U16, 32_767.5, DVec3::X),
            (32_767.5, 0.0, -DVec3::Y),
            (0.0, 0.0, -DVec3::Z),
            (LARGEST_U16, 0.0, -DVec3::Z),
        ] {
            assert!(unfolded(x, y).normalize().distance(expected) < 1e-9, "{x} {y}");
        }
        assert!(unfolded(60_000.0, 60_000.0).z < 0.0 && unfolded(40_000.0, 40_000.0).z > 0.0);
    }
}
