// The depth pyramid: each texel the farthest of four. Depth is reversed, so the farthest is the least.
//
// Level l has texel x >> (l + 1) for pixel x, whatever the size: a rectangle of pixels is shifted, never scaled. With sizes rounded
// down, the last row or column would be of no texel, and what is visible there alone would be hidden. So they are rounded up, and
// what has no partner is repeated. Levels of a texture are rounded down, so the texture's first has sides of powers of two, of which a
// part is used.

struct Used { below: vec2<u32>, first: vec2<u32>, second: vec2<u32>, third: vec2<u32> }

// Of a level that is not there nothing is used.
@group(0) @binding(0) var<uniform> used: Used;
@group(0) @binding(1) var first: texture_storage_2d<r32float, write>;
@group(0) @binding(2) var second: texture_storage_2d<r32float, write>;
@group(0) @binding(3) var third: texture_storage_2d<r32float, write>;

// Three levels of the depth or level in group 1: each invocation makes one texel of the third, and what is below it. A third of the
// passes, and no invocation waits for another. What it reads beyond the edge is of the edge, and that is below the same texel.
@compute @workgroup_size(8, 8)
fn make(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy * 4u >= used.first) { return; }
    var of_third = 1.0;
    for (var j = 0u; j < 4u; j++) {
        let above = id.xy * 2u + vec2<u32>(j & 1u, j >> 1u);
        var of_second = 1.0;
        for (var i = 0u; i < 4u; i++) {
            let at = above * 2u + vec2<u32>(i & 1u, i >> 1u);
            let far = farthest_of_four(min(at * 2u, used.below - 1u), used.below);
            if all(at < used.first) { textureStore(first, at, vec4<f32>(far, 0.0, 0.0, 0.0)); }
            of_second = min(of_second, far);
        }
        if all(above < used.second) {
            textureStore(second, above, vec4<f32>(of_second, 0.0, 0.0, 0.0));
        }
        of_third = min(of_third, of_second);
    }
    if all(id.xy < used.third) { textureStore(third, id.xy, vec4<f32>(of_third, 0.0, 0.0, 0.0)); }
}
