//! `cullet picture` of what teaches: diagrams, and what is made for them.

mod args;
mod impostor;
mod matrix;

use std::ops::ControlFlow;

use cullet::{Mesh, Scene};
use cullet_bake::clusters::{ClusterOptions, Progress, build_reported};
use cullet_cli::levels;
use cullet_command::args::ViewArgs;
use cullet_command::console::{Console, count, interrupted};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::inputs;
use cullet_draw::Picture;
use cullet_mesh::ViewCone;

use crate::bench::{self, BenchOptions};
use crate::teach::{self, VolumeFigure};
use args::PictureKind;
pub(crate) use args::{HELP, PictureArgs};

/// Where diagrams look from and to, where no eye is given.
const SIGHT: [[f64; 3]; 2] = [[3.0, 2.0, 5.0], [0.0; 3]];

/// Runs the command.
pub(crate) fn run(args: &PictureArgs, console: &Console) -> Outcome {
    let picture = match args.kind {
        PictureKind::NormalMask => {
            let half = args.input.view.fov.unwrap_or(20.0).to_radians() * 0.5;
            let cone = ViewCone::around(sight(&args.input.view)?, half).ok_or_else(|| {
                Failure::usage(
                    "normal-mask: the lines of sight must spread by less than 180 degrees; try \
                     --fov 20",
                )
            })?;
            teach::normal_mask(&cone, args.input.view.size)
        }
        PictureKind::NormalPartition => {
            teach::normal_partition(args.input.view.fov.unwrap_or(40.0) * 0.5, args.input.view.size)
        }
        PictureKind::ConservativeSet => {
            teach::conservative_set(args.input.view.fov.unwrap_or(90.0), args.input.view.size)
        }
        PictureKind::Coverage => teach::coverage(args.input.view.size),
        PictureKind::Outcodes => teach::outcodes(args.input.view.size),
        PictureKind::ClipPolygon => teach::clip_polygon(args.input.view.size),
        PictureKind::ClipW => teach::clip_w(args.input.view.size),
        PictureKind::Pipeline => teach::pipeline(&costs(), args.input.view.size),
        PictureKind::PvsMatrix => matrix::draw(args, console)?,
        PictureKind::Impostor => impostor::draw(args, console)?,
        _ => of_scene(args, console)?,
    };
    let out = args.out.clone().unwrap_or_else(|| format!("{}.png", args.kind.name()).into());
    std::fs::write(&out, picture.to_png()).map_err(|e| Failure::write(&out, &e))?;
    console.line(format!("{} written, {}x{}", out.display(), picture.width, picture.height));
    Ok(Exit::Fine)
}

/// The pictures that show a scene.
fn of_scene(args: &PictureArgs, console: &Console) -> Result<Picture, Failure> {
    let mut model = levels::load(&args.input.scene, &args.input.cull, console)?;
    inputs::begin(&mut model, &args.input.view, console)?;
    let views = inputs::culled_views(&model, &args.input.view, &args.input.cull, console)?;
    if let Some(&seconds) = inputs::times(&args.input.view, views.len()).get(args.index as usize) {
        inputs::pose(&mut model, seconds)?;
    }
    let Some(view) = views.get(args.index as usize) else {
        let last = views.len().saturating_sub(1);
        return Err(Failure::usage(format!(
            "--view {}: the path's last view is {last}",
            args.index
        )));
    };
    if args.kind != PictureKind::BackRegions {
        let made = args.clusters.options(console)?;
        cluster(&mut model.scene, &made.options, console)?;
        console.line(format!("clusters for {}", made.words));
    }
    let scene = &model.scene;
    Ok(match args.kind {
        PictureKind::CullingVolume => {
            let (picture, f) = volume(args, scene)?;
            console.line(format!(
                "cluster {}: behind all planes in {:.1} % of its box, proved by Johannsen & Carter's \
                 bound in {:.1} %",
                f.cluster,
                f.ideal * 100.0,
                f.proved * 100.0
            ));
            picture
        }
        PictureKind::Clusters => teach::clusters(scene, view),
        PictureKind::Cones => teach::cones(scene, view),
        _ => {
            let (picture, regions_found) = teach::back_regions(scene, view);
            let regions = "connected back-facing regions";
            console.line(count(regions_found as u64, "connected back-facing region", regions));
            picture
        }
    })
}

/// Measures the costs of the pipeline's tests on this machine: the benchmarks, briefly, at the best
/// SIMD level.
fn costs() -> Vec<(String, f64)> {
    let measure = |name: &str| {
        let filter = Some(name.to_owned());
        let sizes = vec![100_000];
        let options = BenchOptions { filter, seconds: 0.1, sizes, ..BenchOptions::default() };
        // The best level comes first.
        let first = bench::run_all(&options).results.into_iter().next()?;
        Some((first.name, first.ns_per_item))
    };
    teach::pipeline_costs().filter_map(measure).collect()
}

/// Gives every mesh the clusters that are made for culling.
fn cluster(scene: &mut Scene, options: &ClusterOptions, console: &Console) -> Result<(), Failure> {
    /// Steps of the bar.
    const STEPS: u64 = 1000;
    let whole = scene.meshes().iter().map(|m| f64::from(m.triangle_count())).sum::<f64>().max(1.0);
    let mut bar = console.progress("clusters", STEPS);
    let (mut before, mut shown) = (0.0, 0);
    for number in 0..scene.meshes().len() as u32 {
        let mesh = &scene.meshes()[number as usize];
        let triangles = f64::from(mesh.triangle_count());
        let data = mesh.to_data();
        let failed = |e: String| Failure::input(format!("mesh {number}: {e}"));
        let progress = |p: Progress| {
            let share = (before + f64::from(p.share) * triangles) / whole;
            while shown < (share * STEPS as f64) as u64 {
                bar.step();
                shown += 1;
            }
            if interrupted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let (clustering, report) =
            build_reported(&data, options, progress).map_err(|e| failed(e.to_string()))?;
        if !report.complete {
            return Err(Failure {
                exit: Exit::Interrupted,
                message: "stopped before all clusters were made; no picture is written".into(),
            });
        }
        before += triangles;
        let made = Mesh::with_clusters(data, &clustering).map_err(|e| failed(e.to_string()))?;
        scene.edit_mesh(number, |mesh| *mesh = made);
    }
    Ok(())
}

/// The direction of sight of a diagram.
fn sight(view: &ViewArgs) -> Result<[f64; 3], Failure> {
    let [eye, target] = match (view.eye, view.target) {
        (Some(eye), Some(target)) => [eye, target],
        _ => SIGHT,
    };
    let toward = [0, 1, 2].map(|k| target[k] - eye[k]);
    if toward == [0.0; 3] || !toward.iter().all(|v| v.is_finite()) {
        return Err(Failure::usage(
            "normal-mask: --eye and --target must be two points, or there is no direction of sight",
        ));
    }
    Ok(toward)
}

fn volume(args: &PictureArgs, scene: &Scene) -> Result<(Picture, VolumeFigure), Failure> {
    let Some(first) = scene.slots().next() else {
        return Err(Failure::input("the scene has no instance, so no cluster"));
    };
    let draw = |slot| teach::culling_volume(scene, slot, args.cluster, args.input.view.size);
    let clusters = scene.mesh(first).clusters().len();
    let made = match args.cluster {
        Some(_) => draw(first),
        None => scene.slots().find_map(draw),
    };
    made.ok_or_else(|| match args.cluster {
        Some(n) if n as usize >= clusters => Failure::usage(format!(
            "--cluster {n}: the first mesh has {}, numbered from 0",
            count(clusters as u64, "cluster", "clusters")
        )),
        Some(n) => Failure::usage(format!(
            "--cluster {n}: from no eye near it do all of its triangles face away; try another, or \
             none to take the widest that has a volume"
        )),
        None if scene.meshes().iter().all(Mesh::is_two_sided) => Failure::input(
            "no cluster of the scene has a culling volume: its meshes are two-sided, so their clusters are made \
             otherwise; try --one-sided",
        ),
        None => Failure::input(
            "no cluster of the scene has a culling volume: the triangles of each face all ways, as in a small solid \
             that is one cluster, so there is no eye from which all of them face away; try a model of more triangles, \
             such as knobs",
        ),
    })
}
