//! Two copies of a model on the device, drawn whole or by lists of what a test left.

use cullet::mesh::MeshData;
use cullet::{
    Camera, Depth, Instance, Mesh, Projection, Scene, Transform, View,
    view::{CullFace, FrontFace},
};
use cullet_gpu::{
    Draw, DrawArguments, Gpu, GpuError, Lanes, MeshTriangles, OffScreen, TriangleList,
    TrianglePass, TriangleTest, TriangleView, Triangles, culled_faces, triangles_ref,
};
use cullet_lab::methods::Groups;
use cullet_mesh::MaskGrid;
use wgpu::*;

use super::Failure;

/// Half the distance between the copies, in radii of one, as in the reproduction on the CPU.
const APART: f64 = 1.1;
/// How far away the viewer stands, in radii of the sphere around both: from there masks cull what the paper prints.
const DISTANCE: f64 = 6.0;
/// Pixels of a view.
pub(crate) const SIZE: [u32; 2] = [640, 480];
/// Views, spread over a sphere.
pub(crate) const VIEWS: usize = 4;

/// How the hardware is told to cull.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum State {
    /// Nothing; the test before culls back faces.
    None,
    Back,
    Front,
    /// Back faces of triangles whose fronts are clockwise.
    Winding,
}

impl State {
    pub(crate) const ALL: [Self; 4] = [Self::None, Self::Back, Self::Front, Self::Winding];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Back => "back",
            Self::Front => "front",
            Self::Winding => "winding flipped",
        }
    }

    fn of_hardware(self, view: &View) -> View {
        let mut view = self.of_test(view);
        if self == Self::None {
            view.cull_face = CullFace::None;
        }
        view
    }

    fn of_test(self, view: &View) -> View {
        let mut view = view.clone();
        view.cull_face = if self == Self::Front { CullFace::Front } else { CullFace::Back };
        let clockwise = self == Self::Winding;
        view.front_face =
            if clockwise { FrontFace::Clockwise } else { FrontFace::CounterClockwise };
        view
    }
}

/// Work of a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Way {
    /// Clears the picture.
    Empty,
    /// Draws all triangles; the hardware culls.
    Whole(State),
    /// Draws what a test leaves of a set, by its number.
    Listed(State, usize, TriangleTest),
    /// Makes the lists of such a frame, and draws nothing.
    ListsAlone(usize, TriangleTest),
}

/// The model prepared in one way.
struct Set {
    triangles: Triangles,
    lists: Vec<TriangleList>,
}

/// Two copies of a model.
pub(crate) struct Pair<'a> {
    gpu: &'a Gpu,
    scene: Scene,
    stage: OffScreen,
    draw: Draw,
    slots: Buffer,
    pass: TrianglePass,
    sets: Vec<Set>,
    seen: TriangleView,
    radius: f64,
}

impl<'a> Pair<'a> {
    pub(crate) fn new(gpu: &'a Gpu, data: MeshData) -> Result<Self, Failure> {
        let (device, queue) = (&gpu.device, &gpu.queue);
        let mesh = Mesh::new(data)?;
        let sphere = cullet::bounds::Sphere::from_points(mesh.positions());
        let ([x, y, z], radius) = (sphere.center.map(f64::from), f64::from(sphere.radius));
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(mesh);
        for side in [-1.0, 1.0] {
            let at = [side * APART * radius - x, -y, -z];
            scene.add(Instance::new(mesh, Transform::from_translation(at)))?;
        }
        scene.commit(&cullet::Culler::default());
        let stage = OffScreen::new(device, queue, &scene, SIZE)?;
        let draws = stage.culling.scene().draws(&Lanes::of(&scene));
        let [draw] = draws[..] else { return Err("a model of one draw".into()) };
        let slots = device.create_buffer(&BufferDescriptor {
            label: None,
            size: 8,
            usage: BufferUsages::VERTEX | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        queue.write_buffer(&slots, 0, bytemuck::cast_slice(&[0_u32, 1]));
        let (pass, radius) = (TrianglePass::new(device)?, (APART + 1.0) * radius);
        let seen = TriangleView::default();
        Ok(Self { gpu, scene, stage, draw, slots, pass, sets: Vec::new(), seen, radius })
    }

    /// Triangles of both.
    pub(crate) fn triangles(&self) -> usize {
        2 * self.draw.arguments.index_count as usize / 3
    }

    /// Whether what a back face hides is hidden by a front face too.
    pub(crate) fn is_solid(&self) -> bool {
        cullet_mesh::solid(self.scene.mesh(0)).is_ok()
    }

    /// Prepares the model with so many cells along an edge of the cube of normals, in so many groups; the number of the set.
    pub(crate) fn add(&mut self, cells: u32, groups: usize) -> Result<usize, Failure> {
        let (device, queue) = (&self.gpu.device, &self.gpu.queue);
        let grid = MaskGrid::new(cells).ok_or("a grid of too many cells")?;
        let mesh = self.scene.mesh(0);
        let indices = &mesh.indices()[..self.draw.arguments.index_count as usize];
        let triangles = if groups == 1 {
            Triangles::new(mesh.positions(), indices, &grid)?
        } else {
            let kd = Groups::kd(mesh.positions(), indices, groups);
            let counts: Vec<u32> = kd.ranges().iter().map(|r| r.end - r.start).collect();
            Triangles::with_groups(mesh.positions(), &kd.reorder(indices), &grid, &counts)?
        };
        let on_device = MeshTriangles::new(device, queue, &triangles)?;
        let one = DrawArguments { instance_count: 1, ..self.draw.arguments };
        let list = || TriangleList::new(device, queue, &self.pass, &on_device, one);
        let lists = vec![list()?, list()?];
        self.sets.push(Set { triangles, lists });
        Ok(self.sets.len() - 1)
    }

    /// A view that both copies just fit.
    pub(crate) fn view(&self, number: usize) -> Result<View, Failure> {
        let sine: f64 = 1.0 / (DISTANCE * 0.98);
        let tangent = sine / (1.0 - sine * sine).sqrt();
        let aspect = f64::from(SIZE[0]) / f64::from(SIZE[1]);
        let projection = Projection::Perspective {
            fov_y_radians: 2.0 * tangent.atan(),
            aspect,
            near: (DISTANCE - 1.0) * self.radius * 0.5,
            far: f64::INFINITY,
        };
        let eye = fibonacci(number, VIEWS).map(|v| v * DISTANCE * self.radius);
        let camera = Camera::look_at(eye, [0.0; 3], projection);
        let view = View::new(&camera, Depth::Reversed, SIZE)?;
        self.stage.target.set(&self.gpu.queue, &view);
        Ok(view)
    }

    /// Triangles that a test culls.
    pub(crate) fn culled(&mut self, view: &View, set: usize, test: TriangleTest) -> usize {
        let (own, view) = (&self.sets[set].triangles, State::Back.of_test(view));
        let left = (0..2).map(|slot| {
            self.seen.set(own, test, &view, self.scene.transform(slot));
            triangles_ref(own, &self.seen).len() / 3
        });
        2 * own.len() - left.sum::<usize>()
    }

    /// Prepares a test as a frame does, and hands nothing in.
    pub(crate) fn prepare(&mut self, view: &View, set: usize, test: TriangleTest) {
        for slot in 0..2 {
            self.seen.set(&self.sets[set].triangles, test, view, self.scene.transform(slot));
        }
    }

    /// Draws a frame, the tests and all that they take included.
    pub(crate) fn frame(&mut self, view: &View, way: Way) {
        let (device, queue) = (&self.gpu.device, &self.gpu.queue);
        let mut encoder = device.create_command_encoder(&Default::default());
        if let Way::Listed(_, set, test) | Way::ListsAlone(set, test) = way {
            let state = if let Way::Listed(state, ..) = way { state } else { State::Back };
            let own = &mut self.sets[set];
            let of_test = state.of_test(view);
            for (slot, list) in (0..).zip(&mut own.lists) {
                self.seen.set(&own.triangles, test, &of_test, self.scene.transform(slot));
                list.set(queue, &self.seen);
            }
            self.pass.record(&mut encoder, &own.lists);
        }
        let ids = &self.stage.ids;
        let on_device = self.stage.culling.scene();
        let state = match way {
            Way::Empty | Way::ListsAlone(..) => None,
            Way::Whole(state) | Way::Listed(state, ..) => Some(state),
        };
        if !matches!(way, Way::ListsAlone(..)) {
            let mut pass = ids.begin(&mut encoder, &self.stage.target, true);
            let faces = state.and_then(|s| culled_faces(&s.of_hardware(view), &self.draw));
            if let Some(faces) = faces {
                pass.set_pipeline(ids.pipeline(faces, false));
                pass.set_vertex_buffer(0, on_device.vertices().slice(..));
                pass.set_vertex_buffer(1, self.slots.slice(..));
                if let Way::Listed(_, set, _) = way {
                    for (slot, list) in (0..).zip(&self.sets[set].lists) {
                        pass.set_vertex_buffer(1, self.slots.slice(slot * 4..));
                        list.draw(&mut pass);
                    }
                } else {
                    pass.set_index_buffer(on_device.indices().slice(..), IndexFormat::Uint32);
                    pass.draw_indexed(0..self.draw.arguments.index_count, 0, 0..2);
                }
            }
        }
        queue.submit([encoder.finish()]);
    }

    /// Numbers and depths of the last frame.
    pub(crate) fn picture(&self) -> Result<[Vec<u8>; 2], GpuError> {
        let target = &self.stage.target;
        Ok([self.texels(target.ids())?, self.texels(target.depth())?])
    }

    fn texels(&self, texture: &Texture) -> Result<Vec<u8>, GpuError> {
        // A row of 640 is a multiple of 256 bytes.
        let [width, height] = SIZE;
        let bytes = u64::from(width * height * 4);
        let to = self.gpu.device.create_buffer(&BufferDescriptor {
            label: None,
            size: bytes,
            usage: BufferUsages::COPY_DST | BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let layout = TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(width * 4),
            rows_per_image: None,
        };
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let size = Extent3d { width, height, depth_or_array_layers: 1 };
        let into = TexelCopyBufferInfo { buffer: &to, layout };
        encoder.copy_texture_to_buffer(texture.as_image_copy(), into, size);
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.read(&to, bytes)
    }
}

/// Direction `i` of `count`, spread evenly over a sphere.
fn fibonacci(i: usize, count: usize) -> [f64; 3] {
    // The golden angle.
    const TURN: f64 = 2.399_963_229_728_653;
    let z = (2 * i + 1) as f64 / count as f64 - 1.0;
    let (sin, cos) = (i as f64 * TURN).sin_cos();
    let r = (1.0 - z * z).sqrt();
    [r * cos, r * sin, z]
}
