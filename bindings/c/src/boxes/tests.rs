use std::mem::MaybeUninit;
use std::ptr::{from_ref, null, null_mut};

use super::arrays::*;
use super::occluders::*;
use super::*;
use crate::transform::Transform;
use crate::view::cullet_view_look_at;
use engine::bounds::Aabb;
use engine::cull::occlusion::{Convex, DynamicSurface};

/// Boxes of 64 bytes, as a program may have them.
#[repr(C)]
#[derive(Clone, Copy)]
struct Object<T> {
    name: u64,
    first: [T; 3],
    second: [T; 3],
    rest: [u32; 3],
}

fn random(count: usize) -> Vec<Aabb> {
    let mut state = 7_u32;
    let mut next = |range: f32| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32 * range
    };
    // Numbers that f32 has exactly, near 1e6 too, so that all layouts say the same.
    let mut cut = |range: f32| (next(range) * 8.0).floor() / 8.0;
    let mut all = Vec::new();
    for _ in 0..count {
        let center = [cut(120.0) - 60.0, cut(12.0), -cut(120.0)];
        let half = [cut(2.0) + 0.125, cut(2.0) + 0.125, cut(2.0) + 0.125];
        all.push(Aabb::new(
            [0, 1, 2].map(|a| center[a] - half[a]),
            [0, 1, 2].map(|a| center[a] + half[a]),
        ));
    }
    all
}

fn view_from(at: [f64; 3]) -> View {
    let target = [at[0], at[1], at[2] - 1.0];
    let mut view = MaybeUninit::uninit();
    // SAFETY: every pointer is of a value that lives on, and the view is filled.
    unsafe {
        let (eye, target, to) = (at.as_ptr(), target.as_ptr(), view.as_mut_ptr());
        assert_eq!(cullet_view_look_at(eye, target, 0.9, 0.1, 1280, 720, to), Status::Ok);
        view.assume_init()
    }
}

fn created() -> Boxes {
    let mut boxes = Boxes { id: 0 };
    // SAFETY: the pointer is of a value that lives on.
    assert_eq!(unsafe { cullet_boxes_create(320, &mut boxes) }, Status::Ok);
    boxes
}

fn arrays<T>(objects: &[Object<T>], number: Number, form: BoxForm, origin: [f64; 3]) -> BoxArrays {
    BoxArrays {
        first: from_ref(&objects[0].first).cast(),
        second: from_ref(&objects[0].second).cast(),
        stride: size_of::<Object<T>>(),
        second_stride: 0,
        count: objects.len(),
        number: number as u32,
        form: form as u32,
        origin,
    }
}

fn set(boxes: Boxes, arrays: &BoxArrays) -> Status {
    // SAFETY: the arrays are of values that live on.
    unsafe { cullet_boxes_set(boxes, arrays) }
}

fn culled(boxes: Boxes, view: &View, count: usize) -> Vec<u8> {
    let (mut flags, mut visible) = (vec![9; count], 0);
    let mut words = vec![u64::MAX; count.div_ceil(64)];
    // SAFETY: pointers are of values that live on.
    unsafe {
        let (to, room) = (flags.as_mut_ptr(), flags.len());
        assert_eq!(cullet_boxes_cull(boxes, view, to, room, &mut visible), Status::Ok);
        let (to, room) = (words.as_mut_ptr(), words.len());
        assert_eq!(cullet_boxes_cull_bits(boxes, view, to, room, null_mut()), Status::Ok);
    }
    assert_eq!(visible, flags.iter().filter(|f| **f == 1).count());
    assert_eq!(visible, words.iter().map(|w| w.count_ones() as usize).sum::<usize>());
    for (at, flag) in flags.iter().enumerate() {
        assert_eq!(u64::from(*flag), words[at / 64] >> (at % 64) & 1);
    }
    flags
}

const QUAD: [u16; 6] = [0, 1, 2, 0, 2, 3];
const TETRAHEDRON: [u32; 12] = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];

/// A vertex with something beside its place.
type Vertex = [f32; 5];

fn places<const N: usize>(vertices: &[Vertex; N]) -> [[f32; 3]; N] {
    vertices.map(|v| [v[0], v[1], v[2]])
}

/// Two walls, a body, and a quad that is turned, in the arrays of a program.
struct Scenery {
    walls: [[f32; 6]; 2],
    body: [Vertex; 4],
    quad: [Vertex; 4],
    turned: Transform,
}

fn scenery() -> Scenery {
    let turned = Transform {
        linear: [0.0, 0.0, -1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0],
        translation: [-12.0, 0.0, -30.0],
    };
    Scenery {
        walls: [[-9.0, 0.0, -21.0, -1.0, 9.0, -20.0], [3.0, 0.0, -41.0, 30.0, 12.0, -40.0]],
        body: [
            [12.0, 9.0, -24.0, 5.0, 5.0],
            [2.0, -1.0, -24.0, 5.0, 5.0],
            [2.0, 9.0, -34.0, 5.0, 5.0],
            [12.0, -1.0, -34.0, 5.0, 5.0],
        ],
        quad: [
            [-9.0, -9.0, -9.0, 1.0, 2.0],
            [-9.0, -9.0, 9.0, 1.0, 2.0],
            [-9.0, 9.0, 9.0, 1.0, 2.0],
            [-9.0, 9.0, -9.0, 1.0, 2.0],
        ],
        turned,
    }
}

impl Scenery {
    fn given(&self) -> [Occluder; 3] {
        let of = |kind: OccluderKind, index_size, positions: &[f32], stride, count| Occluder {
            kind: kind as u32,
            index_size,
            positions: positions.as_ptr(),
            stride,
            position_count: count,
            indices: null(),
            index_count: 0,
            transform: null(),
        };
        let walls = of(OccluderKind::Boxes, 0, self.walls.as_flattened(), 24, 2);
        let mut body = of(OccluderKind::Hull, 4, self.body.as_flattened(), 20, 4);
        (body.indices, body.index_count) = (TETRAHEDRON.as_ptr().cast(), 12);
        let mut quad = of(OccluderKind::TwoSidedTriangles, 2, self.quad.as_flattened(), 20, 4);
        (quad.indices, quad.index_count, quad.transform) = (QUAD.as_ptr().cast(), 6, &self.turned);
        [walls, body, quad]
    }

    fn engine(&self) -> (Vec<Convex>, DynamicSurface) {
        let mut convex = Vec::new();
        for [a, b, c, d, e, f] in self.walls {
            convex.push(Convex::from_box(&Aabb::new([a, b, c], [d, e, f])).unwrap());
        }
        convex.push(Convex::from_mesh(&places(&self.body), &TETRAHEDRON).unwrap());
        let mut surface = DynamicSurface::default();
        surface.set(&places(&self.quad), &QUAD.map(u32::from), true).unwrap();
        (convex, surface)
    }
}

#[test]
fn flags_are_the_engines_own_answers_in_every_layout() {
    let all = random(3000);
    let (view, scenery) = (view_from([0.0, 4.0, 6.0]), scenery());
    let seen = to_engine(&view).unwrap();
    let batch = Batch::from_slice(&all);
    let mut within = vec![0; mask_words(all.len())];
    let planes = Planes::new(&seen.frustum());
    mask_boxes(Simd::best(), &planes, &batch, 0, &mut within);
    let mut buffer = OcclusionBuffer::new([320, 180]).unwrap();
    buffer.begin(&seen, [0.0; 3]);
    let (convex, mut surface) = scenery.engine();
    for shape in &convex {
        shape.draw(Simd::best(), &mut buffer, &engine::Transform::IDENTITY);
    }
    surface.draw(Simd::best(), &mut buffer, &scenery.turned.to_engine());
    let (mut visible, mut hidden) = (within.clone(), within.clone());
    buffer.test_boxes(Simd::best(), &batch, 0, &within, &mut visible, &mut hidden);
    let flags = |words: &[u64]| -> Vec<u8> {
        (0..all.len()).map(|at| (words[at / 64] >> (at % 64) & 1) as u8).collect()
    };
    let count = |words: &[u64]| words.iter().map(|w| w.count_ones()).sum::<u32>();
    assert!(count(&within) > 900 && count(&hidden) > 300, "{} {}", count(&within), count(&hidden));

    let boxes = created();
    let object = |first, second| Object { name: 1, first, second, rest: [2; 3] };
    let corners: Vec<_> = all.iter().map(|b| object(b.min, b.max)).collect();
    let half = |b: &Aabb, a: usize| (b.max[a] - b.min[a]) * 0.5;
    let centers: Vec<_> = all
        .iter()
        .map(|b| {
            let size = [0, 1, 2].map(|a| half(b, a));
            object([0, 1, 2].map(|a| b.min[a] + size[a]), size)
        })
        .collect();
    let wide = |o: &Object<f32>| Object {
        name: 1,
        first: o.first.map(f64::from),
        second: o.second.map(f64::from),
        rest: [2; 3],
    };
    let wide_corners: Vec<_> = corners.iter().map(wide).collect();
    let wide_centers: Vec<_> = centers.iter().map(wide).collect();
    let layouts = [
        arrays(&corners, Number::F32, BoxForm::MinMax, [0.0; 3]),
        arrays(&centers, Number::F32, BoxForm::CenterHalf, [0.0; 3]),
        arrays(&wide_corners, Number::F64, BoxForm::MinMax, [0.0; 3]),
        arrays(&wide_centers, Number::F64, BoxForm::CenterHalf, [0.0; 3]),
    ];
    for layout in &layouts {
        // SAFETY: no occluders are read.
        let none = unsafe { cullet_boxes_set_occluders(boxes, null(), 0) };
        assert_eq!((none, set(boxes, layout)), (Status::Ok, Status::Ok));
        let found = culled(boxes, &view, all.len());
        let lost = |mine: &[u8], own: &[u64]| {
            flags(own).iter().zip(mine).filter(|(own, mine)| own > mine).count()
        };
        // Rounding outward keeps a few more at the planes, and none less.
        assert_eq!(lost(&found, &within), 0, "{layout:?}");
        let given = scenery.given();
        // SAFETY: the arrays are of values that live on.
        let done = unsafe { cullet_boxes_set_occluders(boxes, given.as_ptr(), 3) };
        assert_eq!(done, Status::Ok);
        let found = culled(boxes, &view, all.len());
        assert_eq!(lost(&found, &visible), 0, "{layout:?}");
        let more = found.iter().map(|f| u32::from(*f)).sum::<u32>() - count(&visible);
        assert!(more <= if layout.form + layout.number == 0 { 0 } else { 5 }, "{more}: {layout:?}");
    }
}

#[test]
fn far_from_zero_doubles_are_as_good_as_floats_near_it() {
    let all = random(2000);
    let far = [1e7, 0.0, -3e7];
    let boxes = created();
    let object = |first, second| Object { name: 0, first, second, rest: [0; 3] };
    let near: Vec<_> = all.iter().map(|b| object(b.min, b.max)).collect();
    let place = |p: [f32; 3]| [0, 1, 2].map(|a| f64::from(p[a]) + far[a]);
    let doubles: Vec<_> = all
        .iter()
        .map(|b| Object { name: 0, first: place(b.min), second: place(b.max), rest: [0; 3] })
        .collect();
    assert_eq!(set(boxes, &arrays(&near, Number::F32, BoxForm::MinMax, [0.0; 3])), Status::Ok);
    let expected = culled(boxes, &view_from([0.0, 4.0, 6.0]), all.len());
    let view = view_from([far[0], 4.0, far[2] + 6.0]);
    let layouts = [
        arrays(&near, Number::F32, BoxForm::MinMax, far),
        arrays(&doubles, Number::F64, BoxForm::MinMax, [0.0; 3]),
    ];
    for layout in &layouts {
        assert_eq!(set(boxes, layout), Status::Ok);
        let found = culled(boxes, &view, all.len());
        let differ = found.iter().zip(&expected).filter(|(a, b)| a != b).count();
        assert!(differ < 5, "{differ} of {}", all.len());
    }
    // Others take their place, relative to another point than the set is: half of them leave.
    let moved = BoxArrays { count: 1000, ..arrays(&near, Number::F32, BoxForm::MinMax, [0.0; 3]) };
    // SAFETY: the arrays are of values that live on.
    assert_eq!(unsafe { cullet_boxes_update(boxes, 500, &moved) }, Status::Ok);
    let found = culled(boxes, &view, all.len());
    assert!(found[500..1500].iter().all(|f| *f == 0));
    let differ = |of: std::ops::Range<usize>| {
        found[of.clone()].iter().zip(&expected[of]).filter(|(a, b)| a != b).count()
    };
    assert!(differ(0..500) + differ(1500..2000) < 5);
    // SAFETY: nothing is read, since the range is refused.
    assert_eq!(unsafe { cullet_boxes_update(boxes, 1001, &moved) }, Status::InvalidValue);
}

#[test]
fn what_is_not_a_number_is_visible_and_what_is_empty_is_not() {
    let boxes = created();
    let (nan, far) = (f32::NAN, f32::INFINITY);
    // Behind the eye, but for a number.
    let object = |first: [f32; 3], second| Object { name: 0, first, second, rest: [0; 3] };
    let centers = [
        object([0.0, 0.0, 9.0], [1.0; 3]),
        object([nan, 0.0, 9.0], [1.0; 3]),
        object([0.0, 0.0, 9.0], [1.0, nan, 1.0]),
        object([0.0, far, 9.0], [1.0; 3]),
        object([0.0, 0.0, 9.0], [far; 3]),
        object([0.0, 0.0, -9.0], [1.0, -1.0, 1.0]),
        object([0.0, 0.0, -9.0], [0.0; 3]),
    ];
    let expected = [0, 1, 1, 1, 1, 0, 1];
    let wide = centers.map(|o| Object {
        name: 0,
        first: o.first.map(f64::from),
        second: o.second.map(f64::from),
        rest: [0; 3],
    });
    let view = view_from([0.0; 3]);
    assert_eq!(
        set(boxes, &arrays(&centers, Number::F32, BoxForm::CenterHalf, [0.0; 3])),
        Status::Ok
    );
    assert_eq!(culled(boxes, &view, 7), expected);
    assert_eq!(set(boxes, &arrays(&wide, Number::F64, BoxForm::CenterHalf, [0.0; 3])), Status::Ok);
    assert_eq!(culled(boxes, &view, 7), expected);
    // Behind a wall that covers the whole view they are no less visible; the point is.
    let scenery = Scenery { walls: [[-99.0, -99.0, -3.0, 99.0, 99.0, -2.0]; 2], ..scenery() };
    // SAFETY: the arrays are of values that live on.
    let done = unsafe { cullet_boxes_set_occluders(boxes, scenery.given().as_ptr(), 1) };
    assert_eq!(done, Status::Ok);
    assert_eq!(culled(boxes, &view, 7), [0, 1, 1, 1, 1, 0, 0]);
}

#[test]
fn a_box_is_not_hidden_by_itself_and_occluders_move() {
    let boxes = created();
    let scenery = scenery();
    let [a, b, c, d, e, f] = scenery.walls[0];
    let object = |first, second| Object { name: 0, first, second, rest: [0; 3] };
    let all = [object([a, b, c], [d, e, f]), object([-6.0, 1.0, -30.0], [-5.0, 2.0, -29.0_f32])];
    let view = view_from([-5.0, 4.0, 6.0]);
    assert_eq!(set(boxes, &arrays(&all, Number::F32, BoxForm::MinMax, [0.0; 3])), Status::Ok);
    // SAFETY: the arrays are of values that live on.
    let done = unsafe { cullet_boxes_set_occluders(boxes, scenery.given().as_ptr(), 1) };
    assert_eq!(done, Status::Ok);
    assert_eq!(culled(boxes, &view, 2), [1, 0]);
    let linear = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    for (translation, expected) in
        [([50.0, 0.0, 0.0], [1, 1]), ([0.0; 3], [1, 0]), ([f64::NAN; 3], [1, 1])]
    {
        let transform = Transform { linear, translation };
        // SAFETY: the pointer is of a value that lives on.
        let done = unsafe { cullet_boxes_move_occluder(boxes, 0, &transform) };
        assert_eq!(done, Status::Ok);
        assert_eq!(culled(boxes, &view, 2), expected, "{translation:?}");
    }
    // SAFETY: nothing is read.
    assert_eq!(unsafe { cullet_boxes_move_occluder(boxes, 1, null()) }, Status::NotFound);
}
