//! `cullet bench portal`: what cells and portals cost, and what they save.

use std::hint::black_box;
use std::path::{Path, PathBuf};

use clap::Args;
use cullet::{Culler, Stage, View, ViewState, Visible};
use cullet_cells::CellView;
use cullet_cells::cell::{CellGraph, CellLocator, CellPiece, CellShapes, Portal};
use cullet_cells::portal::{
    PortalClip, PortalOptions, PortalView, Reached, ray_cells_ref, walk_portals,
};
use cullet_command::args::SceneArgs;
use cullet_command::console::{Console, grouped};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::write_json;
use cullet_command::inputs;
use cullet_io::Model;
use serde::Serialize;

use super::world::Random;
use crate::stopwatch::of_thread;
use cullet_command::machine::Machine;

pub(crate) const HELP: &str = "\
Walks a generated building of 1,000 rooms through its portals, from random views, and finds the cell of random points
among 10,000 rooms; then culls scenes that have cells with portals and occlusion, with occlusion alone, and with neither.
Answers are checked: rays see no cell that a walk does not reach, the cell of a point is that of a search through all,
and portals leave no more triangles than are left without. Times are those of the thread, the fastest of several rounds.

Examples
  cullet bench portal                                 the building, the office, and of CULLET_DATA a house and three maps
  cullet bench portal --scene office:rooms=20,floors=5,roof=1
  cullet bench portal --scene map.bsp --scene house.glb --cells rooms.glb";

/// `cullet bench portal`
#[derive(Debug, Args)]
pub(crate) struct PortalArgs {
    /// A scene that has cells, a file or a built-in one; may be given many times [default: office,
    /// and of `CULLET_DATA` a house and maps]
    #[arg(long, value_name = "SCENE")]
    scene: Vec<String>,
    /// Volumes of rooms that cut scenes without cells into some
    #[arg(long, value_name = "FILE", requires = "scene")]
    cells: Option<PathBuf>,
    /// How many views of each
    #[arg(long, value_name = "N", default_value_t = 500, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    views: u32,
    /// Write the results as JSON; - is the standard output
    #[arg(long, value_name = "PATH")]
    json: Option<PathBuf>,
}

impl PortalArgs {
    pub(crate) fn json(&self) -> Option<&Path> {
        self.json.as_deref()
    }
}

/// Rounds of which the fastest counts.
const ROUNDS: usize = 9;

/// One way of walking.
#[derive(Debug, Serialize)]
struct Walks {
    clip: PortalClip,
    cells: u32,
    portals: usize,
    views: u32,
    /// Microseconds a view.
    median_us: f64,
    p95_us: f64,
    worst_us: f64,
    /// Visits a view.
    mean_visits: f64,
    /// Cells that rays saw, and that the walks reached.
    cells_of_rays: u64,
    cells_reached: u64,
    rays_missed: u64,
}

/// Cells of points.
#[derive(Debug, Serialize)]
struct Located {
    cells: u32,
    points: usize,
    ns_per_point: f64,
    wrong: usize,
}

/// Culls of a scene.
#[derive(Debug, Serialize)]
struct Culls {
    scene: String,
    settings: String,
    views: usize,
    triangles: u64,
    microseconds: f64,
}

/// Portals with occlusion against occlusion alone.
#[derive(Debug, Serialize)]
struct Gain {
    scene: String,
    preset: &'static str,
    /// Triangles left and time of the one over those of the other.
    triangles: f64,
    time: f64,
    /// Views in which portals alone left more than neither: a fault.
    wrong: usize,
}

#[derive(Debug, Serialize)]
struct Record {
    schema: u32,
    machine: Machine,
    walks: Vec<Walks>,
    located: Located,
    culls: Vec<Culls>,
    gains: Vec<Gain>,
}

/// A scene with cells, or a file and the volumes of its rooms.
type Named = (String, Option<PathBuf>);

/// The office, and what of `CULLET_DATA` is there.
fn all() -> Vec<Named> {
    let set = std::env::var_os("CULLET_DATA").filter(|v| !v.is_empty()).map(PathBuf::from);
    let folder = set.unwrap_or_else(|| "../shared/data".into());
    let rooms = folder.join("duplex-bim/duplex-spaces.glb");
    let maps = ["quake-libre/lqdm1.bsp", "quake-libre/lq_e0m1.bsp", "quake3-openarena/oa_dm1.bsp"];
    let files = [("duplex-bim/duplex.glb", Some(rooms))].into_iter();
    let files = files.chain(maps.into_iter().map(|map| (map, None)));
    let there = files
        .map(|(file, rooms)| (folder.join(file), rooms))
        .filter(|(file, _)| file.exists())
        .map(|(file, rooms)| (file.display().to_string(), rooms));
    [("office".to_owned(), None)].into_iter().chain(there).collect()
}

/// Runs the command.
pub(crate) fn run(args: &PortalArgs, console: &Console) -> Outcome {
    let mut walks = Vec::new();
    let (graph, shapes) = building([10, 10, 10]);
    for clip in [PortalClip::Polygons, PortalClip::Rectangles] {
        let row = walk(&graph, &shapes, clip, args.views);
        console.line(format!(
            "{} cells, {} portals, {:?}: {:.2} us a view in the median, {:.2} in 95 of 100, {:.2} at the most; {:.1} visits; \
             {} of {} cells reached were seen by rays, {} missed",
            grouped(row.cells.into()), row.portals, row.clip, row.median_us, row.p95_us, row.worst_us, row.mean_visits,
            grouped(row.cells_of_rays), grouped(row.cells_reached), row.rays_missed
        ));
        walks.push(row);
    }
    let located = locate();
    console.line(format!(
        "cell of a point among {}: {:.0} ns; {} of {} wrong",
        grouped(located.cells.into()),
        located.ns_per_point,
        located.wrong,
        grouped(located.points as u64)
    ));
    let named = match &args.scene[..] {
        [] => all(),
        some => some.iter().map(|scene| (scene.clone(), args.cells.clone())).collect(),
    };
    let (mut culls, mut gains) = (Vec::new(), Vec::new());
    for scene in &named {
        let (rows, of_scene) = cull(scene, args.views, console)?;
        for row in &rows {
            console.line(format!(
                "{}, {}: {:.1} us and {} triangles a view, in {} views",
                row.scene,
                row.settings,
                row.microseconds / row.views as f64,
                grouped(row.triangles / row.views.max(1) as u64),
                row.views
            ));
        }
        for gain in &of_scene {
            console.line(format!(
                "{}, {}: with portals {:.2} of the triangles that occlusion alone leaves, in {:.2} times its time",
                gain.scene, gain.preset, gain.triangles, gain.time
            ));
        }
        culls.extend(rows);
        gains.extend(of_scene);
    }
    let is_wrong = walks.iter().any(|w| w.rays_missed > 0)
        || located.wrong > 0
        || gains.iter().any(|gain| gain.wrong > 0);
    if let Some(path) = args.json() {
        write_json(
            path,
            &Record { schema: 1, machine: Machine::here(), walks, located, culls, gains },
        )?;
    }
    if is_wrong {
        Err(Failure::input("an answer is wrong: see the counts above"))
    } else {
        Ok(Exit::Fine)
    }
}

/// Sides of a room.
const ROOM: [f64; 3] = [6.0, 3.0, 6.0];

/// Rooms along each axis, with a door to most neighbours and a hatch to some above.
fn building(size: [u32; 3]) -> (CellGraph, CellShapes) {
    let mut random = Random::new();
    let number = |[x, y, z]: [u32; 3]| (y * size[2] + z) * size[0] + x;
    let (mut portals, mut pieces) = (Vec::new(), Vec::new());
    for y in 0..size[1] {
        for z in 0..size[2] {
            for x in 0..size[0] {
                let at = [x, y, z];
                let min: [f64; 3] = std::array::from_fn(|a| f64::from(at[a]) * ROOM[a]);
                let max: [f64; 3] = std::array::from_fn(|a| min[a] + ROOM[a]);
                pieces.push(CellPiece::from_box(number(at), min, max));
                for axis in 0..3 {
                    let mut next = at;
                    next[axis] += 1;
                    let share = if axis == 1 { 0.2 } else { 0.75 };
                    if next[axis] == size[axis] || random.next() > share {
                        continue;
                    }
                    let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
                    let middle = |a: usize, t: f32| min[a] + 1.0 + f64::from(t) * (ROOM[a] - 2.0);
                    let (mu, mv) = (middle(u, random.next()), middle(v, random.next()));
                    let corners = [[-0.6, -0.9], [-0.6, 0.9], [0.6, 0.9], [0.6, -0.9]];
                    let polygon = corners.map(|[a, b]| {
                        let mut p = [max[axis]; 3];
                        (p[u], p[v]) = (mu + a, mv + b);
                        p
                    });
                    portals.push(Portal {
                        cells: [number(at), number(next)],
                        polygon: polygon.to_vec(),
                    });
                }
            }
        }
    }
    let graph = CellGraph::new(size.iter().product(), portals).expect("upright rectangles");
    let shapes = CellShapes::new(&graph, pieces).expect("boxes with a door between two of them");
    (graph, shapes)
}

fn walk(graph: &CellGraph, shapes: &CellShapes, clip: PortalClip, views: u32) -> Walks {
    let mut random = Random::new();
    let options = PortalOptions { clip, ..PortalOptions::default() };
    let (mut times, mut reached) = (Vec::new(), Reached::default());
    let (mut visits, mut by_rays, mut by_walks, mut rays_missed) = (0, 0, 0, 0);
    for _ in 0..views {
        let eye: [f64; 3] = random.point::<3>(0.5).map(|v| f64::from(v) + 0.5);
        let eye = std::array::from_fn(|a| eye[a] * ROOM[a] * 10.0);
        let [dx, dy, dz] = random.point::<3>(1.0).map(f64::from);
        let target = [eye[0] + dx, eye[1] + dy * 0.3, eye[2] + dz];
        // A direction without length, or straight up: never drawn here.
        let Ok(view) = View::perspective(eye, target, 1.0, 0.05, 500.0, [1280, 720]) else {
            continue;
        };
        let Some(cell) = shapes.cell_of(eye) else { continue };
        let Some(of_view) = PortalView::new(&view) else { continue };
        let mut best = f64::INFINITY;
        for _ in 0..ROUNDS {
            let took = of_thread(|| {
                let view = PortalView::new(black_box(&view)).expect("a perspective");
                walk_portals(graph, &view, &[cell], &options, &mut reached);
            });
            best = best.min(took.as_secs_f64() * 1e6);
        }
        times.push(best);
        visits += reached.visits().len();
        let mut cells: Vec<u32> = reached.visits().iter().map(|visit| visit.cell).collect();
        cells.sort_unstable();
        cells.dedup();
        by_walks += cells.len() as u64;
        walk_portals(graph, &of_view, &[cell], &options, &mut reached);
        let mut seen = Vec::new();
        for _ in 0..200 {
            let [x, y] = [random.next(), random.next()].map(f64::from);
            let Some(ray) = view.ray([x * 1280.0, y * 720.0]) else { continue };
            ray_cells_ref((graph, shapes), cell, eye, ray.direction, (0, 1e-6), |cell, _, _| {
                seen.push(cell);
            });
        }
        seen.sort_unstable();
        seen.dedup();
        by_rays += seen.len() as u64;
        rays_missed += seen.iter().filter(|cell| cells.binary_search(cell).is_err()).count() as u64;
    }
    times.sort_unstable_by(f64::total_cmp);
    let at =
        |share: f64| times.get((times.len() as f64 * share) as usize).or(times.last()).copied();
    Walks {
        clip,
        cells: graph.cell_count(),
        portals: graph.portals().len(),
        views: times.len() as u32,
        median_us: at(0.5).unwrap_or(0.0),
        p95_us: at(0.95).unwrap_or(0.0),
        worst_us: at(1.0).unwrap_or(0.0),
        mean_visits: visits as f64 / times.len().max(1) as f64,
        cells_of_rays: by_rays,
        cells_reached: by_walks,
        rays_missed,
    }
}

fn locate() -> Located {
    const POINTS: usize = 100_000;
    let size = [25, 16, 25];
    let (graph, shapes) = building(size);
    let mut random = Random::new();
    let points: Vec<[f64; 3]> = (0..POINTS)
        .map(|_| {
            // Some beyond the building.
            let p = random.point::<3>(0.55).map(|v| f64::from(v) + 0.5);
            std::array::from_fn(|a| p[a] * ROOM[a] * f64::from(size[a]))
        })
        .collect();
    let in_grid = |p: &[f64; 3]| {
        let at: [f64; 3] = std::array::from_fn(|a| (p[a] / ROOM[a]).floor());
        let inside = (0..3).all(|a| at[a] >= 0.0 && at[a] < f64::from(size[a]));
        let [x, y, z] = at.map(|v| v as u32);
        inside.then(|| (y * size[2] + z) * size[0] + x)
    };
    let wrong = points.iter().filter(|p| shapes.cell_of(**p) != in_grid(p)).count();
    let mut best = f64::INFINITY;
    for _ in 0..ROUNDS {
        let took = of_thread(|| {
            for p in &points {
                black_box(shapes.cell_of(*p));
            }
        });
        best = best.min(took.as_secs_f64() * 1e9 / POINTS as f64);
    }
    Located { cells: graph.cell_count(), points: POINTS, ns_per_point: best, wrong }
}

/// Culls from where eyes may be in the cells of a scene, with and without portals and occlusion.
fn cull(
    (name, rooms): &Named,
    views: u32,
    console: &Console,
) -> Result<(Vec<Culls>, Vec<Gain>), Failure> {
    let args = SceneArgs { cells: rooms.clone(), ..SceneArgs::of(name) };
    let mut model = inputs::load(&args, console)?;
    let name = name.rsplit(['/', '\\']).next().unwrap_or(name).to_owned();
    if model.cells.cells.is_empty() {
        return Err(Failure::usage(format!("{name}: the scene has no cells; office has")));
    }
    [Culler::balanced(), Culler::exact()].iter().for_each(|c| model.scene.prepare(c));
    let eyes = eyes(&model, views);
    let world = model.in_cells();
    let presets = [("balanced", Culler::balanced()), ("exact", Culler::exact())];
    let (mut rows, mut gains) = (Vec::new(), Vec::new());
    for (preset, all) in &presets {
        // Sets that a map brings along would hide what portals do.
        let all = all.without(Stage::Pvs);
        let neither = all.without(Stage::Occlusion).without(Stage::Portal);
        let ways = [
            ("portals and occlusion", all.clone()),
            ("occlusion alone", all.without(Stage::Portal)),
            ("portals alone", all.without(Stage::Occlusion)),
            ("neither", neither),
        ];
        let mut best = vec![[f64::INFINITY; 4]; eyes.len()];
        let mut triangles = vec![[0; 4]; eyes.len()];
        let mut states: [(ViewState, CellView); 4] = Default::default();
        let mut result = Visible::default();
        for _ in 0..ROUNDS {
            for ((view, best), triangles) in eyes.iter().zip(&mut best).zip(&mut triangles) {
                for (way, (_, culler)) in ways.iter().enumerate() {
                    let ((state, among), result) = (&mut states[way], &mut result);
                    let took = of_thread(|| among.cull(world, culler, view, state, result));
                    best[way] = best[way].min(took.as_secs_f64() * 1e6);
                    triangles[way] = result.triangle_count;
                }
            }
        }
        let of_way = |way: usize| Culls {
            scene: name.clone(),
            settings: format!("{preset}, {}", ways[way].0),
            views: eyes.len(),
            triangles: triangles.iter().map(|t| t[way]).sum(),
            microseconds: best.iter().map(|b| b[way]).sum(),
        };
        let of_ways: [Culls; 4] = std::array::from_fn(of_way);
        let [both, occlusion, ..] = &of_ways;
        gains.push(Gain {
            scene: name.clone(),
            preset,
            triangles: both.triangles as f64 / occlusion.triangles.max(1) as f64,
            time: both.microseconds / occlusion.microseconds.max(1e-9),
            wrong: triangles.iter().filter(|t| t[2] > t[3]).count(),
        });
        rows.extend(of_ways);
    }
    Ok((rows, gains))
}

/// Views in the cells of a scene, at six tenths of their height.
fn eyes(model: &Model, views: u32) -> Vec<View> {
    let mut random = Random::new();
    let half = model.scene.extent().half_extent();
    let size = half.into_iter().fold(0.0, f64::max) * 2.0;
    let mut eyes = Vec::new();
    for i in 0..views as usize {
        let cell = &model.cells.cells[i * 7 % model.cells.cells.len()];
        let [u, v] = [random.next(), random.next()].map(|t| 0.3 + 0.4 * f64::from(t));
        let [dx, dz] = random.point::<2>(1.0).map(f64::from);
        let Some([min, max]) = cell.main_bounds() else { continue };
        let between = |a: usize, t: f64| min[a] + (max[a] - min[a]) * t;
        let eye = [between(0, u), between(1, 0.6), between(2, v)];
        let target = [eye[0] + dx, eye[1] - 0.1, eye[2] + dz];
        eyes.extend(View::perspective(eye, target, 1.0, size * 1e-3, size * 2.0, [1280, 720]));
    }
    eyes
}
