// A level of a pyramid.

@group(1) @binding(0) var below: texture_2d<f32>;

// The farthest of two by two, those beyond the part that is used as at its edge.
fn farthest_of_four(texel: vec2<u32>, size: vec2<u32>) -> f32 {
    var far = 1.0;
    for (var i = 0u; i < 4u; i++) {
        let at = min(texel + vec2<u32>(i & 1u, i >> 1u), size - 1u);
        far = min(far, textureLoad(below, at, 0).r);
    }
    return far;
}
