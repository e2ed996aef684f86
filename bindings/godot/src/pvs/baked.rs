//! Baked sets as plain data, and as bytes with a version and checksums.

use cullet_cells::cell::{CellError, CellGraph, CellPiece, CellShapes};
use cullet_cells::pvs::{SetsError, Targets, VisibleSets};
use cullet_io::baked::{Container, ContainerError, Region, write_chunks};
use thiserror::Error;

/// Version of the bytes.
const VERSION: u32 = 1;

/// Chunks: version and method, two estimates; boxes with their cells; sets of nodes; nodes.
const HEAD: [u8; 4] = *b"GPVS";
const BOXES: [u8; 4] = *b"BOXS";
const SETS: [u8; 4] = *b"SETS";
const NODES: [u8; 4] = *b"NODE";
/// Bytes of a box: its cell, four zeros, and six numbers.
const BOX: usize = 8 + 6 * 8;
/// Bytes of a node before its path: two sums, layers, length of the path.
const NODE: usize = 8 + 8 + 4 + 4;

/// The way by which sets were found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u32)]
pub(crate) enum Method {
    /// Rooms that are found in closed walls, and the openings between them. Conservative.
    #[default]
    Rooms = 0,
    /// Hidden is only what voxels inside closed meshes prove hidden. Conservative.
    Proved = 1,
    /// Visible is only what sampled lines met. Nodes may be missing.
    Sampled = 2,
}

impl Method {
    pub(crate) fn of(number: i64) -> Option<Self> {
        [Self::Rooms, Self::Proved, Self::Sampled].into_iter().find(|m| *m as i64 == number)
    }
}

/// A node of a set.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Named {
    /// Its path from the root of the scene.
    pub(crate) path: String,
    /// Sum of where it may be drawn; 0 for one that is never hidden.
    pub(crate) seen: u64,
    /// Sum of what it hid others by; 0 where it hid nothing.
    pub(crate) hides: u64,
    /// Layers in which it hid.
    pub(crate) layers: u32,
}

/// Baked sets.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Baked {
    pub(crate) method: Method,
    /// Estimated share of looks that go to something that a set lacks, the mean and the most of a
    /// cell; 0 where nothing can be missing.
    pub(crate) missing: [f64; 2],
    /// Boxes in which an eye may be, with their cells.
    pub(crate) boxes: Vec<(u32, Region)>,
    /// A set of nodes for each cell.
    pub(crate) sets: VisibleSets<'static>,
    pub(crate) nodes: Vec<Named>,
}

/// Why bytes are no baked sets.
#[derive(Clone, Debug, PartialEq, Error)]
pub(crate) enum BytesError {
    #[error(transparent)]
    Container(#[from] ContainerError),
    #[error(transparent)]
    Sets(#[from] SetsError),
    #[error(transparent)]
    Cell(#[from] CellError),
    #[error("version {0}; this library reads version {VERSION}: bake it again")]
    Version(u32),
    #[error("{0}: written by another program?")]
    Odd(&'static str),
}

impl Baked {
    /// Returns the bytes, the same for the same sets.
    pub(crate) fn to_bytes(&self) -> Vec<u8> {
        let mut head = [VERSION, self.method as u32].map(u32::to_le_bytes).concat();
        head.extend(self.missing.map(f64::to_le_bytes).concat());
        let mut boxes = Vec::with_capacity(self.boxes.len() * BOX);
        for (cell, region) in &self.boxes {
            boxes.extend(u64::from(*cell).to_le_bytes());
            region.as_flattened().iter().for_each(|v| boxes.extend(v.to_le_bytes()));
        }
        let mut nodes = Vec::new();
        for node in &self.nodes {
            nodes.extend([node.seen, node.hides].map(u64::to_le_bytes).concat());
            nodes.extend([node.layers, node.path.len() as u32].map(u32::to_le_bytes).concat());
            nodes.extend(node.path.as_bytes());
        }
        let sets = self.sets.to_bytes();
        write_chunks(&[(HEAD, &head), (BOXES, &boxes), (SETS, &sets), (NODES, &nodes)])
    }

    /// Reads such bytes.
    ///
    /// # Errors
    /// If they are damaged, of another version, or contradict themselves.
    pub(crate) fn from_bytes(bytes: &[u8]) -> Result<Self, BytesError> {
        let file = Container::open(bytes)?;
        let head = file.chunk(HEAD)?;
        let version = head.first_chunk().map_or(0, |v| u32::from_le_bytes(*v));
        if version != VERSION {
            return Err(BytesError::Version(version));
        }
        let ([head], []) = head.as_chunks::<24>() else {
            return Err(BytesError::Odd("its head is of another size"));
        };
        let method = Method::of(i64::from(word(head, 4)));
        let method = method.ok_or(BytesError::Odd("it was found in a way that is not known"))?;
        let missing = [8, 16].map(|at| f64::from_bits(long(head, at)));
        let (boxes, []) = file.chunk(BOXES)?.as_chunks::<BOX>() else {
            return Err(BytesError::Odd("bytes are left behind the last box"));
        };
        let corner =
            |b: &[u8; BOX], at: usize| std::array::from_fn(|a| f64::from_bits(long(b, at + a * 8)));
        let boxes: Vec<(u32, Region)> =
            boxes.iter().map(|b| (word(b, 0), [corner(b, 8), corner(b, 32)])).collect();
        let sets = VisibleSets::from_bytes(file.chunk(SETS)?)?.into_owned();
        let nodes = nodes_of(file.chunk(NODES)?)?;
        let fits = sets.targets() == Targets::Instances
            && sets.target_count() as usize == nodes.len()
            && boxes.iter().all(|(cell, _)| *cell < sets.cell_count());
        if !fits {
            return Err(BytesError::Odd("it has not a set for each cell, or not of its nodes"));
        }
        let baked = Self { method, missing, boxes, sets, nodes };
        baked.shapes()?;
        Ok(baked)
    }

    /// Returns where the cells are.
    pub(crate) fn shapes(&self) -> Result<CellShapes, CellError> {
        let graph = CellGraph::new(self.sets.cell_count(), Vec::new())?;
        let piece = |(cell, [low, high]): &(u32, Region)| CellPiece::from_box(*cell, *low, *high);
        CellShapes::new(&graph, self.boxes.iter().map(piece).collect())
    }

    /// Returns the combinations of layers that the nodes have that hide others.
    pub(crate) fn layers(&self) -> Vec<u32> {
        let hiding = self.nodes.iter().filter(|node| node.hides != 0);
        let mut layers: Vec<u32> = hiding.map(|node| node.layers).collect();
        layers.sort_unstable();
        layers.dedup();
        layers
    }
}

fn nodes_of(mut bytes: &[u8]) -> Result<Vec<Named>, BytesError> {
    let mut nodes = Vec::new();
    while !bytes.is_empty() {
        let cut = BytesError::Odd("its list of nodes is cut short");
        let (head, rest) = bytes.split_first_chunk::<NODE>().ok_or(cut.clone())?;
        let (path, rest) = rest.split_at_checked(word(head, 20) as usize).ok_or(cut)?;
        let path = String::from_utf8(path.to_vec());
        let path = path.map_err(|_| BytesError::Odd("the path of a node is no text"))?;
        nodes.push(Named {
            path,
            seen: long(head, 0),
            hides: long(head, 8),
            layers: word(head, 16),
        });
        bytes = rest;
    }
    Ok(nodes)
}

/// Returns the number at a place; 0 where there is none.
fn word(bytes: &[u8], at: usize) -> u32 {
    bytes.get(at..).and_then(|b| b.first_chunk()).map_or(0, |b| u32::from_le_bytes(*b))
}

fn long(bytes: &[u8], at: usize) -> u64 {
    bytes.get(at..).and_then(|b| b.first_chunk()).map_or(0, |b| u64::from_le_bytes(*b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sets() -> Baked {
        let rows = [[0b01_u64], [0b11]];
        let node = |path: &str, hides| Named { path: path.into(), seen: 7, hides, layers: 1 };
        Baked {
            method: Method::Sampled,
            missing: [0.25, 0.5],
            boxes: vec![(0, [[0.0; 3], [1.0; 3]]), (1, [[1.0, 0.0, 0.0], [2.0, 1.0, 1.0]])],
            sets: VisibleSets::from_rows(Targets::Instances, 2, rows.iter().map(|r| &r[..])),
            nodes: vec![node("a/ä", 0), node("b", 9)],
        }
    }

    #[test]
    fn what_is_written_is_read_and_no_damage_is() {
        let sets = sets();
        let bytes = sets.to_bytes();
        assert_eq!(Baked::from_bytes(&bytes), Ok(sets));
        for at in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] ^= 0x40;
            // Zeros between chunks belong to no number, and are checked where they end one.
            let read = Baked::from_bytes(&damaged);
            assert!(read.is_err() || read == Baked::from_bytes(&bytes), "byte {at}");
            assert!(Baked::from_bytes(&bytes[..at]).is_err(), "{at} bytes");
        }
    }

    #[test]
    fn a_set_of_other_nodes_is_refused() {
        let mut sets = sets();
        sets.nodes.pop();
        assert!(Baked::from_bytes(&sets.to_bytes()).is_err());
    }
}
