//! Finished levels, occluders, impostors and merged groups in a folder, each file named by what
//! they are a function of.

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use cullet_bake::merged::Keep;
use cullet_command::exit::{Exit, Failure};
use cullet_command::files::replace;
use cullet_io::baked::{Container, Tag, write_chunks};
use cullet_io::baked::{LevelTables, Occluders, impostor_from_bytes, impostor_to_bytes};
use cullet_mesh::Impostor;

/// The folder.
#[derive(Debug)]
pub(super) struct Folder(PathBuf);

/// Endings of files of one chunk, and its name.
const OCCLUDERS: (&str, Tag) = ("occluders", *b"OCCL");
const IMPOSTOR: (&str, Tag) = ("impostor", *b"IMPO");

/// How a bake ends that was interrupted.
pub(super) fn stopped(folder: Option<&Folder>) -> Failure {
    let kept = match folder {
        Some(folder) => format!("what is finished lies in {}", folder.0.display()),
        None => "nothing is kept; --resume would keep what is finished".to_owned(),
    };
    let message = format!("interrupted; nothing was written, and {kept}");
    Failure { exit: Exit::Interrupted, message }
}

/// Merged groups in a folder.
pub(super) struct Groups<'a> {
    folder: &'a Folder,
    /// Whether those that are there count.
    resume: bool,
    resumed: AtomicU64,
    /// The first that could not be written.
    failure: Mutex<Option<Failure>>,
}

impl<'a> Groups<'a> {
    pub(super) fn new(folder: &'a Folder, resume: bool) -> Self {
        Self { folder, resume, resumed: AtomicU64::new(0), failure: Mutex::new(None) }
    }

    /// Whether one could not be written.
    pub(super) fn has_failed(&self) -> bool {
        self.failure.lock().is_ok_and(|failure| failure.is_some())
    }

    /// How many were there before.
    ///
    /// # Errors
    /// If one could not be written.
    pub(super) fn finish(self) -> Result<u64, Failure> {
        match self.failure.into_inner() {
            Ok(Some(failure)) => Err(failure),
            _ => Ok(self.resumed.into_inner()),
        }
    }
}

impl Keep for Groups<'_> {
    fn read(&self, key: u64) -> Option<Vec<u8>> {
        let path = self.folder.place(key, "group");
        let bytes = self.resume.then(|| std::fs::read(path).ok()).flatten()?;
        let file = Container::open(&bytes).ok()?;
        let is_sound = file.tags().all(|tag| file.chunk(tag).is_ok());
        self.resumed.fetch_add(u64::from(is_sound), Ordering::Relaxed);
        is_sound.then_some(bytes)
    }

    fn write(&self, key: u64, bytes: &[u8]) {
        if let Err(problem) = replace(&self.folder.place(key, "group"), bytes)
            && let Ok(mut failure) = self.failure.lock()
        {
            failure.get_or_insert(problem);
        }
    }
}

impl Folder {
    /// A folder, which is made where it is not there.
    pub(super) fn new(path: &Path) -> Result<Self, Failure> {
        std::fs::create_dir_all(path).map_err(|e| Failure::write(path, &e))?;
        Ok(Self(path.to_owned()))
    }

    /// Occluders that lie there under a key. A damaged file counts as missing.
    pub(super) fn read_occluders(&self, key: u64) -> Option<Occluders> {
        Occluders::from_bytes(&self.read_one(key, OCCLUDERS)?).ok()
    }

    /// Writes occluders like [`write`](Self::write).
    pub(super) fn write_occluders(&self, key: u64, made: &Occluders) -> Result<(), Failure> {
        self.write_one(key, OCCLUDERS, &made.to_bytes())
    }

    /// The impostor that lies there under a key. A file that is damaged counts for nothing.
    pub(super) fn read_impostor(&self, key: u64) -> Option<Impostor> {
        impostor_from_bytes(&self.read_one(key, IMPOSTOR)?).ok()
    }

    /// Writes an impostor like [`write`](Self::write).
    pub(super) fn write_impostor(&self, key: u64, made: &Impostor) -> Result<(), Failure> {
        self.write_one(key, IMPOSTOR, &impostor_to_bytes(made))
    }

    /// Reads the chunk of a file of one chunk.
    fn read_one(&self, key: u64, (ending, tag): (&str, Tag)) -> Option<Vec<u8>> {
        let bytes = std::fs::read(self.place(key, ending)).ok()?;
        Some(Container::open(&bytes).ok()?.chunk(tag).ok()?.to_vec())
    }

    fn write_one(&self, key: u64, (ending, tag): (&str, Tag), bytes: &[u8]) -> Result<(), Failure> {
        replace(&self.place(key, ending), &write_chunks(&[(tag, bytes)]))
    }

    fn place(&self, key: u64, ending: &str) -> PathBuf {
        self.0.join(format!("{key:016x}.{ending}"))
    }

    fn file(&self, key: u64) -> PathBuf {
        self.place(key, "levels")
    }

    /// Reads what lies there under a key: the levels, or that there are none. A file that is
    /// damaged counts for nothing.
    pub(super) fn read(&self, key: u64) -> Option<Option<LevelTables>> {
        let bytes = std::fs::read(self.file(key)).ok()?;
        let file = Container::open(&bytes).ok()?;
        let [parts, indices, clusters, groups] =
            [*b"PART", *b"TRIS", *b"CLUS", *b"GRPS"].map(|tag| file.chunk(tag).ok());
        let (rows, rest) = parts?.as_chunks::<4>();
        let parts = rows.iter().map(|&n| u32::from_le_bytes(n)).collect();
        let tables = LevelTables::from_bytes(parts, [indices?, clusters?, groups?]).ok()?;
        rest.is_empty().then(|| Some(tables).filter(|t| !t.groups.is_empty()))
    }

    /// Writes what was made beside its place and renames, so that whoever looks finds all of it or
    /// nothing.
    pub(super) fn write(&self, key: u64, made: Option<&LevelTables>) -> Result<(), Failure> {
        let none = LevelTables::default();
        let made = made.unwrap_or(&none);
        let parts: Vec<u8> = made.parts.iter().flat_map(|n| n.to_le_bytes()).collect();
        let [indices, clusters, groups] = made.to_bytes();
        let chunks: [(_, &[u8]); 4] =
            [(*b"PART", &parts), (*b"TRIS", &indices), (*b"CLUS", &clusters), (*b"GRPS", &groups)];
        replace(&self.file(key), &write_chunks(&chunks))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet::lod::Group;
    use cullet_io::baked::ClusterRow;

    #[test]
    fn what_was_made_comes_back_and_damage_counts_for_nothing() {
        let path = std::env::temp_dir().join(format!("cullet-chunks-{}", std::process::id()));
        let folder = Folder::new(&path).expect("a folder of ours");
        assert_eq!(folder.read(7), None);
        let row = ClusterRow { first_triangle: 0, triangle_count: 2, made_from: 9, replaced_by: 4 };
        let made = LevelTables {
            parts: vec![2],
            indices: vec![0, 1, 2, 2, 1, 3],
            clusters: vec![row],
            groups: vec![Group { centre: [1.0, 2.0, 3.0], radius: 4.0, error: 5.0 }],
        };
        folder.write(7, Some(&made)).expect("written");
        folder.write(8, None).expect("written");
        assert_eq!((folder.read(7), folder.read(8)), (Some(Some(made)), Some(None)));
        let file = folder.file(7);
        let good = std::fs::read(&file).expect("ours");
        for at in (0..good.len()).step_by(7) {
            std::fs::write(&file, &good[..at]).expect("ours");
            assert_eq!(folder.read(7), None, "cut at {at}");
            let mut odd = good.clone();
            odd[at] ^= 4;
            std::fs::write(&file, odd).expect("ours");
            assert_eq!(folder.read(7), None, "odd at {at}");
        }
        std::fs::remove_dir_all(&path).expect("ours to remove");
    }
}
