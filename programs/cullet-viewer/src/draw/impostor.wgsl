// Impostors: the far sides of a box, and in each of its pixels what the ray meets first, as cullet-draw finds it. Follows
// scene.wgsl.

@group(1) @binding(3) var impostor_texels: texture_2d<u32>;
@group(1) @binding(4) var impostors: texture_2d<f32>;

// As in cullet-draw: coverage that counts, places along a ray for each texel of a frame's side, halvings of the step that
// comes upon the mesh, texels of depth between surfaces and in the shadow of all.
const COVERED = 0.3;
const STEPS = 3u;
const HALVINGS = 6;
const STEEP = 2.0;
const DEEP = 2.0;

// Where a frame sees past a place.
const PAST = 1e30;

struct BoxVarying {
    @builtin(position) position: vec4<f32>,
    // From the middle of the box, in the space of the mesh.
    @location(0) place: vec3<f32>,
    // The eye likewise, and 1; or where parallel lines of sight lead, and 0.
    @location(1) @interpolate(flat) eye: vec4<f32>,
    // The slot, and the impostor's first entry.
    @location(2) @interpolate(flat) which: vec2<u32>,
}

fn entry(n: u32) -> vec4<f32> {
    return textureLoad(impostors, at(n), 0);
}

// The cofactors of the linear part as rows: they take normals to normals.
fn cofactors(rows: mat3x3<f32>) -> mat3x3<f32> {
    return mat3x3<f32>(cross(rows[1], rows[2]), cross(rows[2], rows[0]), cross(rows[0], rows[1]));
}

@vertex
fn vs_impostor(@location(0) position: vec3<f32>, @location(1) key: u32, @location(2) slot: u32) -> BoxVarying {
    let place = place_of(slot);
    let middle = entry(key).xyz;
    var out: BoxVarying;
    out.position = to_clip(relative(place, position));
    out.place = position - middle;
    out.which = vec2<u32>(slot, key);
    // Made of sizes around 1, so that no determinant is too small for its number.
    let most = max(abs(place.rows[0]), max(abs(place.rows[1]), abs(place.rows[2])));
    let scale = max(most.x, max(most.y, most.z));
    let rows = place.rows * (1.0 / scale);
    let across = cofactors(rows);
    let volume = dot(rows[0], across[0]) * scale;
    if pane.sight.w != 0.0 {
        out.eye = vec4<f32>(across * -pane.sight.xyz / volume, 0.0);
    } else {
        out.eye = vec4<f32>(across * -place.offset / volume - middle, 1.0);
    }
    var is_hidden = false;
    if PAINT == INSTANCES {
        is_hidden = textureLoad(instance_colours, at(slot), 0).a == 0.0;
    }
    // What an instance flattens has no inside.
    if is_hidden || !(abs(volume) > 0.0) {
        out.position = NOWHERE;
    }
    return out;
}

// A ray in a frame: a place for each distance along it.
struct Sight {
    start: vec3<f32>,
    along: vec3<f32>,
    first: u32,
    weight: f32,
    // A texel's difference of depth, and by how much a place may lie before the surface.
    texel: f32,
    tolerance: f32,
}

// Four texels, how much each weighs, and their shapes' words.
struct Around {
    numbers: vec4<u32>,
    weights: vec4<f32>,
    coverage: vec4<f32>,
    depth: vec4<f32>,
    is_beside: bool,
}

fn around(line: Sight, across: u32, p: vec3<f32>) -> Around {
    var out: Around;
    out.is_beside = max(abs(p.x), abs(p.y)) > 1.0001;
    let last = f32(across) - 1.0;
    let spot = clamp((vec2<f32>(p.x, -p.y) + 1.0) * 0.5 * f32(across) - 0.5, vec2<f32>(0.0), vec2<f32>(last));
    let low = vec2<u32>(spot);
    let high = min(low + 1u, vec2<u32>(across - 1u));
    let f = spot - vec2<f32>(low);
    let rows = line.first + vec2<u32>(low.y, high.y) * across;
    out.numbers = vec4<u32>(rows.x + low.x, rows.x + high.x, rows.y + low.x, rows.y + high.x);
    out.weights = vec4<f32>((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y);
    let words = vec4<u32>(word(out.numbers.x), word(out.numbers.y), word(out.numbers.z), word(out.numbers.w));
    out.coverage = vec4<f32>((words >> vec4<u32>(12u)) & vec4<u32>(15u)) / 15.0;
    out.depth = vec4<f32>(words & vec4<u32>(255u)) / 127.5 - 1.0;
    return out;
}

fn word(n: u32) -> u32 {
    return textureLoad(impostor_texels, at(n), 0).x;
}

// How many texels a place is behind what a frame saw.
fn behind(line: Sight, across: u32, t: f32) -> f32 {
    let p = line.start + line.along * t;
    let four = around(line, across, p);
    if four.is_beside || dot(four.coverage, four.weights) < COVERED {
        return PAST;
    }
    let w = four.weights;
    let d = four.depth;
    var depth = dot(d, w);
    let low = min(min(d.x, d.y), min(d.z, d.w));
    let high = max(max(d.x, d.y), max(d.z, d.w));
    if high - low > STEEP * line.texel {
        // Between two surfaces there is none: that of the texel that weighs most.
        depth = d.x;
        var most = w.x;
        if w.y > most { depth = d.y; most = w.y; }
        if w.z > most { depth = d.z; most = w.z; }
        if w.w > most { depth = d.w; }
    }
    let gap = depth - p.z;
    return select(gap / line.texel, PAST, gap < -line.tolerance);
}

// The place of a direction on the octahedral square: the engine's own.
fn square(d: vec3<f32>) -> vec2<f32> {
    let p = d.xz / (abs(d.x) + abs(d.y) + abs(d.z));
    let folded = (1.0 - abs(p.yx)) * select(vec2<f32>(-1.0), vec2<f32>(1.0), p >= vec2<f32>(0.0));
    return select(p, folded, d.y < 0.0);
}

fn octahedral(p: vec2<f32>) -> vec3<f32> {
    let y = 1.0 - abs(p.x) - abs(p.y);
    let folded = (1.0 - abs(p.yx)) * select(vec2<f32>(-1.0), vec2<f32>(1.0), p >= vec2<f32>(0.0));
    let xz = select(p, folded, y < 0.0);
    return normalize(vec3<f32>(xz.x, y, xz.y));
}

struct Drawn {
    @location(0) colour: vec4<f32>,
    @builtin(frag_depth) depth: f32,
}

@fragment
fn fs_impostor(in: BoxVarying) -> Drawn {
    let place = place_of(in.which.x);
    let head = in.which.y;
    let middle = entry(head);
    let half = entry(head + 1u);
    let more = entry(head + 2u);
    let grid = u32(middle.w);
    let texels = u32(half.w);
    let first = u32(more.x) + (u32(more.y) << 16u);

    // Distances are counted from the box's far side, where numbers are small, however far the eye is.
    let to = select(in.eye.xyz, in.place - in.eye.xyz, in.eye.w != 0.0);
    let reach = length(to);
    let direction = to / reach;
    let steep = select(direction, vec3<f32>(1e-12), abs(direction) < vec3<f32>(1e-12));
    let a = (-half.xyz - in.place) / steep;
    let b = (half.xyz - in.place) / steep;
    let enter = min(a, b);
    let leave = max(a, b);
    var near = max(enter.x, max(enter.y, enter.z));
    if in.eye.w != 0.0 {
        near = max(near, -reach);
    }
    let far = min(leave.x, min(leave.y, leave.z));
    if !(near <= far) {
        discard;
    }

    // The three frames around the direction towards the viewer. The diagonal runs along the folds of the octahedron.
    let last = grid - 1u;
    let uv = square(-direction);
    let spot = (uv + 1.0) * 0.5 * f32(last);
    let cell = min(vec2<u32>(spot), vec2<u32>(last - 1u));
    let f = spot - vec2<f32>(cell);
    let corner = cell.y * grid + cell.x;
    var numbers: vec3<u32>;
    var weights: vec3<f32>;
    if uv.x * uv.y > 0.0 {
        let is_low = f.x + f.y < 1.0;
        numbers = vec3<u32>(select(corner + grid + 1u, corner, is_low), corner + 1u, corner + grid);
        weights = select(vec3<f32>(f.x + f.y - 1.0, 1.0 - f.y, 1.0 - f.x), vec3<f32>(1.0 - f.x - f.y, f.x, f.y), is_low);
    } else {
        let is_right = f.x > f.y;
        numbers = vec3<u32>(corner, select(corner + grid, corner + 1u, is_right), corner + grid + 1u);
        weights = select(vec3<f32>(1.0 - f.y, f.y - f.x, f.x), vec3<f32>(1.0 - f.x, f.x - f.y, f.y), is_right);
    }
    var lines: array<Sight, 3>;
    for (var i = 0; i < 3; i++) {
        let at_frame = head + 4u + numbers[i] * 3u;
        let x = entry(at_frame);
        let y = entry(at_frame + 1u);
        let z = entry(at_frame + 2u);
        let m = mat3x3<f32>(x.xyz, y.xyz, z.xyz);
        lines[i] = Sight(in.place * m, direction * m, first + numbers[i] * texels * texels, weights[i], x.w, y.w);
    }

    // The first place that none of them sees past; then that between it and the one before.
    let steps = STEPS * texels;
    var before = near;
    var hit = far;
    var is_hit = false;
    for (var i = 0u; i <= steps; i++) {
        hit = near + (far - near) * f32(i) / f32(steps);
        if nearest(lines[0], lines[1], lines[2], texels, hit) <= DEEP {
            is_hit = true;
            break;
        }
        before = hit;
    }
    if !is_hit {
        discard;
    }
    for (var i = 0; i < HALVINGS; i++) {
        let between = (before + hit) * 0.5;
        if nearest(lines[0], lines[1], lines[2], texels, between) <= DEEP {
            hit = between;
        } else {
            before = between;
        }
    }
    var best = 0.0;
    var best_texel = 0u;
    for (var i = 0; i < 3; i++) {
        let p = lines[i].start + lines[i].along * hit;
        let four = around(lines[i], texels, p);
        let off = (p.z - four.depth) / lines[i].texel;
        let scores = (lines[i].weight + 0.02) * (four.weights + 1e-3) * four.coverage / (0.1 + off * off);
        for (var k = 0; k < 4; k++) {
            if !four.is_beside && scores[k] > best {
                best = scores[k];
                best_texel = four.numbers[k];
            }
        }
    }
    if best == 0.0 {
        discard;
    }

    let found = word(best_texel);
    let world = relative(place, in.place + direction * hit + middle.xyz);
    let clip = to_clip(world);
    var out: Drawn;
    out.depth = clip.z / clip.w;
    let own = vec2<f32>(vec2<u32>(found >> 24u, (found >> 16u) & 255u)) / 127.5 - 1.0;
    let normal = octahedral(own) * cofactors(place.rows);
    out.colour = impostor_colour(in.which, (found >> 8u) & 15u, more.zw, world, normal, place.opacity);
    var share = 1.0;
    if (pane.flags & FADE) != 0u || PAINT == INSTANCES {
        share = textureLoad(instance_colours, at(in.which.x), 0).a;
    }
    if out.depth < 0.0 || out.depth > 1.0 || is_left_out(share, in.position.xy) {
        discard;
    }
    return out;
}

// How far behind the surface a place is for the frame that it is least behind for.
fn nearest(a: Sight, b: Sight, c: Sight, texels: u32, t: f32) -> f32 {
    let x = behind(a, texels, t);
    if x == PAST {
        return PAST;
    }
    let y = behind(b, texels, t);
    if y == PAST {
        return PAST;
    }
    let z = behind(c, texels, t);
    if z == PAST {
        return PAST;
    }
    return min(x, min(y, z));
}

fn impostor_colour(which: vec2<u32>, part: u32, parts_of: vec2<f32>, world: vec3<f32>, normal: vec3<f32>, opacity: f32) -> vec4<f32> {
    switch PAINT {
        case 1u: {
            return vec4<f32>(lit_by(FRONT, world, normal), 1.0);
        }
        case 2u: {
            return vec4<f32>(lit_by(cluster_colour(which.y + part), world, normal), 1.0);
        }
        case 3u: {
            return vec4<f32>(lit_by(textureLoad(instance_colours, at(which.x), 0).rgb, world, normal), 1.0);
        }
        case 4u: {
            return vec4<f32>(OVERDRAW_STEP, 0.0);
        }
        case 5u: {
            // It has no triangles.
            return vec4<f32>(lit_by(vec3<f32>(0.5), world, normal), 1.0);
        }
        case 6u: {
            return vec4<f32>(nearness(world), 1.0);
        }
        case 7u: {
            return vec4<f32>(lit_by(level_colour(u32(entry(which.y + 3u).x)), world, normal), 1.0);
        }
        default: {
            let colour = textureLoad(parts, at(u32(parts_of.x) + part * u32(parts_of.y)), 0).rgb;
            return vec4<f32>(lit_by(colour, world, normal), opacity);
        }
    }
}
