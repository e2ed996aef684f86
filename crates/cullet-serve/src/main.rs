//! The program `cullet-serve`; `cullet serve` starts it.
#![forbid(unsafe_code)]

use std::io::Write;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use cullet_serve::{Limits, Server, Site, find_page};

const EXAMPLES: &str = "\
Examples
  cullet-serve                      the page with its first scene, on http://127.0.0.1:8080
  cullet-serve city:seed=3          with a built-in scene
  cullet-serve model.glb --port 0   with a file, on any free port
  cullet-serve --host 0.0.0.0       to the whole network; WebGPU needs https there, WebGL2 does not

Ctrl-C ends it. Exit codes: 0 ended by Ctrl-C, 2 wrong command line, 3 page, scene or address
cannot be used.";

/// Serves the viewer's page, and a scene for it
#[derive(Debug, Parser)]
#[command(name = "cullet-serve", version, after_help = EXAMPLES)]
struct Args {
    /// A file (GLB, glTF, OBJ, PLY, STL, OFF) or a built-in scene
    scene: Option<String>,
    /// Folder of the built page [default: found beside the program, or target/page]
    #[arg(long, value_name = "DIR")]
    page: Option<PathBuf>,
    /// Address to listen on
    #[arg(long, value_name = "IP", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    host: IpAddr,
    /// Port to listen on; 0 takes a free one
    #[arg(long, value_name = "N", default_value_t = 8080)]
    port: u16,
}

fn main() -> ExitCode {
    let args = Args::parse();
    match start(&args) {
        Ok(server) => {
            // A reader that has gone (`| head`) is no reason to stop.
            let _ = writeln!(std::io::stdout(), "serving {}\nCtrl-C ends it", server.url());
            server.run();
            ExitCode::SUCCESS
        }
        Err(message) => {
            let _ = writeln!(std::io::stderr(), "error: {message}");
            ExitCode::from(3)
        }
    }
}

fn start(args: &Args) -> Result<Server, String> {
    let page = match &args.page {
        Some(page) => page.clone(),
        None => find_page().map_err(|e| e.to_string())?,
    };
    let site = Site::new(&page, args.scene.as_deref()).map_err(|e| e.to_string())?;
    let address = SocketAddr::new(args.host, args.port);
    Server::bind(address, site, Limits::default())
        .map_err(|e| format!("{address}: cannot be listened on: {e}; try --port 0"))
}
