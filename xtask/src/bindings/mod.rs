//! The bindings, each built and tested in the host that it is for: `cargo xtask bindings [NAME]`,
//! and steps of `test`.

pub(crate) mod bevy;
pub(crate) mod c;
mod csharp;
pub(crate) mod godot;
pub(crate) mod golden;
pub(crate) mod python;
pub(crate) mod web;

use crate::runner::{self, Step};
use crate::tools::Done;

/// The steps: the shared answers first, for every host is held against them.
pub(crate) const STEPS: &[Step] = &[
    Step { name: "golden", run: golden::test },
    Step { name: "host-c", run: c::test },
    Step { name: "host-csharp", run: csharp::test },
    Step { name: "host-python", run: python::test },
    Step { name: "host-web", run: web::test },
    Step { name: "host-bevy", run: bevy::test },
    Step { name: "host-godot", run: godot::test },
];

/// Makes the shared answers, then builds and tests the binding that is called `filter` or, if none
/// is, those whose name contains it.
pub(crate) fn test(filter: &str) -> Done {
    let is_called = |step: &Step| step.name.strip_prefix("host-") == Some(filter);
    let is_name = STEPS.iter().any(is_called);
    let fits = |step: &Step| if is_name { is_called(step) } else { step.name.contains(filter) };
    let is_chosen = |step: &&Step| step.name == "golden" || fits(step);
    let chosen: Vec<Step> = STEPS.iter().filter(is_chosen).copied().collect();
    if chosen.len() == 1 && !"golden".contains(filter) {
        let names: Vec<_> = STEPS.iter().map(|s| s.name).collect();
        return Err(format!("no binding is called {filter}; there are {}", names.join(", ")));
    }
    runner::run(&chosen, "")
}
