//! A benchmark scene, made ready: boxes in batches, views, and the order of what is drawn.

use cullet::bounds::{Aabb, Boxes};
use cullet::cull::Indices;
use cullet::cull::frustum::batch::{Planes, cull_boxes};
use cullet::{Depth, Simd, View};
use cullet_command::exit::Failure;
use cullet_maps::occscn::Occscn;

/// Boxes of what is drawn one by one.
#[derive(Debug)]
pub(super) struct Pieces {
    /// The box of each.
    bounds: Vec<Aabb>,
    /// The same as a batch.
    pub(super) boxes: Boxes,
}

impl Pieces {
    fn new(bounds: Vec<Aabb>) -> Self {
        Self { boxes: Boxes::from_slice(&bounds), bounds }
    }
}

/// Scene of a measurement.
#[derive(Debug)]
pub(super) struct Prepared {
    /// Triangles and meshes.
    pub(super) scene: Occscn,
    /// The boxes of the file's meshes.
    mesh_boxes: Boxes,
    /// Pieces that are drawn one by one: those meshes, unless a rasteriser cuts them itself.
    pub(super) pieces: Pieces,
    /// The boxes that are tested.
    pub(super) objects: Vec<Aabb>,
    /// The same as a batch.
    pub(super) object_boxes: Boxes,
    /// The views, at the resolution of the measurement.
    pub(super) views: Vec<View>,
}

impl Prepared {
    /// A scene at a resolution, drawn mesh by mesh.
    pub(super) fn new(scene: Occscn, size: [u32; 2]) -> Result<Self, Failure> {
        let meshes: Vec<Aabb> = (0..scene.meshes.len()).map(|m| scene.mesh_bounds(m)).collect();
        let objects: Vec<Aabb> =
            scene.objects.iter().map(|&[min, max]| Aabb { min, max }).collect();
        let views: Result<Vec<View>, Failure> =
            (0..scene.cameras.len()).map(|i| view(&scene, i, size)).collect();
        Ok(Self {
            mesh_boxes: Boxes::from_slice(&meshes),
            pieces: Pieces::new(meshes),
            object_boxes: Boxes::from_slice(&objects),
            objects,
            views: views?,
            scene,
        })
    }

    /// The same, drawn in pieces that have these boxes.
    pub(super) fn in_pieces(self, bounds: Vec<Aabb>) -> Self {
        Self { pieces: Pieces::new(bounds), ..self }
    }

    /// The pieces that a view may see, nearest box first; those equally near to within a hundredth
    /// in their order. The eye is the file's.
    pub(super) fn sorted(&self, simd: Simd, view: usize, scratch: &mut Scratch) {
        let Scratch { pieces, visible, order, spare } = scratch;
        cull_boxes(simd, &Planes::new(&self.views[view].frustum()), &self.pieces.boxes, visible);
        let eye = self.scene.cameras[view].eye;
        order.clear();
        order.extend(visible.iter().map(|&m| {
            let b = &self.pieces.bounds[m as usize];
            let outside = |k: usize| (b.min[k] - eye[k]).max(eye[k] - b.max[k]).max(0.0);
            let distance: f32 = (0..3).map(|k| outside(k) * outside(k)).sum();
            // Distances are not negative, so their bits sort as they do.
            (u64::from(distance.to_bits()) << 32) | u64::from(m)
        }));
        sort(order, spare);
        pieces.clear();
        pieces.extend(order.iter().map(|&key| key as u32));
    }

    /// How many triangles the file's meshes have that a view may see.
    pub(super) fn triangles_in(&self, simd: Simd, view: usize) -> u64 {
        let mut visible = Indices::default();
        let planes = Planes::new(&self.views[view].frustum());
        cull_boxes(simd, &planes, &self.mesh_boxes, &mut visible);
        let of = |&m: &u32| u64::from(self.scene.meshes[m as usize].triangle_count);
        visible.iter().map(of).sum()
    }
}

/// Memory that [`Prepared::sorted`] works in, and its result.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    /// Pieces, in the order to draw them.
    pub(super) pieces: Vec<u32>,
    visible: Indices,
    order: Vec<u64>,
    spare: Vec<u64>,
}

/// Sorts by the highest sixteen bits, eight at a time; what is equal stays in its order. Three
/// times as fast as by all bits, and for drawing front to back as good.
fn sort(keys: &mut Vec<u64>, spare: &mut Vec<u64>) {
    spare.clear();
    spare.resize(keys.len(), 0);
    for shift in [48, 56] {
        let digit = |key: u64| (key >> shift & 0xff) as usize;
        let mut next = [0_usize; 256];
        keys.iter().for_each(|&key| next[digit(key)] += 1);
        let mut first = 0;
        for next in &mut next {
            first += std::mem::replace(next, first);
        }
        for &key in keys.iter() {
            let place = &mut next[digit(key)];
            spare[*place] = key;
            *place += 1;
        }
        std::mem::swap(keys, spare);
    }
}

/// A camera of a scene as a view of some pixels.
pub fn view(scene: &Occscn, camera: usize, size: [u32; 2]) -> Result<View, Failure> {
    let matrix = scene.cameras[camera].clip_from_world.map(f64::from);
    View::from_matrix(matrix, Depth::Standard, size)
        .map_err(|e| Failure::input(format!("camera {camera}: {e}")))
}
