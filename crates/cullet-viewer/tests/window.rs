//! The program itself, in a window of a virtual display. Skipped, with a line that says so, where there is no
//! `xvfb-run` or no graphics device; with `CULLET_REQUIRE_GPU=1` that is a failure.

use std::collections::HashSet;
use std::path::Path;
use std::process::{Command, Output};

/// The exit code of the viewer where there is no window or no device.
const NO_DEVICE: i32 = 69;

/// Runs the viewer on a virtual display; `None` where that cannot be.
fn viewer(args: &[&str]) -> Option<Output> {
    let required = std::env::var("CULLET_REQUIRE_GPU").is_ok_and(|v| v == "1");
    let skip = |why: &str| {
        assert!(!required, "{why}, though CULLET_REQUIRE_GPU=1");
        eprintln!("skipped: {why}");
    };
    let out = Command::new("timeout")
        .args(["300", "xvfb-run", "-a", "-s", "-screen 0 1280x800x24"])
        .arg(env!("CARGO_BIN_EXE_cullet-viewer"))
        .args(args)
        .env_remove("WAYLAND_DISPLAY")
        .output();
    match out {
        Ok(out) if out.status.code() == Some(127) => skip("there is no xvfb-run"),
        Ok(out) if out.status.code() == Some(NO_DEVICE) => {
            skip(&format!("no graphics device: {}", String::from_utf8_lossy(&out.stderr)));
        }
        Ok(out) => return Some(out),
        Err(error) => skip(&format!("no xvfb-run: {error}")),
    }
    None
}

/// Width, height, and how many colours a picture has.
fn colours(path: &Path) -> (u32, u32, usize) {
    let file = std::io::BufReader::new(std::fs::File::open(path).expect("a picture was written"));
    let mut reader = png::Decoder::new(file).read_info().expect("a PNG");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut bytes).expect("a whole PNG");
    let all: HashSet<[u8; 4]> = bytes.chunks_exact(4).map(|c| [c[0], c[1], c[2], c[3]]).collect();
    (info.width, info.height, all.len())
}

fn assert_fine(out: &Output) {
    let told = String::from_utf8_lossy(&out.stderr);
    assert!(out.status.success(), "{:?}: {told}", out.status);
}

#[test]
fn a_screenshot_has_the_scene_in_it() {
    let path = std::env::temp_dir().join(format!("cullet-viewer-{}.png", std::process::id()));
    let file = path.display().to_string();
    let state = "layout=split&ghosts.form=solid";
    let args = ["city:sub=1", "--state", state, "--size", "960x600", "--screenshot", &file];
    let Some(out) = viewer(&args) else { return };
    assert_fine(&out);
    let (width, height, colours) = colours(&path);
    assert_eq!((width, height), (960, 600));
    assert!(colours > 400, "only {colours} colours: that is no city");
    std::fs::remove_file(&path).expect("ours to remove");
}

#[test]
fn every_switch_is_thrown_without_error() {
    let Some(out) = viewer(&["solids", "--script", "toggles", "--size", "640x400"]) else { return };
    assert_fine(&out);
}

#[test]
fn a_broken_input_ends_an_unattended_run_with_words() {
    let Some(out) = viewer(&["no-such-file.glb", "--screenshot", "/dev/null"]) else { return };
    assert_eq!(out.status.code(), Some(3));
    let told = String::from_utf8_lossy(&out.stderr);
    assert!(told.contains("no-such-file.glb: cannot be read"), "{told}");
}

#[test]
fn wrong_command_lines_need_no_window() {
    let run = |args: &[&str]| {
        let out =
            Command::new(env!("CARGO_BIN_EXE_cullet-viewer")).args(args).output().expect("runs");
        let text = String::from_utf8_lossy(&[out.stdout, out.stderr].concat()).into_owned();
        (out.status.code(), text)
    };
    let (code, text) = run(&["--help"]);
    assert!(code == Some(0) && text.contains("Examples"));
    for (args, part) in [
        (&["--size", "9x9"][..], "--size 9x9: must be WxH"),
        (&["--state"], "--state needs a value"),
        (&["--frobnicate"], "there is no option --frobnicate"),
        (&["city", "office"], "'office' is a second"),
        (&["--script", "dance"], "there is no script 'dance'"),
    ] {
        let (code, text) = run(args);
        assert!(code == Some(2) && text.contains(part), "{args:?}: {code:?} {text}");
    }
}
