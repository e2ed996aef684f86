//! The directory of a map, and records out of its lumps.

use cullet_io::ErrorKind;

/// A kind of map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Version {
    /// Quake, version 29.
    Quake,
    /// Quake with 32-bit numbers: `BSP2`.
    Bsp2,
    /// Half-Life, version 30: Quake's lumps, with other contents and names.
    HalfLife,
    /// Quake 2: `IBSP` 38.
    Quake2,
    /// Quake 3: `IBSP` 46.
    Quake3,
}

impl Version {
    /// Its name for people.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Quake => "Quake 29",
            Self::Bsp2 => "Quake BSP2",
            Self::HalfLife => "Half-Life 30",
            Self::Quake2 => "Quake 2 38",
            Self::Quake3 => "Quake 3 46",
        }
    }

    /// Version of the map that begins with `head`; `None` if it begins like none that is read.
    pub(crate) fn of(head: &[u8]) -> Option<Self> {
        match head {
            [29, 0, 0, 0, ..] => Some(Self::Quake),
            [b'B', b'S', b'P', b'2', ..] => Some(Self::Bsp2),
            [30, 0, 0, 0, ..] => Some(Self::HalfLife),
            [b'I', b'B', b'S', b'P', 38, 0, 0, 0, ..] => Some(Self::Quake2),
            [b'I', b'B', b'S', b'P', 46, 0, 0, 0, ..] => Some(Self::Quake3),
            _ => None,
        }
    }

    /// Names of its lumps, in the order of the directory.
    pub(crate) fn lumps(self) -> &'static [&'static str] {
        match self {
            Self::Quake | Self::Bsp2 | Self::HalfLife => &[
                "entities",
                "planes",
                "textures",
                "vertices",
                "visibility",
                "nodes",
                "texinfo",
                "faces",
                "lighting",
                "clipnodes",
                "leafs",
                "marksurfaces",
                "edges",
                "surfedges",
                "models",
            ],
            Self::Quake2 => &[
                "entities",
                "planes",
                "vertices",
                "visibility",
                "nodes",
                "texinfo",
                "faces",
                "lighting",
                "leafs",
                "leaffaces",
                "leafbrushes",
                "edges",
                "surfedges",
                "models",
                "brushes",
                "brushsides",
                "pop",
                "areas",
                "areaportals",
            ],
            Self::Quake3 => &[
                "entities",
                "textures",
                "planes",
                "nodes",
                "leafs",
                "leaffaces",
                "leafbrushes",
                "models",
                "brushes",
                "brushsides",
                "vertices",
                "meshverts",
                "effects",
                "faces",
                "lightmaps",
                "lightvols",
                "visibility",
            ],
        }
    }

    /// Where the directory begins.
    pub(crate) fn directory(self) -> usize {
        match self {
            Self::Quake | Self::Bsp2 | Self::HalfLife => 4,
            Self::Quake2 | Self::Quake3 => 8,
        }
    }

    /// Whether leafs name their clusters, and rows of visibility are of clusters. In Quake and
    /// Half-Life rows are of leafs.
    pub(crate) fn has_clusters(self) -> bool {
        matches!(self, Self::Quake2 | Self::Quake3)
    }
}

/// A map's bytes with its directory, checked: every lump lies within the file and after the
/// directory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lumps<'a> {
    pub(crate) version: Version,
    pub(crate) bytes: &'a [u8],
}

impl<'a> Lumps<'a> {
    /// Checks a directory.
    pub(crate) fn new(bytes: &'a [u8]) -> Result<Self, ErrorKind> {
        let Some(version) = Version::of(bytes) else {
            return Err(ErrorKind::Unsupported(foreign(bytes)));
        };
        let lumps = Self { version, bytes };
        let end = lumps.directory_end();
        if bytes.len() < end {
            let message = format!("the file ends at byte {}, its directory at {end}", bytes.len());
            return Err(ErrorKind::invalid("header", message));
        }
        for (index, name) in version.lumps().iter().enumerate() {
            let [offset, length] = lumps.place(index);
            let fits = usize::try_from(offset).is_ok_and(|o| {
                usize::try_from(length).is_ok_and(|l| {
                    l == 0 || o >= end && o.checked_add(l).is_some_and(|e| e <= bytes.len())
                })
            });
            if !fits {
                let size = bytes.len();
                let message = format!(
                    "{length} bytes from byte {offset} on, which must lie between byte {end} and the \
                     file's end at {size}"
                );
                return Err(ErrorKind::invalid(format!("lump {name}"), message));
            }
        }
        Ok(lumps)
    }

    /// End of the directory.
    pub(crate) fn directory_end(&self) -> usize {
        self.version.directory() + 8 * self.version.lumps().len()
    }

    /// Offset and length of a lump, as they are in the file.
    pub(crate) fn place(&self, index: usize) -> [i32; 2] {
        let at = self.version.directory() + 8 * index;
        [int(self.bytes, at), int(self.bytes, at + 4)]
    }

    /// Whether the first two lumps are in each other's place, as in maps of Blue Shift: entities are
    /// text that begins with a brace.
    fn is_swapped(&self) -> bool {
        let begins = |index: usize| {
            let offset = usize::try_from(self.place(index)[0]).unwrap_or(usize::MAX);
            self.bytes.get(offset..).and_then(|b| b.trim_ascii_start().first())
        };
        self.version == Version::HalfLife && begins(0) != Some(&b'{') && begins(1) == Some(&b'{')
    }

    /// The lump of a name that the version has.
    pub(crate) fn lump(&self, name: &'static str) -> Lump<'a> {
        let index = self.version.lumps().iter().position(|n| *n == name);
        let index = index.map(|i| if i < 2 && self.is_swapped() { 1 - i } else { i });
        let [offset, length] = index.map_or([0, 0], |i| self.place(i));
        // The directory is checked, so that both are within the file; an empty lump may lie
        // anywhere.
        let range = offset.max(0) as usize..offset.max(0) as usize + length.max(0) as usize;
        Lump { name, bytes: self.bytes.get(range).unwrap_or(&[]) }
    }
}

/// A lump.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lump<'a> {
    pub(crate) name: &'static str,
    pub(crate) bytes: &'a [u8],
}

impl<'a> Lump<'a> {
    /// Its records of `size` bytes.
    pub(crate) fn records(&self, size: usize) -> Result<Records<'a>, ErrorKind> {
        if !self.bytes.len().is_multiple_of(size) {
            let message = format!("{} bytes are no whole records of {size}", self.bytes.len());
            return Err(ErrorKind::invalid(format!("lump {}", self.name), message));
        }
        Ok(Records { name: self.name, bytes: self.bytes, size })
    }

    /// An error of one of its records.
    pub(crate) fn invalid(&self, index: usize, message: impl Into<String>) -> ErrorKind {
        invalid(self.name, index, message)
    }
}

/// An error of a lump's record.
pub(crate) fn invalid(lump: &str, index: usize, message: impl Into<String>) -> ErrorKind {
    ErrorKind::invalid(format!("lump {lump}, number {index}"), message)
}

/// Records of equal size.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Records<'a> {
    pub(crate) name: &'static str,
    bytes: &'a [u8],
    size: usize,
}

impl<'a> Records<'a> {
    pub(crate) fn len(&self) -> usize {
        self.bytes.len() / self.size
    }

    pub(crate) fn iter(&self) -> impl ExactSizeIterator<Item = &'a [u8]> + use<'a> {
        self.bytes.chunks_exact(self.size)
    }

    /// A record that is there.
    pub(crate) fn get(&self, index: usize) -> Option<&'a [u8]> {
        self.bytes.get(index.checked_mul(self.size)?..)?.get(..self.size)
    }

    /// An error of one of its records.
    pub(crate) fn invalid(&self, index: usize, message: impl Into<String>) -> ErrorKind {
        invalid(self.name, index, message)
    }
}

/// Most times that one item of a lump may be named by the lists of another: compilers name each
/// once or a few times, and a file of a few bytes could claim a great deal otherwise.
const MOST_SHARED: u64 = 16;

/// Sum of the lengths of lists that name items of a lump, refused where it exceeds what compilers
/// write.
pub(crate) struct Shared {
    lump: &'static str,
    sum: u64,
    limit: u64,
}

impl Shared {
    pub(crate) fn new(lump: &'static str, items: usize) -> Self {
        Self { lump, sum: 0, limit: MOST_SHARED * items as u64 }
    }

    /// A list of `count` items from `first` on, of `items` that there are.
    pub(crate) fn range(
        &mut self,
        first: i64,
        count: i64,
        items: usize,
    ) -> Result<std::ops::Range<usize>, String> {
        let there = items as i64;
        if first < 0 || count < 0 || first > there || count > there - first {
            return Err(format!(
                "{count} items of lump {} from {first} on, of {items} that there are",
                self.lump
            ));
        }
        self.sum += count as u64;
        if self.sum > self.limit {
            return Err(format!(
                "with it, lists name {} items of lump {}, over the limit of {} ({MOST_SHARED} times all)",
                self.sum, self.lump, self.limit
            ));
        }
        Ok(first as usize..(first + count) as usize)
    }
}

/// Reason why a map of another kind is not read.
fn foreign(bytes: &[u8]) -> String {
    let version = bytes.get(4..8).map_or(0, |_| int(bytes, 4));
    let known = "known are Quake 29 and BSP2, Half-Life 30, Quake 2 IBSP 38 and Quake 3 IBSP 46";
    match bytes {
        [b'I', b'B', b'S', b'P', _, _, _, _, ..] => {
            format!("a map of kind IBSP {version} is not read; {known}")
        }
        [b'V' | b'R' | b'F', b'B', b'S', b'P', ..] => {
            let name = String::from_utf8_lossy(&bytes[..4]).into_owned();
            format!("a map of kind {name} {version} is not read; {known}")
        }
        [b'2', b'P', b'S', b'B', ..] => {
            format!("a map of kind 2PSB is not read; compile it as BSP2; {known}")
        }
        _ => format!("it does not begin as a map does; {known}"),
    }
}

/// Four bytes at a place that is there.
fn four(bytes: &[u8], at: usize) -> [u8; 4] {
    bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).unwrap_or_default()
}

pub(crate) fn int(bytes: &[u8], at: usize) -> i32 {
    i32::from_le_bytes(four(bytes, at))
}

pub(crate) fn unsigned(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(four(bytes, at))
}

pub(crate) fn short(bytes: &[u8], at: usize) -> i16 {
    i16::from_le_bytes(bytes.get(at..at + 2).and_then(|b| b.try_into().ok()).unwrap_or_default())
}

pub(crate) fn unsigned_short(bytes: &[u8], at: usize) -> u16 {
    short(bytes, at).cast_unsigned()
}

pub(crate) fn float(bytes: &[u8], at: usize) -> f32 {
    f32::from_le_bytes(four(bytes, at))
}

pub(crate) fn floats(bytes: &[u8], at: usize) -> [f32; 3] {
    [0, 4, 8].map(|o| float(bytes, at + o))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_of_other_kinds_are_named() {
        for (bytes, part) in [
            (&b"IBSP\x2f\0\0\0"[..], "IBSP 47"),
            (b"VBSP\x14\0\0\0", "VBSP 20"),
            (b"RBSP\x01\0\0\0", "RBSP 1"),
            (b"2PSB\x01\0\0\0", "as BSP2"),
            (b"\x1d\0", "does not begin"),
            (b"", "does not begin"),
        ] {
            let error = Lumps::new(bytes).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        }
    }

    #[test]
    fn lumps_lie_within_the_file() {
        let mut bytes = vec![0u8; 4 + 15 * 8 + 8];
        bytes[0] = 29;
        assert!(Lumps::new(&bytes).is_ok());
        for (offset, length) in [(0, 1), (120, 8), (124, 9), (-1, 4), (124, -4), (i32::MAX, 4)] {
            bytes[12..16].copy_from_slice(&i32::to_le_bytes(offset));
            bytes[16..20].copy_from_slice(&i32::to_le_bytes(length));
            let error = Lumps::new(&bytes).unwrap_err().to_string();
            let part = format!("lump planes: {length} bytes from byte {offset} on");
            assert!(error.starts_with(&part) && error.contains("132"), "{error}");
        }
        let short = Lumps::new(&bytes[..100]).unwrap_err().to_string();
        assert!(short.contains("ends at byte 100, its directory at 124"), "{short}");
    }
}
