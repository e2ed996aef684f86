//! Topology of a surface once equal positions are welded: closed, manifold, consistently wound?

use cullet::Mesh;
use cullet::bounds::Aabb;
use cullet::mesh::Alpha;
use glam::DVec3;
use thiserror::Error;

use crate::nesting::Nesting;
use crate::surface::{Shells, Surface, for_each_edge};

/// Reason why a mesh is not a solid; the first reason found, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum NotSolid {
    /// It has no triangle that covers anything.
    #[error("it has no triangles")]
    Empty,
    /// A part is blended or alpha-masked.
    #[error("part {part} is not opaque")]
    NotOpaque {
        /// Number of the part.
        part: u32,
    },
    /// Edges with one triangle.
    #[error("it is open: {edges} boundary {}", edge(*edges))]
    Open {
        /// How many.
        edges: u32,
    },
    /// Edges with more than two triangles.
    #[error("it is not manifold: {edges} {} with more than two triangles", edge(*edges))]
    NonManifold {
        /// How many.
        edges: u32,
    },
    /// Edges whose two triangles run along them in the same direction.
    #[error("its winding is inconsistent: {edges} misoriented {}", edge(*edges))]
    Misoriented {
        /// How many.
        edges: u32,
    },
    /// Wound inward: the volume is negative.
    #[error("it is wound inward: its volume is {volume:e}")]
    Inward {
        /// The signed volume.
        volume: f64,
    },
    /// Some shells are wound inward though they are no cavities of others.
    #[error("{shells} of its {of} shells are wound inward and are not cavities")]
    InwardShells {
        /// How many.
        shells: u32,
        /// Total number of shells.
        of: u32,
    },
    /// It encloses nothing.
    #[error("it encloses no volume")]
    NoVolume,
}

fn edge(edges: u32) -> &'static str {
    if edges == 1 { "edge" } else { "edges" }
}

/// Facts about a surface whose equal positions are welded. The caller's vertices are not changed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Topology {
    /// Distinct positions that some triangle uses.
    pub vertices: u32,
    /// Triangles left after dropping those that welding makes degenerate.
    pub triangles: u32,
    /// Distinct edges.
    pub edges: u32,
    /// Edges of one triangle.
    pub boundary_edges: u32,
    /// Edges of more than two triangles.
    pub non_manifold_edges: u32,
    /// Edges whose two triangles run along them in the same direction.
    pub misoriented_edges: u32,
    /// Components connected by edges.
    pub shells: u32,
    /// Shells that are closed, manifold and consistently wound, but inward, and no cavity of
    /// another shell: the space around them is not inside anything.
    pub inward_shells: u32,
    /// Signed volume in cubed units of the mesh, about the middle of the surface: positive when
    /// wound outward. Exactly 0 where it cannot be told from rounding.
    pub volume: f64,
}

impl Topology {
    /// Returns the topology of `mesh`, with all its parts joined. Costs as [`Topology::of`]: keep
    /// the result.
    #[must_use]
    pub fn of_mesh(mesh: &Mesh) -> Self {
        Self::of(mesh.positions(), mesh.indices())
    }

    /// Returns the topology of a triangle list once equal positions are welded (−0 equals 0).
    ///
    /// Triangles whose corners are not three different positions are ignored, and so are those with
    /// an index out of range and indices that make no whole triangle. Triangles of zero area with
    /// three different corners count: they close gaps. Expected O(n).
    #[must_use]
    pub fn of(positions: &[[f32; 3]], indices: &[u32]) -> Self {
        Self::of_surface(&Surface::welded(positions, indices))
    }

    /// Returns the topology of a triangle list as it is indexed: equal positions stay different
    /// vertices, so the seams of a model with texture coordinates count as boundaries. Otherwise as
    /// [`Topology::of`].
    #[must_use]
    pub fn of_indices(positions: &[[f32; 3]], indices: &[u32]) -> Self {
        Self::of_surface(&Surface::indexed(positions, indices))
    }

    /// Every edge is of just two triangles.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.boundary_edges == 0 && self.non_manifold_edges == 0
    }

    /// Whether the surface bounds a solid, opacity apart, or the first reason why not, in the order
    /// of [`NotSolid`].
    ///
    /// # Errors
    /// The reason.
    pub fn solid(&self) -> Result<(), NotSolid> {
        if self.triangles == 0 {
            return Err(NotSolid::Empty);
        }
        if self.boundary_edges > 0 {
            return Err(NotSolid::Open { edges: self.boundary_edges });
        }
        if self.non_manifold_edges > 0 {
            return Err(NotSolid::NonManifold { edges: self.non_manifold_edges });
        }
        if self.misoriented_edges > 0 {
            return Err(NotSolid::Misoriented { edges: self.misoriented_edges });
        }
        if self.volume < 0.0 {
            return Err(NotSolid::Inward { volume: self.volume });
        }
        if self.inward_shells > 0 {
            let (shells, of) = (self.inward_shells, self.shells);
            return Err(NotSolid::InwardShells { shells, of });
        }
        // Positions that are not finite end here too: their volume is NaN.
        if self.volume > 0.0 { Ok(()) } else { Err(NotSolid::NoVolume) }
    }

    fn of_surface(surface: &Surface<'_>) -> Self {
        let shell_map = ShellMap::of(surface);
        let inward: Vec<u32> = (0..shell_map.facts.len() as u32)
            .filter(|&s| shell_map.facts[s as usize].is_inward())
            .collect();
        let mut inward_shells = 0;
        if !inward.is_empty() {
            let nesting = Nesting::new(surface, &shell_map.shell_of, shell_map.facts.len());
            let others = |o: u32| i32::from(shell_map.facts[o as usize].is_oriented_solid());
            let wrong = |&s: &u32| nesting.winding_around(s, others) < 1;
            inward_shells = inward.into_iter().filter(wrong).count() as u32;
        }
        Self {
            vertices: used_vertices(surface),
            triangles: surface.corners.len() as u32,
            shells: shell_map.facts.len() as u32,
            inward_shells,
            volume: volume(surface),
            ..shell_map.counts
        }
    }
}

/// Decides whether `mesh` is a solid in the sense of the project: closed, manifold, consistently
/// wound outward, of non-zero volume, and opaque in every part. Judges the whole mesh, with all its
/// parts joined, and costs as [`Topology::of`].
///
/// # Errors
/// The first reason why it is not.
pub fn solid(mesh: &Mesh) -> Result<(), NotSolid> {
    if let Some(part) = mesh.parts().iter().position(|p| p.alpha != Alpha::Opaque) {
        return Err(NotSolid::NotOpaque { part: part as u32 });
    }
    Topology::of_mesh(mesh).solid()
}

fn used_vertices(surface: &Surface<'_>) -> u32 {
    let mut used = vec![false; surface.positions.len()];
    surface.corners.iter().flatten().for_each(|&v| used[v as usize] = true);
    used.into_iter().map(u32::from).sum()
}

/// Signed volume about the middle, 0 if rounding might have made it.
fn volume(surface: &Surface<'_>) -> f64 {
    let points = surface.corners.iter().flatten().map(|&v| surface.positions[v as usize]);
    let bounds = points.fold(Aabb::EMPTY, |b, p| b.union(&Aabb::new(p, p)));
    let middle = DVec3::from(bounds.center());
    rounded_volume((0..surface.corners.len()).map(|t| surface.volume6(t, middle)))
}

/// A sixth of the sum of the terms, or 0 where the rounding of the sum might be all of it.
fn rounded_volume(terms: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut size, mut count) = (0.0, 0.0, 0.0);
    for t in terms {
        sum += t;
        size += f64::abs(t);
        count += 1.0;
    }
    // Each addition errs by at most half an epsilon of the sum so far; each term by a few of its
    // own.
    let error = size * (count + 16.0) * f64::EPSILON;
    if sum.abs() <= error { 0.0 } else { sum / 6.0 }
}

/// Findings from the edges of one shell.
#[derive(Clone, Copy, Debug, Default)]
struct ShellFacts {
    open: bool,
    non_manifold: bool,
    misoriented: bool,
    /// Signed volume, positive when the shell is wound outward, about one of its own vertices. It
    /// has a meaning for closed shells only.
    volume: f64,
}

impl ShellFacts {
    fn is_oriented_solid(&self) -> bool {
        !(self.open || self.non_manifold || self.misoriented)
    }

    fn is_inward(&self) -> bool {
        self.is_oriented_solid() && self.volume < 0.0
    }
}

/// The shells of a surface, and the counts of its edges.
struct ShellMap {
    /// Edge counts; the rest is not filled in.
    counts: Topology,
    shell_of: Vec<u32>,
    facts: Vec<ShellFacts>,
}

impl ShellMap {
    fn of(surface: &Surface<'_>) -> Self {
        let triangles = surface.corners.len();
        let mut counts = Topology::default();
        let mut shells = Shells::new(triangles);
        // Faults at a triangle's edges, for its shell once that is known.
        let mut marks = vec![0u8; triangles];
        let [open, many, turned] = [1u8, 2, 4];
        for_each_edge(surface, |uses| {
            counts.edges += 1;
            let first = uses[0].triangle();
            match uses {
                [_] => {
                    counts.boundary_edges += 1;
                    marks[first] |= open;
                }
                [a, b] => {
                    let odd = a.falling() == b.falling();
                    counts.misoriented_edges += u32::from(odd);
                    marks[first] |= if odd { turned } else { 0 };
                    shells.join(first, b.triangle());
                }
                _ => {
                    counts.non_manifold_edges += 1;
                    marks[first] |= many;
                    uses[1..].iter().for_each(|other| shells.join(first, other.triangle()));
                }
            }
        });
        let (count, shell_of) = shells.number();
        let mut facts = vec![ShellFacts::default(); count];
        let mut about = vec![None; count];
        for (t, &shell) in shell_of.iter().enumerate() {
            let f = &mut facts[shell as usize];
            f.open |= marks[t] & open != 0;
            f.non_manifold |= marks[t] & many != 0;
            f.misoriented |= marks[t] & turned != 0;
            let about: &mut Option<DVec3> = &mut about[shell as usize];
            let about = about.get_or_insert_with(|| surface.points(t)[0].map(f64::from).into());
            f.volume += surface.volume6(t, *about) / 6.0;
        }
        Self { counts, shell_of, facts }
    }
}
