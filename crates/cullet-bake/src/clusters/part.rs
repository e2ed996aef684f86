//! The clusters of one part: the steps in their order.

use cullet::MeshData;

use super::merge::{Estimate, Limits, MergeCosts, Start, links, merge};
use super::options::{ClusterOptions, Probability};
use super::refine::{Partition, Weights};
use super::spatial;
use super::surface::{Frame, PartSurface};
use super::views::Views;
use super::volume::{Against, Volumes};
use crate::sample::{nearby, view_points};

/// One part to be clustered.
pub(super) struct Task<'a> {
    pub(super) data: &'a MeshData,
    pub(super) surface: &'a PartSurface,
    pub(super) frame: &'a Frame,
    pub(super) options: &'a ClusterOptions,
    pub(super) two_sided: bool,
}

/// The clusters of one part.
pub(super) struct Made {
    /// The cluster of each triangle.
    pub(super) of: Vec<u32>,
    /// Whether each cluster is drawn without a test.
    pub(super) never: Vec<bool>,
    /// The expected cost, in triangles drawn.
    pub(super) cost: f64,
    /// Triangles culled by the ideal test, on average.
    pub(super) ideal: f64,
    /// Triangles that face away, on average.
    pub(super) exact: f64,
}

/// Heat of the random moves of the first round, in triangles.
const HEAT: f64 = 0.4;

impl Task<'_> {
    /// `step` is told the share that is done; once it returns false, the rest is done in the
    /// quickest way.
    pub(super) fn run(&self, step: &mut dyn FnMut(f32) -> bool) -> Made {
        if self.two_sided {
            // Nobody is behind a triangle with two fronts.
            let views = Views::<1>::nowhere(self.surface.len());
            return self.with_views(&views, step);
        }
        match self.options.views {
            0..=256 => self.with_views(&self.views::<4>(), step),
            257..=512 => self.with_views(&self.views::<8>(), step),
            _ => self.with_views(&self.views::<16>(), step),
        }
    }

    fn views<const W: usize>(&self) -> Views<W> {
        let points = view_points(W * 64, &self.options.distances);
        Views::new(&self.data.positions, self.surface, self.frame, &points)
    }

    fn limits(&self) -> Limits {
        Limits {
            vertices: self.options.max_vertices as usize,
            triangles: self.options.max_triangles as usize,
        }
    }

    fn with_views<const W: usize>(
        &self,
        views: &Views<W>,
        step: &mut dyn FnMut(f32) -> bool,
    ) -> Made {
        let unit = views.unit();
        let in_units = |v: f64| (v * unit as f64).round() as i64;
        let weights = Weights {
            test: in_units(self.options.test_cost),
            vertex: in_units(self.options.vertex_cost),
        };
        let mut going = step(0.0);
        let (of, clusters) = if going {
            self.first(views, step)
        } else {
            spatial::split(self.surface, self.limits())
        };
        going = going && step(0.4);
        let mut partition =
            Partition::new(self.surface, views, self.limits(), weights, of, clusters);
        let rounds = if going { self.options.rounds } else { 0 };
        for round in 0..rounds {
            // Progress within the half that all rounds take.
            let done = |part: f32| 0.4 + 0.5 * (round as f32 + part) / rounds as f32;
            partition.descend(8);
            partition.dissolve();
            partition.descend(8);
            let sweeps = self.options.sweeps;
            let heat = HEAT / f64::from(round + 1);
            partition.anneal(heat, sweeps, |s| {
                going = step(done(0.3 + 0.5 * s as f32 / sweeps as f32));
                going
            });
            partition.descend(8);
            partition.dissolve();
            partition.descend(8);
            going = going && step(done(1.0));
            if !going {
                break;
            }
        }
        let (of, clusters) = partition.finish();
        let (of, clusters) = if going { self.fill(views, of, clusters) } else { (of, clusters) };
        step(1.0);
        self.judge(views, of, clusters)
    }

    /// The first clusters: grown greedily, or cut by space where there is no facing to go by.
    fn first<const W: usize>(
        &self,
        views: &Views<W>,
        step: &mut dyn FnMut(f32) -> bool,
    ) -> (Vec<u32>, usize) {
        if self.two_sided {
            return spatial::split(self.surface, self.limits());
        }
        let positions = &self.data.positions;
        let volumes = |against| Volumes::new(positions, self.surface, self.frame, against);
        match self.options.probability {
            Probability::Views => self.grow(views, step),
            Probability::SceneBox { scale } => {
                let all = self.surface.boxes.iter();
                let all = all.fold(cullet::bounds::Aabb::EMPTY, |a, b| a.union(b));
                let [low, high] = [all.min, all.max].map(|p| self.frame.place(p));
                let (middle, half) = ((low + high) * 0.5, (high - low) * 0.5);
                // A flat mesh has viewers on both sides all the same.
                let half = half.max(glam::DVec3::splat(half.max_element() * 0.1)) * scale;
                self.grow(&volumes(Against::Fixed([middle - half, middle + half])), step)
            }
            Probability::NearBox { diagonals } => {
                self.grow(&volumes(Against::Around(diagonals)), step)
            }
        }
    }

    fn grow<E: Estimate>(
        &self,
        estimate: &E,
        step: &mut dyn FnMut(f32) -> bool,
    ) -> (Vec<u32>, usize) {
        let costs = MergeCosts { test: self.options.test_cost, widest: f32::INFINITY };
        let all = self.surface.len().max(1) as f32;
        let start = Start::triangles(self.surface);
        merge(self.surface, estimate, &start, self.limits(), costs, |merges| {
            step(0.05 + 0.35 * merges as f32 / all)
        })
    }

    /// Merges what still may be merged, edges or not, if it is not too wide.
    fn fill<const W: usize>(
        &self,
        views: &Views<W>,
        of: Vec<u32>,
        clusters: usize,
    ) -> (Vec<u32>, usize) {
        // A full, flat and round cluster of average triangles is some 14 edges wide.
        let width = 30.0 * (self.area() / self.surface.len().max(1) as f64).sqrt() as f32;
        let boxes = spatial::boxes(self.surface, &of, clusters);
        let mut links = links(self.surface, &of);
        links.extend(nearby(&boxes));
        links.sort_unstable();
        links.dedup();
        // Above 0, so that a mesh of points in one place has a width too.
        let costs =
            MergeCosts { test: self.options.test_cost, widest: width.max(f32::MIN_POSITIVE) };
        let start = Start { of, clusters, links };
        merge(self.surface, views, &start, self.limits(), costs, |_| true)
    }

    /// Returns the area of all triangles, in the units of the mesh.
    fn area(&self) -> f64 {
        let at = |v: u32| glam::DVec3::from(self.data.positions[v as usize].map(f64::from));
        let corners = self.surface.corners.iter().map(|c| c.map(at));
        corners.map(|[a, b, c]| (b - a).cross(c - a).length() * 0.5).sum()
    }

    fn judge<const W: usize>(&self, views: &Views<W>, of: Vec<u32>, clusters: usize) -> Made {
        let mut state = vec![([u64::MAX; W], 0i64); clusters];
        let mut exact = 0;
        for (t, &c) in of.iter().enumerate() {
            let (bits, count) = &mut state[c as usize];
            *bits = views.join(bits, &views.behind[t]);
            *count += 1;
            exact += views.hits(&views.behind[t]);
        }
        let unit = views.unit() as f64;
        let mut made =
            Made { of, never: vec![], cost: 0.0, ideal: 0.0, exact: exact as f64 / unit };
        for (bits, count) in state {
            let culled = (views.hits(&bits) * count) as f64 / unit;
            made.ideal += culled;
            made.never.push(culled <= self.options.test_cost);
            made.cost += count as f64 - (culled - self.options.test_cost).max(0.0);
        }
        if self.two_sided {
            made.never.fill(true);
        }
        made
    }
}
