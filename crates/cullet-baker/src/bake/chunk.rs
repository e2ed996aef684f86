//! Finished levels and occluders in a folder, each file named by what they are a function of.

use std::path::{Path, PathBuf};

use cullet_bake::container::{Container, write_chunks};
use cullet_command::exit::Failure;
use cullet_command::files::replace;
use cullet_io::baked::{LevelTables, OccluderTables};

/// The folder.
#[derive(Debug)]
pub(super) struct Folder(PathBuf);

impl Folder {
    /// A folder, which is made where it is not there.
    pub(super) fn new(path: &Path) -> Result<Self, Failure> {
        std::fs::create_dir_all(path).map_err(|e| Failure::write(path, &e))?;
        Ok(Self(path.to_owned()))
    }

    pub(super) fn path(&self) -> &Path {
        &self.0
    }

    /// Occluders that lie there under a key. A file that is damaged counts for nothing.
    pub(super) fn read_occluders(&self, key: u64) -> Option<OccluderTables> {
        let bytes = std::fs::read(self.occluders(key)).ok()?;
        let file = Container::open(&bytes).ok()?;
        OccluderTables::from_bytes(file.chunk(*b"OCCL").ok()?).ok()
    }

    /// As [`write`](Self::write).
    pub(super) fn write_occluders(&self, key: u64, made: &OccluderTables) -> Result<(), Failure> {
        replace(&self.occluders(key), &write_chunks(&[(*b"OCCL", &made.to_bytes())]))
    }

    fn occluders(&self, key: u64) -> PathBuf {
        self.0.join(format!("{key:016x}.occluders"))
    }

    fn file(&self, key: u64) -> PathBuf {
        self.0.join(format!("{key:016x}.levels"))
    }

    /// What lies there under a key: the levels, or that there are none. A file that is damaged counts for nothing.
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

    /// Writes what was made beside its place and renames, so that whoever looks finds all of it or nothing.
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
