//! Any bytes as `OCCSCN01`: an error, or a scene that is the same after writing and reading again.
#![no_main]

use cullet_io::LoadOptions;
use cullet_maps::load_bytes;
use cullet_maps::occscn::Occscn;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let parsed = Occscn::parse(bytes);
    // Bytes that begin like another format load as that.
    let loaded = load_bytes("fuzz.occscn", bytes, &LoadOptions::default());
    if let Ok(scene) = parsed {
        loaded.expect("what was parsed can be loaded");
        let mut again = Vec::new();
        scene.write(&mut again).expect("what was parsed can be written");
        // Bytes, not values: a comparison of floats would call −0 and 0 equal.
        let mut twice = Vec::new();
        let scene = Occscn::parse(&again).expect("what was written can be parsed");
        scene.write(&mut twice).expect("what was parsed can be written");
        assert_eq!(again, twice);
    }
});
