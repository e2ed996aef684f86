//! What is listed of each scene and view, and whether the device says the same as the CPU.

use cullet_gpu::{BLOCK, BlockPlanes, Blocks, Gpu, GpuError, Lanes, Passes, visible_ref};

use super::device::Listing;
use super::scenes::{Case, scenes};

/// What a view of a scene lists.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Lists {
    /// A bit a slot, lowest first.
    pub(crate) bits: Vec<u32>,
    /// Of all, of those seen before, of those that are new: of each bucket the slots.
    pub(crate) lists: [Vec<Vec<u32>>; 3],
}

/// What is listed of one view, by the CPU.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// The scene's name.
    pub scene: &'static str,
    /// Instances of it.
    pub instances: u32,
    /// How many are in the view.
    pub listed: usize,
    /// Of bits and lists.
    pub hash: u64,
    /// What the device lists otherwise, in words, if one was asked.
    pub differs: Option<String>,
}

/// A line for each answer, to be compared with that of another machine.
///
/// # Errors
/// If a device listed something else than the CPU: a line for each such answer.
pub fn report(answers: &[Answer]) -> Result<String, String> {
    let line =
        |a: &Answer| format!("{}, {}: {} listed, {:016x}", a.scene, a.instances, a.listed, a.hash);
    let differs = |a: &Answer| Some(format!("{}: {} differs", line(a), a.differs.as_ref()?));
    let wrong: Vec<String> = answers.iter().filter_map(differs).collect();
    if wrong.is_empty() {
        Ok(answers.iter().map(line).collect::<Vec<_>>().join("\n"))
    } else {
        Err(wrong.join("\n"))
    }
}

/// All answers, in order; with a device also whether it gives the same.
///
/// # Errors
/// If the device has no room for a scene, or is lost.
pub async fn answers(on: Option<(&Gpu, &Passes)>) -> Result<Vec<Answer>, GpuError> {
    let mut all = Vec::new();
    for case in scenes() {
        add(&case, on, &mut all).await?;
    }
    Ok(all)
}

async fn add(
    case: &Case,
    on: Option<(&Gpu, &Passes)>,
    all: &mut Vec<Answer>,
) -> Result<(), GpuError> {
    let blocks = Blocks::new(&case.scene);
    let lanes = Lanes::of(&case.scene);
    let mut device = on.map(|on| Listing::new(on, &case.scene, &blocks)).transpose()?;
    let mut planes = BlockPlanes::default();
    let mut seen = vec![0; blocks.boxes().len().max(BLOCK) / 32];
    for (of_view, layers) in &case.views {
        planes.set(&blocks, of_view, *layers);
        let slots = visible_ref(&blocks, &planes);
        let lists = lists_ref(&slots, &seen, &lanes);
        let differs = match &mut device {
            Some(device) => difference(&lists, &device.list(&planes).await?),
            None => None,
        };
        all.push(Answer {
            scene: case.name,
            instances: case.scene.instance_count(),
            listed: slots.len(),
            hash: hash(&lists),
            differs,
        });
        seen = lists.bits;
    }
    Ok(())
}

/// Bits and lists of slots, made by the CPU: slow and obvious.
fn lists_ref(slots: &[u32], seen: &[u32], lanes: &Lanes) -> Lists {
    let mut bits = vec![0; seen.len()];
    slots.iter().for_each(|slot| bits[*slot as usize / 32] |= 1 << (slot % 32));
    let has = |bits: &[u32], slot: u32| bits[slot as usize / 32] >> (slot % 32) & 1 != 0;
    let list = |is_listed: &dyn Fn(u32) -> bool| {
        let of_lanes = |range: &std::ops::Range<u32>| {
            let own = &lanes.slots()[range.start as usize..range.end as usize];
            own.iter().copied().filter(|slot| has(&bits, *slot) && is_listed(*slot)).collect()
        };
        lanes.buckets().iter().map(|bucket| of_lanes(&bucket.lanes)).collect()
    };
    let lists = [list(&|_| true), list(&|slot| has(seen, slot)), list(&|slot| !has(seen, slot))];
    Lists { bits, lists }
}

/// What the device says otherwise, in words.
fn difference(cpu: &Lists, device: &Lists) -> Option<String> {
    if cpu.bits != device.bits {
        let other = cpu.bits.iter().zip(&device.bits).filter(|(a, b)| a != b).count();
        return Some(format!("{other} of {} words of bits", cpu.bits.len()));
    }
    let lists = cpu.lists.iter().zip(&device.lists);
    ["all", "those seen before", "the new ones"].iter().zip(lists).find_map(
        |(name, (own, other))| {
            let bucket = (0..own.len()).find(|b| own.get(*b) != other.get(*b))?;
            Some(format!("the list of {name} in bucket {bucket} of {}", own.len()))
        },
    )
}

/// A hash of bits and lists (FNV-1a of 64 bits, by words).
fn hash(of: &Lists) -> u64 {
    let mut hash = 0xCBF2_9CE4_8422_2325_u64;
    let mut add = |words: &[u32]| {
        for word in std::iter::once(&(words.len() as u32)).chain(words) {
            hash = (hash ^ u64::from(*word)).wrapping_mul(0x0100_0000_01B3);
        }
    };
    add(&of.bits);
    of.lists.iter().flatten().for_each(|slots| add(slots));
    hash
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_differs_is_said() {
        let own = Lists { bits: vec![1; 8], lists: [const { Vec::new() }; 3] };
        let mut other = own.clone();
        assert_eq!(difference(&own, &other), None);
        other.bits[3] = 2;
        let said = difference(&own, &other);
        assert_eq!(said.as_deref(), Some("1 of 8 words of bits"));
        let answer =
            Answer { scene: "s", instances: 1, listed: 1, hash: hash(&own), differs: None };
        assert_ne!(hash(&own), hash(&other));
        let wrong = Answer { differs: said, ..answer.clone() };
        assert_eq!(report(std::slice::from_ref(&answer)).unwrap().lines().count(), 1);
        assert!(report(&[answer, wrong]).unwrap_err().contains("words of bits differs"));
        let mut with = own.clone();
        (with.lists[1], other.lists[1]) = (vec![vec![7]], vec![vec![]]);
        other.bits = own.bits.clone();
        let said = difference(&with, &other).unwrap();
        assert!(said.contains("seen before in bucket 0"), "{said}");
    }
}
