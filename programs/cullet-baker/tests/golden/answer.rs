//! Answers of the engine, in the form that is written.

use std::error::Error;
use std::path::Path;

use cullet::{Culler, Depth, View, ViewState, Visible};
use cullet_io::LoadOptions;
use cullet_maps::load;
use serde::Serialize;

use crate::view::{Camera, VIEWPORT};

/// All answers.
#[derive(Debug, Serialize)]
pub(crate) struct Golden {
    pub(crate) scenes: Vec<Scene>,
}

/// One file and the answers on it.
#[derive(Debug, Serialize)]
pub(crate) struct Scene {
    pub(crate) name: String,
    /// Its name in the folder.
    pub(crate) file: String,
    pub(crate) instances: u32,
    pub(crate) views: Vec<Answer>,
}

/// One view, and what is visible in it.
#[derive(Debug, Serialize)]
pub(crate) struct Answer {
    pub(crate) camera: Camera,
    /// The camera's projection, column-major.
    pub(crate) clip_from_view: [f32; 16],
    pub(crate) clip_from_world: [f64; 16],
    pub(crate) viewport: [u32; 2],
    /// Settings: [`Culler::exact`] or one of the others.
    pub(crate) preset: &'static str,
    /// Indices of the handles of visible instances, ascending: instances in the order of the file.
    pub(crate) visible: Vec<u32>,
    pub(crate) funnel: Vec<Row>,
}

/// A stage: instances, clusters and triangles that it was given, and that it left.
#[derive(Debug, Serialize)]
pub(crate) struct Row {
    pub(crate) stage: &'static str,
    pub(crate) unit: &'static str,
    #[serde(rename = "in")]
    pub(crate) entered: [u64; 3],
    #[serde(rename = "out")]
    pub(crate) left: [u64; 3],
}

impl Scene {
    /// Opens a file and culls it by each preset from each camera, every time as if it were the
    /// first.
    pub(crate) fn of(file: &Path) -> Result<Self, Box<dyn Error>> {
        let model = load(file, &LoadOptions::default())?;
        let scene = &model.scene;
        let presets = [
            ("exact", Culler::exact()),
            ("balanced", Culler::balanced()),
            ("fast", Culler::fast()),
        ];
        let mut views = Vec::new();
        for camera in Camera::around(&scene.extent()) {
            let clip_from_world = camera.clip_from_world();
            let view = View::from_matrix(clip_from_world, Depth::Reversed, VIEWPORT)?;
            for (preset, culler) in &presets {
                let (mut state, mut visible) = (ViewState::default(), Visible::default());
                model.in_cells().cull(culler, &view, &mut state, &mut visible);
                views.push(Answer {
                    camera,
                    clip_from_view: camera.clip_from_view(),
                    clip_from_world,
                    viewport: VIEWPORT,
                    preset,
                    visible: indices(scene, &visible),
                    funnel: funnel(&visible),
                });
            }
        }
        let name = |part: Option<&std::ffi::OsStr>| {
            part.unwrap_or_default().to_string_lossy().into_owned()
        };
        Ok(Self {
            name: name(file.file_stem()),
            file: name(file.file_name()),
            instances: scene.instance_count(),
            views,
        })
    }
}

fn indices(scene: &cullet::Scene, visible: &Visible) -> Vec<u32> {
    let mut indices: Vec<u32> =
        visible.slots().filter_map(|slot| Some(scene.handle(slot)?.index)).collect();
    indices.sort_unstable();
    indices
}

fn funnel(visible: &Visible) -> Vec<Row> {
    let counts = |c: &cullet::funnel::Counts| [c.instances, c.clusters, c.triangles];
    let row = |row: &cullet::funnel::FunnelRow| Row {
        stage: row.stage.name(),
        unit: row.unit.name(),
        entered: counts(&row.entered),
        left: counts(&row.left),
    };
    visible.funnel.rows.iter().map(row).collect()
}
