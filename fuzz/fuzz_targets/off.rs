//! Any bytes as OFF: an error or a model, never a panic.
#![no_main]

use cullet_io::{LoadOptions, load_bytes};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(model) = load_bytes("fuzz.off", bytes, &LoadOptions::default()) {
        assert_eq!(model.instance_names.len(), model.scene.instance_count() as usize);
        let materials = model.materials.len();
        for mesh in model.scene.meshes() {
            assert!(mesh.parts().iter().all(|p| (p.material as usize) < materials));
        }
    }
});
