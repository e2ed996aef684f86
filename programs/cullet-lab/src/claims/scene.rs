//! All occluders of a scene: drawn into a buffer, and as the triangles that they stand for.

use cullet::cull::occlusion::{Occluder, OcclusionBuffer};
use cullet::mesh::Alpha;
use cullet::{Mesh, Scene, Simd, View};

use cullet_draw::OccluderTriangles;

/// The meshes of a scene as occluders, each as [`Occluder::of_mesh`] makes it.
///
/// ```
/// use cullet::cull::occlusion::OcclusionBuffer;
/// use cullet::{Instance, Mesh, MeshData, Scene, Simd, Transform, View};
/// use cullet_lab::claims::{ClaimOptions, Claims, SceneOccluders, check_claims};
///
/// let mut scene = Scene::new();
/// let wall = scene.add_mesh(Mesh::new(MeshData {
///     positions: vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]],
///     indices: vec![0, 1, 2, 0, 2, 3],
///     ..MeshData::default()
/// })?);
/// scene.add(Instance::new(wall, Transform::IDENTITY))?;
/// let view = View::perspective([0.3, 0.2, 4.0], [0.0; 3], 1.0, 0.1, 100.0, [96, 64])?;
///
/// let occluders = SceneOccluders::new(&scene);
/// let mut buffer = OcclusionBuffer::new([96, 64])?;
/// occluders.draw(&view, Simd::best(), &mut buffer);
/// let triangles = occluders.triangles(&view);
/// let mut claims = Claims::of(&buffer);
/// let check = check_claims(&view, &claims, &triangles, &ClaimOptions::default());
/// assert!(check.claimed > 500 && check.wrong == 0);
///
/// // A pixel that nothing covers.
/// claims.claim(0, 0, 0.1);
/// let check = check_claims(&view, &claims, &triangles, &ClaimOptions::default());
/// assert_eq!((check.wrong, check.first[0].pixel), (1, [0, 0]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct SceneOccluders<'a> {
    scene: &'a Scene,
    /// One for each mesh.
    occluders: Vec<Occluder>,
}

impl<'a> SceneOccluders<'a> {
    /// Collects the occluders of every mesh of a scene. Occluders that were given to the scene
    /// ([`Scene::set_occluder`]) are ignored: they may be made of other triangles than the mesh's.
    ///
    /// Cost: that of [`Occluder::of_mesh`] for each mesh.
    #[must_use]
    pub fn new(scene: &'a Scene) -> Self {
        Self { scene, occluders: scene.meshes().iter().map(Occluder::of_mesh).collect() }
    }

    /// The slots of instances that occlude in a view: rigid and opaque, in one of its layers.
    fn slots(&self, view: &View) -> impl Iterator<Item = u32> {
        self.scene.slots().filter(|&slot| {
            let flags = self.scene.flags(slot);
            !(flags.no_occlusion || flags.transparent)
                && self.scene.is_rigid(slot)
                && self.scene.layers(slot) & view.layers != 0
        })
    }

    /// Turns a buffer to a view and draws all of them into it, front to back by the nearest points
    /// of their boxes: every one, whatever it costs and whether or not it is hidden by then.
    /// Returns how many shapes were drawn; those beyond an edge of the screen are not.
    ///
    /// The view is taken to draw front faces, as it does unless told otherwise.
    pub fn draw(&self, view: &View, simd: Simd, buffer: &mut OcclusionBuffer) -> u64 {
        let origin = self.scene.origin();
        buffer.begin(view, origin);
        let eye = view.eye();
        let mut order: Vec<(f64, u32, u32)> = Vec::new();
        for slot in self.slots(view) {
            let transform = self.scene.transform(slot);
            let shapes = self.occluders[self.scene.mesh_id(slot) as usize].shapes();
            for (shape, number) in shapes.iter().zip(0..) {
                let b = transform.transform_box(&shape.bounds(), origin);
                if buffer.test_box(&b) == cullet::cull::occlusion::Visibility::Outside {
                    continue;
                }
                let distance: f64 = (0..3)
                    .map(|a| {
                        let [low, high] = [b.min[a], b.max[a]].map(|v| f64::from(v) + origin[a]);
                        if view.is_orthographic() {
                            -(eye[a] * low).max(eye[a] * high)
                        } else {
                            (eye[a] - eye[a].clamp(low.min(high), high.max(low))).powi(2)
                        }
                    })
                    .sum();
                order.push((distance, slot, number));
            }
        }
        order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        for &(_, slot, shape) in &order {
            let occluder = &self.occluders[self.scene.mesh_id(slot) as usize];
            occluder.shapes()[shape as usize].draw(simd, buffer, self.scene.transform(slot));
        }
        order.len() as u64
    }

    /// The triangles that [`draw`](Self::draw) may have drawn in a view: all that are opaque of its
    /// instances, each with its sidedness.
    #[must_use]
    pub fn triangles(&self, view: &View) -> Vec<OccluderTriangles<'a>> {
        let runs: Vec<Vec<Run<'_>>> = self.scene.meshes().iter().map(runs).collect();
        let of_slot = |slot: u32| {
            let transform = *self.scene.transform(slot);
            let all = self.scene.flags(slot).double_sided;
            runs[self.scene.mesh_id(slot) as usize].iter().map(move |run| OccluderTriangles {
                positions: run.positions,
                indices: run.indices,
                transform,
                two_sided: run.two_sided || all,
            })
        };
        self.slots(view).flat_map(of_slot).collect()
    }
}

/// Opaque triangles of a mesh that follow each other and have as many sides.
#[derive(Clone, Copy, Debug)]
struct Run<'a> {
    positions: &'a [[f32; 3]],
    indices: &'a [u32],
    two_sided: bool,
}

/// Opaque triangles of a mesh.
fn runs(mesh: &Mesh) -> Vec<Run<'_>> {
    mesh.clusters()
        .chunk_by(|a, b| a.part == b.part && a.triangles().end == b.first_triangle)
        .filter_map(|some| {
            let part = &mesh.parts()[some[0].part as usize];
            let first = some[0].first_triangle as usize * 3;
            let count = some.iter().map(|c| c.triangle_count as usize * 3).sum::<usize>();
            (part.alpha == Alpha::Opaque).then(|| Run {
                positions: mesh.positions(),
                indices: &mesh.indices()[first..first + count],
                two_sided: part.two_sided,
            })
        })
        .collect()
}
