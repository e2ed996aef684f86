//! `cullet info`: what is in a scene, and what is wrong with it.

use std::path::{Path, PathBuf};

use clap::Args;
use cullet_command::args::SceneArgs;
use cullet_command::console::{Console, count, grouped};
use cullet_command::exit::{Exit, Outcome};
use cullet_command::files::write_json;
use cullet_command::inputs;
use serde::Serialize;

use crate::baked::{self, BakedRecord};
use crate::meshes;
use crate::record::{MeshRecord, SCHEMA, SceneRecord};

/// `cullet info`
#[derive(Debug, Args)]
pub struct InfoArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// List every mesh and warning, not only the first ones
    #[arg(long)]
    pub(crate) all: bool,
    /// Only what is baked in a .glb, which takes milliseconds however large it is: nothing else is
    /// read, and sums are looked at with --all alone
    #[arg(long)]
    pub(crate) baked: bool,
    /// Write the result as JSON; - is the standard output
    #[arg(long, value_name = "PATH", value_parser = cullet_command::parse::output)]
    pub(crate) json: Option<PathBuf>,
}

const SHOWN: usize = 20;

#[derive(Serialize)]
struct InfoRecord<'a> {
    schema: u32,
    scene: &'a SceneRecord,
    cameras: Vec<&'a str>,
    cells: usize,
    portals: usize,
    mirrored_instances: u64,
    non_finite_instances: u64,
    /// Instances of finite transforms that every view keeps for want of bounds.
    #[serde(skip_serializing_if = "is_zero")]
    unbounded_instances: u64,
    singular_instances: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    groups: Option<GroupsRecord>,
    /// Baked data of the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    baked: Option<BakedRecord>,
    meshes: &'a [MeshRecord],
}

/// The node tree of the file, measured.
#[derive(Serialize)]
struct GroupsRecord {
    nodes: usize,
    /// Nodes with no instance below them.
    empty: usize,
    depth: usize,
    /// The most nodes and instances that one node has for its own.
    widest: usize,
}

/// Runs the command.
pub(crate) fn run(args: &InfoArgs, console: &Console) -> Outcome {
    if args.baked {
        return only_baked(args, console);
    }
    let silent = Console { quiet: true, ..*console };
    // Warnings are part of the result here, so loading need not print them too.
    let model = inputs::load(&args.scene, &silent)?;
    let facts = meshes::facts(&model);
    let record = meshes::scene_record(&model, &facts);
    let scene = &model.scene;
    let counts = cullet_io::instance_facts(scene);
    let tree = Some(&model.node_tree).filter(|t| !t.is_empty());
    let groups = tree.and_then(|_| model.node_tree_statistics());
    let info = InfoRecord {
        schema: SCHEMA,
        scene: &record,
        cameras: model.cameras.iter().map(|c| c.name.as_str()).collect(),
        cells: model.cells.cells.len(),
        portals: model.cells.portals.len(),
        mirrored_instances: counts.mirrored,
        non_finite_instances: counts.non_finite,
        unbounded_instances: counts.unbounded,
        singular_instances: counts.singular,
        groups: groups.map(|g| GroupsRecord {
            nodes: g.nodes,
            empty: g.empty,
            depth: g.depth,
            widest: g.widest,
        }),
        baked: baked::record(&model),
        meshes: &facts,
    };
    print(args, console, &info);
    if let Some(path) = &args.json {
        write_json(path, &info)?;
    }
    Ok(Exit::Fine)
}

/// `cullet info --baked`
fn only_baked(args: &InfoArgs, console: &Console) -> Outcome {
    let path = Path::new(&args.scene.scene);
    let record = baked::of_path(path, args.all, SCHEMA)?;
    let shown = if args.all { usize::MAX } else { SHOWN };
    let bytes = count(record.file_bytes, "byte", "bytes");
    let ms = record.open_seconds * 1e3;
    console.line(format!("{}: {bytes}, opened in {ms:.1} ms", path.display()));
    baked::print(&record.baked, shown, console);
    more(console, record.baked.meshes_count(), shown);
    if let Some(path) = &args.json {
        write_json(path, &record)?;
    }
    Ok(Exit::Fine)
}

fn print(args: &InfoArgs, console: &Console, info: &InfoRecord) {
    let s = info.scene;
    let shown = if args.all { usize::MAX } else { SHOWN };
    console.line(&s.name);
    let row = |what: &str, value: String| console.line(format!("  {what:<12}{value}"));
    row("instances", grouped(s.instances));
    row(
        "meshes",
        match (s.meshes, s.solids) {
            (1, 1) => "1, a solid".into(),
            (1, 0) => "1, not a solid".into(),
            (all, solids) => {
                format!("{}, of which {}", grouped(all), count(solids, "is a solid", "are solids"))
            }
        },
    );
    let polygons = match s.polygons == s.triangles {
        true => String::new(),
        false => format!(" from {}", count(s.polygons, "polygon", "polygons")),
    };
    row(
        "triangles",
        format!("{}{polygons} ({} stored)", grouped(s.triangles), grouped(s.unique_triangles)),
    );
    if let Some([min, max]) = s.extent {
        let size: Vec<String> = (0..3).map(|a| format!("{:.3}", max[a] - min[a])).collect();
        row("size", format!("{} (x × y × z)", size.join(" × ")));
    }
    row("materials", grouped(s.materials));
    if let Some(g) = &info.groups {
        row(
            "node tree",
            format!(
                "{}, {} deep, at most {} in one; {} with nothing to draw below",
                count(g.nodes as u64, "node", "nodes"),
                g.depth,
                grouped(g.widest as u64),
                grouped(g.empty as u64)
            ),
        );
    }
    if info.cells > 0 {
        row(
            "cells",
            format!("{}, with {}", info.cells, count(info.portals as u64, "portal", "portals")),
        );
    }
    if !info.cameras.is_empty() {
        let names: Vec<&str> = info.cameras.iter().take(shown.min(8)).copied().collect();
        row("cameras", format!("{}: {}", info.cameras.len(), names.join(", ")));
    }
    let notes = [
        (info.mirrored_instances, "mirrored"),
        (info.non_finite_instances, "with a transform that is not finite"),
        (info.unbounded_instances, "without finite bounds within ±1e18, and so kept in every view"),
        (info.singular_instances, "scaled to nothing along an axis"),
    ];
    for (n, what) in notes.iter().filter(|o| o.0 > 0) {
        row("note", format!("{} {what}", count(*n, "instance is", "instances are")));
    }
    let degenerate: u64 = info.meshes.iter().map(|m| m.degenerate).sum();
    let duplicate: u64 = info.meshes.iter().map(|m| m.duplicate).sum();
    if degenerate > 0 {
        let what = count(degenerate, "stored triangle has", "stored triangles have");
        row("note", format!("{what} no area"));
    }
    if duplicate > 0 {
        let what =
            count(duplicate, "stored triangle is a duplicate", "stored triangles are duplicates");
        row("note", format!("{what} of another"));
    }
    let defects: Vec<&MeshRecord> = info.meshes.iter().filter(|m| m.defect.is_some()).collect();
    if !defects.is_empty() {
        console.line(format!("\nMeshes that are not solids ({}):", grouped(defects.len() as u64)));
        let width = defects.iter().take(shown).map(|m| m.name.chars().count()).max();
        let width = width.unwrap_or(0).min(40);
        for m in defects.iter().take(shown) {
            let why = m.defect.as_deref().unwrap_or_default();
            let name = printable(&m.name);
            console.line(format!(
                "  {name:<width$}  {}, {}: {why}",
                count(m.triangles, "triangle", "triangles"),
                m.sides
            ));
        }
        more(console, defects.len(), shown);
    }
    if let Some(of) = &info.baked {
        baked::print(of, shown, console);
        more(console, of.meshes_count(), shown);
    }
    if !s.warnings.is_empty() {
        console.line(format!("\nWarnings ({}):", s.warnings.len()));
        s.warnings.iter().take(shown).for_each(|w| console.line(format!("  {}", printable(w))));
        more(console, s.warnings.len(), shown);
    }
}

fn is_zero(count: &u64) -> bool {
    *count == 0
}

fn more(console: &Console, count: usize, shown: usize) {
    if count > shown {
        console.line(format!("  and {} more; --all lists them", grouped((count - shown) as u64)));
    }
}

/// Names come from files: without control characters they cannot command a terminal.
fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_cannot_command_a_terminal() {
        assert_eq!(printable("a\x1b[31mb\n"), "a\u{fffd}[31mb\u{fffd}");
    }
}
