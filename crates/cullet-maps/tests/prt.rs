//! Portal graphs: the variants of the format, real maps, and files that are none.

use cullet_maps::PrtVariant;
use cullet_maps::load_prt;
use cullet_maps::load_prt_bytes;
use cullet_testkit::data;

/// A square at x, wound so that its normal by the right hand points down the axis.
fn square(x: u32) -> String {
    format!("({x} 0 0 ) ({x} 0 1 ) ({x} 1 1 ) ({x} 1 0 ) ")
}

/// Two portals in a row: cells 0, 1 and 2 along x.
fn portals() -> String {
    format!("4 0 1 {}\n4 1 2 {}\n", square(1), square(2))
}

fn error(text: &str) -> String {
    load_prt_bytes("a.prt", text.as_bytes()).unwrap_err().to_string()
}

#[test]
fn every_variant_has_the_same_graph() {
    let portals = portals();
    let hinted = portals.replacen("4 0 1 (", "4 0 1 0 (", 1).replacen("4 1 2 (", "4 1 2 1 (", 1);
    let files = [
        (PrtVariant::Prt1, format!("PRT1\n3\n2\n{portals}"), vec![0, 1, 2]),
        (PrtVariant::Quake3, format!("PRT1\n3\n2\n1\n{hinted}4 2 {}\n", square(9)), vec![0, 1, 2]),
        (
            PrtVariant::Prt2,
            format!("PRT2\n4\n3\n2\n{portals}3 0 -1\n1 -1\n2 -1\n"),
            vec![0, 1, 2, 0],
        ),
        (PrtVariant::Prt1Am, format!("PRT1-AM\n3\n2\n4\n{portals}0\n2\n1\n0\n"), vec![0, 2, 1, 0]),
    ];
    for (variant, text, leafs) in files {
        for text in [text.clone(), text.replace('\n', "\r\n"), text.replace(" )", ")")] {
            let prt = load_prt_bytes("a.prt", text.as_bytes()).unwrap();
            assert_eq!((prt.variant, prt.turned), (variant, 0));
            assert_eq!(prt.leaf_clusters, leafs);
            let graph = &prt.graph;
            assert_eq!((graph.cell_count(), graph.portals().len()), (3, 2));
            // The first cell is on the side of the normal.
            assert_eq!(graph.plane(0).normal, [-1.0, 0.0, 0.0]);
            assert_eq!(graph.portals()[1].cells, [1, 2]);
        }
    }
}

#[test]
fn a_portal_that_is_wound_against_its_cells_is_turned() {
    let text = format!("PRT1\n4\n3\n{}4 3 2 {}\n", portals(), square(3));
    let prt = load_prt_bytes("a.prt", text.as_bytes()).unwrap();
    assert_eq!(prt.turned, 1);
    assert_eq!(prt.graph.portals()[2].cells, [3, 2]);
    assert_eq!(prt.graph.plane(2).normal, [1.0, 0.0, 0.0]);
}

#[test]
fn errors_name_file_line_portal_and_value() {
    let portals = portals();
    for (text, words) in [
        ("PRT3\n1\n1\n".to_owned(), "a.prt: it begins with \"PRT3\""),
        (String::new(), "it begins with \"\""),
        ("PRT1\nx\n".to_owned(), "a.prt: line 2: expected the number of clusters, found \"x\""),
        (
            "PRT1\n3\n900\n1 2".to_owned(),
            "line 3: 900 portals, but the 4 bytes left hold at most 0",
        ),
        ("PRT1\n99\n0\n".to_owned(), "line 2: 99 clusters, but the 3 bytes left"),
        ("PRT1\n-3\n0\n".to_owned(), "line 2: -3 clusters"),
        (format!("PRT1\n2\n2\n{portals}"), "line 5: portal 1 joins cell 2, of 2 cells"),
        (
            format!("PRT1\n3\n2\n{}", portals.replacen("4 1 2", "4 1 1", 1)),
            "portal 1 joins cell 1 with itself",
        ),
        (
            format!("PRT1\n3\n2\n{}", portals.replacen("4 0 1", "2 0 1", 1)),
            "line 4: portal 0 has 2 corners",
        ),
        (
            format!("PRT1\n3\n2\n{}", portals.replacen("4 0 1", "999 0 1", 1)),
            "portal 0 has 999 corners; 3 to",
        ),
        (
            format!("PRT1\n3\n2\n{}", portals.replacen("4 0 1", "4 -1 1", 1)),
            "portal 0 names cluster -1",
        ),
        (
            format!("PRT1\n3\n2\n{}", portals.replacen("(1 0 1 )", "(1 nan 1 )", 1)),
            "expected a coordinate of portal 0, found \"nan\"",
        ),
        (
            format!("PRT1\n3\n2\n{}", portals.replacen("(1 0 1 )", "(5 0 1 )", 1)),
            "line 4: portal 0 is not planar",
        ),
        (
            format!("PRT1\n3\n2\n{}", portals.replacen("(1 0 1 )", "1 0 1 )", 1)),
            "expected the parenthesis before a corner of portal 0, found \"1\"",
        ),
        (format!("PRT1\n3\n2\n{portals}7"), "line 6: expected the end of the file, found \"7\""),
        (
            format!("PRT2\n3\n3\n2\n{portals}0 1 -1\n1 -1\n2 -1\n"),
            "line 8: leaf 1 is in clusters 0 and 1",
        ),
        (
            format!("PRT2\n3\n3\n2\n{portals}0 -1\n1 -1\n3 -1\n"),
            "line 9: cluster 2 has leaf 3, of 3",
        ),
        (format!("PRT2\n3\n3\n2\n{portals}0 -1\n1 -1\n-1\n"), "leaf 2 is in no cluster"),
        (format!("PRT1-AM\n3\n2\n2\n{portals}0\n3\n"), "line 8: leaf 1 is in cluster 3, of 3"),
    ] {
        let error = error(&text);
        assert!(error.contains(words), "{words:?} is not in {error:?}");
    }
}

#[test]
fn a_file_that_is_cut_anywhere_is_an_error_or_still_whole() {
    let text = format!("PRT2\n4\n3\n2\n{}3 0 -1\n1 -1\n2 -1\n", portals());
    let end = text.trim_end().len();
    for cut in 0..end {
        // The last number may lose nothing but its end of line.
        assert!(load_prt_bytes("a.prt", &text.as_bytes()[..cut]).is_err(), "cut at {cut}");
    }
    assert!(load_prt_bytes("a.prt", &text.as_bytes()[..end]).is_ok());
}

#[test]
fn every_real_map_loads_with_the_counts_that_its_compiler_states() {
    let Some(folder) = data("portals") else { return };
    let mut seen = 0;
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.extension().is_none_or(|e| e != "prt") {
            continue;
        }
        let prt = load_prt(&path).unwrap_or_else(|e| panic!("{e}"));
        let text = std::fs::read_to_string(path.with_extension("vis.txt")).unwrap();
        let full = text.lines().find(|line| line.starts_with("full:")).unwrap();
        let stated = |key: &str| -> usize {
            let word = full.split(' ').find_map(|word| word.strip_prefix(key)).unwrap();
            word.parse().unwrap()
        };
        assert_eq!(prt.leaf_clusters.len(), stated("leafs="), "{}", path.display());
        assert_eq!(prt.graph.cell_count() as usize, stated("clusters="), "{}", path.display());
        assert_eq!(prt.graph.portals().len(), stated("portals="), "{}", path.display());
        assert_eq!(prt.turned, 0, "{}", path.display());
        seen += 1;
    }
    assert!(seen >= 13, "{seen} portal graphs");
}
