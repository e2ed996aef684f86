//! Files that a model names: in its folder, or given along with it.

use std::borrow::Cow;
use std::fs::File;
use std::io::Read as _;
use std::path::Path;

/// Where the files are that a model names.
#[derive(Clone, Copy, Debug)]
pub enum Beside<'a> {
    /// In this folder, or below it.
    Folder(&'a Path),
    /// In the first folder, or below it, named from the second, which is within it.
    Below(&'a Path, &'a Path),
    /// Among these, by name and content.
    Given(&'a [(String, Vec<u8>)]),
}

/// Why a file cannot be had.
#[derive(Debug)]
pub enum Missing {
    /// It is not there.
    Absent,
    /// It is no regular file: a pipe or a device might never end.
    NoFile,
    /// It is there, but cannot be read.
    Unread(std::io::Error),
}

impl<'a> Beside<'a> {
    /// The folder, within that in which files may lie, from which they are named.
    #[must_use]
    pub fn inner(self) -> &'a Path {
        match self {
            Self::Below(_, inner) => inner,
            Self::Folder(_) | Self::Given(_) => Path::new(""),
        }
    }

    /// The first `most` bytes of the file that a model calls `path`, and how many it has. Those
    /// that were given are found by their path, or else by their name alone, in small letters or
    /// capitals, for their source may know no folder.
    pub fn read(self, path: &Path, most: u64) -> Result<(Cow<'a, [u8]>, u64), Missing> {
        match self {
            Self::Folder(folder) | Self::Below(folder, _) => {
                let path = folder.join(path);
                let meta = std::fs::metadata(&path).map_err(|e| match e.kind() {
                    std::io::ErrorKind::NotFound => Missing::Absent,
                    _ => Missing::Unread(e),
                })?;
                if !meta.is_file() {
                    return Err(Missing::NoFile);
                }
                let mut bytes = Vec::with_capacity(meta.len().min(most) as usize);
                File::open(&path)
                    .and_then(|f| f.take(most).read_to_end(&mut bytes))
                    .map_err(Missing::Unread)?;
                Ok((Cow::Owned(bytes), meta.len()))
            }
            Self::Given(files) => {
                let name = path.file_name().and_then(|n| n.to_str()).unwrap_or_default();
                // Where they are told with their folders, files of one name are told apart.
                let whole = files.iter().find(|(n, _)| Path::new(n) == path);
                let own = |n: &str| n.rsplit(['/', '\\']).next().unwrap_or_default().to_owned();
                let found = whole
                    .or_else(|| files.iter().find(|(n, _)| own(n) == name))
                    .or_else(|| files.iter().find(|(n, _)| own(n).eq_ignore_ascii_case(name)));
                let (_, bytes) = found.ok_or(Missing::Absent)?;
                let end = bytes.len().min(usize::try_from(most).unwrap_or(usize::MAX));
                Ok((Cow::Borrowed(&bytes[..end]), bytes.len() as u64))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_one_name_in_two_folders_are_told_apart() {
        let file = |name: &str, content: &[u8]| (name.to_owned(), content.to_vec());
        let files = [file("a/x.bin", b"one"), file("b/x.bin", b"two"), file("Y.bin", b"three")];
        let read = |path: &str| {
            let found = Beside::Given(&files).read(Path::new(path), 99).ok();
            found.map(|(bytes, size)| (bytes.into_owned(), size))
        };
        assert_eq!(read("b/x.bin"), Some((b"two".to_vec(), 3)));
        assert_eq!(read("a/x.bin"), Some((b"one".to_vec(), 3)));
        // Who gives them may know no folder, or another.
        assert_eq!(read("c/x.bin"), Some((b"one".to_vec(), 3)));
        assert_eq!(read("parts/y.BIN"), Some((b"three".to_vec(), 5)));
        assert_eq!(read("z.bin"), None);
    }
}
