//! Rooms that see each other: a graph of cells and portals, its sets, and what proves them.

use cullet_bake::pvs::{PairState, PvsSettings, bake};
use cullet_cells::cell::{CellGraph, Portal};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Six rooms along x, each 4 wide; the doors are not in line.
    let door = |room: u32, y: f64| {
        let x = 4.0 * f64::from(room + 1);
        let polygon = vec![[x, y, 0.0], [x, y, 2.0], [x, y + 1.0, 2.0], [x, y + 1.0, 0.0]];
        Portal { cells: [room, room + 1], polygon }
    };
    let doors = [0.0, 2.6, 2.9, 0.4, 1.2].iter().zip(0..).map(|(&y, room)| door(room, y)).collect();
    let graph = CellGraph::new(6, doors)?;
    let pvs = bake(&graph, &PvsSettings::default(), 1);
    println!("who sees whom: # proven by a line, ? undecided and kept, . hidden");
    for a in 0..6 {
        let row: String = (0..6)
            .map(|b| match pvs.state(a, b) {
                PairState::Visible => '#',
                PairState::Undecided => '?',
                PairState::Hidden => '.',
            })
            .collect();
        println!("room {a}: {row}");
    }
    println!("{} lines prove it; followed again, they prove the same:", pvs.witnesses().len());
    println!("{}", pvs.prove_again(&graph)? == *pvs.proven());
    Ok(())
}
