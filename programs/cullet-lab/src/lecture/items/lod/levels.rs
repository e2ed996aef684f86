//! Fewer triangles for what is small on the screen.

use std::collections::{BTreeMap, BTreeSet};

use cullet::bounds::{Aabb, Sphere};
use cullet::lod::{Group, Levels, Lod, NO_GROUP, PixelScale};
use cullet::mesh::{Cluster, Clustering, is_degenerate};
use cullet::{Culler, Mesh, MeshData, Stage, View};
use cullet_draw::surface::SurfaceTree;
use cullet_draw::surface::surface_points;

use crate::lecture::finding::Finding;
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{SIZE, cull, draw, grouped, other, scene_of};

/// Cells of the grids along the longest side of the model, one grid for each level.
const GRIDS: [f32; 3] = [80.0, 32.0, 12.0];
/// Samples of each surface.
const SAMPLES: usize = 4000;
/// By how many pixels a level may be off.
const PIXELS: f64 = 1.0;

/// A chain of levels of the armadillo, with errors that are held against samples: as the eye draws back fewer and fewer triangles are drawn.
pub(super) fn by_size(lab: &Lab) -> Result<Finding, LabError> {
    let armadillo = lab.model("armadillo/armadillo.obj")?;
    let (name, model) = match armadillo {
        Some(model) => ("the armadillo", model),
        None => ("a ball with knobs", lab.scene("knobs:n=40")?),
    };
    let original = &model.scene.meshes()[0];
    let positions = original.positions().to_vec();
    let indices = original.original_indices();
    let chain = Chain::new(&positions, indices)?;
    let measured = chain.levels.iter().map(|l| f64::from(l.measured)).fold(0.0, f64::max);
    let all_within = chain.levels.iter().all(|l| l.measured <= l.error);
    let base = MeshData {
        positions: positions.clone(),
        indices: chain.levels[0].indices.clone(),
        ..MeshData::default()
    };
    let mut scene = scene_of(Mesh::new(base).map_err(other)?)?;
    let known = chain.levels.iter().map(|l| (l.indices.len() as u64 / 3, f64::from(l.error)));
    let errors: BTreeMap<u64, f64> = known.collect();
    let (held, levels) = chain.into_levels(positions)?;
    let held = scene.add_mesh(held);
    scene.add_levels(0, held, levels).map_err(other)?;

    let bounds = scene.meshes()[0].bounds();
    let middle = bounds.center();
    let radius = bounds.half_extent().map(|h| h * h).iter().sum::<f64>().sqrt();
    let culler = Culler { lod: Some(Lod { pixels: PIXELS, ..Lod::default() }), ..Culler::exact() };
    let culler = culler.only(Stage::Lod);
    let mut row = Vec::new();
    let (mut falls, mut worst) = (true, 0.0_f64);
    for doubling in 0..7 {
        let distance = radius * 2.5 * 2.0_f64.powi(doubling);
        let eye = [middle[0], middle[1], middle[2] + distance];
        let view = View::perspective(eye, middle, 1.0, 0.01 * distance, f64::INFINITY, SIZE)?;
        let count = cull(&culler, &scene, &view).triangle_count;
        let error = errors.get(&count).copied().ok_or_else(|| other("a level that is none"))?;
        let scale = PixelScale::of(&view, false).pixels;
        worst = worst.max(error * scale / (distance - radius));
        let pixels = draw(&scene, &view).stats.covered_pixels;
        falls &= row.last().is_none_or(|&(_, before)| count <= before);
        row.push((pixels, count));
    }
    let told: Vec<String> = row
        .iter()
        .map(|&(pixels, count)| format!("{} of {}", grouped(count), grouped(pixels)))
        .collect();
    let fewer = row.first().map(|r| r.1) > row.last().map(|r| r.1.saturating_mul(10));
    Ok(Finding::if_so(
        falls && fewer && all_within && worst <= PIXELS,
        format!(
            "of {name}, twice as far at each step, these triangles are drawn for these pixels: {}; off by {worst:.2} \
             pixels at the most, by errors that no sample exceeds ({:.1} % of the radius is the largest found)",
            told.join(", "),
            measured / radius * 100.0
        ),
    ))
}

/// One of ever coarser index lists over the same vertices.
struct Level {
    indices: Vec<u32>,
    /// How far a corner was moved at the most, in this level or a finer one.
    error: f32,
    /// How far samples of either surface are from the other at the most.
    measured: f32,
}

/// Levels of one mesh from the finest to the coarsest.
struct Chain {
    levels: Vec<Level>,
}

impl Chain {
    /// Joins the vertices in each cell of coarser and coarser grids.
    fn new(positions: &[[f32; 3]], indices: Vec<u32>) -> Result<Self, LabError> {
        let whole = |t: &&[u32; 3]| !is_degenerate(**t, positions);
        let first: Vec<u32> =
            indices.as_chunks::<3>().0.iter().filter(whole).flatten().copied().collect();
        let bounds = Aabb::from_points(positions);
        let side = (0..3).map(|a| bounds.max[a] - bounds.min[a]).fold(0.0, f32::max);
        let tree = SurfaceTree::new(positions, &first);
        let samples = surface_points(positions, &first, SAMPLES, 82);
        let mut levels = vec![Level { indices: first, error: 0.0, measured: 0.0 }];
        for cells in GRIDS {
            let (joined, moved) = joined(positions, &levels[0].indices, side / cells);
            let before = &levels[levels.len() - 1];
            if joined.is_empty() || joined.len() >= before.indices.len() {
                return Err(other(format!("a grid of {cells} cells makes no level")));
            }
            let own_tree = SurfaceTree::new(positions, &joined);
            let own = surface_points(positions, &joined, SAMPLES, 82);
            let mut measured = 0.0_f32;
            for (points, tree) in [(&samples, &own_tree), (&own, &tree)] {
                for p in points {
                    let found = tree.nearest(p.point, f32::INFINITY);
                    measured = measured.max(found.map_or(f32::INFINITY, |(distance, _)| distance));
                }
            }
            levels.push(Level { indices: joined, error: moved.max(before.error), measured });
        }
        Ok(Self { levels })
    }

    /// The mesh with the triangles of all, and a group for each level but the first.
    fn into_levels(self, positions: Vec<[f32; 3]>) -> Result<(Mesh, Levels), LabError> {
        let bounds = Sphere::from_points(&positions);
        let mut all = Clustering::default();
        let (mut indices, mut groups) = (Vec::new(), Vec::new());
        let (mut made_from, mut replaced_by) = (Vec::new(), Vec::new());
        let count = self.levels.len() as u32;
        for (number, level) in (0_u32..).zip(self.levels) {
            let Level { indices: own, error, .. } = level;
            let data =
                MeshData { positions: positions.clone(), indices: own, ..MeshData::default() };
            let own = Clustering::spatial(&data).map_err(other)?;
            let [triangles, order] = [indices.len() as u32 / 3, all.order.len() as u32];
            all.order.extend(own.order.iter().map(|&t| t + triangles));
            for cluster in own.clusters {
                let first_triangle = cluster.first_triangle + order;
                all.clusters.push(Cluster { first_triangle, ..cluster });
                made_from.push(number.checked_sub(1).unwrap_or(NO_GROUP));
                replaced_by.push(if number + 1 < count { number } else { NO_GROUP });
            }
            if number > 0 {
                groups.push(Group { centre: bounds.center, radius: bounds.radius, error });
            }
            indices.extend(data.indices);
        }
        let data = MeshData { positions, indices, ..MeshData::default() };
        let mesh = Mesh::with_clusters(data, &all).map_err(other)?;
        let levels = Levels::new(&mesh, &groups, made_from, replaced_by).map_err(other)?;
        Ok((mesh, levels))
    }
}

/// The triangles whose corners lie in three cells of a grid, with the first vertex of each cell for all in it; and how far that
/// moves a corner at the most.
fn joined(positions: &[[f32; 3]], indices: &[u32], cell: f32) -> (Vec<u32>, f32) {
    let mut first = BTreeMap::new();
    let mut moved = 0.0_f32;
    let mut of = |v: u32| {
        let p = positions[v as usize];
        let to = *first.entry(p.map(|x| (x / cell).floor() as i32)).or_insert(v);
        let q = positions[to as usize];
        let square: f32 = (0..3).map(|a| (p[a] - q[a]).powi(2)).sum();
        moved = moved.max(square.sqrt());
        to
    };
    let triangles: Vec<[u32; 3]> =
        indices.as_chunks::<3>().0.iter().map(|&t| t.map(&mut of)).collect();
    let mut known = BTreeSet::new();
    let is_new = |&[a, b, c]: &[u32; 3]| {
        let mut sorted = [a, b, c];
        sorted.sort_unstable();
        !is_degenerate([a, b, c], positions) && known.insert(sorted)
    };
    (triangles.into_iter().filter(is_new).flatten().collect(), moved)
}
