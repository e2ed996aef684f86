//! The SIMD levels of this machine.

use fearless_simd::Level;

/// Every level that this machine and this build have, with its name, best first.
///
/// The scalar level is there where the machine has no other, or with the feature
/// `force_support_fallback`. For tests and measurements: elsewhere [`Level::new`] is the best.
#[must_use]
pub fn levels() -> Vec<(&'static str, Level)> {
    let best = Level::new();
    let mut levels = Vec::new();
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    {
        levels.extend(best.as_avx512().map(|s| ("avx512", Level::Avx512(s))));
        levels.extend(best.as_avx2().map(|s| ("avx2", Level::Avx2(s))));
        levels.extend(best.as_sse4_2().map(|s| ("sse4.2", Level::Sse4_2(s))));
        levels.extend(best.as_sse2().map(|s| ("sse2", Level::Sse2(s))));
    }
    #[cfg(target_arch = "aarch64")]
    levels.extend(best.as_neon().map(|s| ("neon", Level::Neon(s))));
    #[cfg(feature = "force_support_fallback")]
    levels.push(("scalar", Level::fallback()));
    if levels.is_empty() {
        levels.push((if best.is_fallback() { "scalar" } else { "simd128" }, best));
    }
    levels
}
