// Which instances no plane rejects. Integers only: every device gives the same answer.

struct View { blocks: u32, layers: u32, padding: vec2<u32> }

@group(0) @binding(0) var<storage, read> boxes: array<GridBox>;
@group(0) @binding(1) var<storage, read> in_use: array<InUse>;
@group(0) @binding(2) var<storage, read> planes: array<vec4<i32>>;
// A bit a slot, eight words a block. Those of blocks that are not in use were cleared.
@group(0) @binding(3) var<storage, read_write> bits: array<u32>;
@group(0) @binding(4) var<uniform> view: View;

fn rejects(plane: vec4<i32>, low: vec3<i32>, high: vec3<i32>) -> bool {
    let lowest = plane.xyz * select(high, low, plane.xyz >= vec3<i32>(0));
    return plane.w + lowest.x + lowest.y + lowest.z > 0;
}

fn is_visible(b: GridBox, own: InUse) -> bool {
    if (b.layers & view.layers) == 0u { return false; }
    if is_always(b) { return true; }
    let low = low_corner(b);
    let high = high_corner(b);
    for (var p = own.first_plane; p < own.first_plane + own.plane_count; p++) {
        if rejects(planes[p], low, high) { return false; }
    }
    return true;
}

var<workgroup> own_bits: array<atomic<u32>, 8>;

@compute @workgroup_size(256)
fn test(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let number = group.x + group.y * ROW;
    // The same for the whole group.
    if number >= view.blocks { return; }
    let own = in_use[number];
    if is_visible(boxes[own.block * 256u + lane], own) {
        atomicOr(&own_bits[lane / 32u], 1u << (lane % 32u));
    }
    workgroupBarrier();
    if lane < 8u { bits[own.block * 8u + lane] = atomicLoad(&own_bits[lane]); }
}
