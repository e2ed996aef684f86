//! Texts that a user takes out of a session: the link, the funnel and the camera path.

use std::fmt::Write as _;

use cullet::funnel::Funnel;

use super::Session;

impl Session {
    /// Copies the link.
    pub fn copy_link(&mut self) {
        self.ctx.copy_text(self.link());
        self.tell("The link is copied.", false);
    }

    /// Copies the funnel of the newest decision as JSON, if there is one.
    pub fn copy_funnel(&mut self) {
        if let Some(decision) = &self.decision {
            self.ctx.copy_text(funnel_json(&decision.visible.funnel));
            self.tell("The funnel is copied.", false);
        }
    }

    /// Copies the camera path as the file that `cullet report` reads.
    pub fn copy_path(&mut self) {
        let [w, h] = self.size.map(|v| f64::from(v.max(1)));
        match self.journey.json(w / h) {
            Ok(text) => {
                self.ctx.copy_text(text);
                let next =
                    "The path is copied: save it, then cullet report SCENE --path file:path.json";
                self.tell(next, false);
            }
            Err(error) => self.tell(error.to_string(), true),
        }
    }
}

/// The funnel as JSON: a row for each stage and unit, with the triangles that came in and went on,
/// with nanoseconds where a clock was given.
#[must_use]
pub fn funnel_json(funnel: &Funnel) -> String {
    let mut out = String::from("{\n  \"funnel\": [");
    for (i, row) in funnel.rows.iter().enumerate() {
        let comma = if i > 0 { "," } else { "" };
        let took = row.time().map_or("null".to_owned(), |n| n.to_string());
        // Names of stages and units are plain words.
        let _ = write!(
            out,
            "{comma}\n    {{ \"stage\": \"{}\", \"unit\": \"{}\", \"entered\": {}, \"left\": {}, \
             \"triangles\": [{}, {}], \"nanoseconds\": {took} }}",
            row.stage.name(),
            row.unit.name(),
            row.entered.of(row.unit),
            row.left.of(row.unit),
            row.entered.triangles,
            row.left.triangles
        );
    }
    out.push_str("\n  ]\n}\n");
    out
}
