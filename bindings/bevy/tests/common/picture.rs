//! An app of Bevy without a window that draws into an image, and pictures that are compared.

use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use bevy::app::{PluginsState, TerminalCtrlCHandlerPlugin};
use bevy::core_pipeline::schedule::RootNonCameraView;
use bevy::log::LogPlugin;
use bevy::prelude::*;
use bevy::render::pipelined_rendering::PipelinedRenderingPlugin;
use bevy::render::render_resource::{PipelineCache, PollType, TextureFormat};
use bevy::render::renderer::RenderDevice;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured};
use bevy::render::{RenderApp, RenderPlugin};
use bevy::window::ExitCondition;

/// Frames until Bevy has measured the bounds and sent every mesh to the device.
const SETTLING: u32 = 3;
/// Frames after which what is still not ready never will be.
const PATIENCE: u32 = 2000;

/// The image that the cameras of a [`Studio`] draw into.
#[derive(Resource, Clone)]
pub(crate) struct Canvas(pub(crate) Handle<Image>);

/// When the app's own schedules ended last.
#[derive(Resource)]
struct AppEnd(Instant);

/// An app that draws without a window.
pub(crate) struct Studio {
    app: App,
}

impl Studio {
    /// An app whose plugins are Bevy's and those of `more`, with a [`Canvas`] of `size` pixels.
    pub(crate) fn new(size: [u32; 2], more: impl FnOnce(&mut App)) -> Self {
        let window = WindowPlugin {
            primary_window: None,
            exit_condition: ExitCondition::DontExit,
            ..default()
        };
        let mut app = App::new();
        app.add_plugins(
            DefaultPlugins
                .set(window)
                // Else the first frames lack what is not compiled yet.
                .set(RenderPlugin { synchronous_pipeline_compilation: true, ..default() })
                .disable::<LogPlugin>()
                .disable::<bevy::winit::WinitPlugin>()
                // A second app in the process would complain.
                .disable::<TerminalCtrlCHandlerPlugin>()
                // Else a picture is of the frame before.
                .disable::<PipelinedRenderingPlugin>(),
        );
        let image =
            Image::new_target_texture(size[0], size[1], TextureFormat::Rgba8UnormSrgb, None);
        let image = app.world_mut().resource_mut::<Assets<Image>>().add(image);
        app.insert_resource(Canvas(image));
        app.insert_resource(GlobalAmbientLight { brightness: 200.0, ..default() });
        app.insert_resource(ClearColor(Color::srgb(0.3, 0.5, 0.8)));
        app.insert_resource(AppEnd(Instant::now()));
        app.add_systems(Last, |mut end: ResMut<AppEnd>| end.0 = Instant::now());
        more(&mut app);
        while app.plugins_state() == PluginsState::Adding {
            bevy::tasks::tick_global_task_pools_on_main_thread();
        }
        app.finish();
        app.cleanup();
        Self { app }
    }

    pub(crate) fn world(&mut self) -> &mut World {
        self.app.world_mut()
    }

    /// Views of lamps that the renderer runs its schedule for.
    #[allow(dead_code, reason = "not all tests and examples count them")]
    pub(crate) fn lamp_views(&mut self) -> usize {
        let world = self.app.sub_app_mut(RenderApp).world_mut();
        world.query_filtered::<(), With<RootNonCameraView>>().iter(world).count()
    }

    /// Draws until nothing is on its way to the device any more. Shaders are read by other threads, and until then a picture
    /// lacks what they draw: pictures of nothing are equal too.
    pub(crate) fn settle(&mut self) {
        let (mut frames, mut ready) = (0, 0);
        while frames < SETTLING || ready < SETTLING {
            assert!(frames < PATIENCE, "pipelines are not ready after {frames} frames");
            self.frame();
            let pipelines = self.app.sub_app(RenderApp).world().resource::<PipelineCache>();
            let is_ready = pipelines.waiting_pipelines().next().is_none();
            ready = if is_ready { ready + 1 } else { 0 };
            frames += 1;
        }
    }

    /// Draws a frame and waits for the device.
    pub(crate) fn frame(&mut self) {
        self.frame_parts();
    }

    /// Draws a frame and waits for the device: times of the app, of the renderer's systems, and of the device after
    /// them.
    pub(crate) fn frame_parts(&mut self) -> [Duration; 3] {
        let start = Instant::now();
        self.app.update();
        let updated = Instant::now();
        let app_end = self.app.world().resource::<AppEnd>().0;
        let device = self.app.sub_app(RenderApp).world().resource::<RenderDevice>();
        device.poll(PollType::wait_indefinitely()).expect("the device answers");
        [app_end - start, updated - app_end, updated.elapsed()]
    }

    /// The picture of the next frame.
    pub(crate) fn shoot(&mut self) -> Picture {
        let got = Arc::new(Mutex::new(None));
        let to = got.clone();
        let image = self.world().resource::<Canvas>().0.clone();
        self.world().spawn(Screenshot::image(image)).observe(
            move |captured: On<ScreenshotCaptured>| {
                *to.lock().unwrap() = Some(captured.image.clone());
            },
        );
        for _ in 0..1000 {
            self.frame();
            if let Some(image) = got.lock().unwrap().take() {
                return Picture::new(&image);
            }
        }
        panic!("no picture after 1000 frames");
    }
}

/// Pixels of four bytes.
#[derive(Clone, PartialEq, Eq)]
pub(crate) struct Picture {
    pub(crate) size: [u32; 2],
    pub(crate) pixels: Vec<[u8; 4]>,
}

impl Picture {
    fn new(image: &Image) -> Self {
        let bytes = image.data.as_ref().expect("a screenshot has pixels");
        let pixels = bytes.as_chunks::<4>().0.to_vec();
        Self { size: image.size().to_array(), pixels }
    }

    /// Number of pixels in which two pictures of one size differ.
    pub(crate) fn differing(&self, other: &Self) -> usize {
        assert_eq!(self.size, other.size);
        self.pixels.iter().zip(&other.pixels).filter(|(a, b)| a != b).count()
    }

    /// Writes a PNG without transparency.
    pub(crate) fn save(&self, path: &Path) {
        let image = Image::new(
            bevy::render::render_resource::Extent3d {
                width: self.size[0],
                height: self.size[1],
                depth_or_array_layers: 1,
            },
            bevy::render::render_resource::TextureDimension::D2,
            self.pixels.concat(),
            TextureFormat::Rgba8UnormSrgb,
            bevy::asset::RenderAssetUsages::MAIN_WORLD,
        );
        let dynamic = image.try_into_dynamic().expect("eight bits a channel");
        dynamic.to_rgb8().save(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    }
}
