//! Targets of sight: instances or clusters, by number.

use cullet::Scene;
use glam::DVec3;

use super::SampledError;

/// Kind of item that the bits of a row stand for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Granularity {
    /// Instances, by the index of their handle.
    #[default]
    Instance,
    /// Clusters of instances: the instance's [first](Targets::first) and the number of the cluster
    /// in its mesh.
    Cluster,
}

/// Numbers of what may be seen: the columns of the rows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Targets {
    granularity: Granularity,
    /// First number of each instance, by the index of its handle, and one more at the end.
    first: Vec<u32>,
}

impl Targets {
    /// Most numbers that there may be.
    const LIMIT: u32 = 1 << 31;

    pub(super) fn new(scene: &Scene, granularity: Granularity) -> Result<Self, SampledError> {
        let mut counts = Vec::new();
        for slot in scene.slots() {
            let Some(handle) = scene.handle(slot) else { continue };
            let at = handle.index as usize;
            if counts.len() <= at {
                counts.resize(at + 1, 0_u64);
            }
            counts[at] = match granularity {
                Granularity::Instance => 1,
                Granularity::Cluster => scene.mesh(slot).clusters().len() as u64,
            };
        }
        // An index without an instance keeps its number, so that a bit is found without a table.
        if granularity == Granularity::Instance {
            counts.iter_mut().for_each(|n| *n = 1);
        }
        let total = counts.iter().sum::<u64>();
        if total > u64::from(Self::LIMIT) {
            return Err(SampledError::Targets { targets: total, limit: Self::LIMIT });
        }
        let mut first = vec![0];
        let mut sum = 0;
        first.extend(counts.iter().map(|&n| {
            sum += n as u32;
            sum
        }));
        Ok(Self { granularity, first })
    }

    /// Returns the kind of item that the numbers stand for.
    #[must_use]
    pub fn granularity(&self) -> Granularity {
        self.granularity
    }

    /// How many there are.
    #[must_use]
    pub fn count(&self) -> u32 {
        self.first.last().copied().unwrap_or(0)
    }

    /// First number of the instance whose handle has this index; for instances that is the index
    /// itself. `None` beyond the last.
    #[must_use]
    pub fn first(&self, index: u32) -> Option<u32> {
        self.range(index).map(|range| range.start)
    }

    /// The numbers of the instance whose handle has this index; `None` beyond the last.
    #[must_use]
    pub fn range(&self, index: u32) -> Option<std::ops::Range<u32>> {
        let end = *self.first.get(index as usize + 1)?;
        Some(self.first[index as usize]..end)
    }

    /// The index of the instance that a number is of. The number must be one.
    pub(super) fn index_of(&self, target: u32) -> u32 {
        match self.granularity {
            Granularity::Instance => target,
            Granularity::Cluster => self.first.partition_point(|&first| first <= target) as u32 - 1,
        }
    }
}

/// A ball around a target, in the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ball {
    pub(super) center: DVec3,
    pub(super) radius: f64,
}

impl Ball {
    /// The smallest around a box.
    pub(super) fn around([low, high]: [DVec3; 2]) -> Self {
        Self { center: (low + high) * 0.5, radius: (high - low).length() * 0.5 }
    }
}
