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

@compute @workgroup_size(256)
fn count(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let number = group.x + group.y * ROW;
    // The same for the whole group.
    if number >= which.blocks { return; }
    let own = blocks[number];
    count_bits(number, lane, lane < own.count && !is_culled(own.first + lane, own.mask));
}

@compute @workgroup_size(256)
fn scan(@builtin(local_invocation_index) lane: u32) {
    let all = scan_places(lane, which.blocks);
    if lane == 255u { arguments[0] = all * 3u; }
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
