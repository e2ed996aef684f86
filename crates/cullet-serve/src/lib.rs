//! A small HTTP server for the viewer's page and one scene.
//!
//! It answers with what it was told to serve and with nothing else: the files of the page are read once, at
//! the start, into a list of names, and a request is compared with that list. No path of a request is ever
//! joined to a folder, so `..`, links, absolute paths and unusual encodings lead nowhere by construction.
//!
//! * [`Site`] holds the served files; [`Site::new`] names those that are missing.
//! * [`Server`] listens, on the loopback interface unless told otherwise, and stops on request.
//!
//! Files of the page that have a neighbour `NAME.gz` are sent compressed to whoever accepts that. A scene is
//! sent as it lies on the disk, and compressed on the way only beyond the loopback interface, where it pays.
#![forbid(unsafe_code)]

mod answer;
mod body;
mod places;
mod server;
mod site;

pub use server::{Limits, Server};
pub use site::{PAGE_HELP, SCENE_FOLDER, Site, SiteError, find_page};
