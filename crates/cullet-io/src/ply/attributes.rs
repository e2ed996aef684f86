//! Properties of vertices besides their positions.

use super::header::{Element, Scalar};
use crate::Attributes;
use crate::attributes::{NO_COLOR, NO_NORMAL, NO_UV, linear};

/// The names that programs give texture coordinates.
const UV_NAMES: [[&str; 2]; 4] = [["s", "t"], ["u", "v"], ["texture_u", "texture_v"], ["s0", "t0"]];

/// The properties that are attributes; an attribute counts only if all of its properties are there.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Columns {
    normal: Option<[usize; 3]>,
    uv: Option<[usize; 2]>,
    color: Option<[usize; 3]>,
    alpha: Option<usize>,
    /// The value of full intensity, where colours are integers.
    most: f64,
}

/// The attributes of one vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct VertexAttributes {
    normal: [f32; 3],
    uv: [f32; 2],
    color: [f32; 4],
}

impl Columns {
    /// Finds the attribute columns of an element.
    pub(super) fn find(element: &Element) -> Self {
        let single =
            |name: &str| element.find(name).filter(|&p| element.properties[p].count.is_none());
        let three = |names: [&str; 3]| {
            let [x, y, z] = names.map(single);
            Some([x?, y?, z?])
        };
        let color = three(["red", "green", "blue"]).or_else(|| three(["r", "g", "b"]));
        let most = color.map_or(1.0, |[red, ..]| match element.properties[red].kind {
            Scalar::U8 | Scalar::I8 => 255.0,
            Scalar::U16 | Scalar::I16 => 65_535.0,
            Scalar::U32 | Scalar::I32 => f64::from(u32::MAX),
            Scalar::F32 | Scalar::F64 => 1.0,
        });
        Self {
            normal: three(["nx", "ny", "nz"]),
            uv: UV_NAMES.iter().find_map(|&[u, v]| Some([single(u)?, single(v)?])),
            color,
            alpha: single("alpha").filter(|_| color.is_some()),
            most,
        }
    }

    /// Room for as many vertices as the header was held to.
    pub(super) fn reserve(&self, to: &mut Attributes, vertices: usize) {
        let room = |used: bool| if used { vertices } else { 0 };
        to.normals.reserve_exact(room(self.normal.is_some()));
        to.uvs.reserve_exact(room(self.uv.is_some()));
        to.colors.reserve_exact(room(self.color.is_some()));
    }

    /// A vertex before anything is known of it.
    pub(super) fn none(&self) -> VertexAttributes {
        VertexAttributes { normal: NO_NORMAL, uv: NO_UV, color: NO_COLOR }
    }

    /// Takes the value of a property.
    #[inline]
    pub(super) fn take(&self, property: usize, value: f64, row: &mut VertexAttributes) {
        let place = |columns: &[usize]| columns.iter().position(|&c| c == property);
        if let Some(i) = self.normal.and_then(|c| place(&c)) {
            row.normal[i] = value as f32;
        }
        if let Some(i) = self.uv.and_then(|c| place(&c)) {
            // The first row of an image is at the bottom here.
            row.uv[i] = if i == 1 { (1.0 - value) as f32 } else { value as f32 };
        }
        if let Some(i) = self.color.and_then(|c| place(&c)) {
            // Colours of PLY are those of the screen.
            row.color[i] = linear((value / self.most) as f32);
        }
        if self.alpha == Some(property) {
            row.color[3] = (value / self.most) as f32;
        }
    }

    /// Appends a vertex.
    #[inline]
    pub(super) fn push(&self, row: &VertexAttributes, to: &mut Attributes) {
        if self.normal.is_some() {
            to.normals.push(row.normal);
        }
        if self.uv.is_some() {
            to.uvs.push(row.uv);
        }
        if self.color.is_some() {
            to.colors.push(row.color);
        }
    }
}
