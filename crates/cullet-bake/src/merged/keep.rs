//! Finished groups as bytes, and by what they are known: sums of all that they are a function of.

use std::collections::HashMap;

use cullet::mesh::{Alpha, Part};
use cullet::{Mesh, MeshId, Scene};

use super::made::Made;
use super::tree::Node;
use super::{MergeInput, MergeOptions};
use crate::gather::Surface;
use cullet_io::baked::{Container, Tag, write_chunks};
use cullet_io::baked::{Sum, hash};

/// Counted up whenever the same instances and options give other groups, so that those of before
/// are not taken for them.
const VERSION: u64 = 3;

/// Groups of fewer triangles are made in less time than a file takes to be found.
const LEAST_TRIANGLES: u64 = 1000;

/// Where finished groups are kept, so that a merge that was stopped goes on from them.
pub trait Keep: Sync {
    /// The bytes that were kept under a key; `None` where there are none. What is damaged is not
    /// taken for a group.
    fn read(&self, key: u64) -> Option<Vec<u8>>;

    /// Keeps bytes under a key. Whether that succeeds is for the keeper to know: the group is used
    /// either way.
    fn write(&self, key: u64, bytes: &[u8]);
}

/// A keeper, with the keys of all nodes.
pub(super) struct Kept<'a> {
    keep: &'a dyn Keep,
    keys: Vec<u64>,
}

impl<'a> Kept<'a> {
    /// `None` where nothing is kept.
    pub(super) fn new(
        scene: &Scene,
        input: &MergeInput<'a>,
        options: &MergeOptions,
        nodes: &[Node],
    ) -> Option<Self> {
        let keep = input.keep?;
        Some(Self { keep, keys: keys(scene, input, options, nodes) })
    }

    /// Returns what was kept of a node: its levels, or that it has none.
    pub(super) fn read(&self, node: usize) -> Option<Option<Made>> {
        from_bytes(&self.keep.read(self.keys[node])?)
    }

    pub(super) fn write(&self, node: usize, made: Option<&Made>) {
        self.keep.write(self.keys[node], &to_bytes(made));
    }

    /// Whether a group of so many triangles is kept.
    pub(super) fn is_for(&self, triangles: u64) -> bool {
        triangles >= LEAST_TRIANGLES
    }
}

/// For each node the sum of all that its levels are a function of. Those below come first, and
/// count by their sums.
fn keys(scene: &Scene, input: &MergeInput<'_>, options: &MergeOptions, nodes: &[Node]) -> Vec<u64> {
    // Threads change nothing.
    let settings = format!("{:?}", MergeOptions { threads: 1, ..*options });
    let settings = hash(format!("{} {settings}", env!("CARGO_PKG_VERSION")).as_bytes());
    let mut of_meshes: HashMap<MeshId, u64> = HashMap::new();
    let mut keys: Vec<u64> = Vec::with_capacity(nodes.len());
    for node in nodes {
        let mut sum = Sum::new(VERSION);
        sum.add(settings);
        scene.origin().iter().for_each(|v| sum.add(v.to_bits()));
        sum.add_all(node.below.iter().map(|&b| keys[b as usize]));
        sum.add(node.slots.len() as u64);
        for &slot in &node.slots {
            let mesh = scene.mesh_id(slot);
            sum.add(*of_meshes.entry(mesh).or_insert_with(|| sum_of(scene, input, mesh)));
            scene.transform(slot).to_matrix().iter().for_each(|v| sum.add(v.to_bits()));
        }
        keys.push(sum.end());
    }
    keys
}

/// Returns the sum of a mesh, its levels and its attributes.
fn sum_of(scene: &Scene, input: &MergeInput<'_>, mesh: MeshId) -> u64 {
    let mut sum = Sum::new(1);
    add_mesh(&scene.meshes()[mesh as usize], &mut sum);
    for levels in scene.levels(mesh).iter().filter(|l| l.impostor.is_none()) {
        add_mesh(&scene.meshes()[levels.mesh as usize], &mut sum);
        let own = &levels.levels;
        for group in (0..own.group_count()).map(|g| own.group(g)) {
            let [x, y, z] = group.centre;
            [x, y, z, group.radius, group.error].iter().for_each(|v| sum.add(v.to_bits().into()));
        }
        sum.add_all(own.made_from().iter().map(|&g| g.into()));
        sum.add_all(own.replaced_by().iter().map(|&g| g.into()));
    }
    let attributes = input.attributes.get(mesh as usize).copied().unwrap_or_default();
    let bits = |v: &f32| u64::from(v.to_bits());
    sum.add_all(attributes.uvs.as_flattened().iter().map(bits));
    sum.add_all(attributes.colors.as_flattened().iter().map(bits));
    sum.end()
}

fn add_mesh(mesh: &Mesh, sum: &mut Sum) {
    sum.add_all(mesh.positions().as_flattened().iter().map(|v| v.to_bits().into()));
    sum.add_all(mesh.indices().iter().map(|&v| v.into()));
    for c in mesh.clusters() {
        sum.add(u64::from(c.first_triangle) | u64::from(c.triangle_count) << 32);
        sum.add(c.part.into());
    }
    for part in mesh.parts() {
        let row = row_of(part);
        sum.add(u64::from(row[1]) | u64::from(row[2]) << 32);
        sum.add(row[3].into());
    }
}

/// Numbers of a part: first triangle, how many, material, two-sided + 2 · alpha.
fn row_of(part: &Part) -> [u32; 4] {
    let alpha = match part.alpha {
        Alpha::Opaque => 0,
        Alpha::Masked => 1,
        Alpha::Blended => 2,
    };
    let kind = u32::from(part.two_sided) + 2 * alpha;
    [part.first_triangle, part.triangle_count, part.material, kind]
}

fn part_of([first_triangle, triangle_count, material, kind]: [u32; 4]) -> Option<Part> {
    let alpha = [Alpha::Opaque, Alpha::Masked, Alpha::Blended].get(kind as usize / 2).copied()?;
    Some(Part { first_triangle, triangle_count, material, two_sided: kind % 2 == 1, alpha })
}

/// Most levels that [`MergeOptions::levels`] allows.
const MOST_LEVELS: usize = 16;

/// The name of a chunk of a level.
fn tag(what: [u8; 3], level: usize) -> Tag {
    [what[0], what[1], what[2], b'a' + level as u8]
}

/// A file of chunks: of all the origin (three f64), the radius and the error of each level; of each
/// level positions, attributes, indices and parts.
fn to_bytes(made: Option<&Made>) -> Vec<u8> {
    let mut chunks: Vec<(Tag, Vec<u8>)> = Vec::new();
    let mut head = Vec::new();
    if let Some(made) = made {
        head.extend(made.origin.iter().flat_map(|v| v.to_le_bytes()));
        head.extend(made.radius.to_le_bytes());
        head.extend(made.levels.iter().flat_map(|(_, error)| error.to_le_bytes()));
    }
    chunks.push((*b"HEAD", head));
    let levels = made.iter().flat_map(|made| &made.levels);
    for (level, (surface, _)) in levels.enumerate() {
        let floats =
            |list: &[f32]| -> Vec<u8> { list.iter().flat_map(|v| v.to_le_bytes()).collect() };
        let ints = |list: &[u32]| list.iter().flat_map(|v| v.to_le_bytes()).collect();
        let parts: Vec<[u32; 4]> = surface.parts.iter().map(row_of).collect();
        chunks.extend([
            (tag(*b"POS", level), floats(surface.positions.as_flattened())),
            (tag(*b"ATT", level), floats(surface.values.as_flattened())),
            (tag(*b"IDX", level), ints(&surface.indices)),
            (tag(*b"PRT", level), ints(parts.as_flattened())),
        ]);
    }
    let chunks: Vec<(Tag, &[u8])> = chunks.iter().map(|(tag, bytes)| (*tag, &bytes[..])).collect();
    write_chunks(&chunks)
}

/// Reads levels from such bytes; `None` where they are damaged, or contradict themselves.
fn from_bytes(bytes: &[u8]) -> Option<Option<Made>> {
    let file = Container::open(bytes).ok()?;
    let head = file.chunk(*b"HEAD").ok()?;
    if head.is_empty() {
        return Some(None);
    }
    let (origin, rest) = head.split_at_checked(24)?;
    let (origin, _) = origin.as_chunks::<8>();
    let origin = [0, 1, 2].map(|a| f64::from_le_bytes(origin[a]));
    let numbers = floats(rest)?;
    let (&radius, errors) = numbers.split_first()?;
    let is_sound = radius > 0.0
        && origin.iter().all(|v| v.is_finite())
        && errors.len() <= MOST_LEVELS
        && errors.is_sorted()
        && errors.iter().all(|e| e.is_finite() && *e >= 0.0);
    if !is_sound {
        return None;
    }
    let levels = errors.iter().enumerate().map(|(level, &error)| {
        let chunk = |what: [u8; 3]| file.chunk(tag(what, level)).ok();
        let (positions, none) = rows::<_, 3>(&floats(chunk(*b"POS")?)?);
        let (values, rest) = rows::<_, 6>(&floats(chunk(*b"ATT")?)?);
        let (parts, more) = rows::<_, 4>(&ints(chunk(*b"PRT")?)?);
        let indices = ints(chunk(*b"IDX")?)?;
        let parts: Vec<Part> = parts.into_iter().map(part_of).collect::<Option<_>>()?;
        let mut first = 0;
        for part in &parts {
            if part.first_triangle != first {
                return None;
            }
            first = first.checked_add(part.triangle_count)?;
        }
        let whole = none && rest && more && indices.len() as u64 == u64::from(first) * 3;
        let of_all = values.is_empty() || values.len() == positions.len();
        let known = indices.iter().all(|&v| (v as usize) < positions.len());
        let mut numbers = positions.as_flattened().iter().chain(values.as_flattened());
        let is_sound = whole && of_all && known && numbers.all(|v| v.is_finite());
        is_sound.then_some((Surface { positions, values, indices, parts }, error))
    });
    let levels: Vec<_> = levels.collect::<Option<_>>()?;
    Some(Some(Made { origin, radius, levels }))
}

fn words(bytes: &[u8]) -> Option<&[[u8; 4]]> {
    let (words, rest) = bytes.as_chunks::<4>();
    rest.is_empty().then_some(words)
}

fn floats(bytes: &[u8]) -> Option<Vec<f32>> {
    Some(words(bytes)?.iter().map(|&w| f32::from_le_bytes(w)).collect())
}

fn ints(bytes: &[u8]) -> Option<Vec<u32>> {
    Some(words(bytes)?.iter().map(|&w| u32::from_le_bytes(w)).collect())
}

/// Rows of so many numbers, and whether they are whole.
fn rows<T: Copy, const N: usize>(numbers: &[T]) -> (Vec<[T; N]>, bool) {
    let (rows, rest) = numbers.as_chunks::<N>();
    (rows.to_vec(), rest.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_made_comes_back_and_damage_counts_for_nothing() {
        let part = |first_triangle, triangle_count, material| Part {
            first_triangle,
            triangle_count,
            material,
            two_sided: material == 1,
            alpha: Alpha::Masked,
        };
        let surface = |values: bool| Surface {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [2.0; 3]],
            values: if values { vec![[0.5; 6]; 4] } else { Vec::new() },
            indices: vec![0, 1, 2, 2, 1, 3],
            parts: vec![part(0, 1, 1), part(1, 1, 7)],
        };
        let levels = vec![(surface(true), 0.25), (surface(false), 0.5)];
        let made = Made { origin: [1e7, 2.0, -3.0], radius: 4.0, levels };
        let bytes = to_bytes(Some(&made));
        assert_eq!(from_bytes(&bytes), Some(Some(made)));
        assert_eq!(from_bytes(&to_bytes(None)), Some(None));
        for at in 0..bytes.len() {
            assert_eq!(from_bytes(&bytes[..at]), None, "cut at {at}");
            let mut odd = bytes.clone();
            odd[at] ^= 4;
            assert_eq!(from_bytes(&odd), None, "odd at {at}");
        }
    }

    #[test]
    fn what_contradicts_itself_is_none() {
        let surface = Surface {
            positions: vec![[0.0; 3]; 3],
            indices: vec![0, 1, 2],
            parts: vec![Part { triangle_count: 1, ..Part::default() }],
            ..Surface::default()
        };
        let with = |change: &dyn Fn(&mut Made)| {
            let levels = vec![(surface.clone(), 0.25)];
            let mut made = Made { origin: [0.0; 3], radius: 1.0, levels };
            change(&mut made);
            from_bytes(&to_bytes(Some(&made)))
        };
        assert!(with(&|_| ()).is_some());
        assert_eq!(with(&|m| m.levels[0].0.indices[1] = 3), None);
        assert_eq!(with(&|m| m.levels[0].0.parts[0].triangle_count = 2), None);
        assert_eq!(with(&|m| m.levels[0].0.parts[0].first_triangle = 1), None);
        assert_eq!(with(&|m| m.levels[0].0.values = vec![[0.0; 6]; 2]), None);
        assert_eq!(with(&|m| m.levels[0].0.positions[0][0] = f32::NAN), None);
        assert_eq!(with(&|m| m.levels[0].1 = -1.0), None);
        assert_eq!(with(&|m| m.radius = f32::NAN), None);
    }
}
