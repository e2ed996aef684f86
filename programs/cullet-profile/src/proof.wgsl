// Vertices and fragments of as much work as wanted.

struct Loops { vertex: u32, fragment: u32, covers: u32, zero: f32 }

@group(0) @binding(0) var<uniform> loops: Loops;

struct Varying {
    @builtin(position) position: vec4<f32>,
    @location(0) shade: f32,
}

@vertex
fn vs(@builtin(vertex_index) i: u32) -> Varying {
    let corner = vec2<f32>(f32((i % 3u) & 1u) * 4.0 - 1.0, f32((i % 3u) >> 1u) * 4.0 - 1.0);
    var at = corner;
    if loops.covers == 0u {
        // Somewhere, hardly larger than a point.
        let h = (i / 3u) * 0x9e3779b9u;
        let middle = vec2<f32>(f32(h & 0xffffu), f32(h >> 16u)) / 32768.0 - 1.0;
        at = middle + corner * 1e-5;
    }
    var shade = 0.0;
    for (var n = 0u; n < loops.vertex; n++) { shade = shade * loops.zero + sin(at.x + shade); }
    return Varying(vec4<f32>(at + shade * loops.zero, 0.5, 1.0), shade);
}

@fragment
fn fs(own: Varying) -> @location(0) vec4<f32> {
    var shade = own.shade;
    for (var n = 0u; n < loops.fragment; n++) { shade = shade * loops.zero + sin(own.position.x + shade); }
    return vec4<f32>(shade, shade, shade, 0.5);
}
