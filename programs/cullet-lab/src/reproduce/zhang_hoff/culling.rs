//! How much the masks cull: two copies, seen from everywhere at one distance.

use crate::methods::Bulk;
use cullet::bounds::Sphere;
use cullet::cull::backface::ObjectEye;
use cullet::{
    Simd, Transform,
    view::{CullFace, FrontFace},
};
use cullet_mesh::{BackfaceMask, MaskGrid, NormalMasks, ViewCone};

use super::record::{PAPER, ShareRow, TableRow};
use crate::reproduce::model::Subject;
use crate::shapes::fibonacci;

/// Half the distance between the middles of the copies, in radii of one: they nearly touch.
const APART: f64 = 1.1;

/// Two copies of a model side by side, around the origin.
#[derive(Debug)]
pub struct Pair<'a> {
    /// The model.
    pub subject: &'a Subject,
    /// Where the origin of each copy is.
    pub offsets: [[f64; 3]; 2],
    /// The radius of the sphere around both.
    pub radius: f64,
}

/// The classes of the model's triangles, in the order of its mesh, for each grid of the paper.
#[derive(Debug)]
pub struct Grids(pub Vec<(MaskGrid, NormalMasks)>);

/// The shares at one distance.
#[derive(Debug)]
pub struct CullingFound {
    /// A row a grid.
    pub rows: Vec<ShareRow>,
    /// Triangles culled that the exact test keeps.
    pub lost: u64,
}

impl Grids {
    /// Builds the grids of a model.
    #[must_use]
    pub fn new(subject: &Subject) -> Self {
        let mesh = &subject.mesh;
        let grid = |n: u32| {
            // The sizes are constants of the paper, all of them possible.
            let grid = MaskGrid::new(n)?;
            let mut masks = NormalMasks::default();
            grid.encode_triangles(mesh.positions(), mesh.indices(), &mut masks);
            Some((grid, masks))
        };
        Self(PAPER.iter().filter_map(|p| grid(p.0)).collect())
    }
}

impl<'a> Pair<'a> {
    /// Copies of a model.
    #[must_use]
    pub fn new(subject: &'a Subject) -> Self {
        let ([x, y, z], radius) = (subject.centre(), subject.radius());
        let aside = |to: f64| [to * APART * radius - x, -y, -z];
        Self { subject, offsets: [aside(-1.0), aside(1.0)], radius: (APART + 1.0) * radius }
    }

    /// Triangles of both copies.
    #[must_use]
    pub fn triangles(&self) -> u64 {
        2 * u64::from(self.subject.mesh.triangle_count())
    }

    /// The viewer so many radii away, in the space of each copy.
    #[must_use]
    pub fn eyes(&self, direction: [f64; 3], radii: f64) -> [[f64; 4]; 2] {
        let p = direction.map(|v| v * radii * self.radius);
        self.offsets.map(|o| [p[0] - o[0], p[1] - o[1], p[2] - o[2], 1.0])
    }

    /// The distance in radii, to a hundredth, at which the share culled is nearest to the paper's
    /// where it is farthest from it, over N ≥ 6. (The paper's is one view; with large cells its
    /// luck is not that of the mean.)
    #[must_use]
    pub fn fit(&self, grids: &Grids, directions: u32) -> f64 {
        let level = Simd::best();
        let known: Vec<_> = grids.0.iter().zip(PAPER).filter(|(_, paper)| paper.0 >= 6).collect();
        let all = self.triangles() as f64 * f64::from(directions);
        let too_low = |radii: f64| {
            let mut culled = vec![0; known.len()];
            for i in 0..directions as usize {
                for eye in self.eyes(fibonacci(i, directions as usize), radii) {
                    for (((grid, masks), _), culled) in known.iter().zip(&mut culled) {
                        let mask = mask_to(grid, eye, &self.subject.sphere);
                        *culled += masks.count(level, &mask);
                    }
                }
            }
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for ((_, paper), culled) in known.iter().zip(culled) {
                let off = culled as f64 * 100.0 / all - paper.1;
                (low, high) = (low.min(off), high.max(off));
            }
            -low > high
        };
        // The farther the viewer, the narrower the cones, and the more is culled.
        let (mut near, mut far) = (1.2_f64, 60.0);
        while far - near > 0.005 {
            let middle = (near * far).sqrt();
            if too_low(middle) {
                near = middle;
            } else {
                far = middle;
            }
        }
        (near * 100.0).round() / 100.0
    }

    /// Shares culled by the masks and by the exact test, means over the directions; `step` is
    /// called after each.
    #[must_use]
    pub fn shares(
        &self,
        grids: &Grids,
        radii: f64,
        directions: u32,
        mut step: impl FnMut(),
    ) -> CullingFound {
        let level = Simd::best();
        let (mut culled, mut exact, mut lost) = (vec![0; grids.0.len()], 0, 0);
        let (mut words, mut kept) = (Vec::new(), Vec::new());
        for i in 0..directions as usize {
            for eye in self.eyes(fibonacci(i, directions as usize), radii) {
                exact += keep_exactly(self.subject, eye, &mut kept);
                for ((grid, masks), culled) in grids.0.iter().zip(&mut culled) {
                    let mask = mask_to(grid, eye, &self.subject.sphere);
                    masks.cull(level, &mask, &mut words);
                    *culled += ones(words.iter().copied());
                    lost += ones(words.iter().zip(&kept).map(|(c, k)| c & k));
                }
            }
            step();
        }
        let views = f64::from(directions);
        let percent = |n: u64| n as f64 * 100.0 / (self.triangles() as f64 * views);
        let row = |(&culled, (grid, _)): (&u64, &(MaskGrid, NormalMasks))| {
            let back = (culled as f64 / views).round() as u64;
            ShareRow {
                n: grid.cells(),
                classes: grid.classes(),
                front: self.triangles() - back,
                back,
                culled_percent: percent(culled),
                exact_percent: percent(exact),
            }
        };
        CullingFound { rows: culled.iter().zip(&grids.0).map(row).collect(), lost }
    }
}

/// Bits of the triangles that the test in f64 keeps; returns how many it culls.
pub fn keep_exactly(subject: &Subject, eye: [f64; 4], kept: &mut Vec<u64>) -> u64 {
    let mesh = &subject.mesh;
    let eye = ObjectEye::new(eye, &Transform::IDENTITY, FrontFace::default(), CullFace::Back);
    let count = eye.mask_into(mesh.positions(), mesh.indices(), kept);
    u64::from(mesh.triangle_count()) - count as u64
}

/// The mask of a viewing cone to a sphere.
#[must_use]
pub fn mask_to(grid: &MaskGrid, eye: [f64; 4], sphere: &Sphere) -> BackfaceMask {
    grid.mask(Simd::best(), ViewCone::to_sphere(eye, sphere).as_ref())
}

/// How many bits are set.
pub(super) fn ones(words: impl Iterator<Item = u64>) -> u64 {
    words.map(|w| u64::from(w.count_ones())).sum()
}

impl ShareRow {
    /// The row of Table 1 that it becomes beside the paper's; times are to come.
    pub(super) fn row(&self, (_, paper_percent, paper_ms): (u32, f64, f64)) -> TableRow {
        TableRow {
            n: self.n,
            classes: self.classes,
            front: self.front,
            back: self.back,
            culled_percent: self.culled_percent,
            paper_percent,
            exact_percent: self.exact_percent,
            ms_per_frame: None,
            speedup: None,
            even_speedup: 100.0 / (100.0 - self.culled_percent),
            paper_ms,
        }
    }
}
