//! Slots in the order in which they are drawn: by what one call can draw. Pure computation.

use std::ops::Range;

use cullet::{MeshId, Scene};

/// How instances differ in the way they are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Kind {
    /// Whether they are blended, whatever their mesh says.
    pub transparent: bool,
    /// Their mesh.
    pub mesh: MeshId,
    /// Whether their transform mirrors, so that front faces are clockwise.
    pub mirrored: bool,
    /// Whether both sides are drawn, whatever their mesh says.
    pub two_sided: bool,
}

/// Instances of one kind: some lanes, one after the other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bucket {
    /// Properties that its instances have in common.
    pub kind: Kind,
    /// Range of its lanes.
    pub lanes: Range<u32>,
}

/// A lane for each slot that can be drawn, in buckets; slots ascend within a bucket, so that where
/// two surfaces are equally near it is always the same that is drawn first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Lanes {
    slots: Vec<u32>,
    buckets: Vec<Bucket>,
}

impl Lanes {
    /// The instances of a scene. Those with a transform that is not finite are never drawn, as
    /// levels of detail are not by themselves. O(n log n).
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        let mut all: Vec<(Kind, u32)> =
            drawable(scene).map(|slot| (kind_of(scene, slot), slot)).collect();
        all.sort_unstable();
        let mut made =
            Self { slots: all.iter().map(|(_, slot)| *slot).collect(), ..Self::default() };
        let mut first = 0;
        for same in all.chunk_by(|a, b| a.0 == b.0) {
            let end = first + same.len() as u32;
            made.buckets.push(Bucket { kind: same[0].0, lanes: first..end });
            first = end;
        }
        made
    }

    /// Whether they are [those](Self::of) of a scene. O(n).
    #[must_use]
    pub fn are_of(&self, scene: &Scene) -> bool {
        let has = |kind: &Kind, slot: u32| {
            slot < scene.slot_count() && can_be_drawn(scene, slot) && kind_of(scene, slot) == *kind
        };
        // As many, each of its kind: the same.
        drawable(scene).count() == self.slots.len()
            && self.split().all(|(bucket, slots)| slots.iter().all(|slot| has(&bucket.kind, *slot)))
    }

    /// One bucket of all slots, for those who want to know what is visible and nothing else.
    #[must_use]
    pub fn by_slot(count: u32) -> Self {
        Self::numbered(vec![Bucket { kind: Kind::default(), lanes: 0..count }])
    }

    /// Buckets that follow each other, whose lanes are what is drawn.
    pub(crate) fn numbered(buckets: Vec<Bucket>) -> Self {
        let end = buckets.last().map_or(0, |bucket| bucket.lanes.end);
        Self { slots: (0..end).collect(), buckets }
    }

    /// Each bucket with its slots.
    pub(crate) fn split(&self) -> impl Iterator<Item = (&Bucket, &[u32])> {
        let slots = |b: &Bucket| &self.slots[b.lanes.start as usize..b.lanes.end as usize];
        self.buckets.iter().map(move |bucket| (bucket, slots(bucket)))
    }

    /// The slot of each lane.
    #[must_use]
    pub fn slots(&self) -> &[u32] {
        &self.slots
    }

    /// The buckets, in order and without gap.
    #[must_use]
    pub fn buckets(&self) -> &[Bucket] {
        &self.buckets
    }
}

fn can_be_drawn(scene: &Scene, slot: u32) -> bool {
    !scene.is_removed(slot) && scene.transform(slot).is_finite()
}

fn drawable(scene: &Scene) -> impl Iterator<Item = u32> + '_ {
    (0..scene.slot_count()).filter(|slot| can_be_drawn(scene, *slot))
}

fn kind_of(scene: &Scene, slot: u32) -> Kind {
    let flags = scene.flags(slot);
    Kind {
        transparent: flags.transparent,
        mesh: scene.mesh_id(slot),
        mirrored: scene.transform(slot).determinant() < 0.0,
        two_sided: flags.double_sided,
    }
}
