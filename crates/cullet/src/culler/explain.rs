//! Why one instance is drawn or not, with the numbers of every stage that it came to.

use super::run::{Pass, Scratch};
use super::{CullError, Culler};
use crate::bounds::{Aabb, Plane};
use crate::funnel::{FunnelRow, Reason, Stage, Unit};
use crate::hierarchy::Handle;
use crate::scene::Scene;
use crate::view::{FrustumPlane, View};
use crate::visible::Visible;

/// What one stage found.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Step {
    /// The stage.
    pub stage: Stage,
    /// What it looked at.
    pub unit: Unit,
    /// How many of the instance's instances (one), clusters or triangles came in.
    pub entered: u64,
    /// How many went on.
    pub left: u64,
    /// What it measured, in words with numbers.
    pub finding: String,
}

/// Why an instance is drawn or not: every stage it came to, with its numbers.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Explanation {
    /// Why it was dropped; `None` if something of it is drawn.
    pub reason: Option<Reason>,
    /// The stages, in order.
    pub steps: Vec<Step>,
    /// Where it is hidden, the slots of the instances that hide it, the nearest first.
    pub hidden_by: Vec<u32>,
}

impl Culler {
    /// Replays the stages for one instance alone and says what each of them found. The reason is the
    /// one that [`cull_one`](Self::cull_one) writes.
    ///
    /// # Errors
    /// If the handle names no instance.
    pub fn explain(
        &self,
        scene: &Scene,
        view: &View,
        handle: Handle,
    ) -> Result<Explanation, CullError> {
        let slot = scene.slot(handle)?;
        let asked = Self { reasons: true, clock: None, ..self.clone() };
        let mut result = Visible::default();
        let mut scratch = Scratch::default();
        Pass::new(&asked, scene, view, &mut scratch, &mut result).only(slot).run();
        let reason = result.reasons[slot as usize];
        let steps = result
            .funnel
            .rows
            .iter()
            .filter(|row| row.entered.of(row.unit) > 0)
            .map(|row| Step {
                stage: row.stage,
                unit: row.unit,
                entered: row.entered.of(row.unit),
                left: row.left.of(row.unit),
                finding: if (row.stage, row.unit) == (Stage::Occlusion, Unit::Instances) {
                    scratch.occlusion.finding(self, scene, slot)
                } else {
                    self.finding(scene, view, slot, row, reason)
                },
            })
            .collect();
        let hidden = reason.is_some_and(|r| r.stage == Stage::Occlusion);
        let hidden_by =
            if hidden { scratch.occlusion.blockers(self, scene, view, slot) } else { Vec::new() };
        Ok(Explanation { reason, steps, hidden_by })
    }

    fn finding(
        &self,
        scene: &Scene,
        view: &View,
        slot: u32,
        row: &FunnelRow,
        reason: Option<Reason>,
    ) -> String {
        if row.unit != Unit::Instances {
            let (unit, all) = (row.unit.name(), row.entered.of(row.unit));
            return format!("{} of {all} {unit} dropped", row.dropped().of(row.unit));
        }
        let exempt = scene.exempt()[slot as usize / 64] >> (slot % 64) & 1 == 1;
        match row.stage {
            Stage::Layer => {
                let (own, seen) = (scene.layers(slot), view.layers);
                format!("layers {own:#x} of the instance, {seen:#x} of the view")
            }
            _ if exempt => "exempt: flagged always visible, or without finite bounds".to_owned(),
            Stage::Frustum => {
                let frustum = view.frustum().relative_to(scene.origin());
                let bounds = scene.bounds(slot);
                let rejecting =
                    reason.filter(|r| r.stage == Stage::Frustum && row.left.instances == 0);
                let named = rejecting.and_then(|r| {
                    frustum.planes().find(|(number, _)| *number == usize::from(r.detail))
                });
                match named {
                    Some((number, plane)) => format!(
                        "outside the {} plane by {:.6} units at the nearest corner",
                        plane_name(number),
                        -depth_inside(plane, &bounds)
                    ),
                    None if rejecting.is_some() => {
                        "outside: no plane alone rejects it, the exact test does".to_owned()
                    }
                    None => frustum
                        .planes()
                        .map(|(number, plane)| (depth_inside(plane, &bounds), number))
                        .min_by(|a, b| a.0.total_cmp(&b.0))
                        .map_or_else(String::new, |(depth, number)| {
                            let plane = plane_name(number);
                            format!(
                                "reaches {depth:.6} units inside of the {plane} plane, its nearest"
                            )
                        }),
                }
            }
            Stage::Detail => match view.project_box(&scene.bounds(slot), scene.origin()) {
                Some(r) => format!("{:.2} x {:.2} pixels on the screen", r.width(), r.height()),
                None => "crosses the near plane, so it is never small".to_owned(),
            },
            Stage::Degenerate => format!(
                "rank {} of the transform, {} of {} triangles with area in the mesh",
                scene.transform(slot).rank(),
                scene.mesh(slot).triangle_count() - scene.mesh(slot).degenerate_count(),
                scene.mesh(slot).triangle_count()
            ),
            _ => String::new(),
        }
    }
}

fn plane_name(number: usize) -> String {
    FrustumPlane::ALL.get(number).map_or_else(|| format!("extra {number}"), |p| p.name().to_owned())
}

/// How far the box reaches to the inner side of a plane; negative when it is outside.
fn depth_inside(plane: &Plane, b: &Aabb) -> f64 {
    let inner =
        std::array::from_fn(|a| f64::from(if plane.normal[a] > 0.0 { b.min[a] } else { b.max[a] }));
    -plane.distance(inner)
}
