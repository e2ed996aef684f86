//! Where a model comes from: an address, by the program curl, or a file.

use std::io::{ErrorKind, IsTerminal};
use std::path::{Path, PathBuf};
use std::process::Command;

use cullet_command::console::Console;
use cullet_command::exit::{Exit, Failure};

use super::models::Known;

/// The program that speaks to the network; this one does not.
const CURL: &str = "curl";

/// Gets what is at `from` of a model; where it lies then: at `part` what came from an address, else
/// the file itself.
///
/// # Errors
/// If there is no such file, curl is not there or did not get it, or it is larger than the model's
/// archive can be.
pub(super) fn get(
    from: &str,
    known: &Known,
    part: &Path,
    console: &Console,
) -> Result<PathBuf, Failure> {
    let is_address = ["http://", "https://"].iter().any(|scheme| from.starts_with(scheme));
    let path = if is_address {
        download(from, known, part, console)?;
        part.to_owned()
    } else {
        PathBuf::from(from)
    };
    let size = match std::fs::metadata(&path) {
        Ok(found) if found.is_file() => found.len(),
        Ok(_) => return Err(Failure::input(format!("{}: not a regular file", path.display()))),
        Err(e) => return Err(Failure::input(format!("{from}: cannot be read: {e}"))),
    };
    if size > known.most_bytes() { Err(over(from, known)) } else { Ok(path) }
}

fn download(from: &str, known: &Known, part: &Path, console: &Console) -> Result<(), Failure> {
    console.note(format!("{from} is fetched by {CURL}"));
    let mut curl = Command::new(CURL);
    let shown = !console.quiet && std::io::stderr().is_terminal();
    curl.args(if shown { &["--progress-bar"][..] } else { &["--silent", "--show-error"] });
    // Where it leads to may not be a file of this machine.
    curl.args(["--fail", "--location", "--max-redirs", "5"]);
    curl.args(["--proto", "=http,https", "--proto-redir", "=http,https"]);
    // One that says nothing for a minute is given up.
    curl.args(["--connect-timeout", "30", "--speed-limit", "1", "--speed-time", "60"]);
    curl.args(["--retry", "2", "--max-filesize", &known.most_bytes().to_string()]);
    let ended = curl.arg("--output").arg(part).arg("--url").arg(from).status();
    let elsewhere = "--from takes a file that you have, or another address";
    match ended.map(|status| status.code()) {
        Ok(Some(0)) => Ok(()),
        Ok(Some(FILESIZE_EXCEEDED)) => Err(over(from, known)),
        Ok(Some(code)) => Err(Failure::input(format!(
            "{from}: not fetched: {CURL} ended with exit code {code}. {elsewhere}"
        ))),
        Ok(None) => {
            Err(Failure { exit: Exit::Interrupted, message: format!("{from}: interrupted") })
        }
        Err(e) if e.kind() == ErrorKind::NotFound => Err(Failure::input(format!(
            "the program '{CURL}', which fetches, is not in PATH: install it, or fetch {from} by other means. {elsewhere}"
        ))),
        Err(e) => Err(Failure::input(format!("{CURL} cannot be started: {e}. {elsewhere}"))),
    }
}

/// The exit code of curl by which it says so.
const FILESIZE_EXCEEDED: i32 = 63;

fn over(from: &str, known: &Known) -> Failure {
    let (name, most) = (known.name, known.most_bytes());
    let message = format!("{from}: larger than {most} bytes, which {name} is not");
    Failure { exit: Exit::Limit, message }
}
