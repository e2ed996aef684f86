//! Changes since an older `report.json`.

use std::path::Path;

use cullet_command::console::grouped;
use cullet_command::exit::Failure;
use serde_json::Value;

use super::record::Record;
use crate::record::SCHEMA;

/// Reads an older report.
pub(crate) fn read(path: &Path) -> Result<Value, Failure> {
    let at = |what: String| Failure::input(format!("{}: {what}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|e| at(format!("cannot be read: {e}")))?;
    let value: Value = serde_json::from_str(&text).map_err(|e| at(format!("is not JSON: {e}")))?;
    match value["schema"].as_u64() {
        Some(schema) if schema == u64::from(SCHEMA) => Ok(value),
        Some(schema) => Err(at(format!("has schema {schema}; this program reads {SCHEMA}"))),
        None => Err(at("is not a report.json: it has no \"schema\"".into())),
    }
}

/// A line for each figure that differs, and a first one that says so if none does.
pub(crate) fn changes(record: &Record, old: &Value) -> Vec<String> {
    let mut lines = Vec::new();
    if old["scene"]["name"].as_str() != Some(&record.scene.name) {
        let name = old["scene"]["name"].as_str().unwrap_or("a scene without name");
        lines.push(format!("the baseline is of another scene: {name}"));
    }
    let views = old["views"].as_array().map_or(0, Vec::len);
    if views != record.summary.views {
        lines.push(format!("views: {views} → {}; sums are not comparable", record.summary.views));
    }
    let s = &record.summary;
    let was = &old["summary"];
    let mut count = |what: &str, was: &Value, now: Option<u64>| {
        if let (Some(was), Some(now)) = (was.as_u64(), now)
            && was != now
        {
            let change = match was {
                0 => String::new(),
                _ => format!(" ({:+.2} %)", (now as f64 / was as f64 - 1.0) * 100.0),
            };
            lines.push(format!("{what}: {} → {}{change}", grouped(was), grouped(now)));
        }
    };
    let t = &was["triangles"];
    count("instances", &old["scene"]["instances"], Some(record.scene.instances));
    count("meshes", &old["scene"]["meshes"], Some(record.scene.meshes));
    count("solids", &old["scene"]["solids"], Some(record.scene.solids));
    count("triangles, all", &t["all"], Some(s.triangles.all));
    count("triangles left", &t["potentially_visible"], Some(s.triangles.potentially_visible));
    count("triangles visible", &t["visible"], s.triangles.visible);
    count("false culls", &was["false_culls"], Some(s.false_culls));
    for row in was["stages"].as_array().into_iter().flatten() {
        let (Some(name), Some(unit)) = (row["name"].as_str(), row["unit"].as_str()) else {
            continue;
        };
        let now = s.stages.iter().find(|r| r.stage.name() == name && r.unit.name() == unit);
        count(&format!("{name}, {unit} left"), &row["out"], now.map(|r| r.left));
        if now.is_none() {
            count(&format!("{name}, {unit} left"), &row["out"], Some(0));
        }
    }
    if let (Some(was), Some(now)) = (was["tightness"].as_f64(), s.tightness)
        && (was - now).abs() > 5e-4
    {
        lines.push(format!("tightness: {was:.3} → {now:.3}"));
    }
    let kinds: Vec<&str> =
        was["advice"].as_array().into_iter().flatten().filter_map(|a| a["kind"].as_str()).collect();
    for a in s.advice.iter().filter(|a| !kinds.contains(&a.kind)) {
        lines.push(format!("new advice: {}", a.title));
    }
    for kind in kinds.iter().filter(|k| !s.advice.iter().any(|a| a.kind == **k)) {
        lines.push(format!("advice settled: {kind}"));
    }
    if lines.is_empty() {
        lines.push("nothing changed".into());
    }
    lines
}
