//! Welding of vertices that nearly meet.

use crate::hash::QuickMap;

/// Returns for each vertex the one that it is welded to: the nearest of those before it that stayed
/// where they were and are at most `tolerance` away (Euclidean, in units of the mesh), or itself
/// where none is. So no vertex moves further than the tolerance, and those that stay are further
/// apart. With a tolerance of 0, below 0 or not finite it is [`weld`](cullet::mesh::weld). Vertices
/// that are not finite stay.
///
/// Expected O(n), with some 40 bytes a vertex that stays on top of the result.
pub(crate) fn weld_within(positions: &[[f32; 3]], tolerance: f32) -> Vec<u32> {
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return cullet::mesh::weld(positions);
    }
    let reach = f64::from(tolerance);
    // Cells are as wide as two tolerances, so what is near lies in the cell or in the next one on
    // the side that the point is on. Those that stay are further apart than the tolerance, so a
    // cell has few.
    let size = reach * 2.0;
    let mut cells: QuickMap<[u64; 3], u32> = QuickMap::default();
    // The vertices that stay, each with the one before it in its cell.
    let mut stayed: Vec<[u32; 2]> = Vec::new();
    let place = |vertex: u32| {
        let p = positions[vertex as usize].map(f64::from);
        let cell = p.map(|v| (v / size).floor());
        if !cell.iter().all(|c| c.is_finite()) {
            return vertex;
        }
        let next = [0, 1, 2].map(|a| if p[a] / size - cell[a] < 0.5 { -1.0 } else { 1.0 });
        // −0 is 0, as a cell.
        let bits = |c: [f64; 3]| c.map(|v| (v + 0.0).to_bits());
        let mut nearest: Option<(f64, u32)> = None;
        for corner in 0..8 {
            let at = [0, 1, 2].map(|a| cell[a] + if corner >> a & 1 == 1 { next[a] } else { 0.0 });
            let mut other = cells.get(&bits(at)).copied();
            while let Some([v, before]) = other.and_then(|o| stayed.get(o as usize)) {
                let q = positions[*v as usize];
                let apart = (0..3).map(|a| (f64::from(q[a]) - p[a]).powi(2)).sum::<f64>().sqrt();
                if apart <= reach && nearest.is_none_or(|n| apart < n.0) {
                    nearest = Some((apart, *v));
                }
                other = Some(*before);
            }
        }
        if let Some((_, to)) = nearest {
            return to;
        }
        let number = stayed.len() as u32;
        let before = cells.insert(bits(cell), number).unwrap_or(u32::MAX);
        stayed.push([vertex, before]);
        vertex
    };
    (0..positions.len() as u32).map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::weld_within;

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
        assert_eq!(weld_within(&positions, 1.0), [0, 0, 0, 3, 4, 5]);
        assert_eq!(weld_within(&positions[..4], 0.0), [0, 1, 2, 3]);
        assert_eq!(weld_within(&positions[..4], f32::NAN), [0, 1, 2, 3]);
    }

    #[test]
    fn none_moves_further_than_the_tolerance_and_those_that_stay_are_apart() {
        let at = |i: u32| {
            let mixed = i.wrapping_mul(2_654_435_761);
            [0, 10, 20].map(|s| (mixed >> s & 1023) as f32 / 128.0)
        };
        let positions: Vec<[f32; 3]> = (0..3000).map(at).collect();
        let to = weld_within(&positions, 0.75);
        assert!((0..).zip(&to).filter(|(v, to)| v != *to).count() > 100);
        let welded: Vec<[f32; 3]> = to.iter().map(|&v| positions[v as usize]).collect();
        let apart = |p: [f32; 3], q: [f32; 3]| {
            (0..3).map(|a| f64::from(p[a] - q[a]).powi(2)).sum::<f64>().sqrt()
        };
        assert!(positions.iter().zip(&welded).all(|(p, w)| apart(*p, *w) <= 0.75));
        for (i, p) in welded.iter().enumerate() {
            assert!(welded[..i].iter().all(|q| p == q || apart(*p, *q) > 0.75));
        }
    }
}
