//! A device for tests, of the tier that a test needs.

use std::sync::OnceLock;

use super::device::{Gpu, NONE};
use super::error::GpuError;
use super::tier::Tier;

/// Returns a device of a tier, opened once for all tests of a program. Without one, calls `skip`
/// with what is missing and what gets it.
///
/// # Panics
/// Without a device, if `CULLET_REQUIRE_GPU` is `1`, or names this tier or a higher one.
pub fn device(least: Tier, skip: fn(&str, &str)) -> Option<&'static Gpu> {
    static OPENED: [OnceLock<Result<Gpu, GpuError>>; Tier::ALL.len()] =
        [const { OnceLock::new() }; Tier::ALL.len()];
    match OPENED[least as usize].get_or_init(|| Gpu::open(least)) {
        Ok(gpu) => Some(gpu),
        Err(why) => {
            missing(least, why, skip);
            None
        }
    }
}

/// Calls `skip` with what is missing, and what gets it.
fn missing(least: Tier, why: &GpuError, skip: fn(&str, &str)) {
    assert!(!is_required(least), "CULLET_REQUIRE_GPU is set: {why}");
    match why {
        GpuError::NoAdapter { found, cure, .. } if found == NONE => {
            skip("a graphics adapter", cure);
        }
        // The same words for all tiers above, so that they are told of once.
        GpuError::NoAdapter { found, cure, .. } => {
            skip(&format!("a graphics adapter that can do more than {found}"), cure);
        }
        other => skip(&format!("a graphics device: {other}"), &super::tier::cure()),
    }
}

/// Whether a device of this tier must be there: `CULLET_REQUIRE_GPU` is `1`, or the name of this
/// tier or a higher one.
///
/// # Panics
/// If it is anything else.
#[must_use]
pub fn is_required(tier: Tier) -> bool {
    let value = std::env::var("CULLET_REQUIRE_GPU").unwrap_or_default();
    if value.is_empty() || value == "1" {
        return value == "1";
    }
    let required = Tier::ALL.into_iter().find(|own| own.name() == value);
    let names = Tier::ALL.map(Tier::name).join(", ");
    let required = required
        .unwrap_or_else(|| panic!("CULLET_REQUIRE_GPU is '{value}', neither 1 nor one of {names}"));
    tier <= required
}
