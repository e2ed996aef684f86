// The number of the instance at each pixel, and its depth.

struct Varying {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) slot: u32,
}

@vertex
fn vs(@location(0) position: vec3<f32>, @location(1) slot: u32) -> Varying {
    return Varying(eye.clip * vec4<f32>(placed(position, slot), 1.0), slot);
}

@fragment
fn fs(own: Varying) -> @location(0) u32 {
    return own.slot + 1u;
}
