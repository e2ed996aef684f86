//! Own vertices for each mesh of a file whose meshes share one list.

/// Gives each mesh the vertices that it uses, out of those that all share. O(vertices) once, then
/// O(indices) a mesh.
#[derive(Debug)]
pub struct Compact {
    /// The mesh that last used a vertex, from 1, and the vertex's number there.
    used: Vec<(u32, u32)>,
    mesh: u32,
}

impl Compact {
    /// For a list of so many vertices.
    pub fn new(vertices: usize) -> Self {
        Self { used: vec![(0, 0); vertices], mesh: 0 }
    }

    /// The vertices that `indices` use, in the order of first use; renumbers the indices.
    pub fn take<T: Copy>(&mut self, vertices: &[T], indices: &mut [u32]) -> Vec<T> {
        self.mesh += 1;
        let mut count = 0;
        for index in &mut *indices {
            let used = &mut self.used[*index as usize];
            if used.0 != self.mesh {
                *used = (self.mesh, count);
                count += 1;
            }
        }
        let mut own = Vec::with_capacity(count as usize);
        for index in indices {
            let (_, number) = self.used[*index as usize];
            // Numbers are in the order of first use.
            if number as usize == own.len() {
                own.push(vertices[*index as usize]);
            }
            *index = number;
        }
        own
    }
}
