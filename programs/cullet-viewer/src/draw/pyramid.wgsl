// A level of the depth pyramid, in the greys of the picture of depth.

struct Shown {
    // The world relative to the eye from clip space.
    world: mat4x4<f32>,
    // Towards the viewer, and 1, where lines of sight are parallel; else w is 0.
    sight: vec4<f32>,
    // Left, top, width and height in the target.
    place: vec4<f32>,
    // Of the picture that the pyramid is of.
    size: vec2<f32>,
    // The distance that is half dark.
    half: f32,
    level: u32,
}

@group(0) @binding(0) var<uniform> shown: Shown;
@group(0) @binding(1) var pyramid: texture_2d<f32>;

// What nothing covers: as in the picture of the occlusion buffer.
const OPEN = vec3<f32>(16.0, 26.0, 60.0) / 255.0;

// One triangle over all of the place.
@vertex
fn vs(@builtin(vertex_index) n: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32(n & 1u) * 4.0 - 1.0, f32(n >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

fn to_linear(c: vec3<f32>) -> vec3<f32> {
    return select(pow((c + 0.055) / 1.055, vec3<f32>(2.4)), c / 12.92, c <= vec3<f32>(0.04045));
}

@fragment
fn fs(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let share = (at.xy - shown.place.xy) / shown.place.zw;
    let pixel = min(vec2<u32>(max(share, vec2<f32>(0.0)) * shown.size), vec2<u32>(shown.size) - 1u);
    // Texel x >> (l + 1) is that of pixel x in level l.
    let texel = pixel >> vec2<u32>(shown.level + 1u);
    let depth = textureLoad(pyramid, texel, shown.level).r;
    if depth <= 0.0 {
        return vec4<f32>(to_linear(OPEN), 1.0);
    }
    // One grey for all of a texel: that of its middle.
    let middle = (vec2<f32>(texel) + 0.5) * f32(2u << shown.level) / shown.size * 2.0 - 1.0;
    let p = shown.world * vec4<f32>(middle.x, -middle.y, depth, 1.0);
    let world = p.xyz / p.w;
    var distance = length(world);
    if shown.sight.w != 0.0 {
        distance = max(-dot(world, shown.sight.xyz), 0.0);
    }
    return vec4<f32>(to_linear(vec3<f32>(shown.half / (shown.half + distance))), 1.0);
}
