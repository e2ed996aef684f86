//! `cullet scenes`: the built-in scenes.

use std::path::PathBuf;

use clap::Args;
use cullet_command::console::Console;
use cullet_command::exit::{Exit, Outcome};
use cullet_command::files::write_json;
use serde_json::json;

/// `cullet scenes`
#[derive(Debug, Args)]
pub struct ScenesArgs {
    /// Write the list as JSON; - is the standard output
    #[arg(long, value_name = "PATH", value_parser = cullet_command::parse::output)]
    pub(crate) json: Option<PathBuf>,
}

/// Runs the command.
pub(crate) fn run(args: &ScenesArgs, console: &Console) -> Outcome {
    if let Some(path) = &args.json {
        let key = |k: &cullet_scenes::KeyInfo| json!({"name": k.name, "about": k.about, "default": k.default, "min": k.min, "max": k.max});
        let list: Vec<_> = cullet_scenes::list()
            .iter()
            .map(|s| {
                let keys: Vec<_> = s.keys.iter().map(key).collect();
                json!({"name": s.name, "about": s.about, "keys": keys})
            })
            .collect();
        write_json(path, &json!({"schema": 1, "scenes": list}))?;
    }
    if console.json_on_stdout {
        return Ok(Exit::Fine);
    }
    for s in cullet_scenes::list() {
        console.line(format!("{}\n  {}", s.name, s.about));
        for k in s.keys {
            let range = match k.max {
                u64::MAX => String::new(),
                max => format!(", {} to {max}", k.min),
            };
            console.line(format!("    {:<9} {} (default {}{range})", k.name, k.about, k.default));
        }
        console.line("");
    }
    console.line(
        "Use them as NAME or NAME:key=value,... for example: cullet report city:seed=3,cells=40",
    );
    Ok(Exit::Fine)
}
