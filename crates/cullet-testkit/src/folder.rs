//! A folder of a test's own.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// A folder of its own among the temporary files, there from the start, gone with the value.
#[derive(Debug)]
pub struct Folder(PathBuf);

impl Folder {
    /// A new one, with a name that tells which test left it where one was killed.
    ///
    /// # Panics
    /// If it cannot be made.
    #[must_use]
    pub fn new(name: &str) -> Self {
        // Tests of one program run side by side, and may choose the same name.
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let name = format!("cullet-{name}-{}-{number}", std::process::id());
        let path = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&path).expect("a folder among the temporary files");
        Self(path)
    }

    /// The folder.
    #[must_use]
    pub fn root(&self) -> &Path {
        &self.0
    }

    /// The path of something in it, as an argument of a program.
    #[must_use]
    pub fn path(&self, name: &str) -> String {
        self.0.join(name).to_string_lossy().into_owned()
    }

    /// Writes a file in it; its path.
    ///
    /// # Panics
    /// If it cannot be written.
    #[must_use]
    pub fn file(&self, name: &str, text: &str) -> String {
        std::fs::write(self.0.join(name), text).expect("a file in a folder of its own");
        self.path(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // Who is the last to use something in it may not have let go of it yet.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_of_its_own_and_goes_with_its_value() {
        let (one, other) = (Folder::new("folder"), Folder::new("folder"));
        assert_ne!(one.root(), other.root());
        let file = one.file("a.txt", "text");
        assert_eq!(std::fs::read_to_string(&file).expect("written"), "text");
        assert_eq!(file, one.path("a.txt"));
        let root = one.root().to_owned();
        drop(one);
        assert!(!root.exists() && other.root().exists());
    }
}
