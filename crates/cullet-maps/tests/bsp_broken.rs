//! Maps that are cut short or changed at any byte: an error that says where, or a sound model, within the memory that is
//! promised.

use std::path::PathBuf;

use bsp_seeds::{of, small};
use cullet_io::{ErrorKind, LoadOptions};
use cullet_maps::bsp::{Bsp, ClusterRows, clusters_of_leafs, with_visibility};
use cullet_maps::load_bytes;
use cullet_testkit::memory::{Counting, peak_of};
use cullet_testkit::{Rng, cases, data};

mod bsp_seeds;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Loads a map in every way; whether it is one.
fn tried(bytes: &[u8]) -> bool {
    let loaded = load_bytes("a.bsp", bytes, &LoadOptions::default());
    if let Err(error) = &loaded {
        let text = error.to_string();
        let known = ["lump ", "header: ", "mesh ", "instance ", "file: ", "a map of kind"];
        let begins = |k: &&str| text.strip_prefix("a.bsp: ").is_some_and(|t| t.starts_with(*k));
        assert!(
            known.iter().any(begins) || text.contains("does not begin"),
            "it does not say where: {text}"
        );
    }
    let Ok(map) = Bsp::parse(bytes) else {
        assert!(loaded.is_err());
        return false;
    };
    let _ = map.cells();
    for leaf in 0..map.leafs().len() as u32 {
        let _ = (map.leafs_seen_from(leaf), map.tree().planes_of_leaf(leaf));
    }
    for point in [[0.0; 3], [f64::NAN; 3], [-32.0, 1e9, f64::INFINITY]] {
        let _ = map.cell_at(point);
    }
    let all = vec![0xFF; map.cell_count() as usize * (map.cell_count() as usize).div_ceil(8)];
    let of_leaf = clusters_of_leafs(&map);
    let rows = ClusterRows { clusters: map.cell_count(), of_leaf: &of_leaf, rows: &all };
    if let Ok(written) = with_visibility(bytes, &rows) {
        assert_eq!(Bsp::parse(&written).unwrap().cell_count(), map.cell_count());
    }
    loaded.is_ok()
}

// One test for all that measures memory: its counter is shared by the whole program.
#[test]
fn no_change_of_a_byte_does_harm() {
    let mut rng = Rng(18);
    let (mut sound, mut refused) = (0, 0);
    for (name, bytes) in small() {
        assert!(tried(&bytes), "{name}");
        for end in 0..bytes.len() {
            // The last lump of a map may be padded.
            let cut = tried(&bytes[..end]);
            assert!(!cut || bytes.len() - end < 4, "{name} is a map with {end} bytes");
        }
        for _ in 0..cases(3_000) {
            let mut changed = bytes.clone();
            for _ in 0..=rng.below(3) {
                let at = rng.index(changed.len());
                changed[at] = match rng.below(4) {
                    0 => 0,
                    1 => 0xFF,
                    2 => changed[at] ^ (1 << rng.below(8)),
                    _ => rng.bits() as u8,
                };
            }
            let (is_map, peak) = peak_of(|| tried(&changed));
            assert!(peak < 4 << 20, "{name}: {peak} bytes");
            if is_map { sound += 1 } else { refused += 1 }
        }
    }
    // Most bytes are coordinates; many are not.
    assert!(sound > cases(3_000) && refused > cases(3_000), "{sound} {refused}");
    println!("{sound} sound, {refused} refused");
    real_maps_that_are_changed(&mut rng);
    claims_cost_no_memory();
}

fn real_maps_that_are_changed(rng: &mut Rng) {
    let map = |folder: &str, name: &str| -> Option<PathBuf> { Some(data(folder)?.join(name)) };
    let maps = [map("quake-libre", "start.bsp"), map("quake3-openarena", "oa_bases3.bsp")];
    for path in maps.into_iter().flatten() {
        let bytes = std::fs::read(&path).unwrap();
        for _ in 0..cases(40) {
            let mut changed = bytes.clone();
            if rng.chance(0.5) {
                changed.truncate(rng.index(bytes.len()));
            }
            // The directory and a few bytes anywhere.
            for at in [rng.index(140), rng.index(bytes.len()), rng.index(bytes.len())] {
                if let Some(byte) = changed.get_mut(at) {
                    *byte = rng.bits() as u8;
                }
            }
            let load = || load_bytes("a.bsp", &changed, &LoadOptions::default()).is_ok();
            let (_, peak) = peak_of(load);
            assert!(peak < 8 * bytes.len() + (16 << 20), "{peak} bytes of {}", bytes.len());
        }
    }
}

/// Many faces that name the same corners over and over; counts of what there are no bytes of.
fn claims_cost_no_memory() {
    let bytes = of("quake");
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    let [offset, length] = [4 + 7 * 8, 8 + 7 * 8].map(word);
    let mut changed = bytes.clone();
    let faces = bytes[offset..][..length].repeat(1_000);
    changed[4 + 7 * 8..][..4].copy_from_slice(&(bytes.len() as u32).to_le_bytes());
    changed[8 + 7 * 8..][..4].copy_from_slice(&(faces.len() as u32).to_le_bytes());
    changed.extend(&faces);
    let (loaded, peak) =
        peak_of(|| load_bytes("a.bsp", &changed, &LoadOptions::default()).map(drop));
    let text = loaded.unwrap_err().to_string();
    assert!(text.contains("lump faces") && text.contains("over the limit of 384"), "{text}");
    assert!(peak < 2 << 20, "{peak} bytes");
    // The last of the counts of `OCCSCN01` is reserved, and nothing comes of it.
    for field in 0..5 {
        let mut scene = b"OCCSCN01".to_vec();
        (0..6).for_each(|k| scene.extend(if k == field { u32::MAX } else { 0 }.to_le_bytes()));
        let load = || load_bytes("a.occscn", &scene, &LoadOptions::default()).map(drop);
        let (loaded, peak) = peak_of(load);
        let kind = loaded.unwrap_err().kind;
        let told = matches!(kind, ErrorKind::Invalid { .. } | ErrorKind::OverLimit { .. });
        assert!(told && peak < 1 << 20, "{kind}, {peak} bytes");
    }
}
