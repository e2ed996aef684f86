//! Binary PLY.

use std::io::{self, Write};

use super::{Totals, world, world_indices};
use crate::Model;

pub(super) fn write(model: &Model, totals: &Totals, out: &mut impl Write) -> io::Result<()> {
    let scene = &model.scene;
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\ncomment written by cullet\nelement vertex {}\n\
         property float x\nproperty float y\nproperty float z\nelement face {}\n\
         property list uchar uint vertex_indices\nend_header\n",
        totals.vertices, totals.triangles
    )?;
    for slot in scene.slots() {
        let transform = scene.transform(slot);
        for &p in scene.mesh(slot).positions() {
            for v in world(transform, p) {
                out.write_all(&v.to_le_bytes())?;
            }
        }
    }
    let mut first = 0u32;
    for slot in scene.slots() {
        for t in world_indices(scene, slot).chunks_exact(3) {
            out.write_all(&[3])?;
            for &i in t {
                out.write_all(&(first + i).to_le_bytes())?;
            }
        }
        first += scene.mesh(slot).positions().len() as u32;
    }
    Ok(())
}
