//! Impostors are drawn as the reference draws them, and what fades leaves no pixel out.

use cullet::lod::Lod;
use cullet::mesh::Part;
use cullet::{
    Camera, Culler, Depth, Instance, Mesh, MeshData, Output, Projection, Scene, Stage, Transform,
    View, ViewState, Visible,
};
use cullet_draw::{
    Frame, ImpostorOptions, PixelId, RenderOptions, Selection, capture_impostor, render,
};
use cullet_io::{Material, Model};
use cullet_mesh::Impostor;
use cullet_testkit::soups;
use cullet_viewer::draw::{Paint, Pane, Renderer, Style};
use glam::{DMat4, DVec3};

use super::gpu::*;

const SIZE: [u32; 2] = [240, 160];
/// The colours of the two parts, linear.
const PARTS: [[f32; 4]; 2] = [[0.7, 0.1, 0.05, 1.0], [0.05, 0.3, 0.8, 1.0]];

/// A bumpy ball of two parts, in three poses: as it is, turned and stretched, and mirrored.
fn model() -> (Model, Impostor) {
    let (positions, indices) = soups::bumpy_ball(24, 0.15);
    let half = indices.len() as u32 / 6;
    let all = indices.len() as u32 / 3;
    let part = |first_triangle, triangle_count, material| Part {
        first_triangle,
        triangle_count,
        material,
        ..Part::default()
    };
    let parts = vec![part(0, half, 0), part(half, all - half, 1)];
    let mesh = Mesh::new(MeshData { positions, indices, parts, ..MeshData::default() }).unwrap();
    let options = ImpostorOptions { grid: 8, texels: 10, samples: 3, ..ImpostorOptions::default() };
    let impostor = capture_impostor(&mesh, &options).unwrap();
    let mut scene = Scene::new();
    let own = scene.add_mesh(mesh);
    impostor.clone().add_to(&mut scene, own).unwrap();
    let (s, c) = 0.7f32.sin_cos();
    for (x, linear) in [
        (-3.0, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
        (0.0, [[1.2 * c, 1.2 * s, 0.0], [-0.8 * s, 0.8 * c, 0.0], [0.0, 0.0, 1.0]]),
        (3.0, [[-1.0, 0.0, 0.0], [0.0, 1.1, 0.0], [0.0, 0.3, 0.9]]),
    ] {
        scene.add(Instance::new(own, Transform { linear, translation: [x, 0.0, 0.0] })).unwrap();
    }
    scene.commit(&Culler::default());
    let material = |color| Material { name: String::new(), color };
    let materials = PARTS.map(material).to_vec();
    (Model { scene, materials, ..Model::default() }, impostor)
}

fn views() -> Vec<(&'static str, View)> {
    let aspect = f64::from(SIZE[0]) / f64::from(SIZE[1]);
    let fov = Projection::Perspective { fov_y_radians: 0.5, aspect, near: 0.1, far: 300.0 };
    let endless =
        Projection::Perspective { fov_y_radians: 0.5, aspect, near: 0.1, far: f64::INFINITY };
    let (top, right) = (4.0, 4.0 * aspect);
    let parallel =
        Projection::Orthographic { left: -right, right, bottom: -top, top, near: 0.1, far: 60.0 };
    let of = |eye, projection, depth| {
        View::new(&Camera::look_at(eye, [0.0; 3], projection), depth, SIZE).unwrap()
    };
    vec![
        ("reversed", of([5.0, 6.0, 15.0], endless, Depth::Reversed)),
        ("standard", of([-9.0, -7.0, 13.0], fov, Depth::Standard)),
        ("parallel", of([3.0, 9.0, -12.0], parallel, Depth::Reversed)),
    ]
}

/// Returns what is drawn by a cut of nothing but impostors.
fn impostors(scene: &Scene, view: &View, output: Output) -> Visible {
    // A threshold that nothing exceeds.
    let lod = Some(Lod::default().with_pixels(1e6));
    let culler = Culler::default().with_lod(lod).with_output(output).only(Stage::Lod);
    let mut visible = Visible::default();
    culler.cull_one(scene, view, &mut ViewState::default(), &mut visible);
    visible
}

fn renderer(gpu: &Gpu, model: &Model) -> Renderer {
    let mut renderer = Renderer::new(&gpu.adapter, &gpu.device);
    renderer.set_scene(&gpu.device, &gpu.queue, model).unwrap();
    renderer
}

/// Returns the colour that the viewer paints for a texel of the reference's picture.
fn expected(model: &Model, impostor: &Impostor, view: &View, frame: &Frame, at: usize) -> [u8; 3] {
    let id = frame.ids[at];
    let texel = impostor.texel(id.triangle as usize);
    let linear = model.scene.transform(id.slot).linear.map(|c| DVec3::from(c.map(f64::from)));
    let n = DVec3::from(texel.normal);
    let [a, b, c] = linear;
    let normal = (b.cross(c) * n.x + c.cross(a) * n.y + a.cross(b) * n.z).normalize();
    let place = place(view, frame, at);
    let [x, y, z, w] = view.eye();
    let eye = DVec3::new(x, y, z);
    let to_viewer = if w == 0.0 { eye.normalize() } else { (eye - place).normalize() };
    let facing = normal.dot(to_viewer);
    let light = 0.22 + 0.68 * facing.abs() + 0.10 * normal.y * facing.signum();
    let colour = PARTS[texel.part as usize];
    [0, 1, 2].map(|k| srgb(f64::from(colour[k]) * light))
}

fn place(view: &View, frame: &Frame, at: usize) -> DVec3 {
    let (x, y) = (at as u32 % frame.width, at as u32 / frame.width);
    let ndc = |p: u32, size: u32| (f64::from(p) + 0.5) / f64::from(size) * 2.0 - 1.0;
    let clip = DVec3::new(ndc(x, frame.width), -ndc(y, frame.height), frame.depth[at]);
    DMat4::from_cols_array(&view.world_from_clip()).project_point3(clip)
}

fn srgb(v: f64) -> u8 {
    let v = if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
    (v.clamp(0.0, 1.0) * 255.0).round() as u8
}

#[test]
fn an_impostor_is_drawn_as_the_reference_draws_it() {
    let Some(gpu) = gpu(Tier::Draw) else { return };
    let (model, impostor) = model();
    let mut renderer = renderer(gpu, &model);
    let radius = DVec3::from(model.scene.extent().half_extent()).length();
    for (name, view) in views() {
        let visible = impostors(&model.scene, &view, Output::Triangles);
        assert!(
            visible.partial.iter().all(|r| Impostor::at(&model.scene, r.slot, r.level).is_some())
        );
        let selection = Selection::Visible(&visible);
        let frame = render(&model.scene, &view, selection, &RenderOptions::default());
        let mut shoot = |paint| {
            let style = Style { paint, ..Style::default() };
            let drawn = Pane { visible: Some(&visible), ..pane(&view, style) };
            let image = shot(gpu, &mut renderer, drawn);
            image.save(&format!("impostor-{name}-{}.png", paint as u32));
            image
        };
        let (lit, deep) = (shoot(Paint::Material), shoot(Paint::Depth));
        assert_eq!(renderer.stats().impostors, 3, "{name}");
        let (mut covered, mut other, mut off, mut far) = (0, 0, 0, 0);
        for at in 0..frame.ids.len() {
            let is_there = frame.ids[at] != PixelId::NONE;
            covered += usize::from(is_there);
            if is_there != (lit.pixels[at] != BACKGROUND_BYTES) {
                other += 1;
            } else if is_there {
                let [r, g, b, _] = lit.pixels[at];
                let wanted = expected(&model, &impostor, &view, &frame, at);
                let apart = wanted.iter().zip([r, g, b]).map(|(a, b)| a.abs_diff(b)).max();
                off += usize::from(apart > Some(6));
                let [x, y, z, w] = view.eye();
                let eye = DVec3::new(x, y, z);
                let distance = match w == 0.0 {
                    // From the near plane, along the line of sight.
                    true => {
                        (DVec3::new(3.0, 9.0, -12.0) - place(&view, &frame, at))
                            .dot(eye.normalize())
                            - 0.1
                    }
                    false => (eye - place(&view, &frame, at)).length(),
                };
                let shade = srgb_of_linear(radius * 0.5 / (radius * 0.5 + distance));
                far += usize::from(shade.abs_diff(deep.pixels[at][0]) > 1);
            }
        }
        let told =
            format!("{name}: of {covered}: {other} there or not, {off} colours, {far} depths");
        assert!(covered > 2500, "{told}");
        assert!(other * 500 < covered && off * 50 < covered && far * 500 < covered, "{told}");
    }
}

/// A shade that is linear in the picture is written as it is.
fn srgb_of_linear(v: f64) -> u8 {
    (v.clamp(0.0, 1.0) * 255.0).round() as u8
}

#[test]
fn every_paint_shows_impostors_whole() {
    let Some(gpu) = gpu(Tier::Draw) else { return };
    let (model, _) = model();
    let mut renderer = renderer(gpu, &model);
    let (_, view) = views().swap_remove(0);
    let mut visible = impostors(&model.scene, &view, Output::Triangles);
    let whole = Pane { visible: Some(&visible), ..pane(&view, Style::default()) };
    let covered = shot(gpu, &mut renderer, whole).covered(BACKGROUND_BYTES);
    // What a culler leaves of a box may be less than what is seen in it.
    for range in &mut visible.triangle_ranges {
        range.count = 1;
    }
    for paint in [
        Paint::Material,
        Paint::Sides,
        Paint::Clusters,
        Paint::Instances,
        Paint::TriangleSize,
        Paint::Depth,
        Paint::Levels,
    ] {
        for wireframe in [false, true] {
            let style = Style { paint, wireframe, ..Style::default() };
            let drawn = Pane { visible: Some(&visible), ..pane(&view, style) };
            let image = shot(gpu, &mut renderer, drawn);
            assert_eq!(image.covered(BACKGROUND_BYTES), covered, "{paint:?} {wireframe}");
            assert!(image.colours() > 5, "{paint:?}: {}", image.colours());
        }
    }
    let style = Style { paint: Paint::Overdraw, ..Style::default() };
    let drawn = Pane { visible: Some(&visible), ..pane(&view, style) };
    let image = shot(gpu, &mut renderer, drawn);
    assert_eq!(image.covered([0, 0, 0, 255]), covered);
    // The originals beside: everything in full.
    let all = shot(gpu, &mut renderer, pane(&view, Style::default()));
    assert_eq!(renderer.stats().impostors, 0);
    let apart = all.covered(BACKGROUND_BYTES).abs_diff(covered);
    assert!(apart > 0 && apart * 6 < covered, "{apart} of {covered}");
}

#[test]
fn what_goes_and_what_comes_share_each_pixel() {
    let Some(gpu) = gpu(Tier::Draw) else { return };
    let solids = cullet_scenes::build("solids:n=9").unwrap();
    let (of_impostors, _) = model();
    for (name, model) in [("solids", solids), ("impostors", of_impostors)] {
        let mut renderer = renderer(gpu, &model);
        let view = match name {
            "solids" => view(&model.scene, [0.3, 0.8, 1.0], 1.6, SIZE),
            _ => views().swap_remove(0).1,
        };
        let visible = impostors(&model.scene, &view, Output::Clusters);
        for paint in [Paint::Material, Paint::Instances] {
            let style = Style { paint, ..Style::default() };
            let with = |style| Pane { visible: Some(&visible), ..pane(&view, style) };
            let slots = model.scene.slot_count() as usize;
            renderer.set_instance_colours(&gpu.queue, &vec![[200, 120, 40, 255]; slots]);
            let opaque = shot(gpu, &mut renderer, with(style));
            let covered = opaque.covered(BACKGROUND_BYTES);
            assert!(covered > 2000, "{name}: {covered}");
            let mut before = 0;
            for share in [1, 40, 128, 200, 255] {
                renderer.set_instance_colours(&gpu.queue, &vec![[200, 120, 40, share]; slots]);
                let coming = Style { fade: true, ..style };
                let going = Style { going: true, ..coming };
                let comes = shot(gpu, &mut renderer, with(coming));
                let goes = shot(gpu, &mut renderer, with(going));
                let is_drawn = |image: &Image, at: usize| image.pixels[at] != BACKGROUND_BYTES;
                for at in 0..opaque.pixels.len() {
                    let drawn = [is_drawn(&comes, at), is_drawn(&goes, at)];
                    let wanted = u32::from(is_drawn(&opaque, at));
                    assert_eq!(drawn.map(u32::from).iter().sum::<u32>(), wanted, "{name} {at}");
                }
                let part = comes.covered(BACKGROUND_BYTES);
                let expected = f64::from(share) / 255.0 * covered as f64;
                assert!((part as f64 - expected).abs() < 0.05 * covered as f64, "{name} {part}");
                assert!(part >= before);
                before = part;
                // One over the other is the picture as it was.
                let panes = [with(coming), Pane { over: true, ..with(going) }];
                renderer.draw(&gpu.device, &gpu.queue, SIZE, BACKGROUND, &panes);
                let both = read(gpu, &renderer);
                let colour = |p: &[u8; 4]| [p[0], p[1], p[2]];
                let same = opaque.pixels.iter().map(colour).eq(both.pixels.iter().map(colour));
                assert!(same, "{name} {share}");
            }
        }
    }
}
