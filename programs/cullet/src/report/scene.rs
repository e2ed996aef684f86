//! The report of a scene: its views one after the other, and what is written as they are done.

use std::fmt::Write as _;
use std::fs::File;
use std::io::Write as _;
use std::time::{Duration, Instant};

use cullet::View;
use cullet_command::console::{Console, grouped, interrupted};
use cullet_command::exit::{Exit, Failure};
use cullet_command::files::replace;
use cullet_command::html::data_uri;
use cullet_command::inputs;
use cullet_draw::VerifyOptions;
use cullet_io::Model;
use serde_json::Value;

use super::args::ReportArgs;
use super::export::Export;
use super::opened::Opened;
use super::page::{Gallery, Image};
use super::record::{LevelsCost, Record, Settings};
use super::saved::{Origin, TriangleCosts};
use super::{advice, baseline, drawing, page};
use crate::levels;
use crate::meshes;
use crate::record::{MeshRecord, SCHEMA, Summary, ViewRecord};
use crate::survey::{Seen, Survey};

/// Above this a view takes so long to draw that only some are verified.
const MOST_TRIANGLES_VERIFIED: u64 = 50_000_000;
/// More pictures than this make the folder and the page heavy.
const MOST_PICTURES: usize = 16;
/// While views are being done, the page is written again no oftener than this.
const REWRITE: Duration = Duration::from_secs(3);

/// Reports on a scene, into its folder.
pub(super) fn of_scene(
    args: &ReportArgs,
    baseline: Option<&Value>,
    console: &Console,
) -> Result<Record, Failure> {
    let costs = Origin::find(&args.costs, console)?;
    let mut model = levels::load(&args.input.scene, &args.input.cull, console)?;
    inputs::give_occluders(&mut model, &args.input.cull, console)?;
    inputs::begin(&mut model, &args.input.view, console)?;
    let views = inputs::culled_views(&model, &args.input.view, &args.input.cull, console)?;
    let triangle_costs = costs.map(|origin| TriangleCosts::new(origin, &model.scene));
    let opened = Opened::new(&args.opened, &model.scene, console)?;
    std::fs::create_dir_all(&args.out).map_err(|e| Failure::write(&args.out, &e))?;
    let facts = meshes::facts(&model);
    let mut report = Report::new(args, model, facts, baseline, triangle_costs, console)?;
    report.opened = opened;
    report.survey.move_over(inputs::times(&args.input.view, views.len()));
    let mut progress = console.progress("views", views.len() as u64);
    for view in &views {
        report.add(view, views.len())?;
        progress.step();
        if interrupted() {
            break;
        }
    }
    progress.finish();
    let complete = report.survey.views.len() == views.len();
    report.finish(complete)
}

struct Report<'a> {
    args: &'a ReportArgs,
    survey: Survey,
    facts: Vec<MeshRecord>,
    baseline: Option<&'a Value>,
    triangle_costs: Option<TriangleCosts>,
    gallery: Gallery,
    opened: Option<Opened>,
    csv: File,
    export: Option<Export>,
    verify_time: Duration,
    verify_last: Duration,
    written: Option<Instant>,
}

impl<'a> Report<'a> {
    fn new(
        args: &'a ReportArgs,
        model: Model,
        facts: Vec<MeshRecord>,
        baseline: Option<&'a Value>,
        triangle_costs: Option<TriangleCosts>,
        console: &Console,
    ) -> Result<Self, Failure> {
        let options = VerifyOptions {
            samples: args.samples,
            seed: args.input.view.seed,
            threads: args.input.view.threads,
            count_layers: true,
        };
        let mut survey = Survey::new(model, inputs::culler(&args.input.cull), options);
        survey.compare_bounds();
        survey.count_backfaces();
        let path = args.out.join("views.csv");
        let fail = |e: std::io::Error| Failure::write(&path, &e);
        let mut csv = File::create(&path).map_err(fail)?;
        writeln!(csv, "{CSV_HEAD}").map_err(fail)?;
        let export =
            args.export.as_deref().map(|p| Export::create(p, &survey.model)).transpose()?;
        let triangles = survey.model.scene.triangle_count();
        if triangles > MOST_TRIANGLES_VERIFIED {
            console.note(format!(
                "{} triangles per view: verifying as many views as fit {} s (--verify-seconds)",
                grouped(triangles),
                args.verify_seconds
            ));
        }
        Ok(Self {
            args,
            survey,
            facts,
            baseline,
            triangle_costs,
            gallery: Gallery::default(),
            opened: None,
            csv,
            export,
            verify_time: Duration::ZERO,
            verify_last: Duration::ZERO,
            written: None,
        })
    }

    /// Whether the next view is verified: always, but for scenes so large that time must be shared
    /// out.
    fn verifies(&self) -> bool {
        if self.survey.model.scene.triangle_count() <= MOST_TRIANGLES_VERIFIED {
            return true;
        }
        let budget = Duration::from_secs_f64(self.args.verify_seconds.min(1e9));
        // The next view is expected to take as long as the last one did.
        budget > Duration::ZERO && self.verify_time + self.verify_last <= budget
    }

    fn add(&mut self, view: &View, views: usize) -> Result<(), Failure> {
        let index = self.survey.views.len();
        let verify = self.verifies();
        let start = Instant::now();
        let seen = self.survey.add(view, verify)?;
        if verify {
            self.verify_last = start.elapsed();
            self.verify_time += self.verify_last;
        }
        if index.is_multiple_of(views.div_ceil(MOST_PICTURES)) {
            self.pictures(index, view, &seen)?;
        }
        if let Some(export) = &mut self.export {
            export.add(&self.survey.model, view, &seen.result)?;
        }
        let row = csv_row(&self.survey.views[index]);
        let path = self.args.out.join("views.csv");
        writeln!(self.csv, "{row}").map_err(|e| Failure::write(&path, &e))?;
        if self.written.is_none_or(|at| at.elapsed() > REWRITE) {
            // Not yet complete: whatever ends the run now, the report on disk is valid.
            self.write(false)?;
            self.written = Some(Instant::now());
        }
        Ok(())
    }

    fn pictures(&mut self, index: usize, view: &View, seen: &Seen) -> Result<(), Failure> {
        let featured = self.gallery.large.is_empty();
        let Survey { model, state, full_state, .. } = &self.survey;
        let state = if seen.full.is_some() { full_state } else { state };
        let mut pictures = drawing::of_view(model, view, state, seen, featured, &self.args.show);
        let opened = self.opened.as_ref().filter(|_| featured);
        pictures.extend(opened.map(|o| o.picture(&model.scene, view, seen.in_full())));
        for p in pictures {
            let file = format!("view-{index:03}-{}.png", p.name);
            let path = self.args.out.join(&file);
            let png = p.picture.to_png();
            std::fs::write(&path, &png).map_err(|e| Failure::write(&path, &e))?;
            let embed = |most: u32, caption: String, wide: bool| {
                let small = p.picture.shrunk(most);
                let same = small.width == p.picture.width;
                Image {
                    file: file.clone(),
                    data: if same { data_uri(&png) } else { data_uri(&small.to_png()) },
                    size: [small.width, small.height],
                    caption,
                    wide,
                }
            };
            if featured {
                self.gallery.featured = index;
                self.gallery.large.push(embed(p.embed_px, p.caption.clone(), p.wide));
            }
            if p.thumbnail {
                self.gallery.thumbs.push(embed(320, format!("view {index}"), false));
            }
        }
        Ok(())
    }

    fn record(&self, complete: bool) -> Record {
        let views = self.survey.views.clone();
        let mut summary = Summary::of(&views);
        let meshes = meshes::with_tallies(&self.facts, &self.survey.meshes);
        let size = self.args.input.view.size;
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        summary.advice = advice::advise(
            &self.survey,
            &summary,
            &meshes,
            pixels,
            self.args.tiny,
            self.triangle_costs.as_ref().map(TriangleCosts::drawn_ns),
        );
        Record {
            schema: SCHEMA,
            scene: meshes::scene_record(&self.survey.model, &self.facts),
            settings: Settings {
                path: inputs::path_words(&self.args.input.view),
                size,
                samples: self.args.samples,
                seed: self.args.input.view.seed,
                culling: inputs::culling_words(&self.args.input.cull, self.survey.model.in_cells()),
                version: env!("CARGO_PKG_VERSION"),
            },
            views,
            levels: self.levels_cost(&summary),
            costs: self.triangle_costs.as_ref().map(|p| p.record(&summary)),
            summary,
            meshes,
            complete,
        }
    }

    /// Returns what levels of detail take and save, where they are on.
    fn levels_cost(&self, summary: &Summary) -> Option<LevelsCost> {
        let levels = summary.levels.as_ref()?;
        let views = summary.views.max(1) as f64;
        let (scene, mut stored) = (&self.survey.model.scene, [0u64; 2]);
        let held = levels::holders(scene);
        for (mesh, holds) in scene.meshes().iter().zip(held) {
            stored[usize::from(holds)] += u64::from(mesh.triangle_count());
        }
        let drawn = [levels.ladder.occlusion, levels.ladder.levels];
        Some(LevelsCost {
            stored_triangles: stored[0],
            stored_level_triangles: stored[1],
            drawn_triangles: drawn,
            ms_per_view: self
                .triangle_costs
                .as_ref()
                .map(|costs| drawn.map(|n| n as f64 * costs.drawn_ns() * 1e-6 / views)),
        })
    }

    fn write(&self, complete: bool) -> Result<Record, Failure> {
        let record = self.record(complete);
        let changes = self.baseline.map_or_else(Vec::new, |old| baseline::changes(&record, old));
        let page = page::page(&record, &self.gallery, &changes);
        replace(&self.args.out.join("index.html"), page.as_bytes())?;
        let mut json = serde_json::to_vec_pretty(&record)
            .map_err(|e| Failure { exit: Exit::Internal, message: format!("JSON: {e}") })?;
        json.push(b'\n');
        replace(&self.args.out.join("report.json"), &json)?;
        Ok(record)
    }

    fn finish(mut self, complete: bool) -> Result<Record, Failure> {
        let record = self.write(complete)?;
        self.export.take().map_or(Ok(()), Export::finish)?;
        Ok(record)
    }
}

const CSV_HEAD: &str = "view,eye_x,eye_y,eye_z,triangles_all,triangles_potentially_visible,triangles_visible,\
tightness,instances_all,instances_potentially_visible,instances_visible,false_culls,mean_layers_before,\
mean_layers_after,max_layers_before,max_layers_after,seconds";

fn csv_row(v: &ViewRecord) -> String {
    let mut row = v.index.to_string();
    let mut cell = |value: Option<String>| {
        let _ = write!(row, ",{}", value.unwrap_or_default());
    };
    (0..3).for_each(|a| cell(v.eye.map(|e| e[a].to_string())));
    cell(Some(v.triangles.all.to_string()));
    cell(Some(v.triangles.potentially_visible.to_string()));
    cell(v.triangles.visible.map(|n| n.to_string()));
    cell(v.tightness.map(|t| t.to_string()));
    cell(Some(v.instances.all.to_string()));
    cell(Some(v.instances.potentially_visible.to_string()));
    cell(v.instances.visible.map(|n| n.to_string()));
    cell(Some(v.false_culls.to_string()));
    cell(v.depth_before.map(|d| d.mean_layers.to_string()));
    cell(v.depth_after.map(|d| d.mean_layers.to_string()));
    cell(v.depth_before.map(|d| d.max_layers.to_string()));
    cell(v.depth_after.map(|d| d.max_layers.to_string()));
    cell(Some(format!("{:.4}", v.seconds)));
    row
}
