//! Curved surfaces of Quake 3: nets of quadratic Bézier patches, cut into triangles.

use glam::DVec3;

use cullet_io::reader::Welder;

/// How far triangles may be off the curve, in units of the map: some two centimetres. The engine's
/// own default is 4.
const TOLERANCE: f64 = 1.0;
/// Most pieces along one curve of a patch.
const MOST: usize = 16;

/// A net of control points: odd numbers of columns and rows, at least three, of which each three by
/// three, sharing their borders, are a patch.
pub(crate) struct Net<'a> {
    points: &'a [[f32; 3]],
    columns: usize,
    rows: usize,
}

impl<'a> Net<'a> {
    pub(crate) fn new(points: &'a [[f32; 3]], size: [i32; 2]) -> Result<Self, String> {
        let [columns, rows] = size.map(|s| usize::try_from(s).unwrap_or(0));
        let fit = |n: usize| n >= 3 && n % 2 == 1;
        if !fit(columns) || !fit(rows) {
            let [columns, rows] = size;
            return Err(format!(
                "a patch of {columns} by {rows} control points; both must be odd, and 3 or more"
            ));
        }
        if columns.checked_mul(rows) != Some(points.len()) {
            let count = points.len();
            return Err(format!("a patch of {columns} by {rows} control points has {count}"));
        }
        Ok(Self { points, columns, rows })
    }

    fn point(&self, column: usize, row: usize) -> DVec3 {
        DVec3::from(self.points[row * self.columns + column].map(f64::from))
    }

    /// Into how many pieces each curve along a row (or a column, with `turned`) is cut: as many as
    /// the most curved of those beside each other needs, so that the patches of a net meet without
    /// cracks.
    fn pieces(&self, turned: bool) -> Vec<usize> {
        let at = |along: usize, across: usize| {
            if turned { self.point(across, along) } else { self.point(along, across) }
        };
        let (along, across) =
            if turned { (self.rows, self.columns) } else { (self.columns, self.rows) };
        let curve = |first: usize| {
            // A parabola is off its chord by a quarter of this in its middle; cut in n, by n² less.
            let off = (0..across)
                .map(|i| (at(first, i) - 2.0 * at(first + 1, i) + at(first + 2, i)).length() / 4.0)
                .fold(0.0, f64::max);
            ((off / TOLERANCE).sqrt().ceil() as usize).clamp(1, MOST)
        };
        (0..along - 2).step_by(2).map(curve).collect()
    }

    /// Appends triangles. Cost: at most 512 triangles for each patch of the net.
    pub(crate) fn triangulate(&self, welder: &mut Welder, out: &mut Vec<u32>) {
        let columns = steps(&self.pieces(false));
        let rows = steps(&self.pieces(true));
        let grid: Vec<u32> = rows
            .iter()
            .flat_map(|row| columns.iter().map(|column| (*column, *row)))
            .map(|(column, row)| welder.weld(self.at(column, row)))
            .collect();
        for row in 0..rows.len() - 1 {
            for column in 0..columns.len() - 1 {
                let [a, b] = [0, 1].map(|o| row * columns.len() + column + o);
                let [c, d] = [a, b].map(|v| v + columns.len());
                let [a, b, c, d] = [a, b, c, d].map(|v| grid[v]);
                for t in [[a, b, d], [a, d, c]] {
                    if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
                        out.extend(t);
                    }
                }
            }
        }
    }

    /// A point of the surface. Exact on control points that it goes through.
    fn at(&self, (first_column, s): (usize, f64), (first_row, t): (usize, f64)) -> [f32; 3] {
        let weights = |t: f64| [(1.0 - t) * (1.0 - t), 2.0 * t * (1.0 - t), t * t];
        let (across, down) = (weights(s), weights(t));
        let mut sum = DVec3::ZERO;
        for (i, u) in down.iter().enumerate() {
            for (j, v) in across.iter().enumerate() {
                // A weight of 0 must not turn a far point into one that is not finite.
                if u * v != 0.0 {
                    sum += self.point(first_column + j, first_row + i) * (u * v);
                }
            }
        }
        sum.to_array().map(|v| v as f32)
    }
}

/// Where the pieces of curves begin and end: the first control point, and how far on.
fn steps(pieces: &[usize]) -> Vec<(usize, f64)> {
    let mut steps = vec![(0, 0.0)];
    for (curve, &count) in pieces.iter().enumerate() {
        steps.extend((1..=count).map(|i| (curve * 2, i as f64 / count as f64)));
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter of a pipe along y.
    fn arch(radius: f32) -> Vec<[f32; 3]> {
        let row = |y: f32| [[radius, y, 0.0], [radius, y, radius], [0.0, y, radius]];
        [0.0, 5.0, 10.0].into_iter().flat_map(row).collect()
    }

    #[test]
    fn curves_are_cut_as_they_need_and_keep_their_ends() {
        for (radius, pieces) in [(0.5, 1), (40.0, 4), (1e9, MOST)] {
            let points = arch(radius);
            let net = Net::new(&points, [3, 3]).unwrap();
            assert_eq!((net.pieces(false), net.pieces(true)), (vec![pieces], vec![1]));
            let (mut welder, mut indices) = (Welder::new(), Vec::new());
            net.triangulate(&mut welder, &mut indices);
            assert_eq!(indices.len(), pieces * 6);
            let positions = welder.into_positions();
            assert_eq!(positions.len(), (pieces + 1) * 2);
            for corner in [0, 2, 6, 8] {
                assert!(positions.contains(&points[corner]), "{radius} {corner}");
            }
        }
    }

    #[test]
    fn triangles_are_within_the_tolerance_of_the_surface() {
        let points = arch(100.0);
        let net = Net::new(&points, [3, 3]).unwrap();
        let pieces = net.pieces(false)[0];
        for i in 0..pieces {
            let [a, b, mid] = [0.0, 1.0, 0.5].map(|o| {
                let t = (i as f64 + o) / pieces as f64;
                DVec3::from(net.at((0, t), (0, 0.0)).map(f64::from))
            });
            assert!(((a + b) * 0.5).distance(mid) <= TOLERANCE * 1.001);
        }
    }

    #[test]
    fn nets_of_other_sizes_are_refused() {
        let points = arch(1.0);
        for size in [[3, 2], [1, 9], [9, 1], [-3, -3], [i32::MAX, 3], [3, 5]] {
            assert!(Net::new(&points, size).is_err(), "{size:?}");
        }
    }
}
