//! Any bytes as a baked file, used as they lie: tables within them whose sums are right, or an error; and what can be built of
//! those tables are levels.
#![no_main]

use cullet_io::BakedFile;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    // Where a mapping would have them.
    let mut words = vec![0u64; bytes.len().div_ceil(8)];
    let place = &mut bytemuck::cast_slice_mut(&mut words)[..bytes.len()];
    place.copy_from_slice(bytes);
    let Ok(file) = BakedFile::of(&*place) else { return };
    let mut taken = 0;
    for (at, mesh) in file.meshes().iter().enumerate() {
        for levels in 0..mesh.levels.len() {
            let Ok(tables) = file.levels(at, levels) else { continue };
            let triangles: u64 = tables.parts.iter().map(|&n| u64::from(n)).sum();
            assert_eq!(triangles, tables.indices.len() as u64);
            taken +=
                tables.indices.len() * 12 + tables.clusters.len() * 16 + tables.groups.len() * 20;
            assert!(tables.to_tables().is_ok());
        }
    }
    // No byte is of two tables.
    assert!(taken <= bytes.len());
});
