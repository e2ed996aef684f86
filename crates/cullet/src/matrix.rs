//! Matrices as callers have them.

use crate::array::{self, Each};

/// A 4×4 matrix of a caller's, column-major: columns in order, each as x, y, z, w.
///
/// Made of flat arrays and of arrays of columns, in f32 and f64; with the feature `mint`, of its
/// matrices, to and from which the maths crates convert. Points and directions of the interface are
/// `impl Into<[f64; 3]>`, which the types of glam, nalgebra, cgmath and mint are as they stand.
///
/// ```
/// use cullet::Transform;
///
/// let columns = [[1.0_f32, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [4.0, 5.0, 6.0, 1.0]];
/// assert_eq!(Transform::from_matrix(columns), Transform::from_translation([4.0, 5.0, 6.0]));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matrix(pub(crate) [f64; 16]);

impl From<[f64; 16]> for Matrix {
    fn from(m: [f64; 16]) -> Self {
        Self(m)
    }
}

impl From<&[f64; 16]> for Matrix {
    fn from(m: &[f64; 16]) -> Self {
        Self(*m)
    }
}

impl From<[f32; 16]> for Matrix {
    fn from(m: [f32; 16]) -> Self {
        Self(m.each(f64::from))
    }
}

impl From<&[f32; 16]> for Matrix {
    fn from(m: &[f32; 16]) -> Self {
        Self(m.each(f64::from))
    }
}

impl From<[[f64; 4]; 4]> for Matrix {
    fn from(columns: [[f64; 4]; 4]) -> Self {
        Self(array::from_fn(|i| columns[i / 4][i % 4]))
    }
}

impl From<[[f32; 4]; 4]> for Matrix {
    fn from(columns: [[f32; 4]; 4]) -> Self {
        columns.each(|c| c.each(f64::from)).into()
    }
}

#[cfg(feature = "mint")]
impl<T> From<mint::ColumnMatrix4<T>> for Matrix
where
    [[T; 4]; 4]: Into<Self>,
{
    fn from(m: mint::ColumnMatrix4<T>) -> Self {
        let columns: [[T; 4]; 4] = m.into();
        columns.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_form_is_the_same_matrix() {
        let flat: [f32; 16] = array::from_fn(|i| i as f32 * 0.1);
        let columns: [[f32; 4]; 4] = array::from_fn(|c| array::from_fn(|r| flat[c * 4 + r]));
        let expected = Matrix::from(flat);
        assert_eq!(expected.0[6], f64::from(0.6_f32));
        assert_eq!(Matrix::from(&flat), expected);
        assert_eq!(Matrix::from(columns), expected);
        assert_eq!(Matrix::from(columns.map(|c| c.map(f64::from))), expected);
        assert_eq!(Matrix::from(flat.map(f64::from)), expected);
        #[cfg(feature = "mint")]
        assert_eq!(Matrix::from(mint::ColumnMatrix4::from(columns)), expected);
    }
}
