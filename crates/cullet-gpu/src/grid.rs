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

/// A box in steps of a [`Grid`], and the layers of its instance: 16 bytes, as they lie on the
/// device.
///
/// An instance that is not there, being removed or empty, is in no layer, and never drawn. One
/// whose box says nothing, being infinite or not a number, has [`GridBox::ALWAYS`] and is outside
/// of no plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct GridBox {
    /// Lowest steps.
    pub low: [i16; 3],
    /// Highest steps.
    pub high: [i16; 3],
    /// A bit for each layer.
    pub layers: u32,
}

impl GridBox {
    /// A box beyond every grid, in all layers.
    pub const ALWAYS: Self = Self { low: [i16::MIN; 3], high: [i16::MAX; 3], layers: u32::MAX };

    /// Whether it is outside of no plane.
    #[must_use]
    pub fn is_always(&self) -> bool {
        self.low[0] == i16::MIN
    }
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

    /// A box in steps, at least as large, in all layers; `None` where it reaches beyond the grid. A
    /// box that is empty or not finite is [`GridBox::default`] or [always](GridBox::ALWAYS) there.
    #[must_use]
    pub fn round_out(&self, bounds: &Aabb) -> Option<GridBox> {
        if bounds.min.iter().chain(&bounds.max).any(|v| v.is_nan()) {
            return Some(GridBox::ALWAYS);
        }
        if bounds.is_empty() {
            return Some(GridBox::default());
        }
        if !bounds.is_finite() {
            return Some(GridBox::ALWAYS);
        }
        let mut out = GridBox { layers: u32::MAX, ..GridBox::default() };
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

    /// Steps from the origin, moved in a direction by one where the difference was rounded;
    /// dividing by a power of two is exact.
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
