//! Units that are culled, instances or clusters of them, and how they are drawn.

use cullet::{Scene, Visible};
use wgpu::{Buffer, BufferUsages, CommandEncoder, Device, Queue, RenderPass};

use super::buffers::buffer;
use super::cluster_draws::ClusterDraws;
use super::clusters::{ClusterInstances, levels_of};
use super::error::GpuError;
use super::geometry::{Draw, GpuScene};
use super::lanes::Lanes;
use super::lists::{DrawArguments, LaneBuffers, ListSource, Listed, SlotList};
use super::passes::Passes;
use super::tier::Tier;

/// When something is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Units in the view that were visible in the frame before: drawn first, so that the pyramid is
    /// made of them.
    Early,
    /// Units that are visible and were not before.
    Late,
    /// All units that are blended: after the others, and hiding nothing.
    Blended,
}

/// Kind of unit that is culled, and how draws are handed in. The picture is the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DrawMode {
    /// Instances; one draw after the other for each bucket of those that are alike.
    #[default]
    Each,
    /// Instances; all draws that are alike but for their mesh in one call, for scenes of many
    /// meshes. Takes [`Tier::MultiDraw`].
    Multi,
    /// Clusters of instances, each a draw of its own, those that are alike in one call: for scenes
    /// of large meshes. As [`Multi`](Self::Multi).
    Clusters,
    /// The same with the draws of one instance alone, whose number the device knows: for scenes of
    /// which little is visible. Takes [`Tier::MultiDrawCount`].
    Counted,
}

impl DrawMode {
    /// The least tier of a device that can draw so.
    #[must_use]
    pub fn tier(self) -> Tier {
        match self {
            Self::Each => Tier::Compute,
            Self::Multi | Self::Clusters => Tier::MultiDraw,
            Self::Counted => Tier::MultiDrawCount,
        }
    }

    /// Whether a device can draw so.
    #[must_use]
    pub fn is_offered(self, device: &Device) -> bool {
        self.tier() <= Tier::of(device)
    }

    /// Returns the mode that suits a scene, among those the device can do: clusters where there are
    /// at most 65,536 and eight or more to an instance.
    #[must_use]
    pub fn of(device: &Device, scene: &Scene) -> Self {
        if !Self::Multi.is_offered(device) {
            return Self::Each;
        }
        let of = |slot| u64::from(scene.mesh(slot).cluster_count());
        let clusters: u64 = scene.slots().map(of).sum();
        let many = clusters >= 8 * u64::from(scene.instance_count());
        match many && clusters <= 1 << 16 {
            false => Self::Multi,
            true if Self::Counted.is_offered(device) => Self::Counted,
            true => Self::Clusters,
        }
    }
}

/// Units that are culled, and their lists or arguments by phase.
#[derive(Debug)]
pub(crate) enum Units {
    Instances {
        lanes: Lanes,
        buffers: LaneBuffers,
        lists: Box<[SlotList; 3]>,
        draws: [Vec<Draw>; 3],
        mode: DrawMode,
    },
    Clusters {
        clusters: ClusterInstances,
        slots: Buffer,
        draws: ClusterDraws,
        mode: DrawMode,
    },
}

/// Bits that are drawn in each phase.
const LISTED: [Listed; 3] = [Listed::Seen, Listed::New, Listed::All];

impl Units {
    pub(crate) fn instances(
        (device, queue, passes): (&Device, &Queue, &Passes),
        (scene, on_device): (&Scene, &GpuScene),
        [passed, visible, seen]: [&Buffer; 3],
        mode: DrawMode,
    ) -> Result<Self, GpuError> {
        let lanes = Lanes::of(scene);
        let buffers = LaneBuffers::new(device, queue, &lanes)?;
        let (blended, opaque): (Vec<_>, Vec<_>) =
            on_device.draws(&lanes).into_iter().partition(|draw| draw.blended);
        let draws = [opaque.clone(), opaque, blended];
        let list = |phase: usize, bits| {
            let first_instance = |draw: &Draw| match mode {
                DrawMode::Each => 0,
                _ => lanes.buckets()[draw.bucket as usize].lanes.start,
            };
            let with_first = |draw: &Draw| {
                let first_instance = first_instance(draw);
                (draw.bucket, DrawArguments { first_instance, ..draw.arguments })
            };
            let draws: Vec<_> = draws[phase].iter().map(with_first).collect();
            let source = ListSource { bits, seen, listed: LISTED[phase] };
            SlotList::new(device, queue, &passes.lists, &buffers, &draws, source)
        };
        let lists = Box::new([list(0, passed)?, list(1, visible)?, list(2, visible)?]);
        Ok(Self::Instances { lanes, buffers, lists, draws, mode })
    }

    pub(crate) fn clusters(
        (device, queue, passes): (&Device, &Queue, &Passes),
        clusters: ClusterInstances,
        [passed, visible, seen]: [&Buffer; 3],
        mode: DrawMode,
    ) -> Result<Self, GpuError> {
        let usage = BufferUsages::VERTEX | BufferUsages::COPY_DST;
        let slots = buffer(device, "slots of clusters", clusters.slots().len(), 4, usage)?;
        queue.write_buffer(&slots, 0, bytemuck::cast_slice(clusters.slots()));
        let of = |phase: usize, bits| ListSource { bits, seen, listed: LISTED[phase] };
        let sources = [of(0, passed), of(1, visible), of(2, visible)];
        let on = (device, queue, passes);
        let draws = ClusterDraws::new(on, &clusters, sources, mode == DrawMode::Counted)?;
        Ok(Self::Clusters { clusters, slots, draws, mode })
    }

    /// A bit for each unit that is listed, in so many words. O(slots + clusters).
    pub(crate) fn bits_of(&self, scene: &Scene, visible: &Visible, words: usize) -> Vec<u32> {
        let mut whole = vec![false; scene.slot_count() as usize];
        for range in &visible.whole {
            whole[range.first as usize..][..range.count as usize].fill(true);
        }
        let mut bits = vec![0_u32; words];
        let mut set = |number: u32| bits[number as usize / 32] |= 1 << (number % 32);
        match self {
            Self::Instances { .. } => {
                visible.partial.iter().for_each(|of| whole[of.slot as usize] = true);
                (0..).zip(&whole).filter(|(_, own)| **own).for_each(|(slot, _)| set(slot));
            }
            Self::Clusters { clusters, .. } => {
                // Of other levels than those that are here the mesh itself is drawn.
                for of in visible.partial.iter().filter(|of| of.level > 0) {
                    let known = levels_of(scene, scene.mesh_id(of.slot)).map(|(level, ..)| level);
                    whole[of.slot as usize] |= known != Some(of.level);
                }
                // In the order of slots.
                let listed = |slot: u32, level: u32, cluster: u32| {
                    let first = visible.partial.partition_point(|of| of.slot < slot);
                    let own = visible.partial[first..].iter().take_while(|of| of.slot == slot);
                    own.clone().any(|of| {
                        let clusters = of.first_cluster..of.first_cluster + of.cluster_count;
                        of.level == level && clusters.contains(&cluster)
                    })
                };
                let units = clusters.slots().iter().zip(clusters.levels()).zip(clusters.clusters());
                for (number, ((&slot, &level), &cluster)) in (0..).zip(units) {
                    let is_whole = level == 0 && whole[slot as usize];
                    if is_whole || listed(slot, level, cluster) {
                        set(number);
                    }
                }
            }
        }
        bits
    }

    pub(crate) fn has_blended(&self) -> bool {
        match self {
            Self::Instances { draws, .. } => !draws[2].is_empty(),
            Self::Clusters { clusters, .. } => clusters.runs().iter().any(|run| run.0.blended),
        }
    }

    pub(crate) fn record(&self, passes: &Passes, encoder: &mut CommandEncoder, phase: Phase) {
        match self {
            Self::Instances { lists, .. } => passes.lists.record(encoder, &lists[phase as usize]),
            Self::Clusters { draws, .. } => draws.record(passes, encoder, phase as usize),
        }
    }

    pub(crate) fn draw<'p>(
        &self,
        pass: &mut RenderPass<'p>,
        phase: Phase,
        prepare: &mut impl FnMut(&mut RenderPass<'p>, &Draw) -> bool,
    ) {
        const SIZE: u64 = size_of::<DrawArguments>() as u64;
        match self {
            Self::Clusters { clusters, slots, draws, .. } => {
                pass.set_vertex_buffer(1, slots.slice(..));
                for (call, (draw, numbers)) in clusters.runs().iter().enumerate() {
                    if draw.blended == (phase == Phase::Blended) && prepare(pass, draw) {
                        draws.draw(pass, phase as usize, (call, numbers));
                    }
                }
            }
            Self::Instances { lanes, lists, draws, mode, .. } => {
                let list = &lists[phase as usize];
                pass.set_vertex_buffer(1, list.list().slice(..));
                let alike = |a: &Draw, b: &Draw| *mode == DrawMode::Multi && a.way() == b.way();
                let mut first = 0;
                for together in draws[phase as usize].chunk_by(alike) {
                    let offset = first * SIZE;
                    first += together.len() as u64;
                    if !prepare(pass, &together[0]) {
                        continue;
                    }
                    if *mode == DrawMode::Multi {
                        let count = together.len() as u32;
                        pass.multi_draw_indexed_indirect(list.arguments(), offset, count);
                    } else {
                        let lanes = &lanes.buckets()[together[0].bucket as usize].lanes;
                        let bytes = u64::from(lanes.start) * 4..u64::from(lanes.end) * 4;
                        pass.set_vertex_buffer(1, list.list().slice(bytes));
                        pass.draw_indexed_indirect(list.arguments(), offset);
                    }
                }
            }
        }
    }

    pub(crate) fn arguments(&self, phase: Phase) -> (&Buffer, usize) {
        match self {
            Self::Instances { lists, draws, .. } => {
                (lists[phase as usize].arguments(), draws[phase as usize].len())
            }
            Self::Clusters { clusters, draws, .. } => draws.arguments(phase as usize, clusters),
        }
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        match self {
            Self::Instances { buffers, lists, .. } => {
                buffers.bytes() + lists.iter().map(SlotList::bytes).sum::<u64>()
            }
            Self::Clusters { draws, slots, .. } => slots.size() + draws.bytes(),
        }
    }
}
