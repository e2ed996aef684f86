//! Wavefront OBJ: polygons in groups. Each object or group is a mesh with one instance, each
//! material of a mesh a part; texture coordinates, normals and colours are kept where they are
//! wanted; smoothing groups, points, lines and free-form surfaces are passed over.

mod attributes;

use std::collections::HashMap;
use std::path::PathBuf;

use cullet::mesh::{Alpha, MeshData, Part};

use self::attributes::{Corners, List};
use crate::beside::Beside;
use crate::blocks::Source;
use crate::builder::Builder;
use crate::compact::Compact;
use crate::polygon::{CONCAVE, Triangulator};
use crate::positions::{NotFinite, Positions};
use crate::text::{Cursor, quote};
use crate::{ErrorKind, LoadOptions, Material, mtl};

/// Triangles of one mesh with one material.
#[derive(Debug, Default)]
struct Bucket {
    mesh: u32,
    material: u32,
    polygons: u32,
    indices: Vec<u32>,
}

/// Numbers names in the order of first sight.
#[derive(Debug, Default)]
struct Names {
    number: HashMap<Vec<u8>, u32>,
    names: Vec<Vec<u8>>,
}

impl Names {
    fn get(&mut self, name: &[u8]) -> u32 {
        if let Some(&number) = self.number.get(name) {
            return number;
        }
        let number = self.names.len() as u32;
        self.number.insert(name.to_vec(), number);
        self.names.push(name.to_vec());
        number
    }
}

/// Counts of statements passed over, for one warning each.
#[derive(Debug, Default)]
struct Skipped {
    points: u64,
    lines: u64,
    flat_faces: u64,
    free_form: u64,
    /// How many statements are unknown.
    unknown: u64,
    /// Where the first of them is, and its word.
    first_unknown: (u64, String),
}

#[derive(Debug)]
struct Reader<'a> {
    c: Cursor<'a>,
    positions: Positions,
    object: Vec<u8>,
    group: Vec<u8>,
    material: Vec<u8>,
    meshes: Names,
    materials: Names,
    buckets: Vec<Bucket>,
    bucket_of: HashMap<(u32, u32), usize>,
    /// The bucket that faces go to; `None` after a change of object, group or material.
    current: Option<usize>,
    libraries: Vec<Vec<u8>>,
    polygon: Vec<u32>,
    triangulator: Triangulator,
    triangles: usize,
    /// The largest index ahead of its vertex, and where it stands.
    ahead: Option<(u32, u64)>,
    statements: u64,
    skipped: Skipped,
    /// Attributes of corners besides positions; `None` where they are not wanted.
    corners: Option<Box<Corners>>,
}

pub(crate) fn read<'o>(
    name: &str,
    source: Source<'_>,
    options: &'o LoadOptions,
    beside: Beside<'_>,
) -> Result<Builder<'o>, ErrorKind> {
    let mut builder = Builder::new(name, options);
    let mut reader = Reader::new(source);
    reader.corners = options.details.then(Box::default);
    reader.read(&builder)?;
    reader.warn(&mut builder);
    let library = reader.library(beside, &mut builder);
    reader.build(name, &library, &mut builder)?;
    Ok(builder)
}

/// The names of the libraries in a line that has more than one.
fn several(names: &[u8]) -> Vec<&[u8]> {
    let all = names.split(u8::is_ascii_whitespace);
    all.filter(|n| !n.is_empty() && n.len() < names.len()).collect()
}

/// The libraries that a file names, separators of Windows read as such; where a line may name one
/// with blanks in it or several, both.
///
/// # Errors
/// If the file cannot be read.
pub(crate) fn named(source: Source<'_>) -> Result<Vec<PathBuf>, ErrorKind> {
    let mut c = Cursor::with_continuations(source);
    let mut files = Vec::new();
    c.skip_mark()?;
    while c.more()? {
        c.skip_blanks();
        // Comments are not joined to the line after.
        if c.at_line_end() || c.peek() == Some(b'#') {
            c.skip_comment();
            c.step();
            continue;
        }
        if c.token() == b"mtllib" {
            let names = c.rest_of_line();
            for name in std::iter::once(&names[..]).chain(several(&names)) {
                files
                    .extend(std::str::from_utf8(name).map(|n| PathBuf::from(n.replace('\\', "/"))));
            }
        }
        c.skip_line();
    }
    Ok(files)
}

impl<'a> Reader<'a> {
    fn new(source: Source<'a>) -> Self {
        Self {
            c: Cursor::with_continuations(source),
            positions: Positions::default(),
            object: Vec::new(),
            group: Vec::new(),
            material: Vec::new(),
            meshes: Names::default(),
            materials: Names::default(),
            buckets: Vec::new(),
            bucket_of: HashMap::new(),
            current: None,
            libraries: Vec::new(),
            polygon: Vec::new(),
            triangulator: Triangulator::default(),
            triangles: 0,
            ahead: None,
            statements: 0,
            skipped: Skipped::default(),
            corners: None,
        }
    }

    fn read(&mut self, builder: &Builder<'_>) -> Result<(), ErrorKind> {
        self.c.skip_mark()?;
        while self.c.more()? {
            self.c.skip_blanks();
            if self.c.at_line_end() || self.c.peek() == Some(b'#') {
                // A backslash that ends a comment is part of a path more often than it joins lines.
                self.c.skip_comment();
                self.c.step();
                continue;
            }
            let start = self.c.offset();
            self.statements += 1;
            match self.c.token() {
                b"v" => self.vertex()?,
                b"f" | b"fo" => {
                    self.face(start)?;
                    builder.check_triangles(self.triangles)?;
                }
                b"vt" => self.attribute(List::Uv)?,
                b"vn" => self.attribute(List::Normal)?,
                b"vp" | b"s" => {}
                b"g" => self.group = self.name(),
                b"o" => {
                    self.object = self.name();
                    // A group belongs to its object.
                    self.group.clear();
                }
                b"usemtl" => self.material = self.name(),
                b"mtllib" => {
                    let names = self.c.rest_of_line();
                    self.libraries.push(names);
                }
                b"p" => self.skipped.points += 1,
                b"l" => self.skipped.lines += 1,
                b"curv" | b"curv2" | b"surf" => self.skipped.free_form += 1,
                b"cstype" | b"deg" | b"bmat" | b"step" | b"parm" | b"trim" | b"hole" | b"scrv"
                | b"sp" | b"end" | b"con" | b"mg" | b"bevel" | b"c_interp" | b"d_interp"
                | b"lod" | b"shadow_obj" | b"trace_obj" | b"ctech" | b"stech" | b"maplib"
                | b"usemap" => {}
                _ => {
                    self.statements -= 1;
                    if self.skipped.unknown == 0 {
                        self.c.seek(start);
                        self.skipped.first_unknown = (start, quote(self.c.token()));
                    }
                    self.skipped.unknown += 1;
                }
            }
            self.c.skip_line();
        }
        let vertices = self.positions.len();
        if let Some((index, at)) = self.ahead.filter(|&(index, _)| index as usize >= vertices) {
            let index = u64::from(index) + 1;
            return Err(self.c.error_at(
                at,
                format!("a face refers to vertex {index}, but there are only {vertices} (from 1)"),
            ));
        }
        if let Some((what, index, count, at)) = self.corners.as_ref().and_then(|c| c.ahead()) {
            return Err(self.c.error_at(
                at,
                format!("a face refers to {what} {index}, but there are only {count} (from 1)"),
            ));
        }
        if let Some(bad) = self.first_bad() {
            let NotFinite { vertex, axis, value, at } = bad;
            return Err(self.c.error_at(
                at,
                format!(
                    "vertex {} is not finite in 32 bits: {} is {value}",
                    u64::from(vertex) + 1,
                    AXES[axis]
                ),
            ));
        }
        if self.statements == 0 && self.skipped.unknown > 0 {
            self.c.go_to(self.skipped.first_unknown.0)?;
            return Err(self.c.expected("a statement of OBJ, such as v or f"));
        }
        Ok(())
    }

    /// The first vertex of a face that is not finite.
    fn first_bad(&self) -> Option<NotFinite> {
        match &self.corners {
            Some(corners) => self.positions.first_bad(&corners.positions()),
            None => self.buckets.iter().find_map(|b| self.positions.first_bad(&b.indices)),
        }
    }

    fn name(&mut self) -> Vec<u8> {
        self.current = None;
        self.c.rest_of_line()
    }

    fn vertex(&mut self) -> Result<(), ErrorKind> {
        let at = self.c.offset();
        let mut position = [0.0; 3];
        for (axis, value) in position.iter_mut().enumerate() {
            self.c.skip_blanks();
            let Some(number) = self.c.coordinate() else {
                return Err(self
                    .c
                    .expected(["x as a number", "y as a number", "z as a number"][axis]));
            };
            *value = number;
        }
        if self.positions.len() == u32::MAX as usize {
            return Err(self.c.error("more vertices than 32-bit indices can name"));
        }
        self.positions.push(position, at);
        if self.corners.is_some() {
            self.color();
        }
        Ok(())
    }

    fn face(&mut self, start: u64) -> Result<(), ErrorKind> {
        self.polygon.clear();
        if let Some(corners) = &mut self.corners {
            corners.begin();
        }
        loop {
            self.c.skip_blanks();
            if self.c.at_line_end() || self.c.peek() == Some(b'#') {
                break;
            }
            let at = self.c.offset();
            let index = self.c.integer_prefix();
            let rest = self.c.token();
            let whole = matches!(rest, [] | [b'/', ..]);
            let named = match &mut self.corners {
                Some(corners) => corners.name(rest, at),
                None => true,
            };
            let Some(index) = index.filter(|_| whole && named) else {
                self.c.seek(at);
                return Err(self.c.expected("a vertex of the form v, v/vt, v//vn or v/vt/vn"));
            };
            let vertex = self.resolve(index, at)?;
            self.polygon.push(vertex);
        }
        if self.polygon.len() < 3 {
            self.skipped.flat_faces += 1;
            return Ok(());
        }
        self.triangles += self.polygon.len() - 2;
        let bucket = match self.current {
            Some(bucket) => bucket,
            None => self.open_bucket(start)?,
        };
        let bucket = &mut self.buckets[bucket];
        bucket.polygons += 1;
        let first = bucket.indices.len();
        self.positions.cut(&mut self.triangulator, &self.polygon, &mut bucket.indices);
        if let Some(corners) = &mut self.corners
            && !corners.resolve(&self.polygon, &mut bucket.indices[first..])
        {
            return Err(self.c.error("more corners than 32-bit indices can name"));
        }
        Ok(())
    }

    /// The vertex, from 0, of an index that counts from 1, or back from the last vertex so far.
    #[inline]
    fn resolve(&mut self, index: i64, at: u64) -> Result<u32, ErrorKind> {
        let vertices = self.positions.len() as i64;
        let vertex = if index < 0 { index.saturating_add(vertices) } else { index - 1 };
        if vertex < 0 {
            let message = if index == 0 {
                "a face refers to vertex 0, but vertices count from 1".to_owned()
            } else {
                format!("a face refers {} vertices back, but there are only {vertices}", -index)
            };
            return Err(self.c.error_at(at, message));
        }
        let limit = i64::from(u32::MAX);
        let vertex = u32::try_from(vertex).ok().filter(|&v| v < u32::MAX).ok_or_else(|| {
            self.c.error_at(at, format!("a face refers to vertex {index}; the limit is {limit}"))
        })?;
        if i64::from(vertex) >= vertices && self.ahead.is_none_or(|(most, _)| vertex > most) {
            self.ahead = Some((vertex, at));
        }
        Ok(vertex)
    }

    fn open_bucket(&mut self, start: u64) -> Result<usize, ErrorKind> {
        let name = match (self.object.is_empty(), self.group.is_empty()) {
            (false, false) => [&self.object[..], b"/", &self.group[..]].concat(),
            (false, true) => self.object.clone(),
            _ => self.group.clone(),
        };
        let mesh = self.meshes.get(&name);
        let material = self.materials.get(&self.material);
        let next = self.buckets.len();
        if next == u32::MAX as usize {
            return Err(self.c.error_at(start, "too many groups"));
        }
        let bucket = *self.bucket_of.entry((mesh, material)).or_insert(next);
        if bucket == next {
            self.buckets.push(Bucket { mesh, material, ..Bucket::default() });
        }
        self.current = Some(bucket);
        Ok(bucket)
    }

    fn warn(&self, builder: &mut Builder<'_>) {
        let s = &self.skipped;
        for (count, what) in [
            (s.points, "point statements were skipped: only faces have a surface"),
            (s.lines, "line statements were skipped: only faces have a surface"),
            (s.flat_faces, "faces of fewer than 3 vertices were skipped"),
            (s.free_form, "free-form curves and surfaces were skipped: export them as polygons"),
            (self.triangulator.fanned, CONCAVE),
        ] {
            if count > 0 {
                builder.warn("file", format!("{count} {what}"));
            }
        }
        let count = self.positions.len();
        if self.triangles == 0 && count > 0 {
            builder.warn("file", format!("its {count} vertices are in no face: a point cloud?"));
        }
        if s.unknown > 0 {
            let (first, word) = &s.first_unknown;
            builder.warn(
                format!("line {}", self.c.line_of(*first)),
                format!(
                    "\"{word}\" is not a statement of OBJ; {} such lines were skipped",
                    s.unknown
                ),
            );
        }
    }

    /// The materials of the libraries that the file names; what cannot be read is a warning.
    fn library(&self, beside: Beside<'_>, builder: &mut Builder<'_>) -> mtl::Library {
        let mut library = mtl::Library::new();
        for names in &self.libraries {
            let item = format!("material library \"{}\"", quote(names));
            // One name with blanks in it, or several names.
            let Err(whole) = mtl::read(beside, names, &mut library) else { continue };
            let several = several(names);
            if several.is_empty() {
                builder.warn(item, format!("it was not read, so materials are grey: {whole}"));
            }
            for name in several {
                if let Err(why) = mtl::read(beside, name, &mut library) {
                    let item = format!("material library \"{}\"", quote(name));
                    builder.warn(item, format!("it was not read, so materials are grey: {why}"));
                }
            }
        }
        library
    }

    fn build(
        mut self,
        name: &str,
        library: &mtl::Library,
        builder: &mut Builder<'_>,
    ) -> Result<(), ErrorKind> {
        let mut alphas = Vec::with_capacity(self.materials.names.len());
        for material in &self.materials.names {
            let found = library.get(material);
            let shown = if material.is_empty() {
                "default".to_owned()
            } else {
                String::from_utf8_lossy(material).into_owned()
            };
            builder.material(shown, found.map_or(Material::GREY, |m| m.color));
            alphas.push(found.map_or(Alpha::Opaque, |m| m.alpha));
            builder.model.textures += found.map_or(0, |m| m.textures);
        }
        // Each is shrunk while the others wait: what was made too large never adds up with copies.
        let (origin, mut positions) = self.positions.finish(builder);
        self.buckets.iter_mut().for_each(|b| b.indices.shrink_to_fit());
        // Stable: the parts of a mesh stay in the order of first use.
        self.buckets.sort_by_key(|b| b.mesh);
        let mut corners = self.corners.take();
        if let Some(corners) = &mut corners {
            corners.close();
        }
        let one_mesh = self.meshes.names.len() == 1 && corners.is_none();
        let shared = corners.as_ref().map_or(positions.len(), |c| c.len());
        let mut compact = Compact::new(if one_mesh { 0 } else { shared });
        let mut buckets = self.buckets.into_iter().peekable();
        while let Some(first) = buckets.next() {
            let mesh = first.mesh;
            let mut own = vec![first];
            while let Some(bucket) = buckets.next_if(|b| b.mesh == mesh) {
                own.push(bucket);
            }
            let all: usize = own.iter().map(|b| b.indices.len()).sum();
            let mut data = MeshData::default();
            for bucket in own {
                data.parts.push(Part {
                    first_triangle: (data.indices.len() / 3) as u32,
                    triangle_count: (bucket.indices.len() / 3) as u32,
                    material: bucket.material,
                    two_sided: true,
                    alpha: alphas[bucket.material as usize],
                });
                data.polygons = data.polygons.saturating_add(bucket.polygons);
                if bucket.indices.len() == all {
                    data.indices = bucket.indices;
                } else {
                    data.indices.reserve_exact(all - data.indices.len());
                    data.indices.extend_from_slice(&bucket.indices);
                }
            }
            data.positions = if one_mesh {
                std::mem::take(&mut positions)
            } else if let Some(corners) = &corners {
                let (own, attributes) = corners.take(&positions, &mut compact, &mut data.indices);
                builder.attributes(attributes);
                own
            } else {
                compact.take(&positions, &mut data.indices)
            };
            let shown = match &self.meshes.names[mesh as usize][..] {
                [] => name.to_owned(),
                group => String::from_utf8_lossy(group).into_owned(),
            };
            builder.mesh_instance_at(shown, data, origin)?;
        }
        Ok(())
    }
}

const AXES: [&str; 3] = ["x", "y", "z"];
