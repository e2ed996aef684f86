//! The list of the passes, made by the CPU: slow and obvious.

use super::blocks::{BLOCK, Blocks};
use super::planes::BlockPlanes;

/// The slots in the layers of a view that no plane rejects and that are not small, ascending: what
/// the passes answer, byte for byte.
#[must_use]
pub fn visible_ref(blocks: &Blocks, planes: &BlockPlanes) -> Vec<u32> {
    let mut list = Vec::new();
    for of in planes.in_use() {
        let first = of.block as usize * BLOCK;
        for (slot, own) in (first..).zip(&blocks.boxes()[first..first + BLOCK]) {
            let rejected = || planes.planes_of(of).iter().any(|plane| plane.rejects(own));
            let dropped = || rejected() || planes.is_small(of, own);
            if own.layers & planes.layers() != 0 && (own.is_always() || !dropped()) {
                list.push(slot as u32);
            }
        }
    }
    list
}
