// The depth that was drawn, of several samples a pixel: the farthest of them.

@group(1) @binding(0) var depth: texture_depth_multisampled_2d;

// Anywhere in a pixel may be a sample.
const INSET = 0.0;

fn depth_of(pixel: vec2<u32>) -> f32 {
    var far = 1.0;
    for (var s = 0u; s < textureNumSamples(depth); s++) {
        far = min(far, textureLoad(depth, pixel, s));
    }
    return far;
}

fn farthest_of_four(pixel: vec2<u32>, size: vec2<u32>) -> f32 {
    var far = 1.0;
    for (var i = 0u; i < 4u; i++) {
        far = min(far, depth_of(min(pixel + vec2<u32>(i & 1u, i >> 1u), size - 1u)));
    }
    return far;
}
