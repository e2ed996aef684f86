//! Binary STL.

use std::io::Write;

use glam::{DVec3, Vec3};

use super::{SaveErrorKind, Written, world_indices};
use crate::place::world;
use crate::stl::ORIGIN;

/// Bytes of a file before the count of its triangles.
const HEADER: usize = 80;

pub(super) fn write(all: &mut Written<'_>, out: &mut impl Write) -> Result<(), SaveErrorKind> {
    let Written { model, slots, saved, is_far, .. } = all;
    let origin = DVec3::from(saved.origin);
    // The header must not start with "solid", or readers take the file for text.
    let mut header = b"written by cullet".to_vec();
    if origin != DVec3::ZERO {
        let [x, y, z] = saved.origin;
        header = format!("{ORIGIN}{x} {y} {z}").into_bytes();
        saved.say(
            "origin",
            format!(
                "an STL has 32-bit numbers, which are too coarse so far from zero: positions are \
                 counted from ({x}, {y}, {z}), which its header says; .glb, .ply and .obj keep them"
            ),
        );
    }
    header.resize(HEADER, b' ');
    out.write_all(&header)?;
    // Held against the limit before.
    out.write_all(&(saved.triangles as u32).to_le_bytes())?;
    let mut collapsed = 0_u64;
    for &slot in slots.iter() {
        let (mesh, transform) = (model.scene.mesh(slot), model.scene.transform(slot));
        let exact: Vec<DVec3> =
            mesh.positions().iter().map(|&p| DVec3::from(world(transform, p)) - origin).collect();
        for t in world_indices(&model.scene, slot).chunks_exact(3) {
            let exact = [0, 1, 2].map(|i| exact[t[i] as usize]);
            let corners = exact.map(DVec3::as_vec3);
            let written = corners.map(Vec3::as_dvec3);
            let off = (0..3).map(|k| written[k].distance(exact[k])).fold(0.0, f64::max);
            saved.rounding = saved.rounding.max(off);
            let [normal, own] = [written, exact].map(|[a, b, c]| (b - a).cross(c - a));
            collapsed += u64::from(normal == DVec3::ZERO && own != DVec3::ZERO);
            let normal = normal.normalize_or_zero().as_vec3();
            for v in std::iter::once(normal).chain(corners).flat_map(|p| p.to_array()) {
                out.write_all(&v.to_le_bytes())?;
            }
            out.write_all(&[0; 2])?;
        }
    }
    if collapsed > 0 && collapsed == saved.triangles {
        return Err(SaveErrorKind::TooFar { triangles: collapsed });
    }
    if collapsed > 0 || *is_far {
        saved.say(
            "rounding",
            format!(
                "positions are off by up to {:.3e}, for an STL has 32-bit numbers; {collapsed} \
                 triangles lose their area by it; .glb, .ply and .obj keep them",
                saved.rounding
            ),
        );
    }
    Ok(())
}
