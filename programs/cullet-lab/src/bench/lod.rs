//! Choosing the clusters of levels of detail: a sweep over groups, and the walk to what is drawn.

use cullet::lod::{Group, LevelEye, Levels, NO_GROUP, Selection};
use cullet::mesh::{Cluster, Clustering, Part};
use cullet::{Mesh, MeshData};

use super::measure::beside_reading;
use super::measured::{Measured, Workload};
use super::options::BenchOptions;
use super::world::size_name;

/// Bytes that the sweep reads of a group: centre, radius, error.
const BYTES: usize = 20;

/// From how far an error of 1 looks as large as the threshold: from nearly everywhere the coarsest
/// does; some hundred clusters are drawn.
const REACHES: [(&str, f32); 2] = [("far", 1e-3), ("near", 20.0)];

pub(super) fn run(options: &BenchOptions, each: &mut dyn FnMut(Measured)) {
    for &size in &options.tree_sizes {
        let name = |eye: &str| format!("lod/{eye}/{}", size_name(size));
        if !REACHES.iter().any(|(eye, _)| options.wants(&name(eye))) {
            continue;
        }
        let levels = row_of_pairs(size);
        for (eye, reach) in REACHES.into_iter().filter(|(eye, _)| options.wants(&name(eye))) {
            let at = [size as f32 / 2.0, 3.0, 0.0];
            let from = LevelEye { eye: at, reach, ball: 0.0, nearest: 0.0 };
            let expected = levels.select_where(|group| from.is_over(group));
            for (level, simd) in cullet_command::machine::levels() {
                let mut selection = Selection::default();
                let all = levels.select(simd, &from, &mut selection);
                let is_chosen = |c: usize| selection.clusters()[c / 64] >> (c % 64) & 1 == 1;
                let checked = all && (0..expected.len()).all(|c| is_chosen(c) == expected[c]);
                let items = levels.group_count();
                let visible = selection.cluster_count() as usize;
                let times = beside_reading(options.seconds, items * BYTES, || {
                    levels.select(simd, &from, &mut selection);
                });
                let workload = Workload { name: name(eye), level, items, visible, checked };
                each(workload.streaming(BYTES, times));
            }
        }
    }
}

/// Clusters of a triangle each in a row, at least so many; each two that are neighbours are
/// replaced by one, and so on.
fn row_of_pairs(clusters: usize) -> Levels {
    let finest = clusters.next_power_of_two() as u32;
    let (mut made_from, mut replaced_by) = (vec![NO_GROUP; finest as usize], Vec::new());
    let mut made: Vec<Group> = Vec::new();
    let (mut first, mut count, mut span) = (0, finest, 1.0_f32);
    while count > 1 {
        for pair in 0..count / 2 {
            let group = made.len() as u32;
            replaced_by.extend([group; 2]);
            made_from.push(group);
            span = finest as f32 / (count / 2) as f32;
            let centre = [(pair as f32 + 0.5) * span, 0.0, 0.0];
            made.push(Group { centre, radius: span * 0.5, error: span * 0.01 });
        }
        first += count;
        count /= 2;
    }
    replaced_by.push(NO_GROUP);
    debug_assert!(first + 1 == made_from.len() as u32 && span > 0.0);
    let triangles = made_from.len() as u32;
    let data = MeshData {
        positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        indices: [0, 1, 2].repeat(triangles as usize),
        parts: vec![Part { triangle_count: triangles, ..Part::default() }],
        ..MeshData::default()
    };
    let cluster = |first_triangle| Cluster { first_triangle, triangle_count: 1, part: 0 };
    let clustering = Clustering {
        order: (0..triangles).collect(),
        clusters: (0..triangles).map(cluster).collect(),
    };
    let mesh = Mesh::with_clusters(data, &clustering).expect("one triangle a cluster");
    Levels::new(&mesh, &made, made_from, replaced_by).expect("each group is around its clusters")
}
