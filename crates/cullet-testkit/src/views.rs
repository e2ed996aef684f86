//! Views of any kind, and what is culled by them.

use cullet::bounds::{Aabb, Plane};
use cullet::cull::detail::{Detail, Measure};
use cullet::cull::frustum::batch::Planes;
use cullet::cull::occlusion::Occlusion;
use cullet::{
    Backface, Camera, Culler, Depth, Projection, View,
    view::{CullFace, FrontFace, Frustum},
};

use crate::Rng;

/// A camera of any projection, mostly among what stands around the origin.
fn random_camera(rng: &mut Rng) -> Camera {
    let far = match rng.below(3) {
        0 => f64::INFINITY,
        _ => rng.range(5.0, 60.0),
    };
    let near = 10f64.powf(rng.range(-2.0, 0.5));
    let (w, h) = (near * rng.range(0.2, 2.0), near * rng.range(0.2, 2.0));
    let (x, y) = (w * rng.range(-0.5, 0.5), h * rng.range(-0.5, 0.5));
    let projection = match rng.below(3) {
        0 => Projection::Perspective {
            fov_y_radians: rng.range(0.1, 2.5),
            aspect: rng.range(0.3, 3.0),
            near,
            far,
        },
        1 => Projection::OffCentre {
            left: x - w,
            right: x + w,
            bottom: y - h,
            top: y + h,
            near,
            far,
        },
        _ => {
            let (w, h) = (rng.range(1.0, 15.0), rng.range(1.0, 15.0));
            Projection::Orthographic {
                left: -w,
                right: w * 0.7,
                bottom: -h,
                top: h * 0.8,
                near: rng.range(-5.0, 1.0),
                far: rng.range(5.0, 40.0),
            }
        }
    };
    Camera { eye: rng.vector(14.0), direction: rng.vector(1.0), up: rng.vector(1.0), projection }
}

/// The same view with any winding, culled face and layers.
fn dress(mut view: View, choice: u64) -> View {
    view.front_face =
        if choice & 1 == 0 { FrontFace::CounterClockwise } else { FrontFace::Clockwise };
    view.cull_face = [CullFace::Back, CullFace::Back, CullFace::Front, CullFace::None]
        [(choice >> 1) as usize % 4];
    view.layers = if choice >> 3 & 3 == 0 { 3 } else { u32::MAX };
    view
}

fn depth(choice: u64) -> Depth {
    if choice >> 8 & 1 == 0 { Depth::Standard } else { Depth::Reversed }
}

/// A view of any kind: a third of them mirrored.
pub fn random_view(rng: &mut Rng) -> View {
    let choice = rng.bits();
    let camera = random_camera(rng);
    let view = View::new(&camera, depth(choice), [640, 480]).expect("a good camera");
    if choice.is_multiple_of(3) {
        let mut m = view.clip_from_world();
        (0..4).for_each(|c| m[c * 4] = -m[c * 4]);
        let mirrored = View::from_matrix(m, depth(choice), [640, 480]).expect("a good matrix");
        return dress(mirrored, choice >> 16);
    }
    dress(view, choice >> 16)
}

/// A view, and the same one moved by `offset`.
pub fn view_and_moved(rng: &mut Rng, offset: [f64; 3]) -> (View, View) {
    let choice = rng.bits();
    let camera = random_camera(rng);
    let moved = Camera { eye: std::array::from_fn(|a| camera.eye[a] + offset[a]), ..camera };
    let make = |c: &Camera| {
        dress(View::new(c, depth(choice), [640, 480]).expect("a good camera"), choice >> 16)
    };
    (make(&camera), make(&moved))
}

/// A view of one of every kind, from nearby towards the origin, for small pictures.
pub fn mixed_view(rng: &mut Rng, viewport: [u32; 2]) -> View {
    let mut number = |low: f64, high: f64| rng.range(low, high);
    let eye = [number(-4.0, 4.0), number(-4.0, 4.0), number(-4.0, 4.0)];
    let target = [number(-1.0, 1.0), number(-1.0, 1.0), number(-1.0, 1.0)];
    let aspect = f64::from(viewport[0]) / f64::from(viewport[1]);
    let (near, size) = (number(0.01, 1.0), number(0.3, 4.0));
    let projection = match rng.below(5) {
        0 => Projection::Orthographic {
            left: -size * aspect,
            right: size * aspect,
            bottom: -size,
            top: size,
            near: -5.0,
            far: 9.0,
        },
        1 => Projection::OffCentre {
            left: -0.3 * near,
            right: 1.1 * near,
            bottom: -0.2 * near,
            top: 0.9 * near,
            near,
            far: 12.0,
        },
        // Mirrored.
        2 => Projection::OffCentre {
            left: near,
            right: -near,
            bottom: -near,
            top: near,
            near,
            far: f64::INFINITY,
        },
        kind => Projection::Perspective {
            fov_y_radians: size * 0.5,
            aspect,
            near,
            far: if kind == 3 { f64::INFINITY } else { 8.0 },
        },
    };
    let depth = if rng.chance(0.5) { Depth::Standard } else { Depth::Reversed };
    let mut view = View::new(&Camera::look_at(eye, target, projection), depth, viewport).unwrap();
    view.front_face =
        if rng.chance(0.8) { FrontFace::CounterClockwise } else { FrontFace::Clockwise };
    view.cull_face = match rng.below(6) {
        0 => CullFace::None,
        1 => CullFace::Front,
        _ => CullFace::Back,
    };
    view.layers = if rng.chance(0.2) { 2 } else { u32::MAX };
    view
}

/// A plain perspective from the origin along −Z.
pub fn looking_down_z() -> View {
    let projection =
        Projection::Perspective { fov_y_radians: 1.0, aspect: 1.0, near: 0.1, far: 100.0 };
    let camera = Camera::look_at([0.0; 3], [0.0, 0.0, -1.0], projection);
    View::new(&camera, Depth::Standard, [100, 100]).expect("a good camera")
}

/// A perspective view with +Y up.
pub fn look(eye: [f64; 3], target: [f64; 3], viewport: [u32; 2]) -> View {
    let projection = Projection::Perspective {
        fov_y_radians: 60f64.to_radians(),
        aspect: f64::from(viewport[0]) / f64::from(viewport[1]),
        near: 0.5,
        far: 6000.0,
    };
    View::new(&Camera::look_at(eye, target, projection), Depth::Standard, viewport).unwrap()
}

/// A box of any kind: mostly plain, sometimes one that is no box.
pub fn random_box(rng: &mut Rng) -> Aabb {
    let centre = rng.vector(100.0).map(|v| v as f32);
    let half = rng.range(0.0, 6.0) as f32;
    let mut b = Aabb::new(centre.map(|c| c - half), centre.map(|c| c + half));
    match rng.below(60) {
        0 => b = Aabb::EMPTY,
        1 => b.min[1] = f32::NAN,
        2 => b = Aabb::EVERYTHING,
        3 => b.min[0] = b.max[0] + 1.0,
        4 => b.max[2] = f32::INFINITY,
        5 => b = Aabb::new([1e30; 3], [2e30; 3]),
        6 => b = Aabb::new(centre, centre),
        _ => {}
    }
    b
}

/// Planes of a view, of a region of up to 32 planes, or none.
pub fn random_planes(rng: &mut Rng) -> Planes {
    if rng.below(2) == 0 {
        return Planes::new(&random_view(rng).frustum());
    }
    let mut frustum = Frustum::everything();
    for _ in 0..rng.below(33) {
        let normal = rng.vector(1.0);
        let _ = frustum.push(Plane::new(normal, rng.range(-20.0, 120.0)));
    }
    Planes::new(&frustum)
}

/// Every stage on or off, in every way.
pub fn random_culler(rng: &mut Rng) -> Culler {
    let detail = Detail::default()
        .with_measure(Measure::WidthAndHeight)
        .with_threshold_px(rng.range(1.0, 60.0))
        .with_clusters(rng.below(2) == 0);
    Culler::default()
        .with_frustum(rng.below(6) > 0)
        .with_frustum_exact(rng.below(3) == 0)
        .with_backface(
            [Backface::Off, Backface::Fast, Backface::Fast, Backface::Exact][rng.below(4) as usize],
        )
        .with_degenerate(rng.below(5) > 0)
        .with_detail((rng.below(3) == 0).then_some(detail))
        .with_occlusion((rng.below(2) == 0).then(Occlusion::default))
}
