//! The elasticities of the frames whose slowest link is known.

use cullet_gpu::Gpu;
use cullet_profile::elasticity::limit;
use cullet_profile::link::Link;
use cullet_profile::measure::{Effort, measure};
use cullet_profile::proof::{Amounts, Proof};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let gpu = Gpu::open()?;
    println!("{}", gpu.adapter.get_info().name);
    for link in Link::ALL {
        let mut proof = Proof::new(&gpu, Amounts::of(link));
        let found = measure(&gpu, &mut proof, Effort { rounds: 15, ..Effort::default() })?;
        let all = found
            .elasticity
            .map(|e| format!("{:5.2} [{:5.2} {:5.2}]", e.value, e.interval[0], e.interval[1]));
        println!(
            "{:9} {:7.2} ms  {}  {:?}",
            link.name(),
            found.frame_ms,
            all.join("  "),
            limit(&found.elasticity)
        );
    }
    Ok(())
}
