//! The funnel as diagnostics of Bevy.

use bevy_app::{App, Plugin, PostUpdate};
use bevy_camera::Camera;
use bevy_camera::visibility::VisibilitySystems;
use bevy_diagnostic::{Diagnostic, DiagnosticPath, Diagnostics, RegisterDiagnostic};
use bevy_ecs::prelude::*;

use crate::CulletView;

/// Measures the funnel of all active cameras together, frame by frame: the sums of their
/// [`CulletFunnel`](crate::CulletFunnel)s.
#[derive(Clone, Copy, Debug, Default)]
pub struct CulletDiagnosticsPlugin;

impl CulletDiagnosticsPlugin {
    /// Entities with a mesh.
    pub const ENTITIES: DiagnosticPath = DiagnosticPath::const_new("cullet/entities");
    /// Entities among them in layers and frustum.
    pub const IN_FRUSTUM: DiagnosticPath = DiagnosticPath::const_new("cullet/in_frustum");
    /// Entities among them in their visibility range.
    pub const IN_RANGE: DiagnosticPath = DiagnosticPath::const_new("cullet/in_range");
    /// Entities among them that are not behind others.
    pub const VISIBLE: DiagnosticPath = DiagnosticPath::const_new("cullet/visible");
}

impl Plugin for CulletDiagnosticsPlugin {
    fn build(&self, app: &mut App) {
        for path in [Self::ENTITIES, Self::IN_FRUSTUM, Self::IN_RANGE, Self::VISIBLE] {
            app.register_diagnostic(Diagnostic::new(path));
        }
        app.add_systems(PostUpdate, measure.after(VisibilitySystems::CheckVisibility));
    }
}

fn measure(mut diagnostics: Diagnostics, views: Query<(&Camera, &CulletView)>) {
    let active =
        || views.iter().filter(|(camera, _)| camera.is_active).map(|(_, view)| view.funnel);
    let mut add = |path: DiagnosticPath, of: &dyn Fn(crate::CulletFunnel) -> u64| {
        diagnostics.add_measurement(&path, || active().map(of).sum::<u64>() as f64);
    };
    add(CulletDiagnosticsPlugin::ENTITIES, &|f| f.entities);
    add(CulletDiagnosticsPlugin::IN_FRUSTUM, &|f| f.in_frustum);
    add(CulletDiagnosticsPlugin::IN_RANGE, &|f| f.in_range);
    add(CulletDiagnosticsPlugin::VISIBLE, &|f| f.visible);
}
