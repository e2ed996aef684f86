// By the plane: the product with the eye, beyond what quantising and a renderer's rounding may hide. Integers only.

struct Eye { plane: vec4<i32>, bound: i32, doubt: i32, smallest: i32, padding: i32 }

// Four numbers with 128 added to each; all 0 for a triangle without area.
@group(1) @binding(0) var<storage, read> planes: array<u32>;
// The code of a size in a byte.
@group(1) @binding(1) var<storage, read> sizes: array<u32>;
@group(1) @binding(2) var<uniform> eye: Eye;

fn is_culled(triangle: u32, mask: u32) -> bool {
    let plane = planes[triangle];
    if plane == 0u { return true; }
    let size = (sizes[triangle / 4u] >> (8u * (triangle % 4u))) & 255u;
    if i32(size) > eye.smallest { return false; }
    let bytes = (vec4<u32>(plane) >> vec4<u32>(0u, 8u, 16u, 24u)) & vec4<u32>(255u);
    let products = (vec4<i32>(bytes) - 128) * eye.plane;
    let doubt = ((eye.doubt * i32(4u + (size & 3u))) << (size >> 2u)) >> 2u;
    return products.x + products.y + products.z + products.w + eye.bound + doubt + 1 < 0;
}
