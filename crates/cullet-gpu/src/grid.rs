//! Boxes in whole steps of a grid, 16 bits each, rounded outward.

use bytemuck::{Pod, Zeroable};
use cullet::bounds::Aabb;

/// The largest step number.
pub(crate) const MOST: f64 = 32767.0;

/// A grid: where its zero is, and how far apart its steps are, a power of two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// The zero, in the space of the boxes.
    pub origin: [f64; 3],
    /// Length of a step.
    pub step: f64,
}

/// A box in steps of a [`Grid`], and what an instance is besides: 16 bytes, as they lie on the device.
///
/// An instance without a box, one removed or empty, has `flags` without a bit, and is never drawn. One whose box says nothing, being
/// infinite or not a number, has [`GridBox::ALWAYS`] and is outside of no plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct GridBox {
    /// Lowest steps.
    pub low: [i16; 3],
    /// Highest steps.
    pub high: [i16; 3],
    /// [`GridBox::PRESENT`] and [`GridBox::ALWAYS`].
    pub flags: u32,
}

impl GridBox {
    /// There is an instance.
    pub const PRESENT: u32 = 1;
    /// It is outside of no plane.
    pub const ALWAYS: u32 = 2;
}

impl Grid {
    /// The finest grid that has all of a box. Of an empty or infinite one, some grid.
    #[must_use]
    pub fn around(bounds: &Aabb) -> Self {
        if bounds.is_empty() || !bounds.is_finite() {
            return Self { origin: [0.0; 3], step: 1.0 };
        }
        let origin = bounds.center();
        let reach = (0..3)
            .map(|a| {
                (f64::from(bounds.max[a]) - origin[a]).max(origin[a] - f64::from(bounds.min[a]))
            })
            .fold(0.0, f64::max);
        // Two steps are left for rounding outward.
        let wanted = (reach / (MOST - 2.0)).max(f64::from(f32::MIN_POSITIVE));
        let mut step = wanted.log2().ceil().exp2();
        // The logarithm may be off by an ulp.
        while step * (MOST - 2.0) < reach {
            step *= 2.0;
        }
        Self { origin, step }
    }

    /// A box in steps, at least as large; `None` where it reaches beyond the grid. A box that is empty or not finite is
    /// [`GridBox::default`] or [always](GridBox::ALWAYS) there.
    #[must_use]
    pub fn round_out(&self, bounds: &Aabb) -> Option<GridBox> {
        let always = GridBox { flags: GridBox::PRESENT | GridBox::ALWAYS, ..GridBox::default() };
        if bounds.min.iter().chain(&bounds.max).any(|v| v.is_nan()) {
            return Some(always);
        }
        if bounds.is_empty() {
            return Some(GridBox::default());
        }
        if !bounds.is_finite() {
            return Some(always);
        }
        let mut out = GridBox { flags: GridBox::PRESENT, ..GridBox::default() };
        for a in 0..3 {
            let low = self.steps(bounds.min[a], a, -1.0).floor();
            let high = self.steps(bounds.max[a], a, 1.0).ceil();
            if low < -MOST || high > MOST {
                return None;
            }
            (out.low[a], out.high[a]) = (low as i16, high as i16);
        }
        Some(out)
    }

    /// Steps from the origin, moved in a direction by one where the difference was rounded; dividing by a power of two is exact.
    fn steps(&self, v: f32, a: usize, direction: f64) -> f64 {
        let v = f64::from(v);
        let difference = v - self.origin[a];
        let is_exact = difference + self.origin[a] == v && v - difference == self.origin[a];
        difference / self.step + if is_exact { 0.0 } else { direction }
    }

    /// The box that the steps stand for, in f64.
    #[must_use]
    pub fn to_box(&self, steps: &GridBox) -> [[f64; 3]; 2] {
        let at =
            |s: [i16; 3]| std::array::from_fn(|a| self.origin[a] + f64::from(s[a]) * self.step);
        [at(steps.low), at(steps.high)]
    }
}
