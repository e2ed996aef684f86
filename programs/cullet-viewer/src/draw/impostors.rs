//! Impostors as their shader reads them: what is known of each in one list, and the texels of all
//! in another. Pure computation.
//!
//! The heading of an impostor, the number of its first entry in the table, is the key of all
//! vertices of its box.

use cullet::{Scene, scene::MeshLevels};
use cullet_mesh::{Impostor, ImpostorFrame};

use super::frame::LEVELS;

/// Entries of the table before those of its frames.
const HEAD: u32 = 4;
/// Entries of a frame.
const FRAME: u32 = 3;
/// Distance in texels that a point may lie in front of the surface and still be of it, as in
/// `cullet-draw`.
const TOLERANCE: f64 = 0.5;
/// The heading of what is no box.
const NONE: u32 = u32::MAX;

/// Meshes that are boxes of impostors, and how much all impostors need.
#[derive(Clone, Debug, Default)]
pub(super) struct Boxes {
    /// Heading of each mesh, as far as there are boxes; else [`NONE`].
    headings: Vec<u32>,
    entries: u64,
    texels: u64,
}

/// All impostors of a scene.
#[derive(Clone, Debug, Default)]
pub(super) struct Impostors {
    boxes: Boxes,
    /// Entries of each impostor: the middle of its box, with frames along a side of its grid; half
    /// its size, with texels along a side of a frame; its first texel as low and high 16 bits, its
    /// mesh's first entry in the list of parts, and how many entries a part has; the number of its
    /// colour among levels. Then, for each frame, rows that take an offset from the middle to the
    /// frame, with a texel's difference of depth, the tolerance of depths, and padding.
    pub(super) table: Vec<[f32; 4]>,
    /// Words of each texel: that of its shape, and above it that of its normal.
    pub(super) texels: Vec<u32>,
}

/// All levels that are impostors, with the mesh that has them.
fn all(scene: &Scene) -> impl Iterator<Item = (u32, &MeshLevels, &Impostor)> {
    (0..scene.meshes().len() as u32).flat_map(|mesh| {
        let levels = scene.levels(mesh).iter();
        levels.filter_map(move |l| Some((mesh, l, Impostor::of(l)?)))
    })
}

impl Boxes {
    pub(super) fn of(scene: &Scene) -> Self {
        let mut boxes = Self::default();
        for (_, levels, impostor) in all(scene) {
            let at = levels.mesh as usize;
            if boxes.headings.len() <= at {
                boxes.headings.resize(at + 1, NONE);
            }
            boxes.headings[at] = boxes.entries as u32;
            boxes.entries += u64::from(HEAD + FRAME * impostor.grid().pow(2));
            boxes.texels += impostor.shape().len() as u64;
        }
        boxes
    }

    /// Names and sizes of the two lists.
    pub(super) fn counts(&self) -> [(&'static str, u64); 2] {
        [("frames of impostors", self.entries), ("texels of impostors", self.texels)]
    }

    /// The heading of the impostor whose box a mesh is, if it is one.
    pub(super) fn heading(&self, mesh: u32) -> Option<u32> {
        self.headings.get(mesh as usize).copied().filter(|heading| *heading != NONE)
    }
}

impl Impostors {
    /// `parts` are the first entry of each mesh in the list of parts, and how many entries each of
    /// its parts has. The caller has checked that the lists are not too long.
    pub(super) fn new(scene: &Scene, boxes: Boxes, parts: &[[u32; 2]]) -> Self {
        let [entries, texels] = boxes.counts().map(|(_, count)| count as usize);
        let mut table = Vec::with_capacity(entries);
        let mut words = Vec::with_capacity(texels);
        // Beyond all levels of triangles.
        let levels = (0..scene.meshes().len() as u32).flat_map(|mesh| scene.levels(mesh));
        let triangles = levels.filter(|l| l.impostor.is_none());
        let most = triangles.flat_map(|l| l.levels.steps()).max().unwrap_or(0);
        let colour = (most + 1).min(LEVELS - 1) as f32;
        for (mesh, _, impostor) in all(scene) {
            let [first_part, part_entries] = parts[mesh as usize];
            let bounds = impostor.bounds();
            let [cx, cy, cz] = bounds.center().map(|v| v as f32);
            let [hx, hy, hz] = bounds.half_extent().map(|v| v as f32);
            let first = words.len() as u32;
            let [low, high] = [first & 0xFFFF, first >> 16].map(|v| v as f32);
            table.extend([
                [cx, cy, cz, impostor.grid() as f32],
                [hx, hy, hz, impostor.texels() as f32],
                [low, high, first_part as f32, part_entries as f32],
                [colour, 0.0, 0.0, 0.0],
            ]);
            let frames = Impostor::frames(impostor.grid(), &bounds, impostor.radius());
            table.extend(frames.iter().flat_map(|f| entries_of(f, impostor.texels())));
            let both = impostor.shape().iter().zip(impostor.normals());
            words.extend(both.map(|(&shape, &normal)| u32::from(shape) | u32::from(normal) << 16));
        }
        Self { boxes, table, texels: words }
    }

    /// Whether a mesh is the box of an impostor.
    pub(super) fn has(&self, mesh: u32) -> bool {
        self.boxes.heading(mesh).is_some()
    }
}

/// Returns the entries of a frame in the table.
fn entries_of(frame: &ImpostorFrame, across: u32) -> [[f32; 4]; FRAME as usize] {
    let half = frame.half;
    // Of the finer side, as far as both are of some size.
    let size = half[0].min(half[1]).max(half[0].max(half[1]) / 4.0);
    let texel = 2.0 * size / f64::from(across) / half[2];
    let tolerance = TOLERANCE * texel + 1.5 / 255.0;
    let row = |a: usize, with: f64| {
        let [x, y, z] = frame.axes[a].map(|v| v / half[a]);
        [x, y, z, with].map(|v| v as f32)
    };
    [row(0, texel), row(1, tolerance), row(2, 0.0)]
}

#[cfg(test)]
mod tests {
    use cullet::bounds::Aabb;
    use cullet_testkit::meshes;

    use super::*;

    #[test]
    fn each_box_has_its_heading_and_its_texels() {
        let mut scene = Scene::new();
        let mut held = Vec::new();
        for (grid, texels) in [(4, 3), (5, 2)] {
            let own = scene.add_mesh(meshes::block([-1.0; 3], [1.0, 2.0, 3.0]));
            let count = Impostor::texel_count([grid, texels]).unwrap();
            let bounds = Aabb::new([-1.0; 3], [1.0, 2.0, 3.0]);
            let (shape, normals) = (vec![grid as u16; count], vec![texels as u16; count]);
            let made = Impostor::new([grid, texels], (bounds, 4.0), 0.1, shape, normals).unwrap();
            held.push(made.add_to(&mut scene, own).unwrap());
        }
        let boxes = Boxes::of(&scene);
        let second = HEAD + 16 * FRAME;
        assert_eq!(
            [0, 1, 2, 3, 9].map(|m| boxes.heading(m)),
            [None, Some(0), None, Some(second), None]
        );
        assert_eq!(held, [1, 3]);
        let all = Impostors::new(&scene, boxes, &[[7, 2], [9, 1], [10, 1], [11, 1]]);
        let counts = all.boxes.counts().map(|c| c.1 as usize);
        assert_eq!(counts, [all.table.len(), all.texels.len()]);
        assert_eq!(all.table[2], [0.0, 0.0, 7.0, 2.0]);
        let at = second as usize;
        assert_eq!(all.table[at], [0.0, 0.5, 1.0, 5.0]);
        assert_eq!(all.table[at + 2], [144.0, 0.0, 10.0, 1.0]);
        assert_eq!(all.texels[143..145], [4 | 3 << 16, 5 | 2 << 16]);
        // A corner of the box lies in every frame, or on its edge.
        for frame in all.table[at + HEAD as usize..].chunks_exact(FRAME as usize) {
            let [x, y, z] = [0, 1, 2].map(|k| {
                let row: [f32; 4] = frame[k];
                row[0] + row[1] * 1.5 + row[2] * 2.0
            });
            assert!([x, y, z].iter().all(|v| v.abs() < 1.0001), "{x} {y} {z}");
        }
    }
}
