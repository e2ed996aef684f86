//! Reading a map of any family.

use std::path::Path;

use super::lumps::{Lumps, Version};
use super::map::Bsp;
use super::surfaces::Surfaces;
use super::{quake, quake2, quake3};
use cullet_io::reader::Source;
use cullet_io::{ErrorKind, LoadError};

/// All but the geometry.
pub(crate) fn parse(lumps: &Lumps<'_>) -> Result<Bsp, ErrorKind> {
    match lumps.version {
        Version::Quake | Version::Bsp2 | Version::HalfLife => quake::parse(lumps),
        Version::Quake2 => quake2::parse(lumps),
        Version::Quake3 => quake3::parse(lumps),
    }
}

/// The geometry.
pub(crate) fn surfaces(lumps: &Lumps<'_>, map: &Bsp) -> Result<Surfaces, ErrorKind> {
    match lumps.version {
        Version::Quake | Version::Bsp2 | Version::HalfLife => quake::surfaces(lumps, map),
        Version::Quake2 => quake2::surfaces(lumps, map),
        Version::Quake3 => quake3::surfaces(lumps, map),
    }
}

impl Bsp {
    /// Reads a map. Allocates no more than a few times the size of the file.
    ///
    /// # Errors
    /// If it is no map of a known version, or something in it is wrong: the lump, the number of the
    /// record, the value and the limit are named.
    pub fn parse(bytes: &[u8]) -> Result<Self, ErrorKind> {
        parse(&Lumps::new(bytes)?)
    }

    /// Reads the map of a file.
    ///
    /// # Errors
    /// As [`parse`](Self::parse), and if the file cannot be read.
    pub fn open(path: &Path) -> Result<Self, LoadError> {
        let read = || Self::parse(&Source::open(path)?.into_bytes()?);
        read().map_err(|kind| kind.at(path))
    }
}
