//! Which link frames of scenes wait for, and what culling makes of it.

use cullet::{Culler, Output, Stage};
use cullet_gpu::Gpu;
use cullet_io::paths::{Overrides, PathSpec, views};
use cullet_profile::drawn::Drawn;
use cullet_profile::elasticity::limit;
use cullet_profile::measure::{Effort, measure};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let gpu = Gpu::open()?;
    println!("{}", gpu.adapter.get_info().name);
    for name in ["city", "plant:bays=4,floors=2,kinds=6", "knobs:n=200"] {
        let model = cullet_io::scenes::build(name)?;
        let view = &views(&model, &PathSpec::Walk, 4, [1280, 720], &Overrides::default())
            .or_else(|_| views(&model, &PathSpec::Orbit, 4, [1280, 720], &Overrides::default()))?
            [1];
        let ways = [
            ("nothing", None),
            (
                "frustum",
                Some(Culler {
                    output: Output::Instances,
                    ..Culler::default().only(Stage::Frustum)
                }),
            ),
            ("all", Some(Culler { output: Output::Clusters, ..Culler::default() })),
        ];
        for (way, culler) in ways {
            let mut drawn = Drawn::new(&gpu, &model.scene, view, culler)?;
            let found = measure(&gpu, &mut drawn, Effort { rounds: 9, ..Effort::default() })?;
            let all = found
                .elasticity
                .map(|e| format!("{:5.2} [{:5.2} {:5.2}]", e.value, e.interval[0], e.interval[1]));
            println!(
                "{name:12} {way:8} {:7.2} ms  {}  {:?}; {} triangles",
                found.frame_ms,
                all.join("  "),
                limit(&found.elasticity),
                drawn.visible().triangle_count
            );
        }
    }
    Ok(())
}
