// Where instances are, seen from the eye.

struct Eye {
    // Reversed clip space from world space relative to the eye.
    clip: mat4x4<f32>,
    // The eye as the sum of two, so that far from the origin nothing jitters.
    high: vec4<f32>,
    low: vec4<f32>,
}

// Rows of the linear part, each with the high half of the translation; then its low half.
struct Place { rows: array<vec4<f32>, 3>, low: vec4<f32> }

@group(0) @binding(0) var<uniform> eye: Eye;
@group(0) @binding(1) var<storage, read> places: array<Place>;

// A point of an instance, relative to the eye.
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

