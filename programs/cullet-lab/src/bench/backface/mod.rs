//! Back-face culling of the triangles of one model, and of clusters.

mod ball;
mod frame;

use crate::methods::cluster::{
    Bound, ClusterBounds, EllipticConeQuantised, NormalBox, NormalCone, Pyramid,
};
use crate::methods::{Bulk, Planes16, Planes32};
use crate::shapes::bumpy_ball;
use cullet::bounds::Sphere;
use cullet::cull::Indices;
use cullet::cull::backface::{ClusterPlanes, EllipticCone, Facing, ObjectEye, Planes8};
use cullet::{
    Simd, Transform,
    view::{CullFace, FrontFace},
};
use cullet_mesh::{MaskGrid, NormalMasks, ViewCone};

use super::measure::{beside_reading, fastest_of_both};
use super::measured::{Measured, Workload};
use super::options::BenchOptions;
use ball::EYE;

/// Distinct clusters to fit; more are repetitions, for fitting takes longer than all the rest.
const DISTINCT: usize = 256;
/// Cluster count of a large scene; its clusters lie in the second cache.
const CLUSTERS: usize = 16_384;

pub(super) fn run(options: &BenchOptions, each: &mut dyn FnMut(Measured)) {
    for &len in &options.sizes {
        let names = ["vertices", "planes32", "planes16", "planes8", "masks"];
        let wanted = |name: &str| any_output(options, &triangles(name, len));
        if !names.into_iter().any(wanted) {
            continue;
        }
        let (positions, indices) = bumpy_ball(len);
        if options.wants(&format!("{}/list", triangles("vertices", len))) {
            run_vertices(options, (&positions, &indices), each);
        }
        // One form at a time: four million triangles fill much memory.
        if wanted("planes32") {
            let planes = Planes32::new(&positions, &indices);
            let test = (&planes, EYE, planes.cull_ref(EYE));
            run_test(options, &triangles("planes32", len), test, [len, 16], None, each);
        }
        if wanted("planes16") {
            let planes = Planes16::new(&positions, &indices);
            let test = (&planes, EYE, planes.cull_ref(EYE));
            run_test(options, &triangles("planes16", len), test, [len, 8], None, each);
        }
        if wanted("planes8") {
            let planes = Planes8::new(&positions, &indices);
            let name = triangles("planes8", len);
            let is_list = options.wants(&format!("{name}/list"));
            let versus = is_list.then(|| {
                let mut kept = Vec::new();
                let pass = || frame::keep_of_vertices(&positions, &indices, &mut kept);
                let [_, time] = fastest_of_both(options.seconds, |_| (), pass);
                ("vertices-f32", time / len as f64)
            });
            let Some(eye) = planes.eye(EYE, Facing::Back, 0.0) else { continue };
            let test = (&planes, EYE, planes.cull_ref(&eye));
            run_test(options, &name, test, [len, 4], versus, each);
        }
        if let Some(grid) = MaskGrid::new(16).filter(|_| wanted("masks")) {
            let mut masks = NormalMasks::default();
            grid.encode_triangles(&positions, &indices, &mut masks);
            let sphere = Sphere { center: [0.0; 3], radius: 1.0 };
            let cone = ViewCone::to_sphere(EYE, &sphere);
            let mask = grid.mask(Simd::best(), cone.as_ref());
            let test = (&masks, &mask, masks.cull_ref(&mask));
            run_test(options, &triangles("masks", len), test, [len, 2], None, each);
        }
    }
    let (positions, indices) = bumpy_ball(DISTINCT * 64);
    let planes: Vec<ClusterPlanes> = indices
        .chunks(64 * 3)
        .map(|c| {
            let corners = c.as_chunks::<3>().0.iter();
            ClusterPlanes::new(corners.map(|t| t.map(|v| positions[v as usize])))
        })
        .collect();
    run_clusters::<EllipticCone>(options, ("elliptic", 48), &planes, each);
    run_clusters::<EllipticConeQuantised>(options, ("elliptic8", 21), &planes, each);
    run_clusters::<NormalCone>(options, ("cone", 28), &planes, each);
    run_clusters::<NormalBox>(options, ("box", 40), &planes, each);
    run_clusters::<Pyramid<6>>(options, ("pyramid6", 84), &planes, each);
    run_clusters::<Pyramid<8>>(options, ("pyramid8", 108), &planes, each);
    frame::run(options, each);
}

fn run_clusters<B: Bound>(
    options: &BenchOptions,
    (name, bytes): (&str, usize),
    planes: &[ClusterPlanes],
    each: &mut dyn FnMut(Measured),
) {
    let name = format!("backface/clusters/{name}");
    if !any_output(options, &name) {
        return;
    }
    let fits: Vec<Option<B>> = planes.iter().map(B::fit).collect();
    let all: Vec<Option<B>> = fits.iter().copied().cycle().take(CLUSTERS).collect();
    let mut expected = vec![0; CLUSTERS.div_ceil(64)];
    for (i, bound) in all.iter().enumerate() {
        let behind = bound.as_ref().is_some_and(|b| b.is_behind(EYE));
        expected[i / 64] |= u64::from(behind) << (i % 64);
    }
    let bounds: ClusterBounds<B> = all.into_iter().collect();
    run_test(options, &name, (&bounds, EYE, expected), [CLUSTERS, bytes], None, each);
}

const OUTPUTS: [&str; 3] = ["mask", "count", "list"];

fn any_output(options: &BenchOptions, name: &str) -> bool {
    OUTPUTS.iter().any(|o| options.wants(&format!("{name}/{o}")))
}

fn triangles(kind: &str, len: usize) -> String {
    let power = len.checked_ilog10().unwrap_or(0);
    let scale = 10_usize.pow(power);
    if len.is_multiple_of(scale) {
        format!("backface/{kind}/{}e{power}", len / scale)
    } else {
        format!("backface/{kind}/{len}")
    }
}

/// A set of bounds, its eye, and what the oracle culls. `versus` is the name and the time an item
/// of what lists are held against.
fn run_test<E: Copy>(
    options: &BenchOptions,
    name: &str,
    (test, eye, expected): (&impl Bulk<E>, E, Vec<u64>),
    [len, bytes]: [usize; 2],
    versus: Option<(&'static str, f64)>,
    each: &mut dyn FnMut(Measured),
) {
    let culled_of = |words: &[u64]| words.iter().map(|w| u64::from(w.count_ones())).sum::<u64>();
    let culled = culled_of(&expected);
    let kept_ref: Vec<u32> =
        (0..len as u32).filter(|&i| expected[i as usize / 64] >> (i % 64) & 1 == 0).collect();
    let (mut words, mut kept) = (Vec::new(), Indices::new());
    for output in OUTPUTS {
        let name = format!("{name}/{output}");
        if !options.wants(&name) {
            continue;
        }
        for (level_name, level) in cullet_command::machine::levels() {
            let mut pass = || match output {
                "mask" => test.cull(level, eye, &mut words),
                "count" => {
                    std::hint::black_box(test.count(level, eye));
                }
                _ => test.keep(level, eye, &mut kept),
            };
            pass();
            let times = beside_reading(options.seconds, len * bytes, pass);
            let checked = match output {
                "mask" => words == expected,
                "count" => test.count(level, eye) == culled,
                _ => *kept == *kept_ref,
            };
            let (name, visible) = (name.clone(), kept_ref.len());
            let workload = Workload { name, level: level_name, items: len, visible, checked };
            let versus = versus.filter(|_| output == "list");
            each(Measured {
                versus: versus.map(|(name, ns)| (name, ns * len as f64 / times[1])),
                ..workload.streaming(bytes, times)
            });
        }
    }
}

/// The test that needs nothing prepared: three vertices, in f64, with an error bound.
fn run_vertices(
    options: &BenchOptions,
    (positions, indices): (&[[f32; 3]], &[u32]),
    each: &mut dyn FnMut(Measured),
) {
    let len = indices.len() / 3;
    let (identity, face) = (&Transform::IDENTITY, FrontFace::default());
    let eye = ObjectEye::new(EYE, identity, face, CullFace::Back);
    let mut kept = Vec::new();
    // Twelve bytes of indices, and half a vertex of twelve.
    const BYTES: usize = 18;
    let times = beside_reading(options.seconds, len * BYTES, || {
        kept.clear();
        eye.keep_into(positions, indices, 0..len as u32, &mut kept);
    });
    let corners = |t: usize| [0, 1, 2].map(|k| positions[indices[t * 3 + k] as usize]);
    let expected = (0..len).filter(|&t| !eye.culls(&corners(t))).map(|t| t as u32);
    let workload = Workload {
        name: format!("{}/list", triangles("vertices", len)),
        level: "scalar",
        items: len,
        visible: kept.len(),
        checked: expected.eq(kept.iter().copied()),
    };
    each(workload.streaming(BYTES, times));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ball_is_wound_outward() {
        let (positions, indices) = bumpy_ball(5000);
        assert_eq!(indices.len(), 15_000);
        let wide = |v: u32| positions[v as usize].map(f64::from);
        let mut volume = 0.0;
        for t in indices.as_chunks::<3>().0 {
            let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = t.map(wide);
            volume +=
                ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx);
        }
        assert!(volume / 6.0 > 2.0, "{volume}");
        assert!(positions.iter().all(|p| p.iter().map(|v| v * v).sum::<f32>() <= 1.0));
    }
}
