//! The cut of a hierarchy for an eye: which clusters are drawn where nothing may deviate by more than so many pixels.

use super::data::{Group, LevelsData, NO_GROUP};

/// An eye that sees levels in perspective, in units of the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutView {
    /// Where the eye is.
    pub eye: [f32; 3],
    /// Pixels a radian at the image's centre: half the image's height over the tangent of half the field of view. Towards
    /// the corners a pixel is smaller, and there the deviation is more of them.
    pub pixels_per_radian: f64,
    /// The nearest that anything is seen, above 0.
    pub near: f64,
    /// The largest factor by which the instance is scaled.
    pub scale: f64,
}

impl CutView {
    /// The error of a group in pixels, as near as any of it may be.
    #[must_use]
    pub fn pixels(&self, group: &Group) -> f64 {
        let apart = (0..3)
            .map(|a| (f64::from(group.centre[a]) - f64::from(self.eye[a])).powi(2))
            .sum::<f64>()
            .sqrt();
        let distance = self.scale * (apart - f64::from(group.radius));
        self.scale * f64::from(group.error) * self.pixels_per_radian / distance.max(self.near)
    }
}

/// The clusters that are drawn so that none deviates by more than so many pixels, in ascending order. With a threshold of
/// 0 all that deviates is left out; where it is NaN or below 0 only original clusters are drawn.
///
/// O(groups + clusters).
#[must_use]
pub fn cut(levels: &LevelsData, view: &CutView, threshold: f64) -> Vec<u32> {
    // NaN is over as well, and so is everything over a threshold that is NaN.
    let kept: Vec<bool> = levels.groups.iter().map(|g| view.pixels(g) <= threshold).collect();
    select(levels, |group| !kept[group as usize])
}

/// The clusters that are drawn where a group is over the threshold as the function says. It must say so of every group
/// above one of which it does.
pub fn select(levels: &LevelsData, over: impl Fn(u32) -> bool) -> Vec<u32> {
    let drawn = |cluster: &usize| {
        let [below, above] = [levels.made_from[*cluster], levels.replaced_by[*cluster]];
        (below == NO_GROUP || !over(below)) && (above == NO_GROUP || over(above))
    };
    (0..levels.made_from.len()).filter(drawn).map(|c| c as u32).collect()
}
