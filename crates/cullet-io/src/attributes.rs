//! Attributes of a vertex besides its position: normal, texture coordinates, colour.

use cullet::Mesh;
use cullet::math;
use glam::Vec3;

/// The attributes of a mesh's vertices, kept where
/// [`LoadOptions::details`](crate::LoadOptions::details) requests them. Each list has one entry a
/// vertex, in the order of the mesh's positions, or is empty where the file has none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Attributes {
    /// Normals in the space of the mesh, as the file has them: of any length, and zero where a part
    /// of the mesh has none or what it has is not finite.
    pub normals: Vec<[f32; 3]>,
    /// The first set of texture coordinates, with v = 0 at the top of the image as in glTF.
    pub uvs: Vec<[f32; 2]>,
    /// Linear colours and alpha; white where a part of the mesh has none.
    pub colors: Vec<[f32; 4]>,
}

/// Values in place of attributes that a vertex has not.
pub(crate) const NO_NORMAL: [f32; 3] = [0.0; 3];
pub(crate) const NO_UV: [f32; 2] = [0.0; 2];
pub(crate) const NO_COLOR: [f32; 4] = [1.0; 4];

impl Attributes {
    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.normals.is_empty() && self.uvs.is_empty() && self.colors.is_empty()
    }

    /// Numbers a vertex, if each vertex's are put one after another: normal, texture coordinates,
    /// colour.
    #[must_use]
    pub fn stride(&self) -> usize {
        let size = |used: bool, numbers: usize| if used { numbers } else { 0 };
        size(!self.normals.is_empty(), 3)
            + size(!self.uvs.is_empty(), 2)
            + size(!self.colors.is_empty(), 4)
    }

    /// The numbers of all vertices, one vertex after another.
    #[must_use]
    pub fn interleaved(&self) -> Vec<f32> {
        let vertices = self.normals.len().max(self.uvs.len()).max(self.colors.len());
        let mut out = Vec::with_capacity(vertices * self.stride());
        for v in 0..vertices {
            out.extend(self.normals.get(v).into_iter().flatten());
            out.extend(self.uvs.get(v).into_iter().flatten());
            out.extend(self.colors.get(v).into_iter().flatten());
        }
        out
    }

    /// Takes [`interleaved`](Self::interleaved) numbers apart again, for as many vertices as they
    /// are of, into the lists that this mesh has.
    #[must_use]
    pub fn like(&self, interleaved: &[f32]) -> Self {
        let mut out = Self::default();
        for vertex in interleaved.chunks_exact(self.stride().max(1)) {
            let mut rest = vertex;
            if !self.normals.is_empty() {
                out.normals.extend(take(&mut rest));
            }
            if !self.uvs.is_empty() {
                out.uvs.extend(take(&mut rest));
            }
            if !self.colors.is_empty() {
                out.colors.extend(take(&mut rest));
            }
        }
        out
    }

    /// Appends those of another block of vertices, of which `before` came earlier.
    pub(crate) fn extend(&mut self, before: usize, block: &Self) {
        append(&mut self.normals, before, &block.normals, NO_NORMAL);
        append(&mut self.uvs, before, &block.uvs, NO_UV);
        append(&mut self.colors, before, &block.colors, NO_COLOR);
    }

    /// Appends those of one vertex of another block.
    pub(crate) fn push(&mut self, before: usize, block: &Self, vertex: usize) {
        let at = vertex..vertex + 1;
        append(&mut self.normals, before, block.normals.get(at.clone()).unwrap_or(&[]), NO_NORMAL);
        append(&mut self.uvs, before, block.uvs.get(at.clone()).unwrap_or(&[]), NO_UV);
        append(&mut self.colors, before, block.colors.get(at).unwrap_or(&[]), NO_COLOR);
    }

    /// Brings every list that is there to one entry a vertex, and gives back what it has too much.
    pub(crate) fn complete(&mut self, vertices: usize) {
        fill(&mut self.normals, vertices, NO_NORMAL);
        fill(&mut self.uvs, vertices, NO_UV);
        fill(&mut self.colors, vertices, NO_COLOR);
    }

    /// Puts what stands for none in the place of what is not finite; says how many vertices had
    /// such.
    pub(crate) fn mend(&mut self) -> usize {
        mend(&mut self.normals, NO_NORMAL)
            + mend(&mut self.uvs, NO_UV)
            + mend(&mut self.colors, NO_COLOR)
    }

    /// Normals of unit length: where one is zero, that of the triangles around the vertex, by area,
    /// and +Y where they have none either. Empty where there are none.
    pub(crate) fn unit_normals(&self, mesh: &Mesh) -> Vec<[f32; 3]> {
        let mut normals = self.normals.clone();
        let missing: Vec<bool> =
            normals.iter().map(|&n| Vec3::from(n).try_normalize().is_none()).collect();
        if missing.contains(&true) {
            let positions = mesh.positions();
            for t in mesh.original_indices().chunks_exact(3) {
                let [a, b, c] = [0, 1, 2].map(|i| Vec3::from(positions[t[i] as usize]));
                let area = (b - a).cross(c - a);
                for &v in t.iter().filter(|&&v| missing[v as usize]) {
                    let n = &mut normals[v as usize];
                    *n = (Vec3::from(*n) + area).to_array();
                }
            }
        }
        for n in &mut normals {
            *n = Vec3::from(*n).try_normalize().unwrap_or(Vec3::Y).to_array();
        }
        normals
    }
}

fn take<const N: usize>(from: &mut &[f32]) -> Option<[f32; N]> {
    let (first, rest) = from.split_first_chunk()?;
    *from = rest;
    Some(*first)
}

/// Nothing happens where there is nothing to append: a list begins with the first block that has
/// one.
fn append<T: Copy>(to: &mut Vec<T>, before: usize, block: &[T], none: T) {
    if !block.is_empty() {
        to.resize(before, none);
        to.extend_from_slice(block);
    }
}

fn fill<T: Copy>(list: &mut Vec<T>, vertices: usize, none: T) {
    if !list.is_empty() {
        list.resize(vertices, none);
        list.shrink_to_fit();
    }
}

fn mend<const N: usize>(list: &mut [[f32; N]], none: [f32; N]) -> usize {
    let mut count = 0;
    for v in list.iter_mut().filter(|v| v.iter().any(|c| !c.is_finite())) {
        *v = none;
        count += 1;
    }
    count
}

/// The linear value of one in sRGB, 0 to 1; beyond that it is kept as it is.
pub(crate) fn linear(v: f32) -> f32 {
    match v {
        v if !(0.0..=1.0).contains(&v) => v,
        v if v <= 0.040_45 => v / 12.92,
        v => math::pow((f64::from(v) + 0.055) / 1.055, 2.4) as f32,
    }
}

/// The byte in sRGB of a linear value; NaN is 0.
pub(crate) fn srgb_byte(v: f32) -> u8 {
    let v = f64::from(v);
    let s = if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * math::pow(v, 1.0 / 2.4) - 0.055 };
    // A cast saturates.
    (s * 255.0).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_without_an_attribute_are_filled() {
        let mut all = Attributes::default();
        all.extend(0, &Attributes { uvs: vec![[0.5, 0.25]; 2], ..Attributes::default() });
        all.extend(2, &Attributes { colors: vec![[0.5; 4]], ..Attributes::default() });
        all.push(3, &Attributes { uvs: vec![[0.0; 2], [1.0; 2]], ..Attributes::default() }, 1);
        all.complete(5);
        assert!(all.normals.is_empty());
        assert_eq!(all.uvs, [[0.5, 0.25], [0.5, 0.25], NO_UV, [1.0; 2], NO_UV]);
        assert_eq!(all.colors, [NO_COLOR, NO_COLOR, [0.5; 4], NO_COLOR, NO_COLOR]);
        assert_eq!(all.stride(), 6);
        assert_eq!(all.like(&all.interleaved()), all);
    }

    #[test]
    fn what_is_not_finite_is_none() {
        let mut a = Attributes {
            normals: vec![[0.0, f32::NAN, 0.0], [0.0, 2.0, 0.0]],
            uvs: vec![[f32::INFINITY, 0.0], [0.5; 2]],
            colors: Vec::new(),
        };
        assert_eq!(a.mend(), 2);
        assert_eq!(a.normals, [NO_NORMAL, [0.0, 2.0, 0.0]]);
        assert_eq!(a.uvs, [NO_UV, [0.5; 2]]);
    }

    #[test]
    fn missing_normals_are_those_of_the_triangles() {
        let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [5.0; 3]];
        let data = cullet::MeshData { positions, indices: vec![0, 1, 2], ..Default::default() };
        let mesh = Mesh::new(data).expect("a triangle");
        let normals = vec![NO_NORMAL, [0.0, 0.0, -4.0], NO_NORMAL, NO_NORMAL];
        let a = Attributes { normals, ..Attributes::default() };
        let z = [0.0, 0.0, 1.0];
        assert_eq!(a.unit_normals(&mesh), [z, [0.0, 0.0, -1.0], z, [0.0, 1.0, 0.0]]);
    }

    #[test]
    fn bytes_of_colours_come_back() {
        for b in 0..=255u8 {
            assert_eq!(srgb_byte(linear(f32::from(b) / 255.0)), b);
        }
        assert_eq!([srgb_byte(f32::NAN), srgb_byte(-1.0), srgb_byte(9.0)], [0, 0, 255]);
    }
}
