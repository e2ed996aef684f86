//! Rows of bits that a map stores: what can be seen from where.

use cullet_io::ErrorKind;

/// The stored visibility of a map, its lengths checked.
#[derive(Clone, Debug)]
pub(crate) enum Visibility {
    /// Quake: a row of leafs for each cell, in Quake 2 of clusters, zero bytes counted.
    Runs {
        /// Where the row of each cell begins; one without sees all.
        offsets: Vec<Option<u32>>,
        /// How many leafs or clusters a row has.
        leafs: usize,
        /// The lump.
        bytes: Vec<u8>,
    },
    /// Quake 3: a row of clusters for each cluster.
    Rows {
        /// Bytes of a row.
        row: usize,
        /// The rows, one after the other.
        bytes: Vec<u8>,
    },
}

impl Visibility {
    /// Checks the rows of Quake: each must be whole and end where it should.
    pub(crate) fn runs(
        bytes: &[u8],
        offsets: Vec<Option<u32>>,
        leafs: usize,
    ) -> Result<Self, ErrorKind> {
        for (cell, offset) in offsets.iter().enumerate() {
            let Some(offset) = *offset else { continue };
            let row = bytes.get(offset as usize..).unwrap_or(&[]);
            unpack(row, leafs.div_ceil(8), |_, _| {}).map_err(|message| {
                let item = format!("lump visibility, row {cell} at byte {offset}");
                ErrorKind::invalid(item, message)
            })?;
        }
        Ok(Self::Runs { offsets, leafs, bytes: bytes.to_vec() })
    }

    /// Checks the rows of Quake 3: a count, the bytes of a row, and so many rows.
    pub(crate) fn rows(bytes: &[u8], clusters: usize) -> Result<Self, ErrorKind> {
        let invalid = |message| Err(ErrorKind::invalid("lump visibility", message));
        let Some((head, rows)) = bytes.split_at_checked(8) else {
            return invalid(format!("{} bytes; its two counts alone have 8", bytes.len()));
        };
        let [count, row] = [0, 4].map(|at| super::lumps::int(head, at));
        let (Ok(count), Ok(row)) = (usize::try_from(count), usize::try_from(row)) else {
            return invalid(format!("{count} rows of {row} bytes: neither may be negative"));
        };
        if count < clusters {
            return invalid(format!("{count} rows for {clusters} clusters"));
        }
        if row < count.div_ceil(8) {
            return invalid(format!("rows of {row} bytes hold no {count} clusters"));
        }
        match count.checked_mul(row) {
            Some(need) if need <= rows.len() => {
                Ok(Self::Rows { row, bytes: rows[..clusters * row].to_vec() })
            }
            _ => {
                let there = rows.len();
                invalid(format!("{count} rows of {row} bytes exceed the {there} bytes that follow"))
            }
        }
    }

    /// The row of a cell: of leafs from leaf 1 on in Quake, of clusters in Quake 2 and 3. `None` if it
    /// sees all.
    pub(crate) fn row(&self, cell: u32) -> Option<Vec<u8>> {
        match self {
            Self::Runs { offsets, leafs, bytes } => {
                let offset = (*offsets.get(cell as usize)?)? as usize;
                let mut row = vec![0; leafs.div_ceil(8)];
                // Checked already.
                unpack(&bytes[offset..], row.len(), |at, byte| row[at] = byte).ok()?;
                Some(row)
            }
            Self::Rows { row, bytes } => {
                bytes.get(cell as usize * row..)?.get(..*row).map(<[u8]>::to_vec)
            }
        }
    }
}

/// Whether a bit of a row is 1.
pub(crate) fn bit(row: &[u8], at: usize) -> bool {
    row.get(at / 8).is_some_and(|byte| byte >> (at % 8) & 1 == 1)
}

/// Hands each byte of a row that is not 0 to `visit`, with its place. A byte 0 is followed by how
/// many there are.
fn unpack(packed: &[u8], row: usize, mut visit: impl FnMut(usize, u8)) -> Result<(), String> {
    let mut packed = packed.iter();
    let mut at = 0;
    while at < row {
        let short = || format!("the lump ends after {at} of the row's {row} bytes");
        let byte = *packed.next().ok_or_else(short)?;
        if byte != 0 {
            visit(at, byte);
            at += 1;
            continue;
        }
        let count = usize::from(*packed.next().ok_or_else(short)?);
        if count > row - at {
            return Err(format!(
                "{count} zero bytes after {at} bytes exceed the row's {row} bytes"
            ));
        }
        at += count;
    }
    Ok(())
}

/// Packs a row as Quake has it. At most half as long again as the row.
pub(crate) fn pack(row: &[u8], out: &mut Vec<u8>) {
    for run in row.chunk_by(|a, b| *a == 0 && *b == 0) {
        if run[0] != 0 {
            out.push(run[0]);
            continue;
        }
        for part in run.chunks(255) {
            out.extend([0, part.len() as u8]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_back_from_runs() {
        let mut rng = cullet_testkit::Rng(3);
        for length in [0, 1, 2, 254, 255, 256, 257, 600] {
            for dense in [0.0, 0.02, 0.5, 1.0] {
                let row: Vec<u8> = (0..length)
                    .map(|_| if rng.chance(dense) { rng.below(255) as u8 + 1 } else { 0 })
                    .collect();
                let mut packed = Vec::new();
                pack(&row, &mut packed);
                assert!(packed.len() <= row.len() + row.len().div_ceil(2));
                let visibility = Visibility::runs(&packed, vec![Some(0)], length * 8).unwrap();
                assert_eq!(visibility.row(0), Some(row));
                // Any byte less is too few.
                if let Some(short) = packed.len().checked_sub(1) {
                    let error = Visibility::runs(&packed[..short], vec![Some(0)], length * 8);
                    assert!(error.unwrap_err().to_string().contains("the lump ends after"));
                }
            }
        }
    }

    #[test]
    fn rows_of_wrong_length_are_refused() {
        let runs = |bytes: &[u8], leafs| {
            let rows = Visibility::runs(bytes, vec![None, Some(1)], leafs);
            rows.unwrap_err().to_string()
        };
        assert_eq!(
            runs(&[9, 0, 3], 16),
            "lump visibility, row 1 at byte 1: 3 zero bytes after 0 bytes exceed the row's 2 bytes"
        );
        assert!(runs(&[9], 16).ends_with("the lump ends after 0 of the row's 2 bytes"));
        assert!(runs(&[], 16).ends_with("the lump ends after 0 of the row's 2 bytes"));
        let rows = |counts: [i32; 2], bytes: usize| {
            let mut lump = counts.map(i32::to_le_bytes).concat();
            lump.resize(8 + bytes, 0);
            Visibility::rows(&lump, 9).map(drop).map_err(|e| e.to_string())
        };
        assert_eq!(rows([9, 2], 18), Ok(()));
        assert!(rows([9, 2], 17).unwrap_err().contains("exceed the 17 bytes"));
        assert!(rows([9, 1], 99).unwrap_err().contains("hold no 9 clusters"));
        assert!(rows([8, 1], 99).unwrap_err().contains("8 rows for 9 clusters"));
        assert!(rows([-1, 1], 99).unwrap_err().contains("negative"));
        assert!(rows([i32::MAX, i32::MAX], 99).unwrap_err().contains("exceed"));
        assert!(Visibility::rows(&[0; 7], 0).unwrap_err().to_string().contains("7 bytes"));
    }
}
