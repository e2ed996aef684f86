//! Triangles tested one by one: the same lists from every device, and the pictures that hardware makes without.

use crate::common;

use cullet::cull::backface::ObjectEye;
use cullet::mesh::{MeshData, Part};
use cullet::{
    Camera, Depth, Instance, Mesh, Projection, Scene, Transform, View,
    view::{CullFace, FrontFace},
};
use cullet_gpu::{
    Draw, DrawArguments, EyeUniform, Gpu, GpuError, Lanes, MeshTriangles, OffScreen, Place, Tier,
    TriangleList, TrianglePass, TriangleTest, TriangleView, Triangles, culled_faces, triangles_ref,
};
use cullet_mesh::MaskGrid;
use cullet_scenes::knobbly_ball;
use cullet_testkit::Rng;
use glam::{DMat4, DVec3};
use wgpu::{Buffer, BufferDescriptor, BufferUsages};

use common::{gpu, texels};

const TESTS: [TriangleTest; 2] = [TriangleTest::Masks, TriangleTest::Planes];

fn grid() -> MaskGrid {
    MaskGrid::new(16).unwrap()
}

/// Some triangles anywhere, of all shapes and sizes: some without area, some slivers, some not finite.
fn any_triangles(rng: &mut Rng, count: usize) -> (Vec<[f32; 3]>, Vec<u32>) {
    let mut positions = Vec::new();
    // Of what is not finite, or of all sizes, little is certain; the largest meshes are neither.
    let plain = rng.chance(0.7) || count > 1000;
    let decades = if plain { 1 } else { 5 };
    for i in 0..count {
        let at = rng.vector(2.0);
        let size = 10f64.powi(-(rng.below(decades) as i32));
        let mut corner = || {
            let by = rng.vector(size);
            [0, 1, 2].map(|k| (at[k] + by[k]) as f32)
        };
        let [a, b, mut c] = [corner(), corner(), corner()];
        match i % 23 {
            7 => c = b,
            8 => c = [0, 1, 2].map(|k| (a[k] + b[k]) / 2.0),
            9 if !plain && i % 2 == 0 => c[1] = f32::NAN,
            10 if !plain => c[2] = f32::INFINITY,
            _ => {}
        }
        positions.extend([a, b, c]);
    }
    (positions, (0..count as u32 * 3).collect())
}

/// Indices that a device lists.
fn listed(gpu: &Gpu, pass: &TrianglePass, list: &TriangleList) -> Vec<u32> {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    pass.record(&mut encoder, [list]);
    gpu.queue.submit([encoder.finish()]);
    let read = gpu.read(list.arguments(), size_of::<DrawArguments>() as u64).unwrap();
    let arguments: Vec<DrawArguments> = bytemuck::pod_collect_to_vec(&read);
    let bytes = u64::from(arguments[0].index_count) * 4;
    bytemuck::pod_collect_to_vec(&gpu.read(list.list(), bytes).unwrap())
}

fn any_transform(rng: &mut Rng, scale: f64) -> Transform {
    let mut linear = [0, 1, 2].map(|_| rng.vector(scale).map(|v| v as f32));
    let mut translation = rng.vector(5.0);
    match rng.below(12) {
        0 => linear[1] = linear[0],
        1 => linear[2][0] = f32::NAN,
        2 => linear = [[0.0; 3]; 3],
        3 => translation = rng.vector(1e7),
        4 => linear = linear.map(|c| c.map(|v| v * 1e-20)),
        _ => {}
    }
    Transform { linear, translation }
}

fn any_view(rng: &mut Rng, size: [u32; 2]) -> View {
    let eye = rng.vector(12.0);
    let target = rng.vector(2.0);
    let projection = match rng.below(3) {
        0 => Projection::Orthographic {
            left: -4.0,
            right: 5.0,
            bottom: -3.0,
            top: 4.0,
            near: 0.1,
            far: 100.0,
        },
        _ => Projection::Perspective {
            fov_y_radians: 0.2 + rng.unit() * 1.5,
            aspect: f64::from(size[0]) / f64::from(size[1]),
            near: 0.05,
            far: f64::INFINITY,
        },
    };
    let mut view =
        View::new(&Camera::look_at(eye, target, projection), Depth::Reversed, size).unwrap();
    view.cull_face =
        [CullFace::Back, CullFace::Front, CullFace::Back, CullFace::None][rng.below(4) as usize];
    view.front_face = [FrontFace::CounterClockwise, FrontFace::Clockwise][rng.below(2) as usize];
    view
}

#[test]
fn lists_are_those_of_the_oracle_to_the_byte() {
    let Some(gpu) = gpu(Tier::Compute) else { return };
    let (device, queue) = (&gpu.device, &gpu.queue);
    let pass = TrianglePass::new(device).unwrap();
    let mut rng = Rng(3);
    let (mut culled, mut all) = ([0, 0], 0);
    let mut view = TriangleView::default();
    for count in [0, 1, 2, 255, 256, 257, 511, 700, 5000, 70_001] {
        let (positions, indices) = any_triangles(&mut rng, count);
        for split in [1, 3, 40] {
            let mut groups: Vec<u32> =
                (1..split).map(|_| rng.below(count as u64 / split + 1) as u32).collect();
            groups.push(count as u32 - groups.iter().sum::<u32>());
            let grid = MaskGrid::new(1 + rng.below(18) as u32).unwrap();
            let triangles = Triangles::with_groups(&positions, &indices, &grid, &groups).unwrap();
            assert_eq!((triangles.len(), triangles.groups().len()), (count, groups.len()));
            let mesh = MeshTriangles::new(device, queue, &triangles).unwrap();
            let draw = DrawArguments { instance_count: 1, ..DrawArguments::default() };
            let mut list = TriangleList::new(device, queue, &pass, &mesh, draw).unwrap();
            for _ in 0..8 {
                let seen = (any_view(&mut rng, [1280, 720]), any_transform(&mut rng, 0.7));
                for (test, culled) in TESTS.into_iter().zip(&mut culled) {
                    view.set(&triangles, test, &seen.0, &seen.1);
                    list.set(queue, &view);
                    let expected = triangles_ref(&triangles, &view);
                    assert!(listed(gpu, &pass, &list) == expected, "{count}, {test:?}, {seen:?}");
                    *culled += count - expected.len() / 3;
                }
                all += count;
            }
        }
    }
    println!("{culled:?} of {all}");
    // Of which one in 23 has two corners at one place.
    assert!(culled.iter().all(|culled| culled * 8 > all), "{culled:?} of {all}");
}

/// The area of a triangle on the screen in units of a device that works in f32 and snaps corners to 1/256 of a pixel; positive where
/// it is counter-clockwise. `None` where a corner is not before the eye. With `fused` it multiplies and adds in one step.
fn area_on_screen(
    (view, transform): (&View, &Transform),
    corners: &[[f32; 3]; 3],
    fused: bool,
) -> Option<i128> {
    let add = |a: f32, b: f32, c: f32| if fused { a.mul_add(b, c) } else { a * b + c };
    let (eye, place) = (EyeUniform::new(view), Place::new(transform));
    let mut points = [[0_i128; 2]; 3];
    for (corner, point) in corners.iter().zip(&mut points) {
        let mut world = [0.0; 3];
        for k in 0..3 {
            let row = place.rows[k];
            let offset = (row[3] - eye.high[k]) + (place.low[k] - eye.low[k]);
            let turned = add(row[2], corner[2], add(row[1], corner[1], row[0] * corner[0]));
            world[k] = turned + offset;
        }
        let clip = [0, 1, 3].map(|r| {
            let c = |k: usize| eye.clip[k][r];
            add(c(2), world[2], add(c(1), world[1], add(c(0), world[0], c(3))))
        });
        if clip[2].is_nan() || clip[2] <= 0.0 {
            return None;
        }
        for k in 0..2 {
            let side = view.viewport()[k] as f32;
            let px = (clip[k] / clip[2]) * (side / 2.0) + side / 2.0;
            point[k] = i128::from((f64::from(px) * 256.0).round() as i64);
        }
    }
    let [a, b, c] = points;
    Some((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
}

#[test]
fn what_is_culled_no_device_draws_however_it_rounds() {
    let mut rng = Rng(4);
    let (mut culled, mut exact, mut flipped) = ([0, 0], 0, 0);
    let mut seen_by = TriangleView::default();
    for round in 0..200 {
        // Near each other, so that their heights are alike, as those of a mesh are; in half of all rounds of all shapes.
        let (positions, indices) = if round % 2 == 0 {
            let (positions, indices) = knobbly_ball(8 + rng.below(16) as u16);
            (positions, indices)
        } else {
            any_triangles(&mut rng, 600)
        };
        let triangles = Triangles::new(&positions, &indices, &grid()).unwrap();
        let size = [1 + rng.below(1500) as u32, 1 + rng.below(900) as u32];
        let (view, transform) = (any_view(&mut rng, size), any_transform(&mut rng, 1.5));
        let eye = ObjectEye::of_view(&view, &transform);
        let side = match (view.cull_face, view.front_face, view.is_mirrored()) {
            (CullFace::None, ..) => 0,
            (CullFace::Back, FrontFace::CounterClockwise, false)
            | (CullFace::Front, FrontFace::Clockwise, false) => -1,
            _ => 1,
        } * if transform.determinant() < 0.0 { -1 } else { 1 };
        for (test, culled) in TESTS.into_iter().zip(&mut culled) {
            seen_by.set(&triangles, test, &view, &transform);
            for (i, t) in indices.as_chunks::<3>().0.iter().enumerate() {
                let corners = t.map(|v| positions[v as usize]);
                let [a, b, c] = corners;
                let is_culled = seen_by.culls(&triangles, i, 0);
                if a == b || b == c || c == a {
                    assert!(is_culled, "{test:?}: no area");
                    continue;
                }
                let back = eye.culls(&corners);
                *culled += usize::from(is_culled);
                exact += usize::from(back && test == TriangleTest::Masks);
                assert!(
                    back || !is_culled,
                    "{test:?}, round {round}: {corners:?} {view:?} {transform:?} {:?}",
                    seen_by.planes()
                );
                for fused in [false, true] {
                    let Some(area) = area_on_screen((&view, &transform), &corners, fused) else {
                        continue;
                    };
                    let drawn = area.signum() * side < 0;
                    flipped += usize::from(back && drawn);
                    assert!(!(is_culled && drawn), "{test:?}, round {round}: {corners:?}, {area}");
                }
            }
        }
    }
    // The exact sides alone would not do.
    assert!(flipped > 100, "{flipped}");
    println!("{culled:?} of {exact}, {flipped} turned over by rounding");
    assert!(culled[0] * 20 > exact * 11 && culled[1] * 20 > exact * 13, "{culled:?} of {exact}");
}

/// A scene of one mesh, drawn whole by its buckets, or by lists of what a test left of each instance.
struct Stage<'a> {
    gpu: &'a Gpu,
    pass: TrianglePass,
    all: OffScreen,
    triangles: Triangles,
    /// Draw and list of each slot.
    lists: Vec<(Draw, TriangleList)>,
    slots: Buffer,
}

impl<'a> Stage<'a> {
    fn new(gpu: &'a Gpu, scene: &Scene) -> Self {
        let (device, queue) = (&gpu.device, &gpu.queue);
        let pass = TrianglePass::new(device).unwrap();
        let all = OffScreen::new(device, queue, scene, [1, 1]).unwrap();
        let lanes = Lanes::of(scene);
        let draws = all.culling.scene().draws(&lanes);
        let mesh = scene.mesh(0);
        let indices = &mesh.indices()[..draws[0].arguments.index_count as usize];
        let triangles = Triangles::new(mesh.positions(), indices, &grid()).unwrap();
        let on_device = MeshTriangles::new(device, queue, &triangles).unwrap();
        let mut lists = Vec::new();
        for slot in scene.slots() {
            let mirrored = scene.transform(slot).is_mirrored();
            let draw = draws.iter().find(|draw| draw.kind.mirrored == mirrored).unwrap();
            let one = DrawArguments { instance_count: 1, ..draw.arguments };
            let list = TriangleList::new(device, queue, &pass, &on_device, one).unwrap();
            lists.push((*draw, list));
        }
        let numbers: Vec<u32> = scene.slots().collect();
        let slots = device.create_buffer(&BufferDescriptor {
            label: None,
            size: numbers.len() as u64 * 4,
            usage: BufferUsages::VERTEX | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        queue.write_buffer(&slots, 0, bytemuck::cast_slice(&numbers));
        Self { gpu, pass, all, triangles, lists, slots }
    }

    fn picture(&self, size: [u32; 2]) -> (Vec<u32>, Vec<u32>) {
        let of = |texture| texels(self.gpu, texture, 0, size);
        (of(self.all.target.ids()), of(self.all.target.depth()))
    }

    /// The picture of a view by lists, and how many triangles were drawn for it.
    fn draw(
        &mut self,
        scene: &Scene,
        view: &View,
        test: TriangleTest,
    ) -> ((Vec<u32>, Vec<u32>), usize) {
        let (queue, ids) = (&self.gpu.queue, &self.all.ids);
        let (mut seen, mut left) = (TriangleView::default(), 0);
        for (slot, (_, list)) in (0..).zip(&mut self.lists) {
            seen.set(&self.triangles, test, view, scene.transform(slot));
            list.set(queue, &seen);
            left += triangles_ref(&self.triangles, &seen).len() / 3;
        }
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        self.pass.record(&mut encoder, self.lists.iter().map(|(_, list)| list));
        let mut pass = ids.begin(&mut encoder, &self.all.target, true);
        pass.set_vertex_buffer(0, self.all.culling.scene().vertices().slice(..));
        for (slot, (draw, list)) in (0..).zip(&self.lists) {
            if let Some(faces) = culled_faces(view, draw) {
                pass.set_pipeline(ids.pipeline(faces, false));
                pass.set_vertex_buffer(1, self.slots.slice(slot * 4..));
                list.draw(&mut pass);
            }
        }
        drop(pass);
        queue.submit([encoder.finish()]);
        (self.picture(view.viewport()), left)
    }
}

/// Views from everywhere: far and near, half off the screen, from within, along parallel lines, of every side, mirrored.
fn views_of_a_pair(rng: &mut Rng) -> Vec<View> {
    let mut views = Vec::new();
    for step in 0..60 {
        let far = [14.0, 6.0, 3.0, 1.6, 0.2][step % 5];
        let direction = rng.direction();
        let eye = direction.map(|v| v * far);
        let target = [0, 1, 2].map(|_| rng.signed() * if step % 3 == 0 { 0.0 } else { 2.0 });
        let size = [[640, 480], [333, 251], [64, 512], [1, 1], [17, 9]][(step / 5) % 5];
        let aspect = f64::from(size[0]) / f64::from(size[1]);
        let projection = if step % 7 == 6 {
            let (right, top) = (3.0 * aspect, 3.0);
            Projection::Orthographic {
                left: -right,
                right,
                bottom: -top,
                top,
                near: 0.1,
                far: 40.0,
            }
        } else {
            let fov_y_radians = if far > 4.0 { 0.5 } else { 1.2 };
            Projection::Perspective { fov_y_radians, aspect, near: 0.05, far: f64::INFINITY }
        };
        let camera = Camera::look_at(eye, target, projection);
        let mut view = View::new(&camera, Depth::Reversed, size).unwrap();
        if step % 11 == 10 {
            let m = DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
            let clip = (m * DMat4::from_cols_array(&view.clip_from_world())).to_cols_array();
            view = View::from_matrix(clip, Depth::Reversed, size).unwrap();
        }
        view.cull_face = [CullFace::Back, CullFace::Back, CullFace::Front][step % 3];
        view.front_face =
            [FrontFace::CounterClockwise, FrontFace::Clockwise][usize::from(step % 4 == 3)];
        views.push(view);
    }
    views
}

#[test]
fn pictures_are_those_of_the_hardware_alone() {
    let Some(gpu) = gpu(Tier::Pyramid) else { return };
    let (positions, indices) = knobbly_ball(40);
    let part = Part { triangle_count: (indices.len() / 3) as u32, ..Part::default() };
    let data = MeshData { positions, indices, parts: vec![part], ..MeshData::default() };
    let mut scene = Scene::new();
    let mesh = scene.add_mesh(Mesh::new(data).unwrap());
    let turned = [[0.8, 0.3, 0.0], [-0.3, 0.8, 0.2], [0.1, 0.0, 0.6]];
    let mirrored = [[-0.9, 0.2, 0.0], [0.2, 0.9, 0.1], [0.0, 0.3, 1.0]];
    for (linear, x) in [(turned, -1.1), (mirrored, 1.1)] {
        scene.add(Instance::new(mesh, Transform { linear, translation: [x, 0.0, 0.0] })).unwrap();
    }
    scene.commit(&cullet::Culler::default());
    let mut stage = Stage::new(gpu, &scene);
    let all = 2 * stage.triangles.len();
    let (mut drawn, mut pixels, mut views) = ([0, 0], 0, 0);
    for view in views_of_a_pair(&mut Rng(7)) {
        stage.all.draw(&gpu.device, &gpu.queue, (&scene, &view), false).unwrap();
        let expected = stage.picture(view.viewport());
        pixels += expected.0.iter().filter(|id| **id > 0).count();
        views += 1;
        for (test, drawn) in TESTS.into_iter().zip(&mut drawn) {
            let (found, left) = stage.draw(&scene, &view, test);
            let ids = expected.0.iter().zip(&found.0).filter(|(a, b)| a != b).count();
            let depths = expected.1.iter().zip(&found.1).filter(|(a, b)| a != b).count();
            assert_eq!((ids, depths), (0, 0), "{test:?}, {view:?}");
            *drawn += left;
        }
    }
    println!("{drawn:?} of {} drawn, {pixels} pixels", all * views);
    assert!(pixels > 1_000_000, "{pixels}");
    assert!(drawn[0] * 10 < all * views * 9 && drawn[1] * 10 < all * views * 8, "{drawn:?}");
}

#[test]
fn what_is_not_of_whole_triangles_is_refused_in_numbers() {
    let positions = [[0.0; 3]; 3];
    let told = |indices: &[u32], groups: &[u32]| {
        Triangles::with_groups(&positions, indices, &grid(), groups).map(|_| ()).unwrap_err()
    };
    assert!(matches!(told(&[0, 1, 3], &[1]), GpuError::Index { index: 3, vertices: 3 }));
    assert!(matches!(told(&[0, 1], &[0]), GpuError::Groups { indices: 2, grouped: 0 }));
    assert!(matches!(told(&[0, 1, 2], &[1, 1]), GpuError::Groups { indices: 3, grouped: 2 }));
    let many = [u32::MAX; 4];
    assert!(told(&[0, 1, 2], &many).to_string().contains("17179869180 triangles"));
}
