//! Which meshes have outlines that do not close, and what to try.

use cullet::Mesh;
use cullet::clip::cut::CutReport;
use cullet::mesh::Topology;
use serde::Serialize;

use crate::console::{agree, count, grouped};

/// How many meshes a warning names; the record has all.
const NAMED: usize = 5;

/// A mesh with outlines at the cut that do not close.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct OpenMesh {
    mesh: usize,
    name: String,
    /// Over all its instances that were cut.
    open_chains: u64,
    open_edges: u64,
    /// Edges of one triangle, before the cut.
    boundary_edges: u32,
    /// Edges of more than two triangles, before the cut.
    non_manifold_edges: u32,
}

impl OpenMesh {
    /// Adds what the cut of one instance found. Where that is an open outline, the mesh is looked at as it
    /// was before the cut, once.
    pub(super) fn note(
        list: &mut Vec<Self>,
        number: usize,
        name: &str,
        mesh: &Mesh,
        report: &CutReport,
    ) {
        if report.open_chains == 0 {
            return;
        }
        let at = list.iter().position(|m| m.mesh == number).unwrap_or_else(|| {
            let topology = Topology::of(mesh.positions(), mesh.indices());
            list.push(Self {
                mesh: number,
                name: name.into(),
                open_chains: 0,
                open_edges: 0,
                boundary_edges: topology.boundary_edges,
                non_manifold_edges: topology.non_manifold_edges,
            });
            list.len() - 1
        });
        list[at].open_chains += report.open_chains as u64;
        list[at].open_edges += report.open_edges as u64;
    }

    /// The warning: how many, the meshes with the most, and what has not been tried yet.
    pub(super) fn lines(list: &[Self], welded: bool, healed: bool) -> Vec<String> {
        if list.is_empty() {
            return Vec::new();
        }
        let sum = |of: fn(&Self) -> u64| list.iter().map(of).sum();
        let chains = sum(|m| m.open_chains);
        let mut lines = vec![format!(
            "warning: {} of {} {} no cap, in {}:",
            count(chains, "outline", "outlines"),
            count(sum(|m| m.open_edges), "edge", "edges"),
            agree(chains, "does not close and has", "do not close and have"),
            count(list.len() as u64, "mesh", "meshes")
        )];
        let mut most: Vec<&Self> = list.iter().collect();
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
        let lines = OpenMesh::lines(&list, true, false);
        assert!(lines[0].contains("12 outlines of 36 edges") && lines[0].contains("in 6 meshes"));
        assert_eq!(
            lines[1],
            "  mesh number 5: 7 outlines; it came with 12 edges of one triangle only"
        );
        assert!(lines[2].starts_with("  mesh `hull`: 1 outline; "));
        assert_eq!(lines[6], "  and 1 more: --json names them all");
        assert!(lines[7].contains("a larger --weld") && lines[7].contains("--heal DISTANCE"));
        list.truncate(1);
        list[0].boundary_edges = 1;
        let lines = OpenMesh::lines(&list, true, false);
        assert_eq!(
            lines[0],
            "warning: 1 outline of 3 edges does not close and has no cap, in 1 mesh:"
        );
        assert!(lines[1].ends_with("it came with 1 edge of one triangle only"), "{}", lines[1]);
        assert!(OpenMesh::lines(&[], false, false).is_empty());
    }
}
