//! The engine's SIMD levels as `fearless_simd` has them.

use cullet::Simd;
use fearless_simd::Level;

/// The level by its name, for kernels of this crate and of measurements.
#[must_use]
pub fn level_of(simd: Simd) -> Level {
    let best = Level::new();
    let level = match simd.name() {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        "avx512" => best.as_avx512().map(Level::Avx512),
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        "avx2" => best.as_avx2().map(Level::Avx2),
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        "sse4.2" => best.as_sse4_2().map(Level::Sse4_2),
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        "sse2" => best.as_sse2().map(Level::Sse2),
        #[cfg(feature = "force_support_fallback")]
        "scalar" => Some(Level::fallback()),
        _ => None,
    };
    level.unwrap_or(best)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_level_is_its_own() {
        let found: Vec<String> =
            Simd::all().into_iter().map(|simd| format!("{:?}", level_of(simd))).collect();
        let mut different = found.clone();
        different.dedup();
        assert_eq!(found, different);
    }
}
