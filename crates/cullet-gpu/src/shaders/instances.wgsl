// Which instances no plane rejects and are not small. Integers only: every device gives the same answer.

struct View { blocks: u32, layers: u32, padding: vec2<u32> }

@group(0) @binding(0) var<storage, read> boxes: array<GridBox>;
@group(0) @binding(1) var<storage, read> in_use: array<InUse>;
@group(0) @binding(2) var<storage, read> planes: array<vec4<i32>>;
// A bit a slot, eight words a block. Those of blocks that are not in use were cleared.
@group(0) @binding(3) var<storage, read_write> bits: array<u32>;
@group(0) @binding(4) var<uniform> view: View;

fn sum(v: vec3<i32>) -> i32 { return v.x + v.y + v.z; }

// What a plane has at the lowest corner of a box.
fn lowest(plane: vec4<i32>, low: vec3<i32>, high: vec3<i32>) -> i32 {
    return plane.w + sum(plane.xyz * select(high, low, plane.xyz >= vec3<i32>(0)));
}

fn rejects(plane: vec4<i32>, low: vec3<i32>, high: vec3<i32>) -> bool {
    return lowest(plane, low, high) > 0;
}

// By four rows: the threshold times w, the near plane, and how wide each unit of an extent looks across and up.
fn is_small(rows: u32, low: vec3<i32>, high: vec3<i32>) -> bool {
    if !rejects(planes[rows + 1u], low, high) { return false; }
    let across = planes[rows + 2u];
    let up = planes[rows + 3u];
    let least = lowest(planes[rows], low, high) >> u32(across.w);
    let extent = high - low;
    return sum(across.xyz * extent) < least && sum(up.xyz * extent) < least;
}

fn is_visible(b: GridBox, own: InUse) -> bool {
    if (b.layers & view.layers) == 0u { return false; }
    if is_always(b) { return true; }
    let low = low_corner(b);
    let high = high_corner(b);
    for (var p = own.first_plane; p < own.first_plane + own.plane_count; p++) {
        if rejects(planes[p], low, high) { return false; }
    }
    return own.size_rows == 0u || !is_small(own.first_plane + own.plane_count, low, high);
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
