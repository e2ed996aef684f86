//! Where the test data lies.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use crate::skip;

/// Path of a file or folder of the test data, such as `armadillo/armadillo.obj`.
///
/// Returns `None` where it is not there, once [`skip`] has said so: the test then ends. A `CULLET_DATA` that names
/// a folder which does not exist is no data, like none.
///
/// # Panics
///
/// With `CULLET_REQUIRE_DATA=1`, where the path does not exist; the message names it.
pub fn data(name: &str) -> Option<PathBuf> {
    match look_up(std::env::var_os("CULLET_DATA"), name) {
        Ok(path) => Some(path),
        Err(path) => {
            refuse(&path, std::env::var_os("CULLET_REQUIRE_DATA"));
            skip(&format!("{name}: no data"), "set CULLET_DATA to the folder of test data");
            None
        }
    }
}

/// The path under a folder of data, set or the default one; an error with the path where nothing is there.
fn look_up(set: Option<OsString>, name: &str) -> Result<PathBuf, PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let folder = set.filter(|v| !v.is_empty()).map_or_else(beside, PathBuf::from);
    let path = folder.join(name);
    if path.exists() { Ok(path) } else { Err(path) }
}

/// Fails where data must be there.
fn refuse(path: &Path, required: Option<OsString>) {
    let is_required = required.is_some_and(|v| v == "1");
    assert!(
        !is_required,
        "{} is not there, and CULLET_REQUIRE_DATA=1; set CULLET_DATA to the folder of test data",
        path.display()
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    /// This crate's own folder stands for one of data.
    fn here() -> Option<OsString> {
        Some(env!("CARGO_MANIFEST_DIR").into())
    }

    #[test]
    fn what_is_there_is_found_in_the_folder_that_was_set() {
        let path = look_up(here(), "src/data.rs").expect("this file");
        assert!(path.is_file());
        assert!(look_up(here(), "src").expect("the folder of this file").is_dir());
    }

    #[test]
    fn a_set_folder_that_does_not_exist_is_no_data() {
        let missing = std::env::temp_dir().join("cullet-no-such-folder");
        for name in ["broken", "armadillo/armadillo.obj"] {
            let path = look_up(Some(missing.clone().into()), name).expect_err("nothing is there");
            assert!(path.starts_with(&missing), "{}", path.display());
        }
        assert!(look_up(here(), "no/such/model.obj").is_err());
    }

    #[test]
    fn an_empty_setting_is_none() {
        assert_eq!(look_up(Some(OsString::new()), "x"), look_up(None, "x"));
    }

    #[test]
    fn absent_data_is_refused_only_where_it_is_required() {
        let path = Path::new("/no/such/model.obj");
        refuse(path, None);
        refuse(path, Some("0".into()));
        let panic =
            std::panic::catch_unwind(|| refuse(path, Some("1".into()))).expect_err("required");
        let message = panic.downcast_ref::<String>().expect("a message");
        assert!(message.contains("/no/such/model.obj"), "{message}");
    }
}
