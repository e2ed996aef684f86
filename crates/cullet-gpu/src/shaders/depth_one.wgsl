// The depth that was drawn, of one sample a pixel.

@group(1) @binding(0) var depth: texture_depth_2d;
// Of the nearest texel, and of those at the edge beyond it.
@group(1) @binding(1) var nearest: sampler;

// Where in a pixel what is drawn can be seen: in its middle.
const INSET = 0.5;

fn depth_of(pixel: vec2<u32>) -> f32 { return textureLoad(depth, pixel, 0); }

// The farthest of two by two, of which the first is within the picture; around their common corner.
fn farthest_of_four(pixel: vec2<u32>, size: vec2<u32>) -> f32 {
    let four = textureGather(depth, nearest, vec2<f32>(pixel + 1u) / vec2<f32>(size));
    return min(min(four.x, four.y), min(four.z, four.w));
}
