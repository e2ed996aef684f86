//! `cullet serve`: starts the server of the viewer's page.

use std::ffi::OsString;
use std::net::IpAddr;
use std::path::PathBuf;

use clap::Args;
use cullet_command::exit::Outcome;

use crate::peer::Peer;

const SERVER: Peer =
    Peer { name: "cullet-serve", what: "the server", example: "city", needs: "some minutes" };

pub(crate) const HELP: &str = "\
The server is a program of its own, cullet-serve, looked for beside this program and then in PATH. The
page is built by 'cargo xtask web'. Only the page's own files, the one scene and the
files that it names are served. Ctrl-C ends it.

Examples
  cullet serve                       the page, on http://127.0.0.1:8080
  cullet serve city:seed=3           with a built-in scene
  cullet serve model.glb --port 0    with a file, on any free port";

/// Arguments of `cullet serve`.
#[derive(Clone, Debug, Args)]
pub(crate) struct ServeArgs {
    /// A file or a built-in scene
    scene: Option<OsString>,
    /// Folder of the built page [default: found beside the program, or target/page]
    #[arg(long, value_name = "DIR")]
    page: Option<PathBuf>,
    /// Address to listen on [default: 127.0.0.1]
    #[arg(long, value_name = "IP")]
    host: Option<IpAddr>,
    /// Port to listen on; 0 takes a free one [default: 8080]
    #[arg(long, value_name = "N")]
    port: Option<u16>,
}

/// Runs the command: ends when the server does.
pub(crate) fn run(args: &ServeArgs) -> Outcome {
    SERVER.run(&handed_on(args))
}

fn handed_on(args: &ServeArgs) -> Vec<OsString> {
    let page = args.page.as_ref().map(|p| ["--page".into(), p.into()]);
    let host = args.host.map(|h| ["--host".into(), h.to_string().into()]);
    let port = args.port.map(|p| ["--port".into(), p.to_string().into()]);
    let mut all: Vec<OsString> = [page, host, port].into_iter().flatten().flatten().collect();
    // A scene may be called like an option.
    all.extend(args.scene.iter().flat_map(|s| ["--".into(), s.clone()]));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_asked_is_handed_on() {
        let mut args = ServeArgs { scene: None, page: None, host: None, port: None };
        assert!(handed_on(&args).is_empty());
        args.scene = Some("-x.glb".into());
        args.port = Some(0);
        args.host = "::1".parse().ok();
        assert_eq!(handed_on(&args), ["--host", "::1", "--port", "0", "--", "-x.glb"]);
    }
}
