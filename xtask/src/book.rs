//! The book as it is published: with the viewer's page in it, where its chapters link to.

use std::fs;
use std::path::Path;

use crate::tools::{Done, cargo_install_words, command, optional, root, run};
use crate::web;

/// Where the page lies in the book; chapters link to states of it.
const PAGE: &str = "viewer";

/// Builds the page, then the book, then puts the one into the other.
pub(crate) fn build() -> Done {
    const PACKAGE: &str = "mdbook";
    if optional(PACKAGE, &["--version"]).is_none() {
        return Err(format!("needed: {}", cargo_install_words(PACKAGE)));
    }
    web::build()?;
    run(command(PACKAGE, &["build", "docs"]))?;
    let book = root().join("docs/book");
    copy(&web::page(), &book.join(PAGE))?;
    println!("{}: publish it as it is; any server of plain files does", book.display());
    Ok(())
}

/// Copies the files of a folder that has no others in it.
fn copy(from: &Path, to: &Path) -> Done {
    let fail = |path: &Path, e: std::io::Error| format!("{}: {e}", path.display());
    fs::create_dir_all(to).map_err(|e| fail(to, e))?;
    for entry in fs::read_dir(from).map_err(|e| fail(from, e))?.flatten() {
        let path = entry.path();
        fs::copy(&path, to.join(entry.file_name())).map_err(|e| fail(&path, e))?;
    }
    Ok(())
}
