//! Attributes of the corners of faces besides positions: an index each for texture coordinates and
//! normals, and the colours that some programs put behind positions.

use std::collections::HashMap;

use super::Reader;
use crate::attributes::{NO_COLOR, NO_NORMAL, NO_UV, linear};
use crate::blocks::push;
use crate::compact::Compact;
use crate::{Attributes, ErrorKind};

/// A list of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum List {
    Uv,
    Normal,
}

/// A corner that names no texture coordinates, or no normal.
const NONE: u32 = u32::MAX;
/// Up to so many corners of a polygon are found by looking at each.
const FEW: usize = 16;

/// A face that names what is not there: what, its number from 1, how many there are, and where.
pub(super) type Ahead = (&'static str, u64, usize, u64);

/// Corners, each combination of position, texture coordinates and normal once: the vertices to be.
#[derive(Debug, Default)]
pub(super) struct Corners {
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    /// One colour per position; as long as the last one that has any.
    colors: Vec<[f32; 4]>,
    /// Texture coordinates and normal of each corner of the face that is being read.
    polygon: Vec<[u32; 2]>,
    number: HashMap<[u32; 3], u32>,
    all: Vec<[u32; 3]>,
    /// For either list the largest number named and where.
    largest: [Option<(u32, u64)>; 2],
}

impl Corners {
    /// Begins a face.
    pub(super) fn begin(&mut self) {
        self.polygon.clear();
    }

    /// Takes what follows a corner's position: nothing, `/vt`, `//vn` or `/vt/vn`. Whether it is
    /// one of these, with numbers from 1, or back from the last one.
    pub(super) fn name(&mut self, rest: &[u8], at: u64) -> bool {
        let mut named = [NONE; 2];
        let mut fields = rest.split(|&b| b == b'/');
        // The empty field before the first slash.
        fields.next();
        for (list, count) in [self.uvs.len(), self.normals.len()].into_iter().enumerate() {
            let Some(field) = fields.next().filter(|f| !f.is_empty()) else { continue };
            let number = std::str::from_utf8(field).ok().and_then(|f| f.parse::<i64>().ok());
            let index = match number {
                Some(n) if n > 0 => u32::try_from(n - 1).ok().filter(|&i| i != NONE),
                Some(n) if n < 0 => n.checked_add(count as i64).and_then(|i| u32::try_from(i).ok()),
                _ => None,
            };
            let Some(index) = index else { return false };
            named[list] = index;
            if self.largest[list].is_none_or(|(most, _)| index > most) {
                self.largest[list] = Some((index, at));
            }
        }
        self.polygon.push(named);
        fields.next().is_none()
    }

    /// Puts corners in the place of the positions of a face's triangles. A face that comes by a
    /// position twice takes what it has there first. Whether 32 bits can number them all.
    pub(super) fn resolve(&mut self, positions: &[u32], triangles: &mut [u32]) -> bool {
        let mut first = HashMap::new();
        if positions.len() > FEW {
            for (i, &p) in positions.iter().enumerate() {
                first.entry(p).or_insert(i);
            }
        }
        for index in triangles {
            let at = match positions.len() {
                ..=FEW => positions.iter().position(|p| p == index),
                _ => first.get(index).copied(),
            };
            let [uv, normal] = at.map_or([NONE; 2], |at| self.polygon[at]);
            let corner = [*index, uv, normal];
            let next = self.all.len() as u32;
            if next == u32::MAX {
                return false;
            }
            *index = *self.number.entry(corner).or_insert(next);
            if *index == next {
                push(&mut self.all, corner);
            }
        }
        true
    }

    /// A face that names what the file has not.
    pub(super) fn ahead(&self) -> Option<Ahead> {
        let lists = [
            ("texture coordinates", self.uvs.len(), self.largest[0]),
            ("normal", self.normals.len(), self.largest[1]),
        ];
        lists.into_iter().find_map(|(what, count, largest)| {
            let (index, at) = largest.filter(|&(index, _)| index as usize >= count)?;
            Some((what, u64::from(index) + 1, count, at))
        })
    }

    /// The positions that corners use.
    pub(super) fn positions(&self) -> Vec<u32> {
        self.all.iter().map(|c| c[0]).collect()
    }

    /// How many corners there are.
    pub(super) fn len(&self) -> usize {
        self.all.len()
    }

    /// Frees what only reading needs.
    pub(super) fn close(&mut self) {
        self.number = HashMap::new();
        self.all.shrink_to_fit();
    }

    /// The vertices that `indices`, of corners, use, and what they have; renumbers the indices.
    pub(super) fn take(
        &self,
        positions: &[[f32; 3]],
        compact: &mut Compact,
        indices: &mut [u32],
    ) -> (Vec<[f32; 3]>, Attributes) {
        let own = compact.take(&self.all, indices);
        let mut attributes = Attributes::default();
        let get = |at: u32| (at != NONE).then_some(at as usize);
        if own.iter().any(|c| c[1] != NONE) {
            let uv = |c: &[u32; 3]| get(c[1]).map_or(NO_UV, |i| self.uvs[i]);
            attributes.uvs = own.iter().map(uv).collect();
        }
        if own.iter().any(|c| c[2] != NONE) {
            let normal = |c: &[u32; 3]| get(c[2]).map_or(NO_NORMAL, |i| self.normals[i]);
            attributes.normals = own.iter().map(normal).collect();
        }
        if own.iter().any(|c| (c[0] as usize) < self.colors.len()) {
            let color = |c: &[u32; 3]| self.colors.get(c[0] as usize).copied().unwrap_or(NO_COLOR);
            attributes.colors = own.iter().map(color).collect();
        }
        (own.iter().map(|c| positions[c[0] as usize]).collect(), attributes)
    }
}

impl Reader<'_> {
    /// Reads a statement of texture coordinates or of a normal.
    pub(super) fn attribute(&mut self, list: List) -> Result<(), ErrorKind> {
        let Some(corners) = &mut self.corners else { return Ok(()) };
        let mut values = [0.0f32; 3];
        for (i, value) in values.iter_mut().enumerate() {
            self.c.skip_blanks();
            // One texture coordinate is enough.
            if list == List::Uv && i > 0 && self.c.at_line_end() {
                break;
            }
            *value = match (self.c.f32(), list) {
                (Some(number), _) => number,
                (None, List::Uv) => return Err(self.c.expected("a texture coordinate")),
                (None, List::Normal) => return Err(self.c.expected("a number of the normal")),
            };
            if list == List::Uv && i == 1 {
                break;
            }
        }
        let [x, y, z] = values;
        match list {
            // The first row of an image is at the bottom here.
            List::Uv => push(&mut corners.uvs, [x, 1.0 - y]),
            List::Normal => push(&mut corners.normals, [x, y, z]),
        }
        Ok(())
    }

    /// Reads what follows a position: a colour of the screen if it is three numbers, or four with
    /// alpha.
    pub(super) fn color(&mut self) {
        let Some(corners) = &mut self.corners else { return };
        let mut values = [1.0f32; 4];
        let mut count = 0;
        loop {
            self.c.skip_blanks();
            let Some(number) = self.c.f32().filter(|_| count < 4) else { break };
            values[count] = number;
            count += 1;
        }
        if count >= 3 {
            let [r, g, b, a] = values;
            let before = self.positions.len() - 1;
            corners.colors.resize(before, NO_COLOR);
            push(&mut corners.colors, [linear(r), linear(g), linear(b), a]);
        }
    }
}
