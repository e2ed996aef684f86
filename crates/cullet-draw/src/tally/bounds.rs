//! Boxes against spheres as bounds of instances: how many each keeps for nothing, and at what cost.

use cullet::bounds::Side;
use cullet::bounds::{Boxes, Sphere, Spheres};
use cullet::cull::frustum::batch::{Indices, Planes, SpherePlanes, cull_boxes, cull_spheres};
use cullet::cull::frustum::triangles::ObjectRegion;
use cullet::{Culler, Scene, View, view::Frustum};

/// Boxes and spheres of instances in one view.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BoundsCounts {
    /// Instances that have both.
    pub tested: u64,
    /// Instances whose box is kept.
    pub boxes_kept: u64,
    /// Instances whose sphere is kept.
    pub spheres_kept: u64,
    /// Instances with a triangle that the frustum's triangle test keeps: what a perfect bound
    /// keeps.
    pub in_frustum: u64,
    /// Nanoseconds that the test of a box takes.
    pub box_ns: f64,
    /// Nanoseconds that the test of a sphere takes.
    pub sphere_ns: f64,
}

/// Both bounds of every instance that has any, and room for the answers.
#[derive(Debug)]
pub struct BoundsTest {
    /// Slots of the instances.
    slots: Vec<u32>,
    boxes: Boxes,
    spheres: Spheres,
    hits: Indices,
}

impl BoundsTest {
    /// Spheres are fitted to world-space vertices, so a scene with more of them goes without.
    const MOST_VERTICES: u64 = 20_000_000;

    /// Fits a sphere to each instance with finite bounds. `None` if that would take too long, or if
    /// there is no such instance.
    #[must_use]
    pub fn new(scene: &Scene) -> Option<Self> {
        let vertices: u64 = scene.slots().map(|s| scene.mesh(s).positions().len() as u64).sum();
        if vertices > Self::MOST_VERTICES {
            return None;
        }
        let mut boxes = Boxes::new();
        let (mut slots, mut spheres) = (Vec::new(), Vec::new());
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
            slots.push(slot);
            boxes.push(&b);
            spheres.push(Sphere::from_points(&points));
        }
        (!spheres.is_empty()).then(|| Self {
            slots,
            boxes,
            spheres: Spheres::from_slice(&spheres),
            hits: Indices::new(),
        })
    }

    /// Tests both against a view's frustum, and counts what a perfect bound would keep. `clock`
    /// tells nanoseconds.
    pub fn measure(
        &mut self,
        scene: &Scene,
        view: &View,
        culler: &Culler,
        clock: fn() -> u64,
    ) -> BoundsCounts {
        let frustum = view.frustum();
        let relative = frustum.relative_to(scene.origin());
        let (planes, sphere_planes) = (Planes::new(&relative), SpherePlanes::new(&relative));
        let tested = self.boxes.len();
        let mut time = |test: &mut dyn FnMut(&mut Indices)| {
            // The first run warms the cache and grows the list; the better of two others is the
            // time.
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
        let (spheres_kept, sphere_ns) =
            time(&mut |hits| cull_spheres(culler.simd, &sphere_planes, spheres, hits));
        let (boxes_kept, box_ns) = time(&mut |hits| cull_boxes(culler.simd, &planes, boxes, hits));
        let kept = self.hits.iter().map(|&index| self.slots[index as usize]);
        let in_frustum = kept.filter(|&slot| has_triangle_in(scene, &frustum, &planes, slot));
        BoundsCounts {
            tested: tested as u64,
            boxes_kept,
            spheres_kept,
            in_frustum: in_frustum.count() as u64,
            box_ns,
            sphere_ns,
        }
    }
}

/// Whether a perfect bound would keep an instance: the test of its triangles leaves one, or it
/// cannot be said.
fn has_triangle_in(scene: &Scene, frustum: &Frustum, planes: &Planes, slot: u32) -> bool {
    if !scene.is_rigid(slot) || planes.classify_box(&scene.bounds(slot)) == Side::Inside {
        return true;
    }
    let mesh = scene.mesh(slot);
    let region = ObjectRegion::new(frustum, scene.transform(slot));
    let mut left = Vec::new();
    mesh.clusters().iter().any(|cluster| {
        let triangles = cluster.triangles();
        region.keep_into(mesh.positions(), mesh.indices(), triangles, region.present(), &mut left);
        !left.is_empty()
    })
}
