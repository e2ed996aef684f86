//! OFF, the text format of Geomview: one mesh of polygons. Texture coordinates, normals and colours
//! of the variants STOFF, NOFF, COFF and their mixtures are passed over; so are comments from `#`
//! on.

use cullet::mesh::MeshData;

use crate::blocks::{Source, make_room};
use crate::builder::Builder;
use crate::polygon::{CONCAVE, Triangulator};
use crate::positions::{NotFinite, Positions};
use crate::text::Cursor;
use crate::{ErrorKind, LoadOptions, Material};

/// The keyword at the begin of a word, `[ST][C][N][4][n]OFF`; the first count may follow it without
/// a blank, as in all files of `ModelNet`.
pub(crate) fn keyword(word: &[u8]) -> Option<&[u8]> {
    let digits = word.iter().rev().take_while(|b| b.is_ascii_digit()).count();
    let keyword = &word[..word.len() - digits];
    let mut flags = keyword.strip_suffix(b"OFF")?;
    for flag in [&b"ST"[..], b"C", b"N", b"4", b"n"] {
        flags = flags.strip_prefix(flag).unwrap_or(flags);
    }
    flags.is_empty().then_some(keyword)
}

/// Bytes that a vertex or a face takes at least, such as "0 0 0\n" or "3 0 1 2\n" (and "0\n").
const LEAST_VERTEX: u64 = 6;
const LEAST_FACE: u64 = 2;
const LEAST_TRIANGLE: u64 = 8;

pub(crate) fn read<'o>(
    name: &str,
    source: Source<'_>,
    options: &'o LoadOptions,
) -> Result<Builder<'o>, ErrorKind> {
    let mut builder = Builder::new(name, options);
    builder.material("default", Material::GREY);
    let mut c = Cursor::new(source);
    c.skip_mark()?;
    let [vertices, faces] = read_header(&mut c)?;
    let mut positions = Positions::with_capacity(vertices as usize);
    for vertex in 0..vertices {
        c.skip_space()?;
        let at = c.offset();
        positions.push(read_vertex(&mut c, vertex)?, at);
    }
    let mut triangulator = Triangulator::default();
    let mut indices = Vec::new();
    // A triangle takes four times the least face; the counts were held against the bytes left.
    make_room(&mut indices, 3 * faces.min(c.left() / LEAST_TRIANGLE) as usize);
    let mut polygon = Vec::new();
    let (mut polygons, mut short) = (0u32, 0u64);
    for face in 0..faces {
        read_face(&mut c, face, positions.len(), &mut polygon)?;
        if polygon.len() < 3 {
            short += 1;
            continue;
        }
        polygons = polygons.saturating_add(1);
        positions.cut(&mut triangulator, &polygon, &mut indices);
        builder.check_triangles(indices.len() / 3)?;
    }
    c.skip_space()?;
    if !c.is_end() {
        let line = c.line_of(c.offset());
        builder.warn(format!("line {line}"), "what follows the last face was ignored");
    }
    if let Some(NotFinite { vertex, value, at, .. }) = positions.first_bad(&indices) {
        let message = format!("vertex {vertex} is not finite in 32 bits: {value}");
        return Err(c.error_at(at, message));
    }
    for (count, what) in
        [(short, "faces of fewer than 3 vertices were skipped"), (triangulator.fanned, CONCAVE)]
    {
        if count > 0 {
            builder.warn("file", format!("{count} {what}"));
        }
    }
    let count = positions.len();
    let (origin, positions) = positions.finish(&mut builder);
    if indices.is_empty() && count > 0 {
        builder.warn("file", format!("its {count} vertices are in no face: a point cloud?"));
    }
    if !indices.is_empty() {
        let data = MeshData { positions, indices, polygons, ..MeshData::default() };
        builder.mesh_instance_at(name.to_owned(), data, origin)?;
    }
    Ok(builder)
}

/// The keyword and the counts of vertices and faces, held against the bytes left.
fn read_header(c: &mut Cursor<'_>) -> Result<[u64; 2], ErrorKind> {
    c.skip_space()?;
    let start = c.offset();
    let word = c.token().to_vec();
    if let Some(keyword) = keyword(&word) {
        c.seek(start + keyword.len() as u64);
        let flags = &keyword[..keyword.len() - 3];
        if flags.contains(&b'4') || flags.contains(&b'n') {
            let word = String::from_utf8_lossy(keyword);
            return Err(ErrorKind::Unsupported(format!(
                "{word}: vertices of four or more dimensions are not loaded; export plain OFF"
            )));
        }
        c.skip_space()?;
        if c.keyword("BINARY") {
            return Err(ErrorKind::Unsupported(
                "binary OFF is not loaded; export it as text, or as binary PLY".into(),
            ));
        }
    } else {
        // The keyword is optional.
        c.seek(start);
    }
    let mut counts = [0u64; 2];
    for (k, count) in counts.iter_mut().enumerate() {
        c.skip_space()?;
        let at = c.offset();
        let what = ["the number of vertices", "the number of faces"][k];
        let value = c.integer().and_then(|v| u64::try_from(v).ok());
        let Some(value) = value else {
            c.seek(at);
            return Err(c.expected(what));
        };
        *count = value;
        let least = [LEAST_VERTEX, LEAST_FACE][k];
        // One byte more: the last row needs no line end.
        let most = (c.left() + 1) / least;
        if *count > most || *count > u64::from(u32::MAX) {
            return Err(c.error_at(
                at,
                format!("{what} is {count}, but the {} bytes left hold at most {most}", c.left()),
            ));
        }
    }
    // The number of edges may be missing, and never matters.
    c.skip_comment();
    Ok(counts)
}

/// The first three numbers; whatever else the line has is a normal, a colour or a texture
/// coordinate.
fn read_vertex(c: &mut Cursor<'_>, vertex: u64) -> Result<[f64; 3], ErrorKind> {
    let mut position = [0.0; 3];
    for value in &mut position {
        c.skip_space()?;
        let number = c.coordinate();
        *value = number.ok_or_else(|| c.expected(&format!("a coordinate of vertex {vertex}")))?;
    }
    c.skip_comment();
    Ok(position)
}

fn read_face(
    c: &mut Cursor<'_>,
    face: u64,
    vertices: usize,
    polygon: &mut Vec<u32>,
) -> Result<(), ErrorKind> {
    c.skip_space()?;
    let at = c.offset();
    let Some(count) = c.integer().and_then(|v| u64::try_from(v).ok()) else {
        c.seek(at);
        return Err(c.expected(&format!("the size of face {face}")));
    };
    polygon.clear();
    for _ in 0..count {
        c.skip_space()?;
        let at = c.offset();
        let index = c.integer().ok_or_else(|| c.expected(&format!("an index of face {face}")))?;
        let known = usize::try_from(index).is_ok_and(|i| i < vertices);
        if !known {
            return Err(c.error_at(
                at,
                format!(
                    "face {face} refers to vertex {index}, but there are only {vertices} (from 0)"
                ),
            ));
        }
        polygon.push(index as u32);
    }
    // A colour may follow.
    c.skip_comment();
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keywords() {
        for word in [&b"OFF"[..], b"COFF", b"NOFF", b"CNOFF", b"STOFF", b"STCN4nOFF", b"4OFF"] {
            assert_eq!(keyword(word), Some(word));
        }
        assert_eq!(keyword(b"OFF216"), Some(&b"OFF"[..]));
        assert_eq!(keyword(b"COFF8"), Some(&b"COFF"[..]));
        for word in [&b"off"[..], b"OFFX", b"XOFF", b"NCOFF", b"OF", b"", b"12", b"OFF1x"] {
            assert_eq!(keyword(word), None);
        }
    }
}
