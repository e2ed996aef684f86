//! Costs of tests and triangles on the device: the figures that clusters are made for, as `cullet
//! calibrate` keeps them for the reference renderer.

use cullet::{Instance, Mesh, Scene, Transform, View};
use cullet_gpu::{
    DrawArguments, Gpu, GpuError, MeshTriangles, OffScreen, TriangleList, TrianglePass,
    TriangleTest, TriangleView, Triangles,
};
use cullet_mesh::MaskGrid;
use serde_json::{Value, json};
use wgpu::*;

use super::Failure;
use super::timing::{TURNS, fastest, turns};

/// Pixels along the sides of the picture.
const SIDE: u32 = 512;
/// Quads along the side of a sheet that fills the same pixels, however many there are: what grows with them is a triangle's cost.
const QUADS: [u32; 4] = [64, 128, 192, 256];
/// Draws of the sheet of 128 quads.
const DRAWS: [u32; 3] = [16, 1024, 4096];
/// Instances along the side of a field of boxes.
const FIELDS: [u32; 3] = [100, 200, 400];

/// A cost in nanoseconds: from the fastest of all turns, and the least and the most that a third of them gives.
#[derive(Clone, Copy, Debug)]
struct Spread {
    ns: f64,
    low: f64,
    high: f64,
}

/// All of them, and a triangle of a costly material.
pub(crate) struct DeviceCosts {
    named: Vec<(&'static str, Spread)>,
    mask: Spread,
    plane: Spread,
    lit: Spread,
}

/// A sheet drawn by each of some materials, from its front or its back.
#[derive(Clone, Copy, Debug)]
enum Material {
    Rejected,
    Opaque,
    Masked,
    Blended,
    /// Sixteen lights.
    Lit,
}

const MATERIALS: [Material; 5] =
    [Material::Rejected, Material::Opaque, Material::Masked, Material::Blended, Material::Lit];

pub(crate) fn measure(gpu: &Gpu) -> Result<DeviceCosts, Failure> {
    let sheets = Sheets::new(gpu)?;
    let instances = instances(gpu)?;
    let [mask, plane] = triangle_tests(gpu)?;
    let mut of_materials = Vec::new();
    for material in MATERIALS {
        let counts = QUADS.map(|quads| f64::from(quads * quads * 2));
        let times = turns(gpu, QUADS.len(), |i| sheets.draw(gpu, material, i, 1))?;
        of_materials.push(spread(&counts, &times));
    }
    let times = turns(gpu, DRAWS.len(), |i| sheets.draw(gpu, Material::Opaque, 1, DRAWS[i]))?;
    let draw = spread(&DRAWS.map(f64::from), &times);
    let [rejected, opaque, masked, blended, lit] = of_materials[..] else {
        return Err("a cost for each material".into());
    };
    let named = vec![
        ("object_test", instances),
        // A cluster is tested as a box is.
        ("cluster_test", instances),
        ("triangle_test", mask),
        ("rejected_triangle", rejected),
        ("opaque_triangle", opaque),
        ("masked_triangle", masked),
        ("blended_triangle", blended),
        ("draw", draw),
    ];
    Ok(DeviceCosts { named, mask, plane, lit })
}

/// The day in universal time, as 2026-03-09.
fn today() -> String {
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    let days = now.map_or(0, |t| t.as_secs() / 86_400) as u32;
    // Years from 1 March of the year 0, in eras of 400.
    let since = days + 719_468;
    let (era, day) = (since / 146_097, since % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let of_year = day - (365 * year + year / 4 - year / 100);
    let month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month + 2) / 5 + 1;
    let (month, later) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    format!("{:04}-{month:02}-{day:02}", era * 400 + year + later)
}

/// The slope of the line of least squares through milliseconds over counts, in nanoseconds.
fn slope(counts: &[f64], ms: &[f64]) -> f64 {
    let n = counts.len() as f64;
    let (mx, my) = (counts.iter().sum::<f64>() / n, ms.iter().sum::<f64>() / n);
    let xy: f64 = counts.iter().zip(ms).map(|(x, y)| (x - mx) * (y - my)).sum();
    let xx: f64 = counts.iter().map(|x| (x - mx) * (x - mx)).sum();
    xy / xx * 1e6
}

fn spread(counts: &[f64], times: &[Vec<f64>]) -> Spread {
    let of = |turns: std::ops::Range<usize>| {
        let best: Vec<f64> = times.iter().map(|t| fastest(&t[turns.clone()])).collect();
        slope(counts, &best)
    };
    // Where a count costs less than the clock shows, the least that a cost may be.
    let ns = of(0..TURNS).max(1e-3);
    let third = TURNS / 3;
    let thirds = [0, 1, 2].map(|i| of(i * third..(i + 1) * third));
    Spread {
        ns,
        low: thirds.into_iter().fold(ns, f64::min),
        high: thirds.into_iter().fold(ns, f64::max),
    }
}

/// An instance tested against planes and listed, all of them in the view.
fn instances(gpu: &Gpu) -> Result<Spread, Failure> {
    let mut stages = Vec::new();
    let projection = [-1.0, 1.0, -1.0, 1.0, 0.1, 10.0];
    for side in FIELDS {
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(Mesh::new(super::one_sided((
            vec![[0.0; 3], [1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0]],
            vec![0, 1, 2],
        )))?);
        for i in 0..side * side {
            let at = [i % side, i / side].map(|v| f64::from(v) / f64::from(side) * 2.2 - 1.1);
            let place = Transform::from_translation([at[0], at[1], 0.0]);
            scene.add(Instance::new(mesh, place))?;
        }
        scene.commit(&cullet::Culler::default());
        let mut stage = OffScreen::new(&gpu.device, &gpu.queue, &scene, [64, 64])?;
        let view = View::orthographic(
            [0.0, 0.0, 2.0],
            [0.0; 3],
            2.0,
            projection[4],
            projection[5],
            [64, 64],
        )?;
        stage.draw(&gpu.device, &gpu.queue, (&scene, &view), false)?;
        stages.push(stage);
    }
    let times = turns(gpu, stages.len(), |i| {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        stages[i].culling.record_early(&stages[i].passes, &mut encoder);
        gpu.queue.submit([encoder.finish()]);
        Ok(())
    })?;
    Ok(spread(&FIELDS.map(|side| f64::from(side * side)), &times))
}

/// A triangle tested and listed, by its mask and by its plane; half of them are left.
fn triangle_tests(gpu: &Gpu) -> Result<[Spread; 2], Failure> {
    let (device, queue) = (&gpu.device, &gpu.queue);
    let pass = TrianglePass::new(device)?;
    let grid = MaskGrid::new(16).ok_or("a grid of too many cells")?;
    let view = View::perspective([0.0, 0.0, 12.0], [0.0; 3], 0.2, 1.0, 100.0, [SIDE; 2])?;
    let (mut lists, mut counts) = (Vec::new(), Vec::new());
    let mut seen = TriangleView::default();
    for n in [40, 80, 160] {
        let (positions, indices) = cullet_scenes::knobbly_ball(n);
        let triangles = Triangles::new(&positions, &indices, &grid)?;
        let mesh = MeshTriangles::new(device, queue, &triangles)?;
        for test in [TriangleTest::Masks, TriangleTest::Planes] {
            let mut list =
                TriangleList::new(device, queue, &pass, &mesh, DrawArguments::default())?;
            seen.set(&triangles, test, &view, &Transform::IDENTITY);
            list.set(queue, &seen);
            lists.push(list);
        }
        counts.push(triangles.len() as f64);
    }
    let mut times = turns(gpu, lists.len(), |i| {
        let mut encoder = device.create_command_encoder(&Default::default());
        pass.record(&mut encoder, [&lists[i]]);
        queue.submit([encoder.finish()]);
        Ok(())
    })?;
    let planes = [5, 3, 1].map(|i| times.remove(i));
    let planes: Vec<_> = planes.into_iter().rev().collect();
    Ok([spread(&counts, &times), spread(&counts, &planes)])
}

/// Sheets of some numbers of quads on the device, and pipelines for them.
struct Sheets {
    sheets: Vec<(Buffer, Buffer, u32)>,
    pipelines: Vec<RenderPipeline>,
    color: TextureView,
    depth: TextureView,
}

const SHADER: &str = "
    struct Varying { @builtin(position) position: vec4<f32>, @location(0) at: vec2<f32> }
    @vertex fn vs(@location(0) p: vec2<f32>) -> Varying {
        return Varying(vec4<f32>(p, 0.5, 1.0), p);
    }
    @fragment fn flat_one(v: Varying) -> @location(0) vec4<f32> { return vec4<f32>(0.5); }
    @fragment fn holes(v: Varying) -> @location(0) vec4<f32> {
        if fract(v.at.x * 16.0) < 0.25 { discard; }
        return vec4<f32>(0.5);
    }
    @fragment fn lit(v: Varying) -> @location(0) vec4<f32> {
        let normal = normalize(vec3<f32>(v.at, 1.0));
        var sum = 0.0;
        for (var i = 0u; i < 16u; i++) {
            let light = normalize(vec3<f32>(f32(i) - 8.0, 3.0, 4.0) - vec3<f32>(v.at, 0.0));
            sum += pow(max(dot(normal, light), 0.0), 4.0);
        }
        return vec4<f32>(sum);
    }";

impl Sheets {
    fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let device = &gpu.device;
        let upload = |bytes: &[u8], usage| {
            let made = device.create_buffer(&BufferDescriptor {
                label: None,
                size: bytes.len() as u64,
                usage: usage | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            gpu.queue.write_buffer(&made, 0, bytes);
            made
        };
        let sheet = |quads: u32| {
            let at = |i: u32| (f64::from(i) * 2.0 / f64::from(quads) - 1.0) as f32;
            let corners = (0..=quads).flat_map(|y| (0..=quads).map(move |x| (x, y)));
            let positions: Vec<[f32; 2]> = corners.map(|(x, y)| [at(x), at(y)]).collect();
            let mut indices = Vec::new();
            for (y, x) in (0..quads).flat_map(|y| (0..quads).map(move |x| (y, x))) {
                let a = y * (quads + 1) + x;
                let (b, c, d) = (a + 1, a + quads + 1, a + quads + 2);
                indices.extend([a, b, d, a, d, c]);
            }
            let vertices = upload(bytemuck::cast_slice(&positions), BufferUsages::VERTEX);
            let count = indices.len() as u32;
            (vertices, upload(bytemuck::cast_slice(&indices), BufferUsages::INDEX), count)
        };
        let texture = |format| {
            let made = device.create_texture(&TextureDescriptor {
                label: None,
                size: Extent3d { width: SIDE, height: SIDE, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: TextureDimension::D2,
                format,
                usage: TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            });
            made.create_view(&TextureViewDescriptor::default())
        };
        Ok(Self {
            sheets: QUADS.map(sheet).into(),
            pipelines: MATERIALS.map(|material| pipeline(device, material)).into(),
            color: texture(TextureFormat::Rgba8Unorm),
            depth: texture(TextureFormat::Depth32Float),
        })
    }

    /// Draws a sheet in some draws.
    fn draw(
        &self,
        gpu: &Gpu,
        material: Material,
        sheet: usize,
        draws: u32,
    ) -> Result<(), GpuError> {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: None,
            color_attachments: &[Some(RenderPassColorAttachment {
                view: &self.color,
                depth_slice: None,
                resolve_target: None,
                ops: Operations { load: LoadOp::Clear(Color::BLACK), store: StoreOp::Store },
            })],
            depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(Operations { load: LoadOp::Clear(0.0), store: StoreOp::Store }),
                stencil_ops: None,
            }),
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        let (vertices, indices, count) = &self.sheets[sheet];
        pass.set_pipeline(&self.pipelines[material as usize]);
        pass.set_vertex_buffer(0, vertices.slice(..));
        pass.set_index_buffer(indices.slice(..), IndexFormat::Uint32);
        let each = count / draws / 3 * 3;
        for i in 0..draws {
            pass.draw_indexed(i * each..(i + 1) * each, 0, 0..1);
        }
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
        Ok(())
    }
}

fn pipeline(device: &Device, material: Material) -> RenderPipeline {
    let module = device.create_shader_module(ShaderModuleDescriptor {
        label: None,
        source: ShaderSource::Wgsl(SHADER.into()),
    });
    let (fragment, cull, blend) = match material {
        Material::Rejected => ("flat_one", Face::Front, None),
        Material::Opaque => ("flat_one", Face::Back, None),
        Material::Masked => ("holes", Face::Back, None),
        Material::Blended => ("flat_one", Face::Back, Some(BlendState::ALPHA_BLENDING)),
        Material::Lit => ("lit", Face::Back, None),
    };
    let attributes =
        [VertexAttribute { format: VertexFormat::Float32x2, offset: 0, shader_location: 0 }];
    device.create_render_pipeline(&RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: VertexState {
            module: &module,
            entry_point: Some("vs"),
            compilation_options: Default::default(),
            buffers: &[Some(VertexBufferLayout {
                array_stride: 8,
                step_mode: VertexStepMode::Vertex,
                attributes: &attributes,
            })],
        },
        fragment: Some(FragmentState {
            module: &module,
            entry_point: Some(fragment),
            compilation_options: Default::default(),
            targets: &[Some(ColorTargetState {
                format: TextureFormat::Rgba8Unorm,
                blend,
                write_mask: ColorWrites::ALL,
            })],
        }),
        primitive: PrimitiveState { cull_mode: Some(cull), ..PrimitiveState::default() },
        depth_stencil: Some(DepthStencilState {
            format: TextureFormat::Depth32Float,
            depth_write_enabled: Some(blend.is_none()),
            depth_compare: Some(CompareFunction::Greater),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        multiview_mask: None,
        cache: None,
    })
}

impl DeviceCosts {
    fn of(&self, name: &str) -> f64 {
        self.named.iter().find(|(n, _)| *n == name).map_or(f64::NAN, |(_, s)| s.ns)
    }

    /// A mask's test over a triangle drawn.
    pub(crate) fn t_over_r(&self) -> f64 {
        self.mask.ns / self.of("opaque_triangle")
    }

    pub(crate) fn print(&self) {
        println!("costs, ns                      found   from thirds of the turns");
        let more = [("triangle by its plane", self.plane), ("triangle with 16 lights", self.lit)];
        for (name, s) in self.named.iter().chain(&more) {
            println!("{name:26} {:9.3}   {:.3} to {:.3}", s.ns, s.low, s.high);
        }
        let [test, rejected] = ["cluster_test", "rejected_triangle"].map(|name| self.of(name));
        let back = self.mask.ns / rejected;
        println!(
            "t/r of a triangle's mask: {:.3} of one drawn, {back:.3} of one rejected",
            self.t_over_r()
        );
        let cluster = (test + self.of("draw")) / rejected;
        println!(
            "t/r of a cluster: {:.3} bare; {cluster:.1} as clustering takes it, with a draw, of one rejected",
            test / self.of("opaque_triangle")
        );
        for (what, cost) in [
            ("masked", self.of("masked_triangle")),
            ("blended", self.of("blended_triangle")),
            ("16 lights", self.lit.ns),
        ] {
            println!("t/r of a cluster, {what}: {:.3} bare", test / cost);
        }
    }

    /// Writes costs as `cullet calibrate` keeps them, so that `--costs FILE` takes them.
    pub(crate) fn json(&self, device: &str) -> Value {
        let spread = |s: &Spread| json!({"ns": s.ns, "low": s.low, "high": s.high});
        let named: serde_json::Map<_, _> =
            self.named.iter().map(|(name, s)| ((*name).to_owned(), spread(s))).collect();
        json!({
            "schema": 1, "version": env!("CARGO_PKG_VERSION"), "date": today(),
            "machine": device, "renderer": format!("{device}, by bench-gpu masks"),
            "rounds": TURNS, "costs": named,
            "t_over_r": self.of("cluster_test") / self.of("opaque_triangle"),
        })
    }
}
