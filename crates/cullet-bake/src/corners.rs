//! Triangles by their corners.

/// The same triangle with its least corner first, in the same turn.
pub(crate) fn turned<T: Copy + PartialOrd>([a, b, c]: [T; 3]) -> [T; 3] {
    if a <= b && a <= c {
        [a, b, c]
    } else if b <= c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_comes_first_and_the_turn_stays() {
        for t in [[1, 2, 3], [2, 3, 1], [3, 1, 2]] {
            assert_eq!(turned(t), [1, 2, 3]);
        }
        assert_eq!(turned([3, 2, 1]), [1, 3, 2]);
        assert_eq!(turned([2, 1, 1]), [1, 1, 2]);
    }
}
