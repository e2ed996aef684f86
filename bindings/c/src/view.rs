//! Views: plain structs, from a matrix or a camera.

use engine::view::ViewError;
use engine::{
    Camera as EngineCamera, Depth, Projection,
    view::{CullFace, FrontFace},
};

use crate::memory::{Out, Plain, reserved, value};
use crate::status::{Error, Result, Status, call};

/// Clip depth 0 at the near plane, 1 at the far plane. Value of `depth`.
pub const CULLET_DEPTH_STANDARD: u32 = 0;
/// Clip depth 1 at the near plane, 0 at the far plane, which may be infinitely far. Value of
/// `depth`.
pub const CULLET_DEPTH_REVERSED: u32 = 1;

/// A view: what a camera sees, and how. Filled by `cullet_view_from_matrix`,
/// `cullet_view_from_camera` or `cullet_view_look_at`; then its last three fields may be changed.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The size of this struct, by which one that was never filled is known.
    pub size: u32,
    /// `CULLET_DEPTH_STANDARD` or `CULLET_DEPTH_REVERSED`.
    pub depth: u32,
    /// World to clip space, column-major.
    pub clip_from_world: [f64; 16],
    /// Width of the viewport in pixels, 1 to 65536.
    pub width: u32,
    /// Height of the viewport in pixels, 1 to 65536.
    pub height: u32,
    /// Layers that it sees; all of them at first.
    pub layers: u32,
    /// 1 where fronts are clockwise; 0 at first.
    pub clockwise: u32,
    /// Faces of one-sided meshes that are not drawn: 0 none, 1 the backs, 2 the fronts, as some
    /// shadow passes do; 1 at first.
    pub cull_face: u32,
    /// 0.
    pub reserved: u32,
}

impl Plain for View {}

/// A camera. Right-handed, looking along `direction`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    /// Where it stands.
    pub eye: [f64; 3],
    /// Where it looks; of any length above 0.
    pub direction: [f64; 3],
    /// Up; not along `direction`.
    pub up: [f64; 3],
    /// Perspective: the full vertical field of view in radians, above 0 and below pi. 0 for an
    /// orthographic camera.
    pub fov_y: f64,
    /// Orthographic: height of what it sees, in units of the scene. Not read in perspective.
    pub height: f64,
    /// Width over height of what it sees; 0 takes that of the viewport.
    pub aspect: f64,
    /// Distance of the near plane: above 0 in perspective.
    pub near_plane: f64,
    /// Distance of the far plane, beyond the near one; INFINITY in perspective for none.
    pub far_plane: f64,
}

impl Plain for Camera {}

fn depth_of(depth: u32) -> Result<Depth> {
    match depth {
        CULLET_DEPTH_STANDARD => Ok(Depth::Standard),
        CULLET_DEPTH_REVERSED => Ok(Depth::Reversed),
        _ => {
            Err(Error::value(format!("depth is {depth}: it must be 0 (standard) or 1 (reversed)")))
        }
    }
}

fn refused(error: ViewError) -> Error {
    Error::new(Status::View, error.to_string())
}

fn of_camera(camera: &Camera, depth: u32, viewport: [u32; 2]) -> Result<View> {
    let Camera { eye, direction, up, fov_y, height, aspect, near_plane, far_plane } = *camera;
    let of_viewport = f64::from(viewport[0]) / f64::from(viewport[1].max(1));
    let aspect = if aspect == 0.0 { of_viewport } else { aspect };
    let projection = if fov_y == 0.0 {
        let (x, y) = (height * 0.5 * aspect, height * 0.5);
        let (near, far) = (near_plane, far_plane);
        Projection::Orthographic { left: -x, right: x, bottom: -y, top: y, near, far }
    } else {
        let (near, far) = (near_plane, far_plane);
        Projection::Perspective { fov_y_radians: fov_y, aspect, near, far }
    };
    let camera = EngineCamera { eye, direction, up, projection };
    let view = engine::View::new(&camera, depth_of(depth)?, viewport).map_err(refused)?;
    Ok(of_engine(&view, depth))
}

fn of_engine(view: &engine::View, depth: u32) -> View {
    let [width, height] = view.viewport();
    View {
        size: size_of::<View>() as u32,
        depth,
        clip_from_world: view.clip_from_world(),
        width,
        height,
        layers: view.layers,
        clockwise: 0,
        cull_face: 1,
        reserved: 0,
    }
}

/// The engine's view of one that a caller hands in.
pub(crate) fn to_engine(view: &View) -> Result<engine::View> {
    let known = size_of::<View>() as u32;
    if view.size != known {
        let message = format!(
            "view->size is {}, not {known}: fill the view by cullet_view_from_matrix or its like",
            view.size
        );
        return Err(Error::new(Status::StructSize, message));
    }
    reserved("view->reserved", view.reserved)?;
    let viewport = [view.width, view.height];
    let depth = depth_of(view.depth)?;
    let mut of =
        engine::View::from_matrix(view.clip_from_world, depth, viewport).map_err(refused)?;
    of.layers = view.layers;
    of.front_face = match view.clockwise {
        0 => FrontFace::CounterClockwise,
        1 => FrontFace::Clockwise,
        other => {
            return Err(Error::value(format!("view->clockwise is {other}: it must be 0 or 1")));
        }
    };
    of.cull_face = match view.cull_face {
        0 => CullFace::None,
        1 => CullFace::Back,
        2 => CullFace::Front,
        other => {
            let message = format!("view->cull_face is {other}: it must be 0, 1 or 2");
            return Err(Error::value(message));
        }
    };
    Ok(of)
}

/// All eyes in a box, in world space. A point is a box too; one whose `min` is above its `max` has
/// no eye; where a number is not finite, eyes may be anywhere.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct EyeBox {
    /// The lowest corner.
    pub min: [f64; 3],
    /// The highest corner.
    pub max: [f64; 3],
}

impl Plain for EyeBox {}

/// Fills a view from a matrix that takes world to clip space: 16 doubles, column-major, invertible,
/// with depth 0 to 1 (`depth` says which is near). Perspective, orthographic, off-centre, mirrored,
/// with or without a far plane.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_view_from_matrix(
    clip_from_world: *const f64,
    depth: u32,
    width: u32,
    height: u32,
    view: *mut View,
) -> Status {
    call("cullet_view_from_matrix", || {
        // SAFETY: as the header asks of the caller.
        let matrix: [f64; 16] = unsafe { value("clip_from_world", clip_from_world.cast()) }?;
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::one("view", view) }?;
        let made = engine::View::from_matrix(matrix, depth_of(depth)?, [width, height]);
        out.set(0, of_engine(&made.map_err(refused)?, depth));
        Ok(())
    })
}

/// Fills a view from a camera; the message of a failure names the number that makes none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_view_from_camera(
    camera: *const Camera,
    depth: u32,
    width: u32,
    height: u32,
    view: *mut View,
) -> Status {
    call("cullet_view_from_camera", || {
        // SAFETY: as the header asks of the caller.
        let camera: Camera = unsafe { value("camera", camera) }?;
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::one("view", view) }?;
        out.set(0, of_camera(&camera, depth, [width, height])?);
        Ok(())
    })
}

/// Fills a perspective view from `eye` to `target`, three doubles each, +Y up (+Z where it looks
/// along Y), reversed depth without a far plane. `fov_y` is the full vertical field of view in
/// radians.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cullet_view_look_at(
    eye: *const f64,
    target: *const f64,
    fov_y: f64,
    near_plane: f64,
    width: u32,
    height: u32,
    view: *mut View,
) -> Status {
    call("cullet_view_look_at", || {
        // SAFETY: as the header asks of the caller.
        let eye: [f64; 3] = unsafe { value("eye", eye.cast()) }?;
        // SAFETY: as the header asks of the caller.
        let target: [f64; 3] = unsafe { value("target", target.cast()) }?;
        // SAFETY: as the header asks of the caller.
        let mut out = unsafe { Out::one("view", view) }?;
        let aspect = f64::from(width) / f64::from(height.max(1));
        let projection = Projection::Perspective {
            fov_y_radians: fov_y,
            aspect,
            near: near_plane,
            far: f64::INFINITY,
        };
        let camera = EngineCamera::look_at(eye, target, projection);
        let made = engine::View::new(&camera, Depth::Reversed, [width, height]);
        out.set(0, of_engine(&made.map_err(refused)?, CULLET_DEPTH_REVERSED));
        Ok(())
    })
}
