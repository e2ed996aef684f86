//! "Size dependent mesh reduction", the slide that lectures on levels of detail show: one model
//! drawn smaller and smaller, of fewer and fewer triangles. Beside the counts, which the slide has,
//! how far each is off, which it has not.

use std::path::PathBuf;

use clap::Args;
use cullet::lod::Lod;
use cullet::{Camera, Culler, Depth, Output, Projection, Scene, Stage, View, ViewState, Visible};
use cullet_command::args::SceneArgs;
use cullet_command::console::{Console, count, grouped, interrupted, percent};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::write_json;
use cullet_command::{inputs, parse};
use cullet_draw::picture::text_width;
use cullet_draw::{Picture, RenderOptions, Selection, palette};
use cullet_io::Model;
use glam::DVec3;
use serde::Serialize;

use cullet_cli::levels::{Wanted, load_with};
use cullet_draw::{Measured, Meter};

pub(super) const HELP: &str = "\
The model is drawn at several sizes, as an eye sees it that goes away from it: pixels of 1080 lines over 60 degrees. At
each, levels of detail are chosen that may be off by --pixels, and it is measured how far they are, from points that took no
part in making them, both ways. Lower in the picture is what is drawn, as large as the first, so that one sees it.

Writes mesh-reduction.png and mesh-reduction.json into --out. Levels of a scene without some are made by the baker, once.
Ends with exit code 1 where the threshold is not kept: by 99.9 % of the points, and by all of them to 1.2 of it.

Examples
  cullet reproduce mesh-reduction                            a built-in solid
  cullet reproduce mesh-reduction --model armadillo.obj      the lecture's own model
  cullet reproduce mesh-reduction --model armadillo.obj --pixels 4 --sizes 400,200,100,50,25
  cullet reproduce mesh-reduction --json - | jq .rows";

/// `cullet reproduce mesh-reduction`
#[derive(Debug, Args)]
pub(crate) struct MeshReductionArgs {
    /// A file, or a built-in scene, in place of the built-in solid
    #[arg(long, value_name = "SCENE", default_value = "knobs")]
    model: String,
    /// How many pixels the sphere around the model is across, one for each picture
    #[arg(long, value_name = "PX,...", value_delimiter = ',', default_values_t = [400, 200, 100, 50, 25], value_parser = clap::value_parser!(u32).range(2..=1080))]
    sizes: Vec<u32>,
    /// Pixels by which what is drawn may be off
    #[arg(long, value_name = "PX", default_value_t = 1.0, value_parser = parse::lod_pixels, allow_hyphen_values = true)]
    pixels: f64,
    /// From where the model is seen: a direction from its middle
    #[arg(long, value_name = "X,Y,Z", value_parser = parse::point, allow_hyphen_values = true, default_value = "0.5,0.2,1")]
    from: [f64; 3],
    /// Random points from which each is measured, each way
    #[arg(long, value_name = "N", default_value_t = 400_000, value_parser = clap::value_parser!(u32).range(1000..=100_000_000))]
    points: u32,
    /// Folder to write into
    #[arg(long, value_name = "DIR", default_value = "reproduce")]
    out: PathBuf,
    /// Also write the results here; - is the standard output
    #[arg(long, value_name = "PATH")]
    pub(super) json: Option<PathBuf>,
}

/// The results.
#[derive(Debug, Serialize)]
struct Record {
    schema: u32,
    model: String,
    triangles: u64,
    threshold_px: f64,
    rows: Vec<Row>,
    /// Whether all was done.
    complete: bool,
}

/// The model at one size.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Row {
    /// Pixels across the sphere around it.
    size_px: u32,
    /// How far the eye is from its middle, in radii of that sphere.
    distance_radii: f64,
    triangles: u64,
    /// Measured deviation.
    max_px: f64,
    p999_px: f64,
    points: u64,
    kept: bool,
}

/// Lines of the image whose pixels are counted, and the tangent of half of its angle.
const LINES: f64 = 1080.0;
const HALF: f64 = 0.577_350_269_189_625_8;
/// More of a picture than the sphere.
const ROOM: f64 = 1.06;
/// Between pictures, and around them.
const GAP: u32 = 24;
/// Pixels of an em of the words.
const EM: f64 = 20.0;

/// Runs the command.
pub(super) fn run(args: &MeshReductionArgs, console: &Console) -> Outcome {
    if DVec3::from(args.from).try_normalize().is_none() {
        return Err(Failure::usage("--from 0,0,0 is no direction; try 0.5,0.2,1"));
    }
    let model = load_with(&SceneArgs::of(&args.model), Wanted::Levels, console)?;
    std::fs::create_dir_all(&args.out).map_err(|e| Failure::write(&args.out, &e))?;
    let (record, shown) = measure(args, &model, console)?;
    print(&record, console);
    let picture = picture(&record, &shown);
    let file = args.out.join("mesh-reduction.png");
    std::fs::write(&file, picture.to_png()).map_err(|e| Failure::write(&file, &e))?;
    write_json(&args.out.join("mesh-reduction.json"), &record)?;
    if let Some(path) = &args.json {
        write_json(path, &record)?;
    }
    console.line(format!("\nThe row is in {}, with the figures beside it.", file.display()));
    Ok(match (record.rows.iter().all(|row| row.kept), record.complete) {
        (false, _) => Exit::FalseCull,
        (true, false) => Exit::Interrupted,
        (true, true) => Exit::Fine,
    })
}

/// All places of vertices, in the world.
fn places(scene: &Scene) -> impl Iterator<Item = DVec3> {
    scene.slots().flat_map(|slot| {
        let transform = scene.transform(slot);
        let [x, y, z] = transform.linear.map(|c| DVec3::from(c.map(f64::from)));
        let to = DVec3::from(transform.translation);
        let place = move |p: &[f32; 3]| {
            let [a, b, c] = p.map(f64::from);
            x * a + y * b + z * c + to
        };
        scene.mesh(slot).positions().iter().map(place)
    })
}

/// Around all of a scene: middle and radius. None where it has no size.
fn sphere(scene: &Scene) -> Option<(DVec3, f64)> {
    let first = places(scene).next()?;
    let (low, high) =
        places(scene).fold((first, first), |(low, high), p| (low.min(p), high.max(p)));
    let middle = (low + high) * 0.5;
    let radius = places(scene).map(|p| (p - middle).length()).fold(0.0, f64::max);
    (radius > 0.0 && radius.is_finite()).then_some((middle, radius))
}

/// The model so large, in a picture with a little room around it: the view, and how many radii the
/// eye is away.
fn view((middle, radius): (DVec3, f64), from: [f64; 3], size: u32) -> Result<(View, f64), Failure> {
    // The lines of sight that touch the sphere.
    let tangent = f64::from(size) / LINES * HALF;
    let away = 1.0 / tangent.atan().sin();
    let eye = middle + DVec3::from(from).normalize() * (radius * away);
    let side = (f64::from(size) * ROOM).ceil() as u32;
    // The middle of the larger image: its pixels are as large as those.
    let projection = Projection::Perspective {
        fov_y_radians: 2.0 * (f64::from(side) / LINES * HALF).atan(),
        aspect: 1.0,
        near: radius * (away - 1.0).max(away * 1e-3) * 0.5,
        far: f64::INFINITY,
    };
    let camera = Camera::look_at(eye, middle, projection);
    let view = View::new(&camera, Depth::Reversed, [side, side]).map_err(Failure::input)?;
    Ok((view, away))
}

/// Measures each size; and draws it, as it is and as large as the first.
fn measure(
    args: &MeshReductionArgs,
    model: &Model,
    console: &Console,
) -> Result<(Record, Vec<[Picture; 2]>), Failure> {
    let scene = &model.scene;
    let around = sphere(scene).ok_or_else(|| {
        Failure::input(format!("{}: it has no size, so it has none in pixels either", model.name))
    })?;
    let lod = Lod::default().with_pixels(args.pixels);
    let culler = Culler::default().with_lod(lod).with_output(Output::Triangles).only(Stage::Lod);
    let meter = Meter { points: args.points as usize, seed: 1 };
    let colors = inputs::colors(model);
    let large = args.sizes.iter().copied().max().unwrap_or(2);
    let (near, _) = view(around, args.from, large)?;
    let draw = |view: &View, cut: &Visible| {
        let options = RenderOptions { scale: 2, ..RenderOptions::default() };
        let frame = cullet_draw::render(scene, view, Selection::Visible(cut), &options);
        cullet_draw::shaded_clear(scene, &frame, view, cut, &colors).halved()
    };
    let (mut rows, mut shown) = (Vec::new(), Vec::new());
    let mut progress = console.progress("sizes", args.sizes.len() as u64);
    for &size_px in &args.sizes {
        if interrupted() {
            break;
        }
        let (view, distance_radii) = view(around, args.from, size_px)?;
        let mut cut = Visible::default();
        culler.cull_one(scene, &view, &mut ViewState::default(), &mut cut);
        let found = meter.measure(scene, &view, &lod, &cut, &cut);
        let Measured { max_px, p999_px, points, .. } = found;
        rows.push(Row {
            size_px,
            distance_radii,
            triangles: cut.triangle_count,
            max_px,
            p999_px,
            points,
            kept: found.keeps(args.pixels),
        });
        shown.push([draw(&view, &cut), draw(&near, &cut)]);
        progress.step();
    }
    progress.finish();
    let record = Record {
        schema: 1,
        model: model.name.clone(),
        triangles: scene.triangle_count(),
        threshold_px: args.pixels,
        complete: rows.len() == args.sizes.len(),
        rows,
    };
    Ok((record, shown))
}

fn print(record: &Record, console: &Console) {
    console.line(format!(
        "Size dependent mesh reduction: {}, {}; off by at most {} px",
        record.model,
        count(record.triangles, "triangle", "triangles"),
        record.threshold_px
    ));
    console.line(
        "\n  across    distance    triangles                off, 99.9 %      all    \n      px       radii        drawn     share                px       px",
    );
    for row in &record.rows {
        console.line(format!(
            "{:>8} {:>11.1} {:>12} {:>9} {:>17.3} {:>8.3}   {}",
            row.size_px,
            row.distance_radii,
            grouped(row.triangles),
            percent(row.triangles, record.triangles),
            row.p999_px,
            row.max_px,
            if row.kept { "kept" } else { "NOT KEPT" }
        ));
    }
}

/// The row: each at its size on one ground, below it what is drawn as large as the first, and the
/// figures.
fn picture(record: &Record, shown: &[[Picture; 2]]) -> Picture {
    let wide = shown.iter().flatten().map(|p| p.width).max().unwrap_or(0).max(220);
    let high = |row: usize| shown.iter().map(|p| p[row].height).max().unwrap_or(0);
    let (line, left) = ((EM * 1.5) as u32, |at: usize| GAP + at as u32 * (wide + GAP));
    let words = [GAP + high(0) + GAP / 2, GAP + high(0) + 4 * line + GAP];
    let size = [left(shown.len()), words[1] + high(1) + GAP];
    let mut all = Picture::new(size[0], size[1], palette::PAPER);
    for (at, (row, [small, large])) in record.rows.iter().zip(shown).enumerate() {
        let x = left(at);
        place(&mut all, small, [x + (wide - small.width) / 2, GAP + high(0) - small.height]);
        place(&mut all, large, [x + (wide - large.width) / 2, words[1]]);
        // The font of pictures has no narrow space.
        let n = grouped(row.triangles).replace('\u{202f}', ",");
        let lines = [
            format!("{n} triangles"),
            format!("{} px across, off by", row.size_px),
            format!("{:.2} px (99.9 %), {:.2} px (all)", row.p999_px, row.max_px),
        ];
        for (number, text) in (0..).zip(&lines) {
            let from = i64::from(x) + (i64::from(wide) - text_width(text, EM)) / 2;
            let y = i64::from(words[0] + number * line);
            all.text([from, y], text, EM, palette::INK);
        }
    }
    all
}

/// Copies a picture into a larger one.
fn place(all: &mut Picture, part: &Picture, [x, y]: [u32; 2]) {
    for row in 0..part.height {
        let wide = part.width as usize * 3;
        let from = row as usize * wide;
        let to = ((y + row) as usize * all.width as usize + x as usize) * 3;
        all.rgb[to..to + wide].copy_from_slice(&part.rgb[from..from + wide]);
    }
}

#[cfg(test)]
mod tests {
    use cullet::{Instance, Transform};
    use cullet_testkit::steps::Balls;

    use super::*;

    fn args(words: &str) -> MeshReductionArgs {
        let words = std::iter::once("test").chain(words.split_whitespace());
        let command = MeshReductionArgs::augment_args(clap::Command::new("test"));
        let found = command.try_get_matches_from(words).unwrap();
        clap::FromArgMatches::from_arg_matches(&found).unwrap()
    }

    fn balls(honesty: f64) -> Model {
        let mut scene = Scene::new();
        let mesh = Balls::new(&[64, 32, 16, 8, 4], honesty).add_to(&mut scene);
        scene.add(Instance::new(mesh, Transform::from_translation([50.0, 0.0, 7.0]))).unwrap();
        scene.commit(&Culler::default());
        Model { scene, ..Model::default() }
    }

    #[test]
    fn smaller_ones_have_fewer_triangles_and_keep_the_threshold() {
        let args = args("--sizes 200,50,12 --points 5000");
        let console = Console::new(true, None);
        let (record, shown) = measure(&args, &balls(1.0), &console).unwrap();
        assert!(record.complete && record.rows.len() == 3 && shown.len() == 3);
        assert!(record.rows.is_sorted_by(|a, b| a.triangles > b.triangles), "{record:?}");
        assert!(record.rows.iter().all(|row| row.kept && row.max_px > 0.05), "{record:?}");
        // A ball of radius 1: its sphere is as large in pixels as was said.
        for (row, [small, large]) in record.rows.iter().zip(&shown) {
            let middle = small.height / 2;
            let ground = small.pixel(0, 0);
            let is_ball = |x: &u32| {
                let pixel = small.pixel(*x, middle);
                (0..3).any(|k| pixel[k].abs_diff(ground[k]) > 24)
            };
            let across = (0..small.width).filter(is_ball).count() as u32;
            assert!(across.abs_diff(row.size_px) <= 3, "{across} of {}", row.size_px);
            assert_eq!(large.width, shown[0][0].width);
        }
        let all = picture(&record, &shown);
        assert!(all.width > 3 * 200 && all.height > 2 * 200);
    }

    #[test]
    fn levels_that_state_less_than_they_are_off_are_found_out() {
        let args = args("--sizes 60 --points 5000");
        let (record, _) = measure(&args, &balls(0.2), &Console::new(true, None)).unwrap();
        assert!(!record.rows[0].kept && record.rows[0].max_px > 1.2, "{record:?}");
    }

    #[test]
    fn a_model_without_size_is_refused() {
        let args = args("--sizes 60");
        let empty = Model { scene: Scene::new(), name: "none".to_owned(), ..Model::default() };
        let refused = measure(&args, &empty, &Console::new(true, None)).unwrap_err();
        assert!(refused.message.contains("none: it has no size"), "{}", refused.message);
    }
}
