//! The instances of a scene, grouped by what one call can draw. Pure computation.

use std::ops::Range;

use cullet::Scene;

/// How instances of one mesh differ in the way they are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Kind {
    pub(super) mesh: u32,
    pub(super) mirrored: bool,
    pub(super) two_sided: bool,
    pub(super) transparent: bool,
}

/// Instances of one kind, which are drawn by one call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Group {
    pub(super) kind: Kind,
    /// Where its slots stand in a list.
    pub(super) first: u32,
    /// How many instances there are.
    pub(super) count: u32,
}

/// The group of a slot that is never drawn.
pub(super) const NO_GROUP: u32 = u32::MAX;

/// The instances of a scene, grouped.
#[derive(Clone, Debug, Default)]
pub(super) struct Instances {
    /// Group of each slot, or [`NO_GROUP`].
    pub(super) group: Vec<u32>,
    /// Layers of each slot.
    pub(super) layers: Vec<u32>,
    /// Groups of instances in full; then groups of levels of detail.
    pub(super) groups: Vec<Group>,
    /// For each group of instances in full, the first of the groups of its levels, and how many
    /// there are.
    levels: Vec<[u32; 2]>,
}

impl Instances {
    /// Groups all instances that can be drawn. O(instances).
    #[cfg(test)]
    pub(super) fn new(scene: &Scene) -> Self {
        let mut grouping = Grouping::new(scene);
        grouping.add(scene, 0..scene.slot_count());
        grouping.finish(scene)
    }
}

impl Instances {
    /// The group that an instance of a group is in at a level of detail. `None` where there is no
    /// such level.
    pub(super) fn at_level(&self, group: u32, level: u32) -> Option<u32> {
        let Some(above) = level.checked_sub(1) else { return Some(group) };
        let [first, count] = *self.levels.get(group as usize)?;
        (above < count).then_some(first + above)
    }
}

/// The instances of a scene while they are grouped.
#[derive(Debug)]
pub(super) struct Grouping {
    /// Instances with the numbers of their kinds in place of a group's.
    all: Instances,
    /// How many there are of each kind.
    counts: Vec<u32>,
}

impl Grouping {
    pub(super) fn new(scene: &Scene) -> Self {
        let slots = scene.slot_count();
        let all = Instances {
            group: vec![NO_GROUP; slots as usize],
            layers: (0..slots).map(|s| scene.layers(s)).collect(),
            groups: Vec::new(),
            levels: Vec::new(),
        };
        Self { all, counts: vec![0; scene.meshes().len() * 8] }
    }

    /// Takes in some slots: of them the instances that can be drawn, those with a finite transform.
    pub(super) fn add(&mut self, scene: &Scene, slots: Range<u32>) {
        let drawable = |&slot: &u32| !scene.is_removed(slot) && scene.transform(slot).is_finite();
        for slot in slots.filter(drawable) {
            let flags = scene.flags(slot);
            let mirrored = scene.transform(slot).determinant() < 0.0;
            let bits = [mirrored, flags.double_sided, flags.transparent];
            let kind = bits.iter().fold(scene.mesh_id(slot), |n, &bit| n * 2 + u32::from(bit));
            self.all.group[slot as usize] = kind;
            self.counts[kind as usize] += 1;
        }
    }

    /// The groups. Those of levels have as much room as that of the instances in full, whichever
    /// level each is at.
    pub(super) fn finish(self, scene: &Scene) -> Instances {
        let Self { mut all, counts } = self;
        let mut number = vec![NO_GROUP; counts.len()];
        let mut first = 0;
        for (kind, &count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
            number[kind] = all.groups.len() as u32;
            let bit = |n: usize| kind >> n & 1 == 1;
            let mesh = (kind / 8) as u32;
            let kind = Kind { mesh, mirrored: bit(2), two_sided: bit(1), transparent: bit(0) };
            all.groups.push(Group { kind, first, count });
            first += count;
        }
        for group in all.group.iter_mut().filter(|g| **g != NO_GROUP) {
            *group = number[*group as usize];
        }
        for at in 0..all.groups.len() {
            let Group { kind, count, .. } = all.groups[at];
            let levels = scene.levels(kind.mesh);
            all.levels.push([all.groups.len() as u32, levels.len() as u32]);
            for levels in levels {
                let kind = Kind { mesh: levels.mesh, ..kind };
                all.groups.push(Group { kind, first, count });
                first += count;
            }
        }
        all
    }
}
