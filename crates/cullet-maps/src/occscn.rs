//! `OCCSCN01`, the plain exchange format for occlusion benchmarks: occluder triangles in world
//! space, cameras as matrices, and boxes to be tested.
//!
//! Little-endian, packed: the magic; six u32 (vertices, triangles, meshes, cameras, objects, 0);
//! the vertices, three f32 each; the triangles, three u32 each; the meshes, `first triangle, count,
//! box`; the cameras, `matrix (column-major, depth 0..1), eye, near`; the objects, a box each. A
//! box is its lowest and its highest corner.

mod make;

use std::io::{self, Write};

use cullet::bounds::Aabb;
use cullet::mesh::{Alpha, MeshData, Part};
use cullet::{Instance, InstanceFlags, Transform, scene::BoundsOverride};

pub use make::{MakeOptions, Objects, occluder_slots};

use cullet_io::reader::Builder;
use cullet_io::reader::Compact;
use cullet_io::{ErrorKind, LoadOptions, Material, MatrixView, Model, Up, world, world_box};

/// The first bytes of a file.
pub const MAGIC: &[u8; 8] = b"OCCSCN01";

const HEADER: usize = 32;
/// Bytes of a vertex, a triangle, a mesh, a camera and an object.
const SIZES: [usize; 5] = [12, 12, 32, 80, 24];
const NAMES: [&str; 5] = ["vertices", "triangles", "meshes", "cameras", "objects"];

/// The box of a mesh without triangles.
const ZERO: Aabb = Aabb { min: [0.0; 3], max: [0.0; 3] };

/// A range of triangles that may be culled or sorted as one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeshRange {
    /// First triangle.
    pub first_triangle: u32,
    /// How many triangles.
    pub triangle_count: u32,
}

/// A fixed view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OccCamera {
    /// World to clip space, column-major for column vectors; depth 0 (near) to 1, y up.
    pub clip_from_world: [f32; 16],
    /// Where the eye is.
    pub eye: [f32; 3],
    /// Distance of the near plane, in the units of clip w.
    pub near: f32,
}

/// Contents of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Occscn {
    /// Vertices in world space.
    pub vertices: Vec<[f32; 3]>,
    /// Triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Meshes; together they hold each triangle once.
    pub meshes: Vec<MeshRange>,
    /// Views.
    pub cameras: Vec<OccCamera>,
    /// Boxes to be tested, `[min, max]`.
    pub objects: Vec<[[f32; 3]; 2]>,
}

impl Occscn {
    /// Reads a file and checks it: every number finite, every index in range, each triangle in one
    /// mesh, no box inside out. Allocates no more than the bytes at hand account for.
    ///
    /// # Errors
    /// The first defect, with its number, value and limit.
    pub fn parse(bytes: &[u8]) -> Result<Self, ErrorKind> {
        let Some((head, body)) = bytes.split_at_checked(HEADER) else {
            let message = format!("{} bytes, but the header has {HEADER}", bytes.len());
            return Err(ErrorKind::invalid("header", message));
        };
        if !head.starts_with(MAGIC) {
            return Err(ErrorKind::invalid("header", "it does not begin with OCCSCN01"));
        }
        let counts: Vec<u32> = words(&head[MAGIC.len()..]).map(u32::from_le_bytes).collect();
        let need: u64 = counts.iter().zip(SIZES).map(|(&n, size)| u64::from(n) * size as u64).sum();
        if need != body.len() as u64 {
            let list: Vec<String> =
                counts.iter().zip(NAMES).map(|(n, name)| format!("{n} {name}")).collect();
            return Err(ErrorKind::invalid(
                "header",
                format!(
                    "{} take {need} bytes after the header, but the file has {}",
                    list.join(", "),
                    body.len()
                ),
            ));
        }
        let mut rest = body;
        let mut section = |k: usize| {
            let (section, after) = rest.split_at(counts[k] as usize * SIZES[k]);
            rest = after;
            section.chunks_exact(SIZES[k])
        };
        let vertices = section(0).map(floats).collect();
        let triangles = section(1).map(ints).collect();
        let meshes = section(2)
            .map(|m| ints(&m[..8]))
            .map(|[first_triangle, triangle_count]| MeshRange { first_triangle, triangle_count })
            .collect();
        let cameras = section(3)
            .map(|c| OccCamera {
                clip_from_world: floats(&c[..64]),
                eye: floats(&c[64..76]),
                near: floats::<1>(&c[76..])[0],
            })
            .collect();
        let objects = section(4).map(|o| [floats(&o[..12]), floats(&o[12..])]).collect();
        let scene = Self { vertices, triangles, meshes, cameras, objects };
        scene.check()?;
        Ok(scene)
    }

    fn check(&self) -> Result<(), ErrorKind> {
        let finite = |item: &str, i: usize, values: &[f32]| match values
            .iter()
            .find(|v| !v.is_finite())
        {
            Some(v) => Err(ErrorKind::invalid(format!("{item} {i}"), format!("not finite: {v}"))),
            None => Ok(()),
        };
        for (i, v) in self.vertices.iter().enumerate() {
            finite("vertex", i, v)?;
        }
        let vertices = self.vertices.len();
        for (i, t) in self.triangles.iter().enumerate() {
            if let Some(v) = t.iter().find(|&&v| v as usize >= vertices) {
                return Err(ErrorKind::invalid(
                    format!("triangle {i}"),
                    format!("refers to vertex {v}, but there are only {vertices} (from 0)"),
                ));
            }
        }
        self.check_meshes()?;
        for (i, c) in self.cameras.iter().enumerate() {
            finite("camera", i, &c.clip_from_world)?;
            finite("camera", i, &c.eye)?;
            finite("camera", i, &[c.near])?;
        }
        for (i, [min, max]) in self.objects.iter().enumerate() {
            finite("object", i, min)?;
            finite("object", i, max)?;
            if (0..3).any(|a| min[a] > max[a]) {
                return Err(ErrorKind::invalid(
                    format!("object {i}"),
                    format!("its box is inside out: {min:?} to {max:?}"),
                ));
            }
        }
        Ok(())
    }

    /// Each triangle must be in one mesh: overlaps could claim far more triangles than the file
    /// has.
    fn check_meshes(&self) -> Result<(), ErrorKind> {
        let triangles = self.triangles.len() as u64;
        let mut order: Vec<usize> = (0..self.meshes.len()).collect();
        order.sort_by_key(|&m| (self.meshes[m].first_triangle, self.meshes[m].triangle_count));
        let mut end = 0u64;
        for &m in &order {
            let MeshRange { first_triangle, triangle_count } = self.meshes[m];
            let first = u64::from(first_triangle);
            // An empty mesh takes no place, wherever it says it is.
            if triangle_count == 0 {
                continue;
            }
            if first != end {
                return Err(ErrorKind::invalid(
                    format!("mesh {m}"),
                    format!("starts at triangle {first}, but those before it end at {end}"),
                ));
            }
            end = first + u64::from(triangle_count);
            if end > triangles {
                return Err(ErrorKind::invalid(
                    format!("mesh {m}"),
                    format!("ends at triangle {end}, but there are only {triangles}"),
                ));
            }
        }
        if end != triangles {
            return Err(ErrorKind::invalid(
                "meshes",
                format!("they hold {end} of {triangles} triangles, and must hold all"),
            ));
        }
        Ok(())
    }

    /// The box of a mesh's vertices; empty for a mesh without triangles.
    ///
    /// # Panics
    /// If `mesh` is not below the number of meshes.
    #[must_use]
    pub fn mesh_bounds(&self, mesh: usize) -> Aabb {
        let used = self.triangles_of(&self.meshes[mesh]).as_flattened();
        let corners: Vec<[f32; 3]> = used.iter().map(|&v| self.vertices[v as usize]).collect();
        Aabb::from_points(&corners)
    }

    /// The triangles of a mesh; none for an empty one, wherever it says it is.
    #[must_use]
    pub fn triangles_of(&self, mesh: &MeshRange) -> &[[u32; 3]] {
        let first = mesh.first_triangle as usize;
        self.triangles.get(first..first + mesh.triangle_count as usize).unwrap_or(&[])
    }

    /// Writes the file. Pass a buffered writer.
    ///
    /// # Errors
    /// If writing fails; `InvalidInput` if a count exceeds 32 bits or the scene is not what
    /// [`parse`](Self::parse) would accept.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let invalid = |e: ErrorKind| io::Error::new(io::ErrorKind::InvalidInput, e.to_string());
        self.check().map_err(invalid)?;
        out.write_all(MAGIC)?;
        let counts = [
            self.vertices.len(),
            self.triangles.len(),
            self.meshes.len(),
            self.cameras.len(),
            self.objects.len(),
            0,
        ];
        for (k, &count) in counts.iter().enumerate() {
            let count = u32::try_from(count).map_err(|_| {
                invalid(ErrorKind::OverLimit {
                    item: NAMES[k].into(),
                    count: count as u64,
                    limit: u64::from(u32::MAX),
                })
            })?;
            out.write_all(&count.to_le_bytes())?;
        }
        let floats = |out: &mut dyn Write, values: &[f32]| {
            values.iter().try_for_each(|v| out.write_all(&v.to_le_bytes()))
        };
        for v in &self.vertices {
            floats(out, v)?;
        }
        for i in self.triangles.iter().flatten() {
            out.write_all(&i.to_le_bytes())?;
        }
        for (m, mesh) in self.meshes.iter().enumerate() {
            out.write_all(&mesh.first_triangle.to_le_bytes())?;
            out.write_all(&mesh.triangle_count.to_le_bytes())?;
            let bounds = self.mesh_bounds(m);
            // A box inside out is no number that other programs expect.
            let Aabb { min, max } = if bounds.is_empty() { ZERO } else { bounds };
            floats(out, &min)?;
            floats(out, &max)?;
        }
        for c in &self.cameras {
            floats(out, &c.clip_from_world)?;
            floats(out, &c.eye)?;
            floats(out, &[c.near])?;
        }
        for [min, max] in &self.objects {
            floats(out, min)?;
            floats(out, max)?;
        }
        Ok(())
    }

    /// The contents for a model: instances with
    /// [`no_occlusion`](cullet::InstanceFlags::no_occlusion) are objects, by their bounds, and so
    /// are those of which nothing is opaque; all others are meshes, one each, in world space, with
    /// their opaque triangles; [`Model::views`] are the cameras. Sides, materials, names and levels
    /// are lost. Positions are rounded to f32, so a scene far from 0 loses what f32 loses;
    /// [`make`](Self::make) can count them from a [place](MakeOptions::origin) nearby.
    ///
    /// # Errors
    /// If a count does not fit 32 bits, or an instance has bounds or a transform that are not
    /// finite.
    pub fn from_model(model: &Model) -> Result<Self, ErrorKind> {
        let role = |slot| match model.scene.flags(slot).no_occlusion {
            true => Role::Object,
            false => Role::Occluder,
        };
        let mut out = Self::gather(model, [0.0; 3], role)?;
        out.cameras = model.views.iter().map(OccCamera::from).collect();
        Ok(out)
    }

    /// Instances as what `role` says of their slots, counted from `origin`; no cameras.
    fn gather(
        model: &Model,
        origin: [f64; 3],
        role: impl Fn(u32) -> Role,
    ) -> Result<Self, ErrorKind> {
        let scene = &model.scene;
        let mut out = Self::default();
        let not_finite = |slot: u32| {
            let name = scene.handle(slot).map_or_else(Default::default, |h| model.instance_name(h));
            ErrorKind::invalid(format!("instance {slot} \"{name}\""), "it is not finite")
        };
        // In the order in which they were added, whatever their places.
        let mut slots: Vec<u32> = scene.slots().collect();
        slots.sort_by_key(|&slot| scene.handle(slot));
        for slot in slots {
            let mesh = scene.mesh(slot);
            // A part that is seen through hides nothing.
            let opaque = |part: &&Part| part.alpha == Alpha::Opaque;
            let see_through = scene.flags(slot).transparent
                || (mesh.triangle_count() > 0 && !mesh.parts().iter().any(|p| opaque(&p)));
            match role(slot) {
                Role::Nothing => continue,
                Role::Occluder if !see_through => {}
                Role::Occluder | Role::Object => {
                    let bounds = scene.bounds(slot);
                    let from = std::array::from_fn(|a| scene.origin()[a] - origin[a]);
                    let object = match world_box(scene, slot).filter(|_| !bounds.is_finite()) {
                        // Its bounds are not known, but its vertices are.
                        Some(corners) => {
                            let [low, high] =
                                corners.map(|v| std::array::from_fn(|a| v[a] - origin[a]));
                            let around = Aabb::rounded_out(low, high);
                            [around.min, around.max]
                        }
                        None => in_world(&bounds, from),
                    };
                    if !object.as_flattened().iter().all(|v| v.is_finite()) {
                        return Err(not_finite(slot));
                    }
                    out.objects.push(object);
                    continue;
                }
            }
            let transform = scene.transform(slot);
            let base = fits("vertices", out.vertices.len() + mesh.positions().len())?
                - mesh.positions().len() as u32;
            let first_triangle = fits("triangles", out.triangles.len())?;
            for &p in mesh.positions() {
                let place = world(transform, p);
                let world: [f32; 3] = std::array::from_fn(|a| (place[a] - origin[a]) as f32);
                if !world.iter().all(|v| v.is_finite()) {
                    return Err(not_finite(slot));
                }
                out.vertices.push(world);
            }
            // A mirror turns the winding round; the file has only one.
            let mirrored = transform.determinant() < 0.0;
            // Parts are ranges of the original order, which is the file's.
            let indices = mesh.original_indices();
            let triangles = indices.as_chunks::<3>().0;
            for part in mesh.parts().iter().filter(opaque) {
                let first = part.first_triangle as usize;
                let own = &triangles[first..first + part.triangle_count as usize];
                out.triangles.extend(own.iter().map(|t| {
                    let [a, b, c] = t.map(|v| v + base);
                    if mirrored { [a, c, b] } else { [a, b, c] }
                }));
            }
            let triangle_count = fits("triangles", out.triangles.len())? - first_triangle;
            out.meshes.push(MeshRange { first_triangle, triangle_count });
        }
        Ok(out)
    }
}

/// Role of an instance in the scene that is made.
enum Role {
    /// A mesh, if it is opaque; else an object.
    Occluder,
    /// An object.
    Object,
    /// Neither.
    Nothing,
}

/// Writes a model, as [`Occscn::from_model`] sees it. Pass a buffered writer.
///
/// # Errors
/// As [`Occscn::from_model`] and [`Occscn::write`].
pub fn write(model: &Model, out: &mut impl Write) -> io::Result<()> {
    let scene = Occscn::from_model(model)
        .map_err(|e| io::Error::new(io::ErrorKind::InvalidInput, e.to_string()))?;
    scene.write(out)
}

/// Each mesh is a mesh with an instance `mesh N`; each object an instance `object N` of one unit
/// box, which never serves as an occluder and whose bounds are exactly the file's; each camera a
/// view.
pub(crate) fn read<'o>(
    name: &str,
    bytes: &[u8],
    options: &'o LoadOptions,
) -> Result<Builder<'o>, ErrorKind> {
    let scene = Occscn::parse(bytes)?;
    let mut builder = Builder::new(name, options);
    builder.material("default", Material::GREY);
    let mut compact = Compact::new(scene.vertices.len());
    for (i, mesh) in scene.meshes.iter().enumerate() {
        let mut indices = scene.triangles_of(mesh).as_flattened().to_vec();
        let positions = compact.take(&scene.vertices, &mut indices);
        let data = MeshData { positions, indices, ..MeshData::default() };
        builder.mesh_instance(format!("mesh {i}"), data)?;
    }
    if !scene.objects.is_empty() {
        let unit = builder.mesh("object".into(), unit_box())?;
        let flags = InstanceFlags { no_occlusion: true, ..InstanceFlags::default() };
        for (i, &[min, max]) in scene.objects.iter().enumerate() {
            let scale = std::array::from_fn(|a| inner_extent(min[a], max[a]));
            let transform = Transform::from_scale_translation(scale, min.map(f64::from));
            let bounds = BoundsOverride::World(turned(min, max, options.up.unwrap_or_default()));
            let instance = Instance { flags, bounds, ..Instance::new(unit, transform) };
            builder.instance(format!("object {i}"), instance)?;
        }
    }
    let up = builder.up();
    builder.model.views = scene.cameras.iter().enumerate().map(|(i, c)| view(i, c, &up)).collect();
    Ok(builder)
}

/// The greatest f32 extent that does not carry `min` beyond `max`: what is drawn stays in its
/// bounds.
fn inner_extent(min: f32, max: f32) -> f32 {
    let (min, max) = (f64::from(min), f64::from(max));
    let mut extent = (max - min) as f32;
    while extent > 0.0 && (extent.is_infinite() || min + f64::from(extent) > max) {
        extent = extent.next_down();
    }
    extent
}

fn turned(min: [f32; 3], max: [f32; 3], up: Up) -> Aabb {
    match up {
        Up::Y => Aabb { min, max },
        Up::Z => Aabb { min: [min[0], min[2], -max[1]], max: [max[0], max[2], -min[1]] },
    }
}

/// A view of the turned world: the matrix first turns back.
fn view(i: usize, c: &OccCamera, up: &Transform) -> MatrixView {
    let m = c.clip_from_world.map(f64::from);
    let turn = up.linear.map(|column| column.map(f64::from));
    // The turn is orthogonal: its inverse is its transpose.
    let clip_from_world = std::array::from_fn(|e| {
        let (column, row) = (e / 4, e % 4);
        if column == 3 {
            return m[12 + row];
        }
        (0..3).map(|k| m[k * 4 + row] * turn[k][column]).sum()
    });
    let eye = c.eye.map(f64::from);
    MatrixView {
        name: format!("camera {i}"),
        clip_from_world,
        eye: std::array::from_fn(|r| (0..3).map(|k| turn[k][r] * eye[k]).sum()),
        near: f64::from(c.near),
    }
}

/// The box from 0 to 1, closed and wound outward.
fn unit_box() -> MeshData {
    // Bit a of a corner's number is its coordinate on axis a.
    let positions = (0..8u8).map(|i| [0, 1, 2].map(|a| f32::from(i >> a & 1))).collect();
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let indices = quads.iter().flat_map(|&[a, b, c, d]| [a, b, c, a, c, d]).collect();
    MeshData { positions, indices, polygons: 6, ..MeshData::default() }
}

/// A box that is counted from `origin`, rounded outward.
fn in_world(b: &Aabb, origin: [f64; 3]) -> [[f32; 3]; 2] {
    let at = |v: [f32; 3]| std::array::from_fn(|a| f64::from(v[a]) + origin[a]);
    let b = Aabb::rounded_out(at(b.min), at(b.max));
    [b.min, b.max]
}

fn fits(item: &str, count: usize) -> Result<u32, ErrorKind> {
    u32::try_from(count).map_err(|_| ErrorKind::OverLimit {
        item: item.into(),
        count: count as u64,
        limit: u64::from(u32::MAX),
    })
}

fn words(bytes: &[u8]) -> impl Iterator<Item = [u8; 4]> {
    bytes.as_chunks::<4>().0.iter().copied()
}

fn floats<const N: usize>(bytes: &[u8]) -> [f32; N] {
    let mut words = words(bytes);
    std::array::from_fn(|_| words.next().map_or(0.0, f32::from_le_bytes))
}

fn ints<const N: usize>(bytes: &[u8]) -> [u32; N] {
    let mut words = words(bytes);
    std::array::from_fn(|_| words.next().map_or(0, u32::from_le_bytes))
}
