//! PLY: one mesh of vertices, polygons and triangle strips, in ASCII and both binary orders.
//! Properties may have any type and order. Normals, texture coordinates and colours of vertices are
//! kept where they are wanted; elements and properties that are not geometry are passed over.

mod attributes;
mod header;

use cullet::mesh::MeshData;

use self::attributes::Columns;
use self::header::{Element, Encoding, Header, Scalar};
use crate::blocks::{Records, Source, make_room};
use crate::builder::Builder;
use crate::polygon::{CONCAVE, Triangulator};
use crate::positions::{NotFinite, Positions};
use crate::text::Cursor;
use crate::{Attributes, ErrorKind, LoadOptions, Material};

pub(crate) fn read<'o>(
    name: &str,
    source: Source<'_>,
    options: &'o LoadOptions,
) -> Result<Builder<'o>, ErrorKind> {
    let mut c = Cursor::new(source);
    let header = header::parse(&mut c)?;
    let mut builder = Builder::new(name, options);
    builder.material("default", Material::GREY);
    let body = header.body;
    match header.encoding {
        Encoding::Ascii => {
            c.go_to(body)?;
            let mut values = Ascii { c, body, rows: header.rows(), lines: None, longer: 0 };
            read_rows(&header, &mut values, &mut builder)?;
            if values.longer > 0 {
                let message = format!(
                    "{} rows are longer than the header declares; the rest of their lines was \
                     passed over",
                    values.longer
                );
                builder.warn("file", message);
            }
        }
        Encoding::LittleEndian => {
            let records = Records::new(c.into_source(), body);
            read_rows(&header, &mut Binary::<false> { records }, &mut builder)?;
        }
        Encoding::BigEndian => {
            let records = Records::new(c.into_source(), body);
            read_rows(&header, &mut Binary::<true> { records }, &mut builder)?;
        }
    }
    Ok(builder)
}

/// The values of the body, one after the other. Every 32-bit integer and float is exact in f64.
trait Values {
    /// The next value.
    fn value(&mut self, kind: Scalar, row: &Row<'_>) -> Result<f64, ErrorKind>;
    /// Skips rows of which each has the same size.
    fn skip_fixed(&mut self, element: &Element) -> Result<(), ErrorKind>;
    /// The most values of a type that the bytes left can hold.
    fn most(&self, kind: Scalar) -> u64;
    /// Bytes left.
    fn left(&self) -> u64;
    /// At the end of a row: passes over what its line has beyond it.
    fn end_row(&mut self) {}
    /// The place in the file.
    fn offset(&self) -> u64;
    /// Refines an error with a place, as a line where the file has lines.
    fn error_at(&self, row: &Row<'_>, at: u64, message: String) -> ErrorKind;
    /// Refines an error with this place.
    fn error(&self, row: &Row<'_>, message: String) -> ErrorKind {
        self.error_at(row, self.offset(), message)
    }
}

/// A place in the file, for messages.
struct Row<'a> {
    element: &'a Element,
    row: u64,
    property: usize,
}

impl Row<'_> {
    fn item(&self) -> String {
        let property = self.element.properties.get(self.property);
        let property = property.map_or(String::new(), |p| format!(", property {}", p.name));
        format!("{} {}{property}", self.element.name, self.row)
    }
}

struct Ascii<'a> {
    c: Cursor<'a>,
    /// Where the rows begin, and how many there are.
    body: u64,
    rows: u64,
    /// Whether each row has a line of its own; known once it matters.
    lines: Option<bool>,
    /// Rows whose lines hold more than the header declares.
    longer: u64,
}

impl Ascii<'_> {
    /// Whether the body has a line for each row. Values may stand in lines as they like, so only
    /// then is what follows a row in its line not the next row. Reads the file once more.
    fn has_lines(&self) -> bool {
        let (mut at, mut lines, mut blank) = (0, 0, true);
        self.c.scan(|block| {
            for &b in block {
                let ends = matches!(b, b'\n' | b'\r');
                lines += u64::from(ends && !blank && at >= self.body);
                blank = if ends { true } else { blank && b.is_ascii_whitespace() };
                at += 1;
            }
        });
        lines + u64::from(!blank) >= self.rows
    }
}

impl Values for Ascii<'_> {
    #[inline]
    fn value(&mut self, kind: Scalar, row: &Row<'_>) -> Result<f64, ErrorKind> {
        self.c.skip_lines()?;
        // Rounded once, to the type that the header declares; far from zero the digits stay.
        let value = match kind {
            Scalar::F32 => self.c.coordinate(),
            Scalar::F64 => self.c.f64(),
            _ => {
                let at = self.c.offset();
                match self.c.integer() {
                    Some(value) => Some(value as f64),
                    // Some writers put 255.0 or 3e0 where the header says an integer.
                    None => {
                        self.c.seek(at);
                        self.c.f64()
                    }
                }
            }
        };
        value.ok_or_else(|| match self.c.expected("a number") {
            ErrorKind::Invalid { item, message } => {
                ErrorKind::invalid(format!("{} ({item})", row.item()), message)
            }
            other => other,
        })
    }

    fn skip_fixed(&mut self, element: &Element) -> Result<(), ErrorKind> {
        for row in 0..element.count {
            for (property, p) in element.properties.iter().enumerate() {
                self.value(p.kind, &Row { element, row, property })?;
            }
            self.end_row();
        }
        Ok(())
    }

    #[inline]
    fn end_row(&mut self) {
        self.c.skip_blanks();
        if self.c.at_line_end() {
            return;
        }
        if self.lines.is_none() {
            self.lines = Some(self.has_lines());
        }
        if self.lines == Some(true) {
            self.longer += 1;
            self.c.skip_comment();
        }
    }

    fn offset(&self) -> u64 {
        self.c.offset()
    }

    fn most(&self, _kind: Scalar) -> u64 {
        self.c.left().div_ceil(2)
    }

    fn left(&self) -> u64 {
        self.c.left()
    }

    fn error_at(&self, row: &Row<'_>, at: u64, message: String) -> ErrorKind {
        let line = self.c.line_of(at);
        ErrorKind::invalid(format!("{} (line {line})", row.item()), message)
    }
}

struct Binary<'a, const BIG: bool> {
    records: Records<'a>,
}

impl<const BIG: bool> Binary<'_, BIG> {
    #[inline]
    fn take<const N: usize>(&mut self) -> Result<Option<[u8; N]>, ErrorKind> {
        let mut value = self.records.take::<N>()?;
        if let Some(value) = value.as_mut().filter(|_| BIG) {
            value.reverse();
        }
        Ok(value)
    }
}

impl<const BIG: bool> Values for Binary<'_, BIG> {
    #[inline]
    fn value(&mut self, kind: Scalar, row: &Row<'_>) -> Result<f64, ErrorKind> {
        let value = match kind {
            Scalar::I8 => self.take()?.map(|b| f64::from(i8::from_le_bytes(b))),
            Scalar::U8 => self.take()?.map(|b| f64::from(u8::from_le_bytes(b))),
            Scalar::I16 => self.take()?.map(|b| f64::from(i16::from_le_bytes(b))),
            Scalar::U16 => self.take()?.map(|b| f64::from(u16::from_le_bytes(b))),
            Scalar::I32 => self.take()?.map(|b| f64::from(i32::from_le_bytes(b))),
            Scalar::U32 => self.take()?.map(|b| f64::from(u32::from_le_bytes(b))),
            Scalar::F32 => self.take()?.map(|b| f64::from(f32::from_le_bytes(b))),
            Scalar::F64 => self.take()?.map(f64::from_le_bytes),
        };
        value.ok_or_else(|| self.error(row, "the file ends here; it may be cut short".into()))
    }

    fn skip_fixed(&mut self, element: &Element) -> Result<(), ErrorKind> {
        let size = element.least_bytes(Encoding::LittleEndian) as u64;
        let skip = size.saturating_mul(element.count);
        let left = self.left();
        if skip > left {
            let row = Row { element, row: left / size.max(1), property: usize::MAX };
            return Err(self.error(&row, "the file ends here; it may be cut short".into()));
        }
        self.records.skip(skip);
        Ok(())
    }

    fn most(&self, kind: Scalar) -> u64 {
        self.left() / kind.size() as u64
    }

    fn left(&self) -> u64 {
        self.records.left()
    }

    fn offset(&self) -> u64 {
        self.records.offset()
    }

    fn error_at(&self, row: &Row<'_>, at: u64, message: String) -> ErrorKind {
        ErrorKind::invalid(format!("{} (byte {at})", row.item()), message)
    }
}

/// Reads all rows into one mesh.
fn read_rows(
    header: &Header,
    values: &mut impl Values,
    builder: &mut Builder<'_>,
) -> Result<(), ErrorKind> {
    let vertices: Vec<&Element> = header.elements.iter().filter(|e| e.name == "vertex").collect();
    let [vertex] = vertices[..] else {
        let count = vertices.len();
        return Err(ErrorKind::invalid("header", format!("{count} vertex elements, expected 1")));
    };
    let Ok(vertex_count) = u32::try_from(vertex.count) else {
        let limit = u64::from(u32::MAX);
        return Err(ErrorKind::OverLimit { item: "vertices".into(), count: vertex.count, limit });
    };
    let details = builder.keeps_details();
    let mut out = PlyMesh { vertex_count, details, ..PlyMesh::default() };
    for element in &header.elements {
        match element.name.as_str() {
            // Without properties there are no bytes, and a loop over the rows may never end.
            _ if element.properties.is_empty() => {}
            "vertex" => out.read_vertices(element, values)?,
            "face" | "faces" => out.read_lists(element, values, builder, PlyMesh::polygon)?,
            "tristrips" | "tristrip" => {
                out.read_lists(element, values, builder, PlyMesh::strip)?;
            }
            _ if element.is_fixed() => values.skip_fixed(element)?,
            _ => skip(element, values)?,
        }
    }
    if out.positions.len() != vertex_count as usize {
        return Err(ErrorKind::invalid("header", "element vertex has no properties x, y and z"));
    }
    if let Some(NotFinite { vertex: row, axis, value, at }) = out.positions.first_bad(&out.indices)
    {
        let property = vertex.find(["x", "y", "z"][axis]).unwrap_or(usize::MAX);
        let at_row = Row { element: vertex, row: u64::from(row), property };
        return Err(values.error_at(&at_row, at, format!("not finite in 32 bits: {value}")));
    }
    let left = values.left();
    if left > 0 && header.encoding != Encoding::Ascii {
        builder.warn("file", format!("{left} bytes after the last element were ignored"));
    }
    for (count, what) in [
        (out.short, "faces of fewer than 3 vertices were skipped"),
        (out.triangulator.fanned, CONCAVE),
    ] {
        if count > 0 {
            builder.warn("file", format!("{count} {what}"));
        }
    }
    let count = out.positions.len();
    let PlyMesh { positions, attributes, indices, polygons, .. } = out;
    let (origin, positions) = positions.finish(builder);
    if indices.is_empty() {
        if count > 0 {
            builder.warn("file", format!("its {count} vertices are in no face: a point cloud?"));
        }
        return Ok(());
    }
    let name = builder.model.name.clone();
    if details {
        builder.attributes(attributes);
    }
    let data = MeshData { positions, indices, polygons, ..MeshData::default() };
    builder.mesh_instance_at(name, data, origin)
}

/// The mesh that is being read.
#[derive(Default)]
struct PlyMesh {
    vertex_count: u32,
    /// Whether attributes are kept.
    details: bool,
    positions: Positions,
    attributes: Attributes,
    indices: Vec<u32>,
    polygons: u32,
    list: Vec<u32>,
    triangulator: Triangulator,
    /// Faces of fewer than three vertices.
    short: u64,
}

/// Stands for the index −1, which ends a strip.
const RESTART: u32 = u32::MAX;

impl PlyMesh {
    fn read_vertices(
        &mut self,
        element: &Element,
        values: &mut impl Values,
    ) -> Result<(), ErrorKind> {
        let axes = ["x", "y", "z"]
            .map(|axis| element.find(axis).filter(|&p| element.properties[p].count.is_none()));
        let [Some(x), Some(y), Some(z)] = axes else {
            return Err(ErrorKind::invalid(
                "header",
                "element vertex lacks a property x, y or z, so it has no positions",
            ));
        };
        // The header's count was held against the bytes left.
        self.positions = Positions::with_capacity(self.vertex_count as usize);
        let columns = if self.details { Columns::find(element) } else { Columns::default() };
        columns.reserve(&mut self.attributes, self.vertex_count as usize);
        for row in 0..element.count {
            let mut extra = columns.none();
            let mut position = [0.0; 3];
            for (property, p) in element.properties.iter().enumerate() {
                let at = Row { element, row, property };
                if p.count.is_some() {
                    skip_list(&at, values)?;
                    continue;
                }
                let value = values.value(p.kind, &at)?;
                for (axis, wanted) in [x, y, z].into_iter().enumerate() {
                    if property == wanted {
                        position[axis] = value;
                    }
                }
                columns.take(property, value, &mut extra);
            }
            columns.push(&extra, &mut self.attributes);
            self.positions.push(position, values.offset());
            values.end_row();
        }
        Ok(())
    }

    /// Reads rows whose lists of vertices make a surface.
    fn read_lists<V: Values>(
        &mut self,
        element: &Element,
        values: &mut V,
        builder: &mut Builder<'_>,
        add: fn(&mut Self),
    ) -> Result<(), ErrorKind> {
        let named = ["vertex_indices", "vertex_index"].iter().find_map(|n| element.find(n));
        let is_list = |&p: &usize| element.properties[p].count.is_some();
        let first = (0..element.properties.len()).find(is_list);
        let Some(indices) = named.filter(is_list).or(first) else {
            builder.warn(format!("element {}", element.name), "has no list of vertices; skipped");
            return values.skip_fixed(element);
        };
        // Room for a triangle a row: quads take it twice, and it grows.
        let list = &element.properties[indices];
        let size = list.kind.size() as u64 * 3 + list.count.map_or(0, Scalar::size) as u64;
        let rows = element.count.min(values.left() / size);
        make_room(&mut self.indices, rows as usize * 3);
        for row in 0..element.count {
            for (property, p) in element.properties.iter().enumerate() {
                let at = Row { element, row, property };
                if property == indices {
                    self.read_list(&at, values)?;
                } else if p.count.is_some() {
                    skip_list(&at, values)?;
                } else {
                    values.value(p.kind, &at)?;
                }
            }
            values.end_row();
            add(self);
            builder.check_triangles(self.indices.len() / 3)?;
        }
        Ok(())
    }

    fn read_list(&mut self, at: &Row<'_>, values: &mut impl Values) -> Result<(), ErrorKind> {
        let count = list_length(at, values)?;
        let kind = at.element.properties[at.property].kind;
        let strips = at.element.name.starts_with("tristrip");
        self.list.clear();
        for _ in 0..count {
            let value = values.value(kind, at)?;
            if strips && value == -1.0 {
                self.list.push(RESTART);
                continue;
            }
            // The comparison also refuses NaN.
            if !(value >= 0.0 && value < f64::from(self.vertex_count)) || value.fract() != 0.0 {
                let message = format!(
                    "refers to vertex {value}, but there are only {} (from 0)",
                    self.vertex_count
                );
                return Err(values.error(at, message));
            }
            self.list.push(value as u32);
        }
        Ok(())
    }

    fn polygon(&mut self) {
        if self.list.len() < 3 {
            self.short += 1;
            return;
        }
        self.polygons = self.polygons.saturating_add(1);
        self.positions.cut(&mut self.triangulator, &self.list, &mut self.indices);
    }

    fn strip(&mut self) {
        for strip in self.list.split(|&v| v == RESTART) {
            for (i, t) in strip.windows(3).enumerate() {
                let [a, b] = if i % 2 == 0 { [t[0], t[1]] } else { [t[1], t[0]] };
                make_room(&mut self.indices, 3);
                self.indices.extend([a, b, t[2]]);
                self.polygons = self.polygons.saturating_add(1);
            }
        }
    }
}

/// The number of values of the list that begins here, which the bytes left can hold.
#[inline]
fn list_length(at: &Row<'_>, values: &mut impl Values) -> Result<usize, ErrorKind> {
    let property = &at.element.properties[at.property];
    let count = values.value(property.count.unwrap_or(Scalar::U8), at)?;
    let most = values.most(property.kind);
    if !(count >= 0.0 && count <= most as f64) || count.fract() != 0.0 {
        let message = format!("a list of {count} values, but the bytes left hold at most {most}");
        return Err(values.error(at, message));
    }
    Ok(count as usize)
}

fn skip_list(at: &Row<'_>, values: &mut impl Values) -> Result<(), ErrorKind> {
    let kind = at.element.properties[at.property].kind;
    for _ in 0..list_length(at, values)? {
        values.value(kind, at)?;
    }
    Ok(())
}

fn skip(element: &Element, values: &mut impl Values) -> Result<(), ErrorKind> {
    for row in 0..element.count {
        for (property, p) in element.properties.iter().enumerate() {
            let at = Row { element, row, property };
            if p.count.is_some() {
                skip_list(&at, values)?;
            } else {
                values.value(p.kind, &at)?;
            }
        }
        values.end_row();
    }
    Ok(())
}
