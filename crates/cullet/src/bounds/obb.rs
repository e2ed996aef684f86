//! Oriented boxes.

use bytemuck::{Pod, Zeroable};

/// A box with three orthonormal axes of its own.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Obb {
    /// The middle of the box.
    pub center: [f32; 3],
    /// Unit axes, one a row.
    pub axes: [[f32; 3]; 3],
    /// Half the length along each axis.
    pub half: [f32; 3],
}
