//! Subject of the reproductions: one solid of one-sided triangles, and the eyes that look at it.

use cullet::bounds::Sphere;
use cullet::mesh::Part;
use cullet::{Mesh, MeshData};
use cullet_command::args::SceneArgs;
use cullet_command::console::{Console, grouped};
use cullet_command::exit::{Exit, Failure};
use cullet_command::inputs;
use cullet_io::Model;
use cullet_scenes::knobbly_ball;
use glam::DVec3;

/// More triangles than this do not end within a minute.
const MOST_TRIANGLES: u64 = 1_000_000;

/// A model as one mesh that is drawn from its front alone.
#[derive(Debug)]
pub struct Subject {
    /// Name for people.
    pub name: String,
    /// All its triangles, one-sided.
    pub mesh: Mesh,
    /// Around all its triangles.
    pub sphere: Sphere,
    /// Why it is no solid, though it is taken for one.
    pub defect: Option<String>,
}

impl Subject {
    /// The file or built-in scene of that name, all its instances made one mesh with a part for
    /// each material of each instance; else a built-in solid of 69,312 triangles.
    pub(crate) fn load(model: Option<&str>, console: &Console) -> Result<Self, Failure> {
        let Some(scene) = model else {
            let (positions, indices) = knobbly_ball(76);
            let triangle_count = (indices.len() / 3) as u32;
            let parts = vec![Part { triangle_count, ..Part::default() }];
            let data = MeshData { positions, indices, parts, ..MeshData::default() };
            return Self::new("a built-in knobbly ball".into(), data);
        };
        let args = SceneArgs { one_sided: true, ..SceneArgs::of(scene) };
        let model = inputs::load(&args, console)?;
        let triangles = model.scene.triangle_count();
        if triangles > MOST_TRIANGLES {
            let message = format!(
                "{}: {} triangles in all its instances, {} at the most; choose a smaller model",
                model.name,
                grouped(triangles),
                grouped(MOST_TRIANGLES)
            );
            return Err(Failure { exit: Exit::Limit, message });
        }
        let data = joined(&model);
        Self::new(model.name, data)
    }

    /// The triangles of a mesh, whose parts should be one-sided.
    ///
    /// # Errors
    /// If the mesh is invalid, or none of its triangles has an area.
    pub fn new(name: String, data: MeshData) -> Result<Self, Failure> {
        let mesh = Mesh::new(data).map_err(|e| Failure::input(format!("{name}: {e}")))?;
        let solid = mesh.triangle_count() - mesh.degenerate_count();
        if solid == 0 {
            return Err(Failure::input(format!(
                "{name}: none of its {} triangles has an area; choose a model with a surface",
                mesh.triangle_count()
            )));
        }
        // Vertices that no triangle uses would only widen the cones.
        let used: Vec<[f32; 3]> = (0..solid).flat_map(|t| mesh.corners(t)).collect();
        let sphere = Sphere::from_points(&used);
        let defect = cullet_mesh::solid(&mesh).err().map(|e| e.to_string());
        Ok(Self { name, mesh, sphere, defect })
    }

    /// The data of the mesh, to be divided into other clusters.
    #[must_use]
    pub fn data(&self) -> MeshData {
        MeshData {
            positions: self.mesh.positions().to_vec(),
            indices: self.mesh.original_indices(),
            parts: self.mesh.parts().to_vec(),
            ..MeshData::default()
        }
    }

    /// The radius of its sphere.
    #[must_use]
    pub fn radius(&self) -> f64 {
        f64::from(self.sphere.radius)
    }

    /// The middle of its sphere.
    #[must_use]
    pub fn centre(&self) -> [f64; 3] {
        self.sphere.center.map(f64::from)
    }

    /// A point so many of its radii from its middle, as a homogeneous eye.
    #[must_use]
    pub fn eye(&self, direction: [f64; 3], radii: f64) -> [f64; 4] {
        let c = self.centre();
        let [x, y, z] = [0, 1, 2].map(|a| c[a] + direction[a] * radii * self.radius());
        [x, y, z, 1.0]
    }
}

/// The triangles of all instances in one space, around the middle of the scene so that f32 is fine
/// there.
fn joined(model: &Model) -> MeshData {
    let scene = &model.scene;
    let extent = scene.extent();
    let middle = DVec3::from(extent.center()) + DVec3::from(scene.origin());
    let mut data = MeshData::default();
    for slot in scene.slots() {
        let (mesh, transform) = (scene.mesh(slot), scene.transform(slot));
        let base = data.positions.len() as u32;
        let first = (data.indices.len() / 3) as u32;
        let [x, y, z] = transform.linear.map(|c| DVec3::from(c.map(f64::from)));
        let to = DVec3::from(transform.translation) - middle;
        data.positions.extend(mesh.positions().iter().map(|p| {
            let [px, py, pz] = p.map(f64::from);
            (x * px + y * py + z * pz + to).as_vec3().to_array()
        }));
        // A mirror turns the winding of what passes through it; outside stays outside.
        let mirrored = transform.determinant() < 0.0;
        data.indices.extend(mesh.original_indices().as_chunks::<3>().0.iter().flat_map(
            |&[a, b, c]| {
                let t = if mirrored { [a, c, b] } else { [a, b, c] };
                t.map(|v| base + v)
            },
        ));
        data.parts.extend(mesh.parts().iter().map(|p| Part {
            first_triangle: first + p.first_triangle,
            triangle_count: p.triangle_count,
            material: p.material,
            ..Part::default()
        }));
    }
    data
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::fibonacci;

    #[test]
    fn the_ball_is_a_solid_of_seventy_thousand_triangles() {
        let console = Console::new(true, None);
        let ball = Subject::load(None, &console).unwrap();
        assert_eq!(ball.mesh.triangle_count(), 69_312);
        assert_eq!((ball.defect.clone(), ball.mesh.degenerate_count()), (None, 0));
        assert!(!ball.mesh.is_two_sided());
        // Euler: a closed surface without holes.
        assert_eq!(ball.mesh.positions().len(), 69_312 / 2 + 2);
        assert!((0.9..1.3).contains(&ball.radius()), "{}", ball.radius());
        // Knobs: somewhere the surface leans by half a right angle from the ball's own.
        let lean = (0..69_312).map(|t| {
            let [a, b, c] = ball.mesh.corners(t).map(|p| DVec3::from(p.map(f64::from)));
            (b - a).cross(c - a).normalize().dot(a.normalize())
        });
        assert!(lean.fold(1.0, f64::min) < 0.75);
    }

    #[test]
    fn instances_become_one_mesh_wound_outward() {
        // Every fourth shape of this scene is mirrored, and all are solids but the whole is many.
        let console = Console::new(true, None);
        let all = Subject::load(Some("solids:n=8"), &console).unwrap();
        assert_eq!(all.defect, None);
    }

    #[test]
    fn directions_are_units_that_sum_to_nothing() {
        let mut sum = DVec3::ZERO;
        for i in 0..200 {
            let d = DVec3::from(fibonacci(i, 200));
            assert!((d.length() - 1.0).abs() < 1e-12);
            sum += d;
        }
        assert!(sum.length() < 1.0, "{sum}");
    }
}
