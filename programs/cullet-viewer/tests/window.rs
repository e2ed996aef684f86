//! The program itself, in a window of a virtual display. Skipped, with a line that says so, where
//! there is no `xvfb-run` or no graphics device; with `CULLET_REQUIRE_GPU` that is a failure.

use std::collections::HashSet;
use std::path::Path;
use std::process::{Command, Output};

use cullet_gpu::{Tier, testing};

/// The exit code of the viewer where there is no window or no device.
const NO_DEVICE: i32 = 69;

/// Runs the viewer on a virtual display; `None` where that cannot be.
fn viewer(args: &[&str]) -> Option<Output> {
    viewer_in(Path::new("."), args)
}

/// The same in a folder.
fn viewer_in(folder: &Path, args: &[&str]) -> Option<Output> {
    let skip = |why: &str| {
        assert!(!testing::is_required(Tier::Draw), "{why}, though CULLET_REQUIRE_GPU is set");
        cullet_testkit::skip(why, "apt-get install mesa-vulkan-drivers libvulkan1 xvfb xauth");
    };
    let run = || {
        Command::new("timeout")
            .args(["300", "xvfb-run", "-a", "-s", "-screen 0 1280x800x24"])
            .arg(env!("CARGO_BIN_EXE_cullet-viewer"))
            .args(args)
            .current_dir(folder)
            .env_remove("WAYLAND_DISPLAY")
            .output()
    };
    // Where the program ends at once, xvfb-run may fail to clean up after itself, and hides the
    // program's exit code.
    let is_its_own =
        |out: &Output| String::from_utf8_lossy(&out.stderr).contains("xvfb-run: error");
    let mut out = run();
    for _ in 0..3 {
        if out.as_ref().is_ok_and(is_its_own) {
            out = run();
        }
    }
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

/// Whether the graphics device can decide what is drawn; skips, aloud, where it cannot.
fn device_decides() -> bool {
    testing::device(Tier::Pyramid, cullet_testkit::skip).is_some()
}

/// Width, height and the pixels of a picture.
fn pixels(path: &Path) -> (u32, u32, Vec<[u8; 4]>) {
    let file = std::io::BufReader::new(std::fs::File::open(path).expect("a picture was written"));
    let mut reader = png::Decoder::new(file).read_info().expect("a PNG");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut bytes).expect("a whole PNG");
    let all = bytes.chunks_exact(4).map(|c| [c[0], c[1], c[2], c[3]]).collect();
    (info.width, info.height, all)
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
    let (width, height, pixels) = pixels(&path);
    let colours = pixels.iter().collect::<HashSet<_>>().len();
    assert_eq!((width, height), (960, 600));
    assert!(colours > 400, "only {colours} colours: that is no city");
    std::fs::remove_file(&path).expect("ours to remove");
}

/// States whose pictures are kept, without panels: their times differ from run to run.
const GOLDEN: [(&str, &str, &str); 5] = [
    ("split", "city:sub=1", "layout=split&ghosts.form=solid"),
    ("buffer", "city:sub=1", "layout=buffer&map=false"),
    ("pyramid", "city:sub=1", "device.on=true&layout=buffer&device.level=2&map=false"),
    ("sides", "solids", "look.colour=sides&look.wireframe=true&map=false"),
    ("office", "office", "layout=wipe&look.colour=overdraw"),
];

/// Compares with tests/golden; `CULLET_GOLDEN=new` makes the pictures there anew. Another driver
/// rounds edges in another way: a hundredth of the pixels may be quite different, and all of them a
/// little.
#[test]
fn pictures_are_like_the_golden_ones() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    let anew = std::env::var("CULLET_GOLDEN").is_ok_and(|v| v == "new");
    for (name, scene, state) in GOLDEN {
        if state.contains("device.on") && !device_decides() {
            continue;
        }
        let golden = folder.join(format!("{name}.png"));
        let own = std::env::temp_dir().join(format!("cullet-{}-{name}.png", std::process::id()));
        let path = if anew { &golden } else { &own };
        let file = path.display().to_string();
        let state = format!("panels=false&{state}");
        let args = [scene, "--state", &state, "--size", "480x300", "--screenshot", &file];
        let Some(out) = viewer(&args) else { return };
        assert_fine(&out);
        if anew {
            continue;
        }
        let (shown, kept) = (pixels(&own), pixels(&golden));
        assert_eq!((shown.0, shown.1), (kept.0, kept.1), "{name}");
        let apart = |a: &[u8; 4], b: &[u8; 4]| {
            a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0)
        };
        let far = shown.2.iter().zip(&kept.2).filter(|(a, b)| apart(a, b) > 24).count();
        assert!(far * 100 < shown.2.len(), "{name}: {far} pixels are others; see {file}");
        std::fs::remove_file(&own).expect("ours to remove");
    }
}

#[test]
fn the_window_is_the_same_whoever_decides() {
    if !device_decides() {
        return;
    }
    for (scene, state) in [("city:sub=1", "look.fine=true"), ("office", "look.colour=clusters")] {
        let shown = ["false", "true"].map(|on| {
            let name = format!("cullet-by-{scene}-{on}-{}.png", std::process::id());
            let path = std::env::temp_dir().join(name.replace(':', "-"));
            let state = format!("panels=false&map=false&{state}&device.on={on}");
            let file = path.display().to_string();
            let args = [scene, "--state", &state, "--size", "480x300", "--screenshot", &file];
            let out = viewer(&args)?;
            assert_fine(&out);
            let shown = pixels(&path);
            std::fs::remove_file(&path).expect("ours to remove");
            Some(shown.2)
        });
        let [Some(cpu), Some(device)] = shown else { return };
        let differ = cpu.iter().zip(&device).filter(|(a, b)| a != b).count();
        assert_eq!(differ, 0, "{scene}");
    }
}

#[test]
fn every_switch_is_thrown_without_error() {
    let Some(out) = viewer(&["solids", "--script", "toggles", "--size", "640x400"]) else { return };
    assert_fine(&out);
}

#[test]
fn every_order_is_given_and_leaves_what_it_should() {
    let viewer = Path::new(env!("CARGO_BIN_EXE_cullet-viewer"));
    let cullet = viewer.with_file_name(format!("cullet{}", std::env::consts::EXE_SUFFIX));
    if !cullet.is_file() {
        let missing = format!("{} is not built", cullet.display());
        cullet_testkit::skip(&missing, "cargo build -p cullet-cli");
        return;
    }
    let folder = std::env::temp_dir().join(format!("cullet-orders-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder of ours");
    let args = ["solids", "--script", "orders", "--size", "640x400"];
    if let Some(out) = viewer_in(&folder, &args) {
        assert_fine(&out);
        let (width, height, _) = pixels(&folder.join("cullet-1.png"));
        assert_eq!((width, height), (640, 400));
        let report = folder.join("cullet-report");
        let page = std::fs::read_to_string(report.join("index.html")).expect("a report");
        assert!(page.contains("solids"), "it is of another scene");
        // Of the path, as many as a report has.
        let text = std::fs::read_to_string(report.join("report.json")).expect("its figures");
        let figures: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!(figures["views"].as_array().map(Vec::len), Some(16));
    }
    std::fs::remove_dir_all(&folder).expect("ours to remove");
}

#[test]
fn a_lost_device_brings_the_window_back_as_it_was() {
    let path = std::env::temp_dir().join(format!("cullet-lost-{}.png", std::process::id()));
    let file = path.display().to_string();
    let state = "look.colour=sides&look.wireframe=true&map=false&panels=false";
    let script = ["--script", "lose-device", "--screenshot", &file];
    let args = [&["solids", "--state", state, "--size", "480x300"][..], &script].concat();
    let Some(out) = viewer(&args) else { return };
    assert_fine(&out);
    let told = String::from_utf8_lossy(&out.stderr);
    assert!(
        told.contains("the graphics device was lost") && told.contains("opens again"),
        "{told}"
    );
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/sides.png");
    let (shown, kept) = (pixels(&path), pixels(&golden));
    let far = shown.2.iter().zip(&kept.2).filter(|(a, b)| (0..4).any(|i| a[i].abs_diff(b[i]) > 24));
    let far = far.count();
    assert!(far * 100 < shown.2.len(), "{far} pixels are others; see {file}");
    std::fs::remove_file(&path).expect("ours to remove");
}

#[test]
fn a_broken_input_ends_an_unattended_run_with_words() {
    let Some(out) = viewer(&["no-such-file.glb", "--screenshot", "/dev/null"]) else { return };
    assert_eq!(out.status.code(), Some(3));
    let told = String::from_utf8_lossy(&out.stderr);
    assert!(told.contains("there is no file no-such-file.glb"), "{told}");
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
        (&["--one-sided", "city", "--two-sided"], "--one-sided and --two-sided exclude each other"),
        (&["--script", "dance"], "there is no script 'dance'"),
    ] {
        let (code, text) = run(args);
        assert!(code == Some(2) && text.contains(part), "{args:?}: {code:?} {text}");
    }
}
