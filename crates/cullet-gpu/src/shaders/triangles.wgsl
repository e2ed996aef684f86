// From triangles that a test leaves to the list of their indices, in order, and the argument of a draw of them. As in lists.wgsl
// no counter that several invocations add to. The function is_culled stands in front.

// A run of at most 256 triangles, with the number of its mask.
struct Block { first: u32, count: u32, mask: u32, padding: u32 }
struct Which { blocks: u32, a: u32, b: u32, c: u32 }

@group(0) @binding(0) var<storage, read> blocks: array<Block>;
@group(0) @binding(1) var<storage, read> indices: array<u32>;
// Bits of triangles, and how many are set before in the block: eight words each.
@group(0) @binding(2) var<storage, read_write> words: array<vec2<u32>>;
// For each block how many of its bits are set; after the scan how many are set before it.
@group(0) @binding(3) var<storage, read_write> places: array<u32>;
@group(0) @binding(4) var<storage, read_write> list: array<u32>;
// Five words, of which the first is how many indices.
@group(0) @binding(5) var<storage, read_write> arguments: array<u32>;
@group(0) @binding(6) var<uniform> which: Which;

var<workgroup> own_bits: array<atomic<u32>, 8>;

@compute @workgroup_size(256)
fn count(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let number = group.x + group.y * ROW;
    // The same for the whole group.
    if number >= which.blocks { return; }
    let own = blocks[number];
    if lane < own.count && !is_culled(own.first + lane, own.mask) {
        atomicOr(&own_bits[lane / 32u], 1u << (lane % 32u));
    }
    workgroupBarrier();
    if lane < 8u {
        var before = 0u;
        for (var w = 0u; w < lane; w++) { before += countOneBits(atomicLoad(&own_bits[w])); }
        let bits = atomicLoad(&own_bits[lane]);
        words[number * 8u + lane] = vec2<u32>(bits, before);
        if lane == 7u { places[number] = before + countOneBits(bits); }
    }
}

var<workgroup> sums: array<u32, 256>;

// One workgroup: sums of 256 runs of blocks, their sums before, then within the runs.
@compute @workgroup_size(256)
fn scan(@builtin(local_invocation_index) lane: u32) {
    let run = (which.blocks + 255u) / 256u;
    let first = min(lane * run, which.blocks);
    let end = min(first + run, which.blocks);
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
    if lane == 255u { arguments[0] = sums[255] * 3u; }
}

@compute @workgroup_size(256)
fn scatter(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let number = group.x + group.y * ROW;
    if number >= which.blocks { return; }
    let word = words[number * 8u + lane / 32u];
    let bit = 1u << (lane % 32u);
    if (word.x & bit) == 0u { return; }
    let from_first = (blocks[number].first + lane) * 3u;
    let to_first = (places[number] + word.y + countOneBits(word.x & (bit - 1u))) * 3u;
    for (var corner = 0u; corner < 3u; corner++) {
        list[to_first + corner] = indices[from_first + corner];
    }
}
