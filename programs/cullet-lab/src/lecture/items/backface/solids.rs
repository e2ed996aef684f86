//! Solids, and their back sides.

use std::collections::BTreeMap;

use crate::methods::back_regions;
use cullet::cull::backface::{Facing, ObjectEye};
use cullet::mesh::{Alpha, MeshData, NotSolid, Part};
use cullet::{CullFace, FrontFace, Mesh, Scene, Transform, View};
use cullet_draw::{PixelId, RenderOptions, Selection, render};

use crate::lecture::finding::Finding;
use crate::lecture::lab::{Lab, LabError};
use crate::lecture::tools::{SIZE, cube, grouped, mesh, other, scene_of};

/// One mesh for each part of the definition; then pictures of solids and of what is open, both sides drawn.
pub(super) fn definition(lab: &Lab) -> Result<Finding, LabError> {
    let (positions, indices) = cube();
    let solid = |positions: &[[f32; 3]], indices: &[u32]| {
        Ok::<_, LabError>(mesh(positions.to_vec(), indices.to_vec(), false)?.solid())
    };
    let open = solid(&positions, &indices[..30])?;
    let mut turned = indices.clone();
    turned.swap(0, 1);
    let turned = solid(&positions, &turned)?;
    let inside_out: Vec<u32> = indices.chunks(3).flat_map(|t| [t[0], t[2], t[1]]).collect();
    let inside_out = solid(&positions, &inside_out)?;
    let flat = solid(&positions, &[0, 1, 2, 0, 2, 1])?;
    let parts = vec![Part { triangle_count: 12, alpha: Alpha::Blended, ..Part::default() }];
    let glass = MeshData {
        positions: positions.clone(),
        indices: indices.clone(),
        parts,
        ..MeshData::default()
    };
    let glass = Mesh::new(glass).map_err(other)?.solid();
    let judged = solid(&positions, &indices)?.is_ok()
        && open == Err(NotSolid::Open { edges: 4 })
        && matches!(turned, Err(NotSolid::Misoriented { .. }))
        && matches!(inside_out, Err(NotSolid::Inward { .. }))
        && flat == Err(NotSolid::NoVolume)
        && glass == Err(NotSolid::NotOpaque { part: 0 });

    let mut solids = cullet_scenes::build("solids:n=36")?;
    let are_solid = solids.scene.meshes().iter().all(|mesh| mesh.solid().is_ok());
    solids.scene.edit_meshes(|_, mesh| mesh.set_two_sided(true));
    solids.scene.commit();
    let (mut backs, mut pixels) = (0, 0);
    for view in lab.views(&solids, "orbit", 3, SIZE)? {
        let [back, all] = backs_in_sight(&solids.scene, &view);
        (backs, pixels) = (backs + back, pixels + all);
    }
    let (name, [seen_backs, of]) = match lab.model("stanford-bunny/bun_zipper.ply")? {
        Some(bunny) => {
            let extent = bunny.scene.extent();
            let [x, y, z] = extent.center();
            let reach = extent.half_extent().into_iter().fold(0.0, f64::max);
            let eye = [x, y - 3.0 * reach, z + 0.1 * reach];
            let near = reach * 0.01;
            let below = View::perspective(eye, [x, y, z], 0.8, near, f64::INFINITY, SIZE)?;
            ("the bunny, which has holes, seen from below", backs_in_sight(&bunny.scene, &below))
        }
        None => {
            let (positions, indices) = cube();
            let open = scene_of(mesh(positions, indices[..30].to_vec(), true)?)?;
            let eye = [1.5, 4.0, 1.5];
            let above = View::perspective(eye, [0.0; 3], 1.0, 0.1, f64::INFINITY, SIZE)?;
            ("an open box (the bunny is not there)", backs_in_sight(&open, &above))
        }
    };
    Ok(Finding::if_so(
        judged && are_solid && backs == 0 && pixels > 10_000 && seen_backs > 0,
        format!(
            "a cube is a solid; without a side, with a triangle turned over, inside out, of glass or flat it is not, for the reason at hand. Of {} \
             pixels of pictures of solids {backs} show a back; of {name}, {} of {}",
            grouped(pixels),
            grouped(seen_backs),
            grouped(of)
        ),
    ))
}

/// Pixels that show a back, and all that show anything.
fn backs_in_sight(scene: &Scene, view: &View) -> [usize; 2] {
    let frame = render(scene, view, Selection::All, &RenderOptions::default());
    let mut eyes: BTreeMap<u32, (ObjectEye, Vec<u32>)> = BTreeMap::new();
    let owners = frame.ids.iter().filter(|id| **id != PixelId::NONE);
    owners.fold([0, 0], |[backs, all], id| {
        let mesh = scene.mesh(id.slot);
        let (eye, indices) = eyes.entry(id.slot).or_insert_with(|| {
            (ObjectEye::of_view(view, scene.transform(id.slot)), mesh.original_indices())
        });
        let first = id.triangle as usize * 3;
        let corners = [0, 1, 2].map(|c| mesh.positions()[indices[first + c] as usize]);
        [backs + usize::from(eye.facing(&corners) == Facing::Back), all + 1]
    })
}

/// Connected regions of backs, of bodies that are convex by all their corners, and of others.
pub(super) fn back_sides(lab: &Lab) -> Result<Finding, LabError> {
    let solids = lab.scene("solids:n=36")?;
    let (mut convex, mut of_convex) = (0, (usize::MAX, 0));
    let (mut parted, mut others) = (0, 0);
    for mesh in solids.scene.meshes() {
        let counts = regions_from_around(mesh);
        if is_convex(mesh) {
            convex += 1;
            of_convex = (of_convex.0.min(counts.0), of_convex.1.max(counts.1));
        } else {
            others += 1;
            parted += usize::from(counts.1 > 1);
        }
    }
    let (name, uneven) = match lab.model("armadillo/armadillo.obj")? {
        Some(model) => ("the armadillo", model),
        None => ("a ball with knobs (the armadillo is not there)", lab.scene("knobs:n=24")?),
    };
    let most = regions_from_around(&uneven.scene.meshes()[0]).1;
    Ok(Finding::if_so(
        convex > 1 && of_convex == (1, 1) && parted > 0 && most > 1,
        format!(
            "from {EYES} eyes around, {convex} convex bodies have {} back side each, {parted} of {others} others have several from some eye, and \
             {name} has up to {most}",
            of_convex.1
        ),
    ))
}

const EYES: usize = 12;

/// The least and the most regions of backs, from eyes all around.
fn regions_from_around(mesh: &Mesh) -> (usize, usize) {
    let bounds = mesh.bounds();
    let (centre, half) = (bounds.center(), bounds.half_extent());
    let radius = half.iter().map(|v| v * v).sum::<f64>().sqrt();
    let turn = std::f64::consts::PI * (3.0 - 5.0f64.sqrt());
    let counts = (0..EYES).map(|i| {
        // A spiral of even steps in height (Fibonacci).
        let y = 1.0 - (2 * i + 1) as f64 / EYES as f64;
        let (sin, cos) = (turn * i as f64).sin_cos();
        let flat = (1.0 - y * y).sqrt();
        let eye = [
            centre[0] + 3.0 * radius * flat * cos,
            centre[1] + 3.0 * radius * y,
            centre[2] + 3.0 * radius * flat * sin,
            1.0,
        ];
        let eye = ObjectEye::new(eye, &Transform::IDENTITY, FrontFace::default(), CullFace::Back);
        back_regions(&eye, mesh.positions(), mesh.indices()).count()
    });
    counts.fold((usize::MAX, 0), |(least, most), n| (least.min(n), most.max(n)))
}

/// Whether no corner is in front of any triangle, but for rounding.
fn is_convex(mesh: &Mesh) -> bool {
    let size = mesh.bounds().half_extent().into_iter().fold(0.0, f64::max);
    (0..mesh.triangle_count() - mesh.degenerate_count()).all(|t| {
        let corners = mesh.corners(t);
        let n = super::normal(&corners);
        let length = n.iter().map(|v| v * v).sum::<f64>().sqrt();
        let a = corners[0].map(f64::from);
        mesh.positions().iter().all(|p| {
            let height: f64 = (0..3).map(|i| n[i] * (f64::from(p[i]) - a[i])).sum();
            height <= 1e-6 * size * length
        })
    })
}
