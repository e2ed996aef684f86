//! SIMD levels, and the two ways to compile a kernel for them.
//!
//! A kernel is generic over [`fearless_simd::Simd`]; each level it is compiled for costs the build
//! as much as the kernel itself. So two levels of x86 are left out where they earn nothing: SSE4.2
//! everywhere (as fast as SSE2 in every kernel but the byte shuffles, which ask for it themselves)
//! and AVX-512 in kernels that wait for memory or run once a frame.

use alloc::vec::Vec;
use core::fmt;

use fearless_simd::Level;

/// Runs `$op` compiled for the level of `$simd`, which is a [`Simd`]: at SSE2, AVX2 and AVX-512, or
/// the one level of another architecture.
macro_rules! dispatch {
    ($simd:expr, $token:ident => $op:expr) => {
        match $simd.0 {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            fearless_simd::Level::Avx512(level) => crate::simd::compiled!(level, $token => $op),
            level => crate::simd::dispatch_level!(level, $token => $op),
        }
    };
}

/// [`dispatch!`] with vectors of 256 bits at the most: AVX2 also where the machine has AVX-512.
macro_rules! dispatch_256 {
    ($simd:expr, $token:ident => $op:expr) => {
        crate::simd::dispatch_level!($simd.at_most_256_bits(), $token => $op)
    };
}

/// The levels below AVX-512 of the two macros above.
macro_rules! dispatch_level {
    ($level:expr, $token:ident => $op:expr) => {
        match $level {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            fearless_simd::Level::Avx2(level) => crate::simd::compiled!(level, $token => $op),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            fearless_simd::Level::Sse2(level) => crate::simd::compiled!(level, $token => $op),
            #[cfg(target_arch = "aarch64")]
            fearless_simd::Level::Neon(level) => crate::simd::compiled!(level, $token => $op),
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            fearless_simd::Level::WasmSimd128(level) => crate::simd::compiled!(level, $token => $op),
            #[cfg(any(
                feature = "force_support_fallback",
                not(any(
                    all(target_arch = "aarch64", target_feature = "neon"),
                    all(any(target_arch = "x86", target_arch = "x86_64"), target_feature = "sse2"),
                    all(target_arch = "wasm32", target_feature = "simd128")
                ))
            ))]
            fearless_simd::Level::Fallback(level) => crate::simd::compiled!(level, $token => $op),
            _ => unreachable!("no `Simd` holds another level"),
        }
    };
}

/// `$op` in a function with the instructions of one level.
macro_rules! compiled {
    ($level:ident, $token:ident => $op:expr) => {{
        let $token = $level;
        fearless_simd::Simd::vectorize(
            $level,
            #[inline(always)]
            || $op,
        )
    }};
}

pub(crate) use {compiled, dispatch, dispatch_256, dispatch_level};

/// Vector instructions that the batched tests use. The answer is the same at every level.
///
/// A value of a level can only be had on a machine that has it. Detection takes a few look-ups; a
/// [`Culler`](crate::Culler) holds its level.
#[derive(Clone, Copy)]
pub struct Simd(pub(crate) Level);

impl Simd {
    /// The best level of this machine.
    #[must_use]
    pub fn best() -> Self {
        #[cfg(feature = "std")]
        let level = Level::new();
        #[cfg(not(feature = "std"))]
        let level = Level::baseline();
        Self(without_sse4_2(level))
    }

    /// Every level that this machine and this build have, best first.
    ///
    /// The scalar level is among them where the machine has no other, or with the feature
    /// `force_support_fallback`. For tests and measurements.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let Self(best) = Self::best();
        let mut levels = Vec::new();
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        {
            levels.extend(best.as_avx512().map(|s| Self(Level::Avx512(s))));
            levels.extend(best.as_avx2().map(|s| Self(Level::Avx2(s))));
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

    /// This level, or AVX2 for AVX-512.
    pub(crate) fn at_most_256_bits(self) -> Level {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        if let Some(avx2) = self.0.as_avx2() {
            return Level::Avx2(avx2);
        }
        self.0
    }

    /// The level as `fearless_simd` has it, for kernels outside of this crate that are measured or
    /// tested beside its own.
    #[doc(hidden)]
    #[must_use]
    pub fn level(self) -> Level {
        self.0
    }

    /// The level's name: `avx512`, `avx2`, `sse2`, `neon`, `simd128` or `scalar`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self.0 {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Avx512(_) => "avx512",
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Avx2(_) => "avx2",
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Sse2(_) => "sse2",
            #[cfg(target_arch = "aarch64")]
            Level::Neon(_) => "neon",
            _ if self.0.is_fallback() => "scalar",
            _ => "simd128",
        }
    }
}

/// SSE2 for SSE4.2, every other level as it is.
fn without_sse4_2(level: Level) -> Level {
    match level {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Level::Sse4_2(sse4_2) => level.as_sse2().map_or(Level::Sse4_2(sse4_2), Level::Sse2),
        other => other,
    }
}

impl Default for Simd {
    /// The best level of this machine.
    fn default() -> Self {
        Self::best()
    }
}

impl PartialEq for Simd {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

impl Eq for Simd {}

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
