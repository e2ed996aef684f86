//! Costs and savings of culling on the device, in ratios of one run.
//!
//! `cargo xtask bench-gpu`; `CULLET_DATA` names a folder with `intel-castle/intel-castle.glb`, else that row is left out.
//! `--json PATH` writes the rows there too, and `--within SECONDS` leaves out parts that would begin later.

use std::path::PathBuf;
use std::sync::{Mutex, OnceLock};
use std::time::{Duration, Instant};

use cullet::{Depth, Instance, Mesh, Projection, Scene, Transform, View};
use cullet_gpu::{DrawMode, Gpu, GpuError, OffScreen, Phase, Settings, Tier};
use cullet_scenes::paths::{Overrides, PathSpec, views};
use cullet_testkit::steps::Balls;
use wgpu::*;

type Failure = Box<dyn std::error::Error>;

/// Frames of each kind, of which the fastest counts: what else the machine does only adds.
const FRAMES: usize = 9;

/// When turns end that are not the first of their kind.
static END: OnceLock<Instant> = OnceLock::new();

/// The rows that were printed.
static ROWS: Mutex<Vec<(String, f64)>> = Mutex::new(Vec::new());

fn is_over() -> bool {
    END.get().is_some_and(|end| Instant::now() >= *end)
}

/// Returns the value of an option of the command line.
fn option(name: &str) -> Option<String> {
    std::env::args().skip_while(|arg| arg != name).nth(1)
}

fn main() -> Result<(), Failure> {
    let began = Instant::now();
    if let Some(seconds) = option("--within") {
        let _ = END.set(began + Duration::from_secs(seconds.parse()?));
    }
    let gpu = match Gpu::open(Tier::Pyramid) {
        Ok(gpu) => gpu,
        Err(why @ GpuError::NoAdapter { .. }) => {
            println!("not measured: {why}");
            return Ok(());
        }
        Err(why) => return Err(why.into()),
    };
    let info = gpu.adapter.get_info();
    println!("{} ({:?})", info.name, info.backend);
    println!("{:44} {:>9} {:>7}", "what", "found", "goal");
    measure(&gpu)?;
    let Some(path) = option("--json") else { return Ok(()) };
    let rows = ROWS.lock().map_err(|e| e.to_string())?;
    let record = serde_json::json!({
        "adapter": info.name,
        "backend": info.backend.to_str(),
        "driver": format!("{} {}", info.driver, info.driver_info).trim(),
        "software": info.device_type == DeviceType::Cpu,
        "seconds": began.elapsed().as_secs(),
        "complete": !is_over(),
        "rows": *rows,
    });
    Ok(std::fs::write(path, record.to_string())?)
}

/// Each part, as long as there is time.
fn measure(gpu: &Gpu) -> Result<(), Failure> {
    many_draws(gpu)?;
    levels(gpu)?;
    million(gpu)?;
    let city = cullet_scenes::build("city")?;
    frames(gpu, "city, street", &city, DrawMode::of(&gpu.device, &city.scene))?;
    match castle() {
        Some(path) => {
            let castle = cullet_maps::load(&path, &Default::default())?;
            for mode in [DrawMode::Clusters, DrawMode::Counted] {
                if mode.is_offered(&gpu.device) {
                    frames(gpu, &format!("castle, {mode:?}"), &castle, mode)?;
                }
            }
        }
        None => println!("castle: CULLET_DATA names no folder with it"),
    }
    Ok(())
}

fn castle() -> Option<PathBuf> {
    let beside = || concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data").into();
    let folder = std::env::var_os("CULLET_DATA").unwrap_or_else(beside);
    let path = PathBuf::from(folder).join("intel-castle/intel-castle.glb");
    path.exists().then_some(path)
}

fn row(what: &str, found: f64, goal: &str) {
    println!("{what:44} {found:9.4} {goal:>7}");
    if let Ok(mut rows) = ROWS.lock() {
        rows.push((what.to_owned(), found));
    }
}

/// Milliseconds of the fastest of some turns of each of some works, one after the other; the first turn is not counted.
fn fastest<const N: usize>(
    gpu: &Gpu,
    mut works: [&mut dyn FnMut() -> Result<(), GpuError>; N],
) -> Result<[f64; N], GpuError> {
    let mut best = [f64::INFINITY; N];
    for turn in 0..=FRAMES {
        if turn > 1 && is_over() {
            break;
        }
        for (work, best) in works.iter_mut().zip(&mut best) {
            gpu.finish()?;
            let began = Instant::now();
            work()?;
            gpu.finish()?;
            let took = began.elapsed().as_secs_f64() * 1e3;
            // The first makes what is made once.
            if turn > 0 {
                *best = best.min(took);
            }
        }
    }
    Ok(best)
}

/// Frames of a walk with occlusion culling over the same without, and the share of the late phase where nothing is new.
fn frames(gpu: &Gpu, name: &str, model: &cullet_io::Model, mode: DrawMode) -> Result<(), Failure> {
    let size = [1280, 720];
    let (device, queue, scene) = (&gpu.device, &gpu.queue, &model.scene);
    let all = views(model, &PathSpec::Walk, 8, size, &Overrides::default())?;
    let mut stage = OffScreen::with_mode(device, queue, scene, size, mode)?;
    let mut without = OffScreen::with_mode(device, queue, scene, size, mode)?;
    without.culling.settings.backfaces = false;
    let mut with_backs = OffScreen::with_mode(device, queue, scene, size, mode)?;
    with_backs.culling.settings.backfaces = false;
    let (mut sum, mut late, mut same, mut done) = ([0.0; 3], [0.0; 2], true, 0);
    for view in &all {
        if is_over() {
            break;
        }
        done += 1;
        let on = (scene, view);
        let mut culled = || stage.draw(device, queue, on, true);
        let mut plain = || without.draw(device, queue, on, false);
        let mut backs = || with_backs.draw(device, queue, on, true);
        let [a, b, c] = fastest(gpu, [&mut culled, &mut plain, &mut backs])?;
        sum = [sum[0] + a, sum[1] + b, sum[2] + c];
        let pixels = |of: &OffScreen| picture(gpu, of.target.ids(), size);
        same &= pixels(&stage)? == pixels(&without)?;
        // The same frame without its second phase.
        let early = |with_late: bool| {
            let mut encoder = device.create_command_encoder(&Default::default());
            if with_late {
                stage.record(&mut encoder, view, true);
            } else {
                let drawn = (&stage.culling, view);
                stage.culling.record_early(&stage.passes, &mut encoder);
                stage.ids.draw(&mut encoder, &stage.target, drawn, &[Phase::Early], true);
            }
            queue.submit([encoder.finish()]);
            Ok(())
        };
        let [whole, part] = fastest(gpu, [&mut || early(true), &mut || early(false)])?;
        late = [late[0] + whole, late[1] + part];
    }
    assert!(same, "{name}: the pictures differ");
    if done < all.len() {
        println!("{name}: left out after {done} of {} views, for the time is over", all.len());
        return Ok(());
    }
    let took = sum[1] / all.len() as f64;
    println!("{name}: {took:.2} ms a frame without occlusion culling; {mode:?}");
    row(&format!("{name}: frame with over without"), sum[0] / sum[1], "0.33");
    if mode == DrawMode::Clusters {
        row(&format!("{name}: the same with clusters' backs"), sum[2] / sum[1], "");
    }
    row(&format!("{name}: late phase over frame"), 1.0 - late[1] / late[0], "0.05");
    Ok(())
}

/// Frames by levels of detail over those of everything in full.
fn levels(gpu: &Gpu) -> Result<(), Failure> {
    let (device, queue, size) = (&gpu.device, &gpu.queue, [1280, 720]);
    if gpu.tier() < Tier::MultiDraw {
        println!("levels: the device does not draw clusters");
        return Ok(());
    }
    let mut scene = Scene::new();
    let balls = Balls::new(&[64, 32, 16, 8, 4], 1.0).add_to(&mut scene);
    for i in 0..100 {
        let at = [f64::from(i % 10) * 3.0 - 15.0, 0.0, -f64::from(i / 10) * 3.0];
        scene.add(Instance::new(balls, Transform::from_translation(at)))?;
    }
    scene.commit(&cullet::Culler::default());
    let projection =
        Projection::Perspective { fov_y_radians: 1.0, aspect: 1.78, near: 0.1, far: f64::INFINITY };
    let camera = cullet::Camera::look_at([0.0, 15.0, 30.0], [0.0, 0.0, -15.0], projection);
    let view = View::new(&camera, Depth::Reversed, size)?;
    let stage = || OffScreen::with_mode(device, queue, &scene, size, DrawMode::Clusters);
    let (mut coarse, mut full) = (stage()?, stage()?);
    coarse.culling.settings = Settings { level_px: 1.0, ..Settings::default() };
    let mut coarse = || coarse.draw(device, queue, (&scene, &view), true);
    let mut full = || full.draw(device, queue, (&scene, &view), true);
    let [a, b] = fastest(gpu, [&mut coarse, &mut full])?;
    row("balls of 16,128 triangles: levels at a pixel", a / b, "");
    Ok(())
}

/// The numbers of a picture.
fn picture(gpu: &Gpu, texture: &Texture, [width, height]: [u32; 2]) -> Result<Vec<u8>, GpuError> {
    let row = (width * 4).next_multiple_of(COPY_BYTES_PER_ROW_ALIGNMENT);
    let bytes = u64::from(row * height);
    let to = buffer(gpu, bytes, BufferUsages::COPY_DST | BufferUsages::COPY_SRC);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let layout =
        TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    let size = Extent3d { width, height, depth_or_array_layers: 1 };
    let to_buffer = TexelCopyBufferInfo { buffer: &to, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), to_buffer, size);
    gpu.queue.submit([encoder.finish()]);
    gpu.read(&to, bytes)
}

fn buffer(gpu: &Gpu, size: u64, usage: BufferUsages) -> Buffer {
    let label = None;
    gpu.device.create_buffer(&BufferDescriptor { label, size, usage, mapped_at_creation: false })
}

/// Triangles in rows, one in a hundred of them in the second layer too, and a view from above of all of them.
fn rows(side: u32) -> Result<(Scene, View), Failure> {
    let mut scene = Scene::new();
    let positions = [[-0.4, -0.4, 0.0], [0.4, -0.4, 0.0], [0.0, 0.4, 0.0]].to_vec();
    let data = cullet::mesh::MeshData { positions, indices: vec![0, 1, 2], ..Default::default() };
    let mesh = scene.add_mesh(Mesh::new(data)?);
    for i in 0..side * side {
        let at = [f64::from(i % side), f64::from(i / side), 0.0];
        let mut instance = Instance::new(mesh, Transform::from_translation(at));
        instance.layers = if i % 100 == 0 { 3 } else { 1 };
        scene.add(instance)?;
    }
    scene.commit(&cullet::Culler::default());
    let half = f64::from(side) / 2.0;
    let projection = Projection::Orthographic {
        left: -half,
        right: half,
        bottom: -half,
        top: half,
        near: 0.0,
        far: 100.0,
    };
    let camera = cullet::Camera::look_at([half, half, 50.0], [half, half, 0.0], projection);
    Ok((scene, View::new(&camera, Depth::Reversed, [512, 512])?))
}

/// Passes of a million instances, all of them in the view, over reading as many bytes as they read and write; and what is uploaded when
/// a tenth of them moved.
fn million(gpu: &Gpu) -> Result<(), Failure> {
    const SIDE: u32 = 1000;
    let (device, queue) = (&gpu.device, &gpu.queue);
    let (mut scene, view) = rows(SIDE)?;
    let mut stage = OffScreen::new(device, queue, &scene, view.viewport())?;
    stage.draw(device, queue, (&scene, &view), true)?;
    let n = f64::from(SIDE * SIDE);
    // Boxes, bits, lanes twice, bits of lanes twice, slots.
    let early_bytes = n * (16.0 + 0.25 + 8.0 + 8.0 + 0.25 + 4.0);
    let mut early = || {
        let mut encoder = device.create_command_encoder(&Default::default());
        stage.culling.record_early(&stage.passes, &mut encoder);
        queue.submit([encoder.finish()]);
        Ok(())
    };
    let stream = Stream::new(gpu);
    let mut read = || {
        stream.run(gpu);
        Ok(())
    };
    let [took, streamed] = fastest(gpu, [&mut early, &mut read])?;
    let rate = Stream::BYTES as f64 / streamed;
    println!("a million instances: {took:.2} ms, {:.1} GB/s by streaming", rate / 1e6);
    row("a million instances: passes over streaming", took * rate / early_bytes, "2.5");
    let moved: Vec<_> = (0..SIDE * SIDE / 10).filter_map(|i| scene.handle(i)).collect();
    for handle in &moved {
        let mut t = *scene.transform(scene.slot(*handle)?);
        t.translation[2] += 0.125;
        scene.set_transform(*handle, t)?;
    }
    scene.commit(&cullet::Culler::default());
    stage.follow(device, queue, &scene)?;
    let whole = n * f64::from(16 + 64);
    row("a tenth moved: bytes over those of all", stage.culling.uploaded() as f64 / whole, "0.1");
    Ok(())
}

/// Reads a buffer once.
struct Stream {
    pipeline: ComputePipeline,
    group: BindGroup,
}

impl Stream {
    const BYTES: u64 = 64 << 20;

    fn new(gpu: &Gpu) -> Self {
        let source = "
            @group(0) @binding(0) var<storage, read> given: array<vec4<u32>>;
            @group(0) @binding(1) var<storage, read_write> sums: array<u32>;
            @compute @workgroup_size(256)
            fn sum_up(@builtin(global_invocation_id) id: vec3<u32>) {
                // As many runs as there are invocations, side by side.
                var sum = vec4<u32>(0u);
                for (var i = 0u; i < 16u; i++) { sum += given[id.x + i * 262144u]; }
                sums[id.x] = sum.x + sum.y + sum.z + sum.w;
            }";
        let module = gpu.device.create_shader_module(ShaderModuleDescriptor {
            label: None,
            source: ShaderSource::Wgsl(source.into()),
        });
        let pipeline = gpu.device.create_compute_pipeline(&ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            cache: None,
        });
        let from = buffer(gpu, Self::BYTES, BufferUsages::STORAGE);
        let to = buffer(gpu, 4 << 18, BufferUsages::STORAGE);
        let entry = |binding, resource| BindGroupEntry { binding, resource };
        let group = gpu.device.create_bind_group(&BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[entry(0, from.as_entire_binding()), entry(1, to.as_entire_binding())],
        });
        Self { pipeline, group }
    }

    fn run(&self, gpu: &Gpu) {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.dispatch_workgroups(1024, 1, 1);
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
    }
}

/// A hundred thousand things of which one in a hundred is alive, drawn by each mode.
fn many_draws(gpu: &Gpu) -> Result<(), Failure> {
    let (device, queue) = (&gpu.device, &gpu.queue);
    let (scene, view) = rows(316)?;
    // One in a hundred is in the second layer.
    let view = view.with_layers(2);
    if !DrawMode::Counted.is_offered(device) {
        println!("many draws: the device has neither counted draws nor first instances");
        return Ok(());
    }
    let stage = |mode| {
        let mut made = OffScreen::with_mode(device, queue, &scene, view.viewport(), mode)?;
        made.draw(device, queue, (&scene, &view), false)?;
        Ok::<_, GpuError>(made)
    };
    let stages = [stage(DrawMode::Each)?, stage(DrawMode::Clusters)?, stage(DrawMode::Counted)?];
    let pictures = stages.each_ref().map(|own| picture(gpu, own.target.ids(), view.viewport()));
    let [one, each, counted] = pictures;
    assert!(one? == each? && counted? == picture(gpu, stages[0].target.ids(), view.viewport())?);
    let draw = |own: &OffScreen| {
        let mut encoder = device.create_command_encoder(&Default::default());
        own.ids.draw(&mut encoder, &own.target, (&own.culling, &view), &[Phase::Late], true);
        queue.submit([encoder.finish()]);
        Ok(())
    };
    let [mut one, mut each, mut counted] = stages.each_ref().map(|own| move || draw(own));
    let [a, b, c] = fastest(gpu, [&mut one, &mut each, &mut counted])?;
    let count = scene.slot_count();
    let alive = count.div_ceil(100);
    println!(
        "{count} things, {alive} alive: {a:.2} ms in one draw, {b:.2} in one each, {c:.2} counted"
    );
    row("a draw each over one of what is left", b / a, "8");
    row("a draw each over counted", b / c, "8");
    row("one of what is left over counted", a / c, "1.2");
    Ok(())
}
