//! The answers of the engine's own queries, which the package must give too.
//!
//! `test/queries.txt` holds them: written here (`CULLET_WRITE=1`), compared here and in Node by
//! `test/queries.test.mjs`, which builds the same scene by the same numbers.

#![cfg(feature = "queries")]

use std::fmt::Write;
use std::path::Path;

use cullet::bounds::Aabb;
use cullet::cull::shadow::Light;
use cullet::{Culler, Depth, Output, View, ViewState, Visible};
use cullet_cells::query::{
    BlockingSides, BoxSight, EyeBox, Find, LightAnswer, LightOptions, LightReason, Motion,
    MotionQuery, RegionCuller, RegionState, RegionVisible, Sight, SightOptions, VolumeOptions,
    box_to_box, cull_light_casters, cull_lights, line_of_sight,
};
use cullet_web::{
    Kind, LineSettings, NONE, Queries, SceneSet, SceneView, Settings, VolumeSettings,
};

/// The same numbers as in Node.
struct Random(u32);

impl Random {
    /// A whole number below `n`.
    fn next(&mut self, n: u32) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        ((u64::from(self.0) * u64::from(n)) >> 32) as f64
    }

    fn point(&mut self) -> [f64; 3] {
        [self.next(81) - 40.3, self.next(9) + 0.7, self.next(81) - 40.1]
    }
}

const INSTANCES: usize = 300;
const MATRIX: [f64; 16] =
    [1.5, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, -1.001, -1.0, 0.0, -4.0, 49.9, 50.0];

fn scene(random: &mut Random) -> SceneSet {
    let positions: Vec<f32> = (0..8)
        .flat_map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|v| if v == 1 { 1.0 } else { -1.0 }))
        .collect();
    let indices = [
        0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6,
        1, 3, 5, 3, 7, 5,
    ];
    let mut set = SceneSet::new(cullet::Scene::new());
    for kind in [0, Kind::ONE_SIDED, Kind::MASKED] {
        assert!(set.add_mesh(&positions, &indices, &[], Kind(kind)).is_ok());
    }
    for _ in 0..INSTANCES {
        let mesh = [0, 0, 0, 0, 0, 1, 1, 2][random.next(8) as usize];
        let [x, y, z] = [random.next(81) - 40.0, random.next(5), random.next(81) - 40.0];
        let [a, b, c] = [random.next(5) + 1.0, random.next(4) + 2.0, random.next(5) + 1.0];
        let matrix = [a, 0.0, 0.0, 0.0, 0.0, b, 0.0, 0.0, 0.0, 0.0, c, 0.0, x, y, z, 1.0];
        assert!(set.add(mesh, &matrix, 1, 0).is_ok());
    }
    set.commit();
    set
}

/// A line of the file: a name and numbers.
fn line(out: &mut String, name: &str, numbers: impl IntoIterator<Item = f64>) {
    out.push_str(name);
    for number in numbers {
        let _ = write!(out, " {number}");
    }
    out.push('\n');
}

fn ids(set: &SceneSet, slots: impl Iterator<Item = u32>) -> Vec<f64> {
    let mut ids: Vec<u32> =
        slots.filter_map(|slot| Some(set.scene().handle(slot)?.index)).collect();
    ids.sort_unstable();
    ids.into_iter().map(f64::from).collect()
}

fn lines(set: &SceneSet, random: &mut Random, out: &mut String) {
    let scene = set.scene();
    let mut queries = Queries::default();
    for i in 0..200 {
        let (from, to) = (random.point(), random.point());
        let ignored = if i % 4 == 3 { [i, i + 1] } else { [NONE; 2] };
        let options = SightOptions {
            sides: if i % 4 == 1 { BlockingSides::Both } else { BlockingSides::AsDrawn },
            find: if i % 4 == 2 { Find::Any } else { Find::Nearest },
            ignored: ignored.map(|id| set.handle(id).ok()),
            ..SightOptions::default()
        };
        let ours = match line_of_sight(scene, from, to, &options) {
            Sight::Clear => vec![],
            Sight::Blocked(by) => {
                let [x, y, z] = by.point;
                vec![by.handle.index.into(), by.triangle.into(), by.share, x, y, z]
            }
        };
        // The package's own call, natively.
        let flags = u32::from(i % 4 == 1) | u32::from(i % 4 == 2) << 1;
        let settings = LineSettings { layers: u32::MAX, flags, ignored };
        assert_eq!(queries.lines(set, &[from, to].concat(), &settings), Ok(()));
        let id = ours.first().map_or(NONE, |&id| id as u32);
        assert_eq!(queries.ids(), [id]);
        line(out, "line", ours);
    }
}

fn boxes(set: &SceneSet, random: &mut Random, out: &mut String) {
    let mut queries = Queries::default();
    for i in 0..200_u32 {
        let middles = [random.point(), random.point()];
        let motion = if i % 2 == 0 { [0.0; 2] } else { [0.25, 0.5] };
        let [from, to] = [0, 1].map(|k| {
            let half = 0.3 + motion[k];
            let [low, high] = [-half, half].map(|by| middles[k].map(|v| v + by));
            Aabb::rounded_out(low, high)
        });
        let options = VolumeOptions { splits: i % 3, ..VolumeOptions::default() };
        let (state, id) = match box_to_box(set.scene(), &from, &to, &options) {
            BoxSight::Visible => (0, NONE),
            BoxSight::Hidden(by) => (1, by.handle.index),
            BoxSight::Empty => (2, NONE),
        };
        let pair: Vec<f64> =
            middles.iter().flat_map(|m| [-0.3, 0.3].map(|by| m.map(|v| v + by)).concat()).collect();
        let settings = VolumeSettings { layers: u32::MAX, splits: i % 3, motion };
        assert_eq!(queries.boxes(set, &pair, &settings), Ok(()));
        assert_eq!((queries.states(), queries.ids()), (&[state][..], &[id][..]), "pair {i}");
        line(out, "box", [f64::from(state), id.into()]);
    }
}

fn regions(set: &SceneSet, random: &mut Random, out: &mut String) {
    let scene = set.scene();
    let culler = RegionCuller { cell_world: 1.0, width: 128, ..RegionCuller::default() };
    let (mut state, mut visible) = (RegionState::default(), RegionVisible::default());
    for i in 0..4 {
        let [x, y, z] = random.point();
        let eyes = EyeBox::new([x, y, z], [x + 2.0, y + 0.5, z + 1.0]);
        let culled = match i {
            3 => culler.cull_view(scene, &eyes, &view(), &mut state, &mut visible),
            _ => culler.cull(scene, &eyes, &mut state, &mut visible),
        };
        assert_eq!(culled, Ok(()));
        line(out, "region", ids(set, visible.slots()));
    }
    let points = [random.point(), random.point(), random.point()];
    let motion = Motion { radius_world: 0.5, reach_world: 30.0, ..Motion::along(&points) };
    let query = MotionQuery { region: culler, ..MotionQuery::default() };
    let mut needed = Vec::new();
    assert!(query.needed(scene, &motion, &mut state, &mut needed).is_ok());
    line(out, "needed", needed.iter().map(|n| n.handle.index.into()));
    line(out, "distances", needed.iter().map(|n| n.distance));
}

fn view() -> View {
    View::from_matrix(MATRIX, Depth::Standard, [640, 400]).unwrap_or_else(|e| panic!("{e}"))
}

fn candidates_and_lights(set: &SceneSet, random: &mut Random, out: &mut String) {
    let scene = set.scene();
    let mut culler = Culler::exact();
    culler.output = Output::Clusters;
    let (view, mut state, mut visible) = (view(), ViewState::default(), Visible::default());
    let mut mask = vec![0_u64; scene.slot_count().div_ceil(64) as usize];
    for slot in 0..scene.slot_count() {
        if scene.handle(slot).is_some_and(|handle| handle.index % 3 != 0) {
            mask[slot as usize / 64] |= 1 << (slot % 64);
        }
    }
    assert_eq!(culler.cull_among(scene, &view, &mask, &mut state, &mut visible), Ok(()));
    line(out, "among", ids(set, visible.slots()));

    let (mut state, mut visible) = (ViewState::default(), Visible::default());
    culler.cull_one(scene, &view, &mut state, &mut visible);
    line(out, "visible", ids(set, visible.slots()));
    let mut lights = vec![Light::Directional { direction: [0.3, -1.0, 0.2] }];
    for i in 0..40 {
        let (position, range) = (random.point(), random.next(4) * 3.0);
        lights.push(match i % 2 {
            0 => Light::Point { position, range },
            _ => Light::Spot {
                position,
                direction: [0.5, -1.0, 0.25],
                half_angle_radians: 0.5,
                range,
            },
        });
    }
    let reason = |r: &Option<LightReason>| {
        r.map_or(0.0, |r| {
            LightReason::ALL.iter().position(|&x| x == r).map_or(9.0, |i| i as f64 + 1.0)
        })
    };
    for is_on_visible in [true, false] {
        let options = LightOptions {
            buffer: state.occlusion_buffer().filter(|_| is_on_visible),
            visible: Some(&visible).filter(|_| is_on_visible),
            ..LightOptions::default()
        };
        let mut answer = LightAnswer::default();
        cull_lights(scene, &view, &lights, &options, &mut answer);
        line(out, "reasons", answer.reasons.iter().map(reason));
        let (mut states, mut casters) = (Vec::new(), Vec::new());
        cull_light_casters(&culler, scene, (&view, &lights, &answer), &mut states, &mut casters);
        for casters in &casters {
            line(out, "casters", ids(set, casters.slots()));
        }
        for receivers in answer.receivers.iter().flatten() {
            let corners = [receivers.min, receivers.max].concat();
            line(out, "receivers", corners.into_iter().map(f64::from));
        }
    }
    // A view that has seen nothing has no picture that lights could change.
    let mut fresh = SceneView::new(Settings { preset: 0, output: 1, flags: 0, draw_us: 0.0 });
    assert!(fresh.cull_lights(set, &[0.0; 9], 1).is_err());
}

#[test]
fn the_engine_gives_the_answers_that_the_package_must_give() {
    let mut random = Random(7);
    let set = scene(&mut random);
    let mut out = String::new();
    lines(&set, &mut random, &mut out);
    boxes(&set, &mut random, &mut out);
    regions(&set, &mut random, &mut out);
    candidates_and_lights(&set, &mut random, &mut out);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("test/queries.txt");
    if std::env::var_os("CULLET_WRITE").is_some() {
        std::fs::write(&path, &out).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    for (i, (ours, theirs)) in out.lines().zip(kept.lines()).enumerate() {
        assert_eq!(ours, theirs, "line {} of {}", i + 1, path.display());
    }
    assert_eq!(out.lines().count(), kept.lines().count());
}
