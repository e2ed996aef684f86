//! Claims of an occlusion buffer against samples of what was drawn: pixel by pixel, and depth by
//! depth.
//!
//! A buffer says of a pixel that all of it is covered by something at least so near.
//! [`check_claims`] takes it at its word: every one of N × N jittered samples of that pixel must
//! lie in a triangle of an occluder that shows the side it is drawn from, is not cut off by the
//! near plane, and is at least so near there. Tests of boxes find a wrong claim only where a box
//! happens to lie behind it; this finds it wherever it is.
//!
//! Not a line of the engine's occlusion culling is used: vertices go through the view's matrix in
//! f64, triangles are homogeneous edge functions (Olano & Greer, *Triangle Scan Conversion Using 2D
//! Homogeneous Coordinates*, 1997), so that what crosses the near plane is cut nowhere. Each pixel
//! holds its samples that nothing covers yet as the bits of a word. A pixel that lies wholly within
//! one triangle that is near enough in all of it is done without looking at samples.

mod sample;
mod scene;
mod triangle;

use cullet::View;
use cullet::cull::occlusion::OcclusionBuffer;
use rayon::prelude::*;

use cullet_draw::OccluderTriangles;
use cullet_draw::in_pool;

pub use scene::SceneOccluders;

use sample::{Patterns, Strip};
use triangle::{ObjectRows, ScreenRows, Triangle};

/// Claims of an occlusion buffer: a nearness for each pixel, 0 where it claims nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct Claims {
    size: [u32; 2],
    nearness: Vec<f32>,
}

impl Claims {
    /// No claim, in a buffer of `size` pixels.
    #[must_use]
    pub fn none(size: [u32; 2]) -> Self {
        Self { size, nearness: vec![0.0; size[0] as usize * size[1] as usize] }
    }

    /// The claims of a buffer as it stands.
    #[must_use]
    pub fn of(buffer: &OcclusionBuffer) -> Self {
        let mut claims = Self::none(buffer.size());
        let wide = claims.size[0].max(1);
        for (at, nearness) in (0..).zip(&mut claims.nearness) {
            *nearness = buffer.nearness(at % wide, at / wide);
        }
        claims
    }

    /// Width and height in pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The claim of a pixel; 0 beyond the buffer.
    #[must_use]
    pub fn nearness(&self, x: u32, y: u32) -> f32 {
        self.place(x, y).map_or(0.0, |at| self.nearness[at])
    }

    /// Makes a claim, in place of that of the buffer. Nothing beyond it.
    pub fn claim(&mut self, x: u32, y: u32, nearness: f32) {
        if let Some(at) = self.place(x, y) {
            self.nearness[at] = nearness;
        }
    }

    fn place(&self, x: u32, y: u32) -> Option<usize> {
        let [wide, high] = self.size;
        (x < wide && y < high).then(|| y as usize * wide as usize + x as usize)
    }
}

/// How claims are checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClaimOptions {
    /// N: each pixel is cut into N × N cells, with one sample in each.
    /// 1..=[`MOST_SAMPLES`](Self::MOST_SAMPLES), clamped; default 8. Cost: a pass over the
    /// triangles for each 64 samples of a pixel.
    pub samples: u32,
    /// Seed of the place of each sample in its cell.
    pub seed: u64,
    /// How many threads; 0, the default, is those of the pool that the call runs in. The answer is
    /// the same.
    pub threads: usize,
    /// How many wrong pixels are listed; all are counted. Default 8.
    pub listed: usize,
}

impl ClaimOptions {
    /// The most samples along a side of a pixel.
    pub const MOST_SAMPLES: u32 = 32;
}

impl Default for ClaimOptions {
    fn default() -> Self {
        Self { samples: 8, seed: 1, threads: 0, listed: 8 }
    }
}

/// A pixel whose claim a sample refutes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WrongClaim {
    /// Column and row, from the top left.
    pub pixel: [u32; 2],
    /// Claimed nearness.
    pub claimed: f32,
    /// Samples of the pixel that refute it, of those of the pass that found it.
    pub samples: u32,
    /// The first of them, in pixels from the top left corner of the buffer.
    pub sample: [f64; 2],
    /// The greatest nearness of an occluder there; `None` where no occluder covers the sample.
    pub found: Option<f64>,
}

/// Result of a check.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClaimCheck {
    /// Pixels of the buffer.
    pub pixels: u64,
    /// Pixels that claim something.
    pub claimed: u64,
    /// Pixels among them whose claim is wrong.
    pub wrong: u64,
    /// The first wrong ones, row by row.
    pub first: Vec<WrongClaim>,
}

/// Triangles set up at a time: some 14 MB.
const BATCH: usize = 1 << 16;

/// Rows of pixels of a job.
const STRIP: u32 = 16;

/// Holds each claim of a buffer against samples of the occluders that were drawn into it, or of all
/// that is opaque.
///
/// Nearness is that of [`OcclusionBuffer::nearness`]: 1 / w in perspective, w being the distance
/// along the line of view; in orthographic views the distance from the far plane, as a share of the
/// depth range. A triangle covers a sample where the sample is within its three edges, edges
/// included, and it is beyond the near plane there. One-sided triangles cover where they show their
/// front (counter-clockwise, or as a mirrored transform or view turns it), two-sided ones from both
/// sides. The view's layers, `front_face`, `cull_face` and far plane play no part.
///
/// # Tolerance
/// That of f64 alone: bounds on what rounding does to a vertex (16 units in the last place of its
/// terms) are carried through the edge functions and the plane of each triangle, taken relative to
/// a pixel beside it. A sample that lies outside, or is too far, by less than that counts as
/// covered: less than 1e-9 of a pixel for a triangle in the middle of the screen. Triangles so thin
/// that their side is in doubt cover nothing.
///
/// # Edges of what is allowed
/// A claim that is NaN is wrong. Triangles with a vertex that is not finite, or not there, cover
/// nothing. A buffer without a claim is right.
///
/// Cost: linear in the triangles in view and in the pixels of their areas; what costs most are
/// pixels that a triangle covers in part, for each of which all samples are looked at.
#[must_use]
pub fn check_claims(
    view: &View,
    claims: &Claims,
    occluders: &[OccluderTriangles<'_>],
    options: &ClaimOptions,
) -> ClaimCheck {
    in_pool(options.threads, || Check::new(view, claims, occluders, options).run())
}

/// Whether a pixel claims anything; what is no number does, and wrongly.
fn is_claim(nearness: f32) -> bool {
    nearness > 0.0 || nearness.is_nan()
}

/// All that a check looks at.
struct Check<'a> {
    claims: &'a Claims,
    occluders: &'a [OccluderTriangles<'a>],
    rows: ScreenRows,
    options: &'a ClaimOptions,
}

impl<'a> Check<'a> {
    fn new(
        view: &View,
        claims: &'a Claims,
        occluders: &'a [OccluderTriangles<'a>],
        options: &'a ClaimOptions,
    ) -> Self {
        Self { claims, occluders, rows: ScreenRows::new(view, claims.size), options }
    }

    fn run(&self) -> ClaimCheck {
        let Claims { size, nearness } = self.claims;
        let mut check = ClaimCheck {
            pixels: nearness.len() as u64,
            claimed: nearness.iter().filter(|v| is_claim(**v)).count() as u64,
            ..ClaimCheck::default()
        };
        if check.claimed == 0 {
            return check;
        }
        let mut wrong = vec![false; nearness.len()];
        let side = self.options.samples.clamp(1, ClaimOptions::MOST_SAMPLES);
        for pass in 0..(side * side).div_ceil(64) {
            let patterns = Patterns::new(side, pass, self.options.seed);
            let open = self.open_samples(&patterns);
            for (at, open) in open.iter().enumerate().filter(|(_, open)| **open != 0) {
                if std::mem::replace(&mut wrong[at], true) {
                    continue;
                }
                check.wrong += 1;
                if check.first.len() < self.options.listed {
                    let pixel = [at as u32 % size[0], at as u32 / size[0]];
                    let sample = patterns.place(pixel, open.trailing_zeros() as usize);
                    check.first.push(WrongClaim {
                        pixel,
                        claimed: nearness[at],
                        samples: open.count_ones(),
                        sample,
                        found: self.nearest(sample),
                    });
                }
            }
        }
        check
    }

    /// The samples of each pixel that refute its claim.
    fn open_samples(&self, patterns: &Patterns) -> Vec<u64> {
        let Claims { size: [wide, high], nearness } = self.claims;
        let all = patterns.all();
        let mut open: Vec<u64> =
            nearness.iter().map(|&v| if is_claim(v) { all } else { 0 }).collect();
        let strips = high.div_ceil(STRIP) as usize;
        let mut bins: Vec<Vec<u32>> = vec![Vec::new(); strips];
        self.each_batch(|triangles| {
            bins.iter_mut().for_each(Vec::clear);
            for (number, t) in (0_u32..).zip(triangles) {
                let [first, last] = [t.rows[0] / STRIP, t.rows[1] / STRIP];
                for bin in &mut bins[first as usize..=last as usize] {
                    bin.push(number);
                }
            }
            let strip = (*wide * STRIP) as usize;
            open.par_chunks_mut(strip)
                .zip(nearness.par_chunks(strip))
                .zip(&bins)
                .enumerate()
                .for_each(|(number, ((open, claims), bin))| {
                    let first_row = number as u32 * STRIP;
                    let mut strip = Strip { open, claims, wide: *wide, first_row, patterns };
                    bin.iter().for_each(|&t| strip.cover(&triangles[t as usize]));
                });
        });
        open
    }

    /// Sets up the triangles that may touch the screen, a batch at a time.
    fn each_batch(&self, mut visit: impl FnMut(&[Triangle])) {
        let mut batch = Vec::with_capacity(BATCH);
        for o in self.occluders {
            let rows = self.rows.of_object(&o.transform);
            let indices = o.indices.as_chunks::<3>().0;
            if !rows.may_see(o.positions, indices) {
                continue;
            }
            for some in indices.chunks(BATCH) {
                if batch.len() + some.len() > BATCH {
                    visit(&batch);
                    batch.clear();
                }
                let made = |t: &[u32; 3]| self.triangle(&rows, o, *t);
                // What is small is not worth a job.
                if some.len() < 256 {
                    batch.extend(some.iter().filter_map(made));
                } else {
                    batch.par_extend(some.par_iter().filter_map(made));
                }
            }
        }
        visit(&batch);
    }

    fn triangle(
        &self,
        rows: &ObjectRows,
        o: &OccluderTriangles<'_>,
        corners: [u32; 3],
    ) -> Option<Triangle> {
        let [a, b, c] = corners.map(|v| o.positions.get(v as usize).copied());
        Triangle::new(rows, [a?, b?, c?], o.two_sided, self.claims.size)
    }

    /// The greatest nearness of an occluder at a place.
    fn nearest(&self, place: [f64; 2]) -> Option<f64> {
        let mut nearest: Option<f64> = None;
        self.each_batch(|triangles| {
            for n in triangles.iter().filter_map(|t| t.nearness_at(place)) {
                nearest = Some(nearest.map_or(n, |m| m.max(n)));
            }
        });
        nearest
    }
}
