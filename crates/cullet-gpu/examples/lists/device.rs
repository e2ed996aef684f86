//! The passes on a device, as little as there is: eight storage buffers a stage, no optional feature.

use bytemuck::Pod;
use cullet::Scene;
use cullet_gpu::{
    BlockPlanes, Blocks, DrawArguments, Gpu, GpuError, InstanceBits, LaneBuffers, Lanes,
    ListSource, Listed, Passes, SlotList, Tier,
};
use wgpu::{BufferDescriptor, BufferUsages, Features, Limits};

use super::lists::Lists;

/// A device with no optional feature and the least limits that a browser with WebGPU grants.
///
/// # Errors
/// If no adapter runs compute passes.
pub(crate) async fn least() -> Result<Gpu, GpuError> {
    Gpu::request(Tier::Compute, Features::empty(), Some(Limits::default())).await
}

/// Lister of the instances of one scene on a device.
#[derive(Debug)]
pub(crate) struct Listing<'g> {
    gpu: &'g Gpu,
    passes: &'g Passes,
    bits: InstanceBits,
    seen: wgpu::Buffer,
    /// Lists of all, of those seen before, and of those that are new.
    lists: [SlotList; 3],
    lanes: Lanes,
}

impl<'g> Listing<'g> {
    /// Uploads a scene.
    ///
    /// # Errors
    /// If the device has no room for it.
    pub(crate) fn new(
        (gpu, passes): (&'g Gpu, &'g Passes),
        scene: &Scene,
        blocks: &Blocks,
    ) -> Result<Self, GpuError> {
        let (device, queue) = (&gpu.device, &gpu.queue);
        let bits = InstanceBits::new(device, queue, &passes.instances, blocks, 32)?;
        let seen = device.create_buffer(&BufferDescriptor {
            label: Some("seen"),
            size: bits.bits().size(),
            usage: BufferUsages::STORAGE | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let lanes = Lanes::of(scene);
        let buffers = LaneBuffers::new(device, queue, &lanes)?;
        let buckets = 0..lanes.buckets().len() as u32;
        let draws: Vec<_> = buckets.map(|bucket| (bucket, DrawArguments::default())).collect();
        let list = |listed| {
            let source = ListSource { bits: bits.bits(), seen: &seen, listed };
            SlotList::new(device, queue, &passes.lists, &buffers, &draws, source)
        };
        let lists = [list(Listed::All)?, list(Listed::Seen)?, list(Listed::New)?];
        Ok(Self { gpu, passes, bits, seen, lists, lanes })
    }

    /// The bits and lists of a view; seen before are those of the view before.
    ///
    /// # Errors
    /// If the device is lost.
    pub(crate) async fn list(&mut self, planes: &BlockPlanes) -> Result<Lists, GpuError> {
        self.bits.set(&self.gpu.queue, planes)?;
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(self.bits.bits(), 0, &self.seen, 0, None);
        self.passes.instances.record(&mut encoder, &self.bits, planes);
        self.lists.iter().for_each(|list| self.passes.lists.record(&mut encoder, list));
        self.gpu.queue.submit([encoder.finish()]);
        let bits = self.read(self.bits.bits()).await?;
        let mut lists = [const { Vec::new() }; 3];
        for (from, to) in self.lists.iter().zip(&mut lists) {
            let arguments: Vec<u32> = self.read(from.arguments()).await?;
            let slots: Vec<u32> = self.read(from.list()).await?;
            for (bucket, draw) in self.lanes.buckets().iter().zip(arguments.chunks_exact(5)) {
                let first = bucket.lanes.start as usize;
                let end = (first + draw[1] as usize).min(slots.len());
                to.push(slots[first.min(end)..end].to_vec());
            }
        }
        Ok(Lists { bits, lists })
    }

    async fn read<T: Pod>(&self, buffer: &wgpu::Buffer) -> Result<Vec<T>, GpuError> {
        let bytes = self.gpu.read_later(buffer, buffer.size()).await?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }
}
