//! Implicit tiling (3D Tiles 1.1, section 7.4): a tree whose tiles are bits of subtree files, and
//! whose boxes are halves of the boxes above.

use std::path::{Path, PathBuf};

use super::json::{ImplicitJson, Scheme, Volume, of_bytes};
use cullet_io::reader::{FromJson, Integer, Json};
use cullet_io::{ErrorKind, from_json};

/// The most levels: beyond, numbers of tiles do not fit.
const DEEPEST: u32 = 21;

/// A tile by its level and its place among those of the level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) level: u32,
    pub(super) at: [u32; 3],
}

impl Place {
    pub(super) const ROOT: Self = Self { level: 0, at: [0; 3] };

    /// A template with its numbers.
    pub(super) fn fill(&self, template: &str) -> String {
        let [x, y, z] = self.at.map(|v| v.to_string());
        let text = template.replace("{level}", &self.level.to_string());
        text.replace("{x}", &x).replace("{y}", &y).replace("{z}", &z)
    }

    /// Its part of the root's volume.
    pub(super) fn volume(&self, root: &Volume, axes: usize) -> Volume {
        let parts = f64::from(1_u32 << self.level);
        // The middle and the half size of an axis, with −1 to 1 for all of it.
        let part = |a: usize| match a < axes {
            true => ((2.0 * f64::from(self.at[a]) + 1.0) / parts - 1.0, 1.0 / parts),
            false => (0.0, 1.0),
        };
        let mut volume =
            Volume { region: root.region.clone(), block: root.block.clone(), sphere: None };
        if let Some(block) = volume.block.as_mut().filter(|block| block.len() == 12) {
            for a in 0..3 {
                let (middle, half) = part(a);
                for k in 0..3 {
                    let axis = block[3 + 3 * a + k];
                    block[k] += axis * middle;
                    block[3 + 3 * a + k] = axis * half;
                }
            }
        }
        if let Some(
            &mut [
                ref mut west,
                ref mut south,
                ref mut east,
                ref mut north,
                ref mut low,
                ref mut high,
            ],
        ) = volume.region.as_deref_mut()
        {
            let whole = if *east < *west { *east + std::f64::consts::TAU } else { *east };
            let cut = |low: f64, high: f64, a: usize| {
                let (middle, half) = part(a);
                let at = |v: f64| low + (high - low) * (v + 1.0) * 0.5;
                (at(middle - half), at(middle + half))
            };
            (*west, *east) = cut(*west, whole, 0);
            (*south, *north) = cut(*south, *north, 1);
            (*low, *high) = cut(*low, *high, 2);
        }
        volume
    }
}

impl ImplicitJson {
    /// Checks what it states.
    pub(super) fn check(&self) -> Result<(), ErrorKind> {
        let limit = |item: &str, count: u32| {
            let (item, count, limit) = (item.to_owned(), count.into(), DEEPEST.into());
            Err(ErrorKind::OverLimit { item, count, limit })
        };
        if self.available_levels.is_none() && self.maximum_level.is_none() {
            return Err(ErrorKind::invalid("implicitTiling", "missing field `availableLevels`"));
        }
        match (self.subtree_levels, self.levels()) {
            (0, _) | (_, 0) => {
                let message = "subtreeLevels and availableLevels must be 1 or more";
                Err(ErrorKind::invalid("implicitTiling", message))
            }
            (levels, _) if levels > DEEPEST => limit("subtreeLevels", levels),
            (_, levels) if levels > DEEPEST => limit("availableLevels", levels),
            _ => Ok(()),
        }
    }

    /// How many axes are halved.
    pub(super) fn axes(&self) -> usize {
        if self.subdivision_scheme == Scheme::Quadtree { 2 } else { 3 }
    }

    /// Levels that there are.
    pub(super) fn levels(&self) -> u32 {
        let highest = self.maximum_level.map(|level| level.saturating_add(1));
        self.available_levels.or(highest).unwrap_or(0)
    }

    /// The file of the subtree whose root a tile is.
    pub(super) fn subtree_of(&self, root: Place) -> PathBuf {
        PathBuf::from(root.fill(&self.subtrees.uri))
    }

    pub(super) fn subtree_levels(&self) -> u32 {
        self.subtree_levels
    }
}

/// Bits, or one for all.
#[derive(Clone, Debug)]
enum Bits {
    All(bool),
    Of(Vec<u8>),
}

impl Bits {
    fn get(&self, bit: u64) -> bool {
        match self {
            Self::All(all) => *all,
            Self::Of(bytes) => {
                let byte = usize::try_from(bit / 8).ok().and_then(|k| bytes.get(k));
                byte.is_some_and(|byte| byte >> (bit % 8) & 1 != 0)
            }
        }
    }
}

/// Availability bits of a subtree.
#[derive(Clone, Debug)]
pub(super) struct Subtree {
    tiles: Bits,
    contents: Vec<Bits>,
    children: Bits,
    axes: usize,
    levels: u32,
}

from_json! {
    struct SubtreeJson {
        buffers: Vec<Buffer> = or_default("buffers"),
        buffer_views: Vec<View> = or_default("bufferViews"),
        tiles: Availability = need("tileAvailability"),
        contents: OneOrMore = or_default("contentAvailability"),
        multiple: Option<MultipleAvailability> = extension("3DTILES_multiple_contents"),
        children: Availability = need("childSubtreeAvailability"),
    }

    /// Several contents of 1.0.
    struct MultipleAvailability {
        contents: OneOrMore = or_default("contentAvailability"),
    }

    struct Buffer {
        uri: Option<String> = get("uri"),
        byte_length: Integer = need("byteLength"),
    }

    struct View {
        buffer: Integer = need("buffer"),
        byte_offset: Integer = or_default("byteOffset"),
        byte_length: Integer = need("byteLength"),
    }

    struct Availability {
        bitstream: Option<Integer> = get("bitstream"),
        /// The name of `bitstream` before 1.1 was final.
        buffer_view: Option<Integer> = get("bufferView"),
        constant: Option<Integer> = get("constant"),
    }
}

/// A list of 1.1, or the one item of 1.0.
#[derive(Debug, Default)]
struct OneOrMore(Vec<Availability>);

impl FromJson<'_> for OneOrMore {
    fn from_json(json: Json<'_>) -> Result<Self, String> {
        if json.text().starts_with('[') {
            return Vec::from_json(json).map(Self);
        }
        Availability::from_json(json).map(|one| Self(vec![one]))
    }
}

impl Subtree {
    /// Reads a subtree, binary or JSON. `beside` gives the bytes of a buffer that it names.
    pub(super) fn read(
        bytes: &[u8],
        implicit: &ImplicitJson,
        mut beside: impl FnMut(&Path) -> Result<Vec<u8>, ErrorKind>,
    ) -> Result<Self, ErrorKind> {
        let (json, inner) = chunks(bytes)?;
        let json: SubtreeJson = of_bytes(json, "subtree")?;
        let mut buffers = Vec::with_capacity(json.buffers.len());
        for buffer in &json.buffers {
            let bytes = match &buffer.uri {
                Some(uri) => beside(Path::new(uri))?,
                None => inner.to_vec(),
            };
            let stated = buffer.byte_length.0;
            if (bytes.len() as u64) < stated {
                let message = format!("it has {} bytes; {stated} are stated", bytes.len());
                return Err(ErrorKind::invalid("subtree buffer", message));
            }
            buffers.push(bytes);
        }
        let (axes, levels) = (implicit.axes(), implicit.subtree_levels);
        let bits = |of: &Availability, count: u64| -> Result<Bits, ErrorKind> {
            let Some(Integer(number)) = of.bitstream.or(of.buffer_view) else {
                return Ok(Bits::All(of.constant == Some(Integer(1))));
            };
            let view = usize::try_from(number).ok().and_then(|n| json.buffer_views.get(n));
            let found = view.and_then(|view| {
                let begin = view.byte_offset.index();
                let end = begin.checked_add(view.byte_length.index())?;
                buffers.get(view.buffer.index())?.get(begin..end)
            });
            match found {
                Some(found) if found.len() as u64 >= count.div_ceil(8) => {
                    Ok(Bits::Of(found.to_vec()))
                }
                _ => {
                    let message =
                        format!("bufferView {number} does not hold {count} bits within its buffer");
                    Err(ErrorKind::invalid("subtree availability", message))
                }
            }
        };
        let tiles = before(levels, axes);
        Ok(Self {
            tiles: bits(&json.tiles, tiles)?,
            contents: json
                .multiple
                .as_ref()
                .map_or(&json.contents, |of| &of.contents)
                .0
                .iter()
                .map(|of| bits(of, tiles))
                .collect::<Result<_, _>>()?,
            children: bits(&json.children, 1 << (axes as u32 * levels).min(63))?,
            axes,
            levels,
        })
    }

    /// Whether a tile is there, by its place within the subtree.
    pub(super) fn has_tile(&self, local: Place) -> bool {
        local.level < self.levels && self.tiles.get(self.bit(local))
    }

    /// Whether its content of a number is there.
    pub(super) fn has_content(&self, local: Place, content: usize) -> bool {
        self.contents.get(content).is_some_and(|bits| bits.get(self.bit(local)))
    }

    /// Whether a subtree begins at a place one level below this one's last.
    pub(super) fn has_subtree(&self, local: Place) -> bool {
        self.children.get(morton(local.at, self.axes))
    }

    fn bit(&self, local: Place) -> u64 {
        before(local.level, self.axes) + morton(local.at, self.axes)
    }
}

/// Tiles of all levels above one.
fn before(level: u32, axes: usize) -> u64 {
    let branches = 1_u64 << axes;
    (0..level).fold(0_u64, |sum, _| sum.saturating_mul(branches).saturating_add(1))
}

/// The number of a tile within its level: the bits of its coordinates in turn, those of x lowest.
fn morton(at: [u32; 3], axes: usize) -> u64 {
    let bit = |a: usize, k: u32| u64::from(at[a] >> k & 1) << (k * axes as u32 + a as u32);
    (0..DEEPEST).flat_map(|k| (0..axes).map(move |a| (a, k))).map(|(a, k)| bit(a, k)).sum()
}

/// The JSON of a subtree, and what follows it.
fn chunks(bytes: &[u8]) -> Result<(&[u8], &[u8]), ErrorKind> {
    let Some(rest) = bytes.strip_prefix(b"subt") else { return Ok((bytes, &[])) };
    let invalid = || {
        let message = format!("its header does not fit its {} bytes", bytes.len());
        ErrorKind::invalid("subtree", message)
    };
    let number = |at: usize| {
        let eight = rest.get(at..at + 8)?.first_chunk::<8>()?;
        usize::try_from(u64::from_le_bytes(*eight)).ok()
    };
    let (json, inner) = number(4).zip(number(12)).ok_or_else(invalid)?;
    let rest = &rest[20..];
    let (json, rest) = rest.split_at_checked(json).ok_or_else(invalid)?;
    Ok((json, rest.get(..inner).ok_or_else(invalid)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_in_the_order_of_the_specification() {
        // 3D Tiles 1.1, 7.4.2: Morton order, and levels one after another.
        assert_eq!(morton([0b10, 0b11, 0], 2), 0b1110);
        assert_eq!(morton([0b01, 0b10, 0b11], 3), 0b110_101);
        assert_eq!([0, 1, 2, 3].map(|level| before(level, 2)), [0, 1, 5, 21]);
        assert_eq!([1, 2, 3].map(|level| before(level, 3)), [1, 9, 73]);
    }

    #[test]
    fn halves_of_boxes_and_regions_fill_them() {
        let root = Volume {
            block: Some(vec![1.0, 2.0, 3.0, 4.0, 0.0, 0.0, 0.0, 4.0, 0.0, 0.0, 0.0, 4.0]),
            region: Some(vec![0.0, 0.0, 0.4, 0.4, -10.0, 10.0]),
            sphere: None,
        };
        let at = |x, y, z| Place { level: 1, at: [x, y, z] };
        let four = at(1, 0, 0).volume(&root, 2);
        assert_eq!(
            four.block.unwrap(),
            [3.0, 0.0, 3.0, 2.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 4.0]
        );
        assert_eq!(four.region.unwrap(), [0.2, 0.0, 0.4, 0.2, -10.0, 10.0]);
        let eight = at(0, 1, 1).volume(&root, 3);
        assert_eq!(eight.block.unwrap()[..3], [-1.0, 4.0, 5.0]);
        assert_eq!(eight.region.unwrap()[4..], [0.0, 10.0]);
    }

    #[test]
    fn what_is_cut_short_is_an_error() {
        let implicit: ImplicitJson = of_bytes(
            br#"{"subdivisionScheme":"QUADTREE","subtreeLevels":3,"availableLevels":3,"subtrees":{"uri":"s"}}"#,
            "implicit",
        )
        .unwrap();
        let none = |_: &Path| Err(ErrorKind::invalid("buffer", "none"));
        let json = r#"{"buffers":[{"byteLength":3}],"bufferViews":[{"buffer":0,"byteLength":3}],
            "tileAvailability":{"bitstream":0},"childSubtreeAvailability":{"constant":0}}"#;
        let mut bytes = b"subt\x01\0\0\0".to_vec();
        bytes.extend((json.len() as u64).to_le_bytes());
        bytes.extend(3_u64.to_le_bytes());
        bytes.extend(json.as_bytes());
        bytes.extend([0b0010_0001, 0, 0b1_0000]);
        let subtree = Subtree::read(&bytes, &implicit, none).unwrap();
        assert!(subtree.has_tile(Place::ROOT) && !subtree.has_tile(Place { level: 1, at: [0; 3] }));
        assert!(subtree.has_tile(Place { level: 2, at: [0; 3] }));
        assert!(subtree.has_tile(Place { level: 2, at: [3, 3, 0] }));
        assert!(
            !subtree.has_content(Place::ROOT, 0)
                && !subtree.has_subtree(Place { level: 3, at: [0; 3] })
        );
        for end in 0..bytes.len() {
            assert!(Subtree::read(&bytes[..end], &implicit, none).is_err(), "{end}");
        }
        // Three levels of four are 21 bits.
        let short = String::from_utf8_lossy(&bytes)
            .replace("\"byteLength\":3}],\n", "\"byteLength\":2}],\n");
        assert!(Subtree::read(short.as_bytes(), &implicit, none).is_err());
    }
}
