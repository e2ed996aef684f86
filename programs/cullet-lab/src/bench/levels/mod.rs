//! `cullet bench lod`: levels beside those of a simplifier that is believed.

pub(super) mod args;
mod chain;
mod ideal;
mod kept;
mod models;
mod peer;
mod plain;
mod steady;

use std::time::Instant;

use args::LodBenchArgs;
use cullet_bake::levels::{
    ChainOptions, ErrorSource, HierarchyOptions, LevelsError, build_chain, build_hierarchy,
};
use cullet_command::console::{Console, grouped, interrupted};
use cullet_command::exit::{Exit, Failure, Outcome};
use cullet_command::files::write_json;
use serde::Serialize;

use chain::ChainRow;
use ideal::{Ideal, IdealRow};
use kept::{Cuts, Ours};
use models::Whole;
use peer::PeerLevels;
use steady::Steady;

/// Cuts of the hierarchy.
const MEASURED: &str = "measured";
/// The smaller of that and of a chain.
const DRAWN: &str = "drawn";
/// Points of which the factor of the peer is found.
const FEWER_POINTS: u32 = 160_000;

/// Results of one model.
#[derive(Debug, Serialize)]
struct OfModel {
    model: String,
    triangles: usize,
    /// Cuts at one pixel: of the hierarchy of measured errors, the smaller of that and a chain,
    /// which is what is drawn, of the hierarchy by returned errors, and of the peer.
    cuts: Vec<Cuts>,
    /// Triangles drawn, relative to the peer's with the least factor that keeps a pixel, from 2 to
    /// 20 radii, in the geometric mean; where no factor does, relative to the whole model, which
    /// the peer draws in the end.
    ratio: f64,
    /// Best possible results of whole levels, each place drawn at its own.
    ideal: Vec<IdealRow>,
    chain: Vec<ChainRow>,
    steady: Vec<Steady>,
    /// Seconds of one thread for the hierarchy, errors measured, and millions of triangles a
    /// minute.
    bake_seconds: f64,
    bake_millions_a_minute: f64,
}

#[derive(Debug, Serialize)]
struct Record {
    schema: u32,
    models: Vec<OfModel>,
    /// Geometric means over the models.
    ratio: f64,
    chain_ratio: Option<f64>,
}

/// Runs the command.
pub(crate) fn run(args: &LodBenchArgs, console: &Console) -> Outcome {
    let mut rows = Vec::new();
    for whole in models::models(&args.scene, console)? {
        rows.push(measure(&whole, args, console).map_err(|why| match why {
            Stop::Interrupted => Failure { exit: Exit::Interrupted, message: "interrupted".into() },
            Stop::Levels(e) => Failure::input(format!("{}: {e}", whole.name)),
            Stop::Peer(e) => Failure::input(format!("{}: the peer refuses it: {e}", whole.name)),
        })?);
    }
    let mean_of = |all: Vec<f64>| (!all.is_empty()).then(|| mean(&all));
    let ratio = mean(&rows.iter().map(|r| r.ratio).collect::<Vec<_>>());
    let chain_ratio = mean_of(rows.iter().flat_map(|r| &r.chain).map(ChainRow::ratio).collect());
    console.line(format!("all: {ratio:.2} of the peer's triangles within the same bound"));
    if let Some(ratio) = chain_ratio {
        console.line(format!("all: {ratio:.2} of a plain chain's triangles within the same bound"));
    }
    let outcome = outcome(&rows);
    if let Some(path) = &args.json {
        write_json(path, &Record { schema: 1, models: rows, ratio, chain_ratio })?;
    }
    outcome
}

impl OfModel {
    /// Whether our cuts keep their bounds, without cracks, and nothing flips.
    fn is_kept(&self) -> bool {
        self.cuts
            .iter()
            .filter(|c| c.is_ours())
            .flat_map(|c| &c.rows)
            .all(|r| r.is_kept() && r.cracks == 0)
            && self.chain.iter().all(|r| r.p999 <= 1.0 && r.most <= 1.2)
            && self.steady.iter().all(|s| s.flips == 0)
    }
}

/// Fine where all bounds of all models are kept.
fn outcome(models: &[OfModel]) -> Outcome {
    if models.iter().all(OfModel::is_kept) {
        return Ok(Exit::Fine);
    }
    let message = "a bound is not kept, or a cut has cracks: see above".into();
    Err(Failure { exit: Exit::FalseCull, message })
}

enum Stop {
    Interrupted,
    Levels(LevelsError),
    Peer(meshopt::Error),
}

impl From<meshopt::Error> for Stop {
    fn from(why: meshopt::Error) -> Self {
        Self::Peer(why)
    }
}

impl From<LevelsError> for Stop {
    fn from(why: LevelsError) -> Self {
        Self::Levels(why)
    }
}

fn measure(whole: &Whole, args: &LodBenchArgs, console: &Console) -> Result<OfModel, Stop> {
    let go_on = || if interrupted() { Err(Stop::Interrupted) } else { Ok(()) };
    console.line(format!("{}, {} triangles", whole.name, grouped(whole.triangles() as u64)));
    let data = whole.to_data();
    let begin = Instant::now();
    let measured = build_hierarchy(&data, None, &HierarchyOptions::default())?;
    let bake_seconds = begin.elapsed().as_secs_f64();
    let bake_millions_a_minute = whole.triangles() as f64 * 60e-6 / bake_seconds;
    console.line(format!(
        "  hierarchy of measured errors in {bake_seconds:.1} s: {bake_millions_a_minute:.1} million triangles a minute"
    ));
    let measured = Ours::new(measured)?;
    let chain = Ours::new(build_chain(&data, &ChainOptions::default())?)?;
    go_on()?;
    let options = HierarchyOptions { errors: ErrorSource::Returned, ..HierarchyOptions::default() };
    let returned = Ours::new(build_hierarchy(&data, None, &options)?)?;
    let peer = PeerLevels::new(whole)?;
    let original = kept::Original::new(whole);
    let mut cuts = Vec::new();
    let mut add = |cut: Cuts| {
        print(&cut, console);
        cuts.push(cut);
    };
    add(original.ours(MEASURED, &[&measured], args.points));
    go_on()?;
    add(original.ours(DRAWN, &[&measured, &chain], args.points));
    go_on()?;
    add(original.ours("returned", &[&returned], FEWER_POINTS));
    go_on()?;
    add(original.peer(&peer, 1.0, FEWER_POINTS));
    let kept = original.peer_kept(&peer, FEWER_POINTS);
    go_on()?;
    if let Some(kept) = &kept {
        add(kept.clone());
    } else {
        console.line(
            "  clusterlod: no factor that was tried keeps a pixel: all its triangles are counted",
        );
    }
    let peers =
        |row: usize| kept.as_ref().map_or(whole.triangles() as f64, |k| k.rows[row].triangles);
    let ratio =
        mean(&(1..5).map(|row| cuts[1].rows[row].triangles / peers(row)).collect::<Vec<_>>());
    console.line(format!("  {ratio:.2} of its triangles, from 2 to 20 radii"));
    let ideal = Ideal::new(whole, || !interrupted())?;
    go_on()?;
    let ideal = ideal.rows();
    for (row, ours) in ideal.iter().zip(&cuts[1].rows) {
        console.line(format!(
            "  {:>4} radii: {:.2} of the {} triangles of an ideal choice, which has cracks; {} if each triangle's own error were known",
            row.radii,
            ours.triangles / row.triangles,
            grouped(row.triangles.round() as u64),
            grouped(row.by_place.round() as u64)
        ));
    }
    let bounds = chain::compare(whole, args.points / 2)?;
    for row in &bounds {
        console.line(format!(
            "  within {:.1} %: {} triangles, plain chain {}: {:.2}; off by {:.2} bounds at most, 99.9 % by {:.2}",
            row.bound * 100.0,
            grouped(row.triangles as u64),
            grouped(row.plain as u64),
            row.ratio(),
            row.most,
            row.p999
        ));
    }
    go_on()?;
    let steady = steady::tremble(whole, measured.levels());
    for s in &steady {
        console.line(format!(
            "  an eye that trembles at {} radii: {:.1} % more triangles for a ball of eyes, {} flips ({} without)",
            s.radii,
            s.more * 100.0,
            s.flips,
            s.flips_without
        ));
    }
    Ok(OfModel {
        model: whole.name.clone(),
        triangles: whole.triangles(),
        cuts,
        ratio,
        ideal,
        chain: bounds,
        steady,
        bake_seconds,
        bake_millions_a_minute,
    })
}

fn print(cut: &Cuts, console: &Console) {
    let (name, factor) = (cut.levels, cut.factor);
    let times = if factor == 1.0 { String::new() } else { format!(", errors times {factor}") };
    console.line(format!("  {name}{times}: triangles at one pixel, largest deviation, 99.9 %"));
    for r in &cut.rows {
        console.line(format!(
            "    {:>4} radii {:>9.0}  {:>5.2} px  {:>5.2} px{}",
            r.radii,
            r.triangles,
            r.most,
            r.p999,
            if r.cracks > 0 { format!("  {} open edges", r.cracks) } else { String::new() }
        ));
    }
}

/// The geometric mean.
fn mean(ratios: &[f64]) -> f64 {
    (ratios.iter().map(|r| r.ln()).sum::<f64>() / ratios.len().max(1) as f64).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_testkit::data;

    #[test]
    fn one_bound_that_is_not_kept_fails_all() {
        let kept = || OfModel {
            model: "m".to_owned(),
            triangles: 9,
            cuts: vec![Cuts {
                levels: MEASURED,
                factor: 1.0,
                rows: vec![kept::Kept { most: 1.15, p999: 0.9, ..kept::Kept::default() }],
            }],
            ratio: 0.5,
            ideal: Vec::new(),
            chain: vec![ChainRow {
                bound: 0.01,
                triangles: 1,
                plain: 2,
                most: 1.1,
                p999: 1.0,
                open_edges: [0; 2],
            }],
            steady: vec![Steady::default()],
            bake_seconds: 1.0,
            bake_millions_a_minute: 1.0,
        };
        assert_eq!(outcome(&[kept(), kept()]).ok(), Some(Exit::Fine));
        let spoilt: [fn(&mut OfModel); 5] = [
            |m| m.cuts[0].rows[0].p999 = 1.01,
            |m| m.cuts[0].rows[0].most = f64::NAN,
            |m| m.cuts[0].rows[0].cracks = 1,
            |m| m.chain[0].most = 1.3,
            |m| m.steady[0].flips = 1,
        ];
        for spoil in spoilt {
            let mut broken = kept();
            spoil(&mut broken);
            let failed = outcome(&[kept(), broken]).expect_err("a bound that is not kept");
            assert_eq!(failed.exit, Exit::FalseCull);
        }
    }

    #[test]
    fn a_machine_part_keeps_the_bound_with_fewer_triangles_than_a_plain_chain() {
        let Some(path) = data("classic-meshes/fandisk.obj") else { return };
        let console = Console::new(true, None);
        let named = [path.display().to_string()];
        let whole = models::models(&named, &console).expect("a model").remove(0);
        let args =
            LodBenchArgs { scene: Vec::new(), scenes: false, points: FEWER_POINTS, json: None };
        let found = measure(&whole, &args, &console).ok().expect("a mesh");
        assert_eq!(found.cuts[1].levels, DRAWN);
        for row in found.cuts[..2].iter().flat_map(|c| &c.rows) {
            assert!(row.is_kept() && row.cracks == 0, "{row:?}");
        }
        for (drawn, hierarchy) in found.cuts[1].rows.iter().zip(&found.cuts[0].rows) {
            assert!(drawn.triangles <= hierarchy.triangles, "{drawn:?}");
        }
        assert!(found.cuts[3].rows.iter().any(|r| !r.is_kept()), "believed errors are kept too");
        // Flat sides and sharp edges are what the simplifier's own estimate is good at.
        assert!(found.ratio < 1.2, "{}", found.ratio);
        let chain: Vec<f64> = found.chain.iter().map(ChainRow::ratio).collect();
        assert!(mean(&chain) <= 0.75, "{chain:?}");
        for row in &found.chain {
            assert!(row.p999 <= 1.0 && row.most <= 1.2, "{row:?}");
            assert!(row.open_edges[1] <= row.open_edges[0], "{row:?}");
        }
        assert!(found.steady.iter().all(|s| s.flips == 0), "{:?}", found.steady);
        assert!(found.steady.iter().any(|s| s.flips_without > 0), "{:?}", found.steady);
    }
}
