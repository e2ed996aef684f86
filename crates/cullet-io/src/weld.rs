//! Welding equal positions: for formats that repeat a vertex in every triangle.

use std::collections::hash_map::RandomState;
use std::hash::BuildHasher;

use crate::blocks::push;

const EMPTY: u32 = u32::MAX;

/// Gives each distinct position one number, in the order of first sight; −0 is 0. Open addressing
/// with linear probing, seeded at random so that no file can be made to collide; O(1) a position.
#[derive(Debug)]
pub struct Welder {
    positions: Vec<[f32; 3]>,
    table: Vec<u32>,
    seed: u64,
}

impl Default for Welder {
    fn default() -> Self {
        Self { positions: Vec::new(), table: vec![EMPTY; 64], seed: RandomState::new().hash_one(0) }
    }
}

impl Welder {
    /// A welder without positions.
    pub fn new() -> Self {
        Self::default()
    }

    /// The number of a position.
    #[inline]
    pub fn weld(&mut self, position: [f32; 3]) -> u32 {
        // Adding 0 turns −0 into 0, so that equal positions have equal bits.
        let position = position.map(|v| v + 0.0);
        // At most two thirds full: at one half the table of a file that shares no vertex, doubled,
        // would take loading beyond thrice the geometry.
        if self.positions.len() * 3 >= self.table.len() * 2 {
            self.grow();
        }
        let mut slot = self.slot(position);
        loop {
            match self.table[slot] {
                EMPTY => {
                    let index = self.positions.len() as u32;
                    self.table[slot] = index;
                    push(&mut self.positions, position);
                    return index;
                }
                index
                    if self.positions[index as usize].map(f32::to_bits)
                        == position.map(f32::to_bits) =>
                {
                    return index;
                }
                _ => slot = (slot + 1) & (self.table.len() - 1),
            }
        }
    }

    /// The position of a number that was given.
    pub fn position(&self, number: u32) -> [f32; 3] {
        self.positions[number as usize]
    }

    /// The distinct positions.
    pub fn into_positions(self) -> Vec<[f32; 3]> {
        let Self { mut positions, table, .. } = self;
        drop(table);
        positions.shrink_to_fit();
        positions
    }

    fn slot(&self, position: [f32; 3]) -> usize {
        const MULTIPLIER: u128 = 0x9e37_79b9_7f4a_7c15_f39c_c060_5ced_c835;
        let [x, y, z] = position.map(|v| u64::from(v.to_bits()));
        // Folded multiplication: every bit of the product's middle depends on every bit of the key.
        let fold = |v: u64, k: u64| {
            let product = u128::from(v) * u128::from(k);
            (product as u64) ^ ((product >> 64) as u64)
        };
        let mixed = fold((x | y << 32) ^ self.seed, MULTIPLIER as u64);
        let mixed = fold(mixed ^ z ^ self.seed.rotate_left(29), (MULTIPLIER >> 64) as u64);
        mixed as usize & (self.table.len() - 1)
    }

    fn grow(&mut self) {
        let slots = self.table.len() * 2;
        // Freed before the new one is made.
        self.table = Vec::new();
        self.table = vec![EMPTY; slots];
        for index in 0..self.positions.len() {
            let mut slot = self.slot(self.positions[index]);
            while self.table[slot] != EMPTY {
                slot = (slot + 1) & (self.table.len() - 1);
            }
            self.table[slot] = index as u32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    #[test]
    fn welds_as_a_map_would() {
        let mut welder = Welder::new();
        let mut map: HashMap<[u32; 3], u32> = HashMap::new();
        let mut rng = cullet_testkit::Rng(1);
        for _ in 0..20_000 {
            let p = [(); 3].map(|()| rng.below(20) as f32 * 0.1);
            let next = map.len() as u32;
            let expected = *map.entry(p.map(f32::to_bits)).or_insert(next);
            assert_eq!(welder.weld(p), expected);
        }
        assert_eq!(welder.into_positions().len(), map.len());
    }

    #[test]
    fn zeros_of_both_signs_are_one() {
        let mut welder = Welder::new();
        assert_eq!(welder.weld([0.0, -0.0, 1.0]), welder.weld([-0.0, 0.0, 1.0]));
    }
}
