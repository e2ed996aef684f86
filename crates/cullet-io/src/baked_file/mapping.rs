//! A file as memory.

use std::fmt;
use std::path::Path;

/// A file that is mapped into memory: its bytes are those of the disk, fetched when they are looked
/// at.
///
/// As long as it is there nobody must make the file shorter or write to it: the system ends a
/// program that looks at what is no longer there. `cullet bake` never does that to a file, for it
/// puts a new one in the place of the old, which stays as long as it is mapped.
pub struct Mapping(imp::Bytes);

impl Mapping {
    /// Maps a file. Where the system cannot, as in a page of the web, it is read.
    ///
    /// # Errors
    /// If it is not there, is no file, or cannot be mapped.
    pub fn open(path: &Path) -> std::io::Result<Self> {
        let meta = std::fs::metadata(path)?;
        if !meta.is_file() {
            return Err(std::io::Error::new(std::io::ErrorKind::InvalidInput, "it is no file"));
        }
        // No system maps nothing.
        match meta.len() {
            0 => Ok(Self(imp::Bytes::default())),
            _ => imp::map(path).map(Self),
        }
    }
}

impl AsRef<[u8]> for Mapping {
    fn as_ref(&self) -> &[u8] {
        self.0.as_slice()
    }
}

impl fmt::Debug for Mapping {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Mapping").field("bytes", &self.as_ref().len()).finish()
    }
}

#[cfg(any(unix, windows))]
mod imp {
    use std::path::Path;

    #[derive(Default)]
    pub(super) struct Bytes(Option<vmap::Map>);

    impl Bytes {
        pub(super) fn as_slice(&self) -> &[u8] {
            self.0.as_deref().unwrap_or_default()
        }
    }

    pub(super) fn map(path: &Path) -> std::io::Result<Bytes> {
        // The whole of it, however long it is by now.
        let (map, _) = vmap::Map::with_options().open(path).map_err(std::io::Error::from)?;
        Ok(Bytes(Some(map)))
    }
}

#[cfg(not(any(unix, windows)))]
mod imp {
    use std::path::Path;

    #[derive(Default)]
    pub(super) struct Bytes(Vec<u8>);

    impl Bytes {
        pub(super) fn as_slice(&self) -> &[u8] {
            &self.0
        }
    }

    pub(super) fn map(path: &Path) -> std::io::Result<Bytes> {
        std::fs::read(path).map(Bytes)
    }
}
