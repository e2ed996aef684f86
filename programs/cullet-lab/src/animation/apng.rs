//! The file of an animated PNG.

use png::{BitDepth, BlendOp, ColorType, Compression, DisposeOp, Encoder, EncodingError, Filter};

use super::Animation;

pub(super) fn write(of: &Animation) -> Vec<u8> {
    let mut bytes = Vec::new();
    // Memory has no error to give, and the numbers were checked when the film was made.
    let written = encode(of, &mut bytes);
    debug_assert!(written.is_ok(), "{written:?}");
    bytes
}

fn encode(of: &Animation, bytes: &mut Vec<u8>) -> Result<(), EncodingError> {
    let mut encoder = Encoder::new(bytes, of.size[0], of.size[1]);
    encoder.set_color(ColorType::Indexed);
    encoder.set_depth(BitDepth::Eight);
    // The last colour is clear: all others are opaque.
    let palette: Vec<u8> = of.palette.iter().flatten().copied().chain([0; 3]).collect();
    let mut alpha = vec![255; of.palette.len()];
    alpha.push(0);
    encoder.set_palette(palette);
    encoder.set_trns(alpha);
    encoder.set_compression(Compression::High);
    // Indices are no amounts: the difference of two says nothing.
    encoder.set_filter(Filter::NoFilter);
    encoder.set_animated(of.frame_count() as u32, 0)?;
    let mut writer = encoder.write_header()?;
    for number in 0..of.frame_count() {
        let part = of.changed(number);
        let (whole, sparse) = of.cut(number, &part);
        let [from, to] = of.shown_ms(number);
        writer.set_frame_delay((to - from) as u16, 1000)?;
        writer.set_dispose_op(DisposeOp::None)?;
        if number > 0 {
            // Each is held against the other as it is: first where any size fits.
            writer.set_frame_position(0, 0)?;
            writer.set_frame_dimension(part.size[0], part.size[1])?;
            writer.set_frame_position(part.at[0], part.at[1])?;
            writer.set_blend_op(BlendOp::Over)?;
        }
        writer.write_image_data(sparse.as_ref().unwrap_or(&whole))?;
    }
    writer.finish()
}
