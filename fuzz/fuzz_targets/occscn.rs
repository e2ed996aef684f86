//! Any bytes as `OCCSCN01`: an error, or a scene that is the same after writing and reading again.
#![no_main]

use cullet_io::occscn::Occscn;
use cullet_io::{LoadOptions, load_bytes};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let parsed = Occscn::parse(bytes);
    assert_eq!(parsed.is_ok(), load_bytes("fuzz.occscn", bytes, &LoadOptions::default()).is_ok());
    if let Ok(scene) = parsed {
        let mut again = Vec::new();
        scene.write(&mut again).expect("what was parsed can be written");
        // Bytes, not values: a comparison of floats would call −0 and 0 equal.
        let mut twice = Vec::new();
        let scene = Occscn::parse(&again).expect("what was written can be parsed");
        scene.write(&mut twice).expect("what was parsed can be written");
        assert_eq!(again, twice);
    }
});
