//! Any bytes as a recording of occlusion culling: an error, or one that is the same after writing and reading
//! again, and that can be played.
#![no_main]

use cullet::Simd;
use cullet_maps::recording::Recording;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(recording) = Recording::decode(bytes) {
        let again = recording.encode();
        let twice = Recording::decode(&again).expect("what was encoded can be decoded");
        // Bytes, not values: a comparison of floats would call −0 and 0 equal.
        assert_eq!(twice.encode(), again);
        let _ = recording.replay(Simd::best());
    }
});
