//! Detail: what is too small on the screen, and what covers no sample.

use super::super::evidence::{Evidence, Finding};
use super::super::frame::Frame;
use super::super::log::Log;
use super::super::run::is_parted;
use super::super::sets::{Clusters, Instances, Sets, slots};
use super::occlusion;
use crate::array;
use crate::bits;
use crate::bounds::{Aabb, LANES};
use crate::cull::detail::samples::SampleTest;
use crate::cull::detail::{BatchSizes, Detail};
use crate::funnel::Stage;
use crate::view::SizeBounds;

/// Drops instances whose projected box is below the threshold: whole nodes of the hierarchy at once, where no box below
/// them can be as large.
pub(in super::super) fn instances(frame: &Frame<'_>, set: &mut Instances, log: &mut Log<'_>) {
    let Some(detail) = frame.culler.detail else { return };
    let scene = frame.scene;
    let sizes = Sizes {
        frame,
        detail,
        bounds: SizeBounds::of_world(frame.view, scene.origin()),
        batch: BatchSizes::new(frame.view, scene.origin(), &detail),
    };
    // Of the nodes above a word: words ascend.
    let mut above = Decided::NONE;
    let dropped = set.filter(scene, Stage::Detail, log, |word, tested| {
        // Four words below a node over 256 slots, of which sixteen are decided at once.
        if above.number != word / 64 {
            above = sizes.of_nodes(word / 64);
        }
        let lane = word / 4 % LANES;
        if above.small >> lane & 1 != 0 {
            return tested;
        }
        if above.large >> lane & 1 != 0 {
            return 0;
        }
        let mut small = 0;
        let wanted = (0..4).fold(0, |wanted, part| {
            let own = tested >> (part * LANES) & 0xffff;
            wanted | u8::from(own != 0) << part
        });
        if wanted != 0 {
            let (surely, doubtful) = sizes.of_blocks(word, wanted);
            small |= tested & surely;
            let found = slots(word, tested & doubtful).filter(|&slot| sizes.is_small(slot));
            small = found.fold(small, |small, slot| small | 1 << (slot % 64));
        }
        small
    });
    log.instance_row(Stage::Detail, dropped);
}

/// The level of the nodes that are decided: over 256 instances. Those over 16 were, too: at a threshold at which
/// few of them are decided, that took more than it gained.
const LEVEL: usize = 1;

/// Decisions on the nodes of one block of sixteen.
#[derive(Clone, Copy, Debug)]
struct Decided {
    /// Number of the block; `usize::MAX` for none.
    number: usize,
    /// One bit each: all instances below are surely small; none is.
    small: u16,
    large: u16,
}

impl Decided {
    const NONE: Self = Self { number: usize::MAX, small: 0, large: 0 };
}

struct Sizes<'a> {
    frame: &'a Frame<'a>,
    detail: Detail,
    bounds: SizeBounds,
    batch: BatchSizes,
}

impl Sizes<'_> {
    /// Decides sixteen nodes.
    fn of_nodes(&self, number: usize) -> Decided {
        let scene = self.frame.scene;
        let nodes = scene.hierarchy().nodes();
        let none = Decided { number, ..Decided::NONE };
        let Some(block) = nodes.levels().get(LEVEL).and_then(|boxes| boxes.blocks().get(number))
        else {
            return none;
        };
        let first = number * LANES;
        let sizes = nodes.sizes_below(LEVEL).get(first..).unwrap_or_default();
        let slots = LANES.pow(LEVEL as u32 + 1);
        // Slots that came since the nodes were made are below none.
        let covered = (nodes.len() / slots).saturating_sub(first).min(LANES);
        let weights = scene.size_weights(0).map(|_| {
            array::from_fn(|lane| {
                let from = (first + lane) * slots;
                scene.largest_size_weight(from..from + slots)
            })
        });
        let level = self.frame.culler.level;
        let (small, large) = self.batch.decide_nodes(level, block, sizes, weights.as_ref());
        let mask = ((1_u32 << covered) - 1) as u16;
        Decided { number, small: small & mask, large: large & mask }
    }

    /// One bit each for the slots of some of the four blocks of a word that are surely small, and for those that may be.
    fn of_blocks(&self, word: usize, wanted: u8) -> (u64, u64) {
        let scene = self.frame.scene;
        let blocks = scene.boxes().blocks();
        let blocks = &blocks[word * 4..(word * 4 + 4).min(blocks.len())];
        let weights = scene.size_weights(0).map(|_| {
            let mut weights = [[1.0; LANES]; 4];
            for (part, weights) in weights.iter_mut().enumerate() {
                let own = scene.size_weights((word * 4 + part) * LANES).unwrap_or_default();
                weights[..own.len()].copy_from_slice(own);
            }
            weights
        });
        let level = self.frame.culler.level;
        let (small, large) = self.batch.decide(level, blocks, wanted, weights.as_ref());
        let of_wanted = (0..4).fold(0, |all, part| {
            all | ((u64::from(wanted >> part & 1) * 0xffff) << (part * LANES))
        });
        (small, of_wanted & !small & !large)
    }

    /// Whether an instance is small: by its projected box, where a cheaper bound does not say so.
    fn is_small(&self, slot: u32) -> bool {
        let scene = self.frame.scene;
        let (bounds, weight) = (scene.bounds(slot), f64::from(scene.size_weight(slot)));
        let is_small = |size| self.detail.is_small_size(size, weight);
        self.bounds.of_box(&bounds).is_some_and(is_small)
            || projected(self.frame, &bounds).is_some_and(is_small)
    }
}

fn projected(frame: &Frame<'_>, bounds: &Aabb) -> Option<[f64; 2]> {
    let rectangle = frame.view.project_box(bounds, frame.scene.origin())?;
    Some([rectangle.width(), rectangle.height()])
}

/// Whether clusters are dropped by themselves where they are small.
pub(super) fn drops_clusters(frame: &Frame<'_>) -> bool {
    frame.culler.detail.is_some_and(|detail| detail.clusters)
}

/// The same of an instance.
pub(super) fn may_drop_clusters(frame: &Frame<'_>, slot: u32) -> bool {
    drops_clusters(frame)
        && is_parted(frame.scene.mesh(slot))
        && frame.scene.is_rigid(slot)
        && !bits::get(frame.scene.exempt(), slot as usize)
}

/// Drops clusters of rigid instances whose size is surely below the threshold, where the settings ask for it. An occluder
/// keeps all of its clusters, for it has hidden other instances as a whole.
pub(in super::super) fn clusters(
    frame: &Frame<'_>,
    hidden: &occlusion::Cache,
    set: &mut Clusters,
    log: &mut Log<'_>,
) {
    let Some(detail) = frame.culler.detail.filter(|detail| detail.clusters) else { return };
    let scene = frame.scene;
    set.filter(scene, Stage::Detail, log, |runs, culled| {
        let slot = runs[0].slot;
        if !may_drop_clusters(frame, slot) || hidden.has_drawn(slot) {
            return false;
        }
        let weight = f64::from(scene.size_weight(slot));
        let bounds = SizeBounds::of_object(frame.view, scene.transform(slot));
        let boxes = scene.meshes()[runs[0].mesh as usize].cluster_boxes();
        culled.clear();
        culled.resize(boxes.len().div_ceil(64), 0);
        for run in runs {
            for cluster in run.first_cluster..run.first_cluster + run.cluster_count {
                let size = bounds.of_box(&boxes.get(cluster as usize));
                if size.is_some_and(|size| detail.is_small_size(size, weight)) {
                    culled[cluster as usize / 64] |= 1 << (cluster % 64);
                }
            }
        }
        true
    });
}

/// Drops triangles that cover no sample.
pub(in super::super) fn triangles(frame: &Frame<'_>, sets: &mut Sets, log: &mut Log<'_>) {
    let Some(pattern) = frame.culler.samples else { return };
    let scene = frame.scene;
    sets.triangles.filter(&sets.clusters.runs, Stage::Detail, log, |range, triangles, kept| {
        let slot = range.slot;
        if !scene.is_rigid(slot) || bits::get(scene.exempt(), slot as usize) {
            return false;
        }
        let mesh = scene.mesh_at(slot, range.level);
        // Those without area are another stage's.
        let drawn = mesh.degenerate_triangles().start;
        let test = SampleTest::new(frame.view, scene.transform(slot).to_matrix(), pattern);
        let is_kept = |t: &u32| *t >= drawn || !test.covers_none(&mesh.corners(*t));
        kept.extend(triangles.iter().copied().filter(is_kept));
        true
    });
}

/// The size of an instance on the screen.
pub(in super::super) fn finding(frame: &Frame<'_>, slot: u32) -> Finding {
    let times = frame.scene.size_weight(slot);
    let weight = match times {
        1.0 => String::new(),
        weight => format!(", counted {weight} times"),
    };
    match projected(frame, &frame.scene.bounds(slot)) {
        Some(pixels @ [w, h]) => Finding::new(
            format!("{w:.2} x {h:.2} pixels on the screen{weight}"),
            Evidence::Size { pixels, weight: times },
        ),
        None => "crosses the near plane, so it is never small".into(),
    }
}
