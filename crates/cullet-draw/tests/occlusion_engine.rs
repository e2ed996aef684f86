//! The engine's occlusion culling before both judges: what it calls hidden is proved to be, or at the least neither
//! refuted nor seen by any of 8 × 8 jittered samples a pixel.

use cullet::bounds::Aabb;
use cullet::cull::occlusion::{Convex, OcclusionBuffer, Patch, Visibility};
use cullet::{Camera, Depth, Projection, Simd, Transform, View};
use cullet_draw::{
    OccluderTriangles, Proof, ProofOptions, Prover, SampleOptions, Sampled, occluder_scene,
    sampled_boxes,
};
use proptest::prelude::*;

/// How an occluder is drawn by the engine.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// A box, as one body.
    Convex,
    /// A box, as twelve triangles in patches.
    Patches,
    /// A bumpy sheet with shared edges, one-sided.
    Sheet,
    /// Triangles that share nothing, two-sided.
    Soup,
}

#[derive(Clone, Debug)]
struct Occluder {
    kind: Kind,
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    transform: Transform,
}

const FACES: [[u32; 4]; 6] =
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
const UNIT: Aabb = Aabb { min: [-1.0; 3], max: [1.0; 3] };

impl Occluder {
    fn new(kind: Kind, n: u32, shape: &[f32], transform: Transform) -> Self {
        let value = |i: usize| shape[i % shape.len()];
        let (positions, indices): (Vec<[f32; 3]>, Vec<u32>) = match kind {
            Kind::Convex | Kind::Patches => (
                UNIT.corners().to_vec(),
                FACES.iter().flat_map(|f| [0, 1, 2, 0, 2, 3].map(|k| f[k])).collect(),
            ),
            Kind::Sheet => {
                let row = n + 1;
                let at = |i: u32| i as f32 / n as f32 * 2.0 - 1.0;
                let bump = |v: u32| value(v as usize) * 0.3;
                let positions =
                    (0..row * row).map(|v| [at(v % row), at(v / row), bump(v)]).collect();
                let indices = (0..n * n).flat_map(|i| {
                    let v = i / n * row + i % n;
                    [v, v + 1, v + row + 1, v, v + row + 1, v + row]
                });
                (positions, indices.collect())
            }
            Kind::Soup => {
                let count = n * 4;
                let positions =
                    (0..count as usize * 3).map(|v| [0, 1, 2].map(|a| value(v * 7 + a * 3)));
                (positions.collect(), (0..count * 3).collect())
            }
        };
        Self { kind, positions, indices, transform }
    }

    fn two_sided(&self) -> bool {
        self.kind == Kind::Soup
    }

    fn draw(&self, buffer: &mut OcclusionBuffer) {
        if self.kind == Kind::Convex {
            let convex = Convex::from_box(&UNIT).unwrap();
            return convex.draw(Simd::best(), buffer, &self.transform);
        }
        let cut = Patch::cut(&self.positions, &self.indices, 7, self.two_sided());
        for patch in cut.unwrap() {
            patch.draw(Simd::best(), buffer, &self.transform);
        }
    }

    fn triangles(&self) -> OccluderTriangles<'_> {
        OccluderTriangles {
            positions: &self.positions,
            indices: &self.indices,
            transform: self.transform,
            two_sided: self.two_sided(),
        }
    }
}

fn occluder() -> impl Strategy<Value = Occluder> {
    let small = || -0.4..0.4_f32;
    (
        prop::sample::select(vec![Kind::Convex, Kind::Patches, Kind::Sheet, Kind::Soup]),
        1..7_u32,
        prop::collection::vec(-1.0..1.0_f32, 97),
        [small(), small(), small(), small(), small(), small()],
        ([0.5..5.0_f32, 0.5..4.0_f32, 0.2..1.5_f32], any::<bool>()),
        [-3.0..3.0_f64, -2.0..2.0_f64, -14.0..-2.0_f64],
    )
        .prop_map(|(kind, n, shape, off, ([x, y, z], mirror), translation)| {
            let linear = [
                [if mirror { -x } else { x }, off[0], off[1]],
                [off[2], y, off[3]],
                [off[4], off[5], z],
            ];
            Occluder::new(kind, n, &shape, Transform { linear, translation })
        })
}

fn bounds() -> impl Strategy<Value = Aabb> {
    ([-5.0..5.0_f32, -4.0..3.0_f32, -24.0..-3.0_f32], [0.02..1.5_f32, 0.02..1.5_f32, 0.02..1.5_f32])
        .prop_map(|(min, size)| Aabb { min, max: std::array::from_fn(|a| min[a] + size[a]) })
}

fn view(kind: u8, reversed: bool, mirrored: bool) -> View {
    let projection = match kind {
        0 => Projection::Perspective {
            fov_y_radians: 0.9,
            aspect: 16.0 / 9.0,
            near: 0.1,
            far: f64::INFINITY,
        },
        1 => Projection::OffCentre {
            left: -0.05,
            right: 0.1,
            bottom: -0.06,
            top: 0.03,
            near: 0.1,
            far: 60.0,
        },
        _ => Projection::Orthographic {
            left: -5.0,
            right: 4.0,
            bottom: -3.0,
            top: 2.5,
            near: 0.1,
            far: 60.0,
        },
    };
    let camera = Camera::look_at([0.1, 0.2, 0.3], [0.3, -0.1, -10.0], projection);
    let depth = if reversed { Depth::Reversed } else { Depth::Standard };
    let mut m = View::new(&camera, depth, [96, 54]).unwrap().clip_from_world();
    if mirrored {
        (0..4).for_each(|c| m[c * 4] = -m[c * 4]);
    }
    View::from_matrix(m, depth, [96, 54]).unwrap()
}

/// Counts of the boxes, of those that the engine hides, and of those proved hidden. An error names a box that
/// a judge finds visible.
fn judge(
    view: &View,
    size: [u32; 2],
    occluders: &[Occluder],
    boxes: &[Aabb],
    seed: u64,
) -> Result<[usize; 3], String> {
    let mut buffer = OcclusionBuffer::new(size).unwrap();
    buffer.begin(view, [0.0; 3]);
    occluders.iter().for_each(|o| o.draw(&mut buffer));
    let hidden: Vec<Aabb> =
        boxes.iter().copied().filter(|t| buffer.test_box(t) == Visibility::Hidden).collect();
    if hidden.is_empty() {
        return Ok([0; 3]);
    }
    let triangles: Vec<_> = occluders.iter().map(Occluder::triangles).collect();
    let scene = occluder_scene(&triangles).unwrap();
    let options = SampleOptions { samples: 8, seed: Some(seed), ..SampleOptions::default() };
    let sampled = sampled_boxes(&scene, view, &hidden, &options);
    let prover = Prover::new(view, &triangles);
    let effort = ProofOptions { smallest_px: 1.0 / 16.0, max_cells: 20_000 };
    let mut proved = 0;
    for (bounds, sampled) in hidden.iter().zip(sampled) {
        let proof = prover.prove(bounds, &Transform::IDENTITY, &effort);
        if matches!(proof, Proof::Refuted { .. }) || sampled == Sampled::Visible {
            return Err(format!("{bounds:?} was called hidden: {proof:?}, {sampled:?}"));
        }
        proved += usize::from(proof == Proof::Proved);
    }
    Ok([boxes.len(), hidden.len(), proved])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cullet_testkit::cases(256)))]

    #[test]
    fn what_is_hidden_is_never_refuted_nor_seen(
        occluders in prop::collection::vec(occluder(), 1..8),
        boxes in prop::collection::vec(bounds(), 60),
        (kind, reversed, mirrored) in (0..3_u8, any::<bool>(), any::<bool>()),
        size in prop::sample::select(vec![[96, 54], [192, 108], [48, 27], [37, 91], [5, 3]]),
        seed in any::<u64>(),
    ) {
        let view = view(kind, reversed, mirrored);
        judge(&view, size, &occluders, &boxes, seed).map_err(TestCaseError::fail)?;
    }
}

/// Each kind has a fixed scene: enough is hidden, and nearly all of it proved.
#[test]
fn each_kind_hides_what_can_be_proved() {
    let shape: Vec<f32> = (0..97).map(|i| (i as f32 * 2.399).sin()).collect();
    let boxes: Vec<Aabb> = (0..400)
        .map(|k| {
            let [x, y] = [(k % 20) as f32 * 0.5 - 5.0, (k / 20) as f32 * 0.3 - 3.0];
            Aabb { min: [x, y, -14.0], max: [x + 0.2, y + 0.2, -13.0] }
        })
        .collect();
    for (kind, least) in
        [(Kind::Convex, 40), (Kind::Patches, 40), (Kind::Sheet, 40), (Kind::Soup, 20)]
    {
        let at = Transform::from_scale_translation([2.5, 2.0, 0.5], [0.4, 0.1, -7.0]);
        let occluders = [Occluder::new(kind, 5, &shape, at)];
        let view = view(0, true, false);
        let [_, hidden, proved] = judge(&view, [192, 108], &occluders, &boxes, 5).unwrap();
        println!("{kind:?}: {hidden} hidden, {proved} proved");
        assert!(hidden >= least, "{kind:?}: {hidden} hidden");
        assert!(proved * 10 >= hidden * 9, "{kind:?}: {proved} of {hidden} proved");
    }
}
