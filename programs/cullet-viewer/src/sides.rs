//! Sides of the triangles of a model: what its file declares, how that is declared anew, and why
//! back faces are kept.

use cullet::Mesh;
use cullet::mesh::{Clustering, MeshError};
use cullet_io::Model;
use serde::{Deserialize, Serialize};

use crate::numbers::percent;
use crate::state::Sides;

/// Whether each part of a model's meshes is two-sided, one mesh after the other.
pub(crate) fn of_parts(model: &Model) -> Vec<bool> {
    model.scene.meshes().iter().flat_map(Mesh::parts).map(|part| part.two_sided).collect()
}

/// Declares every part of a model as `stored` has it, or as `sides` has it where that says
/// something. What was prepared of the meshes is made anew.
///
/// # Errors
/// None for the parts of this model; those of another do not fit its meshes.
pub(crate) fn declare(model: &mut Model, sides: Sides, stored: &[bool]) -> Result<(), MeshError> {
    let mut stored = stored.iter();
    let mut done = Ok(());
    model.scene.edit_meshes(|_, mesh| {
        let own: Vec<bool> = stored.by_ref().take(mesh.parts().len()).copied().collect();
        match sides.two_sided().or_else(|| all_alike(&own)) {
            Some(two_sided) => mesh.set_two_sided(two_sided),
            None => match with_parts(mesh, &own) {
                Ok(again) => *mesh = again,
                Err(e) => done = Err(e),
            },
        }
    });
    done
}

/// The common value of all, if there is one.
fn all_alike(sides: &[bool]) -> Option<bool> {
    let first = *sides.first()?;
    sides.iter().all(|&s| s == first).then_some(first)
}

/// A mesh again with each part's own sides, in the same clusters.
fn with_parts(mesh: &Mesh, two_sided: &[bool]) -> Result<Mesh, MeshError> {
    let mut data = mesh.to_data();
    data.parts.iter_mut().zip(two_sided).for_each(|(part, &two)| part.two_sided = two);
    // Those without an area are in no cluster.
    let drawn = (mesh.triangle_count() - mesh.degenerate_count()) as usize;
    let order = mesh.original_triangle()[..drawn].to_vec();
    Mesh::with_clusters(data, &Clustering { order, clusters: mesh.clusters().to_vec() })
}

/// The triangles that back-face culling has nothing to do with, and why.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct KeptBacks {
    /// Triangles of all instances both sides of which are drawn.
    pub two_sided: u64,
    /// Besides these, triangles of instances that are not [rigid](cullet::Scene::is_rigid).
    pub moving: u64,
    /// How many meshes these triangles are of.
    pub meshes: u64,
    /// The name of the mesh that most of them are of.
    pub most: String,
    /// Why that mesh is two-sided or deforms, to follow on "since".
    pub why: String,
}

impl KeptBacks {
    /// Finds them. O(instances), and [`cullet_mesh::solid`] of the mesh that most two-sided
    /// triangles are of.
    #[must_use]
    pub fn of(model: &Model, sides: Sides) -> Self {
        let scene = &model.scene;
        let two_sided_of = |mesh: &Mesh| -> u64 {
            mesh.parts().iter().filter(|p| p.two_sided).map(|p| u64::from(p.triangle_count)).sum()
        };
        let own: Vec<u64> = scene.meshes().iter().map(two_sided_of).collect();
        let mut kept = Self::default();
        // Two-sided and moving triangles of each mesh.
        let mut by_mesh = vec![[0u64; 2]; own.len()];
        for slot in scene.slots() {
            let id = scene.mesh_id(slot) as usize;
            let all = u64::from(scene.mesh(slot).triangle_count());
            let [two_sided, moving] = &mut by_mesh[id];
            if !scene.is_rigid(slot) {
                *moving += all;
            } else if scene.flags(slot).double_sided {
                *two_sided += all;
            } else {
                *two_sided += own[id];
            }
        }
        for [two_sided, moving] in &by_mesh {
            kept.two_sided += two_sided;
            kept.moving += moving;
            kept.meshes += u64::from(two_sided + moving > 0);
        }
        let most = (0..by_mesh.len()).max_by_key(|&id| by_mesh[id].iter().sum::<u64>());
        if let Some(id) = most.filter(|_| kept.meshes > 0) {
            let [two_sided, moving] = by_mesh[id];
            kept.most = model.mesh_names.get(id).cloned().unwrap_or_default();
            kept.why = match moving > two_sided {
                true => "its vertices may move".to_owned(),
                false => why_two_sided(model, &scene.meshes()[id], sides),
            };
        }
        kept
    }

    /// Whether these are more than half of the scene's `all` triangles.
    #[must_use]
    pub fn is_most(&self, all: u64) -> bool {
        self.two_sided + self.moving > all / 2
    }

    /// The sentence for the user, of a scene of `all` triangles; none where fewer than a hundredth
    /// of them keep their backs.
    #[must_use]
    pub fn sentence(&self, all: u64) -> Option<String> {
        let kept = self.two_sided + self.moving;
        let (name, why) = (&self.most, &self.why);
        let how = if self.two_sided >= self.moving { "is two-sided" } else { "deforms" };
        match (kept, self.meshes) {
            _ if kept == 0 || kept < all / 100 => None,
            (_, 1) if kept == all => {
                Some(format!("no back face is culled: the mesh {how}, since {why}"))
            }
            _ => {
                let share = percent(kept, all);
                let most = if name.is_empty() { "the largest such mesh" } else { name };
                Some(format!(
                    "back faces of {share} of the triangles are kept: {most} {how}, since {why}"
                ))
            }
        }
    }
}

fn why_two_sided(model: &Model, mesh: &Mesh, sides: Sides) -> String {
    if sides == Sides::TwoSided {
        return "that was chosen".to_owned();
    }
    // A format without sides leaves a mesh two-sided where it is not solid; glTF and built-in
    // scenes declare the sides.
    let who = match cullet_scenes::is_builtin(&model.name) {
        true => Some("the scene declares it so"),
        false if is_gltf(&model.name) => Some("the file declares it so (doubleSided)"),
        false => None,
    };
    match (cullet_mesh::solid(mesh), who) {
        (Err(defect), None) if mesh.is_two_sided() => defect.to_string(),
        (_, who) => who.unwrap_or("it is declared so").to_owned(),
    }
}

fn is_gltf(name: &str) -> bool {
    let ending = name.rsplit_once('.').map_or("", |(_, ending)| ending);
    ["glb", "gltf"].iter().any(|e| ending.eq_ignore_ascii_case(e))
}

#[cfg(test)]
mod tests {
    use cullet::mesh::{MeshData, Part};
    use cullet::{Instance, Transform};

    use super::*;
    use crate::world::World;

    /// An open strip of two parts with other sides, and an open strip of one part.
    fn world(name: &str) -> World {
        let strip = |sides: &[bool]| {
            let n = sides.len() as u32;
            let positions = (0..2 * n + 2).map(|i| [(i / 2) as f32, (i % 2) as f32, 0.0]).collect();
            let indices = (0..n).flat_map(|i| [0, 2, 1, 1, 2, 3].map(|v| 2 * i + v)).collect();
            let part = |(i, &two_sided): (usize, &bool)| Part {
                first_triangle: 2 * i as u32,
                triangle_count: 2,
                two_sided,
                ..Part::default()
            };
            let parts = sides.iter().enumerate().map(part).collect();
            Mesh::new(MeshData { positions, indices, parts, ..MeshData::default() }).expect("valid")
        };
        let mut model = Model { name: name.to_owned(), ..Model::default() };
        for (sides, copies) in [(&[true, false][..], 1), (&[true][..], 3)] {
            let id = model.scene.add_mesh(strip(sides));
            model.mesh_names.push(format!("strip {id}"));
            for _ in 0..copies {
                let instance = Instance::new(id, Transform::IDENTITY);
                model.scene.add(instance).expect("there is room");
            }
        }
        model.scene.commit(&cullet::Culler::default());
        World::new(model, name.to_owned())
    }

    #[test]
    fn every_part_gets_back_what_the_file_declares() {
        let mut world = world("strips.ply");
        let stored = of_parts(&world.model);
        assert_eq!(stored, [true, false, true]);
        let copy = world.with_sides(Sides::OneSided).expect("a copy");
        assert_eq!(of_parts(&copy.model), [false; 3]);
        assert_eq!(
            copy.with_sides(Sides::Automatic).map(|w| of_parts(&w.model)),
            Ok(stored.clone())
        );
        for sides in [Sides::OneSided, Sides::TwoSided, Sides::Automatic] {
            world.set_sides(sides).expect("its own parts");
            let wanted = sides.two_sided().map_or(stored.clone(), |two| vec![two; 3]);
            assert_eq!(of_parts(&world.model), wanted);
        }
        for (a, b) in world.model.scene.meshes().iter().zip(copy.model.scene.meshes()) {
            assert_eq!((a.clusters(), a.indices()), (b.clusters(), b.indices()));
        }
    }

    #[test]
    fn the_reason_is_that_of_the_mesh_that_matters_most_and_of_its_format() {
        let told = |name: &str| {
            let kept = world(name).kept_backs;
            assert_eq!((kept.two_sided, kept.moving, kept.meshes), (8, 0, 2));
            assert!(kept.is_most(10) && !kept.is_most(16));
            kept.sentence(10).expect("some are kept")
        };
        let of = "back faces of 80 % of the triangles are kept: strip 1 is two-sided, since ";
        assert_eq!(told("strips.ply"), format!("{of}it is open: 4 boundary edges"));
        assert_eq!(told("strips.GLB"), format!("{of}the file declares it so (doubleSided)"));
        assert_eq!(told("city"), format!("{of}the scene declares it so"));
        assert_eq!(KeptBacks::default().sentence(10), None);
    }
}
