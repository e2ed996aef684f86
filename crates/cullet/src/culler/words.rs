//! Words: the steps of an explanation as English sentences.

#[cfg(feature = "candidates")]
use alloc::format;
#[cfg(feature = "candidates")]
use alloc::string::{String, ToString};
#[cfg(feature = "candidates")]
use alloc::vec::Vec;
use core::fmt::{Display, Formatter, Result};

#[cfg(feature = "candidates")]
use super::evidence::{CellTest, Sight};
use super::evidence::{CoverTest, Evidence, PlaneTest};
use super::explain::Step;
use crate::digits::Digits::{self, Fixed};
#[cfg(feature = "candidates")]
use crate::funnel::{Stage, Unit};
use crate::view::FrustumPlane;

/// Writes what the stage found in one sentence, without the stage's name.
impl Display for Step {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let Self { unit, entered, left, ref evidence, .. } = *self;
        let dropped = entered.saturating_sub(left);
        match evidence {
            #[cfg(feature = "candidates")]
            Evidence::None if self.stage == Stage::Pvs && unit == Unit::Instances => {
                write!(f, "{} of the candidates", if left == 0 { "none" } else { "one" })
            }
            Evidence::None => write!(f, "{dropped} of {entered} {} dropped", unit.name()),
            Evidence::Exempt => write!(f, "exempt: always visible, or without finite bounds"),
            Evidence::NearPlane => write!(f, "crosses the near plane, or has no bounds: kept"),
            Evidence::OffScreen => write!(f, "beyond an edge of the screen"),
            Evidence::Cost => write!(f, "left out: it would cost more than it could save"),
            #[cfg(feature = "lossy")]
            Evidence::NoLevels => {
                write!(f, "has no levels of detail, or is not rigid")
            }
            #[cfg(feature = "candidates")]
            Evidence::NoPortals => write!(f, "the cells have no portals, only sets"),
            #[cfg(feature = "candidates")]
            Evidence::NoSets => write!(f, "the cells have no sets"),
            #[cfg(feature = "candidates")]
            Evidence::Orthographic => write!(f, "left out: an orthographic view has no eye"),
            #[cfg(feature = "candidates")]
            Evidence::NoCell => write!(f, "left out: the eye is in no cell"),
            #[cfg(feature = "candidates")]
            Evidence::InWall => write!(f, "left out: the near plane reaches into a wall"),
            Evidence::Layers { instance, view } => {
                write!(f, "layers {instance:#x} of the instance, {view:#x} of the view")
            }
            Evidence::Planes(tests) => planes(f, tests, left == 0),
            #[cfg(feature = "shadows")]
            Evidence::Caster { reason: Some(reason), .. } => {
                write!(f, "its shadow cannot matter: {}", reason.name())
            }
            #[cfg(feature = "shadows")]
            Evidence::Caster { planes, .. } => {
                write!(f, "reaches {} units into the casters' region", Fixed(depth(planes), 6))
            }
            #[cfg(feature = "candidates")]
            Evidence::Cells(test) => cells(f, test),
            #[cfg(feature = "lossy")]
            Evidence::Size { pixels: [w, h], weight } => {
                let (w, h, weight) = (Fixed(*w, 2), Fixed(*h, 2), Digits::Plain32(*weight));
                write!(f, "at most {w} x {h} pixels on the screen, counted {weight} times")
            }
            Evidence::Area { rank, with_area, triangles } => write!(
                f,
                "rank {rank} of the transform, {with_area} of {triangles} triangles with area in the mesh"
            ),
            Evidence::Cover(CoverTest { buffer: [w, h], min, max, nearness, covered, open }) => {
                let ([x0, y0], [x1, y1]) = (min, max);
                let [nearness, covered] = [*nearness, *covered].map(Digits::Exponent32);
                write!(f, "pixels {x0}..={x1} x {y0}..={y1} of {w} x {h}, nearness {nearness}")?;
                match open {
                    Some([x, y]) => write!(f, ": pixel ({x}, {y}) lets it through"),
                    None => write!(f, ", covered at {covered}: all covered by what is nearer"),
                }
            }
            #[cfg(feature = "lossy")]
            Evidence::Levels { drawn, triangles, pixels } => {
                let pixels = Digits::Plain(*pixels);
                write!(f, "{drawn} of {triangles} triangles within {pixels} pixels of the original")
            }
            #[cfg(feature = "lossy")]
            Evidence::Replaced { by, count } => {
                write!(f, "slot {by} is drawn in its place, which stands for {count} instances")
            }
            #[cfg(feature = "lossy")]
            Evidence::StandIn { count, is_off: false } => write!(f, "stands for {count} instances"),
            #[cfg(feature = "lossy")]
            Evidence::StandIn { count, .. } => {
                write!(f, "stands for {count} instances, never drawn: one of them has changed")
            }
            // Found by stages that are not compiled.
            #[cfg(not(all(feature = "candidates", feature = "lossy", feature = "shadows")))]
            _ => Ok(()),
        }
    }
}

fn planes(f: &mut Formatter<'_>, tests: &[PlaneTest], is_dropped: bool) -> Result {
    let depth = depth(tests);
    let test = tests.iter().find(|test| -test.nearest == depth);
    let plane = test.and_then(|test| FrustumPlane::ALL.get(usize::from(test.plane)));
    let plane = plane.map_or("an extra", |plane| plane.name());
    match (is_dropped, depth < 0.0) {
        (true, false) => write!(f, "outside: no plane alone rejects it, the exact test does"),
        (true, true) => write!(f, "outside the {plane} plane by {} units", Fixed(-depth, 6)),
        _ => {
            write!(f, "reaches {} units inside of the {plane} plane, its nearest", Fixed(depth, 6))
        }
    }
}

/// Returns how far a box reaches inside of the plane that it is nearest to.
fn depth(tests: &[PlaneTest]) -> f64 {
    tests.iter().fold(f64::INFINITY, |depth, test| depth.min(-test.nearest))
}

#[cfg(feature = "candidates")]
fn cells(f: &mut Formatter<'_>, test: &CellTest) -> Result {
    let CellTest { instance, eye, portals, in_sight, sight } = test;
    if !instance.is_empty() {
        write!(f, "in {}, ", list("cell", instance))?;
    }
    let (from, by) = (list("cell", eye), list("portal", portals));
    match (sight, in_sight) {
        (Sight::Everywhere, _) => write!(f, "seen from everywhere: beyond the cells, or moved"),
        (Sight::Sets, true) => write!(f, "in the set of {from}"),
        (Sight::Sets, false) => write!(f, "not in the set of {from}"),
        (Sight::Portals, true) => write!(f, "seen from {from} through {by}"),
        (Sight::Portals, false) => write!(f, "beside what is seen from {from} through {by}"),
        (Sight::Limited, _) => write!(f, "behind the limits of chains of portals from {from}"),
        (Sight::Shut(portal), _) => {
            write!(f, "not seen from {from}: portal {portal} on the way is shut")
        }
        (Sight::Open, _) => {
            write!(f, "not seen from {from}: the way leads by {by}, and no line of sight does")
        }
        (Sight::NoWay, _) => write!(f, "not seen from {from}: no portals lead there"),
    }
}

#[cfg(feature = "candidates")]
fn list(noun: &str, numbers: &[u32]) -> String {
    let all: Vec<String> = numbers.iter().map(u32::to_string).collect();
    match all.len() {
        0 => format!("no {noun}"),
        1 => format!("{noun} {}", all[0]),
        _ => format!("{noun}s {}", all.join(", ")),
    }
}
