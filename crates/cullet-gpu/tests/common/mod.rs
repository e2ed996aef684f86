//! A device for tests.

use std::sync::OnceLock;

use cullet_gpu::{Gpu, GpuError};

/// The device, or `None`, said aloud, where there is no adapter. With `CULLET_REQUIRE_GPU` set that is a failure.
pub(crate) fn gpu() -> Option<&'static Gpu> {
    static GPU: OnceLock<Result<Gpu, GpuError>> = OnceLock::new();
    match GPU.get_or_init(Gpu::open) {
        Ok(gpu) => Some(gpu),
        Err(why) => {
            assert!(
                std::env::var("CULLET_REQUIRE_GPU").is_err(),
                "CULLET_REQUIRE_GPU is set: {why}"
            );
            let cure = "apt-get install mesa-vulkan-drivers libvulkan1 (software Vulkan will do)";
            cullet_testkit::skip("no graphics adapter", cure);
            None
        }
    }
}
