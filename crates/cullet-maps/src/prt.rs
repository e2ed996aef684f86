//! `.prt`, the portal graphs that map compilers of the Quake family write: cells and the portals
//! between them, as text.
//!
//! Three variants, told by the first word; after it follow, all parted by blanks:
//!
//! | word | header | after the portals |
//! |---|---|---|
//! | `PRT1` | clusters, portals | nothing; from a compiler for Quake 3, whose header has a third number, its faces |
//! | `PRT2` | leafs, clusters, portals | the leafs of each cluster, each list ended by −1 |
//! | `PRT1-AM` | clusters, portals, leafs | the cluster of each leaf |
//!
//! A portal is `n a b (x y z) ...`, n times, with one number more for Quake 3 (a hint of the
//! mapper's). A cluster becomes a cell of the [`CellGraph`]. Leafs are what the map's own tree has;
//! a cluster may hold several.

use std::path::Path;

use cullet_cells::cell::{CellError, CellGraph, Portal};
use glam::DVec3;

use cullet_io::reader::Source;
use cullet_io::reader::quote;
use cullet_io::{ErrorKind, LoadError};

/// Bytes that a portal takes at least: `3 0 1(0 0 0)(0 0 0)(0 0 0)`.
const LEAST_PORTAL: u64 = 26;
/// And a corner of it: `(0 0 0)`.
const LEAST_CORNER: u64 = 7;
/// Bytes that a leaf of a list takes at least, and a cluster with its end: `0 ` and `-1 `.
const LEAST_LEAF: u64 = 2;
const LEAST_LIST: u64 = 3;

/// A variant of the format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PrtVariant {
    /// `PRT1`: one leaf a cluster, or the map's file says which.
    Prt1,
    /// `PRT1` with faces and a hint for each portal.
    Quake3,
    /// `PRT2`: the leafs of each cluster.
    Prt2,
    /// `PRT1-AM`: the cluster of each leaf.
    Prt1Am,
}

/// A portal graph, and which leafs its cells hold.
#[derive(Clone, Debug)]
pub struct Prt {
    /// The variant of the file.
    pub variant: PrtVariant,
    /// Cells (clusters) and portals, in the order of the file.
    pub graph: CellGraph,
    /// The cluster of each leaf. Leaf k here is leaf k + 1 of the map, whose first is solid.
    pub leaf_clusters: Vec<u32>,
    /// How many portals have corners the other way around than the rest of the file, judged by
    /// where the other portals of their cells lie. They were turned; more than 0 tells of an odd
    /// compiler.
    pub turned: u32,
}

/// Loads a portal graph.
///
/// # Errors
/// If the file cannot be read, is no `.prt`, is cut short, or has a portal that [`CellGraph::new`]
/// refuses; the error names the file, the line, the portal and the value. Counts are held against
/// the bytes of the file before anything is allocated.
pub fn load_prt(path: &Path) -> Result<Prt, LoadError> {
    let read = || parse(&Source::open(path)?.into_bytes()?);
    read().map_err(|kind| kind.at(path))
}

/// Reads a portal graph from memory; `name` stands for the file's in messages.
///
/// # Errors
/// As [`load_prt`].
pub fn load_prt_bytes(name: &str, bytes: &[u8]) -> Result<Prt, LoadError> {
    parse(bytes).map_err(|kind| kind.at(Path::new(name)))
}

fn parse(bytes: &[u8]) -> Result<Prt, ErrorKind> {
    let mut text = Text { bytes, at: 0 };
    let mut variant = match text.word() {
        b"PRT1" => PrtVariant::Prt1,
        b"PRT2" => PrtVariant::Prt2,
        b"PRT1-AM" => PrtVariant::Prt1Am,
        other => {
            return Err(ErrorKind::Unsupported(format!(
                "it begins with \"{}\", not with PRT1, PRT2 or PRT1-AM: no portal file of a Quake-like map",
                quote(&other[..other.len().min(40)])
            )));
        }
    };
    let mut leafs = match variant {
        PrtVariant::Prt2 => text.count("leafs", LEAST_LEAF)?,
        _ => 0,
    };
    // Each cell but a lonely one has a portal, so that no honest file has more cells than bytes.
    let list = if variant == PrtVariant::Prt2 { LEAST_LIST } else { 1 };
    let clusters = text.count("clusters", list)?;
    let portal_count = text.count("portals", LEAST_PORTAL)?;
    match variant {
        PrtVariant::Prt1Am => leafs = text.count("leafs", LEAST_LEAF)?,
        // A number alone on its line cannot begin a portal.
        PrtVariant::Prt1 if text.is_alone() => {
            text.count("faces", LEAST_PORTAL - 2)?;
            variant = PrtVariant::Quake3;
        }
        _ => {}
    }
    let mut portals = Vec::with_capacity(portal_count as usize);
    let mut places = Vec::with_capacity(portal_count as usize);
    for number in 0..portal_count {
        text.skip_blanks();
        places.push(text.at);
        portals.push(read_portal(&mut text, number, variant)?);
    }
    let leaf_clusters = match variant {
        PrtVariant::Prt2 => read_lists(&mut text, leafs, clusters)?,
        PrtVariant::Prt1Am => read_clusters(&mut text, leafs, clusters)?,
        PrtVariant::Prt1 | PrtVariant::Quake3 => (0..clusters).collect(),
    };
    // Faces are of no use here.
    text.skip_blanks();
    if variant != PrtVariant::Quake3 && text.at < bytes.len() {
        return Err(text.expected("the end of the file"));
    }
    let turned = orient(&mut portals, clusters);
    let graph = CellGraph::new(clusters, portals).map_err(|error| match error {
        CellError::Portal { portal, .. } => {
            let place = places.get(portal as usize).copied().unwrap_or(0);
            text.error_at(place, error.to_string())
        }
        error => ErrorKind::invalid("portals", error.to_string()),
    })?;
    Ok(Prt { variant, graph, leaf_clusters, turned })
}

fn read_portal(text: &mut Text<'_>, number: u32, variant: PrtVariant) -> Result<Portal, ErrorKind> {
    let of = |what: &str| format!("{what} of portal {number}");
    let at = text.at;
    let corners = text.integer(&of("the number of corners"))?;
    let most = (text.left() + 1) / LEAST_CORNER;
    if corners < 3 || corners as u64 > most {
        return Err(text.error_at(
            at,
            format!("portal {number} has {corners} corners; 3 to {most} fit the bytes left"),
        ));
    }
    let mut cells = [0; 2];
    for cell in &mut cells {
        let at = text.at;
        let value = text.integer(&of("a cluster"))?;
        // Whether there is such a cell the graph says.
        *cell = u32::try_from(value)
            .map_err(|_| text.error_at(at, format!("portal {number} names cluster {value}")))?;
    }
    if variant == PrtVariant::Quake3 {
        text.integer(&of("the hint"))?;
    }
    let mut polygon = Vec::with_capacity(corners as usize);
    for _ in 0..corners {
        text.mark(b'(', &of("the parenthesis before a corner"))?;
        let mut corner = [0.0; 3];
        for value in &mut corner {
            *value = text.number(&of("a coordinate"))?;
        }
        text.mark(b')', &of("the parenthesis after a corner"))?;
        polygon.push(corner);
    }
    Ok(Portal { cells, polygon })
}

/// The leafs of each cluster, as the cluster of each leaf.
fn read_lists(text: &mut Text<'_>, leafs: u32, clusters: u32) -> Result<Vec<u32>, ErrorKind> {
    const NONE: u32 = u32::MAX;
    let mut owner = vec![NONE; leafs as usize];
    for cluster in 0..clusters {
        loop {
            text.skip_blanks();
            let at = text.at;
            let leaf = text.integer(&format!("a leaf of cluster {cluster}, or -1"))?;
            if leaf == -1 {
                break;
            }
            let slot = usize::try_from(leaf).ok().and_then(|leaf| owner.get_mut(leaf));
            let Some(slot) = slot else {
                let message =
                    format!("cluster {cluster} has leaf {leaf}, of {leafs} numbered from 0");
                return Err(text.error_at(at, message));
            };
            if *slot != NONE {
                let message = format!("leaf {leaf} is in clusters {} and {cluster}", *slot);
                return Err(text.error_at(at, message));
            }
            *slot = cluster;
        }
    }
    match owner.iter().position(|&cluster| cluster == NONE) {
        Some(leaf) => Err(text.error_at(text.at, format!("leaf {leaf} is in no cluster"))),
        None => Ok(owner),
    }
}

/// The cluster of each leaf.
fn read_clusters(text: &mut Text<'_>, leafs: u32, clusters: u32) -> Result<Vec<u32>, ErrorKind> {
    let mut owner = Vec::with_capacity(leafs as usize);
    for leaf in 0..leafs {
        text.skip_blanks();
        let at = text.at;
        let cluster = text.integer(&format!("the cluster of leaf {leaf}"))?;
        let fine = u32::try_from(cluster).ok().filter(|&c| c < clusters);
        owner.push(fine.ok_or_else(|| {
            text.error_at(
                at,
                format!("leaf {leaf} is in cluster {cluster}, of {clusters} numbered from 0"),
            )
        })?);
    }
    Ok(owner)
}

/// Turns the polygons so that they are counter-clockwise as seen from their first cell; how many
/// differ from the rest.
///
/// Compilers wind all portals alike, most of them the other way, but no two agree on paper. So the
/// cells themselves decide: the other portals of the first cell lie on its side of the portal.
/// Where they do not tell, as in a cell with one portal or one that is not convex, the custom of
/// the file decides.
fn orient(portals: &mut [Portal], clusters: u32) -> u32 {
    let mut sums = vec![(DVec3::ZERO, 0.0); clusters as usize];
    let middle = |p: &Portal| {
        p.polygon.iter().map(|&v| DVec3::from(v)).sum::<DVec3>() / p.polygon.len() as f64
    };
    for portal in &*portals {
        for cell in portal.cells {
            if let Some((sum, count)) = sums.get_mut(cell as usize) {
                *sum += middle(portal);
                *count += 1.0;
            }
        }
    }
    // Positive where the normal by the right hand points to the first cell.
    let told: Vec<f64> = portals
        .iter()
        .map(|portal| {
            let own = middle(portal);
            let [a, b] = portal.cells.map(|cell| match sums.get(cell as usize) {
                Some(&(sum, count)) if count > 1.0 => (sum - own) / (count - 1.0) - own,
                _ => DVec3::ZERO,
            });
            let first = DVec3::from(portal.polygon[0]);
            let edge = |k: usize| DVec3::from(portal.polygon[k]) - first;
            let normal: DVec3 = (2..portal.polygon.len()).map(|k| edge(k - 1).cross(edge(k))).sum();
            let size = portal.polygon.iter().map(|&v| (DVec3::from(v) - first).length());
            let far = normal.normalize_or_zero().dot(a - b);
            // Beside a portal's own size, a little is no evidence.
            if far.abs() > 1e-3 * size.fold(0.0, f64::max) { far } else { 0.0 }
        })
        .collect();
    let custom = told.iter().map(|far| far.signum() * f64::from(*far != 0.0)).sum::<f64>() > 0.0;
    let mut odd = 0;
    for (portal, far) in portals.iter_mut().zip(told) {
        let stands = if far == 0.0 { custom } else { far > 0.0 };
        odd += u32::from(stands != custom);
        if !stands {
            portal.polygon.reverse();
        }
    }
    odd
}

/// A place in the text.
struct Text<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Text<'a> {
    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    fn left(&self) -> u64 {
        self.rest().len() as u64
    }

    fn skip_blanks(&mut self) {
        self.at += self.rest().iter().take_while(|b| b.is_ascii_whitespace()).count();
    }

    /// The bytes up to a blank or a parenthesis; may be empty.
    fn word(&mut self) -> &'a [u8] {
        self.skip_blanks();
        let ends = |b: &u8| b.is_ascii_whitespace() || matches!(b, b'(' | b')');
        let rest = self.rest();
        let word = &rest[..rest.iter().position(ends).unwrap_or(rest.len())];
        self.at += word.len();
        word
    }

    /// Whether the next word is the only one of its line.
    fn is_alone(&self) -> bool {
        let mut ahead = Text { bytes: self.bytes, at: self.at };
        let word = ahead.word();
        let line = ahead.rest().split(|&b| b == b'\n').next().unwrap_or(&[]);
        !word.is_empty() && line.iter().all(u8::is_ascii_whitespace)
    }

    fn integer(&mut self, what: &str) -> Result<i64, ErrorKind> {
        self.skip_blanks();
        let at = self.at;
        let value = std::str::from_utf8(self.word()).ok().and_then(|word| word.parse().ok());
        value.ok_or_else(|| {
            self.at = at;
            self.expected(what)
        })
    }

    /// A count of items that take so many bytes each at least.
    fn count(&mut self, what: &str, least: u64) -> Result<u32, ErrorKind> {
        self.skip_blanks();
        let at = self.at;
        let value = self.integer(&format!("the number of {what}"))?;
        // One byte more: the last needs no line end.
        let most = ((self.left() + 1) / least).min(u64::from(u32::MAX - 1));
        match u64::try_from(value) {
            Ok(count) if count <= most => Ok(count as u32),
            _ => Err(self.error_at(
                at,
                format!("{value} {what}, but the {} bytes left hold at most {most}", self.left()),
            )),
        }
    }

    fn number(&mut self, what: &str) -> Result<f64, ErrorKind> {
        self.skip_blanks();
        match fast_float2::parse_partial::<f64, _>(self.rest()) {
            Ok((value, length)) if length > 0 && value.is_finite() => {
                self.at += length;
                Ok(value)
            }
            _ => Err(self.expected(what)),
        }
    }

    fn mark(&mut self, mark: u8, what: &str) -> Result<(), ErrorKind> {
        self.skip_blanks();
        if self.rest().first() != Some(&mark) {
            return Err(self.expected(what));
        }
        self.at += 1;
        Ok(())
    }

    fn error_at(&self, at: usize, message: impl Into<String>) -> ErrorKind {
        let line = 1 + self.bytes[..at].iter().filter(|&&b| b == b'\n').count();
        ErrorKind::invalid(format!("line {line}"), message)
    }

    fn expected(&self, what: &str) -> ErrorKind {
        let mut ahead = Text { bytes: self.bytes, at: self.at };
        let found = match ahead.word() {
            [] if ahead.left() == 0 => "the end of the file".to_owned(),
            [] => format!("\"{}\"", quote(&ahead.rest()[..1])),
            word => format!("\"{}\"", quote(word)),
        };
        self.error_at(self.at, format!("expected {what}, found {found}"))
    }
}
