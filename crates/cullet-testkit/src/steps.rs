//! Levels of detail that are easy to judge: a strip cut into segments, of which two at a time become one.

use cullet::lod::{Group, Levels, NO_GROUP};
use cullet::mesh::{Cluster, Clustering, Part};
use cullet::{Mesh, MeshData};

use crate::Rng;

/// Quads across the strip in each segment.
const ACROSS: u32 = 30;

/// A strip from x = 0 to 2^depth, one unit a segment of the finest level, in the plane z = 0.
#[derive(Debug)]
pub struct Strip {
    /// The finest segments alone.
    pub mesh: Mesh,
    /// The segments of all levels, a cluster each.
    pub steps: Mesh,
    /// Groups of two segments each.
    pub groups: Vec<Group>,
    /// See [`Levels::new`].
    pub made_from: Vec<u32>,
    /// See [`Levels::new`].
    pub replaced_by: Vec<u32>,
    /// From where to where along x each cluster reaches.
    pub spans: Vec<[u32; 2]>,
}

impl Strip {
    /// Makes a strip with errors that grow by random steps, some of them none.
    #[must_use]
    pub fn random(rng: &mut Rng, depth: u32, one_sided: bool) -> Self {
        let (mut spans, mut made_from, mut replaced_by) = (Vec::new(), Vec::new(), Vec::new());
        let mut groups: Vec<Group> = Vec::new();
        for level in 0..=depth {
            let first = spans.len();
            for at in 0..1 << (depth - level) {
                let span = [at << level, (at + 1) << level];
                spans.push(span);
                replaced_by.push(NO_GROUP);
                made_from.push(NO_GROUP);
                if level == 0 {
                    continue;
                }
                // Of the level below, which came before all of this one's.
                let below = first - (2 << (depth - level)) as usize + 2 * at as usize;
                let group = groups.len() as u32;
                (replaced_by[below], replaced_by[below + 1]) = (group, group);
                *made_from.last_mut().expect("pushed") = group;
                let finer = [below, below + 1].map(|c| made_from[c]);
                let error =
                    finer.iter().filter(|&&g| g != NO_GROUP).map(|&g| groups[g as usize].error);
                let error = error.fold(0.0, f32::max) + rng.below(3) as f32 * 0.01;
                let radius = (1 << level) as f32 * 0.5 + 1.0;
                let centre = [(span[0] + span[1]) as f32 * 0.5, 0.0, 0.0];
                groups.push(Group { centre, radius, error });
            }
        }
        let strip = |spans: &[[u32; 2]]| {
            let mut data = MeshData::default();
            let mut clustering = Clustering::default();
            for span in spans {
                let first = data.positions.len() as u32;
                for row in 0..=ACROSS {
                    let y = row as f32 / ACROSS as f32 - 0.5;
                    data.positions.extend(span.map(|x| [x as f32, y, 0.0]));
                }
                for row in 0..ACROSS {
                    let v = first + 2 * row;
                    data.indices.extend([v, v + 1, v + 2, v + 2, v + 1, v + 3]);
                }
                clustering.clusters.push(Cluster {
                    first_triangle: clustering.order.len() as u32,
                    triangle_count: 2 * ACROSS,
                    part: 0,
                });
                let next = clustering.order.len() as u32;
                clustering.order.extend(next..next + 2 * ACROSS);
            }
            let triangle_count = clustering.order.len() as u32;
            data.parts = vec![Part { triangle_count, two_sided: !one_sided, ..Part::default() }];
            (data, clustering)
        };
        let (data, clustering) = strip(&spans);
        let steps = Mesh::with_clusters(data, &clustering).expect("made right");
        let mesh = Mesh::new(strip(&spans[..1 << depth]).0).expect("made right");
        Self { mesh, steps, groups, made_from, replaced_by, spans }
    }

    /// Its levels.
    #[must_use]
    pub fn levels(&self) -> Levels {
        let (made_from, replaced_by) = (self.made_from.clone(), self.replaced_by.clone());
        Levels::new(&self.steps, &self.groups, made_from, replaced_by).expect("made right")
    }
}

/// A ball and coarser balls in it, as a chain of levels whose errors are known.
#[derive(Debug)]
pub struct Balls {
    /// The finest.
    pub mesh: Mesh,
    /// The others, one level after the other.
    pub coarse: Mesh,
    /// Its levels.
    pub levels: Levels,
}

impl Balls {
    /// Balls of radius 1 with so many rings, the finest first. `honesty` times the true error is what the levels state: less
    /// than 1 for levels that do not keep their word.
    ///
    /// # Panics
    /// Without a coarser one.
    #[must_use]
    pub fn new(rings: &[u32], honesty: f64) -> Self {
        let mut data = MeshData::default();
        let mut clustering = Clustering::default();
        let (mut groups, mut made_from, mut replaced_by) = (Vec::new(), Vec::new(), Vec::new());
        for (level, &rings) in (0..).zip(&rings[1..]) {
            let (positions, indices) = crate::soups::ball(rings, 2 * rings);
            let (first, triangles) = (data.positions.len() as u32, indices.len() as u32 / 3);
            let before = data.indices.len() as u32 / 3;
            data.positions.extend(positions);
            data.indices.extend(indices.iter().map(|i| i + first));
            // So few that no cluster has too many vertices, however long the columns are that it is cut from.
            for at in (0..triangles).step_by(40) {
                let triangle_count = 40.min(triangles - at);
                let first_triangle = before + at;
                clustering.clusters.push(Cluster { first_triangle, triangle_count, part: 0 });
                made_from.push(level);
                replaced_by.push(level + 1);
            }
            // A triangle lies within the sphere by as much as the circle around it is large, and a quad's is around its
            // diagonal.
            let step = std::f64::consts::PI / f64::from(rings);
            let error = (1.0 - step.cos().sqrt()) * honesty;
            groups.push(Group { centre: [0.0; 3], radius: 1.0, error: error as f32 });
        }
        let last = groups.len() as u32;
        replaced_by.iter_mut().filter(|g| **g == last).for_each(|g| *g = NO_GROUP);
        let triangle_count = data.indices.len() as u32 / 3;
        clustering.order = (0..triangle_count).collect();
        data.parts = vec![Part { triangle_count, ..Part::default() }];
        let coarse = Mesh::with_clusters(data, &clustering).expect("made right");
        let levels = Levels::new(&coarse, &groups, made_from, replaced_by).expect("made right");
        let (positions, indices) = crate::soups::ball(rings[0], 2 * rings[0]);
        let fine = MeshData { positions, indices, ..MeshData::default() };
        Self { mesh: Mesh::new(fine).expect("made right"), coarse, levels }
    }

    /// Adds both meshes to a scene, and the levels: the number of the finest.
    ///
    /// # Panics
    /// Never: they fit each other.
    pub fn add_to(self, scene: &mut cullet::Scene) -> cullet::MeshId {
        let (mesh, coarse) = (scene.add_mesh(self.mesh), scene.add_mesh(self.coarse));
        scene.add_levels(mesh, coarse, self.levels).expect("made for it");
        mesh
    }
}

/// A round ball, its one coarse level within it, and beads behind it that only the round ball hides: they are near its rim.
/// The ball is slot 0. For a view from [0, 0, 6] to the origin.
///
/// # Panics
/// Never: what it is made of is right.
#[must_use]
pub fn ball_before_beads() -> cullet::Scene {
    use cullet::{Instance, Scene, Transform};
    let mut scene = Scene::new();
    let ball = Balls::new(&[48, 3], 1.0).add_to(&mut scene);
    let bead = scene.add_mesh(crate::meshes::block([-0.02; 3], [0.02; 3]));
    scene.add(Instance::new(ball, Transform::IDENTITY)).expect("few");
    for k in 0..48 {
        let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 48.0).sin_cos();
        let place = [1.26 * cos, 1.26 * sin, -2.0];
        scene.add(Instance::new(bead, Transform::from_translation(place))).expect("few");
    }
    scene
}
