// Which clusters no plane rejects and whose triangles do not all face away. Integers only: every device gives the same answer, and
// what is rounded is added to the side of "kept".

struct Unit { cone: u32, slot: u32 }
struct Eye { at: vec3<i32>, shift: u32 }

@group(1) @binding(0) var<storage, read> units: array<Unit>;
// Six words a cone: its apex and three vectors, 16 bits a number.
@group(1) @binding(1) var<storage, read> cones: array<u32>;
@group(1) @binding(2) var<storage, read> eyes: array<Eye>;
// Where the cones of the side begin that the view culls.
@group(1) @binding(3) var<uniform> first_cone: u32;

// What the way to the eye is off by at the most, in each coordinate.
const OFF = 2;

fn largest(v: vec3<i32>) -> i32 { return max(v.x, max(v.y, v.z)); }

// Three numbers from a half of a word on.
fn lower_three(at: u32) -> vec3<i32> {
    return vec3<i32>(lower_half(cones[at]), upper_half(cones[at]), lower_half(cones[at + 1u]));
}
fn upper_three(at: u32) -> vec3<i32> {
    return vec3<i32>(upper_half(cones[at]), lower_half(cones[at + 1u]), upper_half(cones[at + 1u]));
}

// How much a product with a vector is off by at the most, but for what is around.
fn off(n: vec3<i32>) -> i32 { return OFF * sum(abs(n)); }

fn square(v: i32) -> u32 { return u32(v) * u32(v); }

fn is_behind(cone: u32, eye: Eye) -> bool {
    var way = eye.at - (lower_three(cone * 6u) >> vec3<u32>(eye.shift));
    way = way >> vec3<u32>(u32(max(firstLeadingBit(largest(abs(way))) - 13, 0)));
    let around = sum(abs(way)) / 2 + 2 * OFF;
    let axis = upper_three(cone * 6u + 1u);
    let behind = -sum(axis * way) - off(axis) - around;
    if behind <= 0 { return false; }
    let s = lower_three(cone * 6u + 3u);
    let t = upper_three(cone * 6u + 4u);
    let along_s = abs(sum(s * way)) + off(s) + around;
    let along_t = abs(sum(t * way)) + off(t) + around;
    let shift = u32(max(firstLeadingBit(max(behind, max(along_s, along_t))) - 14, 0));
    let across = square((along_s >> shift) + 1) + square((along_t >> shift) + 1);
    return square(behind >> shift) > across;
}

@compute @workgroup_size(256)
fn face(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let number = group.x + group.y * ROW;
    // The same for the whole group.
    if number >= view.blocks { return; }
    let block = in_use[number];
    let at = block.block * 256u + lane;
    if is_visible(boxes[at], block) {
        let own = units[at];
        if !is_behind(own.cone + first_cone, eyes[own.slot]) {
            atomicOr(&own_bits[lane / 32u], 1u << (lane % 32u));
        }
    }
    workgroupBarrier();
    if lane < 8u { bits[block.block * 8u + lane] = atomicLoad(&own_bits[lane]); }
}
