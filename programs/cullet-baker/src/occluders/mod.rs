//! `cullet occluders`: boxes and polygons that stand for each mesh in the occlusion buffer.

use std::path::PathBuf;
use std::time::Instant;

use crate::baked_occluders::of_meshes;
use clap::Args;
use cullet::math;
use cullet::{Instance, Mesh, Scene, View};
use cullet_bake::occluders::{OccluderOptions, Occluders, Validation, occluders, validate};
use cullet_command::args::{PictureViewArgs, SceneArgs};
use cullet_command::console::{Console, agree, count, grouped};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::{save_model, write_json};
use cullet_command::inputs;
use cullet_draw::{Picture, RenderOptions, Selection};
use cullet_io::{Material, Model, SaveErrorKind, SaveFormat};
use cullet_scenes::paths;
use serde::Serialize;

use cullet_cli::names::mesh_name;

/// End of `cullet occluders --help`.
pub const HELP: &str = "\
Makes boxes that lie within what each mesh seals off, and convex polygons that lie in its surface, so that
what they hide the mesh hides. A mesh has no box where nothing in it is closed (open shell), where its walls
are thinner than the cells of the grid (thin), where every box would hide too little (too little each), and
where it is transparent or deforms. A higher --resolution finds thinner walls. Where boxes and polygons leave much,
triangles of the mesh stand for themselves ('own').

'hides' is the share of the mesh's silhouette that its occluders cover, over a number of directions.
--check proves each box again without the grid, and tries each occluder with that many rays or points;
an occluder that is refuted or not proved makes the exit code 1. --compare tests what they find of all that is
truly hidden, beside the model's own occluders and all of its triangles.

Examples
  cullet occluders castle.glb
  cullet occluders castle.glb --picture occluders.png --out occluders.glb
  cullet occluders house.glb --resolution 128 --max-boxes 40 --min-gain 0.3
  cullet occluders castle.glb --compare --own castleLargeOccluders --own ground
  cullet occluders house.glb --check=256 --json -";

/// `cullet occluders`
#[derive(Debug, Args)]
pub struct OccludersArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Boxes for each mesh, at the most
    #[arg(long, value_name = "N", default_value_t = 16)]
    max_boxes: u32,
    /// Polygons for each mesh, at the most
    #[arg(long, value_name = "N", default_value_t = 16)]
    max_polygons: u32,
    /// Triangles of a mesh that stand for themselves, at the most
    #[arg(long, value_name = "N", default_value_t = 256)]
    max_own: u32,
    /// And for eyes near a mesh, for which its boxes do not serve, at the most
    #[arg(long, value_name = "N", default_value_t = 8192)]
    max_near: u32,
    /// Least gain of an occluder, in per cent of what its mesh hides
    #[arg(long, value_name = "PERCENT", default_value_t = 1.0)]
    min_gain: f64,
    /// Cells of the grid along the longest side of a mesh, 4 to 192
    #[arg(long, value_name = "N", default_value_t = 64)]
    resolution: u32,
    /// Prove each box again, and try each occluder with N rays or points
    #[arg(long, value_name = "N", num_args = 0..=1, default_missing_value = "64", require_equals = true)]
    check: Option<u32>,
    /// List every mesh, not only those that hide the most
    #[arg(long)]
    all: bool,
    /// Write the occluders, placed as the meshes are: .glb, .ply, .obj or .stl
    #[arg(long, short, value_name = "PATH", value_parser = cullet_command::parse::output)]
    out: Option<PathBuf>,
    /// Draw the occluders within the model
    #[arg(long, value_name = "PNG")]
    picture: Option<PathBuf>,
    #[command(flatten)]
    aim: PictureViewArgs,
    /// Write the figures as JSON; - is the standard output
    #[arg(long, value_name = "PATH", value_parser = cullet_command::parse::output)]
    pub json: Option<PathBuf>,
    #[command(flatten)]
    compare: CompareArgs,
}

/// Arguments of `cullet occluders --compare`.
#[derive(Debug, Args)]
#[command(next_help_heading = "Comparison: cullet occluders --compare")]
pub struct CompareArgs {
    /// Test from 32 views of --size pixels whether 20000 random boxes are hidden, by these
    /// occluders and by all triangles, and hold the results against what samples of the model's
    /// triangles see
    #[arg(long)]
    pub compare: bool,
    /// Also by the model's own occluders: the instances that cullet occscn --occluders NAME takes,
    /// which says where the boxes and views are too; may be given several times
    #[arg(long, value_name = "NAME", requires = "compare")]
    pub own: Vec<String>,
    /// Draw what is truly hidden at N x N samples a pixel
    #[arg(long, value_name = "N", default_value_t = 1, requires = "compare", value_parser = clap::value_parser!(u32).range(1..=16))]
    pub reference: u32,
}

/// Result of a comparison.
#[derive(Debug)]
pub struct Compared {
    /// Its figures, for the JSON.
    pub record: serde_json::Value,
    /// Whether a box that is seen was culled.
    pub is_wrong: bool,
}

/// Compares a model's baked occluders with others: of `cullet-lab`.
pub type Compare =
    fn(&CompareArgs, [u32; 2], &mut Model, &[Occluders], &Console) -> Result<Compared, Failure>;

impl OccludersArgs {
    /// Whether they are to be compared with others.
    #[must_use]
    pub fn compares(&self) -> bool {
        self.compare.compare
    }
}

/// Result for one mesh.
#[derive(Debug, Serialize)]
struct MeshOccluders {
    mesh: u32,
    name: String,
    instances: u64,
    triangles: u64,
    boxes: u64,
    polygons: u64,
    /// Triangles of its own that are occluders.
    own: u64,
    /// The share of its silhouette, 0 to 1.
    hides: f64,
    /// The mean area of its silhouette, in squared units of the mesh.
    silhouette: f64,
    no_boxes: Option<String>,
    no_polygons: Option<String>,
    shells: u32,
    skipped_shells: u32,
    seconds: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    proved: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    refuted: Option<Vec<String>>,
}

/// Result for a model.
#[derive(Debug, Serialize)]
struct OccludersRecord {
    schema: u32,
    scene: String,
    resolution: u32,
    boxes: u64,
    polygons: u64,
    own: u64,
    meshes_with_occluders: u64,
    /// The share of all silhouettes, each mesh once.
    hides: f64,
    seconds: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    comparison: Option<serde_json::Value>,
    meshes: Vec<MeshOccluders>,
}

/// Runs the command; `compare` does the work of `--compare`.
///
/// # Errors
/// What the user is to be told, with the exit code.
pub fn run(args: &OccludersArgs, compare: Option<Compare>, console: &Console) -> Outcome {
    // Known before minutes of work are done.
    if let Some(out) = args.out.as_deref().filter(|p| SaveFormat::of(p).is_none()) {
        let kind = SaveErrorKind::Unsupported;
        return Err(Failure::usage(format!("{}: {kind}", out.display())));
    }
    let options = OccluderOptions {
        max_boxes: args.max_boxes,
        max_polygons: args.max_polygons,
        max_triangles: args.max_own,
        max_near: args.max_near,
        min_gain: args.min_gain / 100.0,
        resolution: args.resolution,
        ..OccluderOptions::default()
    };
    if !(0.0..=100.0).contains(&args.min_gain) {
        let given = args.min_gain;
        return Err(Failure::usage(format!(
            "--min-gain {given}: not within 0 to 100 per cent; try 1"
        )));
    }
    occluders(&empty()?, &options).map_err(|e| Failure::usage(format!("--resolution: {e}")))?;
    let mut model = inputs::load(&args.scene, console)?;
    let (mut record, made) = make(args, &options, &model, console)?;
    print(args, &record, console);
    let mut wrong = false;
    if let Some(compare) = compare.filter(|_| args.compares()) {
        let compared = compare(&args.compare, args.aim.size, &mut model, &made, console)?;
        wrong = compared.is_wrong;
        record.comparison = Some(compared.record);
    }
    let placed = Placed::new(&model, &made)?;
    if let Some(path) = &args.out {
        if placed.model.scene.instance_count() == 0 {
            return Err(Failure::input(format!(
                "{}: no mesh has an occluder to write",
                model.name
            )));
        }
        save_model(&placed.model, path, console)?;
        console.line(format!("{} written", path.display()));
    }
    if let Some(path) = &args.picture {
        let picture = draw(args, &model, &placed.model)?;
        std::fs::write(path, picture.to_png()).map_err(|e| Failure::write(path, &e))?;
        let (w, h) = (picture.width, picture.height);
        console.line(format!("{} written, {w}x{h}", path.display()));
    }
    if let Some(path) = &args.json {
        write_json(path, &record)?;
    }
    let refuted = |m: &MeshOccluders| m.refuted.as_ref().is_some_and(|r| !r.is_empty());
    Ok(if wrong || record.meshes.iter().any(refuted) { Exit::FalseCull } else { Exit::Fine })
}

/// A mesh to check whether options are in range.
fn empty() -> Result<Mesh, Failure> {
    Mesh::new(cullet::MeshData::default()).map_err(Failure::input)
}

fn make(
    args: &OccludersArgs,
    options: &OccluderOptions,
    model: &Model,
    console: &Console,
) -> Result<(OccludersRecord, Vec<Occluders>), Failure> {
    let scene = &model.scene;
    let start = Instant::now();
    let mut instances = vec![0u64; scene.meshes().len()];
    scene.slots().for_each(|s| instances[scene.mesh_id(s) as usize] += 1);
    let found = of_meshes(scene.meshes(), console, |mesh| {
        let began = Instant::now();
        let (made, report) = occluders(mesh, options).map_err(Failure::usage)?;
        let seconds = began.elapsed().as_secs_f64();
        let validation = args.check.map(|samples| validate(mesh, &made, samples));
        Ok((made, report, seconds, validation))
    })?;
    let (mut meshes, mut all) = (Vec::new(), Vec::new());
    let mut sums = [0.0; 2];
    for ((mesh, i), found) in scene.meshes().iter().zip(0u32..).zip(found) {
        let (made, report, seconds, validation) = found;
        let [hidden, whole] =
            report.hidden.iter().fold([0.0; 2], |[a, b], h| [a + h.occluders, b + h.mesh]);
        sums = [sums[0] + hidden, sums[1] + whole];
        meshes.push(MeshOccluders {
            mesh: i,
            name: mesh_name(model, i),
            instances: instances[i as usize],
            triangles: u64::from(mesh.triangle_count()),
            boxes: made.boxes.len() as u64,
            polygons: made.polygons.len() as u64,
            own: made.own_triangles(),
            hides: report.efficiency(),
            silhouette: whole / report.hidden.len().max(1) as f64,
            no_boxes: report.no_boxes.map(|r| r.to_string()),
            no_polygons: report.no_polygons.map(|r| r.to_string()),
            shells: report.shells,
            skipped_shells: report.skipped_shells,
            seconds,
            proved: validation.as_ref().map(|v| v.proved_boxes),
            refuted: validation.as_ref().map(refutations),
        });
        all.push(made);
    }
    let record = OccludersRecord {
        schema: 1,
        scene: model.name.clone(),
        resolution: options.resolution,
        boxes: meshes.iter().map(|m| m.boxes).sum(),
        polygons: meshes.iter().map(|m| m.polygons).sum(),
        own: meshes.iter().map(|m| m.own).sum(),
        meshes_with_occluders: all.iter().filter(|m: &&Occluders| !m.is_empty()).count() as u64,
        hides: if sums[1] > 0.0 { sums[0] / sums[1] } else { 0.0 },
        seconds: start.elapsed().as_secs_f64(),
        comparison: None,
        meshes,
    };
    Ok((record, all))
}

fn refutations(found: &Validation) -> Vec<String> {
    let unproved = found.unproved_boxes.iter().map(|b| format!("box {b} is not proved"));
    unproved.chain(found.escapes.iter().map(|e| format!("{e:?}"))).collect()
}

fn print(args: &OccludersArgs, record: &OccludersRecord, console: &Console) {
    /// Meshes that are listed where not all are wanted.
    const SHOWN: usize = 24;
    let mut order: Vec<&MeshOccluders> = record.meshes.iter().collect();
    order.sort_by(|a, b| b.silhouette.total_cmp(&a.silhouette).then(a.mesh.cmp(&b.mesh)));
    let shown = if args.all { order.len() } else { SHOWN.min(order.len()) };
    console.line(format!(
        "{:<32} {:>9} {:>9} {:>6} {:>8} {:>5} {:>6}  without",
        "mesh, widest first", "instances", "triangles", "boxes", "polygons", "own", "hides"
    ));
    for m in &order[..shown] {
        let why = match (&m.no_boxes, &m.no_polygons) {
            // Its own triangles stand for both.
            (Some(a), _) if m.own > 0 => format!("boxes: {a}"),
            (Some(a), Some(b)) if a == b => a.clone(),
            (Some(a), Some(b)) => format!("boxes: {a}; polygons: {b}"),
            (Some(a), None) => format!("boxes: {a}"),
            // Polygons are made only where no box hides what they would.
            (None, _) => String::new(),
        };
        let mut name: String = m.name.chars().take(32).collect();
        if name.len() < m.name.len() {
            name.pop();
            name.push('…');
        }
        let line = format!(
            "{name:<32} {:>9} {:>9} {:>6} {:>8} {:>5} {:>4.0} %  {why}",
            grouped(m.instances),
            grouped(m.triangles),
            m.boxes,
            m.polygons,
            m.own,
            m.hides * 100.0
        );
        console.line(line.trim_end());
        for r in m.refuted.iter().flatten() {
            console.line(format!("    refuted: {r}"));
        }
    }
    if shown < order.len() {
        console
            .line(format!("and {} more; --all lists them", grouped((order.len() - shown) as u64)));
    }
    console.line(format!(
        "{} of {} {} occluders: {}, {}, {} of their own, which hide \
         {:.0} % of their silhouettes; {:.1} s",
        grouped(record.meshes_with_occluders),
        count(record.meshes.len() as u64, "mesh", "meshes"),
        agree(record.meshes_with_occluders, "has", "have"),
        count(record.boxes, "box", "boxes"),
        count(record.polygons, "polygon", "polygons"),
        count(record.own, "triangle", "triangles"),
        record.hides * 100.0,
        record.seconds
    ));
    if args.check.is_some() {
        let proved: u32 = record.meshes.iter().filter_map(|m| m.proved).sum();
        let refuted: usize = record.meshes.iter().flat_map(|m| &m.refuted).map(Vec::len).sum();
        console.line(format!(
            "checked: {} of {} proved, {} refuted or not proved",
            grouped(u64::from(proved)),
            count(record.boxes, "box", "boxes"),
            count(refuted as u64, "occluder", "occluders")
        ));
    }
}

/// The occluders of a model, placed as its meshes are.
struct Placed {
    model: Model,
}

/// Linear colours of boxes and polygons.
const COLORS: [(&str, [f32; 4]); 2] =
    [("box", [0.90, 0.22, 0.03, 1.0]), ("polygon", [0.02, 0.30, 0.75, 1.0])];

impl Placed {
    fn new(model: &Model, made: &[Occluders]) -> Result<Self, Failure> {
        let materials = COLORS.map(|(name, color)| Material { name: name.into(), color });
        let mut out = Model {
            name: format!("{}, occluders", model.name),
            materials: materials.to_vec(),
            ..Model::default()
        };
        out.scene = Scene::new();
        out.scene.rebase(model.scene.origin());
        let mut ids = vec![None; made.len()];
        for slot in model.scene.slots() {
            let number = model.scene.mesh_id(slot) as usize;
            if made[number].is_empty() {
                continue;
            }
            let id = match ids[number] {
                Some(id) => id,
                None => {
                    let mesh = Mesh::new(made[number].to_data(0, 1)).map_err(Failure::input)?;
                    out.mesh_names.push(mesh_name(model, number as u32));
                    *ids[number].insert(out.scene.add_mesh(mesh))
                }
            };
            let instance = Instance::new(id, *model.scene.transform(slot));
            out.scene.add(instance).map_err(Failure::input)?;
        }
        out.scene.commit(&cullet::Culler::default());
        Ok(Self { model: out })
    }
}

/// The vertical field of view of the picture.
const FOV_DEGREES: f64 = 40.0;

/// The model as a pale ghost, and its occluders through it.
fn draw(args: &OccludersArgs, model: &Model, placed: &Model) -> Result<Picture, Failure> {
    let overrides =
        paths::Overrides { fov_degrees: Some(FOV_DEGREES), ..paths::Overrides::default() };
    let [eye, target] = args.aim.line().map_or_else(|| stand(model), |(e, t)| [e, t]);
    let camera =
        paths::look_at(model, eye, target, args.aim.size, &overrides).map_err(Failure::usage)?;
    let view = View::new(&camera, overrides.depth, args.aim.size).map_err(Failure::usage)?;
    let options = RenderOptions { scale: 2, ..RenderOptions::default() };
    let shot = |m: &Model| {
        let frame = cullet_draw::render(&m.scene, &view, Selection::All, &options);
        let picture = cullet_draw::shaded(&m.scene, &frame, &view, &inputs::colors(m));
        (frame, picture)
    };
    let (_, mut picture) = shot(model);
    let (frame, proxies) = shot(placed);
    for (at, id) in frame.ids.iter().enumerate() {
        let drawn = *id != cullet_draw::PixelId::NONE;
        for c in at * 3..at * 3 + 3 {
            let ghost = f32::from(picture.rgb[c]) * 0.55 + 255.0 * 0.45;
            let mixed = if drawn { ghost * 0.25 + f32::from(proxies.rgb[c]) * 0.75 } else { ghost };
            picture.rgb[c] = mixed.round() as u8;
        }
    }
    Ok(picture.halved())
}

/// From above and to the side, so far that all is in sight.
fn stand(model: &Model) -> [[f64; 3]; 2] {
    let extent = model.scene.extent();
    let (middle, half) = (extent.center(), extent.half_extent());
    let origin = model.scene.origin();
    let radius = half.iter().map(|h| h * h).sum::<f64>().sqrt().max(1e-6);
    // The ball around a box is mostly air, and scenes are wider than high.
    let away = 0.62 * radius / math::sin((FOV_DEGREES * 0.5).to_radians());
    let target =
        [0, 1, 2].map(|a| if extent.is_empty() { origin[a] } else { middle[a] + origin[a] });
    // A direction of length 1, near enough.
    let towards = [0.48, 0.46, 0.75];
    [[0, 1, 2].map(|a| target[a] + towards[a] * away), target]
}
