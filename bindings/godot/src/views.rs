//! Cameras of Godot as views of the engine.

use cullet::bounds::Aabb;
use cullet::{Depth, View};
use godot::classes::camera_3d::{KeepAspect, ProjectionType};
use godot::classes::rendering_server::ViewportUpdateMode;
use godot::classes::viewport::Scaling3DMode;
use godot::classes::{
    Camera3D, RenderingServer, SubViewport, Viewport, Window, XrInterface, XrServer,
};
use godot::obj::{InstanceId, Singleton};
use godot::prelude::*;

/// A camera that draws, and what its shadows need.
#[derive(Clone, Debug)]
pub(crate) struct Eye {
    pub(crate) camera: InstanceId,
    pub(crate) view: View,
    /// Fog that is lit, whose shadows lie in the air.
    pub(crate) has_lit_fog: bool,
    /// Global illumination from distance fields, into which all lamps shine.
    pub(crate) has_sdfgi: bool,
    pub(crate) near: f64,
    pub(crate) far: f64,
}

/// Collects the cameras that draw `world`. Returns false if one of them shows no volume: then
/// nothing can be told of what it sees.
pub(crate) fn collect(viewports: &[Gd<Viewport>], world: Rid, eyes: &mut Vec<Eye>) -> bool {
    eyes.clear();
    let mut is_known = true;
    for viewport in viewports {
        if viewport.is_3d_disabled() || !draws(viewport) {
            continue;
        }
        let is_ours = viewport.find_world_3d().is_some_and(|own| own.get_scenario() == world);
        let Some(camera) = viewport.get_camera_3d().filter(|_| is_ours) else { continue };
        let xr = if viewport.is_using_xr() { xr_interface() } else { None };
        let found = match xr {
            Some(xr) => of_headset(&camera, &xr, eyes),
            None => of_camera(viewport, &camera, eyes),
        };
        is_known &= found.is_some();
    }
    is_known
}

/// Whether a viewport may be drawn in this frame. Scripts may ask the server for one picture, which
/// the node does not know of.
fn draws(viewport: &Gd<Viewport>) -> bool {
    let server = RenderingServer::singleton();
    server.viewport_get_update_mode(viewport.get_viewport_rid()) != ViewportUpdateMode::DISABLED
}

fn xr_interface() -> Option<Gd<XrInterface>> {
    XrServer::singleton().get_primary_interface().filter(|xr| xr.is_initialized())
}

fn size_of(viewport: &Gd<Viewport>) -> [f64; 2] {
    let size = if let Ok(sub) = viewport.clone().try_cast::<SubViewport>() {
        sub.get_size()
    } else if let Ok(window) = viewport.clone().try_cast::<Window>() {
        window.get_size()
    } else {
        let rect = viewport.get_visible_rect();
        Vector2i::new(rect.size.x as i32, rect.size.y as i32)
    };
    [size.x, size.y].map(|side| f64::from(side.max(1)))
}

/// Returns what `camera` would show in a picture of `size` pixels, whichever viewport it is in; `None`
/// where that is no volume.
pub(crate) fn of_size(camera: &Gd<Camera3D>, size: Vector2i) -> Option<Eye> {
    let size = [size.x, size.y].map(|side| f64::from(side.max(1)));
    let aspect = (size[0] / size[1]) as f32;
    let (near, far, extent) = (camera.get_near(), camera.get_far(), camera.get_size());
    let by_width = camera.get_keep_aspect_mode() == KeepAspect::WIDTH;
    let projection = match camera.get_projection() {
        ProjectionType::ORTHOGONAL => {
            Projection::create_orthogonal_aspect(extent, aspect, near, far, by_width)
        }
        ProjectionType::FRUSTUM => {
            let offset = camera.get_frustum_offset();
            Projection::create_frustum_aspect(extent, aspect, offset, near, far, by_width)
        }
        _ => Projection::create_perspective(camera.get_fov(), aspect, near, far, by_width),
    };
    eye(camera, matrix(&projection, &camera.get_camera_transform(), [1.0; 2]), size)
}

/// Returns the size of a viewport in pixels.
pub(crate) fn pixels(viewport: &Gd<Viewport>) -> Vector2i {
    let [x, y] = size_of(viewport);
    Vector2i::new(x as i32, y as i32)
}

fn of_camera(viewport: &Gd<Viewport>, camera: &Gd<Camera3D>, eyes: &mut Vec<Eye>) -> Option<()> {
    let size = size_of(viewport);
    // The picture is moved by up to half a pixel from frame to frame: a pixel more on each side.
    let mode = viewport.get_scaling_3d_mode();
    let jitters = viewport.is_using_taa() || mode == Scaling3DMode::FSR2;
    let scale = f64::from(viewport.get_scaling_3d_scale().clamp(0.1, 2.0));
    let wider = size.map(|side| {
        let pixels = (side * scale).max(1.0);
        if jitters { pixels / (pixels + 2.0) } else { 1.0 }
    });
    let matrix = matrix(&camera.get_camera_projection(), &camera.get_camera_transform(), wider);
    eyes.push(eye(camera, matrix, size)?);
    Some(())
}

/// Adds a view of each eye, by where the headset will be drawn from.
fn of_headset(camera: &Gd<Camera3D>, xr: &Gd<XrInterface>, eyes: &mut Vec<Eye>) -> Option<()> {
    let size = xr.clone().get_render_target_size();
    let size = [size.x, size.y].map(|side| f64::from(side.max(1.0)));
    let (near, far) = (f64::from(camera.get_near()), f64::from(camera.get_far()));
    // Godot takes the origin too, not the camera, and adds the newest pose of the head.
    let place = XrServer::singleton().get_world_origin();
    for view in 0..xr.get_view_count() {
        let at = xr.get_transform_for_view(view, place);
        let projection = xr.get_projection_for_view(view, size[0] / size[1], near, far);
        eyes.push(eye(camera, matrix(&projection, &at, [1.0; 2]), size)?);
    }
    Some(())
}

fn eye(camera: &Gd<Camera3D>, matrix: [f64; 16], size: [f64; 2]) -> Option<Eye> {
    let size = size.map(|side| side.min(65_536.0) as u32);
    let view = View::from_gl_matrix(matrix, Depth::Standard, size).ok()?;
    let view = view.with_layers(camera.get_cull_mask());
    let world = camera.get_world_3d();
    let of_world = || world.as_ref().and_then(|world| world.get_environment());
    let fallback = || world.as_ref().and_then(|world| world.get_fallback_environment());
    let environment = camera.get_environment().or_else(of_world).or_else(fallback);
    let has_lit_fog = environment.as_ref().is_some_and(|e| e.is_volumetric_fog_enabled());
    let has_sdfgi = environment.is_some_and(|e| e.is_sdfgi_enabled());
    let (near, far) = (f64::from(camera.get_near()), f64::from(camera.get_far()));
    Some(Eye { camera: camera.instance_id(), view, has_lit_fog, has_sdfgi, near, far })
}

/// Returns clip space of OpenGL from world space. Projections of Godot have it, −w ≤ z ≤ w,
/// whatever the renderer makes of them later.
fn matrix(p: &Projection, t: &Transform3D, wider: [f64; 2]) -> [f64; 16] {
    let mut p = p.cols.map(|c| [c.x, c.y, c.z, c.w].map(f64::from));
    for column in &mut p {
        column[0] *= wider[0];
        column[1] *= wider[1];
    }
    let inverse = inverse(t);
    std::array::from_fn(|i| (0..4).map(|k| p[k][i % 4] * inverse[i / 4][k]).sum())
}

/// Returns the columns of the inverse of a camera's transform, which is orthonormal.
fn inverse(t: &Transform3D) -> [[f64; 4]; 4] {
    let axes = [t.basis.col_a(), t.basis.col_b(), t.basis.col_c()];
    let axes = axes.map(|c| [c.x, c.y, c.z].map(f64::from));
    let origin = [t.origin.x, t.origin.y, t.origin.z].map(f64::from);
    let mut columns = [[0.0; 4]; 4];
    for (column, to) in columns.iter_mut().take(3).enumerate() {
        (0..3).for_each(|row| to[row] = axes[row][column]);
    }
    for row in 0..3 {
        columns[3][row] = -(0..3).map(|k| axes[row][k] * origin[k]).sum::<f64>();
    }
    columns[3][3] = 1.0;
    columns
}

/// Returns a view of all that lies in `cube`, a box around the origin of `at`, seen along parallel
/// lines: for what a probe or a lamp reaches.
pub(crate) fn of_box(at: &Transform3D, half: [f64; 3], layers: u32) -> Option<View> {
    // General: a probe may be scaled.
    let inverse = at.affine_inverse();
    let axes =
        [inverse.basis.col_a(), inverse.basis.col_b(), inverse.basis.col_c(), inverse.origin];
    let mut m = [0.0; 16];
    for (column, axis) in axes.iter().enumerate() {
        let axis = [axis.x, axis.y, axis.z].map(f64::from);
        for row in 0..3 {
            // A little more than the box, for what f32 rounded.
            m[column * 4 + row] = axis[row] / (half[row] * 1.0001);
        }
    }
    m[15] = 1.0;
    let view = View::from_gl_matrix(m, Depth::Standard, [64, 64]).ok()?;
    Some(view.with_layers(layers))
}

/// Returns a view of all that lies in a box of world space.
pub(crate) fn of_world_box(b: &Aabb, layers: u32) -> Option<View> {
    let (centre, half) = (b.center(), b.half_extent());
    let origin = Vector3::new(centre[0] as f32, centre[1] as f32, centre[2] as f32);
    let moved: [f64; 3] = std::array::from_fn(|a| {
        let rounded = f64::from([origin.x, origin.y, origin.z][a]);
        half[a] + (centre[a] - rounded).abs()
    });
    of_box(&Transform3D::new(Basis::IDENTITY, origin), moved, layers)
}
