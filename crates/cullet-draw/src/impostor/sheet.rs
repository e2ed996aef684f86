//! The frames of an impostor side by side, as a picture.

use cullet::lod::Impostor;

use crate::picture::Picture;
use crate::picture::palette;

/// What of an impostor a sheet shows.
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

/// One plane of all frames: a row of the grid is a row of the picture, a texel a pixel. `colors` are of the parts, in sRGB;
/// parts beyond them have one of their own.
#[must_use]
pub fn impostor_sheet(impostor: &Impostor, plane: ImpostorPlane, colors: &[[u8; 3]]) -> Picture {
    let (grid, across) = (impostor.grid() as usize, impostor.texels() as usize);
    let side = grid * across;
    let mut rgb = Vec::with_capacity(side * side * 3);
    for y in 0..side {
        for x in 0..side {
            let frame = y / across * grid + x / across;
            let texel = impostor.texel((frame * across + y % across) * across + x % across);
            let byte = |v: f64| (v * 255.0).round() as u8;
            rgb.extend(match plane {
                ImpostorPlane::Coverage => [byte(texel.coverage); 3],
                ImpostorPlane::Depth => [byte(texel.depth * 0.5 + 0.5); 3],
                ImpostorPlane::Normal => texel.normal.map(|v| byte(v * 0.5 + 0.5)),
                ImpostorPlane::Color => {
                    let own = colors.get(texel.part as usize).copied();
                    let color = own.unwrap_or_else(|| palette::material_color(texel.part));
                    color.map(|v| byte(f64::from(v) / 255.0 * texel.coverage))
                }
            });
        }
    }
    Picture { width: side as u32, height: side as u32, rgb }
}
