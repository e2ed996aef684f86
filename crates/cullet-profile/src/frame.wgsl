// A frame of a scene: flat shading by a lamp at the eye. Vertices are shaded as often as wanted.

struct Eye {
    clip: mat4x4<f32>,
    high: vec4<f32>,
    low: vec4<f32>,
}

struct Place { rows: array<vec4<f32>, 3>, low: vec4<f32> }
// The second is always 0, which no compiler knows.
struct Loops { vertex: u32, zero: f32, padding: vec2<u32> }

@group(0) @binding(0) var<uniform> eye: Eye;
@group(0) @binding(1) var<storage, read> places: array<Place>;
@group(0) @binding(2) var<uniform> loops: Loops;

struct Varying {
    @builtin(position) position: vec4<f32>,
    @location(0) world: vec3<f32>,
}

fn placed(position: vec3<f32>, slot: u32) -> vec3<f32> {
    let own = places[slot];
    let high = vec3<f32>(own.rows[0].w, own.rows[1].w, own.rows[2].w);
    let offset = (high - eye.high.xyz) + (own.low.xyz - eye.low.xyz);
    let turned = vec3<f32>(
        dot(own.rows[0].xyz, position),
        dot(own.rows[1].xyz, position),
        dot(own.rows[2].xyz, position),
    );
    return turned + offset;
}

@vertex
fn vs(@location(0) position: vec3<f32>, @location(1) slot: u32) -> Varying {
    var out: Varying;
    for (var n = 0u; n < loops.vertex; n++) {
        // The same each time.
        out.world = placed(position + out.world * loops.zero, slot);
        out.position = eye.clip * vec4<f32>(out.world + out.position.xyz * loops.zero, 1.0);
    }
    return out;
}

@fragment
fn fs(own: Varying) -> @location(0) vec4<f32> {
    let across = cross(dpdx(own.world), dpdy(own.world));
    let facing = abs(dot(normalize(across), normalize(own.world)));
    return vec4<f32>(vec3<f32>(0.2 + 0.8 * facing), 1.0);
}
