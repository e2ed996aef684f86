//! The header of a PLY file: elements, and the properties of each.

use crate::ErrorKind;
use crate::text::{Cursor, quote};

/// How values are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The type of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn parse(word: &[u8]) -> Option<Self> {
        Some(match word {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes of a value in the binary encodings.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    pub(super) fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }
}

/// A property of an element.
#[derive(Clone, Debug)]
pub(super) struct PlyProperty {
    pub(super) name: String,
    /// The type of the value, or of each value of the list.
    pub(super) kind: Scalar,
    /// The type of the number of values, where it is a list.
    pub(super) count: Option<Scalar>,
}

/// A kind of row: vertices, faces, and whatever else.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<PlyProperty>,
    /// Where its count stands, for messages.
    at: u64,
}

impl Element {
    /// The property of a name.
    pub(super) fn find(&self, name: &str) -> Option<usize> {
        self.properties.iter().position(|p| p.name == name)
    }

    /// Bytes that a row takes at least.
    pub(super) fn least_bytes(&self, encoding: Encoding) -> usize {
        match encoding {
            // A digit and a blank.
            Encoding::Ascii => self.properties.len() * 2,
            _ => self.properties.iter().map(|p| p.count.unwrap_or(p.kind).size()).sum(),
        }
    }

    /// Whether all its rows have the same size.
    pub(super) fn is_fixed(&self) -> bool {
        self.properties.iter().all(|p| p.count.is_none())
    }
}

/// The header, and where the rows begin.
#[derive(Clone, Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    pub(super) body: u64,
}

/// Parses the header, at the begin of a file.
pub(super) fn parse(c: &mut Cursor<'_>) -> Result<Header, ErrorKind> {
    c.more()?;
    // The first line tells how lines end; what follows the header may begin with the byte of one.
    let line_end: &[u8] = match c.rest().get(3..) {
        Some([b'\r', b'\n', ..]) => b"\r\n",
        Some([b'\r', ..]) => b"\r",
        _ => b"\n",
    };
    if !c.keyword("ply") || !c.at_line_end() {
        c.seek(0);
        return Err(c.expected("\"ply\""));
    }
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    loop {
        c.skip_lines()?;
        if c.is_end() {
            return Err(c.error("the header has no end_header"));
        }
        let start = c.offset();
        match c.token() {
            b"comment" | b"obj_info" | b"" => c.skip_comment(),
            b"format" => encoding = Some(parse_format(c)?),
            b"element" => elements.push(parse_element(c)?),
            b"property" => {
                let property = parse_property(c)?;
                let Some(element) = elements.last_mut() else {
                    return Err(c.error_at(start, "a property comes before the first element"));
                };
                element.properties.push(property);
            }
            b"end_header" => break,
            _ => {
                c.seek(start);
                return Err(c.expected("format, element, property, comment or end_header"));
            }
        }
        if !c.at_line_end() {
            c.skip_blanks();
            if !c.at_line_end() {
                return Err(c.expected("the end of the line"));
            }
        }
    }
    let Some(encoding) = encoding else {
        return Err(c.error("the header has no format line"));
    };
    // Blanks after end_header belong to its line, but in a binary file only if the line end
    // follows.
    let end = c.offset();
    c.skip_blanks();
    if !c.at_line_end() {
        c.seek(end);
    }
    let body = c.offset();
    let length = if c.rest().starts_with(line_end) {
        line_end.len() as u64
    } else {
        u64::from(c.at_line_end() && !c.is_end())
    };
    let header = Header { encoding, elements, body: body + length };
    header.check(c)?;
    Ok(header)
}

impl Header {
    /// How many rows have values.
    pub(super) fn rows(&self) -> u64 {
        let counts = self.elements.iter().filter(|e| !e.properties.is_empty()).map(|e| e.count);
        counts.fold(0, u64::saturating_add)
    }

    /// Holds each count against the bytes that are left, so that nothing is allocated on a claim.
    fn check(&self, c: &Cursor<'_>) -> Result<(), ErrorKind> {
        // The last value of an ASCII file needs no blank after it.
        let file = c.offset() + c.left();
        let mut left = file - self.body + u64::from(self.encoding == Encoding::Ascii);
        for e in &self.elements {
            let least = e.least_bytes(self.encoding) as u64;
            let need = least.saturating_mul(e.count);
            if need > left {
                return Err(c.error_at(
                    e.at,
                    format!(
                        "element {} has {} rows of at least {least} bytes, but only {left} bytes \
                         are left; the file may be cut short",
                        e.name, e.count
                    ),
                ));
            }
            left -= need;
        }
        Ok(())
    }
}

fn parse_format(c: &mut Cursor<'_>) -> Result<Encoding, ErrorKind> {
    c.skip_blanks();
    let encoding = if c.keyword("ascii") {
        Encoding::Ascii
    } else if c.keyword("binary_little_endian") {
        Encoding::LittleEndian
    } else if c.keyword("binary_big_endian") {
        Encoding::BigEndian
    } else {
        return Err(c.expected("ascii, binary_little_endian or binary_big_endian"));
    };
    // The version has been 1.0 since 1994.
    c.skip_comment();
    Ok(encoding)
}

fn parse_element(c: &mut Cursor<'_>) -> Result<Element, ErrorKind> {
    c.skip_blanks();
    let name = quote(c.token());
    c.skip_blanks();
    let at = c.offset();
    let count = c.integer().and_then(|n| u64::try_from(n).ok());
    let Some(count) = count else {
        return Err(c.expected("a count of rows"));
    };
    Ok(Element { name, count, properties: Vec::new(), at })
}

fn parse_property(c: &mut Cursor<'_>) -> Result<PlyProperty, ErrorKind> {
    c.skip_blanks();
    let kind = |c: &mut Cursor<'_>| {
        c.skip_blanks();
        let start = c.offset();
        Scalar::parse(c.token()).ok_or_else(|| {
            c.seek(start);
            c.expected("a type: char, uchar, short, ushort, int, uint, float or double")
        })
    };
    let (count, kind) = if c.keyword("list") {
        let start = c.offset();
        let count = kind(c)?;
        if count.is_float() {
            return Err(c.error_at(start, "the length of a list must have an integer type"));
        }
        (Some(count), kind(c)?)
    } else {
        (None, kind(c)?)
    };
    c.skip_blanks();
    Ok(PlyProperty { name: quote(c.token()), kind, count })
}
