//! How near the culling of back faces comes to what could be culled, by cluster and by triangle.

use cullet::cull::backface::ViewEye;
use cullet::{Backface, CullFace, Culler, Output, Scene, View, ViewState, Visible};

use crate::record::BackfaceRecord;

/// Culls by cluster without and with back faces, and counts what faces away in what is left.
#[derive(Debug, Default)]
pub(crate) struct BackfaceTest {
    state: ViewState,
    /// What is left without the culling of back faces.
    pub(crate) base: Visible,
    culled: Visible,
    clusters: Vec<u64>,
    words: Vec<u64>,
}

impl BackfaceTest {
    /// Counting what faces away takes some 15 ns a triangle; views with more than this go without.
    const MOST_TRIANGLES: u64 = 50_000_000;

    /// Culls by cluster; returns how many triangles went with clusters that face away.
    pub(crate) fn by_clusters(&mut self, scene: &Scene, view: &View, culler: &Culler) -> u64 {
        let mut only =
            Culler { output: Output::Clusters, reasons: false, clock: None, ..culler.clone() };
        only.backface = Backface::Off;
        only.cull_one(scene, view, &mut self.state, &mut self.base);
        only.backface = culler.backface;
        only.cull_one(scene, view, &mut self.state, &mut self.culled);
        self.base.triangle_count - self.culled.triangle_count
    }

    /// Counts over the clusters that [`by_clusters`](Self::by_clusters) found in the frustum. `None` where
    /// back faces are not culled, or there are too many triangles to count.
    pub(crate) fn measure(
        &mut self,
        scene: &Scene,
        view: &View,
        culler: &Culler,
    ) -> Option<BackfaceRecord> {
        let off = culler.backface == Backface::Off || view.cull_face == CullFace::None;
        if off || self.base.triangle_count > Self::MOST_TRIANGLES {
            return None;
        }
        let mut record = BackfaceRecord { views: 1, ..BackfaceRecord::default() };
        let eye = ViewEye::new(view);
        let base = std::mem::take(&mut self.base);
        for range in &base.whole {
            for slot in range.first..range.first + range.count {
                self.count(scene, &eye, culler, slot, &[(0, u32::MAX)], &mut record);
            }
        }
        for ranges in base.partial.chunk_by(|a, b| a.slot == b.slot) {
            let clusters: Vec<_> = ranges
                .iter()
                .map(|r| (r.first_cluster, r.first_cluster + r.cluster_count))
                .collect();
            self.count(scene, &eye, culler, ranges[0].slot, &clusters, &mut record);
        }
        self.base = base;
        Some(record)
    }

    /// Adds some clusters of an instance.
    fn count(
        &mut self,
        scene: &Scene,
        view_eye: &ViewEye,
        culler: &Culler,
        slot: u32,
        clusters: &[(u32, u32)],
        record: &mut BackfaceRecord,
    ) {
        let mesh = scene.mesh(slot);
        let exempt = scene.exempt()[slot as usize / 64] >> (slot % 64) & 1 == 1;
        if exempt || !scene.is_rigid(slot) || scene.flags(slot).double_sided || mesh.is_two_sided()
        {
            return;
        }
        let object = view_eye.in_space_of(scene.transform(slot));
        let fast = (culler.backface == Backface::Fast).then(|| mesh.backfaces().eye(&object));
        let fast = fast.flatten();
        if let Some(eye) = &fast {
            self.words.resize(mesh.triangle_count().div_ceil(64) as usize, 0);
            mesh.backfaces().cull_words(culler.level, eye, 0, &mut self.words);
            mesh.cluster_cones(eye.facing()).cull(culler.level, eye, &mut self.clusters);
        }
        let bit = |words: &[u64], i: u32| words[i as usize / 64] >> (i % 64) & 1 == 1;
        for &(first, end) in clusters {
            let end = end.min(mesh.clusters().len() as u32);
            for c in first..end {
                let cluster = &mesh.clusters()[c as usize];
                if mesh.parts()[cluster.part as usize].two_sided {
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
        }
        record.instances += 1;
        record.exact_instances += u64::from(fast.is_none());
    }
}
