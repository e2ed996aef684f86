//! Frames on the device, with occlusion culling and without, and whether they are the same.

use cullet::{Culler, Scene, View, ViewState, Visible};
use cullet_gpu::{DrawArguments, DrawMode, Gpu, OffScreen, Phase};

use cullet_testkit::views::look;

use super::texels;

/// How a frame is culled.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Way {
    /// Not by occlusion.
    All,
    TwoPhases,
    /// Draws what was visible in the frame before and nothing else: wrong.
    EarlyAlone,
    /// Draws as the CPU decides.
    Cpu,
}

/// A scene on the device, drawn at one size.
pub(crate) struct Stage<'a> {
    pub(crate) gpu: &'a Gpu,
    pub(crate) all: OffScreen,
}

/// Contents of the targets after a frame.
pub(crate) struct Frame {
    pub(crate) ids: Vec<u32>,
    pub(crate) depth: Vec<f32>,
}

impl<'a> Stage<'a> {
    pub(crate) fn new(gpu: &'a Gpu, scene: &Scene, size: [u32; 2]) -> Self {
        Self::with_mode(gpu, scene, size, DrawMode::Each)
    }

    pub(crate) fn with_mode(gpu: &'a Gpu, scene: &Scene, size: [u32; 2], mode: DrawMode) -> Self {
        let (device, queue) = (&gpu.device, &gpu.queue);
        Self { gpu, all: OffScreen::with_mode(device, queue, scene, size, mode).unwrap() }
    }

    pub(crate) fn mode(&self) -> DrawMode {
        self.all.culling.mode()
    }

    pub(crate) fn draw(&mut self, scene: &Scene, view: &View, way: Way) -> Frame {
        let (device, queue) = (&self.gpu.device, &self.gpu.queue);
        if way == Way::EarlyAlone {
            let all = &mut self.all;
            all.culling.set(queue, scene, view, 1).unwrap();
            all.target.set(queue, view);
            let mut encoder = device.create_command_encoder(&Default::default());
            all.culling.record_early(&all.passes, &mut encoder);
            all.ids.draw(&mut encoder, &all.target, (&all.culling, view), &[Phase::Early], true);
            all.culling.record_late(&all.passes, &mut encoder, &all.pyramid);
            queue.submit([encoder.finish()]);
        } else if way == Way::Cpu {
            let mut visible = Visible::default();
            Culler::default().cull_one(scene, view, &mut ViewState::default(), &mut visible);
            self.all.draw_decided(device, queue, (scene, view), &visible).unwrap();
        } else {
            self.all.draw(device, queue, (scene, view), way == Way::TwoPhases).unwrap();
        }
        self.frame(view.viewport())
    }

    /// Returns what was drawn last.
    pub(crate) fn frame(&self, size: [u32; 2]) -> Frame {
        let target = &self.all.target;
        let ids = texels(self.gpu, target.ids(), 0, size);
        Frame { ids, depth: texels(self.gpu, target.depth(), 0, size) }
    }

    pub(crate) fn bits(&self, buffer: &wgpu::Buffer) -> Vec<u32> {
        bytemuck::pod_collect_to_vec(&self.gpu.read(buffer, buffer.size()).unwrap())
    }

    /// Instances or clusters that are drawn in a phase.
    pub(crate) fn drawn(&self, phase: Phase) -> u32 {
        let (arguments, count) = self.all.culling.arguments(phase);
        let bytes = (count * size_of::<DrawArguments>()) as u64;
        let all: Vec<DrawArguments> =
            bytemuck::pod_collect_to_vec(&self.gpu.read(arguments, bytes).unwrap());
        all.iter().map(|a| a.instance_count).sum()
    }
}

pub(crate) fn is_set(bits: &[u32], slot: u32) -> bool {
    bits[slot as usize / 32] >> (slot % 32) & 1 != 0
}

/// Fails where a frame is not the picture that all instances make. Returns at how many pixels two are equally near, and the other is
/// seen.
pub(crate) fn assert_same(stage: &Stage<'_>, expected: &Frame, found: &Frame, what: &str) -> usize {
    let mut visible = stage.bits(stage.all.culling.visible());
    if let Some(slots) = stage.all.culling.slots_of_clusters() {
        let most = slots.iter().max().map_or(0, |slot| slot / 32 + 1);
        let mut of_slots = vec![0; most as usize];
        for (number, slot) in (0..).zip(slots) {
            of_slots[*slot as usize / 32] |= u32::from(is_set(&visible, number)) << (slot % 32);
        }
        visible = of_slots;
    }
    for id in expected.ids.iter().filter(|id| **id > 0) {
        assert!(is_set(&visible, id - 1), "{what}: instance {} is seen and was culled", id - 1);
    }
    let wrong = expected.depth.iter().zip(&found.depth).filter(|(a, b)| a != b).count();
    assert_eq!(wrong, 0, "{what}: pixels of another depth");
    expected.ids.iter().zip(&found.ids).filter(|(a, b)| a != b).count()
}

/// Pixels of a frame that are not those of another.
pub(crate) fn wrong(a: &Frame, b: &Frame) -> usize {
    a.depth.iter().zip(&b.depth).filter(|(a, b)| a != b).count()
}

/// A walk through the city with jumps and turns.
pub(crate) fn walk(size: [u32; 2]) -> Vec<View> {
    let mut views = Vec::new();
    for step in 0..6 {
        let at = f64::from(step);
        views.push(look([at * 3.0, 4.0, at * 0.5], [100.0, 6.0, 10.0 + at * 8.0], size));
    }
    // Jumps: back to front, up, and down again.
    views.push(look([0.0, 4.0, 0.0], [-100.0, 6.0, 30.0], size));
    views.push(look([0.0, 300.0, 300.0], [0.0, 0.0, 0.0], size));
    views.push(look([60.0, 4.0, -60.0], [60.0, 6.0, 100.0], size));
    views
}
