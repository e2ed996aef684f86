//! Where an experiment's figures and its chart go.

use std::path::Path;

use cullet_command::console::Console;
use cullet_command::exit::Failure;
use cullet_command::files::write_json;
use serde::Serialize;

use super::chart::Chart;

/// A folder for all, and a file for the figures once more.
#[derive(Clone, Copy, Debug)]
pub(super) struct Places<'a> {
    pub(super) out: &'a Path,
    pub(super) json: Option<&'a Path>,
}

impl Places<'_> {
    /// Writes NAME.svg, NAME.png and NAME.json, and a line that says so of what `chart_words` calls
    /// the chart.
    pub(super) fn write(
        &self,
        name: &str,
        chart_words: &str,
        chart: &Chart,
        record: &impl Serialize,
        console: &Console,
    ) -> Result<(), Failure> {
        let file = |ending: &str| self.out.join(format!("{name}.{ending}"));
        let save = |path: &Path, bytes: &[u8]| {
            std::fs::write(path, bytes).map_err(|e| Failure::write(path, &e))
        };
        save(&file("svg"), chart.to_svg().as_bytes())?;
        save(&file("png"), &chart.to_picture().to_png())?;
        write_json(&file("json"), record)?;
        if let Some(path) = self.json {
            write_json(path, record)?;
        }
        console.line(format!(
            "\n{chart_words} is in {} and .png, all figures are in {name}.json beside them.",
            file("svg").display()
        ));
        Ok(())
    }
}
