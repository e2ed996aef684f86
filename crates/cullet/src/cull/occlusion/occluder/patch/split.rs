//! Splitting a surface into patches.
//!
//! Each connected part of it by itself: at the median of its widest axis until there are few enough
//! facets. Layers of a patch that lie behind one another spoil each other, for a pixel is as far as
//! the farthest that touches it, so that smaller ones find more: of what is hidden in a hall of
//! 262,000 triangles 89.8 % with 128 facets, 90.8 with 64, 91.8 with 32; in 2.4, 2.8 and 3.7 ms.

use alloc::vec;
use alloc::vec::Vec;

use super::facet::{Edge, Facet, NONE, edges};
use crate::array::Each;
use crate::sort::{Sorter, of_f32, pair, sort_by_key};

/// Facets of a surface in patches.
pub(super) struct Split<'a> {
    positions: &'a [[f32; 3]],
    facets: &'a [Facet],
    /// The most facets of a patch.
    most: usize,
    /// The connected part that a facet is of: the least facet of it.
    part: Vec<u32>,
    /// Facets around each vertex, one vertex after the other.
    around: Vec<u32>,
    ends: Vec<u32>,
    /// The last patch that has a facet, or has it around.
    patch: Vec<u32>,
}

impl<'a> Split<'a> {
    pub(super) fn new(positions: &'a [[f32; 3]], facets: &'a [Facet], most: usize) -> Self {
        let mut part: Vec<u32> = (0..facets.len() as u32).collect();
        for Edge { facets, .. } in edges(facets) {
            if facets[1] != NONE {
                let [f, g] = facets.each(|f| root(&mut part, f));
                part[f.max(g) as usize] = f.min(g);
            }
        }
        for f in 0..facets.len() as u32 {
            part[f as usize] = root(&mut part, f);
        }
        let mut ends = vec![0_u32; positions.len() + 1];
        for &v in facets.iter().flat_map(Facet::corners) {
            ends[v as usize + 1] += 1;
        }
        for v in 0..positions.len() {
            ends[v + 1] += ends[v];
        }
        let mut next = ends.clone();
        let mut around = vec![0; ends[positions.len()] as usize];
        for (number, facet) in (0..).zip(facets) {
            for &v in facet.corners() {
                around[next[v as usize] as usize] = number;
                next[v as usize] += 1;
            }
        }
        Self { positions, facets, most, part, around, ends, patch: vec![NONE; facets.len()] }
    }

    /// Calls back with the own facets of each patch, and those around it, both so sorted that whole
    /// groups face away.
    pub(super) fn for_patches(mut self, mut each: impl FnMut(&[Facet], &[Facet])) {
        let mut order: Vec<u32> = (0..self.facets.len() as u32).collect();
        sort_by_key(&mut order, |&f| self.part[f as usize].into());
        let mut lists = Vec::new();
        // A small surface is one patch, whatever its parts: each costs as much as drawing some ten
        // facets.
        let is_small = order.len() <= self.most;
        let is_one =
            |&f: &u32, &g: &u32| is_small || self.part[f as usize] == self.part[g as usize];
        for part in order.chunk_by_mut(is_one) {
            self.split(part, &mut lists);
        }
        for (number, own) in (0..).zip(lists) {
            let around = self.around(number, &own);
            let [own, around] = [own, around].each(|list| self.sorted(list));
            each(&own, &around);
        }
    }

    fn split(&self, facets: &mut [u32], lists: &mut Vec<Vec<u32>>) {
        if facets.len() <= self.most {
            lists.push(facets.to_vec());
            return;
        }
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for &f in &*facets {
            for (a, (low, high)) in low.iter_mut().zip(&mut high).enumerate() {
                let middle = self.middle(f, a);
                (*low, *high) = (low.min(middle), high.max(middle));
            }
        }
        let extent = |a: usize| high[a] - low[a];
        let axis = (0..3).fold(0, |best, a| if extent(a) > extent(best) { a } else { best });
        let half = facets.len() / 2;
        Sorter::default().split(facets, half, |&f| pair(of_f32(self.middle(f, axis)), f));
        let (low, high) = facets.split_at_mut(half);
        self.split(low, lists);
        self.split(high, lists);
    }

    fn middle(&self, facet: u32, axis: usize) -> f32 {
        let corners = self.facets[facet as usize].corners();
        let sum: f32 = corners.iter().map(|&v| self.positions[v as usize][axis]).sum();
        sum / corners.len() as f32
    }

    /// The facets of the same part that share a vertex with some, which are marked with the number
    /// of their patch.
    fn around(&mut self, number: u32, own: &[u32]) -> Vec<u32> {
        own.iter().for_each(|&f| self.patch[f as usize] = number);
        let mut around = Vec::new();
        for &f in own {
            for &v in self.facets[f as usize].corners() {
                let [first, end] = [v, v + 1].each(|v| self.ends[v as usize] as usize);
                for &g in &self.around[first..end] {
                    let is_same = self.part[g as usize] == self.part[f as usize];
                    if is_same && self.patch[g as usize] != number {
                        self.patch[g as usize] = number;
                        around.push(g);
                    }
                }
            }
        }
        around
    }

    fn sorted(&self, mut list: Vec<u32>) -> Vec<Facet> {
        sort_by_key(&mut list, |&f| pair(self.direction(f), f));
        list.into_iter().map(|f| self.facets[f as usize]).collect()
    }

    /// A key that puts facets of one direction together.
    fn direction(&self, facet: u32) -> u32 {
        let triangles = self.facets[facet as usize].triangles();
        let n = triangles.map(|t| super::facet::normal(self.positions, t)).sum::<glam::DVec3>();
        let n = n.to_array();
        let major = (0..3).fold(0, |best, a| if n[a].abs() > n[best].abs() { a } else { best });
        let cell = |a: usize| {
            let t = n[(major + a) % 3] / n[major].abs().max(1e-300);
            ((t + 1.0) * 1.5).clamp(0.0, 2.0) as u32
        };
        let (column, row) = (cell(1), cell(2));
        // Row after row, there and back: neighbours differ by one cell.
        let row = if column % 2 == 1 { 2 - row } else { row };
        (major as u32 * 2 + u32::from(n[major] < 0.0)) * 9 + column * 3 + row
    }
}

fn root(of: &mut [u32], mut facet: u32) -> u32 {
    while of[facet as usize] != facet {
        of[facet as usize] = of[of[facet as usize] as usize];
        facet = of[facet as usize];
    }
    facet
}
