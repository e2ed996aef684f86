// A frame of a scene: flat shading by a lamp at the eye.

struct Varying {
    @builtin(position) position: vec4<f32>,
    @location(0) world: vec3<f32>,
}

@vertex
fn vs(@location(0) position: vec3<f32>, @location(1) slot: u32) -> Varying {
    let world = placed(position, slot);
    return Varying(eye.clip * vec4<f32>(world, 1.0), world);
}

@fragment
fn shade(own: Varying) -> @location(0) vec4<f32> {
    let across = cross(dpdx(own.world), dpdy(own.world));
    let facing = abs(dot(normalize(across), normalize(own.world)));
    return vec4<f32>(vec3<f32>(0.2 + 0.8 * facing), 1.0);
}

// How many samples are covered, hidden ones too: a counter for each row of 256, so that not all wait for one.
@group(1) @binding(0) var<storage, read_write> counts: array<atomic<u32>, 256>;

@fragment
fn count(own: Varying) {
    atomicAdd(&counts[u32(own.position.y) & 255u], 1u);
}
