//! The hierarchy of one part: levels from the finest up.

use std::sync::{Mutex, PoisonError};

use cullet::MeshData;
use cullet::mesh::Part;

use super::cut::{cut_into_clusters, partition};
use super::data::NO_GROUP;
use super::group::{Level, Made, Pending, Scratch, Surface, cluster_size, make};
use super::measure::Carried;
use super::options::{ErrorSource, HierarchyOptions};
use super::sphere::{Ball, around};
use super::weld::Welded;
use cullet_draw::surface::SurfaceTree;

/// A cluster that no group could simplify is tried in so many, with other neighbours.
const TRIES: u8 = 2;

/// The triangles of a part with numbers of its own for its vertices.
pub(super) struct PartSurface {
    /// For each of its vertices that of the mesh.
    pub(super) vertices: Vec<u32>,
    /// The original triangles, cluster by cluster: their numbers from the part's first, and their
    /// corners as numbers of its own vertices.
    pub(super) order: Vec<u32>,
    indices: Vec<u32>,
    positions: Vec<[f32; 3]>,
    /// For each vertex the first at its position.
    position: Vec<u32>,
    /// Whether other parts share a position, by the first vertex at it.
    shared: Vec<bool>,
}

/// A cluster of a part.
#[derive(Debug)]
pub(super) struct PartCluster {
    pub(super) triangles: u32,
    /// Corners of its triangles, as vertices of the part; none of an original one.
    pub(super) indices: Vec<u32>,
    pub(super) made_from: u32,
    pub(super) replaced_by: u32,
}

/// The levels of a part.
#[derive(Debug, Default)]
pub(super) struct PartLevels {
    /// The originals come first.
    pub(super) clusters: Vec<PartCluster>,
    /// Spheres and errors.
    pub(super) groups: Vec<(Ball, f32)>,
}

impl PartSurface {
    /// `local` is as long as the mesh has vertices, and `u32::MAX` all over, before and after.
    pub(super) fn new(
        data: &MeshData,
        welded: &Welded,
        shared: &[bool],
        part: &Part,
        local: &mut [u32],
    ) -> Self {
        let mut surface = Self {
            vertices: Vec::new(),
            order: Vec::new(),
            indices: Vec::new(),
            positions: Vec::new(),
            position: Vec::new(),
            shared: Vec::new(),
        };
        let own = |t: u32| {
            let i = (part.first_triangle + t) as usize * 3;
            [data.indices[i], data.indices[i + 1], data.indices[i + 2]]
        };
        for t in 0..part.triangle_count {
            let [a, b, c] = own(t).map(|v| welded.position[v as usize]);
            if !data.deformable && (a == b || b == c || c == a) {
                continue;
            }
            surface.order.push(t);
            for v in own(t).map(|v| welded.vertex[v as usize]) {
                // The first at a position has a number too, whether or not a triangle here has it.
                let first = welded.position[v as usize];
                for v in [first, v] {
                    let number = &mut local[v as usize];
                    if *number == u32::MAX {
                        *number = surface.vertices.len() as u32;
                        surface.vertices.push(v);
                        surface.positions.push(data.positions[v as usize]);
                        surface.position.push(local[first as usize]);
                        surface.shared.push(shared[first as usize]);
                    }
                }
                surface.indices.push(local[v as usize]);
            }
        }
        surface.vertices.iter().for_each(|&v| local[v as usize] = u32::MAX);
        surface
    }

    /// Cuts the triangles into clusters and puts them in their order; how many triangles each has.
    fn cut(&mut self, options: &HierarchyOptions) -> Vec<u32> {
        let cut = cut_into_clusters(&self.positions, &self.indices, cluster_size(options));
        let triangles = self.indices.as_chunks::<3>().0;
        self.indices = cut.order.iter().flat_map(|&t| triangles[t as usize]).collect();
        self.order = cut.order.iter().map(|&t| self.order[t as usize]).collect();
        cut.counts
    }

    /// The original clusters.
    fn originals(&self, counts: &[u32]) -> Vec<Pending> {
        let mut first = 0;
        (0..)
            .zip(counts)
            .map(|(number, &count)| {
                let indices = self.indices[first as usize * 3..][..count as usize * 3].to_vec();
                let mut corners = indices.clone();
                corners.sort_unstable();
                corners.dedup();
                let centre = |v: &u32| Ball { centre: self.positions[*v as usize], radius: 0.0 };
                let ball = around(&corners.iter().map(centre).collect::<Vec<_>>());
                let carried = Carried::Original(first);
                first += count;
                Pending { number, indices, carried, ball, error: 0.0, stuck: 0 }
            })
            .collect()
    }
}

/// All levels of a part; its surface is put in the order of the original clusters.
pub(super) fn build_part(
    part: &mut PartSurface,
    options: &HierarchyOptions,
    number: u32,
) -> PartLevels {
    let counts = part.cut(options);
    let part = &*part;
    let seed = cullet_draw::Random::new(options.seed, [number, 0]).next();
    let measured = options.errors == ErrorSource::Measured;
    let none: &[u32] = &[];
    let original = SurfaceTree::new(&part.positions, if measured { &part.indices } else { none });
    let surface =
        Surface { positions: &part.positions, position: &part.position, original: &original };
    let pool = part.originals(&counts);
    let mut run = Run::new(&surface, options, pool, part.shared.clone(), seed);
    while run.gained && run.pool.len() > 1 {
        run.level();
    }
    run.levels
}

/// Levels as they grow.
struct Run<'a> {
    surface: &'a Surface<'a>,
    options: &'a HierarchyOptions,
    /// Clusters that are to be simplified, in the order in which they were made.
    pool: Vec<Pending>,
    levels: PartLevels,
    /// Whether a position stays for good, by the first vertex at it.
    fixed: Vec<bool>,
    /// Whether the last level had fewer triangles.
    gained: bool,
    seed: u64,
    /// How many levels there are.
    depth: u32,
}

impl<'a> Run<'a> {
    fn new(
        surface: &'a Surface<'a>,
        options: &'a HierarchyOptions,
        pool: Vec<Pending>,
        fixed: Vec<bool>,
        seed: u64,
    ) -> Self {
        let original = |p: &Pending| PartCluster {
            triangles: (p.indices.len() / 3) as u32,
            indices: Vec::new(),
            made_from: NO_GROUP,
            replaced_by: NO_GROUP,
        };
        let clusters = pool.iter().map(original).collect();
        let levels = PartLevels { clusters, groups: Vec::new() };
        Self { surface, options, pool, levels, fixed, gained: true, seed, depth: 0 }
    }

    /// Simplifies what is in the pool once.
    fn level(&mut self) {
        self.gained = false;
        let groups = self.partition();
        let locked = self.locked(&groups);
        let mut members: Vec<Vec<Pending>> = Vec::new();
        for (pending, &group) in self.pool.drain(..).zip(&groups) {
            members.resize_with(members.len().max(group as usize + 1), Vec::new);
            members[group as usize].push(pending);
        }
        let level = Level {
            surface: self.surface,
            options: self.options,
            locked: &locked,
            seed: self.seed,
            depth: self.depth,
        };
        self.depth += 1;
        let first_key = self.levels.groups.len() as u32;
        let members: Vec<Mutex<Vec<Pending>>> = members.into_iter().map(Mutex::new).collect();
        let vertices = self.surface.positions.len();
        let job = |scratch: &mut Scratch, number: usize| {
            // Each is locked once, so none is poisoned.
            let mut own = members[number].lock().unwrap_or_else(PoisonError::into_inner);
            let made = make(&level, scratch, &own, first_key + number as u32);
            // What was simplified is needed no longer, but for its number.
            if made.ball.is_some() {
                for pending in own.iter_mut() {
                    pending.indices = Vec::new();
                    pending.carried = Carried::Original(0);
                }
            }
            made
        };
        let threads = self.options.threads;
        let made =
            crate::threads::run(threads, members.len(), || Scratch::new(vertices), job, || true);
        for (made, members) in made.unwrap_or_default().into_iter().zip(members) {
            let members = members.into_inner().unwrap_or_else(PoisonError::into_inner);
            self.take(made, members);
        }
    }

    /// Groups of clusters that are neighbours by the positions of their vertices.
    fn partition(&self) -> Vec<u32> {
        let clusters = self.pool.iter().map(|p| &p.indices[..]);
        let size = self.options.group_clusters as usize;
        partition(self.surface.positions, clusters, self.surface.position, size)
    }

    /// Returns whether a position stays, for good or because groups share it, by the first vertex
    /// at it.
    fn locked(&self, groups: &[u32]) -> Vec<bool> {
        let mut locked = self.fixed.clone();
        let mut of = vec![u32::MAX; locked.len()];
        for (pending, &group) in self.pool.iter().zip(groups) {
            for &v in &pending.indices {
                let at = self.surface.position[v as usize] as usize;
                locked[at] |= of[at] != u32::MAX && of[at] != group;
                of[at] = group;
            }
        }
        locked
    }

    /// Takes what became of a group.
    fn take(&mut self, made: Made, members: Vec<Pending>) {
        let Some(ball) = made.ball else {
            for mut pending in members {
                pending.stuck += 1;
                if pending.stuck < TRIES {
                    self.pool.push(pending);
                    continue;
                }
                // It is drawn however coarse its neighbours are, so they may not leave it.
                for v in pending.indices {
                    self.fixed[self.surface.position[v as usize] as usize] = true;
                }
            }
            return;
        };
        self.gained = true;
        let group = self.levels.groups.len() as u32;
        self.levels.groups.push((ball, made.error));
        for pending in members {
            self.levels.clusters[pending.number as usize].replaced_by = group;
        }
        for (indices, carried) in made.clusters {
            let number = self.levels.clusters.len() as u32;
            self.levels.clusters.push(PartCluster {
                triangles: (indices.len() / 3) as u32,
                indices: indices.clone(),
                made_from: group,
                replaced_by: NO_GROUP,
            });
            let error = made.error;
            let carried = Carried::Points(carried);
            self.pool.push(Pending { number, indices, carried, ball, error, stuck: 0 });
        }
    }
}
