//! Every SIMD level.

use cullet::Simd;

/// Runs a block once at every SIMD level of this machine and build, the best first and the scalar one among them where
/// the engine is built with it (`force_support_fallback`, as `cargo xtask test` does): a loop, so that the block may
/// change what stands around it, and leave a property of proptest with an error. A panic within it says at which level.
///
/// ```
/// use cullet_testkit::at_every_level;
///
/// let mut answers = Vec::new();
/// at_every_level!(|name, level| {
///     answers.push((name, cullet::Culler::default().with_simd(level)));
/// });
/// assert!(!answers.is_empty());
/// ```
#[macro_export]
macro_rules! at_every_level {
    (|$name:pat_param, $level:pat_param| $body:block) => {
        for (name, level) in $crate::levels() {
            let _at = $crate::At(name);
            let ($name, $level) = (name, level);
            $body
        }
    };
    (|$level:pat_param| $body:block) => {
        $crate::at_every_level!(|_, $level| $body)
    };
}

/// The levels, with their names.
pub fn levels() -> Vec<(&'static str, Simd)> {
    Simd::all().into_iter().map(|simd| (simd.name(), simd)).collect()
}

/// Says at which level a test failed.
#[derive(Debug)]
pub struct At(pub &'static str);

impl Drop for At {
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("at SIMD level {}", self.0);
        }
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn every_level_is_run_once_and_may_end_a_property() {
        let mut names = Vec::new();
        at_every_level!(|name, _| {
            names.push(name);
        });
        let mut sorted = names.clone();
        sorted.sort_unstable();
        sorted.dedup();
        assert!(!names.is_empty() && sorted.len() == names.len(), "{names:?}");
        let first = || {
            at_every_level!(|name, _| {
                if names.contains(&name) {
                    return Err(name);
                }
            });
            Ok(())
        };
        assert_eq!(first(), Err(names[0]));
    }
}
