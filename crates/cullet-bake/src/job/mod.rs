//! Long bakes as plans that any process on any machine may work on.
//!
//! A [`Plan`] is a short text: which file, by the hash of its content, and with which settings.
//! Whoever holds plan and file opens a [`Job`], runs *units* of its rounds (see
//! [`work`](crate::work)), and takes in those that others ran, as bytes. The result is the same for
//! every split, order, repetition and loss.
//!
//! ```
//! use cullet_bake::job::{Job, Plan, Settings};
//! # use std::sync::{Arc, atomic::AtomicBool};
//!
//! let mut settings = Settings::default();
//! settings.scene.view_cells = Some(4);
//! settings.scene.rays = Some(100_000);
//! let plan = Plan::new("city:objects=50", &settings)?;
//! let mut job = Job::open(&Plan::parse(&plan.to_text())?, "city:objects=50", 1)?;
//! while !job.is_done() {
//!     let stop = Arc::new(AtomicBool::new(false));
//!     let units = job.missing(&[], 2);
//!     let mut found = Vec::new();
//!     for items in units {
//!         // On any machine.
//!         let bytes = job.run(items.clone(), 1, &stop)?.expect("nobody stops it");
//!         found.push((items, bytes));
//!     }
//!     job.merge(found)?;
//! }
//! assert_eq!(job.finish()?.cells, 4);
//! # Ok::<(), cullet_bake::job::WorkError>(())
//! ```
mod error;
mod plan;
mod run;
mod settings;
mod source;

pub use error::WorkError;
pub use plan::{Plan, Product};
pub use run::{Job, Made};
pub use settings::{SceneSettings, Settings};
pub use source::{CellSource, content_of, contents_of, is_named_map, is_named_scene};
