//! Detail: what is too small on the screen.

use super::super::evidence::Evidence;
use super::super::frame::Frame;
use super::super::log::Log;
use super::super::run::is_parted;
use super::super::sets::{Clusters, Instances};
use super::occlusion;
use crate::array;
use crate::bits;
use crate::bounds::LANES;
use crate::cull::detail::{Detail, NodeSizes, SizeTest};
use crate::funnel::Stage;
use crate::transform::Transform;

/// Drops instances whose projected box is below the threshold. Whole nodes of the hierarchy go or
/// stay at once, where no box below them can be as large, or as small.
pub(in super::super) fn instances(frame: &Frame<'_>, set: &mut Instances, log: &mut Log<'_>) {
    let Some(detail) = frame.culler.detail_settings() else { return };
    let sizes = Sizes { frame, test: of_world(frame, &detail) };
    // The nodes above a word, sixteen at once: words ascend.
    let (mut number, mut nodes) = (usize::MAX, NodeSizes::default());
    let dropped = set.filter(frame.scene, Stage::Detail, log, |word, tested| {
        // Four words below a node over 256 slots.
        if number != word / 64 {
            (number, nodes) = (word / 64, sizes.of_nodes(word / 64));
        }
        let node = word / 4 % LANES;
        if nodes.small >> node & 1 != 0 {
            return tested;
        }
        if nodes.kept >> node & 1 != 0 {
            return 0;
        }
        sizes.small((&nodes, node), word, tested)
    });
    log.instance_row(Stage::Detail, dropped);
}

/// The level of the nodes that are decided: over 256 instances. Those over 16 were, too: at a
/// threshold at which few of them are decided, that took more than it gained.
const LEVEL: usize = 1;

/// The test of boxes relative to the scene's origin.
fn of_world(frame: &Frame<'_>, detail: &Detail) -> SizeTest {
    let view = frame.view;
    let place = Transform::from_translation(frame.scene.origin()).to_matrix();
    SizeTest::new(view.depth_rows(&place), view.viewport(), detail)
}

struct Sizes<'a> {
    frame: &'a Frame<'a>,
    test: SizeTest,
}

impl Sizes<'_> {
    /// Returns what sixteen nodes say of the boxes below them.
    fn of_nodes(&self, number: usize) -> NodeSizes {
        let scene = self.frame.scene;
        let nodes = scene.hierarchy().nodes();
        let block = nodes.levels().get(LEVEL).and_then(|boxes| boxes.blocks().get(number));
        let Some(block) = block else { return NodeSizes::default() };
        let first = number * LANES;
        let spans = nodes.spans_below(LEVEL).get(first..).unwrap_or_default();
        let slots = LANES.pow(LEVEL as u32 + 1);
        // Slots that came since the nodes were made are below none.
        let covered = (nodes.len() / slots).saturating_sub(first).min(LANES);
        let weights = scene.size_weights(0).map(|_| {
            array::from_fn(|lane| {
                let from = (first + lane) * slots;
                scene.largest_size_weight(from..from + slots)
            })
        });
        let simd = self.frame.culler.simd;
        let found = self.test.of_nodes(simd, block, spans, weights.as_ref());
        found.only(((1_u32 << covered) - 1) as u16)
    }

    /// Returns which of the slots of a word that are `tested` are small, by the node above it where
    /// that knows.
    fn small(&self, node: (&NodeSizes, usize), word: usize, tested: u64) -> u64 {
        let scene = self.frame.scene;
        let simd = self.frame.culler.simd;
        let blocks = scene.boxes().blocks();
        let blocks = &blocks[word * 4..(word * 4 + 4).min(blocks.len())];
        if let Some(small) = self.test.small_below(simd, node, blocks, tested) {
            return small;
        }
        let wanted = (0..4).fold(0, |wanted, part| {
            let own = tested >> (part * LANES) & 0xffff;
            wanted | u8::from(own != 0) << part
        });
        let weights = scene.size_weights(0).map(|_| {
            let mut weights = [[1.0; LANES]; 4];
            for (part, weights) in weights.iter_mut().enumerate() {
                let own = scene.size_weights((word * 4 + part) * LANES).unwrap_or_default();
                weights[..own.len()].copy_from_slice(own);
            }
            weights
        });
        tested & self.test.small(simd, blocks, wanted, weights.as_ref())
    }
}

/// Whether clusters are dropped by themselves where they are small.
pub(super) fn drops_clusters(frame: &Frame<'_>) -> bool {
    frame.culler.detail_settings().is_some_and(|detail| detail.clusters)
}

/// The same of an instance.
pub(super) fn may_drop_clusters(frame: &Frame<'_>, slot: u32) -> bool {
    drops_clusters(frame)
        && is_parted(frame.scene.mesh(slot))
        && frame.scene.is_rigid(slot)
        && !bits::get(frame.scene.exempt(), slot as usize)
}

/// Drops clusters of rigid instances whose size is surely below the threshold, where the settings
/// ask for it. An occluder keeps all of its clusters, for it has hidden other instances as a whole.
pub(in super::super) fn clusters(
    frame: &Frame<'_>,
    hidden: &occlusion::Cache,
    set: &mut Clusters,
    log: &mut Log<'_>,
) {
    let Some(detail) = frame.culler.detail_settings().filter(|detail| detail.clusters) else {
        return;
    };
    let scene = frame.scene;
    set.filter(scene, Stage::Detail, log, |runs, culled| {
        let slot = runs[0].slot;
        if !may_drop_clusters(frame, slot) || hidden.has_drawn(slot) {
            return false;
        }
        let (view, place) = (frame.view, scene.transform(slot).to_matrix());
        let test = SizeTest::new(view.depth_rows(&place), view.viewport(), &detail);
        let weights = [[scene.size_weight(slot); LANES]; 4];
        let boxes = scene.meshes()[runs[0].mesh as usize].cluster_boxes();
        culled.clear();
        culled.resize(boxes.len().div_ceil(64), 0);
        for run in runs {
            let clusters =
                run.first_cluster as usize..(run.first_cluster + run.cluster_count) as usize;
            for (word, own) in bits::words_of(clusters) {
                let blocks = &boxes.blocks()[word * 4..];
                let small = test.small(frame.culler.simd, blocks, 0xf, Some(&weights));
                culled[word] |= small & own;
            }
        }
        true
    });
}

/// Returns the size of an instance on the screen.
pub(in super::super) fn evidence(frame: &Frame<'_>, slot: u32) -> Evidence {
    let test = of_world(frame, &frame.culler.detail_settings().unwrap_or_default());
    match test.bound(frame.culler.simd, &frame.scene.bounds(slot)) {
        Some(pixels) => Evidence::Size { pixels, weight: frame.scene.size_weight(slot) },
        None => Evidence::NearPlane,
    }
}
