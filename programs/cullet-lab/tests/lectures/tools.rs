//! Helpers that tests of several subjects share: scenes, views and pictures, and the figures of the
//! book.

use std::collections::BTreeSet;

use cullet::mesh::Part;
use cullet::{
    Culler, Depth, Instance, Mesh, MeshData, Output, Scene, Transform, View, ViewState, Visible,
};
use cullet_draw::{Frame, RenderOptions, Selection, render};
use cullet_io::Model;
use cullet_lab::lecture::{agrees, lectures};
use cullet_scenes::knobbly_ball;
use cullet_scenes::paths::{self, Overrides};
use cullet_testkit::vectors::{cross, multiply};

pub(crate) use cullet_testkit::vectors::{dot, fibonacci};

/// The size of pictures.
pub(crate) const SIZE: [u32; 2] = [320, 200];

/// A vector or a point.
pub(crate) type Vec3 = [f64; 3];

/// Holds the figures of an item's measured sentence against those that a test found, but for those
/// of commands.
pub(crate) fn told(number: usize, found: &[f64]) {
    let figures = lectures().items[number - 1].figures.iter();
    let figures: Vec<&String> = figures.filter(|figure| !figure.contains(" = ")).collect();
    let alike = figures.len() == found.len()
        && figures.iter().zip(found).all(|(figure, found)| agrees(figure, *found));
    assert!(alike, "item {number}: docs/lectures.json has {figures:?}, measured are {found:?}");
}

/// A built-in scene.
pub(crate) fn built(words: &str) -> Model {
    let mut model = cullet_scenes::build(words).expect("a built-in scene");
    model.scene.commit(&Culler::default());
    model
}

/// Views of a scene along a path.
pub(crate) fn views(model: &Model, path: &str, count: usize) -> Vec<View> {
    let overrides = Overrides { depth: Depth::Reversed, ..Overrides::default() };
    let path = path.parse().expect("a path");
    paths::views(model, &path, count, SIZE, &overrides).expect("views")
}

/// Positions and indices as a mesh of one part.
pub(crate) fn data((positions, indices): (Vec<[f32; 3]>, Vec<u32>), two_sided: bool) -> MeshData {
    let triangle_count = (indices.len() / 3) as u32;
    let parts = vec![Part { triangle_count, two_sided, ..Part::default() }];
    MeshData { positions, indices, parts, ..MeshData::default() }
}

/// The closed ball with knobs, of 12·n² one-sided triangles around the origin.
pub(crate) fn knobs(n: u16) -> Mesh {
    Mesh::new(data(knobbly_ball(n), false)).expect("a solid")
}

/// A scene of one mesh.
pub(crate) fn scene_of(mesh: Mesh) -> Scene {
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(mesh);
    scene.add(Instance::new(mesh, Transform::IDENTITY)).expect("one instance");
    scene.commit(&Culler::default());
    scene
}

/// A picture of all triangles, with the layers of each pixel counted.
pub(crate) fn draw(scene: &Scene, view: &View) -> Frame {
    let options = RenderOptions { count_layers: true, ..RenderOptions::default() };
    render(scene, view, Selection::All, &options)
}

/// Slots and original triangles that a picture without culling shows.
pub(crate) fn seen(scene: &Scene, view: &View) -> BTreeSet<(u32, u32)> {
    draw(scene, view).visible().into_iter().map(|id| (id.slot, id.triangle)).collect()
}

/// Slots and original triangles that a culler leaves.
pub(crate) fn left(culler: &Culler, scene: &Scene, view: &View) -> BTreeSet<(u32, u32)> {
    let mut visible = Visible::default();
    let culler = culler.clone().with_output(Output::Triangles);
    culler.cull_one(scene, view, &mut ViewState::default(), &mut visible);
    let of_range = |r: &cullet::draw::TriangleRange| {
        let triangles = &visible.triangles[r.first as usize..][..r.count as usize];
        let original = scene.mesh_at(r.slot, r.level).original_triangle();
        let slot = r.slot;
        triangles.iter().map(move |&t| (slot, original[t as usize]))
    };
    visible.triangle_ranges.iter().flat_map(of_range).collect()
}

/// The corners in the world of a triangle of an instance.
pub(crate) fn placed(scene: &Scene, slot: u32, triangle: u32) -> [Vec3; 3] {
    let matrix = scene.transform(slot).to_matrix();
    scene.mesh(slot).corners(triangle).map(|p| {
        let [x, y, z] = p.map(f64::from);
        let [x, y, z, _] = multiply(&matrix, [x, y, z, 1.0]);
        [x, y, z]
    })
}

/// The corners in the world of all triangles that have an area.
pub(crate) fn triangles(scene: &Scene) -> impl Iterator<Item = (u32, u32, [Vec3; 3])> {
    scene.slots().flat_map(move |slot| {
        let mesh = scene.mesh(slot);
        let drawn = mesh.triangle_count() - mesh.degenerate_count();
        (0..drawn).map(move |t| (slot, t, placed(scene, slot, t)))
    })
}

/// A point in clip space.
pub(crate) fn in_clip(view: &View, [x, y, z]: Vec3) -> [f64; 4] {
    multiply(&view.clip_from_world(), [x, y, z, 1.0])
}

/// a + s·b.
pub(crate) fn along(a: Vec3, s: f64, b: Vec3) -> Vec3 {
    std::array::from_fn(|i| a[i] + s * b[i])
}

/// a − b.
pub(crate) fn minus(a: Vec3, b: Vec3) -> Vec3 {
    along(a, -1.0, b)
}

/// The vector of length 1 in the direction of a.
pub(crate) fn unit(a: Vec3) -> Vec3 {
    a.map(|v| v / dot(a, a).sqrt())
}

/// (b − a) × (c − a).
pub(crate) fn normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    cross(minus(b, a), minus(c, a))
}

/// Per cent of a whole.
pub(crate) fn percent(part: usize, whole: usize) -> f64 {
    part as f64 * 100.0 / whole as f64
}
