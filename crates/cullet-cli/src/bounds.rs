//! Boxes against spheres as bounds of instances: how many each keeps for nothing, and at what cost.

use cullet::bounds::{Boxes, Sphere, Spheres};
use cullet::cull::frustum::batch::{Indices, Planes, cull_boxes, cull_spheres};
use cullet::{Backface, Culler, Output, Scene, View, ViewState, Visible};

use crate::record::BoundsRecord;
use crate::survey::clock;

/// Both bounds of every instance that has any, and room for the answers.
#[derive(Debug)]
pub(crate) struct BoundsTest {
    boxes: Boxes,
    spheres: Spheres,
    hits: Indices,
    state: ViewState,
    result: Visible,
}

impl BoundsTest {
    /// Spheres are fitted to world-space vertices, so a scene with more of them goes without.
    const MOST_VERTICES: u64 = 20_000_000;

    /// Fits a sphere to each instance with finite bounds. `None` if that would take too long, or if
    /// there is no such instance.
    pub(crate) fn new(scene: &Scene) -> Option<Self> {
        let vertices: u64 = scene.slots().map(|s| scene.mesh(s).positions().len() as u64).sum();
        if vertices > Self::MOST_VERTICES {
            return None;
        }
        let mut boxes = Boxes::new();
        let mut spheres = Vec::new();
        let mut points = Vec::new();
        for slot in scene.slots() {
            let b = scene.bounds(slot);
            if !b.is_finite() || b.is_empty() {
                continue;
            }
            let m = scene.transform(slot).to_matrix();
            let origin = scene.origin();
            points.clear();
            points.extend(scene.mesh(slot).positions().iter().map(|p| -> [f32; 3] {
                let p = p.map(f64::from);
                std::array::from_fn(|r| {
                    let v = m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r];
                    (v - origin[r]) as f32
                })
            }));
            boxes.push(&b);
            spheres.push(Sphere::from_points(&points));
        }
        (!spheres.is_empty()).then(|| Self {
            boxes,
            spheres: Spheres::from_slice(&spheres),
            hits: Indices::new(),
            state: ViewState::default(),
            result: Visible::default(),
        })
    }

    /// Tests both against a view's frustum, and counts what a perfect bound would keep.
    pub(crate) fn measure(&mut self, scene: &Scene, view: &View, culler: &Culler) -> BoundsRecord {
        let planes = Planes::new(&view.frustum().relative_to(scene.origin()));
        let tested = self.boxes.len();
        let mut time = |test: &mut dyn FnMut(&mut Indices)| {
            // The first run warms the cache and grows the list; the better of two others is the time.
            test(&mut self.hits);
            let run = |hits: &mut Indices, test: &mut dyn FnMut(&mut Indices)| {
                let start = clock();
                test(hits);
                clock() - start
            };
            let best = run(&mut self.hits, test).min(run(&mut self.hits, test));
            (self.hits.len() as u64, best as f64 / tested.max(1) as f64)
        };
        let (boxes, spheres) = (&self.boxes, &self.spheres);
        let (boxes_kept, box_ns) = time(&mut |hits| cull_boxes(culler.level, &planes, boxes, hits));
        let (spheres_kept, sphere_ns) =
            time(&mut |hits| cull_spheres(culler.level, &planes, spheres, hits));
        let only_frustum = Culler {
            frustum: true,
            backface: Backface::Off,
            degenerate: false,
            detail: None,
            output: Output::Triangles,
            reasons: false,
            clock: None,
            ..culler.clone()
        };
        only_frustum.cull_one(scene, view, &mut self.state, &mut self.result);
        BoundsRecord {
            tested: tested as u64,
            boxes_kept,
            spheres_kept,
            in_frustum: self.result.instance_count,
            box_ns,
            sphere_ns,
        }
    }
}
