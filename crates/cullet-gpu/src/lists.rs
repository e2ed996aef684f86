//! The pass that makes lists of bits, and the lists.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use wgpu::{
    BindGroup, BindGroupLayout, Buffer, BufferUsages, CommandEncoder, ComputePass,
    ComputePassDescriptor, ComputePipeline, Device, Queue,
};

use super::buffers::{Access, buffer, buffers_layout, dispatch_rows, group, pipelines};
use super::error::GpuError;
use super::lanes::Lanes;
use super::tier::GROUP;

/// The pipelines that make lists: eight storage buffers, no optional feature.
#[derive(Debug)]
pub struct ListPass {
    layout: BindGroupLayout,
    count: ComputePipeline,
    scan: ComputePipeline,
    scatter: ComputePipeline,
    fill: ComputePipeline,
}

/// The bits that are listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Listed {
    /// All slots whose bit is set.
    All = 0,
    /// Set slots that were seen before.
    Seen = 1,
    /// Set slots that were not seen before.
    New = 2,
}

/// The arguments of an indexed indirect draw: 20 bytes, as [wgpu] wants them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct DrawArguments {
    /// How many indices.
    pub index_count: u32,
    /// How many instances; the passes write it.
    pub instance_count: u32,
    /// The first index.
    pub first_index: u32,
    /// Number that is added to each index.
    pub base_vertex: i32,
    /// Always 0, as not every device has it: a list begins where the bucket's first lane is.
    pub first_instance: u32,
}

/// The lanes of a scene on a device; what lists are made of.
#[derive(Debug)]
pub struct LaneBuffers {
    lanes: Buffer,
    words: Buffer,
    places: Buffer,
    count: u32,
    /// Lanes of each bucket.
    buckets: Vec<Range<u32>>,
}

/// A list of slots by bucket, and the arguments of draws of them.
#[derive(Debug)]
pub struct SlotList {
    list: Buffer,
    arguments: Buffer,
    which: Buffer,
    group: BindGroup,
    lane_groups: u32,
    draws: u32,
}

/// Source of a list.
#[derive(Clone, Copy, Debug)]
pub struct ListSource<'a> {
    /// A bit a slot.
    pub bits: &'a Buffer,
    /// Slots that were seen before: a bit a slot.
    pub seen: &'a Buffer,
    /// Slots among them that are listed.
    pub listed: Listed,
}

impl ListPass {
    /// Compiles the passes.
    pub(crate) fn new(device: &Device) -> Self {
        const ACCESS: [Access; 9] = [
            Access::Read,
            Access::Write,
            Access::Write,
            Access::Read,
            Access::Read,
            Access::Read,
            Access::Write,
            Access::Write,
            Access::Uniform,
        ];
        let layout = buffers_layout(device, "lists", &ACCESS);
        let source = concat!(
            include_str!("shaders/listed.wgsl"),
            include_str!("shaders/ranks.wgsl"),
            include_str!("shaders/scan.wgsl"),
            include_str!("shaders/lists.wgsl")
        );
        let names = ["count", "scan", "scatter", "fill"];
        let [count, scan, scatter, fill] =
            pipelines(device, "lists", source, &[&layout], &[], names);
        Self { layout, count, scan, scatter, fill }
    }

    /// Records how a list is made. The bits must be ready by then, and it is right when the passes
    /// are done.
    pub fn record(&self, encoder: &mut CommandEncoder, to: &SlotList) {
        self.record_with(encoder, to, |pass| dispatch_rows(pass, &self.scatter, to.lane_groups));
    }

    /// The same with something else made of the lanes that are listed than their slots.
    pub(crate) fn record_with(
        &self,
        encoder: &mut CommandEncoder,
        to: &SlotList,
        make: impl FnOnce(&mut ComputePass<'_>),
    ) {
        let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
            label: Some("lists"),
            timestamp_writes: None,
        });
        pass.set_bind_group(0, &to.group, &[]);
        dispatch_rows(&mut pass, &self.count, to.lane_groups);
        dispatch_rows(&mut pass, &self.scan, 1);
        dispatch_rows(&mut pass, &self.fill, to.draws.div_ceil(GROUP));
        make(&mut pass);
    }
}

impl LaneBuffers {
    /// Uploads lanes. O(lanes).
    ///
    /// # Errors
    /// If a buffer would be larger than the device allows.
    pub fn new(device: &Device, queue: &Queue, lanes: &Lanes) -> Result<Self, GpuError> {
        let of_buckets = lanes.buckets().iter();
        let firsts = of_buckets.flat_map(|b| b.lanes.clone().map(|_| b.lanes.start));
        let all: Vec<[u32; 2]> =
            lanes.slots().iter().zip(firsts).map(|(slot, first)| [*slot, first]).collect();
        let groups = all.len().div_ceil(GROUP as usize);
        let (read, written) =
            (BufferUsages::STORAGE, BufferUsages::STORAGE | BufferUsages::COPY_DST);
        let own = buffer(device, "lanes", all.len(), 8, written)?;
        queue.write_buffer(&own, 0, bytemuck::cast_slice(&all));
        Ok(Self {
            lanes: own,
            words: buffer(device, "bits of lanes", groups * 8, 8, read)?,
            places: buffer(device, "places of lanes", groups + 1, 4, read)?,
            count: all.len() as u32,
            buckets: lanes.buckets().iter().map(|b| b.lanes.clone()).collect(),
        })
    }

    /// Lanes, which of them are listed, and where.
    pub(crate) fn ranks(&self) -> [&Buffer; 3] {
        [&self.lanes, &self.words, &self.places]
    }

    /// Bytes that they take on the device.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        [&self.lanes, &self.words, &self.places].into_iter().map(Buffer::size).sum()
    }
}

impl SlotList {
    /// Room for a list of all lanes, and for some draws, each of a bucket with its number; how many
    /// instances each has is written by the [pass](ListPass).
    ///
    /// # Errors
    /// If a buffer would be larger than the device allows.
    ///
    /// # Panics
    /// If there is no such bucket.
    pub fn new(
        device: &Device,
        queue: &Queue,
        pass: &ListPass,
        lanes: &LaneBuffers,
        draws: &[(u32, DrawArguments)],
        source: ListSource<'_>,
    ) -> Result<Self, GpuError> {
        let (storage, written) = (BufferUsages::STORAGE, BufferUsages::COPY_DST);
        let read_back = BufferUsages::COPY_SRC;
        let vertex = storage | BufferUsages::VERTEX | read_back;
        let list = buffer(device, "visible slots", lanes.count as usize, 4, vertex)?;
        let indirect = storage | BufferUsages::INDIRECT | written | read_back;
        let size = size_of::<DrawArguments>();
        let arguments = buffer(device, "arguments of draws", draws.len(), size, indirect)?;
        let table = buffer(device, "draws", draws.len(), 8, storage | written)?;
        let uniform = BufferUsages::UNIFORM | written;
        let which = buffer(device, "which are listed", 4, 4, uniform)?;
        let ends: Vec<[u32; 2]> = draws
            .iter()
            .map(|(bucket, _)| &lanes.buckets[*bucket as usize])
            .map(|b| [b.start, b.end])
            .collect();
        let all: Vec<DrawArguments> = draws.iter().map(|(_, own)| *own).collect();
        let lane_groups = lanes.count.div_ceil(GROUP);
        let draws = draws.len() as u32;
        queue.write_buffer(&table, 0, bytemuck::cast_slice(&ends));
        queue.write_buffer(&arguments, 0, bytemuck::cast_slice(&all));
        let numbers = [lanes.count, lane_groups, draws, source.listed as u32];
        queue.write_buffer(&which, 0, bytemuck::cast_slice(&numbers));
        let resources = [
            &lanes.lanes,
            &lanes.words,
            &lanes.places,
            &table,
            source.bits,
            source.seen,
            &list,
            &arguments,
            &which,
        ]
        .map(|b| b.as_entire_binding());
        let group = group(device, "lists", &pass.layout, &resources);
        Ok(Self { list, arguments, which, group, lane_groups, draws })
    }

    /// Slots, u32 each; those of a bucket from its first lane on.
    #[must_use]
    pub fn list(&self) -> &Buffer {
        &self.list
    }

    /// [`DrawArguments`] of each draw.
    #[must_use]
    pub fn arguments(&self) -> &Buffer {
        &self.arguments
    }

    /// How many lanes there are, in groups, and how many draws.
    pub(crate) fn numbers(&self) -> (&Buffer, u32) {
        (&self.which, self.lane_groups)
    }

    /// Bytes that it takes on the device.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.list.size() + self.arguments.size()
    }
}
