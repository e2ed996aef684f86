// The depth pyramid: each texel the farthest of four. Depth is reversed, so the farthest is the least.
//
// Level l has texel x >> (l + 1) for pixel x, whatever the size: a rectangle of pixels is shifted, never scaled. With sizes rounded
// down, the last row or column would be of no texel, and what is visible there alone would be hidden. So they are rounded up, and
// what has no partner is repeated. Levels of a texture are rounded down, so the texture's first has sides of powers of two, of which a
// part is used.

struct Used { below: vec2<u32>, above: vec2<u32> }

@group(0) @binding(0) var<uniform> used: Used;
@group(0) @binding(1) var above: texture_storage_2d<r32float, write>;
@group(0) @binding(2) var below: texture_2d<f32>;

// The first level, of the pixels of group 1.
@compute @workgroup_size(8, 8)
fn first(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= used.above) { return; }
    let last = used.below - 1u;
    var far = 1.0;
    for (var i = 0u; i < 4u; i++) {
        let at = min(id.xy * 2u + vec2<u32>(i & 1u, i >> 1u), last);
        far = min(far, depth_of(at));
    }
    textureStore(above, id.xy, vec4<f32>(far, 0.0, 0.0, 0.0));
}

// A level of the one below.
@compute @workgroup_size(8, 8)
fn next(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= used.above) { return; }
    let last = used.below - 1u;
    var far = 1.0;
    for (var i = 0u; i < 4u; i++) {
        let at = min(id.xy * 2u + vec2<u32>(i & 1u, i >> 1u), last);
        far = min(far, textureLoad(below, at, 0).r);
    }
    textureStore(above, id.xy, vec4<f32>(far, 0.0, 0.0, 0.0));
}
