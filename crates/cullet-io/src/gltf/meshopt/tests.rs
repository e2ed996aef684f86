//! The reference implementation packs, and unpacks as the oracle.

use proptest::prelude::*;

use super::{Filter, Mode, check, decode};

fn pack<const N: usize>(elements: &[[u8; N]]) -> Vec<u8> {
    // Version 0 of the stream is that of EXT_meshopt_compression.
    meshopt::encode_vertex_buffer_level(elements, 2, Some(0)).unwrap()
}

/// Elements whose bytes wander slowly, jump, or stand still: so that each kind of group occurs.
fn elements<const N: usize>() -> impl Strategy<Value = Vec<[u8; N]>> {
    let steps = prop::collection::vec((0u8..5, any::<u64>()), 1..600);
    steps.prop_map(|steps| {
        let mut v = [0u8; N];
        let mut out = Vec::new();
        for (kind, mut bits) in steps {
            for b in &mut v {
                bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                let r = (bits >> 56) as u8;
                *b = match kind {
                    0 | 1 => *b,
                    2 => b.wrapping_add(r & 1),
                    3 => b.wrapping_sub(r & 7),
                    _ => r,
                };
            }
            out.push(v);
        }
        out
    })
}

fn round_trip<const N: usize>(elements: &[[u8; N]]) {
    let packed = pack(elements);
    let plain = decode(&packed, Mode::Attributes, Filter::None, elements.len(), N).unwrap();
    assert_eq!(plain, elements.as_flattened());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn attributes_come_back(
        a in elements::<4>(), b in elements::<12>(), c in elements::<36>(), d in elements::<256>(),
    ) {
        round_trip(&a);
        round_trip(&b);
        round_trip(&c);
        round_trip(&d);
    }

    #[test]
    fn triangles_come_back(
        deltas in prop::collection::vec(-9i32..12, 3..600), far in any::<u32>(),
    ) {
        let mut at = 40i64;
        let mut list: Vec<u32> = deltas
            .iter()
            .map(|&d| {
                at = (at + i64::from(d)).max(0);
                at as u32
            })
            .collect();
        list.truncate(list.len() / 3 * 3);
        list[0] = far >> 2;
        let packed = meshopt::encode_index_buffer(&list, u32::MAX as usize).unwrap();
        let plain = decode(&packed, Mode::Triangles, Filter::None, list.len(), 4).unwrap();
        // The encoder may turn a triangle, so its own decoder tells what is right.
        let right: Vec<u32> = meshopt::decode_index_buffer(&packed, list.len()).unwrap();
        prop_assert_eq!(words(&plain), right);
    }

    #[test]
    fn sequences_come_back(list in prop::collection::vec(0u32..1 << 29, 1..600)) {
        let packed = meshopt::encode_index_sequence(&list, 1 << 29).unwrap();
        let plain = decode(&packed, Mode::Indices, Filter::None, list.len(), 4).unwrap();
        prop_assert_eq!(words(&plain), list);
    }

    #[test]
    fn damage_is_an_error_or_noise_but_no_panic(
        a in elements::<8>(), at in any::<prop::sample::Index>(), with in any::<u8>(), cut in 0usize..40,
    ) {
        let mut packed = pack(&a);
        *at.get_mut(&mut packed) = with;
        packed.truncate(packed.len() - cut.min(packed.len()));
        for filter in [Filter::None, Filter::Octahedral, Filter::Quaternion, Filter::Exponential] {
            if let Ok(plain) = decode(&packed, Mode::Attributes, filter, a.len(), 8) {
                prop_assert_eq!(plain.len(), a.len() * 8);
            }
        }
        for header in [0xE1, 0xD1] {
            packed.resize(packed.len().max(1), 0);
            packed[0] = header;
            for mode in [Mode::Triangles, Mode::Indices] {
                let count = a.len() / 3 * 3;
                if let Ok(plain) = decode(&packed, mode, Filter::None, count, 2) {
                    prop_assert_eq!(plain.len(), count * 2);
                }
            }
        }
    }
}

fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.as_chunks::<4>().0.iter().map(|&c| u32::from_le_bytes(c)).collect()
}

/// A fan of a grid: the encoder uses every kind of code on it.
#[test]
fn a_grid_of_triangles_comes_back() {
    let n = 60u32;
    let list: Vec<u32> = (0..n - 1)
        .flat_map(|y| (0..n - 1).map(move |x| y * n + x))
        .flat_map(|v| [v, v + 1, v + n, v + 1, v + n + 1, v + n])
        .collect();
    let packed = meshopt::encode_index_buffer(&list, (n * n) as usize).unwrap();
    let plain = decode(&packed, Mode::Triangles, Filter::None, list.len(), 2).unwrap();
    let right: Vec<u16> = meshopt::decode_index_buffer(&packed, list.len()).unwrap();
    let bytes: Vec<u8> = right.iter().flat_map(|i| i.to_le_bytes()).collect();
    assert_eq!(plain, bytes);
}

fn directions() -> Vec<[f32; 4]> {
    (0..200)
        .map(|i| {
            let a = i as f32 * 0.7;
            let v = [a.sin(), (a * 1.3).cos(), (a * 0.41).sin() - 0.2, (a * 0.9).cos()];
            let len = v.iter().map(|c| c * c).sum::<f32>().sqrt();
            v.map(|c| c / len)
        })
        .collect()
}

fn i16s(bytes: &[u8]) -> Vec<i16> {
    bytes.as_chunks::<2>().0.iter().map(|&c| i16::from_le_bytes(c)).collect()
}

fn bytes_of<const N: usize>(v: &[[i16; N]]) -> Vec<[u8; 8]> {
    let flat: Vec<u8> = v.as_flattened().iter().flat_map(|c| c.to_le_bytes()).collect();
    flat.as_chunks::<8>().0.to_vec()
}

/// The specification allows a difference of one unit in the last place.
fn near(a: &[i16], b: &[i16]) {
    assert_eq!(a.len(), b.len());
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        assert!((i32::from(*a) - i32::from(*b)).abs() <= 1, "{i}: {a} {b}");
    }
}

#[test]
fn filters_do_what_the_reference_does() {
    let unit: Vec<[f32; 4]> = directions();
    let mut quaternions = meshopt::encode_filter_quat(&unit, 12);
    let packed = pack(&bytes_of(&quaternions));
    let plain = decode(&packed, Mode::Attributes, Filter::Quaternion, unit.len(), 8).unwrap();
    meshopt::decode_filter_quat(&mut quaternions);
    near(&i16s(&plain), quaternions.as_flattened());

    let normals: Vec<[f32; 4]> = unit
        .iter()
        .map(|v| {
            let len = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
            [v[0] / len, v[1] / len, v[2] / len, 1.0]
        })
        .collect();
    let mut octahedral: Vec<[i16; 4]> = meshopt::encode_filter_oct(&normals, 14);
    let packed = pack(&bytes_of(&octahedral));
    let plain = decode(&packed, Mode::Attributes, Filter::Octahedral, unit.len(), 8).unwrap();
    meshopt::decode_filter_oct(&mut octahedral);
    near(&i16s(&plain), octahedral.as_flattened());

    let mut small: Vec<[i8; 4]> = meshopt::encode_filter_oct(&normals, 8);
    let bytes: Vec<[u8; 4]> = small.iter().map(|v| v.map(|c| c as u8)).collect();
    let plain = decode(&pack(&bytes), Mode::Attributes, Filter::Octahedral, unit.len(), 4).unwrap();
    meshopt::decode_filter_oct(&mut small);
    for (a, b) in plain.iter().zip(small.as_flattened()) {
        assert!((i32::from(*a as i8) - i32::from(*b)).abs() <= 1);
    }

    let numbers: Vec<[f32; 3]> = unit.iter().map(|v| [v[0] * 1e4, v[1] * 1e-3, v[2]]).collect();
    let mode = meshopt::EncodeExpMode::Separate;
    let mut exponential: Vec<[u32; 3]> = meshopt::encode_filter_exp(&numbers, 15, mode);
    let flat: Vec<u8> = exponential.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
    let packed = pack(flat.as_chunks::<12>().0);
    let plain = decode(&packed, Mode::Attributes, Filter::Exponential, unit.len(), 12).unwrap();
    meshopt::decode_filter_exp(&mut exponential);
    assert_eq!(words(&plain), exponential.as_flattened());
}

#[test]
fn layouts_are_checked_before_anything_is_allocated() {
    let ok =
        |mode, filter, count, stride, encoded| check(mode, filter, count, stride, encoded).is_ok();
    let none = Filter::None;
    assert!(ok(Mode::Attributes, none, 1, 16, 1000));
    for stride in [0, 2, 6, 260] {
        assert!(!ok(Mode::Attributes, none, 1, stride, 1000), "{stride}");
    }
    assert!(!ok(Mode::Triangles, none, 4, 4, 1000));
    assert!(!ok(Mode::Triangles, none, 3, 3, 1000));
    assert!(!ok(Mode::Indices, Filter::Exponential, 3, 4, 1000));
    assert!(!ok(Mode::Attributes, Filter::Quaternion, 1, 16, 1000));
    // So many elements that no stream of this length can hold them.
    assert!(!ok(Mode::Attributes, none, usize::MAX / 4, 4, 1000));
    assert!(!ok(Mode::Attributes, none, 1 << 30, 4, 1 << 20));
    assert!(!ok(Mode::Indices, none, 1000, 4, 1000));
    assert!(!ok(Mode::Triangles, none, 6000, 4, 1000));
}
