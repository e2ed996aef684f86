//! `--export`: what each view keeps and drops, by name and handle, with reasons.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use cullet::{Scene, View, Visible};
use cullet_command::exit::Failure;
use cullet_io::Model;
use serde_json::json;

use crate::names::{name_of, reason_text};
use crate::survey::planes;

/// A JSON file that grows by one view at a time, so that a large scene needs no large memory.
#[derive(Debug)]
pub(crate) struct Export {
    path: PathBuf,
    file: BufWriter<File>,
    views: usize,
}

impl Export {
    /// Starts the file.
    pub(crate) fn create(path: &Path, model: &Model) -> Result<Self, Failure> {
        let fail = |e: std::io::Error| Failure::write(path, &e);
        let mut file = BufWriter::new(File::create(path).map_err(fail)?);
        let name = json!(model.name);
        write!(file, "{{\"schema\":1,\"scene\":{name},\"views\":[").map_err(fail)?;
        Ok(Self { path: path.to_owned(), file, views: 0 })
    }

    /// Adds a view: each instance is either visible or dropped.
    pub(crate) fn add(
        &mut self,
        model: &Model,
        view: &View,
        result: &Visible,
    ) -> Result<(), Failure> {
        self.write(model, view, result).map_err(|e| Failure::write(&self.path, &e))
    }

    fn write(&mut self, model: &Model, view: &View, result: &Visible) -> std::io::Result<()> {
        let scene = &model.scene;
        let eye = view.eye();
        let (direction, _, _) = planes(view);
        let comma = if self.views > 0 { "," } else { "" };
        let head = json!({
            "index": self.views, "eye": (eye[3] != 0.0).then_some([eye[0], eye[1], eye[2]]),
            "direction": direction, "triangles": result.triangle_count,
            "instances": result.instance_count,
        });
        // The view's own keys first, then its two long lists, one instance at a time.
        let head = head.to_string();
        write!(self.file, "{comma}\n{},\"visible\":[", head.trim_end_matches('}'))?;
        let mut first = true;
        let mut ranges = result.triangle_ranges.iter().filter(|r| r.count > 0).peekable();
        for slot in scene.slots() {
            while ranges.peek().is_some_and(|r| r.slot < slot) {
                ranges.next();
            }
            let Some(range) = ranges.peek().filter(|r| r.slot == slot) else { continue };
            let mut item = identity(model, scene, slot);
            item["triangles"] = json!(range.count);
            self.item(&mut first, &item)?;
        }
        write!(self.file, "],\"dropped\":[")?;
        let mut first = true;
        for slot in scene.slots() {
            let Some(reason) = result.reasons.get(slot as usize).copied().flatten() else {
                continue;
            };
            let mut item = identity(model, scene, slot);
            item["stage"] = json!(reason.stage);
            item["reason"] = json!(reason_text(reason));
            self.item(&mut first, &item)?;
        }
        write!(self.file, "]}}")?;
        self.views += 1;
        self.file.flush()
    }

    fn item(&mut self, first: &mut bool, item: &serde_json::Value) -> std::io::Result<()> {
        let comma = if std::mem::take(first) { "" } else { "," };
        write!(self.file, "{comma}\n{item}")
    }

    /// Ends the file.
    pub(crate) fn finish(mut self) -> Result<(), Failure> {
        writeln!(self.file, "\n]}}")
            .and_then(|()| self.file.flush())
            .map_err(|e| Failure::write(&self.path, &e))
    }
}

fn identity(model: &Model, scene: &Scene, slot: u32) -> serde_json::Value {
    json!({"name": name_of(model, slot), "handle": scene.handle(slot)})
}
