//! Report on meshes with outlines that do not close, and what to try.

use cullet_command::console::{agree, count, grouped};
use cullet_cut::OpenMesh;

/// How many meshes a warning names; the record has all.
const NAMED: usize = 5;

/// The warning: how many, the meshes with the most, and what has not been tried yet.
pub(super) fn lines(list: &[OpenMesh], welded: bool, healed: bool) -> Vec<String> {
    if list.is_empty() {
        return Vec::new();
    }
    let sum = |of: fn(&OpenMesh) -> u64| list.iter().map(of).sum();
    let chains = sum(|m| m.open_chains);
    let mut lines = vec![format!(
        "warning: {} of {} {} no cap, in {}:",
        count(chains, "outline", "outlines"),
        count(sum(|m| m.open_edges), "edge", "edges"),
        agree(chains, "does not close and has", "do not close and have"),
        count(list.len() as u64, "mesh", "meshes")
    )];
    let mut most: Vec<&OpenMesh> = list.iter().collect();
    most.sort_by_key(|m| std::cmp::Reverse(m.open_chains));
    for m in most.iter().take(NAMED) {
        let name = match m.name.as_str() {
            "" => format!("number {}", m.mesh),
            name => format!("`{name}`"),
        };
        let edges = [
            (m.boundary_edges, "of one triangle only"),
            (m.non_manifold_edges, "of more than two"),
        ];
        let found: Vec<String> = edges
            .iter()
            .filter(|e| e.0 > 0)
            .map(|(n, what)| format!("{} {what}", count(u64::from(*n), "edge", "edges")))
            .collect();
        let before = match found.is_empty() {
            true => String::new(),
            false => format!("; it came with {}", found.join(" and ")),
        };
        lines.push(format!(
            "  mesh {name}: {}{before}",
            count(m.open_chains, "outline", "outlines")
        ));
    }
    if most.len() > NAMED {
        let rest = grouped((most.len() - NAMED) as u64);
        lines.push(format!("  and {rest} more: --json names them all"));
    }
    let weld = match welded {
        true => "a larger --weld closes wider seams",
        false => "--weld DISTANCE closes seams that do not quite meet",
    };
    let heal = match healed {
        true => "a larger --heal joins ends further apart",
        false => "--heal DISTANCE joins ends across a gap",
    };
    lines.push(format!("  {weld}; {heal}"));
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_come_first_and_the_advice_is_what_was_not_tried() {
        let mesh = |number: usize, name: &str, open_chains: u64| OpenMesh {
            mesh: number,
            name: name.into(),
            open_chains,
            open_edges: 3 * open_chains,
            boundary_edges: 12,
            non_manifold_edges: 0,
        };
        let mut list: Vec<OpenMesh> = (0..5).map(|n| mesh(n, "hull", 1)).collect();
        list.push(mesh(5, "", 7));
        let found = lines(&list, true, false);
        assert!(found[0].contains("12 outlines of 36 edges") && found[0].contains("in 6 meshes"));
        assert_eq!(
            found[1],
            "  mesh number 5: 7 outlines; it came with 12 edges of one triangle only"
        );
        assert!(found[2].starts_with("  mesh `hull`: 1 outline; "));
        assert_eq!(found[6], "  and 1 more: --json names them all");
        assert!(found[7].contains("a larger --weld") && found[7].contains("--heal DISTANCE"));
        list.truncate(1);
        list[0].boundary_edges = 1;
        let found = lines(&list, true, false);
        assert_eq!(
            found[0],
            "warning: 1 outline of 3 edges does not close and has no cap, in 1 mesh:"
        );
        assert!(found[1].ends_with("it came with 1 edge of one triangle only"), "{}", found[1]);
        assert!(lines(&[], false, false).is_empty());
    }
}
