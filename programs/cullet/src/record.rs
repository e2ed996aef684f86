//! Records in `report.json` and `verify --json`: plain data, serialised as it stands.

use std::collections::BTreeMap;

use cullet::{
    Handle, Stage,
    funnel::{FrustumWork, FunnelRow, Unit},
};
use cullet_draw::{BackfaceCounts, BoundsCounts};
use serde::{Deserialize, Serialize};

use crate::levels::{LevelsRecord, LevelsSummary};

/// The number of the format; raised only when a key changes its meaning or goes.
pub const SCHEMA: u32 = 1;

#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct SceneRecord {
    pub(crate) name: String,
    pub(crate) meshes: u64,
    pub(crate) instances: u64,
    /// Triangles of all instances, degenerate ones included.
    pub(crate) triangles: u64,
    /// Triangles stored, each mesh once.
    pub(crate) unique_triangles: u64,
    pub(crate) polygons: u64,
    /// Meshes that are solids.
    pub(crate) solids: u64,
    pub(crate) materials: u64,
    pub(crate) cameras: u64,
    pub(crate) extent: Option<[[f64; 3]; 2]>,
    pub(crate) warnings: Vec<String>,
}

/// Counts of triangles. `visible` is null for a view that was not verified.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub(crate) struct Counts {
    pub(crate) all: u64,
    pub(crate) potentially_visible: u64,
    pub(crate) visible: Option<u64>,
}

/// One stage and unit.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub(crate) struct StageRecord {
    #[serde(rename = "name")]
    pub(crate) stage: Stage,
    pub(crate) unit: Unit,
    #[serde(rename = "in")]
    pub(crate) entered: u64,
    #[serde(rename = "out")]
    pub(crate) left: u64,
    /// In and out, whatever the unit of the stage.
    pub(crate) instances: [u64; 2],
    pub(crate) clusters: [u64; 2],
    pub(crate) triangles: [u64; 2],
    pub(crate) ms: Option<f64>,
}

impl StageRecord {
    pub(crate) fn new(row: &FunnelRow) -> Self {
        let (a, b) = (row.entered, row.left);
        Self {
            stage: row.stage,
            unit: row.unit,
            entered: a.of(row.unit),
            left: b.of(row.unit),
            instances: [a.instances, b.instances],
            clusters: [a.clusters, b.clusters],
            triangles: [a.triangles, b.triangles],
            ms: row.time().map(|ns| ns as f64 * 1e-6),
        }
    }

    fn add(&mut self, other: &Self) {
        let add = |a: &mut [u64; 2], b: [u64; 2]| *a = [a[0] + b[0], a[1] + b[1]];
        self.entered += other.entered;
        self.left += other.left;
        add(&mut self.instances, other.instances);
        add(&mut self.clusters, other.clusters);
        add(&mut self.triangles, other.triangles);
        self.ms = self.ms.zip(other.ms).map(|(a, b)| a + b);
    }

    /// How many triangles it took.
    pub(crate) fn taken(&self) -> u64 {
        self.triangles[0].saturating_sub(self.triangles[1])
    }
}

/// How many triangles each stage took, in the order of the stages; none that took nothing.
pub(crate) type Removed = BTreeMap<Stage, u64>;

/// How often pixels were covered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub(crate) struct DepthRecord {
    pub(crate) fragments: u64,
    pub(crate) covered_pixels: u64,
    /// Mean over the pixels that are covered at all.
    pub(crate) mean_layers: f64,
    pub(crate) max_layers: u32,
    /// Triangles submitted over pixels of the view.
    pub(crate) primitives_per_pixel: f64,
}

/// Boxes against spheres as bounds of instances, in one view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub(crate) struct BoundsRecord {
    pub(crate) tested: u64,
    pub(crate) boxes_kept: u64,
    pub(crate) spheres_kept: u64,
    /// Instances with a triangle that the frustum's triangle test keeps: what a perfect bound
    /// keeps.
    pub(crate) in_frustum: u64,
    pub(crate) box_ns: f64,
    pub(crate) sphere_ns: f64,
}

/// Back faces of one-sided parts, counted over the clusters that the frustum left.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub(crate) struct BackfaceRecord {
    /// How many views were counted.
    pub(crate) views: u64,
    /// Instances with backs that can be culled.
    pub(crate) instances: u64,
    /// Instances among them for which only the test from the corners is fine enough.
    pub(crate) exact_instances: u64,
    /// Triangles with a back.
    pub(crate) one_sided: u64,
    /// Triangles among them that face away.
    pub(crate) facing_away: u64,
    /// Triangles in clusters of which every triangle faces away: what a perfect bound takes.
    pub(crate) ideal_by_cluster: u64,
    /// Triangles in clusters that are culled.
    pub(crate) by_cluster: u64,
    /// Triangles that are culled with their cluster or by their plane; the others that face away go
    /// by the test from their corners.
    pub(crate) by_plane: u64,
}

/// Something visible that was dropped.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub(crate) struct Loss {
    pub(crate) view: usize,
    pub(crate) instance: String,
    pub(crate) handle: Handle,
    /// Null for an instance that only the jittered samples see.
    pub(crate) triangle: Option<u32>,
    pub(crate) pixel: [u32; 2],
    pub(crate) stage: Option<Stage>,
    pub(crate) reason: String,
}

/// One view.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(crate) struct ViewRecord {
    pub(crate) index: usize,
    /// Null for parallel lines of sight.
    pub(crate) eye: Option<[f64; 3]>,
    pub(crate) direction: [f64; 3],
    pub(crate) near: Option<f64>,
    /// Null where the far plane is at infinity.
    pub(crate) far: Option<f64>,
    pub(crate) stages: Vec<StageRecord>,
    /// Work of the frustum stage on the scene's hierarchy.
    pub(crate) hierarchy: FrustumWork,
    /// Whole instances and their triangles, kind of culling after kind of culling.
    pub(crate) whole: WholeRecord,
    pub(crate) triangles: Counts,
    pub(crate) instances: Counts,
    /// Triangles that each stage took, whether alone or with its whole cluster or instance.
    pub(crate) removed: Removed,
    pub(crate) tightness: Option<f64>,
    pub(crate) verified: bool,
    pub(crate) false_culls: u64,
    pub(crate) losses: Vec<Loss>,
    pub(crate) depth_before: Option<DepthRecord>,
    pub(crate) depth_after: Option<DepthRecord>,
    pub(crate) bounds: Option<BoundsRecord>,
    /// Null where back faces are not culled, or there was too much to count.
    pub(crate) backfaces: Option<BackfaceRecord>,
    /// Only where levels of detail are on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) levels: Option<LevelsRecord>,
    pub(crate) seconds: f64,
}

/// Sums over the views.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Summary {
    pub(crate) views: usize,
    pub(crate) verified_views: Vec<usize>,
    pub(crate) triangles: Counts,
    pub(crate) instances: Counts,
    pub(crate) removed: Removed,
    /// Potentially visible over visible triangles, in the views that were verified.
    pub(crate) tightness: Option<f64>,
    pub(crate) false_culls: u64,
    pub(crate) stages: Vec<StageRecord>,
    pub(crate) hierarchy: FrustumWork,
    /// Whole instances and their triangles, kind of culling after kind of culling.
    pub(crate) whole: WholeRecord,
    pub(crate) depth_before: Option<DepthRecord>,
    pub(crate) depth_after: Option<DepthRecord>,
    pub(crate) bounds: Option<BoundsRecord>,
    pub(crate) backfaces: Option<BackfaceRecord>,
    /// Only where levels of detail are on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) levels: Option<LevelsSummary>,
    pub(crate) advice: Vec<Advice>,
}

/// Counts where only whole instances are culled, as a renderer that draws instance by instance sees
/// it: the classic table of the power plant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub(crate) struct WholeRecord {
    /// Instances, and the triangles of all of them, that are in the frustum.
    pub(crate) in_frustum: [u64; 2],
    /// Instances in the frustum, and their triangles, that are neither hidden nor dropped by any
    /// stage before.
    pub(crate) not_hidden: [u64; 2],
    /// How many occluders could have been drawn, and how many were.
    pub(crate) occluders: [u64; 2],
}

impl WholeRecord {
    fn sum(records: impl Iterator<Item = Self>) -> Self {
        let add = |a: [u64; 2], b: [u64; 2]| [a[0] + b[0], a[1] + b[1]];
        records.fold(Self::default(), |a, b| Self {
            in_frustum: add(a.in_frustum, b.in_frustum),
            not_hidden: add(a.not_hidden, b.not_hidden),
            occluders: add(a.occluders, b.occluders),
        })
    }
}

/// A suggestion, with the figures it rests on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Advice {
    /// Kind of advice; stable, for scripts.
    pub(crate) kind: &'static str,
    /// The finding, in a line.
    pub(crate) title: String,
    /// The consequence, with figures.
    pub(crate) text: String,
    /// Triangles a view that it is about, for ordering.
    pub(crate) triangles_per_view: f64,
    /// The meshes or instances it names.
    pub(crate) names: Vec<String>,
}

/// One mesh, over all views.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct MeshRecord {
    pub(crate) mesh: u32,
    pub(crate) name: String,
    pub(crate) triangles: u64,
    pub(crate) polygons: u64,
    pub(crate) instances: u64,
    pub(crate) solid: bool,
    /// Why it is not a solid.
    pub(crate) defect: Option<String>,
    /// one-sided, two-sided or mixed.
    pub(crate) sides: &'static str,
    /// Edges along which its two triangles are wound against each other.
    pub(crate) misoriented: u32,
    pub(crate) degenerate: u64,
    pub(crate) duplicate: u64,
    pub(crate) views_kept: u32,
    pub(crate) views_seen: u32,
    /// Triangles drawn over all views.
    pub(crate) drawn: u64,
    /// Triangles among them that own a pixel.
    pub(crate) visible: u64,
    /// Triangles drawn though they face away, because both their sides are drawn.
    pub(crate) facing_away: u64,
}

impl Summary {
    /// Sums over `views`; advice is left empty.
    pub(crate) fn of(views: &[ViewRecord]) -> Self {
        let sum = |part: fn(&ViewRecord) -> Counts| {
            views.iter().map(part).fold(Counts { visible: Some(0), ..Counts::default() }, |a, c| {
                Counts {
                    all: a.all + c.all,
                    potentially_visible: a.potentially_visible + c.potentially_visible,
                    visible: a.visible.map(|v| v + c.visible.unwrap_or(0)),
                }
            })
        };
        let verified: Vec<&ViewRecord> = views.iter().filter(|v| v.verified).collect();
        let mut removed = Removed::new();
        let mut stages: Vec<StageRecord> = Vec::new();
        for view in views {
            for (&stage, n) in &view.removed {
                *removed.entry(stage).or_default() += n;
            }
            for s in &view.stages {
                match stages.iter_mut().find(|t| (t.stage, t.unit) == (s.stage, s.unit)) {
                    Some(t) => t.add(s),
                    None => stages.push(*s),
                }
            }
        }
        let (drawn, seen) = verified.iter().fold((0, 0), |(d, s), v| {
            (d + v.triangles.potentially_visible, s + v.triangles.visible.unwrap_or(0))
        });
        Self {
            views: views.len(),
            verified_views: verified.iter().map(|v| v.index).collect(),
            triangles: sum(|v| v.triangles),
            instances: sum(|v| v.instances),
            removed,
            tightness: tightness(drawn, seen),
            false_culls: views.iter().map(|v| v.false_culls).sum(),
            stages,
            hierarchy: views.iter().fold(FrustumWork::default(), |a, v| FrustumWork {
                nodes: a.nodes + v.hierarchy.nodes,
                blocks: a.blocks + v.hierarchy.blocks,
                plane_tests: a.plane_tests + v.hierarchy.plane_tests,
                swept: a.swept + v.hierarchy.swept,
            }),
            whole: WholeRecord::sum(views.iter().map(|v| v.whole)),
            depth_before: DepthRecord::mean(verified.iter().filter_map(|v| v.depth_before)),
            depth_after: DepthRecord::mean(verified.iter().filter_map(|v| v.depth_after)),
            bounds: BoundsRecord::sum(views.iter().filter_map(|v| v.bounds)),
            backfaces: BackfaceRecord::sum(views.iter().filter_map(|v| v.backfaces)),
            levels: LevelsSummary::of(views.iter().filter_map(|v| v.levels.as_ref())),
            advice: Vec::new(),
        }
    }
}

/// |S'| / |S|; nothing where nothing is visible.
pub(crate) fn tightness(potentially_visible: u64, visible: u64) -> Option<f64> {
    (visible > 0).then(|| potentially_visible as f64 / visible as f64)
}

impl DepthRecord {
    fn mean(views: impl Iterator<Item = Self>) -> Option<Self> {
        let mut n = 0u32;
        let mut sum = Self::default();
        for v in views {
            n += 1;
            sum.fragments += v.fragments;
            sum.covered_pixels += v.covered_pixels;
            // Weighted by the pixels they are means over, so that an empty view does not pull it
            // down.
            sum.mean_layers += v.mean_layers * v.covered_pixels as f64;
            sum.max_layers = sum.max_layers.max(v.max_layers);
            sum.primitives_per_pixel += v.primitives_per_pixel;
        }
        if sum.covered_pixels > 0 {
            sum.mean_layers /= sum.covered_pixels as f64;
        }
        sum.primitives_per_pixel /= f64::from(n.max(1));
        (n > 0).then_some(sum)
    }
}

impl From<BoundsCounts> for BoundsRecord {
    fn from(counts: BoundsCounts) -> Self {
        let BoundsCounts { tested, boxes_kept, spheres_kept, in_frustum, box_ns, sphere_ns } =
            counts;
        Self { tested, boxes_kept, spheres_kept, in_frustum, box_ns, sphere_ns }
    }
}

impl BoundsRecord {
    fn sum(views: impl Iterator<Item = Self>) -> Option<Self> {
        let mut n = 0u32;
        let mut sum = Self::default();
        for v in views {
            n += 1;
            sum.tested += v.tested;
            sum.boxes_kept += v.boxes_kept;
            sum.spheres_kept += v.spheres_kept;
            sum.in_frustum += v.in_frustum;
            sum.box_ns += v.box_ns;
            sum.sphere_ns += v.sphere_ns;
        }
        sum.box_ns /= f64::from(n.max(1));
        sum.sphere_ns /= f64::from(n.max(1));
        (n > 0).then_some(sum)
    }
}

impl From<BackfaceCounts> for BackfaceRecord {
    fn from(of_view: BackfaceCounts) -> Self {
        Self {
            views: 1,
            instances: of_view.instances,
            exact_instances: of_view.exact_instances,
            one_sided: of_view.one_sided,
            facing_away: of_view.facing_away,
            ideal_by_cluster: of_view.ideal_by_cluster,
            by_cluster: of_view.by_cluster,
            by_plane: of_view.by_plane,
        }
    }
}

impl BackfaceRecord {
    fn sum(views: impl Iterator<Item = Self>) -> Option<Self> {
        views.reduce(|a, b| Self {
            views: a.views + b.views,
            instances: a.instances + b.instances,
            exact_instances: a.exact_instances + b.exact_instances,
            one_sided: a.one_sided + b.one_sided,
            facing_away: a.facing_away + b.facing_away,
            ideal_by_cluster: a.ideal_by_cluster + b.ideal_by_cluster,
            by_cluster: a.by_cluster + b.by_cluster,
            by_plane: a.by_plane + b.by_plane,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(value: &impl Serialize) -> String {
        serde_json::to_string(value).unwrap()
    }

    fn view(index: usize, all: u64, drawn: u64, visible: Option<u64>) -> ViewRecord {
        let triangles = Counts { all, potentially_visible: drawn, visible };
        ViewRecord {
            index,
            eye: None,
            direction: [0.0, 0.0, -1.0],
            near: None,
            far: None,
            hierarchy: FrustumWork::default(),
            stages: vec![StageRecord {
                stage: Stage::Frustum,
                unit: Unit::Instances,
                entered: all,
                left: drawn,
                instances: [all, drawn],
                clusters: [all, drawn],
                triangles: [all, drawn],
                ms: Some(1.0),
            }],
            whole: WholeRecord { in_frustum: [3, all], not_hidden: [2, drawn], occluders: [1, 1] },
            triangles,
            instances: triangles,
            removed: BTreeMap::from([(Stage::Frustum, all - drawn)]),
            tightness: None,
            verified: visible.is_some(),
            false_culls: 0,
            losses: Vec::new(),
            depth_before: None,
            depth_after: None,
            bounds: None,
            backfaces: None,
            levels: None,
            seconds: 0.0,
        }
    }

    #[test]
    fn the_summary_sums_over_views() {
        let s = Summary::of(&[view(0, 100, 40, Some(10)), view(1, 100, 20, Some(10))]);
        let expected = Counts { all: 200, potentially_visible: 60, visible: Some(20) };
        assert_eq!(s.triangles, expected);
        assert_eq!(s.tightness, Some(3.0));
        assert_eq!(s.removed[&Stage::Frustum], 140);
        assert_eq!((s.whole.in_frustum, s.whole.not_hidden), ([6, 200], [4, 60]));
        assert_eq!((s.stages.len(), s.stages[0].entered, s.stages[0].ms), (1, 200, Some(2.0)));
    }

    #[test]
    fn tightness_is_over_the_verified_views_alone() {
        let s = Summary::of(&[view(0, 100, 40, Some(10)), view(1, 100, 90, None)]);
        assert_eq!(s.tightness, Some(4.0));
        assert_eq!(s.verified_views, [0]);
        assert_eq!(s.triangles.potentially_visible, 130);
    }

    #[test]
    fn nothing_visible_has_no_tightness() {
        assert_eq!(Summary::of(&[view(0, 5, 0, Some(0))]).tightness, None);
        assert_eq!(Summary::of(&[]).tightness, None);
    }

    #[test]
    fn the_keys_of_the_schema_are_there() {
        let json = serde_json::to_value(view(3, 9, 6, Some(2))).unwrap();
        assert_eq!(json["index"], 3);
        assert_eq!(json["stages"][0]["in"], 9);
        assert_eq!(json["stages"][0]["out"], 6);
        assert_eq!(json["stages"][0]["triangles"], serde_json::json!([9, 6]));
        assert_eq!(json["removed"]["frustum"], 3);
        assert_eq!(json["stages"][0]["ms"], 1.0);
        assert_eq!(json["triangles"]["potentially_visible"], 6);
        assert_eq!(json["false_culls"], 0);
    }

    #[test]
    fn the_engines_types_have_the_names_of_the_schema() {
        let view = view(3, 9, 6, None);
        let stage = r#"{"name":"frustum","unit":"instances","in":9,"out":6,"instances":[9,6],"clusters":[9,6],"triangles":[9,6],"ms":1.0}"#;
        assert_eq!(text(&view.stages[0]), stage);
        let work = FrustumWork { nodes: 1, blocks: 2, plane_tests: 3, swept: 4 };
        let named = r#"{"nodes":1,"blocks":2,"plane_tests":3,"swept":4}"#;
        assert_eq!(text(&work), named);
        let removed: Removed = Stage::ALL.iter().rev().map(|&stage| (stage, 7)).collect();
        let names = Stage::ALL.map(|stage| format!("\"{}\":7", stage.name())).join(",");
        assert_eq!(text(&removed), format!("{{{names}}}"));
        let loss = Loss {
            view: 1,
            instance: "oak 2".to_owned(),
            handle: Handle { index: 2, generation: 5 },
            triangle: None,
            pixel: [3, 4],
            stage: Some(Stage::Lod),
            reason: "x".to_owned(),
        };
        let named = r#"{"view":1,"instance":"oak 2","handle":[2,5],"triangle":null,"pixel":[3,4],"stage":"lod","reason":"x"}"#;
        assert_eq!(text(&loss), named);
    }
}
