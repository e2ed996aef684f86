//! The pictures of README and docs: drawn by the program, so that they show what it does.

use std::fs;

use crate::tools::{Done, cargo_program, command, root, run};

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
        "kinds city:cells=8,objects=60 --no-frustum --path walk --views 8 --view 5 --size 960x540",
    ),
    ("normal-mask.png", "normal-mask --eye 3,2,5 --target 0,0,0 --fov 20 --size 960x560"),
    ("normal-partition.png", "normal-partition --fov 40 --size 960x540"),
    ("conservative-set.png", "conservative-set --size 960x420"),
    ("culling-volume.png", "culling-volume knobs --size 960x540"),
    ("cones.png", "cones knobs --eye 1.55,2.1,2.0 --target 0,1.15,0 --size 800x450"),
    ("clusters.png", "clusters knobs --eye 1.55,2.1,2.0 --target 0,1.15,0 --size 800x450"),
    ("back-regions.png", "back-regions knobs --views 8 --view 1 --size 800x450"),
    ("solids.png", "shaded solids --views 8 --view 1 --size 960x540"),
    ("detail.png", "kinds city --detail 12 --path walk --views 8 --view 2 --size 960x540"),
    ("hidden.png", "hidden plant --path walk --views 8 --view 2 --size 960x540"),
    (
        "occlusion-buffer.png",
        "occlusion-buffer plant --path walk --views 8 --view 2 --size 1280x720",
    ),
    ("occluders-drawn.png", "occluders plant --path walk --views 8 --view 2 --size 960x540"),
    ("coverage.png", "coverage --size 1120x500"),
    ("moving.png", "shaded moving:t=1500 --eye 6,4,14 --target 0,0.5,0 --size 960x540"),
];

/// Pictures that other commands draw: a file, and the command.
const OTHERS: &[(&str, &str)] = &[
    ("occluders.png", "occluders solids --eye 8,5,14 --target 0,0.5,0 --size 960x540"),
    ("cut-office.png", "cut office --plane 0,1,0,1.6 --cap --size 960x540"),
    ("cut-solids.png", "cut solids --plane 0,0,1,0 --cap --size 960x540"),
];

/// Draws them all again.
pub(crate) fn draw() -> Done {
    let folder = root().join(FOLDER);
    fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let pictures = PICTURES.iter().map(|p| (p, Some("picture"), "--out"));
    let others = OTHERS.iter().map(|p| (p, None, "--picture"));
    for ((file, args), what, option) in pictures.chain(others) {
        let out = folder.join(file);
        let mut words = vec!["run", "--quiet", "--release", "--package", "cullet-cli", "--"];
        words.push("--quiet");
        words.extend(what.into_iter().chain(args.split(' ')));
        let out = out.to_string_lossy();
        words.extend_from_slice(&[option, &out]);
        run(command(&cargo_program(), &words))?;
    }
    all_there()
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
            if !link.ends_with(".png") && !link.ends_with(".svg") {
                continue;
            }
            if !base.join(link).is_file() {
                return Err(format!("{} shows {link}, which is not there", page.display()));
            }
            shown.extend(link.rsplit('/').next().map(str::to_owned));
        }
    }
    match PICTURES.iter().chain(OTHERS).find(|(file, _)| !shown.iter().any(|s| s == file)) {
        Some((file, _)) => Err(format!("{FOLDER}/{file} is drawn, but no page shows it")),
        None => Ok(()),
    }
}
