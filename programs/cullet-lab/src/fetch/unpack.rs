//! One file out of what was fetched: plain, packed by gzip, or within a tar.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;

use cullet_command::exit::{Exit, Failure};
use flate2::bufread::GzDecoder;

use super::models::Known;

/// Bytes of a record of a tar.
const RECORD: usize = 512;
/// How many names of what else is in an archive are told.
const TOLD: usize = 6;

/// Writes the model that is in a file to `out`. Nothing is held in memory but a block, and no size
/// that the file claims is believed: no more than [`Known::most_unpacked`] is looked at.
///
/// # Errors
/// If the file cannot be read, ends before its time, is over the limit or does not have the model
/// in it, and if `out` cannot be written.
pub(super) fn unpack(from: &Path, known: &Known, out: &mut impl Write) -> Result<(), Failure> {
    let unreadable = |e| Failure::input(format!("{}: cannot be read: {e}", from.display()));
    let mut file = BufReader::new(File::open(from).map_err(unreadable)?);
    let head = file.fill_buf().map_err(unreadable)?;
    let is_packed = head.starts_with(&[0x1f, 0x8b]);
    if head.starts_with(b"PK\x03\x04") {
        return Err(Failure::input(format!(
            "{}: a zip, which is not read here: unpack it and give {} of it to --from",
            from.display(),
            known.file
        )));
    }
    let bytes: Box<dyn Read> =
        if is_packed { Box::new(GzDecoder::new(file)) } else { Box::new(file) };
    let most = known.most_unpacked();
    Archive { name: from.display().to_string(), bytes: bytes.take(most), most }.write(known, out)
}

/// File that is unpacked while it is read.
struct Archive {
    name: String,
    bytes: std::io::Take<Box<dyn Read>>,
    most: u64,
}

impl Archive {
    fn write(mut self, known: &Known, out: &mut impl Write) -> Result<(), Failure> {
        let mut record = [0; RECORD];
        let read = self.fill(&mut record)?;
        if read == RECORD && Header::of(&record).is_some() {
            return self.write_member(record, known, out);
        }
        out.write_all(&record[..read]).map_err(unwritable)?;
        self.copy(u64::MAX, out)?;
        if self.bytes.limit() == 0 { Err(self.over()) } else { Ok(()) }
    }

    /// Goes through a tar from its first record on.
    fn write_member(
        mut self,
        mut record: [u8; RECORD],
        known: &Known,
        out: &mut impl Write,
    ) -> Result<(), Failure> {
        let wanted = known.member.unwrap_or(known.file);
        let mut others = Vec::new();
        while let Some(header) = Header::of(&record) {
            if header.size > self.bytes.limit() {
                return Err(self.over());
            }
            if header.is_file && is_same(&header.name, wanted) {
                let copied = self.copy(header.size, out)?;
                return if copied == header.size {
                    Ok(())
                } else {
                    Err(self.cut(&format!(
                        "it has {copied} of the {} bytes of {}",
                        header.size, header.name
                    )))
                };
            }
            if header.is_file {
                others.push(header.name);
            }
            let padded = header.size.next_multiple_of(RECORD as u64);
            if self.copy(padded, &mut std::io::sink())? < padded {
                return Err(self.cut(&format!("{wanted} did not come")));
            }
            match self.fill(&mut record)? {
                RECORD => {}
                0 => break,
                _ => return Err(self.cut(&format!("{wanted} did not come"))),
            }
        }
        let more = if others.len() > TOLD { ", and more" } else { "" };
        others.truncate(TOLD);
        let name = &self.name;
        Err(Failure::input(format!(
            "{name}: there is no {wanted} in it; it has {}{more}",
            others.join(", ")
        )))
    }

    /// Reads until the record is full or the bytes end; how many came.
    fn fill(&mut self, record: &mut [u8; RECORD]) -> Result<usize, Failure> {
        let mut filled = 0;
        while filled < RECORD {
            match self.read(&mut record[filled..])? {
                0 => break,
                n => filled += n,
            }
        }
        Ok(filled)
    }

    /// Hands on up to `count` bytes; how many there were.
    fn copy(&mut self, count: u64, out: &mut impl Write) -> Result<u64, Failure> {
        let mut block = vec![0; 1 << 16];
        let mut copied = 0;
        while copied < count {
            let wanted = (count - copied).min(block.len() as u64) as usize;
            let read = self.read(&mut block[..wanted])?;
            if read == 0 {
                break;
            }
            out.write_all(&block[..read]).map_err(unwritable)?;
            copied += read as u64;
        }
        Ok(copied)
    }

    fn read(&mut self, into: &mut [u8]) -> Result<usize, Failure> {
        loop {
            match self.bytes.read(into) {
                Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
                Err(e) => return Err(self.cut(&e.to_string())),
                Ok(read) => return Ok(read),
            }
        }
    }

    fn cut(&self, why: &str) -> Failure {
        let name = &self.name;
        if self.bytes.limit() == 0 {
            return self.over();
        }
        Failure::input(format!("{name}: broken or not all of it: {why}. Fetch it once more"))
    }

    fn over(&self) -> Failure {
        let (name, most) = (&self.name, self.most);
        let message = format!("{name}: {most} bytes or more come out of it: that is not the model");
        Failure { exit: Exit::Limit, message }
    }
}

fn unwritable(error: std::io::Error) -> Failure {
    Failure::input(format!("the model cannot be written: {error}"))
}

/// Whether a path in an archive is the one that is wanted; a copy of the archive may have other
/// folders.
fn is_same(name: &str, wanted: &str) -> bool {
    let last = |path: &str| path.rsplit('/').next().unwrap_or_default().to_owned();
    last(name) == last(wanted)
}

/// Header that a record of a tar has for the file behind it.
struct Header {
    name: String,
    size: u64,
    is_file: bool,
}

impl Header {
    /// None for a record that is no header: its sum is wrong, or its size no octal number.
    fn of(record: &[u8; RECORD]) -> Option<Self> {
        let sum: u64 = record.iter().map(|&b| u64::from(b)).sum();
        let own: u64 = record[148..156].iter().map(|&b| u64::from(b)).sum();
        // Its own field counts as eight spaces.
        if octal(&record[148..156])? != sum - own + 8 * u64::from(b' ') {
            return None;
        }
        let name = String::from_utf8_lossy(until_zero(&record[..100])).into_owned();
        let is_file = matches!(record[156], b'0' | 0);
        Some(Self { name, size: octal(&record[124..136])?, is_file })
    }
}

fn until_zero(field: &[u8]) -> &[u8] {
    field.split(|&b| b == 0).next().unwrap_or_default()
}

/// A number as a tar has it: octal digits with spaces around and a zero behind.
fn octal(field: &[u8]) -> Option<u64> {
    let text = std::str::from_utf8(until_zero(field)).ok()?.trim();
    let is_octal = !text.is_empty() && text.bytes().all(|b| (b'0'..=b'7').contains(&b));
    if is_octal { u64::from_str_radix(text, 8).ok() } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(name: &str, size: &str) -> [u8; RECORD] {
        let mut record = [0; RECORD];
        record[..name.len()].copy_from_slice(name.as_bytes());
        record[124..124 + size.len()].copy_from_slice(size.as_bytes());
        record[148..156].fill(b' ');
        let sum: u64 = record.iter().map(|&b| u64::from(b)).sum();
        record[148..154].copy_from_slice(format!("{sum:06o}").as_bytes());
        record[154] = 0;
        record
    }

    #[test]
    fn a_header_is_known_by_its_sum() {
        let mut good = record("a/b.ply", "00000001750");
        let header = Header::of(&good).unwrap();
        assert_eq!((header.name.as_str(), header.size, header.is_file), ("a/b.ply", 0o1750, true));
        good[0] ^= 1;
        assert!(Header::of(&good).is_none());
        assert!(Header::of(&[0; RECORD]).is_none());
        assert!(Header::of(&[b'7'; RECORD]).is_none());
        for size in ["", "9", "-1", "0x10", "777777777777777"] {
            let told = Header::of(&record("a", size)).map(|h| h.size);
            assert!(told.is_none_or(|size| size < 1 << 37), "{size}: {told:?}");
        }
    }

    #[test]
    fn damaged_archives_are_errors_or_models_and_nothing_else() {
        let folder = cullet_testkit::Folder::new("unpack-damaged");
        let path = folder.root().join("damaged");
        let known = Known::find("bunny").unwrap();
        let model = [7; 700];
        let mut whole = record("bunny/README", "00000000005").to_vec();
        whole.resize(2 * RECORD, b'n');
        whole.extend(record("bunny/reconstruction/bun_zipper.ply", "00000001274"));
        whole.extend(model);
        whole.resize(5 * RECORD, 0);
        let mut rng = cullet_testkit::Rng(7);
        for case in 0..cullet_testkit::cases(400) {
            let mut bytes = whole.clone();
            for _ in 0..case % 4 {
                let at = rng.index(bytes.len());
                bytes[at] = rng.below(256) as u8;
            }
            if case % 3 == 0 {
                bytes.truncate(rng.index(bytes.len()));
            }
            std::fs::write(&path, &bytes).unwrap();
            let mut out = Vec::new();
            let ended = unpack(&path, known, &mut out);
            assert!(out.len() <= bytes.len());
            if case == 4 {
                assert!(ended.is_ok() && out == model);
            }
        }
    }

    #[test]
    fn folders_of_a_copy_do_not_matter() {
        assert!(is_same("x/y/bun_zipper.ply", "bunny/reconstruction/bun_zipper.ply"));
        assert!(!is_same("bunny/bun_zipper_res2.ply", "bunny/reconstruction/bun_zipper.ply"));
        assert!(!is_same("", "a.ply"));
    }
}
