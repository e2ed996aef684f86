//! A model of a map: a mesh for each cell and each brush model, and a camera for each start.

use std::collections::{BTreeMap, HashMap};

use cullet::mesh::{Alpha, MeshData, Part};
use cullet::{Instance, InstanceFlags, Projection, Transform};
use glam::{DMat3, DVec3};

use super::entities::Start;
use super::lumps::{Lumps, Version};
use super::map::Bsp;
use super::parse;
use super::surfaces::{Kind, Surface, Surfaces};
use cullet_io::reader::Builder;
use cullet_io::reader::Compact;
use cullet_io::{CameraNode, ErrorKind, LoadOptions, Up};

/// Turns a point or a direction of a map as loading does with the same `up`: a map has z up where
/// nothing else is said.
#[must_use]
pub fn to_scene([x, y, z]: [f64; 3], up: Option<Up>) -> [f64; 3] {
    match up.unwrap_or(Up::Z) {
        Up::Y => [x, y, z],
        Up::Z => [x, z, -y],
    }
}

/// Height of a player's eyes above the ground: 24 to the origin of the player, and 22 more.
const EYE_HEIGHT: f64 = 46.0;
/// Distance of the near plane of a start's camera, as the engines have it.
const NEAR: f64 = 4.0;
/// Full vertical field of view of a start's camera: 90 degrees across a picture of 4 to 3.
const FOV_Y: f64 = 1.287_002_217_586_57;

/// A mesh with one instance for each cell: the surfaces of leafs that share one row of visibility,
/// so that what is known of cells holds for instances, and no mesh is larger than what its author
/// took for one room. A surface that is in several cells is in the mesh of that in front of its
/// middle. Another mesh for each brush model, with an instance for each entity that places it;
/// triggers are never seen, so they have none.
pub(crate) fn read<'o>(
    name: &str,
    bytes: &[u8],
    options: &'o LoadOptions,
) -> Result<Builder<'o>, ErrorKind> {
    let lumps = Lumps::new(bytes)?;
    let map = parse::parse(&lumps)?;
    let surfaces = parse::surfaces(&lumps, &map)?;
    let mut builder = Builder::new(name, options).for_map();
    warn(&map, &surfaces, &mut builder);
    let mut maker = Maker {
        compact: Compact::new(surfaces.positions.len()),
        materials: HashMap::new(),
        surfaces: &surfaces,
        map: &map,
        builder,
    };
    maker.world()?;
    maker.brush_models()?;
    let mut builder = maker.builder;
    builder.model.eye_height = Some(EYE_HEIGHT);
    match map.model_cells(options.up) {
        Ok(cells) => builder.model.cells = cells,
        Err(error) => builder.warn("cells", format!("none, for they cannot be made: {error}")),
    }
    builder.model.cell_sets = map.cell_sets();
    add_cameras(&map, options.up, &mut builder);
    Ok(builder)
}

fn warn(map: &Bsp, surfaces: &Surfaces, builder: &mut Builder<'_>) {
    if !map.has_visibility() {
        builder.warn("lump visibility", "it is empty: what can be seen from where is not stored");
    }
    if !map.textures.is_empty() && map.textures.iter().all(|t| t.name.is_empty()) {
        let message = format!(
            "none of {} textures has a name: fences cannot be told from walls, and count as walls",
            map.textures.len()
        );
        builder.warn("lump textures", message);
    }
    for (count, message) in surfaces.notes.iter().filter(|(count, _)| *count > 0) {
        builder.warn("lump faces", format!("{count} {message}"));
    }
}

struct Maker<'a, 'o> {
    map: &'a Bsp,
    surfaces: &'a Surfaces,
    compact: Compact,
    /// The material of a texture that serves as some kind of surface.
    materials: HashMap<(u32, Kind), u32>,
    builder: Builder<'o>,
}

impl Maker<'_, '_> {
    fn world(&mut self) -> Result<(), ErrorKind> {
        let Some(world) = self.map.models.first() else { return Ok(()) };
        // The first cell that lists a surface, for those whose front is in rock.
        let mut listing: HashMap<u32, u32> = HashMap::new();
        for leaf in &self.map.leafs {
            let Some(cell) = leaf.cell else { continue };
            for &face in &self.map.listed[leaf.surfaces.clone()] {
                listing.entry(face).or_insert(cell);
            }
        }
        let mut groups: BTreeMap<Option<u32>, Vec<&Surface>> = BTreeMap::new();
        for face in world.surfaces.clone() {
            let Some(surface) = &self.surfaces.list[face] else { continue };
            let before = [0, 1, 2].map(|a| surface.centre[a] + 0.5 * surface.normal[a]);
            let cell = self.map.cell_at(before).or(listing.get(&(face as u32)).copied());
            groups.entry(cell).or_default().push(surface);
        }
        for (cell, group) in groups {
            let name = cell.map_or_else(|| "world".to_owned(), |cell| format!("cell {cell}"));
            let data = self.mesh(group);
            self.builder.mesh_instance(name, data)?;
        }
        Ok(())
    }

    fn brush_models(&mut self) -> Result<(), ErrorKind> {
        let mut meshes = HashMap::new();
        for (number, entity) in self.map.entities.iter().enumerate() {
            let class = entity.class();
            let Some(model) = entity.brush_model().filter(|_| !class.starts_with("trigger_"))
            else {
                continue;
            };
            let Some(brushes) = self.map.models.get(model as usize).filter(|_| model > 0) else {
                let count = self.map.models.len();
                let message =
                    format!("its model *{model} is not there; the map has {count}, from *1");
                self.builder.warn(format!("entity {number} ({class})"), message);
                continue;
            };
            let through = entity.is_seen_through();
            let mesh = if let Some(mesh) = meshes.get(&(model, through)) {
                *mesh
            } else {
                let faces = brushes.surfaces.clone();
                let group: Vec<&Surface> =
                    faces.filter_map(|face| self.surfaces.list[face].as_ref()).collect();
                let mesh = if group.is_empty() {
                    None
                } else {
                    let mut data = self.mesh(group);
                    if through {
                        data.parts.iter_mut().for_each(|part| part.alpha = Alpha::Blended);
                    }
                    Some(self.builder.mesh(format!("*{model}"), data)?)
                };
                meshes.insert((model, through), mesh);
                mesh
            };
            let Some(mesh) = mesh else { continue };
            let still = ["func_wall", "func_static", "func_illusionary", "func_group"];
            let dynamic = !still.contains(&class) && !class.starts_with("func_detail");
            let flags = InstanceFlags { dynamic, ..InstanceFlags::default() };
            let transform = Transform::from_translation(entity.origin().unwrap_or_default());
            let instance = Instance { flags, ..Instance::new(mesh, transform) };
            self.builder.instance(format!("{class} *{model}"), instance)?;
        }
        Ok(())
    }

    /// Surfaces as one mesh, a part for each material.
    fn mesh(&mut self, mut group: Vec<&Surface>) -> MeshData {
        let key = |s: &&Surface| (s.texture, s.kind, s.two_sided);
        group.sort_by_key(key);
        let mut data = MeshData { polygons: group.len() as u32, ..MeshData::default() };
        for same in group.chunk_by(|a, b| key(a) == key(b)) {
            let first_triangle = (data.indices.len() / 3) as u32;
            for surface in same {
                data.indices.extend(&self.surfaces.indices[surface.indices.clone()]);
            }
            let Surface { texture, kind, two_sided, .. } = same[0];
            data.parts.push(Part {
                first_triangle,
                triangle_count: (data.indices.len() / 3) as u32 - first_triangle,
                material: self.material(*texture, *kind),
                two_sided: *two_sided,
                alpha: match kind {
                    Kind::Wall | Kind::Sky => Alpha::Opaque,
                    Kind::Fence => Alpha::Masked,
                    Kind::Liquid | Kind::Effect => Alpha::Blended,
                },
            });
        }
        data.positions = self.compact.take(&self.surfaces.positions, &mut data.indices);
        data
    }

    fn material(&mut self, texture: u32, kind: Kind) -> u32 {
        if let Some(&material) = self.materials.get(&(texture, kind)) {
            return material;
        }
        let own = self.map.textures.get(texture as usize).map_or("", |t| t.name.as_str());
        let name = match (own, kind) {
            ("", Kind::Wall) => format!("texture {texture}"),
            ("", kind) => format!("texture {texture} ({})", format!("{kind:?}").to_lowercase()),
            (name, _) => name.to_owned(),
        };
        let color = color(&name, kind);
        let material = self.builder.material(name, color);
        self.materials.insert((texture, kind), material);
        material
    }
}

/// Colour in place of a texture's: of its kind, or for a wall a muted one by its name, so that
/// neighbours differ.
fn color(name: &str, kind: Kind) -> [f32; 4] {
    match kind {
        Kind::Sky => [0.42, 0.6, 0.86, 1.0],
        Kind::Liquid => [0.1, 0.35, 0.4, 0.6],
        Kind::Effect => [0.9, 0.7, 0.4, 0.5],
        Kind::Wall | Kind::Fence => {
            // FNV-1a: the same colours everywhere.
            let hash = name
                .bytes()
                .fold(0x811c_9dc5_u32, |h, b| (h ^ u32::from(b)).wrapping_mul(0x0100_0193));
            let channel = |shift: u32| 0.3 + 0.3 * ((hash >> shift & 0xFF) as f32 / 255.0);
            [channel(5), channel(13), channel(21), 1.0]
        }
    }
}

/// A camera at the eyes of each start. A map without starts has one in the middle of its largest
/// open leaf.
fn add_cameras(map: &Bsp, up: Option<Up>, builder: &mut Builder<'_>) {
    let mut starts = map.starts();
    if starts.is_empty() {
        starts.extend(largest_leaf(map));
    }
    let bounds = map.models.first().map_or([[0.0; 3]; 2], |world| world.bounds);
    let diagonal = DVec3::from(bounds[0]).distance(bounds[1].into());
    let far = if diagonal.is_finite() { diagonal.max(4096.0) * 1.5 } else { f64::INFINITY };
    let mut names: HashMap<String, u32> = HashMap::new();
    for start in starts {
        let [x, y, z] = start.origin;
        let eye = DVec3::from(to_scene([x, y, z + eye_height(map.version, &start)], up));
        let forward = DVec3::from(to_scene(start.direction, up));
        let upward = DVec3::from(to_scene([0.0, 0.0, 1.0], up));
        let aside = DVec3::from(to_scene([0.0, -1.0, 0.0], up));
        let right = forward.cross(upward).try_normalize().unwrap_or(aside);
        let columns = DMat3::from_cols(right, right.cross(forward), -forward);
        let count = names.entry(start.class.clone()).or_default();
        *count += 1;
        let name = match *count {
            1 => start.class,
            n => format!("{} {n}", start.class),
        };
        builder.model.cameras.push(CameraNode {
            name,
            projection: Projection::Perspective {
                fov_y_radians: FOV_Y,
                aspect: 0.0,
                near: NEAR,
                far,
            },
            keys: vec![(
                0.0,
                Transform {
                    linear: columns.to_cols_array_2d().map(|c| c.map(|v| v as f32)),
                    translation: eye.into(),
                },
            )],
        });
    }
}

/// Height of the eye above the origin of a player; who watches from an intermission is where it
/// says.
fn eye_height(version: Version, start: &Start) -> f64 {
    match version {
        _ if start.class.ends_with("intermission") || start.class == MIDDLE => 0.0,
        Version::Quake | Version::Bsp2 | Version::Quake2 => 22.0,
        Version::HalfLife => 28.0,
        Version::Quake3 => 26.0,
    }
}

/// Name of the camera of a map without starts.
const MIDDLE: &str = "middle";

fn largest_leaf(map: &Bsp) -> Option<Start> {
    let volume = |[low, high]: &[[f64; 3]; 2]| (0..3).map(|a| high[a] - low[a]).product::<f64>();
    let open = map.leafs.iter().filter(|l| l.cell.is_some() && l.contents.is_open());
    let whole = open.filter(|l| volume(&l.bounds).is_finite());
    let leaf = whole.max_by(|a, b| volume(&a.bounds).total_cmp(&volume(&b.bounds)))?;
    let [low, high] = leaf.bounds;
    let origin = [0, 1, 2].map(|a| (low[a] + high[a]) * 0.5);
    Some(Start { class: MIDDLE.into(), origin, direction: [1.0, 0.0, 0.0] })
}
