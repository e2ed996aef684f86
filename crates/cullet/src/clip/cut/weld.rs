//! Vertices that nearly meet, made to meet.

use super::hash::QuickMap;

/// Positions of which each is one of those given, at most `tolerance` from where it was: every vertex goes to
/// the nearest of those before it that stayed, or stays where none is near enough. With how many moved.
///
/// Cells are as wide as two tolerances, so what is near lies in the cell or in the next one on the side that
/// the point is on. Those that stay are further apart than the tolerance, so a cell has few. Expected O(n).
/// Positions that are not finite stay.
pub(super) fn weld(positions: &[[f32; 3]], tolerance: f32) -> (Vec<[f32; 3]>, usize) {
    let reach = f64::from(tolerance);
    let size = reach * 2.0;
    let mut cells: QuickMap<[u64; 3], u32> = QuickMap::default();
    // The vertices that stay, each with the one before it in its cell.
    let mut stayed: Vec<([f32; 3], u32)> = Vec::new();
    let mut moved = 0;
    let place = |&position: &[f32; 3]| {
        let p = position.map(f64::from);
        let cell = p.map(|v| (v / size).floor());
        if !cell.iter().all(|c| c.is_finite()) {
            return position;
        }
        let next = [0, 1, 2].map(|a| if p[a] / size - cell[a] < 0.5 { -1.0 } else { 1.0 });
        // −0 is 0, as a cell.
        let bits = |c: [f64; 3]| c.map(|v| (v + 0.0).to_bits());
        let mut nearest: Option<(f64, [f32; 3])> = None;
        for corner in 0..8 {
            let at = [0, 1, 2].map(|a| cell[a] + if corner >> a & 1 == 1 { next[a] } else { 0.0 });
            let mut other = cells.get(&bits(at)).copied();
            while let Some((q, before)) = other.and_then(|o| stayed.get(o as usize)) {
                let apart = (0..3).map(|a| (f64::from(q[a]) - p[a]).powi(2)).sum::<f64>().sqrt();
                if apart <= reach && nearest.is_none_or(|n| apart < n.0) {
                    nearest = Some((apart, *q));
                }
                other = Some(*before);
            }
        }
        if let Some((apart, to)) = nearest {
            moved += usize::from(apart > 0.0);
            return to;
        }
        let number = stayed.len() as u32;
        let before = cells.insert(bits(cell), number).unwrap_or(u32::MAX);
        stayed.push((position, before));
        position
    };
    let welded = positions.iter().map(place).collect();
    (welded, moved)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_near_moves_and_what_is_not_stays() {
        let positions = [
            [0.0, 0.0, 0.0],
            [0.5, 0.0, 0.0],
            [-0.5, 0.0, 0.0],
            [1.2, 0.0, 0.0],
            [f32::NAN, 0.0, 0.0],
            [1e30, 1e30, 0.0],
        ];
        let (welded, moved) = weld(&positions, 1.0);
        assert_eq!(moved, 2);
        assert_eq!(welded[..4], [[0.0; 3], [0.0; 3], [0.0; 3], [1.2, 0.0, 0.0]]);
        assert!(welded[4][0].is_nan());
        assert_eq!(welded[5], positions[5]);
    }

    #[test]
    fn none_moves_further_than_the_tolerance_and_those_that_stay_are_apart() {
        let at = |i: u32| {
            let mixed = i.wrapping_mul(2_654_435_761);
            [0, 10, 20].map(|s| (mixed >> s & 1023) as f32 / 128.0)
        };
        let positions: Vec<[f32; 3]> = (0..3000).map(at).collect();
        let (welded, moved) = weld(&positions, 0.75);
        assert!(moved > 100);
        let apart = |p: [f32; 3], q: [f32; 3]| {
            (0..3).map(|a| f64::from(p[a] - q[a]).powi(2)).sum::<f64>().sqrt()
        };
        assert!(positions.iter().zip(&welded).all(|(p, w)| apart(*p, *w) <= 0.75));
        for (i, p) in welded.iter().enumerate() {
            assert!(welded[..i].iter().all(|q| p == q || apart(*p, *q) > 0.75));
        }
    }
}
