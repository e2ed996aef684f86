//! Tests that the device's decision is drawn as everything is: the same pixels, whatever was seen
//! before.

use cullet::{Culler, InstanceFlags, Scene, View, ViewState, Visible, view::CullFace};
use cullet_io::Model;
use cullet_viewer::draw::{DeviceFigures, DeviceView, Paint, Pane, Renderer, Style};
use cullet_viewer::state::OnDevice;

use super::gpu::{BACKGROUND, Gpu, Image, Tier, finish, gpu, pane, read, view};

const SIZE: [u32; 2] = [331, 201];

fn by(view: &View) -> DeviceView<'_> {
    let faces = CullFace::None;
    DeviceView { view, frustum: true, occlusion: true, faces, pyramid: None }
}

fn with(gpu: &Gpu, model: &Model) -> Renderer {
    let mut renderer = Renderer::new(&gpu.adapter, &gpu.device);
    assert_eq!(Renderer::refuses_culling(&gpu.adapter), None);
    renderer.set_scene(&gpu.device, &gpu.queue, model).unwrap();
    renderer.prepare_culling(&gpu.device, &gpu.queue, &model.scene).unwrap();
    renderer
}

/// A picture, as the device decides it or of everything.
fn picture(
    gpu: &Gpu,
    renderer: &mut Renderer,
    pane: Pane<'_>,
    by: Option<&DeviceView<'_>>,
) -> Image {
    let panes = [Pane { on_device: by.is_some(), ..pane }];
    let size = pane.view.viewport();
    renderer.draw_by(&gpu.device, &gpu.queue, size, BACKGROUND, &panes, by);
    read(gpu, renderer)
}

/// Figures of a view that is shown for some frames.
fn figures(gpu: &Gpu, renderer: &mut Renderer, by: &DeviceView<'_>) -> DeviceFigures {
    let wanted = renderer.device_frames() + 2;
    for _ in 0..8 {
        picture(gpu, renderer, pane(by.view, Style::default()), Some(by));
        finish(gpu);
        if renderer.device_figures().frame >= wanted {
            return renderer.device_figures();
        }
    }
    panic!("no figures came: {:?}", renderer.device_figures());
}

const DIRECTIONS: [([f64; 3], f64); 4] = [
    ([0.5, 0.4, 1.0], 0.45),
    ([-1.0, 0.1, 0.2], 0.3),
    ([0.2, 1.0, 0.3], 1.6),
    ([0.3, 0.02, 1.0], 0.2),
];

#[test]
fn the_device_changes_no_pixel() {
    let Some(gpu) = gpu(Tier::Pyramid) else { return };
    for spec in ["city:cells=12,objects=400", "solids", "forest:n=2000", "office"] {
        let model = cullet_scenes::build(spec).unwrap();
        let mut renderer = with(gpu, &model);
        let views = DIRECTIONS.map(|(direction, away)| view(&model.scene, direction, away, SIZE));
        // Twice around: each view after another one, and after itself.
        for (number, view) in views.iter().chain(&views).enumerate() {
            let pane = pane(view, Style::default());
            let all = picture(gpu, &mut renderer, pane, None);
            for frame in 0..2 {
                let own = picture(gpu, &mut renderer, pane, Some(&by(view)));
                assert_eq!(all.differing(&own), 0, "{spec}: view {number}, frame {frame}");
            }
        }
    }
}

#[test]
fn the_device_culls() {
    let Some(gpu) = gpu(Tier::Pyramid) else { return };
    let model = cullet_scenes::build("city:cells=12,objects=400").unwrap();
    let mut renderer = with(gpu, &model);
    let all = model.scene.instance_count();
    // Near the ground, within the city.
    let view = view(&model.scene, [0.3, 0.02, 1.0], 0.2, SIZE);
    let told = figures(gpu, &mut renderer, &by(&view));
    assert!(told.in_view < all * 2 / 3 && told.visible < told.in_view / 2, "{told:?} of {all}");
    assert!(told.draws_in_use <= told.draws && told.draws_in_use > 0, "{told:?}");
    // Nothing moves: what is visible is what was, but for what blends.
    assert!(told.early_triangles <= told.triangles, "{told:?}");
    if let Some(times) = told.times {
        assert!(times.sum() > 0.0, "{times:?}");
    }
    // In view is what the CPU finds there, or a little more for coarser boxes.
    let culler = Culler::default().with_occlusion(None);
    let (mut state, mut visible) = (ViewState::default(), Visible::default());
    culler.cull_one(&model.scene, &view, &mut state, &mut visible);
    let of_cpu = visible.instance_count;
    let in_view = u64::from(told.in_view);
    assert!((of_cpu..=of_cpu + of_cpu / 50 + 1).contains(&in_view), "{in_view} for {of_cpu}");
    let without = figures(gpu, &mut renderer, &DeviceView { occlusion: false, ..by(&view) });
    assert_eq!((without.in_view, without.visible), (told.in_view, told.in_view));
    let none = DeviceView { occlusion: false, frustum: false, ..by(&view) };
    assert_eq!(figures(gpu, &mut renderer, &none).visible, all);
}

#[test]
fn every_style_is_drawn_as_without() {
    let Some(gpu) = gpu(Tier::Pyramid) else { return };
    let model = cullet_scenes::build("city:cells=6,objects=100").unwrap();
    let mut renderer = with(gpu, &model);
    let mut view = view(&model.scene, [0.5, 0.1, 1.0], 0.3, SIZE);
    // What the hardware drops is to be all that is dropped.
    view.cull_face = CullFace::None;
    let style = Style::default();
    for style in [
        Style { paint: Paint::Sides, ..style },
        Style { paint: Paint::Clusters, ..style },
        Style { paint: Paint::TriangleSize, ..style },
        Style { paint: Paint::Depth, samples: 4, ..style },
        Style { wireframe: true, ..style },
        Style { wireframe: true, samples: 4, ..style },
        Style { cull_face: CullFace::Front, ..style },
        Style { clockwise: true, ..style },
    ] {
        let pane = pane(&view, style);
        let all = picture(gpu, &mut renderer, pane, None);
        assert!(all.colours() > 10, "{style:?}");
        let by = DeviceView { faces: style.cull_face, ..by(&view) };
        for _ in 0..2 {
            let own = picture(gpu, &mut renderer, pane, Some(&by));
            assert_eq!(all.differing(&own), 0, "{style:?}");
        }
    }
}

#[test]
fn mirrored_two_sided_and_transparent_instances() {
    let Some(gpu) = gpu(Tier::Pyramid) else { return };
    // So many that half of them stand behind others.
    let mut model = cullet_scenes::build("city:cells=8,objects=200").unwrap();
    let scene = &mut model.scene;
    for slot in 0..scene.slot_count() {
        let handle = scene.handle(slot).unwrap();
        let mut transform = *scene.transform(slot);
        if slot % 2 == 0 {
            transform.linear[0] = transform.linear[0].map(|v| -v);
        }
        scene.set_transform(handle, transform).unwrap();
        let (double_sided, transparent) = (slot % 3 == 0, slot % 5 < 3);
        let flags = InstanceFlags { double_sided, transparent, ..scene.flags(slot) };
        scene.set_flags(handle, flags).unwrap();
    }
    scene.commit(&Culler::default());
    let mut renderer = with(gpu, &model);
    let mut view = view(&model.scene, [0.6, 0.05, 1.0], 0.3, SIZE);
    for cull_face in [CullFace::None, CullFace::Back, CullFace::Front] {
        view.cull_face = cull_face;
        let pane = pane(&view, Style::default());
        let all = picture(gpu, &mut renderer, pane, None);
        let own = picture(gpu, &mut renderer, pane, Some(&by(&view)));
        assert_eq!(all.differing(&own), 0, "{cull_face:?}");
    }
}

/// The left half is decided, the right half shows from outside what is.
#[test]
fn what_was_decided_is_seen_from_elsewhere() {
    let Some(gpu) = gpu(Tier::Pyramid) else { return };
    let model = cullet_scenes::build("city:cells=12,objects=400").unwrap();
    let mut renderer = with(gpu, &model);
    let [width, height] = SIZE;
    let inside = view(&model.scene, [0.3, 0.02, 1.0], 0.2, SIZE);
    let above = view(&model.scene, [0.1, 1.0, 0.3], 1.4, SIZE);
    let mut draw = |on_device: [bool; 2], by: Option<&DeviceView<'_>>| {
        let mut panes = [&inside, &above].map(|v| pane(v, Style::default()));
        panes[1].place[0] = width;
        (panes[0].on_device, panes[1].on_device) = (on_device[0], on_device[1]);
        let whole = [width * 2, height];
        renderer.draw_by(&gpu.device, &gpu.queue, whole, BACKGROUND, &panes, by);
        let image = read(gpu, &renderer);
        [0, width].map(|x| image.part([x, 0, width, height]))
    };
    let all = draw([false; 2], None);
    let by = by(&inside);
    let own = draw([true; 2], Some(&by));
    assert_eq!(all[0].differing(&own[0]), 0);
    assert!(all[1].differing(&own[1]) > 1000, "from above nothing is missing");
    // The other way round: nothing shows the view that is decided for.
    let beside = draw([false, true], Some(&by));
    assert_eq!(own[1].differing(&beside[1]), 0);
    assert_eq!(all[0].differing(&beside[0]), 0);
}

#[test]
fn a_level_of_the_pyramid_is_nowhere_nearer_than_the_picture() {
    let Some(gpu) = gpu(Tier::Pyramid) else { return };
    let model = cullet_scenes::build("city:cells=12,objects=400").unwrap();
    let mut renderer = with(gpu, &model);
    let view = view(&model.scene, [0.3, 0.05, 1.0], 0.3, SIZE);
    let [width, height] = SIZE;
    let depth = pane(&view, Style { paint: Paint::Depth, ..Style::default() });
    let mut before = None;
    for level in 0..OnDevice::levels(SIZE) {
        let pyramid = Some(([width, 0, width, height], level));
        let by = DeviceView { pyramid, ..by(&view) };
        let whole = [width * 2, height];
        let mut image = None;
        for _ in 0..2 {
            let panes = [Pane { on_device: true, ..depth }];
            renderer.draw_by(&gpu.device, &gpu.queue, whole, BACKGROUND, &panes, Some(&by));
            image = Some(read(gpu, &renderer));
        }
        let image = image.unwrap();
        let [near, far] = [0, width].map(|x| image.part([x, 0, width, height]));
        let is_open = |p: &[u8; 4]| p[2] > p[0];
        let open = far.pixels.iter().filter(|p| is_open(p)).count();
        // A texel is painted by its middle, and a pixel by its own line of sight: the same depth is
        // a little farther at the edge.
        let nearer = near.pixels.iter().zip(&far.pixels);
        let nearer = nearer.filter(|(n, f)| !is_open(f) && f[0] > n[0].saturating_add(8)).count();
        assert!(nearer * 100 < near.pixels.len(), "level {level}: {nearer} pixels are nearer");
        // What is open below is open above.
        assert!(before.is_none_or(|before| open >= before), "level {level}: {open} open");
        before = Some(open);
        let (_, size) = OnDevice { level, ..OnDevice::default() }.shown(SIZE);
        assert_eq!(size, cullet_gpu::level_sizes(SIZE).nth(level as usize).unwrap());
        if level < 3 {
            assert!(far.colours() > 20, "level {level} has {} colours", far.colours());
        }
    }
    assert_eq!(cullet_gpu::level_sizes(SIZE).count() as u32, OnDevice::levels(SIZE));
}

#[test]
fn an_empty_scene_and_a_view_that_cannot_be() {
    let Some(gpu) = gpu(Tier::Pyramid) else { return };
    let empty = Model { scene: Scene::new(), ..cullet_scenes::build("solids").unwrap() };
    let model = cullet_scenes::build("solids").unwrap();
    let near = view(&model.scene, [0.6, 0.2, 1.0], 0.5, SIZE);
    let mut renderer = with(gpu, &empty);
    let image = picture(gpu, &mut renderer, pane(&near, Style::default()), Some(&by(&near)));
    assert_eq!(image.colours(), 1);
    // Depth that is not reversed: the CPU's result is drawn.
    let standard = View::from_matrix(near.clip_from_world(), cullet::Depth::Standard, SIZE);
    let Ok(standard) = standard else { return };
    let mut renderer = with(gpu, &model);
    let visible = Visible::default();
    let pane = Pane { visible: Some(&visible), ..pane(&standard, Style::default()) };
    let image = picture(gpu, &mut renderer, pane, Some(&by(&standard)));
    assert_eq!(image.colours(), 1);
}
