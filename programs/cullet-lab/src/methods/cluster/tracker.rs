//! From frame to frame: only clusters that the eye may have passed a border of are looked at again.
//!
//! The idea is that of Kumar, Manocha, Garrett & Lin, *Hierarchical Back-Face Computation* (1996),
//! who track the eye through the regions of each cluster. A distance does the same without regions:
//! while the eye has moved by less than its distance from the border of a cluster's bound, the
//! answer stays. That distance is bounded from below by a value of the bound that changes no faster
//! than the eye moves.

use cullet::Simd;
use cullet::cull::backface::ClusterEye;
use glam::DVec3;

use super::{Bound, ClusterBounds};

/// The answers of a set of bounds for an eye that moves, kept up to date at the cost of the
/// clusters near whose borders it is. The same answers as
/// [`Bulk::cull`](crate::methods::Bulk::cull) in every frame.
#[derive(Clone, Debug)]
pub struct ClusterTracker<B: Bound> {
    bounds: ClusterBounds<B>,
    /// Each bound once more, for its margin.
    singles: Vec<Option<B>>,
    culled: Vec<u64>,
    /// How far the eye had gone in all when a cluster must be looked at again, and the least of
    /// each word's 64 clusters.
    due: Vec<f64>,
    first_due: Vec<f64>,
    gone: f64,
    eye: Option<[f64; 3]>,
    looked_at: usize,
    changed: Vec<u32>,
}

impl<B: Bound> FromIterator<Option<B>> for ClusterTracker<B> {
    fn from_iter<I: IntoIterator<Item = Option<B>>>(bounds: I) -> Self {
        let singles: Vec<Option<B>> = bounds.into_iter().collect();
        let words = singles.len().div_ceil(64);
        Self {
            bounds: singles.iter().copied().collect(),
            culled: vec![0; words],
            // Padded with what is never due.
            due: vec![f64::INFINITY; words * 64],
            first_due: vec![f64::INFINITY; words],
            gone: 0.0,
            eye: None,
            looked_at: 0,
            changed: Vec::with_capacity(singles.len()),
            singles,
        }
    }
}

impl<B: Bound> ClusterTracker<B> {
    /// Moves the eye and returns the mask of culled clusters.
    ///
    /// A position after a position costs what is near a border. A direction (weight 0), and what is
    /// no eye, is answered by a full test, as is the first eye.
    pub fn update(&mut self, simd: Simd, eye: [f64; 4]) -> &[u64] {
        self.changed.clear();
        let prepared = ClusterEye::new(eye);
        let position = prepared
            .filter(|e| e.weight() == 1.0)
            .map(|_| [0, 1, 2].map(|k: usize| eye[k] / eye[3]));
        let step = match (self.eye, position) {
            (Some(a), Some(b)) => DVec3::from(a).distance(b.into()),
            _ => f64::INFINITY,
        };
        self.eye = position;
        // The way of the eye is rounded up and the rest of a margin down: many frames of rounding
        // never add up to a border passed unseen.
        self.gone = (self.gone + step * (1.0 + 4.0 * f64::EPSILON)).next_up();
        if !self.gone.is_finite() {
            self.gone = 0.0;
            self.look_at_all(simd, prepared, position);
            return &self.culled;
        }
        self.looked_at = 0;
        for word in 0..self.culled.len() {
            if self.first_due[word] > self.gone {
                continue;
            }
            let Some((eye, position)) = prepared.as_ref().zip(position) else { continue };
            let mut first = f64::INFINITY;
            let (mut bits, mut looked) = (self.culled[word], 0_u64);
            let end = self.singles.len().min(word * 64 + 64);
            for i in word * 64..end {
                if self.due[i] <= self.gone {
                    looked |= 1 << (i % 64);
                    if let Some(bound) = &self.singles[i] {
                        let bit = u64::from(bound.is_behind_eye(eye)) << (i % 64);
                        bits = bits & !(1 << (i % 64)) | bit;
                        self.due[i] = (self.gone + bound.margin(position)).next_down();
                    }
                }
                first = first.min(self.due[i]);
            }
            self.first_due[word] = first;
            self.looked_at += looked.count_ones() as usize;
            self.set(word, bits);
        }
        &self.culled
    }

    fn look_at_all(&mut self, simd: Simd, eye: Option<ClusterEye>, position: Option<[f64; 3]>) {
        self.looked_at = self.singles.len();
        for word in 0..self.culled.len() {
            let bits = eye.as_ref().map_or(0, |eye| self.bounds.word(simd, word, eye));
            self.set(word, bits);
            let mut first = f64::INFINITY;
            let end = self.singles.len().min(word * 64 + 64);
            for i in word * 64..end {
                // A cluster without a bound is never due.
                if let (Some(bound), Some(position)) = (&self.singles[i], position) {
                    self.due[i] = bound.margin(position);
                    first = first.min(self.due[i]);
                }
            }
            self.first_due[word] = first;
        }
    }

    fn set(&mut self, word: usize, bits: u64) {
        let mut different = self.culled[word] ^ bits;
        self.culled[word] = bits;
        while different != 0 {
            self.changed.push(word as u32 * 64 + different.trailing_zeros());
            different &= different - 1;
        }
    }

    /// The mask of the last [`update`](Self::update): bit i is set where the eye is proved behind
    /// cluster i.
    #[must_use]
    pub fn culled(&self) -> &[u64] {
        &self.culled
    }

    /// The clusters whose answer the last update changed, ascending.
    #[must_use]
    pub fn changed(&self) -> &[u32] {
        &self.changed
    }

    /// How many clusters the last update tested.
    #[must_use]
    pub fn looked_at(&self) -> usize {
        self.looked_at
    }

    /// The bounds.
    #[must_use]
    pub fn bounds(&self) -> &ClusterBounds<B> {
        &self.bounds
    }
}
