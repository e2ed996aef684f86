// Which instances no plane rejects, and their slots in order. Integers only: every device gives the same answer.

struct GridBox { low_xy: u32, low_z_high_x: u32, high_yz: u32, flags: u32 }
struct InUse { block: u32, first_plane: u32, plane_count: u32, padding: u32 }
// The first is set by the CPU.
struct Counts { blocks: u32, visible: u32, padding_0: u32, padding_1: u32 }

const PRESENT = 1u;
const ALWAYS = 2u;

@group(0) @binding(0) var<storage, read> boxes: array<GridBox>;
@group(0) @binding(1) var<storage, read> in_use: array<InUse>;
@group(0) @binding(2) var<storage, read> planes: array<vec4<i32>>;
// Eight words for each block in use, a bit an instance.
@group(0) @binding(3) var<storage, read_write> bits: array<u32>;
// For each block in use how many of its bits are set; after the scan how many are set before it.
@group(0) @binding(4) var<storage, read_write> places: array<u32>;
@group(0) @binding(5) var<storage, read_write> list: array<u32>;
@group(0) @binding(6) var<storage, read_write> counts: Counts;

// A row of workgroups: there may be more blocks than one dimension has room for.
const ROW = 32768u;

fn low(v: u32) -> i32 { return i32(v << 16u) >> 16u; }
fn high(v: u32) -> i32 { return i32(v) >> 16u; }

// The lower or the higher step, whichever lies lower along the normal.
fn lowest(n: i32, at_low: i32, at_high: i32) -> i32 { return n * select(at_high, at_low, n >= 0); }

fn rejects(plane: vec4<i32>, b: GridBox) -> bool {
    return plane.w
        + lowest(plane.x, low(b.low_xy), high(b.low_z_high_x))
        + lowest(plane.y, high(b.low_xy), low(b.high_yz))
        + lowest(plane.z, low(b.low_z_high_x), high(b.high_yz)) > 0;
}

fn is_visible(b: GridBox, use_of: InUse) -> bool {
    if (b.flags & PRESENT) == 0u { return false; }
    if (b.flags & ALWAYS) != 0u { return true; }
    for (var p = use_of.first_plane; p < use_of.first_plane + use_of.plane_count; p++) {
        if rejects(planes[p], b) { return false; }
    }
    return true;
}

var<workgroup> own_bits: array<atomic<u32>, 8>;

@compute @workgroup_size(256)
fn test(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let number = group.x + group.y * ROW;
    // The same for the whole group, as counts are not written here.
    let is_there = number < counts.blocks;
    if is_there {
        let own = in_use[number];
        if is_visible(boxes[own.block * 256u + lane], own) {
            atomicOr(&own_bits[lane / 32u], 1u << (lane % 32u));
        }
    }
    workgroupBarrier();
    if is_there && lane < 8u {
        bits[number * 8u + lane] = atomicLoad(&own_bits[lane]);
    }
    if is_there && lane == 0u {
        var sum = 0u;
        for (var w = 0u; w < 8u; w++) { sum += countOneBits(atomicLoad(&own_bits[w])); }
        places[number] = sum;
    }
}

var<workgroup> sums: array<u32, 256>;

// One workgroup: sums of 256 runs of blocks, their sums before, then within the runs.
@compute @workgroup_size(256)
fn scan(@builtin(local_invocation_index) lane: u32) {
    let run = (counts.blocks + 255u) / 256u;
    let first = min(lane * run, counts.blocks);
    let end = min(first + run, counts.blocks);
    var own = 0u;
    for (var i = first; i < end; i++) { own += places[i]; }
    sums[lane] = own;
    workgroupBarrier();
    for (var by = 1u; by < 256u; by <<= 1u) {
        var before = 0u;
        if lane >= by { before = sums[lane - by]; }
        workgroupBarrier();
        sums[lane] += before;
        workgroupBarrier();
    }
    var place = sums[lane] - own;
    for (var i = first; i < end; i++) {
        let count = places[i];
        places[i] = place;
        place += count;
    }
    if lane == 255u { counts.visible = sums[255]; }
}

@compute @workgroup_size(256)
fn scatter(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let number = group.x + group.y * ROW;
    if number >= counts.blocks { return; }
    let word = bits[number * 8u + lane / 32u];
    let bit = lane % 32u;
    if ((word >> bit) & 1u) == 0u { return; }
    var place = places[number] + countOneBits(word & ((1u << bit) - 1u));
    for (var w = 0u; w < lane / 32u; w++) { place += countOneBits(bits[number * 8u + w]); }
    // Beyond the list's end it is counted, and not written.
    if place < arrayLength(&list) { list[place] = in_use[number].block * 256u + lane; }
}
