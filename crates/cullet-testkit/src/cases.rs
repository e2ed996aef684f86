//! How often a property is tried.

/// Percent where nothing is said, so that `cargo test` takes minutes; `cargo xtask test` asks for all.
const PERCENT: u64 = 25;

/// Number of cases of a property whose test says `n`: the share of it that `CULLET_CASES` gives in percent, a quarter
/// where that is unset, and never none. `CULLET_CASES=1000` looks ten times as hard as the test says.
///
/// # Panics
///
/// When `CULLET_CASES` is set to something that is no whole number of percent.
pub fn cases(n: u32) -> u32 {
    let set = std::env::var("CULLET_CASES").ok();
    share(n, set.as_deref())
}

fn share(n: u32, percent: Option<&str>) -> u32 {
    let text = percent.filter(|p| !p.is_empty());
    let percent = text.map_or(PERCENT, |text| {
        text.parse().unwrap_or_else(|_| {
            panic!("CULLET_CASES is {text:?}; it must be a whole number of percent, such as 100")
        })
    });
    let cases = (u64::from(n) * percent).div_ceil(100);
    u32::try_from(cases).unwrap_or(u32::MAX).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_follow_the_percentage_and_are_never_none() {
        assert_eq!(share(400, None), 100);
        assert_eq!(share(400, Some("")), 100);
        assert_eq!(share(400, Some("100")), 400);
        assert_eq!(share(400, Some("1000")), 4000);
        assert_eq!(share(3, Some("10")), 1);
        assert_eq!(share(3, Some("0")), 1);
        assert_eq!(share(u32::MAX, Some("1000")), u32::MAX);
    }

    #[test]
    #[should_panic(expected = "whole number of percent")]
    fn a_setting_that_is_no_percentage_is_refused() {
        share(400, Some("many"));
    }
}
