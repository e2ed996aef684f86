// By the class of the normal: the bit of a triangle in the 256 bytes of the classes that face away.

// Two bytes a triangle: which byte, and its bit.
@group(1) @binding(0) var<storage, read> classes: array<u32>;
@group(1) @binding(1) var<storage, read> masks: array<u32>;

fn is_culled(triangle: u32, mask: u32) -> bool {
    let own = classes[triangle / 2u] >> (16u * (triangle % 2u));
    let word = masks[mask * 64u + (own & 255u) / 4u];
    return ((word >> (8u * (own & 3u))) & (own >> 8u) & 255u) != 0u;
}
