//! Where the samples of an image lie.

/// The samples of an image: one in every pixel, in normalised device coordinates.
#[derive(Clone, Debug)]
pub(crate) struct Samples {
    /// Width and height in pixels.
    pub(crate) size: [u32; 2],
    step: [f64; 2],
    jitter: Jitter,
}

/// Where in its pixel a sample lies.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Jitter {
    /// In the same place in every pixel.
    Fixed([f64; 2]),
    /// Somewhere else in every pixel, by a hash of the pixel and this seed.
    Hashed(u64),
}

impl Samples {
    pub(crate) fn new(size: [u32; 2], jitter: Jitter) -> Self {
        let jitter = match jitter {
            // NaN becomes the centre.
            Jitter::Fixed(at) => Jitter::Fixed(at.map(|v| if v >= 0.0 { v.min(1.0) } else { 0.5 })),
            hashed @ Jitter::Hashed(_) => hashed,
        };
        Self { size, step: size.map(|v| 2.0 / f64::from(v)), jitter }
    }

    pub(crate) fn jitter(&self) -> Jitter {
        self.jitter
    }

    /// X of an offset in a column.
    #[inline]
    pub(crate) fn x(&self, column: u32, offset: f64) -> f64 {
        (f64::from(column) + offset) * self.step[0] - 1.0
    }

    /// Y of an offset in a row; rows run down, Y runs up.
    #[inline]
    pub(crate) fn y(&self, row: u32, offset: f64) -> f64 {
        1.0 - (f64::from(row) + offset) * self.step[1]
    }

    /// The least and greatest offset in a pixel, for each axis.
    pub(crate) fn offsets(&self) -> [[f64; 2]; 2] {
        match self.jitter {
            Jitter::Fixed(at) => at.map(|v| [v, v]),
            Jitter::Hashed(_) => [[0.0, 1.0]; 2],
        }
    }

    /// The sample of a pixel.
    #[inline]
    pub(crate) fn at(&self, column: u32, row: u32) -> [f64; 2] {
        let [x, y] = match self.jitter {
            Jitter::Fixed(at) => at,
            Jitter::Hashed(seed) => hashed(seed, column, row),
        };
        [self.x(column, x), self.y(row, y)]
    }

    /// The columns and rows (first and last, inclusive) whose samples may lie within bounds given
    /// in normalised device coordinates; `None` if there are none. Errs outward by a thousandth of
    /// a pixel, and more where the bounds are far outside.
    #[inline]
    pub(crate) fn rect(&self, low: [f64; 2], high: [f64; 2]) -> Option<Rect> {
        let [ox, oy] = self.offsets();
        // A NaN keeps everything: the casts below send it to the edge that max and min choose.
        let first = |v: f64, step: f64, o: f64| {
            let p = v / step;
            let p = p - p.abs() * 1e-9 - 1e-3 - o;
            if p > 0.0 { p.ceil() } else { 0.0 }
        };
        let last = |v: f64, step: f64, o: f64, size: u32| {
            let p = v / step;
            let p = p + p.abs() * 1e-9 + 1e-3 - o;
            let end = f64::from(size - 1);
            if p < end { p.floor() } else { end }
        };
        let x0 = first(low[0] + 1.0, self.step[0], ox[1]);
        let x1 = last(high[0] + 1.0, self.step[0], ox[0], self.size[0]);
        let y0 = first(1.0 - high[1], self.step[1], oy[1]);
        let y1 = last(1.0 - low[1], self.step[1], oy[0], self.size[1]);
        (x0 <= x1 && y0 <= y1)
            .then_some(Rect { x: [x0 as u32, x1 as u32], y: [y0 as u32, y1 as u32] })
    }

    /// All pixels.
    pub(crate) fn everything(&self) -> Rect {
        Rect { x: [0, self.size[0] - 1], y: [0, self.size[1] - 1] }
    }
}

/// Some columns and rows, first and last, both inclusive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Rect {
    pub(crate) x: [u32; 2],
    pub(crate) y: [u32; 2],
}

/// Two numbers in (0, 1) from a hash of a pixel (the finaliser of Steele, Lea & Flood, *Fast
/// Splittable Pseudorandom Number Generators*, 2014).
#[inline]
fn hashed(seed: u64, column: u32, row: u32) -> [f64; 2] {
    let mix = |mut z: u64| {
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    };
    let pixel = u64::from(row) << 32 | u64::from(column);
    let h = mix(mix(seed.wrapping_add(0x9E37_79B9_7F4A_7C15)).wrapping_add(pixel));
    [h >> 32, h & 0xFFFF_FFFF].map(|v| (v as f64 + 0.5) / 4_294_967_296.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rects_hold_their_samples_and_little_more() {
        let s = Samples::new([10, 4], Jitter::Fixed([0.5; 2]));
        // X of column 3 is −0.3, Y of row 1 is 0.25.
        let [x, y] = s.at(3, 1);
        assert!((x + 0.3).abs() < 1e-15 && y == 0.25);
        let r = s.rect([-0.31, 0.24], [-0.29, 0.26]).unwrap();
        assert_eq!(r, Rect { x: [3, 3], y: [1, 1] });
        assert_eq!(s.rect([-0.29, 0.24], [-0.11, 0.26]), None);
        assert_eq!(s.rect([f64::NAN; 2], [f64::NAN; 2]), Some(s.everything()));
        assert_eq!(s.rect([1.5, -1.0], [2.0, 1.0]), None);
    }

    #[test]
    fn hashed_samples_stay_in_their_pixels() {
        let s = Samples::new([7, 5], Jitter::Hashed(9));
        for row in 0..5 {
            for column in 0..7 {
                let [x, y] = s.at(column, row);
                assert!(s.x(column, 0.0) <= x && x <= s.x(column, 1.0));
                assert!(s.y(row, 1.0) <= y && y <= s.y(row, 0.0));
            }
        }
    }
}
