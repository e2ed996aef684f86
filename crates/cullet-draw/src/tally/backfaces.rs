//! How near the culling of back faces comes to what could be culled, by cluster and by triangle.

use cullet::cull::backface::ViewEye;
use cullet::mesh::{Alpha, Part};
use cullet::{
    Backface, Culler, Scene, Stage, View, Visible,
    funnel::Unit,
    view::{CullFace, FrontFace},
};

use crate::geometry::{cross, sub};
use crate::prepare::part_of;

/// Back faces of one-sided parts, counted over the clusters that were left when back faces were
/// culled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BackfaceCounts {
    /// Instances with backs that can be culled.
    pub instances: u64,
    /// The part that only the test from the corners is fine enough for.
    pub exact_instances: u64,
    /// Triangles with a back.
    pub one_sided: u64,
    /// The part that faces away.
    pub facing_away: u64,
    /// Triangles in clusters that wholly face away: what a perfect bound takes.
    pub ideal_by_cluster: u64,
    /// Triangles in clusters that are culled.
    pub by_cluster: u64,
    /// Triangles that are culled with their cluster or by their plane.
    pub by_plane: u64,
}

/// Counts what faces away among the clusters that came to the stage of back faces.
#[derive(Debug, Default)]
pub struct BackfaceTest {
    /// One bit for each cluster of an instance: taken by a stage before.
    gone: Vec<u64>,
    clusters: Vec<u64>,
    words: Vec<u64>,
}

impl BackfaceTest {
    /// Counting what faces away takes some 15 ns a triangle; views with more than this go without.
    const MOST_TRIANGLES: u64 = 50_000_000;

    /// Counts over the clusters that were left when back faces were culled, as the record of a cull
    /// says ([`Culler::dropped`]). `None` where back faces are not culled, or there are too many
    /// triangles to count.
    pub fn measure(
        &mut self,
        scene: &Scene,
        view: &View,
        culler: &Culler,
        result: &Visible,
    ) -> Option<BackfaceCounts> {
        let off = culler.backface == Backface::Off || view.cull_face == CullFace::None;
        let rows = &result.funnel.rows;
        let last =
            rows.iter().rev().find(|r| r.stage != Stage::Backface && r.unit != Unit::Triangles);
        let came = last.map_or(0, |row| row.left.triangles);
        if off || came > Self::MOST_TRIANGLES {
            return None;
        }
        let mut counts = BackfaceCounts::default();
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
            self.count(scene, &eye, culler, slot, &mut counts);
        }
        Some(counts)
    }

    /// Adds the clusters of an instance that are not gone.
    fn count(
        &mut self,
        scene: &Scene,
        view_eye: &ViewEye,
        culler: &Culler,
        slot: u32,
        counts: &mut BackfaceCounts,
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
            planes.cull_words(culler.simd, eye, 0, &mut self.words);
            self.clusters.clear();
            self.clusters.resize(mesh.clusters().len().div_ceil(64), 0);
            if let Some(cones) = prepared.cluster_cones(eye.facing()) {
                cones.cull(culler.simd, eye, &mut self.clusters);
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
            counts.one_sided += all;
            counts.facing_away += away;
            // The eye is behind every plane.
            if away == all {
                counts.ideal_by_cluster += all;
            }
            let whole = fast.is_some() && bit(&self.clusters, c);
            counts.by_cluster += if whole { all } else { 0 };
            counts.by_plane += match &fast {
                _ if whole => all,
                Some(_) => cluster.triangles().filter(|&t| bit(&self.words, t)).count() as u64,
                None => 0,
            };
        }
        counts.instances += 1;
        counts.exact_instances += u64::from(fast.is_none());
    }
}

/// How many of `triangles` (in the mesh's order) of a slot at a level have both sides drawn and
/// face away: what back-face culling would take if the mesh were one-sided.
#[must_use]
pub fn facing_away(scene: &Scene, view: &View, [slot, level]: [u32; 2], triangles: &[u32]) -> u64 {
    let mesh = scene.mesh_at(slot, level);
    let transform = scene.transform(slot);
    let two_sided = scene.flags(slot).double_sided;
    let opaque = |p: &Part| p.alpha == Alpha::Opaque;
    if !two_sided && !mesh.parts().iter().any(|p| p.two_sided && opaque(p)) {
        return 0;
    }
    let m = transform.to_matrix();
    let world = |p: [f32; 3]| -> [f64; 3] {
        let p = p.map(f64::from);
        std::array::from_fn(|r| m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r])
    };
    // A mirrored instance, or a view with clockwise fronts, turns the order of corners round.
    let mirrored = transform.determinant() < 0.0;
    let clockwise = view.front_face == FrontFace::Clockwise;
    let sign = if mirrored == clockwise { 1.0 } else { -1.0 };
    let eye = view.eye();
    let away = |t: u32| {
        let [a, b, c] = mesh.corners(t).map(world);
        let n = cross(sub(b, a), sub(c, a));
        let facing: f64 = (0..3).map(|i| n[i] * (eye[i] - a[i] * eye[3])).sum();
        sign * facing < 0.0
    };
    let counts = |t: u32| {
        let part = part_of(mesh, mesh.original_triangle()[t as usize]);
        opaque(&part) && (two_sided || part.two_sided)
    };
    triangles.iter().filter(|&&t| counts(t) && away(t)).count() as u64
}
