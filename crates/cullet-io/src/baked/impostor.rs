//! The atlas of an impostor, as it lies in files.

use cullet::bounds::Aabb;
use cullet_mesh::Impostor;

use super::Measured;
use super::error::BakedError;
use super::hash::{Sum, hash};
use crate::bytes::{put_f32s, put_u32s};

/// Bytes before the planes: sizes, box and error as ten words, and zeros up to this.
const HEAD: usize = 64;

/// The bytes of an impostor, all little-endian: frames along a side of the grid and texels along a
/// side of a frame as u32; as f32 the box in six, the radius around its middle and the error; zeros
/// up to 64 bytes; then the plane of the shape and that of the normals.
#[must_use]
pub fn impostor_to_bytes(impostor: &Impostor) -> Vec<u8> {
    let bounds = impostor.bounds();
    let mut bytes = Vec::with_capacity(HEAD + impostor.shape().len() * 4);
    put_u32s(&mut bytes, &[impostor.grid(), impostor.texels()]);
    put_f32s(&mut bytes, &bounds.min);
    put_f32s(&mut bytes, &bounds.max);
    put_f32s(&mut bytes, &[impostor.radius(), impostor.error()]);
    bytes.resize(HEAD, 0);
    for plane in [impostor.shape(), impostor.normals()] {
        plane.iter().for_each(|word| bytes.extend(word.to_le_bytes()));
    }
    bytes
}

/// The impostor of such bytes.
///
/// # Errors
/// If they are of another length than they say, or say what no impostor is.
pub fn impostor_from_bytes(bytes: &[u8]) -> Result<Impostor, BakedError> {
    let size = |bytes: usize| BakedError::Size { what: "its impostor", bytes, row: HEAD };
    let Some((head, planes)) = bytes.split_at_checked(HEAD) else { return Err(size(bytes.len())) };
    let words = head.as_chunks::<4>().0;
    let sizes = [words[0], words[1]].map(u32::from_le_bytes);
    let number = |at: usize| f32::from_le_bytes(words[at]);
    let bounds = Aabb::new([2, 3, 4].map(number), [5, 6, 7].map(number));
    let count = Impostor::texel_count(sizes)?;
    if planes.len() != count * 4 {
        return Err(BakedError::Count {
            what: "bytes of its impostor",
            found: bytes.len() as u64,
            expected: (HEAD + count * 4) as u64,
        });
    }
    let (planes, _) = planes.as_chunks::<2>();
    let plane = |words: &[[u8; 2]]| words.iter().map(|&w| u16::from_le_bytes(w)).collect();
    let (shape, normals) = planes.split_at(count);
    Ok(Impostor::new(sizes, (bounds, number(8)), number(9), plane(shape), plane(normals))?)
}

/// The sum of the impostor of a mesh: of the geometry, how it was measured, and its bytes.
pub(crate) fn impostor_sum(geometry: u64, measured: &Measured, bytes: &[u8]) -> u64 {
    let Measured { points, quantile, most_over, seed, .. } = measured;
    let mut sum = Sum::new(geometry);
    for word in [u64::from(*points), quantile.to_bits(), most_over.to_bits(), *seed, hash(bytes)] {
        sum.add(word);
    }
    sum.end()
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_mesh::ImpostorError;

    fn impostor() -> Impostor {
        let count = Impostor::texel_count([3, 2]).expect("allowed");
        let plane = |k: u16| (0..count as u16).map(|i| i * 7 + k).collect();
        let bounds = Aabb::new([-1.0, 0.0, 2.0], [3.5, 0.0, 4.0]);
        Impostor::new([3, 2], (bounds, 3.0), 0.25, plane(1), plane(900)).expect("sound")
    }

    #[test]
    fn an_impostor_comes_back_and_odd_bytes_are_errors() {
        let bytes = impostor_to_bytes(&impostor());
        assert_eq!(bytes.len(), 64 + 36 * 4);
        assert_eq!(impostor_from_bytes(&bytes), Ok(impostor()));
        for end in [0, 63, 64, bytes.len() - 1] {
            let cut = impostor_from_bytes(&bytes[..end]);
            assert!(
                matches!(cut, Err(BakedError::Size { .. } | BakedError::Count { .. })),
                "{end}"
            );
        }
        let with = |at: usize, value: [u8; 4]| {
            let mut odd = bytes.clone();
            odd[at..at + 4].copy_from_slice(&value);
            impostor_from_bytes(&odd)
        };
        let size = Err(ImpostorError::Size { grid: u32::MAX, texels: 2 });
        assert_eq!(with(0, [255; 4]), size.map_err(BakedError::from));
        for (at, number) in
            [(8, f32::NAN), (20, f32::INFINITY), (8, 1e9), (32, 0.0), (36, -1.0), (36, f32::NAN)]
        {
            let odd = with(at, number.to_le_bytes());
            assert!(matches!(odd, Err(BakedError::Impostor(_))), "{at}: {odd:?}");
        }
    }
}
