//! Triangles within a bound on real models, beside a plain chain whose levels are measured as well. The whole table:
//! `cargo test --release -p cullet-bake --features meshopt --test level_models -- --ignored --nocapture`.
#![cfg(feature = "meshopt")]

use std::path::Path;

use cullet::MeshData;
use cullet_bake::levels::simplifier::{Target, simplify};
use cullet_bake::levels::{Deviation, WithinOptions, deviation, simplify_within};
use cullet_testkit::data;

/// All instances of a model's meshes as one mesh, its equal positions welded; and its radius.
fn loaded(path: &Path) -> (MeshData, f32) {
    let model = cullet_io::load(path, &cullet_io::LoadOptions::default()).expect("a model");
    let mut all = MeshData::default();
    for mesh in model.scene.meshes() {
        let base = all.positions.len() as u32;
        all.positions.extend_from_slice(mesh.positions());
        all.indices.extend(mesh.indices().iter().map(|i| i + base));
    }
    let same = cullet::mesh::weld(&all.positions);
    all.indices.iter_mut().for_each(|i| *i = same[*i as usize]);
    let side = |f: fn(f32, f32) -> f32, from: f32| -> [f32; 3] {
        std::array::from_fn(|a| all.positions.iter().map(|p| p[a]).fold(from, f))
    };
    let (low, high) = (side(f32::min, f32::MAX), side(f32::max, f32::MIN));
    let far = |p: &[f32; 3]| {
        (0..3).map(|a| (p[a] - (low[a] + high[a]) * 0.5).powi(2)).sum::<f32>().sqrt()
    };
    let radius = all.positions.iter().map(far).fold(0.0, f32::max);
    (all, radius)
}

fn measured(mesh: &MeshData, indices: &[u32], samples: usize) -> Deviation {
    deviation((&mesh.positions, &mesh.indices), (&mesh.positions, indices), samples, 77)
}

/// The fewest triangles of a plain chain, each level 0.8 times the one before, that deviate by no more than each bound,
/// as measured.
fn plain(mesh: &MeshData, bounds: &[f32], samples: usize) -> Vec<usize> {
    let mut fewest = vec![mesh.indices.len() / 3; bounds.len()];
    let mut triangles = mesh.indices.len() / 3;
    while triangles > 50 {
        triangles = triangles * 4 / 5;
        let target = Target { triangles, ..Target::default() };
        let level = simplify(&mesh.positions, &mesh.indices, &[], None, target).expect("valid");
        let far = measured(mesh, &level.indices, samples).max;
        for (bound, fewest) in bounds.iter().zip(&mut fewest) {
            if far <= *bound {
                *fewest = (*fewest).min(level.indices.len() / 3);
            }
        }
        // Coarser ones are no nearer.
        if bounds.iter().all(|b| far > 8.0 * b) {
            break;
        }
    }
    fewest
}

/// Ours over a plain chain's triangles, at each bound; prints a line for each.
fn compared(name: &str, shares: &[f32], samples: usize) -> Option<Vec<f64>> {
    let (mesh, radius) = loaded(&data(name)?);
    let bounds: Vec<f32> = shares.iter().map(|s| s * radius).collect();
    let plain = plain(&mesh, &bounds, samples);
    let mut ratios = Vec::new();
    for ((bound, share), plain) in bounds.iter().zip(shares).zip(plain) {
        let start = std::time::Instant::now();
        let found = simplify_within(&mesh, *bound, &WithinOptions::default()).expect("valid");
        let seconds = start.elapsed().as_secs_f64();
        let far = measured(&mesh, &found.indices, samples);
        let (own, ratio) =
            (found.indices.len() / 3, found.indices.len() as f64 / 3.0 / plain as f64);
        println!(
            "{name} {:.2} %: {own}, plain chain {plain}, {ratio:.3} times; off by {:.3} at most, 99.9 % by {:.3} of \
             the bound; open edges {:?}; {seconds:.2} s",
            share * 100.0,
            far.max / bound,
            far.p999 / bound,
            far.open_edges
        );
        assert!(far.p999 <= *bound && far.max <= bound * 1.2, "{name} {share}: {far:?}");
        assert!(far.open_edges[1] <= far.open_edges[0], "{name} {share}: {far:?}");
        ratios.push(ratio);
    }
    Some(ratios)
}

fn mean(ratios: &[f64]) -> f64 {
    (ratios.iter().map(|r| r.ln()).sum::<f64>() / ratios.len().max(1) as f64).exp()
}

#[test]
fn a_machine_part_needs_fewer_triangles_than_a_plain_chain() {
    let Some(ratios) = compared("classic-meshes/fandisk.obj", &[0.001, 0.003, 0.01], 100_000)
    else {
        return;
    };
    assert!(mean(&ratios) <= 0.75, "{ratios:?}");
}

#[test]
#[ignore = "takes minutes"]
fn four_models_need_fewer_triangles_than_plain_chains() {
    let models = [
        ("armadillo/armadillo.obj", &[0.001, 0.003, 0.01][..]),
        ("happy-buddha/buddha-100k.obj", &[0.001, 0.003, 0.01]),
        ("intel-castle/intel-castle.glb", &[0.001, 0.003, 0.01]),
        ("classic-meshes/fandisk.obj", &[0.001, 0.003, 0.01]),
    ];
    let mut means = Vec::new();
    for (name, shares) in models {
        let Some(ratios) = compared(name, shares, 1_000_000) else { continue };
        println!("{name}: {:.3} in the mean", mean(&ratios));
        means.push(mean(&ratios));
    }
    println!("all: {:.3} in the mean", mean(&means));
    assert!(means.is_empty() || mean(&means) <= 0.75, "{means:?}");
}
