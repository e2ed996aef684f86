//! Draws of clusters of which the device knows the number: those that are listed, one after the
//! other.

use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferUsages, CommandEncoder, ComputePipeline, Device,
    Queue,
};

use super::buffers::{Access, buffer, buffers_layout, dispatch_rows, group, pipelines};
use super::clusters::ClusterInstances;
use super::error::GpuError;
use super::lists::{DrawArguments, LaneBuffers, ListPass, ListSource, SlotList};

/// The pipeline that puts arguments of listed draws one after the other: five storage buffers, no
/// optional feature. Only to draw them takes one.
#[derive(Debug)]
pub struct CountedPass {
    layout: BindGroupLayout,
    gather: ComputePipeline,
}

/// Arguments of the clusters that are listed, those that are drawn alike in one call, in order; and
/// how many there are in each call.
#[derive(Debug)]
pub struct CountedArguments {
    arguments: Buffer,
    /// Its draws stand for the calls: how many instances, as they are called there, is how many
    /// draws.
    list: SlotList,
    group: BindGroup,
    groups: u32,
    calls: usize,
}

impl CountedPass {
    /// Compiles the pass.
    pub(crate) fn new(device: &Device) -> Self {
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

    /// How many calls there are.
    #[must_use]
    pub fn calls(&self) -> usize {
        self.calls
    }

    /// Bytes that it takes on the device.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        // Both what is gathered and what from.
        2 * self.arguments.size() + self.list.bytes()
    }
}
