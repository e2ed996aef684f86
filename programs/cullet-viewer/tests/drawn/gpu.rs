//! A device without a window, and pictures read back from it.

use cullet::{Camera, Depth, Projection, Scene, View};
pub(crate) use cullet_gpu::Tier;
use cullet_viewer::draw::{Pane, Renderer, Style};
pub(crate) use cullet_viewer::headless::Gpu;
use cullet_viewer::headless::picture;

/// A device of a tier; skips, aloud, without one.
pub(crate) fn gpu(least: Tier) -> Option<&'static Gpu> {
    cullet_gpu::testing::device(least, cullet_testkit::skip)
}

/// A picture of RGBA bytes.
#[derive(Clone, PartialEq)]
pub(crate) struct Image {
    pub(crate) size: [u32; 2],
    pub(crate) pixels: Vec<[u8; 4]>,
}

impl Image {
    pub(crate) fn differing(&self, other: &Self) -> usize {
        assert_eq!(self.size, other.size);
        self.pixels.iter().zip(&other.pixels).filter(|(a, b)| a != b).count()
    }

    pub(crate) fn colours(&self) -> usize {
        let mut all = self.pixels.clone();
        all.sort_unstable();
        all.dedup();
        all.len()
    }

    /// Pixels that are not of the background.
    pub(crate) fn covered(&self, background: [u8; 4]) -> usize {
        self.pixels.iter().filter(|p| **p != background).count()
    }

    pub(crate) fn part(&self, [x, y, width, height]: [u32; 4]) -> Self {
        let row = |r: u32| {
            let start = ((y + r) * self.size[0] + x) as usize;
            self.pixels[start..start + width as usize].iter().copied()
        };
        Self { size: [width, height], pixels: (0..height).flat_map(row).collect() }
    }

    /// Written for people to look at, where `CULLET_PICTURES` names a folder.
    pub(crate) fn save(&self, name: &str) {
        let Some(folder) = std::env::var_os("CULLET_PICTURES") else { return };
        let file = std::fs::File::create(std::path::Path::new(&folder).join(name)).unwrap();
        let mut encoder = png::Encoder::new(file, self.size[0], self.size[1]);
        encoder.set_color(png::ColorType::Rgba);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(bytemuck::cast_slice(&self.pixels)).unwrap();
    }
}

/// Waits for the device, then reads the renderer's picture.
pub(crate) fn read(gpu: &Gpu, renderer: &Renderer) -> Image {
    let (size, pixels) = picture(gpu, renderer).unwrap();
    Image { size, pixels }
}

/// Waits until the device has nothing left to do.
pub(crate) fn finish(gpu: &Gpu) {
    gpu.finish().unwrap();
}

pub(crate) const BACKGROUND: [f32; 3] = [0.1, 0.12, 0.15];
pub(crate) const BACKGROUND_BYTES: [u8; 4] = [26, 31, 38, 255];

/// A view of a scene from a direction, from so many times its radius away.
pub(crate) fn view(scene: &Scene, direction: [f64; 3], away: f64, size: [u32; 2]) -> View {
    let extent = scene.extent();
    let centre = extent.center().map(f64::from);
    let radius = extent.half_extent().map(|v| v * v).iter().sum::<f64>().sqrt();
    let length = direction.map(|v| v * v).iter().sum::<f64>().sqrt();
    let eye: [f64; 3] = std::array::from_fn(|a| {
        centre[a] + direction[a] / length * radius * away + scene.origin()[a]
    });
    let target: [f64; 3] = std::array::from_fn(|a| centre[a] + scene.origin()[a]);
    let projection = Projection::Perspective {
        fov_y_radians: 1.0,
        aspect: f64::from(size[0]) / f64::from(size[1]),
        near: radius * 1e-3,
        far: f64::INFINITY,
    };
    View::new(&Camera::look_at(eye, target, projection), Depth::Reversed, size).unwrap()
}

/// A pane that fills its view's viewport and draws everything.
pub(crate) fn pane(view: &View, style: Style) -> Pane<'_> {
    let [width, height] = view.viewport();
    Pane {
        place: [0, 0, width, height],
        view,
        visible: None,
        on_device: false,
        style,
        over: false,
        lines: &[],
        overlay: &[],
        ghosts: &[],
    }
}

/// One pane, drawn and read.
pub(crate) fn shot(gpu: &Gpu, renderer: &mut Renderer, pane: Pane<'_>) -> Image {
    let size = pane.view.viewport();
    renderer.draw(&gpu.device, &gpu.queue, size, BACKGROUND, &[pane]);
    read(gpu, renderer)
}
