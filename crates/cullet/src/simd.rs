//! SIMD levels.

use std::fmt;

use fearless_simd::Level;

/// Which vector instructions the batched tests use. The answer is the same at every level.
///
/// A value of a level can only be had on a machine that has it. Detection takes a few look-ups; a
/// [`Culler`](crate::Culler) holds its level.
#[derive(Clone, Copy)]
pub struct Simd(pub(crate) Level);

impl Simd {
    /// The best level of this machine.
    #[must_use]
    pub fn best() -> Self {
        Self(Level::new())
    }

    /// Every level that this machine and this build have, best first.
    ///
    /// The scalar level is among them where the machine has no other, or with the feature `force_support_fallback`. For
    /// tests and measurements.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let best = Level::new();
        let mut levels = Vec::new();
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        {
            levels.extend(best.as_avx512().map(|s| Self(Level::Avx512(s))));
            levels.extend(best.as_avx2().map(|s| Self(Level::Avx2(s))));
            levels.extend(best.as_sse4_2().map(|s| Self(Level::Sse4_2(s))));
            levels.extend(best.as_sse2().map(|s| Self(Level::Sse2(s))));
        }
        #[cfg(target_arch = "aarch64")]
        levels.extend(best.as_neon().map(|s| Self(Level::Neon(s))));
        #[cfg(feature = "force_support_fallback")]
        levels.push(Self(Level::fallback()));
        if levels.is_empty() {
            levels.push(Self(best));
        }
        levels
    }

    /// The level as `fearless_simd` has it, for kernels outside of this crate that are measured or tested beside its own.
    #[doc(hidden)]
    #[must_use]
    pub fn level(self) -> Level {
        self.0
    }

    /// The level's name: `avx512`, `avx2`, `sse4.2`, `sse2`, `neon`, `simd128` or `scalar`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self.0 {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Avx512(_) => "avx512",
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Avx2(_) => "avx2",
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Sse4_2(_) => "sse4.2",
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Sse2(_) => "sse2",
            #[cfg(target_arch = "aarch64")]
            Level::Neon(_) => "neon",
            _ if self.0.is_fallback() => "scalar",
            _ => "simd128",
        }
    }
}

impl Default for Simd {
    /// The best level of this machine.
    fn default() -> Self {
        Self::best()
    }
}

impl fmt::Debug for Simd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_comes_first_and_every_level_once() {
        let names: Vec<_> = Simd::all().into_iter().map(Simd::name).collect();
        assert_eq!(names[0], Simd::best().name());
        let mut sorted = names.clone();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!(sorted.len(), names.len(), "{names:?}");
    }
}
