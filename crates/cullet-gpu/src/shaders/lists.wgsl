// From bits of slots to the lists that draws take: of each bucket the slots in it whose bit is set, in order, from the bucket's
// first lane on. No counter that several invocations add to: the order is the same each time, and on every device.

struct Which { lanes: u32, groups: u32, draws: u32, mode: u32 }

// First lane and end of the bucket that each draw is of.
@group(0) @binding(3) var<storage, read> draws: array<vec2<u32>>;
// A bit a slot each.
@group(0) @binding(4) var<storage, read> bits: array<u32>;
@group(0) @binding(5) var<storage, read> seen: array<u32>;
@group(0) @binding(6) var<storage, read_write> list: array<u32>;
// Five words a draw, of which the second is how many instances.
@group(0) @binding(7) var<storage, read_write> arguments: array<u32>;
@group(0) @binding(8) var<uniform> which: Which;

fn is_listed(slot: u32) -> bool {
    let word = listed(bits[slot / 32u], seen[slot / 32u], which.mode);
    return ((word >> (slot % 32u)) & 1u) != 0u;
}

@compute @workgroup_size(256)
fn count(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let number = group.x + group.y * ROW;
    // The same for the whole group.
    if number >= which.groups { return; }
    let at = number * 256u + lane;
    count_bits(number, lane, at < which.lanes && is_listed(lanes[at].slot));
}

@compute @workgroup_size(256)
fn scan(@builtin(local_invocation_index) lane: u32) {
    let all = scan_places(lane, which.groups);
    if lane == 255u { places[which.groups] = all; }
}

@compute @workgroup_size(256)
fn scatter(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let number = group.x + group.y * ROW;
    if number >= which.groups { return; }
    let at = number * 256u + lane;
    if ((words[at / 32u].x >> (lane % 32u)) & 1u) == 0u { return; }
    let own = lanes[at];
    list[own.first + rank(at) - rank(own.first)] = own.slot;
}

@compute @workgroup_size(256)
fn fill(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let draw = (group.x + group.y * ROW) * 256u + lane;
    if draw >= which.draws { return; }
    let of_bucket = draws[draw];
    // The end may be that of the last group, of which there are no bits.
    var before_end = places[which.groups];
    if of_bucket.y < which.groups * 256u { before_end = rank(of_bucket.y); }
    arguments[draw * 5u + 1u] = before_end - rank(of_bucket.x);
}
