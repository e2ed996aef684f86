//! Planes over the screen: how near a face is at a pixel, at least.

use super::screen::{Doubt, Spot};
use crate::array::Each;
#[cfg(not(feature = "std"))]
use crate::math::Float as _;

/// An affine lower bound of nearness: over the whole pixel in column x and row y, a face that
/// covers the pixel is at least as near as `at(x, y)`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Plane {
    pub(crate) dx: f32,
    pub(crate) dy: f32,
    /// The bound at the pixel (column, row).
    pub(crate) value: f32,
    pub(crate) column: f32,
    pub(crate) row: f32,
}

impl Plane {
    /// The bound of a face through three spots that lie well apart in it, whose outline is `reach`
    /// pixels wide and high, on a screen of `size` pixels; the spots are off by `doubt` at most.
    pub(crate) fn through(
        spots: [Spot; 3],
        reach: [f64; 2],
        size: [u32; 2],
        doubt: &Doubt,
    ) -> Self {
        let [a, b, c] = spots;
        let least = a.nearness.min(b.nearness).min(c.nearness);
        let most = a.nearness.max(b.nearness).max(c.nearness);
        let (bx, by, bn) = (b.x - a.x, b.y - a.y, b.nearness - a.nearness);
        let (cx, cy, cn) = (c.x - a.x, c.y - a.y, c.nearness - a.nearness);
        let area = bx * cy - cx * by;
        let (gx, gy) = ((bn * cy - cn * by) / area, (bx * cn - cx * bn) / area);
        let [width, height] = size.each(f64::from);
        let (column, row) = (a.x.floor().clamp(0.0, width), a.y.floor().clamp(0.0, height));
        let (to_x, to_y) = (column + 0.5 - a.x, row + 0.5 - a.y);
        let middle = a.nearness + gx * to_x + gy * to_y - 0.5 * (gx.abs() + gy.abs());
        // Rounding error of the gradients, over the distance that they are followed.
        let terms = ((bx * cy).abs() + (cx * by).abs()) / area.abs();
        let (width, height) = (reach[0].min(width) + 2.0, reach[1].min(height) + 2.0);
        let steep_x = ((bn * cy).abs() + (cn * by).abs()) / area.abs() + gx.abs() * terms;
        let steep_y = ((bn * cx).abs() + (cn * bx).abs()) / area.abs() + gy.abs() * terms;
        let rounding = 16.0
            * f64::EPSILON
            * (most + steep_x * (to_x.abs() + width) + steep_y * (to_y.abs() + height));
        // Within a face, a plane through spots that span much of it is off by no more than a few
        // times as much as they are.
        let moved = 8.0 * ((gx.abs() + gy.abs()) * doubt.pixels + doubt.nearness);
        // All that f32 does later.
        let scale = gx.abs() * width + gy.abs() * height + middle.abs() + most;
        let value = middle - rounding - moved - scale * 2.0_f64.powi(-20);
        if area == 0.0 || !value.is_finite() || scale > 1e6 * most {
            return Self::level(least - 8.0 * doubt.nearness);
        }
        Self {
            dx: gx as f32,
            dy: gy as f32,
            value: value as f32,
            column: column as f32,
            row: row as f32,
        }
    }

    /// The same bound everywhere.
    pub(crate) fn level(nearness: f64) -> Self {
        let value = (nearness * (1.0 - 2.0_f64.powi(-20))) as f32;
        Self { value: if value.is_finite() { value } else { 0.0 }, ..Self::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_bound_is_below_the_nearness_it_is_made_of() {
        for nearness in [1e-6, 0.1, 1.0, 7.3e4] {
            let value = f64::from(Plane::level(nearness).value);
            assert!(value < nearness && value > nearness * (1.0 - 2.0_f64.powi(-19)), "{nearness}");
        }
    }
}
