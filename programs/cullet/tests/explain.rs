//! `cullet explain`: its reasons are those of a whole cull, its numbers prove them, and it says so.

use std::process::{Command, Output as Ended};

use cullet::cull::detail::Detail;
use cullet::{
    Culler, Output, Reason, Stage, View, ViewState, Visible,
    explain::{Evidence, PlaneTest},
    funnel::Unit,
};
use cullet_draw::{PixelId, RenderOptions, Selection};
use cullet_io::{LoadOptions, Model};
use cullet_scenes::paths::{self, Overrides, PathSpec};
use cullet_testkit::{Folder, data};
use serde_json::Value;

fn cullet(args: &[&str]) -> Ended {
    Command::new(env!("CARGO_BIN_EXE_cullet")).args(args).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).replace('\u{202f}', " ")
}

fn explained(args: &[&str]) -> (Value, String) {
    let out = cullet(&[&["explain"], args, &["--json", "-"]].concat());
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    (serde_json::from_slice(&out.stdout).unwrap(), text(&out.stderr))
}

fn views(model: &Model, spec: &PathSpec, size: [u32; 2]) -> Vec<View> {
    paths::views(model, spec, 4, size, &Overrides::default()).unwrap()
}

/// The settings of the program: what is hidden is looked for at any cost.
fn culler() -> Culler {
    let mut culler = Culler::balanced().with_output(Output::Triangles).with_reasons(true);
    if let Some(occlusion) = &mut culler.occlusion {
        occlusion.risk = None;
    }
    culler
}

/// Every instance of every view: the reason is that of the cull, and the numbers of the stage that
/// dropped it say why. How many each stage dropped by such numbers.
fn hold(model: &Model, views: &[View], culler: &Culler) -> [u64; 10] {
    let scene = &model.scene;
    let mut proved = [0; 10];
    for view in views {
        let mut result = Visible::default();
        let world = model.in_cells();
        world.cull(culler, view, &mut ViewState::default(), &mut result);
        let slots: Vec<u32> = scene.slots().collect();
        let handles: Vec<_> = slots.iter().map(|&slot| scene.handle(slot).unwrap()).collect();
        let all = world.explain_many(culler, view, &handles).unwrap();
        for (slot, told) in slots.into_iter().zip(all) {
            let reason = result.reasons[slot as usize];
            assert_eq!(told.reason, reason, "slot {slot}");
            for step in told.steps.iter().filter(|step| step.unit == Unit::Instances) {
                let dropped_here = reason.filter(|r| r.stage == step.stage && step.left == 0);
                proved[step.stage as usize] += u64::from(dropped_here.is_some());
                prove(&step.evidence, dropped_here, culler, scene.bounds(slot).is_finite());
            }
        }
    }
    proved
}

/// Numbers of a step, where it dropped the instance, or let it pass.
fn prove(evidence: &Evidence, dropped: Option<Reason>, culler: &Culler, finite: bool) {
    match (evidence, dropped) {
        (Evidence::Planes(tests), Some(reason)) if reason.detail != Reason::MIXED => {
            let of = |t: &&PlaneTest| t.plane == reason.detail;
            let test = tests.iter().find(of).expect("the plane is among those that were tested");
            assert!(test.nearest > 0.0 && test.farthest >= test.nearest, "{test:?}");
        }
        (Evidence::Planes(tests), None) => {
            // What is outside by more than rounding goes.
            assert!(!finite || tests.iter().all(|t| t.nearest < 1e-2), "{tests:?}");
        }
        (Evidence::Cells(test), dropped) => {
            assert_eq!(test.in_sight, dropped.is_none(), "{test:?}");
        }
        (Evidence::Cover(test), Some(_)) => {
            assert!(test.open.is_none() && test.covered >= test.nearness, "{test:?}");
        }
        (Evidence::Cover(test), None) => assert!(test.open.is_some(), "{test:?}"),
        (Evidence::Size { pixels, weight }, dropped) => {
            let most = culler.detail.unwrap().threshold_px;
            let is_small = pixels.iter().all(|px| px * f64::from(*weight) <= most);
            assert_eq!(is_small, dropped.is_some(), "{pixels:?}");
        }
        (Evidence::Levels { drawn, triangles, .. }, _) => assert!(drawn <= triangles),
        _ => {}
    }
}

#[test]
fn in_a_city_the_reasons_are_those_of_the_cull() {
    let model = cullet_scenes::build("city:cells=8,objects=60").unwrap();
    let views = views(&model, &PathSpec::Walk, [320, 180]);
    let proved = hold(&model, &views, &culler());
    for stage in [Stage::Frustum, Stage::Occlusion] {
        assert!(proved[stage as usize] > 20, "{stage:?}: {proved:?}");
    }
    let detail = Some(Detail::default().with_threshold_px(8.0));
    let proved = hold(&model, &views, &culler().with_detail(detail));
    assert!(proved[Stage::Detail as usize] > 0, "{proved:?}");
}

#[test]
fn in_an_office_portals_are_told_of() {
    let model = cullet_scenes::build("office").unwrap();
    let views = views(&model, &PathSpec::Walk, [320, 180]);
    let proved = hold(&model, &views[..2], &culler());
    assert!(proved[Stage::Portal as usize] > 20, "{proved:?}");
}

#[test]
fn in_a_castle_the_reasons_are_those_of_the_cull() {
    let Some(folder) = data("intel-castle") else { return };
    let file = std::fs::read_dir(&folder).unwrap().flatten().map(|e| e.path());
    let mut files: Vec<_> = file
        .filter(|p| p.extension().is_some_and(|e| e == "glb" || e == "gltf" || e == "obj"))
        .collect();
    files.sort();
    let Some(file) = files.first() else { return };
    let model = cullet_maps::load(file, &LoadOptions::default()).unwrap();
    let views = views(&model, &PathSpec::Orbit, [320, 180]);
    let few = model.scene.slots().count() < 3000;
    if few {
        let proved = hold(&model, &views[..1], &culler());
        assert!(proved.iter().sum::<u64>() > 0, "{proved:?}");
    }
}

/// A scene and views small enough for any test.
const CITY: &[&str] = &[
    "city:cells=8,objects=60",
    "--path",
    "walk",
    "--views",
    "4",
    "--view",
    "1",
    "--size",
    "160x90",
];

#[test]
fn a_pixel_tells_who_owns_it_and_what_is_behind() {
    let model = cullet_scenes::build(CITY[0]).unwrap();
    let view = &views(&model, &PathSpec::Walk, [160, 90])[1];
    let frame = cullet_draw::render(&model.scene, view, Selection::All, &RenderOptions::default());
    let mut behind = 0;
    for at in [[80, 60], [20, 45], [150, 50]] {
        let (json, _) = explained(&[CITY, &["--pixel", &format!("{},{}", at[0], at[1])]].concat());
        let owner = frame.id(at[0], at[1]);
        assert_eq!(json["pixel"]["at"], serde_json::json!(at));
        if owner == PixelId::NONE {
            assert!(json["instance"].is_null() && json["pixel"]["triangle"].is_null());
            continue;
        }
        assert_eq!(json["pixel"]["triangle"], owner.triangle);
        let handle = model.scene.handle(owner.slot).unwrap();
        assert_eq!(json["instance"]["handle"][0], handle.index);
        assert_eq!(json["instance"]["kept"], true);
        let owned = frame.ids.iter().filter(|id| id.slot == owner.slot).count();
        assert_eq!(json["instance"]["owned_pixels"], owned);
        let triangle = &json["instance"]["triangle"];
        assert!(triangle["drawn"] == true && triangle["owned_pixels"].as_u64() > Some(0));
        assert!(triangle["side"] != "back" || model.scene.mesh(owner.slot).is_two_sided());
        let distances: Vec<f64> = (json["pixel"]["behind"].as_array().unwrap().iter())
            .map(|b| b["distance"].as_f64().unwrap())
            .collect();
        assert!(distances.windows(2).all(|w| w[0] <= w[1]), "{distances:?}");
        let own = json["pixel"]["distance"].as_f64().unwrap();
        assert!(distances.iter().all(|d| *d >= own), "what is culled is behind what is seen");
        behind += distances.len();
    }
    assert!(behind > 0, "something hidden is behind one of them");
}

/// An instance of the city that the frustum drops, and one that is occluded.
fn dropped_in_the_city() -> [(Stage, u32); 2] {
    let model = cullet_scenes::build(CITY[0]).unwrap();
    let view = &views(&model, &PathSpec::Walk, [160, 90])[1];
    let (culler, mut result) = (culler(), Visible::default());
    culler.cull_one(&model.scene, view, &mut ViewState::default(), &mut result);
    [Stage::Frustum, Stage::Occlusion].map(|stage| {
        let is_it = |slot: &u32| result.reasons[*slot as usize].is_some_and(|r| r.stage == stage);
        (stage, model.scene.slots().find(is_it).unwrap())
    })
}

#[test]
fn an_instance_is_told_of_in_text_json_and_picture() {
    let folder = Folder::new("explain");
    for (stage, slot) in dropped_in_the_city() {
        let picture = folder.path(&format!("{}.png", stage.name()));
        let name = format!("#{slot}");
        let (json, told) = explained(&[CITY, &["--instance", &name, "--out", &picture]].concat());
        let instance = &json["instance"];
        assert_eq!(instance["stage"], stage.name());
        assert_eq!((&instance["kept"], &instance["drawn_triangles"]), (&false.into(), &0.into()));
        let sentence = instance["sentence"].as_str().unwrap().replace('\u{202f}', " ");
        assert!(sentence.starts_with(&format!("dropped by {}: ", stage.name())), "{sentence}");
        assert!(told.contains(&sentence), "{told}");
        let last = instance["steps"].as_array().unwrap().last().unwrap();
        assert_eq!((&last["outcome"], &last["stage"]), (&"dropped".into(), &stage.name().into()));
        let shown = if stage == Stage::Frustum { "outside" } else { "no pixel lets it through" };
        assert!(told.contains(shown), "{told}");
        let png = std::fs::read(&picture).unwrap();
        assert!(png.starts_with(b"\x89PNG") && png.len() > 2000);
    }
}

/// The words of a drawing, each piece of text a line, after a look whether it is well-formed: every
/// tag closed by its own, quotes in pairs, and no sign that ought to be escaped.
fn words_of(svg: &str) -> String {
    let (mut open, mut words) = (Vec::new(), String::new());
    for part in svg.split('<').skip(1) {
        let (tag, text) = part.split_once('>').expect("a tag ends");
        let name = tag.trim_start_matches('/').split([' ', '\n']).next().unwrap();
        let attributes = tag.trim_end_matches('/');
        assert!(attributes.matches('"').count().is_multiple_of(2), "{tag}");
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "{tag}");
        } else if !tag.ends_with('/') {
            open.push(name);
        }
        assert!(!text.contains('>'), "{text}");
        for of in [tag, text] {
            let mut entities = of.split('&').skip(1).map(|e| e.split(';').next().unwrap());
            assert!(entities.all(|e| ["amp", "lt", "gt", "quot", "#39"].contains(&e)), "{of}");
        }
        if tag.starts_with("text ") {
            words += &format!("{text}\n");
        }
    }
    assert!(open.is_empty(), "{open:?}");
    let plain = words.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"");
    plain.replace("&#39;", "'").replace("&amp;", "&")
}

#[test]
fn the_chain_is_drawn_with_every_stage_and_its_numbers() {
    let folder = Folder::new("explain-svg");
    let picture = folder.path("chain.svg");
    let of = |scene: &[&str], what: &[&str]| {
        let (json, _) = explained(&[scene, what, &["--out", &picture]].concat());
        let svg = std::fs::read_to_string(&picture).unwrap();
        assert!(svg.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\""), "{svg}");
        assert!(svg.contains("role=\"img\"") && !svg.contains("NaN") && !svg.contains("inf"));
        let words = words_of(&svg).replace('\u{202f}', " ");
        (json, svg, words)
    };
    let hold = |(json, svg, words): (Value, String, String)| {
        let instance = &json["instance"];
        assert!(words.contains(&format!("“{}”", instance["name"].as_str().unwrap())), "{words}");
        let mut rest = words.as_str();
        for step in instance["steps"].as_array().unwrap() {
            // In their order, from top to bottom.
            for word in ["stage", "unit", "outcome"].map(|key| step[key].as_str().unwrap()) {
                let at = rest.find(&format!("{word}\n"));
                rest = &rest[at.unwrap_or_else(|| panic!("{word} is not in {rest}"))..];
            }
            for plane in step["evidence"]["Planes"].as_array().into_iter().flatten() {
                let [near, far] = ["nearest", "farthest"].map(|key| plane[key].as_f64().unwrap());
                assert!(rest.contains(&format!("{near:.4} to {far:.4}\n")), "{plane}: {rest}");
            }
            if let Some([w, h]) = step["evidence"]["Size"]["pixels"].as_array().map(|v| &v[..]) {
                let [w, h] = [w, h].map(|v| v.as_f64().unwrap());
                assert!(rest.contains(&format!("{w:.2} x {h:.2} pixels")), "{rest}");
                assert!(rest.contains("the limit is 40 px"), "{rest}");
            }
        }
        let sentence = instance["sentence"].as_str().unwrap().replace('\u{202f}', " ");
        assert!(words.replace('\n', " ").contains(&sentence), "{sentence}: {words}");
        (instance["stage"].as_str().map(str::to_owned), svg)
    };
    for (stage, slot) in dropped_in_the_city() {
        let (dropped, svg) = hold(of(CITY, &["--instance", &format!("#{slot}")]));
        assert_eq!(dropped.as_deref(), Some(stage.name()));
        let color = cullet_draw::palette::reason_color(Some(stage));
        let color: String = color.iter().map(|v| format!("{v:02x}")).collect();
        assert!(svg.contains(&format!("fill=\"#{color}\"")), "the stage's colour");
    }
    // A pixel, with its triangle; and a size beside its limit.
    let (json, _, words) = of(CITY, &["--pixel", "80,60"]);
    let triangle = json["pixel"]["triangle"].as_u64().unwrap();
    assert!(words.contains(&format!("triangle {triangle}\n")) && words.contains("n·(eye − p)"));
    let (dropped, _) = hold(of(CITY, &["--pixel", "80,60", "--detail", "40"]));
    assert!(dropped.is_none_or(|stage| stage == "detail"));
    // Names from a file cannot become markup.
    let hostile = "o <b>&\"'</b>\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let file = folder.file("hostile.obj", hostile);
    let view = ["--eye", "0.3,0.3,3", "--target", "0.3,0.3,0", "--size", "64x64"];
    let (_, svg, words) = of(&[&[&file[..]], &view[..]].concat(), &["--instance", "#0"]);
    assert!(words.contains("<b>&\"'</b>") && !svg.contains("<b>"), "{words}");
    // Where nothing is there is nothing to explain.
    let (json, _, words) = of(&[&[&file[..]], &view[..]].concat(), &["--pixel", "0,0"]);
    assert!(json["instance"].is_null() && words.contains("nothing is there"), "{words}");
}

#[test]
fn the_record_has_what_its_schema_demands() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/schema/explain.schema.json");
    let schema: Value = serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap();
    let (json, _) = explained(&[CITY, &["--pixel", "80,60"]].concat());
    let demanded = |of: &Value| -> Vec<String> {
        let names = of["required"].as_array().into_iter().flatten();
        names.map(|name| name.as_str().unwrap().to_owned()).collect()
    };
    let holds = |value: &Value, of: &Value, place: &str| {
        let names = demanded(of);
        assert!(!names.is_empty(), "{place}");
        for name in names {
            assert!(value.get(&name).is_some(), "{place}: {name}");
        }
        // And nothing that it does not know.
        for name in value.as_object().unwrap().keys() {
            assert!(of["properties"].get(name).is_some(), "{place}: {name} is not in the schema");
        }
    };
    let parts = &schema["$defs"];
    holds(&json, &schema, "the record");
    holds(&json["view"], &parts["view"], "view");
    holds(&json["pixel"], &parts["pixel"], "pixel");
    holds(&json["instance"], &parts["instance"], "instance");
    holds(&json["instance"]["triangle"], &parts["triangle"], "triangle");
    for step in json["instance"]["steps"].as_array().unwrap() {
        holds(step, &parts["step"], "step");
        let kinds = parts["evidence"]["oneOf"].as_array().unwrap();
        let known = kinds.iter().any(|kind| match step["evidence"].as_object() {
            Some(own) => own.keys().all(|key| !kind["properties"][key].is_null()),
            None => kind["enum"].as_array().is_some_and(|all| all.contains(&step["evidence"])),
        });
        assert!(known, "{}", step["evidence"]);
    }
}

#[test]
fn what_cannot_be_explained_says_what_could() {
    let wrong = |args: &[&str], words: &[&str]| {
        let out = cullet(&[&["explain"], CITY, args].concat());
        assert_eq!(out.status.code(), Some(2), "{args:?}");
        let said = text(&out.stderr);
        for word in words {
            assert!(said.contains(word), "{args:?}: {word} is not in {said}");
        }
    };
    wrong(&["--pixel", "160,10"], &["160x90", "159,89"]);
    wrong(&["--pixel", "a"], &["640,360"]);
    wrong(&["--instance", "no such house"], &["nearest", "'"]);
    wrong(&["--instance", "#99999"], &["nearest"]);
    wrong(&["--instance", "#0", "--triangle", "99999999"], &["numbered from 0"]);
    wrong(&["--instance", "#0", "--out", "why.gif"], &[".png", ".svg"]);
    wrong(&[], &["--pixel"]);
}
