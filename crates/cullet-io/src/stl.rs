//! STL, ASCII and binary. Each solid is a mesh with one instance; its triangles share the vertices
//! whose coordinates have the same bits. Normals and colours are passed over: winding tells the
//! front.

use cullet::mesh::MeshData;
use cullet::{Instance, Transform};

use crate::blocks::{Records, Source, make_room};
use crate::builder::Builder;
use crate::polygon::{CONCAVE, Triangulator};
use crate::text::{Cursor, quote};
use crate::weld::Welder;
use crate::{ErrorKind, LoadOptions, Material};

/// Comment of a file whose coordinates are counted from a place; its three numbers follow.
pub(crate) const ORIGIN: &str = "written by cullet, from ";
/// Bytes before the first triangle of a binary file: 80 of comment, 4 of count.
const HEADER: u64 = 84;
/// Bytes of a triangle: a normal, three corners, two bytes of attributes.
const TRIANGLE: u64 = 50;

/// Whether `size`, that of a file which begins with `head`, is that of a binary STL with the count
/// that it states. Binary files may begin with "solid" too, so only this tells.
pub(crate) fn is_binary(head: &[u8], size: u64) -> bool {
    stated(head).is_some_and(|n| n > 0 && size == HEADER + u64::from(n) * TRIANGLE)
}

fn stated(head: &[u8]) -> Option<u32> {
    head.get(80..84)?.first_chunk().map(|b| u32::from_le_bytes(*b))
}

pub(crate) fn read<'o>(
    name: &str,
    source: Source<'_>,
    options: &'o LoadOptions,
) -> Result<Builder<'o>, ErrorKind> {
    let mut builder = Builder::new(name, options);
    builder.material("default", Material::GREY);
    let bytes = source.head(Source::HEAD)?;
    let head = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes).trim_ascii_start();
    let solid = head.get(..5).is_some_and(|w| w.eq_ignore_ascii_case(b"solid"));
    // No text has a zero byte.
    let text = !bytes[..bytes.len().min(512)].contains(&0);
    if solid && text && !is_binary(&bytes, source.size()) {
        read_ascii(source, (bytes.len() - head.len()) as u64, &mut builder)?;
    } else {
        read_binary(source, stated(&bytes), origin(&bytes), &mut builder)?;
    }
    Ok(builder)
}

/// The place that coordinates are counted from, as our writer says it in the comment of a file that
/// is far from zero; zero otherwise.
fn origin(head: &[u8]) -> [f64; 3] {
    let place = || {
        let text = std::str::from_utf8(head.get(..80)?).ok()?;
        let mut numbers = text.strip_prefix(ORIGIN)?.split_ascii_whitespace();
        let mut next = || numbers.next()?.parse().ok().filter(|v: &f64| v.is_finite());
        Some([next()?, next()?, next()?])
    };
    place().unwrap_or_default()
}

fn read_binary(
    source: Source<'_>,
    stated: Option<u32>,
    origin: [f64; 3],
    builder: &mut Builder<'_>,
) -> Result<(), ErrorKind> {
    let Some(stated) = stated else {
        return Err(ErrorKind::invalid(
            "file",
            format!(
                "{} bytes, which do not begin with \"solid\", and a binary STL has at least \
                 {HEADER}",
                source.size()
            ),
        ));
    };
    let rest = source.size() - HEADER;
    let (count, need) = (rest / TRIANGLE, u64::from(stated) * TRIANGLE);
    if need > rest {
        return Err(ErrorKind::invalid(
            "header",
            format!(
                "{stated} triangles are stated, which take {need} bytes, but only {rest} are left \
                 (room for {count}); the file is cut short, or not an STL"
            ),
        ));
    }
    if rest > need {
        let more = rest - need;
        builder.warn("file", format!("{more} bytes after the last triangle were ignored"));
    }
    builder.check_triangles(stated as usize)?;
    let mut solid = Solid { origin, ..Solid::new(builder.model.name.clone()) };
    solid.indices.reserve_exact(stated as usize * 3);
    let mut records = Records::new(source, HEADER);
    for t in 0..stated {
        // The size was held against the count.
        let Some(triangle) = records.take::<{ TRIANGLE as usize }>()? else { break };
        // The normal comes first and is often wrong.
        let (corners, _) = triangle[12..].as_chunks::<12>();
        for (k, corner) in corners.iter().take(3).enumerate() {
            let axis = |a: usize| corner[a..].first_chunk().map_or(0.0, |b| f32::from_le_bytes(*b));
            let position = [axis(0), axis(4), axis(8)];
            if !position.iter().all(|v| v.is_finite()) {
                return Err(ErrorKind::invalid(
                    format!("triangle {t}, vertex {k}"),
                    format!("not finite: {position:?}"),
                ));
            }
            let index = solid.welder.weld(position);
            solid.indices.push(index);
        }
    }
    if stated > 0 { solid.finish(builder) } else { Ok(()) }
}

/// A solid that is being read.
struct Solid {
    name: String,
    welder: Welder,
    indices: Vec<u32>,
    polygons: u32,
    origin: [f64; 3],
}

impl Solid {
    fn new(name: String) -> Self {
        Self { name, welder: Welder::new(), indices: Vec::new(), polygons: 0, origin: [0.0; 3] }
    }

    fn finish(self, builder: &mut Builder<'_>) -> Result<(), ErrorKind> {
        let Self { name, welder, indices, polygons, origin } = self;
        let positions = welder.into_positions();
        let data = MeshData { positions, indices, polygons, ..MeshData::default() };
        let mesh = builder.mesh(name.clone(), data)?;
        builder.instance(name, Instance::new(mesh, Transform::from_translation(origin)))
    }
}

fn read_ascii(source: Source<'_>, start: u64, builder: &mut Builder<'_>) -> Result<(), ErrorKind> {
    let mut c = Cursor::new(source);
    c.go_to(start)?;
    let file = builder.model.name.clone();
    let mut solid: Option<Solid> = None;
    let mut corners: Vec<[f32; 3]> = Vec::new();
    let mut loops = Loops::default();
    let (mut triangles, mut vertices, mut unknown) = (0usize, 0u64, (0u64, 0u64, String::new()));
    loop {
        c.skip_lines()?;
        if c.is_end() {
            break;
        }
        let at = c.offset();
        if c.keyword("vertex") {
            let position = read_corner(&mut c, vertices)?;
            vertices += 1;
            corners.push(position);
        } else if c.keyword("facet") {
            if !corners.is_empty() {
                return Err(c.error_at(at, "a facet begins inside another; endfacet is missing"));
            }
            // "normal" and three numbers, which may be anything.
            c.skip_comment();
        } else if c.keyword("endfacet") {
            if corners.len() < 3 {
                return Err(
                    c.error_at(at, format!("a facet of {} vertices, expected 3", corners.len()))
                );
            }
            triangles += corners.len() - 2;
            builder.check_triangles(triangles)?;
            let solid = solid.get_or_insert_with(|| Solid::new(file.clone()));
            loops.add(&corners, solid);
            corners.clear();
        } else if c.keyword("outer") {
            // "loop"
            c.skip_comment();
        } else if c.keyword("solid") {
            let name = String::from_utf8_lossy(&c.rest_of_line()).into_owned();
            finish(&mut solid, &mut triangles, builder)?;
            solid = Some(Solid::new(if name.is_empty() { file.clone() } else { name }));
        } else if c.keyword("endsolid") {
            c.skip_comment();
            finish(&mut solid, &mut triangles, builder)?;
        } else if !c.keyword("endloop") && !c.keyword("loop") {
            if unknown.0 == 0 {
                (unknown.1, unknown.2) = (at, quote(c.token()));
            }
            unknown.0 += 1;
            c.skip_comment();
        }
    }
    let open = solid.is_some();
    if !corners.is_empty() || (open && triangles == 0) {
        return Err(c.error("the file ends inside a solid; it may be cut short"));
    }
    if open {
        builder.warn("file", "its last solid has no endsolid; it may be cut short");
    }
    finish(&mut solid, &mut triangles, builder)?;
    for (count, what) in [
        (loops.polygons, "facets of more than 3 vertices were cut into triangles"),
        (loops.triangulator.fanned, CONCAVE),
    ] {
        if count > 0 {
            builder.warn("file", format!("{count} {what}"));
        }
    }
    if unknown.0 > 0 {
        let (count, first, word) = unknown;
        builder.warn(
            format!("line {}", c.line_of(first)),
            format!("\"{word}\" is not a word of STL; {count} such lines were skipped"),
        );
    }
    Ok(())
}

fn read_corner(c: &mut Cursor<'_>, vertex: u64) -> Result<[f32; 3], ErrorKind> {
    let mut position = [0.0f32; 3];
    for value in &mut position {
        c.skip_blanks();
        let at = c.offset();
        *value = c.f32().ok_or_else(|| c.expected("a coordinate"))?;
        if !value.is_finite() {
            return Err(
                c.error_at(at, format!("vertex {vertex} is not finite in 32 bits: {value}"))
            );
        }
    }
    Ok(position)
}

/// Adds a solid that has triangles; counts of triangles begin again.
fn finish(
    solid: &mut Option<Solid>,
    triangles: &mut usize,
    builder: &mut Builder<'_>,
) -> Result<(), ErrorKind> {
    *triangles = 0;
    match solid.take() {
        Some(solid) if !solid.indices.is_empty() => solid.finish(builder),
        _ => Ok(()),
    }
}

/// Adds facets, of three corners by rule, of more in practice.
#[derive(Default)]
struct Loops {
    ring: Vec<u32>,
    cut: Vec<u32>,
    triangulator: Triangulator,
    /// Facets of more than three corners.
    polygons: u64,
}

impl Loops {
    fn add(&mut self, corners: &[[f32; 3]], solid: &mut Solid) {
        solid.polygons = solid.polygons.saturating_add(1);
        make_room(&mut solid.indices, (corners.len() - 2) * 3);
        if let [_, _, _] = corners {
            solid.indices.extend(corners.iter().map(|&p| solid.welder.weld(p)));
            return;
        }
        self.polygons += 1;
        self.ring.clear();
        self.ring.extend(0..corners.len() as u32);
        self.cut.clear();
        self.triangulator.push(&self.ring, corners, &mut self.cut);
        solid.indices.extend(self.cut.iter().map(|&k| solid.welder.weld(corners[k as usize])));
    }
}
