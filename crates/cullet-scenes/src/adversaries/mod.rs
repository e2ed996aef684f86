//! Adversaries: small scenes that are hard for whoever rasterises occluders conservatively, with
//! views of them.
//!
//! Made by rule from a number and a seed: [`ADVERSARIES`] different ones, then the same kinds from
//! other numbers. What each is for is in its name.

mod draft;
mod edges;
mod places;
mod surfaces;

use cullet::mesh::Part;
use cullet::{Camera, Depth, Instance, Mesh, MeshData, Projection, Scene, Transform, View};
use glam::{DMat3, DVec3};

use crate::Rng;
use draft::{Draft, NEAR, Screen, anywhere, one};

/// A scene, and views of it.
#[derive(Debug)]
pub struct Adversary {
    /// Its kind, and how it stands.
    pub name: String,
    /// Its triangles, all of them opaque.
    pub scene: Scene,
    /// At least one. The first stands so that corners of pixels are exact positions.
    pub views: Vec<View>,
}

/// Adds the triangles of a kind.
type Kind = fn(&mut Draft, &mut Rng, &Screen);

const KINDS: &[(&str, Kind)] = &[
    ("sheets", surfaces::sheets),
    ("folds", surfaces::folds),
    ("T-junctions", edges::t_junctions),
    ("hairline gaps", edges::hairline_gaps),
    ("slivers", edges::slivers),
    ("three and more at an edge", edges::fans),
    ("doubled triangles", edges::doubled),
    ("bent quads", surfaces::bent_quads),
    ("near-plane crossers", places::near_crossers),
    ("corners on the near plane", places::on_the_near_plane),
    ("corners on pixel corners", places::pixel_corners),
    ("edges of the screen", places::screen_edges),
    ("huge triangles", surfaces::huge),
    ("tiny triangles", surfaces::tiny),
    ("layers", surfaces::layers),
    ("stars", edges::stars),
    ("solids", places::solids),
    ("terrain", surfaces::terrain),
    ("soup", surfaces::soup),
    ("all together", all_together),
];

/// How an adversary stands.
#[derive(Clone, Copy, Debug)]
struct Stand {
    name: &'static str,
    two_sided: bool,
    parallel: bool,
    /// The image of the axes of the mesh, in powers of two where positions must stay exact.
    linear: [[f64; 3]; 3],
    /// So far from the origin, along each axis.
    away: f64,
    /// Whether the views mirror.
    mirrored: bool,
}

const PLAIN: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

const STANDS: &[Stand] = &[
    Stand {
        name: "one-sided",
        two_sided: false,
        parallel: false,
        linear: PLAIN,
        away: 0.0,
        mirrored: false,
    },
    Stand {
        name: "two-sided, mirrored and stretched",
        two_sided: true,
        parallel: false,
        linear: [[-2.0, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 4.0]],
        away: 0.0,
        mirrored: false,
    },
    Stand {
        name: "one-sided, orthographic",
        two_sided: false,
        parallel: true,
        linear: PLAIN,
        away: 0.0,
        mirrored: false,
    },
    Stand {
        name: "two-sided, sheared, far away, in mirrored views",
        two_sided: true,
        parallel: false,
        linear: [[1.5, 0.2, 0.0], [-0.3, 0.9, 0.1], [0.4, 0.0, 1.1]],
        away: 1_048_576.0,
        mirrored: true,
    },
];

/// How many adversaries differ in more than their numbers.
pub const ADVERSARIES: u32 = (KINDS.len() * STANDS.len()) as u32;

/// An adversary by its number, with so many views (at least one) of `size` pixels.
///
/// The same arguments give the same scene and views, to the last bit, on every machine. Numbers
/// from [`ADVERSARIES`] on give kinds that there were, from other random numbers. A side of `size`
/// must not be 0, and is at most 65,536.
///
/// # Panics
/// If `size` is none of a view.
#[must_use]
pub fn adversary(number: u32, seed: u64, views: u32, size: [u32; 2]) -> Adversary {
    let (kind_name, kind) = KINDS[number as usize % KINDS.len()];
    let stand = STANDS[number as usize / KINDS.len() % STANDS.len()];
    let rng = &mut Rng::new(seed, u64::from(number));
    let screen = Screen { size, parallel: stand.parallel };
    let mut draft = Draft::default();
    kind(&mut draft, rng, &screen);
    Adversary {
        name: format!("{kind_name}, {}", stand.name),
        scene: scene(&draft, &stand),
        views: (0..views.max(1)).map(|view| self::view(view, &screen, &stand, rng)).collect(),
    }
}

fn all_together(d: &mut Draft, rng: &mut Rng, screen: &Screen) {
    for _ in 0..4 {
        // Never itself, the last.
        let (_, kind) = KINDS[rng.below(KINDS.len() - 1)];
        kind(d, rng, screen);
    }
}

/// One instance of one mesh: where its transform takes it is where it was drafted.
fn scene(draft: &Draft, stand: &Stand) -> Scene {
    let linear = DMat3::from_cols_array_2d(&stand.linear);
    let inverse = linear.inverse();
    let positions = draft.positions.iter().map(|p| (inverse * *p).as_vec3().to_array()).collect();
    let mut indices = draft.triangles.as_flattened().to_vec();
    if linear.determinant() < 0.0 {
        // The side that faces outward stays the same.
        indices.as_chunks_mut::<3>().0.iter_mut().for_each(|t| t.swap(1, 2));
    }
    let triangle_count = draft.triangles.len() as u32;
    let part = Part { triangle_count, two_sided: stand.two_sided, ..Part::default() };
    let data = MeshData { positions, indices, parts: vec![part], ..MeshData::default() };
    let mut scene = Scene::new();
    scene.rebase([stand.away; 3]);
    // Drafts are finite, and their indices their own.
    if let Ok(mesh) = Mesh::new(data) {
        let mesh = scene.add_mesh(mesh);
        let transform = Transform {
            linear: stand.linear.map(|c| c.map(|v| v as f32)),
            translation: [stand.away; 3],
        };
        let _ = scene.add(Instance::new(mesh, transform));
    }
    scene.commit(&cullet::Culler::default());
    scene
}

fn view(number: u32, screen: &Screen, stand: &Stand, rng: &mut Rng) -> View {
    let mut eye = DVec3::ZERO;
    let (mut direction, mut up) = (DVec3::NEG_Z, DVec3::Y);
    let [x, y] = screen.half();
    let (mut near, mut zoom) = (NEAR, 1.0);
    if number > 0 {
        // Often on whole numbers and along the axes, where much comes out equal.
        eye = anywhere(rng, 4.0);
        direction = anywhere(rng, 0.5) + DVec3::NEG_Z;
        up = anywhere(rng, 0.3) + DVec3::Y;
        if rng.chance(0.3) {
            (eye, up) = (eye.round(), DVec3::Y);
            direction = one(rng, &[DVec3::NEG_Z, DVec3::NEG_Z, DVec3::X, DVec3::Z]);
        }
        near = one(rng, &[NEAR, 0.01, 0.5, 2.0]);
        zoom = one(rng, &[1.0, 1.0, 0.4, 2.5]);
    }
    let depth = if rng.chance(0.5) { Depth::Reversed } else { Depth::Standard };
    // Off centre in one of three.
    let shift = if number > 0 && rng.chance(0.33) { rng.range(-0.6, 0.6) } else { 0.0 };
    let mut window = [x * (shift - 1.0), x * (shift + 1.0), -y, y].map(|v| v * zoom);
    if stand.mirrored {
        window.swap(0, 1);
    }
    let [left, right, bottom, top] = window;
    let projection = if screen.parallel {
        Projection::Orthographic { left, right, bottom, top, near, far: 64.0 }
    } else {
        let far = if rng.chance(0.5) { f64::INFINITY } else { 100.0 };
        let [left, right, bottom, top] = window.map(|v| v * near);
        Projection::OffCentre { left, right, bottom, top, near, far }
    };
    let eye = (eye + DVec3::splat(stand.away)).to_array();
    let camera = Camera { eye, direction: direction.into(), up: up.into(), projection };
    View::new(&camera, depth, screen.size).expect("finite numbers, and axes that are apart")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_many_and_each_has_a_name_triangles_and_views() {
        let all: Vec<Adversary> = (0..ADVERSARIES).map(|n| adversary(n, 1, 3, [96, 54])).collect();
        assert!(all.len() >= 64);
        let mut names: Vec<&str> = all.iter().map(|a| a.name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), all.len());
        for a in &all {
            assert!(a.scene.triangle_count() > 10, "{}: {}", a.name, a.scene.triangle_count());
            assert_eq!(a.views.len(), 3, "{}", a.name);
        }
    }

    #[test]
    fn the_same_number_and_seed_give_the_same_adversary() {
        for number in [3, 24, 47, 79] {
            let of = |seed| adversary(number, seed, 4, [96, 54]);
            let (a, b, other) = (of(5), of(5), of(6));
            let positions = |a: &Adversary| a.scene.meshes()[0].positions().to_vec();
            assert_eq!(positions(&a), positions(&b));
            assert_eq!(a.views, b.views);
            assert!(positions(&a) != positions(&other) || a.views != other.views);
        }
    }

    #[test]
    fn corners_of_pixels_are_exact_in_the_first_view() {
        let screen = Screen { size: [480, 270], parallel: false };
        let view = adversary(10, 1, 1, screen.size).views.remove(0);
        for (x, y, w) in [(0.0, 0.0, 1.0), (17.0, 200.0, 4.0), (480.0, 135.0, 8.0)] {
            let p = screen.point([x, y], w);
            assert_eq!(p.as_vec3().as_dvec3(), p);
            let [px, py, _] = view.project_point(p.to_array()).expect("it is in front");
            assert!((px - x).abs() < 1e-9 && (py - y).abs() < 1e-9, "{px} {py}");
        }
    }
}
