//! `cullet pvs` as its users meet it: its outputs, its units, its messages and exit codes.

use std::path::Path;
use std::process::{Command, Output};

use cullet_cells::pvs::VisibleSets;
use cullet_io::baked::SceneSets;
use cullet_maps::bsp::Bsp;
use cullet_testkit::{Folder, data};
use serde_json::Value;

fn cullet(args: &[&str]) -> Output {
    let all = [&["pvs"], args].concat();
    Command::new(env!("CARGO_BIN_EXE_cullet")).args(all).output().unwrap()
}

/// Both outputs, with ordinary spaces.
fn said(out: &Output) -> String {
    let text = [&out.stdout[..], &out.stderr[..]].concat();
    String::from_utf8_lossy(&text).replace('\u{202f}', " ")
}

/// Rooms in a row, each door higher than the one before, and a side room at each.
fn map(folder: &Folder) -> String {
    let mut portals = Vec::new();
    for k in 0..12_u32 {
        let (x, y) = (10 * k + 10, 3 * k);
        let top = y + 4;
        portals.push(format!(
            "4 {k} {} ({x} {y} 0 ) ({x} {y} 8 ) ({x} {top} 8 ) ({x} {top} 0 )\n",
            k + 1
        ));
        let (z, a, b, side) = (9, x - 9, x - 1, 13 + k);
        portals.push(format!(
            "4 {k} {side} ({a} {y} {z} ) ({a} {top} {z} ) ({b} {top} {z} ) ({b} {y} {z} )\n"
        ));
    }
    let path = folder.path("rooms.prt");
    std::fs::write(&path, format!("PRT1\n25\n{}\n{}", portals.len(), portals.concat())).unwrap();
    path
}

#[test]
fn a_bake_states_its_pairs_writes_its_rows_and_is_the_same_on_threads_and_in_units() {
    let folder = Folder::new("same");
    let map = map(&folder);
    let (rows, sets) = (folder.path("one.pvs"), folder.path("one.cpvs"));
    let out = cullet(&[
        &map,
        "--json",
        "-",
        "--rows",
        &rows,
        "-o",
        &sets,
        "--threads",
        "1",
        "--check",
        "20000",
    ]);
    assert_eq!(out.status.code(), Some(0), "{}", said(&out));
    let json: Value = serde_json::from_slice(&out.stdout).unwrap();
    let number = |key: &str| json[key].as_u64().unwrap();
    assert_eq!((number("schema"), number("cells"), number("portals")), (1, 25, 24));
    assert_eq!(number("visible_pairs"), number("proven_visible") + number("undecided"));
    assert!(
        number("visible_pairs") >= 48 && number("visible_pairs") < number("candidates"),
        "{json}"
    );
    assert!(number("candidates") < 25 * 24 && number("peak_bytes") > 0);
    assert!(json["cpu_seconds"].is_f64() && json["wall_seconds"].is_f64());
    assert_eq!((&json["check"]["lines"], &json["check"]["missed"]), (&20_000.into(), &0.into()));
    let bytes = std::fs::read(&rows).unwrap();
    assert_eq!((&bytes[..8], bytes.len()), (&b"PVSROWS1"[..], 16 + 25 * 4));
    let ones: u32 = bytes[16..].iter().map(|b| b.count_ones()).sum();
    assert_eq!(u64::from(ones), number("visible_pairs") + 25);
    let whole = std::fs::read(&sets).unwrap();
    let again = folder.path("again.cpvs");
    for threads in ["2", "8"] {
        let out = cullet(&[&map, "-o", &again, "--threads", threads]);
        assert_eq!(out.status.code(), Some(0), "{}", said(&out));
        assert!(std::fs::read(&again).unwrap() == whole, "{threads} threads");
    }
    let units = folder.path("units");
    for share in ["2/3", "1/3", "3/3"] {
        let out = cullet(&[&map, "--unit", share, "--units", &units]);
        assert_eq!(out.status.code(), Some(0), "{}", said(&out));
        assert!(
            said(&out).contains("join them by the same command with --resume"),
            "{}",
            said(&out)
        );
    }
    let out = cullet(&[&map, "--resume", "--units", &units, "-o", &again, "--json", "-"]);
    assert_eq!(out.status.code(), Some(0), "{}", said(&out));
    assert!(std::fs::read(&again).unwrap() == whole, "units");
    let joined: Value = serde_json::from_slice(&out.stdout).unwrap();
    assert_eq!(joined["bytes_hash"], json["bytes_hash"]);
}

#[test]
fn sampled_sets_come_from_units_too_and_verify_holds_them_against_what_they_state() {
    let folder = Folder::new("sampled");
    let town = "city:cells=4,objects=60";
    let bake = |more: &[&str]| {
        let fixed =
            [town, "--view-cells", "12", "--heights", "1..2.5", "--missing", "0", "--threads", "1"];
        cullet(&[&fixed, more].concat())
    };
    let (whole, joined, units) =
        (folder.path("whole.cpvs"), folder.path("joined.cpvs"), folder.path("units"));
    let out = bake(&["--rays", "300000", "-o", &whole]);
    assert_eq!(out.status.code(), Some(0), "{}", said(&out));
    for share in ["2/2", "1/2"] {
        let out = bake(&["--rays", "300000", "--unit", share, "--units", &units]);
        assert_eq!(out.status.code(), Some(0), "{}", said(&out));
        assert!(
            said(&out).contains(&format!("share {} of 2 is done", &share[..1])),
            "{}",
            said(&out)
        );
    }
    let out = bake(&["--rays", "300000", "--resume", "--units", &units, "-o", &joined]);
    assert_eq!(out.status.code(), Some(0), "{}", said(&out));
    assert!(std::fs::read(&joined).unwrap() == std::fs::read(&whole).unwrap());
    let verify = |sets: &str| {
        Command::new(env!("CARGO_BIN_EXE_cullet"))
            .args([
                "verify", town, "--pvs", sets, "--only", "pvs", "--path", "walk", "--views", "4",
            ])
            .args(["--size", "160x120", "--samples", "1", "--json", "-"])
            .output()
            .unwrap()
    };
    let out = verify(&whole);
    assert_eq!(out.status.code(), Some(0), "{}", said(&out));
    let json: Value = serde_json::from_slice(&out.stdout).unwrap();
    let stated = &json["stated"];
    assert_eq!(stated["pixels"], 4 * 160 * 120);
    assert!(stated["mean"].as_f64() <= stated["worst"].as_f64(), "{stated}");
    assert!(said(&out).contains("within the stated error"), "{}", said(&out));
    // Sets of nothing that state to lack nothing: more is lost than is stated.
    let sets = SceneSets::from_bytes(&std::fs::read(&whole).unwrap()).unwrap();
    let none = vec![0_u64; (sets.sets.target_count() as usize).div_ceil(64)];
    let empty = SceneSets {
        sets: VisibleSets::from_rows(
            sets.sets.targets(),
            sets.sets.target_count(),
            sets.cells.iter().map(|_| &none[..]),
        ),
        missing: vec![0.0; sets.cells.len()],
        ..sets
    };
    let worse = folder.path("worse.cpvs");
    std::fs::write(&worse, empty.to_bytes()).unwrap();
    let out = verify(&worse);
    assert_eq!(out.status.code(), Some(1), "{}", said(&out));
    assert!(said(&out).contains("ABOVE THE STATED ERROR"), "{}", said(&out));
}

#[test]
fn a_preset_is_quicker_and_keeps_more() {
    let folder = Folder::new("preset");
    let map = map(&folder);
    let pairs = |preset: &str| {
        let out = cullet(&[&map, "--preset", preset, "--json", "-"]);
        let json: Value = serde_json::from_slice(&out.stdout).unwrap();
        json["visible_pairs"].as_u64().unwrap()
    };
    assert!(pairs("fast") > pairs("full"));
}

#[test]
fn wrong_files_and_command_lines_say_why() {
    let folder = Folder::new("wrong");
    let map = map(&folder);
    let cut = folder.path("cut.prt");
    let text = std::fs::read_to_string(&map).unwrap();
    std::fs::write(&cut, &text[..text.len() / 2]).unwrap();
    for (args, code, words) in [
        (&["no-such.prt"][..], 3, "no-such.prt: cannot be read"),
        (&[&cut], 3, "cut.prt: line"),
        (&[&map, "--unit", "4/3"], 2, "'4/3' is not I/N"),
        (&[&map, "--unit", "1/3", "--json", "-"], 2, "cannot be used with"),
        (&[&map, "--tolerance", "1"], 2, "try 1e-6"),
        (&[&map, "--preset", "slow"], 2, "slow"),
        (&[&map, "--margin", "1"], 2, "--check"),
        (&[&map, "-o", "/nonexistent/folder/x"], 2, "no folder /nonexistent/folder"),
    ] {
        let out = cullet(args);
        assert_eq!(out.status.code(), Some(code), "{args:?}: {}", said(&out));
        assert!(said(&out).contains(words), "{words} is not in {}", said(&out));
    }
}

/// Bakes a map into another; what stands in its rows, cell by cell.
fn baked(folder: &Folder, from: &str) -> (Bsp, Vec<u8>) {
    let (to, rows) = (folder.path("baked.bsp"), folder.path("baked.pvs"));
    let out = cullet(&[from, "-o", &to, "--rows", &rows, "--check", "20000"]);
    assert_eq!(out.status.code(), Some(0), "{}", said(&out));
    (Bsp::open(to.as_ref()).unwrap(), std::fs::read(rows).unwrap())
}

/// The rows of a map as they stand in it.
fn stored(map: &Bsp) -> Vec<u8> {
    let mut rows = Vec::new();
    (0..map.cell_count()).for_each(|cell| map.cell_row_into(cell, &mut rows));
    rows
}

#[test]
fn a_map_is_baked_with_one_command_and_has_what_was_found() {
    let folder = Folder::new("map");
    let seeds = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/seeds/bsp");
    for name in ["quake", "bsp2", "unbaked"] {
        let from = seeds.join(name).to_string_lossy().into_owned();
        let (after, rows) = baked(&folder, &from);
        assert_eq!(after.cell_count(), 2);
        assert_eq!((stored(&after), &rows[16..]), (vec![3, 3], &[3, 3][..]), "{name}");
    }
    // A portal graph has no map around it.
    let graph = map(&folder);
    let out = cullet(&[&graph, "-o", &folder.path("no.bsp")]);
    assert_eq!(out.status.code(), Some(2), "{}", said(&out));
    assert!(said(&out).contains("no map to write the sets into"), "{}", said(&out));
}

#[test]
fn real_maps_keep_no_less_than_lines_prove_and_hardly_more_than_their_compiler() {
    let Some(folder_of_data) = data("quake-libre") else { return };
    let folder = Folder::new("real");
    for name in ["start", "lqdm1", "lqdm2"] {
        let path = folder_of_data.join(format!("{name}.bsp"));
        let before = Bsp::open(&path).unwrap();
        let (after, rows) = baked(&folder, &path.to_string_lossy());
        assert_eq!(stored(&after), rows[16..], "{name}");
        let ones = |rows: Vec<u8>| rows.iter().map(|b| f64::from(b.count_ones())).sum::<f64>();
        let ratio = ones(stored(&after)) / ones(stored(&before));
        assert!((0.9..1.01).contains(&ratio), "{name}: {ratio}");
    }
}
