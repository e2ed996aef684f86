// The scene: instances placed from a texture, painted in one of eight ways. No storage buffers, so that it
// runs on WebGL2 as well.

struct Pane {
    // Clip space from world space relative to the eye.
    clip: mat4x4<f32>,
    // The eye (or, where lines of sight are parallel, a point of the near plane) as the sum of two floats,
    // so that far from the origin nothing jitters. In w: world units a pixel where clip w is 1.
    eye_high: vec4<f32>,
    // In w: the distance that Depth paints half dark.
    eye_low: vec4<f32>,
    // Towards the viewer, and 1, where lines of sight are parallel; else w is 0.
    sight: vec4<f32>,
    background: vec4<f32>,
    size: vec2<f32>,
    flags: u32,
    // log2 of the width of the textures that hold lists.
    shift: u32,
    far: f32,
    pad_a: f32,
    pad_b: vec2<f32>,
}

// What triangles are painted by. Each pipeline has its own: a program that stands in for a graphics card
// computes every side of a branch for every pixel, and the heat of a triangle's size alone takes several
// times as long as the colour of a material.
override PAINT: u32 = 0u;

const MATERIAL = 0u;
const SIDES = 1u;
const CLUSTERS = 2u;
const INSTANCES = 3u;
const OVERDRAW = 4u;
const TRIANGLE_SIZE = 5u;
const LEVELS = 7u;

// Clockwise on the screen is front, by the view and the style.
const FLIPPED = 1u;
// Normals point the other way, by the style alone.
const CLOCKWISE = 2u;
const FILL = 4u;
const WIRE = 8u;
// Instances are drawn by the alpha of their colour.
const FADE = 16u;
// What goes is drawn, in the pixels that what comes in its place leaves.
const GOING = 32u;

@group(0) @binding(0) var<uniform> pane: Pane;
// Four texels a slot: rows of the linear part with the high half of the translation, then its low half
// and 1, negative where the instance is mirrored, 2 where it is transparent.
@group(0) @binding(1) var transforms: texture_2d<f32>;
@group(0) @binding(2) var parts: texture_2d<f32>;
@group(0) @binding(3) var instance_colours: texture_2d<f32>;
@group(1) @binding(0) var vertices: texture_2d<u32>;
@group(1) @binding(1) var indices: texture_2d<u32>;
@group(1) @binding(2) var normals: texture_2d<f32>;

fn at(i: u32) -> vec2<u32> {
    return vec2<u32>(i & ((1u << pane.shift) - 1u), i >> pane.shift);
}

struct Place {
    rows: mat3x3<f32>,
    offset: vec3<f32>,
    // 1, or -1 where the instance is mirrored.
    hand: f32,
    // The most that alpha may be: an instance that is declared transparent is so, whatever its material.
    opacity: f32,
}

fn place_of(slot: u32) -> Place {
    let a = textureLoad(transforms, at(slot * 4u), 0);
    let b = textureLoad(transforms, at(slot * 4u + 1u), 0);
    let c = textureLoad(transforms, at(slot * 4u + 2u), 0);
    let low = textureLoad(transforms, at(slot * 4u + 3u), 0);
    let high = vec3<f32>(a.w, b.w, c.w);
    let offset = (high - pane.eye_high.xyz) + (low.xyz - pane.eye_low.xyz);
    return Place(mat3x3<f32>(a.xyz, b.xyz, c.xyz), offset, sign(low.w), select(1.0, 0.5, abs(low.w) > 1.5));
}

fn relative(place: Place, p: vec3<f32>) -> vec3<f32> {
    return p * place.rows + place.offset;
}

fn to_clip(p: vec3<f32>) -> vec4<f32> {
    return pane.clip * vec4<f32>(p, 1.0);
}

// Behind every far plane, so that it is clipped away.
const NOWHERE = vec4<f32>(0.0, 0.0, 2.0, 1.0);

struct Varying {
    @builtin(position) position: vec4<f32>,
    // Relative to the eye.
    @location(0) world: vec3<f32>,
    @location(1) @interpolate(flat) colour: vec4<f32>,
    // Which corner, for edges; and the pixels of the triangle in w.
    @location(2) corner: vec3<f32>,
    @location(3) @interpolate(flat) hand_and_area: vec2<f32>,
    // By which share the instance is drawn.
    @location(4) @interpolate(flat) share: f32,
}

// A hue for a cluster: steps of the golden ratio, in three shades, so that neighbours differ.
fn cluster_colour(n: u32) -> vec3<f32> {
    let hue = fract(f32(n) * 0.61803399);
    let rgb = clamp(abs(fract(vec3<f32>(hue) + vec3<f32>(0.0, 0.6666667, 0.3333333)) * 6.0 - 3.0) - 1.0, vec3<f32>(0.0), vec3<f32>(1.0));
    let shade = 0.45 + 0.2 * f32(n % 3u);
    return mix(vec3<f32>(shade), rgb, 0.6) * shade * 1.4;
}

// The colours of levels of detail, as the pictures of the library have them.
fn level_colour(level: u32) -> vec3<f32> {
    var colours = array<vec3<f32>, 13>(
        vec3<f32>(246.0, 242.0, 232.0), vec3<f32>(86.0, 180.0, 233.0), vec3<f32>(0.0, 114.0, 178.0), vec3<f32>(0.0, 158.0, 115.0),
        vec3<f32>(155.0, 215.0, 112.0), vec3<f32>(240.0, 228.0, 66.0), vec3<f32>(230.0, 159.0, 0.0), vec3<f32>(213.0, 94.0, 0.0),
        vec3<f32>(227.0, 155.0, 191.0), vec3<f32>(162.0, 74.0, 140.0), vec3<f32>(106.0, 61.0, 154.0), vec3<f32>(138.0, 106.0, 74.0),
        vec3<f32>(69.0, 75.0, 84.0),
    );
    return to_linear(colours[min(level, 12u)] / 255.0);
}

fn vertex(slot: u32, position: vec3<f32>, key: u32, place: Place) -> Varying {
    var out: Varying;
    out.world = relative(place, position);
    out.position = to_clip(out.world);
    out.corner = vec3<f32>(1.0);
    out.hand_and_area = vec2<f32>(place.hand, 0.0);
    out.colour = vec4<f32>(0.5, 0.5, 0.5, 1.0);
    out.share = 1.0;
    if (pane.flags & FADE) != 0u || PAINT == INSTANCES {
        out.share = textureLoad(instance_colours, at(slot), 0).a;
    }
    if PAINT == MATERIAL {
        let part = textureLoad(parts, at(key >> 8u), 0);
        // Twice the level of detail is added to it.
        let alpha = part.a - 2.0 * floor(part.a * 0.5);
        out.colour = vec4<f32>(part.rgb, min(alpha, place.opacity));
    } else if PAINT == LEVELS {
        out.colour = vec4<f32>(level_colour(u32(textureLoad(parts, at(key >> 8u), 0).a * 0.5)), 1.0);
    } else if PAINT == CLUSTERS {
        out.colour = vec4<f32>(cluster_colour((key & 255u) + (key >> 8u) * 7u), 1.0);
    } else if PAINT == INSTANCES {
        out.colour = textureLoad(instance_colours, at(slot), 0);
        if out.colour.a == 0.0 {
            out.position = NOWHERE;
        }
    }
    return out;
}

@vertex
fn vs_indexed(@location(0) position: vec3<f32>, @location(1) key: u32, @location(2) slot: u32) -> Varying {
    return vertex(slot, position, key, place_of(slot));
}

fn corner_vertex(corner: u32) -> vec4<u32> {
    return textureLoad(vertices, at(textureLoad(indices, at(corner), 0).x), 0);
}

// The pixels of a triangle; very many where a corner is not in front of the eye.
fn area_of(a: vec4<f32>, b: vec4<f32>, c: vec4<f32>) -> f32 {
    if min(a.w, min(b.w, c.w)) <= 0.0 {
        return 1e9;
    }
    let p = a.xy / a.w;
    let u = (b.xy / b.w - p) * pane.size * 0.5;
    let v = (c.xy / c.w - p) * pane.size * 0.5;
    return abs(u.x * v.y - u.y * v.x) * 0.5;
}

// Takes its corners from textures, so that a triangle knows all three of its own.
@vertex
fn vs_pulled(@builtin(vertex_index) corner: u32, @location(2) slot: u32) -> Varying {
    let place = place_of(slot);
    let own = corner_vertex(corner);
    var out = vertex(slot, bitcast<vec3<f32>>(own.xyz), own.w, place);
    let k = corner % 3u;
    out.corner = vec3<f32>(vec3<u32>(k) == vec3<u32>(0u, 1u, 2u));
    if PAINT == TRIANGLE_SIZE {
        let first = corner - k;
        let a = to_clip(relative(place, bitcast<vec3<f32>>(corner_vertex(first).xyz)));
        let b = to_clip(relative(place, bitcast<vec3<f32>>(corner_vertex(first + 1u).xyz)));
        let c = to_clip(relative(place, bitcast<vec3<f32>>(corner_vertex(first + 2u).xyz)));
        out.hand_and_area.y = area_of(a, b, c);
    }
    return out;
}

struct Line {
    @builtin(position) position: vec4<f32>,
    @location(0) colour: vec4<f32>,
}

// How long normals are, in pixels, at the most: those of small triangles are as long as these are large.
const NORMAL_PX = 16.0;

// What each layer adds to a pixel: from dark red over orange to white.
const OVERDRAW_STEP = vec3<f32>(0.06, 0.018, 0.005);

fn normal_line(start: vec3<f32>, normal: vec3<f32>, reach: f32, place: Place, tip: bool, colour: vec3<f32>) -> Line {
    let turn = place.hand * select(1.0, -1.0, (pane.flags & CLOCKWISE) != 0u);
    let from_clip = to_clip(start);
    let size = max(length(normal), 1e-30);
    let most = NORMAL_PX * pane.eye_high.w * max(from_clip.w, 0.0);
    let along = normal * (turn / size * min(most, reach));
    let end = start + select(vec3<f32>(0.0), along, tip);
    return Line(to_clip(end), vec4<f32>(colour, 1.0));
}

@vertex
fn vs_face_normal(@builtin(vertex_index) n: u32, @location(2) slot: u32) -> Line {
    let place = place_of(slot);
    let first = n / 2u * 3u;
    let a = relative(place, bitcast<vec3<f32>>(corner_vertex(first).xyz));
    let b = relative(place, bitcast<vec3<f32>>(corner_vertex(first + 1u).xyz));
    let c = relative(place, bitcast<vec3<f32>>(corner_vertex(first + 2u).xyz));
    let normal = cross(b - a, c - a);
    return normal_line((a + b + c) / 3.0, normal, sqrt(length(normal)), place, n % 2u == 1u, vec3<f32>(0.95, 0.75, 0.05));
}

@vertex
fn vs_vertex_normal(@builtin(vertex_index) n: u32, @location(2) slot: u32) -> Line {
    let place = place_of(slot);
    let start = relative(place, bitcast<vec3<f32>>(textureLoad(vertices, at(n / 2u), 0).xyz));
    let own = textureLoad(normals, at(n / 2u), 0);
    // The cofactors of the linear part: its columns' cross products take normals to normals.
    let m = transpose(place.rows);
    let normal = cross(m[1], m[2]) * own.x + cross(m[2], m[0]) * own.y + cross(m[0], m[1]) * own.z;
    // How much the instance scales, all directions together.
    let scale = pow(abs(dot(m[0], cross(m[1], m[2]))), 1.0 / 3.0);
    return normal_line(start, normal, own.w * scale, place, n % 2u == 1u, vec3<f32>(0.05, 0.6, 0.45));
}

fn to_linear(c: vec3<f32>) -> vec3<f32> {
    return select(pow((c + 0.055) / 1.055, vec3<f32>(2.4)), c / 12.92, c <= vec3<f32>(0.04045));
}

@vertex
fn vs_line(@location(0) position: vec3<f32>, @location(1) colour: vec4<f32>) -> Line {
    let p = (position - pane.eye_high.xyz) - pane.eye_low.xyz;
    return Line(to_clip(p), vec4<f32>(to_linear(colour.rgb), colour.a));
}

@fragment
fn fs_line(in: Line) -> @location(0) vec4<f32> {
    return in.colour;
}

// Covers the pane, at the far end.
@vertex
fn vs_clear(@builtin(vertex_index) n: u32) -> Line {
    let p = vec2<f32>(f32(n & 1u) * 4.0 - 1.0, f32(n >> 1u) * 4.0 - 1.0);
    return Line(vec4<f32>(p, pane.far, 1.0), pane.background);
}

fn towards_viewer(world: vec3<f32>) -> vec3<f32> {
    if pane.sight.w != 0.0 {
        return pane.sight.xyz;
    }
    return -world / max(length(world), 1e-30);
}

// A lamp at the eye and a little light from above; the normal is that of the flat triangle.
fn lit(colour: vec3<f32>, world: vec3<f32>) -> vec3<f32> {
    let across = cross(dpdx(world), dpdy(world));
    if !(length(across) > 0.0) {
        return colour * 0.5;
    }
    return lit_by(colour, world, across);
}

// The same by a normal of any length and of either side.
fn lit_by(colour: vec3<f32>, world: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let n = normal / max(length(normal), 1e-30);
    let facing = dot(n, towards_viewer(world));
    let up = n.y * sign(facing);
    return colour * (0.22 + 0.68 * abs(facing) + 0.10 * up);
}

// Distance as a shade.
fn nearness(world: vec3<f32>) -> vec3<f32> {
    var distance = length(world);
    if pane.sight.w != 0.0 {
        distance = max(-dot(world, pane.sight.xyz), 0.0);
    }
    return to_linear(vec3<f32>(pane.eye_low.w / (pane.eye_low.w + distance)));
}

// Inferno, as the pictures of the library have it, from 0 to 1.
fn heat(share: f32) -> vec3<f32> {
    var points = array<vec3<f32>, 8>(
        vec3<f32>(0.0, 0.0, 4.0), vec3<f32>(40.0, 11.0, 84.0), vec3<f32>(101.0, 21.0, 110.0), vec3<f32>(159.0, 42.0, 99.0),
        vec3<f32>(212.0, 72.0, 66.0), vec3<f32>(245.0, 125.0, 21.0), vec3<f32>(250.0, 193.0, 39.0), vec3<f32>(252.0, 255.0, 164.0),
    );
    let t = clamp(share, 0.0, 1.0) * 7.0;
    let i = min(u32(t), 6u);
    return to_linear(mix(points[i], points[i + 1u], t - f32(i)) / 255.0);
}

// The colour of front faces.
const FRONT = vec3<f32>(0.093, 0.456, 0.815);

fn paint(in: Varying, counter_clockwise: bool) -> vec4<f32> {
    switch PAINT {
        case 1u: {
            let flipped = (pane.flags & FLIPPED) != 0u;
            let front = (counter_clockwise != flipped) == (in.hand_and_area.x > 0.0);
            let colour = select(vec3<f32>(0.665, 0.112, 0.0), FRONT, front);
            return vec4<f32>(lit(colour, in.world), 1.0);
        }
        case 4u: {
            return vec4<f32>(OVERDRAW_STEP, 0.0);
        }
        case 5u: {
            // 1 pixel and less is hottest, 4096 and more coldest.
            return vec4<f32>(heat(1.0 - log2(max(in.hand_and_area.y, 1.0)) / 12.0), 1.0);
        }
        case 6u: {
            return vec4<f32>(nearness(in.world), 1.0);
        }
        default: {
            return vec4<f32>(lit(in.colour.rgb, in.world), in.colour.a);
        }
    }
}

@fragment
fn fs_fill(in: Varying, @builtin(front_facing) counter_clockwise: bool) -> @location(0) vec4<f32> {
    return paint(in, counter_clockwise);
}

// A 4×4 ordered dither: which share of alpha covers a pixel, in any order of drawing.
fn threshold(p: vec2<u32>) -> f32 {
    let x = p.x ^ p.y;
    let n = ((x & 1u) << 3u) | ((p.y & 1u) << 2u) | (x & 2u) | ((p.y & 2u) >> 1u);
    return (f32(n) + 0.5) / 16.0;
}

// Whether a pixel is not of the share by which an instance is drawn; of what goes it is those that are.
fn is_left_out(share: f32, pixel: vec2<f32>) -> bool {
    return (share < threshold(vec2<u32>(pixel))) != ((pane.flags & GOING) != 0u);
}

// With edges, or with holes: apart from the others, since discarding costs the early depth test.
@fragment
fn fs_cut(in: Varying, @builtin(front_facing) counter_clockwise: bool) -> @location(0) vec4<f32> {
    let painted = paint(in, counter_clockwise);
    // Pixels to the nearest edge, and across the triangle.
    let wide = max(fwidth(in.corner), vec3<f32>(1e-12));
    let pixels = in.corner / wide;
    let across = 1.0 / max(wide.x, max(wide.y, wide.z));
    let edge = clamp(1.5 - min(pixels.x, min(pixels.y, pixels.z)), 0.0, 1.0);
    let wire = (pane.flags & WIRE) != 0u;
    if is_left_out(in.share, in.position.xy) {
        discard;
    }
    if (pane.flags & FILL) == 0u {
        if !wire || edge < 0.5 {
            discard;
        }
        return vec4<f32>(mix(painted.rgb, vec3<f32>(1.0), 0.35), 1.0);
    }
    // Where triangles are no larger than their edges, these would be all there is to see.
    let amount = select(0.0, edge * (0.15 + 0.6 * smoothstep(2.0, 12.0, across)), wire);
    return vec4<f32>(mix(painted.rgb, vec3<f32>(0.01, 0.012, 0.02), amount), painted.a);
}
