//! Where the meshes of a scene are drawn, and how large.

use cullet::math;
use cullet::{Mesh, Scene};

/// Drawn meshes of a scene, and how large they are drawn.
#[derive(Debug)]
pub(super) struct Uses {
    /// Distance of the farthest vertex from the middle, in world units.
    pub(super) radius: f64,
    /// The middle of the box around all, relative to the scene's origin.
    pub(super) middle: [f64; 3],
    /// For each mesh.
    pub(super) meshes: Vec<MeshUse>,
    total_area: f64,
}

/// Where a mesh is drawn.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MeshUse {
    /// How many instances it has.
    pub(super) count: u64,
    /// The largest scale of any, in its longest direction.
    pub(super) scale: f64,
    /// Its area, at that scale.
    area: f64,
}

impl Uses {
    pub(super) fn of(scene: &Scene) -> Self {
        let mut meshes = vec![MeshUse::default(); scene.meshes().len()];
        for slot in placed(scene) {
            let of = &mut meshes[scene.mesh_id(slot) as usize];
            of.count += 1;
            of.scale = of.scale.max(largest_scale(scene.transform(slot).linear));
        }
        for (of, mesh) in meshes.iter_mut().zip(scene.meshes()).filter(|(of, _)| of.count > 0) {
            of.area = area(mesh) * of.scale * of.scale;
        }
        let total_area = meshes.iter().map(|m| m.area).sum();
        let middle = middle(scene);
        Self { radius: radius(scene, middle), middle, meshes, total_area }
    }

    /// So many of all samples as are the share of a mesh in the area, and always some.
    pub(super) fn samples(&self, mesh: usize, all: u32) -> usize {
        const LEAST: usize = 2000;
        let share = self.meshes[mesh].area / self.total_area;
        // Rounded up, so that all are at least those that were asked for. NaN is none.
        ((share * f64::from(all)).ceil() as usize).max(LEAST)
    }
}

/// The largest singular value of a matrix of columns: the root of the largest eigenvalue of its
/// square, in closed form.
pub(super) fn largest_scale(columns: [[f32; 3]; 3]) -> f64 {
    let m = columns.map(|c| c.map(f64::from));
    let dot = |a: usize, b: usize| (0..3).map(|k| m[a][k] * m[b][k]).sum::<f64>();
    let s: [[f64; 3]; 3] = std::array::from_fn(|a| std::array::from_fn(|b| dot(a, b)));
    let middle = (s[0][0] + s[1][1] + s[2][2]) / 3.0;
    let off = s[0][1] * s[0][1] + s[0][2] * s[0][2] + s[1][2] * s[1][2];
    let on: f64 = (0..3).map(|a| (s[a][a] - middle).powi(2)).sum();
    let spread = ((on + 2.0 * off) / 6.0).sqrt();
    if spread <= middle.abs() * 1e-12 {
        return middle.max(0.0).sqrt();
    }
    let t: [[f64; 3]; 3] = std::array::from_fn(|a| {
        std::array::from_fn(|b| (s[a][b] - if a == b { middle } else { 0.0 }) / spread)
    });
    let minor = |a: usize, b: usize| t[1][a] * t[2][b] - t[1][b] * t[2][a];
    let det = t[0][0] * minor(1, 2) - t[0][1] * minor(0, 2) + t[0][2] * minor(0, 1);
    let angle = math::acos((det / 2.0).clamp(-1.0, 1.0)) / 3.0;
    (middle + 2.0 * spread * math::cos(angle)).max(0.0).sqrt()
}

fn area(mesh: &Mesh) -> f64 {
    let triangle = |t: &[u32]| {
        let [a, b, c] = [0, 1, 2].map(|k| mesh.positions()[t[k] as usize].map(f64::from));
        let [u, v]: [[f64; 3]; 2] = [b, c].map(|p| std::array::from_fn(|k| p[k] - a[k]));
        let cross: [f64; 3] = std::array::from_fn(|k| {
            u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]
        });
        cross.iter().map(|v| v * v).sum::<f64>().sqrt() * 0.5
    };
    mesh.indices().chunks_exact(3).map(triangle).sum()
}

/// Instances that have a place; one without would have a bound of any size for all others.
fn placed(scene: &Scene) -> impl Iterator<Item = u32> {
    scene.slots().filter(|&slot| scene.transform(slot).is_finite())
}

fn middle(scene: &Scene) -> [f64; 3] {
    let extent = scene.extent();
    if !extent.is_finite() {
        return [0.0; 3];
    }
    std::array::from_fn(|a| f64::from(extent.min[a]) * 0.5 + f64::from(extent.max[a]) * 0.5)
}

fn radius(scene: &Scene, middle: [f64; 3]) -> f64 {
    let origin = scene.origin();
    let mut farthest = 0.0_f64;
    for slot in placed(scene) {
        let transform = scene.transform(slot);
        let m = transform.linear.map(|c| c.map(f64::from));
        let start: [f64; 3] =
            std::array::from_fn(|a| transform.translation[a] - origin[a] - middle[a]);
        for p in scene.mesh(slot).positions() {
            let p = p.map(f64::from);
            let squared: f64 = (0..3)
                .map(|a| (start[a] + m[0][a] * p[0] + m[1][a] * p[1] + m[2][a] * p[2]).powi(2))
                .sum();
            // False for NaN.
            if squared > farthest {
                farthest = squared;
            }
        }
    }
    farthest.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_testkit::Rng;

    #[test]
    fn the_largest_scale_is_that_of_the_direction_that_grows_most() {
        assert_eq!(largest_scale([[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, -2.0]]), 2.0);
        assert_eq!(largest_scale([[0.0; 3]; 3]), 0.0);
        let stretched = largest_scale([[0.0, 3.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.5]]);
        assert!((stretched - 3.0).abs() < 1e-9, "{stretched}");
        let mut rng = Rng(3);
        for _ in 0..100 {
            let m = [0; 3].map(|_| rng.vector(2.0).map(|v| v as f32));
            let found = largest_scale(m);
            let mut most = 0.0_f64;
            for _ in 0..3000 {
                let d = rng.direction();
                let image =
                    (0..3).map(|a| (0..3).map(|c| f64::from(m[c][a]) * d[c]).sum::<f64>().powi(2));
                most = most.max(image.sum::<f64>().sqrt());
            }
            assert!(most <= found * (1.0 + 1e-9) && most >= found * 0.97, "{most} of {found}");
        }
    }
}
