//! Levels of detail against the truth: what may be lost by them, and what may not.

use cullet::{Culler, Output, Scene, Stage, View, ViewState, Visible};

use cullet_cells::InCells;

use crate::frame::{Frame, PixelId, RenderOptions, Selection};
use crate::picture::space::Surfaces;
use crate::places::Places;
use crate::prepare;
use crate::render::{in_pool, render_stage};
use crate::verify::{FalseCull, Verification, VerifyOptions, lost_triangles, verify};

/// Result of a verification with levels of detail. Nothing visible was lost if neither list of
/// false culls has anything.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LevelsVerification {
    /// All stages but the levels against the picture of everything in full, as [`verify`] does.
    pub full: Verification,
    /// All stages against the picture of everything at its level, and of hidden instances in full:
    /// `frame` is that, `culled_frame` what is left, `visible` and `seen` are of triangles of
    /// levels.
    ///
    /// False culls are what no level excuses: an instance that was dropped as a whole and is seen
    /// in full, one that was dropped as hidden and shows between what is drawn, and triangles of
    /// levels that were dropped for being hidden, outside, facing away or without area. What was
    /// dropped for the cell of the eye and shows where a wall is coarse is no false cull: it is
    /// counted in [`LevelPixels::uncovered`].
    pub levels: Verification,
    /// Triangles of every instance that levels alone draw, without any other stage.
    pub cut: Visible,
    /// How the picture differs from that in full.
    pub pixels: LevelPixels,
}

/// Pixels of the picture that levels and culling leave, against that of everything in full.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LevelPixels {
    /// Pixels of the picture.
    pub all: u64,
    /// Pixels that show another instance, or nothing, or an instance where there was nothing.
    pub differ: u64,
    /// The `differ` pixels where only one of the two pictures shows anything: the silhouette before
    /// the background.
    pub silhouette: u64,
    /// Pixels where levels show something that was dropped as too small, or out of reach of the
    /// eye's cell.
    pub uncovered: u64,
}

impl LevelPixels {
    fn of(full: &Frame, left: &Frame, places: &Places) -> Self {
        let mut pixels = Self { all: full.ids.len() as u64, ..Self::default() };
        let differ =
            |(a, b): &(&PixelId, &PixelId)| a.slot != b.slot && places.of_slot(a.slot) != b.slot;
        for (a, b) in full.ids.iter().zip(&left.ids).filter(differ) {
            pixels.differ += 1;
            pixels.silhouette += u64::from(*a == PixelId::NONE || *b == PixelId::NONE);
        }
        pixels
    }
}

/// Culls with levels of detail and without, draws four frames, and compares; see
/// [`LevelsVerification`]. The culler returns triangles, reasons and drops, whatever its settings
/// say of those. The states are those of the two cullers: without levels, and with.
///
/// How far what is drawn is from the original is another question, which no picture answers.
///
/// Cost: twice that of [`verify`].
#[must_use]
pub fn verify_levels<'a>(
    world: impl Into<InCells<'a>>,
    view: &View,
    culler: &Culler,
    [full_state, state]: [&mut ViewState; 2],
    options: &VerifyOptions,
) -> LevelsVerification {
    let culler =
        culler.clone().with_output(Output::Triangles).with_reasons(true).with_dropped(true);
    let world = world.into();
    let scene = world.scene;
    let full = verify(world, view, &culler.without(Stage::Lod), full_state, options);
    let (mut cut, mut result) = (Visible::default(), Visible::default());
    world.cull(&culler, view, state, &mut result);
    let mut alone = culler.only(Stage::Lod);
    if let Some((lod, pixels)) = alone.lod.as_mut().zip(result.lod_pixels) {
        // A budget counts what the other stages leave: without them it would come to another
        // threshold.
        (lod.pixels, lod.triangles) = (pixels, None);
    }
    if let Some(lod) = &mut alone.lod {
        lod.stand_ins = false;
    }
    alone.cull_one(scene, view, &mut ViewState::default(), &mut cut);
    if let Some(lod) = alone.lod.filter(|_| scene.stand_in_slots().next().is_some()) {
        let places = Places::of(scene, &result);
        // Who stands for whom depends on what other stages leave, so it is as they left it.
        cut = places.put_in(scene, view, &lod.with_stand_ins(true), &cut, &result);
    }
    in_pool(options.threads, || compare(scene, view, full, cut, result, options))
}

fn compare(
    scene: &Scene,
    view: &View,
    full: Verification,
    cut: Visible,
    result: Visible,
    options: &VerifyOptions,
) -> LevelsVerification {
    let stage = prepare::Stage::new(scene);
    let draw = RenderOptions { count_layers: options.count_layers, ..RenderOptions::default() };
    let before = with_hidden_in_full(scene, &cut, &result);
    let frame = render_stage(&stage, view, Selection::Visible(&before), &draw);
    let culled_frame = render_stage(&stage, view, Selection::Visible(&result), &draw);
    let places = Places::of(scene, &result);
    let mut pixels = LevelPixels::of(&full.frame, &culled_frame, &places);
    let mut false_culls = dropped_though_seen(&full, &result, &places);
    let surfaces = Surfaces::of_visible(scene, &before);
    for (id, pixel) in lost_triangles(&frame, &culled_frame) {
        let taken_by = surfaces.triangle(id).and_then(|t| result.stage_of(id.slot, t));
        match taken_by {
            Some(Stage::Pvs | Stage::Portal | Stage::Detail) => pixels.uncovered += 1,
            _ => {
                let reason = result.reasons.get(id.slot as usize).copied().flatten();
                let triangle = Some(id.triangle);
                false_culls.push(FalseCull { slot: id.slot, triangle, pixel, reason });
            }
        }
    }
    let mut false_culls = FalseCull::sorted(&false_culls);
    false_culls.dedup_by_key(|f| (f.slot, f.triangle));
    let levels = Verification::of(scene, false_culls, [frame, culled_frame], result);
    LevelsVerification { full, levels, cut, pixels }
}

/// Returns `cut` with the whole mesh of each instance that was dropped as hidden at once: its box
/// was, and a level may reach out of that by its error.
fn with_hidden_in_full(scene: &Scene, cut: &Visible, result: &Visible) -> Visible {
    let mut out = cut.clone();
    out.triangles.clear();
    for range in &mut out.triangle_ranges {
        let from = range.first as usize;
        let own = &cut.triangles[from..from + range.count as usize];
        range.first = out.triangles.len() as u32;
        let reason = result.reasons.get(range.slot as usize).copied().flatten();
        let is_hidden = reason.is_some_and(|r| r.stage == Stage::Occlusion);
        if is_hidden && range.level != 0 && !result.went_in_parts(range.slot) {
            range.level = 0;
            out.triangles.extend(0..scene.mesh(range.slot).triangle_count());
        } else {
            out.triangles.extend(own);
        }
        range.count = out.triangles.len() as u32 - range.first;
    }
    out
}

/// Instances that were dropped at once beside the levels and not without them, though they are seen
/// in full.
fn dropped_though_seen(full: &Verification, result: &Visible, places: &Places) -> Vec<FalseCull> {
    let mut false_culls = Vec::new();
    for own in full.seen.chunk_by(|a, b| a.slot == b.slot) {
        let slot = own[0].slot;
        let reason = result.reasons.get(slot as usize).copied().flatten();
        if reason.is_none()
            || reason.is_some_and(|r| r.stage == Stage::Lod) && places.of_slot(slot) != slot
            || result.went_in_parts(slot)
            || full.false_culls.iter().any(|f| f.slot == slot)
        {
            continue;
        }
        let width = full.frame.width.max(1) as usize;
        let at = full.frame.ids.iter().position(|id| id.slot == slot);
        let blended = full.frame.blended.iter().position(|id| id.slot == slot);
        let pixel = match (at, blended) {
            (Some(at), _) => [(at % width) as u32, (at / width) as u32],
            (None, Some(at)) => full.frame.blended_at[at],
            (None, None) => continue,
        };
        false_culls.push(FalseCull { slot, triangle: None, pixel, reason });
    }
    false_culls
}

#[cfg(test)]
mod tests {
    use cullet::lod::Lod;
    use cullet::{Instance, Reason, Transform};
    use cullet_testkit::steps::{Balls, ball_before_beads};
    use cullet_testkit::views::look;

    use super::*;

    fn balls() -> Scene {
        let mut scene = Scene::new();
        let mesh = Balls::new(&[64, 32, 16, 8], 1.0).add_to(&mut scene);
        for k in 0..40 {
            let place = [f64::from(k % 5) * 1.6 - 3.2, 0.0, -5.0 * f64::from(k / 5)];
            scene.add(Instance::new(mesh, Transform::from_translation(place))).unwrap();
        }
        scene.commit(&Culler::default());
        scene.prepare(&culler(1.0));
        scene
    }

    fn culler(pixels: f64) -> Culler {
        Culler::exact().with_lod(Lod::default().with_pixels(pixels))
    }

    fn verified(scene: &Scene, pixels: f64) -> LevelsVerification {
        let view = look([0.5, 0.8, 9.0], [0.0, 0.0, 0.0], [320, 200]);
        let states = [&mut ViewState::default(), &mut ViewState::default()];
        verify_levels(scene, &view, &culler(pixels), states, &VerifyOptions::default())
    }

    #[test]
    fn levels_that_are_near_enough_lose_little_and_coarse_ones_more() {
        let scene = balls();
        let [fine, coarse] = [0.5, 4.0].map(|pixels| verified(&scene, pixels));
        for v in [&fine, &coarse] {
            assert!(v.full.false_culls.is_empty() && v.levels.false_culls.is_empty());
            assert_eq!(v.full.all, v.levels.all);
            assert!(v.levels.potentially_visible < v.full.potentially_visible);
            assert!(v.levels.potentially_visible < v.cut.triangle_count);
            assert!(v.pixels.silhouette <= v.pixels.differ && v.pixels.differ < v.pixels.all);
            // Each pixel of levels shows a triangle that is drawn.
            assert_eq!(v.levels.frame.ids, v.levels.culled_frame.ids);
            assert_eq!(v.pixels.uncovered, 0);
        }
        assert!(
            fine.pixels.differ * 2 < coarse.pixels.differ,
            "{:?} {:?}",
            fine.pixels,
            coarse.pixels
        );
        assert!(coarse.levels.potentially_visible < fine.levels.potentially_visible);
    }

    #[test]
    fn who_stands_for_others_is_drawn_in_their_place_and_loses_nothing() {
        let mut scene = Scene::new();
        let mesh = Balls::new(&[32, 16, 8], 1.0).add_to(&mut scene);
        let place = |k: i32| [f64::from(k % 6) * 2.4 - 6.0, 0.0, -4.0 * f64::from(k / 6)];
        let balls: Vec<_> = (0..24)
            .map(|k| scene.add(Instance::new(mesh, Transform::from_translation(place(k)))).unwrap())
            .collect();
        // A wall hides some of a group, so that what is drawn of it depends on more than levels.
        let wall =
            scene.add_mesh(cullet_testkit::meshes::block([-2.0, -2.0, 0.0], [2.0, 2.0, 0.1]));
        scene.add(Instance::new(wall, Transform::from_translation([-3.0, 0.0, 3.0]))).unwrap();
        // A ball around all of a row, said to be nearer to it than it is: only who is drawn matters
        // here.
        let row = Balls::new(&[16, 9, 4], 0.2).add_to(&mut scene);
        for (k, row_of) in balls.chunks(6).enumerate() {
            let at =
                Transform::from_scale_translation([7.5, 1.0, 1.0], [0.0, 0.0, -4.0 * k as f64]);
            let own = scene.add(Instance::new(row, at)).unwrap();
            scene.stand_for(own, row_of).unwrap();
        }
        scene.commit(&Culler::default());
        scene.prepare(&culler(1.0));
        let mut drawn = [0; 2];
        for pixels in [0.3, 3.0, 12.0] {
            let v = verified(&scene, pixels);
            assert!(
                v.full.false_culls.is_empty() && v.levels.false_culls.is_empty(),
                "{pixels}: {:?}",
                v.levels.false_culls
            );
            let stands = v.levels.result.slots().filter(|&s| scene.is_stand_in(s)).count();
            drawn[usize::from(pixels > 1.0)] += stands;
            assert!(v.levels.potentially_visible <= v.cut.triangle_count);
            // An instance and who stands for it are the same to see, where both are.
            assert!(v.pixels.differ < v.pixels.all / 5, "{:?}", v.pixels);
            assert_eq!(v.levels.frame.ids, v.levels.culled_frame.ids);
        }
        assert!(drawn[0] == 0 && drawn[1] > 2, "{drawn:?}");
    }

    #[test]
    fn what_shows_beside_a_coarse_occluder_is_a_false_cull() {
        let mut scene = ball_before_beads();
        scene.prepare(&culler(1.0));
        let view = look([0.0, 0.0, 6.0], [0.0; 3], [640, 400]);
        let options = VerifyOptions::default();
        let states = [&mut ViewState::default(), &mut ViewState::default()];
        let mut v = verify_levels(&scene, &view, &culler(1e3), states, &options);
        assert!(v.full.false_culls.is_empty() && v.levels.false_culls.is_empty());
        assert_eq!(v.levels.frame.ids, v.levels.culled_frame.ids);
        // As if the round ball hid them, that is not drawn.
        let mut result = v.levels.result.clone();
        result.triangle_ranges.retain(|r| r.slot == 0);
        result.reasons[1..].fill(Some(Reason { stage: Stage::Occlusion, detail: 0 }));
        v = compare(&scene, &view, v.full, v.cut, result, &options);
        assert!(v.levels.false_culls.len() > 9, "{}", v.levels.false_culls.len());
        assert!(v.pixels.differ > 0 && v.pixels.uncovered == 0);
    }

    #[test]
    fn what_levels_do_not_excuse_is_a_false_cull() {
        let scene = balls();
        let v = verified(&scene, 1.0);
        let shown = v.full.seen[0].slot;
        // An instance that is gone, and a triangle of one that faces away, or so it says.
        let mut gone = v.levels.result.clone();
        gone.dropped.clear();
        gone.reasons[shown as usize] = Some(Reason { stage: Stage::Occlusion, detail: 0 });
        let told = dropped_though_seen(&v.full, &gone, &Places::of(&scene, &gone));
        assert_eq!(told.len(), 1);
        assert_eq!((told[0].slot, told[0].triangle), (shown, None));
        let left = v.levels.culled_frame.visible();
        let id = *left.iter().find(|id| id.slot != shown).unwrap();
        let surfaces = Surfaces::of_visible(&scene, &v.cut);
        let t = surfaces.triangle(id).unwrap();
        let mut result = v.levels.result.clone();
        let range = *result.triangle_ranges.iter().find(|r| r.slot == id.slot).unwrap();
        let own = &mut result.triangles[range.first as usize..][..range.count as usize];
        let other = *own.iter().find(|o| **o != t).unwrap();
        *own.iter_mut().find(|o| **o == t).unwrap() = other;
        let options = VerifyOptions::default();
        let view = look([0.5, 0.8, 9.0], [0.0, 0.0, 0.0], [320, 200]);
        let found = compare(&scene, &view, v.full.clone(), v.cut.clone(), result, &options);
        assert!(found.levels.false_culls.iter().any(|f| {
            (f.slot, f.triangle) == (id.slot, Some(id.triangle)) && f.reason.is_none()
        }));
    }
}
