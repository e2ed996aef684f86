//! The program `cullet-serve`: a small HTTP server for the viewer's page and one scene. `cullet
//! serve` starts it.
//!
//! It answers with what it was told to serve and with nothing else: the files of the page are read
//! once, at the start, into a list of names, and a request is compared with that list. No path of a
//! request is ever joined to a folder, so `..`, links, absolute paths and unusual encodings lead
//! nowhere by construction.
//!
//! Files of the page that have a neighbour `NAME.gz` are sent compressed to whoever accepts that. A
//! scene is sent as it lies on the disk, and compressed on the way only beyond the loopback
//! interface, where it pays.
#![forbid(unsafe_code)]

mod answer;
mod body;
mod places;
#[cfg(test)]
mod requests;
mod server;
mod site;

use std::io::Write;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use server::{Limits, Server};
use site::{Site, find_page};

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
    /// A file (GLB, glTF, OBJ, PLY, STL, OFF), with the files that it names beside it, or a
    /// built-in scene
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
    for warning in site.warnings() {
        let _ = writeln!(std::io::stderr(), "warning: {warning}");
    }
    let address = SocketAddr::new(args.host, args.port);
    Server::bind(address, site, Limits::default())
        .map_err(|e| format!("{address}: {}", refused(&e)))
}

/// Why an address cannot be listened on, and what to do.
fn refused(error: &std::io::Error) -> String {
    use std::io::ErrorKind;
    match error.kind() {
        ErrorKind::AddrInUse => {
            "another program has this port, perhaps another cullet-serve: end it, or take a free \
                                 one with --port 0"
                .to_owned()
        }
        ErrorKind::AddrNotAvailable => {
            "this machine has no such address; --host 0.0.0.0 takes all that it has".to_owned()
        }
        ErrorKind::PermissionDenied => {
            "the system keeps this port for itself; take one above 1023, or --port 0".to_owned()
        }
        _ => format!("cannot be listened on: {error}; try --port 0"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_that_cannot_be_had_says_what_to_do() {
        let page = std::env::temp_dir().join(format!("cullet-serve-main-{}", std::process::id()));
        std::fs::create_dir_all(&page).expect("a folder of ours");
        std::fs::write(page.join("index.html"), "page").expect("a file of ours");
        let args = |host: &str, port: u16| {
            let (host, page) = (host.parse().expect("an address"), Some(page.clone()));
            Args { scene: None, page, host, port }
        };
        let first = start(&args("127.0.0.1", 0)).expect("there is a free port");
        let message = start(&args("127.0.0.1", first.address().port())).expect_err("it is taken");
        assert!(message.contains("another program") && message.contains("--port 0"), "{message}");
        // One of those that are for documents alone.
        let message = start(&args("192.0.2.1", 0)).expect_err("nobody has it");
        assert!(message.contains("--host"), "{message}");
        std::fs::remove_dir_all(&page).expect("ours to remove");
    }
}
