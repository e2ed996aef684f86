//! Quake 2: `IBSP` 38. Faces and planes are those of Quake; leafs have clusters, as in Quake 3.

use std::collections::HashMap;

use super::entities;
use super::lumps::{Lump, Lumps, Records, int, short, unsigned, unsigned_short};
use super::map::{Bsp, Contents, Texture};
use super::quake::{self, PLANE, text};
use super::quake3::{RawLeaf, read_leafs, read_models};
use super::surfaces::{Kind, Surfaces};
use super::tree::{self, Child, Node, Tree};
use super::visibility::Visibility;
use cullet_io::ErrorKind;

/// Bytes of the records.
const NODE: usize = 28;
const LEAF: usize = 28;
const FACE: usize = 20;
const TEXINFO: usize = 76;
const MODEL: usize = 48;

/// Flags of surfaces.
mod surface {
    pub(super) const SKY: u32 = 0x4;
    /// Water, slime or lava.
    pub(super) const WARP: u32 = 0x8;
    /// One sees through a third or two thirds of it.
    pub(super) const TRANSLUCENT: u32 = 0x10 | 0x20;
    /// Not drawn, a hint for the compiler, or skipped by it.
    pub(super) const UNSEEN: u32 = 0x80 | 0x100 | 0x200;
}

/// Contents of leafs.
mod contents {
    pub(super) const SOLID: i32 = 0x1;
    /// Lava, slime, water.
    pub(super) const LIQUID: i32 = 0x8 | 0x10 | 0x20;
}

/// All but the geometry.
pub(crate) fn parse(lumps: &Lumps<'_>) -> Result<Bsp, ErrorKind> {
    let faces = lumps.lump("faces").records(FACE)?.len();
    let nodes = lumps.lump("nodes").records(NODE)?;
    let leafs = lumps.lump("leafs").records(LEAF)?;
    let planes = tree::planes(lumps.lump("planes").records(PLANE)?)?;
    let models = read_models(lumps.lump("models").records(MODEL)?, faces, 40, |record| {
        Child::of(i64::from(int(record, 36)))
    })?;
    let node = |record: &[u8]| Node {
        plane: unsigned(record, 0),
        children: [4, 8].map(|at| Child::of(i64::from(int(record, at)))),
    };
    let roots: Vec<Child> = models.iter().map(|m| m.root).collect();
    let tree = Tree::new(planes, nodes.iter().map(node).collect(), leafs.len(), &roots)?;
    let marks = lumps.lump("leaffaces").records(2)?;
    let mark = |(number, record): (usize, &[u8])| match unsigned_short(record, 0) {
        face if usize::from(face) < faces => Ok(u32::from(face)),
        face => Err(marks.invalid(number, format!("it names face {face}, of {faces}"))),
    };
    let listed = marks.iter().enumerate().map(mark).collect::<Result<Vec<u32>, _>>()?;
    let (leafs, cell_count) = read_leafs(leafs, listed.len(), raw_leaf)?;
    Ok(Bsp {
        version: lumps.version,
        entities: entities::parse(lumps.lump("entities").bytes)?,
        textures: read_textures(lumps.lump("texinfo").records(TEXINFO)?).0,
        tree,
        leafs,
        models,
        listed,
        cell_count,
        visibility: read_visibility(lumps.lump("visibility"), cell_count)?,
    })
}

fn raw_leaf(record: &[u8]) -> RawLeaf {
    let contents = match int(record, 0) {
        c if c & contents::SOLID != 0 => Contents::Solid,
        c if c & contents::LIQUID != 0 => Contents::Liquid,
        _ => Contents::Open,
    };
    let corner = |at: usize| [0, 2, 4].map(|o| f64::from(short(record, at + o)));
    let listed = [20, 22].map(|o| i64::from(unsigned_short(record, o)));
    (i32::from(short(record, 4)), contents, [corner(8), corner(14)], listed)
}

/// Textures by name and flags, and that of each texinfo.
fn read_textures(records: Records<'_>) -> (Vec<Texture>, Vec<u32>) {
    let mut textures = Vec::new();
    let mut number = HashMap::new();
    let of_texinfo = records.iter().map(|record| {
        let texture = Texture { name: text(&record[40..72]), flags: [unsigned(record, 32), 0] };
        *number.entry((texture.name.clone(), texture.flags)).or_insert_with(|| {
            textures.push(texture);
            (textures.len() - 1) as u32
        })
    });
    let of_texinfo = of_texinfo.collect();
    (textures, of_texinfo)
}

/// A count of clusters, for each where its rows begin (seen, then heard), and the rows, zero bytes
/// counted.
fn read_visibility(lump: Lump<'_>, clusters: u32) -> Result<Option<Visibility>, ErrorKind> {
    if lump.bytes.is_empty() {
        return Ok(None);
    }
    let invalid = |message| ErrorKind::invalid("lump visibility", message);
    let count = if lump.bytes.len() < 4 { -1 } else { int(lump.bytes, 0) };
    let room = lump.bytes.len().saturating_sub(4) / 8;
    let Some(count) = usize::try_from(count).ok().filter(|&c| c <= room) else {
        let size = lump.bytes.len();
        return Err(invalid(format!("{count} clusters; its {size} bytes hold at most {room}")));
    };
    if count < clusters as usize {
        return Err(invalid(format!("{count} clusters, but leafs are in {clusters}")));
    }
    let offset = |cluster: u32| {
        let at = int(lump.bytes, 4 + 8 * cluster as usize);
        u32::try_from(at).ok().filter(|&o| (o as usize) < lump.bytes.len()).ok_or_else(|| {
            let size = lump.bytes.len();
            lump.invalid(cluster as usize, format!("its row is at byte {at}, of {size}"))
        })
    };
    let offsets = (0..clusters).map(|c| offset(c).map(Some)).collect::<Result<Vec<_>, _>>()?;
    Visibility::runs(lump.bytes, offsets, count).map(Some)
}

/// The geometry.
pub(crate) fn surfaces(lumps: &Lumps<'_>, map: &Bsp) -> Result<Surfaces, ErrorKind> {
    let texinfos = lumps.lump("texinfo").records(TEXINFO)?;
    let (_, of_texinfo) = read_textures(texinfos);
    quake::polygons(lumps, texinfos, |number, _, _, _| {
        let texture = of_texinfo[number];
        let [flags, _] = map.textures[texture as usize].flags;
        let kind = match flags {
            f if f & surface::UNSEEN != 0 => return None,
            f if f & surface::SKY != 0 => Kind::Sky,
            f if f & surface::WARP != 0 => Kind::Liquid,
            f if f & surface::TRANSLUCENT != 0 => Kind::Effect,
            _ => Kind::Wall,
        };
        Some((texture, kind))
    })
}
