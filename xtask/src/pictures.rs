//! The pictures of README and docs: drawn by the program, so that they show what it does.

use std::fs;
use std::path::Path;

use crate::graphics;
use crate::tools::{Done, cargo_program, command, install_words, root, run};
use crate::web;

/// Where pictures lie, from the root.
const FOLDER: &str = "docs/src/pictures";

/// A picture's file, and what follows `cullet picture` to draw it.
const PICTURES: &[(&str, &str)] = &[
    ("kinds.png", "kinds city --path walk --views 8 --view 2 --size 1280x720"),
    ("hierarchy.png", "hierarchy city --path walk --views 8 --view 2 --size 1280x960"),
    ("city.png", "shaded city --path fly --views 12 --view 4 --size 960x540"),
    ("map.png", "map city --path walk --views 8 --view 2 --size 960x720"),
    ("depth.png", "depth city --path fly --views 12 --view 4 --size 960x540"),
    (
        "backface.png",
        "kinds city:cells=8,objects=60 --no-frustum --no-occlusion --path walk --views 8 --view 5 --size 1280x720",
    ),
    ("normal-mask.png", "normal-mask --eye 3,2,5 --target 0,0,0 --fov 20 --size 960x560"),
    ("normal-partition.png", "normal-partition --fov 40 --size 960x540"),
    ("conservative-set.png", "conservative-set --size 960x420"),
    ("culling-volume.png", "culling-volume knobs --test-cost 16 --size 960x540"),
    ("cones.png", "cones knobs --test-cost 16 --eye 1.55,2.1,2.0 --target 0,1.15,0 --size 800x450"),
    (
        "clusters.png",
        "clusters knobs --test-cost 16 --eye 1.55,2.1,2.0 --target 0,1.15,0 --size 800x450",
    ),
    ("back-regions.png", "back-regions knobs --views 8 --view 1 --size 800x450"),
    ("portals.png", "portals office --path walk --views 8 --view 3 --size 960x540"),
    ("cells.png", "cells office --path walk --views 8 --view 3 --size 960x720"),
    (
        "cells-auto.png",
        "cells office:roof=1 --cells auto --path walk --views 8 --view 3 --size 960x720",
    ),
    ("pvs-matrix.png", "pvs-matrix office --size 720x770"),
    ("solids.png", "shaded solids --views 8 --view 1 --size 960x540"),
    ("detail.png", "kinds city --detail 12 --path walk --views 8 --view 2 --size 1280x720"),
    ("hidden.png", "hidden plant --path walk --views 8 --view 2 --size 960x540"),
    (
        "occlusion-buffer.png",
        "occlusion-buffer plant --path walk --views 8 --view 2 --size 1280x720",
    ),
    ("occluders-drawn.png", "occluders plant --path walk --views 8 --view 2 --size 960x540"),
    ("coverage.png", "coverage --size 1120x500"),
    ("outcodes.png", "outcodes --size 1280x720"),
    ("clip-polygon.png", "clip-polygon --size 1280x720"),
    ("clip-w.png", "clip-w --size 1280x720"),
    ("pipeline.png", "pipeline --size 1280x720"),
    ("impostor.png", "impostor knobs"),
    ("moving.png", "shaded moving:t=1500 --eye 6,4,14 --target 0,0.5,0 --size 960x540"),
];

/// Pictures that other commands draw: a file, and the command.
const OTHERS: &[(&str, &str)] = &[
    ("occluders-ball.png", "occluders knobs --eye 2.5,2.5,3 --target 0,1.1,0 --size 960x540"),
    ("occluders.png", "occluders solids --eye 8,5,14 --target 0,0.5,0 --size 960x540"),
    ("cut-office.png", "cut office --plane 0,1,0,1.6 --cap --size 960x540"),
    ("cut-solids.png", "cut solids --plane 0,0,1,0 --cap --size 960x540"),
];

/// Pictures of explanations: a file, and the command that draws it.
const EXPLAINED: &[(&str, &str)] = &[
    (
        "explain-pixel.png",
        "explain city --path walk --views 8 --view 2 --size 960x540 --pixel 500,300",
    ),
    ("explain-chain.svg", "explain city --path walk --views 8 --view 2 --instance #24000"),
];

/// Films: a file, and the command that makes it.
const FILMS: &[(&str, &str)] = &[
    ("film-freeze.webp", "film city --of freeze --seconds 5 --fps 10 --colors 48"),
    ("film-portal.webp", "film office --of portal --size 640x320"),
];

/// The chain of a frame, timed on this machine: the file, and what follows `cullet-profile` to draw
/// it.
const CHAIN: (&str, &str) = ("profile.svg", "profile city --already frustum");

/// Pictures of the viewer's window: a file, its scene, and the state that it shows.
const WINDOWS: &[(&str, &str, &str)] = &[
    ("viewer-city.png", "city", "layout=split&ghosts.form=solid"),
    ("viewer-buffer.png", "city", "layout=buffer"),
    ("viewer-device.png", "city:sub=1", "device.on=true&layout=wipe&device.compare=true"),
    ("viewer-pyramid.png", "city:sub=1", "device.on=true&layout=buffer&device.level=3"),
    (
        "viewer-office.png",
        "office",
        "camera.target=[26.6,1.7,18.2]&camera.distance=6&camera.yaw=-8&camera.pitch=-4&camera.near=0.05\
         &layout=split&ghosts.form=solid",
    ),
    (
        "viewer-portals.png",
        "office",
        "camera.target=[26.6,1.7,18.2]&camera.distance=6&camera.yaw=-8&camera.pitch=-4&camera.near=0.05\
         &layout=split&structure.portals=true&structure.cells=true&structure.step=2",
    ),
];
/// The picture of the page, of its first view.
const PAGE: &str = "viewer-page.png";
/// How large the window is in them.
const WINDOW: &str = "1280x720";

/// Draws them all again: those of the program, then those of the viewer.
pub(crate) fn draw() -> Done {
    let folder = root().join(FOLDER);
    fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    draw_pictures(&folder)?;
    draw_chain(&folder)?;
    draw_windows(&folder)?;
    web::picture("city", "", &folder.join(PAGE))?;
    all_there()
}

fn draw_pictures(folder: &Path) -> Done {
    let pictures = PICTURES.iter().map(|p| (p, Some("picture"), "--out"));
    let others = OTHERS.iter().map(|p| (p, None, "--picture"));
    let films = FILMS.iter().chain(EXPLAINED).map(|p| (p, None, "--out"));
    for ((file, args), what, option) in pictures.chain(others).chain(films) {
        let out = folder.join(file);
        let mut words = vec!["run", "--quiet", "--release", "--package", "cullet-cli", "--"];
        words.push("--quiet");
        words.extend(what.into_iter().chain(args.split(' ')));
        let out = out.to_string_lossy();
        words.extend_from_slice(&[option, &out]);
        run(command(&cargo_program(), &words))?;
    }
    Ok(())
}

fn draw_chain(folder: &Path) -> Done {
    if !graphics::is_there() {
        let words = install_words(graphics::DEBIAN);
        println!("skipped: {} is as it was; {words}", CHAIN.0);
        return Ok(());
    }
    let out = folder.join(CHAIN.0);
    let out = out.to_string_lossy();
    let mut words = vec!["run", "--quiet", "--release", "--package", "cullet-profile", "--"];
    words.push("--quiet");
    words.extend(CHAIN.1.split(' '));
    words.extend_from_slice(&["--out", &out]);
    run(command(&cargo_program(), &words))
}

/// Draws the viewer's window on a virtual screen, so that no desktop's scale or theme is in the
/// picture, and in software, so that two machines draw the same.
fn draw_windows(folder: &Path) -> Done {
    if !graphics::is_there() {
        let words = install_words(graphics::DEBIAN);
        println!("skipped: the viewer's pictures are as they were; {words}");
        return Ok(());
    }
    let cargo = cargo_program();
    let viewer = ["--quiet", "--release", "--package", "cullet-viewer"];
    run(command(&cargo, &[&["build"], &viewer[..]].concat()))?;
    for (file, scene, state) in WINDOWS {
        let out = folder.join(file);
        let out = out.to_string_lossy();
        let screen = ["-a", "-s", "-screen 0 1600x1000x24", &cargo, "run"];
        let shown = ["--", scene, "--size", WINDOW, "--state", state, "--screenshot", &out];
        let mut shoot = command("xvfb-run", &[&screen, &viewer[..], &shown].concat());
        shoot.env("WGPU_BACKEND", "vulkan");
        run(shoot)?;
    }
    Ok(())
}

/// Every picture that a page of the docs or the README shows is there, and each is shown somewhere.
pub(crate) fn all_there() -> Done {
    let root = root();
    let mut pages = vec![(root.join("README.md"), root.clone())];
    let src = root.join("docs/src");
    let entries = fs::read_dir(&src).map_err(|e| format!("{}: {e}", src.display()))?;
    for entry in entries.flatten() {
        if entry.path().extension().is_some_and(|e| e == "md") {
            pages.push((entry.path(), src.clone()));
        }
    }
    let mut shown = Vec::new();
    for (page, base) in pages {
        let text = fs::read_to_string(&page).map_err(|e| format!("{}: {e}", page.display()))?;
        for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            if ![".png", ".svg", ".webp"].iter().any(|ending| link.ends_with(ending)) {
                continue;
            }
            if !base.join(link).is_file() {
                return Err(format!("{} shows {link}, which is not there", page.display()));
            }
            shown.extend(link.rsplit('/').next().map(str::to_owned));
        }
    }
    let commands = PICTURES.iter().chain(OTHERS).chain(FILMS).chain(EXPLAINED).chain([&CHAIN]);
    let commands = commands.map(|(file, _)| file);
    let mut drawn = commands.chain(WINDOWS.iter().map(|(file, ..)| file));
    match drawn.find(|file| !shown.iter().any(|s| s == *file)) {
        Some(file) => Err(format!("{FOLDER}/{file} is drawn, but no page shows it")),
        None => Ok(()),
    }
}
