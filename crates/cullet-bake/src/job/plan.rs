//! Plan of a job, as a text that any machine understands.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::error::WorkError;
use super::settings::Settings;
use super::source::content_of;

/// The version of plans.
const VERSION: u32 = 1;

/// Product of a bake.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Product {
    /// Visible sets of the cells of a file.
    Cells,
    /// Visible sets of the view cells of a scene.
    ViewCells,
}

/// A bake that is to be done: of which content, with which settings, and the key of its units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    version: u32,
    /// The file as it was named where the plan was made, or a built-in scene.
    pub scene: String,
    /// Hash of the file's content; none for a built-in scene.
    pub content: Option<u64>,
    /// Product of the bake.
    pub product: Product,
    /// How.
    pub settings: Settings,
    /// The key of the work, see [`crate::work::Rounds::key`]: it depends on the whole scene, also
    /// on files that the file names.
    pub key: u64,
}

impl Plan {
    pub(crate) fn of(
        scene: &str,
        content: Option<u64>,
        product: Product,
        settings: &Settings,
        key: u64,
    ) -> Self {
        let scene = scene.to_owned();
        Self { version: VERSION, scene, content, product, settings: settings.clone(), key }
    }

    /// Returns the plan as JSON on one line.
    #[must_use]
    pub fn to_text(&self) -> String {
        // Numbers, texts and lists alone: nothing in it can fail.
        serde_json::to_string(self).unwrap_or_default()
    }

    /// Reads such a text.
    ///
    /// # Errors
    /// If it is none, or of another version.
    pub fn parse(text: &str) -> Result<Self, WorkError> {
        let plan: Self = serde_json::from_str(text)?;
        if plan.version != VERSION {
            return Err(WorkError::Version { found: plan.version, expected: VERSION });
        }
        Ok(plan)
    }

    /// Says if a file is not the one that was planned with.
    pub(crate) fn check(&self, scene: &str) -> Result<(), WorkError> {
        match (content_of(scene)?, self.content) {
            (Some(found), Some(expected)) if found != expected => {
                let path = Path::new(scene).to_owned();
                Err(WorkError::OtherContent { path, found, expected })
            }
            _ => Ok(()),
        }
    }
}
