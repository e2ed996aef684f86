//! Messages of the program: numbers agree with their words, figures are readable, and a misspelt
//! name gets a suggestion.

use std::process::{Command, Output};

use cullet_testkit::Folder;
use serde_json::{Value, json};

/// Runs the program with its costs kept in `costs`, never in the user's folder.
fn with_costs(costs: &str, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cullet"));
    command.args(args).env("CULLET_COSTS", costs).output().unwrap()
}

/// Both outputs, with ordinary spaces.
fn said(output: &Output) -> String {
    let text = [&output.stdout[..], &output.stderr[..]].concat();
    String::from_utf8_lossy(&text).replace(['\u{202f}', '\u{a0}'], " ")
}

fn cullet(args: &[&str]) -> String {
    said(&with_costs("/nonexistent/costs.json", args))
}

/// Where a lone 1 stands before a plural: the words around it.
fn disagreements(text: &str) -> Vec<String> {
    text.lines().flat_map(of_line).collect()
}

fn of_line(text: &str) -> Vec<String> {
    const PLURALS: [&str; 26] = [
        "views",
        "triangles",
        "instances",
        "meshes",
        "edges",
        "vertices",
        "solids",
        "polygons",
        "boxes",
        "clusters",
        "outlines",
        "occluders",
        "warnings",
        "are",
        "have",
        "own",
        "nodes",
        "portals",
        "samples",
        "rounds",
        "regions",
        "copies",
        "directions",
        "objects",
        "threads",
        "bounds",
    ];
    let words: Vec<&str> = text.split_whitespace().collect();
    let plain = |w: &str| w.trim_matches(|c: char| !c.is_alphanumeric()).to_lowercase();
    let plural = |i: usize| words.get(i).is_some_and(|w| PLURALS.contains(&plain(w).as_str()));
    let one = |i: &usize| words[*i].trim_start_matches(['(', '|']) == "1";
    // In "2 of 1 triangles" the 1 counts; in "1 of 3 triangles" it does not.
    let wrong = |i: &usize| plural(i + 1) || plural(i + 2) && words[i + 1] != "of";
    let found = (0..words.len()).filter(one).filter(wrong);
    found.map(|i| words[i..words.len().min(i + 3)].join(" ")).collect()
}

/// One triangle that is there twice, open at each edge.
const ONE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
const TWICE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 1 2 3\nf 2 4 3\nf 1 1 2\n";

#[test]
fn a_lone_one_is_followed_by_no_plural() {
    assert_eq!(disagreements("verified in 1 views: 1 of 3 views, 2 of 1 instances").len(), 2);
    let folder = Folder::new("agree");
    let one = folder.file("one.obj", ONE);
    let twice = folder.file("twice.obj", TWICE);
    let view = ["--eye", "0.3,0.3,3", "--target", "0.3,0.3,0", "--size", "64x64", "--samples", "2"];
    for file in [&one, &twice] {
        let out = folder.path("r");
        let picture = folder.path("p.png");
        let cut = folder.path("c.glb");
        for args in [
            &[&["info", file], &[][..]].concat()[..],
            &[&["report", file, "--out", &out], &view[..]].concat(),
            &[&["report", file, "--one-sided", "--out", &out], &view[..]].concat(),
            &[&["verify", file], &view[..]].concat(),
            &["occluders", file, "--check"],
            &["cut", file, "--plane", "1,0,0,0.5", "--cap", "--out", &cut],
            &["cut", file, "--plane", "1,0,0,-5", "--cap", "--out", &cut],
            &[&["picture", "back-regions", file, "--out", &picture], &view[..6]].concat(),
        ] {
            let text = cullet(args);
            assert!(!text.is_empty() && !text.contains("Usage:"), "{args:?}: {text}");
            let wrong = disagreements(&text);
            assert!(wrong.is_empty(), "{args:?}: {wrong:?} in\n{text}");
        }
        let page = std::fs::read_to_string(folder.path("r/index.html")).unwrap();
        let text: String = page.split('<').filter_map(|t| t.split_once('>')).map(|t| t.1).collect();
        assert!(text.contains("Verified in 1 view "), "the page");
        let advice = page.split("<h3>").skip(1).filter_map(|a| a.split("</div>").next());
        let wrong: Vec<_> = advice.flat_map(disagreements).collect();
        assert!(wrong.is_empty(), "{wrong:?}");
    }
    let text = cullet(&["info", &twice]);
    assert!(text.contains("1 stored triangle is a duplicate of another"), "{text}");
    assert!(text.contains("1 stored triangle has no area"), "{text}");
    let text = cullet(&["cut", &one, "--plane", "1,0,0,-5", "--out", &folder.path("c.glb")]);
    assert!(text.contains("of 1 instance 0 are untouched"), "{text}");
    let text = cullet(&[&["report", &one, "--out", &folder.path("r")], &view[..]].concat());
    assert!(text.contains("verified in 1 view: nothing visible was lost"), "{text}");
    let text = cullet(&[&["verify", &one], &view[..]].concat());
    assert!(text.contains("over 1 view\n"), "{text}");
}

/// Costs: `t` ns for a cluster's test, 8 ns for a draw, 4 ns for a rejected triangle.
fn costs(t: f64) -> String {
    let spread = |ns: f64| json!({"ns": ns, "low": ns, "high": ns});
    json!({
        "schema": 1, "version": "0.1.0", "date": "2026-03-09", "machine": "an abacus",
        "renderer": "a painter", "rounds": 3, "t_over_r": 0.4,
        "costs": {
            "object_test": spread(1.0), "cluster_test": spread(t), "triangle_test": spread(3.0),
            "rejected_triangle": spread(4.0), "opaque_triangle": spread(5.0),
            "masked_triangle": spread(6.0), "blended_triangle": spread(7.0), "draw": spread(8.0),
        },
    })
    .to_string()
}

#[test]
fn milliseconds_are_spoken_of_only_where_culling_saves_some() {
    let folder = Folder::new("milliseconds");
    let file = folder.file("costs.json", &costs(1.0));
    let out = folder.path("r");
    let small =
        ["solids:n=20", "--views", "1", "--size", "64x64", "--samples", "1", "--costs", &file];
    let report = |more: &[&str]| {
        let text = cullet(&[&["report", "--out", &out], &small[..], more].concat());
        (text, std::fs::read_to_string(folder.path("r/index.html")).unwrap())
    };
    let (text, page) = report(&[]);
    assert!(text.contains("culling saves ") && text.contains("Milliseconds are"), "{text}");
    assert!(page.contains("Milliseconds are"));
    for text in [&text, &page] {
        assert!(!text.contains("about under"), "a bound is not about: {text}");
    }
    let (text, page) = report(&[
        "--no-frustum",
        "--no-portal",
        "--no-occlusion",
        "--no-backface",
        "--no-degenerate",
    ]);
    assert!(text.contains("removes 0 % of all"), "{text}");
    assert!(!text.contains("Milliseconds") && !text.contains("calibrate"), "{text}");
    assert!(!page.contains("Milliseconds"));
}

#[test]
fn what_fails_if_says_so_in_figures_that_people_read() {
    let folder = Folder::new("fail-if");
    let args =
        ["report", "solids:n=20", "--views", "1", "--size", "64x64", "--samples", "1", "--out"];
    let text = cullet(&[&args[..], &[&folder.path("r"), "--fail-if", "tightness>1"]].concat());
    let figure = text.split("holds: it is ").nth(1).and_then(|t| t.split(", against 1").next());
    let figure = figure.unwrap_or_else(|| panic!("{text}"));
    assert!(figure.parse::<f64>().unwrap() > 1.0 && figure.len() <= 6, "{figure}");
}

#[test]
fn a_slip_finds_what_was_meant() {
    let out = with_costs("", &["report", "ctiy"]);
    assert_eq!(out.status.code(), Some(3));
    assert_eq!(said(&out), "error: there is no file ctiy; did you mean the built-in scene city?\n");
    for (args, code, meant) in [
        (&["info", "offcie:seed=3"][..], 3, "did you mean the built-in scene office?"),
        (
            &["report", "city:cels=3"],
            2,
            "has no key 'cels' (did you mean 'cells'?); its keys are seed,",
        ),
        (
            &["info", "https://example.org/a.glb"],
            3,
            "a.glb: addresses are not fetched; download it",
        ),
        (&["picture", "kindz"], 2, "a similar value exists: 'kinds'"),
        (&["repotr"], 2, "'report'"),
    ] {
        let out = with_costs("", args);
        assert_eq!(out.status.code(), Some(code), "{args:?}");
        assert!(said(&out).contains(meant), "{args:?}: {}", said(&out));
    }
    let text = cullet(&["info", "models/city.glb"]);
    assert!(
        text.contains("there is no file models/city.glb; the built-in scenes are city,"),
        "{text}"
    );
}

#[test]
fn clusters_are_made_for_the_costs_that_were_measured() {
    let folder = Folder::new("clusters");
    // A test and a draw cost 2.1 and 200 rejected triangles.
    let [cheap, dear] = [0.4, 792.0].map(|t| folder.file(&format!("t{t}.json"), &costs(t)));
    let picture = folder.path("clusters.png");
    let draw = |kept: &str, more: &[&str]| {
        let args = ["picture", "clusters", "knobs:n=12", "--size", "160x90", "--out", &picture];
        let out = with_costs(kept, &[&args[..], more].concat());
        assert_eq!(out.status.code(), Some(0), "{}", said(&out));
        (said(&out), std::fs::read(&picture).unwrap())
    };
    let none = "/nonexistent/costs.json";
    let (text, by_default) = draw(none, &[]);
    assert!(
        text.contains("clusters for t/r = 16, the default; `cullet calibrate` measures"),
        "{text}"
    );
    let (text, for_cheap) = draw(&cheap, &[]);
    let from = "as measured on another machine on 2026-03-09";
    let told =
        "clusters for t/r = 2.1: 0.40 ns for a cluster's test and 8.0 ns for a draw over 4.0 ns";
    assert!(text.contains(told) && text.contains(from) && text.contains(&cheap), "{text}");
    let (text, for_dear) = draw(&dear, &[]);
    assert!(text.contains("t/r = 200") && text.contains(&dear), "{text}");
    assert!(for_cheap != for_dear && for_cheap != by_default && for_dear != by_default);
    // Kept, named, or given: the same clusters.
    assert!(draw(none, &["--costs", &cheap]).1 == for_cheap);
    assert!(draw(&dear, &["--test-cost", "2.1"]).1 == for_cheap);
    assert!(draw(&dear, &["--test-cost", "16"]).1 == by_default);
    let clusters = |costs: &str| {
        let args =
            ["reproduce", "johannsen-carter", "knobs:n=12", "--directions", "1", "--json", "-"];
        let out = with_costs(costs, &args);
        assert_eq!(out.status.code(), Some(0), "{}", said(&out));
        let record: Value = serde_json::from_slice(&out.stdout).unwrap();
        (record["clusters"].as_u64().unwrap(), record["test_cost"].as_f64().unwrap())
    };
    let [(many, low), (usual, 16.0), (few, 200.0)] = [&cheap, none, &dear].map(clusters) else {
        panic!("the costs that are kept do not reach the clusters");
    };
    assert!((low - 2.1).abs() < 1e-9 && many > usual && usual >= few, "{many} {usual} {few}");
}

#[test]
fn costs_that_clusters_cannot_be_made_for_are_refused() {
    let folder = Folder::new("refused");
    let picture = folder.path("clusters.png");
    let run = |kept: &str, more: &[&str]| {
        let args = ["picture", "clusters", "knobs:n=2", "--size", "64x64", "--out", &picture];
        let out = with_costs(kept, &[&args[..], more].concat());
        (out.status.code(), said(&out))
    };
    let none = "/nonexistent/costs.json";
    for bad in ["-1", "nan", "1e7", "x"] {
        let (code, text) = run(none, &[&format!("--test-cost={bad}")]);
        assert!(code == Some(2) && text.contains("0 to 1e6; try 16"), "{bad}: {text}");
    }
    let missing = folder.path("none.json");
    let (code, text) = run(none, &["--costs", &missing]);
    assert!(code == Some(3) && text.contains("there is no such file"), "{text}");
    let huge = folder.file("huge.json", &costs(1e9));
    let (code, text) = run(&huge, &[]);
    assert!(code == Some(3) && text.contains("t/r = 2.500e8") && text.contains(&huge), "{text}");
    assert!(!std::path::Path::new(&picture).exists());
}
