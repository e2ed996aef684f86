//! Quake: version 29, BSP2 with the same lumps in 32-bit numbers, and Half-Life's version 30.

use std::collections::HashMap;

use cullet::bounds::Plane;

use super::entities;
use super::lumps::{
    Lump, Lumps, Records, Shared, Version, floats, int, short, unsigned, unsigned_short,
};
use super::map::{BrushModel, Bsp, Contents, Leaf, Texture};
use super::surfaces::{Kind, Surface, Surfaces, area, middle};
use super::tree::{self, Child, Node, Tree};
use super::visibility::Visibility;
use cullet_io::ErrorKind;
use cullet_io::reader::Triangulator;

/// Bytes of a plane, a texinfo and a model, which both versions share.
pub(crate) const PLANE: usize = 20;
const TEXINFO: usize = 40;
const MODEL: usize = 64;

/// Sizes of records that differ.
struct Layout {
    wide: bool,
    node: usize,
    leaf: usize,
    face: usize,
    edge: usize,
    mark: usize,
}

const NARROW: Layout = Layout { wide: false, node: 24, leaf: 28, face: 20, edge: 4, mark: 2 };
const WIDE: Layout = Layout { wide: true, node: 44, leaf: 44, face: 28, edge: 8, mark: 4 };

fn layout(version: Version) -> &'static Layout {
    if version == Version::Bsp2 { &WIDE } else { &NARROW }
}

/// Where in a leaf's record it says where its row of visibility is.
pub(crate) const ROW_OF_LEAF: usize = 4;

/// Bytes of a leaf's record.
pub(crate) fn leaf_size(version: Version) -> usize {
    layout(version).leaf
}

/// All but the geometry.
pub(crate) fn parse(lumps: &Lumps<'_>) -> Result<Bsp, ErrorKind> {
    let Layout { wide, node, leaf, face, .. } = *layout(lumps.version);
    let nodes = lumps.lump("nodes").records(node)?;
    let leaf_records = lumps.lump("leafs").records(leaf)?;
    let faces = lumps.lump("faces").records(face)?;
    let models = lumps.lump("models").records(MODEL)?;
    let planes = tree::planes(lumps.lump("planes").records(PLANE)?)?;

    let (models, visible) = read_models(models, faces.len())?;
    if visible >= leaf_records.len().max(1) {
        let message = format!(
            "{visible} leafs in visibility, of {} leafs without the first",
            leaf_records.len().saturating_sub(1)
        );
        return Err(super::lumps::invalid("models", 0, message));
    }
    let count = nodes.len();
    let node = |record: &[u8]| {
        let child = |side: usize| {
            if wide {
                return Child::of(i64::from(int(record, 4 + 4 * side)));
            }
            // Nodes take all of 16 bits that leafs leave them.
            let number = unsigned_short(record, 4 + 2 * side);
            if usize::from(number) < count {
                Child::Node(u32::from(number))
            } else {
                Child::Leaf(u32::from(u16::MAX - number))
            }
        };
        Node { plane: unsigned(record, 0), children: [child(0), child(1)] }
    };
    let roots: Vec<Child> = models.iter().map(|m| m.root).collect();
    let nodes: Vec<Node> = nodes.iter().map(node).collect();
    let tree = Tree::new(planes, nodes, leaf_records.len(), &roots)?;

    let listed = read_marks(lumps, faces.len())?;
    let visibility = lumps.lump("visibility");
    let mut leafs = read_leafs(leaf_records, wide, listed.len())?;
    let (cell_count, offsets) = cells(&mut leafs, leaf_records, visible, visibility)?;
    let visibility = match visibility.bytes {
        [] => None,
        bytes => Some(Visibility::runs(bytes, offsets, visible)?),
    };
    Ok(Bsp {
        version: lumps.version,
        entities: entities::parse(lumps.lump("entities").bytes)?,
        textures: read_textures(lumps.lump("textures"))?,
        tree,
        leafs,
        models,
        listed,
        cell_count,
        visibility,
    })
}

/// The models, and how many leafs of the world have a place in visibility.
fn read_models(records: Records<'_>, faces: usize) -> Result<(Vec<BrushModel>, usize), ErrorKind> {
    let mut shared = Shared::new("faces", faces);
    let model = |(number, record): (usize, &[u8])| {
        let at = |message| records.invalid(number, message);
        let [first, count] = [56, 60].map(|o| i64::from(int(record, o)));
        let surfaces = shared.range(first, count, faces).map_err(at)?;
        let bounds = [0, 12].map(|o| floats(record, o).map(f64::from));
        Ok(BrushModel { bounds, root: Child::of(i64::from(int(record, 36))), surfaces })
    };
    let models = records.iter().enumerate().map(model).collect::<Result<Vec<_>, ErrorKind>>()?;
    let Some(world) = records.get(0) else {
        return Err(ErrorKind::invalid("lump models", "it has none, but the world is the first"));
    };
    let visible = int(world, 52);
    let visible = usize::try_from(visible)
        .map_err(|_| records.invalid(0, format!("{visible} leafs in visibility")))?;
    Ok((models, visible))
}

fn read_marks(lumps: &Lumps<'_>, faces: usize) -> Result<Vec<u32>, ErrorKind> {
    let layout = layout(lumps.version);
    let records = lumps.lump("marksurfaces").records(layout.mark)?;
    let mark = |(number, record): (usize, &[u8])| {
        let face =
            if layout.wide { unsigned(record, 0) } else { u32::from(unsigned_short(record, 0)) };
        if face as usize >= faces {
            return Err(records.invalid(number, format!("it names face {face}, of {faces}")));
        }
        Ok(face)
    };
    records.iter().enumerate().map(mark).collect()
}

/// The leafs, yet without cells.
fn read_leafs(records: Records<'_>, wide: bool, marks: usize) -> Result<Vec<Leaf>, ErrorKind> {
    let mut shared = Shared::new("marksurfaces", marks);
    let leaf = |(number, record): (usize, &[u8])| {
        let contents = match int(record, 0) {
            -1 => Contents::Open,
            -5..=-3 => Contents::Liquid,
            -6 => Contents::Sky,
            // What is -7 or below is left over from compiling (clip, currents): currents are water.
            -14..=-9 => Contents::Liquid,
            // Translucent, in Half-Life.
            -15 => Contents::Open,
            _ => Contents::Solid,
        };
        let corner = |i: usize| -> [f64; 3] {
            match wide {
                true => floats(record, 8 + 12 * i).map(f64::from),
                false => [0, 1, 2].map(|a| f64::from(short(record, 8 + 6 * i + 2 * a))),
            }
        };
        let [first, count] = match wide {
            true => [32, 36].map(|o| i64::from(unsigned(record, o))),
            false => [20, 22].map(|o| i64::from(unsigned_short(record, o))),
        };
        let surfaces = shared.range(first, count, marks).map_err(|m| records.invalid(number, m))?;
        Ok(Leaf { contents, bounds: [corner(0), corner(1)], cell: None, surfaces })
    };
    records.iter().enumerate().map(leaf).collect()
}

/// Gives the leafs of visibility their cells, numbered in the order of the first leaf of each:
/// leafs of one row are one cell. How many there are, and where the row of each begins.
fn cells(
    leafs: &mut [Leaf],
    records: Records<'_>,
    visible: usize,
    visibility: Lump<'_>,
) -> Result<(u32, Vec<Option<u32>>), ErrorKind> {
    let mut cell_of = HashMap::new();
    let mut offsets: Vec<Option<u32>> = Vec::new();
    let size = visibility.bytes.len();
    for (number, record) in records.iter().enumerate().skip(1).take(visible) {
        // Where nothing is stored, an offset says nothing.
        let offset = if size == 0 { -1 } else { int(record, ROW_OF_LEAF) };
        if offset < -1 || offset >= 0 && offset as usize >= size {
            let message =
                format!("its row is at byte {offset} of lump visibility, which has {size}");
            return Err(records.invalid(number, message));
        }
        let next = offsets.len() as u32;
        let cell = match u32::try_from(offset) {
            Ok(offset) => *cell_of.entry(offset).or_insert(next),
            Err(_) => next,
        };
        if cell == next {
            offsets.push(u32::try_from(offset).ok());
        }
        leafs[number].cell = Some(cell);
    }
    Ok((offsets.len() as u32, offsets))
}

/// Names of the textures. Where a map has none, or was stripped of them, they are empty.
fn read_textures(lump: Lump<'_>) -> Result<Vec<Texture>, ErrorKind> {
    let none = || Texture { name: String::new(), flags: [0; 2] };
    if lump.bytes.is_empty() {
        return Ok(Vec::new());
    }
    let count = int(lump.bytes, 0);
    let room = lump.bytes.len() / 4;
    let names = usize::try_from(count).ok().filter(|c| *c < room.max(1));
    let Some(count) = names else {
        let message = format!("{count} textures; its {} bytes hold fewer", lump.bytes.len());
        return Err(ErrorKind::invalid("lump textures", message));
    };
    let texture = |number: usize| {
        let offset = int(lump.bytes, 4 + 4 * number);
        if offset == -1 {
            return Ok(none());
        }
        let name = usize::try_from(offset).ok().and_then(|o| lump.bytes.get(o..)?.get(..16));
        let Some(name) = name else {
            let message = format!("it is at byte {offset}, of {} bytes", lump.bytes.len());
            return Err(lump.invalid(number, message));
        };
        Ok(Texture { name: text(name), ..none() })
    };
    (0..count).map(texture).collect()
}

/// A name up to its first zero byte.
pub(crate) fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|b| *b == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}

/// The geometry of a map.
pub(crate) fn surfaces(lumps: &Lumps<'_>, map: &Bsp) -> Result<Surfaces, ErrorKind> {
    let texinfos = lumps.lump("texinfo").records(TEXINFO)?;
    polygons(lumps, texinfos, |_, info, plane, centre| {
        let texture = unsigned(info, 32);
        Some((texture, kind(map, texture, plane, centre)))
    })
}

/// The faces of a map of Quake's kind as surfaces. `judge` gives the texture and the kind of a face
/// by the number and the record of its texinfo, its plane and its middle; `None` if it is not drawn.
pub(crate) fn polygons(
    lumps: &Lumps<'_>,
    texinfos: Records<'_>,
    judge: impl Fn(usize, &[u8], &Plane, [f64; 3]) -> Option<(u32, Kind)>,
) -> Result<Surfaces, ErrorKind> {
    let Layout { wide, face, edge, .. } = *layout(lumps.version);
    let vertices = lumps.lump("vertices").records(12)?;
    let edges = lumps.lump("edges").records(edge)?;
    let surfedges = lumps.lump("surfedges").records(4)?;
    let planes = tree::planes(lumps.lump("planes").records(PLANE)?)?;
    let faces = lumps.lump("faces").records(face)?;

    let positions = positions(vertices, 0)?;
    let corner = |number: usize| -> Result<u32, ErrorKind> {
        let surfedge = surfedges.get(number).map_or(0, |r| int(r, 0));
        let Some(edge) = edges.get(surfedge.unsigned_abs() as usize) else {
            let message = format!("it names edge {surfedge}, of {}", edges.len());
            return Err(surfedges.invalid(number, message));
        };
        let end = usize::from(surfedge < 0);
        let vertex =
            if wide { unsigned(edge, 4 * end) } else { u32::from(unsigned_short(edge, 2 * end)) };
        if vertex as usize >= positions.len() {
            let message = format!("it names vertex {vertex}, of {}", positions.len());
            return Err(edges.invalid(surfedge.unsigned_abs() as usize, message));
        }
        Ok(vertex)
    };
    let mut shared = Shared::new("surfedges", surfedges.len());
    let mut triangulator = Triangulator::default();
    let mut indices = Vec::new();
    let mut list = Vec::with_capacity(faces.len());
    let mut few = 0;
    for (number, record) in faces.iter().enumerate() {
        let at = |message| faces.invalid(number, message);
        let [plane, back, first, count, texinfo] = if wide {
            [0, 4, 8, 12, 16].map(|o| i64::from(int(record, o)))
        } else {
            let word = |o| i64::from(unsigned_short(record, o));
            [word(0), word(2), i64::from(int(record, 4)), word(8), word(10)]
        };
        let Some(plane) = usize::try_from(plane).ok().and_then(|p| planes.get(p)) else {
            return Err(at(format!("it names plane {plane}, of {}", planes.len())));
        };
        let Some(info) = usize::try_from(texinfo).ok().and_then(|t| texinfos.get(t)) else {
            return Err(at(format!("it names texinfo {texinfo}, of {}", texinfos.len())));
        };
        let range = shared.range(first, count, surfedges.len()).map_err(at)?;
        let mut polygon = range.map(corner).collect::<Result<Vec<u32>, _>>()?;
        if polygon.len() < 3 {
            few += 1;
            list.push(None);
            continue;
        }
        let plane = if back == 0 { *plane } else { tree::opposite(plane) };
        let corners: Vec<[f32; 3]> = polygon.iter().map(|v| positions[*v as usize]).collect();
        // Quake goes round clockwise.
        if area(&corners).dot(plane.normal.into()) < 0.0 {
            polygon.reverse();
        }
        turn_to_best(&mut polygon, &positions);
        let start = indices.len();
        triangulator.push(&polygon, &positions, &mut indices);
        let centre = middle(corners.into_iter());
        let judged = judge(texinfo as usize, info, &plane, centre);
        if judged.is_none() {
            indices.truncate(start);
        }
        list.push(judged.map(|(texture, kind)| Surface {
            texture,
            kind,
            two_sided: false,
            centre,
            normal: plane.normal,
            indices: start..indices.len(),
        }));
    }
    let notes = vec![(few, "faces of fewer than 3 corners are left out")];
    Ok(Surfaces { positions, indices, list, notes })
}

/// Most corners of a polygon whose best fan is looked for: it takes their square, and the engines
/// allow no more.
const MOST_CORNERS: usize = 64;

/// Turns a polygon so that a fan from its first corner has the least triangle as large as may be:
/// compilers put corners on straight edges, where neighbours have theirs, and a fan from one of
/// those has triangles without area.
fn turn_to_best(polygon: &mut [u32], positions: &[[f32; 3]]) {
    let count = polygon.len();
    if !(4..=MOST_CORNERS).contains(&count) {
        return;
    }
    let at = |i: usize| positions[polygon[i % count] as usize];
    let least = |first: usize| {
        (1..count - 1)
            .map(|k| area(&[at(first), at(first + k), at(first + k + 1)]).length_squared())
            .fold(f64::INFINITY, f64::min)
    };
    let areas: Vec<f64> = (0..count).map(least).collect();
    let best = (0..count).fold(0, |best, i| if areas[i] > areas[best] { i } else { best });
    polygon.rotate_left(best);
}

/// Positions, at `offset` in each record.
pub(crate) fn positions(records: Records<'_>, offset: usize) -> Result<Vec<[f32; 3]>, ErrorKind> {
    let position = |(number, record): (usize, &[u8])| {
        let p = floats(record, offset);
        match p.iter().all(|v| v.is_finite()) {
            true => Ok(p),
            false => Err(records.invalid(number, format!("not finite: {p:?}"))),
        }
    };
    records.iter().enumerate().map(position).collect()
}

/// Kind of a surface: by the name of its texture as the engine tells it, or, where the map has no
/// names, by what lies before and behind it.
fn kind(map: &Bsp, texture: u32, plane: &Plane, centre: [f64; 3]) -> Kind {
    let name = map.textures.get(texture as usize).map_or("", |t| t.name.as_str());
    if !name.is_empty() {
        return match name.as_bytes() {
            [b'*' | b'!', ..] => Kind::Liquid,
            [b'{', ..] => Kind::Fence,
            _ if name.get(..3).is_some_and(|n| n.eq_ignore_ascii_case("sky")) => Kind::Sky,
            _ => Kind::Wall,
        };
    }
    let off = |distance: f64| -> Contents {
        let point = [0, 1, 2].map(|a| centre[a] + plane.normal[a] * distance);
        map.leafs[map.leaf_at(point) as usize].contents
    };
    match [off(0.5), off(-0.5)] {
        [_, Contents::Sky] => Kind::Sky,
        [Contents::Open, Contents::Liquid] | [Contents::Liquid, Contents::Open] => Kind::Liquid,
        _ => Kind::Wall,
    }
}
