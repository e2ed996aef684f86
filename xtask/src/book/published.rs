//! The book as it is published, in a browser: from a path of a server, and from the file system.

use super::{has_mdbook, put_together};
use crate::runner::{End, Ended, Skip, all};
use crate::tools::{cargo_install_words, run};
use crate::web;

/// Folder of the scripts that use a browser, from the root.
const SCRIPTS: &str = "programs/cullet-viewer/web/tests";

/// The step of `test`: every chapter opens, nothing that it shows is missing, and the page starts
/// or says why it cannot.
pub(crate) fn test() -> Ended {
    let what = "the book with the page in it, opened from a server's path and from files";
    let browser = match web::browser(what)? {
        Ok(browser) => browser,
        Err(skip) => return Ok(End::Skipped(skip)),
    };
    if !has_mdbook()? {
        return Ok(End::Skipped(Skip::new(what, cargo_install_words(super::PACKAGE))));
    }
    web::build()?;
    let book = put_together()?;
    match web::script(SCRIPTS, "published.mjs", what)? {
        Ok(mut node) => {
            node.env("CHROMIUM", browser).arg(book);
            all(run(node))
        }
        Err(skip) => Ok(End::Skipped(skip)),
    }
}
