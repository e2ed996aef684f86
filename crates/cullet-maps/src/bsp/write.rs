//! Visibility written back into a map.

use super::lumps::{Lumps, Version, int, unsigned};
use super::quake::leaf_size;
use super::visibility::{bit, pack};
use super::{parse, quake};
use cullet_io::ErrorKind;

/// Rows of bits: what is seen from each cluster.
#[derive(Clone, Copy, Debug)]
pub struct ClusterRows<'a> {
    /// How many clusters there are.
    pub clusters: u32,
    /// Quake: the cluster of each leaf that has a place in visibility, from leaf 1 of the map on:
    /// the leafs of a `.prt` file in their order, or [`clusters_of_leafs`]. Empty for Quake 2
    /// and 3, whose leafs have their clusters in the map.
    pub of_leaf: &'a [u32],
    /// A row for each cluster, one after the other, each of `clusters` / 8 bytes, rounded up: bit j
    /// (byte j/8, bit j%8) says whether cluster j can be seen. Each must see itself.
    pub rows: &'a [u8],
}

/// The cells of a map's leafs from leaf 1 on, as [`ClusterRows::of_leaf`] wants them, where rows
/// are by the map's own cells; empty for Quake 2 and 3.
#[must_use]
pub fn clusters_of_leafs(map: &super::Bsp) -> Vec<u32> {
    match map.version() {
        Version::Quake2 | Version::Quake3 => Vec::new(),
        Version::Quake | Version::Bsp2 | Version::HalfLife => {
            map.leafs().iter().skip(1).map_while(|leaf| leaf.cell).collect()
        }
    }
}

/// The bytes of a map with its visibility replaced. Of all else nothing changes but where it lies:
/// the visibility lump takes the place of the old one, lumps behind it move by whole words, and
/// their offsets with them, those of a BSPX directory too; in Quake each leaf is told where its row
/// is. In Quake rows are of leafs, zero bytes counted, one for each cluster that has a leaf;
/// clusters never share one, so that cells are the same when the map is read again.
///
/// Cost: clusters times leafs, and the file once.
///
/// # Errors
/// If the bytes are no sound map; if there are fewer or more rows, leafs or clusters than the map
/// has; if a cluster does not see itself; or if lumps overlap the visibility lump or the map would
/// exceed 2 GiB.
pub fn with_visibility(bytes: &[u8], rows: &ClusterRows<'_>) -> Result<Vec<u8>, ErrorKind> {
    let lumps = Lumps::new(bytes)?;
    let map = parse::parse(&lumps)?;
    check(rows)?;
    let (lump, offsets) = match lumps.version {
        Version::Quake2 => (seen_and_heard(rows, map.cell_count())?, Vec::new()),
        Version::Quake3 => (plain(rows, map.cell_count())?, Vec::new()),
        Version::Quake | Version::Bsp2 | Version::HalfLife => {
            runs(rows, clusters_of_leafs(&map).len())?
        }
    };
    let mut out = splice(&lumps, &lump)?;
    // Leafs may have moved.
    let moved = Lumps::new(&out)?;
    let index = moved.version.lumps().iter().position(|n| *n == "leafs").unwrap_or(0);
    let [start, _] = moved.place(index);
    for (number, offset) in offsets.iter().enumerate() {
        let at = start as usize + (number + 1) * leaf_size(lumps.version) + quake::ROW_OF_LEAF;
        out[at..at + 4].copy_from_slice(&offset.to_le_bytes());
    }
    Ok(out)
}

/// Rows are as many and as long as they say, and each cluster sees itself.
fn check(rows: &ClusterRows<'_>) -> Result<(), ErrorKind> {
    let length = (rows.clusters as usize).div_ceil(8);
    let need = length as u64 * u64::from(rows.clusters);
    if rows.rows.len() as u64 != need {
        let message = format!(
            "{} bytes; {} rows of {length} bytes have {need}",
            rows.rows.len(),
            rows.clusters
        );
        return Err(ErrorKind::invalid("rows", message));
    }
    let blind = (0..rows.clusters).find(|&c| !bit(row_of(rows, c), c as usize));
    match blind {
        Some(cluster) => {
            let message = "it does not see itself; a map needs that each does";
            Err(ErrorKind::invalid(format!("row {cluster}"), message))
        }
        None => Ok(()),
    }
}

fn row_of<'a>(rows: &ClusterRows<'a>, cluster: u32) -> &'a [u8] {
    let length = (rows.clusters as usize).div_ceil(8);
    &rows.rows[cluster as usize * length..][..length]
}

/// The lump of Quake, and where in it the row of each leaf is.
fn runs(rows: &ClusterRows<'_>, leafs: usize) -> Result<(Vec<u8>, Vec<i32>), ErrorKind> {
    if rows.of_leaf.len() != leafs {
        let message =
            format!("clusters of {} leafs are given; the map has {leafs}", rows.of_leaf.len());
        return Err(ErrorKind::invalid("leafs", message));
    }
    let mut places = vec![None; rows.clusters as usize];
    let (mut lump, mut offsets) = (Vec::new(), Vec::with_capacity(leafs));
    for (leaf, &cluster) in rows.of_leaf.iter().enumerate() {
        let Some(place) = places.get_mut(cluster as usize) else {
            let message = format!("it is in cluster {cluster}, of {}", rows.clusters);
            return Err(ErrorKind::invalid(format!("leaf {}", leaf + 1), message));
        };
        let offset = match *place {
            Some(offset) => offset,
            None => {
                let row = row_of(rows, cluster);
                let mut bits = vec![0; leafs.div_ceil(8)];
                for (leaf, &other) in rows.of_leaf.iter().enumerate() {
                    // A cluster out of range is told when its leaf is reached.
                    bits[leaf / 8] |= u8::from(bit(row, other as usize)) << (leaf % 8);
                }
                let offset = i32::try_from(lump.len()).map_err(|_| too_large(lump.len()))?;
                *place = Some(offset);
                pack(&bits, &mut lump);
                offset
            }
        };
        offsets.push(offset);
    }
    Ok((lump, offsets))
}

/// Refuses another number of clusters than the map has.
fn check_clusters(rows: &ClusterRows<'_>, clusters: u32) -> Result<(), ErrorKind> {
    if rows.clusters == clusters {
        return Ok(());
    }
    let message = format!("{} are given; the map has {clusters}", rows.clusters);
    Err(ErrorKind::invalid("clusters", message))
}

/// The lump of Quake 2. What can be heard from a cluster is, as its own compiler has it, what can be
/// seen from any that is seen from there.
fn seen_and_heard(rows: &ClusterRows<'_>, clusters: u32) -> Result<Vec<u8>, ErrorKind> {
    check_clusters(rows, clusters)?;
    let mut places = Vec::new();
    let mut packed = Vec::new();
    let table = 4 + 8 * clusters as usize;
    for cluster in 0..clusters {
        let seen = row_of(rows, cluster);
        let mut heard = vec![0; seen.len()];
        for other in (0..clusters).filter(|&other| bit(seen, other as usize)) {
            heard.iter_mut().zip(row_of(rows, other)).for_each(|(to, from)| *to |= from);
        }
        for row in [seen, &heard] {
            let place = table + packed.len();
            places.push(i32::try_from(place).map_err(|_| too_large(place))?);
            pack(row, &mut packed);
        }
    }
    let head = std::iter::once(clusters.cast_signed()).chain(places);
    Ok(head.flat_map(i32::to_le_bytes).chain(packed).collect())
}

/// The lump of Quake 3: its rows are of whole 64-bit words, as its own compiler writes them.
fn plain(rows: &ClusterRows<'_>, clusters: u32) -> Result<Vec<u8>, ErrorKind> {
    check_clusters(rows, clusters)?;
    let length = (clusters as usize).div_ceil(64) * 8;
    let mut lump = [clusters, length as u32].map(u32::to_le_bytes).concat();
    for cluster in 0..clusters {
        let row = row_of(rows, cluster);
        lump.extend(row);
        lump.resize(lump.len() + length - row.len(), 0);
    }
    Ok(lump)
}

fn too_large(size: usize) -> ErrorKind {
    ErrorKind::OverLimit {
        item: "bytes of the map".into(),
        count: size as u64,
        limit: i32::MAX as u64,
    }
}

/// The map with other bytes in its visibility lump, all offsets right.
fn splice(lumps: &Lumps<'_>, lump: &[u8]) -> Result<Vec<u8>, ErrorKind> {
    let bytes = lumps.bytes;
    let names = lumps.version.lumps();
    let places: Vec<[usize; 2]> =
        (0..names.len()).map(|i| lumps.place(i).map(|v| v.max(0) as usize)).collect();
    let visibility = names.iter().position(|n| *n == "visibility").unwrap_or(0);
    let last = places.iter().filter(|p| p[1] > 0).map(|p| p[0] + p[1]);
    let last = last.max().unwrap_or(lumps.directory_end());
    let [start, length] = places[visibility];
    let whole = |n: usize| n.div_ceil(4) * 4;
    // A lump that was empty comes behind all others, in front of a BSPX directory.
    let (start, end) = match length {
        0 => (whole(last), whole(last).min(bytes.len())),
        _ => (start, start + length),
    };
    for (name, &[offset, length]) in names.iter().zip(&places) {
        if *name != "visibility" && length > 0 && offset < end && offset + length > start {
            let message = format!(
                "bytes {offset} to {} overlap lump visibility, {start} to {end}",
                offset + length
            );
            return Err(ErrorKind::invalid(format!("lump {name}"), message));
        }
    }
    // The padding of the old lump goes with it, where it is padding: up to where something begins.
    let next = places.iter().filter(|p| p[1] > 0 && p[0] >= end).map(|p| p[0]).min();
    let next = next.or(bspx(bytes, last)).unwrap_or(bytes.len());
    let end = whole(end).min(next.max(end)).min(bytes.len());
    let mut out = bytes[..start.min(bytes.len())].to_vec();
    out.resize(start, 0);
    out.extend(lump);
    let room = whole(out.len() - start);
    out.resize(start + room, 0);
    let by = (start + room) as i64 - end as i64;
    out.extend(&bytes[end..]);
    if i32::try_from(out.len()).is_err() {
        return Err(too_large(out.len()));
    }
    let mut put = |at: usize, value: i64| {
        out[at..at + 4].copy_from_slice(&(value as i32).to_le_bytes());
    };
    for (index, &[offset, length]) in places.iter().enumerate() {
        let at = lumps.version.directory() + 8 * index;
        if index == visibility {
            put(at, start as i64);
            put(at + 4, lump.len() as i64);
        } else if length > 0 && offset >= end {
            put(at, offset as i64 + by);
        }
    }
    if let Some(directory) = bspx(bytes, last).filter(|d| *d >= end) {
        let count = unsigned(bytes, directory + 4) as usize;
        for entry in (0..count).map(|i| directory + 8 + i * 32 + 24) {
            let offset = unsigned(bytes, entry) as usize;
            if offset >= end {
                put((entry as i64 + by) as usize, offset as i64 + by);
            }
        }
    }
    Ok(out)
}

/// Where the BSPX directory begins, if the map has one: behind the last lump, at a whole word.
fn bspx(bytes: &[u8], last: usize) -> Option<usize> {
    let at = last.div_ceil(4) * 4;
    let is = bytes.get(at..at + 8)?.starts_with(b"BSPX");
    let count = usize::try_from(int(bytes, at + 4)).ok()?;
    let entries = bytes.get(at + 8..)?.len() / 32;
    (is && count <= entries).then_some(at)
}
