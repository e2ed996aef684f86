//! The proof that culling dropped nothing that is seen.

use cullet::{Culler, Reason, Scene, View, ViewState, Visible, funnel::Funnel};
use cullet_cells::InCells;

use crate::frame::{Frame, FrameStats, PixelId, RenderOptions, Selection, first_of_each};
use crate::geometry::Lens;
use crate::prepare::Stage;
use crate::render::{Target, in_pool, render_stage, tiles_in, tiles_of};
use crate::sample::{Jitter, Samples};
use crate::sort;

/// Tiles drawn at a time: with 64 × 64 samples of 32 bytes, 64 MiB.
const BAND_TILES: usize = 512;
/// The most samples along a side of the finer image.
pub(crate) const MAX_SIDE: u32 = 65_536;

/// How to verify.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VerifyOptions {
    /// N: instances that were dropped are also looked for at N × N samples a pixel; 0 and 1 are
    /// off. A finer image than 65 536 samples wide or high is not drawn: N is lowered.
    pub samples: u32,
    /// For the places of those samples. A different seed for every run widens what is tested.
    pub seed: u64,
    /// How many threads; 0 is those of the pool that the call runs in. The answer is the same.
    pub threads: usize,
    /// Count the layers of both frames; see [`RenderOptions::count_layers`].
    pub count_layers: bool,
}

impl Default for VerifyOptions {
    fn default() -> Self {
        Self { samples: 4, seed: 0, threads: 0, count_layers: false }
    }
}

/// Something visible that was dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FalseCull {
    /// The instance.
    pub slot: u32,
    /// The original triangle, if it is seen at one sample a pixel; `None` for a whole instance that
    /// is seen at N × N samples only.
    pub triangle: Option<u32>,
    /// The first pixel where it is seen, by row and then column.
    pub pixel: [u32; 2],
    /// Why its instance was dropped, if the culler gave reasons; `None` if only triangles were.
    pub reason: Option<Reason>,
}

impl FalseCull {
    /// Ascending by slot, triangle and pixel, whole instances first.
    pub(crate) fn sorted(all: &[Self]) -> Vec<Self> {
        let by_pixel = sort::sorted_by(all, |f| sort::pair(f.pixel[1], f.pixel[0]));
        let triangle = |f: &Self| f.triangle.map_or(0, |t| t.saturating_add(1));
        sort::sorted_by(&by_pixel, |f| sort::pair(f.slot, triangle(f)))
    }
}

/// Result of a verification. Nothing visible was lost if `false_culls` is empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verification {
    /// |A|: triangles of all instances, degenerate ones included.
    pub all: u64,
    /// |S'|: triangles that the culler left.
    pub potentially_visible: u64,
    /// |S|: triangles that own a pixel, and blended ones that are seen.
    pub visible: u64,
    /// Visible triangles that were lost; ascending by slot and triangle.
    pub false_culls: Vec<FalseCull>,
    /// S, sorted.
    pub seen: Vec<PixelId>,
    /// Counts without culling.
    pub before: FrameStats,
    /// Counts with culling.
    pub after: FrameStats,
    /// The culler's funnel.
    pub funnel: Funnel,
    /// The frame without culling.
    pub frame: Frame,
    /// The frame with culling.
    pub culled_frame: Frame,
    /// The culler's result.
    pub result: Visible,
}

impl Verification {
    /// Builds the verification from the lost triangles, the frames without and with culling, and
    /// the culler's result.
    pub(crate) fn of(
        scene: &Scene,
        false_culls: Vec<FalseCull>,
        [frame, culled_frame]: [Frame; 2],
        result: Visible,
    ) -> Self {
        let seen = frame.visible();
        Self {
            all: scene.triangle_count(),
            potentially_visible: result.triangle_ranges.iter().map(|r| u64::from(r.count)).sum(),
            visible: seen.len() as u64,
            false_culls,
            seen,
            before: frame.stats,
            after: culled_frame.stats,
            funnel: result.funnel.clone(),
            frame,
            culled_frame,
            result,
        }
    }
}

/// Culls, draws with and without culling, and compares; see [`verify_visible`]. The culler returns
/// triangles and reasons, whatever its settings say of those.
#[must_use]
pub fn verify<'a>(
    world: impl Into<InCells<'a>>,
    view: &View,
    culler: &Culler,
    state: &mut ViewState,
    options: &VerifyOptions,
) -> Verification {
    let culler = Culler::clone(culler).with_output(cullet::Output::Triangles).with_reasons(true);
    let mut result = Visible::default();
    let world = world.into();
    world.cull(&culler, view, state, &mut result);
    verify_visible(world.scene, view, result, options)
}

/// Holds a visible set, with its triangles, against the truth.
///
/// Two frames are drawn, of everything and of the set alone, and their owners compared pixel for
/// pixel; so are their blended triangles. Then instances of which the set holds nothing are looked
/// for at N × N jittered samples a pixel. Only tiles that a projected box of such an instance
/// touches are drawn so, with everything in them: elsewhere it owns no sample.
///
/// Cost: two frames; and where much on the screen was dropped, up to N² frames more.
#[must_use]
pub fn verify_visible(
    scene: &Scene,
    view: &View,
    result: Visible,
    options: &VerifyOptions,
) -> Verification {
    in_pool(options.threads, || verify_in_pool(scene, view, result, options))
}

fn verify_in_pool(
    scene: &Scene,
    view: &View,
    result: Visible,
    options: &VerifyOptions,
) -> Verification {
    let stage = Stage::new(scene);
    let draw = RenderOptions { count_layers: options.count_layers, ..RenderOptions::default() };
    let frame = render_stage(&stage, view, Selection::All, &draw);
    let culled_frame = render_stage(&stage, view, Selection::Visible(&result), &draw);

    let lost = first_of_each(&lost_triangles(&frame, &culled_frame), PixelId::key);
    let reason = |slot: u32| result.reasons.get(slot as usize).copied().flatten();
    let mut false_culls: Vec<FalseCull> = lost
        .iter()
        .map(|&(id, pixel)| FalseCull {
            slot: id.slot,
            triangle: Some(id.triangle),
            pixel,
            reason: reason(id.slot),
        })
        .collect();

    let [width, height] = view.viewport();
    let n = options.samples.min(MAX_SIDE / width.max(height));
    if n > 1 {
        let samples = Samples::new([width * n, height * n], Jitter::Hashed(options.seed));
        for (slot, [x, y]) in lost_instances(&stage, view, &result, samples) {
            if lost.binary_search_by_key(&slot, |l| l.0.slot).is_err() {
                let pixel = [x / n, y / n];
                let reason = reason(slot);
                false_culls.push(FalseCull { slot, triangle: None, pixel, reason });
            }
        }
        false_culls = FalseCull::sorted(&false_culls);
    }

    Verification::of(scene, false_culls, [frame, culled_frame], result)
}

/// Owners of pixels and blended triangles of the first frame that the second has not, with a pixel.
pub(crate) fn lost_triangles(frame: &Frame, culled: &Frame) -> Vec<(PixelId, [u32; 2])> {
    let width = frame.width.max(1) as usize;
    let pixel = |at: usize| [(at % width) as u32, (at / width) as u32];
    let pairs = frame.ids.iter().zip(&culled.ids).enumerate();
    let mut lost: Vec<(PixelId, [u32; 2])> = pairs
        .filter(|(_, (all, some))| all != some && **all != PixelId::NONE)
        .map(|(at, (all, _))| (*all, pixel(at)))
        .collect();
    let blended = frame.blended.iter().zip(&frame.blended_at);
    let gone = blended.filter(|(id, _)| culled.blended.binary_search(id).is_err());
    lost.extend(gone.map(|(id, at)| (*id, *at)));
    lost
}

/// Instances that own a sample of this image, or are blended and pass one, though the set holds
/// nothing of them; ascending, with the first such sample.
pub(crate) fn lost_instances(
    stage: &Stage,
    view: &View,
    result: &Visible,
    samples: Samples,
) -> Vec<(u32, [u32; 2])> {
    let lens = Lens::new(view);
    let dropped = dropped(stage, view.layers, result);
    let [wide, high] = tiles_of(&samples);
    let mut wanted = vec![false; (wide * high) as usize];
    let at = |[column, row]: [u32; 2]| (row * wide + column) as usize;
    let items = stage.items(&lens, &samples, Selection::All);
    for item in items.opaque.iter().chain(&items.blended).filter(|i| dropped[i.slot as usize]) {
        tiles_in(&item.screen_bounds.rect).for_each(|tile| wanted[at(tile)] = true);
    }
    if !wanted.contains(&true) {
        return Vec::new();
    }
    let mut found: Vec<(u32, [u32; 2])> = Vec::new();
    let mut row = 0;
    while row < high {
        // Some rows of tiles at a time, to bound the memory.
        let first = row;
        let mut tiles = 0;
        while row < high && (tiles == 0 || tiles < BAND_TILES) {
            tiles += wanted[at([0, row])..at([0, row + 1])].iter().filter(|w| **w).count();
            row += 1;
        }
        let band = |tile: [u32; 2]| (first..row).contains(&tile[1]) && wanted[at(tile)];
        let items = items.within(&|rect| tiles_in(rect).any(band));
        let mut target = Target::new(samples.clone(), band, false);
        target.draw(stage, &lens, Selection::All, &items);
        let seen = target.seen().filter(|(id, _)| dropped[id.slot as usize]);
        found.extend(seen.map(|(id, at)| (id.slot, at)));
        found = first_of_each(&found, u64::from);
    }
    found
}

/// For each slot, whether it is in the view's scene but the set holds nothing of it.
fn dropped(stage: &Stage, layers: u32, result: &Visible) -> Vec<bool> {
    let mut dropped: Vec<bool> =
        (0..stage.scene.slot_count()).map(|slot| stage.is_drawn(slot, layers)).collect();
    for range in result.triangle_ranges.iter().filter(|r| r.count > 0) {
        if let Some(d) = dropped.get_mut(range.slot as usize) {
            *d = false;
        }
    }
    dropped
}

#[cfg(test)]
mod tests {
    use cullet::{Instance, Stage as Kind, Transform, draw::TriangleRange};
    use cullet_testkit::scenes::{city, mixed_scene};
    use cullet_testkit::views::{look, mixed_view};
    use cullet_testkit::{Rng, meshes};
    use proptest::prelude::*;

    use super::*;
    use crate::reference::render_samples;

    /// All triangles of the slots for which `keep` holds.
    fn kept(scene: &Scene, mut keep: impl FnMut(u32) -> bool) -> Visible {
        let mut visible = Visible::default();
        for slot in 0..scene.slot_count() {
            let keep = !scene.is_removed(slot) && keep(slot);
            let reason = Reason { stage: Kind::Frustum, detail: 3 };
            visible.reasons.push((!keep).then_some(reason));
            if keep {
                let count = scene.mesh(slot).triangle_count();
                let first = visible.triangles.len() as u32;
                visible.triangles.extend(0..count);
                visible.triangle_ranges.push(TriangleRange { slot, level: 0, first, count });
            }
        }
        visible
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 120, ..ProptestConfig::default() })]

        #[test]
        fn finds_the_instances_of_the_whole_finer_image(seed in any::<u64>()) {
            let mut rng = Rng(seed);
            let scene = mixed_scene(&mut rng);
            let size = [1 + rng.below(40) as u32, 1 + rng.below(30) as u32];
            let view = mixed_view(&mut rng, size);
            let n = 2 + rng.below(3) as u32;
            let result = kept(&scene, |_| rng.chance(0.5));
            let samples = Samples::new(size.map(|v| v * n), Jitter::Hashed(seed));
            let whole = render_samples(&scene, &view, Selection::All, &samples, false);
            let dropped = dropped(&Stage::new(&scene), view.layers, &result);
            let mut expected: Vec<(u32, [u32; 2])> = Vec::new();
            let pixel = |at: usize| [at as u32 % whole.width, at as u32 / whole.width];
            let owners = whole.ids.iter().enumerate().map(|(at, id)| (id.slot, pixel(at)));
            let blended = whole.blended.iter().zip(&whole.blended_at).map(|(id, at)| (id.slot, *at));
            for (slot, at) in owners.chain(blended) {
                if slot != u32::MAX && dropped[slot as usize] {
                    expected.push((slot, at));
                }
            }
            expected.sort_unstable_by_key(|&(slot, [x, y])| (slot, y, x));
            expected.dedup_by_key(|e| e.0);
            let found = lost_instances(&Stage::new(&scene), &view, &result, samples);
            prop_assert_eq!(found, expected);
        }
    }

    #[test]
    fn nothing_dropped_is_nothing_lost() {
        let scene = city(6, 1, 60);
        let view = look([5.0, 3.0, 90.0], [0.0, 2.0, 0.0], [160, 90]);
        let options = VerifyOptions { count_layers: true, ..VerifyOptions::default() };
        let v = verify_visible(&scene, &view, kept(&scene, |_| true), &options);
        assert!(v.false_culls.is_empty() && v.frame == v.culled_frame);
        assert_eq!(v.potentially_visible, v.all);
        assert_eq!(v.visible as usize, v.frame.visible().len());
        assert!(v.visible > 20 && v.before.max_layers > 1);
    }

    #[test]
    fn every_seen_instance_that_is_dropped_is_found() {
        let scene = city(6, 1, 60);
        let view = look([5.0, 3.0, 90.0], [0.0, 2.0, 0.0], [160, 90]);
        let all = verify_visible(&scene, &view, kept(&scene, |_| true), &VerifyOptions::default());
        let mut slots: Vec<u32> = all.seen.iter().map(|id| id.slot).collect();
        slots.dedup();
        for &gone in slots.iter().step_by(3) {
            let v = verify_visible(
                &scene,
                &view,
                kept(&scene, |slot| slot != gone),
                &VerifyOptions::default(),
            );
            let lost: Vec<&PixelId> = all.seen.iter().filter(|id| id.slot == gone).collect();
            assert_eq!(v.false_culls.len(), lost.len());
            for (f, id) in v.false_culls.iter().zip(lost) {
                assert_eq!((f.slot, f.triangle), (id.slot, Some(id.triangle)));
                assert_eq!(f.reason, Some(Reason { stage: Kind::Frustum, detail: 3 }));
                assert_eq!(v.frame.id(f.pixel[0], f.pixel[1]), *id);
            }
        }
        // An instance that owns no pixel may be dropped.
        let seen = |slot: u32| slots.binary_search(&slot).is_ok();
        let options = VerifyOptions { samples: 1, ..VerifyOptions::default() };
        assert!(verify_visible(&scene, &view, kept(&scene, seen), &options).false_culls.is_empty());
    }

    #[test]
    fn what_falls_between_the_pixels_is_found_by_finer_samples() {
        // A speck a fifth of a pixel wide, where no centre sees it.
        let mut scene = Scene::new();
        let mesh = scene.add_mesh(meshes::block([-1.0; 3], [1.0; 3]));
        let t = Transform::from_scale_translation([0.01; 3], [0.26, 0.26, 0.0]);
        scene.add(Instance::new(mesh, t)).unwrap();
        let view = look([0.0, 0.0, 10.0], [0.0; 3], [100, 100]);
        let verify = |samples| {
            let options = VerifyOptions { samples, ..VerifyOptions::default() };
            verify_visible(&scene, &view, kept(&scene, |_| false), &options)
        };
        assert_eq!(verify(1).visible, 0);
        assert!(verify(1).false_culls.is_empty());
        let found = verify(8).false_culls;
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].slot, found[0].triangle), (0, None));
    }
}
