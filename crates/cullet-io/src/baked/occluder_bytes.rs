//! Occluders of a mesh, as a table of a file has them.

use cullet::bounds::Aabb;

use super::error::BakedError;
use super::hash::{Sum, hash};
use super::occluders::{OccluderPolygon, OccluderSheet, Occluders};
use crate::bytes::{of_u32s, put_f32s, to_u32s};

/// Words before those of polygons and sheets.
const HEAD: usize = 8;

impl Occluders {
    /// Its bytes, in words of four, little-endian: how many boxes, sealed boxes, polygons, sheets
    /// and near sheets; the efficiency as f64; a zero; for each polygon its corners, its sides, its
    /// tolerance; for each sheet its triangles and its sides; then all coordinates.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let sheets = || self.sheets.iter().chain(&self.near);
        let counts = [
            &self.boxes.len(),
            &self.sealed.len(),
            &self.polygons.len(),
            &self.sheets.len(),
            &self.near.len(),
        ];
        let mut words: Vec<u32> = counts.iter().map(|&&n| n as u32).collect();
        let bits = self.efficiency.to_bits();
        words.extend([bits as u32, (bits >> 32) as u32, 0]);
        let sides = |two_sided: bool| 1 + u32::from(two_sided);
        for p in &self.polygons {
            words.extend([p.points.len() as u32, sides(p.two_sided), p.tolerance.to_bits()]);
        }
        sheets().for_each(|s| words.extend([s.triangles.len() as u32, sides(s.two_sided)]));
        let mut bytes = of_u32s(&words);
        for b in self.boxes.iter().chain(&self.sealed) {
            put_f32s(&mut bytes, &b.min);
            put_f32s(&mut bytes, &b.max);
        }
        self.polygons.iter().for_each(|p| put_f32s(&mut bytes, p.points.as_flattened()));
        for s in sheets() {
            put_f32s(&mut bytes, s.triangles.as_flattened().as_flattened());
        }
        bytes
    }

    /// Reads occluders from such bytes. Counts are checked against the number of bytes before
    /// anything is allocated.
    ///
    /// # Errors
    /// If they are not as [`to_bytes`](Self::to_bytes) writes them, or a number is not finite.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, BakedError> {
        let form = |what: &str| BakedError::Form(format!("its occluders: {what}"));
        let words = to_u32s(bytes);
        let head = words.first_chunk::<HEAD>().filter(|_| bytes.len().is_multiple_of(4));
        let &[boxes, sealed, polygons, sheets, near, low, high, _] =
            head.ok_or_else(|| form("cut short"))?;
        let rows = u64::from(polygons) * 3 + (u64::from(sheets) + u64::from(near)) * 2;
        let numbers = HEAD as u64 + rows;
        if numbers > words.len() as u64 {
            return Err(form("has more polygons and sheets than bytes"));
        }
        let (rows, numbers) = words[HEAD..].split_at(rows as usize);
        let (of_polygons, of_sheets) = rows.split_at(polygons as usize * 3);
        let (of_polygons, of_sheets) =
            (of_polygons.as_chunks::<3>().0, of_sheets.as_chunks::<2>().0);
        let expected = (u64::from(boxes) + u64::from(sealed)) * 6
            + of_polygons.iter().map(|p| u64::from(p[0]) * 3).sum::<u64>()
            + of_sheets.iter().map(|s| u64::from(s[0]) * 9).sum::<u64>();
        let found = numbers.len() as u64;
        if expected != found {
            return Err(BakedError::Count { what: "numbers of its occluders", found, expected });
        }
        let numbers: Vec<f32> = numbers.iter().map(|&w| f32::from_bits(w)).collect();
        let efficiency = f64::from_bits(u64::from(low) | u64::from(high) << 32);
        if !numbers.iter().all(|v| v.is_finite()) || !efficiency.is_finite() {
            return Err(form("a number is not finite"));
        }
        let (points, _) = numbers.as_chunks::<3>();
        let mut left = points;
        let mut take = |count: usize| {
            let (taken, rest) = left.split_at(count);
            left = rest;
            taken
        };
        let sides = |sides: u32| match sides {
            1 | 2 => Ok(sides == 2),
            _ => Err(form("sides that are neither one nor two")),
        };
        let corners = |points: &[[f32; 3]]| {
            let boxes = points.as_chunks::<2>().0.iter();
            boxes.map(|&[min, max]| Aabb { min, max }).collect()
        };
        let mut out = Self {
            boxes: corners(take(boxes as usize * 2)),
            sealed: corners(take(sealed as usize * 2)),
            efficiency,
            ..Self::default()
        };
        for &[count, two_sided, tolerance] in of_polygons {
            let tolerance = f32::from_bits(tolerance);
            if !(tolerance >= 0.0 && tolerance.is_finite()) {
                return Err(form("a tolerance that is none"));
            }
            let points = take(count as usize).to_vec();
            out.polygons.push(OccluderPolygon { points, two_sided: sides(two_sided)?, tolerance });
        }
        for (at, &[count, two_sided]) in of_sheets.iter().enumerate() {
            let triangles = take(count as usize * 3).as_chunks::<3>().0.to_vec();
            let sheet = OccluderSheet { triangles, two_sided: sides(two_sided)? };
            if at < sheets as usize { &mut out.sheets } else { &mut out.near }.push(sheet);
        }
        Ok(out)
    }
}

/// The sum of the occluders of a mesh, of their bytes and its geometry.
pub(crate) fn occluder_sum(geometry: u64, bytes: &[u8]) -> u64 {
    let mut sum = Sum::new(geometry);
    sum.add(hash(bytes));
    sum.end()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn some() -> Occluders {
        let sheet = |two_sided| OccluderSheet {
            triangles: vec![[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]; 2],
            two_sided,
        };
        Occluders {
            boxes: vec![Aabb { min: [0.0; 3], max: [1.0, 2.0, 3.0] }; 2],
            sealed: vec![Aabb { min: [-1.0; 3], max: [4.0; 3] }],
            polygons: vec![OccluderPolygon {
                points: vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
                two_sided: true,
                tolerance: 0.25,
            }],
            sheets: vec![sheet(false), sheet(true)],
            near: vec![sheet(true)],
            efficiency: 0.9,
        }
    }

    #[test]
    fn they_come_back_and_none_are_none() {
        for tables in [some(), Occluders::default()] {
            assert_eq!(Occluders::from_bytes(&tables.to_bytes()), Ok(tables));
        }
    }

    #[test]
    fn what_is_none_is_refused_in_words() {
        let good = some().to_bytes();
        for end in 0..good.len() {
            assert!(Occluders::from_bytes(&good[..end]).is_err(), "{end}");
        }
        let with = |word: usize, value: u32| {
            let mut bytes = good.clone();
            bytes[word * 4..][..4].copy_from_slice(&value.to_le_bytes());
            Occluders::from_bytes(&bytes).map_err(|e| e.to_string())
        };
        for word in 0..5 {
            assert!(with(word, u32::MAX).is_err(), "word {word}");
        }
        assert!(with(8, u32::MAX).is_err(), "corners");
        assert!(with(9, 3).unwrap_err().contains("neither one nor two"));
        assert!(with(10, f32::NAN.to_bits()).unwrap_err().contains("tolerance"));
        let last = good.len() / 4 - 1;
        assert!(with(last, f32::INFINITY.to_bits()).unwrap_err().contains("not finite"));
        assert!(with(6, 0x7ff0_0000).unwrap_err().contains("not finite"));
    }
}
