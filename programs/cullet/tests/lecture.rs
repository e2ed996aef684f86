//! Lectures and exercises, as one types them.

use std::process::{Command, Output};

use cullet_testkit::Folder;
use serde_json::Value;

fn cullet(args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cullet"));
    if let Some(data) = cullet_testkit::data("") {
        command.env("CULLET_DATA", data);
    }
    command.args(args).output().expect("the program")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned()
}

#[test]
fn texts_items_and_what_they_measure_are_shown() {
    let texts = said(&cullet(&["lecture"]));
    for name in ["zachmann", "ucsd", "kaist", "zhang-hoff"] {
        assert!(texts.contains(name), "{texts}");
        let list = cullet(&["lecture", name]);
        assert!(list.status.success() && said(&list).lines().count() > 10, "{}", said(&list));
    }
    let one = cullet(&["lecture", "zachmann", "21"]);
    assert_eq!(one.status.code(), Some(0));
    let text = said(&one);
    for part in
        ["21. ", "slide 10", "claim", "said", "here", "test", "try", "see", "read", "-4 and 5"]
    {
        assert!(text.contains(part), "{part}: {text}");
    }
    let missing = cullet(&["lecture", "999"]);
    assert_eq!(missing.status.code(), Some(2), "{}", said(&missing));
}

#[test]
fn what_commands_show_is_measured_and_written() {
    let folder = Folder::new("lecture-check");
    let path = |name: &str| folder.root().join(name).display().to_string();
    let (page, json) = (path("page.md"), path("items.json"));
    let words = ["lecture", "power plant", "--check", "--page", &page, "--json", &json];
    let checked = cullet(&words);
    assert_eq!(checked.status.code(), Some(0), "{}", said(&checked));
    assert!(said(&checked).contains("  84  differs"), "{}", said(&checked));
    let text = std::fs::read_to_string(&json).expect("JSON");
    let record: Value = serde_json::from_str(&text).expect("JSON");
    let [item] = &record["items"].as_array().expect("a list")[..] else { panic!("{record}") };
    assert_eq!((&item["number"], &item["found"]["outcome"]), (&84.into(), &"differs".into()));
    let page = std::fs::read_to_string(&page).expect("the page");
    assert!(page.contains("### 1. ") && page.contains("### 101. "), "all items are in the page");
}

#[test]
fn answers_of_exercises_are_judged() {
    let all = cullet(&["quiz"]);
    assert!(all.status.success() && said(&all).contains("frustum-1"), "{}", said(&all));
    let solved = said(&cullet(&["quiz", "why-1", "--solve"]));
    assert!(solved.contains("2.4"), "{solved}");
    for (exercise, answer, code, words) in [
        ("why-1", "2.4", 0, "Right"),
        ("why-1", "2.5", 1, "Near, but not right"),
        ("why-1", "7", 1, "Not right"),
        ("why-1", "many", 2, "a number"),
        ("frustum-4", "-1", 0, "Right"),
        ("clusters-2", "-0.111", 0, "Right"),
    ] {
        let judged = cullet(&["quiz", exercise, answer]);
        assert_eq!(judged.status.code(), Some(code), "{}", said(&judged));
        assert!(said(&judged).contains(words), "{}", said(&judged));
    }
    let choice = cullet(&["quiz", "why-3", "perhaps"]);
    assert!(
        choice.status.code() == Some(2) && said(&choice).contains("yes, no"),
        "{}",
        said(&choice)
    );
    assert_eq!(cullet(&["quiz", "why-99"]).status.code(), Some(2));
}
