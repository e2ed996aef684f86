//! The bindings, each built and tested in the host that it is for: `cargo xtask bindings [NAME]`,
//! and steps of `test`.

mod bevy;
mod c;
mod godot;
pub(crate) mod golden;
pub(crate) mod python;
pub(crate) mod web;

use crate::runner::{self, Step};
use crate::tools::Done;

/// The steps: the shared answers first, for every host is held against them.
pub(crate) const STEPS: &[Step] = &[
    Step { name: "golden", run: golden::test },
    Step { name: "host-c", run: c::test },
    Step { name: "host-python", run: python::test },
    Step { name: "host-web", run: web::test },
    Step { name: "host-bevy", run: bevy::test },
    Step { name: "host-godot", run: godot::test },
];

/// Makes the shared answers, then builds and tests the bindings whose name contains `filter`.
pub(crate) fn test(filter: &str) -> Done {
    let is_chosen = |step: &&Step| step.name == "golden" || step.name.contains(filter);
    let chosen: Vec<Step> = STEPS.iter().filter(is_chosen).copied().collect();
    if chosen.len() == 1 && !"golden".contains(filter) {
        let names: Vec<_> = STEPS.iter().map(|s| s.name).collect();
        return Err(format!("no binding is called {filter}; there are {}", names.join(", ")));
    }
    runner::run(&chosen, "")
}
