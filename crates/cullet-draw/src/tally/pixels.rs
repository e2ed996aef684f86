//! How many pixels each mesh owns.

use cullet::Scene;
use cullet::cull::occlusion::OcclusionBuffer;

use crate::frame::{Frame, PixelId};

/// Pixels that a mesh owns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PixelCounts {
    /// All of them.
    pub owned: u64,
    /// Pixels where the occlusion buffer is empty.
    pub open: u64,
}

/// For each mesh of a scene, the pixels of a frame that its instances own, and those of them where
/// a buffer of the same view has nothing.
#[must_use]
pub fn pixels_of_meshes(
    scene: &Scene,
    frame: &Frame,
    buffer: &OcclusionBuffer,
) -> Vec<PixelCounts> {
    let mut counts = vec![PixelCounts::default(); scene.meshes().len()];
    let [columns, rows] = buffer.size();
    let scaled =
        |v: u32, from: u32, to: u32| (u64::from(v) * u64::from(to) / u64::from(from)) as u32;
    for (y, line) in (0..).zip(frame.ids.chunks_exact(frame.width.max(1) as usize)) {
        let row = scaled(y, frame.height, rows);
        for (x, id) in (0..).zip(line).filter(|(_, id)| **id != PixelId::NONE) {
            let of_mesh = &mut counts[scene.mesh_id(id.slot) as usize];
            of_mesh.owned += 1;
            let open = buffer.nearness(scaled(x, frame.width, columns), row) <= 0.0;
            of_mesh.open += u64::from(open);
        }
    }
    counts
}
