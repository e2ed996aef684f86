//! Advice: what the tallies say could be done. Every sentence is made of figures of this run; a
//! finding that is not there gives no sentence.

mod context;
mod occlusion;

use cullet_command::console::{agree, count, grouped, percent};

use crate::names::name_of;
use crate::record::{Advice, MeshRecord, Summary};
use crate::survey::Survey;
use context::{Context, NAMES_KEPT, shown};

/// All advice, that on the most triangles first.
pub(crate) fn advise(
    survey: &Survey,
    summary: &Summary,
    meshes: &[MeshRecord],
    pixels: u64,
    tiny_px: f64,
    drawn_ns: Option<f64>,
) -> Vec<Advice> {
    let views = survey.views.len();
    if views == 0 {
        return Vec::new();
    }
    let ctx = Context { survey, model: &survey.model, summary, meshes, views, tiny_px };
    let mut advice: Vec<Advice> = [
        ctx.does_not_pay(pixels),
        ctx.hidden(),
        occlusion::does_not_pay(&ctx, drawn_ns),
        occlusion::poor_occluders(&ctx),
        ctx.unseen_meshes(),
        ctx.lost_backfaces(),
        ctx.solid_but_two_sided(),
        ctx.wound_both_ways(),
        ctx.tiny(),
        ctx.straddlers(),
        ctx.degenerate(),
        ctx.duplicate_triangles(),
        ctx.duplicate_instances(),
        ctx.mirrored(),
        ctx.not_finite(),
        ctx.flat(),
    ]
    .into_iter()
    .flatten()
    .collect();
    advice.sort_by(|a, b| b.triangles_per_view.total_cmp(&a.triangles_per_view));
    advice
}

impl Context<'_> {
    fn does_not_pay(&self, pixels: u64) -> Option<Advice> {
        let t = self.summary.triangles;
        let visible = t.visible.filter(|_| !self.summary.verified_views.is_empty())?;
        let verified = self.summary.verified_views.len() as u64;
        let all = t.all / self.views as u64 * verified;
        // Where four in five are visible, no culler can save more than the fifth.
        let nearly_all = visible * 5 >= all * 4;
        // A triangle for each hundred pixels costs less to draw than to think about.
        let few = all * 100 < pixels * verified;
        if !(nearly_all || few) || all == 0 {
            return None;
        }
        let per_view = |n: u64| grouped(n / verified);
        let (title, text) = if nearly_all {
            (
                "Culling does not pay on these views".to_owned(),
                format!(
                    "{} of {} ({}) {} a pixel: even a perfect culler would save only {}. \
                     Spend the time on cheaper triangles or fewer pixels instead.",
                    per_view(visible),
                    count(all / verified, "triangle", "triangles"),
                    percent(visible, all),
                    agree(visible / verified, "owns", "own"),
                    percent(all - visible, all)
                ),
            )
        } else {
            (
                "The scene is small against its pixels".to_owned(),
                format!(
                    "{} {} pixels: {:.0} pixels for each triangle. Drawing is \
                     bound by pixels here, not by triangles; culling whole instances is enough.",
                    count(all / verified, "triangle per view fills", "triangles per view fill"),
                    grouped(pixels),
                    pixels as f64 * verified as f64 / all as f64
                ),
            )
        };
        Some(self.advice("does-not-pay", title, text, 0, Vec::new()))
    }

    fn hidden(&self) -> Option<Advice> {
        let (mut drawn, mut visible) = (0, 0);
        for v in self.survey.views.iter().filter(|v| v.verified) {
            drawn += v.triangles.potentially_visible;
            visible += v.triangles.visible.unwrap_or(0);
        }
        let hidden = drawn.saturating_sub(visible);
        if hidden * 4 < drawn || drawn == 0 {
            return None;
        }
        let unseen = self.summary.instances;
        let (kept, seen) = (unseen.potentially_visible, unseen.visible.unwrap_or(0));
        // Occluded triangles are culled already where that stage ran.
        let hides = self.summary.stages.iter().any(|s| s.stage == cullet::Stage::Occlusion);
        let text = format!(
            "{} of the {} still drawn per view {} no pixel: they lie behind others, between \
             pixel centres, or at the frustum's edge. {} of {} drawn {} not seen at all{}.",
            grouped(hidden / self.views as u64),
            count(drawn / self.views as u64, "triangle", "triangles"),
            agree(hidden / self.views as u64, "owns", "own"),
            grouped(kept.saturating_sub(seen) / self.views as u64),
            count(kept / self.views as u64, "instance", "instances"),
            agree(kept.saturating_sub(seen) / self.views as u64, "is", "are"),
            if hides {
                ": too small for any pixel, or not proved to be hidden"
            } else {
                "; occlusion culling is what would take them"
            },
        );
        let title =
            format!("{} of what is drawn after culling is still unseen", percent(hidden, drawn));
        Some(self.advice("hidden", title, text, hidden, Vec::new()))
    }

    fn unseen_meshes(&self) -> Option<Advice> {
        if self.summary.verified_views.len() != self.views {
            return None;
        }
        let all = self
            .worst(|m| (m.views_seen == 0 && m.instances > 0).then(|| m.triangles * m.instances))?;
        let (meshes, _, names) = all;
        let drawn: u64 = meshes.iter().map(|m| m.drawn).sum();
        let instances: u64 = meshes.iter().map(|m| m.instances).sum();
        let text = format!(
            "{} no pixel in any of the {} ({}): {}. Even so {} drawn per view. If \
             the views are typical, {} can go, or be loaded later.",
            count(meshes.len() as u64, "mesh owns", "meshes own"),
            count(self.views as u64, "view", "views"),
            count(instances, "instance", "instances"),
            shown(&names),
            count(
                drawn / self.views as u64,
                agree(meshes.len() as u64, "of its triangles is", "of their triangles is"),
                agree(meshes.len() as u64, "of its triangles are", "of their triangles are"),
            ),
            agree(meshes.len() as u64, "it", "they"),
        );
        let title = format!("{} never seen", count(meshes.len() as u64, "mesh is", "meshes are"));
        Some(self.advice("unseen-mesh", title, text, drawn, names))
    }

    fn lost_backfaces(&self) -> Option<Advice> {
        let (meshes, sum, names) =
            self.worst(|m| (m.defect.is_some() && m.facing_away > 0).then_some(m.facing_away))?;
        let first = meshes[0];
        let text = format!(
            "{} drawn all the same: their mesh is not a solid, so both its \
             sides may be seen. The most: “{}”, {}, {} per view. Closed and wound outward, \
             back-face culling would take them; if their backs are never seen, --one-sided says so.",
            count(
                sum / self.views as u64,
                "triangle per view faces away and is",
                "triangles per view face away and are"
            ),
            first.name,
            first.defect.as_deref().unwrap_or_default(),
            grouped(first.facing_away / self.views as u64),
        );
        let title = format!(
            "{} back-face culling by a defect",
            count(meshes.len() as u64, "mesh loses", "meshes lose")
        );
        Some(self.advice("open-mesh", title, text, sum, names))
    }

    fn solid_but_two_sided(&self) -> Option<Advice> {
        let (meshes, sum, names) =
            self.worst(|m| (m.solid && m.facing_away > 0).then_some(m.facing_away))?;
        let text = format!(
            "{} declared two-sided though solid, where no back can ever be seen: {}. One-sided, {} would \
             draw {} fewer per view.",
            count(meshes.len() as u64, "mesh is", "meshes are"),
            shown(&names),
            agree(meshes.len() as u64, "it", "they"),
            count(sum / self.views as u64, "triangle", "triangles"),
        );
        let title = format!(
            "{} two-sided for nothing",
            count(meshes.len() as u64, "solid is", "solids are")
        );
        Some(self.advice("two-sided-solid", title, text, sum, names))
    }

    fn wound_both_ways(&self) -> Option<Advice> {
        let one_sided = |m: &MeshRecord| m.sides != "two-sided" && m.misoriented > 0;
        let (meshes, edges, names) =
            self.worst(|m| one_sided(m).then_some(u64::from(m.misoriented)))?;
        let text = format!(
            "{} one-sided, yet wound both ways along {}: {}. Any viewer that culls back \
             faces loses some of {}. Repair the winding, or declare {} two-sided.",
            count(meshes.len() as u64, "mesh is", "meshes are"),
            count(edges, "edge", "edges"),
            shown(&names),
            agree(meshes.len() as u64, "its faces", "their faces"),
            agree(meshes.len() as u64, "it", "them"),
        );
        let drawn = meshes.iter().map(|m| m.drawn).sum();
        let title = format!(
            "{} in every viewer",
            count(meshes.len() as u64, "mesh loses faces", "meshes lose faces")
        );
        Some(self.advice("wound-both-ways", title, text, drawn, names))
    }

    fn tiny(&self) -> Option<Advice> {
        let scene = &self.model.scene;
        let px = self.tiny_px;
        let (mut instances, mut triangles, mut seen) = (Vec::new(), 0u64, 0usize);
        for slot in scene.slots() {
            let t = self.survey.slots[slot as usize];
            if t.kept > 0 && f64::from(t.largest_px) < px {
                triangles += u64::from(t.drawn);
                seen += usize::from(t.seen > 0);
                instances.push(slot);
            }
        }
        if instances.is_empty() {
            return None;
        }
        let text = format!(
            "{} never wider or higher than {px} pixels, with {} per view; of these instances {} \
             a pixel. --detail {px} drops such instances. That is lossy: try it and look.",
            count(instances.len() as u64, "instance drawn is", "instances drawn are"),
            count(triangles / self.views as u64, "triangle", "triangles"),
            count(seen as u64, "ever owns", "ever own"),
        );
        let title = format!(
            "{} under {px} pixels",
            count(instances.len() as u64, "instance is always", "instances are always")
        );
        let names = instances.iter().take(NAMES_KEPT).map(|&s| name_of(self.model, s)).collect();
        Some(self.advice("tiny", title, text, triangles, names))
    }

    fn straddlers(&self) -> Option<Advice> {
        let scene = &self.model.scene;
        // Fewer triangles than a few clusters hold are cheaper to draw than to split.
        const LEAST_TRIANGLES: u32 = 500;
        let mut found: Vec<(u64, f32, u32)> = scene
            .slots()
            .filter_map(|slot| {
                let t = self.survey.slots[slot as usize];
                let often = t.kept >= 2 && t.straddled * 5 >= t.kept * 4;
                let n = scene.mesh(slot).triangle_count();
                let share = t.outside / t.straddled.max(1) as f32;
                (often && n >= LEAST_TRIANGLES && share >= 0.25)
                    .then(|| ((f64::from(n) * f64::from(t.outside)) as u64, share, slot))
            })
            .collect();
        found.sort_by_key(|&(n, _, slot)| (std::cmp::Reverse(n), slot));
        let &(_, share, slot) = found.first()?;
        let t = self.survey.slots[slot as usize];
        let sum: u64 = found.iter().map(|f| f.0).sum();
        let text = format!(
            "{} the frustum's edge in at least four of five views that draw it. “{}” ({}) does \
             in {} of {}, with {:.0} % of its clusters outside on average. Split into smaller instances, \
             some {} per view would go by whole instances instead of by clusters.",
            count(found.len() as u64, "large instance straddles", "large instances straddle"),
            name_of(self.model, slot),
            count(u64::from(scene.mesh(slot).triangle_count()), "triangle", "triangles"),
            t.straddled,
            t.kept,
            share * 100.0,
            count(sum / self.views as u64, "triangle", "triangles"),
        );
        let title = format!(
            "{} from splitting",
            count(found.len() as u64, "instance would gain", "instances would gain")
        );
        let names = found.iter().take(NAMES_KEPT).map(|f| name_of(self.model, f.2)).collect();
        Some(self.advice("straddles", title, text, sum, names))
    }

    fn degenerate(&self) -> Option<Advice> {
        let (meshes, sum, names) =
            self.worst(|m| (m.degenerate > 0).then_some(m.degenerate * m.instances.max(1)))?;
        let text = format!(
            "{} no area (corners that repeat, or all on one line), in {}: {}. They are never \
             visible; an exporter that drops them makes the file smaller.",
            count(sum, "triangle has", "triangles have"),
            count(meshes.len() as u64, "mesh", "meshes"),
            shown(&names),
        );
        let title = count(sum, "degenerate triangle", "degenerate triangles");
        Some(self.advice("degenerate", title, text, sum * self.views as u64, names))
    }

    fn duplicate_triangles(&self) -> Option<Advice> {
        let (meshes, sum, names) =
            self.worst(|m| (m.duplicate > 0).then_some(m.duplicate * m.instances.max(1)))?;
        let text = format!(
            "{} the same three corners as another of the same mesh, in {}: {}. Such a place is drawn \
             twice, and flickers where the materials differ.",
            count(sum, "triangle has", "triangles have"),
            count(meshes.len() as u64, "mesh", "meshes"),
            shown(&names),
        );
        let title = format!(
            "{} of another",
            count(sum, "triangle is a duplicate", "triangles are duplicates")
        );
        Some(self.advice("duplicate", title, text, sum * self.views as u64, names))
    }

    fn duplicate_instances(&self) -> Option<Advice> {
        let scene = &self.model.scene;
        let twins = cullet_draw::twins(scene);
        if twins.is_empty() {
            return None;
        }
        let triangles: u64 = twins.iter().map(|&s| u64::from(scene.mesh(s).triangle_count())).sum();
        let names: Vec<String> =
            twins.iter().take(NAMES_KEPT).map(|&s| name_of(self.model, s)).collect();
        let text = format!(
            "{} in the same place as another one of the same mesh: {}. That adds {} that \
             can never be told apart from {}.",
            count(twins.len() as u64, "instance is", "instances are"),
            shown(&names),
            count(triangles, "triangle", "triangles"),
            agree(triangles, "its twin", "their twins"),
        );
        let title = format!(
            "{} of another",
            count(twins.len() as u64, "instance is a duplicate", "instances are duplicates")
        );
        Some(self.advice("duplicate-instance", title, text, triangles * self.views as u64, names))
    }

    /// Instances whose transform meets a condition.
    fn transforms(
        &self,
        is_counted: impl Fn(&cullet::Transform) -> bool,
    ) -> Option<(usize, u64, Vec<String>)> {
        let scene = &self.model.scene;
        let slots: Vec<u32> = scene.slots().filter(|&s| is_counted(scene.transform(s))).collect();
        let triangles = slots.iter().map(|&s| u64::from(scene.mesh(s).triangle_count())).sum();
        let names = slots.iter().take(NAMES_KEPT).map(|&s| name_of(self.model, s)).collect();
        (!slots.is_empty()).then_some((slots.len(), triangles, names))
    }

    fn mirrored(&self) -> Option<Advice> {
        let (n, _, names) = self.transforms(|t| t.is_finite() && t.determinant() < 0.0)?;
        let text = format!(
            "{} by a negative scale: {}. The winding of their triangles turns round; cullet \
             allows for it, but a renderer that does not shows them inside out.",
            count(n as u64, "instance is mirrored", "instances are mirrored"),
            shown(&names),
        );
        let title = format!("{} mirrored", count(n as u64, "transform is", "transforms are"));
        Some(self.advice("mirrored", title, text, 0, names))
    }

    fn not_finite(&self) -> Option<Advice> {
        let (n, triangles, names) = self.transforms(|t| !t.is_finite())?;
        let text = format!(
            "{} a NaN or infinite number in the transform: {}. Nothing can be said of where {}, so \
             every view keeps {}.",
            count(n as u64, "instance has", "instances have"),
            shown(&names),
            agree(n as u64, "it is", "they are"),
            count(triangles, "triangle", "triangles"),
        );
        let title = format!("{} not finite", count(n as u64, "transform is", "transforms are"));
        Some(self.advice("not-finite", title, text, triangles * self.views as u64, names))
    }

    fn flat(&self) -> Option<Advice> {
        let (n, triangles, names) = self.transforms(|t| t.is_finite() && t.determinant() == 0.0)?;
        let text = format!(
            "{} scaled to nothing along some axis: {}. What is left of {} has no volume.",
            count(n as u64, "instance is", "instances are"),
            shown(&names),
            count(triangles, "triangle", "triangles"),
        );
        let title = format!("{} singular", count(n as u64, "transform is", "transforms are"));
        Some(self.advice("singular", title, text, 0, names))
    }
}
