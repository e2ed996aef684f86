//! Models of tiles as one.

use std::path::PathBuf;

use cullet::mesh::MeshError;
use cullet::{Instance, Mesh, Transform, scene::MeshLevels};
use glam::{DMat3, DMat4, DVec3};

use cullet_io::{ErrorKind, LoadOptions, Model, Motion, Warning};

/// Models of tiles, joined.
#[derive(Debug)]
pub(super) struct Joint<'a> {
    options: &'a LoadOptions,
    model: Model,
    triangles: u64,
    instances: u64,
    /// Tiles whose motions, levels or cells are left out.
    still: usize,
    /// Tiles of points, which are left out.
    pub(super) points: Vec<PathBuf>,
    /// Extensions of the tileset that are not read.
    pub(super) unread: Vec<String>,
    /// Whether levels of the first of them are kept: clusters of the others are made anew, and
    /// levels are of clusters.
    keeps_levels: bool,
}

impl<'a> Joint<'a> {
    pub(super) fn new(name: &str, options: &'a LoadOptions) -> Self {
        let model = Model { name: name.to_owned(), ..Model::default() };
        Self {
            options,
            model,
            triangles: 0,
            instances: 0,
            still: 0,
            points: Vec::new(),
            unread: Vec::new(),
            keeps_levels: false,
        }
    }

    /// Builds the same as [`new`](Self::new), with the levels of detail and occluders that were
    /// baked of the meshes added first.
    pub(super) fn with_levels(name: &str, options: &'a LoadOptions) -> Self {
        Self { keeps_levels: true, ..Self::new(name, options) }
    }

    /// Adds a warning.
    pub(super) fn warn(&mut self, item: &str, message: String) {
        self.model.warnings.push(Warning { item: item.to_owned(), message });
    }

    /// Adds what a tile shows, once for each of some transforms.
    pub(super) fn add(
        &mut self,
        name: &str,
        tile: Model,
        places: &[DMat4],
    ) -> Result<(), ErrorKind> {
        let over = |item: &str, count: u64, limit: u64| {
            let error = || ErrorKind::OverLimit { item: item.to_owned(), count, limit };
            (count <= limit).then_some(()).ok_or_else(error)
        };
        let meshes = tile.scene.meshes().iter();
        self.triangles += meshes.map(|m| m.indices().len() as u64 / 3).sum::<u64>();
        over("triangles", self.triangles, self.options.max_triangles)?;
        self.instances += u64::from(tile.scene.instance_count()) * places.len() as u64;
        over("instances", self.instances, self.options.max_instances)?;
        let is_kept = self.keeps_levels && self.model.scene.meshes().is_empty();
        let leaves_out = tile.baked.is_some() && !is_kept;
        let moves = tile.motion.as_ref().is_some_and(Motion::moves);
        if moves || leaves_out || !tile.cells.cells.is_empty() {
            self.still += 1;
        }
        let (first, materials) =
            (self.model.scene.meshes().len() as u32, self.model.materials.len() as u32);
        for (k, mesh) in tile.scene.meshes().iter().enumerate() {
            let mesh = if materials == 0 {
                mesh.clone()
            } else {
                let mut data = mesh.to_data();
                data.parts.iter_mut().for_each(|part| part.material += materials);
                let invalid = |e: MeshError| ErrorKind::invalid(format!("mesh {k}"), e.to_string());
                Mesh::new(data).map_err(invalid)?
            };
            self.model.scene.add_mesh(mesh);
            let own = tile.mesh_names.get(k).map_or("", String::as_str);
            self.model.mesh_names.push(format!("{name} {own}").trim_end().to_owned());
        }
        if is_kept {
            for mesh in 0..tile.scene.meshes().len() as u32 {
                for MeshLevels { mesh: held_by, levels, .. } in tile.scene.levels(mesh) {
                    let added = self.model.scene.add_levels(mesh, *held_by, levels.clone());
                    added.map_err(|e| {
                        ErrorKind::invalid(format!("levels of mesh {mesh}"), e.to_string())
                    })?;
                }
            }
        }
        let slots = || tile.scene.slots();
        for (place, slot) in places.iter().flat_map(|place| slots().map(move |slot| (place, slot)))
        {
            let transform = composed(place, tile.scene.transform(slot));
            let instance = Instance {
                layers: tile.scene.layers(slot),
                flags: tile.scene.flags(slot),
                size_weight: tile.scene.size_weight(slot),
                ..Instance::new(first + tile.scene.mesh_id(slot), transform)
            };
            let added = self.model.scene.add(instance);
            added.map_err(|e| ErrorKind::invalid("instance", e.to_string()))?;
            let own = tile.scene.handle(slot).map(|handle| tile.instance_name(handle));
            self.model.instance_names.push(format!("{name} {}", own.unwrap_or_default()));
        }
        if is_kept {
            // Its meshes have the numbers that they had.
            self.model.baked = tile.baked;
        }
        self.model.materials.extend(tile.materials);
        self.model.textures = self.model.textures.saturating_add(tile.textures);
        // Of many tiles with the same extensions each is named once.
        let is_unread = |w: &Warning| tile.unread.iter().any(|u| w.message.starts_with(&u.name));
        self.model.warnings.extend(
            tile.warnings.iter().filter(|w| !(w.item == "not read" && is_unread(w))).map(|w| {
                Warning { item: format!("{name}, {}", w.item), message: w.message.clone() }
            }),
        );
        for unread in tile.unread {
            if !self.model.unread.contains(&unread) {
                self.warn("not read", format!("{}, {}", unread.name, unread.meaning));
                self.model.unread.push(unread);
            }
        }
        Ok(())
    }

    /// Refuses tilesets of nothing but points.
    pub(super) fn check(&self) -> Result<(), ErrorKind> {
        let Some(first) = self.points.first().filter(|_| self.triangles == 0) else {
            return Ok(());
        };
        let message = "a tile of the kind pnts is not read, for points have no surface; make one \
                       first, for example with MeshLab";
        Err(ErrorKind::Unsupported(format!("{}: {message}", first.display())))
    }

    pub(super) fn finish(mut self) -> Model {
        if self.still > 0 {
            let message =
                format!("motions, baked levels and cells of {} tiles are left out", self.still);
            self.warn("tileset", message);
        }
        if !self.points.is_empty() {
            let count = self.points.len();
            let message =
                format!("tiles of points (pnts) left out, for points have no surface: {count}");
            self.warn("tileset", message);
        }
        if !self.unread.is_empty() {
            let message =
                format!("not read: {}; what they add is not there", self.unread.join(", "));
            self.warn("tileset", message);
        }
        // What was left out might have had some.
        let is_read = self.unread.is_empty() && !self.model.unread.iter().any(|u| u.may_draw);
        if self.triangles == 0 && self.points.is_empty() && is_read {
            let message = "it has no triangles, so there is nothing to see or cull".to_owned();
            self.warn("tileset", message);
        }
        self.model.scene.sort();
        self.model
    }
}

/// One transform after another.
fn composed(place: &DMat4, inner: &Transform) -> Transform {
    let columns = inner.linear.map(|c| DVec3::from(c.map(f64::from)));
    let linear = DMat3::from_mat4(*place) * DMat3::from_cols(columns[0], columns[1], columns[2]);
    let translation = place.transform_point3(DVec3::from(inner.translation));
    Transform {
        linear: linear.to_cols_array_2d().map(|c| c.map(|v| v as f32)),
        translation: translation.to_array(),
    }
}
