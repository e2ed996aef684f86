//! Tiles that can be seen from each place: boxes, and a row of bits for each.

use cullet_cells::cell::{CellGraph, CellLocator, CellPiece, CellShapes};
use cullet_cells::pvs::{Targets, VisibleSets};

use cullet_io::ErrorKind;
use cullet_io::baked::hash;

/// First bytes of the file.
const MAGIC: &[u8; 8] = b"CLTSIGHT";
/// Bytes before the boxes: those, the sum of all that follows, how many boxes.
const HEAD: usize = 24;
/// Bytes of a box.
const BOX: usize = 48;

/// The name of the file beside a `tileset.json`.
pub(super) const FILE: &str = "sight.bin";

/// Visible sets of a scene: view cells as boxes in the world, low and high corner, and for each a
/// set of instances by the indices of their handles.
#[derive(Clone, Copy, Debug)]
pub struct TileSets<'a> {
    /// The cells.
    pub cells: &'a [[[f64; 3]; 2]],
    /// The sets; of instances, as many as there are cells. Instances beyond the end are in all of
    /// them.
    pub sets: &'a VisibleSets<'a>,
}

/// Tiles that can be seen from each place, as [`write_tiles_with`](super::write_tiles_with) wrote
/// them. It is as right as the sets that it was made of: use it to decide what to load first, never
/// to leave anything out.
#[derive(Clone, Debug)]
pub struct TileSight {
    place: CellShapes,
    tiles: VisibleSets<'static>,
}

impl TileSight {
    /// The cell of a point of the scene; `None` where it is in none.
    #[must_use]
    pub fn cell_of(&self, point: [f64; 3]) -> Option<u32> {
        self.place.cell_of(point)
    }

    /// Whether anything of a tile, or of those below it, can be seen from a cell, by the
    /// [number](super::TileNode::number) of the tile.
    #[must_use]
    pub fn sees(&self, cell: u32, number: u32) -> bool {
        self.tiles.sees(cell, number)
    }

    /// How many cells there are.
    #[must_use]
    pub fn cell_count(&self) -> u32 {
        self.tiles.cell_count()
    }

    /// Bytes that it takes in memory, near enough.
    #[must_use]
    pub fn size(&self) -> usize {
        // A piece of a cell has six planes, and boxes in a tree.
        self.tiles.size() + self.cell_count() as usize * 512
    }

    /// Reads sights from the bytes of a file.
    ///
    /// # Errors
    /// If they are cut short or were changed, or are no boxes and rows.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ErrorKind> {
        let invalid = |message: String| ErrorKind::invalid("cells", message);
        let (head, rest) = bytes
            .split_first_chunk::<HEAD>()
            .filter(|(head, _)| head.starts_with(MAGIC))
            .ok_or_else(|| invalid("they do not begin as those of a tileset do".to_owned()))?;
        let word = |k: usize| u64::from_le_bytes(std::array::from_fn(|i| head[k * 8 + i]));
        let (sum, count) = (word(1), word(2));
        let found = hash(&bytes[16..]);
        if found != sum {
            return Err(invalid(format!(
                "they have the sum {found:016x}, not {sum:016x}: they are damaged; write the tileset again"
            )));
        }
        let size = usize::try_from(count).ok().and_then(|n| n.checked_mul(BOX));
        let (boxes, sets) = size.and_then(|size| rest.split_at_checked(size)).ok_or_else(|| {
            invalid(format!("{count} boxes are more than its {} bytes", bytes.len()))
        })?;
        let corner = |of: &[u8; BOX], k: usize| -> [f64; 3] {
            std::array::from_fn(|a| {
                f64::from_le_bytes(std::array::from_fn(|i| of[(k * 3 + a) * 8 + i]))
            })
        };
        let tiles = VisibleSets::from_bytes(sets).map_err(|e| invalid(e.to_string()))?.into_owned();
        if u64::from(tiles.cell_count()) != count || tiles.targets() != Targets::Instances {
            return Err(invalid(format!("they have not a row of tiles for each of {count} boxes")));
        }
        let graph = CellGraph::new(tiles.cell_count(), Vec::new());
        let graph = graph.map_err(|e| invalid(e.to_string()))?;
        let boxes = (0..).zip(boxes.as_chunks::<BOX>().0);
        let pieces = boxes
            .map(|(cell, of)| CellPiece::from_box(cell, corner(of, 0), corner(of, 1)))
            .collect();
        let place = CellShapes::new(&graph, pieces).map_err(|e| invalid(e.to_string()))?;
        Ok(Self { place, tiles })
    }
}

/// Tiles as they are written: whose children they are, and which instances they have.
#[derive(Debug, Default)]
pub(super) struct Numbered {
    /// Number of the tile above each tile, lower than its own; the root's is its own.
    pub(super) above: Vec<u32>,
    /// Indices of the handles of instances, and the number of the tile that each is in.
    pub(super) instances: Vec<(u32, u32)>,
}

/// The bytes of a file: magic, the sum of all that follows, how many boxes; the boxes, six f64
/// each; then sets of tiles. A tile is in a set if an instance of it or below it is.
pub(super) fn to_bytes(sets: &TileSets<'_>, tiles: &Numbered) -> Vec<u8> {
    let count = tiles.above.len();
    let most = tiles.instances.iter().map(|&(index, _)| index as usize + 1).max().unwrap_or(0);
    let mut tile_of: Vec<Option<u32>> = vec![None; most];
    let mut always = Vec::new();
    for &(index, tile) in &tiles.instances {
        tile_of[index as usize] = Some(tile);
        if index >= sets.sets.target_count() {
            always.push(tile);
        }
    }
    let row = |cell: u32| {
        let mut is_in = vec![false; count];
        let seen = sets.sets.seen_from(cell);
        let seen = seen.filter_map(|index| tile_of.get(index as usize).copied().flatten());
        seen.chain(always.iter().copied()).for_each(|tile| is_in[tile as usize] = true);
        // Those below come after those above them.
        for tile in (0..count).rev().filter(|&tile| is_in[tile]).collect::<Vec<_>>() {
            let mut at = tile;
            while !std::mem::replace(&mut is_in[tiles.above[at] as usize], true) {
                at = tiles.above[at] as usize;
            }
        }
        let mut words = vec![0_u64; count.div_ceil(64)];
        for tile in (0..count).filter(|&tile| is_in[tile]) {
            words[tile / 64] |= 1 << (tile % 64);
        }
        words
    };
    let rows: Vec<Vec<u64>> = (0..sets.sets.cell_count()).map(row).collect();
    let rows = rows.iter().map(Vec::as_slice);
    let seen = VisibleSets::from_rows(Targets::Instances, count as u32, rows);
    let mut rest = (sets.cells.len() as u64).to_le_bytes().to_vec();
    rest.extend(sets.cells.iter().flatten().flatten().flat_map(|v| v.to_le_bytes()));
    rest.extend(seen.to_bytes());
    [&MAGIC[..], &hash(&rest).to_le_bytes(), &rest].concat()
}
