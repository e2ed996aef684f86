// Which instances are not hidden by what was drawn: the second of two phases, with the matrices of this frame.
//
// Errs to "visible": a corner's place and depth are widened by what f32 may be off, a rectangle by half a step of a rasteriser of 64 steps a pixel.

struct Frame {
    size: vec2<f32>,
    // Half a pixel where what is drawn has one sample a pixel, in its middle; 0 where it has more.
    inset: f32,
    blocks: u32,
}

@group(0) @binding(0) var<storage, read> boxes: array<GridBox>;
@group(0) @binding(1) var<storage, read> in_use: array<InUse>;
// For each block in use, from its grid to clip space.
@group(0) @binding(2) var<storage, read> matrices: array<mat4x4<f32>>;
// A bit a slot: what passed the exact stages.
@group(0) @binding(3) var<storage, read> passed: array<u32>;
// The same, cleared before.
@group(0) @binding(4) var<storage, read_write> visible: array<atomic<u32>>;
@group(0) @binding(5) var<uniform> frame: Frame;
// For each block in use a box around all of it, and whether that is hidden.
@group(0) @binding(6) var<storage, read> around: array<GridBox>;
@group(0) @binding(7) var<storage, read_write> hidden: array<u32>;
// Of the depth in group 1.
@group(2) @binding(0) var pyramid: texture_2d<f32>;

// Sixteen halves of an ulp of the sum of the terms: four products and their sum take four here, and as many where it is drawn.
const ERROR = 9.5367431640625e-7;
// What a depth between corners may be off by where it is drawn.
const DEPTH_SHARE = 3.814697265625e-6;
const DEPTH_STEP = 1.1920928955078125e-7;
const SLACK = 0.0078125;

struct Seen {
    low: vec2<f32>,
    high: vec2<f32>,
    nearest: f32,
    // Whether some corner is not in front of the near plane for sure.
    is_near: bool,
}

fn seen_of(b: GridBox, m: mat4x4<f32>) -> Seen {
    let low = vec3<f32>(low_corner(b));
    let high = vec3<f32>(high_corner(b));
    var out = Seen(vec2<f32>(3e38), vec2<f32>(-3e38), 0.0, true);
    // The largest terms of any corner.
    let far = max(abs(low), abs(high));
    let terms = abs(m[0]) * far.x + abs(m[1]) * far.y + abs(m[2]) * far.z + abs(m[3]);
    if !all(terms < vec4<f32>(1e30)) { return out; }
    let off = terms * ERROR;
    // Of each axis the two ends.
    let x = array<vec4<f32>, 2>(m[0] * low.x, m[0] * high.x);
    let y = array<vec4<f32>, 2>(m[1] * low.y, m[1] * high.y);
    let z = array<vec4<f32>, 2>(m[2] * low.z + m[3], m[2] * high.z + m[3]);
    for (var i = 0u; i < 8u; i++) {
        let p = x[i & 1u] + y[(i >> 1u) & 1u] + z[i >> 2u];
        let w = p.w - off.w;
        if !(w > 0.0) { return out; }
        let r = p.xyz * (1.0 / p.w);
        let widened = (off.xyz + abs(r) * off.w) * (1.0 / w) + abs(r) * ERROR;
        out.low = min(out.low, r.xy - widened.xy);
        out.high = max(out.high, r.xy + widened.xy);
        out.nearest = max(out.nearest, r.z + widened.z);
    }
    out.is_near = out.nearest >= 1.0;
    return out;
}

// Texels beyond a level are those at its edge. No level of ours has such; with sizes rounded down, this is how things vanish.
override CLAMPED: bool = false;

fn farthest(texel: vec2<u32>, shift: u32) -> f32 {
    if shift == 0u { return depth_of(texel); }
    var at = texel;
    if CLAMPED { at = min(at, max(vec2<u32>(frame.size) >> vec2<u32>(shift), vec2<u32>(1u)) - 1u); }
    return textureLoad(pyramid, at, shift - 1u).r;
}

// Whether a depth is farther than all texels of a rectangle of pixels.
fn is_behind(nearest: f32, first: vec2<u32>, end: vec2<u32>, shift: u32) -> bool {
    // Not held against the level's size: one device answers that with the level of another invocation.
    let from_texel = first >> vec2<u32>(shift);
    let to_texel = end >> vec2<u32>(shift);
    for (var y = from_texel.y; y <= to_texel.y; y++) {
        for (var x = from_texel.x; x <= to_texel.x; x++) {
            if nearest >= farthest(vec2<u32>(x, y), shift) { return false; }
        }
    }
    return true;
}

fn is_hidden(b: GridBox, m: mat4x4<f32>) -> bool {
    let seen = seen_of(b, m);
    if seen.is_near { return false; }
    // From the top left corner, in pixels whose middle may be covered.
    let half = frame.size * 0.5;
    let top_left = vec2<f32>(seen.low.x, -seen.high.y) * half + half;
    let bottom_right = vec2<f32>(seen.high.x, -seen.low.y) * half + half;
    let last = frame.size - 1.0;
    let inset = min(frame.inset, INSET);
    let from_pixel = max(floor(top_left + inset - SLACK), vec2<f32>(0.0));
    let to_pixel = min(floor(bottom_right - inset + SLACK), last);
    // It covers no pixel.
    if any(from_pixel > to_pixel) { return true; }
    let first = vec2<u32>(from_pixel);
    let end = vec2<u32>(to_pixel);
    // The finest on which it covers at most four by four texels: the picture itself, or level l with texel x >> (l + 1) for pixel x.
    let across = end - first;
    let span = max(max(across.x, across.y), 1u);
    var shift = max(firstLeadingBit(span), 1u) - 1u;
    let wide = (end >> vec2<u32>(shift)) - (first >> vec2<u32>(shift));
    if max(wide.x, wide.y) > 3u { shift += 1u; }
    shift = min(shift, textureNumLevels(pyramid));
    let nearest = seen.nearest * (1.0 + DEPTH_SHARE) + DEPTH_STEP;
    // Two by two of what is four times as coarse say it of most that is hidden.
    let coarse = shift + 2u;
    if coarse <= textureNumLevels(pyramid) {
        let a = first >> vec2<u32>(coarse);
        let b = end >> vec2<u32>(coarse);
        let far = min(
            min(farthest(a, coarse), farthest(vec2<u32>(b.x, a.y), coarse)),
            min(farthest(vec2<u32>(a.x, b.y), coarse), farthest(b, coarse)),
        );
        if nearest < far { return true; }
    }
    if is_behind(nearest, first, end, shift) { return true; }
    // A level finer finds a third of what is hidden and was not found, and is left at the first texel that is too far.
    return shift > 0u && is_behind(nearest, first, end, shift - 1u);
}

// Whole blocks first: behind a wall are many.
@compute @workgroup_size(256)
fn blocks(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let number = (group.x + group.y * ROW) * 256u + lane;
    if number >= frame.blocks { return; }
    let own = around[number];
    hidden[number] = u32(!is_always(own) && is_hidden(own, matrices[number]));
}

// Without a barrier, so that software may run one invocation after the other; few are visible, so that few wait for each other's bit.
@compute @workgroup_size(256)
fn late(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let number = group.x + group.y * ROW;
    if number >= frame.blocks || hidden[number] != 0u { return; }
    let block = in_use[number].block;
    let word = block * 8u + lane / 32u;
    let bit = 1u << (lane % 32u);
    if (passed[word] & bit) == 0u { return; }
    let own = boxes[block * 256u + lane];
    if is_always(own) || !is_hidden(own, matrices[number]) { atomicOr(&visible[word], bit); }
}
