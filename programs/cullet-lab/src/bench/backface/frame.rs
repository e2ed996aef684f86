//! Costs of a frame of one model apart from its triangles: masks of groups, the list of clusters,
//! planes and masks of a mesh that deforms; and the test that everyone writes first.

use std::ops::Range;

use crate::methods::cluster::{Bound, ClusterBounds, ClusterFacing, TwoWay};
use crate::methods::{Bulk, Groups, Planes32};
use cullet::cull::Indices;
use cullet::cull::backface::{ClusterPlanes, EllipticCone};
use cullet::cull::backface::{Facing, Planes8};
use cullet_mesh::{BackfaceMask, MaskGrid, NormalMasks, ViewCone};

use super::super::measure::beside_reading;
use super::super::measured::{Measured, Workload};
use super::super::options::BenchOptions;
use super::ball::EYE;
use crate::shapes::bumpy_ball;

/// Triangle count of the bunny, in whole clusters.
const TRIANGLES: usize = 69_440;
/// Triangles a cluster.
const CLUSTER: usize = 64;
const GROUPS: usize = 64;

const NAMES: [&str; 6] = [
    "backface/frame/group-masks",
    "backface/frame/clusters",
    "backface/frame/ranges-and-lists",
    "backface/frame/vertices-f32",
    "backface/update/masks",
    "backface/update/planes8",
];

pub(super) fn run(options: &BenchOptions, each: &mut dyn FnMut(Measured)) {
    if !NAMES.iter().any(|name| options.wants(name)) {
        return;
    }
    let model = bumpy_ball(TRIANGLES);
    group_masks(options, &model, each);
    clusters(options, &model, each);
    ranges_and_lists(options, &model, each);
    vertices(options, &model, each);
    updates(options, &model, each);
}

/// One line of results: the time of `pass` beside that of reading as many bytes.
fn measure(
    options: &BenchOptions,
    (name, level): (&str, &'static str),
    [items, visible, bytes]: [usize; 3],
    each: &mut dyn FnMut(Measured),
    pass: impl FnMut(),
    checked: impl FnOnce() -> bool,
) {
    let times = beside_reading(options.seconds, items * bytes, pass);
    let (name, checked) = (name.to_owned(), checked());
    each(Workload { name, level, items, visible, checked }.streaming(bytes, times));
}

type Model = (Vec<[f32; 3]>, Vec<u32>);

/// Masks with N = 16 for a frame of groups; a group is an item, and what it reads are the corners.
fn group_masks(options: &BenchOptions, model: &Model, each: &mut dyn FnMut(Measured)) {
    let [name, ..] = NAMES;
    let Some(grid) = MaskGrid::new(16).filter(|_| options.wants(name)) else { return };
    let groups = Groups::kd(&model.0, &model.1, GROUPS);
    let expected: Vec<BackfaceMask> = groups.masks(cullet::Simd::best(), &grid, EYE).collect();
    // Whatever level made them, no normal of a class that is set may be in front.
    let conservative = groups.spheres().iter().zip(&expected).all(|(sphere, mask)| {
        let Some(cone) = ViewCone::to_sphere(EYE, sphere) else {
            return *mask == BackfaceMask::NOTHING;
        };
        (0..4096).all(|i| {
            let z = f64::from(2 * i + 1) / 4096.0 - 1.0;
            let (y, x) = (f64::from(i) * 2.399_963_229_728_653).sin_cos();
            let r = (1.0 - z * z).sqrt();
            let n = [x * r, y * r, z];
            let along: f64 = (0..3).map(|k| n[k] * cone.axis[k]).sum();
            !mask.culls(grid.encode(n)) || along >= cone.sine
        })
    });
    let sets: usize = expected
        .iter()
        .map(|m| m.bytes().iter().map(|b| b.count_ones() as usize).sum::<usize>())
        .sum();
    let mut masks: Vec<BackfaceMask> = Vec::new();
    for (level_name, level) in cullet_command::machine::levels() {
        let pass = |masks: &mut Vec<BackfaceMask>| {
            masks.clear();
            masks.extend(groups.masks(level, &grid, EYE));
        };
        pass(&mut masks);
        let right = masks == expected && conservative && sets > 0;
        // Three f32 for each of 6·17² corners.
        let sizes = [GROUPS, GROUPS, 6 * 17 * 17 * 12];
        measure(options, (name, level_name), sizes, each, || pass(&mut masks), || right);
    }
}

/// The clusters of the model that are not behind, as a list.
fn clusters(options: &BenchOptions, model: &Model, each: &mut dyn FnMut(Measured)) {
    let [_, name, ..] = NAMES;
    if !options.wants(name) {
        return;
    }
    let fits: Vec<Option<EllipticCone>> = model
        .1
        .chunks(CLUSTER * 3)
        .map(|c| {
            let corners = c.as_chunks::<3>().0.iter();
            EllipticCone::fit(&ClusterPlanes::new(corners.map(|t| t.map(|v| model.0[v as usize]))))
        })
        .collect();
    let bounds: ClusterBounds<EllipticCone> = fits.iter().copied().collect();
    let is_kept = |i: &u32| !fits[*i as usize].is_some_and(|b| b.is_behind(EYE));
    let expected: Vec<u32> = (0..fits.len() as u32).filter(is_kept).collect();
    for (level_name, level) in cullet_command::machine::levels() {
        let mut kept = Indices::new();
        bounds.keep(level, EYE, &mut kept);
        let same = *kept == *expected;
        let pass = || bounds.keep(level, EYE, &mut kept);
        let sizes = [fits.len(), expected.len(), 48];
        measure(options, (name, level_name), sizes, each, pass, || same);
    }
}

/// Triangles of the model that are kept: whole ranges where clusters are proved to be seen from the
/// front, and a list out of the 8-bit planes where they are neither that nor behind. The frame is
/// the item.
fn ranges_and_lists(options: &BenchOptions, model: &Model, each: &mut dyn FnMut(Measured)) {
    let [_, _, name, ..] = NAMES;
    if !options.wants(name) {
        return;
    }
    let planes = Planes8::new(&model.0, &model.1);
    let Some(eye) = planes.eye(EYE, Facing::Back, 0.0) else { return };
    let fits: Vec<TwoWay<EllipticCone>> = model
        .1
        .chunks(CLUSTER * 3)
        .map(|c| {
            let corners = c.as_chunks::<3>().0.iter();
            TwoWay::fit(&ClusterPlanes::new(corners.map(|t| t.map(|v| model.0[v as usize]))))
        })
        .collect();
    let behind: ClusterBounds<EllipticCone> = fits.iter().map(|f| f.back).collect();
    let before: ClusterBounds<EllipticCone> = fits.iter().map(|f| f.front).collect();
    let culled = planes.cull_ref(&eye);
    let facing: Vec<ClusterFacing> = fits.iter().map(|f| f.facing(EYE)).collect();
    let is_kept = |t: &u32| match facing[*t as usize / CLUSTER] {
        ClusterFacing::Back => false,
        ClusterFacing::Front => true,
        ClusterFacing::Mixed => culled[*t as usize / 64] >> (*t % 64) & 1 == 0,
    };
    let expected: Vec<u32> = (0..TRIANGLES as u32).filter(is_kept).collect();
    let mixed = facing.iter().filter(|f| **f == ClusterFacing::Mixed).count();
    for (level_name, level) in cullet_command::machine::levels() {
        let (mut back, mut front) = (Vec::new(), Vec::new());
        let mut ranges: Vec<Range<u32>> = Vec::new();
        let mut list = Indices::new();
        let mut pass = || {
            behind.cull(level, EYE, &mut back);
            before.cull(level, EYE, &mut front);
            ranges.clear();
            let count = fits.len();
            for (i, (back, front)) in back.iter_mut().zip(&front).enumerate() {
                let mut rest = *front;
                while rest != 0 {
                    let start = rest.trailing_zeros();
                    let run = (rest >> start).trailing_ones();
                    rest &= !(u64::MAX >> (64 - run) << start);
                    let first = (i * 64 + start as usize) * CLUSTER;
                    let range = first as u32..(first + run as usize * CLUSTER) as u32;
                    match ranges.last_mut() {
                        Some(last) if last.end == range.start => last.end = range.end,
                        _ => ranges.push(range),
                    }
                }
                // The clusters that are neither, in place of those behind.
                let here = u64::MAX >> (64 - (count - i * 64).min(64));
                *back = !(*back | front) & here;
            }
            planes.keep_in(level, EYE, &back, &mut list);
        };
        pass();
        let bytes = 96 * fits.len() + 4 * CLUSTER * mixed;
        let times = beside_reading(options.seconds, bytes, pass);
        let mut found: Vec<u32> = ranges.iter().cloned().flatten().collect();
        found.extend_from_slice(&list);
        found.sort_unstable();
        let (name, checked) = (name.to_owned(), found == expected);
        let workload = Workload { name, level: level_name, items: 1, visible: 1, checked };
        each(workload.streaming(bytes, times));
    }
}

/// The test that everyone writes first: the normal of three vertices in f32, no error bound, a push
/// for each triangle that is kept. Its gathers through the indices keep it from being vectorised.
pub(super) fn keep_of_vertices(positions: &[[f32; 3]], indices: &[u32], kept: &mut Vec<u32>) {
    let eye: [f32; 3] = [0, 1, 2].map(|k| EYE[k] as f32);
    kept.clear();
    for (i, t) in indices.as_chunks::<3>().0.iter().enumerate() {
        // Without closures over arrays, which were not inlined here and took ten times as long.
        let [a, b, c] =
            [positions[t[0] as usize], positions[t[1] as usize], positions[t[2] as usize]];
        let (u, v, e) = (from(a, b), from(a, c), from(a, eye));
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        if n[0] * e[0] + n[1] * e[1] + n[2] * e[2] >= 0.0 {
            kept.push(i as u32);
        }
    }
}

fn from(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [b[0] - a[0], b[1] - a[1], b[2] - a[2]]
}

fn vertices(options: &BenchOptions, (positions, indices): &Model, each: &mut dyn FnMut(Measured)) {
    let [_, _, _, name, ..] = NAMES;
    if !options.wants(name) {
        return;
    }
    let mut kept: Vec<u32> = Vec::new();
    let pass = |kept: &mut Vec<u32>| keep_of_vertices(positions, indices, kept);
    pass(&mut kept);
    // The oracle keeps what is in doubt; without a bound some of that is dropped, and nothing else.
    let sure = Planes32::new(positions, indices).cull_ref(EYE);
    let same = kept.iter().all(|&t| sure[t as usize / 64] >> (t % 64) & 1 == 0);
    let culled: u32 = sure.iter().map(|w| w.count_ones()).sum();
    let dropped = TRIANGLES - culled as usize - kept.len();
    let sizes = [TRIANGLES, kept.len(), 18];
    let pass = || pass(&mut kept);
    measure(options, (name, "scalar"), sizes, each, pass, || same && dropped < TRIANGLES / 1000);
}

/// Triangles, all of which are updated, and what is read of each: twelve bytes of indices, and half
/// a vertex.
const UPDATE_SIZES: [usize; 3] = [TRIANGLES, TRIANGLES, 18];

/// All triangles of the model encoded anew, as those of a deforming mesh are.
fn updates(options: &BenchOptions, (positions, indices): &Model, each: &mut dyn FnMut(Measured)) {
    let [.., masks_name, name8] = NAMES;
    // The masks and planes to be updated are first made of another shape in the same box.
    let other: Vec<[f32; 3]> = positions.iter().map(|[x, y, z]| [-x, *y, *z]).collect();
    if let Some(grid) = MaskGrid::new(16).filter(|_| options.wants(masks_name)) {
        let mut masks = NormalMasks::default();
        grid.encode_triangles(&other, indices, &mut masks);
        let mut expected = NormalMasks::default();
        grid.encode_triangles(positions, indices, &mut expected);
        grid.update(positions, indices, 0..TRIANGLES, &mut masks);
        let same = (0..TRIANGLES).all(|i| masks.get(i) == expected.get(i));
        let pass = || grid.update(positions, indices, 0..TRIANGLES, &mut masks);
        measure(options, (masks_name, "scalar"), UPDATE_SIZES, each, pass, || same);
    }
    if options.wants(name8) {
        let mut planes = Planes8::new(positions, indices);
        let culled =
            |planes: &Planes8| planes.eye(EYE, Facing::Back, 0.0).map(|eye| planes.cull_ref(&eye));
        let expected = culled(&planes);
        planes.update(&other, indices, 0..TRIANGLES);
        let changed = culled(&planes) != expected;
        planes.update(positions, indices, 0..TRIANGLES);
        let same = changed && culled(&planes) == expected;
        let pass = || planes.update(positions, indices, 0..TRIANGLES);
        measure(options, (name8, "scalar"), UPDATE_SIZES, each, pass, || same);
    }
}
