//! `cullet picture`: one picture of one view.

use cullet::cull::backface::ViewCone;
use cullet::{Mesh, MeshData, Output, Scene, View, ViewState, Visible};
use cullet_bake::clusters::{ClusterOptions, build};
use cullet_draw::{Picture, RenderOptions, Selection, VolumeFigure};

use crate::args::{PictureArgs, PictureKind};
use crate::console::Console;
use crate::drawing;
use crate::exit::{Exit, Failure, Outcome};
use crate::inputs;

/// Runs the command.
pub(crate) fn run(args: &PictureArgs, console: &Console) -> Outcome {
    let mut model = inputs::load(&args.scene, console)?;
    inputs::begin(&mut model, &args.view, console)?;
    let views = inputs::views(&model, &args.view, console)?;
    if let Some(&seconds) = inputs::times(&args.view, views.len()).get(args.index as usize) {
        inputs::pose(&mut model, seconds)?;
    }
    let Some(view) = views.get(args.index as usize) else {
        let last = views.len().saturating_sub(1);
        return Err(Failure::usage(format!(
            "--view {}: the path's last view is {last}",
            args.index
        )));
    };
    let clustered = [PictureKind::CullingVolume, PictureKind::Clusters, PictureKind::Cones]
        .contains(&args.kind);
    if clustered {
        cluster(&mut model.scene)?;
    }
    let mut culler = inputs::culler(&args.cull);
    culler.output = Output::Triangles;
    culler.reasons = true;
    let scene = &model.scene;
    let colors = drawing::colors(&model);
    let options = RenderOptions { threads: args.view.threads, ..RenderOptions::default() };
    let picture: Picture = match args.kind {
        PictureKind::Kinds => cullet_draw::kinds(scene, view, &culler, args.view.size),
        PictureKind::Shaded => {
            let frame = cullet_draw::render(scene, view, Selection::All, &options);
            cullet_draw::shaded(scene, &frame, view, &colors)
        }
        PictureKind::Depth => {
            let options = RenderOptions { count_layers: true, ..options };
            let frame = cullet_draw::render(scene, view, Selection::All, &options);
            cullet_draw::depth_complexity(&frame, None)
        }
        PictureKind::Map => {
            let mut result = Visible::default();
            culler.cull_one(scene, view, &mut ViewState::default(), &mut result);
            let seen = cullet_draw::render(scene, view, Selection::All, &options).visible();
            cullet_draw::top_down(scene, view, &result, &seen, args.view.size)
        }
        PictureKind::NormalMask => {
            let half = args.view.fov.unwrap_or(20.0).to_radians() * 0.5;
            let cone = ViewCone::around(sight(view), half).ok_or_else(|| {
                Failure::usage(
                    "normal-mask: the lines of sight must spread by less than 180 degrees",
                )
            })?;
            cullet_draw::normal_mask(&cone, args.view.size)
        }
        PictureKind::NormalPartition => {
            cullet_draw::normal_partition(args.view.fov.unwrap_or(40.0) * 0.5, args.view.size)
        }
        PictureKind::ConservativeSet => {
            cullet_draw::conservative_set(args.view.fov.unwrap_or(90.0), args.view.size)
        }
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
        PictureKind::Clusters => cullet_draw::clusters(scene, view),
        PictureKind::Cones => cullet_draw::cones(scene, view),
        PictureKind::BackRegions => {
            let (picture, count) = cullet_draw::back_regions(scene, view);
            let noun = if count == 1 { "region" } else { "regions" };
            console.line(format!("{count} connected back-facing {noun}"));
            picture
        }
    };
    let out = args.out.clone().unwrap_or_else(|| format!("{}.png", args.kind.name()).into());
    std::fs::write(&out, picture.to_png()).map_err(|e| Failure::write(&out, &e))?;
    console.line(format!("{} written, {}x{}", out.display(), picture.width, picture.height));
    Ok(Exit::Fine)
}

/// Gives every mesh the clusters that are made for culling.
fn cluster(scene: &mut Scene) -> Result<(), Failure> {
    for (number, mesh) in scene.meshes_mut().enumerate() {
        let data = MeshData {
            positions: mesh.positions().to_vec(),
            indices: mesh.indices().to_vec(),
            parts: mesh.parts().to_vec(),
            polygons: mesh.polygon_count(),
            deformable: mesh.is_deformable(),
        };
        let failed = |e: String| Failure::input(format!("mesh {number}: {e}"));
        let clustering =
            build(&data, &ClusterOptions::default()).map_err(|e| failed(e.to_string()))?;
        *mesh = Mesh::with_clusters(data, &clustering).map_err(|e| failed(e.to_string()))?;
    }
    Ok(())
}

/// The direction of the line of sight in the middle; straight ahead where the view has none.
fn sight(view: &View) -> [f64; 3] {
    let middle = view.viewport().map(|v| f64::from(v) * 0.5);
    view.ray(middle).map_or([0.0, 0.0, -1.0], |ray| ray.direction)
}

fn volume(args: &PictureArgs, scene: &Scene) -> Result<(Picture, VolumeFigure), Failure> {
    let Some(first) = scene.slots().next() else {
        return Err(Failure::input("the scene has no instance, so no cluster"));
    };
    let draw = |slot| cullet_draw::culling_volume(scene, slot, args.cluster, args.view.size);
    let clusters = scene.mesh(first).clusters().len();
    let made = match args.cluster {
        Some(_) => draw(first),
        None => scene.slots().find_map(draw),
    };
    made.ok_or_else(|| match args.cluster {
        Some(n) if n as usize >= clusters => Failure::usage(format!(
            "--cluster {n}: the first mesh has {clusters} clusters, numbered from 0"
        )),
        Some(n) => Failure::usage(format!(
            "--cluster {n}: from no eye near it do all of its triangles face away; try another, or \
             none to take the widest that has a volume"
        )),
        None => Failure::input(
            "no cluster of the scene has a culling volume; for a two-sided mesh give --one-sided",
        ),
    })
}
