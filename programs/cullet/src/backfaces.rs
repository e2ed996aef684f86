//! How near the culling of back faces comes to what could be culled, by cluster and by triangle.

use cullet::cull::backface::ViewEye;
use cullet::{Backface, CullFace, Culler, Scene, Stage, Unit, View, Visible};

use crate::record::BackfaceRecord;

/// Counts what faces away among the clusters that came to the stage of back faces.
#[derive(Debug, Default)]
pub(crate) struct BackfaceTest {
    /// One bit for each cluster of an instance: taken by a stage before.
    gone: Vec<u64>,
    clusters: Vec<u64>,
    words: Vec<u64>,
}

impl BackfaceTest {
    /// Counting what faces away takes some 15 ns a triangle; views with more than this go without.
    const MOST_TRIANGLES: u64 = 50_000_000;

    /// Counts over the clusters that were left when back faces were culled, as the record of a cull says
    /// ([`Culler::dropped`]). `None` where back faces are not culled, or there are too many triangles to count.
    pub(crate) fn measure(
        &mut self,
        scene: &Scene,
        view: &View,
        culler: &Culler,
        result: &Visible,
    ) -> Option<BackfaceRecord> {
        let off = culler.backface == Backface::Off || view.cull_face == CullFace::None;
        let rows = &result.funnel.rows;
        let last =
            rows.iter().rev().find(|r| r.stage != Stage::Backface && r.unit != Unit::Triangles);
        let came = last.map_or(0, |row| row.left.triangles);
        if off || came > Self::MOST_TRIANGLES {
            return None;
        }
        let mut record = BackfaceRecord { views: 1, ..BackfaceRecord::default() };
        let eye = ViewEye::new(view);
        let mut dropped = result.dropped.chunk_by(|a, b| a.slot == b.slot).peekable();
        for slot in scene.slots() {
            let own = dropped.next_if(|ranges| ranges[0].slot == slot).unwrap_or_default();
            if own.is_empty() && result.reasons[slot as usize].is_some() {
                continue;
            }
            let clusters = scene.mesh(slot).clusters();
            self.gone.clear();
            self.gone.resize(clusters.len().div_ceil(64), 0);
            for d in own.iter().filter(|d| d.unit == Unit::Clusters && d.stage != Stage::Backface) {
                let end = d.first_triangle + d.triangle_count;
                let first = clusters.partition_point(|c| c.first_triangle < d.first_triangle);
                let of_range = clusters[first..].iter().take_while(|c| c.first_triangle < end);
                for at in first..first + of_range.count() {
                    self.gone[at / 64] |= 1 << (at % 64);
                }
            }
            self.count(scene, &eye, culler, slot, &mut record);
        }
        Some(record)
    }

    /// Adds the clusters of an instance that are not gone.
    fn count(
        &mut self,
        scene: &Scene,
        view_eye: &ViewEye,
        culler: &Culler,
        slot: u32,
        record: &mut BackfaceRecord,
    ) {
        let mesh = scene.mesh(slot);
        let exempt = scene.exempt()[slot as usize / 64] >> (slot % 64) & 1 == 1;
        if exempt || !scene.is_rigid(slot) || scene.flags(slot).double_sided || mesh.is_two_sided()
        {
            return;
        }
        let object = view_eye.in_space_of(scene.transform(slot));
        let prepared = scene.prepared_of(slot);
        let planes = prepared.backfaces().filter(|_| culler.backface == Backface::Fast);
        let fast = planes.and_then(|planes| Some((planes, planes.eye(&object)?)));
        if let Some((planes, eye)) = &fast {
            self.words.resize(mesh.triangle_count().div_ceil(64) as usize, 0);
            planes.cull_words(culler.level, eye, 0, &mut self.words);
            self.clusters.clear();
            self.clusters.resize(mesh.clusters().len().div_ceil(64), 0);
            if let Some(cones) = prepared.cluster_cones(eye.facing()) {
                cones.cull(culler.level, eye, &mut self.clusters);
            }
        }
        let bit = |words: &[u64], i: u32| words[i as usize / 64] >> (i % 64) & 1 == 1;
        for (c, cluster) in (0..).zip(mesh.clusters()) {
            if bit(&self.gone, c) || mesh.parts()[cluster.part as usize].two_sided {
                continue;
            }
            let all = u64::from(cluster.triangle_count);
            let away =
                cluster.triangles().filter(|&t| object.culls(&mesh.corners(t))).count() as u64;
            record.one_sided += all;
            record.facing_away += away;
            // The eye is behind every plane.
            if away == all {
                record.ideal_by_cluster += all;
            }
            let whole = fast.is_some() && bit(&self.clusters, c);
            record.by_cluster += if whole { all } else { 0 };
            record.by_plane += match &fast {
                _ if whole => all,
                Some(_) => cluster.triangles().filter(|&t| bit(&self.words, t)).count() as u64,
                None => 0,
            };
        }
        record.instances += 1;
        record.exact_instances += u64::from(fast.is_none());
    }
}
