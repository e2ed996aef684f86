//! Models opened by a plane.

use cullet::View;
use cullet::bounds::Plane;
use cullet::mesh::Topology;
use cullet_cut::{CapOptions, CutInput, cut_both};

use crate::lecture::finding::Finding;
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{SIZE, draw, mesh, other, scene_of};

/// Solids cut in two: both parts closed, their volumes those of the whole. And of two balls, one in the other, the inner one is
/// seen when the outer one is opened.
pub(super) fn open(lab: &Lab) -> Result<Finding, LabError> {
    let model = lab.scene("solids")?;
    let (mut cut, mut open_edges, mut worst) = (0, 0, 0.0_f64);
    for solid in model.scene.meshes() {
        let indices = solid.original_indices();
        let positions = solid.positions();
        let whole = solid.topology();
        if !whole.is_closed() {
            continue;
        }
        let [x, y, z] = solid.bounds().center();
        let normal = [0.8, 0.48, 0.36];
        let plane = Plane::from_point_normal([x, y, z], normal).ok_or_else(|| other("no plane"))?;
        let input = CutInput { positions, indices: &indices, ..CutInput::default() };
        let caps = CapOptions::default();
        let parts = cut_both(&input, &[plane], Some(&caps)).map_err(other)?;
        let parts = parts.map(|part| Topology::of(&part.positions, &part.indices));
        cut += 1;
        open_edges += parts.iter().map(|part| part.boundary_edges).sum::<u32>();
        let volume = parts[0].volume + parts[1].volume;
        worst = worst.max((volume / whole.volume - 1.0).abs());
    }
    // An outer cube around an inner one.
    let (corners, indices) = crate::lecture::tools::cube();
    let outer: Vec<[f32; 3]> = corners.iter().map(|p| p.map(|v| v * 2.0)).collect();
    let view = View::perspective([0.0, 0.0, 9.0], [0.0; 3], 0.8, 0.1, 50.0, SIZE)?;
    let input = CutInput { positions: &outer, indices: &indices, ..CutInput::default() };
    let plane = Plane::new([0.0, 0.0, 1.0], 0.5);
    let [opened, _] = cut_both(&input, &[plane], None).map_err(other)?;
    let mut seen = [0, 0];
    for (count, (positions, indices)) in
        seen.iter_mut().zip([(outer.clone(), indices.clone()), (opened.positions, opened.indices)])
    {
        let mut scene = scene_of(mesh(positions, indices, true)?)?;
        let inner = scene.add_mesh(mesh(corners.clone(), crate::lecture::tools::cube().1, true)?);
        let instance = cullet::Instance::new(inner, cullet::Transform::IDENTITY);
        let handle = scene.add(instance).map_err(other)?;
        scene.commit();
        let slot = scene.slot(handle).map_err(other)?;
        *count = draw(&scene, &view).ids.iter().filter(|id| id.slot == slot).count();
    }
    Ok(Finding::if_so(
        cut > 10 && open_edges == 0 && worst < 1e-4 && seen[0] == 0 && seen[1] > 0,
        format!(
            "{cut} solids cut in two with caps have {open_edges} open edges, and volumes that add up within {worst:.0e}; of a cube in a \
             cube {} pixels are seen, and {} once the outer one is open",
            seen[0], seen[1]
        ),
    ))
}
