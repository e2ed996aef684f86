//! The frames of an impostor side by side, as a picture.

use cullet_mesh::{Impostor, Texel};

use crate::picture::Picture;
use crate::picture::palette;

/// Plane of an impostor that a sheet shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ImpostorPlane {
    /// How much of each texel is covered: from black to white.
    Coverage,
    /// A colour for each part, multiplied by the coverage.
    Color,
    /// Normals: red, green and blue are x, y and z, from −1 to 1.
    Normal,
    /// How near the surface is: from black, at the back of the box, to white.
    Depth,
}

impl ImpostorPlane {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Coverage, Self::Color, Self::Normal, Self::Depth];

    /// Its name in a file's.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Coverage => "coverage",
            Self::Color => "color",
            Self::Normal => "normal",
            Self::Depth => "depth",
        }
    }
}

/// All texels as a picture has them: a row of the grid is a row of it, a texel a pixel, from the
/// top; and how long its side is.
pub(super) fn texels(impostor: &Impostor) -> (usize, impl Iterator<Item = Texel>) {
    let (grid, across) = (impostor.grid() as usize, impostor.texels() as usize);
    let side = grid * across;
    let all = (0..side * side).map(move |pixel| {
        let (x, y) = (pixel % side, pixel / side);
        let frame = y / across * grid + x / across;
        impostor.texel((frame * across + y % across) * across + x % across)
    });
    (side, all)
}

/// The colour of the part that a texel is of; parts beyond those given have one of their own.
pub(super) fn part_color(texel: &Texel, colors: &[[u8; 3]]) -> [u8; 3] {
    let own = colors.get(texel.part as usize).copied();
    own.unwrap_or_else(|| palette::material_color(texel.part))
}

/// One plane of all frames: a row of the grid is a row of the picture, a texel a pixel. `colors`
/// are of the parts, in sRGB; parts beyond them have one of their own.
#[must_use]
pub fn impostor_sheet(impostor: &Impostor, plane: ImpostorPlane, colors: &[[u8; 3]]) -> Picture {
    let (side, texels) = texels(impostor);
    let byte = |v: f64| (v * 255.0).round() as u8;
    let rgb = texels.flat_map(|texel| match plane {
        ImpostorPlane::Coverage => [byte(texel.coverage); 3],
        ImpostorPlane::Depth => [byte(texel.depth * 0.5 + 0.5); 3],
        ImpostorPlane::Normal => texel.normal.map(|v| byte(v * 0.5 + 0.5)),
        ImpostorPlane::Color => {
            part_color(&texel, colors).map(|v| byte(f64::from(v) / 255.0 * texel.coverage))
        }
    });
    Picture { rgb: rgb.collect(), width: side as u32, height: side as u32 }
}
