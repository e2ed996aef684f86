//! `CULLET_cells_portals`: cells and portals in the root of a document. What each member means is
//! in the book's page on the format, and in `docs/schema/CULLET_cells_portals.schema.json`.

use std::borrow::Cow;
use std::collections::HashMap;

use cullet::Handle;
use cullet::bounds::Plane;
use cullet_cells::cell::CellError;
use glam::{DAffine3, DVec3};

use super::json::{self, Index, Items, Root};
use crate::cells::{Cell, CellGraph, Mirror, Portal, box_planes, numbers};
use crate::from_json;
use crate::json::{FromJson, Json, Object};
use crate::{ErrorKind, Model};

/// The extension's name.
pub(crate) const NAME: &str = "CULLET_cells_portals";

from_json! {
    struct Extension<'a> {
        cells: Items<'a> = get("cells"),
        portals: Items<'a> = get("portals"),
        mirrors: Items<'a> = get("mirrors"),
        walls: Option<f64> = get("walls"),
        sealed: bool = or_default("sealed"),
    }

    struct CellItem<'a> {
        name: Option<Cow<'a, str>> = get("name"),
        pieces: Vec<PieceItem> = or_default("pieces"),
        skin: Vec<PieceItem> = or_default("skin"),
    }

    struct PieceItem {
        corners: Option<[[f64; 3]; 2]> = get("box"),
        planes: Option<Vec<[f64; 4]>> = get("planes"),
    }

    struct PortalItem<'a> {
        name: Option<Cow<'a, str>> = get("name"),
        cells: [Index; 2] = need("cells"),
        polygon: Vec<[f64; 3]> = need("polygon"),
        open: Option<bool> = get("open"),
        one_way: bool = or_default("oneWay"),
        node: Option<Index> = get("node"),
    }

    struct MirrorItem<'a> {
        name: Option<Cow<'a, str>> = get("name"),
        cell: Index = need("cell"),
        polygon: Vec<[f64; 3]> = need("polygon"),
    }
}

/// Reads an object of the extension; `name` is what errors call it.
fn member<'a, T: FromJson<'a>>(json: Json<'a>, name: &str) -> Result<T, ErrorKind> {
    T::from_json(json).map_err(|message| ErrorKind::invalid(name, message))
}

/// Cells of a document, and the nodes of their doors.
#[derive(Debug, Default)]
pub(super) struct Cells {
    graph: CellGraph,
    /// Portals by the node of their door.
    doors: HashMap<u32, Vec<u32>>,
}

impl Cells {
    /// Reads the extension, if it is there. `base` is the rotation of the file's up axis, `nodes`
    /// how many there are.
    ///
    /// # Errors
    /// If it is not of the right form, or an index leads nowhere. What polygons and pieces enclose
    /// is judged when the cells are placed.
    pub(super) fn read(root: &Root<'_>, base: &DAffine3, nodes: usize) -> Result<Self, ErrorKind> {
        let mut out = Self::default();
        let extensions = root.extensions.filter(|json| json.text().starts_with('{'));
        let Some(extensions) = extensions else { return Ok(out) };
        let own = Object::from_json(extensions).and_then(|all| all.get(NAME));
        let own = own.map_err(|message| ErrorKind::invalid("extensions", message))?;
        let Some(own) = own else { return Ok(out) };
        let extension: Extension<'_> = member(own, NAME)?;
        let list = |items: &Items<'_>| items.as_ref().map_or(0, Vec::len);
        let cells = list(&extension.cells);
        if cells == 0 && list(&extension.portals) + list(&extension.mirrors) > 0 {
            return Err(ErrorKind::invalid(NAME, "it has portals or mirrors, but no cells"));
        }
        let turn = Turn(base);
        let walls = extension.walls.unwrap_or(0.0);
        if !(walls >= 0.0 && walls.is_finite()) {
            let message = format!("its walls are {walls} thick; they must be 0 or more");
            return Err(ErrorKind::invalid(NAME, message));
        }
        (out.graph.walls, out.graph.sealed) = (walls, extension.sealed);
        for (number, json) in json::all(&extension.cells).iter().enumerate() {
            let name = format!("{NAME} cell {number}");
            let item: CellItem<'_> = member(*json, &name)?;
            let piece = |(i, piece): (usize, PieceItem)| match (piece.corners, piece.planes) {
                (Some([min, max]), None) => Ok(turn.piece(box_planes(min, max))),
                (None, Some(planes)) => Ok(turn.piece(planes)),
                (corners, _) => {
                    let what = if corners.is_some() { "both a" } else { "neither a" };
                    let item = format!("{name}, piece {i}");
                    let message = format!("has {what} box and planes; it must have one of them");
                    Err(ErrorKind::invalid(item, message))
                }
            };
            let count = item.pieces.len();
            let all = item.pieces.into_iter().chain(item.skin).enumerate().map(piece);
            let mut pieces = all.collect::<Result<Vec<_>, _>>()?;
            let skins = pieces.split_off(count);
            let name = item.name.map_or_else(String::new, Cow::into_owned);
            out.graph.cells.push(Cell { name, pieces, skins });
        }
        for (number, json) in json::all(&extension.portals).iter().enumerate() {
            let name = format!("{NAME} portal {number}");
            let item: PortalItem<'_> = member(*json, &name)?;
            let [a, b] = item.cells.map(|cell| link(cell, "cell", cells, &name));
            if let Some(node) = item.node {
                let node = link(node, "node", nodes, &name)?;
                out.doors.entry(node).or_default().push(number as u32);
            }
            out.graph.portals.push(Portal {
                name: item.name.map_or_else(String::new, Cow::into_owned),
                cells: [a?, b?],
                polygon: turn.polygon(item.polygon),
                door: None,
                closed: item.open == Some(false),
                one_way: item.one_way,
            });
        }
        for (number, json) in json::all(&extension.mirrors).iter().enumerate() {
            let name = format!("{NAME} mirror {number}");
            let item: MirrorItem<'_> = member(*json, &name)?;
            out.graph.mirrors.push(Mirror {
                cell: link(item.cell, "cell", cells, &name)?,
                name: item.name.map_or_else(String::new, Cow::into_owned),
                polygon: turn.polygon(item.polygon),
            });
        }
        Ok(out)
    }

    /// Notes that a node draws an instance: the first of a door's node is the door.
    pub(super) fn drawn(&mut self, node: u32, handle: Handle) {
        for portal in self.doors.remove(&node).into_iter().flatten() {
            self.graph.portals[portal as usize].door = Some(handle);
        }
    }

    /// Gives them to the model.
    pub(super) fn give(self, model: &mut Model) {
        model.cells = self.graph;
    }
}

/// The error of cells that cannot be placed.
pub(crate) fn error(cells: &CellGraph, error: &CellError) -> ErrorKind {
    let (item, message) = match error {
        CellError::Portal { portal, problem } => (format!("portal {portal}"), problem.to_string()),
        CellError::Mirror { mirror, problem } => (format!("mirror {mirror}"), problem.to_string()),
        CellError::Piece { piece, problem } => {
            let place = cells.piece_place(*piece);
            let (cell, piece) = place.unwrap_or((u32::MAX, *piece));
            (format!("cell {cell}, piece {piece}"), problem.to_string())
        }
        other => ("cells".to_owned(), other.to_string()),
    };
    ErrorKind::invalid(format!("{NAME} {item}"), message)
}

fn link(to: Index, what: &str, count: usize, name: &str) -> Result<u32, ErrorKind> {
    match to.index() {
        i if i < count => Ok(i as u32),
        _ => Err(ErrorKind::invalid(name, format!("names {what} {} of {count}", to.0))),
    }
}

/// From the file's axes to the scene's.
struct Turn<'a>(&'a DAffine3);

impl Turn<'_> {
    fn polygon(&self, polygon: Vec<[f64; 3]>) -> Vec<[f64; 3]> {
        polygon.into_iter().map(|p| self.0.transform_point3(p.into()).into()).collect()
    }

    fn piece(&self, planes: Vec<[f64; 4]>) -> Vec<[f64; 4]> {
        let turned = |[x, y, z, d]: [f64; 4]| {
            let normal = self.0.transform_vector3(DVec3::new(x, y, z));
            numbers(&Plane::new(normal.into(), d))
        };
        planes.into_iter().map(turned).collect()
    }
}
