//! Paths within a model: `walk` and `fly`.

use cullet::Camera;
use glam::{DVec2, DVec3};

use super::free::{gather, heights, is_free, sight};
use super::{Lens, PathError};
use crate::{Rng, sin_cos};
use cullet_io::Model;

/// Height of the eye above the ground, in metres, where the model may be in metres.
const EYE: f64 = 1.7;
/// Heights that a flight tries where its way is blocked.
const RUNGS: usize = 12;
/// How far to a side it tries at each of them, in heights of the eye.
const ASIDE: [f64; 5] = [0.0, 0.6, -0.6, 1.2, -1.2];
/// Directions looked at from each place of a walk.
const DIRECTIONS: usize = 16;

/// How high above the ground the eye is: as the model says; else a person's, if the model is of a
/// size for people; else a tenth of the model's larger horizontal side, but at most half its
/// height.
fn eye_height(model: &Model, low: DVec3, high: DVec3) -> f64 {
    if let Some(height) = model.eye_height.filter(|h| h.is_finite() && *h > 0.0) {
        return height;
    }
    let size = high - low;
    let across = size.x.max(size.z);
    if size.y >= EYE && (4.0..=1e6).contains(&across) {
        return EYE;
    }
    let h = (across * 0.1).min(size.y * 0.5);
    if h > 0.0 { h } else { (size.length() * 0.1).max(f64::MIN_POSITIVE) }
}

/// A place for the eye, and the height of the ground under it.
#[derive(Clone, Copy)]
struct Place {
    eye: DVec3,
    ground: f64,
}

/// Points spread evenly over the unit square, however many are taken (Roberts, *The Unreasonable
/// Effectiveness of Quasirandom Sequences*, 2018).
fn spread_points(seed: u64) -> impl Iterator<Item = DVec2> {
    let mut rng = Rng::new(seed, 11);
    let start = DVec2::new(rng.unit(), rng.unit());
    let step = DVec2::new(0.754_877_666_246_692_8, 0.569_840_290_998_053_2);
    (1u32..).map(move |i| (start + step * f64::from(i)).fract())
}

/// Places at eye height over the ground where the eye is free: the lowest such of each of many
/// points.
fn places(model: &Model, lens: &Lens, count: usize) -> Result<Vec<Place>, PathError> {
    let scene = &model.scene;
    let origin = DVec3::from(scene.origin());
    let [low, high] = lens.extent()?;
    let eye = eye_height(model, low, high);
    // The edge of a model is mostly bare; of a small one, only the edge may be free.
    let (middle, half) = ((low + high) * 0.5, (high - low) * 0.5);
    let mut free: Vec<Place> = Vec::new();
    for (round, reach) in [0.7, 1.0, 1.4].into_iter().enumerate() {
        let wanted = (count * 4).clamp(64, 4096);
        let points: Vec<DVec2> = spread_points(lens.overrides.seed.wrapping_add(round as u64))
            .take(wanted)
            .map(|p| {
                DVec2::new(middle.x, middle.z)
                    + (p * 2.0 - 1.0) * DVec2::new(half.x, half.z) * reach
            })
            .collect();
        let columns: Vec<[DVec3; 2]> = points
            .iter()
            .map(|p| {
                let at = |y: f64| DVec3::new(p.x, y, p.y) - origin;
                [at(low.y - half.y - 1.0), at(high.y + half.y + 1.0)]
            })
            .collect();
        let mut stands: Vec<(usize, Place)> = Vec::new();
        for (i, (p, slots)) in points.iter().zip(gather(scene, &columns)).enumerate() {
            let mut hits = heights(scene, &slots, p.x, p.y);
            if hits.is_empty() {
                hits.push(low.y);
            }
            // Ground is whatever has room above it for an eye, and a little more.
            let ceilings = hits.iter().skip(1).copied().chain([f64::INFINITY]);
            let grounds = hits.iter().zip(ceilings).filter(|(g, c)| *c - **g >= eye * 1.25);
            stands.extend(grounds.take(4).map(|(&ground, _)| {
                (i, Place { eye: DVec3::new(p.x, ground + eye, p.y), ground })
            }));
        }
        let clearance = eye * 0.25;
        let eyes: Vec<DVec3> = stands.iter().map(|(_, s)| s.eye).collect();
        let near = gather(scene, &boxes_around(&eyes, DVec3::splat(clearance), origin));
        let mut taken = None;
        for ((i, place), slots) in stands.iter().zip(&near) {
            if taken != Some(*i) && is_free(scene, slots, place.eye, clearance) {
                taken = Some(*i);
                free.push(*place);
            }
        }
        if free.len() >= count * 2 {
            break;
        }
    }
    // On the ground rather than on roofs: not above the middle place, if there are enough below.
    let mut levels: Vec<f64> = free.iter().map(|p| p.ground).collect();
    levels.sort_by(f64::total_cmp);
    let ground = levels.get(levels.len() / 2).map_or(f64::INFINITY, |g| g + eye * 0.5);
    // Where the rooms of a model are known, a walk is through them first.
    let indoors = |p: &Place| model.cells.cells.iter().any(|cell| cell.contains(p.eye.into()));
    free.sort_by_key(|p| (!indoors(p), p.ground > ground));
    free.truncate(count);
    Ok(free)
}

/// Places of a walk in an order that goes from each to the nearest that is left.
fn tour(mut left: Vec<Place>) -> Vec<Place> {
    let mut tour: Vec<Place> = Vec::with_capacity(left.len());
    while !left.is_empty() {
        let nearest = tour.last().and_then(|at| {
            let far = |p: &Place| p.eye.distance_squared(at.eye);
            (0..left.len()).min_by(|a, b| far(&left[*a]).total_cmp(&far(&left[*b])))
        });
        tour.push(left.swap_remove(nearest.unwrap_or(0)));
    }
    tour
}

/// At eye height from place to place, looking where one sees far, on the way to the next place if
/// that is as good.
pub(super) fn walk(model: &Model, lens: &Lens, count: usize) -> Result<Vec<Camera>, PathError> {
    let scene = &model.scene;
    let origin = DVec3::from(scene.origin());
    let [low, high] = lens.extent()?;
    let eye = eye_height(model, low, high);
    // A nearest-neighbour tour of very many places would take too long for its use.
    let places = tour(places(model, lens, count.min(4096))?);
    if places.is_empty() {
        return around(lens, count, low.y + eye);
    }
    let far = eye * 20.0;
    let eyes: Vec<DVec3> = places.iter().map(|p| p.eye).collect();
    let near = gather(scene, &boxes_around(&eyes, DVec3::new(far, eye, far), origin));
    let mut cameras = Vec::with_capacity(count);
    // Directions by merit, for each place; a place that must serve again takes its next best.
    let ranked: Vec<Vec<DVec3>> = places
        .iter()
        .enumerate()
        .map(|(i, p)| {
            let onward = (places[(i + 1) % places.len()].eye - p.eye).normalize_or_zero();
            let mut rated: Vec<(f64, DVec3)> = (0..DIRECTIONS)
                .map(|d| {
                    let (s, c) = sin_cos(d as f64 / DIRECTIONS as f64);
                    let along = DVec3::new(s, 0.0, c);
                    let open = sight(scene, &near[i], p.eye, along, far);
                    (open * (1.0 + 0.3 * along.dot(onward)), along)
                })
                .collect();
            rated.sort_by(|a, b| b.0.total_cmp(&a.0));
            rated.into_iter().map(|r| r.1).collect()
        })
        .collect();
    for i in 0..count {
        let (lap, at) = (i / places.len(), i % places.len());
        let along = ranked[at][(lap * 3) % DIRECTIONS];
        cameras.push(lens.look_along(places[at].eye, along));
    }
    Ok(cameras)
}

/// In a circle outside of the whole extent, where nothing can be in the way.
fn around(lens: &Lens, count: usize, y: f64) -> Result<Vec<Camera>, PathError> {
    let [low, high] = lens.extent()?;
    let middle = ((low + high) * 0.5).with_y(y);
    let radius = (high - low).length().max(f64::MIN_POSITIVE);
    Ok((0..count)
        .map(|i| {
            let (s, c) = sin_cos(i as f64 / count as f64);
            lens.look_at(middle + DVec3::new(s, 0.0, c) * radius, middle)
        })
        .collect())
}

/// Along the longer side of the model: in from above its near end, swinging to and fro, down to a
/// third of its height over the middle, and up again before the far end.
pub(super) fn fly(model: &Model, lens: &Lens, count: usize) -> Result<Vec<Camera>, PathError> {
    let scene = &model.scene;
    let origin = DVec3::from(scene.origin());
    let [low, high] = lens.extent()?;
    let eye = eye_height(model, low, high);
    let (middle, half) = ((low + high) * 0.5, (high - low) * 0.5);
    let (along, across) =
        if half.x >= half.z { (DVec3::X, DVec3::Z) } else { (DVec3::Z, DVec3::X) };
    let (long, wide, tall) = (half.dot(along), half.dot(across), half.y * 2.0);
    let mut rng = Rng::new(lens.overrides.seed, 12);
    let (phase, side) = (rng.unit(), if rng.chance(0.5) { 1.0 } else { -1.0 });
    let at = |t: f64| {
        // From 1.25 half-lengths before the middle to 0.75 behind it: the end still has something
        // ahead.
        let u = -1.25 + 2.0 * t;
        let swing = 0.35 * sin_cos(phase + 1.2 * t).0;
        let dip = u.abs().min(1.0);
        let height = tall * (0.33 + 1.1 * dip * dip);
        middle.with_y(low.y + height.max(eye)) + along * (side * u * long) + across * (swing * wide)
    };
    let clearance = eye * 0.25;
    let steps: Vec<f64> = (0..count).map(|i| i as f64 / count as f64).collect();
    // Where the way is blocked the eye goes a little to a side, or up, in steps, to above
    // everything.
    let over = high.y + eye.max(tall * 0.05) + clearance;
    let tries: Vec<DVec3> = steps
        .iter()
        .flat_map(|t| {
            let p = at(*t);
            let rise = over.max(p.y) - p.y;
            (0..RUNGS * ASIDE.len()).map(move |i| {
                let (rung, aside) = ((i / ASIDE.len()) as f64, ASIDE[i % ASIDE.len()]);
                p + DVec3::Y * (rise * rung / (RUNGS - 1) as f64) + across * (aside * eye)
            })
        })
        .collect();
    let near = gather(scene, &boxes_around(&tries, DVec3::splat(clearance), origin));
    let mut eyes = Vec::with_capacity(count);
    for i in 0..count {
        let mut own = i * RUNGS * ASIDE.len()..(i + 1) * RUNGS * ASIDE.len();
        // The last is above all that has bounds.
        let last = own.end - 1;
        let free = own.find(|r| is_free(scene, &near[*r], tries[*r], clearance));
        eyes.push(tries[free.unwrap_or(last)]);
    }
    // Ahead; or somewhat to a side, where a wall is just ahead and that shows more.
    let (blocked, far) = (eye * 4.0, eye * 20.0);
    let near = gather(scene, &boxes_around(&eyes, DVec3::splat(far), origin));
    let camera = |(i, t): (usize, &f64)| {
        let eye = eyes[i];
        let ahead = at(t + 0.15);
        let target = ahead.with_y((low.y + tall * 0.25).min(ahead.y));
        // Down by twenty degrees at the most: steeper shows ground alone.
        let to = target - eye;
        let level = to.with_y(0.0).length();
        let forward = to.with_y(to.y.clamp(-0.36 * level, 0.1 * level)).normalize_or(along);
        let open = |direction: DVec3| sight(scene, &near[i], eye, direction, far);
        let ahead = open(forward);
        let aside = [0.08, -0.08, 0.16, -0.16].map(|turn: f64| {
            let (s, c) = sin_cos(turn);
            let [x, y, z] = forward.to_array();
            DVec3::new(c * x + s * z, y, c * z - s * x)
        });
        let best = aside
            .into_iter()
            .map(|d| (open(d), d))
            .filter(|(open, _)| ahead < blocked && *open > ahead * 1.5)
            .reduce(|a, b| if b.0 > a.0 { b } else { a });
        lens.look_along(eye, best.map_or(forward, |b| b.1))
    };
    Ok(steps.iter().enumerate().map(camera).collect())
}

/// Boxes about points, relative to the scene's origin.
fn boxes_around(points: &[DVec3], half: DVec3, origin: DVec3) -> Vec<[DVec3; 2]> {
    points.iter().map(|p| [*p - half - origin, *p + half - origin]).collect()
}
