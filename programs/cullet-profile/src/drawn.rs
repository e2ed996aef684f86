//! Frames of a scene: culled by the CPU as told, drawn by the device.

use std::time::Instant;

use cullet::{Backface, Culler, DrawList, Output, Scene, View, ViewState, Visible};
use cullet_gpu::{Gpu, GpuError};
use wgpu::SubmissionIndex;

use super::covered::Covered;
use super::drawing::Drawing;
use super::elasticity::median;
use super::link::{Link, Way};
use super::measure::Workload;
use super::relief::Work;

/// A scene in some views, culled in several ways: as a program would that has the engine's lists
/// and draws them, instances of one mesh in one draw.
#[derive(Debug)]
pub struct Drawn<'a> {
    scene: &'a Scene,
    views: &'a [View],
    cullers: Vec<Culled>,
    visible: Visible,
    list: DrawList,
    drawing: Drawing,
    covered: Covered,
}

/// A culler, and what it remembers of each view.
#[derive(Debug)]
struct Culled {
    culler: Culler,
    states: Vec<ViewState>,
}

impl<'a> Drawn<'a> {
    /// Uploads a scene, to be drawn in views of one size: plain frames are culled as the first
    /// culler says, [`Way::Culled`] as the others do. O(triangles + slots).
    ///
    /// # Errors
    /// If it does not fit the device.
    pub fn new(
        gpu: &Gpu,
        scene: &'a Scene,
        views: &'a [View],
        cullers: Vec<Culler>,
    ) -> Result<Self, GpuError> {
        let size = views.first().map_or([1; 2], View::viewport);
        let drawing = Drawing::new(gpu, scene, size)?;
        let covered = Covered::new(gpu, &drawing, size);
        let of = |culler| Culled {
            culler,
            states: views.iter().map(|_| ViewState::default()).collect(),
        };
        Ok(Self {
            scene,
            views,
            cullers: cullers.into_iter().map(of).collect(),
            visible: Visible::default(),
            list: DrawList::default(),
            drawing,
            covered,
        })
    }

    /// The work of a mean frame, by the number of its culler.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn work(&mut self, gpu: &Gpu, culler: usize) -> Result<Work, GpuError> {
        /// So often each frame is made, for its time.
        const TURNS: usize = 5;
        let mut sum = Work::default();
        let own = &self.cullers[culler].culler;
        let on_screen = own
            .clone()
            .with_frustum(true)
            .with_backface(if own.backface == Backface::Off {
                Backface::Fast
            } else {
                own.backface
            })
            .with_output(Output::Triangles);
        for number in 0..self.views.len() {
            let view = &self.views[number];
            let seconds = (0..TURNS).map(|_| {
                let began = Instant::now();
                self.cull(culler, number);
                drop(self.drawing.record(&gpu.device, view, &self.list, Way::Plain));
                began.elapsed().as_secs_f64()
            });
            let seconds = median(seconds.collect());
            self.drawing.upload(&gpu.queue, view, &self.list, Way::Plain);
            let samples = self.covered.count(gpu, &self.drawing, view, &self.list)?;
            let commands = &self.list.commands;
            let triangles: u64 = commands
                .iter()
                .map(|c| u64::from(c.index_count / 3) * u64::from(c.instance_count))
                .sum();
            let mut shown = Visible::default();
            on_screen.cull_one(self.scene, view, &mut ViewState::default(), &mut shown);
            sum = sum.plus(&Work {
                samples: samples as f64,
                on_screen: shown.triangle_count as f64,
                triangles: triangles as f64,
                bytes: Drawing::bytes(&self.list) as f64,
                seconds,
            });
        }
        Ok(sum.times(1.0 / self.views.len().max(1) as f64))
    }

    fn cull(&mut self, culler: usize, number: usize) {
        let Culled { culler, states } = &mut self.cullers[culler];
        let view = &self.views[number];
        culler.cull_one(self.scene, view, &mut states[number], &mut self.visible);
        let filled = self.list.fill(self.scene, &self.visible, &self.drawing.places);
        filled.expect("the scene stands as it was culled");
    }
}

impl Workload for Drawn<'_> {
    fn frames(&self) -> usize {
        self.views.len()
    }

    fn frame(&mut self, gpu: &Gpu, number: usize, way: Way) -> Result<SubmissionIndex, GpuError> {
        let culler = if let Way::Culled(at) = way { at + 1 } else { 0 };
        let view = &self.views[number];
        if way.doubles(Link::Cpu) {
            self.cull(culler, number);
            drop(self.drawing.record(&gpu.device, view, &self.list, way));
        }
        self.cull(culler, number);
        self.drawing.upload(&gpu.queue, view, &self.list, way);
        let commands = self.drawing.record(&gpu.device, view, &self.list, way);
        Ok(gpu.queue.submit([commands]))
    }
}
