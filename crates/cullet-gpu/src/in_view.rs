//! List of what of a scene is in a view: from the device, or from the CPU in its place.

use cullet::Scene;
use cullet::bounds::Plane;

use super::blocks::Blocks;
use super::checked::checked;
use super::device::Gpu;
use super::error::GpuError;
use super::instances::{InstanceBits, InstancePass};
use super::lanes::Lanes;
use super::lists::{DrawArguments, LaneBuffers, ListPass, ListSource, Listed, SlotList};
use super::planes::BlockPlanes;
use super::reference::visible_ref;
use super::tier::Tier;

/// Lists what of a scene is in a view, for programs that want to know and draw nothing.
///
/// The device and the CPU list the same, byte for byte, so that the CPU may take over at any time.
/// It does [where asked to](Self::or_cpu), and [tells why](Self::why_cpu).
#[derive(Debug)]
pub struct InView<'g> {
    blocks: Blocks,
    planes: BlockPlanes,
    most_planes: usize,
    by: By<'g>,
    /// Whether the CPU takes over from a device that fails.
    or_cpu: bool,
}

/// Who lists.
#[derive(Debug)]
enum By<'g> {
    Device(&'g Gpu, Box<OnDevice>),
    Cpu(GpuError),
}

#[derive(Debug)]
struct OnDevice {
    instances: InstancePass,
    lists: ListPass,
    bits: InstanceBits,
    list: SlotList,
    slots: u32,
}

impl<'g> InView<'g> {
    /// Uploads the boxes of a scene, for views of up to so many planes. O(slots).
    ///
    /// # Errors
    /// If the device cannot run the passes, or has no room for the scene, or is lost.
    pub fn new(gpu: &'g Gpu, scene: &Scene, most_planes: usize) -> Result<Self, GpuError> {
        let blocks = Blocks::new(scene);
        let by = By::Device(gpu, Box::new(OnDevice::new(gpu, &blocks, most_planes)?));
        Ok(Self { blocks, planes: BlockPlanes::default(), most_planes, by, or_cpu: false })
    }

    /// The same, but where there is no device, or it fails now or later, the CPU lists.
    #[must_use]
    pub fn or_cpu(gpu: Result<&'g Gpu, GpuError>, scene: &Scene, most_planes: usize) -> Self {
        let blocks = Blocks::new(scene);
        let on = |gpu| Ok((gpu, OnDevice::new(gpu, &blocks, most_planes)?));
        let by = match gpu.and_then(on) {
            Ok((gpu, device)) => By::Device(gpu, Box::new(device)),
            Err(why) => By::Cpu(why),
        };
        Self { blocks, planes: BlockPlanes::default(), most_planes, by, or_cpu: true }
    }

    /// Follows a scene that changed, uploading what is new. O(slots) reading.
    ///
    /// # Errors
    /// As [`new`](Self::new), unless the CPU takes over.
    pub fn follow(&mut self, scene: &Scene) -> Result<(), GpuError> {
        self.blocks.update(scene);
        let By::Device(gpu, device) = &mut self.by else { return Ok(()) };
        // The list has a place for each slot, of which the last block may have more than before.
        let slots = self.blocks.slot_count();
        if slots == device.slots && device.bits.update(&gpu.queue, &self.blocks) {
            return Ok(());
        }
        match OnDevice::new(gpu, &self.blocks, self.most_planes) {
            Ok(made) => **device = made,
            Err(why) => return self.give_up(why),
        }
        Ok(())
    }

    /// The slots in some layers that none of the planes rejects, which point out and lie in the
    /// space of the scene's boxes, ascending.
    ///
    /// # Errors
    /// If the device is lost, or there are more planes than was said, unless the CPU takes over.
    pub fn list(&mut self, planes: &[Plane], layers: u32) -> Result<Vec<u32>, GpuError> {
        self.planes.set(&self.blocks, planes, layers);
        if let By::Device(gpu, device) = &mut self.by {
            match device.list(gpu, &self.planes) {
                Ok(list) => return Ok(list),
                Err(why) => self.give_up(why)?,
            }
        }
        Ok(visible_ref(&self.blocks, &self.planes))
    }

    /// Why the CPU lists, if it does.
    #[must_use]
    pub fn why_cpu(&self) -> Option<&GpuError> {
        match &self.by {
            By::Device(..) => None,
            By::Cpu(why) => Some(why),
        }
    }

    /// Bytes of boxes that were uploaded the last time.
    #[must_use]
    pub fn uploaded(&self) -> u64 {
        match &self.by {
            By::Device(_, device) => device.bits.uploaded(),
            By::Cpu(_) => 0,
        }
    }

    /// Hands over to the CPU, if that was asked for.
    fn give_up(&mut self, why: GpuError) -> Result<(), GpuError> {
        if !self.or_cpu {
            return Err(why);
        }
        self.by = By::Cpu(why);
        Ok(())
    }
}

impl OnDevice {
    fn new(gpu: &Gpu, blocks: &Blocks, most_planes: usize) -> Result<Self, GpuError> {
        Tier::Compute.demand(&gpu.device)?;
        checked(&gpu.device, || Self::upload(gpu, blocks, most_planes))?
    }

    fn upload(gpu: &Gpu, blocks: &Blocks, most_planes: usize) -> Result<Self, GpuError> {
        let (device, queue) = (&gpu.device, &gpu.queue);
        let (instances, lists) = (InstancePass::new(device), ListPass::new(device));
        let bits = InstanceBits::new(device, queue, &instances, blocks, most_planes)?;
        let slots = blocks.slot_count();
        let lanes = LaneBuffers::new(device, queue, &Lanes::by_slot(slots))?;
        let source = ListSource { bits: bits.bits(), seen: bits.bits(), listed: Listed::All };
        let draws = [(0, DrawArguments::default())];
        let list = SlotList::new(device, queue, &lists, &lanes, &draws, source)?;
        Ok(Self { instances, lists, bits, list, slots })
    }

    fn list(&mut self, gpu: &Gpu, planes: &BlockPlanes) -> Result<Vec<u32>, GpuError> {
        gpu.is_there()?;
        self.bits.set(&gpu.queue, planes)?;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        self.instances.record(&mut encoder, &self.bits, planes);
        self.lists.record(&mut encoder, &self.list);
        gpu.queue.submit([encoder.finish()]);
        let arguments: Vec<DrawArguments> = pod(&gpu.read(self.list.arguments(), 20)?);
        let count = arguments.first().map_or(0, |draw| draw.instance_count);
        Ok(pod(&gpu.read(self.list.list(), u64::from(count) * 4)?))
    }
}

fn pod<T: bytemuck::Pod>(bytes: &[u8]) -> Vec<T> {
    bytemuck::pod_collect_to_vec(bytes)
}
