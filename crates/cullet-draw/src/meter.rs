//! How far what is drawn is from the original, in pixels: found by points and distances, without
//! the errors that levels state.

use crate::ImpostorJudge;
use crate::surface::{SHARE_ABOVE, SurfaceTree, surface_points};
use crate::{parallel, sort};
use cullet::lod::{Lod, PixelScale};
use cullet::{Mesh, Scene, View, Visible, draw::TriangleRange};
use cullet_mesh::Impostor;
use glam::{DMat3, DMat4, DVec3};

/// Measurements in a view.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured {
    /// The farthest that any point is off.
    pub max_px: f64,
    /// Bound that 99.9 % of the random points stay within, of the original and of what is drawn:
    /// the larger of both.
    pub p999_px: f64,
    /// The slot that is off the most.
    pub worst: Option<u32>,
    /// Points that were measured.
    pub points: u64,
    /// Instances that were measured, and those that are drawn at a level.
    pub instances: [u64; 2],
}

/// The most that any point may be off, in thresholds: between the points that a bake measured there
/// are others.
pub const MOST_EXCESS: f64 = 1.2;

impl Measured {
    /// Whether a threshold is kept: by 99.9 % of the points, and by all of them to [`MOST_EXCESS`]
    /// of it. NaN is not kept.
    #[must_use]
    pub fn keeps(&self, pixels: f64) -> bool {
        let rounding = 1.0 + 1e-6;
        self.p999_px <= pixels * rounding && self.max_px <= pixels * MOST_EXCESS * rounding
    }
}

/// Measures one view after another.
#[derive(Clone, Copy, Debug)]
pub struct Meter {
    /// Random points of a view, each way, shared out among its instances.
    pub points: usize,
    /// For the places of those points.
    pub seed: u64,
}

/// An instance has at least so many random points, each way.
const LEAST_POINTS: usize = 500;
/// And at most so many.
const MOST_POINTS: usize = 100_000;

impl Meter {
    /// Measures the instances of which `drawn` has something at a level, by all the triangles that
    /// `cut` chose for them: what other stages dropped of an instance leaves no hole that counts.
    ///
    /// Both ways: from random points and vertices of the original to the nearest triangle that was
    /// chosen, and from those back. Distances are in the world, and a pixel is as large as where
    /// the point is: an angle, at the image's centre, or with [`Lod::at_corners`] the smaller one
    /// of where the point is in the image.
    #[must_use]
    pub fn measure(
        &self,
        scene: &Scene,
        view: &View,
        lod: &Lod,
        cut: &Visible,
        drawn: &Visible,
    ) -> Measured {
        let shown = drawn.triangle_ranges.iter().filter(|r| r.level > 0 && r.count > 0);
        let slots: Vec<u32> = shown.map(|r| r.slot).collect();
        // With so many that not all can have enough points, some, evenly.
        let most = (self.points / LEAST_POINTS).max(1);
        let step = slots.len().div_ceil(most).max(1);
        let some: Vec<u32> =
            slots.iter().copied().skip(self.seed as usize % step).step_by(step).collect();
        let each = (self.points / some.len().max(1)).clamp(LEAST_POINTS, MOST_POINTS);
        let pixels = Pixels::new(view, lod.at_corners);
        let of_slot = |i: usize| {
            let slot = some[i];
            let at = cut.triangle_ranges.binary_search_by_key(&slot, |r| r.slot).ok()?;
            let chosen = cut.triangle_ranges[at];
            let triangles =
                cut.triangles.get(chosen.first as usize..)?.get(..chosen.count as usize)?;
            let task = Task { scene, pixels: &pixels, lod, each, seed: self.seed };
            Some((slot, task.run(&chosen, triangles)))
        };
        let found: Vec<(u32, [Distances; 2])> =
            parallel::map(some.len(), &of_slot).into_iter().flatten().collect();
        let mut measured = Measured {
            instances: [found.len(), slots.len()].map(|n| n as u64),
            ..Measured::default()
        };
        for way in 0..2 {
            let mut all: Vec<f32> =
                found.iter().flat_map(|f| f.1[way].random.iter().copied()).collect();
            measured.p999_px = measured.p999_px.max(quantile(&mut all));
        }
        for (slot, ways) in &found {
            for way in ways {
                measured.points += way.random.len() as u64 + way.vertices;
                // What is no number is the worst of all.
                if way.max > measured.max_px || way.max.is_nan() {
                    (measured.max_px, measured.worst) = (way.max, Some(*slot));
                }
            }
        }
        measured
    }
}

/// Returns the value that all but one in a thousand stay within.
fn quantile(all: &mut [f32]) -> f64 {
    let over = (all.len() as f64 * SHARE_ABOVE) as usize;
    if over < all.len() { sort::largest_but(over, all).into() } else { 0.0 }
}

/// Distances one way, in pixels.
#[derive(Clone, Debug, Default)]
struct Distances {
    random: Vec<f32>,
    vertices: u64,
    /// Largest distance, including those of the vertices.
    max: f64,
}

/// How many pixels a length has where it is.
struct Pixels {
    scale: PixelScale,
    /// Towards the viewer, where lines of sight are parallel.
    back: DVec3,
    /// The direction of the image's centre, and how much smaller than there a pixel is at most, if
    /// that counts.
    ahead: Option<(DVec3, f64)>,
}

impl Pixels {
    fn new(view: &View, at_corners: bool) -> Self {
        let scale = PixelScale::of(view, false);
        let corner = PixelScale::of(view, true).pixels / scale.pixels;
        let m = view.clip_from_world();
        let ahead = DVec3::new(m[3], m[7], m[11]).normalize_or_zero();
        let back = DVec3::from_slice(&view.eye());
        Self { scale, back, ahead: at_corners.then_some((ahead, corner)) }
    }

    /// Returns the size in pixels of a length of 1 at a point this far from the eye.
    fn of(&self, from_eye: Option<DVec3>) -> f64 {
        let Some(to) = from_eye else { return self.scale.pixels };
        let distance = to.length().max(self.scale.near);
        let smaller = self.ahead.map_or(1.0, |(ahead, most)| {
            let cosine = to.normalize_or_zero().dot(ahead);
            // Beyond the image, and behind the eye, as in its corner.
            if cosine > 0.0 { (1.0 / (cosine * cosine)).min(most) } else { most }
        });
        self.scale.pixels * smaller / distance
    }
}

/// One instance.
struct Task<'a> {
    scene: &'a Scene,
    pixels: &'a Pixels,
    lod: &'a Lod,
    each: usize,
    seed: u64,
}

/// A surface in directions and lengths of the world, around the instance's place: f32 is fine
/// there.
struct Surface {
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
}

impl Surface {
    /// All of a mesh but its triangles without area, which have no surface.
    fn whole(mesh: &Mesh, turn: &DMat3, place: DVec3) -> Self {
        Self::new(mesh, 0..mesh.triangle_count() - mesh.degenerate_count(), turn, place)
    }

    fn new(mesh: &Mesh, triangles: impl Iterator<Item = u32>, turn: &DMat3, around: DVec3) -> Self {
        let place =
            |p: [f32; 3]| (*turn * DVec3::from(p.map(f64::from)) + around).as_vec3().to_array();
        let positions: Vec<[f32; 3]> = triangles.flat_map(|t| mesh.corners(t)).map(place).collect();
        let indices = (0..positions.len() as u32).collect();
        Self { positions, indices }
    }
}

impl Task<'_> {
    /// From the original to what was chosen, and back.
    fn run(&self, chosen: &TriangleRange, triangles: &[u32]) -> [Distances; 2] {
        let slot = chosen.slot;
        let transform = self.scene.transform(slot);
        let [x, y, z] = transform.linear.map(|c| DVec3::from(c.map(f64::from)));
        let turn = DMat3::from_cols(x, y, z);
        if let Some(impostor) = Impostor::at(self.scene, slot, chosen.level) {
            return self.of_impostor(slot, self.scene.mesh(slot), impostor);
        }
        let original = match self.scene.is_stand_in(slot) {
            true => self.stood_for_by(slot),
            false => Surface::whole(self.scene.mesh(slot), &turn, DVec3::ZERO),
        };
        let mesh = self.scene.mesh_at(slot, chosen.level);
        let coarse = Surface::new(mesh, triangles.iter().copied(), &turn, DVec3::ZERO);
        let eye =
            self.pixels.scale.eye.map(|e| DVec3::from(e) - DVec3::from(transform.translation));
        [self.one_way(&original, &coarse, eye), self.one_way(&coarse, &original, eye)]
    }

    /// All instances that one stands for, around its place.
    fn stood_for_by(&self, stand_in: u32) -> Surface {
        let around = DVec3::from(self.scene.transform(stand_in).translation);
        let mut all = Surface { positions: Vec::new(), indices: Vec::new() };
        for slot in self.scene.stood_for_by(stand_in) {
            let transform = self.scene.transform(slot);
            let [x, y, z] = transform.linear.map(|c| DVec3::from(c.map(f64::from)));
            let turn = DMat3::from_cols(x, y, z);
            let place = DVec3::from(transform.translation) - around;
            all.positions.extend(Surface::whole(self.scene.mesh(slot), &turn, place).positions);
        }
        all.indices.extend(0..all.positions.len() as u32);
        all
    }

    /// Compares pictures of the mesh and its impostor from where the eye is: an impostor is only
    /// what it looks like, and has no surface elsewhere.
    fn of_impostor(&self, slot: u32, mesh: &Mesh, impostor: &Impostor) -> [Distances; 2] {
        let transform = self.scene.transform(slot);
        let to_world = DMat4::from_cols_array(&transform.to_matrix());
        let group = impostor.group();
        let centre = to_world.transform_point3(DVec3::from(group.centre.map(f64::from)));
        let [x, y, z] = transform.linear.map(|c| DVec3::from(c.map(f64::from)).length());
        let stretch = x.max(y).max(z);
        let (there, towards) = match self.pixels.scale.eye {
            Some(eye) => (Some(centre - DVec3::from(eye)), DVec3::from(eye) - centre),
            None => (None, self.pixels.back),
        };
        let own = to_world.inverse().transform_vector3(towards);
        let judged =
            ImpostorJudge::new(mesh, impostor.clone()).and_then(|j| j.distances(own.to_array()));
        let pixels = self.pixels.of(there) * stretch;
        let random: Vec<f32> = match judged {
            Ok(all) => all.into_iter().map(|d| (f64::from(d) * pixels) as f32).collect(),
            // What cannot be looked at is as wrong as can be.
            Err(_) => vec![f32::INFINITY],
        };
        let max = random.iter().copied().fold(0.0, f32::max).into();
        [Distances { random, vertices: 0, max }, Distances::default()]
    }

    fn one_way(&self, from: &Surface, to: &Surface, eye: Option<DVec3>) -> Distances {
        let tree = SurfaceTree::new(&to.positions, &to.indices);
        let off = |point: [f32; 3]| -> f64 {
            let there = eye.map(|eye| DVec3::from(point.map(f64::from)) - eye);
            let pixels = self.pixels.of(there);
            // Most are near, and a short search finds those.
            let near = (2.0 * self.lod.pixels / pixels) as f32;
            let found = tree.nearest(point, near).or_else(|| tree.nearest(point, f32::INFINITY));
            found.map_or(f64::INFINITY, |(distance, _)| f64::from(distance) * pixels)
        };
        let points = surface_points(&from.positions, &from.indices, self.each, self.seed);
        let random: Vec<f32> = points.iter().map(|p| off(p.point) as f32).collect();
        let mut max = random.iter().copied().fold(0.0, f32::max).into();
        let step = from.positions.len().div_ceil(self.each).max(1);
        let vertices = from.positions.iter().step_by(step);
        let count = vertices.len() as u64;
        for d in vertices.map(|&p| off(p)) {
            max = f64::max(max, d);
        }
        Distances { random, vertices: count, max }
    }
}

#[cfg(test)]
mod tests {
    use cullet::{Culler, Instance, Output, Stage, Transform};
    use cullet_testkit::answers::cull;
    use cullet_testkit::steps::Balls;
    use cullet_testkit::views::look;

    use super::*;

    fn measured(honesty: f64, lod: Lod, view: &View) -> Measured {
        let mut scene = Scene::new();
        let mesh = Balls::new(&[96, 48, 24, 12, 6, 4], honesty).add_to(&mut scene);
        for (k, scale) in
            [[1.0; 3], [2.0, 0.5, 1.0], [-1.0, 1.0, 1.0], [0.1; 3]].into_iter().enumerate()
        {
            let place = [k as f64 * 3.0 - 4.5, 0.0, 1e5 - 6.0 * k as f64];
            let scale = scale.map(|v: f64| v as f32);
            scene
                .add(Instance::new(mesh, Transform::from_scale_translation(scale, place)))
                .unwrap();
        }
        scene.commit(&Culler::default());
        let culler = Culler::exact().with_lod(lod).with_output(Output::Triangles);
        let cut = cull(&culler.only(Stage::Lod), &scene, view);
        Meter { points: 20_000, seed: 7 }.measure(
            &scene,
            view,
            &lod,
            &cut,
            &cull(&culler, &scene, view),
        )
    }

    #[test]
    fn who_stands_for_others_is_measured_against_all_of_them() {
        let mut scene = Scene::new();
        let ball = scene.add_mesh(Balls::new(&[24, 4], 1.0).mesh);
        let places = [[1.0, 0.5, 0.0], [0.0, 0.5, 1.0], [-1.0, 0.5, -1.0]];
        let balls = places.map(|at| {
            let at = Transform::from_scale_translation([0.3; 3], [at[0], at[1], at[2] + 1e5]);
            scene.add(Instance::new(ball, at)).unwrap()
        });
        // Nothing like them, but never off by more than all of it is large.
        let like = Balls::new(&[9, 6, 4], 1.0).add_to(&mut scene);
        let at = Transform::from_scale_translation([1.5; 3], [0.0, 0.5, 1e5]);
        let own = scene.add(Instance::new(like, at)).unwrap();
        scene.stand_for(own, &balls).unwrap();
        scene.commit(&Culler::default());
        let own = scene.slot(own).unwrap();
        let view = look([0.0, 0.5, 1e5 + 100.0], [0.0, 0.5, 1e5], [640, 400]);
        let lod = Lod::default().with_pixels(20.0);
        let culler = Culler::exact().with_lod(lod).with_output(Output::Triangles);
        let cut = cull(&culler.only(Stage::Lod), &scene, &view);
        assert_eq!(cut.slots().collect::<Vec<_>>(), [own]);
        let meter = Meter { points: 20_000, seed: 7 };
        let found = meter.measure(&scene, &view, &lod, &cut, &cut);
        assert_eq!((found.instances, found.worst), ([1, 1], Some(own)));
        // From the shell to the nearest ball, and no farther than to one beyond the middle.
        let pixel = 100.0 / PixelScale::of(&view, false).pixels;
        assert!((0.4..2.5).contains(&(found.max_px * pixel)), "{found:?}");
    }

    #[test]
    fn honest_levels_keep_their_threshold_and_others_are_found_out() {
        let view = look([0.0, 1.0, 1e5 + 6.0], [0.0, 0.0, 1e5], [640, 400]);
        for pixels in [0.3, 1.0, 3.0] {
            let lod = Lod::default().with_pixels(pixels);
            let kept = measured(1.0, lod, &view);
            assert_eq!(kept.instances[0], kept.instances[1]);
            assert!(kept.max_px <= pixels * (1.0 + 1e-4), "{pixels}: {kept:?}");
            assert!(kept.p999_px <= kept.max_px && kept.points > 20_000, "{kept:?}");
            // They are not drawn much finer than is needed either: a level has a quarter of the
            // triangles of the one before.
            assert!(kept.max_px > pixels * 0.2, "{pixels}: {kept:?}");
            let broken = measured(0.2, lod, &view);
            assert!(broken.max_px > pixels * 1.2 && broken.worst.is_some(), "{pixels}: {broken:?}");
        }
    }

    #[test]
    fn in_the_corners_a_pixel_is_smaller() {
        // The balls are far off the centre.
        let view = look([0.0, 0.0, 1e5 + 6.0], [9.0, 0.0, 1e5 - 2.0], [640, 400]);
        let lod = |at_corners| Lod::default().with_pixels(1.0).with_at_corners(at_corners);
        let [centre, corners] = [false, true].map(|c| measured(1.0, lod(c), &view));
        assert!(centre.max_px <= 1.0 + 1e-4 && corners.max_px <= 1.0 + 1e-4);
        let pixels = Pixels::new(&view, true);
        let [ahead, aside, behind] = [[9.0, 0.0, -8.0], [9.0, 0.0, -1.0], [-9.0, 0.0, 8.0]]
            .map(|to| pixels.of(Some(DVec3::from(to) / DVec3::from(to).length() * 10.0)));
        let plain = Pixels::new(&view, false).of(Some(DVec3::X * 10.0));
        assert!((ahead / plain - 1.0).abs() < 1e-9 && aside > plain * 1.2 && behind >= aside);
    }

    #[test]
    fn one_in_a_thousand_may_be_farther() {
        let mut all: Vec<f32> = (0..10_000).rev().map(|i| i as f32).collect();
        assert_eq!(quantile(&mut all), 9989.0);
        assert_eq!((quantile(&mut [3.0]), quantile(&mut [])), (3.0, 0.0));
    }
}
