//! 3D Tiles, tile by tile.

use std::path::Path;

use cullet::{Instance, Mesh};
use cullet_io::{LoadError, LoadOptions, TileTree};

use crate::source::{TileContent, TileError, TileId, TileInfo, TileSource};

/// Of a tile of a tileset that does not say what it takes: so many bytes of its file an instance, a vertex and a triangle at the
/// least.
const OF_A_FILE: [u64; 3] = [1024, 12, 6];

/// A tileset in a folder, whose tiles are loaded when they matter: 3D Tiles 1.0 or 1.1, see [`TileTree`].
///
/// What [`write_tiles`](cullet_io::write_tiles) wrote says what each tile takes. Of other tilesets that is estimated from the
/// size of its files, more than most need; a tile that takes more than that is not shown, and named in
/// [`Status::failed`](crate::Status::failed). Levels of detail are those of the tiles' files; cells and motions are left out.
#[derive(Debug)]
pub struct FolderTiles {
    tree: TileTree,
    infos: Vec<TileInfo>,
}

impl FolderTiles {
    /// Opens a `tileset.json`.
    ///
    /// # Errors
    /// If it, or a tileset within it, cannot be read or is invalid.
    pub fn open(path: &Path, options: &LoadOptions) -> Result<Self, LoadError> {
        let tree = TileTree::open(path, options)?;
        let info = |(tile, node): (usize, &cullet_io::TileNode)| {
            let (instances, meshes) = match node.size {
                Some(size) => (size.instances, [size.vertices, size.triangles]),
                None => {
                    let bytes = tree.file_bytes(tile as u32);
                    let [instance, vertex, triangle] = OF_A_FILE.map(|of| bytes / of);
                    (u32::try_from(instance + 1).unwrap_or(u32::MAX), [vertex, triangle])
                }
            };
            TileInfo { bounds: node.bounds, error: node.error, instances, meshes, adds: node.adds }
        };
        let infos = tree.tiles().iter().enumerate().map(info).collect();
        Ok(Self { tree, infos })
    }

    /// The tree of its tiles; a tile's number is its [`TileId`].
    #[must_use]
    pub fn tree(&self) -> &TileTree {
        &self.tree
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
        self.infos.get(Self::number(tile)).copied().unwrap_or(none)
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
        let instances = scene.slots().map(|slot| Instance {
            layers: scene.layers(slot),
            flags: scene.flags(slot),
            size_weight: scene.size_weight(slot),
            user: tile.0 << 32 | u64::from(slot),
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
        })
    }
}
