//! 3D Tiles, tile by tile.

use std::path::Path;
use std::sync::OnceLock;

use cullet::cull::occlusion::Occluder;
use cullet::{Instance, InstanceFlags, Mesh};
use cullet_io::baked::BakedMesh;
use cullet_io::{LoadError, LoadOptions};
use cullet_maps::TileNode;
use cullet_maps::TileSight;
use cullet_maps::TileTree;

use crate::source::{TileContent, TileError, TileId, TileInfo, TileSource};

/// Least bytes of a file for an instance, a vertex and a triangle, for a tile that states its size
/// neither in its tileset nor in the headers of its files.
const OF_A_FILE: [u64; 3] = [1024, 12, 6];

/// A tileset in a folder, whose tiles are loaded when they matter: 3D Tiles 1.0 or 1.1, see
/// [`TileTree`].
///
/// What [`write_tiles`](cullet_maps::write_tiles) wrote says what each tile takes. Of other
/// tilesets the counts in the headers of a tile's files say it, which are read when the tile first
/// matters, and for meshes that deform or have levels of detail the size of the files, more than
/// most need; a tile that takes more than that is not shown, and named in
/// [`Status::failed`](crate::Status::failed). Levels of detail and occluders are those that the
/// tiles' files have baked; a tile that others replace stands in for them and never occludes. Where
/// the tileset has visible sets, they say what matters first. Cells and motions are left out.
#[derive(Debug)]
pub struct FolderTiles {
    tree: TileTree,
    /// Facts about each tile, once they were asked for.
    infos: Vec<OnceLock<TileInfo>>,
    /// Bytes of the tree and of the facts.
    bytes: u64,
    uses_sight: bool,
}

impl FolderTiles {
    /// Opens a `tileset.json`.
    ///
    /// # Errors
    /// If it, or a tileset within it, cannot be read or is invalid.
    pub fn open(path: &Path, options: &LoadOptions) -> Result<Self, LoadError> {
        let tree = TileTree::open(path, options)?;
        let infos: Vec<OnceLock<TileInfo>> = tree.tiles().iter().map(|_| OnceLock::new()).collect();
        let bytes = tree.size() + size_of_val(&infos[..]) as u64;
        Ok(Self { tree, infos, bytes, uses_sight: true })
    }

    /// The same world, without what its visible sets say of what matters first.
    #[must_use]
    pub fn without_sight(self) -> Self {
        Self { uses_sight: false, ..self }
    }

    fn sight(&self) -> Option<&TileSight> {
        self.tree.sight().filter(|_| self.uses_sight)
    }

    /// The tree of its tiles; a tile's number is its [`TileId`].
    #[must_use]
    pub fn tree(&self) -> &TileTree {
        &self.tree
    }

    fn find(&self, number: usize, node: &TileNode) -> TileInfo {
        let (instances, meshes) = match self.tree.counted(number as u32) {
            Some(size) => (size.instances, [size.vertices, size.triangles]),
            None => {
                let bytes = self.tree.file_bytes(number as u32);
                let [instance, vertex, triangle] = OF_A_FILE.map(|of| bytes / of);
                (u32::try_from(instance + 1).unwrap_or(u32::MAX), [vertex, triangle])
            }
        };
        TileInfo { bounds: node.bounds, error: node.error, instances, meshes, adds: node.adds }
    }

    fn number(TileId(tile): TileId) -> usize {
        usize::try_from(tile).unwrap_or(usize::MAX)
    }
}

impl TileSource for FolderTiles {
    fn meshes(&self) -> &[Mesh] {
        &[]
    }

    fn roots(&self) -> Vec<TileId> {
        vec![TileId(0)]
    }

    fn info(&self, tile: TileId) -> TileInfo {
        let everywhere = [[f64::NEG_INFINITY; 3], [f64::INFINITY; 3]];
        let none =
            TileInfo { bounds: everywhere, error: 0.0, instances: 0, meshes: [0; 2], adds: false };
        let number = Self::number(tile);
        let found = self.infos.get(number).zip(self.tree.tiles().get(number));
        found.map_or(none, |(info, node)| *info.get_or_init(|| self.find(number, node)))
    }

    fn children(&self, tile: TileId, out: &mut Vec<TileId>) {
        let node = self.tree.tiles().get(Self::number(tile));
        out.extend(node.iter().flat_map(|n| &n.children).map(|&child| TileId(child.into())));
    }

    fn load(&self, tile: TileId) -> Result<TileContent, TileError> {
        let fail = |reason: String| TileError::Load { tile: tile.0, reason };
        let number = u32::try_from(tile.0).map_err(|_| fail("there is no such tile".to_owned()))?;
        let model = self.tree.load(number).map_err(|e| fail(e.to_string()))?;
        let scene = &model.scene;
        let stands_in =
            self.tree.tiles().get(Self::number(tile)).is_some_and(TileNode::is_stand_in);
        let flags = |flags: InstanceFlags| InstanceFlags {
            no_occlusion: flags.no_occlusion || stands_in,
            ..flags
        };
        let instances = scene.slots().map(|slot| Instance {
            layers: scene.layers(slot),
            flags: flags(scene.flags(slot)),
            size_weight: scene.size_weight(slot),
            user_data: tile.0 << 32 | u64::from(slot),
            ..Instance::new(scene.mesh_id(slot), *scene.transform(slot))
        });
        let levels = |mesh: u32| {
            let of = scene.levels(mesh).iter();
            of.map(move |levels| ([mesh, levels.mesh], levels.levels.clone()))
        };
        Ok(TileContent {
            instances: instances.collect(),
            meshes: scene.meshes().to_vec(),
            levels: (0..scene.meshes().len() as u32).flat_map(levels).collect(),
            occluders: model
                .baked
                .iter()
                .flat_map(|baked| &baked.meshes)
                .filter_map(occluder)
                .collect(),
        })
    }

    fn bytes(&self) -> u64 {
        self.bytes
    }

    fn cells_of(&self, points: &[[f64; 3]]) -> Vec<u32> {
        let Some(sight) = self.sight() else { return Vec::new() };
        let cells = points.iter().map(|&point| sight.cell_of(point));
        let mut cells: Vec<u32> = cells.collect::<Option<_>>().unwrap_or_default();
        cells.sort_unstable();
        cells.dedup();
        cells
    }

    fn is_seen(&self, tile: TileId, cells: &[u32]) -> bool {
        let node = self.tree.tiles().get(Self::number(tile));
        match (self.sight(), node.and_then(|node| node.number)) {
            (Some(sight), Some(number)) => cells.iter().any(|&cell| sight.sees(cell, number)),
            _ => true,
        }
    }
}

/// Occluders that were baked for a mesh, where they hide nearly all that it does.
fn occluder(of: &BakedMesh) -> Option<(u32, Occluder)> {
    let made = of.occluders.as_ref()?;
    // One that is none, in spite of its sum, is left out: the mesh's own triangles serve.
    let occluder = made.hide_enough().then(|| made.to_engine().ok())??;
    (!occluder.shapes().is_empty()).then_some((of.mesh, occluder))
}
