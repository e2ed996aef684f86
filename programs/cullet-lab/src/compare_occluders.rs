//! `cullet occluders --compare`: how much of what is truly hidden each kind of occluder finds.

use crate::bench::occlusion::{Agreement, HIDDEN, OUTSIDE, Reference, TOLERANCE, VISIBLE, view};
use crate::occscn;
use cullet::bounds::Aabb;
use cullet::cull::occlusion::{Occlusion, Visibility};
use cullet::{Culler, Output, Scene, View, ViewState, Visible, prepared::Preparation};
use cullet_baker::occluders::{CompareArgs, Compared};
use cullet_command::clock::clock;
use cullet_command::console::{Console, count, grouped, interrupted};
use cullet_command::exit::{Exit, Failure};
use cullet_draw::{SampleOptions, sampled_boxes};
use cullet_io::Model;
use cullet_io::baked::Occluders;
use cullet_maps::occscn::{Occscn, occluder_slots};
use serde::Serialize;

/// Result of a comparison.
#[derive(Debug, Serialize)]
struct Comparison {
    /// Views.
    views: usize,
    /// Boxes that each view tests.
    objects: usize,
    /// Pixels of views and buffers.
    size: [u32; 2],
    /// The model's own occluders, where they have a name; what was baked; all triangles.
    kinds: Vec<Kind>,
}

/// Result of one kind of occluder.
#[derive(Debug, Serialize)]
struct Kind {
    name: &'static str,
    /// Shapes that a view draws, on average.
    shapes: f64,
    /// Choosing and drawing them and testing the instances, on average over the views, in
    /// milliseconds.
    ms: f64,
    /// How its answers stand beside the reference.
    #[serde(flatten)]
    agreement: Agreement,
}

/// Compares a model's baked occluders with others; `made` has those of each mesh.
///
/// # Errors
/// If a scene for comparing cannot be made of the model, or Ctrl-C was pressed.
pub(crate) fn compare(
    args: &CompareArgs,
    size: [u32; 2],
    model: &mut Model,
    made: &[Occluders],
    console: &Console,
) -> Result<Compared, Failure> {
    let found = Comparison::new(args, size, model, console, |model: &mut Model| {
        for (mesh, made) in (0..).zip(made) {
            let occluder = made.to_engine().map_err(Failure::input)?;
            model.scene.set_occluder(mesh, occluder);
        }
        Ok(())
    })?;
    found.print(console);
    let record = serde_json::to_value(&found).map_err(Failure::input)?;
    Ok(Compared { record, is_wrong: found.is_wrong() })
}

/// Where answers come from and what they are held against.
struct Bench {
    views: Vec<View>,
    objects: Vec<Aabb>,
    size: [u32; 2],
    truth: Reference,
}

impl Comparison {
    /// Whether a box that is seen was culled.
    fn is_wrong(&self) -> bool {
        self.kinds.iter().any(|k| k.agreement.false_culls > 0)
    }

    /// Compares. `bake` gives the model its baked occluders, after its own were looked at.
    fn new(
        args: &CompareArgs,
        size: [u32; 2],
        model: &mut Model,
        console: &Console,
        bake: impl FnOnce(&mut Model) -> Result<(), Failure>,
    ) -> Result<Self, Failure> {
        let scene = occscn::with_occluders(model, &args.own)?;
        let bench = Bench::new(&scene, &model.scene, size, args.reference, console)?;
        drop(scene);
        model.scene.prepare(Preparation { occluder: true, ..Preparation::NONE });
        let mut kinds = Vec::new();
        if !args.own.is_empty() {
            let own = occluder_slots(model, &args.own).map_err(Failure::input)?;
            let flags = only(&mut model.scene, &own)?;
            kinds.push(bench.kind("own", &model.scene, console)?);
            restore(&mut model.scene, &flags)?;
        }
        let all = bench.kind("all triangles", &model.scene, console)?;
        bake(model)?;
        kinds.push(bench.kind("baked", &model.scene, console)?);
        kinds.push(all);
        Ok(Self { views: bench.views.len(), objects: bench.objects.len(), size, kinds })
    }

    /// For people.
    fn print(&self, console: &Console) {
        let Some(Kind { agreement: v, .. }) = self.kinds.first() else { return };
        let [w, h] = self.size;
        console.line(format!(
            "compared: {} from {} of {w}x{h}; {} hidden and {} seen at {} a pixel",
            count(self.objects as u64, "box", "boxes"),
            count(self.views as u64, "view", "views"),
            grouped(v.hidden),
            grouped(v.visible),
            count(u64::from(v.samples * v.samples), "sample", "samples"),
        ));
        console.line(format!(
            "{:<16} {:>13} {:>9} {:>13} {:>8} {:>12}",
            "what hides",
            "shapes per view",
            "ms per view",
            "hidden, found",
            "of all",
            "false culls"
        ));
        for k in &self.kinds {
            console.line(format!(
                "{:<16} {:>13} {:>9.2} {:>13} {:>6.2} % {:>12}",
                k.name,
                grouped(k.shapes.round() as u64),
                k.ms,
                grouped(k.agreement.found),
                k.agreement.efficiency,
                grouped(k.agreement.false_culls)
            ));
        }
        let found = |name| self.kinds.iter().find(|k| k.name == name).map(|k| k.agreement.found);
        for than in ["own", "all triangles"] {
            if let (Some(baked), Some(other)) = (found("baked"), found(than).filter(|f| *f > 0)) {
                let share = baked as f64 / other as f64 * 100.0;
                console.line(format!("baked finds {share:.1} % of what {than} finds"));
            }
        }
    }
}

impl Bench {
    fn new(
        scene: &Occscn,
        model: &Scene,
        size: [u32; 2],
        samples: u32,
        console: &Console,
    ) -> Result<Self, Failure> {
        let views: Vec<View> =
            (0..scene.cameras.len()).map(|i| view(scene, i, size)).collect::<Result<_, _>>()?;
        let origin = model.origin();
        let relative = |p: [f32; 3]| std::array::from_fn(|a| f64::from(p[a]) - origin[a]);
        let objects: Vec<Aabb> = scene
            .objects
            .iter()
            .map(|&[min, max]| Aabb::rounded_out(relative(min), relative(max)))
            .collect();
        let options = SampleOptions { samples, tolerance: TOLERANCE, ..SampleOptions::default() };
        let mut values = Vec::with_capacity(views.len() * objects.len());
        let mut bar = console.progress("drawing what is seen", views.len() as u64);
        for view in &views {
            go_on()?;
            values.extend(sampled_boxes(model, view, &objects, &options).iter().map(|a| *a as u8));
            bar.step();
        }
        bar.finish();
        Ok(Self { views, objects, size, truth: Reference { samples, jittered: false, values } })
    }

    /// Measures what the occluders of a scene find without a limit on their cost.
    fn kind(&self, name: &'static str, scene: &Scene, console: &Console) -> Result<Kind, Failure> {
        let culler = Culler::default()
            .with_output(Output::Instances)
            .with_occlusion(
                Occlusion::default().with_width(self.size[0]).with_budget(f32::INFINITY),
            )
            .with_clock(Some(clock));
        let (mut state, mut result) = (ViewState::default(), Visible::default());
        let mut answers = Vec::with_capacity(self.truth.values.len());
        let (mut shapes, mut nanoseconds) = (0, 0);
        let mut bar = console.progress(name, self.views.len() as u64);
        for view in &self.views {
            go_on()?;
            culler.cull_one(scene, view, &mut state, &mut result);
            shapes += result.funnel.occlusion.drawn;
            let stage = |s: &cullet::funnel::FunnelRow| s.stage == cullet::Stage::Occlusion;
            let row = result.funnel.rows.iter().find(|row| stage(row));
            nanoseconds += row.and_then(cullet::funnel::FunnelRow::time).unwrap_or(0);
            let buffer = state.occlusion_buffer();
            answers.extend(self.objects.iter().map(|b| match buffer.map(|o| o.test_box(b)) {
                Some(Visibility::Hidden) => HIDDEN,
                Some(Visibility::Outside) => OUTSIDE,
                _ => VISIBLE,
            }));
            bar.step();
        }
        bar.finish();
        let mean = 1.0 / self.views.len().max(1) as f64;
        Ok(Kind {
            name,
            shapes: shapes as f64 * mean,
            ms: nanoseconds as f64 * 1e-6 * mean,
            agreement: self.truth.judge(&answers),
        })
    }
}

fn go_on() -> Result<(), Failure> {
    if interrupted() {
        let message = "interrupted; nothing was compared".into();
        return Err(Failure { exit: Exit::Interrupted, message });
    }
    Ok(())
}

/// Lets only some slots occlude; returns the flags that those of all others had.
fn only(
    scene: &mut Scene,
    own: &[bool],
) -> Result<Vec<(cullet::Handle, cullet::InstanceFlags)>, Failure> {
    let others: Vec<_> = scene
        .slots()
        .filter(|&slot| !own[slot as usize])
        .filter_map(|slot| Some((scene.handle(slot)?, scene.flags(slot))))
        .collect();
    for &(handle, flags) in &others {
        let flags = cullet::InstanceFlags { no_occlusion: true, ..flags };
        scene.set_flags(handle, flags).map_err(Failure::input)?;
    }
    Ok(others)
}

fn restore(
    scene: &mut Scene,
    flags: &[(cullet::Handle, cullet::InstanceFlags)],
) -> Result<(), Failure> {
    flags.iter().try_for_each(|&(h, f)| scene.set_flags(h, f)).map_err(Failure::input)
}
