//! Repair of winding, shell by shell, where it is well defined.

use super::Mesh;
use super::nesting::Nesting;
use super::surface::Surface;
use super::topology::{Joined, ShellMap};
use crate::array::Each;
use crate::sort::{of_f64, sort_by_key};

/// Changes that [`Mesh::oriented`] made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Repair {
    /// Shells: components connected by edges of just two triangles, once equal positions are welded.
    pub shells: u32,
    /// Shells whose triangles disagreed and were made to agree.
    pub made_consistent: u32,
    /// Closed shells turned outward as a whole.
    pub turned_outward: u32,
    /// Closed shells left inward, since they are cavities of another.
    pub cavities: u32,
    /// Shells left as they were although they have misoriented edges, since they have only one side, like
    /// a Möbius strip.
    pub left: u32,
    /// Triangles turned over.
    pub triangles_turned: u32,
}

/// Repairs the winding of a triangle list in place, by exchanging the last two corners of triangles.
///
/// Each shell is treated by itself: what edges of just two triangles connect, once equal positions are
/// welded. Edges of more than two separate shells, so two blocks that touch along an edge are two shells.
/// - A shell with only **one side** is left alone: no winding is right for it.
/// - An **open** shell is made consistent; the side that more of its triangles had already wins (the
///   side of its first triangle at a tie). Which side is out is not known, so a consistent one stays.
/// - A **closed** shell is made consistent likewise, and then outward by the sign of its volume; but if
///   it was inward, and the space around it is inside the other closed shells (winding number 1 or
///   more, as they are after repair, larger ones first), then it is a cavity and stays inward. A shell
///   wound outward within another is a body of its own and stays. A shell without volume stays.
///
/// Degenerate triangles are not touched. Expected O(n), but for the search of what lies around inward
/// shells.
pub fn orient_triangles(positions: &[[f32; 3]], indices: &mut [u32]) -> Repair {
    let mut surface = Surface::welded(positions, indices);
    let mut shell_map = ShellMap::of(&surface, Joined::ByManifoldEdges);
    let shells = shell_map.facts.len();
    let mut repair = Repair { shells: shells as u32, ..Repair::default() };
    // First make each shell agree with itself, by turning the fewer.
    let mut odd: Vec<bool> =
        (0..shell_map.shell_of.len()).map(|t| shell_map.shells.find(t).1).collect();
    let mut balance = vec![0i64; shells];
    for (t, &s) in shell_map.shell_of.iter().enumerate() {
        balance[s as usize] += if odd[t] { 1 } else { -1 };
    }
    for f in &shell_map.facts {
        repair.made_consistent += u32::from(!f.one_sided && f.misoriented);
        repair.left += u32::from(f.one_sided);
    }
    shell_map.facts.iter_mut().filter(|f| f.misoriented).for_each(|f| f.volume = 0.0);
    for (t, &s) in shell_map.shell_of.iter().enumerate() {
        let (facts, s) = (&mut shell_map.facts[s as usize], s as usize);
        odd[t] = (odd[t] != (balance[s] > 0)) && !facts.one_sided;
        if odd[t] {
            surface.corners[t].swap(1, 2);
        }
    }
    // The volume of what was inconsistent is known only now.
    let mut about = vec![None; shells];
    for (t, &s) in shell_map.shell_of.iter().enumerate() {
        let facts = &mut shell_map.facts[s as usize];
        if facts.misoriented {
            let about = about[s as usize]
                .get_or_insert_with(|| glam::DVec3::from(surface.points(t)[0].each(f64::from)));
            facts.volume += surface.volume6(t, *about) / 6.0;
        }
    }
    // Then turn closed shells outward, larger ones first: what holds a shell is larger than it.
    let closed = |s: usize| !(shell_map.facts[s].open || shell_map.facts[s].one_sided);
    let volume = |s: usize| shell_map.facts[s].volume;
    let mut inward: Vec<u32> =
        (0..shells as u32).filter(|&s| closed(s as usize) && volume(s as usize) < 0.0).collect();
    sort_by_key(&mut inward, |&s| of_f64(volume(s as usize)).into());
    let mut turned = vec![false; shells];
    if !inward.is_empty() {
        let nesting = Nesting::new(&surface, &shell_map.shell_of, shells);
        for &s in &inward {
            let size = volume(s as usize).abs();
            let weight = |o: u32| match o as usize {
                o if !closed(o) || volume(o).abs() <= size => 0,
                o if turned[o] => -1,
                _ => 1,
            };
            turned[s as usize] = nesting.winding_around(s, weight) < 1;
        }
    }
    repair.turned_outward = turned.iter().map(|&t| u32::from(t)).sum();
    repair.cavities = inward.len() as u32 - repair.turned_outward;
    for ((t, &s), source) in shell_map.shell_of.iter().enumerate().zip(surface.sources()) {
        if odd[t] != turned[s as usize] {
            let i = source * 3;
            indices.swap(i + 1, i + 2);
            repair.triangles_turned += 1;
        }
    }
    repair
}

impl Mesh {
    /// This mesh with its winding repaired per shell where that is well defined, and what was done;
    /// [`orient_triangles`] has the rules. Parts are joined for it. Clusters, order and every triangle
    /// number stay; a triangle that is turned over has its last two corners exchanged.
    #[must_use]
    pub fn oriented(mut self) -> (Self, Repair) {
        let repair = orient_triangles(&self.positions, &mut self.indices);
        (self, repair)
    }
}
