//! Quake 3: `IBSP` 46.

use super::entities;
use super::lumps::{Lumps, Records, Shared, float, floats, int, unsigned};
use super::map::{BrushModel, Bsp, Contents, Leaf, Texture};
use super::patch;
use super::quake::{positions, text};
use super::surfaces::{Kind, Surface, Surfaces, area, middle};
use super::tree::{self, Child, Node, Tree};
use super::visibility::Visibility;
use cullet_io::ErrorKind;
use cullet_io::reader::Welder;

/// Bytes of the records.
const TEXTURE: usize = 72;
const PLANE: usize = 16;
const NODE: usize = 36;
const LEAF: usize = 48;
const MODEL: usize = 40;
const VERTEX: usize = 44;
const FACE: usize = 104;

/// Flags of a texture's surfaces.
mod surface {
    pub(super) const SKY: u32 = 0x4;
    /// Not drawn: caulk, triggers and the like.
    pub(super) const NO_DRAW: u32 = 0x80;
    /// Without light of the map's own: the sky, and what a shader animates.
    pub(super) const NO_LIGHTMAP: u32 = 0x400;
    pub(super) const NON_SOLID: u32 = 0x4000;
    /// Its shadow is cut out by its alpha channel: a fence, a grate.
    pub(super) const ALPHA_SHADOW: u32 = 0x10000;
}

/// Flags of a texture's contents.
mod contents {
    pub(super) const SOLID: u32 = 0x1;
    /// Lava, slime, water.
    pub(super) const LIQUID: u32 = 0x8 | 0x10 | 0x20;
    pub(super) const FOG: u32 = 0x40;
    pub(super) const TRANSLUCENT: u32 = 0x2000_0000;
}

/// All but the geometry.
pub(crate) fn parse(lumps: &Lumps<'_>) -> Result<Bsp, ErrorKind> {
    let faces = lumps.lump("faces").records(FACE)?;
    let leafs = lumps.lump("leafs").records(LEAF)?;
    let nodes = lumps.lump("nodes").records(NODE)?;
    let planes = tree::planes(lumps.lump("planes").records(PLANE)?)?;
    let models =
        read_models(lumps.lump("models").records(MODEL)?, faces.len(), 24, |_| Child::Node(0))?;

    let node = |record: &[u8]| Node {
        plane: unsigned(record, 0),
        children: [4, 8].map(|at| Child::of(i64::from(int(record, at)))),
    };
    let nodes: Vec<Node> = nodes.iter().map(node).collect();
    let tree = Tree::new(planes, nodes, leafs.len(), &[Child::Node(0)])?;

    let marks = lumps.lump("leaffaces").records(4)?;
    let mark = |(number, record): (usize, &[u8])| match unsigned(record, 0) {
        face if (face as usize) < faces.len() => Ok(face),
        face => Err(marks.invalid(number, format!("it names face {face}, of {}", faces.len()))),
    };
    let listed = marks.iter().enumerate().map(mark).collect::<Result<Vec<u32>, _>>()?;
    let (leafs, cell_count) = read_leafs(leafs, listed.len(), raw_leaf)?;
    let visibility = match lumps.lump("visibility").bytes {
        [] => None,
        bytes => Some(Visibility::rows(bytes, cell_count as usize)?),
    };
    let texture = |record: &[u8]| Texture {
        name: text(&record[..64]),
        flags: [64, 68].map(|at| unsigned(record, at)),
    };
    Ok(Bsp {
        version: lumps.version,
        entities: entities::parse(lumps.lump("entities").bytes)?,
        textures: lumps.lump("textures").records(TEXTURE)?.iter().map(texture).collect(),
        tree,
        leafs,
        models,
        listed,
        cell_count,
        visibility,
    })
}

/// The world and the brush models; a record has its faces, two numbers, at `at`.
pub(crate) fn read_models(
    records: Records<'_>,
    faces: usize,
    at: usize,
    root: impl Fn(&[u8]) -> Child,
) -> Result<Vec<BrushModel>, ErrorKind> {
    let mut shared = Shared::new("faces", faces);
    let model = |(number, record): (usize, &[u8])| {
        let [first, count] = [at, at + 4].map(|o| i64::from(int(record, o)));
        let surfaces = shared.range(first, count, faces).map_err(|m| records.invalid(number, m))?;
        let bounds = [0, 12].map(|o| floats(record, o).map(f64::from));
        Ok(BrushModel { bounds, root: root(record), surfaces })
    };
    let models = records.iter().enumerate().map(model).collect::<Result<Vec<_>, ErrorKind>>()?;
    if models.is_empty() {
        return Err(ErrorKind::invalid("lump models", "it has none, but the world is the first"));
    }
    Ok(models)
}

/// A leaf as a record has it: its cluster, or −1, its contents, its bounds, and the first and the
/// number of its marks.
pub(crate) type RawLeaf = (i32, Contents, [[f64; 3]; 2], [i64; 2]);

/// The leafs, and how many clusters there are. A cluster has a leaf of its own at least.
pub(crate) fn read_leafs(
    records: Records<'_>,
    marks: usize,
    raw: impl Fn(&[u8]) -> RawLeaf,
) -> Result<(Vec<Leaf>, u32), ErrorKind> {
    let mut shared = Shared::new("leaffaces", marks);
    let mut clusters = 0;
    let leaf = |(number, record): (usize, &[u8])| {
        let at = |message| records.invalid(number, message);
        let (cluster, contents, bounds, [first, count]) = raw(record);
        let cell = u32::try_from(cluster).ok();
        if cluster < -1 || cell.is_some_and(|c| c as usize >= records.len()) {
            let message = format!("it is in cluster {cluster}, of at most {}", records.len());
            return Err(at(message));
        }
        clusters = clusters.max(cell.map_or(0, |c| c + 1));
        let surfaces = shared.range(first, count, marks).map_err(at)?;
        let contents = if cell.is_some() { contents } else { Contents::Solid };
        Ok(Leaf { contents, bounds, cell, surfaces })
    };
    let leafs = records.iter().enumerate().map(leaf).collect::<Result<Vec<_>, ErrorKind>>()?;
    Ok((leafs, clusters))
}

fn raw_leaf(record: &[u8]) -> RawLeaf {
    let corner = |at: usize| [0, 4, 8].map(|o| f64::from(int(record, at + o)));
    let listed = [32, 36].map(|o| i64::from(int(record, o)));
    (int(record, 0), Contents::Open, [corner(8), corner(20)], listed)
}

/// Faces of these types have triangles of their own; a patch is curved, a billboard is the glare of
/// a lamp.
const POLYGON: i32 = 1;
const PATCH: i32 = 2;
const MESH: i32 = 3;
const BILLBOARD: i32 = 4;

/// The geometry of a map.
pub(crate) fn surfaces(lumps: &Lumps<'_>, map: &Bsp) -> Result<Surfaces, ErrorKind> {
    let vertices = lumps.lump("vertices").records(VERTEX)?;
    let corners = positions(vertices, 0)?;
    let meshverts = lumps.lump("meshverts").records(4)?;
    let faces = lumps.lump("faces").records(FACE)?;
    let mut shared =
        (Shared::new("vertices", vertices.len()), Shared::new("meshverts", meshverts.len()));
    // Each face has vertices of its own in the file; joined, edges are shared.
    let mut welder = Welder::new();
    let mut out = Surfaces::default();
    let (mut odd, mut billboards) = (0, 0);
    for (number, record) in faces.iter().enumerate() {
        let at = |message| faces.invalid(number, message);
        let [texture, kind, first, count, first_mesh, mesh_count] =
            [0, 8, 12, 16, 20, 24].map(|o| int(record, o));
        let Some(info) = usize::try_from(texture).ok().and_then(|t| map.textures.get(t)) else {
            return Err(at(format!("it names texture {texture}, of {}", map.textures.len())));
        };
        let range = shared.0.range(first.into(), count.into(), vertices.len()).map_err(at)?;
        let own = &corners[range.clone()];
        let start = out.indices.len();
        match kind {
            POLYGON | MESH => {
                let range = shared
                    .1
                    .range(first_mesh.into(), mesh_count.into(), meshverts.len())
                    .map_err(at)?;
                let welded: Vec<u32> = own.iter().map(|p| welder.weld(*p)).collect();
                for number in range {
                    let offset = meshverts.get(number).map_or(0, |r| int(r, 0));
                    let vertex = usize::try_from(offset).ok().and_then(|o| welded.get(o));
                    let Some(vertex) = vertex else {
                        let message =
                            format!("it names vertex {offset} of a face that has {}", own.len());
                        return Err(meshverts.invalid(number, message));
                    };
                    out.indices.push(*vertex);
                }
                // What is over is no triangle.
                odd += u64::from(!(out.indices.len() - start).is_multiple_of(3));
                out.indices.truncate(out.indices.len() - (out.indices.len() - start) % 3);
            }
            PATCH => {
                let size = [96, 100].map(|o| int(record, o));
                let net = patch::Net::new(own, size).map_err(at)?;
                net.triangulate(&mut welder, &mut out.indices);
            }
            BILLBOARD => billboards += 1,
            _ => return Err(at(format!("it is of type {kind}; known are 1 to 4"))),
        }
        let [flags, contents] = info.flags;
        if kind == BILLBOARD || flags & surface::NO_DRAW != 0 {
            out.indices.truncate(start);
            out.list.push(None);
            continue;
        }
        let what = of_flags(flags, contents);
        let normals = vertices_normals(vertices, range);
        turn(&mut out.indices[start..], normals, &welder);
        // Which shaders are drawn from both sides, the map does not say: only of brushes is it
        // known that nobody looks at the back.
        let brush = kind == POLYGON && contents & contents::SOLID != 0 && what == Kind::Wall;
        out.list.push(Some(Surface {
            texture: texture.unsigned_abs(),
            kind: what,
            two_sided: !(brush || what == Kind::Sky),
            centre: middle(own.iter().copied()),
            normal: normals.normalize_or_zero().into(),
            indices: start..out.indices.len(),
        }));
    }
    out.positions = welder.into_positions();
    out.notes = vec![
        (odd, "faces whose corners make no whole triangles lose those that are over"),
        (billboards, "billboards (flares of lamps), which turn to the eye, are left out"),
    ];
    Ok(out)
}

fn of_flags(flags: u32, contents: u32) -> Kind {
    if flags & surface::SKY != 0 {
        Kind::Sky
    } else if contents & contents::LIQUID != 0 {
        Kind::Liquid
    } else if flags & surface::ALPHA_SHADOW != 0 {
        Kind::Fence
    } else if contents & (contents::TRANSLUCENT | contents::FOG) != 0
        || flags & (surface::NON_SOLID | surface::NO_LIGHTMAP) != 0
    {
        // Flames and beams have the contents of walls, but no lightmap.
        Kind::Effect
    } else {
        Kind::Wall
    }
}

/// Sum of the normals of vertices; those that are not finite count as none.
fn vertices_normals(vertices: Records<'_>, range: std::ops::Range<usize>) -> glam::DVec3 {
    let normal = |v: usize| vertices.get(v).map_or([0.0; 3], |r| [28, 32, 36].map(|o| float(r, o)));
    let normals = range.map(|v| glam::DVec3::from(normal(v).map(f64::from)));
    normals.filter(|n| n.is_finite()).sum()
}

/// Turns triangles so that they go round counter-clockwise about the normal: Quake 3 goes round
/// clockwise.
fn turn(indices: &mut [u32], normal: glam::DVec3, welder: &Welder) {
    let triangles = indices.as_chunks_mut::<3>().0;
    let sum = triangles
        .iter()
        .fold(glam::DVec3::ZERO, |sum, t| sum + area(&t.map(|v| welder.position(v))));
    if sum.dot(normal) < 0.0 {
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
}
