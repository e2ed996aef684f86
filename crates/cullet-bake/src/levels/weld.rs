//! Vertices that are one: at one position, or at one position with the same attributes.

use cullet::mesh::weld;

use super::attributes::VertexValues;

/// For each vertex the first at its position, and the first at its position with the same
/// attributes. Bits are compared, but −0 is 0 as a coordinate.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Welded {
    /// Position number of each vertex; it decides which triangles meet.
    pub(super) position: Vec<u32>,
    /// Vertex that triangles name: of two vertices with different attributes each stays.
    pub(super) vertex: Vec<u32>,
}

impl Welded {
    /// Attributes must have been checked. O(n log n), expected O(n) without attributes.
    pub(super) fn new(positions: &[[f32; 3]], attributes: Option<VertexValues<'_>>) -> Self {
        let position = weld(positions);
        let Some(attributes) = attributes.filter(|a| a.count > 0) else {
            return Self { vertex: position.clone(), position };
        };
        let count = attributes.count;
        let of =
            |v: u32| attributes.values[v as usize * count..][..count].iter().map(|a| a.to_bits());
        // Sorted, for there may be any number at one position.
        let mut order: Vec<u32> = (0..positions.len() as u32).collect();
        order.sort_unstable_by(|&a, &b| {
            let place = position[a as usize].cmp(&position[b as usize]);
            place.then_with(|| of(a).cmp(of(b))).then(a.cmp(&b))
        });
        let mut vertex = position.clone();
        let same =
            |a: &u32, b: &u32| position[*a as usize] == position[*b as usize] && of(*a).eq(of(*b));
        for run in order.chunk_by(same) {
            run.iter().for_each(|&v| vertex[v as usize] = run[0]);
        }
        Self { position, vertex }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_keep_vertices_apart_that_positions_join() {
        let positions = [[1.0; 3], [0.0; 3], [-0.0; 3], [1.0; 3], [1.0; 3]];
        let plain = Welded::new(&positions, None);
        assert_eq!(plain.position, [0, 1, 1, 0, 0]);
        assert_eq!(plain.vertex, plain.position);
        let attributes =
            VertexValues { values: &[0.0, 7.0, 1.0, 1.0, 1.0, 1.0, 2.0, 7.0, 0.0, 7.0], count: 2 };
        let apart = Welded::new(&positions, Some(attributes));
        assert_eq!(apart.position, plain.position);
        assert_eq!(apart.vertex, [0, 1, 1, 3, 0]);
    }
}
