//! The stages of triangles: a list that each stage shortens in place.

use super::count::degenerate_of;
use super::run::{Pass, triangles_of};
use crate::clip::outcode::ObjectRegion;
use crate::cull::degenerate::Flattening;
use crate::funnel::{Counts, Reason, Stage, Unit};
use crate::mesh::{Cluster, Mesh};
use crate::visible::TriangleRange;

impl Pass<'_> {
    /// Lists the triangles of all runs, those of straddling clusters by their outcodes.
    pub(super) fn list_triangles(&mut self) {
        let scene = self.scene;
        let entered = self.tally.counts;
        let mut region = None;
        for i in 0..self.scratch.runs.len() {
            let run = self.scratch.runs[i];
            let mesh = scene.mesh(run.slot);
            let triangles = triangles_of(mesh, run);
            let list = &mut self.result.triangles;
            let before = list.len();
            if run.inside {
                list.extend(triangles.clone());
            } else {
                // Runs of a slot follow each other: its region is made once.
                if region.as_ref().is_none_or(|(slot, _)| *slot != run.slot) {
                    let transform = scene.transform(run.slot);
                    region = Some((run.slot, ObjectRegion::new(&self.world_frustum, transform)));
                }
                let Some((_, region)) = &region else { continue };
                let (positions, indices) = (mesh.positions(), mesh.indices());
                region.keep_into(positions, indices, triangles.clone(), region.present(), list);
            }
            let is_part = list.len() - before < triangles.len();
            if is_part && self.lists_dropped() {
                let list = std::mem::take(&mut self.result.triangles);
                self.drop_triangles(Stage::Frustum, run.slot, triangles, &list[before..]);
                self.result.triangles = list;
            }
            // Degenerate triangles are in no cluster; they go with the last run of their instance.
            let list = &mut self.result.triangles;
            let last = self.scratch.runs.get(i + 1).is_none_or(|next| next.slot != run.slot);
            if last {
                list.extend(degenerate_of(mesh));
            }
            let count = (list.len() - before) as u32;
            match self.result.triangle_ranges.last_mut() {
                Some(range) if range.slot == run.slot => range.count += count,
                _ => self.result.triangle_ranges.push(TriangleRange {
                    slot: run.slot,
                    first: before as u32,
                    count,
                }),
            }
        }
        if self.culler.frustum {
            self.end_triangles(Stage::Frustum, entered);
        }
        debug_assert_eq!(self.tally.counts.triangles, self.result.triangles.len() as u64);
    }

    /// Drops triangles without area: those found when the mesh was made, and those that a flattening
    /// transform makes.
    pub(super) fn degenerate_triangles(&mut self) {
        let scene = self.scene;
        self.filter_triangles(Stage::Degenerate, |slot, triangles, kept| {
            let mesh = scene.mesh(slot);
            let drawn = degenerate_of(mesh).start;
            let flattening = Flattening::of(scene.transform(slot));
            let flattened = scene.is_rigid(slot) && flattening.rank() < 3;
            if !flattened && triangles.last().is_none_or(|&t| t < drawn) {
                return false;
            }
            kept.extend(
                triangles.iter().copied().filter(|&t| {
                    t < drawn && !(flattened && flattening.flattens(&mesh.corners(t)))
                }),
            );
            true
        });
    }

    /// Runs a triangle stage over every range in place. The closure appends what it keeps, or returns
    /// `false` to keep all.
    pub(super) fn filter_triangles(
        &mut self,
        stage: Stage,
        mut keep: impl FnMut(u32, &[u32], &mut Vec<u32>) -> bool,
    ) {
        let entered = self.tally.counts;
        let mut ranges = std::mem::take(&mut self.result.triangle_ranges);
        let mut triangles = std::mem::take(&mut self.result.triangles);
        let mut kept = std::mem::take(&mut self.scratch.kept);
        let mut write = 0;
        for range in &mut ranges {
            let read = range.first as usize..(range.first + range.count) as usize;
            kept.clear();
            let count = if keep(range.slot, &triangles[read.clone()], &mut kept) {
                if self.lists_dropped() && kept.len() < read.len() {
                    let before = triangles[read].iter().copied();
                    self.drop_triangles(stage, range.slot, before, &kept);
                }
                triangles[write..write + kept.len()].copy_from_slice(&kept);
                kept.len()
            } else {
                triangles.copy_within(read.clone(), write);
                read.len()
            };
            *range = TriangleRange { slot: range.slot, first: write as u32, count: count as u32 };
            write += count;
        }
        triangles.truncate(write);
        self.result.triangle_ranges = ranges;
        self.result.triangles = triangles;
        self.scratch.kept = kept;
        self.end_triangles(stage, entered);
    }

    /// Forgets instances of which a stage left no triangle, counts what is left, and ends the stage.
    fn end_triangles(&mut self, stage: Stage, entered: Counts) {
        let reasons = &mut self.result.reasons;
        let detail = if stage == Stage::Frustum { Reason::MIXED } else { 0 };
        let left = &mut self.tally.counts;
        let runs = &self.scratch.runs;
        self.result.triangle_ranges.retain(|range| {
            if range.count == 0 {
                if !reasons.is_empty() {
                    reasons[range.slot as usize] = Some(Reason { stage, detail });
                }
                let first = runs.partition_point(|run| run.slot < range.slot);
                let own = runs[first..].iter().take_while(|run| run.slot == range.slot);
                left.instances -= 1;
                left.clusters -= own.map(|run| u64::from(run.cluster_count)).sum::<u64>();
            }
            range.count > 0
        });
        left.triangles = self.result.triangles.len() as u64;
        self.row(stage, Unit::Triangles, entered);
    }
}

/// The clusters from the one of the first triangle of an ascending list on.
pub(super) fn clusters_of_list<'m>(mesh: &'m Mesh, triangles: &[u32]) -> &'m [Cluster] {
    let first = triangles.first().copied().unwrap_or(0);
    let clusters = mesh.clusters();
    let at = clusters.partition_point(|c| c.first_triangle + c.triangle_count <= first);
    &clusters[at..]
}
