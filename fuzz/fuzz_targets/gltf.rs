//! Any bytes, as GLB or as bare JSON, load or end in an error: no panic, no hang, no flood of memory.
#![no_main]

use cullet_io::{LoadOptions, load_bytes};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    // Small limits, so that what the fuzzer finds is a fault and not a large model.
    let options = LoadOptions {
        max_triangles: 1 << 20,
        max_instances: 1 << 16,
        details: true,
        ..LoadOptions::default()
    };
    if let Ok(model) = load_bytes("fuzz.gltf", bytes, &options) {
        let instances = model.scene.instance_count() as usize;
        assert_eq!(model.instance_names.len(), instances);
        assert!(instances <= 1 << 16);
        for mesh in model.scene.meshes() {
            let count = mesh.positions().len();
            assert!(mesh.indices().iter().all(|&i| (i as usize) < count));
        }
    }
});
