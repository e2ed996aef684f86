//! Small scenes that the tour shows where no scene of cullet-io has what a kind of culling is
//! about: layers, triangles without area, levels of detail, and sets of cells that were worked out
//! beforehand. Made in the viewer, natively and on a page.

use std::f64::consts::{PI, TAU};

use cullet::lod::{Group, Levels, NO_GROUP};
use cullet::mesh::{Cluster, Clustering, Part};
use cullet::{Instance, Mesh, MeshData, Scene, Transform};
use cullet_bake::pvs::{PvsSettings, bake};
use cullet_io::Model;

/// A scene by its name, and how it is made.
type Example = (&'static str, fn() -> Result<Model, String>);

/// All of them. `example:` keeps them apart from files and from the scenes of cullet-io.
const EXAMPLES: [Example; 3] =
    [("example:balls", balls), ("example:levels", levels), ("example:office", office)];

/// Whether a text names one of them.
#[must_use]
pub fn is_example(text: &str) -> bool {
    EXAMPLES.iter().any(|(name, _)| *name == text)
}

/// Makes one of them; `None` where the text names none.
///
/// # Errors
/// In words for the user, of a fault of this program.
pub fn build(text: &str) -> Option<Result<Model, String>> {
    let (name, make) = EXAMPLES.iter().find(|(name, _)| *name == text)?;
    Some(make().map(|mut model| {
        model.scene.commit(&cullet::Culler::default());
        model.update_cells();
        model.name = (*name).to_owned();
        model
    }))
}

/// Returns the message for a scene that cannot be made, which tests make: a page has no room to
/// tell the kinds of faults apart.
fn fault<E>(_: E) -> String {
    "An example scene of the tour cannot be made: a fault of cullet".to_owned()
}

/// A ball of radius 1 of `rings` × 2 `rings` quads. At the poles quads come to a point, so that
/// half of each has no area: with `poles` those halves are there.
fn ball(rings: u32, poles: bool) -> MeshData {
    let around = 2 * rings;
    let mut data = MeshData::default();
    for ring in 0..=rings {
        let (mut s, c) = (PI * f64::from(ring) / f64::from(rings)).sin_cos();
        if ring % rings == 0 {
            s = 0.0;
        }
        for k in 0..around {
            let (sin, cos) = (TAU * f64::from(k) / f64::from(around)).sin_cos();
            data.positions.push([s * cos, c, s * sin].map(|v| v as f32));
        }
    }
    for ring in 0..rings {
        for k in 0..around {
            let at = |r: u32, k: u32| r * around + k % around;
            let [a, b] = [at(ring, k), at(ring, k + 1)];
            let [c, d] = [at(ring + 1, k), at(ring + 1, k + 1)];
            if poles || ring > 0 {
                data.indices.extend([a, b, c]);
            }
            if poles || ring + 1 < rings {
                data.indices.extend([b, d, c]);
            }
        }
    }
    let triangle_count = data.indices.len() as u32 / 3;
    data.parts = vec![Part { triangle_count, ..Part::default() }];
    data
}

/// A cage around what is within a box of −1 to 1: twelve thin bars.
fn cage() -> MeshData {
    const CORNERS: [[f32; 3]; 8] = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 1.0],
        [0.0, 1.0, 1.0],
        [1.0, 1.0, 1.0],
    ];
    const SIDES: [[u32; 4]; 6] =
        [[0, 2, 1, 3], [4, 5, 6, 7], [0, 1, 4, 5], [2, 6, 3, 7], [0, 4, 2, 6], [1, 3, 5, 7]];
    const THIN: f32 = 0.03;
    let mut data = MeshData::default();
    for axis in 0..3 {
        for corner in 0..4 {
            let (mut low, mut high) = ([0.0; 3], [0.0; 3]);
            (low[axis], high[axis]) = (-1.0, 1.0);
            for (bit, other) in [(axis + 1) % 3, (axis + 2) % 3].into_iter().enumerate() {
                let at = if corner >> bit & 1 == 0 { -1.0 } else { 1.0 };
                (low[other], high[other]) = (at - THIN, at + THIN);
            }
            let first = data.positions.len() as u32;
            let at = |c: [f32; 3]| std::array::from_fn(|a| low[a] + (high[a] - low[a]) * c[a]);
            data.positions.extend(CORNERS.map(at));
            for side in SIDES {
                let [a, b, c, d] = side.map(|i| first + i);
                data.indices.extend([a, b, c, b, d, c]);
            }
        }
    }
    let triangle_count = data.indices.len() as u32 / 3;
    data.parts = vec![Part { triangle_count, ..Part::default() }];
    data
}

fn mesh(model: &mut Model, name: &str, data: MeshData) -> Result<u32, String> {
    let mesh = Mesh::new(data).map_err(fault)?;
    model.mesh_names.push(name.to_owned());
    Ok(model.scene.add_mesh(mesh))
}

fn add(scene: &mut Scene, mesh: u32, layers: u32, at: [f64; 3]) -> Result<(), String> {
    let instance = Instance { layers, ..Instance::new(mesh, Transform::from_translation(at)) };
    scene.add(instance).map(|_| ()).map_err(fault)
}

/// Balls of quads, each in a cage that is in no layer.
fn balls() -> Result<Model, String> {
    let mut model = Model::default();
    let ball = mesh(&mut model, "ball", ball(16, true))?;
    let cage = mesh(&mut model, "cage", cage())?;
    for i in 0..16 {
        let at = [f64::from(i % 4) * 3.0, 0.0, f64::from(i / 4) * 3.0];
        add(&mut model.scene, ball, 1, at)?;
        add(&mut model.scene, cage, 0, at)?;
    }
    Ok(model)
}

/// Rings of a ball at each of its levels, the finest first.
const RINGS: [u32; 4] = [32, 16, 8, 5];

/// A field of balls that have levels of detail.
fn levels() -> Result<Model, String> {
    let mut model = Model::default();
    let fine = mesh(&mut model, "ball", ball(RINGS[0], false))?;
    let (coarse, levels) = coarser()?;
    model.mesh_names.push("coarser balls".to_owned());
    let held_by = model.scene.add_mesh(coarse);
    model.scene.add_levels(fine, held_by, levels).map_err(fault)?;
    for i in 0..400 {
        let at = [f64::from(i % 20) * 3.0, 0.0, f64::from(i / 20) * 3.0];
        add(&mut model.scene, fine, 1, at)?;
    }
    Ok(model)
}

/// The coarser balls in one mesh, and the levels that they are.
fn coarser() -> Result<(Mesh, Levels), String> {
    let (mut data, mut clustering) = (MeshData::default(), Clustering::default());
    let (mut groups, mut made_from, mut replaced_by) = (Vec::new(), Vec::new(), Vec::new());
    for (level, &rings) in (0..).zip(&RINGS[1..]) {
        let one = ball(rings, false);
        let (first, before) = (data.positions.len() as u32, data.indices.len() as u32 / 3);
        let triangles = one.indices.len() as u32 / 3;
        data.positions.extend(one.positions);
        data.indices.extend(one.indices.iter().map(|i| i + first));
        // So few that no cluster has too many vertices.
        for at in (0..triangles).step_by(20) {
            let (first_triangle, triangle_count) = (before + at, 20.min(triangles - at));
            clustering.clusters.push(Cluster { first_triangle, triangle_count, part: 0 });
            made_from.push(level);
            replaced_by.push(if rings == RINGS[RINGS.len() - 1] { NO_GROUP } else { level + 1 });
        }
        // A quad lies within the sphere by as much as the circle around its diagonal is large.
        let error = 1.0 - (PI / f64::from(rings)).cos().sqrt();
        groups.push(Group { centre: [0.0; 3], radius: 1.0, error: error as f32 });
    }
    let triangle_count = data.indices.len() as u32 / 3;
    clustering.order = (0..triangle_count).collect();
    data.parts = vec![Part { triangle_count, ..Part::default() }];
    let coarse = Mesh::with_clusters(data, &clustering).map_err(fault)?;
    let levels = Levels::new(&coarse, &groups, made_from, replaced_by).map_err(fault)?;
    Ok((coarse, levels))
}

/// The office with what may be seen from each of its rooms.
fn office() -> Result<Model, String> {
    let mut model = cullet_scenes::build("office").map_err(fault)?;
    if let Some(cells) = &mut model.placed {
        let sets = bake(cells.graph(), &PvsSettings::default(), 1).sets();
        cells.set_visible_sets(sets).map_err(fault)?;
    }
    Ok(model)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_has_what_it_is_for() {
        let made = |name| build(name).expect("an example").expect("made");
        assert!(!is_example("city") && build("example:none").is_none());
        let scene = made("example:balls").scene;
        assert!(scene.meshes()[0].degenerate_count() > 0);
        assert!(scene.slots().any(|slot| scene.layers(slot) == 0));
        let scene = made("example:levels").scene;
        assert_eq!(scene.levels(0).len(), 1);
        assert_eq!(scene.meshes()[0].degenerate_count(), 0);
        assert!(made("example:office").placed.is_some_and(|cells| cells.visible_sets().is_some()));
    }

    #[test]
    fn balls_and_cages_are_closed_and_wound_outwards() {
        for data in [ball(8, false), cage()] {
            let p = |i: u32| glam::DVec3::from(data.positions[i as usize].map(f64::from));
            let volume: f64 = data
                .indices
                .chunks_exact(3)
                .map(|t| p(t[0]).dot(p(t[1]).cross(p(t[2]))) / 6.0)
                .sum();
            assert!(volume > 0.0, "{volume}");
        }
    }
}
