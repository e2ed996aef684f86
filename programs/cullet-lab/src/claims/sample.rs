//! Samples of pixels, and what covers them.

use super::triangle::{Affine, Triangle};

/// So many different patterns of samples; which one a pixel has is random.
const PATTERNS: usize = 64;

/// Samples of a pass: bits of a word.
const SAMPLES: usize = 64;

/// Digits of a place in a pixel: so few that a place on the screen is exact.
const DIGITS: u32 = 24;

/// Where in its pixel each sample lies.
#[derive(Clone, Debug)]
struct Pattern {
    x: [f64; SAMPLES],
    y: [f64; SAMPLES],
}

/// Up to 64 of the cells of a pixel, with a sample in each, in several patterns.
#[derive(Clone, Debug)]
pub(super) struct Patterns {
    patterns: Vec<Pattern>,
    count: u32,
    seed: u64,
}

/// A hash (the finaliser of Steele, Lea & Flood, *Fast Splittable Pseudorandom Number Generators*,
/// 2014).
fn mix(mut z: u64) -> u64 {
    z = z.wrapping_add(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

impl Patterns {
    /// Makes the patterns of `side` × `side` cells from number 64 × `pass` on.
    pub(super) fn new(side: u32, pass: u32, seed: u64) -> Self {
        let cells = side * side;
        let first = pass * SAMPLES as u32;
        let count = (cells - first).min(SAMPLES as u32);
        let seed = mix(seed ^ u64::from(pass) << 32);
        let whole = f64::from(1_u32 << DIGITS);
        let pattern = |number: usize| {
            let mut p = Pattern { x: [0.5; SAMPLES], y: [0.5; SAMPLES] };
            for k in 0..count as usize {
                let cell = first + k as u32;
                let h = mix(seed ^ (number << 8 | k) as u64);
                let place = |cell: u32, bits: u64| {
                    let within = (bits as f64 + 0.5) / 4_294_967_296.0;
                    // Not on the border of the pixel, which it shares with others.
                    let at = ((f64::from(cell) + within) / f64::from(side) * whole).floor();
                    at.clamp(1.0, whole - 1.0) / whole
                };
                p.x[k] = place(cell % side, h >> 32);
                p.y[k] = place(cell / side, h & 0xFFFF_FFFF);
            }
            p
        };
        Self { patterns: (0..PATTERNS).map(pattern).collect(), count, seed }
    }

    /// A bit for each sample.
    pub(super) fn all(&self) -> u64 {
        u64::MAX >> (SAMPLES as u32 - self.count)
    }

    #[inline(always)]
    fn of(&self, [x, y]: [u32; 2]) -> &Pattern {
        let h = mix(self.seed ^ u64::from(y) << 32 ^ u64::from(x));
        &self.patterns[h as usize % PATTERNS]
    }

    /// The place of a sample on the screen.
    pub(super) fn place(&self, pixel: [u32; 2], sample: usize) -> [f64; 2] {
        let p = self.of(pixel);
        [f64::from(pixel[0]) + p.x[sample], f64::from(pixel[1]) + p.y[sample]]
    }
}

/// Some rows of a buffer.
pub(super) struct Strip<'a> {
    /// The samples of each pixel that nothing covers as yet.
    pub(super) open: &'a mut [u64],
    pub(super) claims: &'a [f32],
    pub(super) wide: u32,
    pub(super) first_row: u32,
    pub(super) patterns: &'a Patterns,
}

/// Whether a function is not negative somewhere in a pixel, and everywhere in it.
#[inline(always)]
fn range(f: &Affine, x: f64, y: f64) -> (bool, bool) {
    let (middle, swing) = (f.at(x, y), f.swing());
    // Where the difference is rounding, samples decide.
    let doubt = (middle.abs() + swing) * 4.0 * f64::EPSILON;
    (middle + swing + doubt >= f.least, middle - swing - doubt >= f.least)
}

impl Strip<'_> {
    /// Takes away the samples that a triangle covers and for which it is near enough.
    pub(super) fn cover(&mut self, t: &Triangle) {
        let rows = self.open.len() as u32 / self.wide;
        let first = t.rows[0].max(self.first_row);
        let end = (t.rows[1] + 1).min(self.first_row + rows);
        for row in first..end {
            let y = f64::from(row) - t.origin[1] + 0.5;
            let Some([from, to]) = columns(t, y) else { continue };
            for column in from..=to {
                let at = ((row - self.first_row) * self.wide + column) as usize;
                if self.open[at] != 0 {
                    self.cover_pixel(t, [column, row], at, y);
                }
            }
        }
    }

    #[inline(always)]
    fn cover_pixel(&mut self, t: &Triangle, pixel: [u32; 2], at: usize, y: f64) {
        let x = f64::from(pixel[0]) - t.origin[0] + 0.5;
        let mut whole = true;
        for f in t.edges.iter().chain(&t.height) {
            let (some, all) = range(f, x, y);
            if !some {
                return;
            }
            whole &= all;
        }
        let claim = f64::from(self.claims[at]);
        // A triangle that is near enough in all of it needs no plane, of which slivers know little.
        let nearness = if t.farthest >= claim {
            Affine::default()
        } else {
            let least = t.nearness.least - (t.nearness.c.abs() + claim) * f64::EPSILON;
            Affine { c: t.nearness.c - claim, least, ..t.nearness }
        };
        let (some, all) = range(&nearness, x, y);
        if !some {
            return;
        }
        if whole && all {
            self.open[at] = 0;
            return;
        }
        let height = t.height.unwrap_or_default();
        let functions = [t.edges[0], t.edges[1], t.edges[2], nearness, height];
        let pattern = self.patterns.of(pixel);
        self.open[at] &= !covered(&functions, pattern, x - 0.5, y - 0.5);
    }
}

/// First and last column of a row of pixels, whose middle is at `y`, in which all three edges of a
/// triangle may be positive.
#[inline(always)]
fn columns(t: &Triangle, y: f64) -> Option<[u32; 2]> {
    let (mut low, mut high) = (0.0, f64::from(t.columns[1] - t.columns[0] + 1));
    for e in &t.edges {
        // The most of it over the row's height, at x: e.a · x + most.
        let most = e.b * y + e.c + 0.5 * e.b.abs() - e.least;
        let cross = -most / e.a;
        // Farther out by more than any rounding; NaN where the edge is level leaves all columns.
        let slack = 1e-6 * (1.0 + cross.abs());
        if e.a > 0.0 && cross - slack > low {
            low = cross - slack;
        } else if e.a < 0.0 && cross + slack < high {
            high = cross + slack;
        }
    }
    if low > high {
        return None;
    }
    let [first, last] = t.columns;
    Some([first + low as u32, (first + high as u32).min(last)])
}

/// A bit for each sample at which none of the functions is negative.
#[inline(never)]
fn covered(functions: &[Affine; 5], pattern: &Pattern, x: f64, y: f64) -> u64 {
    let mut inside = [true; SAMPLES];
    for f in functions {
        for k in 0..SAMPLES {
            inside[k] &= f.at(x + pattern.x[k], y + pattern.y[k]) >= f.least;
        }
    }
    let bit = |k: usize| u64::from(inside[k]) << k;
    (0..SAMPLES).map(bit).fold(0, |all, bit| all | bit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_cell_has_a_sample_in_every_pattern() {
        for (side, pass, count) in [(8, 0, 64), (1, 0, 1), (9, 1, 17), (16, 3, 64)] {
            let patterns = Patterns::new(side, pass, 7);
            assert_eq!(patterns.all().count_ones(), count);
            for pixel in (0..200).map(|k| [k, k * 7]) {
                let mut cells: Vec<[u32; 2]> = (0..count as usize)
                    .map(|k| {
                        let [x, y] = patterns.place(pixel, k);
                        let at = |v: f64, p: u32| (v - f64::from(p)) * f64::from(side);
                        [at(x, pixel[0]), at(y, pixel[1])].map(|v| v.floor() as u32)
                    })
                    .collect();
                assert!(cells.as_flattened().iter().all(|&c| c < side), "{cells:?}");
                cells.sort_unstable();
                cells.dedup();
                assert_eq!(cells.len(), count as usize);
            }
        }
    }

    #[test]
    fn neighbours_seldom_have_the_same_pattern() {
        let patterns = Patterns::new(8, 0, 1);
        let same = (0..1000).filter(|&x| {
            let [a, b] = [x, x + 1].map(|x| patterns.place([x, 3], 5)[0].fract());
            a == b
        });
        assert!(same.count() < 60);
    }
}
