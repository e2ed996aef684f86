//! Binary STL.

use std::io::{self, Write};

use glam::DVec3;

use super::{Totals, world, world_indices};
use crate::Model;

pub(super) fn write(model: &Model, totals: &Totals, out: &mut impl Write) -> io::Result<()> {
    // The header must not start with "solid", or readers take the file for text.
    let mut header = [b' '; 80];
    header[..17].copy_from_slice(b"written by cullet");
    out.write_all(&header)?;
    // Held against the limit before.
    out.write_all(&(totals.triangles as u32).to_le_bytes())?;
    let scene = &model.scene;
    for slot in scene.slots() {
        let (mesh, transform) = (scene.mesh(slot), scene.transform(slot));
        let points: Vec<[f32; 3]> = mesh.positions().iter().map(|&p| world(transform, p)).collect();
        for t in world_indices(scene, slot).chunks_exact(3) {
            let corners = [0, 1, 2].map(|i| points[t[i] as usize]);
            let [a, b, c] = corners.map(|p| DVec3::from(p.map(f64::from)));
            let normal = (b - a).cross(c - a).normalize_or_zero().as_vec3().to_array();
            for v in std::iter::once(normal).chain(corners).flatten() {
                out.write_all(&v.to_le_bytes())?;
            }
            out.write_all(&[0; 2])?;
        }
    }
    Ok(())
}
