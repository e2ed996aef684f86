//! Subject of the items on back faces: one body of one-sided triangles, and which of them face an eye.

use crate::reproduce::model::Subject;
use cullet::cull::backface::{Facing, ObjectEye};
use cullet::mesh::Part;
use cullet::{CullFace, FrontFace, MeshData, Transform};
use cullet_scenes::knobbly_ball;

use crate::lecture::lab::{Lab, LabError};

/// The bunny that everybody knows, all its triangles one-sided; else a built-in solid of as many triangles.
pub(super) fn bunny(lab: &Lab) -> Result<Subject, LabError> {
    let Some(model) = lab.model("stanford-bunny/bun_zipper.ply")? else {
        return of_soup("a knobbly ball", knobbly_ball(76));
    };
    let mesh = &model.scene.meshes()[0];
    of_soup("the bunny", (mesh.positions().to_vec(), mesh.original_indices()))
}

/// The built-in ball with knobs, around the origin: a solid of 12·n² triangles.
pub(super) fn knobs(n: u16) -> Result<Subject, LabError> {
    of_soup("a knobbly ball", knobbly_ball(n))
}

fn of_soup(
    name: &str,
    (positions, indices): (Vec<[f32; 3]>, Vec<u32>),
) -> Result<Subject, LabError> {
    Subject::new(name.to_owned(), one_sided(positions, indices))
        .map_err(|failure| LabError::Other(failure.message))
}

/// A mesh of one part, which is drawn from its front alone.
pub(super) fn one_sided(positions: Vec<[f32; 3]>, indices: Vec<u32>) -> MeshData {
    let triangle_count = (indices.len() / 3) as u32;
    let parts = vec![Part { triangle_count, ..Part::default() }];
    MeshData { positions, indices, parts, ..MeshData::default() }
}

/// The exact test of triangles for a homogeneous eye.
pub(super) fn test_of(eye: [f64; 4]) -> ObjectEye {
    ObjectEye::new(eye, &Transform::IDENTITY, FrontFace::default(), CullFace::Back)
}

/// How each triangle faces an eye, by the exact test.
pub(super) fn facings(subject: &Subject, eye: [f64; 4]) -> Vec<Facing> {
    let test = test_of(eye);
    (0..subject.mesh.triangle_count()).map(|t| test.facing(&subject.mesh.corners(t))).collect()
}

/// Whether bit `i` is set.
pub(super) fn bit(bits: &[u64], i: usize) -> bool {
    bits[i / 64] >> (i % 64) & 1 == 1
}

/// How many bits are set.
pub(super) fn ones(bits: &[u64]) -> usize {
    bits.iter().map(|word| word.count_ones() as usize).sum()
}

/// Front faces among what is culled.
pub(super) fn lost(culled: impl Fn(usize) -> bool, facings: &[Facing]) -> usize {
    facings.iter().enumerate().filter(|(i, f)| **f == Facing::Front && culled(*i)).count()
}

/// a·b.
pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a of length 1.
pub(super) fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = dot(a, a).sqrt();
    a.map(|v| v / length)
}

/// Per cent of a whole.
pub(super) fn percent(part: usize, whole: usize) -> f64 {
    part as f64 * 100.0 / whole.max(1) as f64
}
