//! A map: its tree, leafs, brush models, entities and stored visibility.

use std::ops::Range;

use super::entities::{Entity, Lamp, Start};
use super::lumps::Version;
use super::tree::{Child, Tree};
use super::visibility::{Visibility, bit};

/// Contents of a leaf, as far as sight cares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Contents {
    /// Air: one may be there and see. In Quake 3 whatever is in a cluster.
    Open,
    /// A liquid: one may be there and see.
    Liquid,
    /// Sky: engines draw its surface in front of what is beyond it, but compilers let sight pass.
    Sky,
    /// Rock, or the outside.
    Solid,
}

impl Contents {
    /// Whether it is a region at all: all but rock.
    #[must_use]
    pub fn is_open(self) -> bool {
        self != Self::Solid
    }
}

/// A convex region at an end of the tree.
#[derive(Clone, Debug, PartialEq)]
pub struct Leaf {
    /// Contents.
    pub contents: Contents,
    /// Lowest and highest corner, in the map's axes, as the file has them: rounded to whole numbers
    /// in most maps.
    pub bounds: [[f64; 3]; 2],
    /// The cell that it is a part of: leafs that share one row of visibility are one cell. `None`
    /// for what has no place in visibility: the solid outside, and leafs of brush models.
    pub cell: Option<u32>,
    /// Surfaces in it: a range of [`Bsp::listed`].
    pub(crate) surfaces: Range<usize>,
}

/// The world (number 0), or a door, platform or the like.
#[derive(Clone, Debug, PartialEq)]
pub struct BrushModel {
    /// Lowest and highest corner, in the map's axes.
    pub bounds: [[f64; 3]; 2],
    /// Its tree. In Quake 3 only the world has one, and the others name the world's.
    pub root: Child,
    /// Its surfaces.
    pub(crate) surfaces: Range<usize>,
}

/// A texture of a map.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Texture {
    /// Its name; empty where the map has none.
    pub name: String,
    /// Its flags and contents in Quake 3, its flags and 0 in Quake 2, 0 in Quake.
    pub flags: [u32; 2],
}

/// A Quake or Quake 3 map, but for its geometry, which [`load`](crate::load()) makes a model of.
///
/// All is in the map's own axes (z up) and units, as in `.prt` files; [`to_scene`](super::to_scene)
/// turns a point as loading does.
#[derive(Clone, Debug)]
pub struct Bsp {
    pub(crate) version: Version,
    pub(crate) entities: Vec<Entity>,
    pub(crate) textures: Vec<Texture>,
    pub(crate) tree: Tree,
    pub(crate) leafs: Vec<Leaf>,
    pub(crate) models: Vec<BrushModel>,
    /// Surfaces that leafs name.
    pub(crate) listed: Vec<u32>,
    pub(crate) cell_count: u32,
    pub(crate) visibility: Option<Visibility>,
}

impl Bsp {
    /// Kind of map.
    #[must_use]
    pub fn version(&self) -> Version {
        self.version
    }

    /// The entities, in the order of the file.
    #[must_use]
    pub fn entities(&self) -> &[Entity] {
        &self.entities
    }

    /// The textures, of which a map has but names, and some maps not even these.
    #[must_use]
    pub fn textures(&self) -> &[Texture] {
        &self.textures
    }

    /// The tree.
    #[must_use]
    pub fn tree(&self) -> &Tree {
        &self.tree
    }

    /// The leafs.
    #[must_use]
    pub fn leafs(&self) -> &[Leaf] {
        &self.leafs
    }

    /// The world, then doors, platforms and the like.
    #[must_use]
    pub fn models(&self) -> &[BrushModel] {
        &self.models
    }

    /// How many cells there are: leafs that share one row of stored visibility are one cell, as are
    /// those of one cluster in Quake 2 and 3. In a Quake map without visibility each leaf is a cell.
    #[must_use]
    pub fn cell_count(&self) -> u32 {
        self.cell_count
    }

    /// Places where players appear: `info_player_start` first, others in the order of the file.
    #[must_use]
    pub fn starts(&self) -> Vec<Start> {
        let mut starts: Vec<Start> = self.entities.iter().filter_map(Entity::start).collect();
        let rank = |s: &Start| match s.class.to_ascii_lowercase().as_str() {
            "info_player_start" => 0,
            "info_player_deathmatch" => 1,
            _ => 2,
        };
        starts.sort_by_key(rank);
        starts
    }

    /// Lamps, in the order of the file.
    #[must_use]
    pub fn lamps(&self) -> Vec<Lamp> {
        self.entities.iter().filter_map(Entity::lamp).collect()
    }

    /// The leaf of the world that a point is in; on a border, that in front. Cost: the depth of the
    /// tree.
    #[must_use]
    pub fn leaf_at(&self, point: [f64; 3]) -> u32 {
        let root = self.models.first().map_or(Child::Leaf(0), |world| world.root);
        self.tree.leaf_at(root, point)
    }

    /// The cell of a point; `None` in rock and outside.
    #[must_use]
    pub fn cell_at(&self, point: [f64; 3]) -> Option<u32> {
        let leaf = &self.leafs[self.leaf_at(point) as usize];
        leaf.cell.filter(|_| leaf.contents.is_open())
    }

    /// Whether visibility is stored in it.
    #[must_use]
    pub fn has_visibility(&self) -> bool {
        self.visibility.is_some()
    }

    /// Leafs that can be seen from a leaf, as the file says, ascending; only leafs that are part of
    /// a cell. All of them where nothing is stored, for a leaf without a row (`vis` gives leafs of
    /// a leak none), and from rock: this is what engines make of it. Cost: linear in the leafs.
    ///
    /// # Panics
    /// If there is no such leaf.
    #[must_use]
    pub fn leafs_seen_from(&self, leaf: u32) -> Vec<u32> {
        let row = self.row_of(self.leafs[leaf as usize].cell);
        let seen = |(number, other): &(usize, &Leaf)| match (&row, other.cell) {
            (_, None) => false,
            (None, Some(_)) => true,
            (Some(row), Some(cell)) if self.version.has_clusters() => bit(row, cell as usize),
            (Some(row), Some(_)) => bit(row, number - 1),
        };
        let leafs = self.leafs.iter().enumerate().filter(seen);
        leafs.map(|(number, _)| number as u32).collect()
    }

    /// The stored row of a cell; `None` if all is seen.
    pub(super) fn row_of(&self, cell: Option<u32>) -> Option<Vec<u8>> {
        self.visibility.as_ref()?.row(cell?)
    }
}
