//! Measures the savings of each stage of culling with the viewer's renderer.

use crate::tools::{Done, cargo};

/// Runs the viewer's own measurement of a scene; of the city and of the office where none is named.
pub(crate) fn measure(scene: Option<&str>) -> Done {
    let scenes = scene.map_or(vec!["city", "office"], |s| vec![s]);
    scenes.into_iter().try_for_each(|scene| {
        cargo(&["run", "--release", "-q", "-p", "cullet-viewer", "--", scene, "--bench"])
    })
}
