//! Baked files as assets.

use bevy_app::{App, Plugin};
use bevy_asset::io::Reader;
use bevy_asset::{Asset, AssetApp, AssetLoader, LoadContext};
use bevy_reflect::TypePath;
use cullet_io::{LoadError, LoadOptions, Model, load_bytes};
use thiserror::Error;

/// A scene that was baked (`cullet bake`) with all that the engine needs of it: clusters, levels of
/// detail, occluders, cells.
///
/// Cull [`model.scene`](Model::scene) with an [`engine::Culler`] of your own: for renderers that
/// draw clusters and levels.
#[derive(Asset, Debug, TypePath)]
pub struct CulletBaked {
    /// The scene, with the names and materials of the file.
    pub model: Model,
}

/// Loads [`CulletBaked`] from `.glb`, where it is asked for by its type:
/// `asset_server.load::<CulletBaked>("city.glb")`. Bevy's own loader still loads the same file as a
/// scene.
#[derive(Clone, Copy, Debug, Default, TypePath)]
pub struct CulletBakedLoader;

/// Why a baked file cannot be loaded.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CulletBakedError {
    /// The file could not be read.
    #[error("{path}: {error}")]
    Read {
        /// The asset's path.
        path: String,
        /// Error of the asset source.
        error: std::io::Error,
    },
    /// The contents of the file cannot be loaded.
    #[error(transparent)]
    Load(#[from] LoadError),
}

impl AssetLoader for CulletBakedLoader {
    type Asset = CulletBaked;
    type Settings = ();
    type Error = CulletBakedError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        (): &(),
        context: &mut LoadContext<'_>,
    ) -> Result<CulletBaked, CulletBakedError> {
        let path = context.path().to_string();
        let mut bytes = Vec::new();
        let read = reader.read_to_end(&mut bytes).await;
        read.map_err(|error| CulletBakedError::Read { path: path.clone(), error })?;
        Ok(CulletBaked { model: load_bytes(&path, &bytes, &LoadOptions::default())? })
    }

    fn extensions(&self) -> &[&str] {
        &["glb"]
    }
}

/// Adds [`CulletBaked`] and its loader.
#[derive(Clone, Copy, Debug, Default)]
pub struct CulletBakedPlugin;

impl Plugin for CulletBakedPlugin {
    fn build(&self, app: &mut App) {
        app.init_asset::<CulletBaked>().register_asset_loader(CulletBakedLoader);
    }
}
