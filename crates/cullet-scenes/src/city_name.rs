//! The name of a city in tiles: `city:n=1e8,seed=1`.

use std::str::FromStr;

use thiserror::Error;

/// The most instances.
const MOST: f64 = 1e9;

/// Size and seed of a city in tiles, parsed from its name. `cullet-tiles` makes the city.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CityName {
    /// Instances that it has at least, 1 to 1e9.
    pub instances: u64,
    /// The seed; 1 where none is named.
    pub seed: u64,
}

impl CityName {
    /// The most instances of the built-in scene of this name, which is made whole.
    pub const MOST_WHOLE: u64 = 10_000_000;

    /// Whether it is too large to be made whole.
    #[must_use]
    pub fn needs_tiles(&self) -> bool {
        self.instances > Self::MOST_WHOLE
    }
}

/// A text that is no [`CityName`].
#[derive(Clone, Debug, PartialEq, Error)]
#[error(
    "'{text}' is no city in tiles: write city:n=NUMBER[,seed=NUMBER], whole numbers, with n from 1 to 1e9; try city:n=1e8"
)]
pub struct NoCityName {
    /// The text.
    pub text: String,
    /// The instances that it names all the same.
    pub instances: Option<f64>,
}

impl FromStr for CityName {
    type Err = NoCityName;

    fn from_str(text: &str) -> Result<Self, NoCityName> {
        let settings = text.trim().strip_prefix("city:").unwrap_or_default().split(',');
        let (mut instances, mut seed, mut is_right) = (None, Some(1), true);
        for setting in settings {
            let (key, value) = setting.split_once('=').unwrap_or((setting, ""));
            let value = value.trim().replace('_', "");
            match key.trim() {
                "n" => instances = value.parse::<f64>().ok(),
                "seed" => seed = value.parse().ok(),
                _ => is_right = false,
            }
        }
        let whole = instances.filter(|n| (1.0..=MOST).contains(n) && n.fract() == 0.0);
        match (whole, seed) {
            (Some(n), Some(seed)) if is_right => Ok(Self { instances: n as u64, seed }),
            _ => Err(NoCityName { text: text.to_owned(), instances }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cities_are_named_by_their_size() {
        let of = |text: &str| text.parse().map(|CityName { instances, seed }| (instances, seed));
        assert_eq!(of("city:n=1e8"), Ok((100_000_000, 1)));
        assert_eq!(of("city:seed=7,n=5"), Ok((5, 7)));
        assert_eq!(of(" city: seed=7, n=10_000_001"), Ok((10_000_001, 7)));
        for wrong in [
            "city",
            "city:",
            "city:n",
            "city:n=0",
            "city:n=1e10",
            "city:n=1.5",
            "city:n=NaN",
            "city:m=3,n=4",
            "city:n=4,seed=x",
            "town:n=4",
        ] {
            let told = of(wrong).expect_err(wrong);
            assert_eq!(told.text, wrong);
            assert!(told.to_string().contains("try city:n=1e8"), "{told}");
        }
        assert_eq!(of("city:n=1e8,sub=2").unwrap_err().instances, Some(1e8));
        assert_eq!(of("city:n=many").unwrap_err().instances, None);
    }
}
