//! A place on the globe, where a scene is to stand.

use std::str::FromStr;

/// A place on the globe (WGS 84): longitude, latitude and height above the ellipsoid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlobePlace {
    degrees: [f64; 2],
    height: f64,
}

impl GlobePlace {
    /// Makes a place of a longitude from −180 to 180 and a latitude from −90 to 90, in degrees, and a
    /// height in metres of at most 100 km above or below the ellipsoid. `None` for other numbers.
    #[must_use]
    pub fn new(longitude: f64, latitude: f64, height: f64) -> Option<Self> {
        let is_place = longitude.abs() <= 180.0 && latitude.abs() <= 90.0 && height.abs() <= 1e5;
        is_place.then_some(Self { degrees: [longitude, latitude], height })
    }

    /// Longitude and latitude in radians.
    pub(super) fn radians(self) -> [f64; 2] {
        self.degrees.map(f64::to_radians)
    }

    /// Height above the ellipsoid, in metres.
    pub(super) fn height(self) -> f64 {
        self.height
    }
}

impl FromStr for GlobePlace {
    type Err = String;

    /// Reads `LONGITUDE,LATITUDE` or `LONGITUDE,LATITUDE,HEIGHT`.
    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Result<Vec<f64>, _> = text.split(',').map(|n| n.trim().parse()).collect();
        let place = match numbers.as_deref() {
            Ok(&[longitude, latitude]) => Self::new(longitude, latitude, 0.0),
            Ok(&[longitude, latitude, height]) => Self::new(longitude, latitude, height),
            _ => None,
        };
        place.ok_or_else(|| {
            "give a longitude from -180 to 180 and a latitude from -90 to 90 in degrees, then a height \
             above the ellipsoid in metres if it is not 0, such as 13.4,52.5,34"
                .to_owned()
        })
    }
}
