//! Draws of clusters of which the device knows the number: those that are listed, one after the other.

use std::ops::Range;

use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferUsages, CommandEncoder, ComputePipeline, Device,
    Queue, RenderPass,
};

use super::buffers::{Access, buffer, buffers_layout, dispatch_rows, group, pipelines};
use super::clusters::{ClusterArguments, ClusterInstances};
use super::error::GpuError;
use super::lists::{DrawArguments, LaneBuffers, ListPass, ListSource, SlotList};
use super::passes::Passes;
use super::units::Phase;

const SIZE: u64 = size_of::<DrawArguments>() as u64;

/// The pipeline that puts arguments of listed draws one after the other: five storage buffers, no optional feature. Only to draw them takes
/// one.
#[derive(Debug)]
pub struct CountedPass {
    layout: BindGroupLayout,
    gather: ComputePipeline,
}

/// Arguments of the clusters that are listed, those that are drawn alike in one call, in order; and how many there are in each call.
#[derive(Debug)]
pub struct CountedArguments {
    arguments: Buffer,
    /// Its draws stand for the calls: how many instances, as they are called there, is how many draws.
    list: SlotList,
    group: BindGroup,
    groups: u32,
    calls: usize,
}

impl CountedPass {
    /// Compiles the pass.
    #[must_use]
    pub fn new(device: &Device) -> Self {
        const ACCESS: [Access; 6] = [
            Access::Read,
            Access::Write,
            Access::Write,
            Access::Read,
            Access::Write,
            Access::Uniform,
        ];
        let layout = buffers_layout(device, "counted", &ACCESS);
        let source =
            concat!(include_str!("shaders/ranks.wgsl"), include_str!("shaders/counted.wgsl"));
        let [gather] = pipelines(device, "counted", source, &[&layout], &[], ["gather"]);
        Self { layout, gather }
    }

    /// Records what bits make of arguments.
    pub fn record(&self, lists: &ListPass, encoder: &mut CommandEncoder, to: &CountedArguments) {
        lists.record_with(encoder, &to.list, |pass| {
            pass.set_bind_group(0, &to.group, &[]);
            dispatch_rows(pass, &self.gather, to.groups);
        });
    }
}

impl CountedArguments {
    /// Room for all clusters, of lanes that are [theirs](ClusterInstances::lanes).
    ///
    /// # Errors
    /// If a buffer would be larger than the device allows.
    pub fn new(
        device: &Device,
        queue: &Queue,
        (pass, lists): (&CountedPass, &ListPass),
        (clusters, lanes): (&ClusterInstances, &LaneBuffers),
        source: ListSource<'_>,
    ) -> Result<Self, GpuError> {
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let (size, count) = (size_of::<DrawArguments>(), clusters.arguments().len());
        let all = buffer(device, "draws of clusters", count, size, usage)?;
        queue.write_buffer(&all, 0, bytemuck::cast_slice(clusters.arguments()));
        let usage = usage | BufferUsages::INDIRECT | BufferUsages::COPY_SRC;
        let arguments = buffer(device, "arguments of clusters", count, size, usage)?;
        let calls = clusters.runs().len();
        let of_calls: Vec<_> =
            (0..calls as u32).map(|call| (call, DrawArguments::default())).collect();
        let list = SlotList::new(device, queue, lists, lanes, &of_calls, source)?;
        let [lane, words, places] = lanes.ranks();
        let (numbers, groups) = list.numbers();
        let resources =
            [lane, words, places, &all, &arguments, numbers].map(|b| b.as_entire_binding());
        let group = group(device, "counted", &pass.layout, &resources);
        Ok(Self { arguments, list, group, groups, calls })
    }

    /// [`DrawArguments`] of those that are listed, from the first of their call on.
    #[must_use]
    pub fn arguments(&self) -> &Buffer {
        &self.arguments
    }

    /// How many are listed in each call, where [`DrawArguments`] have their number of instances.
    #[must_use]
    pub fn counts(&self) -> &Buffer {
        self.list.arguments()
    }
}

/// Draws of clusters by phase.
#[derive(Debug)]
pub(crate) enum ClusterDraws {
    /// One for each, of which some have no instance.
    Each([ClusterArguments; 3]),
    /// Those that are listed.
    Counted {
        all: Box<[CountedArguments; 3]>,
        /// Bytes of their lanes on the device.
        of_lanes: u64,
    },
}

impl ClusterDraws {
    pub(crate) fn new(
        (device, queue, passes): (&Device, &Queue, &Passes),
        clusters: &ClusterInstances,
        sources: [ListSource<'_>; 3],
        is_counted: bool,
    ) -> Result<Self, GpuError> {
        let [early, late, blended] = sources;
        if is_counted {
            let lanes = LaneBuffers::new(device, queue, &clusters.lanes())?;
            let both = (&passes.counted, &passes.lists);
            let of =
                |source| CountedArguments::new(device, queue, both, (clusters, &lanes), source);
            let all = [of(early)?, of(late)?, of(blended)?];
            return Ok(Self::Counted { all: Box::new(all), of_lanes: lanes.bytes() });
        }
        let of = |source| ClusterArguments::new(device, queue, &passes.arguments, clusters, source);
        Ok(Self::Each([of(early)?, of(late)?, of(blended)?]))
    }

    pub(crate) fn record(&self, passes: &Passes, encoder: &mut CommandEncoder, phase: Phase) {
        match self {
            Self::Each(all) => passes.arguments.record(encoder, &all[phase as usize]),
            Self::Counted { all, .. } => {
                passes.counted.record(&passes.lists, encoder, &all[phase as usize]);
            }
        }
    }

    /// Draws one call's.
    pub(crate) fn draw(
        &self,
        pass: &mut RenderPass<'_>,
        phase: Phase,
        (call, numbers): (usize, &Range<u32>),
    ) {
        let (first, most) = (u64::from(numbers.start) * SIZE, numbers.end - numbers.start);
        match self {
            Self::Each(all) => {
                let arguments = all[phase as usize].arguments();
                pass.multi_draw_indexed_indirect(arguments, first, most);
            }
            Self::Counted { all, .. } => {
                /// Of how many instances, among arguments.
                const COUNT: u64 = 4;
                let own = &all[phase as usize];
                let count = call as u64 * SIZE + COUNT;
                let counts = own.counts();
                pass.multi_draw_indexed_indirect_count(&own.arguments, first, counts, count, most);
            }
        }
    }

    /// Arguments whose instances are the clusters that are drawn, and how many there are.
    pub(crate) fn arguments(&self, phase: Phase, clusters: &ClusterInstances) -> (&Buffer, usize) {
        match self {
            Self::Each(all) => (all[phase as usize].arguments(), clusters.slots().len()),
            Self::Counted { all, .. } => {
                let own = &all[phase as usize];
                (own.counts(), own.calls)
            }
        }
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        match self {
            Self::Each(all) => all.iter().map(|own| own.arguments().size()).sum(),
            Self::Counted { all, of_lanes } => {
                // Both what is gathered and what from.
                let of = |own: &CountedArguments| 2 * own.arguments.size() + own.list.bytes();
                of_lanes + all.iter().map(of).sum::<u64>()
            }
        }
    }
}
